//! The control authority of a cell in the running server: the machine, its clock, its epochs, and who is told.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Duration;

use api::{ControlEnd, ControlLease, ControlToken, ControlView, LossBehavior, ProblemCode};
use journal::{Audit, AuditResult};
use tokio::sync::{Notify, watch};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::clock::LeaseClock;
use super::epochs::EpochStore;
use super::machine::{Authority, Denied, Ended, Force, Granted, Terms};
use super::said::{AcquireError, Refused};
use crate::identity::{AuditSink, NotRecorded};

/// How long the end of a lease may go unnoticed where nobody asks: a timer alone would sleep with the machine.
const WATCHFULNESS: Duration = Duration::from_millis(250);

/// The control authority of one cell.
#[derive(Debug)]
pub(crate) struct CellControl {
    pub(super) cell: String,
    machine: Mutex<Authority>,
    /// Held from asking for an epoch to granting with it, so that epochs are granted in their order.
    granting: tokio::sync::Mutex<()>,
    pub(super) clock: LeaseClock,
    epochs: Arc<dyn EpochStore>,
    audit: Arc<dyn AuditSink>,
    changed: Notify,
    news: watch::Sender<ControlNews>,
    observers: RwLock<Vec<Arc<dyn ControlObserver>>>,
}

/// What is published of each change. A reader that was slow sees the latest one; no loss is overlooked by comparing
/// `losses`.
#[derive(Clone, Debug, Default, Eq, PartialEq)]
pub struct ControlNews {
    /// Whether somebody holds control, and jobs therefore may not act.
    pub held: bool,
    /// The epoch of the latest lease.
    pub epoch: u64,
    /// How many leases were lost so far.
    pub losses: u64,
    /// The latest loss.
    pub last_loss: Option<ControlLoss>,
}

/// A lease that was lost, not given back.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct ControlLoss {
    /// The cell.
    pub cell: String,
    /// The epoch of the lost lease: what was ordered under it or before is meant.
    pub epoch: u64,
    /// Who lost it.
    pub holder: String,
    /// How.
    pub end: ControlEnd,
    /// What becomes of motions under way.
    pub behavior: LossBehavior,
}

/// Is told of lost control at once, so that robots can be stopped.
pub trait ControlObserver: fmt::Debug + Send + Sync + 'static {
    /// Called once for each loss. It must not wait for anything.
    fn control_lost(&self, loss: &ControlLoss);
}

impl CellControl {
    pub(crate) fn new(
        cell: &str,
        clock: LeaseClock,
        epochs: Arc<dyn EpochStore>,
        audit: Arc<dyn AuditSink>,
    ) -> Self {
        Self {
            cell: cell.to_owned(),
            machine: Mutex::default(),
            granting: tokio::sync::Mutex::default(),
            clock,
            epochs,
            audit,
            changed: Notify::new(),
            news: watch::channel(ControlNews::default()).0,
            observers: RwLock::default(),
        }
    }

    /// The cell's id.
    pub(crate) fn cell(&self) -> &str {
        &self.cell
    }

    /// Adds somebody who is told of each loss.
    pub(crate) fn observe(&self, observer: Arc<dyn ControlObserver>) {
        let observers = self.observers.write();
        observers
            .unwrap_or_else(PoisonError::into_inner)
            .push(observer);
    }

    /// What changes, as it changes.
    pub(crate) fn watch(&self) -> watch::Receiver<ControlNews> {
        self.news.subscribe()
    }

    /// Whether jobs may move the robots: while nobody else holds control.
    pub(crate) fn jobs_may_act(&self) -> bool {
        let now = self.clock.now();
        self.machine().held(now).is_none()
    }

    /// Who has control.
    pub(crate) fn view(&self) -> ControlView {
        let now = self.clock.now();
        self.expire();
        let machine = self.machine();
        let held = machine.held(now).map(|lease| self.lease_body(lease));
        ControlView {
            cell: self.cell.clone(),
            jobs_may_act: held.is_none(),
            held,
            epoch: machine.epoch(),
            last: machine.last().map(|ended| self.ended_body(ended)),
        }
    }

    /// Grants control, or says who has it.
    pub(crate) async fn acquire(
        &self,
        terms: Terms,
        force: Force,
    ) -> Result<ControlLease, AcquireError> {
        let _one_at_a_time = self.granting.lock().await;
        let asked = self.machine().may_acquire(self.clock.now(), &terms, force);
        asked.map_err(|denied| self.refused(denied))?;
        let token = self.next_token().await?;
        self.granted(|machine, now| machine.acquire(now, terms, force, token))
    }

    /// Lengthens a lease.
    pub(crate) fn heartbeat(&self, lease: Uuid, holder: &str) -> Result<ControlLease, Refused> {
        self.expire();
        let beaten = self.machine().heartbeat(self.clock.now(), lease, holder);
        let lease = beaten.map_err(|denied| self.refused(denied))?;
        Ok(self.lease_body(&lease))
    }

    /// Gives control back. That the lease is over already is no error.
    pub(crate) fn release(&self, lease: Uuid, holder: &str) -> Result<(), Refused> {
        self.expire();
        let released = self.machine().release(self.clock.now(), lease, holder);
        let ended = released.map_err(|denied| self.refused(denied))?;
        self.tell(ended.as_ref());
        Ok(())
    }

    /// Hands control to somebody else.
    pub(crate) async fn transfer(
        &self,
        lease: Uuid,
        holder: &str,
        to: &str,
        reason: &str,
    ) -> Result<ControlLease, AcquireError> {
        let _one_at_a_time = self.granting.lock().await;
        let token = self.next_token().await?;
        self.granted(|machine, now| machine.transfer(now, lease, holder, to, reason, token))
    }

