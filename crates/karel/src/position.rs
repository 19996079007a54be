//! Cartesian positions as KAREL holds them: `f32` millimeters and degrees plus a configuration.
//!
//! W, P and R are rotations about the fixed X, Y and Z axes: `R = Rz(r) Ry(p) Rx(w)`.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Which way the wrist bends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Wrist {
    /// `F`.
    Flip,
    /// `N`.
    #[default]
    NoFlip,
}

/// Where the elbow is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Elbow {
    /// `U`.
    #[default]
    Up,
    /// `D`.
    Down,
}

/// Whether the arm reaches to its front or over its back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Front {
    /// `T`, toward the front.
    #[default]
    Toward,
    /// `B`, over the back.
    Back,
}

/// KAREL's `CONFIG`: the branch of the inverse kinematics and the turns of J4, J5 and J6.
///
/// `Display` writes `N U T, 0, 0, 0`. The default is the one KAREL assumes when a program fills
/// only x..r of a position: no flip, elbow up, front, no turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Config {
    /// Flip or no flip.
    pub wrist: Wrist,
    /// Up or down.
    pub elbow: Elbow,
    /// Toward or back.
    pub front: Front,
    /// Turn numbers of J4, J5 and J6.
    pub turns: [i8; 3],
}

impl Config {
    /// Reads `N U T, 0, 0, -1`, and the short form `NUT000` that programs use. The letters may
    /// have blanks between them, and an `L` or `R` for arms that have a shoulder to the side.
    ///
    /// ASSUMPTION: in the short form each turn is one digit with an optional sign.
    #[must_use]
    pub fn parse(text: &str) -> Option<Config> {
        let text = text.trim().to_ascii_uppercase();
        let end = text.find(|c: char| c == ',' || c == '-' || c.is_ascii_digit());
        let (letters, numbers) = text.split_at_checked(end.unwrap_or(text.len()))?;
        let mut config = Config::default();
        let mut seen = 0_u8;
        for letter in letters.chars().filter(|c| !c.is_whitespace()) {
            let place = match letter {
                'F' | 'N' => 1,
                'L' | 'R' => 2,
                'U' | 'D' => 4,
                'T' | 'B' => 8,
                _ => return None,
            };
            // In the pendant's order, each at most once.
            if seen >= place {
                return None;
            }
            seen |= place;
            match letter {
                'F' => config.wrist = Wrist::Flip,
                'D' => config.elbow = Elbow::Down,
                'B' => config.front = Front::Back,
                _ => {}
            }
        }
        if (seen & !2) != (1 | 4 | 8) {
            return None;
        }
        config.turns = turns(numbers)?;
        Some(config)
    }
}

/// `, 0, 0, -1` or `00-1`; nothing for no turns.
fn turns(text: &str) -> Option<[i8; 3]> {
    if text.is_empty() {
        return Some([0; 3]);
    }
    let mut numbers = Vec::new();
    if let Some(list) = text.strip_prefix(',') {
        for number in list.split(',') {
            numbers.push(number.trim().parse().ok()?);
        }
    } else {
        let mut sign = 1;
        for c in text.chars().filter(|c| !c.is_whitespace()) {
            if c == '-' && sign == 1 {
                sign = -1;
            } else {
                let digit = i8::try_from(c.to_digit(10)?).ok()?;
                numbers.push(sign * digit);
                sign = 1;
            }
        }
        if sign != 1 {
            return None;
        }
    }
    <[i8; 3]>::try_from(numbers).ok()
}

impl fmt::Display for Config {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let wrist = match self.wrist {
            Wrist::Flip => 'F',
            Wrist::NoFlip => 'N',
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
        write!(f, "{wrist} {elbow} {front}, {j4}, {j5}, {j6}")
    }
}

/// `XYZWPR`: a position with its configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Xyzwpr {
    /// X in millimeters.
    pub x: f32,
    /// Y in millimeters.
    pub y: f32,
    /// Z in millimeters.
    pub z: f32,
    /// W, rotation about the fixed X axis, in degrees.
    pub w: f32,
    /// P, rotation about the fixed Y axis, in degrees.
    pub p: f32,
    /// R, rotation about the fixed Z axis, in degrees.
    pub r: f32,
    /// The branch of the inverse kinematics.
    pub config: Config,
}

