//! A little world: arms that drive and grip, mobile robots that obey, a network that loses things, and a ledger.
//! What it knows is the truth; the cell's books are judged by it.

#![allow(dead_code, reason = "each test file uses a part of it")]
#![allow(
    unreachable_pub,
    missing_debug_implementations,
    unused_imports,
    reason = "shared by test files only, each of which uses a part of it"
)]

mod arms;
mod example;
mod luck;
mod mobiles;
mod network;
mod people;
mod truth;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use uuid::Uuid;
use workflow::{
    BasePose, Cell, CountingIds, Effect, Fact, Input, Location, MobileMode, MobileState, OpResult,
    Refusal, Reply, Safety, Setup, SignalAnswer, SignalKind, Target,
};

pub use example::{delivery, fixed, integrator, item, operator, pickup, setup, slot};
pub use luck::{Chance, Odds};
pub use truth::{ArmTruth, Do, MobileTruth};

pub const POINT: &str = "station/1";
pub const ZONE: &str = "zone/1";
const DOCK: BasePose = BasePose {
    x_mm: 1000.0,
    y_mm: 0.0,
    heading_deg: 90.0,
};

pub struct World {
    pub now: u64,
    pub cell: Cell,
    pub setup: Setup,
    pub ids: CountingIds,
    pub journal: Vec<Fact>,
    pub arms: BTreeMap<String, ArmTruth>,
    pub mobiles: BTreeMap<String, MobileTruth>,
    /// Where each load really is.
    pub loads: BTreeMap<String, Location>,
    pub chance: Chance,
    pub odds: Odds,
    pub results: Vec<(u64, Uuid, OpResult)>,
    pub asked: Vec<Uuid>,
    pub answers: Vec<(SignalKind, SignalAnswer)>,
    pub log: Vec<String>,
    pub may_act: bool,
    pub check_replay: bool,
    pub crashes: u32,
    next_look: u64,
    /// The mobile robot is made to break the rules: then its driving is not our fault.
    pub rogue: bool,
    /// Records kept so far, and the ones after which the process dies before it carried anything out.
    pub records: usize,
    pub crash_at: Vec<usize>,
}

impl World {
    pub fn new() -> Self {
        Self::with(setup(), 1, Odds::default())
    }

    pub fn with(setup: Setup, seed: u64, odds: Odds) -> Self {
        let arm = ArmTruth {
            at: Some(Target::Safe),
            moving: None,
            holds: None,
            link: true,
            ready: true,
            manual: false,
            displaced: false,
            safety: Safety::Normal,
            done: BTreeMap::new(),
            asked: BTreeSet::new(),
            grip_fails: 0,
            release_sticks: false,
            doubt_next: false,
            doubt_for_good: false,
            alarm_next: false,
            swallow_next: false,
            not_executed_next: false,
            blocked: BTreeSet::new(),
            forgot: false,
        };
        let mobile = MobileTruth {
            boot: 1,
            seq: 0,
            state: MobileState {
                localized: true,
                battery_percent: 80.0,
                mode: MobileMode::Automatic,
                ..MobileState::default()
            },
            session: None,
            sending: VecDeque::new(),
            next_send: 0,
            next_beat: 100,
            permit: false,
            docked: false,
            paused: false,
            plan: VecDeque::new(),
            onward: false,
            acks: true,
            rejects: false,
            arrives: true,
            docks: true,
            obeys_retry: true,
            dock_error_mm: 0.0,
            dock_errors: 0,
            says_ready: true,
            leaves: true,
            delivers: true,
            beats: true,
            reports_loads: true,
            lies_slot: None,
            got: vec![],
            read: 0,
        };
        let mut world = Self {
            now: 1_000,
            cell: Cell::new(setup.clone()),
            ids: CountingIds::default(),
            journal: vec![],
            arms: setup
                .arms
                .iter()
                .map(|a| (a.clone(), arm.clone()))
                .collect(),
            mobiles: setup
                .mobile_robots
                .iter()
                .map(|m| (m.id.clone(), mobile.clone()))
                .collect(),
            loads: setup
                .loads
                .iter()
                .map(|l| (l.id.clone(), l.at.clone()))
                .collect(),
            setup,
            chance: Chance(seed),
            odds,
            results: vec![],
            asked: vec![],
            answers: vec![],
            log: vec![],
            may_act: true,
            check_replay: false,
            crashes: 0,
            next_look: 0,
            rogue: false,
            records: 0,
            crash_at: vec![],
        };
        world.boot();
        world
    }

    fn boot(&mut self) {
        let before = self.crashes;
        let _reply = self.input(Input::Recover).unwrap();
        // Unless it crashed again inside, and the inner start has gone further.
        assert!(
            before != self.crashes
                || self
                    .cell
                    .permits()
                    .iter()
                    .all(|(_, p)| *p == workflow::Permit::None),
            "I7"
        );
        for id in self.mobiles.keys().cloned().collect::<Vec<_>>() {
            self.fetch(&id, u64::MAX);
        }
        let jobs_may_act = self.may_act;
        let _reply = self.input(Input::Control { jobs_may_act }).unwrap();
        self.look();
    }

    /// A mobile robot asks for what it has not read.
    fn fetch(&mut self, id: &str, up_to: u64) {
        for out in self.cell.outbox(id, self.mobiles[id].read) {
            if out.n > up_to {
                break;
            }
            self.obey(id, out);
        }
    }

