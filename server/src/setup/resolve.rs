//! From a place to what an arm is told: the taught pose, moved with the mobile robot it is on.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CT is the tool T in the cell C"
)]

use kinematics::{Configuration, IkError, PendantJoints, Pose, Seed, Singularity, Xyzwpr};
use nalgebra::{Isometry3, Translation3};
use thiserror::Error;

use super::geometry::{DockDeviation, DockPose, DockTolerance};
use super::model::{Arm, Setup, Site, Taught};

/// Where an arm is to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target<'a> {
    /// Its home joints.
    #[cfg_attr(not(test), expect(dead_code, reason = "no workflow goes home yet"))]
    Home,
    /// Its safe joints, out of every hand-over zone.
    Safe,
    /// Before a place, against the tool's Z axis.
    ApproachOf(&'a str),
    /// At a place: the taught pose.
    At(&'a str),
    /// Straight above it.
    LiftOf(&'a str),
}

/// Where the mobile robot is docked, for places on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Dock {
    /// Exactly where it should be: for plans made before it comes.
    Nominal,
    /// Where it was measured.
    Measured(DockPose),
}

/// What an arm is told.
#[derive(Clone, Debug)]
pub(crate) struct Resolved {
    /// The tool center point in the cell frame.
    pub(crate) X_CT: Pose,
    /// The point as the robot's controller counts it: its own tool in its own user frame.
    pub(crate) controller_point: Xyzwpr,
    pub(crate) configuration: Configuration,
    /// Inside the limits.
    pub(crate) joints: PendantJoints,
    pub(crate) singularity: Singularity,
}

/// Why an arm cannot be told to go there.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum ResolveError {
    #[error("`{arm}` is no arm of the set-up")]
    NoArm { arm: String },
    #[error("`{place}` is no place of the set-up")]
    NoPlace { place: String },
    #[error("no pose is taught at `{place}` for `{arm}`")]
    NotTaught { arm: String, place: String },
    #[error(
        "the mobile robot at `{point}` is {:.1} mm along, {:.1} mm across and {:.2} degrees off; at most {:.1} mm and \
         {:.2} degrees are allowed",
        .deviation.along.0, .deviation.across.0, .deviation.angle.0, .tolerance.position.0, .tolerance.angle.0
    )]
    DockOutsideTolerance {
        point: String,
        deviation: DockDeviation,
        tolerance: DockTolerance,
    },
    #[error("{what}: {error}")]
    Kinematics { what: &'static str, error: IkError },
    #[error(
        "{what}: the distance from the {kind} singularity is {measure:.3}; at least {least} is needed"
    )]
    Singular {
        what: &'static str,
        kind: kinematics::SingularityKind,
        measure: f64,
        least: f64,
    },
}

impl Setup {
    /// What `arm` is told to get to `target`, with the mobile robot docked as said.
    ///
    /// # Errors
    /// Nothing is taught there, the mobile robot stands outside the tolerance of its dock, or the arm cannot reach it
    /// in the taught configuration, inside its limits and away from singularities.
    pub(crate) fn resolve(
        &self,
        arm: &str,
        target: Target<'_>,
        dock: Dock,
    ) -> Result<Resolved, ResolveError> {
        let arm = self.arm(arm).ok_or_else(|| ResolveError::NoArm {
            arm: arm.to_owned(),
        })?;
        let (place, what, shift): (_, _, fn(&Taught, Pose) -> Pose) = match target {
            Target::Home => return Ok(at_joints(arm, &arm.home)),
            Target::Safe => return Ok(at_joints(arm, &arm.safe)),
            Target::At(place) => (place, "the pose", |_, X| X),
            Target::ApproachOf(place) => {
                (place, "the approach", |taught, X| taught.approach_of(&X))
            }
            Target::LiftOf(place) => (place, "the lift", |taught, X| taught.lift_of(&X)),
        };
        let taught = self
            .taught(&arm.id, place)
            .ok_or_else(|| ResolveError::NotTaught {
                arm: arm.id.clone(),
                place: place.to_owned(),
            })?;
        let X_CT = shift(taught, self.grip_pose(taught, dock)?);
        reach(arm, &X_CT, taught.configuration, what)
    }

