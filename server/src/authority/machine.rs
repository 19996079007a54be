//! Control authority as a pure state machine: who may move the robots of one cell. No clock, no I/O.
//!
//! ```text
//! FREE ── acquire ──▶ HELD ── heartbeat ──▶ HELD
//!   ▲                  │
//!   └── released, expired, revoked          preempted by LOCAL or an admin, transferred: ──▶ HELD by the next
//! ```
//!
//! A lease has an epoch, greater than that of every lease before. Time is monotonic and given by the caller; the
//! machine never goes back behind a time it has seen, and a heartbeat that comes at the end or later is too late.

use std::time::Duration;

use api::{ControlEnd, ControlToken, LossBehavior, Station};
use uuid::Uuid;

/// A monotonic time that goes on while the machine sleeps.
pub(crate) type Moment = Duration;

/// Who may move the robots of one cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Authority {
    lease: Option<Lease>,
    last: Option<Ended>,
    /// The epoch of the latest lease.
    epoch: u64,
    /// The latest time seen.
    seen: Moment,
}

/// Control that somebody holds.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct Lease {
    pub(crate) token: ControlToken,
    pub(crate) terms: Terms,
    pub(crate) since: Moment,
    /// Over at this time, not after it.
    pub(crate) expires: Moment,
}

/// What somebody asks for.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct Terms {
    pub(crate) holder: String,
    pub(crate) station: Station,
    pub(crate) ttl: Duration,
    pub(crate) loss: LossBehavior,
    pub(crate) reason: String,
}

/// Whether a request may take control from somebody.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Force {
    /// Only `LOCAL` takes.
    ByStation,
    /// An admin takes.
    Admin,
}

/// A lease that is over.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct Ended {
    pub(crate) lease: Lease,
    pub(crate) end: ControlEnd,
    pub(crate) at: Moment,
    pub(crate) by: Option<String>,
    pub(crate) reason: Option<String>,
}

/// A lease that has just begun, and the one it ended.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct Granted {
    pub(crate) lease: Lease,
    pub(crate) ended: Option<Ended>,
}

/// Why somebody may not act.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) enum Denied {
    /// Somebody else holds control.
    Held(Box<Lease>),
    /// The lease is over, and how, where that is still known.
    Lost(Option<Box<Ended>>),
    /// The epoch was given before: a defect of what keeps the epochs, and nobody may act on it.
    StaleEpoch { given: u64, latest: u64 },
}

impl Ended {
    /// What becomes of motions under way; `None` where the lease ended by its holder's will, and they go on.
    pub(crate) fn loss(&self) -> Option<LossBehavior> {
        match self.end {
            ControlEnd::Released | ControlEnd::Transferred => None,
            ControlEnd::Expired | ControlEnd::Preempted | ControlEnd::Revoked => {
                Some(self.lease.terms.loss)
            }
        }
    }
}

impl Authority {
    /// Ends the lease whose time is over. Every other call does this first in effect: nothing counts on being told.
    pub(crate) fn expire(&mut self, now: Moment) -> Option<Ended> {
        let now = self.see(now);
        let over = self
            .lease
            .as_ref()
            .is_some_and(|lease| now >= lease.expires);
        if over {
            self.end(now, ControlEnd::Expired, None, None)
        } else {
            None
        }
    }

    /// The lease that holds at `now`.
    pub(crate) fn held(&self, now: Moment) -> Option<&Lease> {
        let now = now.max(self.seen);
        self.lease.as_ref().filter(|lease| now < lease.expires)
    }

    /// How the lease before the present one ended.
    pub(crate) fn last(&self) -> Option<&Ended> {
        self.last.as_ref()
    }

    /// The epoch of the latest lease, 0 before the first.
    pub(crate) fn epoch(&self) -> u64 {
        self.epoch
    }

    /// When something happens by itself.
    pub(crate) fn next_deadline(&self) -> Option<Moment> {
        self.lease.as_ref().map(|lease| lease.expires)
    }

    /// Whether a request would be granted now.
    pub(crate) fn may_acquire(
        &self,
        now: Moment,
        terms: &Terms,
        force: Force,
    ) -> Result<(), Denied> {
        let takes = terms.station == Station::Local || force == Force::Admin;
        match self.held(now) {
            Some(lease) if !takes => Err(Denied::Held(Box::new(lease.clone()))),
            Some(_) | None => Ok(()),
        }
    }

    /// Grants control, or says who has it. `epoch` is greater than every one before.
    pub(crate) fn acquire(
        &mut self,
        now: Moment,
        terms: Terms,
        force: Force,
        token: ControlToken,
    ) -> Result<Granted, Denied> {
        self.may_acquire(now, &terms, force)?;
        self.check_epoch(token)?;
        let expired = self.expire(now);
        let (by, reason) = (Some(terms.holder.clone()), Some(terms.reason.clone()));
        let preempted = self.end(now, ControlEnd::Preempted, by, reason);
        let lease = self.begin(now, terms, token);
        Ok(Granted {
            lease,
            ended: preempted.or(expired),
        })
    }

