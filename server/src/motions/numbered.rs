//! Motions of a robot of tier 2: numbered, observed to their end, and asked about again after a restart.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use api::{Outcome, ProblemCode};
use jiff::Timestamp;
use journal::{Claim, Hold, Mode, Observation, OutputLevel, Standstill};
use kinematics::{Configuration, Elbow, Flip, Front};
use protocol::v2::{
    Command, FinishStatus, LinearSpeed, MotionNumber, Move, OperatingMode, Output, OutputNumber,
    Percent, StatusLine, ValueError, WireConfiguration, WireJoints, WirePose,
};
use protocol::{MoveCommand, WireMove};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use units::{Degrees, MmPerSec};
use uuid::Uuid;

use super::record::{point_of_thousandths, target_of};
use super::{Asked, Door, End, Entered, Entry, KeyGuard, Motions, Permit, Progress, Speed};
use crate::authority;
use crate::config::RobotPlan;
use crate::link::cell_server::{
    CellServerLink, Instruction, MotionEnd, MotionObserver, MotionOrder, NotReady, Open,
};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::Robot;

/// Between two attempts to ask a controller about what an earlier process left behind.
const ASK_AGAIN: Duration = Duration::from_millis(500);

/// Makes a motion of what is known when its turn at the door comes.
pub(crate) type Resolve = Box<dyn FnOnce(&Robot) -> Result<Asked, Problem> + Send>;

/// A motion on its way to the link.
pub(crate) struct Numbered {
    pub(crate) resolve: Resolve,
    pub(crate) request_id: RequestId,
    pub(crate) principal: Arc<str>,
    pub(crate) reason: Option<String>,
    pub(crate) not_after: Timestamp,
    pub(crate) begin_by: Instant,
    pub(crate) claim: Claim,
    /// On whose behalf: looked at again right before the intent.
    pub(crate) control: authority::Claim,
    /// How many stops there had been when it was asked for.
    pub(crate) stops: u64,
    /// Held until the link has the motion, whether or not the caller is still there.
    pub(crate) guard: KeyGuard,
}

/// A motion of an earlier process whose end is open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leftover {
    pub(super) motion: Uuid,
    pub(super) open: Open,
}

impl Robot {
    /// Makes the intent of a motion durable and gives it to the link; the motion, and whether it is a new one. It goes
    /// on where the caller goes away.
    pub(crate) async fn start_numbered(
        self: &Arc<Self>,
        link: &CellServerLink,
        numbered: Numbered,
    ) -> Result<(Uuid, bool), Problem> {
        let (robot, link) = (Arc::clone(self), link.clone());
        let started = self
            .motions
            .tracker
            .spawn(async move { robot.pass_door(&link, numbered).await });
        let started = started.await.unwrap_or_else(|_panicked| {
            Err(Problem::new(
                ProblemCode::Internal,
                "the server failed between journal and link",
            )
            .outcome(Outcome::Unknown))
        });
        started.map_err(|problem| problem.robot(&self.plan.id))
    }

    async fn pass_door(
        &self,
        link: &CellServerLink,
        numbered: Numbered,
    ) -> Result<(Uuid, bool), Problem> {
        let mut door = self.motions.door.lock().await;
        numbered.control.check()?;
        let wire_epoch = ready(link, &self.motions)?;
        let asked = (numbered.resolve)(self)?;
        let command = command_of(&asked, &self.plan)
            .map_err(|error| Problem::not_sent(ProblemCode::Validation, error))?;
        let request_id = numbered.request_id.clone();
        let entry = Entry {
            asked,
            request_id: numbered.request_id,
            principal: numbered.principal,
            reason: numbered.reason,
            not_after: Some(numbered.not_after),
        };
        door.enter_wire_epoch(wire_epoch, link.view().status.map(|seen| seen.line.boot));
        let entered = self.motions.begin(entry, Some(numbered.claim), &mut door);
        let permit = match entered.await.map_err(|trouble| trouble.problem())? {
            Entered::New(permit) => permit,
            Entered::Replayed(motion) => return Ok((motion, false)),
        };
        let motion = permit.motion();
        self.motions.heed_stop(motion, numbered.stops);
        let submitted = submit(link, &permit, &door, command, numbered.begin_by, request_id);
        if submitted.is_err() {
            // There was room a moment ago, and only the door fills it: the server is stopping.
            let end = End::NotExecuted {
                code: ProblemCode::ShuttingDown,
                why: Some("the server is stopping".into()),
            };
            let _at = self.motions.end(motion, end).await;
        }
        drop(door);
        drop(numbered.guard);
        Ok((motion, true))
    }
}

