//! Motions as resources.

use std::collections::HashSet;

use serde_json::{Value, json};

use crate::support::{FakeRobot, MOTION, MOTIONS, TestServer, robot_section};

fn joints(degrees: [f64; 6]) -> Value {
    let keys = ["j1_deg", "j2_deg", "j3_deg", "j4_deg", "j5_deg", "j6_deg"];
    keys.iter()
        .zip(degrees)
        .map(|(key, value)| (*key, value))
        .collect()
}

fn joint_motion(degrees: [f64; 6]) -> String {
    json!({"type": "JOINT", "speed_mm_s": 100, "target": {"joints": joints(degrees)}}).to_string()
}

#[tokio::test]
async fn a_motion_is_created_accepted_and_found_again() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let body = MOTION.replacen('{', r#"{"reason": "teach check", "deadline_ms": 5000, "#, 1);

    let reply = server.post(MOTIONS, &body).await;

    assert_eq!(reply.status, 202, "{reply:?}");
    let motion = reply.json();
    assert_eq!(motion["state"], "accepted");
    assert_eq!(motion["completion"], "not_observable");
    assert_eq!(motion["tier"], "seed");
    assert_eq!(motion["reason"], "teach check");
    assert_eq!(motion["controller_text"], "SUCESS: MOVEMENT COMPLETE");
    assert_eq!(motion["request_id"], reply.header("x-request-id").unwrap());
    assert_eq!(motion["target"]["z_mm"], 940.0);
    assert_eq!(motion["speed_mm_s"], 200.0);
    let j5 = motion["expected_joints"]["j5_deg"].as_f64().unwrap();
    assert!((j5 + 90.0).abs() < 1e-6, "{j5}");
    assert_eq!(robot.commands(), ["985000 0 940000 180000 0 0 200 1"]);

    let location = reply.header("location").unwrap();
    assert_eq!(server.get(location).await.json(), motion);
    let state = server.get("/api/v1/cells/c1/robots/r1/state").await.json();
    assert_eq!(state["last_motion"], motion["id"]);
    assert_eq!(state["link"]["state"], "answering");
}

#[tokio::test]
async fn joint_values_are_sent_as_the_pose_they_have() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let home = r#"{"type": "HOME", "speed_mm_s": 100}"#;
    assert_eq!(server.post(MOTIONS, home).await.status, 202);
    let body = joint_motion([30.0, 10.0, -5.0, 0.0, -80.0, 0.0]);
    let reply = server.post(MOTIONS, &body).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let expected = reply.json()["expected_joints"]["j2_deg"].as_f64().unwrap();
    assert!((expected - 10.0).abs() < 0.01);
    assert_eq!(robot.commands().len(), 2);
}

#[tokio::test]
async fn joint_values_the_controller_would_not_choose_are_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let cases = [
        // The wrist flipped: the pose has another joint set in the configuration the controller keeps.
        (
            [30.0, 10.0, -5.0, 180.0, 80.0, 180.0],
            "no-solution-in-configuration",
        ),
        (
            [30.0, 10.0, -5.0, 180.0, 80.0, -180.0],
            "no-solution-in-configuration",
        ),
        ([500.0, 10.0, -5.0, 0.0, -80.0, 0.0], "joint-limit-exceeded"),
        ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], "singularity"),
    ];
    for (degrees, code) in cases {
        let reply = server.post(MOTIONS, &joint_motion(degrees)).await;
        let problem = reply.problem(422, code, "NOT_SENT");
        assert_eq!(problem["robot"], "r1");
        assert!(problem["violations"][0]["item"].is_string(), "{problem}");
    }
    robot.assert_untouched();
    assert_eq!(server.get(MOTIONS).await.json(), json!({"motions": []}));
}

/// Covers: H4.
#[tokio::test]
async fn a_joint_beyond_its_limit_is_named_with_value_and_limits() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let reply = server
        .post(MOTIONS, &joint_motion([500.0, 10.0, -5.0, 0.0, -80.0, 0.0]))
        .await;
    let problem = reply.problem(422, "joint-limit-exceeded", "NOT_SENT");
    let violation = &problem["violations"][0];
    assert_eq!(violation["item"], "J1");
    assert_eq!(violation["value"], 500.0);
    assert!(violation["max"].as_f64().unwrap() < 500.0);
    robot.assert_untouched();
}

#[tokio::test]
async fn fields_that_do_not_go_together_are_all_named() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let long = "x".repeat(201);
    let cases = [
        (json!({"type": "JOINT", "speed_mm_s": 1}), vec!["target"]),
        (
            json!({"type": "HOME", "speed_mm_s": 1, "target": {"joints": joints([0.0; 6])}, "deadline_ms": 0, "reason": long}),
            vec!["target", "deadline_ms", "reason"],
        ),
        (
            json!({"type": "HOME", "speed_mm_s": 1, "deadline_ms": 60_001}),
            vec!["deadline_ms"],
        ),
    ];
    for (body, items) in cases {
        let reply = server.post(MOTIONS, &body.to_string()).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        let found: Vec<_> = problem["violations"]
            .as_array()
            .unwrap()
            .iter()
            .map(|violation| violation["item"].as_str().unwrap())
            .collect();
        assert_eq!(found, items);
    }
    robot.assert_untouched();
}

#[tokio::test]
async fn the_speed_limit_of_the_robot_holds() {
    let robot = FakeRobot::accepting().await;
    let mut section = robot_section(robot.address);
    section.max_speed_mm_s = 250;
    let server = TestServer::with_robot(section).await;
    let fast = MOTION.replace("200", "251");
    let problem = server
        .post(MOTIONS, &fast)
        .await
        .problem(422, "validation", "NOT_SENT");
    assert_eq!(problem["violations"][0]["max"], 250.0);
    robot.assert_untouched();
    let legal = MOTION.replace("200", "250");
    assert_eq!(server.post(MOTIONS, &legal).await.status, 202);
}

/// Covers: R8.
#[tokio::test]
async fn the_list_is_newest_first_in_pages() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let mut created = Vec::new();
    for _ in 0..5 {
        let motion = server.post(MOTIONS, MOTION).await.json();
        created.push(motion["id"].as_str().unwrap().to_owned());
    }
    created.reverse();

    let mut listed = Vec::new();
    let mut path = format!("{MOTIONS}?limit=2");
    loop {
        let page = server.get(&path).await.json();
        let motions = page["motions"].as_array().unwrap();
        assert!(motions.len() <= 2);
        listed.extend(
            motions
                .iter()
                .map(|motion| motion["id"].as_str().unwrap().to_owned()),
        );
        match page.get("next_cursor") {
            Some(cursor) => path = format!("{MOTIONS}?limit=2&cursor={}", cursor.as_str().unwrap()),
            None => break,
        }
    }
    assert_eq!(listed, created);
    assert_eq!(created.iter().collect::<HashSet<_>>().len(), 5);

    for query in ["limit=0", "limit=201", "cursor=abc", "page=2"] {
        let reply = server.get(&format!("{MOTIONS}?{query}")).await;
        let _problem = reply.problem(422, "validation", "NONE");
    }
}

#[tokio::test]
async fn an_id_that_is_no_motions_is_not_found() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for id in ["x", "00000000-0000-7000-8000-000000000000", "%ff"] {
        let reply = server.get(&format!("{MOTIONS}/{id}")).await;
        let _problem = reply.problem(404, "not-found", "NONE");
    }
}
