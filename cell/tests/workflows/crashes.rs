//! F21: the server's plug is pulled, at any moment and any number of times, and started again.
//!
//! The arms, the mobile robots and the loads go on meanwhile. Afterwards every job ends, with a person's help where only
//! a person can know, and nothing was done twice.

use std::time::Duration;

use karel_emulator::CmosMemory;
use karel_emulator::gripper::GripperPosition;
use mobile_emulator::Phase;
use serde_json::json;

use crate::chance::kills;
use crate::kit::{A_JOB, TestCell};
use crate::random_moments::{Moments, crash_at_random};
use crate::rows;

/// Covers: F21, P3, P4, P6, P11.
#[tokio::test(flavor = "multi_thread")]
async fn f21_a_delivery_survives_a_crash_in_each_of_its_rows() {
    rows::delivery(TestCell::start().await).await;
}

/// Covers: F21, P3, P4, P6, P11.
#[tokio::test(flavor = "multi_thread")]
async fn f21_a_pickup_survives_a_crash_in_each_of_its_rows() {
    rows::pickup(TestCell::with_setup(&rows::empty_mobile_robot()).await).await;
}

/// A start reads a snapshot and what came after it; one whose snapshot was never written reads more, and that is all.
///
/// Covers: R6, F21.
#[tokio::test(flavor = "multi_thread")]
async fn r6_a_start_on_a_snapshot_goes_on_where_the_job_was() {
    let mut cell = TestCell::start().await;
    let job = cell.delivery("rack/d").await;
    for written in [true, false] {
        let before = cell.disk.snapshots();
        if written {
            cell.wait("a snapshot", A_JOB, async |cell| {
                let _said = cell.answer_everything().await;
                (cell.disk.snapshots() > before).then_some(())
            })
            .await;
        } else {
            cell.disk.stalls_at_snapshots();
            let struck = cell.disk.struck();
            cell.wait("a snapshot is begun", A_JOB, async |cell| {
                let _said = cell.answer_everything().await;
                (cell.disk.struck() > struck).then_some(())
            })
            .await;
        }
        // The arm may be between two operations: it is enough that the job is not over.
        assert!(!cell.is_over(&job).await, "a crash of nothing");
        cell.crash().await;
        cell.disk.is_sound();
        cell.assert_nothing_twice().await;
    }
    let (ended, said) = cell.see_through(&job).await;
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}\n{said:#?}");
    let _story = cell.assert_story(&job).await;
    cell.assert_sound().await;
}

/// Covers: F21, P6, P7, P8, P10, P13.
#[tokio::test(flavor = "multi_thread")]
async fn f21_p13_crashes_at_random_moments_and_during_the_recovery_do_nothing_twice() {
    crash_at_random(
        TestCell::start,
        &Moments {
            kills: kills(),
            crashes_of_a_job: 6,
            one_start_in: 3,
            start_ms: 30,
        },
    )
    .await;
}

/// Pulls the plug the moment something of the world is so. Each of these lasts less than a busy machine may take to look, so what comes after it counts, too.
async fn when(cell: &mut TestCell, what: &str, is_so: impl AsyncFn(&TestCell) -> bool) {
    cell.wait(what, A_JOB, async |cell| is_so(cell).await.then_some(()))
        .await;
    cell.crash().await;
    cell.assert_nothing_twice().await;
}

/// Covers: F21, P7, P10, P11.
#[tokio::test(flavor = "multi_thread")]
async fn f21_a_crash_while_the_world_is_in_motion_is_survived() {
    let mut cell = TestCell::start().await;
    let job = cell.delivery("rack/d").await;
    when(&mut cell, "a permit to move is granted", async |cell| {
        cell.mobile_robot().state().await.unwrap().move_permit
    })
    .await;
    when(&mut cell, "the mobile robot docks", async |cell| {
        let phase = cell.mobile_robot().state().await.unwrap().phase;
        matches!(phase, Some(Phase::Docking | Phase::Docked | Phase::Ready))
    })
    .await;
    when(&mut cell, "the arm moves", async |cell| {
        cell.controller().state().await.unwrap().moving
    })
    .await;
    when(&mut cell, "the gripper closes", async |cell| {
        let gripper = cell.controller().state().await.unwrap().gripper.unwrap();
        gripper.position != GripperPosition::Open
    })
    .await;
    when(&mut cell, "the arm moves with the load", async |cell| {
        let state = cell.controller().state().await.unwrap();
        state.moving && state.gripper.unwrap().part.is_some()
    })
    .await;
    when(&mut cell, "the gripper opens", async |cell| {
        let gripper = cell.controller().state().await.unwrap().gripper.unwrap();
        gripper.position != GripperPosition::Closed
    })
    .await;
    let (ended, said) = cell.see_through(&job).await;
    eprintln!("{said:#?}");
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}");
    cell.assert_sound().await;
}

