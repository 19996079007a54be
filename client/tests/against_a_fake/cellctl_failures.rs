//! What `cellctl` says, and how it ends, when something goes wrong.

use api::{Outcome, ProblemCode, Violation};
use serde_json::json;
use tokio::net::TcpListener;

use crate::fake::{Answer, Fake, cellctl};
use crate::samples;

const MOVE: [&str; 7] = ["move", "600", "200", "600", "-180", "30", "0"];

#[tokio::test]
async fn a_refusal_tells_what_the_value_and_the_limits_are() {
    let mut problem = samples::problem(ProblemCode::JointLimitExceeded, Outcome::NotSent);
    problem.detail = "J5 would be at 143.2 degrees".to_owned();
    problem.violations = vec![Violation {
        item: "J5".to_owned(),
        message: "18.2 degrees beyond its limit".to_owned(),
        value: Some(143.2),
        min: Some(-125.0),
        max: Some(125.0),
    }];
    problem.hint = Some("turn the tool by 20 degrees".to_owned());
    let fake = Fake::always(Answer::Problem(Box::new(problem.clone()))).await;

    let ran = fake.cellctl(&MOVE).await;
    assert_eq!(ran.code, 1);
    assert_eq!(ran.stdout, "");
    assert_eq!(
        ran.stderr,
        "cellctl: A joint limit is exceeded: J5 would be at 143.2 degrees\n  \
         J5 = 143.2 (limits -125 to 125): 18.2 degrees beyond its limit\n\
         Hint: turn the tool by 20 degrees\nRequest q1\n"
    );

    let ran = fake.cellctl(&[&["--json"], &MOVE[..]].concat()).await;
    assert_eq!(ran.code, 1);
    assert_eq!(ran.json(), serde_json::to_value(problem).unwrap());
}

#[tokio::test]
async fn the_controllers_no_is_a_refusal_in_its_own_words() {
    let mut problem = samples::problem(ProblemCode::ControllerRejected, Outcome::Rejected);
    problem.controller_text = Some("ERROR: POINT \u{1b}[31mUNREACHABLE".to_owned());
    let fake = Fake::always(Answer::Problem(Box::new(problem))).await;
    let ran = fake.cellctl(&MOVE).await;
    assert_eq!(ran.code, 1);
    assert!(
        ran.stderr
            .contains("The controller said: ERROR: POINT  [31mUNREACHABLE"),
        "{ran:?}"
    );
}

#[tokio::test]
async fn an_unknown_outcome_is_told_plainly() {
    let refuse = samples::refuse(ProblemCode::ControllerTimeout, Outcome::Unknown);
    let fake = Fake::always(refuse).await;
    let ran = fake.cellctl(&MOVE).await;
    assert_eq!(ran.code, 3);
    assert!(
        ran.stderr.contains("UNKNOWN: the robot may have moved"),
        "{ran:?}"
    );
}

#[tokio::test]
async fn no_4xx_with_an_unknown_outcome_counts_as_a_refusal() {
    let fake = Fake::always(samples::refuse(
        ProblemCode::RequestTimeout,
        Outcome::Unknown,
    ))
    .await;
    assert_eq!(fake.cellctl(&MOVE).await.code, 3);
}

#[tokio::test]
async fn a_link_that_is_down_is_no_refusal() {
    for code in [
        ProblemCode::ControllerDisconnected,
        ProblemCode::ControllerBusy,
    ] {
        let fake = Fake::always(samples::refuse(code, Outcome::NotSent)).await;
        let ran = fake.cellctl(&MOVE).await;
        assert_eq!(ran.code, 3);
        assert!(!ran.stderr.contains("UNKNOWN"), "{ran:?}");
    }
}

#[tokio::test]
async fn a_motion_recorded_as_in_doubt_or_rejected_is_no_success() {
    for (state, code) in [("in_doubt", 3), ("rejected", 1), ("not_executed", 1)] {
        let fake = Fake::always(Answer::Json(samples::motion(state))).await;
        assert_eq!(fake.cellctl(&MOVE).await.code, code, "{state}");
    }
}

#[tokio::test]
async fn a_server_that_is_not_there_is_named() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    drop(listener);
    let ran = cellctl(&["--server", &url, "cells"]).await;
    assert_eq!(ran.code, 3);
    assert!(
        ran.stderr
            .starts_with(&format!("cellctl: {url}/api/v1/cells cannot be reached: ")),
        "{ran:?}"
    );

    let ran = cellctl(&["--json", "--server", &url, "cells"]).await;
    assert_eq!(ran.code, 3);
    assert_eq!(ran.json()["outcome"], json!("NOT_SENT"));
}

#[tokio::test]
async fn a_command_without_an_answer_may_have_been_carried_out() {
    let fake = Fake::always(Answer::Silence).await;
    let ran = fake
        .cellctl(&[&["--timeout-ms", "300"], &MOVE[..]].concat())
        .await;
    assert_eq!(ran.code, 3);
    assert!(
        ran.stderr.contains("did not answer within 300 ms"),
        "{ran:?}"
    );
    assert!(ran.stderr.contains("the robot may have moved"), "{ran:?}");

    let ran = fake.cellctl(&["--timeout-ms", "300", "state"]).await;
    assert_eq!(ran.code, 3);
    assert!(!ran.stderr.contains("may have moved"), "{ran:?}");
}

#[tokio::test]
async fn an_answer_of_something_else_is_shown_and_not_believed() {
    let fake = Fake::always(Answer::Raw {
        status: 200,
        media_type: "text/html",
        body: "<html>Welcome to another server".to_owned(),
    })
    .await;
    let ran = fake.cellctl(&MOVE).await;
    assert_eq!(ran.code, 3);
    assert!(
        ran.stderr.contains("<html>Welcome to another server"),
        "{ran:?}"
    );
    assert!(ran.stderr.contains("UNKNOWN"), "{ran:?}");
}

#[tokio::test]
async fn a_delta_needs_a_place_to_count_from() {
    let fake = Fake::always(Answer::Json(samples::state(None))).await;
    let ran = fake.cellctl(&["delta", "0", "0", "1", "0", "0", "0"]).await;
    assert_eq!(ran.code, 1);
    assert!(
        ran.stderr.contains("Hint: move to an absolute pose"),
        "{ran:?}"
    );
    assert_eq!(fake.lines().len(), 1, "only the state was asked for");
}
