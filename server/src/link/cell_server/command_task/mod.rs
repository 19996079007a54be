//! The command port of a controller: one command at a time, from its turn to its end.

mod follow;
mod seed;

use std::sync::Arc;
use std::time::Duration;

use protocol::v2::{Command, ErrorCode, Reply, Request, WirePose};
use tokio::io::AsyncRead;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use super::error::{LinkError, ReadError};
use super::exchange::{Written, check_greeting, greet, send};
use super::handle::Shared;
use super::order::{Instruction, MotionEnd, MotionObserver, MotionOrder, Rejection};
use super::readiness::{self, NotReady};
use super::seed_wire::SeedStream;
use super::stream::LineStream;
use super::view::{InFlight, Phase};
use crate::link::Connector;

/// How long a motion in flight is followed once the server is stopping. The controller's dead-man stops it when the
/// server has gone.
const PARTING: Duration = Duration::from_secs(3);

/// An order in the queue, and how many stops had been asked for when it came.
#[derive(Debug)]
pub(super) struct Queued {
    pub(super) order: MotionOrder,
    pub(super) stops: u64,
}

/// The owner of the command port: one command at a time, from its turn to its end.
pub(super) struct CommandTask<C, O> {
    pub(super) shared: Arc<Shared>,
    pub(super) connector: Arc<C>,
    pub(super) observer: Arc<O>,
    pub(super) stop: CancellationToken,
    /// The epoch in which the seed's pose server was fenced.
    pub(super) seed_fenced: Option<u32>,
}

impl<C: Connector, O: MotionObserver> CommandTask<C, O> {
    pub(super) async fn run(mut self, mut orders: mpsc::Receiver<Queued>) {
        loop {
            let queued = tokio::select! {
                biased;
                () = self.stop.cancelled() => break,
                queued = orders.recv() => queued,
            };
            let Some(queued) = queued else { break };
            self.shared.plan.metrics.queued(orders.len());
            self.carry_out(queued).await;
        }
        orders.close();
        while let Some(queued) = orders.recv().await {
            let error = LinkError::Stopping;
            self.end(&queued.order, MotionEnd::NotSent { error }).await;
        }
    }

    async fn carry_out(&mut self, queued: Queued) {
        let order = &queued.order;
        if let Err(error) = self.may_send(&queued) {
            self.end(order, MotionEnd::NotSent { error }).await;
            return;
        }
        self.shared.view.send_modify(|view| {
            view.last_motion = Some(order.motion);
            view.in_flight = Some(InFlight {
                motion: order.motion,
                number: order.number(),
                phase: Phase::Dispatched,
            });
        });
        self.observer.dispatched(order.motion).await;
        let sent = match &order.command {
            Instruction::Numbered(command) => self.send_numbered(&queued, *command).await,
            Instruction::Seed(target) => self.send_seed(&queued, target).await,
        };
        let end = match sent {
            Err(error) => Some(MotionEnd::NotSent { error }),
            Ok(sent) => self.follow(&queued, sent).await,
        };
        let end = end.map(|end| self.unless_late(&queued, end));
        self.shared.view.send_modify(|view| view.in_flight = None);
        if let Some(end) = end {
            self.end(order, end).await;
        } else {
            tracing::warn!(
                robot.id = self.shared.plan.robot,
                motion = %order.motion,
                "the server stops while the motion is in flight"
            );
        }
    }

    /// A nonce dies of age, or of a stop. Where nobody stopped, it says nothing about the motion, which may be sent
    /// again under a new number.
    fn unless_late(&self, queued: &Queued, end: MotionEnd) -> MotionEnd {
        match end {
            MotionEnd::Rejected {
                code: Rejection::Error(ErrorCode::Nonce),
                ..
            } if *self.shared.stops.borrow() == queued.stops => MotionEnd::NotSent {
                error: LinkError::GreetingTooOld,
            },
            end @ (MotionEnd::Arrived { .. }
            | MotionEnd::Rejected { .. }
            | MotionEnd::NotSent { .. }
            | MotionEnd::Interrupted { .. }
            | MotionEnd::InDoubt { .. }) => end,
        }
    }

