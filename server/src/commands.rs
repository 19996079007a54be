//! From a prepared move to what became of it, and to the problem that says so.

use std::sync::Arc;
use std::time::Duration;

use api::{Outcome, ProblemCode};
use protocol::{Reply, WireMove};
use units::MmPerSec;
use uuid::Uuid;

use crate::authority::Claim;
use crate::link::{Answer, Base, LinkError, Order, Turned};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::Robot;
use crate::target::{Prepared, Refusal};

/// A motion the controller took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accepted {
    pub(crate) motion: Uuid,
    pub(crate) sent: WireMove,
}

/// Why a command did not end in an accepted motion.
#[derive(Debug)]
pub(crate) enum CommandFailure {
    /// The controller said no.
    Rejected { motion: Uuid, reply: Reply },
    /// The server's own kinematics said no; nothing was sent.
    Refused(Refusal),
    /// A relative move has nothing to count from; nothing was sent.
    NoBase(Base),
    /// Everything else, already worded.
    Problem(Problem),
}

impl Robot {
    /// Sends a prepared move and waits for what becomes of it.
    pub(crate) async fn carry_out(
        self: &Arc<Self>,
        prepared: Prepared,
        claim: Claim,
        request_id: RequestId,
        within: Duration,
        reason: Option<String>,
    ) -> Result<Accepted, CommandFailure> {
        // The place comes first: a command that is turned away leaves no motion.
        let place = self
            .link
            .reserve()
            .map_err(|turned| self.turned(turned, &request_id))?;
        let motion = self.motions.queue(prepared, request_id.clone(), reason);
        let order = Order::Move { motion, prepared };
        self.judge(place.fill(order, within, request_id, claim).await)
    }

    /// Sends a move relative to the last accepted target and waits for what becomes of it.
    pub(crate) async fn carry_out_delta(
        self: &Arc<Self>,
        change: [f64; 6],
        speed: MmPerSec,
        claim: Claim,
        request_id: RequestId,
    ) -> Result<Accepted, CommandFailure> {
        let place = self
            .link
            .reserve()
            .map_err(|turned| self.turned(turned, &request_id))?;
        let order = Order::Delta { change, speed };
        let within = self.plan.deadline;
        let answer = place.fill(order, within, request_id.clone(), claim).await;
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

    fn judge(&self, answer: Option<Answer>) -> Result<Accepted, CommandFailure> {
        match answer {
            Some(Answer::Replied {
                motion,
                reply: Reply::Accepted,
                sent,
            }) => Ok(Accepted { motion, sent }),
            Some(Answer::Replied { motion, reply, .. }) => {
                Err(CommandFailure::Rejected { motion, reply })
            }
            Some(Answer::Failed { motion, error }) => {
                Err(CommandFailure::Problem(self.link_problem(motion, &error)))
            }
            Some(Answer::Refused(refusal)) => Err(CommandFailure::Refused(refusal)),
            Some(Answer::NoBase(base)) => Err(CommandFailure::NoBase(base)),
            None => Err(CommandFailure::Problem(
                Problem::new(ProblemCode::Internal, "the robot's link has ended")
                    .outcome(Outcome::Unknown)
                    .robot(&self.plan.id),
            )),
        }
    }

    fn turned(&self, turned: Turned, request_id: &str) -> CommandFailure {
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
        CommandFailure::Problem(problem.robot(&self.plan.id).retry_after_a_second())
    }

    fn link_problem(&self, motion: Option<Uuid>, error: &LinkError) -> Problem {
        if let LinkError::Control(refused) = error {
            return Problem::from(refused.clone())
                .robot(&self.plan.id)
                .motion(motion);
        }
        let problem = match error.outcome() {
            Outcome::NotSent | Outcome::None => {
                Problem::not_sent(error.code(), error.chain()).retryable()
            }
            Outcome::Unknown | Outcome::Rejected => Problem::new(
                error.code(),
                format!("{}; the robot may have moved", error.chain()),
            )
            .outcome(Outcome::Unknown)
            .hint("Look at the robot before sending anything else. The server does not send this command again."),
        };
        let problem = problem
            .robot(&self.plan.id)
            .motion(motion)
            .controller_text(error.controller_text());
        match error.code().status() {
            503 => problem.retry_after_a_second(),
            _ => problem,
        }
    }

    /// The problem of a command the controller refused.
    pub(crate) fn rejected(&self, motion: Uuid, reply: Reply) -> Problem {
        Problem::new(
            ProblemCode::ControllerRejected,
            format!("the controller answered \"{reply}\""),
        )
        .outcome(Outcome::Rejected)
        .robot(&self.plan.id)
        .motion(Some(motion))
        .controller_text(Some(reply.text()))
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
