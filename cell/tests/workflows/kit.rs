//! The whole demo cell on free ports, faster than life, with a server whose plug can be pulled.

use std::net::{SocketAddr, TcpListener as StdListener};
use std::path::PathBuf;
use std::process::Child;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use cell::Assembly;
use karel_emulator::{LedgerEntry, LedgerEvent, VirtualController};
use mobile_emulator::MobileRobot;
use reqwest::{Client, StatusCode};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio_util::sync::CancellationToken;

use crate::child::Program;
use crate::faults_disk::Disk;
use crate::faults_wire::Wires;

/// Seconds of the cell in a second.
pub(crate) const SCALE: f64 = 15.0;
/// How often something that is waited for is looked at.
const LOOK: Duration = Duration::from_millis(8);
/// A job of two drives and a few motions takes about two minutes of the cell's time.
pub(crate) const A_JOB: Duration = Duration::from_mins(1);
/// The demo's, for machines that are slow: at this pace a silence of three seconds is 150 ms, and a busy core alone
/// would be taken for a mobile robot that fell silent.
pub(crate) const SETUP: &str = concat!(
    include_str!("../../demo.setup.toml"),
    "\n[timers]\nheartbeat_ms = 15000\narm_silence_ms = 15000\nmotion_margin_ms = 20000\n",
    "grip_ms = 15000\nsafe_ms = 15000\n"
);
const BASE: &str = "/api/v1/cells/demo";

/// A server that runs.
enum Running {
    /// In a runtime of its own: pulling its plug takes every task of it, wherever it is.
    Here(Runtime, CancellationToken),
    /// In a process of its own, killed by SIGKILL.
    Process(Child),
}

/// The cell's configuration, without its set-up.
pub(crate) fn config() -> String {
    config_at(SCALE)
}

fn config_at(scale: f64) -> String {
    format!(
        "[server]\ndemo = true\nlisten = '127.0.0.1:0'\n\
         [[cells]]\nid = 'demo'\n\
         [[cells.robots]]\nid = 'r1'\nmodel = 'fanuc-m20ia'\ncontroller = 'virtual:vc1'\n\
         tier = 'cell_server'\ntime_scale = {scale:.1}\n\
         [[virtual_controllers]]\nname = 'vc1'\nmodel = 'fanuc-m20ia'\nruns = 'cell_server'\n\
         time_scale = {scale:.1}\nstart_joints_deg = [90, 0, 0, 0, -90, 0]\n\
         [[virtual_mobile_robots]]\ncell = 'demo'\nid = 'mr1'\ntime_scale = {scale:.1}\n"
    )
}

/// The virtual world and the server before it.
pub(crate) struct TestCell {
    pub(crate) assembly: Assembly,
    server: Option<Running>,
    address: SocketAddr,
    journal: PathBuf,
    /// What happens to its writes.
    pub(crate) disk: Disk,
    /// The lines to the controller, where they can be cut.
    pub(crate) wires: Option<Wires>,
    /// The server is a process of its own.
    program: Option<Program>,
    folder: tempfile::TempDir,
    http: Client,
    keys: AtomicU64,
}

impl TestCell {
    pub(crate) async fn start() -> Self {
        Self::with_setup(SETUP).await
    }

    pub(crate) async fn with_setup(setup: &str) -> Self {
        let mut cell = Self::dark(setup).await;
        cell.start_server().await;
        cell
    }

    /// The program that simulates for this cell only, so that its processes are told from those of other tests.
    pub(crate) fn simulator(&self) -> PathBuf {
        self.folder.path().join("robocell")
    }

    /// The server can simulate jobs.
    pub(crate) async fn simulating() -> Self {
        Self::simulating_with(SCALE, SETUP).await
    }

    pub(crate) async fn simulating_with(scale: f64, setup: &str) -> Self {
        let mut cell = Self::dark_at(scale, setup).await;
        let program = cell.simulator();
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_robocell"), &program).unwrap();
        cell.assembly.simulate_with(program);
        cell.start_server().await;
        // A simulation begins where the robots are.
        cell.until_heard().await;
        cell
    }

    /// Waits until every robot was heard.
    pub(crate) async fn until_heard(&self) {
        self.wait("every robot is heard", A_JOB, async |cell| {
            let mobile = cell.get("/mobile-robots").await;
            let arm = cell.get("/robots/r1/state").await;
            (mobile[0]["connected"] == true && !arm["controller"].is_null()).then_some(())
        })
        .await;
    }

    /// With lines to the controller that can be cut.
    pub(crate) async fn with_wires() -> Self {
        let mut cell = Self::dark(SETUP).await;
        let wires = Wires::to(cell.controller()).await;
        let (command, status) = (wires.command.address(), wires.status.address());
        assert!(cell.assembly.reroute("r1", command, status), "r1");
        cell.wires = Some(wires);
        cell.start_server().await;
        cell
    }

