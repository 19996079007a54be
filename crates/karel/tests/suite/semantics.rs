//! Rules of the language, one test each. Tests whose name starts with `assumed` hold rules that are
//! not documented for certain; whoever learns better changes the one function behind it.

use karel::{Limits, Machine, Program, Run, Status, SysPath, Value, Wait};

use crate::host::{Event, ScriptedHost, machine_with, run};

/// Runs a program with these declarations and statements and returns its trace.
fn trace(declarations: &str, statements: &str) -> String {
    trace_with(declarations, statements, Vec::new())
}

fn trace_with(declarations: &str, statements: &str, script: Vec<Event>) -> String {
    let source = format!("PROGRAM t\n{declarations}\nBEGIN\n{statements}\nEND t\n");
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(script);
    run(&mut machine, task, &mut host);
    host.trace
}

/// What a program shows on the pendant.
fn shown(declarations: &str, statements: &str) -> String {
    let trace = trace(declarations, statements);
    let lines = trace
        .lines()
        .filter_map(|line| line.strip_prefix("display \""));
    lines.map(|line| line.trim_end_matches('"')).collect()
}

#[test]
fn assumed_precedence_is_pascals() {
    assert_eq!(shown("", "WRITE (2 + 3 * 4)"), " 14");
    assert_eq!(
        shown("", "WRITE (-7 MOD 4)"),
        "-3",
        "the sign covers the whole term"
    );
    assert_eq!(
        shown("", "WRITE (NOT FALSE AND FALSE)"),
        "FALSE",
        "NOT binds tightest"
    );
    assert_eq!(
        shown("", "WRITE (1 + 1 = 2)"),
        "TRUE",
        "relations bind loosest"
    );
    assert_eq!(shown("", "WRITE (FALSE AND FALSE OR TRUE)"), "TRUE");
}

#[test]
fn integer_divided_by_integer_is_a_real() {
    assert_eq!(
        shown("VAR x: INTEGER", "x = 600001\nWRITE (x / 1000::9::3)"),
        "  600.001"
    );
}

/// Covers: K3.
#[test]
fn and_and_or_evaluate_both_sides() {
    let trace = trace("VAR a: BOOLEAN", "WRITE (FALSE AND a)");
    assert!(trace.contains("INTP-311 (T, 4)"), "{trace}");
}

#[test]
fn an_uninitialized_argument_can_be_passed_and_tested() {
    let routine = "VAR x: INTEGER\nROUTINE r(a: INTEGER)\nBEGIN\nWRITE (UNINIT(a))\nEND r";
    assert_eq!(shown(routine, "r(x)"), "TRUE");
}

#[test]
fn a_parenthesized_argument_is_a_copy_and_is_read() {
    let routine = "VAR x: INTEGER\nROUTINE r(a: INTEGER)\nBEGIN\na = 2\nEND r";
    assert_eq!(
        shown(routine, "x = 1\nr((x))\nWRITE (x)\nr(x)\nWRITE (x)"),
        " 1 2"
    );
    assert!(trace(routine, "r((x))").contains("INTP-311"));
}

#[test]
fn an_integer_for_a_real_parameter_is_a_copy() {
    let routine = "VAR x: INTEGER\nROUTINE r(a: REAL)\nBEGIN\na = a / 2\nEND r";
    assert_eq!(shown(routine, "x = 7\nr(x)\nWRITE (x)"), " 7");
}

#[test]
fn a_routine_declared_with_from_has_its_body_later() {
    let text = "ROUTINE twice(n: INTEGER): INTEGER FROM t\nROUTINE twice\nBEGIN\nRETURN (2 * n)\nEND twice";
    assert_eq!(shown(text, "WRITE (twice(21))"), " 42");
}

