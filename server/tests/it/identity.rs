//! Tokens: made, used, rotated, revoked, kept.

use std::fs;
use std::os::unix::fs::PermissionsExt as _;

use jiff::Timestamp;
use serde_json::{Value, json};
use server::config::{CellSection, ServerSection};
use server::identity::{Identity, StoreError};
use server::{Plan, Seams, ServeError, SystemClock, TcpConnector};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::support::{FakeRobot, MOTIONS, Secured, TestServer, robot_section};

fn id_of(token: &str) -> &str {
    token.split('_').nth(1).unwrap()
}

#[tokio::test]
async fn the_first_admin_makes_an_operator_who_moves_the_robot() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let alice = cell.token("alice", "operator").await;
    let me = cell.get("/api/v1/me", &alice).await.json();
    assert_eq!(
        (&me["name"], &me["roles"]),
        (&json!("alice"), &json!(["operator"]))
    );
    assert_eq!(me["demo"], false);
    let home = cell.send("POST", "/fanuc/home", &alice, &Value::Null).await;
    assert_eq!(home.status, 200, "{home:?}");
    let admin = cell
        .send("POST", "/fanuc/home", &cell.admin, &Value::Null)
        .await;
    let problem = admin.problem(403, "forbidden", "NOT_SENT");
    assert!(
        problem["detail"]
            .as_str()
            .unwrap()
            .contains("it needs: operator"),
        "{problem}"
    );
    assert_eq!(robot.commands().len(), 1);
}

#[tokio::test]
async fn the_file_holds_hashes_and_is_its_owners_alone() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let alice = cell.token("alice", "operator").await;
    let kept = fs::read_to_string(cell.file()).unwrap();
    for token in [&alice, &cell.admin, &cell.expired] {
        let secret = token.rsplit('_').next().unwrap();
        assert!(!kept.contains(secret));
        assert!(kept.contains(id_of(token)));
    }
    assert_eq!(
        fs::metadata(cell.file()).unwrap().permissions().mode() & 0o777,
        0o600
    );
    let folder = cell.file().parent().unwrap().to_owned();
    assert_eq!(
        fs::read_dir(folder).unwrap().count(),
        1,
        "nothing is left beside it"
    );
    let listed = cell.get("/api/v1/tokens", &cell.admin).await.body;
    assert!(
        listed.contains("alice") && !listed.contains("hash"),
        "{listed}"
    );
}

#[test]
fn a_file_others_may_read_or_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tokens.json");
    let now = Timestamp::now();
    let (_, first) = Identity::open(path.clone(), now).unwrap();
    assert!(first.is_some());
    // The second start makes none.
    assert!(Identity::open(path.clone(), now).unwrap().1.is_none());
    assert!(
        Identity::open_with_new_admin(path.clone(), now)
            .unwrap()
            .1
            .is_some()
    );
    for mode in [0o644, 0o640, 0o602] {
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        let error = Identity::open(path.clone(), now).unwrap_err();
        assert!(matches!(error, StoreError::NotPrivate { .. }), "{error}");
        assert!(error.to_string().contains("chmod 600"), "{error}");
    }
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    let good = fs::read_to_string(&path).unwrap();
    for (good_part, bad) in [
        ("\"version\": 1", "\"version\": 2"),
        ("\"role\": \"admin\"", "\"role\": \"root\""),
        ("\"name\": \"admin\"", "\"name\": \"\\u001b[2J\""),
        ("\"created_by\"", "\"made_by\""),
        ("{", "["),
    ] {
        let text = good.replacen(good_part, bad, 1);
        assert_ne!(text, good, "{good_part}");
        fs::write(&path, text).unwrap();
        let error = Identity::open(path.clone(), now).unwrap_err();
        assert!(matches!(error, StoreError::Format { .. }), "{error}");
    }
    fs::write(&path, good).unwrap();
    assert!(Identity::check(&path).is_ok());
}

#[tokio::test]
async fn a_revoked_token_opens_nothing_from_the_next_request_on() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let alice = cell.token("alice", "operator").await;
    assert_eq!(cell.get("/api/v1/cells", &alice).await.status, 200);
    let path = format!("/api/v1/tokens/{}", id_of(&alice));
    for _ in 0..2 {
        let reply = cell.send("DELETE", &path, &cell.admin, &Value::Null).await;
        assert_eq!(
            (reply.status, &reply.json()["state"]),
            (200, &json!("revoked"))
        );
        let refused = cell.get("/api/v1/cells", &alice).await;
        let problem = refused.problem(401, "unauthorized", "NONE");
        assert_eq!(problem["detail"], "the token was revoked");
    }
    // It stays so after a restart.
    let (identity, _) = Identity::open(cell.file(), Timestamp::now()).unwrap();
    let again =
        TestServer::with_identity(&robot, identity, server::SharedJournal::volatile()).await;
    let bearer = format!("Bearer {alice}");
    let headers = [("authorization", bearer.as_str())];
    assert_eq!(
        again
            .bare("GET", "/api/v1/cells", &headers, "")
            .await
            .status,
        401
    );
}

