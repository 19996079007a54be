//! Nothing that comes from outside makes the crate panic, hang or overflow its stack.

use std::fmt::Write as _;

use karel::{Limits, Machine, Program, Run, TaskState};
use proptest::prelude::*;

use crate::host::{Event, ScriptedHost, machine_with, run};

const PROGRAMS: [&[u8]; 5] = [
    include_bytes!("../../../../programs/sock_server.kl"),
    include_bytes!("../cases/arrays_and_structures.kl"),
    include_bytes!("../cases/control_flow.kl"),
    include_bytes!("../cases/strings.kl"),
    include_bytes!("../cases/positions_and_system_variables.kl"),
];

/// Translates, and runs what is legal for a while.
fn exercise(source: &[u8]) {
    let _ = karel::syntax_tree(source, "x.kl");
    let program = match Program::parse_and_check(source, "x.kl") {
        Ok(program) => program,
        Err(diagnostics) => {
            assert!(!diagnostics.is_empty(), "refused without a reason");
            let _ = karel::render(&diagnostics);
            return;
        }
    };
    let name = program.name().to_owned();
    let mut machine = Machine::new(Limits::default());
    machine.load(program).unwrap();
    let task = machine.start(&name).unwrap();
    let command = b"600000 200000 600000 -180000 30000 0 300 1".to_vec();
    let mut host = ScriptedHost::new(vec![Event::Connect, Event::Send(command), Event::Close]);
    for _ in 0..50 {
        let slice = machine.run(task, 500, &mut host);
        match slice.run {
            Run::OutOfFuel => {}
            Run::Blocked(wait) if host.satisfy(&wait) => {}
            Run::Blocked(_) | Run::Ended | Run::Aborted(_) => return,
        }
    }
}

/// A change of a program.
#[derive(Clone, Debug)]
enum Mutation {
    Delete {
        at: usize,
        count: usize,
    },
    Replace {
        at: usize,
        byte: u8,
    },
    /// Swaps two words, which often stays legal.
    SwapWords {
        a: usize,
        b: usize,
    },
    CopyWord {
        from: usize,
        to: usize,
    },
}

fn mutations() -> impl Strategy<Value = Vec<Mutation>> {
    let any = any::<usize>();
    let one = prop_oneof![
        (any, 0_usize..8).prop_map(|(at, count)| Mutation::Delete { at, count }),
        (any, proptest::char::range(' ', '~'))
            .prop_map(|(at, c)| Mutation::Replace { at, byte: c as u8 }),
        (any, any).prop_map(|(a, b)| Mutation::SwapWords { a, b }),
        (any, any).prop_map(|(from, to)| Mutation::CopyWord { from, to }),
    ];
    proptest::collection::vec(one, 1..4)
}

fn mutate(source: &[u8], mutation: &Mutation) -> Vec<u8> {
    let mut bytes = source.to_vec();
    let length = bytes.len().max(1);
    match mutation {
        Mutation::Delete { at, count } => {
            let start = (at % length).min(bytes.len());
            let end = (start + count).min(bytes.len());
            drop(bytes.drain(start..end));
        }
        Mutation::Replace { at, byte } => {
            if let Some(slot) = bytes.get_mut(at % length) {
                *slot = *byte;
            }
        }
        Mutation::SwapWords { a, b } => {
            return with_words(&bytes, |words, count| words.swap(a % count, b % count));
        }
        Mutation::CopyWord { from, to } => {
            return with_words(&bytes, |words, count| {
                if let Some(word) = words.get(from % count).cloned() {
                    drop(words.splice(to % count..=to % count, [word]));
                }
            });
        }
    }
    bytes
}

/// Changes the words of the lines that are not comments.
fn with_words(bytes: &[u8], change: impl FnOnce(&mut Vec<String>, usize)) -> Vec<u8> {
    let text: String = bytes.iter().map(|byte| char::from(*byte)).collect();
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("--"));
    let mut words: Vec<String> = lines
        .flat_map(|line| {
            line.split_inclusive(' ')
                .map(str::to_owned)
                .chain(["\n".to_owned()])
        })
        .collect();
    let count = words.len();
    if count > 0 {
        change(&mut words, count);
    }
    words
        .concat()
        .chars()
        .map(|c| u8::try_from(c).unwrap())
        .collect()
}

