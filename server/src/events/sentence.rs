//! Each fact of the state machines as a kind of event and a sentence.

use uuid::Uuid;
use workflow::{Fact, Message, SignalAnswer};

use super::known::Known;
use crate::words::{because, word};

/// What a fact is as an event.
pub(super) struct Said {
    pub(super) kind: &'static str,
    pub(super) text: String,
    pub(super) job: Option<Uuid>,
    pub(super) subject: Option<String>,
}

fn said(kind: &'static str, job: Option<Uuid>, text: String) -> Said {
    Said {
        kind,
        text,
        job,
        subject: job.map(|job| format!("jobs/{job}")),
    }
}

/// The event a fact is; none for what only the state machines need, and for what is not kept.
pub(super) fn of_fact(known: &Known, fact: &Fact) -> Option<Said> {
    of_job(known, fact)
        .or_else(|| of_session(known, fact))
        .or_else(|| of_robot(known, fact))
        .or_else(|| of_rest(known, fact))
}

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
#[expect(
    clippy::too_many_lines,
    reason = "one arm for each fact, most of them one line"
)]
fn of_job(known: &Known, fact: &Fact) -> Option<Said> {
    let (kind, job, text) = match fact {
        Fact::JobCreated { job, spec, .. } => (
            "robocell.job.created",
            job,
            format!(
                "a job was created: {} at {}",
                word(&spec.workflow),
                spec.point
            ),
        ),
        Fact::JobAssigned {
            job,
            arm,
            mobile_robot,
        } => (
            "robocell.job.assigned",
            job,
            format!("the job has {arm} and {mobile_robot}"),
        ),
        Fact::JobMoved { job, to, text, .. } => (
            "robocell.job.state",
            job,
            format!("the job is {}{}", word(to), because(text)),
        ),
        Fact::FaultNoted { job, fault, text } => (
            "robocell.job.fault",
            job,
            format!("{} {}{}", fault.code(), word(fault), because(text)),
        ),
        Fact::Planned { job, steps, .. } => (
            "robocell.job.planned",
            job,
            format!("{} steps were planned", steps.len()),
        ),
        Fact::StepMoved {
            job,
            step,
            to,
            attempt,
            text,
        } => (
            "robocell.step.state",
            job,
            match attempt {
                0 | 1 => format!(
                    "{} is {}{}",
                    known.step(job, *step),
                    word(to),
                    because(text)
                ),
                _ => format!(
                    "{} is {} (attempt {attempt}){}",
                    known.step(job, *step),
                    word(to),
                    because(text)
                ),
            },
        ),
        Fact::StepRedirected { job, step, place } => (
            "robocell.step.redirected",
            job,
            format!("{} goes to {place}", known.step(job, *step)),
        ),
        Fact::StepResent { job, step } => (
            "robocell.step.resent",
            job,
            format!(
                "{} is tried or waited for once more",
                known.step(job, *step)
            ),
        ),
        Fact::CompensationMoved { job, to } => (
            "robocell.job.compensation",
            job,
            format!("undoing is {}", word(to)),
        ),
        Fact::LoadsAccepted { job } => (
            "robocell.job.loads-accepted",
            job,
            "a person accepted the loads as they are".to_owned(),
        ),
        Fact::Redispatched { job } => (
            "robocell.job.redispatched",
            job,
            "the mobile robot is called anew".to_owned(),
        ),
        Fact::ArmByHand { job, displaced } => (
            "robocell.job.arm-by-hand",
            job,
            if *displaced {
                "the arm was moved by hand".to_owned()
            } else {
                "the pendant was enabled, or the mode changed".to_owned()
            },
        ),
        Fact::ArmByHandDecided { job } => (
            "robocell.job.arm-by-hand-decided",
            job,
            "a person said how the arm goes on".to_owned(),
        ),
        Fact::OpStarted {
            job,
            step,
            arm,
            action,
            ..
        } => (
            "robocell.operation.started",
            job,
            format!(
                "{arm} begins {}: {}",
                known.step(job, *step),
                crate::words::action(action)
            ),
        ),
        _ => return None,
    };
    Some(said(kind, Some(*job), text))
}

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
fn of_session(known: &Known, fact: &Fact) -> Option<Said> {
    let (kind, session, text) = match fact {
        Fact::SessionOpened {
            session,
            point,
            mobile_robot,
            ..
        } => (
            "robocell.session.opened",
            session,
            format!("a hand-over with {mobile_robot} at {point} is reserved"),
        ),
        Fact::SessionHandedOn {
            session,
            mobile_robot,
        } => (
            "robocell.session.handed-on",
            session,
            format!("{mobile_robot} comes instead"),
        ),
        Fact::SessionMoved { session, to, fault } => {
            let at = known.session(session).map_or("?", |session| &session.point);
            let fault = fault.map(|fault| format!(": {} {}", fault.code(), word(&fault)));
            let text = format!(
                "the hand-over at {at} is {}{}",
                word(to),
                fault.unwrap_or_default()
            );
            ("robocell.session.state", session, text)
        }
        Fact::SessionOrdered {
            session,
            order,
            update,
        } => (
            "robocell.session.ordered",
            session,
            format!("order {order}, update {update}"),
        ),
        Fact::SessionResent { session } => (
            "robocell.session.resent",
            session,
            "the last request of the hand-over is sent again".to_owned(),
        ),
        Fact::SessionRewound { session, to } => (
            "robocell.session.rewound",
            session,
            format!("the hand-over goes back: {}", word(to)),
        ),
        Fact::MeasuredAccepted { session } => (
            "robocell.session.measured-accepted",
            session,
            "the measured dock pose was accepted".to_owned(),
        ),
        Fact::SessionLeft { session } => (
            "robocell.session.left",
            session,
            "the mobile robot drives out".to_owned(),
        ),
        _ => return None,
    };
    let job = known.session(session).map(|session| session.job);
    let mut said = said(kind, job, text);
    said.subject = Some(format!("sessions/{session}"));
    Some(said)
}

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
fn of_robot(known: &Known, fact: &Fact) -> Option<Said> {
    let of_session = |session: &Option<Uuid>| {
        let session = known.session(session.as_ref()?)?;
        Some(session.job)
    };
    let (kind, robot, job, text) = match fact {
        Fact::Told {
            mobile_robot,
            session,
            message,
        } => (
            "robocell.mobile-robot.told",
            mobile_robot,
            of_session(session),
            format!("{mobile_robot} is told: {}", message_in_words(message)),
        ),
        Fact::OutboxTaken { mobile_robot, n } => (
            "robocell.mobile-robot.fetched",
            mobile_robot,
            None,
            format!("{mobile_robot} has its messages up to {n}"),
        ),
        Fact::Signaled { signal, answer } => {
            let answer = match answer {
                SignalAnswer::Accepted { .. } => String::new(),
                SignalAnswer::Parked => ", too early: parked".to_owned(),
                SignalAnswer::Conflict { expected, got, .. } => {
                    format!(", not acted on: expected {expected}, got {got}")
                }
                SignalAnswer::Gap { expected, .. } => {
                    format!(", not taken: number {expected} is missing")
                }
                SignalAnswer::Late { .. } => ", too late: it was given up as lost".to_owned(),
                SignalAnswer::Closed { .. } => ", too late: its hand-over is over".to_owned(),
            };
            (
                "robocell.mobile-robot.signal",
                &signal.mobile_robot,
                of_session(&signal.session),
                format!(
                    "{} says {}{answer}",
                    signal.mobile_robot,
                    word(&signal.kind)
                ),
            )
        }
        Fact::TransportBegun {
            mobile_robot,
            job,
            destination,
            ..
        } => (
            "robocell.mobile-robot.transport-begun",
            mobile_robot,
            Some(*job),
            format!("{mobile_robot} takes its loads to {destination}"),
        ),
        Fact::TransportEnded { mobile_robot } => (
            "robocell.mobile-robot.transport-ended",
            mobile_robot,
            None,
            format!("the transport of {mobile_robot} is over"),
        ),
        _ => return of_robot_itself(fact),
    };
    let mut said = said(kind, job, text);
    said.subject = Some(format!("mobile-robots/{robot}"));
    Some(said)
}

