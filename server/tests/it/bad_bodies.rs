//! Bodies that are no JSON, or not the right JSON. Nothing of them reaches a robot.

use serde_json::Value;

use crate::support::{FakeRobot, TestServer};

const MOTIONS: &str = "/api/v1/cells/c1/robots/r1/motions";
const FORWARD: &str = "/api/v1/cells/c1/robots/r1/kinematics/forward";

fn legacy(x: &str) -> String {
    format!(r#"{{"x": {x}, "y": 0, "z": 940, "w": 180, "p": 0, "r": 0}}"#)
}

fn motion(x: &str, speed: &str) -> String {
    format!(
        r#"{{"type": "JOINT", "speed_mm_s": {speed}, "target": {{"pose": {{"x_mm": {x}, "y_mm": 0, "z_mm": 940,
        "w_deg": 180, "p_deg": 0, "r_deg": 0}}}}}}"#
    )
}

/// Covers: H9.
#[tokio::test]
async fn what_is_no_json_is_named_with_its_position() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for text in [
        "NaN",
        "Infinity",
        "-Infinity",
        "1e999",
        "-1e999",
        "01",
        "+1",
        ".5",
        "0x10",
        "",
    ] {
        let reply = server.post("/fanuc/move", &legacy(text)).await;
        assert_eq!(reply.status, 422, "{text}: {reply:?}");
        let item = &reply.json()["detail"][0];
        assert_eq!(item["type"], "json_invalid", "{text}: {item}");
        assert!(item["msg"].as_str().unwrap().contains("line 1, column"));

        let reply = server.post(MOTIONS, &motion(text, "200")).await;
        let problem = reply.problem(400, "invalid-json", "NOT_SENT");
        assert!(
            problem["detail"]
                .as_str()
                .unwrap()
                .contains("line 1, column")
        );
    }
    for text in ["", "{", "\u{feff}{}", "{} {}", "[1]]", &"[".repeat(10_000)] {
        let reply = server.post(MOTIONS, text).await;
        assert!(matches!(reply.status, 400 | 422), "{text}: {reply:?}");
        assert_eq!(server.post("/fanuc/move", text).await.status, 422);
    }
    let trailing = format!("{} 1", motion("985", "200"));
    let _problem = server
        .post(MOTIONS, &trailing)
        .await
        .problem(400, "invalid-json", "NOT_SENT");
    robot.assert_untouched();
}