    /// Everything that can speak against sending, at this moment. Gives the controller's boot counter.
    fn may_send(&self, queued: &Queued) -> Result<u32, LinkError> {
        let order = &queued.order;
        if self.stop.is_cancelled() {
            return Err(LinkError::Stopping);
        }
        if *self.shared.stops.borrow() != queued.stops {
            return Err(LinkError::StoppedBeforeSent);
        }
        if Instant::now() >= order.not_after {
            return Err(LinkError::DeadlinePassed);
        }
        if !self.observer.may_begin(order.motion) {
            return Err(LinkError::TakenBack);
        }
        let view = self.shared.view.borrow();
        let (Some(observed), true) = (view.status, view.is_connected()) else {
            let reason = view.not_ready.unwrap_or(NotReady::Disconnected);
            return Err(LinkError::NotReady(reason));
        };
        if let Some(used_up @ NotReady::GenerationsUsedUp { .. }) = view.not_ready {
            return Err(LinkError::NotReady(used_up));
        }
        if view.wire_epoch != Some(order.wire_epoch) {
            return Err(LinkError::WrongEpoch {
                order: order.wire_epoch,
                current: view.wire_epoch,
            });
        }
        let frames = self.shared.plan.frame_numbers;
        // Nothing of this link is moving yet.
        let against = readiness::check(&observed.line, order.wire_epoch, frames, false);
        match against.or_else(|| self.shared.plan.implausible(&observed.line)) {
            Some(reason) => Err(LinkError::NotReady(reason)),
            None => Ok(observed.line.boot),
        }
    }

    /// Connects, is greeted, checks again and writes.
    async fn send_numbered(
        &self,
        queued: &Queued,
        command: Command,
    ) -> Result<Sent<C::Stream>, LinkError> {
        let order = &queued.order;
        let plan = &self.shared.plan;
        let started = Instant::now();
        let greeted = greet(&*self.connector, plan, order);
        let (mut lines, greeting) = self.unless_stopped(queued, greeted).await??;
        plan.metrics.connected(started.elapsed());
        // From here to the write nothing waits. A stop that comes later kills the nonce.
        let boot = self.may_send(queued)?;
        check_greeting(&greeting, order, boot)?;
        let request = Request {
            number: order.number(),
            nonce: greeting.nonce,
            command,
        };
        let written_at = Instant::now();
        let limit = order.not_after.min(written_at + plan.reply_timeout);
        let written = send(&mut lines, &request, limit).await?;
        Ok(Sent {
            channel: match written {
                Written::Whole => Some(Channel::Numbered(lines)),
                Written::Part(error) => {
                    self.channel_lost(order, &error);
                    None
                }
            },
            boot,
            written_at,
            start: None,
        })
    }

    fn phase(&self, order: &MotionOrder, phase: Phase) {
        self.shared.view.send_modify(|view| {
            view.in_flight = Some(InFlight {
                motion: order.motion,
                number: order.number(),
                phase,
            });
        });
    }

    async fn end(&self, order: &MotionOrder, end: MotionEnd) {
        self.shared.plan.metrics.ended(&end);
        tracing::info!(
            robot.id = self.shared.plan.robot,
            request_id = &*order.request_id,
            motion = %order.motion,
            number = %order.number(),
            ?end,
            "the command has ended"
        );
        self.observer.ended(order.motion, end).await;
    }
}

/// Waits until more stops were asked for than `before`.
async fn stop_after(stops: &mut watch::Receiver<u64>, before: u64) {
    // The sender lives as long as the task that waits.
    let _ = stops.wait_for(|stops| *stops != before).await;
}

/// A command that was written, or of which some bytes were.
struct Sent<S> {
    /// The connection it was written on, while it may answer.
    channel: Option<Channel<S>>,
    boot: u32,
    written_at: Instant,
    /// Where the arm stood, for a controller that keeps no numbers.
    start: Option<WirePose>,
}

/// A connection of the command port, by the program that listens there.
enum Channel<S> {
    Numbered(LineStream<S>),
    Seed(SeedStream<S>),
}

/// What the controller said on it.
enum Said {
    Numbered(Reply),
    Seed(protocol::Reply),
}

impl<S: AsyncRead + Unpin> Channel<S> {
    async fn next(&mut self) -> Result<Said, ReadError> {
        match self {
            Self::Numbered(lines) => lines.next(Reply::decode).await.map(Said::Numbered),
            Self::Seed(stream) => stream.next().await.map(Said::Seed),
        }
    }
}

enum Answer {
    Accepted,
    Known,
    Done,
    End(MotionEnd),
    Senseless,
}
