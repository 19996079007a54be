//! The ledger: what the arm was asked to do and what it did, the truth that tests and operators look at.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::time::Duration;

use serde::{Deserialize, Serialize, Serializer};

/// Six joint angles as the pendant shows them, in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[expect(missing_docs, reason = "the six axes")]
pub struct JointsDeg {
    #[serde(serialize_with = "as_shown")]
    pub j1: f64,
    #[serde(serialize_with = "as_shown")]
    pub j2: f64,
    #[serde(serialize_with = "as_shown")]
    pub j3: f64,
    #[serde(serialize_with = "as_shown")]
    pub j4: f64,
    #[serde(serialize_with = "as_shown")]
    pub j5: f64,
    #[serde(serialize_with = "as_shown")]
    pub j6: f64,
}

impl From<[f64; 6]> for JointsDeg {
    fn from([j1, j2, j3, j4, j5, j6]: [f64; 6]) -> Self {
        Self {
            j1,
            j2,
            j3,
            j4,
            j5,
            j6,
        }
    }
}

impl From<JointsDeg> for [f64; 6] {
    fn from(j: JointsDeg) -> Self {
        [j.j1, j.j2, j.j3, j.j4, j.j5, j.j6]
    }
}

/// A pose as the pendant shows it: millimeters and degrees, W, P, R about the fixed X, Y, Z axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[expect(missing_docs, reason = "the six components")]
pub struct PoseMmDeg {
    #[serde(serialize_with = "as_shown")]
    pub x_mm: f64,
    #[serde(serialize_with = "as_shown")]
    pub y_mm: f64,
    #[serde(serialize_with = "as_shown")]
    pub z_mm: f64,
    #[serde(serialize_with = "as_shown")]
    pub w_deg: f64,
    #[serde(serialize_with = "as_shown")]
    pub p_deg: f64,
    #[serde(serialize_with = "as_shown")]
    pub r_deg: f64,
}

impl From<[f64; 6]> for PoseMmDeg {
    fn from([x_mm, y_mm, z_mm, w_deg, p_deg, r_deg]: [f64; 6]) -> Self {
        Self {
            x_mm,
            y_mm,
            z_mm,
            w_deg,
            p_deg,
            r_deg,
        }
    }
}

impl From<PoseMmDeg> for [f64; 6] {
    fn from(pose: PoseMmDeg) -> Self {
        let PoseMmDeg {
            x_mm,
            y_mm,
            z_mm,
            w_deg,
            p_deg,
            r_deg,
        } = pose;
        [x_mm, y_mm, z_mm, w_deg, p_deg, r_deg]
    }
}

/// `(600.000, 200.000, 600.000, -180.000, 30.000, 0.000)`, in the pendant's order and units.
impl std::fmt::Display for PoseMmDeg {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            x_mm,
            y_mm,
            z_mm,
            w_deg,
            p_deg,
            r_deg,
        } = self;
        write!(
            f,
            "({x_mm:.3}, {y_mm:.3}, {z_mm:.3}, {w_deg:.3}, {p_deg:.3}, {r_deg:.3})"
        )
    }
}

/// As people read it: see [`units::shown`]. Inside, numbers keep all their digits.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde hands over a reference"
)]
fn as_shown<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(units::shown(*value))
}

/// What happened to a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum LedgerEvent {
    /// The arm began to move.
    Started,
    /// The arm stands still at the target.
    Finished,
    /// The arm has gone around the corner at the target without standing still; the next motion has taken over.
    Passed,
    /// The controller did not accept the motion; `alarm` says why. The arm did not move for it.
    Refused,
    /// The motion was stopped on its way, or dropped before it began.
    Cancelled,
    /// The arm stands still on its way and the motion waits.
    Held,
    /// The motion that was held goes on.
    Resumed,
    /// The gripper closed on a part.
    Gripped,
    /// The gripper let a part go.
    Released,
    /// The part fell out of the gripper.
    Lost,
    /// A person moved the arm with the pendant.
    Jogged,
}

/// The command that a program carries out, as the program noted it in registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct CommandId {
    /// The epoch of whoever commands.
    pub epoch: u32,
    /// The number of the command within its epoch.
    pub seq: u32,
}

/// The geometry of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum MotionKind {
    /// All axes start and stop together.
    Joint,
    /// The tool center point on a straight line.
    Linear,
    /// The tool center point on an arc.
    Circular,
}