    /// Whether the holder of a token may act now. The door calls this right before it journals an intent, and the
    /// link before the first byte.
    pub(crate) fn check(&self, token: ControlToken, holder: &str) -> Result<(), Refused> {
        let checked = self.machine().check(self.clock.now(), token, holder);
        checked.map_err(|denied| self.refused(denied))
    }

    /// Whether somebody without a lease may act now: while nobody holds one.
    pub(crate) fn check_free(&self) -> Result<(), Refused> {
        let checked = self.machine().is_free(self.clock.now());
        checked.map_err(|denied| self.refused(denied))
    }

    /// That a request names no lease, and what to do about it.
    pub(crate) fn required(&self, caller: &str) -> Refused {
        let now = self.clock.now();
        let held = self.machine().held(now).cloned();
        match held {
            Some(lease) if lease.terms.holder != caller => {
                self.refused(Denied::Held(Box::new(lease)))
            }
            Some(_) | None => Refused {
                code: ProblemCode::ControlRequired,
                detail: format!(
                    "whoever moves a robot holds control of its cell, and sends its `Control-Token`; \
                     POST /api/v1/cells/{}/control-authority takes it",
                    self.cell
                ),
                holder: None,
            },
        }
    }

    /// Ends a lease whose holder is not `known` any more.
    pub(crate) fn revoke_unless(&self, known: impl Fn(&str) -> bool) {
        let ended = {
            let now = self.clock.now();
            let mut machine = self.machine();
            let gone = machine
                .held(now)
                .is_some_and(|lease| !known(&lease.terms.holder));
            if gone { machine.revoke(now) } else { None }
        };
        if let Some(ended) = ended {
            self.tell(Some(&ended));
            self.changed.notify_one();
        }
    }

    /// Ends leases in time until `stop` is cancelled.
    pub(crate) async fn keep_time(self: Arc<Self>, stop: CancellationToken) {
        let keep = async {
            loop {
                let changed = self.changed.notified();
                self.expire();
                let deadline = self.machine().next_deadline();
                match deadline {
                    None => changed.await,
                    Some(deadline) => {
                        let left = deadline.saturating_sub(self.clock.now());
                        // A change is noticed at the next look; the end can only move away meanwhile.
                        tokio::time::sleep(left.min(WATCHFULNESS)).await;
                    }
                }
            }
        };
        let _stopped: Option<()> = stop.run_until_cancelled(keep).await;
    }

    fn machine(&self) -> MutexGuard<'_, Authority> {
        self.machine.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn next_token(&self) -> Result<ControlToken, NotRecorded> {
        let epoch = self.epochs.next(&self.cell).await?;
        Ok(ControlToken {
            lease: Uuid::now_v7(),
            epoch,
        })
    }

    fn granted(
        &self,
        grant: impl FnOnce(&mut Authority, Duration) -> Result<Granted, Denied>,
    ) -> Result<ControlLease, AcquireError> {
        self.expire();
        let granted = grant(&mut self.machine(), self.clock.now());
        let granted = granted.map_err(|denied| self.refused(denied))?;
        self.tell(granted.ended.as_ref());
        self.changed.notify_one();
        Ok(self.lease_body(&granted.lease))
    }

    /// Ends the lease whose time is over, and tells of it.
    fn expire(&self) {
        let ended = self.machine().expire(self.clock.now());
        if let Some(ended) = ended {
            self.tell(Some(&ended));
            self.changed.notify_one();
        }
    }

    /// Publishes the state, and the loss where there was one.
    fn tell(&self, ended: Option<&Ended>) {
        let loss = ended.and_then(|ended| {
            Some(ControlLoss {
                cell: self.cell.clone(),
                epoch: ended.lease.token.epoch,
                holder: ended.lease.terms.holder.clone(),
                end: ended.end,
                behavior: ended.loss()?,
            })
        });
        let now = self.clock.now();
        {
            // Published under the lock, so that the latest news is of the latest state.
            let machine = self.machine();
            self.news.send_modify(|news| {
                news.held = machine.held(now).is_some();
                news.epoch = machine.epoch();
                if let Some(loss) = &loss {
                    news.losses += 1;
                    news.last_loss = Some(loss.clone());
                }
            });
        }
        let Some(loss) = loss else {
            return;
        };
        tracing::warn!(
            cell.id = self.cell,
            holder = loss.holder,
            epoch = loss.epoch,
            end = ?loss.end,
            behavior = ?loss.behavior,
            by = ended.and_then(|ended| ended.by.as_deref()),
            "control of the cell was lost"
        );
        self.note_loss(&loss, ended.and_then(|ended| ended.by.as_deref()));
        let observers = self.observers.read();
        for observer in observers.unwrap_or_else(PoisonError::into_inner).iter() {
            observer.control_lost(&loss);
        }
    }

    /// Whose control was lost, and how: a person did not ask for it, so it has an entry of its own.
    fn note_loss(&self, loss: &ControlLoss, by: Option<&str>) {
        let action = match loss.end {
            ControlEnd::Revoked => "control.revoked",
            ControlEnd::Preempted => "control.preempted",
            ControlEnd::Expired | ControlEnd::Released | ControlEnd::Transferred => {
                "control.expired"
            }
        };
        self.audit.note(Audit {
            principal: loss.holder.clone(),
            action: action.to_owned(),
            object: self.cell.clone(),
            result: AuditResult::Done,
            request_id: None,
            cell: Some(self.cell.clone()),
            role: None,
            source: None,
            lease: Some(loss.epoch),
            before: None,
            after: by.map(|by| format!("by {by}")),
        });
    }
}
