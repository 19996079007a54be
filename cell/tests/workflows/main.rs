//! Both group workflows from the HTTP request to the loads, judged by what the emulators did.
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::indexing_slicing,
    reason = "helpers of tests: a failure here fails the test"
)]

mod c10;
mod chance;
mod child;
mod crashes;
mod faults;
mod faults_delivery;
mod faults_disk;
mod faults_evidence;
mod faults_journal;
mod faults_others;
mod faults_pickup;
mod faults_wire;
mod judge;
mod kit;
mod mobile;
mod operator;
mod random_moments;
mod rows;
mod run;
mod sigkill;
mod simulate;
mod zones;

use cell::world::PartAt;
use kit::TestCell;

#[tokio::test(flavor = "multi_thread")]
async fn a_delivery_brings_the_load_from_the_mobile_robot_to_its_place() {
    let cell = TestCell::start().await;
    let job = cell.delivery("rack/d").await;
    let _done = cell.wait_for_job(&job, &["COMPLETE"]).await;
    assert_eq!(cell.truly_at("load-1"), PartAt::Place("rack/d".to_owned()));
    assert_eq!(cell.custody("load-1").await["location"]["place"], "rack/d");
    cell.assert_nothing_twice().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pickup_takes_the_load_from_its_place_to_the_destination() {
    let cell = TestCell::start().await;
    let job = cell.pickup().await;
    let _done = cell.wait_for_job(&job, &["COMPLETE"]).await;
    assert!(matches!(cell.truly_at("load-2"), PartAt::Away(_)));
    cell.assert_nothing_twice().await;
}
