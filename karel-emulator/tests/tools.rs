//! The tools for people who write KAREL: check, run until idle, and the commands for a controller that runs.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

const SERVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../programs/sock_server.kl");

/// Two tasks that move, compute and wait on each other's flags and an input.
const BUSY: &str = "PROGRAM busy
VAR
  p : XYZWPR
  n, status : INTEGER
BEGIN
  RUN_TASK('helper', 1, FALSE, FALSE, 1, status)
  p = CURPOS(0, 0)
  FOR n = 1 TO 6 DO
    p.z = p.z - 5
    MOVE TO p NOWAIT
    FLG[1] = ON
    DELAY 13
  ENDFOR
  WAIT FOR DIN[2] = ON
  WRITE ('done', CR)
END busy
";
const HELPER: &str = "PROGRAM helper
VAR n, k : INTEGER
BEGIN
  WAIT FOR FLG[1] = ON
  k = 0
  FOR n = 1 TO 20000 DO
    k = k + n MOD 7
  ENDFOR
  $MCR.$GENOVERRIDE = 40
  DELAY 70
  $MCR.$GENOVERRIDE = 90
  WRITE ('helped', CR)
END helper
";

fn tool(arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_karel-emulator"));
    let Output {
        status,
        stdout,
        stderr,
    } = command
        .args(arguments)
        .env_remove("KAREL_EMULATOR_PANEL")
        .output()
        .expect("the binary is built");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (status.code(), text(stdout), text(stderr))
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("it has one")).expect("it is writable");
            std::fs::write(path, text).expect("it is writable");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }
}

#[test]
fn check_tells_every_error_of_every_file_for_people_and_for_machines() {
    let folder = Folder::new(&[
        (
            "a.kl",
            "PROGRAM a\nVAR n : INTEGER\nBEGIN\n  x = 1\n  n = 'text'\nEND a\n",
        ),
        ("b.kl", "PROGRAM b\nBEGIN\n  no_such(1)\nEND b\n"),
        ("good.kl", "PROGRAM good\nBEGIN\nEND good\n"),
    ]);
    let (a, b, good) = (
        folder.path("a.kl"),
        folder.path("b.kl"),
        folder.path("good.kl"),
    );
    let (code, stdout, stderr) = tool(&["check", &a, &b, &good]);
    assert_eq!((code, stdout.as_str()), (Some(1), ""));
    assert_eq!(stderr.matches("error: ").count(), 3, "{stderr}");
    assert!(stderr.matches('^').count() >= 3, "{stderr}");
    let (code, stdout, stderr) = tool(&["check", "--json", &a, &b, &good]);
    assert_eq!((code, stderr.as_str()), (Some(1), ""));
    let found: Value = serde_json::from_str(&stdout).expect("one JSON document");
    assert_eq!(
        (&found["errors"], &found["warnings"]),
        (&3.into(), &0.into())
    );
    assert_eq!(found["files"][2]["program"], "GOOD");
    assert_eq!(found["files"][0]["program"], Value::Null);
    let first = &found["diagnostics"][0];
    assert_eq!(
        (&first["line"], &first["column"], &first["length"]),
        (&4.into(), &3.into(), &1.into())
    );
    assert_eq!(first["source_line"], "  x = 1");
    assert_eq!(tool(&["check", "--json", &good]).0, Some(0));
}

