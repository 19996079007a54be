//! Relative moves: what they count from, and when they are refused.

use std::sync::Arc;

use crate::legacy_moves::POINT;
use journal::MemoryDisk;

use crate::link_queue::queued;
use crate::support::{
    ACCEPTED, Act, DEMO_SETUP, FakeRobot, MOTION, MOTIONS, TestServer, opened, robot_section,
    wait_until,
};

const UP: &str = r#"{"dx": 0, "dy": 0, "dz": 10.5, "dw": 0, "dp": 0, "dr": 0}"#;

fn assert_no_target(reply: &crate::support::HttpReply) {
    assert_eq!(reply.status, 409, "{reply:?}");
    let detail = reply.json()["detail"].as_str().unwrap().to_owned();
    assert!(detail.starts_with("ERROR: NO ACCEPTED TARGET"), "{detail}");
}

#[tokio::test]
async fn a_delta_counts_from_the_last_accepted_target_of_any_route() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;

    assert_no_target(&server.post("/fanuc/delta", UP).await);
    robot.assert_untouched();

    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
    let reply = server.post("/fanuc/delta?velocity=7", UP).await;
    assert_eq!(reply.json()["current_position"]["z"], 950.5);
    let reply = server.post("/fanuc/delta", UP).await;
    assert_eq!(reply.json()["current_position"]["z"], 961.0);
    assert_eq!(robot.commands()[1], "985000 0 950500 180000 0 0 7 1");

    let state = server.get("/api/v1/cells/c1/robots/r1/state").await.json();
    assert_eq!(state["pose_source"], "last_accepted_target");
    assert_eq!(state["pose"]["z_mm"], 961.0);
}

/// Covers: H5.
#[tokio::test]
async fn a_refusal_leaves_the_base_and_a_doubt_removes_it() {
    let robot = FakeRobot::start([
        Act::Reply(ACCEPTED),
        Act::Reply("ERROR: POINT UNREACHABLE"),
        Act::Reply(ACCEPTED),
        Act::CloseAfter(""),
        Act::Reply("ERROR: POINT UNREACHABLE"),
        Act::Reply(ACCEPTED),
    ])
    .await;
    let server = TestServer::start(&robot).await;
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    assert_eq!(server.post("/fanuc/delta", UP).await.status, 409);
    let reply = server.post("/fanuc/delta", UP).await;
    assert_eq!(reply.json()["current_position"]["z"], 950.5);

    let _doubt =
        server
            .post("/fanuc/move", POINT)
            .await
            .problem(504, "controller-timeout", "UNKNOWN");
    assert_no_target(&server.post("/fanuc/delta", UP).await);
    // A refusal does not say where the arm is going either.
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 409);
    assert_no_target(&server.post("/fanuc/delta", UP).await);
    assert_eq!(robot.commands().len(), 5);

    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    assert_eq!(server.post("/fanuc/delta", UP).await.status, 200);
}

#[tokio::test]
async fn deltas_at_the_same_time_never_count_from_the_same_target() {
    let robot = FakeRobot::accepting().await;
    let mut section = robot_section(robot.address);
    section.queue_capacity = 64;
    let server = Arc::new(TestServer::with_robot(section).await);
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    let step = r#"{"dx": 0, "dy": 0, "dz": 1, "dw": 0, "dp": 0, "dr": 0}"#;
    let tasks: Vec<_> = (0..20)
        .map(|_| {
            let server = Arc::clone(&server);
            tokio::spawn(async move { server.post("/fanuc/delta", step).await })
        })
        .collect();
    let mut heights = Vec::new();
    for task in tasks {
        let reply = task.await.unwrap();
        heights.push(reply.json()["current_position"]["z"].as_f64().unwrap());
    }
    heights.sort_by(f64::total_cmp);
    let expected: Vec<f64> = (1..=20).map(|step| 940.0 + f64::from(step)).collect();
    assert_eq!(heights, expected);
}

#[tokio::test]
async fn a_delta_to_where_the_arm_cannot_be_is_refused_and_keeps_the_base() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    for far in ["5000", "1e9", "1e300"] {
        let reply = server.post("/fanuc/delta", &UP.replace("10.5", far)).await;
        assert_eq!(reply.status, 409, "{reply:?}");
        let detail = reply.json()["detail"].as_str().unwrap().to_owned();
        assert!(detail.starts_with("ERROR: POINT UNREACHABLE: "), "{detail}");
    }
    assert_eq!(robot.commands().len(), 1);
    let reply = server.post("/fanuc/delta", UP).await;
    assert_eq!(reply.json()["current_position"]["z"], 950.5);
}

/// Somewhere to the left of where the moves of the test below begin.
const POST: &str = "
[[zones]]
id = \"post\"
kind = \"KEEP_OUT\"
box.min = { x_mm = 900, y_mm = 550, z_mm = 1200 }
box.max = { x_mm = 1100, y_mm = 700, z_mm = 1600 }
";

/// The zones are looked at where the move ends that is sent, not where it would end from the target of a moment ago.
///
/// Covers: H4, H5.
#[tokio::test]
async fn h4_a_delta_whose_base_changed_while_it_waited_does_not_enter_a_keep_out_zone() {
    let robot = FakeRobot::start([
        Act::Reply(ACCEPTED),
        Act::Held(ACCEPTED),
        Act::Reply(ACCEPTED),
    ])
    .await;
    let setup = format!("{DEMO_SETUP}{POST}");
    let journal = opened(&MemoryDisk::new());
    let server = TestServer::with_setup(robot_section(robot.address), &setup, journal).await;
    let server = Arc::new(server);
    let post = |path: &'static str, body: String| {
        let server = Arc::clone(&server);
        tokio::spawn(async move { server.post(path, &body).await })
    };
    let left = |mm: i32| UP.replace("\"dy\": 0", &format!("\"dy\": {mm}"));
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    let aside = POINT.replace("\"y\": 0", "\"y\": 300");
    assert_ne!(aside, POINT);
    let aside = post("/fanuc/move", aside);
    wait_until("the second move is with the robot", || {
        robot.commands().len() == 2
    })
    .await;
    // From the first target it would end 250 mm before the zone, from the second one in it.
    let delta = post("/fanuc/delta", left(300));
    queued(&server, 1).await;
    robot.release();
    assert_eq!(aside.await.unwrap().status, 200);
    let reply = delta.await.unwrap();
    assert_eq!(reply.status, 409, "{reply:?}");
    let detail = reply.json()["detail"].as_str().unwrap().to_owned();
    assert!(detail.starts_with("ERROR: POINT UNREACHABLE: "), "{detail}");
    assert!(detail.contains("`post`"), "{detail}");
    assert_eq!(robot.commands().len(), 2);
    // What it counts from is still the second target.
    let reply = server.post("/fanuc/delta", &left(-300)).await;
    assert_eq!(reply.json()["current_position"]["y"], 0.0, "{reply:?}");
}
