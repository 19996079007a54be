//! Tokens and control, as `cellctl` handles them.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails is a test that fails"
)]

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::fake::{Answer, Fake, cellctl_in};
use crate::samples;

const TOKEN: &str =
    "cell_0123456789abcdef_00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";

fn me() -> Value {
    json!({"name": "alice", "roles": ["operator"], "scope": {}, "demo": false, "token": "0123456789abcdef"})
}

/// Runs `cellctl` with a home of its own and something on its standard input.
async fn at_home(home: &Path, arguments: &[&str], input: &str) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cellctl"));
    let _ = command
        .args(arguments)
        .env_clear()
        .env("HOME", home)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let input = input.to_owned();
    let output = tokio::task::spawn_blocking(move || {
        let mut running = command.spawn().unwrap();
        // A program that does not read its input may have ended already.
        let _written = running.stdin.take().unwrap().write_all(input.as_bytes());
        running.wait_with_output().unwrap()
    });
    let output = output.await.unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[tokio::test]
async fn the_audit_is_a_table_that_says_how_to_go_on() {
    let entries = json!([{"id": "3-1207", "at": "2026-11-22T18:00:00Z", "since_start_ms": 5, "principal": "anna",
        "role": "operator", "action": "control.acquire", "object": "demo", "result": "denied"}]);
    let body = json!({"entries": entries, "next_cursor": "1207"});
    let fake = Fake::always(Answer::Json(body)).await;
    let ran = fake
        .cellctl(&["audit", "--limit", "1", "--cursor", "1300"])
        .await;
    assert_eq!(ran.code, 0, "{ran:?}");
    for part in [
        "anna",
        "operator",
        "control.acquire",
        "denied",
        "--cursor 1207",
    ] {
        assert!(ran.stdout.contains(part), "{part}: {}", ran.stdout);
    }
    let seen = fake.seen();
    assert_eq!(
        seen[0].line,
        "GET /api/v1/cells/demo/audit?limit=1&cursor=1300"
    );
}

#[tokio::test]
async fn a_token_that_was_tried_is_kept_for_its_owner_alone_and_used() {
    let fake = Fake::always(Answer::Json(me())).await;
    let home = tempfile::tempdir().unwrap();
    let url = fake.url();
    let (code, said, wrong) = at_home(home.path(), &["--server", &url, "login"], TOKEN).await;
    assert_eq!((code, wrong.as_str()), (Some(0), ""), "{said}");
    assert!(said.contains("alice") && !said.contains(TOKEN), "{said}");
    let file = home.path().join(".config/robocell/credentials.json");
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o600
    );

    let (code, _, _) = at_home(home.path(), &["--server", &url, "whoami"], "").await;
    assert_eq!(code, Some(0));
    let bearer = format!("Bearer {TOKEN}");
    assert!(
        fake.seen()
            .iter()
            .all(|seen| seen.token.as_ref() == Some(&bearer))
    );
    // Of one server, not of another.
    let other = Fake::always(Answer::Json(me())).await;
    let _ran = at_home(home.path(), &["--server", &other.url(), "whoami"], "").await;
    assert_eq!(other.seen()[0].token, None);

    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    let (code, _, wrong) = at_home(home.path(), &["--server", &url, "whoami"], "").await;
    assert_eq!(code, Some(2));
    assert!(
        wrong.contains("chmod 600") && !wrong.contains(TOKEN),
        "{wrong}"
    );
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();

    let (_, said, _) = at_home(home.path(), &["--server", &url, "logout"], "").await;
    assert!(said.contains("alice"), "{said}");
    assert!(!fs::read_to_string(&file).unwrap().contains("cell_"));
    let (_, said, _) = at_home(home.path(), &["--server", &url, "logout"], "").await;
    assert!(said.contains("No token"), "{said}");
}

