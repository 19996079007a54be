use crate::http::{Effect, Http};
use crate::{Alarm, ClientError, EmulatorState, LedgerEntry, Log, Timeouts};

/// The panel of a virtual controller: what the controller itself knows. Cheap to clone.
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
}
