//! The journal in the middle of a job: it cannot be written, it is full, it was edited, the power goes at one record.

use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::sync::atomic::{AtomicUsize, Ordering};

use karel_emulator::{LedgerEvent, Operation};
use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::kit::{A_JOB, TestCell};
use crate::run::{Run, Which};

/// Nothing is taken any more, in the middle of a motion: the motion ends, no other begins, whoever asks for something is
/// told. When it can be written again the job is on hold, and goes on when a person says so.
async fn not_writable(which: Which) {
    let run = Run::start(which).await;
    run.hold_in_motion("PLACE_APPROACH").await;
    run.cell.disk.takes_nothing();
    let begun = run.cell.begun().await;
    run.operate(Operation::CycleStart).await;
    run.until_arm_stands().await;
    run.cell
        .wait("the end could not be kept", A_JOB, async |cell| {
            (cell.disk.struck() > 0).then_some(())
        })
        .await;
    let other = match which {
        Which::Delivery => TestCell::pickup_body(),
        Which::Pickup => TestCell::delivery_body("rack/e"),
    };
    let (status, said) = run.cell.post("/jobs", &other).await;
    assert_eq!(status, 503, "{said}");
    let (status, said) = run.try_command("stop").await;
    assert_eq!(status, 503, "{said}");
    // Looking, and stopping the arm, need no journal.
    let _seen = run.job().await;
    let (status, said) = run.cell.post("/robots/r1/stop", &json!({})).await;
    assert!(status.is_success(), "{status} {said}");
    run.nothing_moves().await;
    assert_eq!(run.cell.begun().await, begun, "nothing began");
    run.cell.disk.is_sound();
    let job = run.until("HELD").await;
    assert!(run.has("F24").await, "{job}");
    run.nothing_moves().await;
    assert_eq!(run.cell.begun().await, begun, "a person has to say so");
    run.assert_at_hand().await;
    run.command("unhold").await;
    run.complete_with_a_person().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn f24_a_journal_that_cannot_be_written_begins_nothing_and_holds_a() {
    not_writable(Which::Delivery).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn f24_a_journal_that_cannot_be_written_begins_nothing_and_holds_b() {
    not_writable(Which::Pickup).await;
}

/// The disk is full in the middle of a job: the store's own limit. Nothing begins any more, and nothing is lost: with room
/// and a new start the job goes on where it was.
///
/// Covers: F24, D1.
#[tokio::test(flavor = "multi_thread")]
async fn f24_d1_a_full_disk_in_the_middle_of_a_job_begins_nothing() {
    let mut cell = TestCell::with_pages(120).await;
    let job = cell.delivery("rack/d").await;
    cell.wait("the arm works", A_JOB, async |cell| {
        (cell.begun().await > 1).then_some(())
    })
    .await;
    // It fills up: a person says again and again where a load is.
    let turn = AtomicUsize::new(0);
    let (status, said) = cell
        .wait("the disk is full", A_JOB, async |cell| {
            let even = turn.fetch_add(1, Ordering::Relaxed).is_multiple_of(2);
            let place = if even { "rack/f" } else { "rack/b" };
            let (status, said) = says_where(cell, place).await;
            (!status.is_success()).then_some((status, said))
        })
        .await;
    assert!(matches!(status.as_u16(), 503 | 507), "{status} {said}");
    cell.wait("the arm stands", A_JOB, async |cell| {
        let state = cell.controller().state().await.unwrap();
        (!state.moving && state.motion_queue == 0).then_some(())
    })
    .await;
    let begun = cell.begun().await;
    cell.after(std::time::Duration::from_millis(500)).await;
    assert_eq!(cell.begun().await, begun, "nothing began on a full disk");
    let (ready, said) = cell.try_get("/readyz").await;
    assert_eq!(ready, 503, "{said}");
    let (status, said) = cell.post("/robots/r1/stop", &json!({})).await;
    assert!(status.is_success(), "{status} {said}");
    cell.disk.limit(None);
    cell.crash().await;
    let (ended, said) = cell.see_through(&job).await;
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}\n{said:#?}");
    let (status, said) = says_where(&cell, "rack/b").await;
    assert!(status.is_success(), "{status} {said}");
    cell.assert_sound().await;
}

async fn says_where(cell: &TestCell, place: &str) -> (StatusCode, Value) {
    let location = json!({"at": "FIXED", "place": place});
    let body = json!({"location": location, "confirm": "load-3", "reason": "x".repeat(200)});
    cell.put("/loads/load-3/custody", &body).await
}

/// The power goes when the last step is done and the end of the job is not kept, or when it is kept and nobody heard of
/// it: after the next start it is over, once.
///
/// Covers: P12.
#[tokio::test(flavor = "multi_thread")]
async fn p12_a_crash_at_the_end_of_a_job_ends_it_once() {
    for kept in [false, true] {
        let mut cell = TestCell::start().await;
        if kept {
            cell.disk.stalls_after(ENDS);
        } else {
            cell.disk.stalls_before(ENDS);
        }
        let job = cell.delivery("rack/d").await;
        cell.wait("the end of the job", A_JOB, async |cell| {
            (cell.disk.struck() > 0).then_some(())
        })
        .await;
        let begun = cell.begun().await;
        cell.disk.is_sound();
        cell.crash().await;
        let (ended, said) = cell.see_through(&job).await;
        assert_eq!(ended["state"], "COMPLETE", "{ended:#}");
        assert!(said.is_empty(), "{said:#?}");
        assert_eq!(cell.begun().await, begun, "nothing of it is done again");
        let ends = cell.story(&job).await;
        let ends = ends.iter().filter(|event| says_complete(event));
        assert_eq!(ends.count(), 1, "it ended once");
        cell.assert_sound().await;
    }
}

const ENDS: &str = "\"to\":\"COMPLETE\"";

fn says_complete(event: &Value) -> bool {
    let text = event["text"].as_str().unwrap_or_default();
    event["kind"] == "job_moved"
        && text.to_uppercase().contains("COMPLETE")
        && !text.to_uppercase().contains("COMPLETING")
}

/// The power goes between a person's answer and what follows from it, or before it is kept: applied once, or asked again.
///
/// Covers: P14.
#[tokio::test(flavor = "multi_thread")]
async fn p14_an_answer_is_applied_once_over_a_crash() {
    for kept in [false, true] {
        let mut run = Run::start(Which::Delivery).await;
        run.power_cycle_in_motion("PLACE_APPROACH").await;
        let question = run.asked_for("F8", "replan").await;
        run.until_ready().await;
        let begun = run.cell.begun().await;
        if kept {
            run.cell.disk.stalls_after("\"fact\":\"answered\"");
        } else {
            run.cell.disk.stalls_before("\"fact\":\"answered\"");
        }
        let body = json!({"answer": "replan", "reason": "it stands free"});
        let path = format!("/interventions/{}/respond", question.id());
        let answered = run.cell.post(&path, &body);
        let stalled = run.cell.wait("the answer stalls", A_JOB, async |cell| {
            (cell.disk.struck() > 0).then_some(())
        });
        tokio::select! {
            (status, said) = answered => panic!("answered without being kept: {status} {said}"),
            () = stalled => {}
        }
        assert_eq!(run.cell.begun().await, begun, "nothing followed yet");
        run.cell.disk.is_sound();
        run.cell.crash().await;
        if !kept {
            let again = run.asked_for("F8", "replan").await;
            assert_eq!(again.id(), question.id(), "the same question");
            assert_eq!(run.cell.begun().await, begun);
            run.until_ready().await;
            run.answer(&again, "replan").await;
        }
        run.complete_with_a_person().await;
        let now = run.question_now(&question).await;
        assert_eq!(now["state"], "answered", "{now}");
    }
}

/// Somebody edits the journal of a job that is under way, by a byte: the server does not start on it, and nothing moves.
///
/// Covers: X17, D4.
#[tokio::test(flavor = "multi_thread")]
async fn x17_d4_an_edited_journal_starts_nothing() {
    let mut cell = TestCell::start().await;
    let job = cell.delivery("rack/d").await;
    cell.wait("the arm works", A_JOB, async |cell| {
        (cell.begun().await > 0).then_some(())
    })
    .await;
    cell.pull_the_plug();
    let sound = cell.disk.open(cell.journal()).await;
    drop(sound);
    edit(cell.journal(), job.as_bytes());
    let error = cell.refused_journal().await;
    assert!(
        error.contains("Broken") || error.contains("damaged"),
        "{error}"
    );
    cell.wait("the arm stands", A_JOB, async |cell| {
        let state = cell.controller().state().await.unwrap();
        (!state.moving).then_some(())
    })
    .await;
    let begun = cell.begun().await;
    assert!(cell.refused_journal().await.contains("Broken"));
    assert_eq!(cell.begun().await, begun, "nothing moves");
    cell.assert_nothing_twice().await;
}

/// Changes one character of each record that names a job.
fn edit(path: &std::path::Path, needle: &[u8]) {
    let mut file = std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .open(path)
        .unwrap();
    let mut bytes = Vec::new();
    let _count = file.read_to_end(&mut bytes).unwrap();
    let places: Vec<_> = bytes
        .windows(needle.len())
        .enumerate()
        .filter(|(_, window)| *window == needle)
        .map(|(at, _)| at)
        .collect();
    assert!(!places.is_empty(), "the journal names the job");
    for at in places {
        let _at = file.seek(SeekFrom::Start(at as u64)).unwrap();
        let other = if bytes[at] == b'0' { b"1" } else { b"0" };
        file.write_all(other).unwrap();
    }
}

/// A journal of a newer version in the middle of a job: what it decided is not understood, so nothing is guessed and
/// nothing moves. The version that wrote it goes on with it.
///
/// Covers: P15.
#[tokio::test(flavor = "multi_thread")]
async fn p15_decisions_of_a_newer_version_are_not_guessed() {
    let mut cell = TestCell::start().await;
    let _job = cell.delivery("rack/d").await;
    cell.wait("the arm works", A_JOB, async |cell| {
        (cell.begun().await > 0).then_some(())
    })
    .await;
    cell.pull_the_plug();
    cell.disk
        .decide(
            cell.journal(),
            "[{\"fact\":\"thought_of_later\",\"job\":1}]",
        )
        .await;
    let error = cell.refused_server().await;
    assert!(error.contains("not understood"), "{error}");
    cell.wait("the arm stands", A_JOB, async |cell| {
        let state = cell.controller().state().await.unwrap();
        (!state.moving).then_some(())
    })
    .await;
    let begun = cell.begun().await;
    let _error = cell.refused_server().await;
    assert_eq!(cell.begun().await, begun, "nothing moves");
    let events = cell.ledger().await;
    assert!(
        events
            .iter()
            .any(|entry| entry.event == LedgerEvent::Started)
    );
}
