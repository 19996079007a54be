//! The binary: what it prints and what it exits with.

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Output, Stdio};

const SERVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../programs/sock_server.kl");

fn emulator(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_karel-emulator"));
    let _command = command.args(arguments);
    command
}

fn run(arguments: &[&str]) -> (Option<i32>, String) {
    let Output { status, stderr, .. } = emulator(arguments).output().expect("the binary is built");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

fn source(text: &str) -> tempfile::NamedTempFile {
    let file = tempfile::Builder::new()
        .suffix(".kl")
        .tempfile()
        .expect("a temporary file");
    std::fs::write(file.path(), text).expect("a temporary file is writable");
    file
}

#[test]
fn check_counts_what_it_finds_and_points_at_an_error() {
    let said = |text: &str| text.lines().last().map(ToOwned::to_owned);
    let (code, text) = run(&["check", SERVER]);
    assert_eq!(
        (code, text.as_str()),
        (Some(0), "1 file, 0 errors, 0 warnings\n")
    );
    let bad = source("PROGRAM a\nBEGIN\n  x = = 1\nEND a\n");
    let (code, text) = run(&["check", bad.path().to_str().unwrap()]);
    assert_eq!(code, Some(1));
    assert!(text.contains(":3:") && text.contains('^'), "{text}");
    let (code, text) = run(&["check", SERVER, bad.path().to_str().unwrap()]);
    assert_eq!(code, Some(1));
    assert_eq!(
        said(&text).unwrap(),
        "2 files, 1 error, 0 warnings",
        "{text}"
    );
}

#[test]
fn check_reads_listings_of_tp_programs_and_all_that_is_shipped_is_good() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../programs");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the programs are there")
        .map(|entry| entry.expect("it can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == "kl" || e == "ls"))
        .map(|path| path.display().to_string())
        .collect();
    files.sort();
    assert_eq!(files.len(), 12);
    let mut arguments = vec!["check"];
    arguments.extend(files.iter().map(String::as_str));
    let summary = "12 files, 0 errors, 0 warnings\n".to_owned();
    assert_eq!(run(&arguments), (Some(0), summary));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bad = folder.path().join("bad.LS");
    let text = "/PROG BAD\n/ATTR\n/MN\n   1:  JMP LBL[3] ;\n   2:  RSR[1]=MAYBE ;\n/POS\n/END\n";
    std::fs::write(&bad, text).expect("it is writable");
    let (code, text) = run(&["check", &bad.display().to_string()]);
    assert_eq!(code, Some(1));
    assert!(
        text.contains("expected ENABLE or DISABLE") && text.contains(":5:"),
        "{text}"
    );
}

#[test]
fn included_files_are_found_from_the_folder_of_the_program_whatever_their_case() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("it is writable");
    };
    std::fs::create_dir(folder.path().join("Include")).expect("it is writable");
    write("Include/Shared_H.KL", "CONST\n  answer = 42\n");
    write("Include/shared.kl", "%INCLUDE include\\shared_h\n");
    let program = "PROGRAM a\n%INCLUDE include\\shared\nBEGIN\n  WRITE (answer)\nEND a\n";
    write("a.kl", program);
    write("b.kl", "PROGRAM b\n%INCLUDE ..\\none\nBEGIN\nEND b\n");
    let path = |name: &str| folder.path().join(name).display().to_string();
    assert_eq!(
        run(&["check", &path("a.kl")]),
        (Some(0), "1 file, 0 errors, 0 warnings\n".to_owned())
    );
    let (code, text) = run(&["check", &path("b.kl")]);
    assert_eq!(code, Some(1));
    assert!(
        text.contains("there is no file ..\\none to include"),
        "{text}"
    );
}

