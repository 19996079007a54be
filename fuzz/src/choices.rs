//! Decisions drawn from the bytes of an input. When they are used up, every decision is the first one.

/// The bytes that are left.
#[derive(Clone, Debug)]
pub struct Choices<'a>(&'a [u8]);

impl<'a> Choices<'a> {
    /// Decisions from `bytes`.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Whether there are bytes left.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte, 0 if there is none.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    /// The next two bytes as a number.
    pub fn short(&mut self) -> u16 {
        u16::from_be_bytes([self.byte(), self.byte()])
    }

    /// A number below `count`, 0 if that is 0.
    pub fn below(&mut self, count: usize) -> usize {
        if count <= 1 {
            return 0;
        }
        let drawn = if count <= 256 {
            usize::from(self.byte())
        } else {
            usize::from(self.short())
        };
        drawn % count
    }

    /// One of `items`.
    ///
    /// # Panics
    /// If there are none.
    pub fn one_of<'b, T>(&mut self, items: &'b [T]) -> &'b T {
        let index = self.below(items.len());
        items.get(index).expect("there is something to choose")
    }

    /// The next bytes, a length and what it counts, at most `longest`.
    pub fn bytes(&mut self, longest: usize) -> &'a [u8] {
        let length = self.below(longest + 1).min(self.0.len());
        let (taken, rest) = self.0.split_at(length);
        self.0 = rest;
        taken
    }

    /// All that is left.
    pub fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.0)
    }
}
