//! The binary as a person meets it: what it says when something is wrong, and that it starts and stops.
#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails is a test that fails"
)]

use std::io::{BufRead as _, BufReader, Read as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use api::{LegacyDelta, LegacyPoint};
use client::Client;

/// A configuration file that is removed when this is dropped.
struct ConfigFile(PathBuf);

impl ConfigFile {
    fn new(name: &str, text: &str) -> Self {
        let name = format!("robocell-test-{}-{name}.toml", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).unwrap();
        Self(path)
    }
}

impl Drop for ConfigFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn robocell(config: &ConfigFile) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robocell"));
    let _command = command
        .env_remove("ROBOCELL_DEMO")
        .arg("--config")
        .arg(&config.0);
    command
}

/// As [`robocell`], asking nobody for a token.
fn demo(config: &ConfigFile) -> Command {
    let mut command = robocell(config);
    let _command = command.arg("--demo");
    command
}

/// What it says about a configuration that it must refuse.
fn complaint(name: &str, text: &str) -> String {
    let config = ConfigFile::new(name, text);
    let Output { status, stderr, .. } = demo(&config).output().unwrap();
    assert_eq!(status.code(), Some(2), "{text}");
    String::from_utf8(stderr).unwrap()
}

fn cell(listen: SocketAddr, panel: SocketAddr) -> String {
    format!(
        "[server]\nlisten = \"{listen}\"\n[[cells]]\nid = \"demo\"\n[[cells.robots]]\nid = \"r1\"\n\
         model = \"fanuc-m20ia\"\ncontroller = \"virtual:vc1\"\n[[virtual_controllers]]\nname = \"vc1\"\n\
         model = \"fanuc-m20ia\"\npanel = \"{panel}\"\nports = {{ 59002 = 0 }}\n"
    )
}

fn any_port() -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, 0))
}

/// A running cell that ends when this is dropped.
struct Running {
    process: Child,
    http: String,
    // Kept open: the process must not find its output closed.
    _output: BufReader<std::process::ChildStdout>,
}

impl Running {
    fn start(config: &ConfigFile) -> Self {
        Self::of(demo(config)).0
    }

