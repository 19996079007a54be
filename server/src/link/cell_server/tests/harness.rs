//! A link to the fake, an observer that writes down, and the judgment by the ledger.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use api::LinkState;
use axum::http::HeaderMap;
use jiff::Timestamp;
use protocol::v2::{
    Command, FinishStatus, MotionNumber, Move, Output, OutputNumber, Percent, WireConfiguration,
};
use tokio::sync::Notify;
use tokio::time::{Instant, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

use super::fake::{Event, joints_at, pose_at, x_of};
use super::serve::{COMMAND, Fake};
use crate::config::{CellSection, Plan, RobotSection, ServerSection};
use crate::link::Turned;
use crate::link::cell_server::{
    CellServerLink, CellServerPlan, ControllerView, Instruction, MotionEnd, MotionObserver,
    MotionOrder, spawn,
};
use crate::metrics::Metrics;
use crate::request_id::RequestId;

pub(super) const BASE: u64 = 7;

/// What the link said, in order.
#[derive(Debug, Default)]
pub(super) struct Heard {
    steps: Mutex<Vec<(Uuid, &'static str)>>,
    ends: Mutex<HashMap<Uuid, Arc<MotionEnd>>>,
    news: Notify,
}

impl Heard {
    fn step(&self, motion: Uuid, step: &'static str) {
        self.steps.lock().unwrap().push((motion, step));
        self.news.notify_waiters();
    }
}

impl MotionObserver for Heard {
    async fn dispatched(&self, motion: Uuid) {
        self.step(motion, "dispatched");
    }

    async fn accepted(&self, motion: Uuid) {
        self.step(motion, "accepted");
    }

    async fn executing(&self, motion: Uuid) {
        self.step(motion, "executing");
    }

    async fn ended(&self, motion: Uuid, end: MotionEnd) {
        let before = self.ends.lock().unwrap().insert(motion, Arc::new(end));
        assert!(before.is_none(), "{motion} ended twice");
        self.step(motion, "ended");
    }
}

pub(super) struct Harness {
    pub(super) fake: Fake,
    pub(super) link: CellServerLink,
    pub(super) heard: Arc<Heard>,
    pub(super) stop: CancellationToken,
    pub(super) tracker: TaskTracker,
    sent: Mutex<Vec<(Uuid, MotionNumber, Command)>>,
    seq: Mutex<u32>,
}

pub(super) fn section() -> RobotSection {
    RobotSection {
        tier: api::Tier::CellServer,
        reply_timeout_ms: 1_000,
        queue_capacity: 4,
        ..RobotSection::new("r1", "fanuc-m20ia", COMMAND)
    }
}

pub(super) fn link_plan(section: RobotSection) -> CellServerPlan {
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        robots: vec![section],
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
    };
    let plan = Plan::try_new(&ServerSection::default(), &[cell]).unwrap();
    let robot = &plan.cells[0].robots[0];
    let metrics = Metrics::new(std::iter::empty()).unwrap();
    CellServerPlan {
        // The fake's arm is none of the models.
        arm: None,
        ..CellServerPlan::of(robot, metrics.controller_link(robot))
    }
}

impl Harness {
    /// A link whose controller is there and ready.
    pub(super) async fn start() -> Self {
        let harness = Self::on(&Fake::new(), BASE);
        harness.until_state(LinkState::Control).await;
        harness
    }

    /// A start of the server on a controller.
    pub(super) fn on(fake: &Fake, base: u64) -> Self {
        Self::with(fake, base, section())
    }

    pub(super) fn with(fake: &Fake, base: u64, section: RobotSection) -> Self {
        Self::of_plan(fake, base, link_plan(section))
    }

    pub(super) fn of_plan(fake: &Fake, base: u64, plan: CellServerPlan) -> Self {
        let heard = Arc::new(Heard::default());
        let stop = CancellationToken::new();
        let tracker = TaskTracker::new();
        let link = spawn(
            plan,
            Arc::new(fake.clone()),
            Arc::clone(&heard),
            base,
            &tracker,
            stop.clone(),
        );
        Self {
            fake: fake.clone(),
            link,
            heard,
            stop,
            tracker,
            sent: Mutex::default(),
            seq: Mutex::default(),
        }
    }

    pub(super) async fn until(&self, what: &str, wanted: impl Fn(&ControllerView) -> bool) {
        let mut watch = self.link.watch();
        let waited = timeout(Duration::from_mins(1), watch.wait_for(|view| wanted(view))).await;
        assert!(
            waited.is_ok(),
            "timed out waiting until {what}; last: {:?}",
            self.link.view()
        );
    }

    pub(super) async fn until_state(&self, state: LinkState) {
        self.until(&format!("{state:?}"), |view| view.state == state)
            .await;
    }

    /// Numbers and queues a command, as the door of the motion service does.
    pub(super) fn submit(&self, command: impl Into<Instruction>) -> (Uuid, MotionNumber) {
        self.submit_until(command, Duration::from_secs(5))
    }

    pub(super) fn submit_until(
        &self,
        command: impl Into<Instruction>,
        within: Duration,
    ) -> (Uuid, MotionNumber) {
        let submitted = self.try_submit(command, within);
        submitted.unwrap_or_else(|turned| panic!("the queue turned it away: {turned:?}"))
    }

    pub(super) fn try_submit(
        &self,
        command: impl Into<Instruction>,
        within: Duration,
    ) -> Result<(Uuid, MotionNumber), Turned> {
        let (motion, command) = (Uuid::now_v7(), command.into());
        let wire_epoch = self.link.view().wire_epoch.unwrap_or(0);
        let seq = {
            let mut seq = self.seq.lock().unwrap();
            *seq += 1;
            *seq
        };
        let order = MotionOrder {
            motion,
            wire_epoch,
            seq,
            command,
            not_after: Instant::now() + within,
            request_id: RequestId::of(&HeaderMap::new(), || Timestamp::UNIX_EPOCH),
        };
        let number = order.number();
        self.link.submit(order)?;
        if let Instruction::Numbered(command) = command {
            self.sent.lock().unwrap().push((motion, number, command));
        }
        Ok((motion, number))
    }

    pub(super) async fn end(&self, motion: Uuid) -> Arc<MotionEnd> {
        let wait = async {
            loop {
                let news = self.heard.news.notified();
                if let Some(end) = self.heard.ends.lock().unwrap().get(&motion) {
                    return Arc::clone(end);
                }
                news.await;
            }
        };
        timeout(Duration::from_mins(2), wait)
            .await
            .unwrap_or_else(|_| {
                panic!(
                    "no end of {motion}; {:?}; {:?}",
                    self.link.view(),
                    self.fake.ledger()
                )
            })
    }

    /// Sends a command and waits for its end, and judges it.
    pub(super) async fn carry_out(&self, command: impl Into<Instruction>) -> Arc<MotionEnd> {
        let (motion, _) = self.submit(command);
        let end = self.end(motion).await;
        self.judge();
        end
    }

    pub(super) async fn until_step(&self, motion: Uuid, step: &str) {
        let wait = async {
            loop {
                let news = self.heard.news.notified();
                if self.steps(motion).contains(&step) {
                    return;
                }
                news.await;
            }
        };
        assert!(
            timeout(Duration::from_mins(1), wait).await.is_ok(),
            "timed out waiting until {motion} is {step}"
        );
    }

    pub(super) fn heard_no_end(&self, motion: Uuid) -> bool {
        !self.heard.ends.lock().unwrap().contains_key(&motion)
    }

    /// Until the status port has just answered, so that the next line on it is the next one sent.
    pub(super) async fn until_idle(&self) {
        let before = self.link.view().status.map_or(0, |status| status.count);
        self.until("the next status line", |view| {
            view.status.is_some_and(|status| status.count > before)
        })
        .await;
    }

    pub(super) fn steps(&self, motion: Uuid) -> Vec<&'static str> {
        let steps = self.heard.steps.lock().unwrap();
        let of = steps.iter().filter(|(of, _)| *of == motion);
        of.map(|(_, step)| *step).collect()
    }

    /// Compares what the link said with what really happened.
    pub(super) fn judge(&self) {
        let ledger = self.fake.ledger();
        let count = |wanted: Event| ledger.iter().filter(|event| **event == wanted).count();
        let mut fence = 0;
        for event in &ledger {
            match event {
                Event::Fenced(epoch) => fence = fence.max(*epoch),
                Event::Started(number) => {
                    assert!(
                        number.epoch >= fence || *number == MotionNumber::default(),
                        "{number} started behind fence {fence}"
                    );
                }
                Event::Received(_)
                | Event::Accepted(_)
                | Event::Finished(..)
                | Event::Stopped
                | Event::PowerLost => {}
            }
        }
        let ends = self.heard.ends.lock().unwrap();
        for (motion, number, command) in &*self.sent.lock().unwrap() {
            assert!(
                count(Event::Received(*number)) <= 1,
                "{number} was sent twice"
            );
            let started = count(Event::Started(*number));
            assert!(started <= 1, "{number} started twice");
            let Some(end) = ends.get(motion) else {
                continue;
            };
            let arrived = count(Event::Finished(*number, FinishStatus::Arrived)) == 1;
            match &**end {
                MotionEnd::Arrived { status } => {
                    assert!(arrived, "{number} is said to have arrived: {ledger:?}");
                    assert!(!status.moving);
                    if let Command::Move(Move::Joint { pose, .. }) = command {
                        assert!((x_of(&status.pose) - x_of(pose)).abs() <= 0.5);
                    }
                }
                MotionEnd::Rejected { .. } | MotionEnd::NotSent { .. } => {
                    assert_eq!(started, 0, "{number}: {end:?}, and it started");
                }
                MotionEnd::Interrupted { fin_status, .. } => {
                    assert_eq!(count(Event::Finished(*number, *fin_status)), 1);
                    assert!(!arrived);
                }
                MotionEnd::InDoubt { .. } => {}
            }
        }
    }
}

pub(super) fn to(x: f64) -> Command {
    Command::Move(Move::Joint {
        pose: pose_at(x),
        speed: Percent::try_new(50).unwrap(),
        configuration: WireConfiguration::default(),
    })
}

pub(super) fn to_joints(j1: f64) -> Command {
    Command::Move(Move::Joints {
        joints: joints_at(j1),
        speed: Percent::try_new(50).unwrap(),
    })
}

pub(super) fn output(number: u8, on: bool) -> Command {
    Command::Output(Output {
        output: OutputNumber::try_new(number).unwrap(),
        on,
    })
}

pub(super) fn arrived(end: &MotionEnd) -> bool {
    matches!(end, MotionEnd::Arrived { .. })
}