/// What a mobile robot lost, what it did not start, and what a person had it do.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
fn of_robot_itself(fact: &Fact) -> Option<Said> {
    let (kind, robot, text) = match fact {
        Fact::SignalsLost {
            mobile_robot,
            from,
            to,
            ..
        } => (
            "robocell.mobile-robot.signals-lost",
            mobile_robot,
            format!("the signals {from} to {to} of {mobile_robot} are lost"),
        ),
        Fact::TriggerSkipped {
            trigger,
            mobile_robot,
            text,
            ..
        } => (
            "robocell.mobile-robot.trigger-skipped",
            mobile_robot,
            format!("trigger {trigger} starts no job for {mobile_robot}: {text}"),
        ),
        Fact::InstantActed {
            mobile_robot,
            action,
            principal,
            reason,
        } => (
            "robocell.mobile-robot.instant-action",
            mobile_robot,
            format!(
                "{principal} has {mobile_robot} told: {}{}",
                instant_in_words(*action),
                because(reason.as_deref().unwrap_or_default())
            ),
        ),
        _ => return None,
    };
    let mut said = said(kind, None, text);
    said.subject = Some(format!("mobile-robots/{robot}"));
    Some(said)
}

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
fn of_rest(known: &Known, fact: &Fact) -> Option<Said> {
    Some(match fact {
        Fact::Recovered => said(
            "robocell.cell.recovered",
            None,
            "the cell was started; no permit is granted".to_owned(),
        ),
        Fact::SetupChanged { .. } => said(
            "robocell.cell.setup",
            None,
            "the workflows have a new set-up".to_owned(),
        ),
        Fact::OpDoubted { op, text } => said(
            "robocell.operation.in-doubt",
            known.job_of(op),
            format!("nobody knows what became of an operation{}", because(text)),
        ),
        Fact::OpReconciling { op } => said(
            "robocell.operation.reconciling",
            known.job_of(op),
            "the truth about an operation is being read".to_owned(),
        ),
        Fact::OpEnded { op, result } => said(
            "robocell.operation.ended",
            known.job_of(op),
            format!("the operation ended: {}", result_in_words(result)),
        ),
        Fact::LoadRegistered {
            load,
            kind,
            location,
        } => {
            let mut said = said(
                "robocell.load.registered",
                None,
                format!("load {load} of type {kind} is known now, at {location}"),
            );
            said.subject = Some(format!("loads/{load}"));
            said
        }
        Fact::CustodyMoved { load, to, by } => {
            let job = match by {
                workflow::Evidence::Gripper { op } => known.job_of(op),
                workflow::Evidence::Doubt { .. }
                | workflow::Evidence::MobileRobot { .. }
                | workflow::Evidence::Human { .. } => None,
            };
            let mut said = said(
                "robocell.load.moved",
                job,
                format!("load {load} is at {to}"),
            );
            said.subject = Some(format!("loads/{load}"));
            said
        }
        Fact::Asked { question } => {
            let job = question.job;
            let text = format!("{} {}", question.fault.code(), question.question);
            about_question("robocell.intervention.asked", job, question.id, text)
        }
        Fact::Answered {
            intervention,
            decided,
        } => about_question(
            "robocell.intervention.answered",
            known.job_of(intervention),
            *intervention,
            format!(
                "{} answered {}, because \"{}\"",
                decided.principal,
                word(&decided.answer),
                decided.reason
            ),
        ),
        Fact::Withdrawn { intervention, text } => about_question(
            "robocell.intervention.withdrawn",
            known.job_of(intervention),
            *intervention,
            format!("the question is no longer asked{}", because(text)),
        ),
        _ => return None,
    })
}

