//! A job's story in sentences.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use api::JobEvent;
use uuid::Uuid;
use workflow::{
    Evidence, Fact, Holder, Location, Message, OpResult, Phase, PlannedStep, Resource, Why,
    Workflow,
};

use super::report::Elapsed;
use super::story::History;
use crate::words::{action, because, word};

/// Everything that happened to a job, the oldest first.
pub(crate) fn events(history: &History) -> Vec<JobEvent> {
    let mut teller = Teller::default();
    let mut elapsed = Elapsed::default();
    let mut events = Vec::new();
    for chapter in &history.chapters {
        let since_ms = elapsed.at(chapter);
        for (index, fact) in &chapter.facts {
            teller.note(fact);
            let Some(told) = teller.tell(fact) else {
                continue;
            };
            events.push(JobEvent {
                id: format!("{}-{index}", chapter.position.0),
                at: chapter.at.wall,
                since_ms,
                kind: kind_of(fact),
                text: told.text,
                code: told.step.and_then(|step| teller.code(step)),
                step: told.step,
                principal: told.principal,
            });
        }
    }
    events
}

/// The word of a fact, as it is written in the journal.
fn kind_of(fact: &Fact) -> String {
    let value = serde_json::to_value(fact).unwrap_or_default();
    let kind = value.get("fact").and_then(serde_json::Value::as_str);
    kind.unwrap_or_default().to_owned()
}

#[derive(Debug, Default)]
struct Told {
    text: String,
    step: Option<usize>,
    principal: Option<String>,
}

impl Told {
    fn of(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    fn step(text: impl Into<String>, step: usize) -> Self {
        Self {
            text: text.into(),
            step: Some(step),
            principal: None,
        }
    }

    fn by(text: impl Into<String>, principal: &str) -> Self {
        Self {
            text: text.into(),
            step: None,
            principal: Some(principal.to_owned()),
        }
    }
}

/// Knows what the facts refer to.
#[derive(Debug, Default)]
struct Teller {
    workflow: Option<Workflow>,
    steps: Vec<PlannedStep>,
    operations: BTreeMap<Uuid, (usize, String, String)>,
}

impl Teller {
    fn note(&mut self, fact: &Fact) {
        if let Fact::JobCreated { spec, .. } = fact {
            self.workflow = Some(spec.workflow);
        } else if let Fact::Planned { steps, .. } = fact {
            self.steps.extend(steps.iter().cloned());
        } else if let Fact::JobMoved {
            to: workflow::JobState::Idle,
            ..
        } = fact
        {
            // Into the queue again: there will be another plan.
            self.steps.clear();
        } else if let Fact::OpStarted {
            op,
            step,
            arm,
            action: what,
            ..
        } = fact
        {
            let told = (*step, arm.clone(), action(what));
            let _new = self.operations.insert(*op, told);
        }
    }

    fn code(&self, step: usize) -> Option<String> {
        let phase = self.steps.get(step)?.phase;
        Some(phase.code(self.workflow?).to_owned())
    }

    fn step_name(&self, step: usize) -> String {
        let Some(planned) = self.steps.get(step) else {
            return format!("step {step}");
        };
        let code = self.workflow.map_or("", |name| planned.phase.code(name));
        let mut name = format!("{code} {}", phase_name(planned.phase));
        if let Some(place) = &planned.place {
            let _ = write!(name, " ({place})");
        }
        name
    }

    fn operation(&self, op: Uuid, text: &str) -> Option<Told> {
        let (step, arm, what) = self.operations.get(&op)?;
        Some(Told::step(format!("{arm}: {what}{text}"), *step))
    }

