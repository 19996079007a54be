//! Facts become state. Nothing is decided here: a fact says what is, and the fold writes it down.

use std::sync::Arc;

use crate::book::{ArmLive, Jump, Live, Mobile, Op, OpState, REMEMBERED, Transport};
use crate::cell::Cell;
use crate::custody::{Load, Location};
use crate::effect::{Action, Effect, Target};
use crate::fact::{Fact, Rewind};
use crate::ids::Millis;
use crate::input::OpResult;
use crate::intervention::Intervention;
use crate::job::{ByHand, Compensation, FaultNote, Job, JobState, Step, StepState, Why};
use crate::session::{Session, SessionState};
use crate::signal::{Message, OutMessage, Signal, SignalAnswer, SignalKind};
use crate::timers::TimerKey;

/// What a mobile robot that finds itself anew may correct its pose by.
const JUMP_SLACK_MM: f64 = 300.0;

impl Cell {
    /// Folds `fact`; `now` is `None` while old facts are replayed.
    #[expect(
        clippy::too_many_lines,
        reason = "one arm for each fact, most of them one line"
    )]
    pub(crate) fn fold(&mut self, now: Option<Millis>, fact: &Fact) -> Vec<Effect> {
        let mut effects = Vec::new();
        let fresh = now.is_some();
        match fact {
            Fact::Recovered => {
                if fresh {
                    self.live = Live {
                        recovered: true,
                        ..Live::default()
                    };
                }
                for mobile in self.book.mobiles.values_mut() {
                    // A grant nobody fetched dies with the permit it announced.
                    Arc::make_mut(mobile).outbox.retain(|m| !m.message.grants());
                }
            }
            Fact::SetupChanged { setup } => self.install(setup),
            Fact::JobCreated {
                job,
                spec,
                trigger,
                origin,
                items,
            } => {
                self.book.jobs_created += 1;
                let new = Job {
                    id: *job,
                    number: self.book.jobs_created,
                    spec: (**spec).clone(),
                    trigger: trigger.clone(),
                    origin: origin.clone(),
                    definition: None,
                    state: JobState::Idle,
                    why: Why::Course,
                    text: String::new(),
                    arm: None,
                    mobile_robot: None,
                    session: None,
                    items: items.clone(),
                    steps: Vec::new(),
                    near: None,
                    by_hand: None,
                    compensation: Compensation::None,
                    redispatches: 0,
                    loads_accepted: false,
                    faults: Vec::new(),
                };
                drop(self.book.jobs.insert(*job, Arc::new(new)));
            }
            Fact::JobAssigned {
                job,
                arm,
                mobile_robot,
            } => self.job_mut(job, |j| {
                j.arm = Some(arm.clone());
                j.mobile_robot = Some(mobile_robot.clone());
            }),
            Fact::JobMoved { job, to, why, text } => {
                self.job_mut(job, |j| {
                    j.state = *to;
                    j.why = why.clone();
                    j.text.clone_from(text);
                    if *to == JobState::Idle {
                        (j.steps, j.near, j.session) = (Vec::new(), None, None);
                        j.by_hand = None;
                        (j.compensation, j.loads_accepted) = (Compensation::None, false);
                        j.redispatches = 0;
                    }
                });
                if to.is_final() {
                    self.book.forget();
                }
            }
            Fact::FaultNoted { job, fault, text } => self.job_mut(job, |j| {
                if j.faults.len() < REMEMBERED {
                    j.faults.push(FaultNote {
                        fault: *fault,
                        text: text.clone(),
                    });
                }
            }),
            Fact::Planned {
                job,
                steps,
                drop,
                definition,
            } => self.job_mut(job, |j| {
                if definition.is_some() {
                    j.definition.clone_from(definition);
                }
                for index in drop {
                    if let Some(step) = j.steps.get_mut(*index) {
                        step.state = StepState::Dropped;
                    }
                }
                j.steps.extend(steps.iter().cloned().map(Step::new));
            }),
            Fact::StepMoved {
                job,
                step,
                to,
                attempt,
                text: _,
            } => self.step_mut(job, *step, |s| {
                if s.attempt != *attempt || *to == StepState::Pending {
                    (s.done_ops, s.resends) = (0, 0);
                }
                (s.state, s.attempt) = (*to, *attempt);
            }),
            Fact::StepRedirected { job, step, place } => {
                self.step_mut(job, *step, |s| s.plan.place = Some(place.clone()));
            }
            Fact::StepResent { job, step } => {
                self.step_mut(job, *step, |s| s.resends = s.resends.saturating_add(1));
            }
            Fact::StepNeeds { job, step, need } => {
                self.step_mut(job, *step, |s| s.plan.needs.push(*need));
            }
            Fact::ItemChanged { job, item, to } => self.job_mut(job, |j| {
                if let Some(slot) = j.items.get_mut(*item) {
                    slot.clone_from(to);
                }
            }),
            Fact::CompensationMoved { job, to } => self.job_mut(job, |j| j.compensation = *to),
            Fact::LoadsAccepted { job } => self.job_mut(job, |j| j.loads_accepted = true),
            Fact::Redispatched { job } => {
                self.job_mut(job, |j| j.redispatches = j.redispatches.saturating_add(1));
            }
            Fact::ArmByHand { job, displaced } => self.job_mut(job, |j| {
                let before = j.by_hand.is_some_and(|by| by.displaced);
                j.by_hand = Some(ByHand {
                    displaced: *displaced || before,
                    decided: false,
                });
            }),
            Fact::ArmByHandDecided { job } => self.job_mut(job, |j| {
                // Where the arm was moved it stays known until it is at its safe pose.
                j.by_hand = j.by_hand.filter(|by| by.displaced).map(|by| ByHand {
                    decided: true,
                    ..by
                });
            }),
            Fact::Claimed { by, resources } => self.book.claims.claim(*by, resources),
            Fact::Released { by, resources } => {
                self.book.claims.release(*by, resources.as_deref());
            }
            Fact::OpStarted {
                op,
                job,
                step,
                arm,
                action,
            } => {
                let new = Op {
                    job: *job,
                    step: *step,
                    arm: arm.clone(),
                    action: action.clone(),
                    state: OpState::Running,
                };
                drop(self.book.ops.insert(*op, new));
                self.moves_on(arm);
                self.job_mut(job, |j| {
                    if let Action::Move { target, .. } = action
                        && let Some(place) = target.place()
                    {
                        j.near = Some(place.clone());
                    }
                    if let Some(s) = j.steps.get_mut(*step) {
                        s.op = Some(*op);
                    }
                });
                effects.push(Effect::Operate {
                    op: *op,
                    arm: arm.clone(),
                    action: action.clone(),
                    job: *job,
                    step: *step,
                });
            }
            Fact::OpDoubted { op, text: _ } => self.op_state(op, OpState::Doubt),
            Fact::OpReconciling { op } => {
                self.op_state(op, OpState::Reconciling);
                if let Some(found) = self.book.ops.get(op) {
                    effects.push(Effect::Reconcile {
                        op: *op,
                        arm: found.arm.clone(),
                        action: found.action.clone(),
                    });
                }
            }
            Fact::OpEnded { op, result } => self.fold_op_ended(op, result),
            Fact::ArmStopped { arm, text: _ } => {
                if let Some(live) = self.live.arms.get_mut(arm) {
                    live.stopping = true;
                }
                effects.push(Effect::StopArm { arm: arm.clone() });
            }
            Fact::SafeDue { arm } => {
                let _stamp = self.live.safe.insert(arm.clone(), 1);
            }
            Fact::SessionOpened {
                session,
                point,
                job,
                mobile_robot,
            } => {
                self.book.sessions_created += 1;
                self.forget_jump(mobile_robot);
                let new = Session {
                    id: *session,
                    number: self.book.sessions_created,
                    point: point.clone(),
                    job: *job,
                    mobile_robot: mobile_robot.clone(),
                    state: SessionState::Reserved,
                    faulted: None,
                    order: None,
                    update: 0,
                    assigned: false,
                    arrived: false,
                    docked: None,
                    ready: false,
                    cleared: false,
                    echoes: false,
                    left: false,
                    dock_tries: 0,
                    backs_out: false,
                    measured_accepted: false,
                    resends: 0,
                };
                drop(self.book.sessions.insert(*session, Arc::new(new)));
                self.job_mut(job, |j| j.session = Some(*session));
            }
            Fact::SessionHandedOn {
                session,
                mobile_robot,
            } => {
                let job = self.book.sessions.get(session).map(|s| s.job);
                self.session_mut(session, |s| {
                    s.mobile_robot.clone_from(mobile_robot);
                    rewind(s, Rewind::Order);
                });
                if let Some(job) = job {
                    self.job_mut(&job, |j| j.mobile_robot = Some(mobile_robot.clone()));
                }
            }
            Fact::SessionMoved { session, to, fault } => {
                self.session_mut(session, |s| {
                    if *to == SessionState::Faulted {
                        let from = s.faulted.map_or(s.state, |(from, _)| from);
                        s.faulted = Some((from, fault.unwrap_or(crate::Fault::NoAnswer)));
                    } else {
                        s.faulted = None;
                    }
                    (s.state, s.resends) = (*to, 0);
                });
                if to.is_closed() {
                    self.book.forget();
                }
            }
            Fact::SessionOrdered {
                session,
                order,
                update,
            } => self.session_mut(session, |s| {
                (s.order, s.update) = (Some(*order), *update);
            }),
            Fact::SessionResent { session } => {
                self.session_mut(session, |s| s.resends = s.resends.saturating_add(1));
            }
            Fact::SessionRewound { session, to } => {
                self.session_mut(session, |s| rewind(s, *to));
                let robot = self.book.sessions.get(session);
                if let Some(robot) = robot.map(|s| s.mobile_robot.clone()) {
                    self.forget_jump(&robot);
                }
            }
            Fact::SessionBacksOut { session } => {
                self.session_mut(session, |s| s.backs_out = true);
            }
            Fact::MeasuredAccepted { session } => {
                self.session_mut(session, |s| s.measured_accepted = true);
            }
            Fact::SessionLeft { session } => self.session_mut(session, |s| s.left = true),
            Fact::Told {
                mobile_robot,
                session,
                message,
            } => {
                let out = self.put_out(mobile_robot, *session, message);
                effects.push(Effect::Tell {
                    mobile_robot: mobile_robot.clone(),
                    message: out,
                });
            }
            Fact::OutboxTaken { mobile_robot, n } => {
                self.mobile_mut(mobile_robot, |m| m.outbox.retain(|o| o.n > *n));
            }
            Fact::Signaled { signal, answer } => self.fold_signal(now, signal, answer),
            Fact::SignalsLost {
                mobile_robot,
                boot,
                from,
                to,
            } => self.mobile_mut(mobile_robot, |m| {
                if m.boot != *boot {
                    m.answers.clear();
                    m.lost.clear();
                    (m.boot, m.parked) = (*boot, None);
                    m.seq = 0;
                }
                if m.parked.as_ref().is_some_and(|p| p.seq <= *to) {
                    m.parked = None;
                }
                m.seq = m.seq.max(*to);
                m.lost.push_back((*from, *to));
                if m.lost.len() > 64 {
                    let _oldest = m.lost.pop_front();
                }
            }),
            Fact::Beat { signal } => {
                self.see(now, signal);
            }
            Fact::TransportBegun {
                mobile_robot,
                job,
                order,
                destination,
                session,
                update,
            } => {
                self.mobile_mut(mobile_robot, |m| {
                    m.transport = Some(Transport {
                        job: *job,
                        order: *order,
                        destination: destination.clone(),
                        session: *session,
                        update: *update,
                    });
                });
            }
            Fact::TransportEnded { mobile_robot } => {
                self.mobile_mut(mobile_robot, |m| m.transport = None);
            }
            // They are records: what was told is a fact of its own.
            Fact::TriggerSkipped { .. } | Fact::InstantActed { .. } => {}
            Fact::LoadRegistered {
                load,
                kind,
                location,
            } => {
                let new = Load {
                    kind: kind.clone(),
                    location: location.clone(),
                };
                let custody = Arc::make_mut(&mut self.book.custody);
                drop(custody.0.insert(load.clone(), new));
            }
            Fact::CustodyMoved { load, to, by: _ } => {
                if matches!(to, Location::Delivered { .. }) {
                    self.book.delivered.retain(|known| known != load);
                    self.book.delivered.push_back(load.clone());
                    self.forget_delivered();
                }
                let custody = Arc::make_mut(&mut self.book.custody);
                let before = custody
                    .0
                    .get_mut(load)
                    .map(|found| std::mem::replace(&mut found.location, to.clone()));
                // What the part sensor said before is about another situation.
                for at in before.iter().chain([to]) {
                    if let Location::Gripper { arm } = at
                        && let Some(live) = self.live.arms.get_mut(arm)
                    {
                        live.seen.part_present = None;
                    }
                }
            }
            Fact::Asked { question } => {
                self.book.questions_asked += 1;
                let new = Intervention {
                    number: self.book.questions_asked,
                    question: (**question).clone(),
                    decided: None,
                    withdrawn: None,
                    reminders: 0,
                };
                drop(self.book.interventions.insert(question.id, Arc::new(new)));
                effects.push(Effect::Ask {
                    intervention: question.id,
                });
            }
            Fact::Answered {
                intervention,
                decided,
            } => {
                if let Some(found) = self.book.interventions.get_mut(intervention) {
                    Arc::make_mut(found).decided = Some(decided.clone());
                }
            }
            Fact::Withdrawn { intervention, text } => {
                if let Some(found) = self.book.interventions.get_mut(intervention) {
                    Arc::make_mut(found).withdrawn = Some(text.clone());
                }
            }
            Fact::TimerExpired { timer } => {
                if let Some(wait) = self.live.timers.get_mut(timer) {
                    wait.fired = true;
                }
                if let TimerKey::Question { intervention } = timer {
                    let _armed_anew = self.live.timers.remove(timer);
                    effects.push(Effect::Remind {
                        intervention: *intervention,
                    });
                }
                if let TimerKey::Safe { arm } = timer {
                    let _one = self.live.safe.remove(arm);
                }
                if matches!(
                    timer,
                    TimerKey::Queue { .. } | TimerKey::State { .. } | TimerKey::Step { .. }
                ) {
                    let _armed_anew = self.live.timers.remove(timer);
                }
            }
            Fact::ArmSeen(seen) => {
                if fresh {
                    let before = self.live.arms.get(&seen.arm);
                    let count = before.map_or(0, |b| b.count) + 1;
                    let stopping = before.is_some_and(|b| b.stopping) && !seen.still;
                    let live = ArmLive {
                        seen: seen.clone(),
                        count,
                        stopping,
                    };
                    drop(self.live.arms.insert(seen.arm.clone(), live));
                }
            }
            Fact::ArmLost { arm } => {
                if let Some(live) = self.live.arms.get_mut(arm) {
                    (live.seen.link, live.seen.ready, live.seen.still) = (false, false, false);
                }
            }
            Fact::MobileLost { mobile_robot } => {
                if let Some(live) = self.live.mobiles.get_mut(mobile_robot) {
                    let live = Arc::make_mut(live);
                    (live.lost, live.beats) = (true, 0);
                }
            }
            Fact::OpPlanned { op, expected_ms } => {
                let _before = self.live.planned.insert(*op, *expected_ms);
            }
            Fact::ControlChanged { jobs_may_act } => self.live.jobs_may_act = *jobs_may_act,
            Fact::JournalChanged { writable } => self.live.unwritable = !writable,
        }
        effects
    }

    fn fold_op_ended(&mut self, op: &uuid::Uuid, result: &OpResult) {
        let Some(ended) = self.book.ops.remove(op) else {
            return;
        };
        let _planned = self.live.planned.remove(op);
        self.moves_on(&ended.arm);
        let succeeded = match (&ended.action, result) {
            (Action::Move { .. }, OpResult::Arrived) => true,
            (Action::Precheck { .. }, OpResult::Prechecked { failures }) => failures.is_empty(),
            (
                Action::Grip { action, .. },
                OpResult::Gripped {
                    closed,
                    open,
                    part_present,
                },
            ) => match action {
                crate::GripAction::Close => *closed && *part_present,
                crate::GripAction::Open => *open && !*part_present,
            },
            (Action::Move { .. } | Action::Precheck { .. } | Action::Grip { .. }, _) => false,
        };
        let safe = matches!(
            &ended.action,
            Action::Move {
                target: Target::Safe,
                ..
            }
        );
        if safe {
            let _one = self.live.safe.remove(&ended.arm);
        }
        self.job_mut(&ended.job, |j| {
            if let Some(step) = j.steps.get_mut(ended.step)
                && step.op == Some(*op)
            {
                step.op = None;
                step.done_ops += usize::from(succeeded);
            }
            if safe && succeeded {
                (j.near, j.by_hand) = (None, None);
            }
        });
    }

    /// Where an arm was seen to stand is overtaken by its next operation.
    fn moves_on(&mut self, arm: &str) {
        if let Some(live) = self.live.arms.get_mut(arm) {
            live.seen.displaced = false;
        }
    }

    fn fold_signal(&mut self, now: Option<Millis>, signal: &Signal, answer: &SignalAnswer) {
        if matches!(answer, SignalAnswer::Late { .. }) {
            // What it tells was overtaken long ago: it is remembered, and that is all.
            self.mobile_mut(&signal.mobile_robot, |m| {
                m.remember(signal.seq, answer.clone());
            });
            return;
        }
        self.mobile_mut(&signal.mobile_robot, |m| {
            if m.boot != signal.boot {
                m.answers.clear();
                m.lost.clear();
                (m.boot, m.seq, m.parked) = (signal.boot, 0, None);
            }
            if matches!(answer, SignalAnswer::Parked) {
                m.parked = Some(signal.clone());
                return;
            }
            if m.parked.as_ref().is_some_and(|p| p.seq <= signal.seq) {
                m.parked = None;
            }
            m.seq = m.seq.max(signal.seq);
            m.remember(signal.seq, answer.clone());
        });
        if matches!(answer, SignalAnswer::Parked) {
            if let Some(live) = self.live.mobiles.get_mut(&signal.mobile_robot)
                && live.boot != signal.boot
            {
                let live = Arc::make_mut(live);
                (live.boot, live.seq) = (signal.boot, 0);
            }
            return;
        }
        self.see(now, signal);
        if !matches!(answer, SignalAnswer::Accepted { .. }) {
            return;
        }
        let Some(session) = self
            .book
            .open_session_of(&signal.mobile_robot)
            .map(|s| s.id)
        else {
            return;
        };
        self.session_mut(&session, |s| {
            s.echoes |= s.order.is_some() && signal.state.order == s.order;
            fold_said(s, signal);
        });
    }

    fn see(&mut self, now: Option<Millis>, signal: &Signal) {
        let Some(now) = now else { return };
        let jump = self.jump_of(now, signal);
        let live = Arc::make_mut(
            self.live
                .mobiles
                .entry(signal.mobile_robot.clone())
                .or_default(),
        );
        live.jump = jump.or(live.jump.filter(|_| signal.kind != SignalKind::MrClear));
        live.state = Some(signal.state.clone());
        (live.seen_at, live.told_at) = (Some(now), signal.at_ms);
        (live.boot, live.seq) = (signal.boot, signal.seq);
        live.beats += 1;
        live.count += 1;
        live.lost &= live.beats < u64::from(self.setup.timers.heartbeats_to_resume);
        live.synced = true;
    }

    /// Whether the pose is farther from the one before than can be driven meanwhile. Signals that waited for a network
    /// arrive closer together than they were sent, so the longer of both times counts. Another boot may find itself
    /// anywhere.
    fn jump_of(&self, now: Millis, signal: &Signal) -> Option<Jump> {
        let setup = self.setup.mobile_robot(&signal.mobile_robot)?;
        let max_speed_mm_s = setup.max_speed_mm_s?;
        let live = self.live.mobiles.get(&signal.mobile_robot)?;
        let before = live.state.as_ref().filter(|_| live.boot == signal.boot)?;
        let arrived = now.saturating_sub(live.seen_at?);
        let told = signal.at_ms.zip(live.told_at);
        let told = told.and_then(|(at, before)| u64::try_from(at.saturating_sub(before)).ok());
        let within_ms = arrived.max(told.unwrap_or(0));
        let (from, to) = (before.pose, signal.state.pose);
        let distance_mm = (to.x_mm - from.x_mm).hypot(to.y_mm - from.y_mm);
        #[expect(
            clippy::cast_precision_loss,
            reason = "times of one run: far below the integers that a float has"
        )]
        let possible = f64::from(max_speed_mm_s) * within_ms as f64 / 1_000.0 + JUMP_SLACK_MM;
        (distance_mm > possible).then_some(Jump {
            distance_mm,
            within_ms,
            max_speed_mm_s,
        })
    }

    /// What it claimed of its way before counts no more: it is to dock, for the first time or anew.
    fn forget_jump(&mut self, mobile_robot: &str) {
        if let Some(live) = self.live.mobiles.get_mut(mobile_robot) {
            Arc::make_mut(live).jump = None;
        }
    }

    fn put_out(
        &mut self,
        mobile_robot: &str,
        session: Option<uuid::Uuid>,
        message: &Message,
    ) -> OutMessage {
        let mut out = OutMessage {
            n: 0,
            session,
            message: message.clone(),
        };
        self.mobile_mut(mobile_robot, |m| {
            m.sent += 1;
            out.n = m.sent;
            if matches!(
                message,
                Message::MovePermit { granted: false } | Message::StartPause
            ) {
                // What was granted and not fetched yet must not be fetched before it is taken back.
                m.outbox.retain(|o| !o.message.grants());
            }
            if let Message::TransportOrder { order, .. } = message {
                // An order of the same hand-over that was not fetched yet is not driven to any more.
                m.outbox.retain(|o| {
                    let other = matches!(&o.message, Message::TransportOrder { order: earlier, .. } if earlier != order);
                    !(other && o.session == session && session.is_some())
                });
            }
            m.outbox.push_back(out.clone());
            if m.outbox.len() > REMEMBERED {
                drop(m.outbox.pop_front());
            }
        });
        out
    }

    fn op_state(&mut self, op: &uuid::Uuid, state: OpState) {
        if let Some(found) = self.book.ops.get_mut(op) {
            found.state = state;
        }
    }

    fn job_mut(&mut self, job: &uuid::Uuid, change: impl FnOnce(&mut Job)) {
        if let Some(found) = self.book.jobs.get_mut(job) {
            change(Arc::make_mut(found));
        }
    }

    fn step_mut(&mut self, job: &uuid::Uuid, step: usize, change: impl FnOnce(&mut Step)) {
        self.job_mut(job, |j| {
            if let Some(found) = j.steps.get_mut(step) {
                change(found);
            }
        });
    }

    fn session_mut(&mut self, session: &uuid::Uuid, change: impl FnOnce(&mut Session)) {
        if let Some(found) = self.book.sessions.get_mut(session) {
            change(Arc::make_mut(found));
        }
    }

    fn mobile_mut(&mut self, mobile_robot: &str, change: impl FnOnce(&mut Mobile)) {
        change(Arc::make_mut(
            self.book
                .mobiles
                .entry(mobile_robot.to_owned())
                .or_default(),
        ));
    }

    /// Takes a configuration; loads that are new appear where it says.
    fn install(&mut self, setup: &crate::Setup) {
        let before = std::mem::replace(&mut self.setup, Arc::new(setup.clone()));
        let custody = Arc::make_mut(&mut self.book.custody);
        // A load that was delivered, and that the set-up does not name any more, is nobody's.
        for load in &before.loads {
            let named = setup.loads.iter().any(|known| known.id == load.id);
            let gone = custody
                .of(&load.id)
                .is_some_and(|at| matches!(at, Location::Delivered { .. }));
            if gone && !named {
                drop(custody.0.remove(&load.id));
            }
        }
        for load in &setup.loads {
            if !custody.0.contains_key(&load.id) {
                let new = Load {
                    kind: load.kind.clone(),
                    location: load.at.clone(),
                };
                drop(custody.0.insert(load.id.clone(), new));
            }
        }
    }

    /// What a mobile robot took away stays in the books for a while, and then only in the journal. What the set-up
    /// names stays: its next change would bring it back to where it was at first.
    fn forget_delivered(&mut self) {
        let setup = Arc::clone(&self.setup);
        let named = |load: &String| setup.loads.iter().any(|known| known.id == *load);
        let mut surplus = self.book.delivered.len().saturating_sub(REMEMBERED);
        let custody = Arc::make_mut(&mut self.book.custody);
        let claims = &self.book.claims;
        self.book.delivered.retain(|load| {
            let gone = custody
                .of(load)
                .is_some_and(|at| matches!(at, Location::Delivered { .. }));
            let claimed = !claims.is_free(&crate::Resource::Load(load.clone()));
            if surplus == 0 || claimed {
                return true;
            }
            surplus -= 1;
            if gone && !named(load) {
                drop(custody.0.remove(load));
            }
            false
        });
    }

    /// A load that is nowhere else.
    pub(crate) fn is_free(&self, location: &Location) -> bool {
        !self.setup.is_single(location) || self.book.custody.at(location).is_none()
    }
}

