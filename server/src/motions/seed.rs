//! Motions of a robot of tier 0: from a prepared move to the link, and from what became of it to a problem.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use api::{Outcome, ProblemCode, Tier};
use journal::Claim;
use protocol::{Reply, WireMove};
use tokio::sync::oneshot;
use tokio::time::Instant;
use units::MmPerSec;
use uuid::Uuid;

use super::{Asked, End, Entered, Entry, KeyGuard, Record};
use crate::authority;
use crate::config::RobotPlan;
use crate::journal::Trouble;
use crate::link::{Answer, Base, Link, LinkError, Order, TargetCheck, Turned};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::{Robot, RobotLink};
use crate::target::{Prepared, Refusal};

/// What is said where the robot may have moved.
const LOOK: &str =
    "Look at the robot before sending anything else. The server does not send this command again.";

/// A motion the controller took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accepted {
    pub(crate) sent: WireMove,
}

/// Why a command did not end in an accepted motion.
#[derive(Debug)]
pub(crate) enum CommandFailure {
    /// The controller said no.
    Rejected(Reply),
    /// The server's own kinematics said no; nothing was sent.
    Refused(Refusal),
    /// A relative move has nothing to count from; nothing was sent.
    NoBase(Base),
    /// Everything else, already worded.
    Problem(Problem),
}

/// A move on its way to the link.
#[derive(Debug)]
pub(crate) struct Start {
    pub(crate) prepared: Prepared,
    pub(crate) entry: Entry,
    pub(crate) claim: Option<Claim>,
    /// On whose behalf: looked at again before the intent and before the first byte.
    pub(crate) control: authority::Claim,
    /// When its turn must have come.
    pub(crate) begin_by: Instant,
    /// When its answer must have come.
    pub(crate) deadline: Instant,
    /// How many stops there had been when it was asked for.
    pub(crate) stops: u64,
    /// Held until the link has the move, whether or not the caller is still there.
    pub(crate) guard: Option<KeyGuard>,
}

/// A move the link has, or one of earlier.
#[derive(Debug)]
pub(crate) enum Started {
    New {
        motion: Uuid,
        answer: oneshot::Receiver<Answer>,
    },
    Replayed(Uuid),
}

impl Robot {
    /// Sends a prepared move of nobody's key and waits for what becomes of it.
    pub(crate) async fn carry_out(
        self: &Arc<Self>,
        prepared: Prepared,
        control: authority::Claim,
        request_id: RequestId,
        within: Duration,
    ) -> Result<Accepted, CommandFailure> {
        let deadline = Instant::now() + within;
        let start = Start {
            prepared,
            entry: Entry {
                asked: Asked::of(&prepared),
                request_id,
                principal: Arc::from(control.actor()),
                reason: None,
                not_after: None,
            },
            claim: None,
            control,
            begin_by: deadline,
            deadline,
            stops: self.motions.stops(),
            guard: None,
        };
        match self.start(start).await.map_err(CommandFailure::Problem)? {
            Started::New { answer, .. } => self.judge(answer.await.ok()),
            Started::Replayed(motion) => Err(CommandFailure::Problem(
                Problem::new(ProblemCode::Internal, "a move without a key was replayed")
                    .motion(Some(motion)),
            )),
        }
    }

    /// Makes the intent of a move durable and gives it to the link. It goes on where the caller goes away.
    pub(crate) async fn start(self: &Arc<Self>, start: Start) -> Result<Started, Problem> {
        if start.claim.is_none() && !self.motions.keeps_all() {
            // Nothing is waited for, so there is nothing to go on with alone.
            return self.start_unkept(start);
        }
        let robot = Arc::clone(self);
        let mut starting = Box::pin(async move { robot.start_kept(start).await });
        // Where nothing has to be waited for, nobody can go away meanwhile, and a task of its own only costs time.
        if let Poll::Ready(started) = poll_once(starting.as_mut()) {
            return started;
        }
        let started = self.motions.tracker.spawn(starting);
        started.await.unwrap_or_else(|_panicked| {
            Err(Problem::new(
                ProblemCode::Internal,
                "the server failed between journal and link",
            )
            .outcome(Outcome::Unknown)
            .robot(&self.plan.id))
        })
    }