    #[expect(clippy::too_many_lines, reason = "one sentence for each fact")]
    fn tell(&self, fact: &Fact) -> Option<Told> {
        let told = match fact {
            Fact::JobCreated { spec, items, .. } => Told::of(format!(
                "created: {} at {}, {} item(s)",
                word(&spec.workflow),
                spec.point,
                items.len()
            )),
            Fact::JobAssigned {
                arm, mobile_robot, ..
            } => Told::of(format!("{arm} and {mobile_robot} do it")),
            Fact::JobMoved { to, why, text, .. } => {
                let because = because(text);
                let to = word(to);
                match why {
                    Why::Human { principal } => {
                        Told::by(format!("{to} by {principal}{because}"), principal)
                    }
                    Why::Fault { fault } => Told::of(format!("{to} for {}{because}", fault.code())),
                    Why::Recovering => Told::of(format!("{to} after a restart{because}")),
                    Why::DeadlinePassed => Told::of(format!("{to}: its deadline has passed")),
                    Why::Course | Why::Awaiting => Told::of(format!("{to}{because}")),
                }
            }
            Fact::FaultNoted { fault, text, .. } => Told::of(format!(
                "fault {} {}{}",
                fault.code(),
                word(fault),
                because(text)
            )),
            Fact::Planned { steps, drop, .. } => {
                let mut text = format!("{} step(s) planned", steps.len());
                if !drop.is_empty() {
                    let _ = write!(text, ", {} not needed any more", drop.len());
                }
                Told::of(text)
            }
            Fact::StepMoved {
                step,
                to,
                attempt,
                text,
                ..
            } => {
                let again = if *attempt > 1 {
                    format!(", attempt {attempt}")
                } else {
                    String::new()
                };
                let name = self.step_name(*step);
                let to = word(to);
                Told::step(format!("{name}: {to}{again}{}", because(text)), *step)
            }
            Fact::StepRedirected { step, place, .. } => Told::step(
                format!("{}: goes to {place} instead", self.step_name(*step)),
                *step,
            ),
            Fact::StepResent { step, .. } => Told::step(
                format!(
                    "{}: asked again, or its wait extended",
                    self.step_name(*step)
                ),
                *step,
            ),
            Fact::ItemChanged { item, to, .. } => Told::of(format!(
                "item {item} is {} of type {}, {} and {}",
                to.load.as_deref().unwrap_or("a load without a name"),
                to.kind,
                to.slot,
                to.place
            )),
            Fact::CompensationMoved { to, .. } => Told::of(format!("undoing: {}", word(to))),
            Fact::LoadsAccepted { .. } => Told::of("the loads are accepted as they are"),
            Fact::ArmByHand {
                displaced: true, ..
            } => Told::of("the arm was moved by hand"),
            Fact::ArmByHand { .. } => Told::of("the arm is, or was, in a human's hand"),
            Fact::ArmByHandDecided { .. } => Told::of("a human said how the arm goes on"),
            Fact::Redispatched { .. } => Told::of("a mobile robot is called again"),
            Fact::Claimed { resources, .. } => Told::of(format!("claimed: {}", names(resources))),
            Fact::Released { by, resources } => match (by, resources) {
                (_, Some(some)) => Told::of(format!("released: {}", names(some))),
                (Holder::Job(_), None) => Told::of("released everything it had claimed"),
                (Holder::Session(_), None) => Told::of("the session released its point"),
            },
            Fact::OpStarted { op, .. } => return self.operation(*op, ""),
            Fact::OpDoubted { op, text } => {
                return self.operation(
                    *op,
                    &format!(": nobody knows how it ended{}", because(text)),
                );
            }
            Fact::OpReconciling { op } => return self.operation(*op, ": finding out how it ended"),
            Fact::OpEnded { op, result } => {
                return self.operation(*op, &format!(": {}", ended(result)));
            }
            Fact::SessionOpened {
                point,
                mobile_robot,
                ..
            } => Told::of(format!("session opened at {point} for {mobile_robot}")),
            Fact::SessionHandedOn { mobile_robot, .. } => {
                Told::of(format!("the session goes on with {mobile_robot}"))
            }
            Fact::SessionMoved { to, fault, .. } => {
                let fault =
                    fault.map_or_else(String::new, |fault| format!(" for {}", fault.code()));
                Told::of(format!("session {}{fault}", word(to)))
            }
            Fact::SessionOrdered { update, .. } => {
                Told::of(format!("transport order sent, update {update}"))
            }
            Fact::SessionResent { .. } => Told::of("the session's request was sent again"),
            Fact::SessionRewound { to, .. } => Told::of(format!("session back to: {}", word(to))),
            Fact::MeasuredAccepted { .. } => Told::of("the measured dock pose is accepted"),
            Fact::SessionBacksOut { .. } => {
                Told::of("the mobile robot gives docking up and drives out")
            }
            Fact::SessionLeft { .. } => Told::of("the mobile robot drives out"),
            Fact::Told {
                mobile_robot,
                message,
                ..
            } => Told::of(format!("to {mobile_robot}: {}", message_word(message))),
            Fact::Signaled { signal, answer } => Told::of(format!(
                "{} says {}, answered {}",
                signal.mobile_robot,
                word(&signal.kind),
                answer_word(answer)
            )),
            Fact::TransportBegun {
                mobile_robot,
                destination,
                ..
            } => Told::of(format!("{mobile_robot} drives to {destination}")),
            Fact::CustodyMoved { load, to, by } => match by {
                Evidence::Human { principal, reason } => Told::by(
                    format!(
                        "load {load} is {}, says {principal}: {reason}",
                        place_of(to)
                    ),
                    principal,
                ),
                Evidence::Gripper { .. }
                | Evidence::Doubt { .. }
                | Evidence::MobileRobot { .. } => {
                    Told::of(format!("load {load} is {}", place_of(to)))
                }
            },
            Fact::Asked { question } => {
                Told::of(format!("a person is asked: {}", question.question))
            }
            Fact::Answered { decided, .. } => Told::by(
                format!(
                    "{} answers {}: {}",
                    decided.principal,
                    word(&decided.answer),
                    decided.reason
                ),
                &decided.principal,
            ),
            Fact::Withdrawn { text, .. } => {
                Told::of(format!("the question is withdrawn{}", because(text)))
            }
            Fact::Recovered => Told::of("the server was started again"),
            Fact::StepNeeds { .. }
            | Fact::SetupChanged { .. }
            | Fact::ArmStopped { .. }
            | Fact::SafeDue { .. }
            | Fact::OutboxTaken { .. }
            | Fact::SignalsLost { .. }
            | Fact::TriggerSkipped { .. }
            | Fact::InstantActed { .. }
            | Fact::Beat { .. }
            | Fact::TransportEnded { .. }
            | Fact::LoadRegistered { .. }
            | Fact::TimerExpired { .. }
            | Fact::ArmSeen(_)
            | Fact::ArmLost { .. }
            | Fact::MobileLost { .. }
            | Fact::OpPlanned { .. }
            | Fact::ControlChanged { .. }
            | Fact::JournalChanged { .. } => return None,
        };
        Some(told)
    }
}

fn place_of(location: &Location) -> String {
    match location {
        Location::Fixed { place } => format!("at {place}"),
        Location::Gripper { .. } | Location::MobileRobot { .. } => format!("in {location}"),
        Location::Delivered { .. } => location.to_string(),
        Location::Unknown { .. } => "nobody knows where".to_owned(),
    }
}

fn phase_name(phase: Phase) -> String {
    word(&phase).to_lowercase().replace('_', " ")
}

fn names(resources: &[Resource]) -> String {
    let name = |resource: &Resource| match resource {
        Resource::Point(id) => format!("point {id}"),
        Resource::Arm(id) => format!("arm {id}"),
        Resource::Place(id) => format!("place {id}"),
        Resource::MobileRobot(id) => format!("mobile robot {id}"),
        Resource::Load(id) => format!("load {id}"),
    };
    let names: Vec<_> = resources.iter().map(name).collect();
    names.join(", ")
}

pub(super) fn ended(result: &OpResult) -> String {
    match result {
        OpResult::Arrived => "done".to_owned(),
        OpResult::Gripped {
            closed,
            open,
            part_present,
        } => {
            let jaws = match (closed, open) {
                (true, false) => "closed",
                (false, true) => "open",
                (true, true) => "closed and open at once",
                (false, false) => "between open and closed",
            };
            let part = if *part_present { "a part" } else { "no part" };
            format!("the gripper is {jaws}, with {part}")
        }
        OpResult::Prechecked { failures } if failures.is_empty() => {
            "every pose can be reached".to_owned()
        }
        OpResult::Prechecked { failures } => {
            let reasons: Vec<_> = failures.iter().map(|failure| &*failure.reason).collect();
            reasons.join("; ")
        }
        OpResult::NotExecuted { text } => format!("not executed{}", because(text)),
        OpResult::Rejected { text } => format!("refused{}", because(text)),
        OpResult::Interrupted { text } => format!("interrupted{}", because(text)),
        OpResult::InDoubt { text } => format!("in doubt{}", because(text)),
    }
}

/// The first word of a message's JSON: its kind.
fn message_word(message: &Message) -> String {
    tag(message, "kind")
}

fn answer_word(answer: &workflow::SignalAnswer) -> String {
    tag(answer, "answer")
}

fn tag<T: serde::Serialize>(value: &T, key: &str) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    let tag = value.get(key).and_then(serde_json::Value::as_str);
    tag.map_or_else(|| value.to_string(), str::to_owned)
}
