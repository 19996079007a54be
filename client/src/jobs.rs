//! Jobs of the group workflows, hand-over sessions, loads, the cell as a whole.

use api::{
    CellState, CustodyBody, Job, JobBody, JobCommandBody, JobEventList, JobList, JobReport,
    JobSimulation, JobState, Load, LoadDetail, LoadList, Session, SessionList,
};
use uuid::Uuid;

use crate::http::{Effect, Http};
use crate::robot::KEY;
use crate::{Ask, Client, ClientError, Page};

/// The jobs of one cell, and what they work with. Cheap to clone.
///
/// Asking for a job moves nothing at once: it waits in the queue, and runs by itself.
#[derive(Clone, Debug)]
pub struct Jobs {
    http: Http,
    cell: String,
}

impl Client {
    /// The jobs of a cell. Nothing is sent.
    #[must_use]
    pub fn jobs(&self, cell: &str) -> Jobs {
        Jobs {
            http: self.http.clone(),
            cell: cell.to_owned(),
        }
    }
}

impl Jobs {
    /// The cell's id.
    #[must_use]
    pub fn cell(&self) -> &str {
        &self.cell
    }

    /// Asks for a job. The same body with the same key is answered with the same job, over restarts of the server too.
    ///
    /// # Errors
    /// A problem `validation` if an item does not fit the set-up, `queue-full`; else as all calls.
    pub async fn create(&self, body: &JobBody, ask: &Ask) -> Result<Job, ClientError> {
        let effect = Effect::Command(self.http.timeouts.command);
        self.http
            .post(&self.path(&["jobs"]), effect)
            .header(KEY, &ask.key())
            .body(body)
            .json()
            .await
    }

    /// Plays a whole job in virtual time, from where the cell is now. Nothing of the cell changes.
    ///
    /// It takes some seconds, at most about 30.
    ///
    /// # Errors
    /// A problem `validation` as [`Jobs::create`]; `simulator-busy` while another one runs; `simulator-missing`;
    /// `custody-unknown`; else as all calls.
    pub async fn simulate(&self, body: &JobBody) -> Result<JobSimulation, ClientError> {
        // It moves nothing, but is answered as late as a command may be.
        let effect = Effect::LongQuestion(self.http.timeouts.command);
        self.http
            .post(&self.path(&["jobs", "simulate"]), effect)
            .body(body)
            .json()
            .await
    }

    /// A page of jobs, the newest first; in these states only, where any are given.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn list(&self, states: &[JobState], page: &Page) -> Result<JobList, ClientError> {
        let states: Vec<_> = states.iter().map(|state| ("state", state)).collect();
        self.http
            .get(&self.path(&["jobs"]), Effect::Question)
            .query(&states)
            .query(page)
            .json()
            .await
    }

    /// One job.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such job; else as all calls.
    pub async fn get(&self, job: Uuid) -> Result<Job, ClientError> {
        self.question(&["jobs", &job.to_string()]).await
    }

    /// Steers a job. `stop` and `abort` may be sent as often as wanted; any other command is carried out once a key.
    ///
    /// # Errors
    /// A problem `wrong-job-state` if its state does not allow it; else as [`Jobs::get`].
    pub async fn command(
        &self,
        job: Uuid,
        body: &JobCommandBody,
        ask: &Ask,
    ) -> Result<Job, ClientError> {
        let effect = Effect::Command(self.http.timeouts.command);
        self.http
            .post(&self.path(&["jobs", &job.to_string(), "commands"]), effect)
            .header(KEY, &ask.key())
            .body(body)
            .json()
            .await
    }

    /// A page of what happened to a job, the oldest first.
    ///
    /// # Errors
    /// As [`Jobs::get`].
    pub async fn events(&self, job: Uuid, page: &Page) -> Result<JobEventList, ClientError> {
        self.http
            .get(
                &self.path(&["jobs", &job.to_string(), "events"]),
                Effect::Question,
            )
            .query(page)
            .json()
            .await
    }

    /// What a job took: phases, attempts, states, faults, decisions.
    ///
    /// # Errors
    /// As [`Jobs::get`].
    pub async fn report(&self, job: Uuid) -> Result<JobReport, ClientError> {
        self.question(&["jobs", &job.to_string(), "report"]).await
    }

    /// The hand-over sessions, open ones first.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn sessions(&self) -> Result<SessionList, ClientError> {
        self.question(&["sessions"]).await
    }

    /// One hand-over session.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such session; else as all calls.
    pub async fn session(&self, session: Uuid) -> Result<Session, ClientError> {
        self.question(&["sessions", &session.to_string()]).await
    }

    /// Where every load is.
    ///
    /// # Errors
    /// As [`Jobs::sessions`].
    pub async fn loads(&self) -> Result<LoadList, ClientError> {
        self.question(&["loads"]).await
    }

    /// Where a load is, and how it came there.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such load; else as all calls.
    pub async fn load(&self, load: &str) -> Result<LoadDetail, ClientError> {
        self.question(&["loads", load]).await
    }

    /// Says where a load is, after somebody has looked. Saying the same again changes nothing.
    ///
    /// # Errors
    /// A problem `custody-conflict` if it cannot be there; else as [`Jobs::load`].
    pub async fn set_custody(&self, load: &str, body: &CustodyBody) -> Result<Load, ClientError> {
        self.http
            .put(&self.path(&["loads", load, "custody"]), Effect::Question)
            .body(body)
            .json()
            .await
    }

    /// The cell as a whole, now.
    ///
    /// # Errors
    /// As [`Jobs::sessions`].
    pub async fn state(&self) -> Result<CellState, ClientError> {
        self.question(&["state"]).await
    }

    async fn question<T: serde::de::DeserializeOwned>(
        &self,
        rest: &[&str],
    ) -> Result<T, ClientError> {
        self.http
            .get(&self.path(rest), Effect::Question)
            .json()
            .await
    }

    fn path<'a>(&'a self, rest: &[&'a str]) -> Vec<&'a str> {
        let mut path = vec!["api", "v1", "cells", &self.cell];
        path.extend(rest);
        path
    }
}