proptest! {
    /// Covers: K7.
    #[test]
    fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        exercise(&bytes);
    }

    #[test]
    fn arbitrary_words_never_panic(
        words in proptest::collection::vec(
            prop_oneof![
                "PROGRAM|BEGIN|END|IF|THEN|ELSE|ENDIF|WHILE|DO|ENDWHILE|FOR|TO|ENDFOR|SELECT|OF|CASE|ENDSELECT",
                "VAR|CONST|TYPE|ROUTINE|STRUCTURE|ENDSTRUCTURE|ARRAY|STRING|INTEGER|REAL|READ|WRITE|OPEN|FILE|MOVE",
                "[a-c]|x|1|2\\.5|'s'|=|<|\\+|-|\\*|/|\\(|\\)|\\[|\\]|,|:|::|;|\\.|&|%|--|\\$SPEED|\\$UTOOL",
                Just("\n".to_owned()),
            ],
            0..120,
        )
    ) {
        exercise(format!("PROGRAM x\nVAR a, b: INTEGER\nBEGIN\n{}\nEND x\n", words.join(" ")).as_bytes());
        exercise(words.join(" ").as_bytes());
    }

    #[test]
    fn mutated_programs_never_panic(which in 0..PROGRAMS.len(), mutations in mutations()) {
        let mut source = PROGRAMS[which].to_vec();
        for mutation in &mutations {
            source = mutate(&source, mutation);
        }
        exercise(&source);
    }
}

#[test]
fn every_prefix_of_a_program_is_handled() {
    let source = PROGRAMS[1];
    for length in 0..source.len() {
        exercise(&source[..length]);
    }
}

#[test]
fn types_within_types_and_huge_variables_are_refused() {
    let chain = (1..5_000).fold(String::new(), |text, n| {
        text + &format!("t{n} = ARRAY[1] OF t{}\n", n - 1)
    });
    let deep =
        format!("PROGRAM x\nTYPE\nt0 = ARRAY[1] OF INTEGER\n{chain}VAR v: t4999\nBEGIN\nEND x\n");
    let refused = Program::parse_and_check(deep.as_bytes(), "x.kl").unwrap_err();
    assert!(
        refused[0].message.contains("in each other"),
        "{}",
        refused[0]
    );
    let huge = b"PROGRAM x\nVAR v: ARRAY[1000, 1000, 1000] OF STRING[254]\nBEGIN\nEND x\n";
    let refused = Program::parse_and_check(huge, "x.kl").unwrap_err();
    assert!(
        refused[0].message.contains("cells of memory"),
        "{}",
        refused[0]
    );
}

/// Covers: K5.
#[test]
fn a_value_too_large_for_a_task_is_refused_when_it_is_needed() {
    let source = "PROGRAM x\nTYPE big = STRUCTURE\na: ARRAY[1000000] OF INTEGER\nENDSTRUCTURE\nVAR n: big\nROUTINE f: big\nBEGIN\nEND f\nBEGIN\nn = f\nEND x\n";
    let program = Program::parse_and_check(source.as_bytes(), "x.kl").unwrap();
    let mut machine = Machine::new(Limits::default());
    machine.load(program).unwrap();
    let refused = machine.start("x").unwrap_err().to_string();
    assert_eq!(
        refused,
        "the main body needs 1000000 cells of memory, a task may have 262144"
    );
}

#[test]
fn tasks_can_move_between_threads() {
    fn assert_send<T: Send>() {}
    assert_send::<Machine>();
    assert_send::<Program>();
}

#[test]
fn the_deepest_legal_nesting_translates_and_runs() {
    let open = "IF TRUE THEN\n".repeat(95);
    let close = "ENDIF\n".repeat(95);
    let parens = format!("{}1{}", "(".repeat(95), ")".repeat(95));
    let sum = format!("1{}", " + 1".repeat(190));
    exercise(format!("PROGRAM x\nBEGIN\n{open}{close}WRITE ({parens}, {sum})\nEND x\n").as_bytes());
}

/// A main body around `statements`.
fn main_body(statements: &str) -> String {
    format!("PROGRAM x\nVAR i: INTEGER\n b: BOOLEAN\nBEGIN\n i = 1\n{statements}\nEND x\n")
}

