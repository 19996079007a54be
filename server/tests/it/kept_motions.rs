//! Motions over crashes, full disks and clocks that jump. A crash is the loss of the journal's power: the old server
//! can keep nothing any more, and the next one begins with what was durable.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use jiff::Timestamp;
use journal::{Fault, MemoryDisk};
use serde_json::{Value, json};
use server::config::{JournalSection, ServerSection};
use server::{Seams, SystemClock, TcpConnector, WallClock, open_journal};

use crate::legacy_moves::POINT;
use crate::support::{
    ACCEPTED, Act, FakeRobot, MOTION, MOTIONS, TestServer, opened, robot_section, wait_until,
};

const STOP: &str = "/api/v1/cells/c1/robots/r1/stop";
const INTERVENTIONS: &str = "/api/v1/cells/c1/interventions";

/// A server on what the disk has.
pub(crate) async fn serve(robot: &FakeRobot, disk: &MemoryDisk) -> TestServer {
    TestServer::with_journal(robot_section(robot.address), opened(disk)).await
}

pub(crate) async fn motions(server: &TestServer) -> Vec<Value> {
    let list = server.get(MOTIONS).await.json();
    list["motions"].as_array().unwrap().clone()
}

pub(crate) async fn answer(server: &TestServer, id: &Value, answer: &str) -> Value {
    let path = format!("{INTERVENTIONS}/{}/respond", id.as_str().unwrap());
    let body = json!({"answer": answer, "reason": "looked"}).to_string();
    let reply = server.post(&path, &body).await;
    assert_eq!(reply.status, 200, "{reply:?}");
    reply.json()
}

/// P1: the power goes before the intent is durable. Nothing was sent, and the key is free for the same motion, once.
#[tokio::test]
async fn a_motion_whose_intent_was_not_kept_was_never_sent() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    disk.fail_next("intent", Fault::PowerLossBefore);
    let server = serve(&robot, &disk).await;
    let reply = server.post_with_key(MOTIONS, "k1", MOTION).await;
    let _problem = reply.problem(503, "journal-unavailable", "NOT_SENT");
    robot.assert_untouched();

    let server = serve(&robot, &disk).await;
    let reply = server.post_with_key(MOTIONS, "k1", MOTION).await;
    assert_eq!(reply.status, 202);
    assert_eq!(reply.header("idempotency-replayed"), None);
    assert_eq!(robot.commands().len(), 1);
}

/// P2, P8: what was answered survives; the key leads to it, and the list shows it.
#[tokio::test]
async fn an_answer_survives_a_crash_and_the_key_leads_to_it() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server = serve(&robot, &disk).await;
    let body = MOTION.replacen('{', r#"{"reason": "teach check", "#, 1);
    let first = server.post_with_key(MOTIONS, "k1", &body).await.json();
    disk.lose_power();

    let server = serve(&robot, &disk).await;
    assert_eq!(motions(&server).await, std::slice::from_ref(&first));
    let again = server.post_with_key(MOTIONS, "k1", &body).await;
    assert_eq!(again.status, 202);
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    assert_eq!(again.json(), first);
    assert_eq!(robot.commands().len(), 1);
    assert_eq!(
        server.get(INTERVENTIONS).await.json()["interventions"],
        json!([])
    );
}

