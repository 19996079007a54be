//! What is said of control, to people and programs.

use api::{ControlEnd, ControlHolder, ControlLease, EndedLease, ProblemCode};

use super::control::CellControl;
use super::machine::{Denied, Ended, Lease};
use crate::identity::NotRecorded;

/// Why somebody may not act, for people and programs.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[error("{detail}")]
pub(crate) struct Refused {
    pub(crate) code: ProblemCode,
    pub(crate) detail: String,
    pub(crate) holder: Option<Box<ControlHolder>>,
}

/// Why control was not granted.
#[derive(Debug)]
pub(crate) enum AcquireError {
    Refused(Refused),
    NotRecorded(NotRecorded),
}

impl From<Refused> for AcquireError {
    fn from(refused: Refused) -> Self {
        Self::Refused(refused)
    }
}

impl From<NotRecorded> for AcquireError {
    fn from(error: NotRecorded) -> Self {
        Self::NotRecorded(error)
    }
}

impl CellControl {
    pub(super) fn refused(&self, denied: Denied) -> Refused {
        match denied {
            Denied::Held(lease) => {
                let holder = self.holder_body(&lease);
                Refused {
                    code: ProblemCode::ControlHeld,
                    detail: format!(
                        "`{}` has control of cell `{}` since {:.0}, and keeps it until {:.0} if no heartbeat comes; the reason given: {}",
                        holder.holder, self.cell, holder.since, holder.expires, holder.reason
                    ),
                    holder: Some(Box::new(holder)),
                }
            }
            Denied::Lost(ended) => Refused {
                code: ProblemCode::ControlLost,
                detail: match ended {
                    Some(ended) => how(&self.ended_body(&ended)),
                    None => "the Control-Token is of no lease that holds: it ended, or the server was started anew"
                        .to_owned(),
                },
                holder: None,
            },
            Denied::StaleEpoch { given, latest } => {
                tracing::error!(given, latest, "an epoch was given twice; control is not granted");
                Refused {
                    code: ProblemCode::NotRecorded,
                    detail: format!("the epoch {given} is not after {latest}"),
                    holder: None,
                }
            }
        }
    }

    pub(super) fn lease_body(&self, lease: &Lease) -> ControlLease {
        ControlLease {
            token: lease.token,
            lease: lease.token.lease,
            epoch: lease.token.epoch,
            holder: lease.terms.holder.clone(),
            station: lease.terms.station,
            reason: lease.terms.reason.clone(),
            since: self.clock.wall(lease.since),
            expires: self.clock.wall(lease.expires),
            ttl_s: u32::try_from(lease.terms.ttl.as_secs()).unwrap_or(u32::MAX),
            loss_behavior: lease.terms.loss,
        }
    }

    fn holder_body(&self, lease: &Lease) -> ControlHolder {
        ControlHolder {
            holder: lease.terms.holder.clone(),
            station: lease.terms.station,
            since: self.clock.wall(lease.since),
            expires: self.clock.wall(lease.expires),
            reason: lease.terms.reason.clone(),
        }
    }

    pub(super) fn ended_body(&self, ended: &Ended) -> EndedLease {
        EndedLease {
            epoch: ended.lease.token.epoch,
            holder: ended.lease.terms.holder.clone(),
            end: ended.end,
            at: self.clock.wall(ended.at),
            by: ended.by.clone(),
            reason: ended.reason.clone(),
        }
    }
}

/// How a lease ended, in a sentence.
fn how(ended: &EndedLease) -> String {
    let EndedLease { epoch, at, .. } = ended;
    let by = ended.by.as_deref().unwrap_or("somebody");
    let why = ended.reason.as_deref().unwrap_or("no reason given");
    match ended.end {
        ControlEnd::Released => format!("control of epoch {epoch} was given back at {at:.0}"),
        ControlEnd::Expired => {
            format!("control of epoch {epoch} ended at {at:.0}: no heartbeat came in time")
        }
        ControlEnd::Preempted => {
            format!("control of epoch {epoch} was taken by `{by}` at {at:.0}: {why}")
        }
        ControlEnd::Transferred => {
            format!("control of epoch {epoch} was handed on by `{by}` at {at:.0}: {why}")
        }
        ControlEnd::Revoked => {
            format!("control of epoch {epoch} ended at {at:.0}: its holder's token was revoked")
        }
    }
}
