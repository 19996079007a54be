//! Any requests to the control interface: they get an answer that is not the server's own fault, and the controller
//! goes on.

use std::fmt::Write as _;

use axum::Router;
use axum::body::Body;
use axum::http::{Method, Request, StatusCode, header};
use karel_emulator::{
    Clock, ControlAccess, ControllerConfig, PeerLabels, ProgramSource, VirtualController,
};
use kinematics::ArmModel;
use tokio::runtime::Runtime;
use tower::ServiceExt as _;

use crate::choices::Choices;

/// Moves, counts and waits, with variables of all kinds.
const PROGRAM: &str = "PROGRAM work
TYPE rec = STRUCTURE
  n : INTEGER
  t : STRING[8]
ENDSTRUCTURE
VAR
  i IN CMOS : INTEGER
  r : REAL
  b : BOOLEAN
  p : XYZWPR
  list : ARRAY[3] OF rec
BEGIN
  i = 0
  p = CURPOS(0, 0)
  $SPEED = 500
  WHILE TRUE DO
    i = i + 1
    p.z = p.z - 1
    MOVE TO p NOWAIT
    DELAY 50
  ENDWHILE
END work
";

const METHODS: &[Method] = &[
    Method::GET,
    Method::PUT,
    Method::POST,
    Method::PATCH,
    Method::DELETE,
];

const PATHS: &[&str] = &[
    "state",
    "ledger",
    "trace",
    "screen",
    "programs",
    "programs/WORK/run",
    "tasks",
    "tasks/WORK",
    "tasks/WORK/abort",
    "tasks/WORK/pause",
    "tasks/WORK/continue",
    "tasks/WORK/step",
    "abort-all",
    "variables",
    "variable",
    "registers",
    "registers/R[1]",
    "registers/PR[2]",
    "registers/SR[3]",
    "io",
    "io/DIN[1]",
    "io/GOUT[1]",
    "io/DIN[1]/simulation",
    "frames",
    "frames/user/1",
    "frames/tool/2",
    "selected-frames/user",
    "operator",
    "hold",
    "cycle-start",
    "reset",
    "jog",
    "power-cycle",
    "alarms",
    "time",
    "time/step",
    "faults",
    "faults/1",
    "openapi.json",
];

/// # Panics
/// If that finds something.
pub fn run(data: &[u8]) {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime");
    exchange(&runtime, data);
}

/// Requests one after the other: method, path, query, body.
fn exchange(runtime: &Runtime, data: &[u8]) {
    let model = ArmModel::builtin("fanuc-m20ia").expect("the arm is built in");
    let mut config =
        ControllerConfig::new("fuzz", model).with_program(ProgramSource::new("work.kl", PROGRAM));
    config.limits.instructions_per_ms = 50;
    config.control = ControlAccess::Control;
    runtime.block_on(async {
        let (clock, stepper) = Clock::stepped();
        let controller = VirtualController::start(&config, clock, PeerLabels::new())
            .expect("the program is correct");
        let router = controller.panel_router(ControlAccess::Control);
        let mut choices = Choices::new(data);
        for _ in 0..8 {
            if choices.is_over() {
                break;
            }
            request(&router, &mut choices).await;
            let by = std::time::Duration::from_millis(u64::from(choices.byte()));
            let _now = stepper.advance(by).await;
        }
        let state = controller.state().await.expect("the controller lives");
        let _json = serde_json::to_string(&state).expect("a state is JSON");
        controller.shutdown().await;
    });
}

async fn request(router: &Router, choices: &mut Choices<'_>) {
    let method = choices.one_of(METHODS).clone();
    let mut path = format!("/api/v1/{}", choices.one_of(PATHS));
    let query = choices.bytes(60);
    if !query.is_empty() {
        path.push('?');
        for byte in query {
            let c = char::from(*byte);
            if c.is_ascii_graphic() && c != '#' {
                path.push(c);
            } else {
                let _written = write!(path, "%{byte:02X}");
            }
        }
    }
    // Whoever asks to wait for news, or for much time to pass, gets it.
    if path.contains("wait_s") {
        return;
    }
    let body = choices.bytes(300).to_vec();
    let request = Request::builder()
        .method(method)
        .uri(&path)
        .header(header::HOST, "localhost")
        .header(header::CONTENT_TYPE, "application/json")
        .body(Body::from(body.clone()));
    let Ok(request) = request else {
        return;
    };
    let told = format!("{} {path} {}", request.method(), body.escape_ascii());
    let response = router
        .clone()
        .oneshot(request)
        .await
        .expect("a router answers");
    let status = response.status();
    let is_problem = response
        .headers()
        .get(header::CONTENT_TYPE)
        .is_some_and(|kind| kind == "application/problem+json");
    let text = axum::body::to_bytes(response.into_body(), 16 << 20)
        .await
        .expect("a body ends");
    assert!(
        !status.is_server_error() || status == StatusCode::SERVICE_UNAVAILABLE,
        "{told}: {status} {}",
        text.escape_ascii()
    );
    assert!(
        !status.is_client_error() || is_problem,
        "{told}: {status} without a problem"
    );
    if !text.is_empty() {
        let parsed: Result<serde_json::Value, _> = serde_json::from_slice(&text);
        assert!(parsed.is_ok(), "{told}: no JSON: {}", text.escape_ascii());
    }
}