fn about_question(kind: &'static str, job: Option<Uuid>, id: Uuid, text: String) -> Said {
    let mut said = said(kind, job, text);
    said.subject = Some(format!("interventions/{id}"));
    said
}

fn message_in_words(message: &Message) -> String {
    match message {
        Message::TransportOrder {
            goal,
            update,
            then_to,
            ..
        } => {
            let then = then_to.as_ref().map(|to| format!(", later to {to}"));
            format!(
                "TRANSPORT_ORDER to {goal}, update {update}{}",
                then.unwrap_or_default()
            )
        }
        Message::MovePermit { granted: true } => "MOVE_PERMIT granted".to_owned(),
        Message::MovePermit { granted: false } => "MOVE_PERMIT withdrawn".to_owned(),
        Message::CellReady => "CELL_READY".to_owned(),
        Message::TransferDone => "TRANSFER_DONE".to_owned(),
        Message::TransferFailed { reason } => format!("TRANSFER_FAILED{}", because(reason)),
        Message::ExitGranted => "EXIT_GRANTED".to_owned(),
        Message::CancelOrder { .. } => "CANCEL_ORDER".to_owned(),
        Message::StartPause => "START_PAUSE".to_owned(),
        Message::StopPause => "STOP_PAUSE".to_owned(),
        Message::Retry => "RETRY".to_owned(),
        Message::SkipRetry => "SKIP_RETRY".to_owned(),
        Message::StateRequest => "STATE_REQUEST".to_owned(),
    }
}

fn instant_in_words(action: workflow::InstantAction) -> &'static str {
    use workflow::InstantAction as Action;
    match action {
        Action::StartPause => "START_PAUSE",
        Action::StopPause => "STOP_PAUSE",
        Action::CancelOrder { .. } => "CANCEL_ORDER",
        Action::Retry => "RETRY",
        Action::SkipRetry => "SKIP_RETRY",
        Action::StateRequest => "STATE_REQUEST",
    }
}

fn result_in_words(result: &workflow::OpResult) -> String {
    use workflow::OpResult;
    match result {
        OpResult::Arrived => "arrived".to_owned(),
        OpResult::Gripped {
            closed,
            open,
            part_present,
        } => {
            let fingers = match (closed, open) {
                (true, false) => "closed",
                (false, true) => "open",
                (false, false) | (true, true) => "between",
            };
            let part = if *part_present { "a part" } else { "no part" };
            format!("the gripper is {fingers}, with {part}")
        }
        OpResult::Prechecked { failures } => match failures.first() {
            None => "every pose can be reached".to_owned(),
            Some(first) => format!(
                "{} poses cannot be reached: {}",
                failures.len(),
                first.reason
            ),
        },
        OpResult::NotExecuted { text } => format!("not executed{}", because(text)),
        OpResult::Rejected { text } => format!("rejected{}", because(text)),
        OpResult::Interrupted { text } => format!("interrupted{}", because(text)),
        OpResult::InDoubt { text } => format!("in doubt{}", because(text)),
    }
}
