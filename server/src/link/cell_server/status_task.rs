use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use api::{LinkState, ProblemCode};
use protocol::v2::{StatusLine, StatusReply, Verb};
use tokio::io::AsyncWriteExt as _;
use tokio::sync::{mpsc, oneshot};
use tokio::time::{Instant, sleep_until, timeout, timeout_at};
use tokio_util::sync::CancellationToken;

use super::backoff::Backoff;
use super::error::{LinkError, ReadError, chain};
use super::handle::Shared;
use super::plan::{LATE, LOST};
use super::readiness::{self, Identity, NotReady};
use super::stream::LineStream;
use super::view::Observed;
use crate::link::Connector;

/// Generations of the link in one start of the server: the wire epoch is the journal's epoch times this, and the
/// generation.
const GENERATIONS: u32 = 1_000;
/// The highest journal epoch whose wire epochs fit the controller's 32 bits.
const LAST_BASE: u64 = 2_147_482;
/// A connection that held this long was a good one: the next pause is short again.
const GOOD: std::time::Duration = std::time::Duration::from_secs(10);
/// Lines that may wait for their answers.
const OUTSTANDING: usize = 8;

/// Something the status port is to do.
#[derive(Debug)]
pub(super) struct Ask {
    pub(super) wanted: Wanted,
    pub(super) answer: oneshot::Sender<Result<StatusLine, LinkError>>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Wanted {
    Verb(Verb),
    /// A fence with the next generation.
    Fence,
}

/// The owner of the status port's connection.
pub(super) struct StatusTask<C> {
    shared: Arc<Shared>,
    connector: Arc<C>,
    stop: CancellationToken,
    base: u32,
    generation: Option<u32>,
    exhausted: bool,
    backoff: Backoff,
    lines: u64,
    /// The controller of the connection before: another one is not taken for it.
    known: Option<Identity>,
    /// What speaks against whoever answered last.
    stranger: Option<NotReady>,
    /// A fence was sent because of the dead-man that is shown.
    dead_man_fenced: bool,
}

/// A line on its way, and who waits for its answer.
struct Sent {
    verb: Verb,
    at: Instant,
    answer: Option<oneshot::Sender<Result<StatusLine, LinkError>>>,
}

/// Why a connection ended.
enum Ended {
    Stopping,
    Broken(String),
}

struct Session<S> {
    lines: LineStream<S>,
    sent: VecDeque<Sent>,
    last_sent: Instant,
    late: bool,
    /// The epoch to fence with, until it is known who answers.
    to_fence: Option<u32>,
}

impl<C: Connector> StatusTask<C> {
    pub(super) fn new(
        shared: Arc<Shared>,
        connector: Arc<C>,
        base_epoch: u64,
        stop: CancellationToken,
    ) -> Self {
        let base = u32::try_from(base_epoch.min(LAST_BASE)).unwrap_or(0) * GENERATIONS;
        Self {
            backoff: Backoff::new(&shared.plan.cell, &shared.plan.robot),
            shared,
            connector,
            stop,
            base,
            generation: None,
            // Beyond the last epoch nothing can be told from what an earlier start has sent.
            exhausted: base_epoch > LAST_BASE,
            lines: 0,
            known: None,
            stranger: None,
            dead_man_fenced: false,
        }
    }