    fn start_unkept(&self, start: Start) -> Result<Started, Problem> {
        let request_id = start.entry.request_id.clone();
        // The place comes first: a command that is turned away leaves no motion.
        let place = self
            .seed_link()?
            .reserve()
            .map_err(|turned| self.turned(turned, &request_id))?;
        let permit = self.motions.begin_unkept(start.entry);
        let motion = permit.motion();
        let order = Order::Move {
            permit,
            prepared: start.prepared,
        };
        let answer = place.send(
            order,
            start.begin_by,
            start.deadline,
            request_id,
            start.control,
        );
        Ok(Started::New { motion, answer })
    }

    async fn start_kept(&self, start: Start) -> Result<Started, Problem> {
        let request_id = start.entry.request_id.clone();
        let place = self
            .seed_link()?
            .reserve()
            .map_err(|turned| self.turned(turned, &request_id))?;
        let mut door = self.motions.door.lock().await;
        start
            .control
            .check()
            .map_err(|refused| Problem::from(refused).robot(&self.plan.id))?;
        let entered = self
            .motions
            .begin(start.entry, start.claim, &mut door)
            .await
            .map_err(|trouble| trouble.problem().robot(&self.plan.id))?;
        match entered {
            Entered::New(permit) => {
                let motion = permit.motion();
                self.motions.heed_stop(motion, start.stops);
                let order = Order::Move {
                    permit,
                    prepared: start.prepared,
                };
                let answer = place.send(
                    order,
                    start.begin_by,
                    start.deadline,
                    request_id,
                    start.control,
                );
                drop(door);
                drop(start.guard);
                Ok(Started::New { motion, answer })
            }
            Entered::Replayed(motion) => Ok(Started::Replayed(motion)),
        }
    }

    /// Sends a move relative to the last accepted target and waits for what becomes of it. `check` sees the target the link
    /// has come to, which no other move can change any more.
    pub(crate) async fn carry_out_delta(
        self: &Arc<Self>,
        change: [f64; 6],
        speed: MmPerSec,
        check: TargetCheck,
        control: authority::Claim,
        request_id: RequestId,
    ) -> Result<Accepted, CommandFailure> {
        let place = self
            .seed_link()
            .map_err(CommandFailure::Problem)?
            .reserve()
            .map_err(|turned| CommandFailure::Problem(self.turned(turned, &request_id)))?;
        let order = Order::Delta {
            change,
            speed,
            principal: Arc::from(control.actor()),
            check,
        };
        let deadline = Instant::now() + self.plan.deadline;
        let answer = place.send(order, deadline, deadline, request_id.clone(), control);
        let answer = answer.await.ok();
        // The link could not tell before, and made no motion of it.
        if let Some(Answer::Refused(refusal)) = &answer {
            refusal.log(&self.plan.id, &request_id);
        }
        if let Some(Answer::NoBase(base)) = &answer {
            tracing::info!(
                robot.id = self.plan.id,
                request_id = &*request_id,
                reason = no_base(*base),
                "the command was refused and not sent"
            );
        }
        self.judge(answer)
    }

    /// The link of the seed program, which the thesis's routes speak to.
    fn seed_link(&self) -> Result<&Link, Problem> {
        match &self.link {
            RobotLink::Seed(link) => Ok(link),
            RobotLink::CellServer(_) => Err(Problem::not_sent(
                ProblemCode::NotSupported,
                if self.plan.tier == Tier::SeedStatus {
                    "the motions of this robot are observed to their end; they are at /api/v1"
                } else {
                    "the robot's controller runs another program than the seed's; its motions are at /api/v1"
                },
            )
            .robot(&self.plan.id)),
        }
    }

