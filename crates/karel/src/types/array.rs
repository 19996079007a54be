//! Arrays, and the lengths that a reference to an open one carries.

use super::{MAX_CELLS, MAX_STRING, Type};

#[derive(Debug, PartialEq)]
pub(crate) struct ArrayType {
    /// Lengths of the dimensions; none for an open array, zeros for an open one of several.
    pub(crate) dims: Vec<u32>,
    pub(crate) element: Type,
    /// Levels of arrays and structures, this one included.
    pub(crate) depth: u32,
}

impl ArrayType {
    pub(crate) fn is_open(&self) -> bool {
        self.dims.is_empty() || self.is_open_grid()
    }

    /// Open, with several dimensions.
    pub(crate) fn is_open_grid(&self) -> bool {
        self.dims.contains(&0)
    }
}

/// Most open dimensions of an array.
pub(crate) const MAX_OPEN_DIMS: usize = 3;

/// Bits for the length of one of this many dimensions.
const GRID_BITS: [u32; 2] = [16, 10];

fn grid_bits(dims: usize) -> u32 {
    let index = dims.saturating_sub(2);
    GRID_BITS.get(index).copied().unwrap_or(0)
}

/// The lengths of two or three dimensions as one number, which a reference carries; `None` if one
/// is too long for that.
pub(crate) fn grid_lengths(dims: &[u32]) -> Option<u32> {
    let bits = grid_bits(dims.len());
    let mut lengths = 0;
    for dim in dims {
        if *dim >> bits != 0 {
            return None;
        }
        lengths = lengths << bits | dim;
    }
    (bits > 0).then_some(lengths)
}

/// The lengths of [`grid_lengths`].
pub(crate) fn split_grid(mut lengths: u32, dims: usize) -> Vec<u32> {
    let bits = grid_bits(dims);
    let mut split = Vec::new();
    for _ in 0..dims {
        split.push(lengths & ((1 << bits) - 1));
        lengths >>= bits;
    }
    split.reverse();
    split
}

/// Bits that the length of a string needs beside the length of an array.
const TEXT_BITS: u32 = 8;

/// The length of an array and that of its strings as one number, which a reference to it carries.
pub(crate) fn text_array_lengths(array: u32, text: u32) -> u32 {
    array << TEXT_BITS | text
}

/// The two lengths of [`text_array_lengths`].
pub(crate) fn split_text_array(lengths: u32) -> (u32, u32) {
    (lengths >> TEXT_BITS, lengths & ((1 << TEXT_BITS) - 1))
}

const _: () = assert!(MAX_CELLS <= 1 << (32 - TEXT_BITS) && MAX_STRING < 1 << TEXT_BITS);
