//! F21 with the real program: `kill -9` at random moments, and a supervisor that starts it again.

use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::chance::kills;
use crate::child::Program;
use crate::kit::TestCell;
use crate::random_moments::{Moments, crash_at_random};
use crate::rows;

/// Covers: F21, P5, P6, P7, P13.
#[tokio::test(flavor = "multi_thread")]
async fn f21_p13_a_killed_process_does_nothing_twice() {
    crash_at_random(
        TestCell::of_processes,
        &Moments {
            kills: kills(),
            crashes_of_a_job: 5,
            one_start_in: 4,
            start_ms: 60,
        },
    )
    .await;
}

/// Covers: F21, P3, P4, P6, P11.
#[tokio::test(flavor = "multi_thread")]
async fn f21_p13_a_process_killed_in_each_row_of_a_delivery_finishes_it() {
    rows::delivery(TestCell::of_processes().await).await;
}

/// Covers: F21, P3, P4, P6, P11.
#[tokio::test(flavor = "multi_thread")]
async fn f21_p13_a_process_killed_in_each_row_of_a_pickup_finishes_it() {
    rows::pickup(TestCell::of_processes_with(&rows::empty_mobile_robot()).await).await;
}

/// The demo under its supervisor: the server is killed in the middle of a job, and the job ends.
///
/// Covers: F21.
#[tokio::test(flavor = "multi_thread")]
async fn f21_the_supervisor_starts_a_killed_server_again_and_the_job_ends() {
    let folder = tempfile::tempdir().unwrap();
    let listen = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let config = crate::kit::config();
    let setup = crate::kit::SETUP;
    let program = Program::prepare(folder.path(), &config, setup, String::new());
    let supervisor = Command::new(env!("CARGO_BIN_EXE_robocell"))
        .arg("--config")
        .arg(&program.config)
        .args([
            "--listen",
            &listen.to_string(),
            "--demo",
            "--supervised",
            "--log",
            "error",
        ])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let supervisor = Ended(supervisor);
    let base = format!("http://{listen}/api/v1/cells/demo");
    let http = reqwest::Client::new();
    let get = async |path: &str| -> Option<Value> {
        let answer = http.get(format!("{base}{path}")).send().await.ok()?;
        answer.json().await.ok()
    };
    let wait = async |what: &str, found: &dyn Fn(&Value) -> bool, path: &str| {
        let until = Instant::now() + crate::kit::A_JOB;
        loop {
            let seen = get(path).await;
            if let Some(seen) = &seen
                && found(seen)
            {
                return seen.clone();
            }
            assert!(
                Instant::now() < until,
                "timed out waiting for {what}: {seen:#?}"
            );
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    let _lives = wait(
        "the arm's link",
        &|state| state["arms"].is_array(),
        "/state",
    )
    .await;
    let body = json!({"workflow": "delivery-and-placement", "params": {
        "point": "handover/front",
        "items": [{"load_id": "load-1", "type": "crate", "mr_slot": "left", "place": "rack/d"}]
    }});
    let request = http
        .post(format!("{base}/jobs"))
        .header("idempotency-key", "one");
    let job: Value = request
        .json(&body)
        .send()
        .await
        .unwrap()
        .json()
        .await
        .unwrap();
    let path = format!("/jobs/{}", job["id"].as_str().unwrap());
    let _at_work = wait("the arm works", &|job| job["code"] == "A8", &path).await;
    kill_child_of(supervisor.0.id());
    let ended = wait(
        "the end of the job",
        &|job| matches!(job["state"].as_str(), Some("COMPLETE" | "STOPPED")),
        &path,
    )
    .await;
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}");
    let report = get(&format!("{path}/report")).await.unwrap();
    assert_eq!(report["restarts"], 1, "{report:#}");
}

/// `kill -9` of the server, found by its parent.
fn kill_child_of(parent: u32) {
    let children = std::fs::read_to_string(format!("/proc/{parent}/task/{parent}/children"));
    let mut tasks = children.unwrap_or_default();
    if tasks.trim().is_empty() {
        // Whichever thread of the parent started it.
        for task in std::fs::read_dir(format!("/proc/{parent}/task")).unwrap() {
            let at = task.unwrap().path().join("children");
            tasks.push_str(&std::fs::read_to_string(at).unwrap_or_default());
        }
    }
    let child = tasks
        .split_whitespace()
        .next()
        .expect("the server's process");
    let killed = Command::new("kill").args(["-9", child]).status().unwrap();
    assert!(killed.success());
}

/// A supervisor that ends, with its server, when the test does.
struct Ended(std::process::Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let id = self.0.id().to_string();
        let _told = Command::new("kill").arg(id).status();
        let _ended = self.0.wait();
    }
}
