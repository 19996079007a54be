//! From the first byte of a numbered command to its end.

use protocol::v2::{Reply, Verb};
use tokio::time::Instant;

use super::super::error::{LinkError, ReadError, chain};
use super::super::follow::Follower;
use super::super::handle::at;
use super::super::judge::Open;
use super::super::order::{Instruction, MotionEnd, MotionObserver, MotionOrder, Rejection};
use super::super::status_task::Wanted;
use super::super::view::Phase;
use super::stop_after;
use super::{Answer, CommandTask, PARTING, Queued, Said, Sent};
use crate::link::Connector;

impl<C: Connector, O: MotionObserver> CommandTask<C, O> {
    /// Follows a command that was written to its end. `None`: the server stops first.
    pub(super) async fn follow(&self, queued: &Queued, sent: Sent<C::Stream>) -> Option<MotionEnd> {
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
    pub(super) async fn shut_out(
        &self,
        order: &MotionOrder,
        follower: &mut Follower<'_>,
        stopped: bool,
    ) {
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
    pub(super) fn answer(
        &self,
        order: &MotionOrder,
        follower: &mut Follower<'_>,
        reply: Reply,
    ) -> Answer {
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

    pub(super) async fn accepted(&self, order: &MotionOrder, written_at: Instant) {
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

    /// Has the controller end what it moves; whether it has said so.
    pub(super) async fn halt(&self, order: &MotionOrder) -> bool {
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

    pub(super) async fn fence(&self, order: &MotionOrder) {
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
    pub(super) fn channel_lost(&self, order: &MotionOrder, error: &ReadError) {
        tracing::info!(
            robot.id = self.shared.plan.robot,
            motion = %order.motion,
            error = chain(error),
            "the command's connection ended early"
        );
    }
}