/// Gives a link what the journal has: there is no permit without a durable intent, and it goes no further than here.
fn submit(
    link: &CellServerLink,
    permit: &Permit,
    door: &Door,
    command: Instruction,
    not_after: Instant,
    request_id: RequestId,
) -> Result<(), crate::link::Turned> {
    link.submit(MotionOrder {
        motion: permit.motion(),
        wire_epoch: door.wire_epoch.unwrap_or_default(),
        seq: u32::try_from(door.number).unwrap_or(u32::MAX),
        command,
        not_after,
        request_id,
    })
}

/// The epoch to number the next motion in, if one would be taken now.
fn ready(link: &CellServerLink, motions: &Motions) -> Result<u32, Problem> {
    let view = link.view();
    let (waiting, capacity) = link.depth();
    if waiting >= capacity {
        let detail = format!("{capacity} commands are waiting for this robot, and no more may");
        return Err(Problem::not_sent(ProblemCode::ControllerBusy, detail).retry_after_a_second());
    }
    if motions.recovering.load(Ordering::Acquire) > 0 {
        let detail = "what became of a motion from before the restart is still being found out";
        return Err(
            Problem::not_sent(ProblemCode::ControllerNotReady, detail).retry_after_a_second()
        );
    }
    match (view.wire_epoch, view.not_ready) {
        (Some(epoch), None) if view.is_connected() => Ok(epoch),
        (Some(_), Some(reason)) if view.is_connected() => Err(Problem::not_sent(
            ProblemCode::ControllerNotReady,
            reason.to_string(),
        )),
        (_, Some(reason @ NotReady::OtherController { .. })) => Err(Problem::not_sent(
            ProblemCode::ControllerNotReady,
            reason.to_string(),
        )),
        _ => Err(Problem::not_sent(
            ProblemCode::ControllerDisconnected,
            "the controller's status port is not connected",
        )
        .retry_after_a_second()),
    }
}

/// The command on the wire for a motion.
pub(super) fn command_of(asked: &Asked, plan: &RobotPlan) -> Result<Instruction, String> {
    match plan.tier {
        api::Tier::Seed | api::Tier::SeedStatus => seed_command_of(asked).map(Instruction::Seed),
        api::Tier::CellServer => numbered_command_of(asked, plan)
            .map(Instruction::Numbered)
            .map_err(|error| error.to_string()),
    }
}

/// The seed's wire carries a pose and a speed in mm/s, and nothing else.
fn seed_command_of(asked: &Asked) -> Result<WireMove, String> {
    let (None, Speed::MmPerSec(speed)) = (asked.output, asked.speed) else {
        return Err("the program on this controller takes poses at speeds in mm/s only".to_owned());
    };
    let point = point_of_thousandths(asked.point);
    let command = MoveCommand {
        x: point.x,
        y: point.y,
        z: point.z,
        w: point.w,
        p: point.p,
        r: point.r,
        speed: MmPerSec(f64::from(speed)),
    };
    command.to_wire().map_err(|error| error.to_string())
}

fn numbered_command_of(asked: &Asked, plan: &RobotPlan) -> Result<Command, ValueError> {
    if let Some(OutputLevel { output, on }) = asked.output {
        let output = OutputNumber::try_new(output)?;
        return Ok(Command::Output(Output { output, on }));
    }
    let point = point_of_thousandths(asked.point);
    let pose = || WirePose::try_new([point.x, point.y, point.z], [point.w, point.p, point.r]);
    let configuration = wire_configuration(plan.configuration);
    Ok(Command::Move(match asked.speed {
        Speed::MmPerSec(speed) => Move::Linear {
            pose: pose()?,
            speed: LinearSpeed::try_new(speed)?,
            configuration,
        },
        Speed::Percent(percent) if asked.to_joints => Move::Joints {
            joints: WireJoints::try_new(asked.joints.degrees().map(Degrees))?,
            speed: Percent::try_new(percent)?,
        },
        Speed::Percent(percent) => Move::Joint {
            pose: pose()?,
            speed: Percent::try_new(percent)?,
            configuration,
        },
    }))
}

fn wire_configuration(configuration: Configuration) -> WireConfiguration {
    use protocol::v2;
    WireConfiguration {
        flip: match configuration.flip {
            Flip::NoFlip => v2::Flip::NoFlip,
            Flip::Flip => v2::Flip::Flip,
        },
        elbow: match configuration.elbow {
            Elbow::Up => v2::Elbow::Up,
            Elbow::Down => v2::Elbow::Down,
        },
        front: match configuration.front {
            Front::Toward => v2::Front::Toward,
            Front::Back => v2::Front::Back,
        },
        turns: configuration.turns,
    }
}

impl MotionObserver for Motions {
    fn may_begin(&self, motion: Uuid) -> bool {
        let open = self
            .book
            .look(motion, |record| record.progress.end().is_none());
        open == Some(true)
    }

    async fn dispatched(&self, motion: Uuid) {
        let _was_queued = self.dispatch(motion);
    }

