//! The hand-over of one zone between two arms and a mobile robot, with the intent protocol of each arm, as a model.
//!
//! The decision about a motion whose answer is missing is the product's own [`decide_motion`]; states and permits of
//! the session are the product's own types. Around them: crashes, lost and doubled messages, messages that stay on the
//! way while the server is restarted (an old writer), a pendant that jogs, a human who drives the mobile robot away.

#![allow(
    unreachable_pub,
    missing_docs,
    missing_debug_implementations,
    dead_code,
    reason = "shared by a test and an example"
)]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::too_many_lines,
    clippy::wildcard_enum_match_arm,
    clippy::struct_excessive_bools,
    reason = "a model: a wrong index is a bug of the model"
)]

use stateright::{Model, Property};
use workflow::reconcile::{Finish, MotionNumber, Reading, Verdict, decide_motion};
use workflow::{Permit, SessionState};

/// What is left out of the design. Nothing: the design itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weakened {
    No,
    ResendOnRestart,
    TrustTheReply,
    NoFence,
    PermitsSurviveTheBoot,
    NoSecondEvidence,
    NoDedupe,
    PoseOnly,
    /// The permit to leave does not wait for the arm to be out.
    ExitWithoutClearArm,
}

/// How much may go wrong.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    pub crashes: u8,
    pub losses: u8,
    pub doubles: u8,
    pub jogs: u8,
    pub drives: u8,
    pub lies: u8,
    /// How often an answer is not waited for any longer.
    pub give_ups: u8,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Intent {
    pub number: MotionNumber,
    pub sent: bool,
    /// It was waited for in vain, or by a process that is gone.
    pub doubt: bool,
    /// Only a human can say.
    pub asked: bool,
    pub fenced: bool,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Arm {
    // The server's journal.
    pub done: u8,
    pub intent: Option<Intent>,
    // The controller.
    pub fence: u32,
    pub accepted: Option<MotionNumber>,
    pub finished: Option<(MotionNumber, Finish)>,
    pub moving: Option<(MotionNumber, u8)>,
    pub pose: u8,
    // The ledger.
    pub starts: [u8; 2],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Packet {
    Motion {
        arm: u8,
        number: MotionNumber,
        step: u8,
    },
    Ack {
        arm: u8,
        number: MotionNumber,
    },
    Finished {
        arm: u8,
        number: MotionNumber,
    },
    /// "I have docked", of one visit.
    Docked {
        visit: u8,
    },
    Clear {
        visit: u8,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Base {
    Away,
    DrivingIn,
    Docked,
    /// It stands, says that it docked, and is not where it should be.
    Astray,
    DrivingOut,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Bad {
    Twice,
    Early,
    Order,
    /// An arm in the zone while the mobile robot drives in it or is not at its dock.
    Zone,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct State {
    pub up: bool,
    pub epoch: u32,
    pub seq: u32,
    pub arms: [Arm; 2],
    pub net: Vec<Packet>,
    // The session, durable: which arm it serves, and its state.
    pub visit: u8,
    pub session: SessionState,
    /// Volatile: the permit was granted by this process.
    pub granted: bool,
    pub docked_said: bool,
    pub clear_said: bool,
    // The mobile robot.
    pub base: Base,
    pub base_visit: u8,
    pub base_permit: bool,
    pub outbox_permit: bool,
    pub left: [u8; 7],
    pub bad: Option<Bad>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Act {
    Crash,
    Boot,
    Begin(u8),
    Send(u8),
    GiveUp(u8),
    Fence(u8),
    Decide(u8),
    Human(u8),
    Finish(u8),
    Jog(u8, u8),
    Deliver(usize),
    Lose(usize),
    Double(usize),
    Session,
    BaseReads,
    BaseDrivesIn,
    BaseDocks,
    BaseDocksAstray,
    BaseLeaves,
    BaseIsOut,
    HumanDrivesBase,
}

pub struct Handover {
    pub weakened: Weakened,
    pub bounds: Bounds,
}

const IN_ZONE: u8 = 1;
const CRASHES: usize = 0;
const LOSSES: usize = 1;
const DOUBLES: usize = 2;
const JOGS: usize = 3;
const DRIVES: usize = 4;
const LIES: usize = 5;
const GIVE_UPS: usize = 6;

/// The pose a step ends at: step 0 goes into the zone, step 1 out of it.
const fn target(step: u8) -> u8 {
    if step == 0 { IN_ZONE } else { 2 }
}

impl Handover {
    fn is(&self, weakened: Weakened) -> bool {
        self.weakened == weakened
    }

    fn permit(s: &State) -> Permit {
        if s.granted {
            Permit::of(s.session)
        } else {
            Permit::None
        }
    }

    /// What the controllers can say about the arms right now: no arm in the zone or on its way.
    fn arms_clear(s: &State) -> bool {
        s.arms
            .iter()
            .all(|a| a.pose != IN_ZONE && a.moving.is_none() && a.intent.is_none())
    }

    /// The heart of the judge, after every action.
    fn judge(s: &mut State) {
        let inside = s
            .arms
            .iter()
            .any(|a| a.pose == IN_ZONE || a.moving.is_some_and(|(_, step)| step == 0));
        if inside && s.base != Base::Docked && s.bad.is_none() {
            s.bad = Some(Bad::Zone);
        }
    }

    fn accept(&self, s: &mut State, arm: u8, number: MotionNumber, step: u8) {
        let a = &mut s.arms[usize::from(arm)];
        let ids = !self.is(Weakened::PoseOnly) && !self.is(Weakened::ResendOnRestart);
        if ids
            && (number.epoch < a.fence
                || a.accepted.is_some_and(|acc| {
                    if self.is(Weakened::NoDedupe) {
                        number < acc
                    } else {
                        number <= acc
                    }
                }))
        {
            return;
        }
        if a.moving.is_some() {
            return;
        }
        a.fence = a.fence.max(number.epoch);
        a.accepted = Some(number);
        a.moving = Some((number, step));
        let index = usize::from(step);
        a.starts[index] += 1;
        if a.starts[index] > 1 {
            s.bad = Some(Bad::Twice);
        }
        if a.done < step {
            s.bad = Some(Bad::Order);
        }
        // The acceptance matters only to a design that believes it.
        if self.is(Weakened::TrustTheReply) {
            s.net.push(Packet::Ack { arm, number });
        }
    }

    fn done(s: &mut State, arm: u8) {
        let a = &mut s.arms[usize::from(arm)];
        let step = usize::from(a.done);
        if a.starts[step] == 0 || a.moving.is_some() {
            s.bad = Some(Bad::Early);
        }
        a.done += 1;
        a.intent = None;
    }

    /// One transition of the session, if its guard holds.
    fn session(&self, s: &State) -> Option<State> {
        let mut n = s.clone();
        let permit = Self::permit(s);
        match s.session {
            SessionState::AccessPending => {
                if !Self::arms_clear(s) {
                    return None;
                }
                (n.session, n.granted, n.outbox_permit) = (SessionState::AccessGranted, true, true);
            }
            SessionState::AccessGranted => {
                let evidence = s.base == Base::Docked || self.is(Weakened::NoSecondEvidence);
                if !s.docked_said || !evidence {
                    return None;
                }
                (n.session, n.outbox_permit) = (SessionState::Docked, false);
            }
            SessionState::Docked => {
                // The entry permit: only with the second evidence, which is read now.
                let evidence = (s.base == Base::Docked && !s.base_permit)
                    || self.is(Weakened::NoSecondEvidence);
                if !evidence {
                    return None;
                }
                (n.session, n.granted) = (SessionState::Transferring, true);
            }
            SessionState::Transferring if permit == Permit::ArmEntry => {
                let a = &s.arms[usize::from(s.visit)];
                let out = a.done == 2 && Self::arms_clear(s);
                let early = self.is(Weakened::ExitWithoutClearArm) && a.done > 0;
                if !(out || early) {
                    return None;
                }
                (n.session, n.granted, n.outbox_permit) = (SessionState::ExitGranted, true, true);
            }
            SessionState::ExitGranted if s.clear_said => {
                n.granted = false;
                (n.docked_said, n.clear_said, n.outbox_permit) = (false, false, false);
                if s.visit == 0 {
                    (n.visit, n.session) = (1, SessionState::AccessPending);
                } else {
                    n.session = SessionState::Released;
                }
            }
            _ => return None,
        }
        Some(n)
    }

    fn boot(&self, n: &mut State) {
        n.up = true;
        n.epoch += 1;
        if !self.is(Weakened::PermitsSurviveTheBoot) {
            n.granted = false;
            n.outbox_permit = false;
            n.session = match n.session {
                // Whatever had a permit goes back to the last state that promises nothing.
                state if Permit::of(state) == Permit::None => state,
                SessionState::ExitGranted => SessionState::ExitGranted,
                state => state.last_safe(),
            };
            if n.session == SessionState::ExitGranted {
                (n.granted, n.outbox_permit) = (true, true);
            }
        }
        let again = self.is(Weakened::ResendOnRestart);
        for (index, a) in n.arms.iter_mut().enumerate() {
            let Some(intent) = &mut a.intent else {
                continue;
            };
            (intent.doubt, intent.fenced) = (true, false);
            if again {
                n.seq += 1;
                let number = MotionNumber {
                    epoch: n.epoch,
                    seq: n.seq,
                };
                *intent = Intent {
                    number,
                    sent: true,
                    doubt: false,
                    asked: false,
                    fenced: false,
                };
                n.net.push(Packet::Motion {
                    arm: u8::try_from(index).unwrap(),
                    number,
                    step: a.done,
                });
            }
        }
    }

    fn decide(&self, n: &mut State, arm: u8) -> Option<()> {
        let a = &mut n.arms[usize::from(arm)];
        let intent = a.intent?;
        let verdict = if self.is(Weakened::PoseOnly) {
            let at = a.pose == target(a.done);
            if a.moving.is_some() {
                Verdict::Wait
            } else if at {
                Verdict::Executed
            } else {
                Verdict::NotExecuted
            }
        } else {
            let reading = Reading {
                fenced: intent.fenced || self.is(Weakened::NoFence),
                same_boot: true,
                accepted: a.accepted,
                finished: a.finished,
                moving: a.moving.is_some(),
                held: false,
                at_target: a.pose == target(a.done),
                settled: true,
            };
            decide_motion(intent.number, Some(&reading))
        };
        match verdict {
            Verdict::Executed => Self::done(n, arm),
            Verdict::NotExecuted | Verdict::Interrupted => a.intent = None,
            Verdict::Wait => return None,
            Verdict::InDoubt => {
                if intent.asked {
                    return None;
                }
                a.intent = Some(Intent {
                    asked: true,
                    ..intent
                });
            }
        }
        Some(())
    }

    fn deliver(&self, n: &mut State, packet: Packet) {
        match packet {
            Packet::Motion { arm, number, step } => self.accept(n, arm, number, step),
            Packet::Ack { arm, number } => {
                let mine = n.arms[usize::from(arm)]
                    .intent
                    .is_some_and(|i| i.number == number);
                if n.up && mine && self.is(Weakened::TrustTheReply) {
                    Self::done(n, arm);
                }
            }
            Packet::Finished { arm, number } => {
                let a = &n.arms[usize::from(arm)];
                // Done is: the answer, and seen at the target, still.
                let mine = a.intent.is_some_and(|i| i.number == number);
                let seen = a.moving.is_none() && a.pose == target(a.done);
                if n.up && mine && seen {
                    Self::done(n, arm);
                }
            }
            Packet::Docked { visit } => {
                if n.up && visit == n.visit {
                    n.docked_said = true;
                }
            }
            Packet::Clear { visit } => {
                if n.up && visit == n.visit && n.session == SessionState::ExitGranted {
                    n.clear_said = true;
                }
            }
        }
    }
}

impl Model for Handover {
    type State = State;
    type Action = Act;

    fn init_states(&self) -> Vec<State> {
        let arm = Arm {
            done: 0,
            intent: None,
            fence: 0,
            accepted: None,
            finished: None,
            moving: None,
            pose: 0,
            starts: [0, 0],
        };
        let b = self.bounds;
        vec![State {
            up: true,
            epoch: 1,
            seq: 0,
            arms: [arm.clone(), arm],
            net: vec![],
            visit: 0,
            session: SessionState::AccessPending,
            granted: false,
            docked_said: false,
            clear_said: false,
            base: Base::Away,
            base_visit: 0,
            base_permit: false,
            outbox_permit: false,
            left: [
                b.crashes, b.losses, b.doubles, b.jogs, b.drives, b.lies, b.give_ups,
            ],
            bad: None,
        }]
    }

    fn actions(&self, s: &State, all: &mut Vec<Act>) {
        all.push(if s.up { Act::Crash } else { Act::Boot });
        all.extend([
            Act::Session,
            Act::BaseReads,
            Act::BaseDrivesIn,
            Act::BaseDocks,
        ]);
        all.extend([
            Act::BaseDocksAstray,
            Act::BaseLeaves,
            Act::BaseIsOut,
            Act::HumanDrivesBase,
        ]);
        for arm in 0..2 {
            all.extend([
                Act::Begin(arm),
                Act::Send(arm),
                Act::GiveUp(arm),
                Act::Fence(arm),
            ]);
            all.extend([Act::Decide(arm), Act::Human(arm), Act::Finish(arm)]);
            all.extend([Act::Jog(arm, 0), Act::Jog(arm, 2)]);
        }
        for index in 0..s.net.len() {
            all.extend([Act::Deliver(index), Act::Lose(index), Act::Double(index)]);
        }
    }

    fn next_state(&self, s: &State, act: Act) -> Option<State> {
        let mut n = s.clone();
        let spend = |n: &mut State, which: usize| -> Option<()> {
            n.left[which] = n.left[which].checked_sub(1)?;
            Some(())
        };
        match act {
            Act::Crash => {
                spend(&mut n, CRASHES)?;
                n.up = false;
            }
            Act::Boot => self.boot(&mut n),
            Act::Begin(arm) => {
                let a = &mut n.arms[usize::from(arm)];
                if !s.up
                    || a.intent.is_some()
                    || a.done >= 2
                    || s.visit != arm
                    || a.moving.is_some()
                {
                    return None;
                }
                let permitted = Self::permit(s) == Permit::ArmEntry;
                let evidence = s.base == Base::Docked
                    || self.is(Weakened::NoSecondEvidence)
                    || self.is(Weakened::PermitsSurviveTheBoot);
                if a.done == 0 && !(permitted && evidence) {
                    return None;
                }
                n.seq += 1;
                let number = MotionNumber {
                    epoch: s.epoch,
                    seq: n.seq,
                };
                a.intent = Some(Intent {
                    number,
                    sent: false,
                    doubt: false,
                    asked: false,
                    fenced: false,
                });
            }
            Act::Send(arm) => {
                let a = &mut n.arms[usize::from(arm)];
                let step = a.done;
                let intent = a.intent.as_mut()?;
                if !s.up || intent.sent || intent.doubt {
                    return None;
                }
                intent.sent = true;
                n.net.push(Packet::Motion {
                    arm,
                    number: intent.number,
                    step,
                });
            }
            Act::GiveUp(arm) => {
                let intent = n.arms[usize::from(arm)].intent.as_mut()?;
                if !s.up || !intent.sent || intent.doubt {
                    return None;
                }
                // The answer takes too long: the next generation of the link.
                intent.doubt = true;
                n.epoch += 1;
                spend(&mut n, GIVE_UPS)?;
            }
            Act::Fence(arm) => {
                let a = &mut n.arms[usize::from(arm)];
                let intent = a.intent.as_mut()?;
                if !s.up || !intent.doubt || intent.fenced || self.is(Weakened::NoFence) {
                    return None;
                }
                intent.fenced = true;
                a.fence = a.fence.max(s.epoch);
            }
            Act::Decide(arm) => {
                if !s.up || !s.arms[usize::from(arm)].intent?.doubt {
                    return None;
                }
                self.decide(&mut n, arm)?;
            }
            Act::Human(arm) => {
                // Only after the fence, and when it stands; a human sees whether it happened.
                let a = &mut n.arms[usize::from(arm)];
                let intent = a.intent?;
                if !s.up || !intent.asked || !intent.fenced || a.moving.is_some() {
                    return None;
                }
                if a.starts[usize::from(a.done)] > 0 {
                    Self::done(&mut n, arm);
                } else {
                    a.intent = None;
                }
            }
            Act::Finish(arm) => {
                let a = &mut n.arms[usize::from(arm)];
                let (number, step) = a.moving.take()?;
                a.pose = target(step);
                a.finished = Some((number, Finish::Arrived));
                n.net.push(Packet::Finished { arm, number });
            }
            Act::Jog(arm, pose) => {
                let a = &mut n.arms[usize::from(arm)];
                if a.moving.is_some() || a.pose == pose {
                    return None;
                }
                a.pose = pose;
                spend(&mut n, JOGS)?;
            }
            Act::Deliver(index) => {
                let packet = n.net.remove(index);
                self.deliver(&mut n, packet);
            }
            Act::Lose(index) => {
                spend(&mut n, LOSSES)?;
                let _lost = n.net.remove(index);
            }
            Act::Double(index) => {
                spend(&mut n, DOUBLES)?;
                n.net.push(s.net[index]);
            }
            Act::Session => {
                if !s.up {
                    return None;
                }
                n = self.session(s)?;
            }
            Act::BaseReads => {
                if s.base_permit == s.outbox_permit {
                    return None;
                }
                n.base_permit = s.outbox_permit;
            }
            Act::BaseDrivesIn => {
                if s.base != Base::Away
                    || !s.base_permit
                    || s.session != SessionState::AccessGranted
                {
                    return None;
                }
                (n.base, n.base_visit) = (Base::DrivingIn, s.visit);
            }
            Act::BaseDocks => {
                if !matches!(s.base, Base::DrivingIn | Base::Astray) {
                    return None;
                }
                n.base = Base::Docked;
                n.net.push(Packet::Docked {
                    visit: s.base_visit,
                });
            }
            Act::BaseDocksAstray => {
                if s.base != Base::DrivingIn {
                    return None;
                }
                spend(&mut n, LIES)?;
                n.base = Base::Astray;
                n.net.push(Packet::Docked {
                    visit: s.base_visit,
                });
            }
            Act::BaseLeaves => {
                // With a permit it leaves when it was docked and the cell let it go.
                let told = s.session == SessionState::ExitGranted;
                if s.base != Base::Docked || !s.base_permit || !told {
                    return None;
                }
                n.base = Base::DrivingOut;
            }
            Act::BaseIsOut => {
                if s.base != Base::DrivingOut {
                    return None;
                }
                n.base = Base::Away;
                n.net.push(Packet::Clear {
                    visit: s.base_visit,
                });
            }
            Act::HumanDrivesBase => {
                // While the server is down, nobody stops a human from driving it out of its dock; nobody would with an
                // arm in the zone or on its way.
                let arm_near = s
                    .arms
                    .iter()
                    .any(|a| a.pose == IN_ZONE || a.moving.is_some())
                    || s.net.iter().any(|p| matches!(p, Packet::Motion { .. }));
                if s.up || s.base != Base::Docked || arm_near {
                    return None;
                }
                spend(&mut n, DRIVES)?;
                n.base = Base::Astray;
            }
        }
        if n.net.len() > 3 {
            return None;
        }
        n.net.sort_unstable();
        Self::judge(&mut n);
        Some(n)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always("no motion twice", |_, s: &State| s.bad != Some(Bad::Twice)),
            Property::always("done means done", |_, s: &State| s.bad != Some(Bad::Early)),
            Property::always("in order", |_, s: &State| s.bad != Some(Bad::Order)),
            Property::always("one in the zone", |_, s: &State| s.bad != Some(Bad::Zone)),
            Property::sometimes("both visits end", |_, s: &State| {
                s.session == SessionState::Released
            }),
            Property::sometimes(
                "both visits end after a crash and a loss",
                |m: &Self, s: &State| {
                    s.session == SessionState::Released
                        && s.left[CRASHES] < m.bounds.crashes
                        && (s.left[LOSSES] < m.bounds.losses || m.bounds.losses == 0)
                },
            ),
            Property::sometimes("a human is asked", |m: &Self, s: &State| {
                m.bounds.jogs == 0 || s.arms.iter().any(|a| a.intent.is_some_and(|i| i.asked))
            }),
        ]
    }
}
