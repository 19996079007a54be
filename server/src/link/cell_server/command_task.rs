use std::sync::Arc;
use std::time::Duration;

use protocol::WireMove;
use protocol::v2::{Command, ErrorCode, Reply, Request, Verb, WirePose};
use tokio::io::AsyncRead;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use super::error::{LinkError, ReadError, chain};
use super::exchange::{Written, check_greeting, connect, greet, send, write_once};
use super::follow::Follower;
use super::handle::{Shared, at};
use super::judge::Open;
use super::order::{Instruction, MotionEnd, MotionObserver, MotionOrder, Rejection};
use super::readiness::{self, NotReady};
use super::seed_wire::{self, SeedStream};
use super::status_task::Wanted;
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

    /// Connects, checks again and writes, in the seed's words.
    async fn send_seed(
        &mut self,
        queued: &Queued,
        target: &WireMove,
    ) -> Result<Sent<C::Stream>, LinkError> {
        let order = &queued.order;
        let started = Instant::now();
        if self.seed_fenced != Some(order.wire_epoch) {
            // An earlier connection of this server, or an earlier server, may have left something unread.
            let fenced = self.unless_stopped(queued, self.fence_seed(order)).await?;
            fenced.map_err(LinkError::SeedFence)?;
            self.seed_fenced = Some(order.wire_epoch);
        }
        let plan = &self.shared.plan;
        let connecting = connect(&*self.connector, plan, order.not_after);
        let mut stream = self.unless_stopped(queued, connecting).await??;
        plan.metrics.connected(started.elapsed());
        self.connector.before_send(&stream, &order.request_id);
        // From here to the write nothing waits.
        let boot = self.may_send(queued)?;
        let start = self.shared.view.borrow().status.map(|seen| seen.line.pose);
        let written_at = Instant::now();
        let limit = order.not_after.min(written_at + plan.reply_timeout);
        let written = write_once(&mut stream, &target.encode(), limit).await;
        Ok(Sent {
            channel: match written.map_err(LinkError::WriteNothing)? {
                Written::Whole => Some(Channel::Seed(SeedStream::new(stream))),
                Written::Part(error) => {
                    self.channel_lost(order, &error);
                    None
                }
            },
            boot,
            written_at,
            start,
        })
    }

    /// What comes before the server stops and before a stop.
    async fn unless_stopped<T>(
        &self,
        queued: &Queued,
        future: impl Future<Output = T>,
    ) -> Result<T, LinkError> {
        let mut stops = self.shared.stops.subscribe();
        tokio::select! {
            biased;
            () = self.stop.cancelled() => Err(LinkError::Stopping),
            () = stop_after(&mut stops, queued.stops) => Err(LinkError::StoppedBeforeSent),
            done = future => Ok(done),
        }
    }

    /// Shows that the seed's pose server has read everything that was sent before.
    async fn fence_seed(&self, order: &MotionOrder) -> Result<(), ReadError> {
        let plan = &self.shared.plan;
        let limit = Instant::now() + plan.connect_timeout;
        let stream = match connect(&*self.connector, plan, limit).await {
            Ok(stream) => stream,
            Err(error) => {
                tracing::debug!(robot.id = plan.robot, error = error.chain(), "not fenced");
                return Err(ReadError::Closed);
            }
        };
        self.connector.before_send(&stream, &order.request_id);
        seed_wire::fence(stream, plan.reply_timeout).await
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

    /// Follows a command that was written to its end. `None`: the server stops first.
    async fn follow(&self, queued: &Queued, sent: Sent<C::Stream>) -> Option<MotionEnd> {
        let plan = &self.shared.plan;
        let order = &queued.order;
        let Sent {
            mut channel,
            boot,
            written_at,
            start,
        } = sent;
        let mut follower = Follower::sent(
            plan,
            Open {
                number: order.number(),
                boot: Some(boot),
                accepted: false,
                command: order.command,
            },
            start,
        );
        let is_seed = matches!(order.command, Instruction::Seed(_));
        let mut stops = self.shared.stops.subscribe();
        let mut stopped = false;
        let mut view = self.shared.view.subscribe();
        let mut silent_at = Some(written_at + plan.reply_timeout);
        let mut parting = None;
        loop {
            let look = follower.look(&view.borrow_and_update());
            if look.accepted {
                self.accepted(order, written_at).await;
            }
            if look.executing {
                self.phase(order, Phase::Executing);
                self.observer.executing(order.motion).await;
            }
            if let Some(end) = look.end {
                return Some(self.shared.concluded(end, is_seed).await);
            }
            if follower.is_accepted() {
                silent_at = None;
            } else if channel.is_none() && silent_at.take().is_some() {
                // Whether it was taken is not known, and it must not be taken from now on.
                self.shut_out(order, &mut follower, stopped).await;
                continue;
            }
            let read = async {
                match channel.as_mut() {
                    Some(channel) => channel.next().await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                biased;
                reply = read => match reply {
                    Err(error) => {
                        self.channel_lost(order, &error);
                        channel = None;
                    }
                    Ok(Said::Seed(reply)) => {
                        channel = None;
                        if reply != protocol::Reply::Accepted {
                            let (code, text) = (Rejection::Seed(reply), reply.text().to_owned());
                            return Some(MotionEnd::Rejected { code, text });
                        }
                        let _news = follower.acknowledged();
                        self.accepted(order, written_at).await;
                        self.shared.nudge.notify_one();
                    }
                    Ok(Said::Numbered(reply)) => match self.answer(order, &mut follower, reply) {
                        Answer::Accepted => self.accepted(order, written_at).await,
                        Answer::Known => {}
                        Answer::Done => {
                            channel = None;
                            self.shared.nudge.notify_one();
                        }
                        Answer::End(end) => return Some(end),
                        Answer::Senseless => channel = None,
                    },
                },
                _changed = view.changed() => {}
                () = at(follower.deadline()) => {}
                () = at(silent_at) => {
                    // No answer that tells: what comes on this connection from now on comes too late.
                    channel = None;
                }
                () = stop_after(&mut stops, queued.stops), if is_seed && !stopped => {
                    // The stop ended the pose server, which may have had the command still to read: once it has read
                    // everything, it is ended again.
                    stopped = true;
                    channel = None;
                    if follower.is_accepted() {
                        follower.stopped(self.halt(order).await);
                    }
                }
                () = self.stop.cancelled(), if parting.is_none() => {
                    parting = Some(Instant::now() + PARTING);
                }
                () = at(parting) => return None,
            }
        }
    }

    /// Sees to it that a command nobody has answered is not taken from now on.
    async fn shut_out(&self, order: &MotionOrder, follower: &mut Follower<'_>, stopped: bool) {
        match order.command {
            Instruction::Numbered(_) => self.fence(order).await,
            Instruction::Seed(_) => {
                let fenced = self.fence_seed(order).await;
                follower.unanswered(fenced.is_ok());
                if stopped {
                    follower.stopped(self.halt(order).await);
                }
            }
        }
    }

    /// What an answer on the command port means for a command that was written on its connection.
    fn answer(&self, order: &MotionOrder, follower: &mut Follower<'_>, reply: Reply) -> Answer {
        let number = order.number();
        let fresh = !follower.is_accepted();
        let rejected = |code, text: String| Answer::End(MotionEnd::Rejected { code, text });
        match reply {
            Reply::Ack(acknowledged) if acknowledged == number => {
                // The status line may have been faster.
                return if follower.acknowledged() {
                    Answer::Accepted
                } else {
                    Answer::Known
                };
            }
            Reply::Done { number: done, .. } if done == number => return Answer::Done,
            Reply::Err(code) if fresh => return rejected(Rejection::Error(code), code.to_string()),
            Reply::Stale { epoch_max } if fresh => {
                return rejected(
                    Rejection::Stale { epoch_max },
                    format!("the epoch is below the controller's {epoch_max}"),
                );
            }
            Reply::Busy(running) if fresh => {
                return rejected(Rejection::Busy(running), format!("motion {running} runs"));
            }
            Reply::Dup { number: dup, .. } if fresh && dup == number => {
                return Answer::End(MotionEnd::InDoubt {
                    error: LinkError::Duplicate { number },
                    status: None,
                });
            }
            Reply::Ack(_)
            | Reply::Done { .. }
            | Reply::Err(_)
            | Reply::Stale { .. }
            | Reply::Busy(_)
            | Reply::Dup { .. } => {}
        }
        tracing::warn!(
            robot.id = self.shared.plan.robot,
            motion = %order.motion,
            %number,
            ?reply,
            "the controller's answer makes no sense here"
        );
        Answer::Senseless
    }

    async fn accepted(&self, order: &MotionOrder, written_at: Instant) {
        let plan = &self.shared.plan;
        plan.metrics.replied(written_at.elapsed());
        self.phase(order, Phase::Accepted);
        tracing::info!(
            robot.id = plan.robot,
            request_id = &*order.request_id,
            motion = %order.motion,
            number = %order.number(),
            "the controller took the command"
        );
        self.observer.accepted(order.motion).await;
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

    /// Has the controller end what it moves; whether it has said so.
    async fn halt(&self, order: &MotionOrder) -> bool {
        let halted = self.shared.ask(Wanted::Verb(Verb::Stop)).await;
        if let Err(error) = &halted {
            tracing::warn!(
                robot.id = self.shared.plan.robot,
                motion = %order.motion,
                error = error.chain(),
                "the controller has not confirmed the stop yet"
            );
        }
        halted.is_ok()
    }

    async fn fence(&self, order: &MotionOrder) {
        // Where the status port is down, its next connection fences.
        if let Err(error) = self.shared.ask(Wanted::Fence).await {
            tracing::warn!(
                robot.id = self.shared.plan.robot,
                motion = %order.motion,
                error = error.chain(),
                "the controller could not be fenced yet"
            );
        }
    }

    /// Not a failure of the motion: the status port tells what becomes of it.
    fn channel_lost(&self, order: &MotionOrder, error: &ReadError) {
        tracing::info!(
            robot.id = self.shared.plan.robot,
            motion = %order.motion,
            error = chain(error),
            "the command's connection ended early"
        );
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
