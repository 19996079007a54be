use std::time::Duration;

use api::{
    InstantActionAnswer, InstantActionBody, MobileRobotState, MobileRobotSummary, Outbox,
    OutboxQuery, ProblemCode, SignalAnswer, SignalBody,
};

use crate::http::{Effect, Exchange, Http};
use crate::robot::KEY;
use crate::{Ask, Client, ClientError};

/// One mobile robot of one cell, from the robot's side and from an onlooker's. Cheap to clone.
#[derive(Clone, Debug)]
pub struct MobileRobotClient {
    http: Http,
    cell: String,
    id: String,
}

/// The cell wants a number that the robot does not send: more than one signal before it is missing.
///
/// Its number was not used up. A robot that still has the missing signals sends them, from `expected`. One that has lost
/// them for ever sends an `MR_HEARTBEAT` with `resync`, under its next number, and then whatever still is to be said
/// under numbers of its own: a number that was given up is not acted on any more.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct SignalGap {
    /// The number the cell waits for.
    pub expected: u64,
}

impl SignalGap {
    /// The gap that an answer to a signal tells of, if it does.
    #[must_use]
    pub fn of(error: &ClientError) -> Option<Self> {
        let problem = error.problem()?;
        if problem.code != ProblemCode::HandoverConflict {
            return None;
        }
        let mut violations = problem.violations.iter();
        let found = violations.find(|violation| violation.item == "expected.seq")?;
        Some(Self {
            expected: found.message.parse().ok()?,
        })
    }
}

impl Client {
    /// One mobile robot of one cell. Nothing is sent: whether it exists is known at the first call.
    #[must_use]
    pub fn mobile_robot(&self, cell: &str, mobile_robot: &str) -> MobileRobotClient {
        MobileRobotClient {
            http: self.http.clone(),
            cell: cell.to_owned(),
            id: mobile_robot.to_owned(),
        }
    }

    /// The mobile robots of one cell.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn mobile_robots(&self, cell: &str) -> Result<Vec<MobileRobotSummary>, ClientError> {
        let path = ["api", "v1", "cells", cell, "mobile-robots"];
        self.http.get(&path, Effect::Question).json().await
    }
}

impl MobileRobotClient {
    /// The cell's id.
    #[must_use]
    pub fn cell(&self) -> &str {
        &self.cell
    }

    /// The robot's id.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// What the cell knows of the robot.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell or mobile robot; else as all calls.
    pub async fn state(&self) -> Result<MobileRobotState, ClientError> {
        self.get(&["state"]).json().await
    }

    /// Sends a signal. It may be sent again until it is answered: the cell knows it by its boot and number.
    ///
    /// Where a signal came before its predecessor the answer says `parked`, and the predecessor is still wanted.
    ///
    /// # Errors
    /// A problem `handover-conflict` (409) if the signal is not legal now (or [`SignalGap`]), `session-closed` (410) if its hand-over
    /// is over; else as all calls.
    pub async fn post_signal(&self, signal: &SignalBody) -> Result<SignalAnswer, ClientError> {
        let timeout = self.http.timeouts.question;
        self.http
            .post(&self.path(&["signals"]), Effect::Command(timeout))
            .body(signal)
            .json()
            .await
    }

    /// Has the robot do something at once. Asked again with the same key, nothing is done a second time.
    ///
    /// # Errors
    /// Problems `handover-conflict` (409) if it would interfere with a job, `interlock-violation` (409) if an arm may be
    /// in the way; else as all calls.
    pub async fn instant_action(
        &self,
        body: &InstantActionBody,
        ask: &Ask,
    ) -> Result<InstantActionAnswer, ClientError> {
        let timeout = self.http.timeouts.command;
        self.http
            .post(&self.path(&["instant-actions"]), Effect::Command(timeout))
            .header(KEY, &ask.key())
            .body(body)
            .json()
            .await
    }

    /// The messages after `query.after`, waiting up to `query.wait_s` for one. Acknowledges those up to `after`.
    ///
    /// # Errors
    /// As [`MobileRobotClient::state`]. The time limit of a question counts beyond the wait.
    pub async fn outbox(&self, query: OutboxQuery) -> Result<Outbox, ClientError> {
        let wait = Duration::from_secs(u64::from(query.wait_s));
        let timeout = self.http.timeouts.question.saturating_add(wait);
        self.get(&["outbox"])
            .within(timeout)
            .query(&query)
            .json()
            .await
    }

    fn get(&self, rest: &[&str]) -> Exchange {
        self.http.get(&self.path(rest), Effect::Question)
    }

    fn path<'a>(&'a self, rest: &[&'a str]) -> Vec<&'a str> {
        let mut path = vec!["api", "v1", "cells", &self.cell, "mobile-robots", &self.id];
        path.extend(rest);
        path
    }
}
