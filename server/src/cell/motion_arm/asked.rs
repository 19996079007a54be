//! What an operation of a job asks of the controller, checked.

use std::sync::Arc;

use api::MotionType;
use journal::OutputLevel;
use kinematics::PendantJoints;
use workflow::{
    Action, BasePose, GripAction, Interpolation, OpResult, PoseFailure, Speed as Pace,
    Target as Goal,
};

use super::ends::not_now;
use super::{
    AT_ONCE, CLOSE_OUTPUT, FREE_MM_S, FREE_PERCENT, MotionArm, REDUCED_MM_S, REDUCED_PERCENT, WAYS,
};
use crate::motions::{Asked, Speed, actual};
use crate::setup::book::Kept;
use crate::setup::path::joint_path;
use crate::setup::resolve::Resolved;

impl MotionArm {
    pub(super) fn resolve(
        &self,
        kept: &Kept,
        target: &Goal,
        docked: Option<BasePose>,
    ) -> Result<Resolved, String> {
        kept.setup
            .resolve_for(self.id(), target, docked)
            .map_err(|error| error.to_string())
    }

    pub(super) fn precheck(&self, targets: &[Goal]) -> OpResult {
        let kept = self.setup.current();
        let failures = targets
            .iter()
            .enumerate()
            .filter_map(|(target, goal)| {
                let reason = self.resolve(&kept, goal, None).err()?;
                Some(PoseFailure { target, reason })
            })
            .collect();
        OpResult::Prechecked { failures }
    }

    /// What the controller is to be asked for.
    pub(super) async fn asked(&self, action: &Action) -> Result<Asked, OpResult> {
        let rejected = |text: String| OpResult::Rejected { text };
        match action {
            Action::Move {
                target,
                interpolation,
                speed,
                docked,
            } => {
                let kept = self.setup.current();
                let to = self.resolve(&kept, target, *docked).map_err(rejected)?;
                if *interpolation == Interpolation::Joint {
                    self.check_way(kept, &to.joints).await?;
                }
                Ok(asked_motion(&to, *interpolation, *speed))
            }
            Action::Grip { action } => {
                let now = actual(&self.robot, &self.link).map_err(|problem| not_now(&problem))?;
                Ok(Asked {
                    motion_type: MotionType::Output,
                    point: now.point,
                    speed: Speed::Percent(FREE_PERCENT),
                    joints: now.joints,
                    to_joints: false,
                    output: Some(OutputLevel {
                        output: CLOSE_OUTPUT,
                        on: *action == GripAction::Close,
                    }),
                    from: None,
                })
            }
            Action::Precheck { .. } => Err(rejected("a check moves nothing".to_owned())),
        }
    }

    /// The way itself, not only its end, stays out of what nobody may touch.
    ///
    /// The arm is looked at every degree of the joint that turns farthest, at most some 700 times, against each of its
    /// keep-out zones. Of a small cell that is less than a millisecond, and done at once; what may be more is done on
    /// a thread that answers nobody, one for all arms.
    pub(super) async fn check_way(
        &self,
        kept: Arc<Kept>,
        to: &PendantJoints,
    ) -> Result<(), OpResult> {
        let from = actual(&self.robot, &self.link).map_err(|problem| not_now(&problem))?;
        let samples = joint_path(&from.joints, to);
        let id = self.id().to_owned();
        let looks = samples.len() * kept.setup.keep_out_zones_of(&id);
        let check = move || {
            let checked = kept
                .setup
                .arm(&id)
                .map(|arm| kept.setup.check_path(arm, &samples));
            checked.transpose().map(drop)
        };
        let checked = if looks <= AT_ONCE {
            check()
        } else {
            let Ok(_alone) = WAYS.acquire().await else {
                unreachable!("nobody closes it");
            };
            match tokio::task::spawn_blocking(check).await {
                Ok(checked) => checked,
                Err(error) => {
                    let text = format!("the way could not be checked: {error}");
                    return Err(OpResult::Rejected { text });
                }
            }
        };
        checked.map_err(|violation| OpResult::Rejected {
            text: violation.to_string(),
        })
    }
}

pub(super) fn asked_motion(to: &Resolved, interpolation: Interpolation, pace: Pace) -> Asked {
    let point = &to.controller_point;
    let thousandths = [
        point.x.0, point.y.0, point.z.0, point.w.0, point.p.0, point.r.0,
    ]
    .map(thousandths);
    match interpolation {
        Interpolation::Joint => Asked {
            motion_type: MotionType::Joint,
            point: thousandths,
            speed: Speed::Percent(percent(pace)),
            joints: to.joints,
            to_joints: true,
            output: None,
            from: None,
        },
        Interpolation::Linear => Asked {
            motion_type: MotionType::Linear,
            point: thousandths,
            speed: Speed::MmPerSec(match pace {
                Pace::Free => FREE_MM_S,
                Pace::Reduced => REDUCED_MM_S,
            }),
            joints: to.joints,
            to_joints: false,
            output: None,
            from: None,
        },
    }
}

/// Millimeters and degrees of a pose that passed every limit, in the wire's thousandths.
pub(super) fn thousandths(value: f64) -> i32 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "an arm's reach and angles fit many times"
    )]
    let rounded = (value * 1_000.0).round() as i32;
    rounded
}

pub(super) fn percent(pace: Pace) -> u8 {
    match pace {
        Pace::Free => FREE_PERCENT,
        Pace::Reduced => REDUCED_PERCENT,
    }
}
