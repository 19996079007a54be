//! Facts about arms and mobile robots, in words.

use uuid::Uuid;
use workflow::{Fact, Message, SignalAnswer};

use super::super::known::Known;
use super::{Said, said};
use crate::words::{because, word};

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
pub(super) fn of_robot(known: &Known, fact: &Fact) -> Option<Said> {
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
pub(super) fn of_robot_itself(fact: &Fact) -> Option<Said> {
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

pub(super) fn instant_in_words(action: workflow::InstantAction) -> &'static str {
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
