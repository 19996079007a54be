//! The cell's operations as durable motions of a robot.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use api::{DoubtAnswer, MotionType, ProblemCode};
use jiff::SignedDuration;
use journal::{Claim, Digest, IdempotencyKey, LookupError, OutputLevel, Record as Entry};
use kinematics::PendantJoints;
use tokio::sync::{Semaphore, watch};
use tokio::time::{Instant, timeout};
use uuid::Uuid;
use workflow::{
    Action, ArmSeen, BasePose, GripAction, Interpolation, Millis, OpResult, PoseFailure,
    Speed as Pace, Target as Goal,
};

use super::arm::{ArmPort, Later, Operation};
use crate::authority;
use crate::link::cell_server::CellServerLink;
use crate::motions::{
    Asked, End, InFlight, Numbered, Progress, Respond, Speed, actual, joint_duration,
};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::setup::SetupBook;
use crate::setup::book::Kept;
use crate::setup::path::joint_path;
use crate::setup::resolve::Resolved;
use crate::state::Robot;

/// Joint motions through free space, and near loads and in a zone: percent of the joints' own speeds.
const FREE_PERCENT: u8 = 40;
const REDUCED_PERCENT: u8 = 15;
/// Straight lines, in mm/s. Reduced speed is that of ISO 10218-1: 250 mm/s at most.
const FREE_MM_S: u16 = 600;
const REDUCED_MM_S: u16 = 200;
/// The gripper's ports: output 1 closes, inputs 1 to 3 are closed, open and part present.
const CLOSE_OUTPUT: u8 = 1;
const CLOSED_INPUT: u8 = 1;
const OPEN_INPUT: u8 = 2;
const PART_INPUT: u8 = 3;
/// Looks at a way that are no work for another thread.
const AT_ONCE: usize = 1_500;
/// One longer look at a time.
static WAYS: Semaphore = Semaphore::const_new(1);
/// How long an operation may wait before its first byte. After that it never starts.
const NOT_AFTER: Duration = Duration::from_secs(10);
/// A motion whose end never comes is stopped by the cell's own timers; this only ends what they forgot.
const FOREVER: Duration = Duration::from_hours(24);
/// How long a gripper may take, on the controller's clock.
const GRIP: Duration = Duration::from_secs(2);

/// An arm with a controller that numbers its commands.
#[derive(Clone)]
pub(crate) struct MotionArm {
    pub(crate) robot: Arc<Robot>,
    pub(crate) link: CellServerLink,
    pub(crate) setup: Arc<SetupBook>,
    pub(crate) control: authority::Claim,
    pub(crate) keys: InFlight,
    pub(crate) seen: watch::Receiver<ArmSeen>,
}

impl ArmPort for MotionArm {
    fn expected(&self, operation: &Operation) -> Option<Millis> {
        let Action::Move {
            target,
            interpolation: _,
            speed,
            docked,
        } = &operation.action
        else {
            return None;
        };
        let to = self.resolve(&self.setup.current(), target, *docked).ok()?;
        let from = actual(&self.robot, &self.link).ok()?.joints;
        // A straight line takes longer than its joints would.
        let seconds = 2.0 * joint_duration(&self.robot.plan, &from, &to.joints, percent(*speed));
        let scaled = 1_000.0 * seconds * 100.0 / f64::from(self.speed_override());
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a duration in milliseconds, positive and rounded up"
        )]
        Some(scaled.clamp(0.0, 3_600_000.0).ceil() as Millis)
    }

    fn operate(&self, operation: Operation) -> Later<OpResult> {
        let this = self.clone();
        Box::pin(async move {
            match &operation.action {
                Action::Move { .. } => this.carry_out(&operation).await,
                Action::Grip { .. } => {
                    let ended = this.carry_out(&operation).await;
                    this.gripped(ended).await
                }
                Action::Precheck { targets } => this.precheck(targets),
            }
        })
    }

    fn reconcile(&self, operation: Operation) -> Later<OpResult> {
        let this = self.clone();
        Box::pin(async move {
            match &operation.action {
                Action::Move { .. } => this.ask_after(&operation).await,
                Action::Grip { .. } => {
                    let ended = this.ask_after(&operation).await;
                    this.gripped(ended).await
                }
                // Nothing moved for it: it is simply done again.
                Action::Precheck { targets } => this.precheck(targets),
            }
        })
    }

    fn stop(&self) -> Later<()> {
        let this = self.clone();
        Box::pin(async move {
            if let Err(error) = this.link.stop().await {
                tracing::error!(
                    robot.id = this.robot.plan.id,
                    error = error.chain(),
                    "the stop of the arm is not confirmed"
                );
            }
        })
    }

    fn watch(&self) -> watch::Receiver<ArmSeen> {
        self.seen.clone()
    }
}

