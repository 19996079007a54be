//! The typed client against a fake server.

use std::time::Duration;

use api::{LegacyDelta, LegacyPoint, MotionBody, MotionType, Outcome, ProblemCode};
use client::{Client, ClientError, EmulatorClient, LedgerEvent, MAX_ANSWER_BYTES, Page, Timeouts};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;

use crate::fake::{Answer, Fake};
use crate::samples;

fn home() -> MotionBody {
    MotionBody {
        speed_mm_s: Some(100.0),
        ..MotionBody::new(MotionType::Home)
    }
}

const POINT: LegacyPoint = LegacyPoint {
    x: 985.0,
    y: 0.0,
    z: 940.0,
    w: -180.0,
    p: 0.0,
    r: 0.0,
};

#[tokio::test]
async fn every_route_has_its_path() {
    let fake = Fake::start(|seen| {
        let text = |body: &str| Answer::Raw {
            status: 200,
            media_type: "text/plain",
            body: body.to_owned(),
        };
        let point = json!({"current_position":
            {"x": 985.0, "y": 0.0, "z": 940.0, "w": -180.0, "p": 0.0, "r": 0.0}});
        match seen.line.as_str() {
            "GET /livez" => Answer::Json(json!({"alive": true})),
            "GET /readyz" => Answer::Raw {
                status: 503,
                media_type: "application/json",
                body: r#"{"ready": false, "links": [], "journal":
                    {"writable": false, "durable": true, "epoch": 1, "last_record": 7}}"#
                    .to_owned(),
            },
            "GET /metrics" => text("cell_motions_total 1\n"),
            "GET /version" => Answer::Json(json!({"version": ["0.1.0"]})),
            "GET /api/v1/cells/demo" => Answer::Json(samples::cells(&["r1"])[0].clone()),
            "GET /api/v1/cells/demo/robots" => {
                Answer::Json(samples::cells(&["r1"])[0]["robots"].clone())
            }
            line if line.starts_with("POST /fanuc/") => Answer::Json(point),
            _ => Answer::Json(json!({"motions": []})),
        }
    })
    .await;
    let client = Client::new(&fake.url()).unwrap();
    assert!(client.livez().await.unwrap().alive);
    assert!(!client.readyz().await.unwrap().ready);
    assert_eq!(client.metrics().await.unwrap(), "cell_motions_total 1\n");
    assert_eq!(client.version().await.unwrap().version, ["0.1.0"]);
    assert_eq!(client.cell("demo").await.unwrap().id, "demo");
    assert_eq!(client.robots("demo").await.unwrap().len(), 1);
    let moved = client.legacy_move(&POINT, Some(250)).await.unwrap();
    assert_eq!(moved.current_position, POINT);
    let _ = client.legacy_home(None).await.unwrap();
    let delta = LegacyDelta {
        dx: 1.0,
        dy: 0.0,
        dz: 0.0,
        dw: 0.0,
        dp: 0.0,
        dr: 0.0,
    };
    let _ = client.legacy_delta(&delta, None).await.unwrap();
    let page = Page {
        limit: Some(2),
        cursor: Some("a&b".to_owned()),
    };
    let robot = client.robot("demo", "r1");
    assert_eq!(robot.motions(&page).await.unwrap().motions, []);
    assert_eq!(
        fake.lines()[6..],
        [
            "POST /fanuc/move?velocity=250",
            "POST /fanuc/home",
            "POST /fanuc/delta",
            "GET /api/v1/cells/demo/robots/r1/motions?limit=2&cursor=a%26b",
        ]
    );
}

#[tokio::test]
async fn each_request_has_an_id_of_its_own_unless_one_is_given() {
    let fake = Fake::always(Answer::Json(json!([]))).await;
    let client = Client::new(&fake.url()).unwrap();
    for client in [
        client.clone(),
        client.clone(),
        client.with_request_id("mine").unwrap(),
    ] {
        assert_eq!(client.cells().await.unwrap(), []);
    }
    let ids: Vec<String> = fake
        .seen()
        .into_iter()
        .filter_map(|seen| seen.request_id)
        .collect();
    assert_eq!(ids.len(), 3);
    assert_ne!(ids[0], ids[1]);
    assert_eq!(ids[2], "mine");
}

