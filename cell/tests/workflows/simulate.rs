//! Jobs in virtual time: the real world does not notice, and what is foretold happens.

use api::JobSimulation;
use cell::world::PartAt;
use karel_emulator::Operation;
use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::kit::{A_JOB, SCALE, SETUP, TestCell};

const SIMULATE: &str = "/jobs/simulate";
/// A cycle that is simulated takes as long as a real one, within this part of it.
const TOLERANCE: f64 = 0.15;

fn delivery(place: &str) -> Value {
    json!({
        "workflow": "delivery-and-placement",
        "params": {
            "point": "handover/front",
            "items": [{"load_id": "load-1", "type": "crate", "mr_slot": "left", "place": place}]
        }
    })
}

impl TestCell {
    async fn simulated(&self, body: &Value) -> JobSimulation {
        let (status, answer) = self.post(SIMULATE, body).await;
        assert_eq!(status, StatusCode::OK, "{answer:#}");
        let simulation: JobSimulation = serde_json::from_value(answer).unwrap();
        assert_eq!(simulation.violations, [], "{:#?}", simulation.violations);
        simulation
    }

    /// Everything of the cell that a job would change.
    async fn traces(&self) -> (usize, Vec<Value>, Value, Value, String) {
        let mut loads = Vec::new();
        for load in ["load-1", "load-2", "load-3", "load-4"] {
            loads.push(self.custody(load).await);
        }
        let ledger = self.ledger().await.len();
        let orders = self.mobile_robot().ledger().await.unwrap();
        let orders = orders
            .iter()
            .filter(|entry| {
                matches!(
                    entry.event,
                    mobile_emulator::LedgerEvent::OrderTaken { .. }
                        | mobile_emulator::LedgerEvent::DriveStarted { .. }
                )
            })
            .count();
        let parts = format!("{:?}", self.assembly.plant().world("demo").unwrap().parts());
        let jobs = self.get("/jobs").await;
        (ledger, loads, json!(orders), jobs, parts)
    }
}

/// The phases as they are worked through, and the time from the start of the work to the end.
fn phases(report: &Value) -> Vec<(String, String)> {
    let phases = report["phases"].as_array().unwrap();
    let told = phases.iter().map(|phase| {
        let text = |key: &str| phase[key].as_str().unwrap_or_default().to_owned();
        (format!("{} {}", text("code"), text("phase")), text("place"))
    });
    told.collect()
}

async fn foretold(cell: &TestCell, body: Value) -> (JobSimulation, Value) {
    let before = cell.traces().await;
    let simulated = cell.simulated(&body).await;
    assert_eq!(cell.traces().await, before, "the cell has changed");
    assert_eq!(serde_json::to_value(simulated.outcome).unwrap(), "COMPLETE");
    assert_eq!(simulated.interventions, []);
    let [supposed] = &*simulated.assumptions else {
        panic!("{:?}", simulated.assumptions)
    };
    assert!(
        supposed.starts_with("mobile robots drive and dock like the default mobile emulator"),
        "{supposed}"
    );

    let workflow = body["workflow"].as_str().unwrap();
    let job = cell.job(workflow, body["params"].clone()).await;
    let _done = cell.wait_for_job(&job, &["COMPLETE"]).await;
    let report = cell.get(&format!("/jobs/{job}/report")).await;
    let told = serde_json::to_value(&simulated.report).unwrap();
    assert_eq!(phases(&told), phases(&report));
    (simulated, report)
}

/// Its own pace: faster, a millisecond between two programs is many of the cell's, and more where the machine is busy.
const OWN_PACE: f64 = 1.0;

