//! A little world: arms that drive and grip, mobile robots that obey, a network that loses things, and a ledger.
//! What it knows is the truth; the cell's books are judged by it.

#![allow(dead_code, reason = "each test file uses a part of it")]
#![allow(
    unreachable_pub,
    missing_debug_implementations,
    reason = "shared by test files only"
)]

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use uuid::Uuid;
use workflow::{
    Action, Answer, ArmSeen, BasePose, Cell, Command, CountingIds, Detail, Effect, Fact,
    GripAction, Input, ItemParams, JobState, LoadSetup, Location, Message, MobileMode,
    MobileRobotSetup, MobileState, NewJob, OnCancel, OpResult, OutMessage, Place, PlaceKind,
    PlaceRef, Point, PoseFailure, Principal, Refusal, Reply, Role, Safety, Setup, Signal,
    SignalAnswer, SignalKind, SlotLoad, Target, Taught, Timers, Tolerance, Workflow,
};

pub const POINT: &str = "station/1";
pub const ZONE: &str = "zone/1";
const DOCK: BasePose = BasePose {
    x_mm: 1000.0,
    y_mm: 0.0,
    heading_deg: 90.0,
};

/// A deterministic source of chance.
#[derive(Debug, Clone)]
pub struct Chance(pub u64);

impl Chance {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }

    pub fn hits(&mut self, permille: u64) -> bool {
        permille > 0 && self.below(1000) < permille
    }
}

/// What goes wrong by chance, in thousandths.
#[derive(Debug, Clone, Default)]
pub struct Odds {
    pub lost: u64,
    pub duplicated: u64,
    pub reordered: u64,
    pub grip_fails: u64,
    pub motion_doubt: u64,
    pub motion_alarm: u64,
    pub not_executed: u64,
    pub part_dropped: u64,
    pub crash: u64,
    pub controller_forgets: u64,
    pub mode_change: u64,
    pub heartbeat_gap: u64,
    pub dock_off: u64,
    pub command: u64,
    pub protective_stop: u64,
}

#[derive(Debug, Clone)]
pub struct ArmTruth {
    pub at: Option<Target>,
    pub moving: Option<(Uuid, Target, u64)>,
    pub holds: Option<String>,
    pub link: bool,
    pub ready: bool,
    /// The pendant is enabled.
    pub manual: bool,
    /// A human moved it since its last motion.
    pub displaced: bool,
    pub safety: Safety,
    /// What the controller remembers of operations.
    pub done: BTreeMap<Uuid, OpResult>,
    /// Operations it was ever asked for: never one twice.
    pub asked: BTreeSet<Uuid>,
    pub grip_fails: u32,
    pub release_sticks: bool,
    pub doubt_next: bool,
    pub doubt_for_good: bool,
    pub alarm_next: bool,
    pub swallow_next: bool,
    pub not_executed_next: bool,
    pub blocked: BTreeSet<String>,
    /// It lost its memory: what is not in `done` may have happened.
    pub forgot: bool,
}

