//! Health, metrics, descriptions, and paths that are none.

use crate::legacy_moves::POINT;
use crate::support::{FakeRobot, MODEL, TestServer};

#[tokio::test]
async fn the_server_lives_and_is_ready_while_its_links_run() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    assert_eq!(server.get("/livez").await.json()["alive"], true);
    let ready = server.get("/readyz").await;
    assert_eq!(ready.status, 200);
    assert_eq!(ready.json()["links"][0]["robot"], "r1");
    assert_eq!(ready.json()["links"][0]["state"], "untried");
}

#[tokio::test]
async fn metrics_count_requests_by_route_and_commands_by_outcome() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    // Another server in the same process counts for itself.
    let other = TestServer::start(&robot).await;
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    assert_eq!(server.post("/fanuc/move", "{}").await.status, 422);
    assert_eq!(server.get("/api/v1/cells/nowhere").await.status, 404);
    assert_eq!(server.get("/no/such/path").await.status, 404);
    assert_eq!(
        server.request("BREW", "/fanuc/move", &[], "").await.status,
        405
    );

    let text = server.get("/metrics").await.body;
    for line in [
        r#"robocell_http_requests_total{route="/fanuc/move",method="POST",status="200"} 1"#,
        r#"robocell_http_requests_total{route="/fanuc/move",method="POST",status="422"} 1"#,
        r#"robocell_http_requests_total{route="/fanuc/move",method="other",status="405"} 1"#,
        r#"robocell_http_requests_total{route="/api/v1/cells/{cell}",method="GET",status="404"} 1"#,
        r#"robocell_http_requests_total{route="other",method="GET",status="404"} 1"#,
        r#"robocell_link_commands_total{cell="c1",robot="r1",outcome="accepted"} 1"#,
        r#"robocell_link_commands_total{cell="c1",robot="r1",outcome="no_reply"} 0"#,
        r#"robocell_link_connect_duration_seconds_count{cell="c1",robot="r1"} 1"#,
        r#"robocell_link_queued_commands{cell="c1",robot="r1"} 0"#,
    ] {
        assert!(
            text.lines().any(|found| found == line),
            "{line} is not in\n{text}"
        );
    }
    let others = other.get("/metrics").await.body;
    assert!(others.contains(r#"outcome="accepted"} 0"#), "{others}");
}

#[tokio::test]
async fn cells_and_robots_describe_themselves() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let cells = server.get("/api/v1/cells").await.json();
    assert_eq!(cells[0]["id"], "c1");
    assert_eq!(cells[0]["robots"][0]["model"], MODEL);
    let cell = server.get("/api/v1/cells/c1").await.json();
    assert_eq!(cell, cells[0]);
    let robots = server.get("/api/v1/cells/c1/robots").await.json();
    assert_eq!(robots, cell["robots"]);
    let described = server.get("/api/v1/cells/c1/robots/r1").await.json();
    assert_eq!(described["controller_address"], robot.address.to_string());
    assert_eq!(described["joints"][5]["joint"], "J6");
    assert_eq!(described["configuration"], "N U T, 0, 0, 0");
    let same = server
        .get("/api/v1/cells/c1/robots/r1/description")
        .await
        .json();
    assert_eq!(same, described);
}

#[tokio::test]
async fn what_is_not_there_is_a_problem() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    for path in [
        "/nothing",
        "/api/v1/cells/c2",
        "/api/v1/cells/c2/robots",
        "/api/v1/cells/c1/robots/r2",
        "/api/v1/cells/c1/robots/r2/state",
        "/api/v1/cells/%ff/robots/r1",
        "/api/v1/cells/../cells/c1",
        "//fanuc/move",
    ] {
        let problem = server.get(path).await.problem(404, "not-found", "NONE");
        assert_eq!(problem["instance"], path);
    }
    let reply = server.get("/fanuc/move").await;
    assert_eq!(
        reply.header("content-security-policy"),
        Some("frame-ancestors 'none'")
    );
    let _problem = reply.problem(405, "method-not-allowed", "NONE");
    assert_eq!(reply.header("allow"), Some("POST"));
    let headers = [
        ("x-http-method-override", "POST"),
        ("content-type", "application/json"),
    ];
    let reply = server.request("PUT", "/fanuc/move", &headers, POINT).await;
    assert_eq!(reply.status, 405);
    robot.assert_untouched();
}

#[tokio::test]
async fn the_type_of_a_problem_leads_to_its_kind() {
    let robot = FakeRobot::accepting().await;
    let server = TestServer::start(&robot).await;
    let problem = server.get("/nothing").await.json();
    let kind = server.get(problem["type"].as_str().unwrap()).await.json();
    assert_eq!(kind["code"], "not-found");
    assert_eq!(kind["title"], problem["title"]);
    let kinds = server.get("/problems").await.json();
    assert_eq!(kinds.as_array().unwrap().len(), api::ProblemCode::ALL.len());
    assert!(kinds.as_array().unwrap().contains(&kind));
    let reply = server.get("/problems/bad-luck").await;
    let _problem = reply.problem(404, "not-found", "NONE");
}
