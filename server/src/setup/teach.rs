//! A taught pose, of where an arm is.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CT is the tool T in the cell C"
)]

use api::setup::{ExplicitPose, PlaceKind, PoseFrame, SetupFile, TaughtPoseBody, TeachBody};
use api::{JointsBody, PoseBody};
use kinematics::{ArmModel, Configuration, PendantJoints, Pose};

use super::build::{in_cell, joints, planar, pose};
use super::faults::{Faults, SetupErrors};
use super::model::{Arm, Setup};
use crate::wire_bodies::pose_body;

/// Where an approach begins unless somebody says otherwise, in millimeters.
const APPROACH_MM: f64 = 100.0;

impl Setup {
    /// The taught pose of an arm that stands at the place now, where `actual` or the request says that it is.
    ///
    /// # Errors
    /// What does not fit. Whether the pose fits the rest of the set-up is found where it is put in.
    pub(crate) fn teach(
        &self,
        file: &SetupFile,
        arm: &str,
        place: &str,
        body: &TeachBody,
        actual: Option<PendantJoints>,
    ) -> Result<TaughtPoseBody, SetupErrors> {
        let mut faults = Faults::default();
        let taught = self.taught_now(&mut faults, file, arm, place, body, actual);
        match (faults.into_errors(), taught) {
            (None, Some(taught)) => Ok(taught),
            (Some(errors), _) => Err(errors),
            (None, None) => unreachable!("what cannot be taught has a fault"),
        }
    }

    fn taught_now(
        &self,
        faults: &mut Faults,
        file: &SetupFile,
        arm_id: &str,
        place_id: &str,
        body: &TeachBody,
        actual: Option<PendantJoints>,
    ) -> Option<TaughtPoseBody> {
        let Some(arm) = self.arm(arm_id) else {
            faults.add("arm", format!("`{arm_id}` is no arm of the set-up"));
            return None;
        };
        let Some(place) = file.places.iter().find(|place| place.id == place_id) else {
            let place = crate::state::shown(place_id);
            faults.add("place", format!("`{place}` is no place of the set-up"));
            return None;
        };
        let (X_CT, configuration) = match (&body.at, actual) {
            (Some(at), _) => said(faults, arm, body.frame, at)?,
            (None, Some(joints)) => (arm.tip(&joints), arm.model.configuration(&joints)),
            (None, None) => {
                faults.add("at", "is missing, and the arm's actual pose is not known");
                return None;
            }
        };
        let X_CT = match (&body.measured_dock, place.kind, &place.point) {
            (None, ..) => X_CT,
            (Some(measured), PlaceKind::OnMobileRobot, Some(point)) => {
                let measured = planar(faults, "measured_dock", measured)?;
                let nominal = self.point(point)?;
                let deviation = nominal.dock.deviation(&measured);
                if !nominal.tolerance.allows(&deviation) {
                    faults.add(
                        "measured_dock",
                        format!(
                            "is {:.1} mm along, {:.1} mm across and {:.2} degrees off `{point}`; at most {} mm and {} \
                             degrees are allowed",
                            deviation.along.0,
                            deviation.across.0,
                            deviation.angle.0,
                            nominal.tolerance.position.0,
                            nominal.tolerance.angle.0
                        ),
                    );
                    return None;
                }
                nominal.dock.pose()? * measured.pose()?.inverse() * X_CT
            }
            (Some(_), ..) => {
                faults.add(
                    "measured_dock",
                    format!(
                        "`{place_id}` stands still; only a place on a mobile robot moves with it"
                    ),
                );
                return None;
            }
        };
        let before = file
            .taught_poses
            .iter()
            .find(|taught| taught.arm == arm_id && taught.place == place_id);
        let X = match body.frame {
            PoseFrame::Cell => X_CT,
            PoseFrame::Arm => arm.X_CW.inverse() * X_CT,
        };
        Some(TaughtPoseBody {
            arm: arm_id.to_owned(),
            place: place_id.to_owned(),
            frame: body.frame,
            configuration: configuration.to_string(),
            approach_mm: body
                .approach_mm
                .or(before.map(|taught| taught.approach_mm))
                .unwrap_or(APPROACH_MM),
            lift_mm: body.lift_mm.or(before.and_then(|taught| taught.lift_mm)),
            pose: pose_body(&X.xyzwpr()),
        })
    }
}

/// Where the caller says that the arm is.
fn said(
    faults: &mut Faults,
    arm: &Arm,
    frame: PoseFrame,
    at: &ExplicitPose,
) -> Option<(Pose, Configuration)> {
    match (at.joints, at.pose, &at.configuration) {
        (Some(body), None, None) => {
            let joints = joints(faults, "at.joints", body, arm.model)?;
            Some((arm.tip(&joints), arm.model.configuration(&joints)))
        }
        (None, Some(body), Some(text)) => {
            let X = pose(faults, "at.pose", &body);
            let configuration = text.parse::<Configuration>();
            let configuration = configuration
                .map_err(|error| faults.add("at.configuration", error.to_string()))
                .ok();
            Some((in_cell(frame, &arm.X_CW, X?), configuration?))
        }
        _ => {
            faults.add(
                "at",
                "must have either `joints`, or `pose` with its `configuration`",
            );
            None
        }
    }
}

/// The flange in the arm's world, of a posture in a request: joint values, or the flange itself.
pub(crate) fn flange_of_body(
    faults: &mut Faults,
    item: &str,
    body_joints: Option<JointsBody>,
    flange: Option<PoseBody>,
    model: &ArmModel,
) -> Option<Pose> {
    match (body_joints, flange) {
        (Some(body), None) => {
            let joints = joints(faults, &format!("{item}.joints"), body, model)?;
            Some(model.forward(&joints))
        }
        (None, Some(body)) => pose(faults, &format!("{item}.flange"), &body),
        (Some(_), Some(_)) | (None, None) => {
            faults.add(item, "must have either `joints` or `flange`");
            None
        }
    }
}
