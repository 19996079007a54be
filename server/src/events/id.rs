use std::fmt;

use jiff::Timestamp;
use journal::{Epoch, Position};

use crate::journal::{Keeps, SharedJournal};

/// The place of a record, as streams name it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct EventId {
    pub(crate) epoch: u64,
    pub(crate) position: Position,
}

impl EventId {
    /// Before everything.
    pub(crate) const START: Self = Self {
        epoch: 0,
        position: Position::START,
    };

    /// Reads `<epoch>-<position>`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (epoch, position) = text.split_once('-')?;
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            digits.then(|| text.parse().ok()).flatten()
        };
        Some(Self {
            epoch: number(epoch)?,
            position: Position(number(position)?),
        })
    }
}

impl fmt::Display for EventId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.epoch, self.position)
    }
}

/// How the epochs of a journal are shown. One that ends with the process begins with the same epoch each time, so
/// there the time of the start stands for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Epochs(Option<u64>);

impl Epochs {
    pub(super) fn of(journal: &SharedJournal, now: Timestamp) -> Self {
        match journal.keeps() {
            Keeps::OverRestarts => Self(None),
            Keeps::UntilTheEnd => Self(u64::try_from(now.as_millisecond()).ok()),
        }
    }

    pub(super) fn shown(self, epoch: Epoch) -> u64 {
        self.0.unwrap_or(epoch.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_read_back_and_nothing_else_is_one() {
        let id = EventId {
            epoch: 3,
            position: Position(120),
        };
        assert_eq!(EventId::parse(&id.to_string()), Some(id));
        for text in [
            "",
            "-",
            "3",
            "3-",
            "-3",
            "3-4-5",
            "+3-4",
            "3- 4",
            "3-99999999999999999999",
        ] {
            assert_eq!(EventId::parse(text), None, "{text}");
        }
    }
}