#[test]
fn locals_hide_globals_and_start_uninitialized_at_each_call() {
    let text = "VAR n: INTEGER\nROUTINE r\nVAR n: INTEGER\nBEGIN\nWRITE (UNINIT(n))\nn = 5\nEND r";
    assert_eq!(shown(text, "n = 1\nr\nr\nWRITE (n)"), "TRUETRUE 1");
}

#[test]
fn recursion_has_its_own_locals() {
    let text = "ROUTINE down(n: INTEGER)\nVAR m: INTEGER\nBEGIN\nm = n\nIF n > 0 THEN\ndown(n - 1)\nENDIF\nWRITE (m)\nEND down";
    assert_eq!(shown(text, "down(2)"), " 0 1 2");
}

#[test]
fn assumed_whole_arrays_are_copied_with_their_uninitialized_elements() {
    let text = "VAR a, b: ARRAY[2] OF INTEGER";
    assert_eq!(
        shown(
            text,
            "b[1] = 4\na[2] = 3\nb = a\nWRITE (UNINIT(b[1]), b[2])"
        ),
        "TRUE 3"
    );
}

#[test]
fn assumed_arrays_count_as_uninitialized_while_all_of_them_is() {
    let text = "VAR a: ARRAY[2] OF INTEGER";
    assert_eq!(
        shown(text, "WRITE (UNINIT(a))\na[2] = 3\nWRITE (UNINIT(a))"),
        "TRUEFALSE"
    );
}

#[test]
fn a_position_built_from_six_components_has_a_default_configuration() {
    let text = "VAR e: XYZWPREXT\np: POSITION";
    let fill = "e.x = 1\ne.y = 2\ne.z = 3\ne.w = 4\ne.p = 5\n";
    let whole = trace(text, &format!("{fill}e.r = 6\np = e\n$UTOOL = p"));
    assert!(
        whole.contains("set $UTOOL = (1 2 3 4 5 6 'N U T, 0, 0, 0')"),
        "{whole}"
    );
    assert!(trace(text, &format!("{fill}p = e")).contains("INTP-311 (T, 10)"));
}

#[test]
fn assumed_the_counter_of_a_for_ends_one_beyond_its_limit() {
    assert_eq!(
        shown("VAR i: INTEGER", "FOR i = 1 TO 3 DO\nENDFOR\nWRITE (i)"),
        " 4"
    );
}

#[test]
fn assumed_halves_round_away_from_zero() {
    assert_eq!(
        shown("", "WRITE (ROUND(2.5), ROUND(-2.5), ROUND(0.49))"),
        " 3-3 0"
    );
}

#[test]
fn assumed_a_bad_substring_is_a_bad_argument() {
    assert!(trace("VAR s: STRING[5]", "s = SUB_STR('abc', 0, 1)").contains("INTP-322 (T, 4)"));
    assert!(trace("VAR s: STRING[5]", "s = SUB_STR('abc', 1, -1)").contains("INTP-322 (T, 4)"));
}

#[test]
fn assumed_an_empty_string_is_nowhere() {
    assert_eq!(shown("", "WRITE (INDEX('abc', ''))"), " 0");
}

#[test]
fn assumed_negative_decimals_mean_scientific_notation() {
    assert_eq!(
        shown(
            "VAR s: STRING[20]",
            "CNV_REAL_STR(1.5, 3, -1, s)\nWRITE (s)"
        ),
        " 1.500000E+00"
    );
}

