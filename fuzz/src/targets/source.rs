//! Any bytes as the source of a program: they are refused with reasons, or they run.

use karel::{Diagnostic, IncludeFiles, Program};
use karel_emulator::{Controller, ProgramSource};

use super::core::{check_bounds, config, ms};

/// Bytes as KAREL.
///
/// # Panics
/// If that finds something.
pub fn karel(source: &[u8]) {
    let _tree = karel::syntax_tree(source, "x.kl");
    exercise(source, "x.kl");
}

/// Bytes as a TP program.
///
/// # Panics
/// If that finds something.
pub fn listing(source: &[u8]) {
    exercise(source, "x.ls");
}

/// The file that sources may include.
const INCLUDED: &str = "CONST inc_const = 5\nVAR inc_var : INTEGER\n";

fn exercise(source: &[u8], name: &str) {
    let mut includes = IncludeFiles::default();
    includes.insert("inc.kl", INCLUDED);
    let unix: Vec<u8> = source.iter().copied().filter(|b| *b != b'\r').collect();
    let dos: Vec<u8> = unix
        .iter()
        .flat_map(|byte| match byte {
            b'\n' => vec![b'\r', b'\n'],
            other => vec![*other],
        })
        .collect();
    let found = outcome(Program::from_file(&unix, name, &includes));
    let with_cr = outcome(Program::from_file(&dos, name, &includes));
    // Where the source is no text at all, bytes are counted.
    if !found.contains(" at offset ") {
        assert_eq!(found, with_cr, "line ends change what is found");
    }
    let lines = source.split(|byte| *byte == b'\n').count();
    match Program::from_file(source, name, &includes) {
        Err(diagnostics) => check(&diagnostics, lines),
        Ok(program) => {
            check(program.warnings(), lines);
            run(source, name);
        }
    }
}

fn outcome(program: Result<Program, Vec<Diagnostic>>) -> String {
    match program {
        Ok(program) => karel::render(program.warnings()),
        Err(diagnostics) => {
            assert!(!diagnostics.is_empty(), "refused without a reason");
            karel::render(&diagnostics)
        }
    }
}

/// Messages point into the source and stay short.
fn check(diagnostics: &[Diagnostic], lines: usize) {
    assert!(diagnostics.len() <= 51, "{} messages", diagnostics.len());
    for diagnostic in diagnostics {
        assert!(!diagnostic.message.is_empty());
        assert!(diagnostic.line >= 1 && diagnostic.column >= 1);
        // What is included has lines of its own.
        let own = diagnostic.file.starts_with("x.");
        assert!(
            !own || diagnostic.line as usize <= lines,
            "{diagnostic}\n{lines} lines"
        );
        let text = diagnostic.to_string();
        assert!(text.len() < 2_000, "a long message: {text}");
    }
}

fn run(source: &[u8], name: &str) {
    let mut config = config().with_program(ProgramSource::new(name, source));
    config
        .includes
        .push(ProgramSource::new("inc.kl", INCLUDED.as_bytes()));
    // A program that wants a routine of another one loads, and one with a name that is taken does not.
    let Ok(mut core) = Controller::try_new(&config) else {
        return;
    };
    core.advance_fully(ms(50));
    let _effects = core.take_effects();
    core.advance_fully(ms(3_000));
    check_bounds(&core);
}
