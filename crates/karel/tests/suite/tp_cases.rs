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
    golden::{give_what_they_gave, loads, script},
    host::{ScriptedHost, run},
};

#[test]
fn listings_do_what_they_did() {
    give_what_they_gave(&folder(), "ls", outcome);
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/tp")
}

fn outcome(source: &[u8], name: &str) -> String {
    let program = match Program::parse_listing(source, name) {
        Ok(program) => program,
        Err(diagnostics) => return karel::render(&diagnostics) + "\n",
    };
    let mut out = String::new();
    if !program.warnings().is_empty() {
        out = karel::render(program.warnings()) + "\n\n";
    }
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
    out += &host.trace;
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
