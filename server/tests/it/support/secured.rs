use std::path::PathBuf;

use api::NewToken;
use jiff::{Timestamp, ToSpan};
use serde_json::{Value, json};
use server::SharedJournal;
use server::identity::Identity;
use tempfile::TempDir;

use super::cell::TestServer;
use super::client::HttpReply;
use super::robot::FakeRobot;

/// A server with tokens, cells `c1` and `c2` with the robot `r1` each, and its first admin.
pub(crate) struct Secured {
    pub(crate) server: TestServer,
    pub(crate) admin: String,
    /// An admin token of a year ago.
    pub(crate) expired: String,
    folder: TempDir,
}

impl Secured {
    pub(crate) async fn start(robot: &FakeRobot) -> Self {
        Self::start_with(robot, SharedJournal::volatile()).await
    }

    pub(crate) async fn start_with(robot: &FakeRobot, journal: SharedJournal) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.json");
        let now = Timestamp::now();
        let long_ago = now - (366 * 24).hours();
        let (_, expired) = Identity::open(path.clone(), long_ago).unwrap();
        let (identity, admin) = Identity::open(path, now).unwrap();
        let text = |made: Option<NewToken>| made.unwrap().token.reveal().to_owned();
        Self {
            server: TestServer::with_identity(robot, identity, journal).await,
            admin: text(admin),
            expired: text(expired),
            folder,
        }
    }

    /// Stops the server in order, and starts the next one with the same tokens.
    pub(crate) async fn again(
        &mut self,
        robot: &FakeRobot,
        journal: impl AsyncFnOnce() -> SharedJournal,
    ) {
        self.end().await;
        let (identity, _) = Identity::open(self.file(), Timestamp::now()).unwrap();
        self.server = TestServer::with_identity(robot, identity, journal().await).await;
    }

    /// Stops the server in order.
    pub(crate) async fn end(&mut self) {
        self.server.stop.cancel();
        (&mut self.server.task).await.unwrap().unwrap();
    }

    pub(crate) fn file(&self) -> PathBuf {
        self.folder.path().join("tokens.json")
    }

    /// Makes a token; answers its text.
    pub(crate) async fn token(&self, name: &str, role: &str) -> String {
        self.scoped(name, role, json!({})).await
    }

    pub(crate) async fn scoped(&self, name: &str, role: &str, scope: Value) -> String {
        let body = json!({"name": name, "role": role, "scope": scope});
        let reply = self
            .send("POST", "/api/v1/tokens", &self.admin, &body)
            .await;
        assert_eq!(reply.status, 201, "{reply:?}");
        reply.json()["token"].as_str().unwrap().to_owned()
    }

    /// Sends JSON, or nothing, with a token.
    pub(crate) async fn send(
        &self,
        method: &str,
        path: &str,
        token: &str,
        body: &Value,
    ) -> HttpReply {
        self.send_with(method, path, token, &[], body).await
    }

    pub(crate) async fn send_with(
        &self,
        method: &str,
        path: &str,
        token: &str,
        more: &[(&str, &str)],
        body: &Value,
    ) -> HttpReply {
        let bearer = format!("Bearer {token}");
        let mut headers = more.to_vec();
        if !token.is_empty() {
            headers.push(("authorization", &bearer));
        }
        let text = if body.is_null() {
            String::new()
        } else {
            headers.push(("content-type", "application/json"));
            body.to_string()
        };
        self.server.bare(method, path, &headers, &text).await
    }

    pub(crate) async fn get(&self, path: &str, token: &str) -> HttpReply {
        self.send("GET", path, token, &Value::Null).await
    }

    /// Takes control of `c1`.
    pub(crate) async fn acquire(&self, token: &str, more: &Value) -> HttpReply {
        let mut body = json!({"station": "REMOTE", "ttl_s": 60, "reason": "a test"});
        let more = more.as_object().into_iter().flatten();
        for (key, value) in more {
            body[key] = value.clone();
        }
        let path = "/api/v1/cells/c1/control-authority";
        self.send("POST", path, token, &body).await
    }

    /// Asks for a motion with control, under a new key.
    pub(crate) async fn motion(&self, token: &str, control: Option<&str>) -> HttpReply {
        let body = serde_json::from_str(super::cell::MOTION).unwrap();
        let key = super::cell::fresh_key();
        let mut headers = vec![("idempotency-key", key.as_str())];
        headers.extend(control.map(|token| ("control-token", token)));
        let path = super::cell::MOTIONS;
        self.send_with("POST", path, token, &headers, &body).await
    }
}

/// The token of a granted lease.
pub(crate) fn control_of(reply: &HttpReply) -> String {
    assert_eq!(reply.status, 201, "{reply:?}");
    reply.json()["token"].as_str().unwrap().to_owned()
}
