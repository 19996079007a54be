//! Control of a cell: taking it, keeping it alive, giving it back.

use std::time::Duration;

use api::{AcquireBody, ControlLease, ControlToken, ControlView, TransferBody};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use uuid::Uuid;

use crate::http::{Effect, Http};
use crate::{Client, ClientError};

/// The control authority of one cell. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Control {
    http: Http,
    cell: String,
}

impl Client {
    /// The control authority of a cell. Nothing is sent.
    #[must_use]
    pub fn control(&self, cell: &str) -> Control {
        Control {
            http: self.http.clone(),
            cell: cell.to_owned(),
        }
    }
}

impl Control {
    /// Who has control.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn show(&self) -> Result<ControlView, ClientError> {
        let path = self.path(&[]);
        self.http.get(&path, Effect::Question).json().await
    }

    /// Takes control. The lease ends after its `ttl_s` unless [`Control::heartbeat`] keeps it; [`Control::hold`] does
    /// that by itself.
    ///
    /// # Errors
    /// A problem `control-held` if somebody else has it; else as all calls.
    pub async fn acquire(&self, body: &AcquireBody) -> Result<ControlLease, ClientError> {
        let path = self.path(&[]);
        let exchange = self.http.post(&path, Effect::Question);
        exchange.body(body).json().await
    }

    /// Keeps a lease for another `ttl_s`.
    ///
    /// # Errors
    /// A problem `control-lost` if it is over; else as all calls.
    pub async fn heartbeat(&self, lease: Uuid) -> Result<ControlLease, ClientError> {
        let lease = lease.to_string();
        let path = self.path(&[&lease]);
        self.http.put(&path, Effect::Question).json().await
    }

    /// Gives control back; that the lease is over already is no error.
    ///
    /// # Errors
    /// A problem `control-held` if the lease is somebody else's; else as all calls.
    pub async fn release(&self, lease: Uuid) -> Result<ControlView, ClientError> {
        let lease = lease.to_string();
        let path = self.path(&[&lease]);
        self.http.delete(&path, Effect::Question).json().await
    }

    /// Hands control to another principal, who finds the new lease with [`Control::show`].
    ///
    /// # Errors
    /// A problem `control-lost` if the lease is over; else as all calls.
    pub async fn transfer(
        &self,
        lease: Uuid,
        body: &TransferBody,
    ) -> Result<ControlLease, ClientError> {
        let lease = lease.to_string();
        let path = self.path(&[&lease, "transfer"]);
        let exchange = self.http.post(&path, Effect::Question);
        exchange.body(body).json().await
    }

    /// Takes control and keeps it alive until it is given back or dropped. Dropped, it ends by itself after its
    /// `ttl_s`, with its loss behavior.
    ///
    /// # Errors
    /// As [`Control::acquire`].
    pub async fn hold(&self, body: &AcquireBody) -> Result<HeldControl, ClientError> {
        let lease = self.acquire(body).await?;
        let (lost, watch) = watch::channel(None);
        let every = Duration::from_secs(u64::from(lease.ttl_s)) / 3;
        let (control, id) = (self.clone(), lease.lease);
        let heart = tokio::spawn(async move {
            loop {
                tokio::time::sleep(every).await;
                // A problem is the server's decision; anything else may pass before the lease does.
                if let Err(error @ ClientError::Problem(_)) = control.heartbeat(id).await {
                    let _old = lost.send_replace(Some(error.to_string()));
                    return;
                }
            }
        });
        Ok(HeldControl {
            control: self.clone(),
            lease,
            heart,
            lost: watch,
        })
    }

    fn path<'a>(&'a self, rest: &[&'a str]) -> Vec<&'a str> {
        let mut path = vec!["api", "v1", "cells", &self.cell, "control-authority"];
        path.extend(rest);
        path
    }
}

/// Control that is being kept alive.
#[derive(Debug)]
pub struct HeldControl {
    control: Control,
    lease: ControlLease,
    heart: JoinHandle<()>,
    lost: watch::Receiver<Option<String>>,
}

impl HeldControl {
    /// The lease as it was granted.
    #[must_use]
    pub fn lease(&self) -> &ControlLease {
        &self.lease
    }

    /// What to send with everything that moves a robot: [`Client::with_control`].
    #[must_use]
    pub fn token(&self) -> ControlToken {
        self.lease.token
    }

    /// Waits until control is lost, and says how.
    pub async fn lost(&self) -> String {
        let mut lost = self.lost.clone();
        match lost.wait_for(Option::is_some).await {
            Ok(reason) => reason.clone().unwrap_or_default(),
            Err(_) => "nothing keeps it alive any more".to_owned(),
        }
    }

    /// Gives control back.
    ///
    /// # Errors
    /// As [`Control::release`].
    pub async fn release(self) -> Result<ControlView, ClientError> {
        self.heart.abort();
        self.control.release(self.lease.lease).await
    }
}

impl Drop for HeldControl {
    fn drop(&mut self) {
        self.heart.abort();
    }
}
