//! A mobile robot's side of the library.

use api::{
    FloorPoseBody, MobileMessage, OperatingMode, OutboxQuery, ProblemCode, SignalBody, SignalData,
    SignalName,
};
use client::Client;
use serde_json::json;
use uuid::Uuid;

use crate::fake::{Answer, Fake};

fn signal() -> SignalBody {
    SignalBody {
        session: Some(Uuid::from_u128(1)),
        seq: 3,
        resync: false,
        boot: 1,
        signal: SignalName::MrDocked,
        at: jiff::Timestamp::UNIX_EPOCH,
        data: SignalData {
            pose: FloorPoseBody::default(),
            driving: false,
            localized: true,
            battery_percent: 90.0,
            mode: OperatingMode::Automatic,
            loads: Some(Vec::new()),
            order: None,
            at_point: Some("s1/p1".to_owned()),
            errors: Vec::new(),
        },
    }
}

#[tokio::test]
async fn a_signal_is_posted_as_it_is_and_parked_is_an_answer() {
    let fake = Fake::start(|_| Answer::Raw {
        status: 202,
        media_type: "application/json",
        body: json!({"accepted": true, "duplicate": false, "parked": true}).to_string(),
    })
    .await;
    let robot = Client::new(&fake.url())
        .unwrap()
        .mobile_robot("demo", "mr1");
    let answer = robot.post_signal(&signal()).await.unwrap();
    assert!(answer.accepted && answer.parked && !answer.duplicate);
    assert_eq!(
        fake.lines(),
        ["POST /api/v1/cells/demo/mobile-robots/mr1/signals"]
    );
    let sent = fake.seen()[0].body.clone();
    assert_eq!(sent, serde_json::to_value(signal()).unwrap());
}

#[tokio::test]
async fn a_refused_signal_is_a_problem_with_its_code() {
    let fake = Fake::always(Answer::Raw {
        status: 410,
        media_type: "application/problem+json",
        body: json!({
            "type": "/problems/session-closed", "title": "closed", "status": 410, "detail": "over",
            "code": "session-closed", "outcome": "NONE", "retryable": false
        })
        .to_string(),
    })
    .await;
    let robot = Client::new(&fake.url())
        .unwrap()
        .mobile_robot("demo", "mr1");
    let error = robot.post_signal(&signal()).await.unwrap_err();
    assert_eq!(error.problem().unwrap().code, ProblemCode::SessionClosed);
}

#[tokio::test]
async fn the_outbox_is_asked_for_what_is_after_and_its_messages_are_read() {
    let fake = Fake::always(Answer::Json(json!({
        "messages": [{"n": 8, "at": "2026-01-01T00:00:00Z", "session": null, "kind": "MOVE_PERMIT", "granted": true}],
        "next": 8
    })))
    .await;
    let robot = Client::new(&fake.url())
        .unwrap()
        .mobile_robot("demo", "mr1");
    let query = OutboxQuery {
        after: 7,
        wait_s: 30,
    };
    let outbox = robot.outbox(query).await.unwrap();
    assert_eq!(outbox.next, 8);
    let granted = MobileMessage::MovePermit { granted: true };
    assert_eq!(outbox.messages[0].message, granted);
    assert_eq!(
        fake.lines(),
        ["GET /api/v1/cells/demo/mobile-robots/mr1/outbox?after=7&wait_s=30"]
    );
}

#[tokio::test]
async fn mobile_robots_are_listed_and_looked_at() {
    let fake = Fake::start(|seen| {
        Answer::Json(if seen.line.ends_with("/state") {
            json!({"id": "mr1", "cell": "demo", "connected": true, "move_permit": false, "unacknowledged": 2})
        } else {
            json!([{"id": "mr1", "connected": true, "mode": "AUTOMATIC"}])
        })
    })
    .await;
    let client = Client::new(&fake.url()).unwrap();
    let list = client.mobile_robots("demo").await.unwrap();
    assert_eq!(list[0].mode, Some(OperatingMode::Automatic));
    let state = client.mobile_robot("demo", "mr1").state().await.unwrap();
    assert_eq!(state.unacknowledged, 2);
    assert_eq!(
        fake.lines(),
        [
            "GET /api/v1/cells/demo/mobile-robots",
            "GET /api/v1/cells/demo/mobile-robots/mr1/state"
        ]
    );
}
