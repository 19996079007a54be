//! The fake controller's memory and arm, in virtual time.

use std::time::Duration;

use protocol::WireMove;
use protocol::v2::{
    Command, ErrorCode, FinishStatus, Greeting, LinearSpeed, MotionNumber, Move, OperatingMode,
    Reply, Request, StatusLine, Verb, WireConfiguration, WireJoints, WirePose,
};
use tokio::time::Instant;
use units::{Degrees, Millimeters};

/// The controller's dead-man and the life of its nonces.
const DEAD_MAN: Duration = Duration::from_secs(2);
const NONCE_LIFE: Duration = Duration::from_millis(500);

/// What really happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Event {
    /// A whole command was read, whatever became of it.
    Received(MotionNumber),
    Accepted(MotionNumber),
    /// The arm, or an output, begins.
    Started(MotionNumber),
    Finished(MotionNumber, FinishStatus),
    Fenced(u32),
    Stopped,
    PowerLost,
}

/// A motion being carried out.
#[derive(Clone, Copy, Debug)]
struct Running {
    number: MotionNumber,
    command: Command,
    from: (WirePose, WireJoints),
    duration: Duration,
    /// How much of it was done when `since` began.
    done: Duration,
    /// Since when it moves; `None` while it does not.
    since: Option<Instant>,
}

#[derive(Debug)]
pub(super) struct Brain {
    pub(super) ledger: Vec<Event>,
    pub(super) status: StatusLine,
    /// How long a motion takes.
    pub(super) duration: Duration,
    /// How far from its target a motion really ends, in mm.
    pub(super) miss: f64,
    /// A motion is accepted and never begins.
    pub(super) stuck: bool,
    /// A controller without numbers: nobody watches the commander, either.
    unwatched: bool,
    nonce: Option<(i32, Instant)>,
    nonces: i32,
    running: Option<Running>,
    heartbeat: Instant,
    dead_man_epoch: u32,
}

impl Brain {
    pub(super) fn new() -> Self {
        Self {
            ledger: Vec::new(),
            status: StatusLine {
                boot: 1,
                epoch_max: 0,
                accepted: MotionNumber::default(),
                finished: MotionNumber::default(),
                finish: FinishStatus::Arrived,
                moving: false,
                held: false,
                mode: OperatingMode::Auto,
                pendant: false,
                alarm: 0,
                speed_override: 100,
                user_frame: 0,
                tool: 1,
                dead_man: false,
                outputs: 0,
                inputs: 0b010,
                pose: pose_at(0.0),
                joints: joints_at(0.0),
            },
            duration: Duration::from_millis(700),
            miss: 0.0,
            stuck: false,
            unwatched: false,
            nonce: None,
            nonces: 0,
            running: None,
            heartbeat: Instant::now(),
            dead_man_epoch: 0,
        }
    }

    /// Lets time pass: a motion arrives, or the dead-man stops it, whichever came first.
    pub(super) fn advance(&mut self) {
        let now = Instant::now();
        let Some(running) = self.running else {
            return;
        };
        let stops_at = self.heartbeat + DEAD_MAN;
        let arrives_at = running
            .since
            .map(|since| since + running.duration.saturating_sub(running.done));
        match arrives_at {
            Some(arrives) if arrives <= now && (arrives <= stops_at || self.unwatched) => {
                self.finish(FinishStatus::Arrived, arrives);
            }
            _ if stops_at <= now && !self.unwatched => {
                self.status.dead_man = true;
                self.dead_man_epoch = running.number.epoch;
                self.finish(FinishStatus::DeadMan, stops_at);
            }
            _ => self.place(&running, now),
        }
    }

