//! Keys, deadlines, preferences: what a caller may say about a motion beside where to.

use std::sync::Arc;

use serde_json::{Value, json};

use crate::legacy_moves::POINT;
use crate::support::{
    ACCEPTED, Act, FakeRobot, MOTION, MOTIONS, TestServer, fresh_key, robot_section, wait_until,
};

const STOP: &str = "/api/v1/cells/c1/robots/r1/stop";
const STATE: &str = "/api/v1/cells/c1/robots/r1/state";
const PREVIEW: &str = "/api/v1/cells/c1/robots/r1/motions/preview";

/// `MOTION` with more keys.
fn with(more: &Value) -> String {
    let mut body: Value = serde_json::from_str(MOTION).unwrap();
    for (key, value) in more.as_object().unwrap() {
        body[key] = value.clone();
    }
    body.to_string()
}

async fn held() -> (FakeRobot, Arc<TestServer>) {
    let robot = FakeRobot::start([Act::Held(ACCEPTED)]).await;
    let server = TestServer::with_robot(robot_section(robot.address)).await;
    (robot, Arc::new(server))
}

fn post(
    server: &Arc<TestServer>,
    key: &str,
    body: &str,
) -> tokio::task::JoinHandle<crate::support::HttpReply> {
    let (server, key, body) = (Arc::clone(server), key.to_owned(), body.to_owned());
    tokio::spawn(async move { server.post_with_key(MOTIONS, &key, &body).await })
}

/// H6: the same key and body are the same motion, with the same answer, whatever the blanks between them.
#[tokio::test]
async fn the_same_request_again_is_answered_and_not_sent() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let first = server.post_with_key(MOTIONS, "k1", MOTION).await;
    assert_eq!(first.header("idempotency-replayed"), None);
    let respaced = MOTION.replace([' ', '\n'], "");
    for body in [MOTION, &respaced] {
        let again = server.post_with_key(MOTIONS, "\"k1\"", body).await;
        assert_eq!(again.status, 202);
        assert_eq!(again.header("idempotency-replayed"), Some("true"));
        assert_eq!(again.header("location"), first.header("location"));
        assert_eq!(again.json(), first.json());
    }
    assert_eq!(robot.commands().len(), 1);
}

/// H6: what went wrong is answered again, too, while the next motion is refused for it.
#[tokio::test]
async fn a_failure_is_answered_again_and_not_tried_again() {
    let robot = FakeRobot::start([Act::Reply("ERROR: POINT UNREACHABLE"), Act::CloseAfter("")]);
    let robot = robot.await;
    let server = TestServer::start(&robot).await;
    for (key, status, code, outcome) in [
        ("k1", 409, "controller-rejected", "REJECTED"),
        ("k2", 504, "controller-timeout", "UNKNOWN"),
    ] {
        let first = server.post_with_key(MOTIONS, key, MOTION).await;
        let first = first.problem(status, code, outcome);
        let again = server.post_with_key(MOTIONS, key, MOTION).await;
        assert_eq!(again.header("idempotency-replayed"), Some("true"));
        let again = again.problem(status, code, outcome);
        assert_eq!(again["motion"], first["motion"]);
        assert_eq!(again["detail"], first["detail"]);
    }
    assert_eq!(robot.commands().len(), 2);
    let refused = server.post(MOTIONS, MOTION).await;
    let _problem = refused.problem(409, "in-doubt", "NOT_SENT");
    assert_eq!(robot.commands().len(), 2);
}

/// H7: the same key with another body, or for another robot's path, is refused.
#[tokio::test]
async fn a_key_of_another_request_is_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    assert_eq!(
        server.post_with_key(MOTIONS, "k1", MOTION).await.status,
        202
    );
    let other = MOTION.replace("200", "201");
    let reply = server.post_with_key(MOTIONS, "k1", &other).await;
    let _problem = reply.problem(422, "idempotency-mismatch", "NOT_SENT");
    assert_eq!(robot.commands().len(), 1);
}

/// H7: the same key while the first request is being answered.
#[tokio::test]
async fn a_key_whose_first_request_is_under_way_is_refused_until_it_is_answered() {
    let (robot, server) = held().await;
    let first = post(&server, "k1", MOTION);
    wait_until("the robot has the command", || robot.commands().len() == 1).await;
    let reply = server.post_with_key(MOTIONS, "k1", MOTION).await;
    let _problem = reply.problem(409, "idempotency-in-flight", "NOT_SENT");
    assert_eq!(reply.header("retry-after"), Some("1"));
    robot.release();
    let first = first.await.unwrap();
    let again = server.post_with_key(MOTIONS, "k1", MOTION).await;
    assert_eq!(again.json(), first.json());
    assert_eq!(robot.commands().len(), 1);
}

