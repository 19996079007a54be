//! Poses, frames, arm models, forward and inverse kinematics.
//!
//! An [`ArmModel`] is data: a TOML file with a Denavit-Hartenberg table, the way from the pendant's
//! joints to the chain's, limits and speeds. [`ArmModel::forward`] gives the flange's pose,
//! [`ArmModel::inverse_all`] every joint set that reaches a pose, [`ArmModel::inverse`] the one to
//! use, or the reason why there is none.
//!
//! ```text
//!            elbow o---------------o wrist center    W  world: base of the arm, Z up along axis 1
//!                 /                 \                F  flange: Z out of the flange
//!   Z            /                   o flange F      T  tool:  X_FT, on the flange
//!   |  shoulder o                    o tool T        U  user frame: X_WU, in the world
//!   W---X      axis 1
//!                                                    X_UT = X_WU^-1 * X_WF * X_FT
//! ```
//!
//! ```
//! use kinematics::{ArmModel, Frames, Pose, Seed, Xyzwpr};
//! use units::{Degrees, Millimeters};
//!
//! let arm = ArmModel::builtin("fanuc-m20ia").ok_or("no such arm")?;
//! let target = Xyzwpr::new(
//!     [Millimeters(985.0), Millimeters(0.0), Millimeters(940.0)],
//!     [Degrees(180.0), Degrees(0.0), Degrees(0.0)],
//! );
//! let X_UT = Pose::try_from_xyzwpr(&target)?;
//! let X_WF = Frames::default().flange_in_world(&X_UT);
//!
//! let solution = arm.inverse(&X_WF, Seed::Near(arm.home()))?;
//! assert_eq!(solution.configuration.to_string(), "N U T, 0, 0, 0");
//! assert!((solution.joints.degrees()[4] - -90.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Lengths are millimeters, angles of the public types degrees where a person reads them and
//! radians inside. This crate does no I/O and reads no clock; it does not know collisions or time.
#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_WF is the flange F in the world W"
)]

mod batch;
mod branches;
mod calibration;
mod capsule;
mod checked;
mod configuration;
mod coupling;
mod dh;
pub mod dynamics;
mod forward;
mod frames;
mod geometry;
mod ik_error;
mod inverse;
mod jacobian;
mod joints;
mod lanes;
mod limits;
mod model;
mod model_file;
mod pose;
mod posture;
mod reach;
mod select;
pub mod serial;
mod singularity;
mod trigonometry;
mod wpr;
mod zyz;

pub use batch::JointSets;
pub use branches::{Branches, Solution};
pub use calibration::{CalibrationError, TipCalibration, calibrate_tip, calibrate_tool};
pub use capsule::{Capsule, CapsuleError};
pub use configuration::{Configuration, ConfigurationError, Elbow, Flip, Front};
pub use dh::DhLink;
pub use frames::Frames;
pub use ik_error::{IkError, Obstacle, ReachBound};
pub use joints::{Axis, ChainJoints, JointsError, PendantJoints};
pub use lanes::Instructions;
pub use limits::{LimitViolation, LimitViolations, Limits};
pub use model::ArmModel;
pub use model_file::ModelError;
pub use pose::{Pose, PoseError};
pub use reach::{Reach, ReachError};
pub use select::Seed;
pub use singularity::{Singularity, SingularityKind};
pub use wpr::Xyzwpr;
pub use zyz::{Zyz, ZyzAngles, ZyzBranch};
