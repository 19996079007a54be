//! What an operation of a job asks of the controller, checked.

use std::sync::Arc;

use api::MotionType;
use journal::OutputLevel;
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
use crate::setup::resolve::Resolved;
use crate::setup::ways::Shape;

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

    /// Plans the poses of a job: each can be reached, and no way there or back leads where it may not.
    pub(super) async fn precheck(&self, targets: &[Goal]) -> OpResult {
        let kept = self.setup.current();
        let taught = |goal: &Goal| match goal {
            Goal::At { place } => kept.setup.taught_at(self.id(), place),
            Goal::Safe | Goal::ApproachOf { .. } | Goal::LiftOf { .. } => None,
        };
        kept.look_at_ways(targets.iter().filter_map(taught).collect())
            .await;
        let failures = targets
            .iter()
            .enumerate()
            .filter_map(|(target, goal)| {
                let reason = match self.resolve(&kept, goal, None) {
                    Err(reason) => reason,
                    Ok(_) => kept.forbidden_way(taught(goal)?)?.to_string(),
                };
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
                self.check_way(kept, &to, *interpolation, target).await?;
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

    /// The way itself, not only its end, stays out of what nobody may touch, out of the hand-over zones of other places,
    /// and in its work area.
    ///
    /// The arm is looked at every degree of the joint that turns farthest, at most some 700 times, or every 5 mm of a
    /// line, against each of its zones. Of a small cell that is less than a millisecond, and done at once; what may be more
    /// is done on a thread that answers nobody, one for all arms.
    async fn check_way(
        &self,
        kept: Arc<Kept>,
        to: &Resolved,
        interpolation: Interpolation,
        goal: &Goal,
    ) -> Result<(), OpResult> {
        let zones = kept.setup.count_zones_of(self.id());
        if zones == 0 {
            // A way is hundreds of postures: they are not calculated for nothing.
            return Ok(());
        }
        let start = actual(&self.robot, &self.link).map_err(|problem| not_now(&problem))?;
        let start = start.joints;
        let shape = match interpolation {
            Interpolation::Joint => Shape::Joint,
            Interpolation::Linear => Shape::Straight,
        };
        let Some(arm) = kept.setup.arm(self.id()) else {
            return Ok(());
        };
        let rejected = |text: String| OpResult::Rejected { text };
        let samples = shape.samples(arm, &start, to).map_err(rejected)?;
        let looks = samples.len() * zones;
        let (id, goal, of_set_up) = (self.id().to_owned(), goal.clone(), Arc::clone(&kept));
        let check = move || {
            let setup = &of_set_up.setup;
            let arm = setup.arm(&id);
            let checked = arm.map(|arm| setup.check_way(arm, &start, &samples, &goal));
            let forbidden = checked.and_then(Result::err);
            forbidden.map_or(Ok(()), |found| Err(found.to_string()))
        };
        let checked = if looks <= AT_ONCE {
            check()
        } else {
            let Ok(_alone) = WAYS.acquire().await else {
                unreachable!("nobody closes it");
            };
            match tokio::task::spawn_blocking(check).await {
                Ok(checked) => checked,
                Err(error) => Err(format!("the way could not be checked: {error}")),
            }
        };
        checked.map_err(rejected)
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