/// Covers: K7.
#[test]
fn ten_thousand_levels_of_anything_are_an_error_and_not_a_stack_overflow() {
    let many = |text: &str| text.repeat(10_000);
    for statements in [
        format!("i = {}1{}", many("("), many(")")),
        format!("i = {}", many("(")),
        format!("i = {}1", many("- ")),
        format!("i = {}1", many("1 + ")),
        format!("b = {}TRUE", many("NOT ")),
        format!("i = a{}1{}", many("["), many("]")),
        format!("i = a{}", many(".x")),
        format!("{}{}", many("IF b THEN\n"), many("ENDIF\n")),
        many("IF b THEN\n"),
        format!("{}{}", many("WHILE b DO\n"), many("ENDWHILE\n")),
        format!("{}{}", many("FOR i = 1 TO 2 DO\n"), many("ENDFOR\n")),
        format!("{}{}", many("REPEAT\n"), many("UNTIL b\n")),
        format!("{}{}", many("SELECT i OF\nCASE(1):\n"), many("ENDSELECT\n")),
    ] {
        let source = main_body(&statements);
        let refused = Program::parse_and_check(source.as_bytes(), "x.kl");
        assert!(refused.is_err(), "{}", &statements[..40]);
    }
}

/// Covers: K7.
#[test]
fn a_megabyte_of_anything_is_handled_and_its_messages_stay_short() {
    let size = 1 << 20;
    let long_name = format!("PROGRAM {}\nBEGIN\nEND x\n", "a".repeat(size - 100));
    let long_text = main_body(&format!("WRITE ('{}')", "x".repeat(size - 200)));
    for source in [
        vec![0; size],
        vec![0xFF; size],
        vec![b'\''; size],
        vec![b'('; size],
        vec![b'9'; size],
        "i = = 1\n".repeat(size / 8).into_bytes(),
        long_name.into_bytes(),
        long_text.into_bytes(),
    ] {
        let diagnostics = Program::parse_and_check(&source, "x.kl").unwrap_err();
        let shown = karel::render(&diagnostics);
        assert!(shown.len() < 64 * 1024, "{} bytes of messages", shown.len());
    }
    let longest = main_body(&"i = i + 1\n".repeat((size - 200) / 10));
    assert!(Program::parse_and_check(longest.as_bytes(), "x.kl").is_ok());
}

#[test]
fn a_nul_byte_is_not_source_text() {
    let source = main_body("i = \0 2");
    let refused = Program::parse_and_check(source.as_bytes(), "x.kl").unwrap_err();
    assert!(refused[0].message.contains("0x00"), "{}", refused[0]);
}

#[test]
fn files_of_a_controller_that_are_no_source_say_what_to_load_instead() {
    let files = karel::IncludeFiles::default();
    for (name, what, help) in [
        ("a/main.pc", "a translated KAREL program (.pc)", "`.kl`"),
        ("MAIN.TP", "own form (.tp)", "`.ls`"),
        ("numreg.vr", "own form (.vr)", "--set"),
        ("main.va", "a listing of variables (.va)", "--set"),
        ("backup.sv", "own form (.sv)", "--set"),
        ("eng.tx", "a translated dictionary (.tx)", "`.utx`"),
    ] {
        let refused = Program::from_file(b"\x00\x01PROGRAM", name, &files).unwrap_err();
        assert_eq!(refused.len(), 1, "{refused:?}");
        assert!(refused[0].message.contains(what), "{}", refused[0]);
        let shown = refused[0].help.as_deref().unwrap_or_default();
        assert!(shown.contains(help), "{}", refused[0]);
    }
}

#[test]
fn a_million_lines_are_counted() {
    let mut source = b"PROGRAM lines\nVAR n: INTEGER\nBEGIN\n".to_vec();
    source.extend(std::iter::repeat_n(b'\n', 1_000_000));
    source.extend(b"n = n + 1\nEND lines\n");
    let (mut machine, task) = machine_with(&source, "lines.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    assert!(
        host.trace.starts_with("aborted: INTP-311 (LINES, 1000004)"),
        "{}",
        host.trace
    );
    source.extend(vec![b'\n'; 100_000]);
    let refused = Program::parse_and_check(&source, "lines.kl").unwrap_err();
    assert_eq!(refused.len(), 1);
    assert!(refused[0].message.contains("at most 1048576"));
}

/// Found by the fuzzer: what is missing at the end of a line was one column further with CR LF.
#[test]
fn columns_do_not_depend_on_the_line_ends() {
    let found = |source: &str, name: &str| {
        let includes = karel::IncludeFiles::default();
        let result = Program::from_file(source.as_bytes(), name, &includes);
        let diagnostics = result.unwrap_err();
        (diagnostics[0].line, diagnostics[0].column)
    };
    let sources = [
        ("PROGRAM x\nVAR\n  a\nBEGIN\nEND x\n", "x.kl", (3, 4)),
        ("/PROG X\n/MN\n   1:  R[1]=1 ;\n/POS\n", "x.ls", (4, 5)),
    ];
    for (source, name, place) in sources {
        assert_eq!(found(source, name), place);
        assert_eq!(found(&source.replace('\n', "\r\n"), name), place);
    }
}