#[test]
fn assumed_cr_writes_carriage_return_and_line_feed() {
    assert!(trace("", "WRITE ('a', CR)").contains(r#"display "a\r\n""#));
}

/// Covers: K5.
#[test]
fn assumed_division_by_zero_is_intp_307() {
    for division in ["1 / 0", "1 DIV 0", "1 MOD 0", "1.5 / 0.0"] {
        assert!(
            trace("", &format!("WRITE ({division})")).contains("INTP-307 (T, 4)"),
            "{division}"
        );
    }
}

#[test]
fn assumed_a_function_without_return_is_intp_321() {
    let text = "ROUTINE f: INTEGER\nBEGIN\nIF FALSE THEN\nRETURN (1)\nENDIF\nEND f";
    assert!(trace(text, "WRITE (f)").contains("INTP-321 (T, 7)"));
}

#[test]
fn assumed_statements_of_predefined_constants_have_their_numbers() {
    assert_eq!(
        shown(
            "",
            "WRITE (FINE, NODECEL, VARDECEL, JOINT, LINEAR, CIRCULAR)"
        ),
        " 1 4 5 6 7 8"
    );
}

/// Covers: K2.
#[test]
fn assumed_a_failed_connect_rests_a_millisecond() {
    let source = b"PROGRAM t\nVAR s: INTEGER\nBEGIN\nMSG_CONNECT('S3:', s)\nWRITE (s)\nEND t\n";
    let (mut machine, task) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(vec![Event::FailConnect(67_144)]);
    assert!(
        matches!(machine.run(task, 100, &mut host).run, Run::Blocked(Wait::Connect(tag)) if tag == "S3")
    );
    assert!(host.satisfy(&Wait::Connect("S3".to_owned())));
    let rests = machine.run(task, 100, &mut host).run;
    assert!(
        matches!(&rests, Run::Blocked(Wait::Until(until)) if until.as_millis() == 1),
        "{rests:?}"
    );
    run(&mut machine, task, &mut host);
    assert!(
        host.trace.ends_with("display \" 67144\"\nend\n"),
        "{}",
        host.trace
    );
}

#[test]
fn one_write_is_one_segment_whatever_it_has_of_items() {
    let text = "VAR f: FILE\ns: INTEGER";
    let statements =
        "MSG_CONNECT('S3:', s)\nOPEN FILE f ('RW', 'S3:')\nWRITE f ('a', 1, TRUE)\nWRITE f ('b')";
    let trace = trace_with(text, statements, vec![Event::Connect]);
    assert!(
        trace.contains("write 1 \"a 1TRUE\"\nwrite 1 \"b\"\n"),
        "{trace}"
    );
}

#[test]
fn input_and_output_errors_never_end_a_task() {
    let text = "VAR f: FILE\nn: INTEGER";
    let statements = "READ f (n)\nWRITE f (1)\nWRITE (IO_STATUS(f))\nCANCEL FILE f\nOPEN FILE f ('RW', 'S3:')\nWRITE (IO_STATUS(f))";
    assert_eq!(shown(text, statements), " 12328 12327");
}

/// Covers: K6.
#[test]
fn while_true_costs_slices_and_starves_nobody() {
    let (mut machine, task) = machine_with(
        b"PROGRAM t\nBEGIN\nWHILE TRUE DO\nENDWHILE\nEND t\n",
        "t.kl",
    );
    let mut host = ScriptedHost::new(Vec::new());
    for _ in 0..3 {
        let slice = machine.run(task, 1_000, &mut host);
        assert_eq!((slice.run, slice.used), (Run::OutOfFuel, 1_000));
    }
    assert_eq!(machine.task(task).unwrap().line, 3);
    machine.abort(task, &mut host);
    assert_eq!(machine.run(task, 1_000, &mut host).run, Run::Ended);
}

#[test]
fn a_slice_can_end_anywhere_without_changing_the_result() {
    let source = include_bytes!("../cases/control_flow.kl");
    let whole = {
        let (mut machine, task) = machine_with(source, "t.kl");
        let mut host = ScriptedHost::new(Vec::new());
        run(&mut machine, task, &mut host);
        host.trace
    };
    let (mut machine, task) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    while machine.run(task, 1, &mut host).run == Run::OutOfFuel {}
    assert!(whole.starts_with(&host.trace), "{whole}\n{}", host.trace);
    assert_eq!(host.alarms.len(), 1);
}

#[test]
fn variables_of_a_program_outlive_its_runs_and_can_be_set_from_outside() {
    let source = b"PROGRAM t\nTYPE c = STRUCTURE\nok: BOOLEAN\nENDSTRUCTURE\nVAR n: INTEGER\ncfg: c\nBEGIN\nIF UNINIT(n) THEN\nn = 0\nENDIF\nn = n + 1\nWRITE (n, UNINIT(cfg.ok))\nEND t\n";
    let (mut machine, first) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, first, &mut host);
    let path = SysPath::parse("cfg.ok").unwrap();
    assert_eq!(machine.variable("T", &path), Ok(None));
    machine
        .set_variable("t", &path, Some(&Value::Boolean(true)))
        .unwrap();
    assert_eq!(
        machine.set_variable("t", &path, Some(&Value::Real(1.0))),
        Err(Status::VARS_TYPE)
    );
    let second = machine.start("t").unwrap();
    run(&mut machine, second, &mut host);
    assert_eq!(
        host.trace,
        "display \" 1TRUE\"\nend\ndisplay \" 2FALSE\"\nend\n"
    );
    assert_eq!(
        machine.variable("t", &SysPath::parse("N").unwrap()),
        Ok(Some(Value::Integer(2)))
    );
}

#[test]
fn loading_and_starting_have_clear_refusals() {
    let program =
        || Program::parse_and_check(b"PROGRAM one\nBEGIN\nDELAY 5\nEND one\n", "one.kl").unwrap();
    let mut machine = Machine::new(Limits {
        programs: 1,
        ..Limits::default()
    });
    machine.load(program()).unwrap();
    assert_eq!(
        machine.load(program()).unwrap_err().to_string(),
        "program ONE is loaded already"
    );
    assert_eq!(
        machine.start("two").unwrap_err().to_string(),
        "program TWO is not loaded"
    );
    let _ = machine.start("One").unwrap();
    assert_eq!(
        machine.start("one").unwrap_err().to_string(),
        "program ONE is running already"
    );
}

#[test]
fn a_delay_waits_for_the_controllers_clock() {
    let (mut machine, task) = machine_with(b"PROGRAM t\nBEGIN\nDELAY 1500\nEND t\n", "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    for _ in 0..2 {
        let slice = machine.run(task, 100, &mut host);
        assert!(matches!(slice.run, Run::Blocked(Wait::Until(until)) if until.as_millis() == 1500));
    }
    assert!(trace("", "DELAY -1").contains("INTP-322"));
}

#[test]
fn a_motion_alarm_ends_the_task_and_is_posted_once() {
    let source = b"PROGRAM t\nBEGIN\nMOVE TO CURPOS(0, 0)\nEND t\n";
    let (mut machine, task) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(vec![Event::FailMotion(15_018)]);
    run(&mut machine, task, &mut host);
    let again = machine.run(task, 10, &mut host);
    assert!(matches!(again.run, Run::Aborted(_)) && again.used == 0);
    assert_eq!(host.alarms.len(), 1);
    assert_eq!(
        host.alarms[0].to_string(),
        "MOTN-018 (T, 3) The motion was refused"
    );
}

#[test]
fn assumed_a_program_that_starts_again_finds_its_files_closed() {
    let source = b"PROGRAM t\nVAR f: FILE\ns, n: INTEGER\nBEGIN\nMSG_CONNECT('S3:', s)\nOPEN FILE f ('RW', 'S3:')\nWRITE (IO_STATUS(f))\nn = 1 DIV 0\nEND t\n";
    let (mut machine, first) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(vec![Event::Connect]);
    run(&mut machine, first, &mut host);
    assert!(
        !host.trace.contains("close"),
        "an abort closes nothing: {}",
        host.trace
    );
    let second = machine.start("T").unwrap();
    run(&mut machine, second, &mut host);
    assert_eq!(
        host.trace.matches("display \" 0\"").count(),
        2,
        "{}",
        host.trace
    );
    assert_eq!(host.trace.matches("close 1").count(), 1, "{}", host.trace);
}