#[test]
fn check_looks_whether_programs_fit_together_and_into_more_folders() {
    let caller = "PROGRAM caller\n%INCLUDE shared\nROUTINE add(a, b : INTEGER) : INTEGER FROM lib\nVAR n : INTEGER\nBEGIN\n  n = add(one, 2)\nEND caller\n";
    let lib = "PROGRAM lib\nROUTINE add(a : REAL) : INTEGER\nBEGIN\n  RETURN (1)\nEND add\nBEGIN\nEND lib\n";
    let folder = Folder::new(&[
        ("caller.kl", caller),
        ("lib.kl", lib),
        ("headers/shared.kl", "CONST\n  one = 1\n"),
    ]);
    let (caller, lib, headers) = (
        folder.path("caller.kl"),
        folder.path("lib.kl"),
        folder.path("headers"),
    );
    let (code, _, stderr) = tool(&["check", &caller]);
    assert_eq!(code, Some(1));
    assert!(stderr.contains("no file shared"), "{stderr}");
    assert_eq!(
        tool(&["check", &caller, &lib, "--include", &headers]).0,
        Some(0)
    );
    let (code, _, stderr) = tool(&["check", "--together", &caller, &lib, "--include", &headers]);
    assert_eq!(code, Some(1));
    assert!(stderr.contains("ADD") && stderr.contains("LIB"), "{stderr}");
    let (code, _, stderr) = tool(&["check", "--together", &lib, &lib]);
    assert_eq!(code, Some(1));
    assert!(stderr.contains("loaded already"), "{stderr}");
}

#[test]
fn a_run_until_idle_prints_what_the_program_writes_and_says_how_it_ended() {
    let folder = Folder::new(&[
        (
            "good.kl",
            "PROGRAM good\nBEGIN\n  DELAY 100000\n  WRITE ('all ', 2 + 2, CR)\nEND good\n",
        ),
        (
            "bad.kl",
            "PROGRAM bad\nVAR n : INTEGER\nBEGIN\n  WRITE ('so far')\n  n = n + 1\nEND bad\n",
        ),
        (
            "endless.kl",
            "PROGRAM endless\nBEGIN\n  WHILE TRUE DO\n    DELAY 50\n  ENDWHILE\nEND endless\n",
        ),
        (
            "server.kl",
            "PROGRAM waits\nBEGIN\n  WAIT FOR DIN[1] = ON\nEND waits\n",
        ),
    ]);
    let (code, stdout, stderr) = tool(&["run", &folder.path("good.kl"), "--until-idle"]);
    assert_eq!(
        (code, stdout.as_str(), stderr.as_str()),
        (Some(0), "all  4\n", "task GOOD ended\n")
    );
    let (code, stdout, stderr) = tool(&[
        "run",
        &folder.path("bad.kl"),
        "--until-idle",
        "--log",
        "off",
    ]);
    assert_eq!((code, stdout.as_str()), (Some(1), "so far\n"));
    assert!(
        stderr.contains("task BAD was aborted: INTP-311 (BAD, 5)"),
        "{stderr}"
    );
    assert!(stderr.contains("alarm INTP-311"), "{stderr}");
    let (code, _, stderr) = tool(&[
        "run",
        &folder.path("endless.kl"),
        "--until-idle",
        "--limit",
        "5",
    ]);
    assert_eq!(code, Some(1));
    assert!(
        stderr.contains("at line") && stderr.contains("still running after 5 s"),
        "{stderr}"
    );
    let input = [
        "run",
        &folder.path("server.kl"),
        "--until-idle",
        "--limit",
        "5",
    ];
    assert_eq!(tool(&input).0, Some(1), "it looks for its input for ever");
    let (code, _, stderr) = tool(&[&input[..], &["--set", "DI[1]=ON"]].concat());
    assert_eq!(code, Some(0), "{stderr}");
}

#[test]
fn what_cannot_be_set_or_injected_at_the_start_is_named() {
    for (arguments, words) in [
        (&["--set", "R[999]=1"][..], &["R[999]"][..]),
        (&["--set", "DIN[1]=banana"], &["DIN[1]", "banana"]),
        (&["--set", "nonsense"], &["ITEM=VALUE"]),
        (&["--fault", "{\"fault\": \"explode\"}"], &["explode"]),
        (
            &[
                "--fault",
                "{\"fault\": {\"slow_override\": {\"percent\": 0}}}",
            ],
            &["slow_override", "1 to 100"],
        ),
        (&["--time-scale", "2000"], &["2000", "1000"]),
        (&["--limit", "-1"], &["limit", "-1"]),
        (&["--missing-option", "R632"], &["R632", "SOCK_SERVER"]),
    ] {
        let run = [
            "run",
            SERVER,
            "--panel",
            "off",
            "--until-idle",
            "--port-map",
            "59002=0",
        ];
        let (code, _, stderr) = tool(&[&run[..], arguments].concat());
        assert_eq!(code, Some(2), "{arguments:?}: {stderr}");
        for word in words {
            assert!(stderr.contains(word), "{word:?} in {stderr}");
        }
    }
}

