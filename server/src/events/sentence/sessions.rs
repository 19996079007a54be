//! Facts about hand-over sessions, in words.

use workflow::Fact;

use super::super::known::Known;
use super::{Said, said};
use crate::words::word;

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
pub(super) fn of_session(known: &Known, fact: &Fact) -> Option<Said> {
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
