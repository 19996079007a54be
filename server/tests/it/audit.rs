//! Who did what: kept in the journal, told over HTTP, and in nobody's way.

use std::path::Path;
use std::sync::Arc;

use journal::{Filesystem, MemoryDisk, Opening, Record, SqliteJournal, SqliteOptions, Stored};
use serde_json::{Value, json};
use server::SharedJournal;

use crate::kept_motions::serve;
use crate::support::{FakeRobot, Secured, TestServer, control_of, opened, wait_until};

const AUDIT: &str = "/api/v1/cells/c1/audit";
const CONTROL: &str = "/api/v1/cells/c1/control-authority";
const STOP: &str = "/api/v1/cells/c1/robots/r1/stop";

/// The journal in a file. The writer of an earlier one gives up the lock when it has ended.
async fn in_file(path: &Path) -> SharedJournal {
    let opening = Opening {
        at: journal::Clocks {
            wall: jiff::Timestamp::now(),
            monotonic: std::time::Duration::ZERO,
        },
        program: "test".into(),
        keys: journal::KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: Filesystem::Trusted,
        ..SqliteOptions::default()
    };
    loop {
        match SqliteJournal::open(path, &opening, &options).await {
            Ok(journal) => return SharedJournal::durable(journal),
            Err(journal::OpenError::InUse { .. }) => tokio::task::yield_now().await,
            Err(error) => panic!("{error}"),
        }
    }
}

fn actions(list: &Value) -> Vec<String> {
    let entries = list["entries"].as_array().unwrap();
    entries
        .iter()
        .map(|entry| format!("{} {}", entry["principal"], entry["action"]).replace('"', ""))
        .collect()
}

/// The actions in a journal in memory, in their order.
fn kept(disk: &MemoryDisk) -> Vec<String> {
    let rows = disk.rows();
    let records = rows
        .iter()
        .map(|row| Stored::decode(&row.body).unwrap().record);
    records
        .filter_map(|record| {
            let Record::Audit(audit) = record else {
                return None;
            };
            Some(audit.action)
        })
        .collect()
}

/// SM-3: whatever was written or not, a later lease has a greater epoch, over a crash too.
#[tokio::test]
async fn sm3_the_epochs_of_control_grow_over_a_crash() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let mut last = 0;
    for start in 1..=3_u64 {
        let server = serve(&robot, &disk).await;
        // The power goes before anything of the lease is on the disk.
        disk.hold_syncs();
        for _lease in 0..2 {
            let body = r#"{"station": "LOCAL", "ttl_s": 60, "reason": "a test"}"#;
            let taken = server.post(CONTROL, body).await;
            assert_eq!(taken.status, 201, "{taken:?}");
            let epoch = taken.json()["epoch"].as_u64().unwrap();
            assert!(
                epoch > last && epoch / 1_000_000 == start,
                "{epoch} after {last}"
            );
            last = epoch;
        }
        disk.lose_power();
    }
}

#[tokio::test]
async fn who_did_what_is_in_the_journal_after_a_restart_and_in_its_export() {
    let robot = FakeRobot::accepting().await;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.journal");
    let mut cell = Secured::start_with(&robot, in_file(&path).await).await;
    let anna = cell.token("anna", "operator").await;
    let vera = cell.token("vera", "viewer").await;
    let lease = control_of(&cell.acquire(&anna, &json!({"reason": "teach check"})).await);
    assert_eq!(cell.acquire(&vera, &json!({})).await.status, 403);
    assert_eq!(cell.get(CONTROL, "cell_0_0").await.status, 401);
    assert_eq!(cell.get(CONTROL, "").await.status, 401);
    assert_eq!(
        cell.send("POST", STOP, &vera, &Value::Null).await.status,
        200
    );
    let id = lease.split('.').next().unwrap();
    let given = format!("{CONTROL}/{id}");
    assert_eq!(
        cell.send("DELETE", &given, &anna, &Value::Null)
            .await
            .status,
        200
    );
    let token = vera.split('_').nth(1).unwrap().to_owned();
    let revoke = format!("/api/v1/tokens/{token}");
    let admin = cell.admin.clone();
    assert_eq!(
        cell.send("DELETE", &revoke, &admin, &Value::Null)
            .await
            .status,
        200
    );

    cell.again(&robot, async || in_file(&path).await).await;
    let list = cell.get(AUDIT, &admin).await.json();
    let expected = [
        "first-admin token.revoke",
        "anna control.release",
        "vera robot.stop",
        "nobody access.refused",
        "vera access.refused",
        "anna control.acquire",
        "first-admin token.create",
        "first-admin token.create",
    ];
    let admins_name = list["entries"][0]["principal"].as_str().unwrap();
    let expected = expected.map(|line| line.replace("first-admin", admins_name));
    assert_eq!(actions(&list), expected);
    let acquired = &list["entries"][5];
    assert_eq!(
        (
            &acquired["role"],
            &acquired["cell"],
            &acquired["lease"],
            &acquired["after"]
        ),
        (
            &json!("operator"),
            &json!("c1"),
            &json!(1_000_001),
            &json!("teach check")
        )
    );
    assert_eq!(list["entries"][1]["lease"], 1_000_001);
    let refused = &list["entries"][4];
    assert_eq!(
        (&refused["result"], &refused["after"], &refused["source"]),
        (&json!("denied"), &json!("forbidden"), &json!("127.0.0.1"))
    );
    assert_eq!(list["next_cursor"], Value::Null);

    // The same in the file's export, in the chain.
    cell.end().await;
    drop(in_file(&path).await);
    let mut lines = Vec::new();
    let _head = journal::export(&path, &mut lines).await.unwrap();
    let text = String::from_utf8(lines).unwrap();
    for action in [
        "token.create",
        "control.acquire",
        "control.release",
        "access.refused",
    ] {
        assert!(
            text.contains(&format!("\"action\":\"{action}\"")),
            "{action}"
        );
    }
}