#[tokio::test]
async fn a_rotated_token_has_a_new_secret_and_the_old_one_ends() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let old = cell.token("alice", "operator").await;
    let path = format!("/api/v1/tokens/{}/rotate", id_of(&old));
    let rotated = cell
        .send("POST", &path, &cell.admin, &json!({"overlap_s": 600}))
        .await;
    assert_eq!(rotated.status, 201, "{rotated:?}");
    let new = rotated.json()["token"].as_str().unwrap().to_owned();
    for token in [&old, &new] {
        assert_eq!(cell.get("/api/v1/me", token).await.json()["name"], "alice");
    }
    let path = format!("/api/v1/tokens/{}/rotate", id_of(&new));
    let rotated = cell.send("POST", &path, &cell.admin, &json!({})).await;
    let newest = rotated.json()["token"].as_str().unwrap().to_owned();
    let problem = cell.get("/api/v1/me", &new).await;
    let problem = problem.problem(401, "unauthorized", "NONE");
    assert!(
        problem["detail"]
            .as_str()
            .unwrap()
            .starts_with("the token expired at")
    );
    assert_eq!(cell.get("/api/v1/me", &newest).await.status, 200);
    let again = cell.send("POST", &path, &cell.admin, &json!({})).await;
    let _problem = again.problem(404, "not-found", "NONE");
}

#[tokio::test]
async fn the_last_admin_stays() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let path = format!("/api/v1/tokens/{}", id_of(&cell.admin));
    let refused = cell.send("DELETE", &path, &cell.admin, &Value::Null).await;
    let _problem = refused.problem(409, "last-admin", "NOT_SENT");
    let second = cell.token("second", "admin").await;
    assert_eq!(
        cell.send("DELETE", &path, &second, &Value::Null)
            .await
            .status,
        200
    );
}

/// X4, X10, X11.
#[tokio::test]
async fn x4_x10_a_token_that_does_not_fit_is_not_made() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let long = "x".repeat(65);
    for (body, item) in [
        (json!({"name": "a", "role": "root"}), "role"),
        (
            json!({"name": "a", "role": "viewer", "state": "active"}),
            "state",
        ),
        (json!({"name": "a", "role": "viewer", "epoch": 7}), "epoch"),
        (json!({"name": "", "role": "viewer"}), "name"),
        (
            json!({"name": "a\r\nforged line", "role": "viewer"}),
            "name",
        ),
        (json!({"name": "\u{1b}[2J", "role": "viewer"}), "name"),
        (json!({"name": "<script>", "role": "viewer"}), "name"),
        (json!({"name": long, "role": "viewer"}), "name"),
        (json!({"name": "jobs", "role": "viewer"}), "name"),
        (
            json!({"name": "a", "role": "viewer", "expires_in_days": 0}),
            "expires_in_days",
        ),
        (
            json!({"name": "a", "role": "viewer", "expires_in_days": 366}),
            "expires_in_days",
        ),
        (
            json!({"name": "a", "role": "mobile_robot"}),
            "scope.mobile_robot",
        ),
        (
            json!({"name": "a", "role": "viewer", "scope": {"mobile_robot": "mr1"}}),
            "scope.mobile_robot",
        ),
        (
            json!({"name": "a", "role": "viewer", "scope": {"local_station": true}}),
            "scope.local_station",
        ),
        (
            json!({"name": "a", "role": "admin", "scope": {"cell": "c1"}}),
            "scope",
        ),
        (
            json!({"name": "a", "role": "viewer", "scope": {"robots": "r1"}}),
            "scope.robots",
        ),
    ] {
        let reply = cell
            .send("POST", "/api/v1/tokens", &cell.admin, &body)
            .await;
        let problem = reply.problem(422, "validation", "NOT_SENT");
        assert_eq!(problem["violations"][0]["item"], item, "{problem}");
        assert!(!reply.body.contains('\u{1b}'));
    }
    let _alice = cell.token("alice", "viewer").await;
    let body = json!({"name": "alice", "role": "admin"});
    let reply = cell
        .send("POST", "/api/v1/tokens", &cell.admin, &body)
        .await;
    let _problem = reply.problem(409, "name-taken", "NOT_SENT");
    let listed = cell.get("/api/v1/tokens", &cell.admin).await.json();
    assert_eq!(listed["tokens"].as_array().unwrap().len(), 3, "{listed}");
}