    fn judge(&self, answer: Option<Answer>) -> Result<Accepted, CommandFailure> {
        match answer {
            Some(Answer::Replied {
                reply: Reply::Accepted,
                sent,
            }) => Ok(Accepted { sent }),
            Some(Answer::Replied { reply, .. }) => Err(CommandFailure::Rejected(reply)),
            // Who holds control now is worth telling.
            Some(Answer::Failed {
                motion,
                error: LinkError::Control(refused),
            }) => Err(CommandFailure::Problem(
                Problem::from(refused).robot(&self.plan.id).motion(motion),
            )),
            Some(Answer::Failed { motion, error }) => {
                let problem = problem_of_end(&self.plan, motion, &error.end());
                Err(CommandFailure::Problem(problem))
            }
            Some(Answer::Refused(refusal)) => Err(CommandFailure::Refused(refusal)),
            Some(Answer::Forbidden(problem)) => {
                Err(CommandFailure::Problem(problem.robot(&self.plan.id)))
            }
            Some(Answer::NoBase(base)) => Err(CommandFailure::NoBase(base)),
            Some(Answer::Unkept(trouble)) => Err(CommandFailure::Problem(self.unkept(&trouble))),
            None => Err(CommandFailure::Problem(
                Problem::new(ProblemCode::Internal, "the robot's link has ended")
                    .outcome(Outcome::Unknown)
                    .robot(&self.plan.id),
            )),
        }
    }

    fn unkept(&self, trouble: &Trouble) -> Problem {
        trouble.problem().robot(&self.plan.id)
    }

    fn turned(&self, turned: Turned, request_id: &str) -> Problem {
        tracing::info!(
            robot.id = self.plan.id,
            request_id,
            reason = ?turned,
            "the command was turned away and not sent"
        );
        let problem = match turned {
            Turned::Busy => Problem::not_sent(
                ProblemCode::ControllerBusy,
                format!(
                    "{} commands are waiting for this robot, and no more may",
                    self.plan.queue_capacity
                ),
            ),
            Turned::Stopping => {
                Problem::not_sent(ProblemCode::ShuttingDown, LinkError::Stopping.to_string())
            }
        };
        problem.robot(&self.plan.id).retry_after_a_second()
    }
}

/// What a future has at once. Whoever polls it next is woken.
fn poll_once<F: Future>(future: Pin<&mut F>) -> Poll<F::Output> {
    future.poll(&mut Context::from_waker(Waker::noop()))
}

/// The problem a motion ended in, if it did.
pub(crate) fn problem_of(plan: &RobotPlan, record: &Record) -> Option<Problem> {
    let end = record.progress.end()?;
    let _went_wrong = end.code()?;
    Some(problem_of_end(plan, Some(record.id), end))
}

/// The problem of a motion that did not do what it was to do.
fn problem_of_end(plan: &RobotPlan, motion: Option<Uuid>, end: &End) -> Problem {
    let code = end.code().unwrap_or(ProblemCode::Internal);
    let why = || end.why().unwrap_or_else(|| code.title());
    let problem = match end {
        End::Rejected { text, .. } => {
            Problem::new(code, format!("the controller answered \"{text}\""))
                .outcome(Outcome::Rejected)
        }
        End::NotExecuted { .. } => Problem::not_sent(code, why()).retryable(),
        End::Interrupted { .. } => Problem::new(
            code,
            "the motion began and ended before its target; the arm is where it stopped",
        )
        .outcome(Outcome::Unknown),
        End::Accepted | End::Succeeded { .. } | End::InDoubt { .. } => {
            Problem::new(code, format!("{}; the robot may have moved", why()))
                .outcome(Outcome::Unknown)
                .hint(LOOK)
        }
    };
    let problem = problem
        .robot(&plan.id)
        .motion(motion)
        .controller_text(end.controller_text());
    match code.status() {
        503 => problem.retry_after_a_second(),
        _ => problem,
    }
}

/// Why a relative move has nothing to count from.
pub(crate) fn no_base(base: Base) -> &'static str {
    match base {
        Base::Nothing | Base::Target(_) => "no move was accepted since the server started",
        Base::InDoubt => {
            "the last move is in doubt, so the target the arm is going to is not known; an absolute move sets it"
        }
    }
}