/// Real milliseconds are of the wall, and the cell under test runs `scale` times as fast.
#[expect(clippy::cast_precision_loss, reason = "some minutes")]
fn cycles(simulated: &JobSimulation, report: &Value, scale: f64) -> (f64, f64) {
    let real = report["cycle_ms"].as_f64().unwrap() * scale;
    (simulated.report.cycle_ms as f64, real)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_simulated_delivery_changes_nothing_and_foretells_the_real_one() {
    let cell = TestCell::simulating_with(OWN_PACE, SETUP).await;
    let (simulated, report) = foretold(&cell, delivery("rack/d")).await;
    let (told, real) = cycles(&simulated, &report, OWN_PACE);
    assert!(
        (told - real).abs() <= TOLERANCE * real,
        "simulated {told} ms, real {real} ms"
    );
    let end = simulated.loads.iter().find(|load| load.id == "load-1");
    let end = serde_json::to_value(&end.unwrap().location).unwrap();
    assert_eq!(end, cell.custody("load-1").await["location"]);
    assert_eq!(
        simulated.custody.len(),
        2,
        "into the gripper, and out of it"
    );
    assert!(
        simulated
            .permits
            .iter()
            .any(|permit| permit.arm_entry_permit)
    );
    assert!(
        simulated
            .permits
            .iter()
            .all(|permit| !(permit.arm_entry_permit && permit.mr_move_permit))
    );
    assert!(simulated.motions.iter().all(|motion| motion.end.is_some()));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_simulated_pickup_changes_nothing_and_foretells_the_real_one() {
    let cell = TestCell::simulating().await;
    let (simulated, report) = foretold(&cell, TestCell::pickup_body()).await;
    let (told, real) = cycles(&simulated, &report, SCALE);
    assert!(
        told <= real && told >= real / 2.0,
        "simulated {told} ms, real {real} ms, of which some on the way between fast programs"
    );
    let end = simulated.loads.iter().find(|load| load.id == "load-2");
    let end = serde_json::to_value(&end.unwrap().location).unwrap();
    assert_eq!(end["at"], "DELIVERED");
}

/// The rack is too far away in this set-up: nothing moves, and the fault and the pose are named.
#[tokio::test(flavor = "multi_thread")]
async fn f06_a_simulated_job_out_of_reach_is_stopped_and_says_why() {
    let far = SETUP.replacen("x_mm = -100, y_mm = 1000", "x_mm = -100, y_mm = 2600", 1);
    assert_ne!(far, SETUP);
    let cell = TestCell::simulating_with(SCALE, &far).await;
    let before = cell.traces().await;
    let simulated = cell.simulated(&delivery("rack/d")).await;
    assert_eq!(simulated.outcome, api::JobState::Stopped);
    assert_eq!(simulated.ended, api::SimulationEnd::JobOver);
    assert_eq!(simulated.fault.unwrap().code, "F6");
    assert!(simulated.text.contains("rack/d"), "{}", simulated.text);
    assert_eq!(simulated.motions, []);
    assert_eq!(cell.traces().await, before);
}

/// A job that runs is left out, said so, and not disturbed.
#[tokio::test(flavor = "multi_thread")]
async fn a_job_is_simulated_while_another_one_runs() {
    let cell = TestCell::simulating().await;
    let running = cell.delivery("rack/d").await;
    let _works = cell.wait_for_job(&running, &["EXECUTE"]).await;
    let simulated = cell.simulated(&TestCell::pickup_body()).await;
    assert_eq!(simulated.outcome, api::JobState::Complete);
    let said = simulated.assumptions.join("; ");
    assert!(said.contains("job 1 is open"), "{said}");
    assert!(said.contains("mr1 works for job 1"), "{said}");
    let _done = cell.wait_for_job(&running, &["COMPLETE"]).await;
    assert_eq!(cell.truly_at("load-1"), PartAt::Place("rack/d".to_owned()));
    cell.assert_nothing_twice().await;
}

/// One at a time; and who goes away takes the simulation along.
#[tokio::test(flavor = "multi_thread")]
async fn a_second_simulation_is_refused_until_the_first_one_is_dropped() {
    let cell = TestCell::simulating().await;
    let body = delivery("rack/d");
    {
        let first = cell.post(SIMULATE, &body);
        tokio::pin!(first);
        let refused = async {
            cell.wait("a second one is refused", A_JOB, async |cell| {
                // Only then it is certain which one is the first.
                if cell.simulating_processes().is_empty() {
                    return None;
                }
                let (status, problem) = cell.post(SIMULATE, &delivery("rack/e")).await;
                (problem["code"] == "simulator-busy").then_some((status, problem))
            })
            .await
        };
        tokio::select! {
            done = &mut first => panic!("it was over before it was looked at: {done:?}"),
            (status, problem) = refused => {
                assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE);
                assert_eq!(problem["retryable"], true);
                assert!(!cell.simulating_processes().is_empty(), "a simulation has a process");
            }
        }
    }
    // The first caller has gone.
    let none = cell.wait("no process is left of it", A_JOB, async |cell| {
        cell.simulating_processes().is_empty().then_some(())
    });
    none.await;
    let simulated = cell.simulated(&body).await;
    assert_eq!(simulated.outcome, api::JobState::Complete);
    assert_eq!(
        cell.simulating_processes(),
        Vec::<u32>::new(),
        "nothing is left of a simulation"
    );
}

impl TestCell {
    /// Processes that simulate for this cell, by the name of its own that they were started by.
    fn simulating_processes(&self) -> Vec<u32> {
        let name = self.simulator().to_str().unwrap().to_owned();
        let all = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
            let id: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
            let command = std::fs::read_to_string(format!("/proc/{id}/cmdline")).ok()?;
            command.starts_with(&name).then_some(id)
        });
        all.collect()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_simulation_is_refused_as_the_job_would_be() {
    let cell = TestCell::simulating().await;
    let mut nowhere = delivery("rack/z");
    let (status, problem) = cell.post(SIMULATE, &nowhere).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{problem}");
    assert_eq!(problem["code"], "validation");
    assert!(problem["detail"].as_str().unwrap().contains("rack/z"));
    nowhere["faults"] = json!([]);
    let (status, problem) = cell.post(SIMULATE, &nowhere).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{problem}");
}

/// What is in a gripper now cannot be moved by a simulated job, and what nobody can find ends all of it.
#[tokio::test(flavor = "multi_thread")]
async fn a_load_in_a_gripper_or_lost_is_named() {
    let cell = TestCell::simulating().await;
    // Slowly, so that it is seen.
    cell.controller().set_override(30).await.unwrap();
    let job = cell.delivery("rack/d").await;
    cell.wait("the load is in the gripper", A_JOB, async |cell| {
        let custody = cell.custody("load-1").await;
        (custody["location"]["at"] == "GRIPPER").then_some(())
    })
    .await;
    let (status, problem) = cell.post(SIMULATE, &delivery("rack/e")).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY, "{problem}");
    assert_eq!(problem["code"], "validation");
    assert!(problem["detail"].as_str().unwrap().contains("load-1"));
    let lose = cell.controller().operate(Operation::LosePart).await;
    lose.unwrap();
    let _lost = cell.wait_for_job(&job, &["ABORTED"]).await;
    let (status, problem) = cell.post(SIMULATE, &TestCell::pickup_body()).await;
    assert_eq!(status, StatusCode::CONFLICT, "{problem}");
    assert_eq!(problem["code"], "custody-unknown");
    assert!(problem["detail"].as_str().unwrap().contains("load-1"));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_without_a_simulator_says_so() {
    let cell = TestCell::start().await;
    let (status, problem) = cell.post(SIMULATE, &delivery("rack/d")).await;
    assert_eq!(status, StatusCode::NOT_IMPLEMENTED, "{problem}");
    assert_eq!(problem["code"], "simulator-missing");
}
