//! Arms of any number of revolute and prismatic joints.
//!
//! [`SerialArm`] is data: a Denavit-Hartenberg table in the standard or the modified convention,
//! out of a TOML file. Its joint values are [`JointValues`], in radians and millimeters, counted as
//! the arm's own display counts them: signs, offsets and couplings between joints belong to the
//! model, and every Jacobian is taken with respect to *these* values.
//!
//! ```text
//! X_WF = X_W0 * A1(q1) * .. * An(qn) * X_nF      A(q) = Rz(theta) Tz(d) Tx(a) Rx(alpha)
//! q = sign * J + offset + sum(factor * other J)  theta = q (revolute) or d = q (prismatic)
//! ```
//!
//! ```
//! use kinematics::serial::SerialArm;
//!
//! let arm = SerialArm::builtin("scara").ok_or("no such arm")?;
//! // Degrees and millimeters, as its display shows them; the third joint is the quill.
//! let joints = arm.joints(&[0.0, 90.0, 100.0, 0.0])?;
//! let pose = arm.forward(&joints)?.xyzwpr();
//! assert!((pose.x.0 - 325.0).abs() < 1e-9 && (pose.y.0 - 275.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arm;
mod decomposition;
mod dls;
mod error;
mod file;
mod five_link;
mod forward;
mod jacobian;
mod motion;
mod polynomial;
mod spherical;
mod task;
mod textbook;
mod values;
mod velocity;

pub use arm::{JointKind, SerialArm, SerialJoint};
pub use decomposition::SingularityDecomposition;
pub use dls::{DlsError, DlsOptions, DlsSolution};
pub use error::{OutsideRange, SerialError};
pub use file::SerialModelError;
pub use five_link::{FIVE_LINK_RANGES, FiveJoints, FiveLinkArm, FiveLinkError, FiveLinkSolutions};
pub use jacobian::{Angles, Jacobian, RepresentationSingular};
pub use motion::{MotionEnd, MotionError, MotionSample, VelocityCommand, VelocityMotion};
pub use spherical::{WristError, WristSolution};
pub use task::Task;
pub use textbook::{TextbookArm, TextbookBranch, TextbookError, TextbookSolution};
pub use values::JointValues;
pub use velocity::{Dexterity, Rates, Twist, VelocityError};
