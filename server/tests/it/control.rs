//! Control authority over HTTP: who may move the robots now.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::support::{
    ACCEPTED, Act, FakeRobot, MOTION, MOTIONS, Secured, TestServer, control_of, wait_until,
};

/// The epoch of the first lease: the journal in memory is opened for the first time.
const FIRST_EPOCH: u64 = 1_000_001;
const CONTROL: &str = "/api/v1/cells/c1/control-authority";

fn lease(token: &str) -> String {
    format!("{CONTROL}/{}", token.split('.').next().unwrap())
}

#[tokio::test]
async fn nothing_moves_without_control() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let json = ("content-type", "application/json");
    let reply = server.bare("POST", MOTIONS, &[json], MOTION).await;
    let problem = reply.problem(428, "control-required", "NOT_SENT");
    assert!(
        problem["detail"].as_str().unwrap().contains(CONTROL),
        "{problem}"
    );
    let twice = [json, ("control-token", "a.1"), ("control-token", "a.1")];
    for headers in [&[json, ("control-token", "x")][..], &twice] {
        let reply = server.bare("POST", MOTIONS, headers, MOTION).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], "Control-Token");
    }
    let never_given = format!("{}.1", uuid::Uuid::from_u128(1));
    let headers = [json, ("control-token", never_given.as_str())];
    let reply = server.bare("POST", MOTIONS, &headers, MOTION).await;
    let _problem = reply.problem(409, "control-lost", "NOT_SENT");
    robot.assert_untouched();
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
}

/// O2.
#[tokio::test]
async fn o2_of_two_operators_one_has_control_and_the_other_sees_who() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let (anna, boris) = (
        cell.token("anna", "operator").await,
        cell.token("boris", "operator").await,
    );
    let annas = control_of(&cell.acquire(&anna, &json!({"reason": "teach check"})).await);
    for reply in [
        cell.acquire(&boris, &json!({})).await,
        cell.motion(&boris, None).await,
        cell.motion(&boris, Some(&annas)).await,
    ] {
        let problem = reply.problem(423, "control-held", "NOT_SENT");
        let control = &problem["control"];
        assert_eq!(
            (&control["holder"], &control["station"]),
            (&json!("anna"), &json!("REMOTE"))
        );
        assert_eq!(control["reason"], "teach check");
        assert!(control["since"].is_string() && control["expires"].is_string());
    }
    assert_eq!(cell.motion(&anna, Some(&annas)).await.status, 202);
    let problem = cell.motion(&anna, None).await;
    let _problem = problem.problem(428, "control-required", "NOT_SENT");
    let view = cell.get(CONTROL, &boris).await.json();
    assert_eq!(
        (&view["held"]["holder"], &view["jobs_may_act"]),
        (&json!("anna"), &json!(false))
    );
    // Neither keeps nor gives back what is not his.
    for method in ["PUT", "DELETE"] {
        let reply = cell
            .send(method, &lease(&annas), &boris, &Value::Null)
            .await;
        assert_eq!(reply.json()["code"], "control-held");
    }
    assert_eq!(robot.commands().len(), 1);
}

/// O2: what lets the arm move, or move faster, needs control as a motion does; what makes it stand does not.
#[tokio::test]
async fn resuming_and_speeding_up_need_control_and_holding_does_not() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let (anna, boris) = (
        cell.token("anna", "operator").await,
        cell.token("boris", "operator").await,
    );
    let r1 = "/api/v1/cells/c1/robots/r1";
    let resume = format!("{r1}/motions/019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11/resume");
    let pause = resume.replace("resume", "pause");
    let speed = format!("{r1}/speed-override");
    let percent = json!({"percent": 100});
    for (status, code) in [(428, "control-required"), (423, "control-held")] {
        for (method, path, body) in [("POST", &resume, &Value::Null), ("PUT", &speed, &percent)] {
            let reply = cell.send(method, path, &boris, body).await;
            let _problem = reply.problem(status, code, "NOT_SENT");
        }
        let reply = cell.send("POST", &pause, &boris, &Value::Null).await;
        let _problem = reply.problem(404, "not-found", "NOT_SENT");
        let _annas = cell.acquire(&anna, &json!({})).await;
    }
}