/// Covers: H9, H1.
#[tokio::test]
async fn a_key_that_is_missing_unknown_double_or_of_another_type_is_named() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let legacy_cases: [(&str, &[&str], &str); 6] = [
        (
            r#"{"x":"985","y":0,"z":940,"w":180,"p":0,"r":0}"#,
            &["body", "x"],
            "float_type",
        ),
        (
            r#"{"x":null,"y":0,"z":940,"w":180,"p":0,"r":0}"#,
            &["body", "x"],
            "float_type",
        ),
        (
            r#"{"x":985,"y":0,"z":940,"w":180,"p":0}"#,
            &["body", "r"],
            "missing",
        ),
        (
            r#"{"x":985,"y":0,"z":940,"w":180,"p":0,"r":0,"q":1}"#,
            &["body", "q"],
            "extra_forbidden",
        ),
        (
            r#"{"x":985,"x":985,"y":0,"z":940,"w":180,"p":0,"r":0}"#,
            &["body", "x"],
            "duplicate",
        ),
        ("[985,0,940,180,0,0]", &["body"], "type_error"),
    ];
    for (body, loc, kind) in legacy_cases {
        let reply = server.post("/fanuc/move", body).await;
        assert_eq!(reply.status, 422, "{body}: {reply:?}");
        let item = &reply.json()["detail"][0];
        assert_eq!(item["type"], kind, "{body}: {item}");
        let found: Vec<_> = item["loc"]
            .as_array()
            .unwrap()
            .iter()
            .map(|part| part.as_str().unwrap())
            .collect();
        assert_eq!(found, loc, "{body}: {item}");
    }
    let good = motion("985", "200");
    let motion_cases = [
        (good.replace("985", r#""985""#), "target.pose.x_mm"),
        (good.replace(r#""y_mm": 0, "#, ""), "target.pose.y_mm"),
        (good.replace("y_mm", "y"), "target.pose.y"),
        (
            good.replace(r#""y_mm": 0"#, r#""x_mm": 0, "y_mm": 0"#),
            "target.pose.x_mm",
        ),
        (good.replace("JOINT", "SPIRAL"), "type"),
        (good.replace("speed_mm_s", "speed"), "speed"),
        (good.replace(r#""type": "JOINT", "#, ""), "type"),
        ("null".to_owned(), "body"),
    ];
    for (body, item) in motion_cases {
        let problem = server
            .post(MOTIONS, &body)
            .await
            .problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], item, "{body}: {problem}");
    }
    robot.assert_untouched();
}

/// Covers: H1, H2, H3.
#[tokio::test]
async fn a_number_the_wire_cannot_carry_is_refused_with_its_value_and_limit() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for x in ["2147483.648", "-2147483.649", "1e300"] {
        let reply = server.post("/fanuc/move", &legacy(x)).await;
        assert_eq!(reply.status, 422, "{x}: {reply:?}");
        let item = &reply.json()["detail"][0];
        assert_eq!(item["loc"][1], "x");
        assert!(
            item["msg"].as_str().unwrap().contains("2147483.647"),
            "{item}"
        );

        let reply = server.post(MOTIONS, &motion(x, "200")).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        let violation = &problem["violations"][0];
        assert_eq!(violation["item"], "target.pose.x_mm");
        let value: f64 = x.parse().unwrap();
        assert_eq!(violation["value"], Value::from(value));
    }
    for speed in ["0", "-1", "2000", "200.5", "1e300"] {
        let reply = server.post(MOTIONS, &motion("985", speed)).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        let violation = &problem["violations"][0];
        assert_eq!(violation["item"], "speed_mm_s");
        assert_eq!(
            (&violation["min"], &violation["max"]),
            (&Value::from(1.0), &Value::from(1999.0))
        );
    }
    robot.assert_untouched();
}

/// Covers: H9.
#[tokio::test]
async fn a_body_that_is_too_large_is_not_read() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let body = format!("{}{}", " ".repeat(64 * 1024), legacy("985"));
    for path in ["/fanuc/move", MOTIONS, FORWARD] {
        let reply = server.post(path, &body).await;
        let problem = reply.problem(413, "payload-too-large", "NOT_SENT");
        assert!(problem["detail"].as_str().unwrap().contains("65536"));
    }
    // In chunks, so that no length announces it.
    let chunk = format!("{:x}\r\n{}\r\n", 1 << 14, " ".repeat(1 << 14)).repeat(5);
    let headers = [
        ("content-type", "application/json"),
        ("transfer-encoding", "chunked"),
    ];
    let reply = server
        .request("POST", MOTIONS, &headers, &format!("{chunk}0\r\n\r\n"))
        .await;
    let _problem = reply.problem(413, "payload-too-large", "NOT_SENT");
    robot.assert_untouched();
}

/// Covers: H9.
#[tokio::test]
async fn another_content_type_is_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let cases: [&[(&str, &str)]; 4] = [
        &[],
        &[("content-type", "text/plain")],
        &[("content-type", "application/x-www-form-urlencoded")],
        &[("content-type", "application/jsonx")],
    ];
    for headers in cases {
        for path in ["/fanuc/move", MOTIONS, FORWARD] {
            let reply = server.request("POST", path, headers, &legacy("985")).await;
            let _problem = reply.problem(415, "unsupported-media-type", "NOT_SENT");
        }
    }
    let headers = [
        ("content-type", "Application/JSON; charset=utf-8"),
        ("idempotency-key", "k1"),
    ];
    let reply = server
        .request("POST", MOTIONS, &headers, &motion("985", "200"))
        .await;
    assert_eq!(reply.status, 202, "{reply:?}");
}

#[tokio::test]
async fn a_body_cut_short_is_never_a_command() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let (whole_legacy, whole_motion) = (legacy("985"), motion("985", "200"));
    for (path, whole) in [("/fanuc/move", whole_legacy), (MOTIONS, whole_motion)] {
        for cut in 0..whole.len() {
            let reply = server.post(path, &whole[..cut]).await;
            assert!(matches!(reply.status, 400 | 422), "{cut}: {reply:?}");
        }
    }
    robot.assert_untouched();
}
