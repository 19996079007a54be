//! Each fact of the state machines as a kind of event and a sentence.

mod jobs;
mod rest;
mod robots;
mod sessions;

use uuid::Uuid;
use workflow::Fact;

use super::known::Known;
use jobs::of_job;
use rest::of_rest;
use robots::of_robot;
use sessions::of_session;

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