/// P4, P5, P6: an intent without an end. The seed program cannot be asked, so it is in doubt, is not sent again, and
/// keeps other motions away until somebody has looked.
#[tokio::test]
async fn a_motion_under_way_in_a_crash_is_in_doubt_and_never_sent_again() {
    let robot = FakeRobot::start([Act::Held(ACCEPTED), Act::Reply(ACCEPTED)]).await;
    let disk = MemoryDisk::new();
    let server = Arc::new(serve(&robot, &disk).await);
    let posting = Arc::clone(&server);
    let lost = tokio::spawn(async move { posting.post_with_key(MOTIONS, "k1", MOTION).await });
    wait_until("the robot has the command", || robot.commands().len() == 1).await;
    disk.lose_power();
    lost.abort();

    let next = serve(&robot, &disk).await;
    let motion = &motions(&next).await[0];
    assert_eq!(motion["state"], "in_doubt");
    assert_eq!(motion["code"], "server-restarted");
    let again = next.post_with_key(MOTIONS, "k1", MOTION).await;
    assert_eq!(again.header("idempotency-replayed"), Some("true"));
    let _problem = again.problem(409, "server-restarted", "UNKNOWN");
    let refused = next.post(MOTIONS, MOTION).await;
    let _problem = refused.problem(409, "in-doubt", "NOT_SENT");
    assert_eq!(robot.commands().len(), 1);
    robot.release();

    let _answered = answer(&next, &motion["id"], "happened").await;
    let shown = next
        .get(&format!("{MOTIONS}/{}", motion["id"].as_str().unwrap()))
        .await;
    assert_eq!(shown.json()["state"], "succeeded");
    assert_eq!(next.post(MOTIONS, MOTION).await.status, 202);
    // What was decided stays decided.
    disk.lose_power();
    let last = serve(&robot, &disk).await;
    let states: Vec<_> = motions(&last)
        .await
        .iter()
        .map(|one| one["state"].clone())
        .collect();
    assert_eq!(states, ["accepted", "succeeded"]);
    assert_eq!(robot.commands().len(), 2);
}

/// P7: the controller answered and the power went before that was durable, or after it.
#[tokio::test]
async fn an_acceptance_that_was_not_kept_is_a_doubt_and_one_that_was_is_none() {
    for (fault, state) in [
        (Fault::PowerLossBefore, "in_doubt"),
        (Fault::PowerLossAfter, "accepted"),
    ] {
        let robot = FakeRobot::accepting().await;
        let disk = MemoryDisk::new();
        disk.fail_next("accepted", fault);
        let server = serve(&robot, &disk).await;
        // The controller has taken it, so that is the answer, whatever the disk says.
        assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
        let server = serve(&robot, &disk).await;
        assert_eq!(motions(&server).await[0]["state"], state, "{fault:?}");
        assert_eq!(robot.commands().len(), 1);
    }
}

/// P13: the power goes again while the next start takes up what was left; the start after that does it.
#[tokio::test]
async fn a_crash_in_the_recovery_changes_nothing() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    disk.fail_next("accepted", Fault::PowerLossBefore);
    let server = serve(&robot, &disk).await;
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
    for fault in [Fault::PowerLossBefore, Fault::PowerLossAfter] {
        // The doubt.
        disk.fail_next("outcome", fault);
        // It cannot keep what it finds out, and does not begin to serve.
        let server = serve(&robot, &disk).await;
        let error = server.task.await.unwrap().unwrap_err();
        assert!(error.to_string().contains("journal"), "{error}");
    }
    let server = serve(&robot, &disk).await;
    let all = motions(&server).await;
    assert_eq!((all.len(), &all[0]["state"]), (1, &json!("in_doubt")));
    assert_eq!(robot.commands().len(), 1);
}

/// P14: the power goes between a person's answer and what follows from it; the next start does what follows.
#[tokio::test]
async fn an_answer_that_was_kept_is_applied_after_a_crash() {
    let robot = FakeRobot::start([Act::CloseAfter("")]).await;
    let disk = MemoryDisk::new();
    let server = serve(&robot, &disk).await;
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 504);
    let id = motions(&server).await[0]["id"].clone();
    // The answer is kept, and the end that follows is not.
    disk.fail_next("outcome", Fault::PowerLossBefore);
    let _answered = answer(&server, &id, "abort").await;
    let server = serve(&robot, &disk).await;
    let motion = &motions(&server).await[0];
    assert_eq!(motion["state"], "failed");
    assert_eq!(motion["decision"]["answer"], "abort");
    assert_eq!(
        server.get(INTERVENTIONS).await.json()["interventions"],
        json!([])
    );
}