/// H8
#[tokio::test]
async fn a_motion_without_a_key_is_refused() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let headers = [("content-type", "application/json")];
    let reply = server.request("POST", MOTIONS, &headers, MOTION).await;
    let _problem = reply.problem(400, "idempotency-missing", "NOT_SENT");
    for wrong in ["", "two words", &"x".repeat(129)] {
        let reply = server.post_with_key(MOTIONS, wrong, MOTION).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], "Idempotency-Key");
    }
    robot.assert_untouched();
}

/// H10: the caller goes away; the motion keeps the state it has, and the answer is found by the key.
#[tokio::test]
async fn the_answer_of_a_caller_that_went_away_is_found_by_its_key() {
    let (robot, server) = held().await;
    let first = post(&server, "k1", MOTION);
    wait_until("the robot has the command", || robot.commands().len() == 1).await;
    first.abort();
    let _gone = first.await;
    robot.release();
    let mut status = 0;
    let mut body = Value::Null;
    while status != 202 || body["state"] != "accepted" {
        let reply = server.post_with_key(MOTIONS, "k1", MOTION).await;
        (status, body) = (reply.status, reply.json());
        // While the server has not noticed that the caller is gone, the first request is under way.
        assert!(matches!(status, 202 | 409), "{reply:?}");
    }
    assert_eq!(robot.commands().len(), 1);
}

#[tokio::test]
async fn a_caller_that_does_not_want_to_wait_is_answered_at_once() {
    let (robot, server) = held().await;
    let headers = |key: &'static str, prefer: &'static str| {
        [
            ("content-type", "application/json"),
            ("idempotency-key", key),
            ("prefer", prefer),
        ]
    };
    let reply = server
        .request("POST", MOTIONS, &headers("k1", "wait=0"), MOTION)
        .await;
    assert_eq!(reply.status, 202);
    assert_eq!(reply.header("preference-applied"), Some("wait=0"));
    let state = reply.json()["state"].as_str().unwrap().to_owned();
    assert!(matches!(&*state, "queued" | "dispatched"), "{state}");
    robot.release();
    let waited = server
        .request("POST", MOTIONS, &headers("k1", "wait=60"), MOTION)
        .await;
    assert_eq!(waited.json()["state"], "accepted");
    assert_eq!(waited.header("idempotency-replayed"), Some("true"));
}

#[tokio::test]
async fn a_motion_that_could_not_begin_in_time_expires_and_is_never_sent() {
    let (robot, server) = held().await;
    let first = post(&server, "k1", MOTION);
    wait_until("the robot has the command", || robot.commands().len() == 1).await;
    let soon = jiff::Timestamp::now() + jiff::SignedDuration::from_millis(50);
    let body = with(&json!({"not_after": soon.to_string()}));
    let late = post(&server, "k2", &body);
    while server.get(STATE).await.json()["queued"] != 1 {}
    wait_until("the time is over", || jiff::Timestamp::now() > soon).await;
    robot.release();
    let problem = late.await.unwrap();
    let problem = problem.problem(409, "deadline-passed", "NOT_SENT");
    let id = problem["motion"].as_str().unwrap();
    let motion = server.get(&format!("{MOTIONS}/{id}")).await.json();
    assert_eq!(motion["state"], "expired");
    assert_eq!(motion["not_after"], soon.to_string());
    assert_eq!(first.await.unwrap().status, 202);

    let passed = with(&json!({"not_after": "2020-01-01T00:00:00Z"}));
    let reply = server.post(MOTIONS, &passed).await;
    let _problem = reply.problem(409, "deadline-passed", "NOT_SENT");
    let far = with(&json!({"not_after": "2099-01-01T00:00:00Z"}));
    let reply = server.post(MOTIONS, &far).await;
    let problem = reply.problem(422, "validation", "NOT_SENT");
    assert_eq!(problem["violations"][0]["item"], "not_after");
    assert_eq!(robot.commands().len(), 1);
}