    pub(super) async fn run(
        mut self,
        mut asks: mpsc::Receiver<Ask>,
        mut urgent: mpsc::Receiver<Ask>,
    ) {
        loop {
            self.publish_state(LinkState::Connecting);
            let stop = self.stop.clone();
            let connected = {
                let connect = timeout(
                    self.shared.plan.connect_timeout,
                    self.connector.connect(&self.shared.plan.status),
                );
                tokio::pin!(connect);
                loop {
                    tokio::select! {
                        biased;
                        () = stop.cancelled() => break None,
                        Some(ask) = urgent.recv() => self.turn_down(ask),
                        connected = &mut connect => break Some(connected),
                        Some(ask) = asks.recv() => self.turn_down(ask),
                    }
                }
            };
            let failure = match connected {
                None => break,
                Some(Ok(Ok(stream))) => {
                    let since = Instant::now();
                    let ended = self.session(stream, &mut asks, &mut urgent).await;
                    if since.elapsed() >= GOOD {
                        self.backoff.reset();
                    }
                    match ended {
                        Ended::Stopping => break,
                        Ended::Broken(failure) => failure,
                    }
                }
                Some(Ok(Err(error))) => format!("connecting: {error}"),
                Some(Err(_)) => "connecting took too long".to_owned(),
            };
            self.publish_lost(&failure);
            let pause = Instant::now() + self.backoff.next();
            loop {
                tokio::select! {
                    biased;
                    () = stop.cancelled() => break,
                    Some(ask) = urgent.recv() => self.turn_down(ask),
                    Some(ask) = asks.recv() => self.turn_down(ask),
                    () = sleep_until(pause) => break,
                }
            }
            if stop.is_cancelled() {
                break;
            }
        }
        self.publish_lost("the server is stopping");
        asks.close();
        urgent.close();
        while let Some(ask) = urgent.recv().await {
            self.turn_down(ask);
        }
        while let Some(ask) = asks.recv().await {
            self.turn_down(ask);
        }
    }

    /// One connection, from the fence to its loss.
    async fn session(
        &mut self,
        stream: C::Stream,
        asks: &mut mpsc::Receiver<Ask>,
        urgent: &mut mpsc::Receiver<Ask>,
    ) -> Ended {
        let plan = &self.shared.plan;
        let (poll, late, lost) = (plan.poll(), LATE, LOST);
        let mut session = Session {
            lines: LineStream::new(stream),
            sent: VecDeque::new(),
            last_sent: Instant::now(),
            late: false,
            to_fence: None,
        };
        let epoch = self.generation_of_connection();
        // Another controller must not be fenced: somebody else works with it. So it is asked first.
        let first = if self.known.is_some() {
            session.to_fence = Some(epoch);
            Verb::Status { epoch: 0 }
        } else {
            Verb::Fence { epoch }
        };
        let mut written = session.write(first, None, lost).await;
        let stop = self.stop.clone();
        let ended = loop {
            if let Err(failure) = written {
                break Ended::Broken(failure);
            }
            let waiting = session.sent.front().map(|sent| sent.at);
            let wake = match waiting {
                Some(at) if session.late => at + lost,
                Some(at) => at + late,
                None => session.last_sent + poll,
            };
            let shared = Arc::clone(&self.shared);
            written = tokio::select! {
                biased;
                () = stop.cancelled() => break Ended::Stopping,
                Some(ask) = urgent.recv() => self.carry_out(ask, &mut session).await,
                read = session.lines.next(StatusReply::decode) => {
                    match self.answered(read, &mut session) {
                        Ok(None) => Ok(()),
                        Ok(Some(verb)) => session.write(verb, None, lost).await,
                        Err(failure) => Err(failure),
                    }
                }
                Some(ask) = asks.recv(), if session.sent.len() < OUTSTANDING => {
                    self.carry_out(ask, &mut session).await
                }
                () = shared.nudge.notified(), if session.sent.is_empty() => {
                    session.write(Verb::Status { epoch: self.epoch() }, None, lost).await
                }
                () = sleep_until(wake) => match waiting {
                    None => session.write(Verb::Status { epoch: self.epoch() }, None, lost).await,
                    Some(_) if session.late => {
                        Err(format!("no answer within {} ms", lost.as_millis()))
                    }
                    Some(_) => {
                        session.late = true;
                        self.publish_late();
                        Ok(())
                    }
                },
            };
        };
        for sent in session.sent {
            if let Some(answer) = sent.answer {
                let _gone = answer.send(Err(LinkError::Unconfirmed {
                    verb: name(sent.verb),
                    after: sent.at.elapsed(),
                }));
            }
        }
        ended
    }