/// One line of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct LedgerEntry {
    /// Counts from 1, without holes while nothing is dropped.
    pub seq: u64,
    /// Controller time since power-on.
    pub time_s: f64,
    /// What happened.
    pub event: LedgerEvent,
    /// The motion; the entries of one motion carry the same number. A refused motion has one of its own.
    pub motion: u64,
    /// Joint, linear or circular.
    pub kind: MotionKind,
    /// Where the motion starts.
    pub from_deg: JointsDeg,
    /// Where it ends: the target, or where the arm came to rest if it was cancelled, or was behind a rounded corner.
    /// `None` if there is no such place.
    pub to_deg: Option<JointsDeg>,
    /// The target as commanded, in the user frame, for the tool.
    pub target_pose: PoseMmDeg,
    /// `$SPEED` of the motion.
    pub speed_mm_s: f64,
    /// The speed as a percentage, for a joint motion of a TP program; `speed_mm_s` is that part of `$SPEEDLIM` then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_percent: Option<f64>,
    /// The command that the program carries out, if it notes that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<CommandId>,
    /// The part, for `gripped`, `released` and `lost`; `target_pose` is that of the tool in the world then, and `motion`
    /// is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The general override at this moment.
    pub override_percent: i32,
    /// The program that commanded the motion.
    pub program: String,
    /// Its source line.
    pub line: u32,
    /// The TCP peer whose bytes the program read last.
    #[schema(value_type = Option<String>)]
    pub peer: Option<SocketAddr>,
    /// The HTTP request behind that peer.
    pub request_id: Option<String>,
    /// Why the motion was refused or cancelled.
    pub alarm: Option<String>,
    /// From the start to this moment; for `started`, the planned duration at the present override,
    /// `None` if that is 0.
    pub duration_s: Option<f64>,
}

/// The newest entries, up to a bound; what fell off the end is counted.
#[derive(Debug)]
pub struct Ledger {
    entries: VecDeque<LedgerEntry>,
    capacity: usize,
    dropped: u64,
    last_seq: u64,
}

impl Ledger {
    /// An empty ledger that keeps the newest `capacity` entries.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            entries: VecDeque::new(),
            capacity,
            dropped: 0,
            last_seq: 0,
        }
    }

    /// Appends an entry; its number is set here.
    pub fn push(&mut self, mut entry: LedgerEntry) {
        self.last_seq += 1;
        entry.seq = self.last_seq;
        if self.entries.len() >= self.capacity {
            let _oldest = self.entries.pop_front();
            self.dropped += 1;
        }
        self.entries.push_back(entry);
    }

    /// Entries with a number above `after`, oldest first.
    pub fn after(&self, after: u64) -> impl Iterator<Item = &LedgerEntry> {
        self.entries.iter().filter(move |entry| entry.seq > after)
    }

    /// How many entries were dropped because the ledger was full.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The number of the newest entry, 0 if there was none.
    #[must_use]
    pub fn last_seq(&self) -> u64 {
        self.last_seq
    }
}

/// Controller time as the ledger writes it: seconds with microseconds, so that equal runs are equal byte for byte.
#[must_use]
pub(crate) fn seconds(time: Duration) -> f64 {
    #[expect(
        clippy::cast_precision_loss,
        reason = "exact up to 2^53 microseconds, 285 years"
    )]
    let micros = time.as_micros() as f64;
    micros / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(motion: u64) -> LedgerEntry {
        LedgerEntry {
            seq: 0,
            time_s: 0.0,
            event: LedgerEvent::Started,
            motion,
            kind: MotionKind::Joint,
            from_deg: [0.0; 6].into(),
            to_deg: None,
            target_pose: PoseMmDeg::default(),
            speed_mm_s: 300.0,
            speed_percent: None,
            command: None,
            part: None,
            override_percent: 25,
            program: "SOCKSERVER".to_owned(),
            line: 1,
            peer: None,
            request_id: None,
            alarm: None,
            duration_s: None,
        }
    }

    #[test]
    fn a_full_ledger_drops_the_oldest_and_counts_it() {
        let mut ledger = Ledger::new(2);
        for motion in 1..=3 {
            ledger.push(entry(motion));
        }
        assert_eq!(ledger.dropped(), 1);
        assert_eq!(ledger.after(0).map(|e| e.seq).collect::<Vec<_>>(), [2, 3]);
        assert_eq!(ledger.after(2).count(), 1);
        assert_eq!(ledger.last_seq(), 3);
    }

    #[test]
    fn a_pose_reads_as_on_the_pendant() {
        let pose = PoseMmDeg::from([600.0, 200.0, 600.0, -180.0, 30.0, 0.000_04]);
        assert_eq!(
            pose.to_string(),
            "(600.000, 200.000, 600.000, -180.000, 30.000, 0.000)"
        );
    }

    #[test]
    fn an_entry_survives_json() {
        let json = serde_json::to_string(&entry(7)).unwrap();
        assert_eq!(
            serde_json::from_str::<LedgerEntry>(&json).unwrap(),
            entry(7)
        );
    }
}
