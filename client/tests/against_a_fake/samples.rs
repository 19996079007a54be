//! Answers as the server and the panel give them.

use api::{Outcome, Problem, ProblemCode};
use serde_json::{Value, json};

use crate::fake::Answer;

pub(crate) const MOTION_ID: &str = "019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11";

pub(crate) fn pose() -> Value {
    json!({"x_mm": 600.0, "y_mm": 200.0, "z_mm": 600.0, "w_deg": -180.0, "p_deg": 30.0, "r_deg": 0.0})
}

pub(crate) fn joints() -> Value {
    json!({"j1_deg": 18.4, "j2_deg": -10.0, "j3_deg": -20.5, "j4_deg": 0.0, "j5_deg": -90.0, "j6_deg": 0.0})
}

pub(crate) fn motion(state: &str) -> Value {
    json!({
        "id": MOTION_ID, "cell": "demo", "robot": "r1", "type": "JOINT", "state": state,
        "completion": "not_observable", "tier": "seed", "target": pose(), "expected_joints": joints(),
        "speed_mm_s": 200.0, "principal": "anna", "created_at": "2026-01-02T03:04:05Z", "request_id": "q1",
        "a_key_of_tomorrow": true,
    })
}

/// The lease every fake grants, or the view after it was given back.
pub(crate) fn control(given_back: bool) -> Value {
    if given_back {
        return json!({"cell": "demo", "jobs_may_act": true, "epoch": 7});
    }
    json!({
        "token": format!("{MOTION_ID}.7"), "lease": MOTION_ID, "epoch": 7, "holder": "demo", "station": "REMOTE",
        "reason": "a test", "since": "2026-01-02T03:04:05Z", "expires": "2026-01-02T03:04:15Z", "ttl_s": 10,
        "loss_behavior": "STOP_1",
    })
}

pub(crate) fn cells(robots: &[&str]) -> Value {
    let robots: Vec<Value> = robots
        .iter()
        .map(|id| json!({"id": id, "name": "Arm", "model": "fanuc-m20ia", "tier": "seed"}))
        .collect();
    json!([{"id": "demo", "name": "Demo cell", "robots": robots}])
}

pub(crate) fn state(pose: Option<&Value>) -> Value {
    json!({
        "id": "r1", "cell": "demo", "tier": "seed", "link": {"state": "answering"},
        "pose_source": if pose.is_some() { "last_accepted_target" } else { "unknown" },
        "pose": pose, "queued": 0, "queue_capacity": 8,
    })
}

fn margins() -> Value {
    json!([
        {"joint": "J1", "value_deg": 18.4, "min_deg": -170.0, "max_deg": 170.0, "margin_deg": 151.6},
        {"joint": "J5", "value_deg": -90.0, "min_deg": -125.0, "max_deg": 125.0, "margin_deg": 35.0},
    ])
}

fn singularity() -> Value {
    json!({"wrist": 1.0, "shoulder": 0.5, "elbow": 0.7, "singular": false})
}

pub(crate) fn forward() -> Value {
    json!({
        "pose": pose(), "configuration": "N U T, 0, 0, 0", "within_limits": true,
        "margins": margins(), "singularity": singularity(),
    })
}

pub(crate) fn inverse() -> Value {
    let branch = |configuration: &str, within: bool| {
        json!({
            "joints": joints(), "configuration": configuration, "within_limits": within,
            "margins": margins(), "singularity": singularity(), "distance_deg": 20.5,
        })
    };
    json!({
        "branches": [branch("N U T, 0, 0, 0", true), branch("F U T, 0, 0, 0", false)],
        "nearest": 0, "controller": 0,
    })
}

pub(crate) fn description() -> Value {
    json!({
        "id": "r1", "cell": "demo", "name": "Arm", "model": "fanuc-m20ia", "manufacturer": "FANUC",
        "tier": "seed", "controller_address": "127.0.0.1:59002",
        "joints": [{"joint": "J1", "min_deg": -170.0, "max_deg": 170.0, "max_speed_deg_s": 195.0}],
        "reach_mm": 1811.0, "home": joints(), "configuration": "N U T, 0, 0, 0",
        "tool": pose(), "user_frame": pose(), "max_speed_mm_s": 1999.0,
        "capabilities": api::Tier::Seed.capabilities(),
    })
}

pub(crate) fn emulator_state(moving: bool) -> Value {
    json!({
        "controller": "demo-r1", "model": "fanuc-m20ia", "time_s": 12.5,
        "joints_deg": {"j1": 0.0, "j2": 0.0, "j3": 0.0, "j4": 0.0, "j5": -90.0, "j6": 0.0},
        "pose": pose(), "configuration": "N U T, 0, 0, 0", "moving": moving,
        "override_percent": 25, "motion_queue": i32::from(moving),
        "tasks": [{"name": "SOCKSERVER", "program": "SOCKSERVER", "state": "waiting", "line": 40, "detail": null}],
        "tags": [{"tag": "S3:", "port": 59002, "state": "listening", "peer": null}],
        "active_alarms": 0, "ledger_seq": 2, "mode": "AUTO", "servo_power": true,
        "fidelity": "kind", "generation": "v9", "note_seq": 3,
        "limits_deg": [{"joint": "J1", "min_deg": -170.0, "max_deg": 170.0}],
    })
}

pub(crate) fn notes() -> Value {
    json!({"notes": [{
        "seq": 3, "time_s": 1.274, "program": "MAPPDK_SERVER", "line": 203, "times": 1,
        "text": "CNV_STR_REAL finds no number in \"abc\": its variable has no value now",
    }], "next": 3})
}

pub(crate) fn ledger() -> Value {
    let entry = |seq: u64, event: &str| {
        json!({
            "seq": seq, "time_s": 1.25, "event": event, "motion": 1, "kind": "joint",
            "from_deg": {"j1": 0.0, "j2": 0.0, "j3": 0.0, "j4": 0.0, "j5": -90.0, "j6": 0.0},
            "to_deg": null, "target_pose": pose(), "speed_mm_s": 200.0, "override_percent": 25,
            "program": "SOCKSERVER", "line": 61, "peer": "127.0.0.1:50000", "request_id": "q1",
            "alarm": null, "duration_s": 3.5,
        })
    };
    json!({"dropped": 0, "entries": [entry(1, "started"), entry(2, "finished")]})
}

pub(crate) fn alarms() -> Value {
    json!({"dropped": 3, "entries": [{
        "seq": 1, "time_s": 2.0, "facility": "MOTN", "number": 17, "text": "J5 at its limit.",
        "severity": "abort", "program": "SOCKSERVER", "line": 61, "active": true,
    }]})
}

pub(crate) fn problem(code: ProblemCode, outcome: Outcome) -> Problem {
    Problem {
        type_uri: format!("/problems/{}", code.as_str()),
        title: code.title().to_owned(),
        status: code.status(),
        detail: "what happened this time".to_owned(),
        instance: None,
        code,
        outcome,
        retryable: false,
        robot: Some("r1".to_owned()),
        motion: None,
        controller_text: None,
        request_id: Some("q1".to_owned()),
        violations: Vec::new(),
        hint: None,
        control: None,
    }
}

pub(crate) fn refuse(code: ProblemCode, outcome: Outcome) -> Answer {
    Answer::Problem(Box::new(problem(code, outcome)))
}