/// A motion in the middle of which the server died and the controller lost power: nobody can know what it did.
///
/// Covers: F21, P6.
#[tokio::test(flavor = "multi_thread")]
async fn f21_what_only_a_person_can_know_is_asked_with_its_evidence() {
    let mut cell = TestCell::start().await;
    let job = cell.delivery("rack/d").await;
    cell.wait("the arm moves", A_JOB, async |cell| {
        cell.controller()
            .state()
            .await
            .unwrap()
            .moving
            .then_some(())
    })
    .await;
    cell.pull_the_plug();
    cell.controller()
        .power_cycle(CmosMemory::Kept)
        .await
        .unwrap();
    let began = cell.begun().await;
    cell.start_server().await;
    let question = cell
        .wait("a question", A_JOB, async |cell| {
            cell.questions().await.pop()
        })
        .await;
    eprintln!("{question:#}");
    assert_eq!(
        cell.begun().await,
        began,
        "nothing moves before a person answered"
    );
    assert!(
        !question["known"].as_array().unwrap().is_empty(),
        "{question:#}"
    );
    // Once more: the question is still there, and the same one.
    cell.crash().await;
    let again = cell
        .wait("the question again", A_JOB, async |cell| {
            cell.questions().await.pop()
        })
        .await;
    assert_eq!(again["id"], question["id"]);
    assert_eq!(
        cell.begun().await,
        began,
        "nothing moves before a person answered"
    );
    let (ended, said) = cell.see_through(&job).await;
    eprintln!("{said:#?}");
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}");
    cell.assert_sound().await;
}

/// Covers: F21, P1, P2.
#[tokio::test(flavor = "multi_thread")]
async fn f21_a_key_makes_one_job_over_any_crash() {
    let mut cell = TestCell::start().await;
    let body = json!({"workflow": "delivery-and-placement", "params": {
        "point": "handover/front",
        "items": [{"load_id": "load-1", "type": "crate", "mr_slot": "left", "place": "rack/d"}]
    }});
    let (status, first) = cell.post_with_key("/jobs", "the-key", &body).await;
    assert!(status.is_success(), "{status} {first}");
    for _ in 0..3 {
        cell.crash().await;
        let (status, again) = cell.post_with_key("/jobs", "the-key", &body).await;
        assert!(status.is_success(), "{status} {again}");
        assert_eq!(again["id"], first["id"]);
    }
    // A request that the crash met on its way: whether it was kept or not, its key makes one job.
    let lost = TestCell::pickup_body();
    for round in 0..4 {
        let key = format!("lost-{round}");
        let after = Duration::from_millis(2 * round);
        cell.lose("/jobs", &key, &lost, after).await;
        cell.start_server().await;
        let (status, one) = cell.post_with_key("/jobs", &key, &lost).await;
        let (_, two) = cell.post_with_key("/jobs", &key, &lost).await;
        assert!(status.is_success(), "{status} {one}");
        assert_eq!(one["id"], two["id"]);
        let stop = json!({"command": "stop", "reason": "one is enough"});
        let path = format!("/jobs/{}/commands", one["id"].as_str().unwrap());
        let (status, answer) = cell.post(&path, &stop).await;
        assert!(status.is_success(), "{status} {answer}");
    }
    let jobs = cell.get("/jobs").await;
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 5, "{jobs:#}");
    let (ended, _said) = cell.see_through(first["id"].as_str().unwrap()).await;
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}");
    cell.assert_sound().await;
}