#[tokio::test]
async fn of_two_clients_that_race_exactly_one_wins() {
    let robot = FakeRobot::accepting().await;
    let server = Arc::new(TestServer::start(&robot).await);
    let clients: Vec<_> = (0..12)
        .map(|_| {
            let server = Arc::clone(&server);
            let body = r#"{"station": "REMOTE", "reason": "a race"}"#;
            tokio::spawn(async move { server.post(CONTROL, body).await.status })
        })
        .collect();
    let mut statuses = Vec::new();
    for client in clients {
        statuses.push(client.await.unwrap());
    }
    statuses.sort_unstable();
    assert_eq!(statuses[0], 201);
    assert!(
        statuses[1..].iter().all(|status| *status == 423),
        "{statuses:?}"
    );
    assert_eq!(server.get(CONTROL).await.json()["epoch"], FIRST_EPOCH);
}

#[tokio::test]
async fn a_stolen_lease_moves_nothing_any_more_not_even_what_waits() {
    let robot = FakeRobot::start([Act::Held(ACCEPTED)]).await;
    let cell = Arc::new(Secured::start(&robot).await);
    let remote = cell.token("remote", "operator").await;
    let panel = json!({"local_station": true});
    let panel = cell.scoped("panel", "operator", panel).await;
    let old = control_of(&cell.acquire(&remote, &json!({})).await);
    let ask = || {
        let (cell, remote, old) = (Arc::clone(&cell), remote.clone(), old.clone());
        tokio::spawn(async move { cell.motion(&remote, Some(&old)).await })
    };
    let sent = ask();
    wait_until("the first motion is with the robot", || {
        robot.commands().len() == 1
    })
    .await;
    let waiting = ask();
    while cell
        .get("/api/v1/cells/c1/robots/r1/state", &remote)
        .await
        .json()["queued"]
        != 1
    {}

    let taken = json!({"station": "LOCAL", "reason": "someone is inside"});
    let local = control_of(&cell.acquire(&panel, &taken).await);
    robot.release();
    assert_eq!(sent.await.unwrap().status, 202);
    for reply in [
        waiting.await.unwrap(),
        cell.motion(&remote, Some(&old)).await,
    ] {
        let problem = reply.problem(409, "control-lost", "NOT_SENT");
        let detail = problem["detail"].as_str().unwrap();
        assert!(
            detail.contains("taken by `panel`") && detail.contains("someone is inside"),
            "{detail}"
        );
    }
    assert_eq!(robot.commands().len(), 1);
    let view = cell.get(CONTROL, &remote).await.json();
    assert_eq!(
        (&view["last"]["end"], &view["epoch"]),
        (&json!("PREEMPTED"), &json!(FIRST_EPOCH + 1))
    );
    // REMOTE never takes from LOCAL, and the late heartbeat brings nothing back.
    assert_eq!(cell.acquire(&remote, &json!({})).await.status, 423);
    let beat = cell.send("PUT", &lease(&old), &remote, &Value::Null).await;
    let _problem = beat.problem(409, "control-lost", "NOT_SENT");
    let moved = tokio::spawn(async move { cell.motion(&panel, Some(&local)).await });
    wait_until("the panel's motion is with the robot", || {
        robot.commands().len() == 2
    })
    .await;
    robot.release();
    assert_eq!(moved.await.unwrap().status, 202);
}

#[tokio::test]
async fn local_and_preemption_are_for_those_they_were_given_to() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let anna = cell.token("anna", "operator").await;
    for body in [json!({"station": "LOCAL"}), json!({"preempt": true})] {
        let reply = cell.acquire(&anna, &body).await;
        let _problem = reply.problem(403, "forbidden", "NOT_SENT");
    }
    let annas = control_of(&cell.acquire(&anna, &json!({})).await);
    let admin = &cell.admin;
    assert_eq!(cell.acquire(admin, &json!({})).await.status, 423);
    let taken = json!({"preempt": true, "reason": "maintenance"});
    let admins = control_of(&cell.acquire(admin, &taken).await);
    let lost = cell.motion(&anna, Some(&annas)).await;
    let problem = lost.problem(409, "control-lost", "NOT_SENT");
    assert!(problem["detail"].as_str().unwrap().contains("maintenance"));
    // An admin who has control still moves nothing.
    let moved = cell.motion(admin, Some(&admins)).await;
    let _problem = moved.problem(403, "forbidden", "NOT_SENT");
    robot.assert_untouched();
}

