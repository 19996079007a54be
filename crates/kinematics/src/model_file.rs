//! Reading and checking model files.

use serde::Deserialize;
use serde::de::IgnoredAny;
use units::{DegPerSec, DegPerSec2, DegPerSec3, Degrees, Millimeters, Radians};

use crate::capsule::{CapsuleEntry, CapsuleError, expect_capsules};
use crate::coupling::Coupling;
use crate::dh::DhLink;
use crate::geometry::{Geometry, NotCovered};
use crate::joints::{Axis, PendantJoints};
use crate::lanes::Level;
use crate::limits::{JERK_PER_ACCELERATION, Limits};
use crate::model::ArmModel;

/// No link of an arm is longer.
const MAX_LENGTH_MM: f64 = 100_000.0;
/// No twist, offset or limit is larger.
const MAX_ANGLE_DEG: f64 = 3600.0;
/// No axis is faster; the same bound holds for accelerations, times ten.
const MAX_SPEED_DEG_S: f64 = 10_000.0;

/// Why a model file was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// Not TOML, or a key is missing, unknown or of the wrong type.
    #[error("reading the model file")]
    Syntax(#[source] Box<toml::de::Error>),
    /// A number outside its range.
    #[error("{axis}: {key} is {value}; it must be a number from {min} to {max}")]
    Range {
        /// The joint.
        axis: Axis,
        /// The key in the file.
        key: &'static str,
        /// What was given.
        value: f64,
        /// The lowest legal value.
        min: f64,
        /// The highest legal value.
        max: f64,
    },
    /// A speed or an acceleration that no axis has.
    #[error("{axis}: {key} is {value}; it must be above 0 and not above {max}")]
    Positive {
        /// The joint.
        axis: Axis,
        /// The key in the file.
        key: &'static str,
        /// What was given.
        value: f64,
        /// The highest legal value.
        max: f64,
    },
    /// A sign that is not 1 or -1, or a coupling that is not -1, 0 or 1.
    #[error("{axis}: {key} is {value}; it must be {wanted}")]
    Choice {
        /// The joint.
        axis: Axis,
        /// The key in the file.
        key: &'static str,
        /// What was given.
        value: i8,
        /// The legal values.
        wanted: &'static str,
    },
    /// The lower limit is not below the upper one.
    #[error("{axis}: min_deg is {min}, which is not below max_deg {max}", min = .limits.min.0, max = .limits.max.0)]
    ReversedLimits {
        /// The joint.
        axis: Axis,
        /// Its limits.
        limits: Limits,
    },
    /// The home position is outside the limits.
    #[error("{axis}: home_deg is {value}; the limits are {min} to {max}", min = .limits.min.0, max = .limits.max.0)]
    HomeOutsideLimits {
        /// The joint.
        axis: Axis,
        /// Its home.
        value: f64,
        /// Its limits.
        limits: Limits,
    },
    /// The file does not have six joints.
    #[error("the file has {count} joints; it must have 6")]
    JointCount {
        /// How many it has.
        count: usize,
    },
    /// The joints are not J1 to J6 in this order.
    #[error("joint number {position} of the file is called {name:?}; it must be {wanted}")]
    JointName {
        /// From 1.
        position: usize,
        /// What it is called.
        name: String,
        /// What it must be called.
        wanted: Axis,
    },
    /// A capsule of the arm's shape that is none.
    #[error(transparent)]
    Capsule(#[from] CapsuleError),
    /// The name is empty.
    #[error("{key} is empty; it must be a text")]
    Empty {
        /// The key in the file.
        key: &'static str,
    },
    /// The axes are not arranged as the closed-form inverse kinematics needs them.
    #[error(
        "{axis}: {key} is {value}, {wanted}: the closed form covers arms with J2 and J3 parallel, J1 and J4 at right \
         angles to them, and the axes of J4, J5 and J6 through one point"
    )]
    NotOrthoParallel {
        /// The joint.
        axis: Axis,
        /// The key in the file.
        key: &'static str,
        /// What was given.
        value: f64,
        /// What it would have to be.
        wanted: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    name: String,
    manufacturer: String,
    no_flip_j5: Sign,
    joints: Vec<JointEntry>,
    #[serde(default)]
    capsules: Vec<CapsuleEntry>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Sign {
    Positive,
    Negative,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    axis: String,
    d_mm: f64,
    a_mm: f64,
    alpha_deg: f64,
    sign: i8,
    offset_deg: f64,
    #[serde(default)]
    j2_coupling: i8,
    min_deg: f64,
    max_deg: f64,
    max_speed_deg_s: f64,
    max_acceleration_deg_s2: f64,
    max_jerk_deg_s3: Option<f64>,
    home_deg: f64,
    /// Read by `SerialArm` only, as the next two.
    #[serde(default, rename = "mass_kg")]
    _mass_kg: IgnoredAny,
    #[serde(default, rename = "center_of_mass_m")]
    _center_of_mass_m: IgnoredAny,
    #[serde(default, rename = "inertia_kg_m2")]
    _inertia_kg_m2: IgnoredAny,
}

/// A joint whose numbers are in range.
#[derive(Clone, Copy)]
struct Joint {
    link: DhLink,
    sign: f64,
    offset: f64,
    j2_coupling: f64,
    limits: Limits,
    max_speed: DegPerSec,
    max_acceleration: DegPerSec2,
    max_jerk: DegPerSec3,
    home: f64,
}

pub(crate) fn read(text: &str) -> Result<ArmModel, ModelError> {
    let file: ModelFile =
        toml::from_str(text).map_err(|error| ModelError::Syntax(Box::new(error)))?;
    for (key, value) in [("name", &file.name), ("manufacturer", &file.manufacturer)] {
        if value.trim().is_empty() {
            return Err(ModelError::Empty { key });
        }
    }
    let joints = file
        .joints
        .iter()
        .zip(Axis::ALL)
        .enumerate()
        .map(|(index, (entry, axis))| {
            if entry.axis == axis.to_string() {
                check(axis, entry)
            } else {
                Err(ModelError::JointName {
                    position: index + 1,
                    name: entry.axis.clone(),
                    wanted: axis,
                })
            }
        });
    let joints = joints.collect::<Result<Vec<_>, _>>()?;
    let joints: [Joint; 6] = joints
        .try_into()
        .ok()
        .filter(|_| file.joints.len() == Axis::ALL.len())
        .ok_or(ModelError::JointCount {
            count: file.joints.len(),
        })?;
    let dh = joints.map(|joint| joint.link);
    let geometry = Geometry::try_from_dh(&dh).map_err(|reason| not_covered(reason, &dh))?;
    Ok(ArmModel {
        name: file.name,
        manufacturer: file.manufacturer,
        dh,
        geometry,
        coupling: Coupling {
            signs: joints.map(|joint| joint.sign),
            offsets: joints.map(|joint| joint.offset),
            j2_in_q3: Axis::J3.of(&joints).j2_coupling,
        },
        no_flip_sign: match file.no_flip_j5 {
            Sign::Positive => 1.0,
            Sign::Negative => -1.0,
        } * Axis::J5.of(&joints).sign,
        limits: joints.map(|joint| joint.limits),
        max_speeds: joints.map(|joint| joint.max_speed),
        max_accelerations: joints.map(|joint| joint.max_acceleration),
        max_jerks: joints.map(|joint| joint.max_jerk),
        home: PendantJoints::from_degrees(joints.map(|joint| joint.home)),
        shown_middles: shown_middles(&joints.map(|joint| joint.limits)),
        level: Level::new(),
        capsules: expect_capsules(&file.capsules, Axis::ALL.len())?,
    })
}

/// J1, J2 and J3 are shown on the turn nearest to the middle of their range, the wrist's joints
/// within half a turn.
fn shown_middles(&[j1, j2, j3, ..]: &[Limits; 6]) -> [f64; 6] {
    let [j1, j2, j3] =
        [j1, j2, j3].map(|range| f64::midpoint(range.min.0, range.max.0).to_radians());
    [j1, j2, j3, 0.0, 0.0, 0.0]
}

/// One joint's own numbers.
fn check(axis: Axis, entry: &JointEntry) -> Result<Joint, ModelError> {
    let in_range = |key, value: f64, min: f64, max: f64| {
        // Negated, so that NaN is refused too.
        if !(value >= min && value <= max) {
            return Err(ModelError::Range {
                axis,
                key,
                value,
                min,
                max,
            });
        }
        Ok(value)
    };
    let positive = |key, value: f64, max: f64| {
        if value > 0.0 && value <= max {
            Ok(value)
        } else {
            Err(ModelError::Positive {
                axis,
                key,
                value,
                max,
            })
        }
    };
    let length = |key, value| in_range(key, value, -MAX_LENGTH_MM, MAX_LENGTH_MM);
    let angle = |key, value| in_range(key, value, -MAX_ANGLE_DEG, MAX_ANGLE_DEG);
    let choice = |key, value: i8, legal: &[i8], wanted| {
        if legal.contains(&value) {
            Ok(f64::from(value))
        } else {
            Err(ModelError::Choice {
                axis,
                key,
                value,
                wanted,
            })
        }
    };
    let limits = Limits {
        min: Degrees(angle("min_deg", entry.min_deg)?),
        max: Degrees(angle("max_deg", entry.max_deg)?),
    };
    if limits.min >= limits.max {
        return Err(ModelError::ReversedLimits { axis, limits });
    }
    let home = angle("home_deg", entry.home_deg)?;
    if !limits.contains(Degrees(home)) {
        return Err(ModelError::HomeOutsideLimits {
            axis,
            value: home,
            limits,
        });
    }
    let (couplings, wanted): (&[i8], _) = if axis == Axis::J3 {
        (&[-1, 0, 1], "-1, 0 or 1")
    } else {
        (&[0], "0: only J3 is coupled")
    };
    let acceleration = positive(
        "max_acceleration_deg_s2",
        entry.max_acceleration_deg_s2,
        10.0 * MAX_SPEED_DEG_S,
    )?;
    Ok(Joint {
        link: DhLink {
            d: Millimeters(length("d_mm", entry.d_mm)?),
            a: Millimeters(length("a_mm", entry.a_mm)?),
            alpha: Radians::from(Degrees(angle("alpha_deg", entry.alpha_deg)?)),
        },
        sign: choice("sign", entry.sign, &[-1, 1], "1 or -1")?,
        offset: angle("offset_deg", entry.offset_deg)?.to_radians(),
        j2_coupling: choice("j2_coupling", entry.j2_coupling, couplings, wanted)?,
        limits,
        max_speed: DegPerSec(positive(
            "max_speed_deg_s",
            entry.max_speed_deg_s,
            MAX_SPEED_DEG_S,
        )?),
        max_acceleration: DegPerSec2(acceleration),
        max_jerk: DegPerSec3(positive(
            "max_jerk_deg_s3",
            entry
                .max_jerk_deg_s3
                .unwrap_or(JERK_PER_ACCELERATION * acceleration),
            1000.0 * MAX_SPEED_DEG_S,
        )?),
        home,
    })
}

fn not_covered(reason: NotCovered, dh: &[DhLink; 6]) -> ModelError {
    match reason {
        NotCovered::Twist { axis, wanted } => ModelError::NotOrthoParallel {
            axis,
            key: "alpha_deg",
            value: Degrees::from(axis.of(dh).alpha).0,
            wanted,
        },
        NotCovered::A { axis, wanted } => ModelError::NotOrthoParallel {
            axis,
            key: "a_mm",
            value: axis.of(dh).a.0,
            wanted,
        },
        NotCovered::D { axis, wanted } => ModelError::NotOrthoParallel {
            axis,
            key: "d_mm",
            value: axis.of(dh).d.0,
            wanted,
        },
    }
}
