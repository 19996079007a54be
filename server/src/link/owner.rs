use std::sync::Arc;
use std::time::Duration;

use api::{LinkState, Outcome, ProblemCode};
use protocol::{Reply, WireMove};
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

use super::seed::{Answered, Drained, Exchange, drain};
use super::{
    Answer, Base, Connector, FenceAnswer, Job, Link, LinkError, Order, Status, TargetCheck,
};
use crate::authority::Claim;
use crate::config::RobotPlan;
use crate::metrics::LinkMetrics;
use crate::motions::{Asked, End, Entry, Motions, Permit};
use crate::request_id::RequestId;
use crate::target::{Prepared, moved_by};

/// For how long after an answer a refused connection means that the controller is reopening its tag.
///
/// ASSUMPTION: between two commands the seed program closes its tag and opens it again, and is done in this time.
const REOPENING: Duration = Duration::from_millis(300);

/// The one task that talks to a robot's controller.
#[derive(Debug)]
pub(crate) struct Owner<C> {
    pub(crate) plan: Arc<RobotPlan>,
    pub(crate) motions: Arc<Motions>,
    pub(crate) connector: Arc<C>,
    pub(crate) metrics: LinkMetrics,
}

/// Starts the owner task of a link. It ends between two commands once `stop` is cancelled, and answers what is
/// still queued.
pub(crate) fn spawn<C: Connector>(
    owner: Owner<C>,
    tracker: &TaskTracker,
    stop: CancellationToken,
) -> Link {
    let (queue, jobs) = mpsc::channel(owner.plan.queue_capacity);
    let (fences, fenced) = mpsc::channel(1);
    let (publish, status) = watch::channel(Status {
        state: LinkState::Untried,
        last_answer_at: None,
        last_failure: None,
        base: Base::Nothing,
        last_motion: None,
    });
    let task = Task {
        owner,
        publish,
        reopening_until: None,
        received: Vec::with_capacity(256),
    };
    // The tracker waits for the task; nothing needs its handle.
    drop(tracker.spawn(task.run(jobs, fenced, stop)));
    Link {
        queue,
        fences,
        status,
    }
}

struct Task<C> {
    owner: Owner<C>,
    publish: watch::Sender<Status>,
    reopening_until: Option<Instant>,
    received: Vec<u8>,
}

impl<C: Connector> Task<C> {
    async fn run(
        mut self,
        mut jobs: mpsc::Receiver<Job>,
        mut fences: mpsc::Receiver<FenceAnswer>,
        stop: CancellationToken,
    ) {
        loop {
            let job = tokio::select! {
                biased;
                () = stop.cancelled() => break,
                Some(answer) = fences.recv() => {
                    let fenced = self.fence().await;
                    // Whoever asked may have gone.
                    let _gone = answer.send(fenced);
                    continue;
                }
                job = jobs.recv() => job,
            };
            match job {
                Some(job) => self.carry_out(job).await,
                None => break,
            }
        }
        jobs.close();
        while let Some(job) = jobs.recv().await {
            self.fail_unsent(job, LinkError::Stopping).await;
        }
    }

    /// Has the controller refuse a message, which proves that it has read those before.
    async fn fence(&mut self) -> Result<(), LinkError> {
        let exchange = Exchange {
            connector: &*self.owner.connector,
            plan: &self.owner.plan,
            request_id: "fence",
            deadline: Instant::now() + self.owner.plan.deadline,
            reopening_until: self.reopening_until.take(),
        };
        let stream = exchange.connect().await?;
        let fence = protocol::seed_fence();
        let Answered { reply, stream } = exchange.send(stream, &fence, &mut self.received).await?;
        self.finish(stream, "fence").await;
        match reply {
            Reply::Unreachable => Ok(()),
            Reply::Accepted | Reply::IncorrectInput => Err(LinkError::UnknownReply {
                text: reply.text().to_owned(),
            }),
        }
    }

    async fn carry_out(&mut self, job: Job) {
        if Instant::now() >= job.begin_by.min(job.deadline) {
            self.fail_unsent(job, LinkError::DeadlinePassed).await;
            return;
        }
        if let Err(refused) = job.claim.check() {
            self.fail_unsent(job, refused.into()).await;
            return;
        }
        let (permit, prepared) = match job.order {
            Order::Move { permit, prepared } => (permit, prepared),
            Order::Delta {
                change,
                speed,
                principal,
                check,
            } => match self
                .begin_delta(change, speed, principal, check, &job.request_id)
                .await
            {
                Ok(begun) => begun,
                Err(answer) => {
                    answer_caller(job.answer, answer);
                    return;
                }
            },
        };
        let motion = permit.motion();
        if !self.owner.motions.dispatch(motion) {
            let answer = Answer::Failed {
                motion: Some(motion),
                error: LinkError::TakenBack,
            };
            answer_caller(job.answer, answer);
            return;
        }
        self.publish.send_modify(|status| {
            status.state = LinkState::Busy;
            status.last_motion = Some(motion);
        });
        let exchanged = self
            .exchange(&prepared.wire, &job.request_id, job.deadline, &job.claim)
            .await;
        match exchanged {
            Ok(Answered { reply, stream }) => {
                self.record_reply(motion, reply, prepared.wire, &job.request_id)
                    .await;
                answer_caller(
                    job.answer,
                    Answer::Replied {
                        reply,
                        sent: prepared.wire,
                    },
                );
                self.finish(stream, &job.request_id).await;
            }
            Err(error) => {
                self.record_failure(motion, &error, &job.request_id).await;
                let answer = Answer::Failed {
                    motion: Some(motion),
                    error,
                };
                answer_caller(job.answer, answer);
            }
        }
    }

