//! What can go wrong with a mobile robot, on demand.

use api::{FloorPoseBody, OperatingMode, SignalName};
use serde::{Deserialize, Serialize};

mod check;
mod effect;
mod text;

pub(crate) use effect::{Lasting, SignalFault};

/// The most faults that are kept at a time.
pub const MAX_FAULTS: usize = 64;

/// A fault. Set in the configuration, by the library, or over HTTP; the same shape everywhere.
///
/// A fault of a signal holds once, for the `nth` signal (the next, where absent) of that name (any, where absent)
/// after it was set.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
// The shape is flat, `{"fault": "LATE", "delay_s": 1}`; see `text.rs` for why serde's own tag will not do.
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