#[tokio::test]
async fn what_is_no_token_is_neither_sent_nor_shown() {
    let fake = Fake::always(Answer::Json(me())).await;
    let home = tempfile::tempdir().unwrap();
    let long = format!("cell_{}", "x".repeat(300));
    for input in ["", "\n", "hunter2", "cell_a b", "cell_\u{e9}", &long] {
        let (code, said, wrong) =
            at_home(home.path(), &["--server", &fake.url(), "login"], input).await;
        assert_eq!(code, Some(2), "{input}: {said}{wrong}");
        assert!(
            !wrong.contains("hunter2") && !wrong.contains("xxxx"),
            "{wrong}"
        );
    }
    assert!(fake.seen().is_empty());
    assert!(!home.path().join(".config").exists());
}

#[tokio::test]
async fn the_environment_and_a_file_go_before_what_was_kept() {
    let fake = Fake::always(Answer::Json(me())).await;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("token");
    fs::write(&file, format!("{TOKEN}\n")).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    let (url, other) = (fake.url(), TOKEN.replace('0', "1"));
    let ran = cellctl_in(&[("ROBOCELL_TOKEN", &other)], &["--server", &url, "whoami"]).await;
    assert_eq!(ran.code, 0, "{ran:?}");
    let arguments = [
        "--server",
        &url,
        "--token-file",
        file.to_str().unwrap(),
        "whoami",
    ];
    let ran = cellctl_in(&[("ROBOCELL_TOKEN", &other)], &arguments).await;
    assert_eq!(ran.code, 0, "{ran:?}");
    let tokens: Vec<_> = fake
        .seen()
        .into_iter()
        .map(|seen| seen.token.unwrap())
        .collect();
    assert_eq!(
        tokens,
        [format!("Bearer {other}"), format!("Bearer {TOKEN}")]
    );
    let ran = cellctl_in(&[("ROBOCELL_TOKEN", &other)], &["--help"]).await;
    assert!(!ran.stdout.contains(&other) && !ran.stdout.contains("--token "));
}

#[tokio::test]
async fn a_move_takes_control_and_gives_it_back_also_when_it_is_refused() {
    let refused = samples::problem(api::ProblemCode::OutOfWorkspace, api::Outcome::NotSent);
    for answer in [
        Answer::Json(samples::motion("accepted")),
        Answer::Problem(Box::new(refused)),
    ] {
        let fake = Fake::always(answer).await;
        let _ran = fake.cellctl(&["home"]).await;
        let lease = samples::MOTION_ID;
        let path = "/api/v1/cells/demo/control-authority";
        assert_eq!(
            fake.controls(),
            [format!("POST {path}"), format!("DELETE {path}/{lease}")]
        );
        assert_eq!(fake.seen()[0].control, Some(format!("{lease}.7")));
    }
}

#[tokio::test]
async fn control_that_was_taken_before_is_used_and_kept() {
    let fake = Fake::always(Answer::Json(samples::motion("accepted"))).await;
    let token = format!("{}.3", samples::MOTION_ID);
    let ran = fake.cellctl(&["home", "--control", &token]).await;
    assert_eq!(ran.code, 0, "{ran:?}");
    assert_eq!(fake.controls(), Vec::<String>::new());
    assert_eq!(fake.seen()[0].control.as_ref(), Some(&token));
    let ran = fake.cellctl(&["home", "--control", "x"]).await;
    assert_eq!(ran.code, 2, "{ran:?}");
}

#[tokio::test]
async fn control_is_shown_taken_and_given_back_by_hand() {
    let fake = Fake::always(Answer::Json(json!(null))).await;
    let ran = fake
        .cellctl(&["control", "take", "--reason", "teaching"])
        .await;
    assert_eq!(ran.code, 0, "{ran:?}");
    let token = format!("{}.7", samples::MOTION_ID);
    assert!(ran.stdout.starts_with(&token), "{ran:?}");
    let ran = fake.cellctl(&["control", "release", &token]).await;
    assert!(ran.stdout.contains("free"), "{ran:?}");
    let ran = fake.cellctl(&["control", "take", "--ttl-s", "61"]).await;
    assert_eq!(ran.code, 2, "{ran:?}");
}
