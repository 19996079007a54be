//! Load: eight arms and eight mobile robots before one server, jobs back to back, judged by what the emulators did.
//!
//! Four cells of two arms and two mobile robots each. In a cell both arms reach both hand-over points, and both mobile
//! robots go to either: every job waits in the queue for a point, an arm and a mobile robot that others use as well.
//! The server is the real program in a process of its own, so that what it holds is its own.
//!
//! Nothing here depends on how fast the machine is, except how long it takes: `ROBOCELL_LOAD_SCALE` says how many
//! seconds of the cells pass in a second, `ROBOCELL_LOAD_MINUTES` how many of their minutes are worked.
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    reason = "helpers of tests: a failure here fails the test"
)]

mod judge;
mod person;
mod plant;
mod setup;
mod usage;
mod worker;

use plant::LoadedPlant;
use usage::Usage;
use worker::Worker;

/// Seconds of the cells in a second.
const SCALE: f64 = 4.0;
/// Minutes of the cells.
const MINUTES: f64 = 20.0;

fn from_environment(name: &str, absent: f64) -> f64 {
    std::env::var(name).map_or(absent, |text| text.parse().expect("a number"))
}

#[tokio::test(flavor = "multi_thread")]
async fn eight_arms_and_eight_mobile_robots_work_back_to_back_and_nothing_leaks() {
    tokio::task::LocalSet::new()
        .run_until(work_and_judge())
        .await;
}

async fn work_and_judge() {
    let scale = from_environment("ROBOCELL_LOAD_SCALE", SCALE);
    let work = from_environment("ROBOCELL_LOAD_MINUTES", MINUTES) * 60.0;
    let plant = LoadedPlant::start(scale).await;
    let checks = plant.checks().await;
    assert!(checks.is_empty(), "the set-up: {checks:#?}");

    let begun = plant.now().await;
    let seconds = begun + work;
    let workers = (0..setup::CELLS).flat_map(|cell| (0..2).map(move |mobile| (cell, mobile)));
    let working: Vec<_> = workers
        .map(|(cell, mobile)| {
            let worker = Worker::new(plant.clone(), cell, mobile);
            tokio::task::spawn_local(worker.work_until(seconds))
        })
        .collect();
    let said = std::rc::Rc::default();
    let person =
        tokio::task::spawn_local(person::answers(plant.clone(), std::rc::Rc::clone(&said)));
    plant.until(begun + work / 3.0).await;
    let early = Usage::of(&plant).await;
    plant.until(begun + work * 2.0 / 3.0).await;
    let middle = Usage::of(&plant).await;
    let mut done = worker::Done::default();
    for work in working {
        done.add(&work.await.unwrap());
    }
    person.abort();
    let late = Usage::of(&plant).await;
    let lived = plant.now().await - begun;
    let said = said.take();
    eprintln!(
        "{lived:.0} s of the cells: {} jobs ({} of them waited in the queue), {} crates brought, {} taken, {:.1} jobs an hour and \
         mobile robot; a person was asked {} times\nafter a third: {early:?}\nafter two: {middle:?}\nat the end: {late:?}\n{said:#?}",
        done.jobs,
        done.queued,
        done.brought,
        done.taken,
        f64::from(done.jobs) / 8.0 / (lived / 3600.0),
        said.len(),
    );
    judge::everything(&plant, &done).await;
    late.assert_no_leak_since(&early, &done);
}
