//! The shape of an arm: capsules on its links.

use serde::Deserialize;

/// A cylinder with round ends, fixed to a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// The frame of the (standard) Denavit-Hartenberg table it moves with: 0 is the base, 6 the
    /// flange of an arm with six joints.
    pub link: usize,
    /// One end of its axis, in that frame, mm.
    pub from: [f64; 3],
    /// The other.
    pub to: [f64; 3],
    /// mm.
    pub radius: f64,
}

/// Why a capsule was refused. Capsules count from 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CapsuleError {
    /// A number that is out of range.
    #[error("capsule {capsule}: {item} is {value}; sizes are positive, coordinates within 100 m")]
    Number {
        /// Which capsule.
        capsule: usize,
        /// `from`, `to`, `radius`.
        item: &'static str,
        /// What was given.
        value: f64,
    },
    /// A link that the arm does not have.
    #[error("capsule {capsule} is on link {link}; links are 0 to {last}")]
    Link {
        /// Which capsule.
        capsule: usize,
        /// What was given.
        link: usize,
        /// The flange's link.
        last: usize,
    },
    /// More capsules than one would check.
    #[error("{count} capsules; an arm has at most {most}")]
    Count {
        /// How many were given.
        count: usize,
        /// How many there may be.
        most: usize,
    },
}

impl Capsule {
    /// An arm has no more.
    pub const MOST: usize = 64;

    const MAX_MM: f64 = 1e5;

    /// Are these capsules of an arm whose flange is link `last`?
    ///
    /// # Errors
    /// Names the first capsule and the number that is wrong.
    pub fn check(capsules: &[Capsule], last: usize) -> Result<(), CapsuleError> {
        if capsules.len() > Self::MOST {
            return Err(CapsuleError::Count {
                count: capsules.len(),
                most: Self::MOST,
            });
        }
        for (capsule, shape) in (1..).zip(capsules) {
            for (item, values) in [("from", shape.from), ("to", shape.to)] {
                let wrong = |value: &&f64| !value.is_finite() || value.abs() > Self::MAX_MM;
                if let Some(&value) = values.iter().find(wrong) {
                    return Err(CapsuleError::Number {
                        capsule,
                        item,
                        value,
                    });
                }
            }
            let value = shape.radius;
            if !(value > 0.0 && value <= Self::MAX_MM) {
                return Err(CapsuleError::Number {
                    capsule,
                    item: "radius",
                    value,
                });
            }
            if shape.link > last {
                let link = shape.link;
                return Err(CapsuleError::Link {
                    capsule,
                    link,
                    last,
                });
            }
        }
        Ok(())
    }
}

/// As a model file has it.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CapsuleEntry {
    link: usize,
    from_mm: [f64; 3],
    to_mm: [f64; 3],
    radius_mm: f64,
}

/// The checked capsules of a model file.
pub(crate) fn expect_capsules(
    entries: &[CapsuleEntry],
    last: usize,
) -> Result<Vec<Capsule>, CapsuleError> {
    let capsule = |entry: &CapsuleEntry| Capsule {
        link: entry.link,
        from: entry.from_mm,
        to: entry.to_mm,
        radius: entry.radius_mm,
    };
    let capsules: Vec<_> = entries.iter().map(capsule).collect();
    Capsule::check(&capsules, last)?;
    Ok(capsules)
}
