//! How long a fault is kept, and what one does to a signal.

use api::SignalName;

use super::{Fault, LostNumber, SlipMoment};

impl Fault {
    /// The part of it that concerns a signal.
    pub(crate) fn of_signal(&mut self) -> Option<FaultOfSignal<'_>> {
        let (signal, nth, fault) = match self {
            Self::LoseSignal {
                signal,
                nth,
                transmissions,
                number,
            } => {
                let fault =
                    transmissions.map_or(SignalFault::LoseForEver(*number), SignalFault::Lose);
                (signal, nth, fault)
            }
            Self::LoseAnswer {
                signal,
                nth,
                answers,
            } => (signal, nth, SignalFault::LoseAnswers(*answers)),
            Self::DelaySignal {
                signal,
                nth,
                delay_s,
            } => (signal, nth, SignalFault::Delay(*delay_s)),
            Self::DuplicateSignal {
                signal,
                nth,
                copies,
            } => (signal, nth, SignalFault::Copies(*copies)),
            Self::ReorderSignal { signal, nth } => (signal, nth, SignalFault::Overtaken),
            Self::Late { .. }
            | Self::Stuck { .. }
            | Self::Obstacle { .. }
            | Self::WrongDock { .. }
            | Self::DockFails { .. }
            | Self::Slip { .. }
            | Self::Lie { .. }
            | Self::Unlocalized { .. }
            | Self::DoesNotLeave { .. }
            | Self::DrivesOff { .. }
            | Self::IgnoresPermit { .. }
            | Self::HeartbeatStops { .. }
            | Self::Mode { .. }
            | Self::Crash { .. }
            | Self::Battery { .. }
            | Self::LoadMissing { .. }
            | Self::LoadWrong { .. }
            | Self::LoadExtra { .. }
            | Self::MisreportLoad { .. }
            | Self::OrderUnacknowledged { .. }
            | Self::OrderRefused { .. } => return None,
        };
        Some(FaultOfSignal {
            signal: *signal,
            nth,
            fault,
        })
    }

    /// How long it lasts, of those that last.
    pub(crate) fn lasts(&self) -> Lasting {
        match self {
            Self::Stuck { for_s }
            | Self::Obstacle { for_s, .. }
            | Self::Lie { for_s, .. }
            | Self::Unlocalized { for_s }
            | Self::DoesNotLeave { for_s }
            | Self::IgnoresPermit { for_s }
            | Self::HeartbeatStops { for_s }
            | Self::MisreportLoad { for_s, .. } => Lasting::For(*for_s),
            Self::Slip {
                when: SlipMoment::Now,
                ..
            }
            | Self::Mode { .. }
            | Self::Crash { .. }
            | Self::Battery { .. }
            | Self::LoadMissing { .. }
            | Self::LoadWrong { .. }
            | Self::LoadExtra { .. } => Lasting::AtOnce,
            Self::Late { .. }
            | Self::WrongDock { .. }
            | Self::DockFails { .. }
            | Self::Slip { .. }
            | Self::DrivesOff { .. }
            | Self::OrderUnacknowledged { .. }
            | Self::OrderRefused { .. }
            | Self::LoseSignal { .. }
            | Self::LoseAnswer { .. }
            | Self::DelaySignal { .. }
            | Self::DuplicateSignal { .. }
            | Self::ReorderSignal { .. } => Lasting::UntilUsed,
        }
    }
}

/// How long a fault is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lasting {
    /// It happens, and is over.
    AtOnce,
    /// It waits for its moment.
    UntilUsed,
    /// It lasts so many seconds, or until it is cleared.
    For(Option<f64>),
}

/// A fault of one signal.
#[derive(Debug)]
pub(crate) struct FaultOfSignal<'a> {
    /// Of this name; of any.
    pub(crate) signal: Option<SignalName>,
    /// The nth of them; the next.
    pub(crate) nth: &'a mut Option<u32>,
    pub(crate) fault: SignalFault,
}

/// What a fault does to a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SignalFault {
    Lose(u32),
    LoseForEver(LostNumber),
    LoseAnswers(u32),
    Delay(f64),
    Copies(u32),
    Overtaken,
}
