//! The operator's set-up over HTTP.

use serde_json::{Value, json};

use crate::support::{FakeRobot, HttpReply, TestServer};

const SETUP: &str = "/api/v1/cells/c1/setup";
const DEMO: &str = include_str!("../../../cell/demo.setup.toml");
const TOML: (&str, &str) = ("content-type", "application/toml");
const JSON: (&str, &str) = ("content-type", "application/json");

/// A server with the demo's set-up, and the entity tag of it.
async fn demo() -> (TestServer, String) {
    let server = TestServer::start(&FakeRobot::accepting().await).await;
    let empty = server.get(SETUP).await;
    assert_eq!(empty.json(), json!({"format": 1}));
    let etag = empty.header("etag").unwrap().to_owned();
    let put = server
        .request("PUT", SETUP, &[TOML, ("if-match", &etag)], DEMO)
        .await;
    let etag = changed(&put);
    (server, etag)
}

/// The entity tag after a change that was made.
fn changed(reply: &HttpReply) -> String {
    assert_eq!(reply.status, 200, "{reply:?}");
    let etag = reply.header("etag").unwrap().to_owned();
    assert_eq!(reply.json()["etag"], etag);
    etag
}

async fn put(server: &TestServer, path: &str, etag: &str, body: &Value) -> HttpReply {
    let path = format!("{SETUP}/{path}");
    let headers = [JSON, ("if-match", etag)];
    server
        .request("PUT", &path, &headers, &body.to_string())
        .await
}

#[tokio::test]
async fn what_is_exported_is_imported_as_the_same_in_both_forms() {
    let (server, etag) = demo().await;
    for accept in ["application/toml", "application/json"] {
        let exported = server
            .request("GET", SETUP, &[("accept", accept)], "")
            .await;
        assert_eq!(exported.header("content-type"), Some(accept));
        assert_eq!(exported.header("etag"), Some(&*etag));
        let headers = [("content-type", accept), ("if-match", &*etag)];
        let imported = server.request("PUT", SETUP, &headers, &exported.body).await;
        assert_eq!(imported.json()["changed"], json!([]));
        assert_eq!(changed(&imported), etag);
    }
}

#[tokio::test]
async fn h12_a_change_names_the_revision_it_is_based_on() {
    let (server, etag) = demo().await;
    let zone = server.get(&format!("{SETUP}/zones/floor")).await;
    assert_eq!(zone.header("etag"), Some(&*etag));
    let zone = zone.json();
    let path = format!("{SETUP}/zones/floor");
    for headers in [
        &[JSON][..],
        &[JSON, ("if-match", "*")],
        &[JSON, ("if-match", "")],
    ] {
        let reply = server
            .request("PUT", &path, headers, &zone.to_string())
            .await;
        let _problem = reply.problem(428, "precondition-required", "NONE");
    }
    // Two panels have read the same revision; the second one is told.
    let mut first = zone.clone();
    first["name"] = json!("Hall");
    let mut second = zone.clone();
    second["name"] = json!("Floor");
    let now = changed(&put(&server, "zones/floor", &etag, &first).await);
    assert_ne!(now, etag);
    let stale = put(&server, "zones/floor", &etag, &second).await;
    let problem = stale.problem(412, "precondition-failed", "NONE");
    assert!(
        problem["detail"].as_str().unwrap().contains(&now),
        "{problem}"
    );
    let weak = put(&server, "zones/floor", &format!("W/{now}"), &second).await;
    let _problem = weak.problem(412, "precondition-failed", "NONE");
    let _stale = server
        .request("DELETE", &path, &[("if-match", &etag)], "")
        .await
        .problem(412, "precondition-failed", "NONE");
    assert_eq!(server.get(&path).await.json()["name"], "Hall");
    let several = format!("\"1-x\", {now}");
    let _now = changed(&put(&server, "zones/floor", &several, &second).await);
}

#[tokio::test]
async fn every_kind_of_part_is_read_put_and_deleted() {
    let (server, mut etag) = demo().await;
    let whole = server.get(SETUP).await.json();
    for (path, list) in [
        ("arms/r1", "arms"),
        ("tools/r1/1", "tools"),
        ("zones/floor", "zones"),
        ("stations/handover", "stations"),
        ("places/rack%2Ff", "places"),
        ("taught-poses/r1/rack%2Ff", "taught_poses"),
        ("destinations/warehouse", "destinations"),
        ("mobile-robots/mr1", "mobile_robots"),
        ("routes/front-gate", "routes"),
        ("loads/load-4", "loads"),
    ] {
        let part = server.get(&format!("{SETUP}/{path}")).await;
        assert_eq!(part.status, 200, "{path}");
        let part = part.json();
        assert!(whole[list].as_array().unwrap().contains(&part), "{path}");
        // The same again is no change.
        assert_eq!(changed(&put(&server, path, &etag, &part).await), etag);
        let _absent =
            server
                .get(&format!("{SETUP}/{path}x"))
                .await
                .problem(404, "not-found", "NONE");
    }
    for path in [
        "loads/load-4",
        "taught-poses/r1/rack%2Ff",
        "places/rack%2Ff",
        "routes/front-gate",
    ] {
        let path = format!("{SETUP}/{path}");
        let gone = server
            .request("DELETE", &path, &[("if-match", &etag)], "")
            .await;
        etag = changed(&gone);
        let again = server
            .request("DELETE", &path, &[("if-match", &etag)], "")
            .await;
        let _absent = again.problem(404, "not-found", "NONE");
    }
    let load = json!({"id": "load-9", "type": "crate", "place": "rack/c"});
    let added = put(&server, "loads/load-9", &etag, &load).await;
    assert_eq!(added.json()["changed"], json!(["loads/load-9"]));
}