/// D1: no room for the intent. Nothing is sent, on any route, and everything else is answered.
#[tokio::test]
async fn a_full_disk_refuses_motions_and_nothing_else() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    disk.fail_next("intent", Fault::Refuse);
    let server = serve(&robot, &disk).await;
    assert_eq!(server.get("/readyz").await.status, 200);
    for _first_and_later in 0..2 {
        let reply = server.post(MOTIONS, MOTION).await;
        let _problem = reply.problem(507, "journal-full", "NOT_SENT");
    }
    let legacy = server.post("/fanuc/move", POINT).await;
    let _problem = legacy.problem(507, "journal-full", "NOT_SENT");
    robot.assert_untouched();
    let ready = server.get("/readyz").await;
    assert_eq!(
        (ready.status, &ready.json()["journal"]["writable"]),
        (503, &json!(false))
    );
    for path in [
        MOTIONS,
        "/api/v1/cells/c1/robots/r1/state",
        INTERVENTIONS,
        "/livez",
    ] {
        assert_eq!(server.get(path).await.status, 200, "{path}");
    }
    assert_eq!(server.request("POST", STOP, &[], "").await.status, 200);
}

/// D2: the sync failed, and the intent is there after the next start all the same. It was not sent, but nothing proves
/// that: in doubt.
#[tokio::test]
async fn a_failed_sync_sends_nothing_and_is_not_trusted_afterwards() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    disk.fail_next("intent", Fault::RefuseAndKeep);
    let server = serve(&robot, &disk).await;
    let reply = server.post(MOTIONS, MOTION).await;
    let _problem = reply.problem(503, "journal-unavailable", "NOT_SENT");
    robot.assert_untouched();
    disk.lose_power();
    let server = serve(&robot, &disk).await;
    assert_eq!(motions(&server).await[0]["state"], "in_doubt");
    robot.assert_untouched();
}

/// D4, D8: a journal that another process has, or that is damaged, is not opened, and says so.
#[tokio::test]
async fn a_journal_in_use_or_damaged_keeps_the_server_from_starting() {
    let folder = tempfile::tempdir().unwrap();
    let section = JournalSection {
        path: Some("cell.journal".into()),
        allow_volatile_filesystem: true,
        ..JournalSection::default()
    };
    let journal = open_journal(&section, folder.path(), &SystemClock)
        .await
        .unwrap();
    let error = open_journal(&section, folder.path(), &SystemClock).await;
    let error = format!("{:?}", error.unwrap_err());
    assert!(error.contains("InUse"), "{error}");
    drop(journal);
    let path = folder.path().join("cell.journal");
    // The writer gives up the lock when it has ended.
    let mut damaged = false;
    for _attempt in 0..10_000 {
        match open_journal(&section, folder.path(), &SystemClock).await {
            Ok(journal) => {
                drop(journal);
                // Sixteen bytes in the middle of the first page of records.
                if !damaged {
                    damaged = true;
                    let bytes = std::fs::read(&path).unwrap();
                    let text = String::from_utf8_lossy(&bytes);
                    assert!(text.contains("SQLite format"));
                    std::fs::write(&path, &bytes[..100]).unwrap();
                }
            }
            Err(error) => {
                let text = format!("{error:?}");
                if text.contains("InUse") {
                    tokio::task::yield_now().await;
                } else {
                    assert!(damaged, "{text}");
                    return;
                }
            }
        }
    }
    panic!("a damaged journal was opened, or the lock never came free");
}

/// D9: the disk stalls. Motions wait; reads and the stop do not, and what the stop came before is not sent.
#[tokio::test]
async fn a_stalled_disk_holds_motions_and_neither_reads_nor_the_stop() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server = Arc::new(serve(&robot, &disk).await);
    disk.hold_syncs();
    let posting = Arc::clone(&server);
    let waiting = tokio::spawn(async move { posting.post(MOTIONS, MOTION).await });
    while server.get("/api/v1/cells/c1/robots/r1/state").await.json()["queued"] != 1 {}
    assert_eq!(server.request("POST", STOP, &[], "").await.status, 200);
    robot.assert_untouched();
    disk.release_syncs();
    let problem = waiting.await.unwrap();
    let _problem = problem.problem(409, "motion-canceled", "NOT_SENT");
    robot.assert_untouched();
}

/// A wall clock that somebody sets.
#[derive(Debug)]
struct SetClock(AtomicI64);

impl WallClock for SetClock {
    fn now(&self) -> Timestamp {
        Timestamp::from_second(self.0.load(Ordering::SeqCst)).unwrap()
    }
}

