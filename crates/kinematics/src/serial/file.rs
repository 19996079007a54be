//! Reading and checking the model files of any arm.
//!
//! A model file of [`crate::ArmModel`] is one of these too.

use nalgebra::Isometry3;
use serde::Deserialize;
use units::{Degrees, Millimeters};

use crate::capsule::{CapsuleEntry, CapsuleError, expect_capsules};
use crate::dynamics::{InertiaError, LinkInertia};
use crate::limits::JERK_PER_ACCELERATION;
use crate::pose::{Pose, PoseError};
use crate::serial::arm::{JointKind, SerialArm, SerialJoint};
use crate::wpr::Xyzwpr;

/// Longer arms than any that was built; it bounds what a file can make us compute.
const MAX_JOINTS: usize = 32;
const MAX_LENGTH_MM: f64 = 100_000.0;
const MAX_ANGLE_DEG: f64 = 3600.0;
const MAX_RATE: f64 = 1e6;
/// Two axes closer than this (radians and millimeters) are one line.
const ONE_LINE: f64 = 1e-9;

/// Why a model file was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SerialModelError {
    /// Not TOML, or a key is missing, unknown or of the wrong type.
    #[error("reading the model file")]
    Syntax(#[source] Box<toml::de::Error>),
    /// A text is empty.
    #[error("{key} is empty; it must be a text")]
    Empty {
        /// The key in the file.
        key: &'static str,
    },
    /// No joint at all, or too many.
    #[error("the file has {count} joints; it must have 1 to {max}")]
    JointCount {
        /// How many it has.
        count: usize,
        /// How many are taken.
        max: usize,
    },
    /// Two joints of one name.
    #[error("two joints are called {name}; a name must be one joint's")]
    SameName {
        /// The name.
        name: String,
    },
    /// A key that this kind of joint needs.
    #[error("{joint}: {key} is missing; a {kind:?} joint needs it")]
    Missing {
        /// The joint.
        joint: String,
        /// The key in the file.
        key: &'static str,
        /// The joint's kind.
        kind: JointKind,
    },
    /// A key that this kind of joint cannot have.
    #[error("{joint}: {key} is given; a {kind:?} joint has none")]
    NotForKind {
        /// The joint.
        joint: String,
        /// The key in the file.
        key: &'static str,
        /// The joint's kind.
        kind: JointKind,
    },
    /// A number outside its range.
    #[error("{joint}: {key} is {value}; it must be a number from {min} to {max}")]
    Range {
        /// The joint.
        joint: String,
        /// The key in the file.
        key: &'static str,
        /// What was given.
        value: f64,
        /// The lowest legal value.
        min: f64,
        /// The highest legal value.
        max: f64,
    },
    /// A speed or an acceleration that is not above 0.
    #[error("{joint}: {key} is {value}; it must be above 0 and not above {max}")]
    Positive {
        /// The joint.
        joint: String,
        /// The key in the file.
        key: &'static str,
        /// What was given.
        value: f64,
        /// The highest legal value.
        max: f64,
    },
    /// A sign that is not 1 or -1.
    #[error("{joint}: sign is {value}; it must be 1 or -1")]
    Sign {
        /// The joint.
        joint: String,
        /// What was given.
        value: i8,
    },
    /// The lower limit is not below the upper one.
    #[error("{joint}: its range is from {min} to {max} {}; the first must be below the second", .kind.unit())]
    ReversedLimits {
        /// The joint.
        joint: String,
        /// The lower limit of the file.
        min: f64,
        /// The upper limit of the file.
        max: f64,
        /// Degrees or millimeters.
        kind: JointKind,
    },
    /// Home is outside the limits.
    #[error("{joint}: home is {value} {}; the range is {min} to {max}", .kind.unit())]
    HomeOutsideLimits {
        /// The joint.
        joint: String,
        /// Its home.
        value: f64,
        /// The lowest legal value.
        min: f64,
        /// The highest legal value.
        max: f64,
        /// Degrees or millimeters.
        kind: JointKind,
    },
    /// A coupling names a joint that does not come before.
    #[error("{joint}: couplings names {other:?}; it must be a joint before {joint}")]
    Coupling {
        /// The joint.
        joint: String,
        /// What it names.
        other: String,
    },
    /// `base` or `flange` is no pose.
    #[error("{frame} is not a pose")]
    Frame {
        /// The key in the file.
        frame: &'static str,
        /// What is wrong with it.
        #[source]
        source: PoseError,
    },
    /// Two neighbors move along or about the same line: the table is degenerate.
    #[error(
        "{first} and {second} {what}: a_mm {a} and alpha_deg {alpha_deg} between them leave no way \
         to tell them apart"
    )]
    SameAxis {
        /// The joint nearer to the base.
        first: String,
        /// The next one.
        second: String,
        /// `turn about one line` or `slide in one direction`.
        what: &'static str,
        /// Between them, in millimeters.
        a: f64,
        /// Between them, in degrees.
        alpha_deg: f64,
    },
    /// What the link weighs is no body's.
    #[error("{joint}: {error}")]
    Inertia {
        /// The joint.
        joint: String,
        /// What is wrong with it.
        error: InertiaError,
    },
    /// Only a part of what the link weighs.
    #[error(
        "{joint}: {missing} is missing; mass_kg, center_of_mass_m and inertia_kg_m2 are given together"
    )]
    InertiaPart {
        /// The joint.
        joint: String,
        /// The key that is not there.
        missing: &'static str,
    },
    /// A capsule of the arm's shape that is none.
    #[error(transparent)]
    Capsule(#[from] CapsuleError),
    /// All lengths are zero: the flange never leaves the base's origin.
    #[error("all lengths of the table are 0; at least one link must have a length")]
    NoLength,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArmFile {
    name: String,
    manufacturer: String,
    #[serde(default)]
    convention: ConventionKey,
    /// Read by `ArmModel` only.
    #[serde(default, rename = "no_flip_j5")]
    _no_flip_j5: Option<String>,
    base: Option<FrameEntry>,
    flange: Option<FrameEntry>,
    joints: Vec<JointEntry>,
    #[serde(default)]
    capsules: Vec<CapsuleEntry>,
}

/// The two conventions of a Denavit-Hartenberg table.
#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ConventionKey {
    /// A row is `Rz(theta) Tz(d) Tx(a) Rx(alpha)`: textbook (1.12), thesis section 2.2.1.
    #[default]
    Standard,
    /// A row is `Rx(alpha) Tx(a) Rz(theta) Tz(d)`: the twist comes before the joint (Craig).
    Modified,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindKey {
    #[default]
    Revolute,
    Prismatic,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameEntry {
    x_mm: f64,
    y_mm: f64,
    z_mm: f64,
    w_deg: f64,
    p_deg: f64,
    r_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CouplingEntry {
    joint: String,
    factor: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    axis: String,
    #[serde(default)]
    kind: KindKey,
    a_mm: f64,
    alpha_deg: f64,
    d_mm: Option<f64>,
    theta_deg: Option<f64>,
    #[serde(default = "plus_one")]
    sign: i8,
    #[serde(default)]
    j2_coupling: i8,
    #[serde(default)]
    couplings: Vec<CouplingEntry>,
    offset_deg: Option<f64>,
    offset_mm: Option<f64>,
    min_deg: Option<f64>,
    min_mm: Option<f64>,
    max_deg: Option<f64>,
    max_mm: Option<f64>,
    max_speed_deg_s: Option<f64>,
    max_speed_mm_s: Option<f64>,
    max_acceleration_deg_s2: Option<f64>,
    max_acceleration_mm_s2: Option<f64>,
    max_jerk_deg_s3: Option<f64>,
    max_jerk_mm_s3: Option<f64>,
    home_deg: Option<f64>,
    home_mm: Option<f64>,
    mass_kg: Option<f64>,
    center_of_mass_m: Option<[f64; 3]>,
    inertia_kg_m2: Option<[[f64; 3]; 3]>,
}

fn plus_one() -> i8 {
    1
}

pub(crate) fn read(text: &str) -> Result<SerialArm, SerialModelError> {
    let file: ArmFile =
        toml::from_str(text).map_err(|error| SerialModelError::Syntax(Box::new(error)))?;
    for (key, value) in [("name", &file.name), ("manufacturer", &file.manufacturer)] {
        if value.trim().is_empty() {
            return Err(SerialModelError::Empty { key });
        }
    }
    if file.joints.is_empty() || file.joints.len() > MAX_JOINTS {
        return Err(SerialModelError::JointCount {
            count: file.joints.len(),
            max: MAX_JOINTS,
        });
    }
    let mut joints: Vec<SerialJoint> = Vec::new();
    for entry in &file.joints {
        if entry.axis.trim().is_empty() {
            return Err(SerialModelError::Empty { key: "axis" });
        }
        if joints.iter().any(|joint| joint.name == entry.axis) {
            return Err(SerialModelError::SameName {
                name: entry.axis.clone(),
            });
        }
        let joint = check(entry, &joints)?;
        joints.push(joint);
    }
    let mut base = frame("base", file.base.as_ref())?;
    if matches!(file.convention, ConventionKey::Modified) {
        base *= to_standard(&mut joints);
    }
    refuse_degenerate(&joints)?;
    let flange = frame("flange", file.flange.as_ref())?;
    let capsules = expect_capsules(&file.capsules, joints.len())?;
    let arm = SerialArm::from_parts(file.name, file.manufacturer, joints, base, flange)
        .with_capsules(capsules);
    if arm.span <= ONE_LINE {
        return Err(SerialModelError::NoLength);
    }
    Ok(arm)
}

fn frame(
    name: &'static str,
    entry: Option<&FrameEntry>,
) -> Result<Isometry3<f64>, SerialModelError> {
    let Some(e) = entry else {
        return Ok(Isometry3::identity());
    };
    let pose = Xyzwpr::new(
        [e.x_mm, e.y_mm, e.z_mm].map(Millimeters),
        [e.w_deg, e.p_deg, e.r_deg].map(Degrees),
    );
    Pose::try_from_xyzwpr(&pose)
        .map(|pose| *pose.isometry())
        .map_err(|source| SerialModelError::Frame {
            frame: name,
            source,
        })
}

/// Moves each row's twist to the row before, and gives what was before the first joint: the twist
/// that a modified table has in front of joint i + 1 is the one a standard table has behind joint
/// i.
fn to_standard(joints: &mut [SerialJoint]) -> Isometry3<f64> {
    let (first_a, first_alpha) = joints
        .first()
        .map_or((0.0, 0.0), |joint| (joint.a, joint.alpha));
    let mut behind: Vec<(f64, f64)> = joints.iter().skip(1).map(|j| (j.a, j.alpha)).collect();
    behind.push((0.0, 0.0));
    for (joint, (a, alpha)) in joints.iter_mut().zip(behind) {
        (joint.a, joint.alpha) = (a, alpha);
        // The link's frame moves along with its twist.
        let back = twist(a, alpha).inverse();
        let X_SM = Pose::from_parts(back.translation.vector, back.rotation);
        joint.inertia = joint.inertia.map(|inertia| inertia.seen_from(&X_SM));
    }
    twist(first_a, first_alpha)
}

/// `Tx(a) Rx(alpha)`
fn twist(a: f64, alpha: f64) -> Isometry3<f64> {
    Isometry3::new(
        nalgebra::Vector3::new(a, 0.0, 0.0),
        nalgebra::Vector3::new(alpha, 0.0, 0.0),
    )
}

fn refuse_degenerate(joints: &[SerialJoint]) -> Result<(), SerialModelError> {
    for (first, second) in joints.iter().zip(joints.iter().skip(1)) {
        let parallel = first.alpha.sin().abs() < ONE_LINE;
        let what = match (first.kind, second.kind) {
            (JointKind::Revolute, JointKind::Revolute) if parallel && first.a.abs() < ONE_LINE => {
                "turn about one line"
            }
            (JointKind::Prismatic, JointKind::Prismatic) if parallel => "slide in one direction",
            _ => continue,
        };
        return Err(SerialModelError::SameAxis {
            first: first.name.clone(),
            second: second.name.clone(),
            what,
            a: first.a,
            alpha_deg: first.alpha.to_degrees(),
        });
    }
    Ok(())
}

/// One joint's own numbers.
fn check(entry: &JointEntry, before: &[SerialJoint]) -> Result<SerialJoint, SerialModelError> {
    let kind = match entry.kind {
        KindKey::Revolute => JointKind::Revolute,
        KindKey::Prismatic => JointKind::Prismatic,
    };
    let keys = Keys { entry, kind };
    let a = keys.number("a_mm", entry.a_mm, MAX_LENGTH_MM)?;
    let alpha = keys.number("alpha_deg", entry.alpha_deg, MAX_ANGLE_DEG)?;
    let (d, theta) = match kind {
        JointKind::Revolute => {
            keys.none("theta_deg", entry.theta_deg)?;
            let d = keys.needed("d_mm", entry.d_mm)?;
            (keys.number("d_mm", d, MAX_LENGTH_MM)?, 0.0)
        }
        JointKind::Prismatic => {
            keys.none("d_mm", entry.d_mm)?;
            let theta = keys.needed("theta_deg", entry.theta_deg)?;
            (0.0, keys.number("theta_deg", theta, MAX_ANGLE_DEG)?)
        }
    };
    let offset = keys
        .of_kind(
            ["offset_deg", "offset_mm"],
            [entry.offset_deg, entry.offset_mm],
        )?
        .unwrap_or(0.0);
    let min = keys.value(["min_deg", "min_mm"], [entry.min_deg, entry.min_mm])?;
    let max = keys.value(["max_deg", "max_mm"], [entry.max_deg, entry.max_mm])?;
    if min >= max {
        return Err(SerialModelError::ReversedLimits {
            joint: entry.axis.clone(),
            min,
            max,
            kind,
        });
    }
    let home = keys.value(["home_deg", "home_mm"], [entry.home_deg, entry.home_mm])?;
    if home < min || home > max {
        return Err(SerialModelError::HomeOutsideLimits {
            joint: entry.axis.clone(),
            value: home,
            min,
            max,
            kind,
        });
    }
    let speed = keys.rate(
        ["max_speed_deg_s", "max_speed_mm_s"],
        [entry.max_speed_deg_s, entry.max_speed_mm_s],
    )?;
    let acceleration = keys.rate(
        ["max_acceleration_deg_s2", "max_acceleration_mm_s2"],
        [entry.max_acceleration_deg_s2, entry.max_acceleration_mm_s2],
    )?;
    let jerk = match (entry.max_jerk_deg_s3, entry.max_jerk_mm_s3) {
        (None, None) => JERK_PER_ACCELERATION * acceleration,
        given => keys.rate(["max_jerk_deg_s3", "max_jerk_mm_s3"], given.into())?,
    };
    if entry.sign != 1 && entry.sign != -1 {
        return Err(SerialModelError::Sign {
            joint: entry.axis.clone(),
            value: entry.sign,
        });
    }
    Ok(SerialJoint {
        name: entry.axis.clone(),
        kind,
        a,
        alpha: alpha.to_radians(),
        d,
        theta: theta.to_radians(),
        sign: f64::from(entry.sign),
        offset: kind.inside(offset),
        couplings: couplings(&keys, before)?,
        min: kind.inside(min),
        max: kind.inside(max),
        max_speed: kind.inside(speed),
        max_acceleration: kind.inside(acceleration),
        max_jerk: kind.inside(jerk),
        home: kind.inside(home),
        inertia: inertia(entry)?,
    })
}

/// In the link's frame of the file's table.
fn inertia(entry: &JointEntry) -> Result<Option<LinkInertia>, SerialModelError> {
    let joint = || entry.axis.clone();
    let parts = (entry.mass_kg, entry.center_of_mass_m, entry.inertia_kg_m2);
    let missing = match parts {
        (None, None, None) => return Ok(None),
        (Some(mass), Some(center), Some(inertia)) => {
            let read = LinkInertia::try_new(mass, center, inertia);
            return read.map(Some).map_err(|error| SerialModelError::Inertia {
                joint: joint(),
                error,
            });
        }
        (None, ..) => "mass_kg",
        (_, None, _) => "center_of_mass_m",
        (.., None) => "inertia_kg_m2",
    };
    Err(SerialModelError::InertiaPart {
        joint: joint(),
        missing,
    })
}

fn couplings(
    keys: &Keys<'_>,
    before: &[SerialJoint],
) -> Result<Vec<(usize, f64)>, SerialModelError> {
    let entry = keys.entry;
    let index = |name: &str| {
        let found = before.iter().position(|joint| joint.name == name);
        found.ok_or_else(|| SerialModelError::Coupling {
            joint: entry.axis.clone(),
            other: name.to_owned(),
        })
    };
    let mut couplings = Vec::new();
    if entry.j2_coupling != 0 {
        couplings.push((index("J2")?, f64::from(entry.j2_coupling)));
    }
    for CouplingEntry { joint, factor } in &entry.couplings {
        couplings.push((
            index(joint)?,
            keys.number("couplings.factor", *factor, 1000.0)?,
        ));
    }
    Ok(couplings)
}

/// A joint's keys, two for each quantity: in degrees and in millimeters.
struct Keys<'a> {
    entry: &'a JointEntry,
    kind: JointKind,
}

impl Keys<'_> {
    fn joint(&self) -> String {
        self.entry.axis.clone()
    }

    fn needed(&self, key: &'static str, value: Option<f64>) -> Result<f64, SerialModelError> {
        value.ok_or_else(|| SerialModelError::Missing {
            joint: self.joint(),
            key,
            kind: self.kind,
        })
    }

    fn none(&self, key: &'static str, value: Option<f64>) -> Result<(), SerialModelError> {
        match value {
            None => Ok(()),
            Some(_) => Err(SerialModelError::NotForKind {
                joint: self.joint(),
                key,
                kind: self.kind,
            }),
        }
    }

    fn number(&self, key: &'static str, value: f64, most: f64) -> Result<f64, SerialModelError> {
        // NaN is in no range.
        if (-most..=most).contains(&value) {
            return Ok(value);
        }
        Err(SerialModelError::Range {
            joint: self.joint(),
            key,
            value,
            min: -most,
            max: most,
        })
    }

    /// The one of the two that belongs to the joint's kind, in range.
    fn of_kind(
        &self,
        [deg_key, mm_key]: [&'static str; 2],
        [deg, mm]: [Option<f64>; 2],
    ) -> Result<Option<f64>, SerialModelError> {
        let (key, value, most) = match self.kind {
            JointKind::Revolute => {
                self.none(mm_key, mm)?;
                (deg_key, deg, MAX_ANGLE_DEG)
            }
            JointKind::Prismatic => {
                self.none(deg_key, deg)?;
                (mm_key, mm, MAX_LENGTH_MM)
            }
        };
        value.map(|value| self.number(key, value, most)).transpose()
    }

    fn key(&self, [deg_key, mm_key]: [&'static str; 2]) -> &'static str {
        match self.kind {
            JointKind::Revolute => deg_key,
            JointKind::Prismatic => mm_key,
        }
    }

    fn value(
        &self,
        keys: [&'static str; 2],
        values: [Option<f64>; 2],
    ) -> Result<f64, SerialModelError> {
        let value = self.of_kind(keys, values)?;
        self.needed(self.key(keys), value)
    }

    fn rate(
        &self,
        keys: [&'static str; 2],
        [deg, mm]: [Option<f64>; 2],
    ) -> Result<f64, SerialModelError> {
        let [deg_key, mm_key] = keys;
        let value = match self.kind {
            JointKind::Revolute => {
                self.none(mm_key, mm)?;
                deg
            }
            JointKind::Prismatic => {
                self.none(deg_key, deg)?;
                mm
            }
        };
        let key = self.key(keys);
        let value = self.needed(key, value)?;
        if value > 0.0 && value <= MAX_RATE {
            return Ok(value);
        }
        Err(SerialModelError::Positive {
            joint: self.joint(),
            key,
            value,
            max: MAX_RATE,
        })
    }
}