impl MotionArm {
    fn id(&self) -> &str {
        &self.robot.plan.id
    }

    fn speed_override(&self) -> u8 {
        let seen = self.link.view().status;
        seen.map_or(100, |seen| seen.line.speed_override).max(1)
    }

    fn resolve(
        &self,
        kept: &Kept,
        target: &Goal,
        docked: Option<BasePose>,
    ) -> Result<Resolved, String> {
        kept.setup
            .resolve_for(self.id(), target, docked)
            .map_err(|error| error.to_string())
    }

    fn precheck(&self, targets: &[Goal]) -> OpResult {
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
    async fn asked(&self, action: &Action) -> Result<Asked, OpResult> {
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
    async fn check_way(&self, kept: Arc<Kept>, to: &PendantJoints) -> Result<(), OpResult> {
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

    async fn carry_out(&self, operation: &Operation) -> OpResult {
        self.settle_doubt(operation).await;
        let claim = match claim_of(operation) {
            Ok(claim) => claim,
            Err(text) => return OpResult::Rejected { text },
        };
        let guard = match self.keys.enter(&claim.key) {
            Ok(guard) => guard,
            Err(problem) => return not_now(&problem),
        };
        let asked = match self.asked(&operation.action).await {
            Ok(asked) => asked,
            Err(result) => return result,
        };
        let motions = &self.robot.motions;
        let not_after = SignedDuration::try_from(NOT_AFTER).unwrap_or(SignedDuration::ZERO);
        let numbered = Numbered {
            resolve: Box::new(move |_| Ok(asked)),
            request_id: RequestId::recorded(&operation.op.to_string()),
            principal: Arc::from(self.control.actor()),
            reason: Some(format!("job {}", operation.job)),
            not_after: motions
                .now()
                .saturating_add(not_after)
                .unwrap_or(motions.now()),
            begin_by: Instant::now() + NOT_AFTER,
            claim,
            control: self.control.clone(),
            stops: motions.stops(),
            guard,
        };
        match self.robot.start_numbered(&self.link, numbered).await {
            Ok((motion, _new)) => self.follow(motion).await,
            Err(problem) => not_now(&problem),
        }
    }

    /// What became of an operation of an earlier process: its intent in the journal says whether there was a motion,
    /// and the motion's own story what became of it.
    async fn ask_after(&self, operation: &Operation) -> OpResult {
        let claim = match claim_of(operation) {
            Ok(claim) => claim,
            Err(text) => return OpResult::Rejected { text },
        };
        let motions = &self.robot.motions;
        let motion = match motions.journal().lookup(&claim, motions.now()).await {
            Ok(None) => {
                return OpResult::NotExecuted {
                    text: "the journal has no intent of it, so nothing was ever sent".to_owned(),
                };
            }
            Ok(Some(replay)) => {
                if let Entry::Intent(intent) = &replay.first.record {
                    intent.motion.0
                } else {
                    Uuid::nil()
                }
            }
            // The motion is open: it is being asked about already.
            Err(LookupError::Refused(journal::Refusal::KeyInFlight { motion })) => motion.0,
            Err(error) => {
                return OpResult::InDoubt {
                    text: error.to_string(),
                };
            }
        };
        self.follow(motion).await
    }

    async fn follow(&self, motion: Uuid) -> OpResult {
        let motions = &self.robot.motions;
        let limit = Instant::now() + FOREVER;
        let ended = motions
            .book
            .wait(motion, limit, |progress| progress.end().is_some())
            .await;
        let record = match ended {
            Some(record) => record,
            None => match motions.find(motion).await {
                Ok(Some(record)) => record,
                Ok(None) | Err(_) => {
                    return OpResult::InDoubt {
                        text: format!("what became of motion {motion} is not known"),
                    };
                }
            },
        };
        if let Progress::Ended { end, .. } = &record.progress {
            result_of(end)
        } else {
            OpResult::InDoubt {
                text: format!("motion {motion} has no end"),
            }
        }
    }

    /// The gripper's own inputs say what a level came to.
    async fn gripped(&self, ended: OpResult) -> OpResult {
        if ended != OpResult::Arrived {
            return ended;
        }
        let mut views = self.link.watch();
        let limit = GRIP.div_f64(self.robot.plan.time_scale.max(0.01));
        let first = views.borrow().status.map(|seen| seen.count);
        let settled = async {
            loop {
                let line = views.borrow_and_update().status;
                if let Some(seen) = line {
                    let closing = seen.line.output(CLOSE_OUTPUT);
                    let input = if closing { CLOSED_INPUT } else { OPEN_INPUT };
                    // A line of before the level was set tells nothing.
                    if Some(seen.count) != first && seen.line.input(input) {
                        return;
                    }
                }
                if views.changed().await.is_err() {
                    return;
                }
            }
        };
        let _in_time = timeout(limit, settled).await;
        match self.link.view().status {
            Some(seen) => OpResult::Gripped {
                closed: seen.line.input(CLOSED_INPUT),
                open: seen.line.input(OPEN_INPUT),
                part_present: seen.line.input(PART_INPUT),
            },
            None => OpResult::InDoubt {
                text: "the gripper's inputs cannot be read".to_owned(),
            },
        }
    }

    /// The cell goes on, so what was in doubt has been decided there, by a person where one was needed.
    async fn settle_doubt(&self, operation: &Operation) {
        let motions = &self.robot.motions;
        for doubt in motions.book.doubts() {
            if &*doubt.principal != self.control.actor() {
                continue;
            }
            let respond = Respond {
                motion: doubt.id,
                answer: DoubtAnswer::Abort,
                principal: Arc::from(self.control.actor()),
                reason: "decided by the job's own intervention or reconciliation".to_owned(),
                decision: operation.op,
            };
            if let Err(error) = motions.respond(respond).await {
                tracing::warn!(motion = %doubt.id, %error, "a doubt that was decided stays open");
            }
        }
    }
}

fn asked_motion(to: &Resolved, interpolation: Interpolation, pace: Pace) -> Asked {
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
fn thousandths(value: f64) -> i32 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "an arm's reach and angles fit many times"
    )]
    let rounded = (value * 1_000.0).round() as i32;
    rounded
}

fn percent(pace: Pace) -> u8 {
    match pace {
        Pace::Free => FREE_PERCENT,
        Pace::Reduced => REDUCED_PERCENT,
    }
}

/// The key under which the journal knows the motion of an operation.
fn claim_of(operation: &Operation) -> Result<Claim, String> {
    let key = format!("jobs:{}", operation.op);
    Ok(Claim {
        key: IdempotencyKey::try_new(key).map_err(|error| error.to_string())?,
        body: Digest::of(operation.op.as_bytes()),
    })
}

fn not_now(problem: &Problem) -> OpResult {
    let text = problem.detail().to_owned();
    // The arm cannot do it, now or later.
    let never = matches!(
        problem.code(),
        ProblemCode::Validation
            | ProblemCode::JointLimitExceeded
            | ProblemCode::OutOfWorkspace
            | ProblemCode::Singularity
            | ProblemCode::NoSolutionInConfiguration
    );
    if never {
        OpResult::Rejected { text }
    } else {
        OpResult::NotExecuted { text }
    }
}

fn result_of(end: &End) -> OpResult {
    let why = || match (end.why(), end.code()) {
        (Some(why), _) => why.to_owned(),
        (None, Some(code)) => code.title().to_owned(),
        (None, None) => String::new(),
    };
    match end {
        End::Succeeded { .. } => OpResult::Arrived,
        End::Rejected { text, .. } => OpResult::Rejected {
            text: text.to_string(),
        },
        End::NotExecuted { .. } => OpResult::NotExecuted { text: why() },
        End::Interrupted { .. } => OpResult::Interrupted { text: why() },
        End::Accepted | End::InDoubt { .. } => OpResult::InDoubt { text: why() },
    }
}

impl fmt::Debug for MotionArm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MotionArm").field("id", &self.id()).finish()
    }
}