#[test]
fn what_cannot_run_is_one_sentence_and_exit_code_two() {
    let not_karel = source("print('hello')\n");
    let not_karel = not_karel.path().to_str().unwrap();
    for (arguments, words) in [
        (
            &["run", "/no/such/file.kl"][..],
            &["reading /no/such/file.kl"][..],
        ),
        (
            &["check", "/no/such/file.kl"],
            &["reading /no/such/file.kl"],
        ),
        (
            &["run", not_karel, "--panel", "off"],
            &["does not start", "not a correct KAREL program"],
        ),
        (&["run", SERVER, "--port-map", "59002"], &["PORT=HOST"]),
        (&["run", SERVER, "--panel", "nowhere"], &["panel's address"]),
        (
            &["run", SERVER, "--panel", "0.0.0.0:0"],
            &["not a loopback address"],
        ),
        (
            &["run", SERVER, "--panel", "off", "--ip", "0.0.0.0"],
            &["not a loopback address"],
        ),
        (
            &["run", SERVER, "--panel", "off", "--home", "0,0,0,0,0"],
            &["six joints"],
        ),
        (
            &["run", SERVER, "--panel", "off", "--home", "0,0,0,0,-150,0"],
            &["J5", "140"],
        ),
        (
            &["run", SERVER, "--panel", "off", "--model", "puma"],
            &["puma", "fanuc-m20ia"],
        ),
        (
            &["run", SERVER, "--panel", "off", "--time-scale", "0"],
            &["time scale"],
        ),
        (
            &["run", SERVER, "--panel", "off", "--program", "nosuch"],
            &["nosuch"],
        ),
        (&["run"], &["<FILE>"]),
    ] {
        let (code, text) = run(arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {text}");
        for word in words {
            assert!(
                text.contains(word),
                "{word:?} for {arguments:?} in {text:?}"
            );
        }
    }
}

#[test]
fn a_port_in_use_is_one_sentence_that_names_the_port() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("it is bound").port().to_string();
    let map = format!("59002={port}");
    let panel = format!("127.0.0.1:{port}");
    for arguments in [
        &["run", SERVER, "--panel", "off", "--port-map", &map][..],
        &["run", SERVER, "--port-map", "59002=0", "--panel", &panel],
    ] {
        let (code, text) = run(arguments);
        assert_eq!(code, Some(2), "{text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
        assert!(text.contains(&port) && text.contains("in use"), "{text}");
    }
}

#[test]
fn a_port_in_use_that_only_the_program_names_ends_the_run_with_one_sentence() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("it is bound").port().to_string();
    let program = std::fs::read_to_string(SERVER).expect("it is in the repository");
    let program = source(&program.replace("listen_port = 59002", &format!("listen_port = {port}")));
    let path = program.path().to_str().expect("a plain path");
    let (code, text) = run(&["run", path, "--panel", "off", "--log", "error"]);
    assert_eq!(code, Some(2), "{text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{text}");
    assert!(text.contains(&port) && text.contains("in use"), "{text}");
}

#[test]
fn run_serves_until_it_is_terminated() {
    let mut child = emulator(&[
        "run",
        SERVER,
        "--port-map",
        "59002=0",
        "--panel",
        "127.0.0.1:0",
    ])
    .env_remove("NO_COLOR")
    .stderr(Stdio::piped())
    .spawn()
    .expect("the binary is built");
    let mut log = BufReader::new(child.stderr.take().expect("piped"));
    let (mut line, mut seen) = (String::new(), String::new());
    while !line.contains("is open at") {
        line.clear();
        let count = log.read_line(&mut line).expect("readable");
        assert_ne!(count, 0, "it ended early: {seen}");
        seen.push_str(&line);
    }
    let kill = format!("kill -TERM {}", child.id());
    assert!(
        Command::new("sh")
            .args(["-c", &kill])
            .status()
            .expect("a shell")
            .success()
    );
    let _rest = log.read_to_string(&mut seen).expect("readable");
    let status = child.wait().expect("it ends");
    assert!(status.success(), "{status}: {seen}");
    assert!(seen.contains("The controller is off"), "{seen}");
    assert!(!seen.contains('\x1b'), "colors are for terminals: {seen}");
}