/// Covers: K8, the same seed and inputs give the same ledger byte for byte.
#[test]
fn a_busy_program_of_two_tasks_leaves_the_same_ledger_and_trace_twice() {
    let folder = Folder::new(&[("busy.kl", BUSY), ("helper.kl", HELPER)]);
    let run = |name: &str, scale: &str| {
        let (ledger, trace) = (
            folder.path(&format!("{name}.ledger")),
            folder.path(&format!("{name}.trace")),
        );
        let (code, stdout, stderr) = tool(&[
            "run",
            &folder.path("busy.kl"),
            &folder.path("helper.kl"),
            "--until-idle",
            "--seed",
            "7",
            "--time-scale",
            scale,
            "--set",
            "DIN[2]=ON",
            "--fault",
            "{\"fault\": \"freeze\", \"for_ms\": 25}",
            "--ledger",
            &ledger,
            "--trace",
            &trace,
        ]);
        assert_eq!(code, Some(0), "{stderr}");
        let read = |path: &str| std::fs::read(PathBuf::from(path)).expect("it was written");
        (stdout, read(&ledger), read(&trace))
    };
    let first = run("first", "max");
    assert!(
        first.0.contains("helped") && first.0.contains("done"),
        "{}",
        first.0
    );
    assert_eq!(
        first
            .1
            .split(|b| *b == b'\n')
            .filter(|line| !line.is_empty())
            .count(),
        12,
        "six motions"
    );
    assert!(
        first.2.len() > 100_000,
        "the loop of the helper is in the trace"
    );
    assert!(run("second", "max") == first, "the same once more");
    let third = run("third", "500");
    assert!(
        third.1 == first.1 && third.2 == first.2,
        "however fast time goes"
    );
}

/// A controller in a process of its own, ended with the test.
struct Running {
    child: Child,
    panel: String,
}

impl Running {
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_karel-emulator"))
            .arg("run")
            .args(arguments)
            .args(["--panel", "127.0.0.1:0", "--log", "info"])
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary is built");
        let log = BufReader::new(child.stderr.take().expect("piped"));
        let mut lines = log.lines().map(|line| line.expect("readable"));
        let panel = lines
            .find_map(|line| {
                Some(
                    line.split_once("The panel is at http://")?
                        .1
                        .split('/')
                        .next()?
                        .to_owned(),
                )
            })
            .expect("it says where its panel is");
        // The rest of the log must be read, or it would wait for a reader.
        drop(std::thread::spawn(move || lines.for_each(drop)));
        Self { child, panel }
    }

    fn tool(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        tool(&[arguments, &["--panel", &self.panel]].concat())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _killed = self.child.kill();
        let _ended = self.child.wait();
    }
}