#[tokio::test]
async fn the_answer_to_another_request_is_not_believed() {
    let fake = Fake::always(Answer::OfAnother("not-mine")).await;
    let error = Client::new(&fake.url()).unwrap().cells().await.unwrap_err();
    assert!(
        error.to_string().contains("the id of another request"),
        "{error}"
    );
}

#[test]
fn only_ids_the_server_takes_are_sent() {
    let client = Client::new("http://127.0.0.1:1").unwrap();
    for id in ["", "a b", "a\nb", "\u{e9}", &"a".repeat(65)] {
        assert!(client.with_request_id(id).is_err(), "{id}");
    }
}

#[tokio::test]
async fn a_problem_arrives_whole() {
    let problem = samples::problem(ProblemCode::OutOfWorkspace, Outcome::NotSent);
    let fake = Fake::always(Answer::Problem(Box::new(problem.clone()))).await;
    let robot = Client::new(&fake.url()).unwrap().robot("demo", "r1");
    let error = robot.create_motion(&home()).await.unwrap_err();
    assert_eq!(error.problem(), Some(&problem));
    assert_eq!(error.outcome(), Outcome::NotSent);
    assert_eq!(error.request_id(), Some("q1"));
}

#[tokio::test]
async fn the_seeds_refusals_are_understood() {
    for (status, body, outcome) in [
        (
            409,
            r#"{"detail": "ERROR: POINT UNREACHABLE"}"#,
            Outcome::Rejected,
        ),
        (
            503,
            r#"{"detail": "ERROR: no connection"}"#,
            Outcome::NotSent,
        ),
        (504, r#"{"detail": "ERROR: no answer"}"#, Outcome::Unknown),
        (
            422,
            r#"{"detail": [{"loc": ["body", "x"], "msg": "missing", "type": "missing"}]}"#,
            Outcome::NotSent,
        ),
    ] {
        let fake = Fake::always(Answer::Raw {
            status,
            media_type: "application/json",
            body: body.to_owned(),
        })
        .await;
        let client = Client::new(&fake.url()).unwrap();
        let error = client.legacy_move(&POINT, None).await.unwrap_err();
        assert_eq!(error.status(), Some(status));
        assert_eq!(error.outcome(), outcome);
        assert!(!matches!(error, ClientError::Protocol { .. }), "{error}");
    }
}

#[tokio::test]
async fn a_timeout_is_a_doubt_only_after_a_command() {
    let fake = Fake::always(Answer::Silence).await;
    let timeouts = Timeouts {
        command: Duration::from_millis(100),
        question: Duration::from_millis(100),
        ..Timeouts::default()
    };
    let client = Client::with_timeouts(&fake.url(), timeouts).unwrap();
    let robot = client.robot("demo", "r1");
    let command = robot.create_motion(&home()).await.unwrap_err();
    assert!(matches!(command, ClientError::Timeout { .. }), "{command}");
    assert_eq!(command.outcome(), Outcome::Unknown);
    assert_eq!(robot.state().await.unwrap_err().outcome(), Outcome::None);
    // A simulation takes as long as a command may, and moves nothing.
    let body: api::JobBody = serde_json::from_value(serde_json::json!({
        "workflow": "delivery-and-placement",
        "params": {"point": "handover/front", "items": []},
    }))
    .unwrap();
    let simulated = client.jobs("demo").simulate(&body).await.unwrap_err();
    assert!(
        matches!(simulated, ClientError::Timeout { .. }),
        "{simulated}"
    );
    assert_eq!(simulated.outcome(), Outcome::None);
}

#[tokio::test]
async fn a_connection_cut_before_the_answer_is_a_doubt_and_nothing_is_sent_twice() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    let connections = tokio::spawn(async move {
        let mut requests = 0;
        while let Ok((mut socket, _)) = listener.accept().await {
            let mut bytes = [0; 4096];
            if socket.read(&mut bytes).await.unwrap() == 0 {
                continue;
            }
            if bytes.starts_with(b"GET /livez") {
                socket
                    .write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 15\r\nconnection: close\r\n\r\n{\"alive\": true}")
                    .await
                    .unwrap();
                break;
            }
            requests += 1;
        }
        requests
    });
    let client = Client::new(&url).unwrap();
    let error = client
        .robot("demo", "r1")
        .create_motion(&home())
        .await
        .unwrap_err();
    assert!(
        matches!(error, ClientError::Interrupted { .. }),
        "{error:?}"
    );
    assert_eq!(error.outcome(), Outcome::Unknown);
    assert!(client.livez().await.unwrap().alive);
    assert_eq!(connections.await.unwrap(), 1);
}