#[tokio::test]
async fn the_audit_is_paged_and_shows_each_what_concerns_them() {
    let robot = FakeRobot::accepting().await;
    let cell = Secured::start(&robot).await;
    let of_c2 = json!({"cell": "c2"});
    let ines = cell.scoped("ines", "integrator", of_c2).await;
    let otto = cell.token("otto", "integrator").await;
    for _ in 0..3 {
        assert_eq!(
            cell.acquire(&otto, &json!({"station": "REMOTE"}))
                .await
                .status
                / 100,
            2
        );
        let held = cell.get(CONTROL, &otto).await.json()["held"]["lease"].clone();
        let path = format!("{CONTROL}/{}", held.as_str().unwrap());
        assert_eq!(
            cell.send("DELETE", &path, &otto, &Value::Null).await.status,
            200
        );
    }
    let other = "/api/v1/cells/c2/robots/r1/stop";
    assert_eq!(
        cell.send("POST", other, &ines, &Value::Null).await.status,
        200
    );
    while actions(&cell.get("/api/v1/cells/c2/audit", &ines).await.json()).is_empty() {}
    // Neither the tokens nor the other cell.
    let hers = cell.get("/api/v1/cells/c2/audit", &ines).await.json();
    assert_eq!(actions(&hers), ["ines robot.stop"]);
    assert_eq!(cell.get(AUDIT, &ines).await.status, 404);

    let (mut cursor, mut pages) = (String::new(), Vec::new());
    loop {
        let page = cell
            .get(&format!("{AUDIT}?limit=3{cursor}"), &otto)
            .await
            .json();
        pages.extend(actions(&page));
        let Some(next) = page["next_cursor"].as_str() else {
            break;
        };
        cursor = format!("&cursor={next}");
    }
    assert_eq!(pages.len(), 9, "{pages:?}");
    assert_eq!(pages[0], "ines access.refused");
    assert!(
        pages[1..7]
            .iter()
            .all(|one| one.starts_with("otto control.")),
        "{pages:?}"
    );
    for query in [
        "limit=0",
        "limit=201",
        "cursor=x",
        "cursor=-1",
        "sort=1",
        "limit=1&limit=2",
    ] {
        let reply = cell.get(&format!("{AUDIT}?{query}"), &otto).await;
        let _problem = reply.problem(422, "validation", "NONE");
    }
}

/// D9, SM-3: a disk that stalls keeps nobody from control, and nobody from stopping; the record comes when it can, in
/// order.
#[tokio::test]
async fn d9_a_stalled_disk_holds_up_neither_control_nor_heartbeat_nor_stop() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server: Arc<TestServer> = Arc::new(serve(&robot, &disk).await);
    disk.hold_syncs();
    let body = r#"{"station": "REMOTE", "ttl_s": 60, "reason": "a test"}"#;
    for _ in 0..2 {
        let taken = server.post(CONTROL, body).await;
        assert_eq!(taken.status, 201, "{taken:?}");
        let path = format!("{CONTROL}/{}", taken.json()["lease"].as_str().unwrap());
        assert_eq!(server.bare("PUT", &path, &[], "").await.status, 200);
        assert_eq!(server.bare("POST", STOP, &[], "").await.status, 200);
        assert_eq!(server.bare("DELETE", &path, &[], "").await.status, 200);
    }
    assert_eq!(kept(&disk), Vec::<String>::new());
    assert_eq!(server.get("/readyz").await.status, 200);
    disk.release_syncs();
    wait_until("the record is on the disk", || kept(&disk).len() == 6).await;
    let once = ["control.acquire", "robot.stop", "control.release"];
    assert_eq!(kept(&disk), [once, once].concat());
}

/// A journal that takes nothing any more keeps nobody from control either; no token is made, and one can be revoked.
#[tokio::test]
async fn what_a_broken_journal_misses_is_counted_and_no_token_is_made() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let cell = Secured::start_with(&robot, opened(&disk)).await;
    let anna = cell.token("anna", "operator").await;
    disk.fail_next("audit", journal::Fault::RefuseAndKeep);
    let taken = cell.acquire(&anna, &json!({})).await;
    assert_eq!(taken.status, 201);
    let body = json!({"name": "boris", "role": "operator"});
    let reply = cell
        .send("POST", "/api/v1/tokens", &cell.admin, &body)
        .await;
    let _problem = reply.problem(503, "not-recorded", "NOT_SENT");
    let id = anna.split('_').nth(1).unwrap();
    let path = format!("/api/v1/tokens/{id}");
    let revoked = cell.send("DELETE", &path, &cell.admin, &Value::Null).await;
    assert_eq!(revoked.status, 200, "{revoked:?}");
    assert_eq!(cell.get(CONTROL, &anna).await.status, 401);
    let ready = cell.server.get("/readyz").await;
    let journal = &ready.json()["journal"];
    assert_eq!((ready.status, &journal["writable"]), (503, &json!(false)));
    assert!(journal["audit_lost"].as_u64().unwrap() >= 2, "{journal}");
}