    async fn carry_out(
        &mut self,
        ask: Ask,
        session: &mut Session<C::Stream>,
    ) -> Result<(), String> {
        let verb = match ask.wanted {
            Wanted::Verb(verb) => verb,
            Wanted::Fence => {
                let Some(epoch) = self.next_generation() else {
                    let limit = GENERATIONS;
                    let _gone = ask.answer.send(Err(LinkError::GenerationsUsedUp { limit }));
                    return Ok(());
                };
                Verb::Fence { epoch }
            }
        };
        session.write(verb, Some(ask.answer), LOST).await
    }

    /// Takes a line; gives a verb to be sent because of it.
    fn answered(
        &mut self,
        read: Result<StatusReply, ReadError>,
        session: &mut Session<C::Stream>,
    ) -> Result<Option<Verb>, String> {
        let reply = read.map_err(|error| chain(&error))?;
        let Some(sent) = session.sent.pop_front() else {
            return Err("a line came that nothing was asked for".to_owned());
        };
        let took = sent.at.elapsed();
        self.shared.plan.metrics.round_trip(took);
        session.late = took > LATE;
        let status = match reply {
            StatusReply::Status(status) => status,
            StatusReply::Malformed => {
                let verb = name(sent.verb);
                if let Some(answer) = sent.answer {
                    let _gone = answer.send(Err(LinkError::NotUnderstood { verb }));
                }
                return match sent.verb {
                    Verb::Fence { .. } => Err("the fence was not understood".to_owned()),
                    Verb::Status { .. }
                    | Verb::Stop
                    | Verb::Hold
                    | Verb::Continue
                    | Verb::Override(_) => Ok(None),
                };
            }
        };
        if let Some(epoch) = session.to_fence {
            let is = Identity::of(&status);
            if let Err(stranger) = self.known.map_or(Ok(()), |was| was.check(is)) {
                self.stranger = Some(stranger);
                return Err(stranger.to_string());
            }
            session.to_fence = None;
            if let Some(answer) = sent.answer {
                let _gone = answer.send(Ok(status));
            }
            return Ok(Some(Verb::Fence { epoch }));
        }
        if let Verb::Fence { epoch } = sent.verb
            && status.epoch_max < epoch
        {
            return Err(format!(
                "the fence with epoch {epoch} left the controller at {}",
                status.epoch_max
            ));
        }
        self.stranger = None;
        self.known = Some(Identity::of(&status));
        self.publish_status(&status, &sent, session.late);
        if let Some(answer) = sent.answer {
            let _gone = answer.send(Ok(status));
        }
        Ok(self.after_dead_man(&status))
    }

    /// The dead-man stays latched until an epoch above that of the motion it stopped.
    fn after_dead_man(&mut self, status: &StatusLine) -> Option<Verb> {
        if !status.dead_man {
            self.dead_man_fenced = false;
            return None;
        }
        if std::mem::replace(&mut self.dead_man_fenced, true) {
            return None;
        }
        tracing::warn!(
            robot.id = self.shared.plan.robot,
            "the controller's dead-man stopped a motion: no heartbeat had reached it"
        );
        self.next_generation().map(|epoch| Verb::Fence { epoch })
    }

    fn epoch(&self) -> u32 {
        self.base + self.generation.unwrap_or(0)
    }

    /// The epoch to fence a new connection with: that of the last one if nothing was queued in it.
    fn generation_of_connection(&mut self) -> u32 {
        let used = self.shared.used.swap(false, Ordering::SeqCst);
        if self.generation.is_none() || used {
            let _next = self.next_generation();
        }
        self.epoch()
    }

    fn next_generation(&mut self) -> Option<u32> {
        let next = self.generation.map_or(0, |generation| generation + 1);
        if self.exhausted || next >= GENERATIONS {
            self.exhausted = true;
            return None;
        }
        self.generation = Some(next);
        self.shared.used.store(false, Ordering::SeqCst);
        Some(self.epoch())
    }