#[tokio::test]
async fn what_others_refer_to_is_not_deleted_and_they_are_listed() {
    let (server, etag) = demo().await;
    for (path, items) in [
        ("zones/front", &["stations[0].points[0].zone"][..]),
        (
            "places/rack%2Fa",
            &["taught_poses[0].place", "loads[1].place"],
        ),
        (
            "mobile-robots/mr1",
            &[
                "zones[1].robots[0]",
                "zones[5].robots[0]",
                "places[7].slot",
                "places[8].slot",
                "loads[0].on.mobile_robot",
            ],
        ),
        ("tools/r1/1", &["arms[0].tool"]),
    ] {
        let path = format!("{SETUP}/{path}");
        let reply = server
            .request("DELETE", &path, &[("if-match", &etag)], "")
            .await;
        let problem = reply.problem(409, "still-referenced", "NONE");
        let listed: Vec<_> = problem["violations"]
            .as_array()
            .unwrap()
            .iter()
            .map(|found| found["item"].as_str().unwrap())
            .collect();
        assert_eq!(listed, items, "{path}");
    }
    assert_eq!(server.get(SETUP).await.header("etag"), Some(&*etag));
}

#[tokio::test]
async fn a_set_up_that_does_not_fit_is_refused_whole_with_everything_wrong() {
    let (server, etag) = demo().await;
    let bad = DEMO
        .replacen("zone = \"front\"", "zone = \"back\"", 1)
        .replacen("approach_mm = 150", "approach_mm = 0", 1);
    let reply = server
        .request("PUT", SETUP, &[TOML, ("if-match", &etag)], &bad)
        .await;
    let problem = reply.problem(422, "validation", "NONE");
    assert_eq!(
        problem["violations"].as_array().unwrap().len(),
        2,
        "{problem}"
    );
    for (content, body, status, code) in [
        ("application/toml", "format = ", 400, "invalid-toml"),
        ("application/json", "{", 400, "invalid-json"),
        (
            "application/json",
            r#"{"format": 1, "epoch": 3}"#,
            422,
            "validation",
        ),
        (
            "application/json",
            r#"{"format": 1, "mobile_robots": [{"push_url": "http://a/"}]}"#,
            422,
            "validation",
        ),
        ("text/plain", "format = 1", 415, "unsupported-media-type"),
    ] {
        let headers = [("content-type", content), ("if-match", &*etag)];
        let reply = server.request("PUT", SETUP, &headers, body).await;
        assert_eq!(
            (reply.status, reply.json()["code"].as_str()),
            (status, Some(code)),
            "{body}"
        );
    }
    let huge = "#".repeat(1024 * 1024 + 1);
    let reply = server
        .request("PUT", SETUP, &[TOML, ("if-match", &etag)], &huge)
        .await;
    let _problem = reply.problem(413, "payload-too-large", "NOT_SENT");
    let other = json!({"id": "load-2", "type": "crate", "place": "rack/d"});
    let reply = put(&server, "loads/load-3", &etag, &other).await;
    let _problem = reply.problem(422, "validation", "NONE");
    assert_eq!(server.get(SETUP).await.header("etag"), Some(&*etag));
}

#[tokio::test]
async fn a_check_plans_what_holds_or_what_is_sent_and_changes_nothing() {
    let (server, etag) = demo().await;
    let path = format!("{SETUP}/check");
    let check = server.request("POST", &path, &[], "").await;
    assert_eq!(
        (check.status, &check.json()["passed"]),
        (200, &json!(true)),
        "{check:?}"
    );
    assert_eq!(check.json()["revision"], 2);
    assert_eq!(check.json()["taught_poses"].as_array().unwrap().len(), 9);
    let far = DEMO.replacen("x_mm = 500, y_mm = 1000", "x_mm = 2500, y_mm = 1000", 1);
    let check = server.request("POST", &path, &[TOML], &far).await.json();
    assert_eq!(
        (&check["passed"], &check["revision"]),
        (&json!(false), &Value::Null)
    );
    assert_eq!(check["taught_poses"][0]["findings"][0]["severity"], "ERROR");
    let unfit = server.request("POST", &path, &[TOML], "format = 2").await;
    let _problem = unfit.problem(422, "validation", "NONE");
    assert_eq!(server.get(SETUP).await.header("etag"), Some(&*etag));
    let _absent = server
        .get("/api/v1/cells/c9/setup")
        .await
        .problem(404, "not-found", "NONE");
}

