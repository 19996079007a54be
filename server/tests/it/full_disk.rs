//! D1 in the running server: on a full disk what runs gets its end, and nothing begins.

use std::time::Duration;

use journal::{Filesystem, KeyRetention, MemoryDisk, Opening, SqliteJournal, SqliteOptions};
use serde_json::json;
use server::SharedJournal;

use crate::kept_motions::{answer, motions, serve};
use crate::legacy_moves::POINT;
use crate::support::{
    ACCEPTED, Act, FakeRobot, HttpReply, MOTION, MOTIONS, TestServer, robot_section, until,
};

const STOP: &str = "/api/v1/cells/c1/robots/r1/stop";
const CONTROL: &str = "/api/v1/cells/c1/control-authority";

fn no_room(reply: &HttpReply, limit: &str) {
    let problem = reply.problem(507, "journal-full", "NOT_SENT");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains(limit), "{detail}");
}

/// D1: a doubt from before is decided, the decision survives a restart, and with room again everything goes on.
#[tokio::test]
async fn d1_on_the_reserve_a_doubt_is_decided_and_nothing_begins() {
    let robot = FakeRobot::start([Act::CloseAfter(""), Act::Reply(ACCEPTED)]).await;
    let disk = MemoryDisk::new();
    let server = serve(&robot, &disk).await;
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 504);
    disk.fill();
    let id = motions(&server).await[0]["id"].clone();
    let _answered = answer(&server, &id, "happened").await;
    no_room(&server.post(MOTIONS, MOTION).await, "16 MiB");
    no_room(&server.post("/fanuc/move", POINT).await, "16 MiB");
    assert_eq!(server.bare("POST", STOP, &[], "").await.status, 200);
    let ready = server.get("/readyz").await;
    let journal = &ready.json()["journal"];
    assert_eq!(
        (ready.status, &journal["writable"], &journal["on_reserve"]),
        (503, &json!(true), &json!(true))
    );
    assert!(
        journal["problem"]
            .as_str()
            .unwrap()
            .contains("disk is full")
    );
    assert_eq!(robot.commands().len(), 1);

    disk.lose_power();
    let server = serve(&robot, &disk).await;
    let states: Vec<_> = motions(&server)
        .await
        .iter()
        .map(|motion| motion["state"].clone())
        .collect();
    assert_eq!(states, ["succeeded"]);
    no_room(&server.post(MOTIONS, MOTION).await, "16 MiB");
    disk.make_room();
    assert_eq!(server.get("/readyz").await.status, 200);
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
}

/// D1 with a limit of the file's pages: the motions up to it are all kept, and then what people need still works.
#[tokio::test]
async fn d1_a_file_that_may_not_grow_refuses_motions_and_keeps_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let opening = Opening {
        at: journal::Clocks {
            wall: jiff::Timestamp::now(),
            monotonic: Duration::ZERO,
        },
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: Filesystem::Trusted,
        max_pages: Some(120),
        reserve: 256 << 10,
        ..SqliteOptions::default()
    };
    let path = folder.path().join("cell.journal");
    let journal = SqliteJournal::open(&path, &opening, &options)
        .await
        .unwrap();
    let robot = FakeRobot::accepting().await;
    let section = robot_section(robot.address);
    let server = TestServer::with_journal(section, SharedJournal::durable(journal)).await;
    let mut accepted = 0;
    let refused = loop {
        let reply = server.post(MOTIONS, MOTION).await;
        if reply.status != 202 {
            break reply;
        }
        accepted += 1;
    };
    no_room(&refused, "256 KiB");
    assert!(accepted > 10, "{accepted}");
    // The acceptance may be what found no room: it is kept, and with it every motion the robot has.
    assert_eq!(robot.commands().len(), accepted);
    assert_eq!(server.bare("POST", STOP, &[], "").await.status, 200);
    let lease = server.control().await.split('.').next().unwrap().to_owned();
    let lease = format!("{CONTROL}/{lease}");
    assert_eq!(server.bare("PUT", &lease, &[], "").await.status, 200);
    assert_eq!(server.bare("DELETE", &lease, &[], "").await.status, 200);
    until("the record of it is kept, in the reserve", async || {
        let audit = server.get("/api/v1/cells/c1/audit?limit=1").await.json();
        audit["entries"][0]["action"] == "control.release"
    })
    .await;
    assert_eq!(
        server.get("/readyz").await.json()["journal"]["on_reserve"],
        true
    );
}
