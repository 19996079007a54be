use std::time::Duration;

use serde_json::Value;

use crate::http::{Effect, Exchange, Http};
use crate::{Alarm, ClientError, EmulatorState, LedgerEntry, Log, Notes, Timeouts};

/// How something is changed through the control interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Do it.
    Post,
    /// Set it.
    Put,
    /// Set parts of it.
    Patch,
    /// Take it away.
    Delete,
}

/// The panel of a virtual controller: what the controller itself knows, and its control interface. Cheap to clone.
#[derive(Clone, Debug)]
pub struct EmulatorClient {
    http: Http,
}

impl EmulatorClient {
    /// A client of the panel at `panel_url`, e.g. `http://127.0.0.1:8081`. Nothing is sent yet.
    ///
    /// # Errors
    /// [`ClientError::BaseUrl`] if the address is not an `http://` one.
    pub fn new(panel_url: &str) -> Result<Self, ClientError> {
        Self::with_timeouts(panel_url, Timeouts::default())
    }

    /// Like [`EmulatorClient::new`], with time limits of the caller's choice.
    ///
    /// # Errors
    /// [`ClientError::BaseUrl`] if the address is not an `http://` one.
    pub fn with_timeouts(panel_url: &str, timeouts: Timeouts) -> Result<Self, ClientError> {
        Http::new(panel_url, timeouts).map(|http| Self { http })
    }

    /// The controller as it stands.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn state(&self) -> Result<EmulatorState, ClientError> {
        self.http.get(&["state"], Effect::Question).json().await
    }

    /// The motions the controller started, finished and refused; those after the entry `after` only, where it is given.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn ledger(&self, after: Option<u64>) -> Result<Log<LedgerEntry>, ClientError> {
        let exchange = self.http.get(&["ledger"], Effect::Question);
        match after {
            Some(after) => exchange.query(&[("after", after)]).json().await,
            None => exchange.json().await,
        }
    }

    /// The alarms the controller raised.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn alarms(&self) -> Result<Log<Alarm>, ClientError> {
        self.http.get(&["alarms"], Effect::Question).json().await
    }

    /// What a kind controller has said above the note `after`; where there is nothing yet, waits for it up to `wait`,
    /// which the panel bounds at 30 s.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn notes(&self, after: u64, wait: Option<Duration>) -> Result<Notes, ClientError> {
        let path = control(&["notes"]);
        let longer = wait.unwrap_or_default() + self.http.timeouts.question;
        let mut query = vec![("after", after.to_string())];
        query.extend(wait.map(|wait| ("wait_s", wait.as_secs_f64().to_string())));
        self.http
            .get(&path, Effect::LongQuestion(longer))
            .query(&query)
            .json()
            .await
    }

    /// Asks the control interface; `path` is what follows `/api/v1`. The answers are in its OpenAPI document.
    ///
    /// # Errors
    /// As all calls: see [`ClientError`].
    pub async fn ask(&self, path: &[&str], query: &[(&str, &str)]) -> Result<Value, ClientError> {
        let exchange = self.http.get(&control(path), Effect::Question);
        exchange.query(query).json().await
    }

    /// Changes something through the control interface: programs, variables, I/O, keys, time, faults. The answer is
    /// `null` where there is none.
    ///
    /// # Errors
    /// As all calls; [`ClientError::Refused`] names item, value and limit, and nothing has changed then.
    pub async fn change(
        &self,
        change: Change,
        path: &[&str],
        body: Option<&Value>,
    ) -> Result<Value, ClientError> {
        let path = control(path);
        let effect = Effect::Command(self.http.timeouts.command);
        let exchange: Exchange = match change {
            Change::Post => self.http.post(&path, effect),
            Change::Put => self.http.put(&path, effect),
            Change::Patch => self.http.patch(&path, effect),
            Change::Delete => self.http.delete(&path, effect),
        };
        let exchange = match body {
            Some(body) => exchange.body(body),
            None => exchange,
        };
        exchange.json_or_nothing().await
    }
}

fn control<'a>(path: &[&'a str]) -> Vec<&'a str> {
    [&["api", "v1"], path].concat()
}
