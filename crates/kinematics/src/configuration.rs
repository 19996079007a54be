//! FANUC's configuration of an arm: `N U T, 0, 0, 0`.
//!
//! The letters are defined by geometry, so that a branch changes its name exactly where it meets
//! another one: at a singularity. Home, with the tool hanging down in front, is `N U T`.
//!
//! ASSUMPTION: which side of J5 = 0 is `N` is not published by FANUC for each arm; the model file
//! says it; docs/sources.md has the evidence, which is not decisive.
//!
//! ASSUMPTION: a turn number counts half turns away from zero: 0 from -179 to 179 degrees, 1 from
//! 180 to 539, -1 from -180 to -539. So operators' manuals put it, in whole degrees; here the
//! boundary is exactly 180, and belongs to the next turn.

use std::fmt;
use std::str::FromStr;

use crate::joints::{Axis, PendantJoints};

/// Which of the two wrist angles: the sign of J5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Flip {
    /// `N`: the side of J5 = 0 where the tool hangs down at home.
    NoFlip,
    /// `F`: the other side.
    Flip,
}

/// Which side of the line from shoulder to wrist center the elbow is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Elbow {
    /// `U`: above, seen with the arm's front to the right.
    Up,
    /// `D`: below.
    Down,
}

/// Which side of axis 1 the wrist center is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Front {
    /// `T`: the side the arm's front faces.
    Toward,
    /// `B`: behind, the arm reaches over its own back.
    Back,
}

/// Which of the joint sets that reach a pose: the configuration string of a FANUC position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Configuration {
    /// `N` or `F`.
    pub flip: Flip,
    /// `U` or `D`.
    pub elbow: Elbow,
    /// `T` or `B`.
    pub front: Front,
    /// Turn numbers of J4, J5 and J6: 0 within ±180 degrees, 1 from 180 on, -1 from -180 down.
    pub turns: [i8; 3],
}

/// A configuration string that could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigurationError {
    /// One of the three letters is missing or wrong.
    #[error("configuration {text:?}: letter {position} must be {expected}")]
    Letter {
        /// What was given, cut after a few characters.
        text: String,
        /// 1, 2 or 3.
        position: u8,
        /// The letters that may stand there.
        expected: &'static str,
    },
    /// A turn number is missing, not a number, or out of range.
    #[error("configuration {text:?}: turn number {position} must be a whole number from -8 to 7")]
    Turn {
        /// What was given, cut after a few characters.
        text: String,
        /// 1, 2 or 3: J4, J5 or J6.
        position: u8,
    },
    /// More follows than three letters and three turn numbers.
    #[error("configuration {text:?}: three letters and three turn numbers, and nothing after them")]
    TooLong {
        /// What was given, cut after a few characters.
        text: String,
    },
}

/// A joint this close to ±180 degrees counts for the turn on either side: the angle came from a
/// rounded pose.
const TURN_ROUNDING_DEG: f64 = 1e-6;
/// A turn number is a signed half byte on the controller.
const TURNS: std::ops::RangeInclusive<i8> = -8..=7;
/// An error message quotes this many characters.
const QUOTED: usize = 40;

/// The turn number of a joint angle.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the cast saturates, no joint turns 127 times"
)]
#[inline]
pub(crate) fn turn_of(degrees: f64) -> i8 {
    if degrees.abs() < 180.0 {
        return 0;
    }
    let turns = ((degrees.abs() + 180.0) / 360.0).floor();
    turns.copysign(degrees) as i8
}

/// Does an angle have this turn number, seen with the rounding of a pose?
pub(crate) fn has_turn(degrees: f64, turn: i8) -> bool {
    turn_of(degrees) == turn
        || turn_of(degrees + TURN_ROUNDING_DEG) == turn
        || turn_of(degrees - TURN_ROUNDING_DEG) == turn
}

/// The turn numbers of J4, J5 and J6.
pub(crate) fn turns_of(joints: &PendantJoints) -> [i8; 3] {
    [Axis::J4, Axis::J5, Axis::J6].map(|axis| turn_of(joints.of(axis).0))
}

impl Configuration {
    /// The same branch, whatever the turns?
    #[must_use]
    pub fn same_branch(self, other: Configuration) -> bool {
        (self.flip, self.elbow, self.front) == (other.flip, other.elbow, other.front)
    }
}