    /// The taught pose in the cell frame, moved rigidly with the mobile robot the place is on.
    ///
    /// # Errors
    /// The mobile robot stands outside the tolerance.
    pub(crate) fn grip_pose(&self, taught: &Taught, dock: Dock) -> Result<Pose, ResolveError> {
        let Dock::Measured(measured) = dock else {
            return Ok(taught.X_CT);
        };
        let place = self
            .place(&taught.place)
            .ok_or_else(|| ResolveError::NoPlace {
                place: taught.place.clone(),
            })?;
        let Site::OnMobileRobot { point, slot: _ } = &place.site else {
            return Ok(taught.X_CT);
        };
        let point = self.point(point).ok_or_else(|| ResolveError::NoPlace {
            place: taught.place.clone(),
        })?;
        let deviation = point.dock.deviation(&measured);
        let (true, Some(X_CD), Some(X_CM)) = (
            point.tolerance.allows(&deviation),
            point.dock.pose(),
            measured.pose(),
        ) else {
            return Err(ResolveError::DockOutsideTolerance {
                point: point.id.clone(),
                deviation,
                tolerance: point.tolerance,
            });
        };
        Ok(X_CM * X_CD.inverse() * taught.X_CT)
    }
}

impl Taught {
    /// The start of the approach to a grip pose: back along the tool's Z axis.
    pub(crate) fn approach_of(&self, X_CT: &Pose) -> Pose {
        *X_CT * moved(Translation3::new(0.0, 0.0, -self.approach.0))
    }

    /// Straight up from a grip pose, in the cell frame.
    pub(crate) fn lift_of(&self, X_CT: &Pose) -> Pose {
        moved(Translation3::new(0.0, 0.0, self.lift.0)) * *X_CT
    }
}

/// A pose without rotation.
fn moved(translation: Translation3<f64>) -> Pose {
    let isometry = Isometry3::from_parts(translation, nalgebra::UnitQuaternion::identity());
    // At most a meter, as checked where the taught pose was.
    Pose::try_from_isometry(isometry).unwrap_or_else(|_| Pose::identity())
}

/// An arm at joint values that were checked against its limits.
fn at_joints(arm: &Arm, joints: &PendantJoints) -> Resolved {
    let X_WF = arm.model.forward(joints);
    Resolved {
        X_CT: arm.tip(joints),
        controller_point: arm.controller_frames.tcp_in_user_frame(&X_WF).xyzwpr(),
        configuration: arm.model.configuration(joints),
        joints: *joints,
        singularity: arm.model.singularity(joints),
    }
}

/// An arm with its tool center point at a pose, in a configuration.
pub(crate) fn reach(
    arm: &Arm,
    X_CT: &Pose,
    configuration: Configuration,
    what: &'static str,
) -> Result<Resolved, ResolveError> {
    let X_WF = arm.flange_of(X_CT);
    let solution = arm
        .model
        .inverse(&X_WF, Seed::InConfiguration(configuration))
        .map_err(|error| ResolveError::Kinematics { what, error })?;
    if let Some((kind, measure, least)) = nearest_singularity(&solution.singularity) {
        return Err(ResolveError::Singular {
            what,
            kind,
            measure,
            least,
        });
    }
    Ok(Resolved {
        X_CT: *X_CT,
        controller_point: arm.controller_frames.tcp_in_user_frame(&X_WF).xyzwpr(),
        configuration,
        joints: solution.joints,
        singularity: solution.singularity,
    })
}

/// The singularity that a posture is nearer to than its threshold, its measure and the threshold.
fn nearest_singularity(
    singularity: &Singularity,
) -> Option<(kinematics::SingularityKind, f64, f64)> {
    use kinematics::SingularityKind::{Elbow, Shoulder, Wrist};
    singularity.near().next().map(|kind| match kind {
        Wrist => (kind, singularity.wrist, Singularity::NEAR_WRIST),
        Shoulder => (kind, singularity.shoulder, Singularity::NEAR_SHOULDER),
        Elbow => (kind, singularity.elbow, Singularity::NEAR_ELBOW),
    })
}
