//! The seed's routes, from the request to the bytes a controller reads.

use serde_json::json;

use crate::support::{ACCEPTED, Act, FakeRobot, TestServer, robot_section};

pub(crate) const POINT: &str = r#"{"x": 985, "y": 0, "z": 940, "w": 180, "p": 0, "r": 0}"#;

#[tokio::test]
async fn a_move_reaches_the_controller_and_its_answer_comes_back() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;

    let reply = server.post("/fanuc/move", POINT).await;

    assert_eq!(reply.status, 200, "{reply:?}");
    assert_eq!(
        reply.json(),
        json!({"current_position": {"x": 985.0, "y": 0.0, "z": 940.0, "w": 180.0, "p": 0.0, "r": 0.0}})
    );
    assert_eq!(robot.commands(), ["985000 0 940000 180000 0 0 200 1"]);
}

#[tokio::test]
async fn the_answer_shows_the_point_as_it_was_sent_rounded_to_thousandths() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;

    let body = r#"{"x": 900.00049, "y": 0.0005, "z": 900, "w": -180, "p": 1e-9, "r": 0}"#;
    let reply = server.post("/fanuc/move?velocity=300", body).await;

    let point = &reply.json()["current_position"];
    assert_eq!(point["x"], 900.0);
    assert_eq!(point["y"], 0.001);
    assert_eq!(robot.commands(), ["900000 1 900000 -180000 0 0 300 1"]);
}

#[tokio::test]
async fn home_is_the_pose_of_the_home_joints() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;

    let reply = server.post("/fanuc/home?velocity=50", "").await;

    assert_eq!(reply.status, 200, "{reply:?}");
    let point = &reply.json()["current_position"];
    assert_eq!((&point["x"], &point["z"]), (&json!(985.0), &json!(940.0)));
    assert_eq!(robot.commands().len(), 1);
    assert!(robot.commands()[0].ends_with(" 50 1"));
}

#[tokio::test]
async fn the_version_is_a_list() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(
        server.get("/version").await.json(),
        json!({"version": [version]})
    );
}

/// Covers: W6.
#[tokio::test]
async fn a_refusal_of_the_controller_is_its_own_words() {
    for text in ["ERROR: POINT UNREACHABLE", "ERROR: INCORRECT INPUT"] {
        let robot = FakeRobot::start([Act::Reply(text)]).await;
        let server = TestServer::start(&robot).await;
        let reply = server.post("/fanuc/move", POINT).await;
        assert_eq!(reply.status, 409);
        assert_eq!(reply.json(), json!({"detail": text}));
    }
}

/// Covers: W4.
#[tokio::test]
async fn a_reply_that_comes_in_single_bytes_is_put_together() {
    let robot = FakeRobot::start([Act::ReplyInSingleBytes(ACCEPTED)]).await;
    let server = TestServer::start(&robot).await;
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
}

#[tokio::test]
async fn a_point_the_arm_cannot_reach_is_refused_in_the_controllers_manner_and_nothing_is_sent() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let cases = [
        (
            r#"{"x": 5000, "y": 0, "z": 940, "w": 180, "p": 0, "r": 0}"#,
            "beyond the stretched arm",
        ),
        // The home pose turned by half a turn about the vertical: J6 would have to be far outside.
        (
            r#"{"x": -985, "y": 1, "z": 940, "w": 180, "p": 0, "r": 0}"#,
            "J",
        ),
        // The flange forward at the height of the wrist: axes 4 and 6 in line.
        (
            r#"{"x": 985, "y": 0, "z": 1040, "w": 180, "p": -90, "r": 0}"#,
            "its distance from the wrist singularity is 0.00",
        ),
    ];
    for (body, reason) in cases {
        let reply = server.post("/fanuc/move", body).await;
        assert_eq!(reply.status, 409, "{body}: {reply:?}");
        let detail = reply.json()["detail"].as_str().unwrap().to_owned();
        assert!(detail.starts_with("ERROR: POINT UNREACHABLE: "), "{detail}");
        assert!(detail.contains(reason), "{detail}");
    }
    robot.assert_untouched();
}

/// Covers: H3.
#[tokio::test]
async fn a_velocity_that_is_no_whole_number_in_range_is_refused_with_its_limit() {
    let robot = FakeRobot::accepting().await;
    let mut section = robot_section(robot.address);
    section.max_speed_mm_s = 500;
    let server = TestServer::with_robot(section).await;
    let given = [
        "0", "-1", "2000", "501", "200.5", "2e2", "", "abc", "NaN", "99999999", "%ff",
    ];
    for velocity in given {
        for path in ["move", "home", "delta"] {
            let path = format!("/fanuc/{path}?velocity={velocity}");
            let reply = server.post(&path, POINT).await;
            assert_eq!(reply.status, 422, "{path}: {reply:?}");
            let item = &reply.json()["detail"][0];
            assert_eq!(item["loc"][0], "query");
            let message = item["msg"].as_str().unwrap();
            assert!(message.contains("500") || velocity == "%ff", "{message}");
        }
    }
    for query in ["speed=200", "velocity=200&velocity=300", "velocity=200&x=1"] {
        let reply = server.post(&format!("/fanuc/home?{query}"), "").await;
        assert_eq!(reply.status, 422, "{query}: {reply:?}");
    }
    robot.assert_untouched();
    assert_eq!(
        server.post("/fanuc/home?velocity=500", "").await.status,
        200
    );
}