/// X3.
#[tokio::test]
async fn x3_a_cell_outside_the_scope_does_not_exist() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let token = cell.scoped("b", "operator", json!({"cell": "c2"})).await;
    let foreign = cell.get("/api/v1/cells/c1", &token).await;
    let foreign = foreign.problem(404, "not-found", "NONE");
    let absent = cell.get("/api/v1/cells/c9", &token).await;
    let absent = absent.problem(404, "not-found", "NONE");
    let text = |problem: &Value| problem["detail"].as_str().unwrap().replace("c9", "c1");
    assert_eq!(text(&foreign), text(&absent));
    assert_eq!(cell.get("/api/v1/cells/c2", &token).await.status, 200);
    assert_eq!(cell.get("/api/v1/cells/%632", &token).await.status, 404);
    let listed = cell.get("/api/v1/cells", &token).await.json();
    assert_eq!(listed.as_array().unwrap().len(), 1, "{listed}");
    // The thesis's routes drive a robot of c1.
    let home = cell.send("POST", "/fanuc/home", &token, &Value::Null).await;
    let _problem = home.problem(403, "forbidden", "NOT_SENT");
    let moved = cell.send("POST", MOTIONS, &token, &json!({})).await;
    let _problem = moved.problem(404, "not-found", "NOT_SENT");
    robot.assert_untouched();
}

/// X12.
#[tokio::test]
async fn x12_guessing_is_slowed_down_and_keeps_nobody_out() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let alice = cell.token("alice", "operator").await;
    let mut statuses = Vec::new();
    for _ in 0..8 {
        let reply = cell.get("/api/v1/cells", &"cell_guess".repeat(3)).await;
        statuses.push(reply.status);
        if reply.status == 429 {
            let _problem = reply.problem(429, "rate-limited", "NONE");
            assert_eq!(reply.header("retry-after"), Some("1"));
        }
    }
    assert_eq!(statuses, [401, 401, 401, 401, 401, 401, 429, 429]);
    // What any valid token may do, stopping among it, says what is wrong and never to wait.
    assert_eq!(cell.get("/api/v1/me", "cell_guess").await.status, 401);
    assert_eq!(cell.get("/api/v1/cells", &alice).await.status, 200);
    assert_eq!(cell.get("/api/v1/cells", "").await.status, 401);
}

#[tokio::test]
async fn only_one_bearer_token_in_the_header_counts() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let token = &cell.admin;
    let (bearer, lower) = (format!("Bearer {token}"), format!("bearer {token}"));
    let basic = format!("Basic {token}");
    let status = async |headers: &[(&str, &str)], path: &str| {
        cell.server.bare("GET", path, headers, "").await.status
    };
    assert_eq!(
        status(&[("authorization", &lower)], "/api/v1/me").await,
        200
    );
    for headers in [
        vec![("authorization", basic.as_str())],
        vec![("authorization", token.as_str())],
        vec![("authorization", "Bearer")],
        vec![
            ("authorization", bearer.as_str()),
            ("authorization", bearer.as_str()),
        ],
        vec![("x-api-key", token.as_str())],
        vec![("cookie", token.as_str())],
    ] {
        assert_eq!(status(&headers, "/api/v1/me").await, 401, "{headers:?}");
    }
    let query = format!("/api/v1/me?access_token={token}");
    assert_eq!(status(&[], &query).await, 401);
}

/// X5, X6.
#[tokio::test]
async fn x5_x6_a_token_does_not_excuse_another_sites_page() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let alice = cell.token("alice", "operator").await;
    let page = [("origin", "http://evil.example")];
    let home = cell
        .send_with("POST", "/fanuc/home", &alice, &page, &Value::Null)
        .await;
    let _problem = home.problem(403, "cross-site-request", "NOT_SENT");
    robot.assert_untouched();
}

#[tokio::test]
async fn a_server_that_knows_nobody_does_not_start() {
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        robots: vec![robot_section(([127, 0, 0, 1], 1).into())],
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
    };
    let plan = Plan::try_new(&ServerSection::default(), std::slice::from_ref(&cell)).unwrap();
    let seams = Seams {
        connector: TcpConnector::default(),
        clock: std::sync::Arc::new(SystemClock),
        journal: server::SharedJournal::volatile(),
    };
    let stop = CancellationToken::new();
    let started = server::start(plan, seams, &TaskTracker::new(), &stop).await;
    assert!(matches!(started, Err(ServeError::NoIdentity)));

    let demo = ServerSection {
        demo: true,
        ..ServerSection::default()
    };
    let plan = Plan::try_new(&demo, std::slice::from_ref(&cell)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (identity, _) = Identity::open(folder.path().join("t"), Timestamp::now()).unwrap();
    assert_eq!(
        plan.with_identity(identity).unwrap_err().key(),
        "server.demo"
    );
    let remote = ServerSection {
        listen: "0.0.0.0:8080".to_owned(),
        allow_remote: true,
        ..demo
    };
    let error = Plan::try_new(&remote, &[cell]).unwrap_err();
    assert_eq!(error.key(), "server.listen");
    assert!(error.to_string().contains("demo"), "{error}");
}

#[tokio::test]
async fn in_a_demo_everybody_is_demo_and_there_are_no_tokens() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let me = server.get("/api/v1/me").await.json();
    assert_eq!((&me["name"], &me["demo"]), (&json!("demo"), &json!(true)));
    assert_eq!(me["roles"].as_array().unwrap().len(), 5);
    let reply = server.get("/api/v1/tokens").await;
    let _problem = reply.problem(409, "demo-mode", "NOT_SENT");
}