    fn place(&mut self, running: &Running, now: Instant) {
        let done = running.done + running.since.map_or(Duration::ZERO, |since| now - since);
        let share = (done.as_secs_f64() / running.duration.as_secs_f64()).min(1.0);
        let (from_pose, from_joints) = running.from;
        match running.command {
            Command::Move(Move::Joint { pose, .. } | Move::Linear { pose, .. }) => {
                let (from, to) = (x_of(&from_pose), x_of(&pose));
                self.status.pose = pose_at(from + (to - from) * share);
            }
            Command::Move(Move::Joints { joints, .. }) => {
                let (from, to) = (from_joints.degrees()[0].0, joints.degrees()[0].0);
                self.status.joints = joints_at(from + (to - from) * share);
            }
            Command::Output(_) => {}
        }
        self.status.moving = running.since.is_some();
    }

    fn finish(&mut self, finish: FinishStatus, at: Instant) {
        let Some(running) = self.running.take() else {
            return;
        };
        self.place(&running, at);
        if finish == FinishStatus::Arrived && self.miss != 0.0 {
            self.status.pose = pose_at(x_of(&self.status.pose) + self.miss);
        }
        self.status.moving = false;
        self.status.held = false;
        self.status.finished = running.number;
        self.status.finish = finish;
        self.ledger.push(Event::Finished(running.number, finish));
    }

    pub(super) fn greet(&mut self) -> Greeting {
        self.advance();
        self.nonces += 7;
        self.nonce = Some((self.nonces, Instant::now()));
        Greeting {
            boot: self.status.boot,
            epoch_max: self.status.epoch_max,
            accepted: self.status.accepted,
            finished: self.status.finished,
            finish: self.status.finish,
            nonce: self.nonces,
        }
    }

    /// Judges a command in the order of the page; `Ok` means that it is accepted and begins.
    pub(super) fn take(&mut self, request: &Request) -> Result<(), Reply> {
        self.advance();
        let number = request.number;
        self.ledger.push(Event::Received(number));
        let fresh = self
            .nonce
            .take()
            .is_some_and(|(nonce, since)| nonce == request.nonce && since.elapsed() <= NONCE_LIFE);
        if !fresh {
            return Err(Reply::Err(ErrorCode::Nonce));
        }
        let status = &mut self.status;
        if number.epoch < status.epoch_max {
            let epoch_max = status.epoch_max;
            return Err(Reply::Stale { epoch_max });
        }
        if number <= status.accepted {
            let finished = number <= status.finished;
            return Err(Reply::Dup { number, finished });
        }
        if let Some(running) = self.running {
            return Err(Reply::Busy(running.number));
        }
        let ready = status.mode == OperatingMode::Auto
            && !status.pendant
            && !status.held
            && status.alarm == 0;
        if !ready {
            return Err(Reply::Err(ErrorCode::NotReady));
        }
        if status.dead_man && number.epoch <= self.dead_man_epoch {
            return Err(Reply::Err(ErrorCode::DeadMan));
        }
        status.dead_man = false;
        status.epoch_max = number.epoch;
        status.accepted = number;
        self.ledger.push(Event::Accepted(number));
        if let Command::Output(output) = request.command {
            let bit = 1 << (output.output.get() - 1);
            status.outputs = (status.outputs & !bit) | if output.on { bit } else { 0 };
            status.finished = number;
            status.finish = FinishStatus::Arrived;
            self.ledger.push(Event::Started(number));
            self.ledger
                .push(Event::Finished(number, FinishStatus::Arrived));
        } else if !self.stuck {
            let now = Instant::now();
            self.ledger.push(Event::Started(number));
            self.running = Some(Running {
                number,
                command: request.command,
                from: (status.pose, status.joints),
                duration: self.duration,
                done: Duration::ZERO,
                since: (status.speed_override > 0).then_some(now),
            });
            status.moving = status.speed_override > 0;
        }
        Ok(())
    }