    /// Starts it; answers what it said up to the address of the API, too.
    fn of(mut command: Command) -> (Self, String) {
        let mut process = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(process.stdout.take().unwrap());
        let mut http = None;
        let mut said = String::new();
        let mut begin = 0;
        while http.is_none() && output.read_line(&mut said).unwrap() > 0 {
            http = said[begin..]
                .split_whitespace()
                .find(|word| word.starts_with("http://"))
                .map(str::to_owned);
            begin = said.len();
        }
        let http = http.expect("the banner names the address of the API");
        let running = Self {
            process,
            http,
            _output: output,
        };
        (running, said)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[tokio::test]
async fn the_cell_starts_moves_its_arm_and_stops_on_sigterm() {
    let config = ConfigFile::new("whole", &cell(any_port(), any_port()));
    let mut running = Running::start(&config);
    let client = Client::new(&running.http).unwrap();
    let moved = client.legacy_home(None).await.unwrap();
    assert!((moved.current_position.x - 985.0).abs() < 1e-9);

    let process = running.process.id().to_string();
    let told = Command::new("kill")
        .args(["-TERM", &process])
        .status()
        .unwrap();
    assert!(told.success());
    assert!(running.process.wait().unwrap().success());
}

#[tokio::test]
async fn an_operator_can_follow_the_log_line_by_line() {
    let config = ConfigFile::new("log", &cell(any_port(), any_port()));
    let mut running = Running::start(&config);
    let client = Client::new(&running.http).unwrap();
    let took = client.with_request_id("took-1").unwrap();
    let _moved = took.legacy_home(None).await.unwrap();
    let refused = client.with_request_id("refused-1").unwrap();
    let _refused = refused.legacy_home(Some(2000)).await.unwrap_err();
    let far = LegacyPoint {
        x: 5000.0,
        y: 0.0,
        z: 0.0,
        w: 0.0,
        p: 0.0,
        r: 0.0,
    };
    let _refused = refused.legacy_move(&far, None).await.unwrap_err();
    let change = LegacyDelta {
        dx: 5000.0,
        dy: 0.0,
        dz: 0.0,
        dw: 0.0,
        dp: 0.0,
        dr: 0.0,
    };
    let delta = client.with_request_id("delta-1").unwrap();
    let _refused = delta.legacy_delta(&change, None).await.unwrap_err();
    running.process.kill().unwrap();
    let mut log = String::new();
    let mut errors = running.process.stderr.take().unwrap();
    let _length = errors.read_to_string(&mut log).unwrap();

    let line = |words: &[&str]| {
        log.lines()
            .any(|line| words.iter().all(|word| line.contains(word)))
    };
    assert!(
        line(&["INFO", "the controller took the command", "r1", "took-1"]),
        "{log}"
    );
    assert!(
        line(&[
            "INFO",
            "the command was refused and not sent",
            "r1",
            "refused-1",
            "stretched arm"
        ]),
        "{log}"
    );
    assert!(
        line(&[
            "INFO",
            "the command was refused and not sent",
            "r1",
            "delta-1",
            "stretched arm"
        ]),
        "{log}"
    );
    assert!(!log.contains('\u{1b}'), "colors in a file: {log:?}");
}

#[test]
fn a_port_in_use_is_named() {
    let taken = TcpListener::bind(any_port()).unwrap();
    let address = taken.local_addr().unwrap();
    let said = complaint("http-in-use", &cell(address, any_port()));
    assert!(
        said.contains(&address.to_string()) && said.contains("in use"),
        "{said}"
    );
    let said = complaint("panel-in-use", &cell(any_port(), address));
    assert!(
        said.contains(&address.to_string()) && said.contains("in use"),
        "{said}"
    );
    let robot =
        cell(any_port(), any_port()).replace("59002 = 0", &format!("59002 = {}", address.port()));
    let said = complaint("robot-in-use", &robot);
    assert!(
        said.contains(&address.port().to_string()) && said.contains("in use"),
        "{said}"
    );
}

#[test]
fn a_key_that_does_not_exist_is_named_with_its_line() {
    let said = complaint(
        "unknown-key",
        &cell(any_port(), any_port()).replace("panel", "pannel"),
    );
    assert!(
        said.contains("pannel") && said.contains("`panel`") && said.contains("line 12"),
        "{said}"
    );
}

#[test]
fn a_wrong_unit_is_answered_with_the_right_one() {
    let text =
        cell(any_port(), any_port()).replace("[[virtual", "connect_timeout_s = 1\n[[virtual");
    let said = complaint("wrong-unit", &text);
    assert!(
        said.contains("connect_timeout_s") && said.contains("connect_timeout_ms"),
        "{said}"
    );
}

#[test]
fn two_controllers_of_one_name_are_refused_before_anything_starts() {
    let text = cell(any_port(), any_port());
    let (_, section) = text.split_once("[[virtual_controllers]]").unwrap();
    let config = ConfigFile::new(
        "one-name",
        &format!("{text}[[virtual_controllers]]{section}"),
    );
    let Output { status, stderr, .. } = demo(&config).arg("--check").output().unwrap();
    let said = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{said}");
    assert!(
        said.contains("virtual_controllers[1].name") && said.contains("vc1"),
        "{said}"
    );
}

#[test]
fn a_controller_that_is_not_in_the_file_is_named() {
    let said = complaint(
        "dangling",
        &cell(any_port(), any_port()).replace("virtual:vc1", "virtual:vc7"),
    );
    assert!(
        said.contains("cells[0].robots[0].controller") && said.contains("vc7"),
        "{said}"
    );
}

#[test]
fn a_program_that_is_missing_or_not_karel_is_named() {
    let with_program = |path: &str| {
        cell(any_port(), any_port()).replace("panel", &format!("programs = [\"{path}\"]\npanel"))
    };
    let said = complaint("no-program", &with_program("nowhere.kl"));
    assert!(
        said.contains("virtual_controllers[0].programs") && said.contains("nowhere.kl"),
        "{said}"
    );
    let not_karel = ConfigFile::new("not-karel", "this = \"is not KAREL\"\n");
    let said = complaint("not-karel", &with_program(not_karel.0.to_str().unwrap()));
    assert!(
        said.contains("expected PROGRAM") && said.contains('^'),
        "{said}"
    );
}

#[test]
fn a_checked_configuration_starts_nothing() {
    let config = ConfigFile::new("check", &cell(any_port(), any_port()));
    let mut process = demo(&config)
        .arg("--check")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = String::new();
    let _length = process
        .stdout
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert!(process.wait().unwrap().success());
    assert!(
        said.contains("1 cell, 1 robot, 1 virtual controller;"),
        "{said}"
    );
}

#[test]
fn without_tokens_and_without_the_word_demo_it_does_not_start() {
    let config = ConfigFile::new("nobody", &cell(any_port(), any_port()));
    for check in [&[][..], &["--check"]] {
        let Output { status, stderr, .. } = robocell(&config).args(check).output().unwrap();
        let said = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(2), "{said}");
        assert!(
            said.contains("[identity]") && said.contains("--demo"),
            "{said}"
        );
    }
    let both = format!(
        "[identity]\npath = \"t.json\"\n{}",
        cell(any_port(), any_port())
    );
    let said = complaint("both", &both);
    assert!(said.contains("exclude one another"), "{said}");
    let elsewhere = SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0));
    let said = complaint("remote-demo", &cell(elsewhere, any_port()));
    assert!(
        said.contains("server.listen") && said.contains("demo"),
        "{said}"
    );
}