#[test]
fn a_running_controller_is_looked_at_changed_and_broken_from_the_command_line() {
    let folder = Folder::new(&[(
        "counter.kl",
        "PROGRAM counter\nVAR n : INTEGER\nBEGIN\n  n = 0\n  WHILE TRUE DO\n    n = n + 1\n    DELAY 40\n  ENDWHILE\nEND counter\n",
    )]);
    let source = folder.path("counter.kl");
    let running = Running::start(&[&source]);
    let (code, stdout, _) = running.tool(&["state"]);
    assert_eq!(code, Some(0));
    for word in ["AUTO", "J1", "POSE", "COUNTER", "ALARMS  0 active"] {
        assert!(stdout.contains(word), "{word} in {stdout}");
    }
    let (_, stdout, _) = running.tool(&["state", "--json"]);
    assert_eq!(
        serde_json::from_str::<Value>(&stdout).expect("JSON")["tasks"][0]["name"],
        "COUNTER"
    );
    let ok = |arguments: &[&str]| {
        let (code, stdout, stderr) = running.tool(arguments);
        assert_eq!(code, Some(0), "{arguments:?}: {stdout}{stderr}");
        stdout
    };
    let _time = ok(&["time", "pause"]);
    let _set = ok(&["set", "[COUNTER]N", "-500"]);
    assert_eq!(ok(&["get", "[COUNTER]n"]), "-500\n");
    assert_eq!(ok(&["get", "[COUNTER]"]), "N = -500\n");
    assert!(ok(&["time", "step", "1000"]).contains("stands still"));
    let n: i32 = ok(&["get", "[counter]n"]).trim().parse().expect("a number");
    assert!((-477..=-473).contains(&n), "{n}");
    let _set = ok(&["set", "DIN[4]", "ON", "--simulate"]);
    assert_eq!(ok(&["get", "DI[4]"]), "1\n");
    let _set = ok(&["set", "DIN[4]", "--end-simulation"]);
    let _set = ok(&["set", "R[3]", "2.5"]);
    assert_eq!(ok(&["get", "R[3]"]), "2.5\n");
    let _time = ok(&["time", "run"]);
    let traced = ok(&["trace", "--lines", "6", "--source", &source]);
    assert_eq!(traced.lines().count(), 6, "{traced}");
    assert!(
        traced.contains("COUNTER:6") && traced.contains("n = n + 1"),
        "{traced}"
    );
    assert_eq!(
        ok(&[
            "fault", "delay", "--ms", "50", "--port", "59002", "--times", "2"
        ]),
        "fault 1\n"
    );
    let _id = ok(&["fault", "servo-off"]);
    let list = ok(&["fault", "list"]);
    assert!(
        list.contains("2 times left") && list.contains("servo_off"),
        "{list}"
    );
    let watched = ok(&["watch", "--count", "1"]);
    assert!(
        watched.contains("SERVO OFF") && watched.contains("FAULTS"),
        "{watched}"
    );
    assert!(!watched.contains('\u{1b}'), "no terminal, no cursor");
    let (code, _, stderr) = running.tool(&["operator", "start"]);
    assert_eq!(code, Some(1));
    assert!(stderr.contains("RESET"), "{stderr}");
    let _cleared = ok(&["fault", "clear"]);
    assert!(ok(&["operator", "reset"]).contains("active_alarms 0"));
    assert!(ok(&["operator", "start"]).contains("mode AUTO"));
    let _off = ok(&["operator", "abort", "counter"]);
    for (arguments, words) in [
        (&["get", "R[999]"][..], "R[999]"),
        (&["set", "DOUT[1]", "7"], "0 or 1"),
        (&["fault", "split", "--bytes", "0"], "split.bytes is 0"),
        (&["fault", "clear", "77"], "no active fault 77"),
        (&["operator", "run", "nobody"], "nobody"),
        (&["time", "step", "5"], "pause it"),
    ] {
        let (code, _, stderr) = running.tool(arguments);
        assert_eq!(code, Some(1), "{arguments:?}: {stderr}");
        assert!(stderr.contains(words), "{words} in {stderr}");
    }
}

#[test]
fn nobody_there_is_exit_code_three_and_nonsense_is_two() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = free.local_addr().expect("it is bound").to_string();
    drop(free);
    for arguments in [
        &["state"][..],
        &["watch"],
        &["fault", "list"],
        &["get", "R[1]"],
    ] {
        let (code, _, stderr) = tool(&[arguments, &["--panel", &address]].concat());
        assert_eq!(code, Some(3), "{arguments:?}: {stderr}");
        assert!(stderr.contains(&address), "{stderr}");
    }
    for arguments in [
        &["fault", "delay"][..],
        &["operator", "mode", "T3"],
        &["state", "--panel", "x"],
        &["watch", "--interval-ms", "1"],
    ] {
        assert_eq!(tool(arguments).0, Some(2), "{arguments:?}");
    }
    assert!(Path::new(SERVER).exists());
}