    async fn exchange(
        &mut self,
        wire: &WireMove,
        request_id: &str,
        deadline: Instant,
        claim: &Claim,
    ) -> Result<Answered<C::Stream>, LinkError> {
        let exchange = Exchange {
            connector: &*self.owner.connector,
            plan: &self.owner.plan,
            request_id,
            deadline,
            reopening_until: self.reopening_until.take(),
        };
        let started = Instant::now();
        let stream = exchange.connect().await?;
        let connected = Instant::now();
        self.owner.metrics.connected(connected - started);
        // Connecting may have taken long: nothing is sent on behalf of somebody who is not in control any more.
        claim.check()?;
        let answered = exchange
            .send(stream, &wire.encode(), &mut self.received)
            .await?;
        self.owner.metrics.replied(connected.elapsed());
        Ok(answered)
    }

    /// Resolves a relative move and makes its intent durable.
    async fn begin_delta(
        &self,
        change: [f64; 6],
        speed: units::MmPerSec,
        principal: Arc<str>,
        check: TargetCheck,
        request_id: &RequestId,
    ) -> Result<(Permit, Prepared), Answer> {
        let prepared = self.resolve(change, speed)?;
        (check.0)(&prepared).map_err(Answer::Forbidden)?;
        let entry = Entry {
            asked: Asked::of(&prepared),
            request_id: request_id.clone(),
            principal,
            reason: None,
            not_after: None,
        };
        match self.owner.motions.begin_in_link(entry).await {
            Ok(permit) => Ok((permit, prepared)),
            Err(trouble) => Err(Answer::Unkept(trouble)),
        }
    }

    /// The absolute target of a relative move, counted from the target last accepted.
    fn resolve(&self, change: [f64; 6], speed: units::MmPerSec) -> Result<Prepared, Answer> {
        let base = self.publish.borrow().base;
        let Base::Target(base) = base else {
            return Err(Answer::NoBase(base));
        };
        let point = moved_by(&base, change);
        self.owner
            .plan
            .prepare_point(&point, speed)
            .map_err(Answer::Refused)
    }

    async fn record_reply(&self, motion: Uuid, reply: Reply, sent: WireMove, request_id: &str) {
        let end = match reply {
            Reply::Accepted => End::Accepted,
            Reply::Unreachable | Reply::IncorrectInput => End::Rejected {
                text: reply.text().into(),
                code: ProblemCode::ControllerRejected,
            },
        };
        let at = self.owner.motions.end(motion, end).await;
        self.owner.metrics.reply(reply);
        self.publish.send_modify(|status| {
            status.state = LinkState::Answering;
            status.last_answer_at = Some(at);
            status.last_failure = None;
            if reply == Reply::Accepted {
                status.base = Base::Target(sent);
            }
        });
        let robot = &self.owner.plan.id;
        match reply {
            Reply::Accepted => tracing::info!(
                robot.id = robot,
                request_id,
                %motion,
                "the controller took the command"
            ),
            Reply::Unreachable | Reply::IncorrectInput => tracing::info!(
                robot.id = robot,
                request_id,
                %motion,
                %reply,
                "the controller refused the command"
            ),
        }
    }

    async fn record_failure(&self, motion: Uuid, error: &LinkError, request_id: &str) {
        let _at = self.owner.motions.end(motion, error.end()).await;
        self.owner.metrics.failure(error);
        let in_doubt = error.outcome() == Outcome::Unknown;
        self.publish.send_modify(|status| {
            status.last_failure = Some(error.code());
            status.state = if in_doubt {
                LinkState::Degraded
            } else {
                LinkState::Disconnected
            };
            if in_doubt {
                status.base = Base::InDoubt;
            }
        });
        tracing::warn!(
            robot.id = self.owner.plan.id,
            request_id,
            %motion,
            outcome = ?error.outcome(),
            error = error.chain(),
            "the command got no answer that tells"
        );
    }

    /// Answers an order whose turn did not come.
    async fn fail_unsent(&self, job: Job, error: LinkError) {
        let motion = match &job.order {
            Order::Move { permit, .. } => Some(permit.motion()),
            Order::Delta { .. } => None,
        };
        if let Some(motion) = motion {
            let _at = self.owner.motions.end(motion, error.end()).await;
        }
        self.owner.metrics.failure(&error);
        tracing::info!(
            robot.id = self.owner.plan.id,
            request_id = &*job.request_id,
            reason = %error,
            "the command was not sent"
        );
        answer_caller(job.answer, Answer::Failed { motion, error });
    }

    async fn finish(&mut self, stream: C::Stream, request_id: &str) {
        match drain(stream, &mut self.received).await {
            Drained::Closed => {}
            Drained::MoreBytes => tracing::warn!(
                robot.id = self.owner.plan.id,
                request_id,
                bytes = self.received.len(),
                "bytes followed the controller's reply; is another program answering?"
            ),
            // Some controllers close their end only when the client does; nothing is wrong with the command.
            Drained::LeftOpen => tracing::info!(
                robot.id = self.owner.plan.id,
                request_id,
                "the controller left the connection open after its reply"
            ),
        }
        self.reopening_until = Some(Instant::now() + REOPENING);
    }
}

/// The caller may have gone; what became of its order is recorded all the same.
fn answer_caller(caller: tokio::sync::oneshot::Sender<Answer>, answer: Answer) {
    if caller.send(answer).is_err() {
        tracing::debug!("the caller went away before its answer");
    }
}
