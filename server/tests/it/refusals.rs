//! What a refusal says: the right kind of problem, in a sentence of readable length, and that nothing was sent.

use crate::support::{FakeRobot, TestServer};

const MOTIONS: &str = "/api/v1/cells/c1/robots/r1/motions";

fn legacy(x: &str) -> String {
    format!(r#"{{"x": {x}, "y": 0, "z": 940, "w": 180, "p": 0, "r": 0}}"#)
}

fn motion(x: &str, speed: &str) -> String {
    format!(
        r#"{{"type": "JOINT", "speed_mm_s": {speed}, "target": {{"pose": {{"x_mm": {x}, "y_mm": 0, "z_mm": 940,
        "w_deg": 180, "p_deg": 0, "r_deg": 0}}}}}}"#
    )
}

#[tokio::test]
async fn valid_json_of_the_wrong_kind_is_not_called_invalid_json() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for (body, item, said) in [
        (
            r#"{"type": "JOINT", "speed_mm_s": 1, "target": {}}"#,
            "target",
            "object",
        ),
        (r#"{"type": 3, "speed_mm_s": 1}"#, "type", "integer `3`"),
        ("[1, 2, 3]", "[0]", "integer `1`"),
        (
            r#"{"type": "HOME", "speed_mm_s": "fast"}"#,
            "speed_mm_s",
            "expected a number",
        ),
        ("null", "body", "expected an object"),
    ] {
        let problem = server
            .post(MOTIONS, body)
            .await
            .problem(422, "validation", "NOT_SENT");
        let violation = &problem["violations"][0];
        assert_eq!(violation["item"], item, "{violation}");
        assert!(
            violation["message"].as_str().unwrap().contains(said),
            "{violation}"
        );
    }
    robot.assert_untouched();
}

/// Covers: H9.
#[tokio::test]
async fn an_empty_body_and_a_byte_order_mark_are_called_by_their_names() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for (body, said) in [
        ("", "the body is empty"),
        ("\u{feff}{}", "a byte order mark stands before the value"),
    ] {
        let problem = server
            .post(MOTIONS, body)
            .await
            .problem(400, "invalid-json", "NOT_SENT");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.starts_with(said), "{detail}");
        let legacy = server.post("/fanuc/move", body).await.json();
        let msg = legacy["detail"][0]["msg"].as_str().unwrap();
        assert!(
            msg.starts_with(&format!("the body is not valid JSON: {said}")),
            "{msg}"
        );
    }
    robot.assert_untouched();
}

#[tokio::test]
async fn a_refusal_does_not_repeat_pages_of_what_was_sent() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let key = "k".repeat(9_000);
    let long_key = format!(r#"{{"type": "HOME", "speed_mm_s": 1, "{key}": 1}}"#);
    for (path, body) in [
        (MOTIONS.to_owned(), long_key.as_str()),
        (MOTIONS.to_owned(), &motion("1e308", "1")),
        (MOTIONS.to_owned(), &motion("1", "1e308")),
        ("/fanuc/move".to_owned(), &legacy("1e308")),
        (format!("/fanuc/move?velocity={key}"), &legacy("985")),
        (format!("/fanuc/move?{key}=1"), &legacy("985")),
    ] {
        let reply = server.post(&path, body).await;
        assert_eq!(reply.status, 422, "{reply:?}");
        let said = reply.json();
        let shown = said["detail"].as_str();
        let shown = shown.or(said["detail"][0]["msg"].as_str()).unwrap();
        assert!(shown.len() < 400, "{} characters: {shown}", shown.len());
    }
    let reply = server.get(&format!("{MOTIONS}?cursor={key}")).await;
    assert!(reply.body.len() < 1_000, "{}", reply.body);
    robot.assert_untouched();
}

/// Covers: X8.
#[tokio::test]
async fn a_compressed_body_is_refused_by_the_name_of_its_encoding() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let body = legacy("985");
    let headers = [
        ("content-type", "application/json"),
        ("content-encoding", "gzip"),
    ];
    let problem = server
        .request("POST", "/fanuc/move", &headers, &body)
        .await
        .problem(415, "unsupported-media-type", "NOT_SENT");
    assert!(problem["detail"].as_str().unwrap().contains("`gzip`"));
    robot.assert_untouched();
}

#[tokio::test]
async fn a_plus_sign_does_not_slip_into_a_velocity() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for velocity in ["+300", "%2B300"] {
        let path = format!("/fanuc/move?velocity={velocity}");
        let reply = server.post(&path, &legacy("985")).await;
        assert_eq!(reply.status, 422, "{reply:?}");
    }
    robot.assert_untouched();
}

#[tokio::test]
async fn a_command_that_is_turned_away_at_the_door_says_that_nothing_was_sent() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let body = motion("985", "200");
    for (path, status, code) in [
        ("/api/v1/cells/c1/robots/nobody/motions", 404, "not-found"),
        ("/api/v1/cells/nowhere/robots/r1/motions", 404, "not-found"),
        ("/fanuc/mvoe", 404, "not-found"),
        ("/livez", 405, "method-not-allowed"),
    ] {
        let _problem = server
            .post(path, &body)
            .await
            .problem(status, code, "NOT_SENT");
    }
    let problem =
        server
            .post(MOTIONS, &motion("3e6", "200"))
            .await
            .problem(422, "validation", "NOT_SENT");
    let violation = &problem["violations"][0];
    assert_eq!(violation["min"], -2_147_483.648);
    assert_eq!(violation["max"], 2_147_483.647);
    robot.assert_untouched();
}
