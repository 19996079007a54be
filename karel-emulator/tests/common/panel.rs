//! The control interface in tests.

use std::net::SocketAddr;

use karel_emulator::{ControlAccess, ControllerConfig};
use serde_json::Value;

use super::{Stepped, http};

/// Counts to a thousand, ten times a second, and has variables of several types.
pub(crate) const COUNTER: &str = "PROGRAM counter
TYPE
  cfg_t = STRUCTURE
    checked : BOOLEAN
    name : STRING[8]
  ENDSTRUCTURE
VAR
  n : INTEGER
  x : REAL
  cfg : cfg_t
  table : ARRAY[3] OF INTEGER
  p : XYZWPR
ROUTINE wait_a_bit
BEGIN
  DELAY 100
END wait_a_bit
BEGIN
  n = 0
  WHILE n < 1000 DO
    n = n + 1
    wait_a_bit
  ENDWHILE
END counter
";

/// The same, with its control interface on a free port.
pub(crate) fn controlled(mut config: ControllerConfig) -> ControllerConfig {
    config.panel = Some(([127, 0, 0, 1], 0).into());
    config.control = ControlAccess::Control;
    config
}

/// A controller, and its control interface.
pub(crate) struct Panel {
    pub(crate) cell: Stepped,
    pub(crate) address: SocketAddr,
}

impl Panel {
    pub(crate) fn start(config: ControllerConfig) -> Self {
        let cell = Stepped::start(&controlled(config));
        let address = cell.controller.panel_address().unwrap();
        Self { cell, address }
    }

    pub(crate) async fn get(&self, path: &str) -> (u16, Value) {
        http(self.address, "GET", path, None).await
    }

    pub(crate) async fn send(&self, method: &str, path: &str, body: Value) -> (u16, Value) {
        http(self.address, method, path, Some(&body)).await
    }

    pub(crate) async fn refused(
        &self,
        method: &str,
        path: &str,
        body: Value,
        status: u16,
        words: &[&str],
    ) {
        let (found, problem) = self.send(method, path, body).await;
        let detail = problem["detail"].as_str().unwrap_or_default();
        assert_eq!(found, status, "{path}: {detail}");
        for word in words {
            assert!(detail.contains(word), "{word:?} in {detail:?}");
        }
    }

    /// [`Self::refused`] for each row.
    pub(crate) async fn refused_each<const N: usize>(
        &self,
        rows: [(&str, &str, Value, u16, &[&str]); N],
    ) {
        for (method, path, body, status, words) in rows {
            self.refused(method, path, body, status, words).await;
        }
    }
}
