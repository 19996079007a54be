//! The limits of what a fault may say.

use super::Fault;
use crate::error::{Refusal, id, number};

/// A day.
const MAX_S: f64 = 86_400.0;
const MAX_MM: f64 = 1e6;

impl Fault {
    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// Names item, value and limit.
    #[expect(clippy::too_many_lines, reason = "one arm for each fault")]
    pub fn check(&self) -> Result<(), Refusal> {
        let seconds = |item, value: Option<f64>| {
            value.map_or(Ok(()), |value| number(item, value, (0.0, MAX_S)).map(drop))
        };
        let way = |item, value| number(item, value, (-MAX_MM, MAX_MM)).map(drop);
        let angle = |item, value| number(item, value, (-360.0, 360.0)).map(drop);
        let times = |item, value: u32| number(item, f64::from(value), (1.0, 1000.0)).map(drop);
        let nth = |value: &Option<u32>| value.map_or(Ok(()), |value| times("nth", value));
        match self {
            Self::Late { delay_s } => seconds("delay_s", Some(*delay_s)),
            Self::Stuck { for_s }
            | Self::Unlocalized { for_s }
            | Self::DoesNotLeave { for_s }
            | Self::IgnoresPermit { for_s }
            | Self::HeartbeatStops { for_s } => seconds("for_s", *for_s),
            Self::Obstacle {
                x_mm,
                y_mm,
                radius_mm,
                for_s,
            } => {
                way("x_mm", *x_mm)?;
                way("y_mm", *y_mm)?;
                let _ = number("radius_mm", *radius_mm, (1.0, 1e5))?;
                seconds("for_s", *for_s)
            }
            Self::WrongDock { dock } => {
                way("dock.x_mm", dock.x_mm)?;
                way("dock.y_mm", dock.y_mm)?;
                angle("dock.heading_deg", dock.heading_deg)
            }
            Self::DockFails { times: count }
            | Self::OrderUnacknowledged { times: count }
            | Self::OrderRefused { times: count } => times("times", *count),
            Self::Slip {
                forward_mm,
                left_mm,
                turn_deg,
                ..
            } => {
                way("forward_mm", *forward_mm)?;
                way("left_mm", *left_mm)?;
                angle("turn_deg", *turn_deg)
            }
            Self::Lie {
                x_mm,
                y_mm,
                heading_deg,
                for_s,
            } => {
                way("x_mm", *x_mm)?;
                way("y_mm", *y_mm)?;
                angle("heading_deg", *heading_deg)?;
                seconds("for_s", *for_s)
            }
            Self::DrivesOff { after_s } => seconds("after_s", Some(*after_s)),
            Self::Mode { .. } => Ok(()),
            Self::Crash { down_s } => seconds("down_s", Some(*down_s)),
            Self::Battery { percent } => number("percent", *percent, (0.0, 100.0)).map(drop),
            Self::LoadMissing { slot } => id("slot", slot).map(drop),
            Self::LoadWrong { slot, load } | Self::LoadExtra { slot, load } => {
                let _ = id("slot", slot)?;
                id("load", load).map(drop)
            }
            Self::MisreportLoad { slot, load, for_s } => {
                let _ = id("slot", slot)?;
                if let Some(load) = load {
                    let _ = id("load", load)?;
                }
                seconds("for_s", *for_s)
            }
            Self::LoseSignal {
                nth: which,
                transmissions,
                ..
            } => {
                nth(which)?;
                transmissions.map_or(Ok(()), |count| times("transmissions", count))
            }
            Self::LoseAnswer {
                nth: which,
                answers,
                ..
            } => {
                nth(which)?;
                times("answers", *answers)
            }
            Self::DelaySignal {
                nth: which,
                delay_s,
                ..
            } => {
                nth(which)?;
                seconds("delay_s", Some(*delay_s))
            }
            Self::DuplicateSignal {
                nth: which, copies, ..
            } => {
                nth(which)?;
                times("copies", *copies)
            }
            Self::ReorderSignal { nth: which, .. } => nth(which),
        }
    }
}