    /// A command of the pose server, which takes whatever it can read.
    pub(super) fn take_seed(&mut self, command: &WireMove) {
        self.advance();
        self.unwatched = true;
        let number = MotionNumber::default();
        self.ledger.push(Event::Accepted(number));
        if self.stuck {
            return;
        }
        self.ledger.push(Event::Started(number));
        self.running = Some(Running {
            number,
            command: Command::Move(Move::Linear {
                pose: WirePose::from(*command),
                speed: LinearSpeed::try_new(command.speed()).unwrap(),
                configuration: WireConfiguration::default(),
            }),
            from: (self.status.pose, self.status.joints),
            duration: self.duration,
            done: Duration::ZERO,
            since: Some(Instant::now()),
        });
        self.status.moving = true;
    }

    pub(super) fn obey(&mut self, verb: Verb) -> StatusLine {
        self.advance();
        let (now, beats) = (Instant::now(), self.status.epoch_max);
        let newer = |epoch: u32| epoch > self.dead_man_epoch;
        match verb {
            Verb::Status { epoch } if epoch >= beats => {
                self.heartbeat = now;
                if newer(epoch) {
                    self.status.dead_man = false;
                }
            }
            Verb::Status { .. } => {}
            Verb::Fence { epoch } => {
                self.heartbeat = now;
                if newer(epoch) {
                    self.status.dead_man = false;
                }
                self.status.epoch_max = beats.max(epoch);
                self.nonce = None;
                self.ledger.push(Event::Fenced(epoch));
            }
            Verb::Stop => {
                self.nonce = None;
                self.ledger.push(Event::Stopped);
                self.finish(FinishStatus::Stopped, now);
            }
            Verb::Hold => self.pause(true),
            Verb::Continue => self.pause(false),
            Verb::Override(percent) => self.status.speed_override = percent.get(),
        }
        self.status
    }

    fn pause(&mut self, held: bool) {
        let now = Instant::now();
        if let Some(running) = &mut self.running {
            if let Some(since) = running.since.take() {
                running.done += now - since;
            }
            if !held {
                running.since = Some(now);
            }
            self.status.held = held;
            self.status.moving = !held;
        }
    }

    /// An alarm stops what runs.
    pub(super) fn alarm(&mut self, code: u32) {
        self.advance();
        self.finish(FinishStatus::Alarm, Instant::now());
        self.status.alarm = code;
    }

    /// Power goes and comes back: what was stored stays, what ran is gone without an end.
    pub(super) fn lose_power(&mut self) {
        self.advance();
        self.ledger.push(Event::PowerLost);
        self.running = None;
        self.nonce = None;
        self.status.moving = false;
        self.status.held = false;
        self.status.boot += 1;
    }

    /// What was stored is gone, as after a cold start.
    pub(super) fn forget(&mut self) {
        self.status.epoch_max = 0;
        self.status.accepted = MotionNumber::default();
        self.status.finished = MotionNumber::default();
    }

    /// As if the dead-man had stopped a motion of this epoch, and nobody had noticed.
    pub(super) fn latch_dead_man(&mut self, epoch: u32) {
        self.status.dead_man = true;
        self.dead_man_epoch = epoch;
    }

    /// Somebody releases the hold on the pendant.
    pub(super) fn release(&mut self) {
        self.advance();
        self.pause(false);
        self.status.held = false;
    }

    pub(super) fn has_finished(&mut self, number: MotionNumber) -> bool {
        self.advance();
        self.status.finished >= number
    }

    pub(super) fn count(&self, wanted: Event) -> usize {
        self.ledger.iter().filter(|event| **event == wanted).count()
    }
}

/// Targets differ in X only: that is enough to tell them apart.
pub(super) fn pose_at(x: f64) -> WirePose {
    WirePose::try_new(
        [Millimeters(900.0 + x), Millimeters(0.0), Millimeters(940.0)],
        [Degrees(-180.0), Degrees(0.0), Degrees(0.0)],
    )
    .unwrap()
}

pub(super) fn x_of(pose: &WirePose) -> f64 {
    pose.position()[0].0 - 900.0
}

/// Joint values differ in J1 only.
pub(super) fn joints_at(j1: f64) -> WireJoints {
    WireJoints::try_new([j1, 0.0, 0.0, 0.0, -90.0, 0.0].map(Degrees)).unwrap()
}