#[tokio::test]
async fn control_is_kept_handed_on_and_given_back() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let (anna, boris) = (
        cell.token("anna", "operator").await,
        cell.token("boris", "operator").await,
    );
    let annas = control_of(&cell.acquire(&anna, &json!({"ttl_s": 2})).await);
    let kept = cell.send("PUT", &lease(&annas), &anna, &Value::Null).await;
    assert_eq!((kept.status, &kept.json()["ttl_s"]), (200, &json!(2)));
    assert_eq!(kept.json()["loss_behavior"], "STOP_1");

    let path = format!("{}/transfer", lease(&annas));
    let nobody = json!({"to": "zoe", "reason": "shift"});
    let reply = cell.send("POST", &path, &anna, &nobody).await;
    let _problem = reply.problem(422, "validation", "NOT_SENT");
    let to = json!({"to": "boris", "reason": "shift"});
    let handed = control_of(&cell.send("POST", &path, &anna, &to).await);
    assert_eq!(
        cell.motion(&anna, Some(&annas)).await.json()["code"],
        "control-lost"
    );
    assert_eq!(
        cell.motion(&anna, Some(&handed)).await.json()["code"],
        "control-held"
    );
    let found = cell.get(CONTROL, &boris).await.json()["held"]["token"].clone();
    assert_eq!(found, handed.as_str());
    assert_eq!(cell.motion(&boris, Some(&handed)).await.status, 202);
    for _ in 0..2 {
        let back = cell
            .send("DELETE", &lease(&handed), &boris, &Value::Null)
            .await;
        assert_eq!(
            (back.status, &back.json()["jobs_may_act"]),
            (200, &json!(true))
        );
    }
    let view = cell.get(CONTROL, &anna).await.json();
    assert_eq!(
        (&view["last"]["end"], &view["epoch"]),
        (&json!("RELEASED"), &json!(FIRST_EPOCH + 1))
    );
    let _again = control_of(&cell.acquire(&anna, &json!({})).await);
}

/// X4.
#[tokio::test]
async fn x4_a_request_for_control_that_does_not_fit_is_refused() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let anna = cell.token("anna", "operator").await;
    let long = "x".repeat(201);
    for (body, item) in [
        (json!({"ttl_s": 1}), "ttl_s"),
        (json!({"ttl_s": 61}), "ttl_s"),
        (json!({"reason": ""}), "reason"),
        (json!({"reason": "  "}), "reason"),
        (json!({"reason": "a\nb"}), "reason"),
        (json!({"reason": long}), "reason"),
        (json!({"epoch": 99}), "epoch"),
        (json!({"holder": "boris"}), "holder"),
        (json!({"station": "ELSEWHERE"}), "station"),
        (json!({"loss_behavior": "RUN"}), "loss_behavior"),
    ] {
        let reply = cell.acquire(&anna, &body).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], item, "{problem}");
    }
    for path in [
        format!("{CONTROL}/x"),
        "/api/v1/cells/c9/control-authority/x".to_owned(),
    ] {
        let reply = cell.send("DELETE", &path, &anna, &Value::Null).await;
        let _problem = reply.problem(404, "not-found", "NONE");
    }
    assert_eq!(cell.get(CONTROL, &anna).await.json()["epoch"], 0);
}

#[tokio::test]
async fn the_thesiss_routes_wait_while_somebody_has_control() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let home =
        async |headers: &[(&str, &str)]| server.bare("POST", "/fanuc/home", headers, "").await;
    assert_eq!(home(&[]).await.status, 200);
    let control = server.control().await;
    let refused = home(&[]).await;
    assert_eq!(refused.status, 409);
    let detail = refused.json()["detail"].as_str().unwrap().to_owned();
    assert!(
        detail.starts_with("ERROR: NO CONTROL: `demo` has control"),
        "{detail}"
    );
    assert_eq!(home(&[("control-token", control)]).await.status, 200);
    let back = server.bare("DELETE", &lease(control), &[], "").await;
    assert_eq!(back.status, 200);
    assert_eq!(home(&[]).await.status, 200);
    assert_eq!(robot.commands().len(), 3);
}

#[tokio::test]
async fn whoevers_token_is_revoked_has_no_control_any_more() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let (anna, boris) = (
        cell.token("anna", "operator").await,
        cell.token("boris", "operator").await,
    );
    let _annas = control_of(&cell.acquire(&anna, &json!({})).await);
    let id = anna.split('_').nth(1).unwrap();
    let path = format!("/api/v1/tokens/{id}");
    let revoked = cell.send("DELETE", &path, &cell.admin, &Value::Null).await;
    assert_eq!(revoked.status, 200);
    while cell.get(CONTROL, &boris).await.json()["held"].is_object() {}
    let view = cell.get(CONTROL, &boris).await.json();
    assert_eq!(view["last"]["end"], "REVOKED");
}
