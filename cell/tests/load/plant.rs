//! The virtual world in this process, and the server as a process before it.

use std::fmt::Write as _;
use std::net::{SocketAddr, TcpListener};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use cell::Assembly;
use cell::world::World;
use karel_emulator::VirtualController;
use mobile_emulator::MobileRobot;
use reqwest::Client;
use serde_json::Value;

use crate::setup::{self, CELLS, MOBILES};

/// How long nothing may happen at all, in seconds of this machine: ends a test that hangs, and says nothing about speed.
const HANGS: Duration = Duration::from_mins(4);

/// Cheap to clone.
#[derive(Clone)]
pub(crate) struct LoadedPlant(Arc<Inner>);

struct Inner {
    assembly: Assembly,
    server: Mutex<Child>,
    address: SocketAddr,
    folder: tempfile::TempDir,
    http: Client,
    keys: AtomicU64,
}

impl LoadedPlant {
    pub(crate) async fn start(scale: f64) -> Self {
        let text = setup::setup();
        let mut assembly = Assembly::start(&setup::config(scale, false), &text)
            .await
            .unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        let folder = tempfile::tempdir().unwrap();
        for cell in 0..CELLS {
            let name = format!("{}.toml", setup::cell_id(cell));
            std::fs::write(folder.path().join(name), &text).unwrap();
        }
        let journal = "[journal]\npath = 'load.journal'\nallow_volatile_filesystem = true\n";
        let config = folder.path().join("robocell.toml");
        std::fs::write(&config, setup::config(scale, true) + journal).unwrap();
        let server = Command::new(env!("CARGO_BIN_EXE_robocell"))
            .arg("--config")
            .arg(&config)
            .args(["--listen", &address.to_string(), "--demo", "--log", "warn"])
            .args(["--parts-at", &assembly.parts_at().unwrap()])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        assembly.start_mobile_robots(address).unwrap();
        let plant = Self(Arc::new(Inner {
            assembly,
            server: Mutex::new(server),
            address,
            folder,
            http: Client::new(),
            keys: AtomicU64::new(0),
        }));
        plant
            .wait("the server to live", async |plant| {
                plant.try_get("/livez").await.map(drop)
            })
            .await;
        plant
    }

    /// What `check` of each set-up finds wrong.
    pub(crate) async fn checks(&self) -> Vec<Value> {
        let path = format!("/api/v1/cells/{}/setup/check", setup::cell_id(0));
        let url = format!("http://{}{path}", self.0.address);
        let answer = self.0.http.post(url).send().await.unwrap();
        assert!(answer.status().is_success(), "{}", answer.status());
        let check: Value = answer.json().await.unwrap();
        let poses = check["taught_poses"].as_array().cloned();
        let mut wrong: Vec<_> = poses.unwrap_or_default();
        wrong.extend(check["routes"].as_array().cloned().unwrap_or_default());
        wrong.retain(|part| part["passed"] == false);
        wrong
    }

    pub(crate) fn mobile_robot(&self, cell: usize, mobile: usize) -> &MobileRobot {
        let robots = self.0.assembly.plant().mobile_robots();
        &robots[cell * MOBILES.len() + mobile]
    }

    pub(crate) fn controller(&self, cell: usize, arm: usize) -> &VirtualController {
        let name = setup::controller(cell, arm);
        self.0.assembly.controller(&name).expect("a controller")
    }

    pub(crate) fn world(&self, cell: usize) -> &World {
        let world = self.0.assembly.plant().world(&setup::cell_id(cell));
        world.expect("a world")
    }

    pub(crate) fn server_process(&self) -> u32 {
        self.0.server.lock().unwrap().id()
    }

    /// Bytes of the journal's files.
    pub(crate) fn journal_bytes(&self) -> u64 {
        let files = std::fs::read_dir(self.0.folder.path()).unwrap();
        let lengths = files
            .filter_map(Result::ok)
            .filter(|file| {
                file.file_name()
                    .to_string_lossy()
                    .starts_with("load.journal")
            })
            .filter_map(|file| file.metadata().ok())
            .map(|data| data.len());
        lengths.sum()
    }

    /// Seconds of the cells that all mobile robots have lived.
    pub(crate) async fn now(&self) -> f64 {
        let mut least = f64::INFINITY;
        for robot in self.0.assembly.plant().mobile_robots() {
            least = least.min(robot.state().await.unwrap().time_s);
        }
        least
    }

    /// Waits until all mobile robots have lived that long.
    pub(crate) async fn until(&self, seconds: f64) {
        while self.now().await < seconds {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }

    pub(crate) async fn get(&self, path: &str) -> Value {
        let answer = self.try_get(path).await;
        answer.unwrap_or_else(|| panic!("GET {path} has no answer"))
    }

    pub(crate) async fn text(&self, path: &str) -> String {
        let url = format!("http://{}{path}", self.0.address);
        self.0
            .http
            .get(url)
            .send()
            .await
            .unwrap()
            .text()
            .await
            .unwrap()
    }

    async fn try_get(&self, path: &str) -> Option<Value> {
        let url = format!("http://{}{path}", self.0.address);
        let answer = self.0.http.get(url).send().await.ok()?;
        answer.status().is_success().then_some(())?;
        answer.json().await.ok()
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let key = self.0.keys.fetch_add(1, Ordering::Relaxed);
        let request = self
            .0
            .http
            .post(format!("http://{}{path}", self.0.address))
            .header("idempotency-key", format!("load-{key}"))
            .json(body);
        let answer = request.send().await.unwrap();
        let status = answer.status().as_u16();
        (status, answer.json().await.unwrap_or(Value::Null))
    }

    /// Waits until `look` finds something. Ends the test where that takes so long that it must hang.
    pub(crate) async fn wait<T>(&self, what: &str, look: impl AsyncFn(&Self) -> Option<T>) -> T {
        let until = Instant::now() + HANGS;
        loop {
            if let Some(found) = look(self).await {
                return found;
            }
            let ended = self.0.server.lock().unwrap().try_wait().unwrap();
            assert!(ended.is_none(), "the server ended: {ended:?}");
            let late = Instant::now() >= until;
            assert!(
                !late,
                "timed out waiting for {what}: {}",
                self.story().await
            );
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// What a person would look at where nothing goes on.
    async fn story(&self) -> String {
        let mut story = String::new();
        for cell in 0..CELLS {
            let base = format!("/api/v1/cells/{}", setup::cell_id(cell));
            for part in [
                "jobs?state=IDLE&state=EXECUTE&state=HELD&state=SUSPENDED",
                "interventions",
                "mobile-robots",
            ] {
                let found = self.try_get(&format!("{base}/{part}")).await;
                let found = found.map(|value| serde_json::to_string(&value).unwrap());
                // Writing to a string cannot fail.
                let _ = write!(story, "\n{base}/{part}: {}", found.unwrap_or_default());
            }
        }
        story
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        let mut server = self
            .server
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let _gone = server.kill();
        let _gone = server.wait();
    }
}
