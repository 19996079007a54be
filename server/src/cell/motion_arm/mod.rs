//! The cell's operations as durable motions of a robot.

mod asked;
mod ends;

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use jiff::SignedDuration;
use journal::{Claim, Digest, IdempotencyKey, LookupError, Record as Entry};
use tokio::sync::{Semaphore, watch};
use tokio::time::Instant;
use uuid::Uuid;
use workflow::{Action, ArmSeen, Millis, OpResult};

use super::arm::{ArmPort, Later, Operation};
use crate::authority;
use crate::link::cell_server::CellServerLink;
use crate::motions::{InFlight, Numbered, actual, joint_duration};
use crate::request_id::RequestId;
use crate::setup::SetupBook;
use crate::state::Robot;
use asked::percent;
use ends::not_now;

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
                Action::Precheck { targets } => this.precheck(targets).await,
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
                Action::Precheck { targets } => this.precheck(targets).await,
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
}

/// The key under which the journal knows the motion of an operation.
fn claim_of(operation: &Operation) -> Result<Claim, String> {
    let key = format!("jobs:{}", operation.op);
    Ok(Claim {
        key: IdempotencyKey::try_new(key).map_err(|error| error.to_string())?,
        body: Digest::of(operation.op.as_bytes()),
    })
}

impl fmt::Debug for MotionArm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MotionArm").field("id", &self.id()).finish()
    }
}