/// T1: the wall clock jumps a day, either way. Motions go on, since deadlines are not the wall clock's, keys are known
/// as long as they are kept, and the journal says that the clock was set.
#[tokio::test]
async fn a_wall_clock_that_jumps_stops_nothing_and_is_written_down() {
    const DAY: i64 = 24 * 60 * 60;
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let clock = Arc::new(SetClock(AtomicI64::new(1_800_000_000)));
    let seams = Seams {
        connector: TcpConnector::default(),
        clock: Arc::clone(&clock) as Arc<dyn WallClock>,
        journal: opened(&disk),
    };
    let section = robot_section(robot.address);
    let server = TestServer::with_seams(ServerSection::default(), section, seams).await;
    assert_eq!(
        server.post_with_key(MOTIONS, "k1", MOTION).await.status,
        202
    );
    for step in [DAY, -2 * DAY, 3 * DAY] {
        let _before = clock.0.fetch_add(step, Ordering::SeqCst);
        let reply = server.post(MOTIONS, MOTION).await;
        assert_eq!(reply.status, 202, "{step}: {reply:?}");
        let again = server.post_with_key(MOTIONS, "k1", MOTION).await;
        assert_eq!(again.header("idempotency-replayed"), Some("true"), "{step}");
    }
    let steps = disk
        .rows()
        .iter()
        .filter(|row| String::from_utf8_lossy(&row.body).contains("clock.step"))
        .count();
    assert_eq!(steps, 3);
    let ids: Vec<_> = motions(&server)
        .await
        .iter()
        .map(|motion| motion["id"].as_str().unwrap().to_owned())
        .collect();
    assert!(ids.is_sorted_by(|newer, older| newer > older), "{ids:?}");
    assert_eq!(robot.commands().len(), 4);
}

/// T4: a time with an offset is the moment it names, and every time that is told or kept is in UTC; a time without an
/// offset names no moment.
#[tokio::test]
async fn t4_every_time_is_utc() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server = serve(&robot, &disk).await;
    let soon = Timestamp::from_second(Timestamp::now().as_second() + 60).unwrap();
    let summer = jiff::tz::TimeZone::fixed(jiff::tz::offset(2));
    let local = soon.to_zoned(summer);
    let body = |time: &str| MOTION.replacen('{', &format!("{{\"not_after\": \"{time}\", "), 1);
    let offset = local.strftime("%Y-%m-%dT%H:%M:%S%:z").to_string();
    assert!(offset.ends_with("+02:00"), "{offset}");
    let reply = server.post(MOTIONS, &body(&offset)).await;
    assert_eq!(reply.status, 202, "{reply:?}");
    let motion = reply.json();
    assert_eq!(motion["not_after"], soon.to_string());
    let times = [&motion["not_after"], &motion["created_at"]];
    assert!(
        times
            .iter()
            .all(|time| time.as_str().unwrap().ends_with('Z'))
    );
    for row in disk.rows() {
        let row: Value = serde_json::from_slice(&row.body).unwrap();
        assert!(row["wall"].as_str().unwrap().ends_with('Z'), "{row}");
    }
    let nowhere = local.strftime("%Y-%m-%dT%H:%M:%S").to_string();
    let reply = server.post(MOTIONS, &body(&nowhere)).await;
    let problem = reply.problem(422, "validation", "NOT_SENT");
    assert_eq!(problem["violations"][0]["item"], "not_after");
    assert_eq!(robot.commands().len(), 1);
}

/// The thesis's routes are kept, too, and count from nothing after a restart.
#[tokio::test]
async fn the_thesiss_routes_are_kept_where_there_is_a_journal() {
    let up = r#"{"dx": 0, "dy": 0, "dz": 10.5, "dw": 0, "dp": 0, "dr": 0}"#;
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server = serve(&robot, &disk).await;
    assert_eq!(server.post("/fanuc/move", POINT).await.status, 200);
    assert_eq!(server.post("/fanuc/delta", up).await.status, 200);
    let before = motions(&server).await;
    disk.lose_power();
    let server = serve(&robot, &disk).await;
    assert_eq!(motions(&server).await, before);
    assert_eq!(before.len(), 2);
    assert_eq!(server.post("/fanuc/delta", up).await.status, 409);
    assert_eq!(robot.commands().len(), 2);
}
