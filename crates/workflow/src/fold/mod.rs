//! Facts become state. Nothing is decided here: a fact says what is, and the fold writes it down.

mod changes;
mod jobs;
mod jump;
mod loads;
mod operations;
mod seen;
mod sessions;
mod signals;

use std::sync::Arc;

use crate::book::{Live, OpState, REMEMBERED, Transport};
use crate::cell::Cell;
use crate::custody::Load;
use crate::effect::Effect;
use crate::fact::Fact;
use crate::ids::Millis;
use crate::intervention::Intervention;
use crate::job::{ByHand, FaultNote, Job, StepState};
use crate::session::Session;

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
                let number = self.book.jobs_created;
                let new = Job {
                    trigger: trigger.clone(),
                    origin: origin.clone(),
                    ..Job::new(*job, number, (**spec).clone(), items.clone())
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
            Fact::JobMoved { job, to, why, text } => self.fold_job_moved(job, *to, why, text),
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
            } => self.fold_planned(job, steps, drop, definition.as_ref()),
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
                self.fold_op_started(*op, *job, *step, arm, action);
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
                let number = self.book.sessions_created;
                let new = Session::reserved(*session, number, *job, point, mobile_robot);
                drop(self.book.sessions.insert(*session, Arc::new(new)));
                self.job_mut(job, |j| j.session = Some(*session));
            }
            Fact::SessionHandedOn {
                session,
                mobile_robot,
            } => self.fold_handed_on(session, mobile_robot),
            Fact::SessionMoved { session, to, fault } => {
                self.fold_session_moved(session, *to, *fault);
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
            Fact::SessionRewound { session, to } => self.fold_rewound(session, *to),
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
            } => self.fold_signals_lost(mobile_robot, *boot, *from, *to),
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
            Fact::CustodyMoved { load, to, by: _ } => self.fold_custody(load, to),
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
            Fact::TimerExpired { timer } => effects.extend(self.fold_expired(timer)),
            Fact::ArmSeen(seen) => self.see_arm(fresh, seen),
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
}
