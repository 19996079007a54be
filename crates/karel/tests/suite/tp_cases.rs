//! Cases in `tests/cases/tp`: a listing `.ls` and what becomes of it, `.out`, as in `golden`.
//!
//! The script stands behind `/END`, where a controller reads no more. The trace ends with the registers that have a
//! value. Files that `--> load` names are in `tests/cases/tp/more`. `UPDATE_GOLDEN=1` rewrites.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use karel::{IncludeFiles, Limits, Machine, Number, Position, PositionRegister, Program, Value};

use crate::{
    golden::{loads, script, with_crlf},
    host::{ScriptedHost, run},
};

#[test]
fn listings_do_what_they_did() {
    let mut cases: Vec<PathBuf> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    cases.retain(|path| path.extension().is_some_and(|extension| extension == "ls"));
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

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/tp")
}

fn outcome(source: &[u8], name: &str) -> String {
    let program = match Program::parse_listing(source, name) {
        Ok(program) => program,
        Err(diagnostics) => return karel::render(&diagnostics) + "\n",
    };
    let mut machine = Machine::new(Limits::default());
    let root = program.name().to_owned();
    machine.load(program).unwrap();
    for file in loads(source) {
        let text = fs::read(folder().join("more").join(&file)).unwrap();
        let program = Program::from_file(&text, &file, &IncludeFiles::default()).unwrap();
        machine.load(program).unwrap();
    }
    let task = machine.start(&root).unwrap();
    let mut host = ScriptedHost::new(script(source));
    host.variables.extend(
        [
            ("$MNUFRAMENUM[1]", Value::Integer(0)),
            ("$MNUTOOLNUM[1]", Value::Integer(1)),
            ("$MNUFRAME[1,2]", Value::Position(Position::default())),
            ("$MNUTOOL[1,1]", Value::Position(Position::default())),
        ]
        .map(|(name, value)| (name.to_owned(), value)),
    );
    run(&mut machine, task, &mut host);
    let mut out = host.trace;
    let registers = machine.registers();
    for n in 1..=99 {
        match registers.number(n).unwrap() {
            Number::Integer(0) => {}
            Number::Integer(value) => writeln!(out, "R[{n}] = {value}").unwrap(),
            Number::Real(value) => writeln!(out, "R[{n}] = {value:?}").unwrap(),
        }
        match registers.position(n).unwrap() {
            PositionRegister::Unset => {}
            PositionRegister::Cartesian(p) => {
                let place = [p.x, p.y, p.z, p.w, p.p, p.r];
                writeln!(out, "PR[{n}] = {place:?} {}", p.config).unwrap();
            }
            PositionRegister::Joints(joints) => {
                writeln!(out, "PR[{n}] = {:?}", joints.axes).unwrap();
            }
        }
    }
    for n in 1..=25 {
        let text = registers.string(n).unwrap();
        if !text.is_empty() {
            writeln!(out, "SR[{n}] = {text}").unwrap();
        }
    }
    out
}