    /// Lengthens the lease from now on.
    pub(crate) fn heartbeat(
        &mut self,
        now: Moment,
        lease: Uuid,
        holder: &str,
    ) -> Result<Lease, Denied> {
        let now = self.see(now);
        let known = self.own(now, lease, holder)?;
        known.expires = now + known.terms.ttl;
        Ok(known.clone())
    }

    /// Gives control back. A lease that is over already is given back all the same.
    pub(crate) fn release(
        &mut self,
        now: Moment,
        lease: Uuid,
        holder: &str,
    ) -> Result<Option<Ended>, Denied> {
        let now = self.see(now);
        match self.own(now, lease, holder) {
            Ok(_) => Ok(self.end(now, ControlEnd::Released, None, None)),
            Err(Denied::Lost(_)) => Ok(None),
            Err(denied @ (Denied::Held(_) | Denied::StaleEpoch { .. })) => Err(denied),
        }
    }

    /// Hands control to somebody else, under a new lease with the terms of the old one. The next holder is `REMOTE`:
    /// where it stands is not known.
    pub(crate) fn transfer(
        &mut self,
        now: Moment,
        lease: Uuid,
        holder: &str,
        to: &str,
        reason: &str,
        token: ControlToken,
    ) -> Result<Granted, Denied> {
        let now = self.see(now);
        let terms = Terms {
            holder: to.to_owned(),
            station: Station::Remote,
            reason: reason.to_owned(),
            ..self.own(now, lease, holder)?.terms.clone()
        };
        self.check_epoch(token)?;
        let (by, why) = (Some(holder.to_owned()), Some(reason.to_owned()));
        let ended = self.end(now, ControlEnd::Transferred, by, why);
        let lease = self.begin(now, terms, token);
        Ok(Granted { lease, ended })
    }

    /// Ends the lease of somebody who may not act at all any more.
    pub(crate) fn revoke(&mut self, now: Moment) -> Option<Ended> {
        let expired = self.expire(now);
        let now = self.seen;
        expired.or_else(|| self.end(now, ControlEnd::Revoked, None, None))
    }

    /// Whether somebody with this token may act now: the fence in front of everything that moves.
    pub(crate) fn check(
        &self,
        now: Moment,
        token: ControlToken,
        holder: &str,
    ) -> Result<(), Denied> {
        match self.held(now) {
            Some(lease) if lease.token == token && lease.terms.holder == holder => Ok(()),
            Some(lease) if lease.token == token => Err(Denied::Held(Box::new(lease.clone()))),
            Some(_) | None => Err(self.lost(now, token.lease)),
        }
    }

    /// Whether somebody without a lease may act: while nobody holds one.
    pub(crate) fn is_free(&self, now: Moment) -> Result<(), Denied> {
        match self.held(now) {
            Some(lease) => Err(Denied::Held(Box::new(lease.clone()))),
            None => Ok(()),
        }
    }

    fn see(&mut self, now: Moment) -> Moment {
        self.seen = self.seen.max(now);
        self.seen
    }

    /// The present lease, if it is this one and this holder's.
    fn own(&mut self, now: Moment, lease: Uuid, holder: &str) -> Result<&mut Lease, Denied> {
        let lost = self.lost(now, lease);
        match &mut self.lease {
            Some(known) if known.token.lease == lease && now < known.expires => {
                if known.terms.holder == holder {
                    Ok(known)
                } else {
                    Err(Denied::Held(Box::new(known.clone())))
                }
            }
            Some(_) | None => Err(lost),
        }
    }

    /// That a lease is over, and how.
    fn lost(&self, now: Moment, lease: Uuid) -> Denied {
        if let Some(known) = &self.lease
            && known.token.lease == lease
        {
            // Over, and not yet told.
            return Denied::Lost(Some(Box::new(Ended {
                lease: known.clone(),
                end: ControlEnd::Expired,
                at: now.max(self.seen),
                by: None,
                reason: None,
            })));
        }
        let last = self.last.as_ref();
        let last = last.filter(|ended| ended.lease.token.lease == lease);
        Denied::Lost(last.cloned().map(Box::new))
    }

    fn check_epoch(&self, token: ControlToken) -> Result<(), Denied> {
        if token.epoch > self.epoch {
            return Ok(());
        }
        Err(Denied::StaleEpoch {
            given: token.epoch,
            latest: self.epoch,
        })
    }

    fn begin(&mut self, now: Moment, terms: Terms, token: ControlToken) -> Lease {
        let now = self.see(now);
        let lease = Lease {
            token,
            since: now,
            expires: now + terms.ttl,
            terms,
        };
        self.epoch = token.epoch;
        self.lease = Some(lease.clone());
        lease
    }

    fn end(
        &mut self,
        now: Moment,
        end: ControlEnd,
        by: Option<String>,
        reason: Option<String>,
    ) -> Option<Ended> {
        let at = self.see(now);
        let ended = Ended {
            lease: self.lease.take()?,
            end,
            at,
            by,
            reason,
        };
        self.last = Some(ended.clone());
        Some(ended)
    }
}