    /// With a journal of at most so many pages of 4 KiB, on a disk that does not grow.
    pub(crate) async fn with_pages(pages: u32) -> Self {
        let mut cell = Self::dark(SETUP).await;
        cell.disk.limit(Some(pages));
        cell.start_server().await;
        cell
    }

    pub(crate) fn journal(&self) -> &std::path::Path {
        &self.journal
    }

    /// The server as the real program, in a process of its own.
    pub(crate) async fn of_processes() -> Self {
        Self::of_processes_with(SETUP).await
    }

    pub(crate) async fn of_processes_with(setup: &str) -> Self {
        let mut cell = Self::dark(setup).await;
        let parts_at = cell.assembly.parts_at().unwrap();
        let program = Program::prepare(cell.folder.path(), &config(), setup, parts_at);
        cell.program = Some(program);
        cell.start_server().await;
        cell
    }

    /// The world, without a server yet.
    async fn dark(setup: &str) -> Self {
        Self::dark_at(SCALE, setup).await
    }

    /// With one more mobile robot, and what its configuration says.
    pub(crate) async fn with_another(setup: &str, id: &str, more: &str) -> Self {
        let config = format!(
            "{}[[virtual_mobile_robots]]\ncell = 'demo'\nid = '{id}'\ntime_scale = {SCALE:.1}\n{more}\n",
            config()
        );
        let mut cell = Self::dark_of(&config, setup).await;
        cell.start_server().await;
        cell
    }

    async fn dark_at(scale: f64, setup: &str) -> Self {
        Self::dark_of(&config_at(scale), setup).await
    }

    async fn dark_of(config: &str, setup: &str) -> Self {
        let mut assembly = Assembly::start(config, setup).await.unwrap();
        let folder = tempfile::tempdir().unwrap();
        let listener = StdListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        assembly.start_mobile_robots(address).unwrap();
        Self {
            assembly,
            server: None,
            address,
            journal: folder.path().join("cell.journal"),
            disk: Disk::default(),
            wires: None,
            program: None,
            folder,
            http: Client::new(),
            keys: AtomicU64::new(0),
        }
    }

    /// Starts the server, and waits until it answers.
    pub(crate) async fn start_server(&mut self) {
        self.plug_in().await;
        let _ready = self
            .wait("the server lives", Duration::from_secs(20), async |cell| {
                cell.get_any("/livez").await.map(drop)
            })
            .await;
    }

    /// Pulls the plug and starts the server again.
    pub(crate) async fn crash(&mut self) {
        self.pull_the_plug();
        self.start_server().await;
    }

    /// Starts the server and does not wait until it answers.
    pub(crate) async fn plug_in(&mut self) {
        assert!(self.server.is_none(), "one server at a time");
        if let Some(program) = &self.program {
            self.server = Some(Running::Process(program.start(self.address)));
            return;
        }
        let runtime = Runtime::new().unwrap();
        let stop = CancellationToken::new();
        let (path, disk) = (self.journal.clone(), self.disk.clone());
        let journal = async move { disk.open(&path).await };
        let journal = runtime.spawn(journal).await.unwrap();
        let address = self.address;
        let listener = runtime
            .spawn(async move {
                loop {
                    match TcpListener::bind(address).await {
                        Ok(listener) => return listener,
                        Err(_still_held) => tokio::time::sleep(Duration::from_millis(1)).await,
                    }
                }
            })
            .await
            .unwrap();
        let serving = self
            .assembly
            .serve(listener, journal, stop.clone())
            .unwrap();
        drop(runtime.spawn(serving));
        self.server = Some(Running::Here(runtime, stop));
    }

    /// Pulls the plug: nothing of the server runs any more, nothing is written, nothing is said to anybody.
    pub(crate) fn pull_the_plug(&mut self) {
        match self.server.take().expect("a server runs") {
            Running::Here(runtime, _never_cancelled) => runtime.shutdown_background(),
            Running::Process(mut child) => {
                child.kill().unwrap();
                let _killed = child.wait().unwrap();
            }
        }
    }

    pub(crate) async fn is_over(&self, job: &str) -> bool {
        let job = self.get(&format!("/jobs/{job}")).await;
        matches!(job["state"].as_str(), Some("COMPLETE" | "STOPPED"))
    }

    pub(crate) async fn post(&self, path: &str, body: &Value) -> (StatusCode, Value) {
        let key = self.keys.fetch_add(1, Ordering::Relaxed);
        self.post_with_key(path, &format!("test-{key}"), body).await
    }

    pub(crate) async fn post_with_key(
        &self,
        path: &str,
        key: &str,
        body: &Value,
    ) -> (StatusCode, Value) {
        self.send(path, body, &[("idempotency-key", key)]).await
    }

