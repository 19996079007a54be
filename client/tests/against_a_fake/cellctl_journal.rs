//! `cellctl journal`: exit codes, and the first broken record.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests: a failure here fails the test"
)]

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use journal::{
    Audit, AuditResult, Clocks, Filesystem, Journal as _, KeyRetention, Opening, Record,
    SqliteJournal, SqliteOptions,
};

fn at() -> Clocks {
    Clocks {
        wall: jiff::Timestamp::UNIX_EPOCH,
        monotonic: Duration::ZERO,
    }
}

async fn make(path: &Path) {
    let opening = Opening {
        at: at(),
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: Filesystem::Trusted,
        ..SqliteOptions::default()
    };
    let journal = SqliteJournal::open(path, &opening, &options).await.unwrap();
    for n in 0..5 {
        let audit = Record::Audit(Audit {
            principal: "anna".into(),
            action: "limits.update".into(),
            object: format!("object-{n}"),
            result: AuditResult::Done,
            request_id: None,
            cell: None,
            role: None,
            source: None,
            lease: None,
            before: None,
            after: None,
        });
        let _kept = journal.append(at(), audit).await.unwrap();
    }
    journal.close().await;
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_cellctl"))
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[tokio::test]
async fn a_journal_is_verified_and_exported_and_its_first_broken_record_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.journal");
    make(&path).await;
    let file = path.to_str().unwrap();
    let (code, text, _) = run(&["journal", "verify", file]);
    assert_eq!(code, 0, "{text}");
    assert!(text.starts_with("The journal holds: 6 records"), "{text}");
    let head = text
        .lines()
        .find_map(|line| line.strip_prefix("head "))
        .unwrap();
    let (code, _, _) = run(&["journal", "verify", file, "--head", head]);
    assert_eq!(code, 0);
    let later = format!("9:{}", head.split_once(':').unwrap().1);
    let (code, _, error) = run(&["journal", "verify", file, "--head", &later]);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains("record 9"), "{error}");

    let (code, lines, _) = run(&["journal", "export", file]);
    assert_eq!((code, lines.lines().count()), (0, 6));
    let out = folder.path().join("out.jsonl");
    let out = out.to_str().unwrap();
    assert_eq!(run(&["journal", "export", file, "--output", out]).0, 0);
    assert_eq!(std::fs::read_to_string(out).unwrap(), lines);
    // Never over a file that is there.
    assert_eq!(run(&["journal", "export", file, "--output", out]).0, 2);

    let bytes = std::fs::read(&path).unwrap();
    let place = bytes
        .windows(8)
        .position(|window| window == b"object-3")
        .unwrap();
    let mut edited = bytes.clone();
    edited[place + 7] = b'7';
    std::fs::write(&path, &edited).unwrap();
    let (code, _, error) = run(&["journal", "verify", file]);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains("record 5"), "{error}");
    let (code, text, _) = run(&["--json", "journal", "verify", file]);
    let told: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!((code, &told["first_broken"]), (1, &serde_json::json!(5)));

    let nothing = folder.path().join("nothing");
    assert_eq!(run(&["journal", "verify", nothing.to_str().unwrap()]).0, 3);
}

#[tokio::test]
async fn r6_what_was_removed_is_said_and_proved_by_its_archive() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.journal");
    make(&path).await;
    let file = path.to_str().unwrap();
    let lines = run(&["journal", "export", file]).1;
    let opening = Opening {
        at: at(),
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: Filesystem::Trusted,
        ..SqliteOptions::default()
    };
    let journal = SqliteJournal::open(&path, &opening, &options)
        .await
        .unwrap();
    let pruned = journal.prune(at(), journal::Position(4), None).await;
    assert_eq!(pruned.unwrap().removed, 4);
    journal.close().await;
    let (code, text, _) = run(&["journal", "verify", file]);
    assert_eq!(code, 0, "{text}");
    assert!(text.starts_with("The journal holds: 4 records"), "{text}");
    assert!(text.contains("not proved by this file"), "{text}");

    let archive = folder.path().join("old.jsonl");
    let old: Vec<_> = lines.lines().take(4).collect();
    std::fs::write(&archive, old.join("\n") + "\n").unwrap();
    let archive = archive.to_str().unwrap();
    let (code, text, _) = run(&["journal", "verify", file, "--archive", archive]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("one chain"), "{text}");

    std::fs::write(archive, old[..3].join("\n") + "\n").unwrap();
    let (code, _, error) = run(&["journal", "verify", file, "--archive", archive]);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains("the archives end at 3:"), "{error}");
    let edited = old.join("\n").replace("object-1", "object-7");
    std::fs::write(archive, edited + "\n").unwrap();
    let (code, _, error) = run(&["journal", "verify", file, "--archive", archive]);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains("record 3"), "{error}");
}
