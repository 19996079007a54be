use api::{
    CellSummary, ControlToken, Intervention, InterventionList, LegacyVersion, Liveness, Readiness,
    RespondBody, RobotSummary, TokenSecret,
};
use reqwest::StatusCode;
use uuid::Uuid;

use crate::http::{Effect, Exchange, Http};
use crate::robot::KEY;
use crate::{Arms, Ask, CellSetup, ClientError, Robot, Timeouts};

/// The server's HTTP API. Cheap to clone.
///
/// Each call sends an `X-Request-Id`, a fresh one unless [`Client::with_request_id`] set it; the server logs it,
/// writes it into motions and problems, and hands it to the virtual controller's ledger. An answer that carries the id
/// of another request is not believed.
#[derive(Clone, Debug)]
pub struct Client {
    pub(crate) http: Http,
}

impl Client {
    /// A client of the server at `base_url`, e.g. `http://127.0.0.1:8080`, with the default [`Timeouts`].
    ///
    /// Nothing is sent yet.
    ///
    /// # Errors
    /// [`ClientError::BaseUrl`] if the address is not an `http://` one.
    pub fn new(base_url: &str) -> Result<Self, ClientError> {
        Self::with_timeouts(base_url, Timeouts::default())
    }

    /// Like [`Client::new`], with time limits of the caller's choice.
    ///
    /// # Errors
    /// [`ClientError::BaseUrl`] if the address is not an `http://` one.
    pub fn with_timeouts(base_url: &str, timeouts: Timeouts) -> Result<Self, ClientError> {
        Http::new(base_url, timeouts).map(|http| Self { http })
    }

    /// This client, with every request named `request_id`, so that a caller's own id runs through all logs.
    ///
    /// # Errors
    /// [`ClientError::RequestId`] if it is not 1 to 64 of `[A-Za-z0-9._-]`: the server takes no other.
    pub fn with_request_id(&self, request_id: &str) -> Result<Self, ClientError> {
        let http = self.http.with_request_id(request_id)?;
        Ok(Self { http })
    }

    /// This client, with a token of the server. It goes in a header of each request and never into a log or an error.
    ///
    /// # Errors
    /// [`ClientError::Token`] if no token of such a server looks like it.
    pub fn with_token(&self, token: &TokenSecret) -> Result<Self, ClientError> {
        let http = self.http.with_token(token)?;
        Ok(Self { http })
    }

    /// This client, moving robots on behalf of a lease of control.
    #[must_use]
    pub fn with_control(&self, token: ControlToken) -> Self {
        let http = self.http.with_control(token);
        Self { http }
    }

    /// One robot of one cell. Nothing is sent: whether it exists is known at the first call.
    #[must_use]
    pub fn robot(&self, cell: &str, robot: &str) -> Robot {
        Robot::new(self.http.clone(), cell, robot)
    }

    /// The operator's set-up of one cell. Nothing is sent.
    #[must_use]
    pub fn setup(&self, cell: &str) -> CellSetup {
        CellSetup::new(self.http.clone(), cell)
    }

    /// Questions about arm models and paths. Nothing is sent.
    #[must_use]
    pub fn arms(&self) -> Arms {
        Arms::new(self.http.clone())
    }

    /// Every cell with its robots.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn cells(&self) -> Result<Vec<CellSummary>, ClientError> {
        self.question(&["api", "v1", "cells"]).json().await
    }

    /// One cell with its robots.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn cell(&self, cell: &str) -> Result<CellSummary, ClientError> {
        self.question(&["api", "v1", "cells", cell]).json().await
    }

    /// The robots of one cell.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn robots(&self, cell: &str) -> Result<Vec<RobotSummary>, ClientError> {
        self.question(&["api", "v1", "cells", cell, "robots"])
            .json()
            .await
    }

    /// What waits for a person's answer in a cell.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn interventions(&self, cell: &str) -> Result<InterventionList, ClientError> {
        self.question(&["api", "v1", "cells", cell, "interventions"])
            .json()
            .await
    }

    /// Answers what waits for a person, once and for good. The same answer with the same key is taken once.
    ///
    /// # Errors
    /// A problem `already-answered` if somebody gave another answer; else as all calls.
    pub async fn respond(
        &self,
        cell: &str,
        id: Uuid,
        body: &RespondBody,
        ask: &Ask,
    ) -> Result<Intervention, ClientError> {
        let id = id.to_string();
        let path = ["api", "v1", "cells", cell, "interventions", &id, "respond"];
        self.http
            .post(&path, Effect::Command(self.http.timeouts.command))
            .header(KEY, &ask.key())
            .body(body)
            .json()
            .await
    }

    /// The server's version.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn version(&self) -> Result<LegacyVersion, ClientError> {
        self.question(&["version"]).json().await
    }

    /// Asks whether the server's process answers.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn livez(&self) -> Result<Liveness, ClientError> {
        self.question(&["livez"]).json().await
    }

    /// Asks whether the server takes commands. A server that says no is an answer, not an error.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn readyz(&self) -> Result<Readiness, ClientError> {
        self.question(&["readyz"])
            .json_even_at(StatusCode::SERVICE_UNAVAILABLE)
            .await
    }

    /// The server's metrics in the Prometheus text format.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn metrics(&self) -> Result<String, ClientError> {
        self.question(&["metrics"]).text().await
    }

    fn question(&self, path: &[&str]) -> Exchange {
        self.http.get(path, Effect::Question)
    }
}