#[tokio::test]
async fn a_controller_that_reports_no_position_is_only_taught_with_an_explicit_pose() {
    let (server, etag) = demo().await;
    // The robot has accepted a target; that is not where it is.
    let moved = server
        .post(crate::support::MOTIONS, crate::support::MOTION)
        .await;
    assert_eq!(moved.status, 202);
    let path = format!("{SETUP}/taught-poses/r1/rack%2Fa/teach");
    let teach = async |body: Value| {
        let headers = [JSON, ("if-match", &*etag)];
        server
            .request("POST", &path, &headers, &body.to_string())
            .await
    };
    let problem = teach(json!({}))
        .await
        .problem(409, "no-actual-pose", "NONE");
    assert!(
        problem["detail"]
            .as_str()
            .unwrap()
            .contains("reports no position"),
        "{problem}"
    );
    let pose =
        json!({"x_mm": 480, "y_mm": 990, "z_mm": 650, "w_deg": 180, "p_deg": 0, "r_deg": 90});
    let at = json!({"pose": pose, "configuration": "NUT 000"});
    let taught = teach(json!({"at": at, "lift_mm": 80})).await;
    let result = taught.json();
    assert_eq!(taught.status, 200, "{taught:?}");
    assert_eq!(result["taught"]["configuration"], "N U T, 0, 0, 0");
    assert_eq!(
        (
            &result["taught"]["approach_mm"],
            &result["taught"]["lift_mm"]
        ),
        (&json!(150.0), &json!(80.0))
    );
    let kept = server
        .get(&format!("{SETUP}/taught-poses/r1/rack%2Fa"))
        .await;
    assert_eq!(kept.json(), result["taught"]);
    assert_eq!(kept.header("etag"), result["etag"].as_str());
    let _stale = teach(json!({"at": at}))
        .await
        .problem(412, "precondition-failed", "NONE");
}

#[tokio::test]
async fn a_tool_is_calibrated_from_joint_readings() {
    let (server, etag) = demo().await;
    let path = format!("{SETUP}/tools/r1/1/calibrate");
    // Four postures that hold the tip of the demo's gripper at one point, as inverse kinematics gives them.
    let mut points = Vec::new();
    for [w, p, r] in [
        [180.0, 0.0, 0.0],
        [165.0, 10.0, 40.0],
        [190.0, -20.0, -35.0],
        [175.0, 25.0, 60.0],
    ] {
        let rotation = |[x, y, z]: [f64; 3]| {
            let [(sw, cw), (sp, cp), (sr, cr)] =
                [w, p, r].map(|angle: f64| angle.to_radians().sin_cos());
            [
                cr * cp * x + (cr * sp * sw - sr * cw) * y + (cr * sp * cw + sr * sw) * z,
                sr * cp * x + (sr * sp * sw + cr * cw) * y + (sr * sp * cw - cr * sw) * z,
                -sp * x + cp * sw * y + cp * cw * z,
            ]
        };
        let [dx, dy, dz] = rotation([5.0, -3.0, 150.0]);
        let pose = json!({"x_mm": 950.0 - dx, "y_mm": 100.0 - dy, "z_mm": 300.0 - dz, "w_deg": w, "p_deg": p, "r_deg": r});
        let body = json!({"pose": pose}).to_string();
        let inverse = server
            .post("/api/v1/cells/c1/robots/r1/kinematics/inverse", &body)
            .await
            .json();
        points.push(json!({"joints": inverse["branches"][0]["joints"]}));
    }
    let reply = server
        .post(&path, &json!({"points": points}).to_string())
        .await;
    assert_eq!(reply.status, 200, "{reply:?}");
    let found = reply.json();
    for (key, wanted) in [
        ("x_mm", 5.0),
        ("y_mm", -3.0),
        ("z_mm", 150.0),
        ("r_deg", 0.0),
    ] {
        assert!(
            (found["frame"][key].as_f64().unwrap() - wanted).abs() < 1e-6,
            "{found}"
        );
    }
    assert!(found["uncertainty_mm"].as_f64().unwrap() < 1e-6);
    let mut tool = server.get(&format!("{SETUP}/tools/r1/1")).await.json();
    tool["frame"] = found["frame"].clone();
    tool["calibration"] = found["calibration"].clone();
    let _etag = changed(&put(&server, "tools/r1/1", &etag, &tool).await);

    points.truncate(3);
    let few = server
        .post(&path, &json!({"points": points}).to_string())
        .await;
    let _problem = few.problem(422, "calibration-refused", "NONE");
    let neither =
        server
            .post(&path, r#"{"points": [{}]}"#)
            .await
            .problem(422, "validation", "NONE");
    assert_eq!(neither["violations"][0]["item"], "points[0]");
}
