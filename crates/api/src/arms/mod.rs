//! Questions about arm models: no robot of a cell is concerned, and nothing is sent.
//!
//! Joint values are lists, base first, in the joint's own unit: degrees of a revolute joint, millimeters of a prismatic
//! one. Their keys end in `_deg_mm`, rates of them in `_deg_mm_s` (a second), `_deg_mm_s2` and `_deg_mm_s3`. Points are
//! lists of x, y and z. Poses are the tool's in the user frame; both frames are the identity where they are absent, so
//! that a pose is the flange's in the arm's world.

mod dynamics;
mod model;
mod posture;
mod reach;
mod transfer;
mod velocity;

pub use dynamics::{ArmInertia, ArmInverseDynamicsBody, ArmInverseDynamicsResult};
pub use model::{
    ArmCapsule, ArmDescription, ArmJoint, ArmJointCoupling, ArmJointKind, ArmList, ArmSolver,
    ArmSummary, ArmTask,
};
pub use posture::{
    ArmBranch, ArmForwardBody, ArmForwardResult, ArmFrames, ArmInverseBody, ArmInverseResult,
    ArmOutside, ArmPoint, ArmSearch, FiveLinkPoints, PlacedCapsule, ZyzBody,
};
pub use reach::{ReachBody, ReachGrid, ReachPlane, ReachResult};
pub use transfer::{ArmObstacle, ArmTransferBody, ArmTransferResult};
pub use velocity::{
    ArmCalibrationBody, ArmCalibrationMethod, ArmCalibrationPoint, ArmCalibrationResult,
    ArmDecomposition, ArmJacobianBody, ArmJacobianResult, ArmMotionEnd, ArmMotionSample,
    ArmRatesBody, ArmRatesResult, ArmTwist, ArmVelocityMotionBody, ArmVelocityMotionResult,
};