/// `N U T, 0, 0, 0`
impl fmt::Display for Configuration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let flip = match self.flip {
            Flip::NoFlip => 'N',
            Flip::Flip => 'F',
        };
        let elbow = match self.elbow {
            Elbow::Up => 'U',
            Elbow::Down => 'D',
        };
        let front = match self.front {
            Front::Toward => 'T',
            Front::Back => 'B',
        };
        let [j4, j5, j6] = self.turns;
        write!(f, "{flip} {elbow} {front}, {j4}, {j5}, {j6}")
    }
}

/// Reads `N U T, 0, 0, 0`, and also `NUT 000`, `NUT 00-1` and small letters.
impl FromStr for Configuration {
    type Err = ConfigurationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let quoted = || text.chars().take(QUOTED).collect::<String>();
        let mut rest = text
            .chars()
            .filter(|c| !c.is_whitespace() && *c != ',')
            .map(|c| c.to_ascii_uppercase());
        let letter = |position, expected| ConfigurationError::Letter {
            text: quoted(),
            position,
            expected,
        };
        let flip = match rest.next() {
            Some('N') => Flip::NoFlip,
            Some('F') => Flip::Flip,
            _ => return Err(letter(1, "N or F")),
        };
        let elbow = match rest.next() {
            Some('U') => Elbow::Up,
            Some('D') => Elbow::Down,
            _ => return Err(letter(2, "U or D")),
        };
        let front = match rest.next() {
            Some('T') => Front::Toward,
            Some('B') => Front::Back,
            _ => return Err(letter(3, "T or B")),
        };
        let mut turns = [0; 3];
        for (position, turn) in (1..).zip(&mut turns) {
            *turn = expect_turn(&mut rest).ok_or_else(|| ConfigurationError::Turn {
                text: quoted(),
                position,
            })?;
        }
        if rest.next().is_some() {
            return Err(ConfigurationError::TooLong { text: quoted() });
        }
        Ok(Self {
            flip,
            elbow,
            front,
            turns,
        })
    }
}

/// One digit with an optional sign.
fn expect_turn(rest: &mut impl Iterator<Item = char>) -> Option<i8> {
    let (sign, digit) = match rest.next()? {
        '-' => (-1, rest.next()?),
        '+' => (1, rest.next()?),
        digit => (1, digit),
    };
    let turn = sign * i8::try_from(digit.to_digit(10)?).ok()?;
    TURNS.contains(&turn).then_some(turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Configuration, ConfigurationError> {
        text.parse()
    }

    #[test]
    fn the_usual_spellings_mean_the_same() {
        let nut = read("N U T, 0, 0, 0").unwrap();
        assert_eq!(nut.to_string(), "N U T, 0, 0, 0");
        for text in [
            "NUT 000",
            "NUT000",
            "nut 0 0 0",
            "N U T,0,0,0",
            "  N U T , +0, 0, -0 ",
        ] {
            assert_eq!(read(text), Ok(nut), "{text}");
        }
        assert_eq!(read("FDB 1-10").unwrap().turns, [1, -1, 0]);
    }

    #[test]
    fn a_wrong_string_is_refused_by_position() {
        assert_eq!(
            read("N U X, 0, 0, 0").unwrap_err().to_string(),
            "configuration \"N U X, 0, 0, 0\": letter 3 must be T or B"
        );
        assert_eq!(
            read("N U T, 0, 9, 0").unwrap_err().to_string(),
            "configuration \"N U T, 0, 9, 0\": turn number 2 must be a whole number from -8 to 7"
        );
        assert!(matches!(
            read(""),
            Err(ConfigurationError::Letter { position: 1, .. })
        ));
        assert!(matches!(
            read("NUT 00"),
            Err(ConfigurationError::Turn { position: 3, .. })
        ));
        assert!(matches!(
            read("NUT 0001"),
            Err(ConfigurationError::TooLong { .. })
        ));
    }

    #[test]
    fn a_half_turn_already_counts_as_the_next_turn() {
        for (degrees, turn) in [
            (0.0, 0),
            (179.999, 0),
            (-179.999, 0),
            (180.0, 1),
            (539.0, 1),
            (540.0, 2),
            (-180.0, -1),
            (-539.0, -1),
        ] {
            assert_eq!(turn_of(degrees), turn, "{degrees}");
        }
        assert!(has_turn(180.0, 0) && has_turn(180.0, 1) && !has_turn(180.0, -1));
    }
}