/// H5: without a report of where the arm is there is nothing to count from, and no line can be kept.
#[tokio::test]
async fn what_the_seed_program_cannot_do_is_refused_with_the_reason() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for body in [
        with(&json!({"type": "LINEAR"})),
        with(&json!({"type": "RELATIVE", "relative_to": "ACTUAL"})),
    ] {
        let reply = server.post(MOTIONS, &body).await;
        let problem = reply.problem(409, "not-supported", "NOT_SENT");
        assert!(problem["detail"].as_str().unwrap().contains("seed program"));
    }
    for (body, item) in [
        (with(&json!({"type": "RELATIVE"})), "relative_to"),
        (with(&json!({"relative_to": "ACTUAL"})), "relative_to"),
        (with(&json!({"speed_percent": 10})), "speed_percent"),
        (
            json!({"type": "HOME", "speed_percent": 10}).to_string(),
            "speed_percent",
        ),
        (json!({"type": "HOME"}).to_string(), "speed_mm_s"),
    ] {
        let reply = server.post(MOTIONS, &body).await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], item, "{body}");
    }
    for path in ["pause", "resume"] {
        let motion = server.post(MOTIONS, MOTION).await.json();
        let path = format!("{MOTIONS}/{}/{path}", motion["id"].as_str().unwrap());
        let reply = server.post(&path, "").await;
        let _problem = reply.problem(409, "not-supported", "NOT_SENT");
    }
    let speed_override = "/api/v1/cells/c1/robots/r1/speed-override";
    let reply = server.get(speed_override).await;
    let _problem = reply.problem(409, "not-supported", "NONE");
    let headers = [("content-type", "application/json")];
    for (percent, status, code) in [("50", 409, "not-supported"), ("0", 422, "validation")] {
        let body = format!(r#"{{"percent": {percent}}}"#);
        let reply = server.request("PUT", speed_override, &headers, &body).await;
        let _problem = reply.problem(status, code, "NOT_SENT");
    }
}

