//! The way over the seed program, with a status channel beside it.

use protocol::WireMove;
use tokio::time::Instant;

use super::super::error::{LinkError, ReadError};
use super::super::exchange::{Written, connect, write_once};
use super::super::order::{MotionObserver, MotionOrder};
use super::super::seed_wire::{self, SeedStream};
use super::stop_after;
use super::{Channel, CommandTask, Queued, Sent};
use crate::link::Connector;

impl<C: Connector, O: MotionObserver> CommandTask<C, O> {
    /// Connects, checks again and writes, in the seed's words.
    pub(super) async fn send_seed(
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
    pub(super) async fn unless_stopped<T>(
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
    pub(super) async fn fence_seed(&self, order: &MotionOrder) -> Result<(), ReadError> {
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
}