#[tokio::test]
async fn an_answer_without_end_is_not_read_to_the_end() {
    let fake = Fake::always(Answer::Raw {
        status: 200,
        media_type: "text/plain",
        body: "x".repeat(MAX_ANSWER_BYTES + 1),
    })
    .await;
    let error = Client::new(&fake.url())
        .unwrap()
        .metrics()
        .await
        .unwrap_err();
    let ClientError::Protocol {
        excerpt, reason, ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!(excerpt.len(), 200);
    assert!(reason.contains("1048576 bytes"), "{reason}");
}

#[tokio::test]
async fn a_redirect_is_not_followed() {
    let fake = Fake::always(Answer::Raw {
        status: 307,
        media_type: "text/plain",
        body: "elsewhere".to_owned(),
    })
    .await;
    let robot = Client::new(&fake.url()).unwrap().robot("demo", "r1");
    let error = robot.create_motion(&home()).await.unwrap_err();
    assert_eq!(error.status(), Some(307));
    assert_eq!(fake.lines().len(), 1);
}

#[tokio::test]
async fn the_panel_of_a_virtual_controller_is_read() {
    let fake = Fake::start(|seen| {
        Answer::Json(match seen.line.as_str() {
            "GET /state" => samples::emulator_state(false),
            "GET /alarms" => samples::alarms(),
            _ => samples::ledger(),
        })
    })
    .await;
    let emulator = EmulatorClient::new(&fake.url()).unwrap();
    assert!(emulator.state().await.unwrap().is_still());
    assert_eq!(emulator.alarms().await.unwrap().entries[0].number, 17);
    let ledger = emulator.ledger(Some(0)).await.unwrap();
    let events: Vec<LedgerEvent> = ledger.entries.iter().map(|entry| entry.event).collect();
    assert_eq!(events, [LedgerEvent::Started, LedgerEvent::Finished]);
    assert!(fake.lines().contains(&"GET /ledger?after=0".to_owned()));
}

/// What `karel-emulator` writes; an unknown word would make the whole ledger unreadable.
#[test]
fn every_event_of_a_virtual_controllers_ledger_is_known() {
    for word in [
        "started",
        "finished",
        "passed",
        "refused",
        "cancelled",
        "held",
        "resumed",
        "gripped",
        "released",
        "lost",
        "jogged",
    ] {
        let event: Result<LedgerEvent, _> = serde_json::from_value(serde_json::json!(word));
        assert_eq!(serde_json::to_value(event.unwrap()).unwrap(), word);
    }
}

#[tokio::test]
async fn a_problem_of_a_newer_server_is_still_told() {
    let body = r#"{"title": "New", "status": 409, "detail": "a new kind of no", "code": "new", "outcome": "NOT_SENT"}"#;
    let fake = Fake::always(Answer::Raw {
        status: 409,
        media_type: "application/problem+json",
        body: body.to_owned(),
    })
    .await;
    let robot = Client::new(&fake.url()).unwrap().robot("demo", "r1");
    let error = robot.create_motion(&home()).await.unwrap_err();
    assert_eq!(error.to_string(), "a new kind of no");
    assert_eq!(error.outcome(), Outcome::NotSent);
}