    fn publish_state(&self, state: LinkState) {
        self.shared.plan.metrics.state(state);
        self.shared.view.send_modify(|view| {
            view.state = state;
            view.not_ready = Some(self.stranger.unwrap_or(NotReady::Disconnected));
        });
    }

    fn publish_lost(&self, failure: &str) {
        let plan = &self.shared.plan;
        plan.metrics.state(LinkState::Disconnected);
        let mut news = false;
        self.shared.view.send_modify(|view| {
            news = view
                .failure
                .as_ref()
                .is_none_or(|(_, text)| **text != *failure);
            view.state = LinkState::Disconnected;
            view.not_ready = Some(self.stranger.unwrap_or(NotReady::Disconnected));
            view.failure = Some((ProblemCode::ControllerDisconnected, failure.into()));
        });
        // The same failure again and again is one line in the log.
        if news && !self.stop.is_cancelled() {
            tracing::warn!(
                robot.id = plan.robot,
                address = %plan.status,
                failure,
                "the controller's status port is not connected"
            );
        }
    }

    fn publish_late(&self) {
        self.shared.plan.metrics.state(LinkState::Degraded);
        self.shared.view.send_modify(|view| {
            if view.is_connected() {
                view.state = LinkState::Degraded;
            }
        });
    }

    fn publish_status(&mut self, status: &StatusLine, sent: &Sent, late: bool) {
        self.lines += 1;
        let observed = Observed {
            line: *status,
            at: Instant::now(),
            asked_at: sent.at,
            count: self.lines,
        };
        let epoch = self.epoch();
        let frames = self.shared.plan.frame_numbers;
        let exhausted = self.exhausted;
        let mut connected = false;
        let mut state = LinkState::Monitor;
        self.shared.view.send_modify(|view| {
            connected = !view.is_connected();
            if connected {
                view.connections += 1;
            }
            if let Verb::Fence { epoch } = sent.verb {
                view.wire_epoch = Some(epoch);
            }
            view.status = Some(observed);
            view.failure = None;
            view.not_ready = if exhausted {
                Some(NotReady::GenerationsUsedUp { limit: GENERATIONS })
            } else {
                readiness::check(status, epoch, frames, view.in_flight.is_some())
                    .or_else(|| self.shared.plan.implausible(status))
            };
            state = match view.not_ready {
                _ if late => LinkState::Degraded,
                None => LinkState::Control,
                Some(_) => LinkState::Monitor,
            };
            view.state = state;
        });
        self.shared.plan.metrics.state(state);
        if connected {
            tracing::info!(
                robot.id = self.shared.plan.robot,
                boot = status.boot,
                epoch,
                "the controller is connected and fenced"
            );
        }
    }

    fn turn_down(&self, ask: Ask) {
        let _gone = ask.answer.send(Err(self.shared.status_down()));
    }
}

impl<S: tokio::io::AsyncWrite + Unpin> Session<S> {
    async fn write(
        &mut self,
        verb: Verb,
        answer: Option<oneshot::Sender<Result<StatusLine, LinkError>>>,
        within: std::time::Duration,
    ) -> Result<(), String> {
        let at = Instant::now();
        let line = verb.encode();
        // From here on it may have been sent: whoever waits for it is told so if the connection breaks.
        self.sent.push_back(Sent { verb, at, answer });
        self.last_sent = at;
        match timeout_at(at + within, self.lines.stream.write_all(&line)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => Err(format!("writing `{}`: {error}", name(verb))),
            Err(_) => Err(format!("writing `{}` took too long", name(verb))),
        }
    }
}

fn name(verb: Verb) -> &'static str {
    match verb {
        Verb::Status { .. } => "status",
        Verb::Fence { .. } => "fence",
        Verb::Stop => "stop",
        Verb::Hold => "hold",
        Verb::Continue => "continue",
        Verb::Override(_) => "override",
    }
}
