use std::time::Duration;

use api::{MobileRobotState, MobileRobotSummary, Outbox, OutboxQuery, SignalAnswer, SignalBody};

use crate::http::{Effect, Exchange, Http};
use crate::{Client, ClientError};

/// One mobile robot of one cell, from the robot's side and from an onlooker's. Cheap to clone.
#[derive(Clone, Debug)]
pub struct MobileRobotClient {
    http: Http,
    cell: String,
    id: String,
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
    /// A problem `handover-conflict` (409) if the signal is not legal now, `session-closed` (410) if its hand-over
    /// is over; else as all calls.
    pub async fn post_signal(&self, signal: &SignalBody) -> Result<SignalAnswer, ClientError> {
        let timeout = self.http.timeouts.question;
        self.http
            .post(&self.path(&["signals"]), Effect::Command(timeout))
            .body(signal)
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
