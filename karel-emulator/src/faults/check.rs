//! Whether a fault can be injected at all.

use super::{FaultBody, FaultError, FaultKind, MAX_BYTES, MAX_MS, MAX_TIMES, Scope};
use crate::effects::Tag;

impl FaultBody {
    /// Whether the fault can be injected at all.
    pub(crate) fn check(&self) -> Result<(), FaultError> {
        let within = |item: &'static str, value: u64, min: u64, max: u64| {
            if (min..=max).contains(&value) {
                Ok(())
            } else {
                Err(FaultError::Range {
                    item,
                    value: value.to_string(),
                    min,
                    max,
                })
            }
        };
        if let Some(times) = self.times {
            within("times", times.into(), 1, MAX_TIMES.into())?;
        }
        if let Some(ms) = self.for_ms {
            within("for_ms", ms, 1, MAX_MS)?;
        }
        check_tag("scope.tag", self.scope.tag.as_deref())?;
        let wire = self.fault.is_wire();
        if !wire && (self.times.is_some() || self.scope != Scope::default()) {
            return Err(FaultError::NotForDevices {
                fault: self.fault.name(),
            });
        }
        if self.fault.is_momentary() && (self.times.is_some() || self.for_ms.is_some()) {
            return Err(FaultError::NoEnd {
                fault: self.fault.name(),
            });
        }
        if self.fault == FaultKind::Stall && self.times.is_some() {
            return Err(FaultError::NoTimes);
        }
        let bytes = |value: usize| u64::try_from(value).unwrap_or(u64::MAX);
        match &self.fault {
            FaultKind::Delay { ms, jitter_ms } => {
                within("delay.ms", *ms, 0, MAX_MS)?;
                within("delay.jitter_ms", *jitter_ms, 0, MAX_MS)
            }
            FaultKind::Split { bytes: n, gap_ms } => {
                within("split.bytes", bytes(*n), 1, bytes(MAX_BYTES))?;
                within("split.gap_ms", *gap_ms, 0, MAX_MS)
            }
            FaultKind::Truncate { keep } => {
                within("truncate.keep", bytes(*keep), 0, bytes(MAX_BYTES))
            }
            FaultKind::Corrupt { bytes: n } => {
                within("corrupt.bytes", bytes(*n), 1, bytes(MAX_BYTES))
            }
            FaultKind::WedgeTag { tag } => check_tag("wedge_tag.tag", Some(tag)),
            FaultKind::PowerLoss { off_ms, .. } => within("power_loss.off_ms", *off_ms, 0, MAX_MS),
            FaultKind::SlowOverride { percent } => {
                if (1..=100).contains(percent) {
                    return Ok(());
                }
                Err(FaultError::Range {
                    item: "slow_override.percent",
                    value: percent.to_string(),
                    min: 1,
                    max: 100,
                })
            }
            FaultKind::Drop
            | FaultKind::Stall
            | FaultKind::HalfOpen
            | FaultKind::Reset
            | FaultKind::Freeze
            | FaultKind::ServoOff
            | FaultKind::WrongToolFrame { .. }
            | FaultKind::OptionMissing { .. } => Ok(()),
        }
    }
}

fn check_tag(item: &'static str, tag: Option<&str>) -> Result<(), FaultError> {
    match tag {
        Some(name) if Tag::parse(name).is_none() => Err(FaultError::Tag {
            item,
            value: name.chars().take(32).collect(),
        }),
        Some(_) | None => Ok(()),
    }
}