    async fn accepted(&self, motion: Uuid) {
        let at = self.now();
        // What is kept here only helps: the controller has the number, and is asked after a restart.
        let kept = self.journal().append(at, super::intent::taken(motion));
        if let Err(trouble) = kept.await {
            tracing::error!(%motion, error = %trouble, "an acceptance could not be kept");
        }
        let _changed = self.book.update(motion, |progress| match progress {
            Progress::Queued | Progress::Dispatched => Some(Progress::Accepted),
            Progress::Accepted | Progress::Executing | Progress::Ended { .. } => None,
        });
    }

    async fn executing(&self, motion: Uuid) {
        let _changed = self.book.update(motion, |progress| match progress {
            Progress::Queued | Progress::Dispatched | Progress::Accepted => {
                Some(Progress::Executing)
            }
            Progress::Executing | Progress::Ended { .. } => None,
        });
    }

    async fn ended(&self, motion: Uuid, end: MotionEnd) {
        let end = end_of(end, self.now());
        let _at = self.end(motion, end).await;
    }
}

fn end_of(end: MotionEnd, now: Timestamp) -> End {
    let seen = |status: &StatusLine| Some(Arc::new(observation(status, now)));
    match end {
        MotionEnd::Arrived { status } => End::Succeeded {
            seen: seen(&status),
        },
        MotionEnd::Rejected { text, .. } => End::Rejected {
            text: text.into(),
            code: ProblemCode::ControllerRejected,
        },
        MotionEnd::NotSent { error } => End::NotExecuted {
            code: error.code(),
            why: Some(error.chain().into()),
        },
        MotionEnd::Interrupted { fin_status, status } => End::Interrupted {
            code: match fin_status {
                FinishStatus::Stopped => ProblemCode::MotionCanceled,
                FinishStatus::Arrived | FinishStatus::Alarm | FinishStatus::DeadMan => {
                    ProblemCode::MotionInterrupted
                }
            },
            seen: seen(&status),
        },
        MotionEnd::InDoubt { error, status } => End::InDoubt {
            code: error.code(),
            text: None,
            why: Some(error.chain().into()),
            seen: status.as_ref().and_then(seen),
        },
    }
}

/// A status line as evidence. The link has read it more than once where it had to stay the same.
pub(super) fn observation(line: &StatusLine, now: Timestamp) -> Observation {
    Observation {
        fence_at: None,
        first_at: now,
        second_at: now,
        pose: target_of(line.pose.thousandths()),
        standstill: if line.moving {
            Standstill::Moving
        } else {
            Standstill::Standing
        },
        hold: if line.held { Hold::Held } else { Hold::Free },
        mode: match line.mode {
            OperatingMode::T1 => Mode::T1,
            OperatingMode::T2 => Mode::T2,
            OperatingMode::Auto => Mode::Auto,
        },
        boot: Some(line.boot.into()),
        pendant_since: None,
        alarm: (line.alarm != 0).then(|| format!("{}-{:03}", line.alarm / 1000, line.alarm % 1000)),
    }
}

impl Motions {
    /// Asks the controller about the motions an earlier process left behind, until it has told of each.
    pub(crate) async fn reconcile(self: Arc<Self>, link: CellServerLink, stop: CancellationToken) {
        let leftovers = std::mem::take(&mut *self.leftovers());
        for leftover in leftovers {
            let told = stop.run_until_cancelled(self.ask_until_told(&link, leftover));
            let Some(end) = told.await else { return };
            tracing::warn!(
                robot.id = self.plan.id,
                motion = %leftover.motion,
                ?end,
                "the controller told of a motion from before the restart"
            );
            self.ended(leftover.motion, end).await;
            let _left = self.recovering.fetch_sub(1, Ordering::AcqRel);
        }
    }

    async fn ask_until_told(&self, link: &CellServerLink, leftover: Leftover) -> MotionEnd {
        loop {
            match link.reconcile(leftover.open).await {
                Ok(end) => return end,
                Err(error) => tracing::debug!(
                    robot.id = self.plan.id,
                    motion = %leftover.motion,
                    error = error.chain(),
                    "the controller cannot be asked yet"
                ),
            }
            tokio::time::sleep(ASK_AGAIN).await;
        }
    }

    /// What has to be asked about a motion without an end, if it was numbered.
    pub(super) fn leftover(
        &self,
        record: &super::Record,
        intent: &journal::Intent,
        accepted: bool,
    ) -> Option<Leftover> {
        let more = intent.asked.as_deref()?;
        let number = MotionNumber {
            epoch: more.wire_epoch?,
            seq: u32::try_from(intent.seq).ok()?,
        };
        Some(Leftover {
            motion: record.id,
            open: Open {
                number,
                boot: more.boot,
                accepted,
                command: command_of(&record.asked, &self.plan).ok()?,
            },
        })
    }
}