fn fold_said(s: &mut Session, signal: &Signal) {
    match signal.kind {
        SignalKind::MrAssigned => s.assigned = true,
        SignalKind::MrArrived => s.arrived = true,
        SignalKind::MrDocked => (s.arrived, s.docked) = (true, Some(signal.state.pose)),
        SignalKind::MrReady => s.ready = true,
        SignalKind::MrClear => s.cleared = true,
        SignalKind::MrDockFailed => s.dock_tries = s.dock_tries.saturating_add(1),
        SignalKind::MrDelivered
        | SignalKind::LoadChanged
        | SignalKind::MrHeartbeat
        | SignalKind::MrFault
        | SignalKind::MrMode
        | SignalKind::MrRejected => {}
    }
}

fn rewind(session: &mut Session, to: Rewind) {
    (session.docked, session.ready, session.measured_accepted) = (None, false, false);
    session.backs_out = false;
    if to == Rewind::Order {
        (session.order, session.update) = (None, 0);
        (session.assigned, session.arrived, session.cleared) = (false, false, false);
        (session.left, session.echoes, session.dock_tries) = (false, false, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::{BasePose, MobileRobotSetup, Setup};
    use crate::signal::MobileState;

    fn signal(boot: u64, x_mm: f64, at_ms: Option<i64>) -> Signal {
        Signal {
            mobile_robot: "m1".into(),
            session: None,
            boot,
            seq: 1,
            kind: SignalKind::MrHeartbeat,
            at_ms,
            resync: false,
            state: MobileState {
                pose: BasePose {
                    x_mm,
                    ..BasePose::default()
                },
                ..MobileState::default()
            },
        }
    }

    fn seen(max_speed_mm_s: Option<u32>) -> Cell {
        let mut cell = Cell::new(Setup {
            mobile_robots: vec![MobileRobotSetup {
                id: "m1".into(),
                slots: Vec::new(),
                max_speed_mm_s,
            }],
            ..Setup::default()
        });
        cell.see(Some(10_000), &signal(1, 0.0, Some(0)));
        cell
    }

    #[test]
    fn m5_a_pose_goes_no_farther_than_its_robot_drives_in_the_longer_of_both_times() {
        let cell = seen(Some(1_000));
        let jump = |now, signal| cell.jump_of(now, &signal).map(|jump| jump.within_ms);
        assert_eq!(jump(11_000, signal(1, 1_300.0, None)), None);
        assert_eq!(jump(11_000, signal(1, 1_301.0, None)), Some(1_000));
        assert_eq!(jump(11_000, signal(1, -1_301.0, Some(500))), Some(1_000));
        // Three signals that waited for the network arrive together, and were sent a second apart.
        assert_eq!(jump(10_001, signal(1, 5_000.0, Some(5_000))), None);
        // A clock that was set back takes nothing from the time that passed here.
        assert_eq!(jump(15_000, signal(1, 5_000.0, Some(-9_000))), None);
        // After its start it may find itself anywhere.
        assert_eq!(jump(10_001, signal(2, 5_000.0, None)), None);
        let anyhow = seen(None);
        assert_eq!(anyhow.jump_of(10_001, &signal(1, 5_000.0, None)), None);
    }

    #[test]
    fn m5_a_jump_is_remembered_until_the_robot_is_told_to_dock_anew_or_is_clear() {
        let mut cell = seen(Some(1_000));
        let jumped = |cell: &Cell| cell.live.mobiles["m1"].jump.is_some();
        cell.see(Some(10_100), &signal(1, 5_000.0, None));
        assert!(jumped(&cell));
        cell.see(Some(10_200), &signal(1, 5_000.0, None));
        assert!(jumped(&cell), "standing still afterwards proves nothing");
        let mut clear = signal(1, 5_000.0, None);
        clear.kind = SignalKind::MrClear;
        cell.see(Some(10_300), &clear);
        assert!(!jumped(&cell));
        cell.see(Some(10_400), &signal(1, 0.0, None));
        cell.forget_jump("m1");
        assert!(!jumped(&cell));
    }
}