    /// The process dies and comes back: everything volatile is gone, the journal is not.
    pub fn crash(&mut self) {
        self.crashes += 1;
        self.results.clear();
        let mut cell = Cell::new(self.setup.clone());
        for fact in &self.journal {
            let text = serde_json::to_string(fact).unwrap();
            let fact: Fact = serde_json::from_str(&text).unwrap();
            cell.replay(&fact);
        }
        assert!(
            cell.permits()
                .iter()
                .all(|(_, p)| *p == workflow::Permit::None),
            "I7"
        );
        assert!(cell.same_book(&self.cell), "replay is not exact");
        // Every other start reads what was kept of the state instead of its facts (R6).
        if self.crashes.is_multiple_of(2) {
            let text = serde_json::to_string(&self.cell.snapshot()).unwrap();
            let kept = Cell::of_snapshot(serde_json::from_str(&text).unwrap());
            assert!(kept.same_book(&cell), "a snapshot is not exact");
            cell = kept;
        }
        self.cell = cell;
        self.boot();
    }

    /// Decides, keeps, applies, carries out.
    pub fn input(&mut self, input: Input) -> Result<Reply, Refusal> {
        let decision = self.cell.decide(self.now, input, &mut self.ids)?;
        self.journal
            .extend(decision.facts.iter().filter(|f| f.is_durable()).cloned());
        self.records += usize::from(decision.facts.iter().any(Fact::is_durable));
        let mut effects = Vec::new();
        for fact in &decision.facts {
            if let Fact::JobMoved { to, text, .. } = fact {
                self.log.push(format!("{:>7} job {to:?} {text}", self.now));
            }
            if let Fact::SessionMoved { to, fault, .. } = fact {
                self.log
                    .push(format!("{:>7} session {to:?} {fault:?}", self.now));
            }
            if let Fact::StepMoved { step, to, text, .. } = fact {
                self.log
                    .push(format!("{:>7} step {step} {to:?} {text}", self.now));
            }
            if let Fact::FaultNoted { fault, text, .. } = fact {
                self.log
                    .push(format!("{:>7} fault {fault:?} {text}", self.now));
            }
            if let Fact::Asked { question } = fact {
                self.log.push(format!(
                    "{:>7} ask {:?} {}",
                    self.now, question.fault, question.question
                ));
            }
            effects.extend(self.cell.apply(self.now, fact));
            let broken = self.cell.violations();
            let hard: Vec<_> = broken.iter().filter(|v| v.invariant != "I9").collect();
            assert!(hard.is_empty(), "{hard:?}\n{}", self.story());
        }
        let broken = self.cell.violations();
        assert!(broken.is_empty(), "{broken:?}\n{}", self.story());
        if decision.facts.iter().any(Fact::is_durable) && self.crash_at.contains(&self.records) {
            self.crash();
            return Ok(decision.reply);
        }
        if self.chance.hits(self.odds.crash) {
            // Kept, but only a part of the effects was carried out.
            let some = self.chance.below(effects.len() as u64 + 1) as usize;
            effects.truncate(some);
            for effect in effects {
                self.carry_out(effect);
            }
            self.crash();
            return Ok(decision.reply);
        }
        for effect in effects {
            self.carry_out(effect);
        }
        Ok(decision.reply)
    }

    pub fn story(&self) -> String {
        let from = self.log.len().saturating_sub(80);
        self.log[from..].join("\n")
    }

    fn carry_out(&mut self, effect: Effect) {
        match effect {
            Effect::Operate {
                op, arm, action, ..
            } => self.operate(op, &arm, action),
            Effect::Reconcile { op, arm, .. } => {
                let truth = self.arms.get(&arm).unwrap();
                if truth.doubt_for_good {
                    self.results.push((
                        self.now + 50,
                        op,
                        OpResult::InDoubt {
                            text: "it forgot".into(),
                        },
                    ));
                } else if truth.moving.as_ref().is_some_and(|(id, ..)| *id == op) {
                    // Answered when it stands.
                } else if let Some(result) = truth.done.get(&op) {
                    self.results.push((self.now + 50, op, result.clone()));
                } else if truth.forgot && truth.asked.contains(&op) {
                    let text = "the controller forgot".to_owned();
                    self.results
                        .push((self.now + 50, op, OpResult::InDoubt { text }));
                } else if truth.link {
                    let text = "the controller never accepted it".to_owned();
                    self.results
                        .push((self.now + 50, op, OpResult::NotExecuted { text }));
                }
            }
            Effect::StopArm { arm } => {
                self.log.push(format!("{:>7} stop {arm}", self.now));
                let truth = self.arms.get_mut(&arm).unwrap();
                if let Some((op, ..)) = truth.moving.take() {
                    truth.at = None;
                    let result = OpResult::Interrupted {
                        text: "stopped".into(),
                    };
                    let _old = truth.done.insert(op, result.clone());
                    self.results.push((self.now + 100, op, result));
                }
            }
            // It reads its outbox in order; what was not fetched before a crash is still there.
            Effect::Tell {
                mobile_robot,
                message,
            } => self.fetch(&mobile_robot, message.n),
            Effect::Ask { intervention } => self.asked.push(intervention),
            Effect::Remind { .. } => {}
        }
    }
}