    /// What a person asks for who has control of the cell.
    pub(crate) async fn post_in_control(
        &self,
        path: &str,
        control: &str,
        body: &Value,
    ) -> (StatusCode, Value) {
        let key = self.keys.fetch_add(1, Ordering::Relaxed);
        let key = format!("test-{key}");
        let headers = [("idempotency-key", &*key), ("control-token", control)];
        self.send(path, body, &headers).await
    }

    /// Takes control of the cell for a minute, and returns its token.
    pub(crate) async fn take_control(&self) -> String {
        let body = json!({"station": "REMOTE", "ttl_s": 60, "reason": "a look", "preempt": true});
        let (status, lease) = self.post("/control-authority", &body).await;
        assert_eq!(status, 201, "{lease}");
        lease["token"].as_str().unwrap().to_owned()
    }

    async fn send(
        &self,
        path: &str,
        body: &Value,
        headers: &[(&str, &str)],
    ) -> (StatusCode, Value) {
        let url = format!("http://{}{BASE}{path}", self.address);
        let mut request = self.http.post(url).json(body);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let answer = request.send().await.unwrap();
        let status = answer.status();
        (status, answer.json().await.unwrap_or(Value::Null))
    }

    pub(crate) async fn put(&self, path: &str, body: &Value) -> (StatusCode, Value) {
        let url = format!("http://{}{BASE}{path}", self.address);
        let answer = self.http.put(url).json(body).send().await.unwrap();
        let status = answer.status();
        (status, answer.json().await.unwrap_or(Value::Null))
    }

    /// Changes a part of the set-up as it is now; without a body it is removed.
    pub(crate) async fn change_setup(&self, part: &str, body: Option<&Value>) {
        let url = format!("http://{}{BASE}/setup", self.address);
        let now = self.http.get(&url).send().await.unwrap();
        let etag = now.headers()["etag"].clone();
        let part = format!("{url}/{part}");
        let request = match body {
            Some(body) => self.http.put(part).json(body),
            None => self.http.delete(part),
        };
        let answer = request.header("if-match", etag).send().await.unwrap();
        let status = answer.status();
        assert!(status.is_success(), "{status} {:?}", answer.text().await);
    }

    pub(crate) async fn delete(&self, path: &str) -> StatusCode {
        let url = format!("http://{}{BASE}{path}", self.address);
        self.http.delete(url).send().await.unwrap().status()
    }

    /// What a GET is answered, whatever the status.
    pub(crate) async fn try_get(&self, path: &str) -> (StatusCode, Value) {
        let url = format!("http://{}{path}", self.address);
        let answer = self.http.get(url).send().await.unwrap();
        let status = answer.status();
        (status, answer.json().await.unwrap_or(Value::Null))
    }

    pub(crate) async fn get(&self, path: &str) -> Value {
        let found = self.get_any(&format!("{BASE}{path}")).await;
        found.unwrap_or_else(|| panic!("GET {path} has no answer"))
    }

    async fn get_any(&self, path: &str) -> Option<Value> {
        let url = format!("http://{}{path}", self.address);
        let answer = self.http.get(url).send().await.ok()?;
        answer.status().is_success().then_some(())?;
        answer.json().await.ok()
    }

    /// Asks for a job and returns its id.
    pub(crate) async fn job(&self, workflow: &str, params: Value) -> String {
        let body = json!({"workflow": workflow, "params": params});
        let (status, job) = self.post("/jobs", &body).await;
        assert!(status.is_success(), "{status} {job}");
        job["id"].as_str().unwrap().to_owned()
    }

    /// A delivery of load-1, which mr1 has in its left slot at the beginning, to a place of the rack.
    pub(crate) async fn delivery(&self, place: &str) -> String {
        let body = Self::delivery_body(place);
        self.job("delivery-and-placement", body["params"].clone())
            .await
    }

    pub(crate) fn delivery_body(place: &str) -> Value {
        json!({
            "workflow": "delivery-and-placement",
            "params": {
                "point": "handover/front",
                "items": [{"load_id": "load-1", "type": "crate", "mr_slot": "left", "place": place}]
            }
        })
    }

    /// A pickup of load-2, which is in rack/a at the beginning, to the warehouse.
    pub(crate) async fn pickup(&self) -> String {
        let body = Self::pickup_body();
        self.job("pickup-and-delivery", body["params"].clone())
            .await
    }

    pub(crate) fn pickup_body() -> Value {
        json!({
            "workflow": "pickup-and-delivery",
            "params": {
                "point": "handover/front",
                "items": [{"load_id": "load-2", "type": "crate", "mr_slot": "right", "place": "rack/a"}],
                "destination": "warehouse/gate",
                "complete_on": "DELIVERED"
            }
        })
    }