#[derive(Debug, Clone)]
pub struct MobileTruth {
    pub boot: u64,
    pub seq: u64,
    pub state: MobileState,
    pub session: Option<Uuid>,
    /// Signals on their way, oldest first; the head is sent until it is answered.
    pub sending: VecDeque<Signal>,
    pub next_send: u64,
    pub next_beat: u64,
    pub permit: bool,
    pub docked: bool,
    pub paused: bool,
    /// What it does next, and when.
    pub plan: VecDeque<(u64, Do)>,
    pub onward: bool,
    // Knobs.
    pub acks: bool,
    pub rejects: bool,
    pub arrives: bool,
    pub docks: bool,
    pub obeys_retry: bool,
    pub dock_error_mm: f64,
    pub dock_errors: u32,
    pub says_ready: bool,
    pub leaves: bool,
    pub delivers: bool,
    pub beats: bool,
    pub reports_loads: bool,
    pub lies_slot: Option<(String, Option<String>)>,
    pub got: Vec<Message>,
    /// The last message it has read; the others wait in its outbox.
    pub read: u64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Do {
    Assigned,
    Rejected,
    Depart,
    Arrive,
    Dock,
    Ready,
    Leave,
    Clear,
    Deliver,
}

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

pub fn slot(name: &str) -> PlaceRef {
    PlaceRef::MobileRobot {
        point: POINT.into(),
        slot: name.into(),
    }
}

pub fn setup() -> Setup {
    let places = ["rack/a", "rack/b", "rack/c", "rack/d"];
    let mut all: Vec<_> = places
        .iter()
        .map(|id| Place {
            id: (*id).into(),
            kind: PlaceKind::Fixed,
            accepts: vec![],
        })
        .collect();
    all.push(Place {
        id: "bin".into(),
        kind: PlaceKind::Reject,
        accepts: vec![],
    });
    let mut taught = Vec::new();
    for arm in ["r1", "r2"] {
        for place in places.iter().chain(&["bin"]) {
            taught.push(Taught {
                arm: arm.into(),
                place: PlaceRef::fixed(*place),
            });
        }
        for name in ["s1", "s2", "s3"] {
            taught.push(Taught {
                arm: arm.into(),
                place: slot(name),
            });
        }
    }
    let load = |id: &str, at: Location| LoadSetup {
        id: id.into(),
        kind: "box".into(),
        at,
    };
    let on = |name: &str| Location::MobileRobot {
        mobile_robot: "m1".into(),
        slot: name.into(),
    };
    Setup {
        arms: vec!["r1".into(), "r2".into()],
        mobile_robots: ["m1", "m2"]
            .iter()
            .map(|id| MobileRobotSetup {
                id: (*id).into(),
                slots: vec!["s1".into(), "s2".into(), "s3".into()],
                max_speed_mm_s: None,
            })
            .collect(),
        points: vec![Point {
            id: POINT.into(),
            arms: vec!["r1".into(), "r2".into()],
            zone: ZONE.into(),
            dock: DOCK,
            tolerance: Tolerance { mm: 10.0, deg: 2.0 },
            route: vec![],
        }],
        places: all,
        taught,
        loads: vec![
            load("L1", on("s1")),
            load("L2", on("s2")),
            load("P1", fixed("rack/c")),
            load("P2", fixed("rack/d")),
        ],
        destinations: vec!["warehouse".into()],
        triggers: vec![],
        timers: Timers::default(),
    }
}

/// A place that does not drive away.
pub fn fixed(place: &str) -> Location {
    Location::Fixed {
        place: place.into(),
    }
}

pub fn item(load: Option<&str>, mr_slot: &str, place: &str) -> ItemParams {
    ItemParams {
        load_id: load.map(Into::into),
        kind: "box".into(),
        mr_slot: mr_slot.into(),
        place: place.into(),
        alternates: vec![],
    }
}

pub fn delivery() -> NewJob {
    NewJob {
        workflow: Workflow::DeliveryAndPlacement,
        mobile_robot: Some("m1".into()),
        arm: Some("r1".into()),
        point: POINT.into(),
        items: vec![item(Some("L1"), "s1", "rack/a")],
        early_release: false,
        prefetch: false,
        on_cancel_with_load: OnCancel::Hold,
        reject_slot: None,
        max_attempts: 2,
        destination: None,
        complete_on: workflow::CompleteOn::Departed,
        priority: 0,
        deadline: None,
        expected_arrival_ms: None,
        expected_transport_ms: None,
    }
}

pub fn pickup() -> NewJob {
    NewJob {
        workflow: Workflow::PickupAndDelivery,
        items: vec![item(Some("P1"), "s3", "rack/c")],
        destination: Some("warehouse".into()),
        complete_on: workflow::CompleteOn::Delivered,
        ..delivery()
    }
}

pub fn operator() -> Principal {
    Principal {
        name: "ada".into(),
        role: Role::Operator,
    }
}

pub fn integrator() -> Principal {
    Principal {
        name: "ivo".into(),
        role: Role::Integrator,
    }
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

    fn operate(&mut self, op: Uuid, name: &str, action: Action) {
        self.log.push(format!("{:>7} {name} {action:?}", self.now));
        self.judge_motion(name, &action);
        let now = self.now;
        let arm = self.arms.get_mut(name).unwrap();
        assert!(arm.asked.insert(op), "operation {op} was sent twice");
        if std::mem::take(&mut arm.not_executed_next) || self.chance.hits(self.odds.not_executed) {
            let text = "refused, nothing was sent".to_owned();
            let _old = arm
                .done
                .insert(op, OpResult::NotExecuted { text: text.clone() });
            self.results
                .push((now + 20, op, OpResult::NotExecuted { text }));
            return;
        }
        match action {
            Action::Precheck { targets } => {
                let failures = targets
                    .iter()
                    .enumerate()
                    .filter(|(_, t)| {
                        t.place()
                            .is_some_and(|p| arm.blocked.contains(&p.to_string()))
                    })
                    .map(|(target, _)| PoseFailure {
                        target,
                        reason: "J5 at 126, limit 125".into(),
                    })
                    .collect();
                self.results
                    .push((now + 30, op, OpResult::Prechecked { failures }));
            }
            Action::Move {
                target,
                interpolation,
                speed,
                ..
            } => {
                assert!(
                    arm.moving.is_none(),
                    "two motions at once\n{}",
                    self.log.join("\n")
                );
                if std::mem::take(&mut arm.displaced) {
                    assert!(
                        matches!(target, Target::Safe)
                            && interpolation == workflow::Interpolation::Joint
                            && speed == workflow::Speed::Reduced,
                        "from where it was jogged the arm goes to its safe pose, not to {target:?} {interpolation:?}\n{}",
                        self.log.join("\n")
                    );
                }
                if std::mem::take(&mut arm.swallow_next) {
                    return;
                }
                if std::mem::take(&mut arm.alarm_next) || self.chance.hits(self.odds.motion_alarm) {
                    let result = OpResult::Rejected {
                        text: "MOTN-018".into(),
                    };
                    let _old = arm.done.insert(op, result.clone());
                    self.results.push((now + 60, op, result));
                    return;
                }
                arm.moving = Some((op, target, now + 800));
                if std::mem::take(&mut arm.doubt_next) || self.chance.hits(self.odds.motion_doubt) {
                    let text = "the answer was lost".to_owned();
                    self.results
                        .push((now + 300, op, OpResult::InDoubt { text }));
                }
            }
            Action::Grip { action } => {
                let result = self.grip(name, action);
                let arm = self.arms.get_mut(name).unwrap();
                let _old = arm.done.insert(op, result.clone());
                self.results.push((now + 200, op, result));
            }
        }
    }

    fn place_of(&self, target: &Target) -> Option<Location> {
        Some(match target.place()? {
            PlaceRef::Fixed { place } => Location::Fixed {
                place: place.clone(),
            },
            PlaceRef::MobileRobot { slot, .. } => {
                let docked = self.mobiles.iter().find(|(_, m)| m.docked)?;
                Location::MobileRobot {
                    mobile_robot: docked.0.clone(),
                    slot: slot.clone(),
                }
            }
        })
    }

    fn grip(&mut self, name: &str, action: GripAction) -> OpResult {
        let at = self.arms[name].at.clone();
        let here = match &at {
            Some(t @ Target::At { .. }) => self.place_of(t),
            _ => None,
        };
        let chance = self.chance.hits(self.odds.grip_fails);
        let arm = self.arms.get_mut(name).unwrap();
        match action {
            GripAction::Close => {
                let there = here.as_ref().and_then(|h| {
                    self.loads
                        .iter()
                        .find(|(_, at)| *at == h)
                        .map(|(id, _)| id.clone())
                });
                let fails = arm.grip_fails > 0 || chance;
                arm.grip_fails = arm.grip_fails.saturating_sub(1);
                if let (Some(load), false) = (there, fails) {
                    arm.holds = Some(load.clone());
                    let _old = self
                        .loads
                        .insert(load, Location::Gripper { arm: name.into() });
                }
                OpResult::Gripped {
                    closed: true,
                    open: false,
                    part_present: arm.holds.is_some(),
                }
            }
            GripAction::Open => {
                if arm.release_sticks {
                    return OpResult::Gripped {
                        closed: false,
                        open: true,
                        part_present: true,
                    };
                }
                if let Some(load) = arm.holds.take() {
                    let to = here.unwrap_or(Location::Unknown { arm: None });
                    assert!(
                        matches!(&to, Location::Fixed { place } if place == "bin")
                            || !self.loads.values().any(|at| *at == to)
                            || matches!(to, Location::Unknown { .. }),
                        "two loads at {to}"
                    );
                    let _old = self.loads.insert(load, to);
                }
                OpResult::Gripped {
                    closed: false,
                    open: true,
                    part_present: false,
                }
            }
        }
    }

    /// The rule of the shared zone, judged by what is really there.
    fn judge_motion(&self, name: &str, action: &Action) {
        let Action::Move { target, .. } = action else {
            return;
        };
        if !target.enters_zone() {
            return;
        }
        let docked = self.mobiles.values().any(|m| m.docked);
        let driving = self
            .mobiles
            .values()
            .any(|m| m.state.driving && m.state.at_point.as_deref() == Some(POINT));
        assert!(
            self.rogue || docked && !driving,
            "{name} enters without a docked mobile robot\n{}",
            self.story()
        );
        let other = self
            .arms
            .iter()
            .any(|(id, a)| id != name && self.arm_inside(a));
        assert!(!other, "two arms in the zone");
    }

    #[allow(
        clippy::unused_self,
        reason = "reads like the other questions to the world"
    )]
    pub fn arm_inside(&self, arm: &ArmTruth) -> bool {
        let inside = |t: &Target| t.place().is_some_and(PlaceRef::in_zone);
        arm.at.as_ref().is_some_and(inside)
            || arm.moving.as_ref().is_some_and(|(_, t, _)| inside(t))
    }

    /// The mobile robot reads a message.
    fn obey(&mut self, id: &str, out: OutMessage) {
        if self.chance.hits(self.odds.dock_off) {
            self.mobiles.get_mut(id).unwrap().dock_errors += 1;
        }
        let inside = self.arms.values().any(|a| self.arm_inside(a));
        let now = self.now;
        let m = self.mobiles.get_mut(id).unwrap();
        self.log
            .push(format!("{now:>7} tell {id} {:?}", out.message));
        m.session = out.session.or(m.session);
        if out.n <= m.read {
            return;
        }
        m.read = out.n;
        m.got.push(out.message.clone());
        match out.message {
            Message::TransportOrder {
                order,
                update,
                goal,
                ..
            } => {
                if goal != POINT {
                    m.onward = true;
                    if !m.docked && m.state.at_point.is_none() && m.delivers {
                        m.plan.push_back((now + 500, Do::Deliver));
                    }
                    return;
                }
                let same = m.state.order == Some(order) && update == 1;
                if !same && m.acks && !m.state.driving {
                    m.state.order = Some(order);
                    m.plan.clear();
                    m.plan.push_back((
                        now + 100,
                        if m.rejects {
                            Do::Rejected
                        } else {
                            Do::Assigned
                        },
                    ));
                }
            }
            Message::MovePermit { granted } => {
                m.permit = granted;
                if granted && m.arrives {
                    m.plan.push_back((now + 200, Do::Depart));
                } else if !granted && m.docked && m.says_ready {
                    m.plan.push_back((now + 100, Do::Ready));
                }
                if !granted {
                    m.plan.retain(|(_, d)| !matches!(d, Do::Depart));
                }
            }
            Message::ExitGranted => {
                assert!(!inside, "exit granted with an arm in the zone");
                m.permit = true;
                if m.leaves && m.state.at_point.is_some() {
                    m.plan.clear();
                    m.plan.push_back((now + 300, Do::Leave));
                } else if m.state.at_point.is_none() && m.leaves {
                    m.plan.push_back((now + 300, Do::Clear));
                }
            }
            Message::CancelOrder { order } => {
                if m.state.order == Some(order) {
                    m.plan.clear();
                    m.state.order = None;
                    if m.leaves {
                        let first = if m.state.at_point.is_some() {
                            Do::Leave
                        } else {
                            Do::Clear
                        };
                        m.plan.push_back((now + 300, first));
                    }
                }
            }
            Message::Retry if !m.obeys_retry => {}
            Message::Retry => m.plan.push_back((now + 500, Do::Dock)),
            Message::StartPause => (m.paused, m.state.driving) = (true, false),
            Message::StopPause => m.paused = false,
            Message::SkipRetry => {
                m.plan.clear();
                m.plan.push_back((now + 300, Do::Leave));
            }
            Message::CellReady
            | Message::TransferDone
            | Message::TransferFailed { .. }
            | Message::StateRequest => {}
        }
    }

    /// What the slots really hold, or what it is made to say.
    fn report(&self, id: &str) -> Option<Vec<SlotLoad>> {
        let m = &self.mobiles[id];
        if !m.reports_loads {
            return None;
        }
        let mut all: Vec<_> = self
            .loads
            .iter()
            .filter_map(|(load, at)| match at {
                Location::MobileRobot { mobile_robot, slot } if mobile_robot == id => {
                    Some(SlotLoad {
                        slot: slot.clone(),
                        load: Some(load.clone()),
                    })
                }
                _ => None,
            })
            .collect();
        if let Some((slot, lie)) = &m.lies_slot {
            all.retain(|l| l.slot != *slot);
            if let Some(lie) = lie {
                all.push(SlotLoad {
                    slot: slot.clone(),
                    load: Some(lie.clone()),
                });
            }
        }
        Some(all)
    }

    pub fn say(&mut self, id: &str, kind: SignalKind) {
        let loads = self.report(id);
        let m = self.mobiles.get_mut(id).unwrap();
        m.seq += 1;
        m.state.loads = loads;
        m.sending.push_back(Signal {
            mobile_robot: id.into(),
            session: m.session.filter(|_| m.state.order.is_some()),
            boot: m.boot,
            seq: m.seq,
            kind,
            at_ms: None,
            resync: false,
            state: m.state.clone(),
        });
    }

    fn act(&mut self, id: &str, what: Do) {
        let arm_inside = self.arms.values().any(|a| self.arm_inside(a));
        let rogue = self.rogue;
        let now = self.now;
        let m = self.mobiles.get_mut(id).unwrap();
        match what {
            Do::Assigned => self.say(id, SignalKind::MrAssigned),
            Do::Rejected => {
                m.state.order = None;
                self.say(id, SignalKind::MrRejected);
            }
            Do::Depart => {
                if m.permit && m.state.order.is_some() && m.state.at_point.is_none() {
                    m.state.driving = true;
                    m.plan.push_back((now + 3_000, Do::Arrive));
                } else if m.docked && m.permit {
                    // It is there already: it says so again.
                    m.plan.push_back((now + 100, Do::Arrive));
                }
            }
            Do::Arrive => {
                assert!(
                    rogue || !arm_inside || !m.state.driving,
                    "a mobile robot drives in with an arm in the zone"
                );
                (m.state.driving, m.state.at_point) = (false, Some(POINT.into()));
                if !m.docked {
                    m.state.pose = BasePose {
                        x_mm: DOCK.x_mm - 300.0,
                        ..DOCK
                    };
                }
                self.say(id, SignalKind::MrArrived);
                if self.mobiles[id].docks {
                    self.mobiles
                        .get_mut(id)
                        .unwrap()
                        .plan
                        .push_back((now + 1_000, Do::Dock));
                }
            }
            Do::Dock => {
                let off = if m.dock_errors > 0 {
                    50.0
                } else {
                    m.dock_error_mm
                };
                m.dock_errors = m.dock_errors.saturating_sub(1);
                m.state.pose = BasePose {
                    x_mm: DOCK.x_mm + off,
                    ..DOCK
                };
                m.docked = true;
                self.say(id, SignalKind::MrDocked);
            }
            Do::Ready => {
                if m.docked && !m.permit {
                    self.say(id, SignalKind::MrReady);
                }
            }
            Do::Leave => {
                assert!(
                    rogue || !arm_inside,
                    "a mobile robot leaves with an arm in the zone\n{}",
                    self.story()
                );
                let m = self.mobiles.get_mut(id).unwrap();
                (m.state.driving, m.docked) = (true, false);
                m.plan.push_back((now + 2_000, Do::Clear));
            }
            Do::Clear => {
                (m.state.driving, m.permit) = (false, false);
                m.docked = false;
                m.state.at_point = None;
                m.state.pose = BasePose::default();
                self.say(id, SignalKind::MrClear);
                let m = self.mobiles.get_mut(id).unwrap();
                m.state.order = None;
                if std::mem::take(&mut m.onward) && m.delivers {
                    m.plan.push_back((now + 3_000, Do::Deliver));
                }
            }
            Do::Deliver => {
                for (load, at) in &mut self.loads {
                    if load.starts_with('P')
                        && matches!(at, Location::MobileRobot { mobile_robot, .. } if mobile_robot == id)
                    {
                        *at = Location::Delivered {
                            destination: "warehouse".into(),
                        };
                    }
                }
                self.say(id, SignalKind::MrDelivered);
            }
        }
    }

    fn look(&mut self) {
        for name in self.setup.arms.clone() {
            let arm = &self.arms[&name];
            let seen = ArmSeen {
                arm: name.clone(),
                link: arm.link,
                ready: arm.link && arm.ready,
                still: arm.link && arm.moving.is_none(),
                manual: arm.manual,
                displaced: arm.displaced,
                safety: arm.safety,
                zones: if self.arm_inside(arm) || arm.at.is_none() && self.was_inside(arm) {
                    vec![ZONE.into()]
                } else {
                    vec![]
                },
                part_present: Some(arm.holds.is_some()),
            };
            let _reply = self.input(Input::ArmObserved(seen)).unwrap();
        }
        self.next_look = self.now + 200;
    }

    /// Stopped in between: it may be anywhere, so it is said to be inside if a mobile robot is there.
    fn was_inside(&self, _arm: &ArmTruth) -> bool {
        self.mobiles.values().any(|m| m.docked)
    }

    fn send(&mut self, id: &str) {
        let Some(m) = self.mobiles.get_mut(id) else {
            return;
        };
        if m.sending.is_empty() || self.now < m.next_send {
            return;
        }
        m.next_send = self.now + 300;
        let swap = m.sending.len() > 1 && self.chance.hits(self.odds.reordered);
        let signal = m.sending[usize::from(swap)].clone();
        if self.chance.hits(self.odds.lost) {
            return;
        }
        let copies = if self.chance.hits(self.odds.duplicated) {
            2
        } else {
            1
        };
        for _copy in 0..copies {
            let (boot, seq, kind) = (signal.boot, signal.seq, signal.kind);
            let before = self.crashes;
            let reply = self.input(Input::Signal(Box::new(signal.clone())));
            if self.crashes != before {
                // The answer died with the process: it is sent again.
                return;
            }
            let answer = match reply {
                Ok(Reply::Signal(answer)) => answer,
                other => panic!("{other:?}"),
            };
            if kind != SignalKind::MrHeartbeat {
                self.log
                    .push(format!("{:>7} {id} says {kind:?} -> {answer:?}", self.now));
            }
            self.answers.push((kind, answer.clone()));
            let m = self.mobiles.get_mut(id).unwrap();
            let again = matches!(&answer, SignalAnswer::Conflict { expected, .. } if expected.starts_with("boot"))
                || matches!(&answer, SignalAnswer::Gap { .. });
            if !again && m.boot == boot {
                m.sending.retain(|s| s.seq != seq);
                m.next_send = self.now + 20;
            }
        }
    }

    /// One step of time.
    pub fn tick(&mut self) {
        self.now += 50;
        let now = self.now;
        self.misfortune();
        for name in self.setup.arms.clone() {
            let arm = self.arms.get_mut(&name).unwrap();
            if let Some((op, target, until)) = arm.moving.clone()
                && until <= now
            {
                arm.moving = None;
                arm.at = Some(target);
                let _old = arm.done.insert(op, OpResult::Arrived);
                if !arm.doubt_for_good {
                    self.results.push((now, op, OpResult::Arrived));
                }
            }
        }
        if now >= self.next_look {
            self.look();
        }
        let due: Vec<_> = self
            .results
            .iter()
            .filter(|(at, ..)| *at <= now)
            .cloned()
            .collect();
        self.results.retain(|(at, ..)| *at > now);
        for (_, op, result) in due {
            let linked = !self.arms.values().any(|a| !a.link && a.asked.contains(&op));
            if linked {
                let _reply = self.input(Input::OperationEnded { op, result });
            }
        }
        for id in self.mobiles.keys().cloned().collect::<Vec<_>>() {
            let m = self.mobiles.get_mut(&id).unwrap();
            if m.beats && now >= m.next_beat {
                m.next_beat = now + 1_000;
                self.say(&id, SignalKind::MrHeartbeat);
            }
            let m = self.mobiles.get_mut(&id).unwrap();
            let due: Vec<_> = m
                .plan
                .iter()
                .filter(|(at, _)| *at <= now && !m.paused)
                .copied()
                .collect();
            m.plan.retain(|(at, _)| *at > now || m.paused);
            for (_, what) in due {
                self.act(&id, what);
            }
            if self.mobiles[&id].beats {
                self.send(&id);
            }
        }
        if self.cell.next_deadline().is_some_and(|at| at <= now) {
            let _reply = self.input(Input::Tick).unwrap();
        }
    }

    fn misfortune(&mut self) {
        if !self.rogue {
            return;
        }
        let odds = self.odds.clone();
        if self.chance.hits(odds.mode_change) {
            let m = self.mobiles.get_mut("m1").unwrap();
            let auto = m.state.mode.is_automatic();
            m.state.mode = if auto {
                MobileMode::Manual
            } else {
                MobileMode::Automatic
            };
            self.say("m1", SignalKind::MrMode);
        } else if !self.mobiles["m1"].state.mode.is_automatic() && self.chance.hits(20) {
            self.mobiles.get_mut("m1").unwrap().state.mode = MobileMode::Automatic;
            self.say("m1", SignalKind::MrMode);
        }
        if self.chance.hits(odds.heartbeat_gap) {
            self.mobiles.get_mut("m1").unwrap().beats = false;
        } else if !self.mobiles["m1"].beats && self.chance.hits(10) {
            self.mobiles.get_mut("m1").unwrap().beats = true;
        }
        if self.chance.hits(odds.controller_forgets) {
            let arm = self.arms.get_mut("r1").unwrap();
            arm.done.clear();
            arm.forgot = true;
        }
        if self.chance.hits(odds.part_dropped)
            && let Some(load) = self.arms.get_mut("r1").unwrap().holds.take()
        {
            let _old = self.loads.insert(load, Location::Unknown { arm: None });
        }
        if self.chance.hits(odds.protective_stop) {
            let arm = self.arms.get_mut("r1").unwrap();
            arm.safety = Safety::ProtectiveStop;
        } else if self.arms["r1"].safety == Safety::ProtectiveStop && self.chance.hits(20) {
            self.arms.get_mut("r1").unwrap().safety = Safety::Normal;
        }
    }

    /// Runs until `done` or for `most_ms`.
    pub fn run(&mut self, most_ms: u64, done: impl Fn(&Self) -> bool) -> bool {
        let end = self.now + most_ms;
        while self.now < end {
            if done(self) {
                return true;
            }
            self.tick();
        }
        done(self)
    }

    pub fn create(&mut self, job: NewJob) -> Uuid {
        match self.input(Input::CreateJob { job: Box::new(job) }) {
            Ok(Reply::Created(id)) => id,
            other => panic!("{other:?}"),
        }
    }

    pub fn state(&self, job: Uuid) -> JobState {
        self.cell.job(self.now, job).unwrap().state
    }

    pub fn command(&mut self, job: Uuid, command: Command) -> Result<Reply, Refusal> {
        self.input(Input::JobCommand {
            job,
            command,
            principal: operator(),
            reason: "test".into(),
        })
    }

    pub fn open_question(&self) -> Option<workflow::view::InterventionView> {
        self.cell.interventions().into_iter().find(|i| i.open)
    }

    pub fn answer(&mut self, answer: Answer, detail: Detail) -> Result<Reply, Refusal> {
        let open = self.open_question().expect("a question");
        self.input(Input::Respond {
            intervention: open.question.id,
            answer,
            detail,
            principal: integrator(),
            reason: "looked".into(),
        })
    }

    /// The books against the truth.
    pub fn judge_custody(&self) {
        for found in self.cell.custody() {
            if matches!(found.load.location, Location::Unknown { .. }) {
                continue;
            }
            let truth = &self.loads[&found.id];
            // A gripper that acts, or a part that fell a moment ago: the books cannot know yet.
            let acting = self
                .cell
                .jobs(self.now)
                .iter()
                .flat_map(|j| &j.steps)
                .any(|s| {
                    s.operation
                        .as_ref()
                        .is_some_and(|o| matches!(o.action, Action::Grip { .. }))
                });
            if acting || matches!(truth, Location::Unknown { .. }) {
                continue;
            }
            let delivered = matches!(truth, Location::Delivered { .. });
            assert!(
                *truth == found.load.location || delivered,
                "{} is at {truth}, booked at {}\n{}",
                found.id,
                found.load.location,
                self.story()
            );
        }
    }

    /// Runs a job to COMPLETE, or says why not.
    pub fn complete(&mut self, job: Uuid) {
        let ok = self.run(120_000, |w| w.state(job) == JobState::Complete);
        assert!(
            ok,
            "{:?} {:?}\n{}",
            self.state(job),
            self.open_question(),
            self.story()
        );
        self.judge_custody();
    }
}
