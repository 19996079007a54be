//! What can go wrong with a mobile robot, on demand.

use api::{FloorPoseBody, OperatingMode, SignalName};
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value};
use serde_path_to_error::Track;

use crate::error::{Refusal, id, number};

/// The most faults that are kept at a time.
pub const MAX_FAULTS: usize = 64;
/// The key that names the fault.
const TAG: &str = "fault";
/// A day.
const MAX_S: f64 = 86_400.0;
const MAX_MM: f64 = 1e6;

/// A fault. Set in the configuration, by the library, or over HTTP; the same shape everywhere.
///
/// A fault of a signal holds once, for the `nth` signal (the next, where absent) of that name (any, where absent)
/// after it was set.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
// The shape is flat, `{"fault": "LATE", "delay_s": 1}`; see the impls below for why serde's own tag will not do.
#[serde(
    remote = "Self",
    rename_all = "SCREAMING_SNAKE_CASE",
    deny_unknown_fields
)]
pub enum Fault {
    /// It stands this long on the drive it is on, or else on the next.
    Late {
        /// How long.
        delay_s: f64,
    },
    /// Its wheels turn and it does not move.
    Stuck {
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// Something round is in the way.
    Obstacle {
        /// Its middle.
        x_mm: f64,
        /// Its middle.
        y_mm: f64,
        /// Its radius.
        radius_mm: f64,
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// It takes this for the dock of its next order.
    WrongDock {
        /// Where it docks.
        dock: FloorPoseBody,
    },
    /// Docking fails this often.
    DockFails {
        /// How often.
        times: u32,
    },
    /// It slides, in its own frame.
    Slip {
        /// Along its x.
        #[serde(default)]
        forward_mm: f64,
        /// Along its y.
        #[serde(default)]
        left_mm: f64,
        /// Counterclockwise.
        #[serde(default)]
        turn_deg: f64,
        /// When.
        when: SlipMoment,
        /// Whether it measures where it then is, or goes on believing what its wheels say.
        noticed: bool,
    },
    /// It adds this to the pose it tells, in the world.
    Lie {
        /// Along X.
        #[serde(default)]
        x_mm: f64,
        /// Along Y.
        #[serde(default)]
        y_mm: f64,
        /// Counterclockwise.
        #[serde(default)]
        heading_deg: f64,
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// It does not know where it is, says so, and stands.
    Unlocalized {
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// It stays docked although it may leave.
    DoesNotLeave {
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// Docked, it drives off without a permit.
    DrivesOff {
        /// This long after it has docked, or after this was set.
        #[serde(default)]
        after_s: f64,
    },
    /// It drives into zones without a permit.
    IgnoresPermit {
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// No heartbeats.
    HeartbeatStops {
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// Somebody turns the key.
    Mode {
        /// To this mode.
        mode: OperatingMode,
    },
    /// It loses power, and starts again.
    Crash {
        /// After this time.
        down_s: f64,
    },
    /// The charge is suddenly this.
    Battery {
        /// From 0 to 100.
        percent: f64,
    },
    /// What lay in a slot is gone, unseen.
    LoadMissing {
        /// The slot.
        slot: String,
    },
    /// Something else lies in a slot.
    LoadWrong {
        /// The slot.
        slot: String,
        /// What lies there now.
        load: String,
    },
    /// Something lies in a slot that was empty.
    LoadExtra {
        /// The slot.
        slot: String,
        /// What lies there now.
        load: String,
    },
    /// It tells something else of a slot than what lies there.
    MisreportLoad {
        /// The slot.
        slot: String,
        /// What it tells.
        load: Option<String>,
        /// How long; until cleared, where absent.
        #[serde(default)]
        for_s: Option<f64>,
    },
    /// It takes no notice of its next orders.
    OrderUnacknowledged {
        /// How many messages it ignores.
        times: u32,
    },
    /// It refuses its next orders.
    OrderRefused {
        /// How many.
        times: u32,
    },
    /// A signal is lost on its way.
    LoseSignal {
        /// Which.
        #[serde(default)]
        signal: Option<SignalName>,
        /// Which of them.
        #[serde(default)]
        nth: Option<u32>,
        /// So often; then it gets through. For ever, where absent.
        #[serde(default)]
        transmissions: Option<u32>,
        /// Lost for ever: whether its number is lost too.
        #[serde(default)]
        number: LostNumber,
    },
    /// A signal arrives, and its answers are lost: it is sent again.
    LoseAnswer {
        /// Which.
        #[serde(default)]
        signal: Option<SignalName>,
        /// Which of them.
        #[serde(default)]
        nth: Option<u32>,
        /// How many answers.
        answers: u32,
    },
    /// A signal, and all behind it, waits.
    DelaySignal {
        /// Which.
        #[serde(default)]
        signal: Option<SignalName>,
        /// Which of them.
        #[serde(default)]
        nth: Option<u32>,
        /// How long.
        delay_s: f64,
    },
    /// A signal is sent more than once.
    DuplicateSignal {
        /// Which.
        #[serde(default)]
        signal: Option<SignalName>,
        /// Which of them.
        #[serde(default)]
        nth: Option<u32>,
        /// How often beyond the first.
        copies: u32,
    },
    /// A signal is overtaken by the one after it.
    ReorderSignal {
        /// Which.
        #[serde(default)]
        signal: Option<SignalName>,
        /// Which of them.
        #[serde(default)]
        nth: Option<u32>,
    },
}

/// When a robot slides.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum SlipMoment {
    /// At once, wherever it is.
    Now,
    /// In the middle of its next docking.
    Docking,
}

/// What becomes of the number of a signal that is lost for ever.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum LostNumber {
    /// The next signal has it.
    #[default]
    Unused,
    /// The cell sees a hole.
    Consumed,
}

/// Serde's internal tag forgets which key did not fit; here an error names it.
impl<'de> Deserialize<'de> for Fault {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut keys = Map::deserialize(deserializer)?;
        let Some(Value::String(name)) = keys.remove(TAG) else {
            return Err(D::Error::custom(
                "fault: missing, or no text; it names the fault, e.g. \"LATE\"",
            ));
        };
        let nested = Value::Object(Map::from_iter([(name.clone(), Value::Object(keys))]));
        let mut track = Track::new();
        let tracked = serde_path_to_error::Deserializer::new(nested, &mut track);
        Fault::deserialize(tracked).map_err(|error| {
            let path = track.path().to_string();
            match path
                .strip_prefix(&name)
                .and_then(|key| key.strip_prefix('.'))
            {
                Some(key) => D::Error::custom(format!("{key}: {error}")),
                None => match error.to_string().strip_prefix("unknown variant ") {
                    Some(known) => D::Error::custom(format!("{TAG}: there is no {known}")),
                    None => D::Error::custom(error),
                },
            }
        })
    }
}

impl Serialize for Fault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let nested = Fault::serialize(self, serde_json::value::Serializer);
        let Value::Object(nested) = nested.map_err(S::Error::custom)? else {
            return Err(S::Error::custom("a fault is an object"));
        };
        let mut flat = Map::new();
        for (name, keys) in nested {
            let _first = flat.insert(TAG.to_owned(), Value::String(name));
            if let Value::Object(keys) = keys {
                flat.extend(keys);
            }
        }
        flat.serialize(serializer)
    }
}

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