    /// Sends a request and pulls the plug before its answer is there, or just when it is.
    pub(crate) async fn lose(&mut self, path: &str, key: &str, body: &Value, after: Duration) {
        let url = format!("http://{}{BASE}{path}", self.address);
        let request = self
            .http
            .post(url)
            .header("idempotency-key", key)
            .json(body);
        let _answer = tokio::time::timeout(after, request.send()).await;
        self.pull_the_plug();
    }

    /// Waits until some time has passed: a random moment.
    pub(crate) async fn after(&self, time: Duration) {
        let at = Instant::now() + time;
        self.wait("a moment", A_JOB, async |_| {
            (Instant::now() >= at).then_some(())
        })
        .await;
    }

    pub(crate) fn controller(&self) -> &VirtualController {
        self.assembly.controller("vc1").expect("vc1")
    }

    pub(crate) fn mobile_robot(&self) -> &MobileRobot {
        let mut robots = self.assembly.plant().mobile_robots().iter();
        robots.next().expect("mr1")
    }

    /// Why the journal is not opened as it is.
    pub(crate) async fn refused_journal(&self) -> String {
        self.disk.refused(&self.journal).await
    }

    /// Why the server does not start on its journal.
    pub(crate) async fn refused_server(&self) -> String {
        let journal = self.disk.open(&self.journal).await;
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let stop = CancellationToken::new();
        let serving = self.assembly.serve(listener, journal, stop).unwrap();
        let error = serving.await.expect_err("it should not start");
        format!("{error:#}")
    }

    /// How many commands of the wire the arm has begun.
    pub(crate) async fn begun(&self) -> usize {
        let ledger = self.ledger().await;
        let begun = ledger
            .iter()
            .filter(|entry| entry.event == LedgerEvent::Started);
        begun.count()
    }

    /// Waits until a job is in one of `states`; the job then.
    pub(crate) async fn wait_for_job(&self, job: &str, states: &[&str]) -> Value {
        let path = format!("{BASE}/jobs/{job}");
        let wanted = format!("job {job} in {states:?}");
        self.wait(&wanted, A_JOB, async |cell| {
            let job = cell.get_any(&path).await?;
            let state = job["state"].as_str()?;
            states.contains(&state).then_some(job)
        })
        .await
    }

    /// Waits until `look` finds something, and says what was missing where it does not.
    pub(crate) async fn wait<T>(
        &self,
        what: &str,
        limit: Duration,
        look: impl AsyncFn(&Self) -> Option<T>,
    ) -> T {
        let until = Instant::now() + limit;
        loop {
            if let Some(found) = look(self).await {
                return found;
            }
            if Instant::now() >= until {
                let jobs = self.get_any(&format!("{BASE}/jobs")).await;
                let questions = self.get_any(&format!("{BASE}/interventions")).await;
                let sessions = self.get_any(&format!("{BASE}/sessions")).await;
                panic!(
                    "timed out waiting for {what}\njobs: {}\ninterventions: {}\nsessions: {}",
                    pretty(jobs),
                    pretty(questions),
                    pretty(sessions)
                );
            }
            tokio::time::sleep(LOOK).await;
        }
    }

    /// What the arm really did.
    pub(crate) async fn ledger(&self) -> Vec<LedgerEntry> {
        self.controller().ledger().await.unwrap()
    }

    /// No command of the wire began twice, and none in another order than that of its numbers.
    pub(crate) async fn assert_nothing_twice(&self) {
        let ledger = self.ledger().await;
        let started: Vec<_> = ledger
            .iter()
            .filter(|entry| entry.event == LedgerEvent::Started)
            .filter_map(|entry| entry.command.as_ref().map(|id| (id.epoch, id.seq)))
            .collect();
        let mut sorted = started.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(started, sorted, "a motion began twice, or out of order");
    }

    /// Where the parts truly are, by the world's own account.
    pub(crate) fn truly_at(&self, part: &str) -> cell::world::PartAt {
        let world = self.assembly.plant().world("demo").expect("a world");
        world.parts().get(part).cloned().expect("a part")
    }

    /// Where the server says a load is.
    pub(crate) async fn custody(&self, load: &str) -> Value {
        self.get(&format!("/loads/{load}")).await
    }
}

impl Drop for TestCell {
    fn drop(&mut self) {
        match self.server.take() {
            None => {}
            Some(Running::Here(runtime, stop)) => {
                stop.cancel();
                runtime.shutdown_background();
            }
            Some(Running::Process(mut child)) => {
                let _gone = child.kill();
                let _gone = child.wait();
            }
        }
    }
}

fn pretty(value: Option<Value>) -> String {
    value.map_or_else(
        || "no answer".to_owned(),
        |value| serde_json::to_string_pretty(&value).unwrap_or_default(),
    )
}