impl Xyzwpr {
    /// Builds a position from x, y, z (millimeters) and w, p, r (degrees), default configuration.
    #[must_use]
    pub fn from_components([x, y, z, w, p, r]: [f32; 6]) -> Xyzwpr {
        Xyzwpr {
            x,
            y,
            z,
            w,
            p,
            r,
            config: Config::default(),
        }
    }

    /// x, y, z in millimeters and w, p, r in degrees.
    #[must_use]
    pub fn components(&self) -> [f32; 6] {
        [self.x, self.y, self.z, self.w, self.p, self.r]
    }
}

/// `POSITION`: on a controller a matrix, here the same six components as [`Xyzwpr`].
///
/// ASSUMPTION: a program cannot observe the matrix except through W, P, R values that a round
/// trip through it would normalize; this crate keeps them as they were written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position {
    /// X in millimeters.
    pub x: f32,
    /// Y in millimeters.
    pub y: f32,
    /// Z in millimeters.
    pub z: f32,
    /// W, rotation about the fixed X axis, in degrees.
    pub w: f32,
    /// P, rotation about the fixed Y axis, in degrees.
    pub p: f32,
    /// R, rotation about the fixed Z axis, in degrees.
    pub r: f32,
    /// The branch of the inverse kinematics.
    pub config: Config,
}

/// `XYZWPREXT`: a position with its configuration and up to three extended axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct XyzwprExt {
    /// X in millimeters.
    pub x: f32,
    /// Y in millimeters.
    pub y: f32,
    /// Z in millimeters.
    pub z: f32,
    /// W, rotation about the fixed X axis, in degrees.
    pub w: f32,
    /// P, rotation about the fixed Y axis, in degrees.
    pub p: f32,
    /// R, rotation about the fixed Z axis, in degrees.
    pub r: f32,
    /// The branch of the inverse kinematics.
    pub config: Config,
    /// Extended axes, millimeters or degrees; zero where there is none.
    pub ext: [f32; 3],
}

/// `JOINTPOS`: angles as the pendant shows them, in degrees; millimeters for linear axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointPosition {
    /// One to nine axes, J1 first.
    pub axes: Vec<f32>,
}

impl From<Xyzwpr> for Position {
    fn from(
        Xyzwpr {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
        }: Xyzwpr,
    ) -> Position {
        Position {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
        }
    }
}

impl From<Position> for Xyzwpr {
    fn from(
        Position {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
        }: Position,
    ) -> Xyzwpr {
        Xyzwpr {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
        }
    }
}

impl From<Xyzwpr> for XyzwprExt {
    fn from(
        Xyzwpr {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
        }: Xyzwpr,
    ) -> XyzwprExt {
        XyzwprExt {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
            ext: [0.0; 3],
        }
    }
}

impl From<XyzwprExt> for Xyzwpr {
    fn from(
        XyzwprExt {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
            ext: _,
        }: XyzwprExt,
    ) -> Xyzwpr {
        Xyzwpr {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
        }
    }
}

impl From<Position> for XyzwprExt {
    fn from(position: Position) -> XyzwprExt {
        Xyzwpr::from(position).into()
    }
}

impl From<XyzwprExt> for Position {
    fn from(position: XyzwprExt) -> Position {
        Xyzwpr::from(position).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_reads_like_on_the_pendant() {
        assert_eq!(Config::default().to_string(), "N U T, 0, 0, 0");
        let turned = Config {
            wrist: Wrist::Flip,
            turns: [0, -1, 1],
            ..Config::default()
        };
        assert_eq!(turned.to_string(), "F U T, 0, -1, 1");
    }

    #[test]
    fn extended_axes_are_zero_where_a_position_had_none() {
        let plain = Xyzwpr::from_components([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let extended = XyzwprExt::from(plain);
        let expected = XyzwprExt {
            x: 1.0,
            y: 2.0,
            z: 3.0,
            w: 4.0,
            p: 5.0,
            r: 6.0,
            ..XyzwprExt::default()
        };
        assert_eq!(extended, expected);
        assert_eq!(Xyzwpr::from(extended), plain);
    }
}
