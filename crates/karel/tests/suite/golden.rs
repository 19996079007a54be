//! Cases in `tests/cases`: a program `.kl` and what becomes of it, `.out`.
//!
//! A program that has errors gives its diagnostics; one whose first line is `-- golden: tree`
//! gives its tree; any other is run, and gives its warnings and its trace. Lines that start with
//! `-->` are the script: `connect`, `send TEXT` (`\n`, `\r` as such), `silence`, `close`, `fail-connect N`,
//! `fail-motion N`, `abort`, `pause`, `continue` by the operator; `load FILE` loads one more program before. Those, and files for `%INCLUDE`, are
//! in `tests/cases/more`. Every case gives the same with CRLF line ends. `UPDATE_GOLDEN=1` rewrites.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use karel::{IncludeFiles, Limits, Machine, Program};

use crate::host::{Event, ScriptedHost, run};

#[test]
fn golden_cases_give_what_they_gave() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    give_what_they_gave(&folder, "kl", outcome);
}

/// Compares what becomes of each case of a folder, with either line end, with the file `.out` beside it.
pub(crate) fn give_what_they_gave(
    folder: &Path,
    extension: &str,
    outcome: fn(&[u8], &str) -> String,
) {
    let mut cases: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    cases.retain(|path| path.extension().is_some_and(|found| found == extension));
    cases.sort();
    assert!(cases.len() >= 10, "the cases are missing");
    let update = std::env::var_os("UPDATE_GOLDEN").is_some();
    let mut differences = String::new();
    for path in cases {
        let source = fs::read(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let found = outcome(&source, &name);
        let crlf = outcome(&with_crlf(&source), &name);
        assert_eq!(crlf, found, "{name} with CRLF line ends");
        let golden = path.with_extension("out");
        if update {
            fs::write(&golden, &found).unwrap();
            continue;
        }
        let expected = String::from_utf8(fs::read(&golden).unwrap_or_default()).unwrap();
        if expected != found {
            let _ = writeln!(
                differences,
                "== {name}\n-- expected\n{expected}-- found\n{found}"
            );
        }
    }
    assert!(differences.is_empty(), "{differences}");
}

pub(crate) fn with_crlf(source: &[u8]) -> Vec<u8> {
    let mut converted = Vec::new();
    for byte in source {
        if *byte == b'\n' {
            converted.push(b'\r');
        }
        converted.push(*byte);
    }
    converted
}

fn outcome(source: &[u8], name: &str) -> String {
    if source.starts_with(b"-- golden: tree") {
        return match karel::syntax_tree(source, name) {
            Ok(tree) => tree,
            Err(diagnostics) => karel::render(&diagnostics) + "\n",
        };
    }
    let program = match Program::with_includes(source, name, &more()) {
        Ok(program) => program,
        Err(diagnostics) => return karel::render(&diagnostics) + "\n",
    };
    let mut out = String::new();
    if !program.warnings().is_empty() {
        out = karel::render(program.warnings()) + "\n\n";
    }
    let mut machine = Machine::new(Limits::default());
    let program_name = program.name().to_owned();
    machine.load(program).unwrap();
    for file in loads(source) {
        let text = fs::read(folder().join(&file)).unwrap();
        let program = Program::from_file(&text, &file, &more()).unwrap();
        if let Err(error) = machine.load(program) {
            return out + &error.to_string() + "\n";
        }
    }
    for routine in machine.unresolved() {
        let _ = writeln!(out, "unresolved: {routine}");
    }
    let task = machine.start(&program_name).unwrap();
    let mut host = ScriptedHost::new(script(source));
    run(&mut machine, task, &mut host);
    out + &host.trace
}

pub(crate) fn script(source: &[u8]) -> Vec<Event> {
    let text = String::from_utf8_lossy(source).replace('\r', "");
    text.lines()
        .filter_map(|line| line.strip_prefix("--> "))
        .filter(|line| !line.starts_with("load "))
        .map(event)
        .collect()
}

pub(crate) fn loads(source: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(source).replace('\r', "");
    let files = text
        .lines()
        .filter_map(|line| line.strip_prefix("--> load "));
    files.map(str::to_owned).collect()
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/more")
}

/// Every file of the folder, for `%INCLUDE`.
fn more() -> IncludeFiles {
    let mut files = IncludeFiles::default();
    for entry in fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        files.insert(&name, fs::read(&path).unwrap());
    }
    files
}

fn event(line: &str) -> Event {
    let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
    match word {
        "connect" => Event::Connect,
        "close" => Event::Close,
        "silence" => Event::Silence,
        "abort" => Event::Abort,
        "pause" => Event::Pause,
        "continue" => Event::Continue,
        "send" => Event::Send(bytes(rest)),
        "fail-connect" => Event::FailConnect(rest.parse().unwrap()),
        "fail-motion" => Event::FailMotion(rest.parse().unwrap()),
        _ => panic!("unknown script line {line:?}"),
    }
}

/// `\n`, `\r` and `\xNN` are single bytes.
fn bytes(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((byte, tail)) = rest.split_first() {
        let (value, used) = match (byte, tail) {
            (b'\\', [b'n', ..]) => (b'\n', 1),
            (b'\\', [b'r', ..]) => (b'\r', 1),
            (b'\\', [b'x', a, b, ..]) => {
                let digits = String::from_utf8(vec![*a, *b]).unwrap();
                (u8::from_str_radix(&digits, 16).unwrap(), 3)
            }
            _ => (*byte, 0),
        };
        bytes.push(value);
        rest = tail.get(used..).unwrap_or_default();
    }
    bytes
}