#[tokio::test]
async fn a_stop_takes_back_what_waits_and_says_that_it_stops_nothing_else() {
    let (robot, server) = held().await;
    let first = post(&server, "k1", MOTION);
    wait_until("the robot has the command", || robot.commands().len() == 1).await;
    let waiting = post(&server, "k2", MOTION);
    while server.get(STATE).await.json()["queued"] != 1 {}
    // No key, no body, no place in the queue.
    let reply = server.request("POST", STOP, &[], "").await;
    assert_eq!(reply.status, 200, "{reply:?}");
    let stopped = reply.json();
    assert_eq!(stopped["stop_effect"], "issues_nothing_more");
    let canceled = stopped["canceled"][0].as_str().unwrap().to_owned();
    let problem = waiting.await.unwrap();
    let problem = problem.problem(409, "motion-canceled", "NOT_SENT");
    assert_eq!(problem["motion"], canceled);
    robot.release();
    assert_eq!(first.await.unwrap().status, 202);
    assert_eq!(robot.commands().len(), 1);
    let motion = server.get(&format!("{MOTIONS}/{canceled}")).await.json();
    assert_eq!(motion["state"], "canceled");
    for (body, status) in [
        (r#"{"category": "STOP_2"}"#, 200),
        (r#"{"category": "STOP_0"}"#, 422),
    ] {
        assert_eq!(server.post(STOP, body).await.status, status, "{body}");
    }
}

#[tokio::test]
async fn a_motion_that_waits_is_canceled_and_one_that_was_taken_is_not() {
    let (robot, server) = held().await;
    let first = post(&server, "k1", MOTION);
    wait_until("the robot has the command", || robot.commands().len() == 1).await;
    let waiting = post(&server, "k2", MOTION);
    while server.get(STATE).await.json()["queued"] != 1 {}
    let motions = server.get(MOTIONS).await.json();
    let id = |index: usize| motions["motions"][index]["id"].as_str().unwrap().to_owned();
    let cancel = |id: String| format!("{MOTIONS}/{id}/cancel");
    for _twice in 0..2 {
        let reply = server.request("POST", &cancel(id(0)), &[], "").await;
        assert_eq!(reply.status, 200, "{reply:?}");
        assert_eq!(reply.json()["state"], "canceled");
    }
    let reply = server.request("POST", &cancel(id(1)), &[], "").await;
    let _problem = reply.problem(409, "not-supported", "NOT_SENT");
    robot.release();
    assert_eq!(first.await.unwrap().status, 202);
    assert_eq!(waiting.await.unwrap().status, 409);
    let reply = server.request("POST", &cancel(id(1)), &[], "").await;
    let _problem = reply.problem(409, "wrong-motion-state", "NOT_SENT");
    assert_eq!(robot.commands().len(), 1);
}

#[tokio::test]
async fn a_plan_is_binding_and_holds_as_long_as_nothing_changes() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let preview = server.post(PREVIEW, MOTION).await;
    assert_eq!(preview.status, 200, "{preview:?}");
    let plan = preview.json();
    assert_eq!(plan["feasible"], true);
    assert_eq!(plan["target"]["z_mm"], 940.0);
    assert_eq!(plan["margins"].as_array().unwrap().len(), 6);
    assert!(plan["solutions"].as_array().unwrap().len() > 1);
    robot.assert_untouched();
    let planned = |plan: &Value| json!({"type": "JOINT", "plan_id": plan["plan_id"]}).to_string();

    let both = with(&json!({"plan_id": plan["plan_id"]}));
    let reply = server.post(MOTIONS, &both).await;
    let problem = reply.problem(422, "validation", "NOT_SENT");
    assert_eq!(problem["violations"][0]["item"], "target");
    let motion = server.post(MOTIONS, &planned(&plan)).await;
    assert_eq!(motion.status, 202, "{motion:?}");
    assert_eq!(motion.json()["target"], plan["target"]);
    assert_eq!(robot.commands(), ["985000 0 940000 180000 0 0 200 1"]);

    // The robot has moved since.
    let reply = server.post(MOTIONS, &planned(&plan)).await;
    let _problem = reply.problem(409, "stale-state", "NOT_SENT");
    let unknown = json!({"plan_id": "00000000-0000-7000-8000-000000000000"});
    let reply = server.post(MOTIONS, &planned(&unknown)).await;
    let _problem = reply.problem(409, "plan-expired", "NOT_SENT");
    let revision = server.get(STATE).await.json()["revision"].as_u64().unwrap();
    for (expected, status) in [(revision + 1, 409), (revision, 202)] {
        let body = with(&json!({"expect": {"state_revision": expected}}));
        assert_eq!(server.post(MOTIONS, &body).await.status, status);
    }
    assert_eq!(robot.commands().len(), 2);
}

#[tokio::test]
async fn a_preview_of_what_the_arm_cannot_do_says_why() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let far = MOTION.replace("985", "5000");
    let plan = server.post(PREVIEW, &far).await.json();
    assert_eq!(plan["feasible"], false);
    assert_eq!(plan["code"], "out-of-workspace");
    assert_eq!(plan["plan_id"], Value::Null);
    let reply = server.post(PREVIEW, r#"{"type": "JOINT"}"#).await;
    let _problem = reply.problem(422, "validation", "NOT_SENT");
    robot.assert_untouched();
}

#[tokio::test]
async fn a_doubt_is_answered_once_with_a_reason_and_then_motions_go_on() {
    let robot = FakeRobot::start([Act::CloseAfter(""), Act::Reply(ACCEPTED)]).await;
    let server = TestServer::start(&robot).await;
    // Of the thesis's route, which takes no key: in doubt all the same.
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 504);
    let list = server.get("/api/v1/cells/c1/interventions").await.json();
    let doubt = &list["interventions"][0];
    assert_eq!(doubt["kind"], "motion_in_doubt");
    assert_eq!(doubt["state"], "open");
    assert_eq!(doubt["code"], "controller-timeout");
    assert_eq!(doubt["allowed"].as_array().unwrap().len(), 3);
    let id = doubt["id"].as_str().unwrap();
    let path = format!("/api/v1/cells/c1/interventions/{id}/respond");
    let answer =
        |answer: &str, reason: &str| json!({"answer": answer, "reason": reason}).to_string();
    for (body, item) in [
        (answer("perhaps", "x"), "answer"),
        (answer("abort", " "), "reason"),
        (answer("abort", &"x".repeat(501)), "reason"),
    ] {
        let problem = server.post(&path, &body).await;
        let problem = problem.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], item);
    }
    let refused = server.post(MOTIONS, MOTION).await;
    let problem = refused.problem(409, "in-doubt", "NOT_SENT");
    assert_eq!(problem["motion"], id);

    let body = answer("did_not_happen", "it stands where it stood");
    let key = fresh_key();
    let first = server.post_with_key(&path, &key, &body).await;
    assert_eq!(first.status, 200, "{first:?}");
    assert_eq!(first.header("idempotency-replayed"), None);
    assert_eq!(first.json()["decision"]["answer"], "did_not_happen");
    let again = server.post_with_key(&path, &key, &body).await;
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.json(), first.json());
    let other = server.post(&path, &answer("happened", "saw it")).await;
    let problem = other.problem(409, "already-answered", "NOT_SENT");
    assert!(problem["detail"].as_str().unwrap().contains("it stands"));
    let motion = server.get(&format!("{MOTIONS}/{id}")).await.json();
    assert_eq!(motion["state"], "not_executed");
    assert_eq!(motion["decision"]["reason"], "it stands where it stood");
    let list = server.get("/api/v1/cells/c1/interventions").await.json();
    assert_eq!(list, json!({"interventions": []}));
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
    for id in ["x", "00000000-0000-7000-8000-000000000000"] {
        let path = format!("/api/v1/cells/c1/interventions/{id}");
        let _problem = server.get(&path).await.problem(404, "not-found", "NONE");
    }
}
