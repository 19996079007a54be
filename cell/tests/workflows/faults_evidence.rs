//! What somebody says and what is true: a mobile robot about where it is, a person about what happened, a page that sends
//! everything twice.

use cell::world::PartAt;
use karel_emulator::LedgerEvent;
use mobile_emulator::Fault;
use serde_json::{Value, json};

use crate::kit::{A_JOB, TestCell};
use crate::run::{Run, Which};

/// It says that it has docked, and that it stands somewhere else: the arm does not enter.
async fn says_docked_elsewhere(which: Which) {
    let lie = Fault::Lie {
        x_mm: 60.0,
        y_mm: 0.0,
        heading_deg: 0.0,
        for_s: None,
    };
    let run = Run::with(which, &[lie], Value::Null).await;
    let question = run.asked("F3").await;
    assert!(!question.answers().contains(&"happened"));
    let _job = run.until("SUSPENDED").await;
    run.nothing_moves().await;
    if which == Which::Delivery {
        run.assert_never_entered().await;
    }
    run.assert_at(&which.source()).await;
    run.assert_no_arm_permit().await;
    run.assert_orderly().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn m5_an_arrival_at_another_place_lets_no_arm_in_a() {
    says_docked_elsewhere(Which::Delivery).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn m5_an_arrival_at_another_place_lets_no_arm_in_b() {
    says_docked_elsewhere(Which::Pickup).await;
}

/// It docked, and does not know any more where it is before the arm enters.
#[tokio::test(flavor = "multi_thread")]
async fn m5_a_mobile_robot_that_is_lost_lets_no_arm_in() {
    let run = Run::start(Which::Pickup).await;
    // It has docked, and the arm fetches the load.
    run.hold_in_motion("LIFT_CLEAR").await;
    run.fault(Fault::Unlocalized { for_s: None }).await;
    run.until_has("F13").await;
    run.operate(karel_emulator::Operation::CycleStart).await;
    run.until_no_permits().await;
    let _job = run.until("SUSPENDED").await;
    run.until_arm_stands().await;
    run.nothing_moves().await;
    run.assert_never_entered().await;
    run.assert_at(&PartAt::Gripper("vc1".to_owned())).await;
    run.cell.assert_nothing_twice().await;
}

/// It slid in its dock and did not notice: everything it says is right, and it stands elsewhere. No report can show that.
/// The gripper finds nothing, and that is what it is taken for: the arm goes out, and a person is asked.
#[tokio::test(flavor = "multi_thread")]
async fn m5_a_lie_that_nothing_shows_ends_at_an_empty_gripper() {
    let slip = Fault::Slip {
        forward_mm: 60.0,
        left_mm: 0.0,
        turn_deg: 0.0,
        when: mobile_emulator::SlipMoment::Docking,
        noticed: false,
    };
    let run = Run::with(Which::Delivery, &[slip], Value::Null).await;
    let question = run.asked("F4").await;
    assert!(run.has("F9").await);
    let _job = run.until("HELD").await;
    run.until_out_of_zone().await;
    run.nothing_moves().await;
    run.assert_at(&Which::Delivery.source()).await;
    run.answer(&question, "send_back").await;
    let _job = run.until("STOPPED").await;
    run.assert_at(&Which::Delivery.source()).await;
    run.cell.assert_nothing_twice().await;
}

/// For a moment on its way it believes to be elsewhere, and trusts its pose as ever. Nobody drives that far in the time: it
/// docks anew before the arm comes near, and nobody has to be asked.
///
/// Covers: M5.
#[tokio::test(flavor = "multi_thread")]
async fn m5_a_pose_that_jumped_on_the_way_is_docked_for_anew() {
    let fast = ("max_speed_mm_s = 2000", "max_speed_mm_s = 60_000");
    let run = Run::with_setup(Which::Delivery, fast, &[], Value::Null).await;
    run.until_phase("AWAIT").await;
    run.fault(Fault::Lie {
        x_mm: 100_000.0,
        y_mm: 0.0,
        heading_deg: 0.0,
        for_s: None,
    })
    .await;
    run.cell
        .wait("the cell hears of it", A_JOB, async |cell| {
            let robot = cell.get("/mobile-robots/mr1").await;
            (robot["data"]["pose"]["x_mm"].as_f64()? > 90_000.0).then_some(())
        })
        .await;
    run.faults_end().await;
    run.complete().await;
    assert!(run.has("F3").await);
    run.assert_nobody_asked().await;
}

/// It leaves in the middle of the transfer: the arm stops, and what the job holds stays reserved until a person cleared it.
async fn leaves(which: Which) {
    let run = Run::start(which).await;
    run.until_in_zone().await;
    run.fault(Fault::DrivesOff { after_s: 0.0 }).await;
    let _job = run.until("ABORTED").await;
    run.until_no_permits().await;
    run.until_arm_stands().await;
    run.nothing_moves().await;
    // Another job has to wait for the point.
    let other = run.cell.delivery("rack/e").await;
    run.nothing_moves().await;
    let waiting = run.cell.get(&format!("/jobs/{other}")).await;
    assert_eq!(waiting["state"], "IDLE", "{waiting}");
    let claims = run.job().await["claims"].to_string();
    assert!(claims.contains("r1"), "its arm is nobody else's: {claims}");
    run.cell.assert_nothing_twice().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn m6_a_mobile_robot_that_leaves_stops_the_arm_and_keeps_the_point_a() {
    leaves(Which::Delivery).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn m6_a_mobile_robot_that_leaves_stops_the_arm_and_keeps_the_point_b() {
    leaves(Which::Pickup).await;
}

/// A double click: the page sends the same request twice at the same time, with the key of one action.
///
/// Covers: O1, H6.
#[tokio::test(flavor = "multi_thread")]
async fn o1_a_double_click_makes_one_job() {
    let cell = TestCell::start().await;
    let body = TestCell::pickup_body();
    let click = || cell.post_with_key("/jobs", "one-action", &body);
    let (one, two, three) = tokio::join!(click(), click(), click());
    let mut ids = Vec::new();
    for (status, job) in [one, two, three] {
        // While the first is under way the others may be told just that.
        if status == 409 {
            assert_eq!(job["code"], "idempotency-in-flight", "{job}");
            continue;
        }
        assert!(status.is_success(), "{status} {job}");
        ids.push(job["id"].clone());
    }
    ids.dedup();
    assert_eq!(ids.len(), 1, "{ids:?}");
    let jobs = cell.get("/jobs").await;
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 1, "{jobs}");
    // The same click on a command: stopped once, and said to be.
    let id = ids[0].as_str().unwrap();
    let path = format!("/jobs/{id}/commands");
    let stop = json!({"command": "stop", "reason": "twice"});
    let click = || cell.post_with_key(&path, "another-action", &stop);
    let (one, two) = tokio::join!(click(), click());
    assert!(one.0.is_success() || two.0.is_success(), "{one:?} {two:?}");
    let _stopped = cell.wait_for_job(id, &["STOPPED"]).await;
    let events = cell.story(id).await;
    let stops = events.iter().filter(|event| {
        event["kind"] == "job_moved"
            && event["text"]
                .as_str()
                .unwrap_or_default()
                .to_uppercase()
                .contains("STOPPING")
    });
    assert_eq!(stops.count(), 1, "{events:#?}");
    cell.assert_nothing_twice().await;
}

/// A doubt that only a person can settle: the evidence is shown, only what makes sense may be answered, only with a
/// reason, once, and what was answered is kept with its author.
///
/// Covers: O3.
#[tokio::test(flavor = "multi_thread")]
async fn o3_an_answer_to_a_doubt_is_limited_reasoned_and_kept() {
    let mut run = Run::start(Which::Delivery).await;
    run.power_cycle_in_motion("PLACE_APPROACH").await;
    let question = run.asked_for("F8", "replan").await;
    let begun = run.cell.begun().await;
    let known = question.0["known"].to_string();
    assert!(known.contains("load-1") && known.contains("r1"), "{known}");
    assert!(!question.0["unknown"].as_array().unwrap().is_empty());
    assert_eq!(
        question.answers(),
        ["happened", "did_not_happen", "replan", "abort"]
    );
    let path = format!("/interventions/{}/respond", question.id());
    for (body, statuses) in [
        (
            json!({"answer": "mark_delivered", "reason": "a guess"}),
            409..=422,
        ),
        (json!({"answer": "yes", "reason": "a guess"}), 400..=422),
        (json!({"answer": "replan"}), 400..=422),
        (json!({"answer": "replan", "reason": " "}), 400..=422),
    ] {
        let (status, said) = run.cell.post(&path, &body).await;
        assert!(
            statuses.contains(&status.as_u16()),
            "{body}: {status} {said}"
        );
    }
    assert_eq!(
        run.cell.begun().await,
        begun,
        "a wrong answer moves nothing"
    );
    assert_eq!(run.question_now(&question).await["state"], "open");
    run.until_ready().await;
    run.answer(&question, "replan").await;
    // Another opinion comes too late.
    let other = json!({"answer": "abort", "reason": "second thoughts"});
    let (status, said) = run.cell.post(&path, &other).await;
    assert_eq!(status, 409, "{said}");
    run.cell.crash().await;
    let kept = run.question_now(&question).await;
    assert_eq!(kept["state"], "answered", "{kept}");
    let text = kept.to_string();
    assert!(text.contains("replan") && text.contains("a test"), "{kept}");
    run.complete_with_a_person().await;
}

/// A person says that a motion arrived which did not: the next one is planned from where the arm is, the load is still
/// in the gripper, and custody is right at the end.
///
/// Covers: O3.
#[tokio::test(flavor = "multi_thread")]
async fn o3_a_wrong_answer_about_a_motion_moves_no_load_in_the_books() {
    let run = Run::start(Which::Delivery).await;
    run.power_cycle_in_motion("APPROACH").await;
    let question = run.asked_for("F8", "happened").await;
    run.until_ready().await;
    run.answer(&question, "happened").await;
    // It closes where nothing is, or goes on to the load: by its own inputs it knows which.
    run.complete_with_a_person().await;
    let ledger = run.cell.ledger().await;
    assert!(
        ledger
            .iter()
            .any(|entry| entry.event == LedgerEvent::Started)
    );
    run.cell
        .wait("custody is right", A_JOB, async |cell| {
            (cell.custody("load-1").await["location"]["place"] == "rack/d").then_some(())
        })
        .await;
}
