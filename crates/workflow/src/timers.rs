//! How long each wait may last, and the name of each wait.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::ids::Millis;

/// The durations of all waits, in milliseconds, and how often something is tried again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the names are the table's; each comment says which row"
)]
pub struct Timers {
    // T_res: how often a queued job is looked at although nothing changed.
    pub reserve_ms: Millis,
    // Planning every pose of the job.
    pub precheck_ms: Millis,
    // T_ack, and how often the same order is sent again.
    pub acknowledge_ms: Millis,
    pub resends: u8,
    // T_arr where the job names no expected arrival; with one: 1.5 times that.
    pub arrival_ms: Millis,
    pub redispatches: u8,
    // T_dock, and how often docking is tried again.
    pub dock_ms: Millis,
    pub dock_retries: u8,
    // Waiting for a report of loads, and how often it is waited for again.
    pub verify_ms: Millis,
    pub rescans: u8,
    // T_rdy
    pub ready_ms: Millis,
    // A motion may take 1.5 times its plan plus this much; without a plan, `motion_unplanned_ms`.
    pub motion_margin_ms: Millis,
    pub motion_unplanned_ms: Millis,
    // T_grip
    pub grip_ms: Millis,
    // T_exit and T_clear
    pub exit_ms: Millis,
    pub clear_ms: Millis,
    // A16 and B16
    pub close_ms: Millis,
    // T_hold: how long a prefetched load waits in the gripper for a mobile robot that is late.
    pub prefetch_hold_ms: Millis,
    // T_safe
    pub safe_ms: Millis,
    // A mobile robot at a point that says nothing for this long is lost (F12).
    pub heartbeat_ms: Millis,
    pub heartbeats_to_resume: u8,
    // An arm that nothing was observed of for this long is lost (F8).
    pub arm_silence_ms: Millis,
    // An acting state that does not end because the arm is not confirmed still.
    pub still_ms: Millis,
    // A parked signal whose predecessor does not come.
    pub park_ms: Millis,
    // A question that nobody answers is shown again.
    pub remind_ms: Millis,
    // The drive to the destination where the job names no expected duration; with one: twice that.
    pub transport_ms: Millis,
    // Waiting for evidence after a restart before a human is asked.
    pub recover_ms: Millis,
}

impl Default for Timers {
    fn default() -> Self {
        Self {
            reserve_ms: 30_000,
            precheck_ms: 5_000,
            acknowledge_ms: 5_000,
            resends: 3,
            arrival_ms: 300_000,
            redispatches: 2,
            dock_ms: 60_000,
            dock_retries: 2,
            verify_ms: 10_000,
            rescans: 1,
            ready_ms: 10_000,
            motion_margin_ms: 5_000,
            motion_unplanned_ms: 30_000,
            grip_ms: 3_000,
            exit_ms: 10_000,
            clear_ms: 60_000,
            close_ms: 5_000,
            prefetch_hold_ms: 120_000,
            safe_ms: 3_000,
            heartbeat_ms: 3_000,
            heartbeats_to_resume: 3,
            arm_silence_ms: 3_000,
            still_ms: 10_000,
            park_ms: 2_000,
            remind_ms: 300_000,
            transport_ms: 600_000,
            recover_ms: 30_000,
        }
    }
}

/// The name of one wait. Two waits with the same name are the same wait.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(tag = "timer", rename_all = "snake_case")]
#[expect(missing_docs, reason = "the fields name what the wait belongs to")]
pub enum TimerKey {
    /// A queued job is looked at again.
    Queue { job: Uuid },
    /// A job has to have started by now.
    Deadline { job: Uuid },
    /// A running step.
    Step { job: Uuid, step: usize },
    /// A job in an acting state, or suspended by a fault.
    State { job: Uuid },
    /// A prefetched load in the gripper (`T_hold`).
    Prefetch { job: Uuid },
    /// An operation of an arm.
    Operation { op: Uuid },
    /// An arm has to be out of the zone or still (`T_safe`).
    Safe { arm: String },
    /// A session on its way out.
    Session { session: Uuid },
    /// The next signal of a mobile robot at a point.
    Heartbeat { mobile_robot: String },
    /// The next observation of an arm.
    ArmSeen { arm: String },
    /// The predecessor of a parked signal.
    Parked { mobile_robot: String },
    /// A question to a human.
    Question { intervention: Uuid },
}

/// A running wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Running {
    /// When it ends, on the driver's clock.
    pub at: Millis,
    /// How long it was when it was armed.
    pub total_ms: Millis,
}