/// O5, and the canary: no token comes into the log, however much is logged.
#[tokio::test]
async fn o5_the_first_start_shows_one_admin_token_and_nothing_shows_it_again() {
    let folder = tempfile::tempdir().unwrap();
    let tokens = folder.path().join("tokens.json");
    let text = format!(
        "[identity]\npath = \"{}\"\n{}",
        tokens.display(),
        cell(any_port(), any_port())
    );
    let config = ConfigFile::new("first-start", &text);
    let tracing = || {
        let mut command = robocell(&config);
        let _command = command.args(["--log", "trace"]);
        command
    };
    // A check makes nothing.
    let checked = robocell(&config).arg("--check").output().unwrap();
    assert!(checked.status.success() && !tokens.exists());

    let (mut running, said) = Running::of(tracing());
    let shown: Vec<_> = said
        .split_whitespace()
        .filter(|word| word.starts_with("cell_"))
        .collect();
    let [admin] = shown[..] else {
        panic!("{said}");
    };
    let secret = |text: &str| api::TokenSecret::new(text.to_owned());
    let anybody = Client::new(&running.http).unwrap();
    assert_eq!(anybody.cells().await.unwrap_err().status(), Some(401));
    let admins = anybody.with_token(&secret(admin)).unwrap();
    assert_eq!(admins.me().await.unwrap().roles, [api::Role::Admin]);
    assert_eq!(
        admins.legacy_home(None).await.unwrap_err().status(),
        Some(403)
    );
    let body = api::TokenBody {
        name: "alice".to_owned(),
        role: api::Role::Operator,
        scope: api::TokenScope::default(),
        expires_in_days: None,
    };
    let alice = admins.create_token(&body).await.unwrap().token;
    let alices = anybody.with_token(&alice).unwrap();
    let _moved = alices.legacy_home(None).await.unwrap();
    // The last digit is another one, whatever it was.
    let last = if admin.ends_with('f') { 'e' } else { 'f' };
    let forged = format!("{}{last}", &admin[..admin.len() - 1]);
    let forger = anybody.with_token(&secret(&forged)).unwrap();
    assert_eq!(forger.cells().await.unwrap_err().status(), Some(401));
    assert!(!format!("{admins:?}{alice:?}").contains(admin.rsplit('_').next().unwrap()));

    let mut errors = running.process.stderr.take().unwrap();
    running.process.kill().unwrap();
    let mut log = String::new();
    let _length = errors.read_to_string(&mut log).unwrap();
    assert!(
        log.contains("DEBUG") && log.contains("token.create"),
        "{log}"
    );
    let line = log
        .lines()
        .find(|line| line.contains("/fanuc/home") && line.contains("alice"));
    assert!(line.is_some(), "the log says who moved the robot: {log}");
    for token in [admin, alice.reveal(), &forged] {
        let secret = token.rsplit('_').next().unwrap();
        assert!(!log.contains(secret), "a secret is in the log");
    }
    drop(running);

    let (_running, said) = Running::of(tracing());
    assert!(!said.contains("cell_") && !said.contains("DEMO"), "{said}");
    let (_running, said) = {
        let mut command = tracing();
        let _command = command.arg("--new-admin-token");
        Running::of(command)
    };
    assert!(said.contains("cell_"), "{said}");
}

#[test]
fn a_demo_says_so_loudly() {
    let config = ConfigFile::new("loud", &cell(any_port(), any_port()));
    let (_running, said) = Running::of(demo(&config));
    assert!(
        said.contains("DEMO MODE: nobody is asked for a token."),
        "{said}"
    );
}
