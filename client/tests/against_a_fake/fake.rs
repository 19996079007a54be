#![expect(
    clippy::unwrap_used,
    reason = "a fake that breaks is a test that fails"
)]

use std::net::SocketAddr;
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};

use api::Problem;
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::{Request, State};
use axum::http::{Response, header};
use serde_json::Value;
use tokio::net::TcpListener;

use crate::samples;

/// A request as the fake saw it.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub(crate) line: String,
    pub(crate) request_id: Option<String>,
    pub(crate) body: Value,
    /// The headers `authorization` and `control-token`.
    pub(crate) token: Option<String>,
    pub(crate) control: Option<String>,
}

/// What the fake answers.
#[derive(Clone, Debug)]
pub(crate) enum Answer {
    Json(Value),
    Problem(Box<Problem>),
    Raw {
        status: u16,
        media_type: &'static str,
        body: String,
    },
    /// A success with this request id instead of the one that was sent.
    OfAnother(&'static str),
    /// Never answers.
    Silence,
}

type Script = Arc<dyn Fn(&Seen) -> Answer + Send + Sync>;

/// An HTTP server that answers what its script says and remembers what it was asked.
pub(crate) struct Fake {
    address: SocketAddr,
    seen: Arc<Mutex<Vec<Seen>>>,
    controls: Arc<Mutex<Vec<String>>>,
}

type Shared = (Script, Arc<Mutex<Vec<Seen>>>, Arc<Mutex<Vec<String>>>);

impl Fake {
    pub(crate) async fn start(script: impl Fn(&Seen) -> Answer + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let seen = Arc::new(Mutex::new(Vec::new()));
        let controls = Arc::new(Mutex::new(Vec::new()));
        let state: Shared = (Arc::new(script), Arc::clone(&seen), Arc::clone(&controls));
        let router = Router::new().fallback(answer).with_state(state);
        drop(tokio::spawn(
            async move { axum::serve(listener, router).await },
        ));
        Self {
            address,
            seen,
            controls,
        }
    }

    /// A fake that answers everything the same.
    pub(crate) async fn always(answer: Answer) -> Self {
        Self::start(move |_| answer.clone()).await
    }

    pub(crate) fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    pub(crate) fn seen(&self) -> Vec<Seen> {
        self.seen.lock().unwrap().clone()
    }

    /// What was asked of control authority, which every fake grants.
    pub(crate) fn controls(&self) -> Vec<String> {
        self.controls.lock().unwrap().clone()
    }

    pub(crate) fn lines(&self) -> Vec<String> {
        self.seen().into_iter().map(|seen| seen.line).collect()
    }

    /// Runs the real `cellctl` with this fake as server, emulator, and only cell and robot.
    pub(crate) async fn cellctl(&self, arguments: &[&str]) -> Ran {
        let url = self.url();
        let mut all = vec![
            "--server",
            &url,
            "--emulator",
            &url,
            "--cell",
            "demo",
            "--robot",
            "r1",
        ];
        all.extend(arguments);
        cellctl(&all).await
    }
}

async fn answer(
    State((script, seen, controls)): State<Shared>,
    request: Request,
) -> Response<Body> {
    let (head, body) = request.into_parts();
    let body = to_bytes(body, 1 << 20).await.unwrap();
    let header = |name: &str| {
        let value = head.headers.get(name)?;
        Some(value.to_str().unwrap().to_owned())
    };
    let request = Seen {
        token: header("authorization"),
        control: header("control-token"),
        line: format!("{} {}", head.method, head.uri),
        request_id: head
            .headers
            .get("x-request-id")
            .map(|id| id.to_str().unwrap().to_owned()),
        body: serde_json::from_slice(&body).unwrap_or(Value::Null),
    };
    let is_control = request.line.contains("/control-authority");
    let answer = if is_control {
        Answer::Json(samples::control(request.line.starts_with("DELETE")))
    } else {
        script(&request)
    };
    let sent_id = request.request_id.clone();
    if is_control {
        controls.lock().unwrap().push(request.line);
    } else {
        seen.lock().unwrap().push(request);
    }
    let id = match &answer {
        Answer::OfAnother(id) => Some((*id).to_owned()),
        Answer::Json(_) | Answer::Problem(_) => sent_id,
        Answer::Raw { .. } | Answer::Silence => None,
    };
    let (status, media_type, body) = match answer {
        Answer::Json(value) => (200, "application/json", value.to_string()),
        Answer::Problem(problem) => (
            problem.status,
            "application/problem+json",
            serde_json::to_string(&problem).unwrap(),
        ),
        Answer::Raw {
            status,
            media_type,
            body,
        } => (status, media_type, body),
        Answer::OfAnother(_) => (200, "application/json", "[]".to_owned()),
        Answer::Silence => std::future::pending().await,
    };
    let mut response = Response::builder()
        .status(status)
        .header(header::CONTENT_TYPE, media_type);
    if let Some(id) = id {
        response = response.header("x-request-id", id);
    }
    response.body(Body::from(body)).unwrap()
}

/// What a run of `cellctl` left behind.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    pub(crate) fn json(&self) -> Value {
        assert_eq!(self.stderr, "");
        serde_json::from_str(&self.stdout).unwrap()
    }
}

/// Runs the real `cellctl`, with no settings from this machine's environment.
pub(crate) async fn cellctl(arguments: &[&str]) -> Ran {
    cellctl_in(&[], arguments).await
}

/// As [`cellctl`], with settings in the environment.
pub(crate) async fn cellctl_in(environment: &[(&str, &str)], arguments: &[&str]) -> Ran {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cellctl"));
    let _ = command
        .args(arguments)
        .env_clear()
        .envs(environment.iter().copied());
    let output = tokio::task::spawn_blocking(move || command.output())
        .await
        .unwrap();
    let Output {
        status,
        stdout,
        stderr,
    } = output.unwrap();
    Ran {
        code: status.code().unwrap(),
        stdout: String::from_utf8(stdout).unwrap(),
        stderr: String::from_utf8(stderr).unwrap(),
    }
}
