//! The thesis's own routes. They speak to the one robot the server gives to them, and know neither cells nor motions.

use api::{LegacyDelta, LegacyMoved, LegacyPoint};

use crate::http::{Effect, Exchange};
use crate::{Client, ClientError};

impl Client {
    /// Moves to an absolute point at `velocity` mm/s, or at the server's default where `None`.
    ///
    /// # Errors
    /// [`ClientError::Refused`] if the controller or the server says no, [`ClientError::Invalid`] if a number does not
    /// fit; else as all calls.
    pub async fn legacy_move(
        &self,
        point: &LegacyPoint,
        velocity: Option<u16>,
    ) -> Result<LegacyMoved, ClientError> {
        self.command("move", velocity).body(point).json().await
    }

    /// Moves to the home point.
    ///
    /// # Errors
    /// As [`Client::legacy_move`].
    pub async fn legacy_home(&self, velocity: Option<u16>) -> Result<LegacyMoved, ClientError> {
        self.command("home", velocity).json().await
    }

    /// Moves by a change to the last accepted point.
    ///
    /// # Errors
    /// As [`Client::legacy_move`].
    pub async fn legacy_delta(
        &self,
        delta: &LegacyDelta,
        velocity: Option<u16>,
    ) -> Result<LegacyMoved, ClientError> {
        self.command("delta", velocity).body(delta).json().await
    }

    fn command(&self, name: &str, velocity: Option<u16>) -> Exchange {
        let effect = Effect::Command(self.http.timeouts.command);
        let exchange = self.http.post(&["fanuc", name], effect);
        match velocity {
            Some(velocity) => exchange.query(&[("velocity", velocity)]),
            None => exchange,
        }
    }
}