#[test]
fn bytes_above_ascii_are_latin_1_in_texts_and_comments() {
    let source = b"PROGRAM t -- gr\xfc\xdfe\nBEGIN\nWRITE ('\xe9', ORD('\xff', 1))\nEND t\n";
    let (mut machine, task) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    assert_eq!(host.trace, "display \"\u{e9} 255\"\nend\n");
}

#[test]
fn handlers_that_always_act_leave_the_program_its_turn() {
    let source = "PROGRAM t\nVAR n, hits: INTEGER\nBEGIN\nhits = 0\nCONDITION[1]:\nWHEN hits >= 0 DO\n\
                  hits = hits + 1\nENABLE CONDITION[1]\nENDCONDITION\nENABLE CONDITION[1]\n\
                  FOR n = 1 TO 100 DO\nDELAY 1\nENDFOR\nWRITE (hits)\nEND t\n";
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    // Every 32 ms, the first at once.
    assert_eq!(host.trace, "display \" 4\"\nend\n");
}

#[test]
fn thousands_of_conditions_cost_fuel_and_end() {
    let mut source = "PROGRAM t\nVAR n: INTEGER\nBEGIN\nn = 0\n".to_owned();
    for number in 1..=1000 {
        let _ = write!(
            source,
            "CONDITION[{number}]:\nWHEN n > {number} DO\nn = 0\nENDCONDITION\nENABLE CONDITION[{number}]\n"
        );
    }
    source += "CONDITION[1001]:\nENDCONDITION\nEND t\n";
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    assert!(host.trace.contains("INTP-322"), "{}", host.trace);
    assert!(host.trace.contains("CONDITION[1001]"), "{}", host.trace);
}

#[test]
fn a_task_that_signals_itself_for_ever_spends_only_its_own_fuel() {
    let source = "PROGRAM t\nBEGIN\nCONDITION[1]:\nWHEN EVENT[1] DO\nENABLE CONDITION[1]\n\
                  SIGNAL EVENT[1]\nENDCONDITION\nENABLE CONDITION[1]\nSIGNAL EVENT[1]\nEND t\n";
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    for _ in 0..100 {
        let slice = machine.run(task, 1_000, &mut host);
        assert!(slice.used <= 1_000);
    }
}

#[test]
fn tasks_that_died_in_a_routine_give_back_its_paths() {
    // Each run leaves 1000 PATHs behind, the machine has 10,000 of routines.
    let source = b"PROGRAM t
VAR
  n : INTEGER
ROUTINE r
VAR
  many : ARRAY[1000] OF PATH NODEDATA = INTEGER
  status : INTEGER
BEGIN
  APPEND_NODE(many[1000], status)
  n = n DIV 0
END r
BEGIN
  n = 1
  r
END t
";
    let program = Program::parse_and_check(source, "t.kl").unwrap();
    let mut machine = Machine::new(Limits::default());
    machine.load(program).unwrap();
    for _ in 0..30 {
        let task = machine.start("t").unwrap();
        let mut host = ScriptedHost::new(Vec::new());
        run(&mut machine, task, &mut host);
        let TaskState::Aborted(error) = &machine.task(task).unwrap().state else {
            panic!("it divides by zero")
        };
        assert_eq!(error.status, karel::Status(12_307), "{error}");
    }
}

/// Found by the fuzzer: the lines of a saved file were in another order each time.
#[test]
fn variables_are_saved_in_the_same_order_each_time() {
    let source = b"PROGRAM t
VAR
  zulu, alpha, kilo, mike, beta : PATH NODEDATA = INTEGER
  status : INTEGER
BEGIN
  SAVE('T', 'FR:T.VR', status)
END t
";
    let saved = || {
        let (mut machine, task) = machine_with(source, "t.kl");
        let mut host = ScriptedHost::new(Vec::new());
        run(&mut machine, task, &mut host);
        host.file("FR:T.VR")
    };
    let first = saved();
    assert!(
        first.starts_with(b"-- variables of T\r\n[T]ALPHA nodes 0"),
        "{first:?}"
    );
    assert_eq!(first, saved());
}
