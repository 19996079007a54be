//! Rules that were guessed, one test for each, named after the guess.

use crate::host::{Event, ScriptedHost, machine_with, run};

/// What a program with these declarations and statements shows, and how it ends.
fn shown(declarations: &str, statements: &str) -> String {
    let source = format!("PROGRAM t\nVAR\n{declarations}\nBEGIN\n{statements}\nEND t\n");
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    let lines = host.trace.lines().filter_map(|line| match line {
        "end" => None,
        line => Some(
            line.strip_prefix("display ")
                .unwrap_or(line)
                .trim_matches('"'),
        ),
    });
    lines.collect::<Vec<_>>().join("|")
}

#[test]
fn assumed_a_handler_is_disabled_as_a_whole_when_one_when_holds() {
    let handler = "CONDITION[1]:\nWHEN n = 1 DO\nWRITE ('a')\nWHEN n = 2 DO\nWRITE ('b')\n\
                   ENDCONDITION\nENABLE CONDITION[1]\nn = 1\nDELAY 100\nn = 2\nDELAY 100";
    assert_eq!(shown("n: INTEGER", &format!("n = 0\n{handler}")), "a");
}

#[test]
fn assumed_noabort_takes_back_neither_an_own_abort_nor_an_error() {
    let handler = "CONDITION[1]:\nWHEN ABORT DO\nNOABORT\nENDCONDITION\nENABLE CONDITION[1]\n";
    assert_eq!(
        shown("n: INTEGER", &format!("{handler}ABORT\nWRITE ('on')")),
        ""
    );
    let error = shown("n: INTEGER", &format!("{handler}n = n + 1\nWRITE ('on')"));
    assert!(error.starts_with("aborted: INTP-311 (T, 10)"), "{error}");
}

#[test]
fn assumed_a_semaphore_that_a_condition_sees_keeps_its_count() {
    let statements = "SIGNAL SEMAPHORE[2]\nWAIT FOR SEMAPHORE[2]\nWAIT FOR SEMAPHORE[2]\n\
                      PEND_SEMA(2, 0, late)\nWRITE (late)\nPEND_SEMA(2, 0, late)\nWRITE (late)";
    assert_eq!(shown("late: BOOLEAN", statements), "FALSE|TRUE");
}

#[test]
fn assumed_a_pulse_inverts_its_port() {
    let pulses = "DOUT[1] = ON\nPULSE DOUT[1] FOR 50\nPULSE DOUT[2] FOR 50";
    assert_eq!(
        shown("n: INTEGER", pulses),
        "DOUT[1] = Switch(true)|DOUT[1] = Switch(false)|DOUT[1] = Switch(true)\
         |DOUT[2] = Switch(true)|DOUT[2] = Switch(false)"
    );
}

#[test]
fn assumed_a_pause_lets_what_moves_go_on() {
    let statements = "p = CURPOS(0, 0)\nMOVE TO p NOWAIT\nPAUSE";
    let trace = shown("p: XYZWPR", statements);
    assert!(!trace.contains("hold"), "{trace}");
    assert!(trace.ends_with("waits for Continue"), "{trace}");
}

#[test]
fn assumed_a_byte_has_no_sign() {
    let stored = shown("b: ARRAY[1] OF BYTE", "b[1] = 255\nWRITE (b[1])\nb[1] = -1");
    assert!(stored.starts_with(" 255|aborted: INTP-323"), "{stored}");
}

#[test]
fn assumed_a_composed_position_has_the_configuration_of_the_right_one() {
    let declarations = "p, q: POSITION\nc: CONFIG\ns: INTEGER\nt: STRING[20]";
    let statements = "p = $UTOOL\nq = $UTOOL\nCNV_STR_CONF('FDB000', c, s)\nq.config_data = c\n\
                      q = p : q\nCNV_CONF_STR(q.config_data, t)\nWRITE (t)";
    assert_eq!(shown(declarations, statements), "F D B, 0, 0, 0");
}

#[test]
fn assumed_positions_are_nearly_equal_within_a_hundredth() {
    let near = |x: &str, r: &str| {
        let statements = format!("p = $UTOOL\nq = p\nq.x = {x}\nq.r = {r}\nWRITE (p >=< q)");
        shown("p, q: POSITION", &statements)
    };
    assert_eq!(near("0.009", "0"), "TRUE");
    assert_eq!(near("0.011", "0"), "FALSE");
    assert_eq!(near("0", "0.009"), "TRUE");
    assert_eq!(near("0", "0.02"), "FALSE");
}

#[test]
fn assumed_a_comment_of_a_port_has_24_characters() {
    let statements = "SET_PORT_CMT(2, 1, '123456789012345678901234567890', s)\n\
                      GET_PORT_CMT(2, 1, t, s)\nWRITE (STR_LEN(t))";
    assert_eq!(shown("s: INTEGER\nt: STRING[40]", statements), " 24");
}

#[test]
fn assumed_restore_and_nomessage_change_nothing() {
    let statements = "CONDITION[1]:\nWHEN TRUE DO\nRESTORE\nNOMESSAGE\nWRITE ('x')\n\
                      ENDCONDITION\nENABLE CONDITION[1]\nDELAY 1";
    assert_eq!(shown("n: INTEGER", statements), "x");
}

#[test]
fn assumed_a_string_of_binary_data_without_a_width_is_as_long_as_its_variable() {
    // The golden case `binary` reads one of three bytes so; what is missing is waited for.
    let statements = "SET_FILE_ATR(f, ATR_UF)\nMSG_CONNECT('S1:', s)\nOPEN FILE f('RW', 'S1:')\n\
                      READ f(t)";
    let source = format!(
        "PROGRAM t\nVAR\nf: FILE\ns: INTEGER\nt: STRING[4]\nBEGIN\n{statements}\nWRITE (t)\nEND t\n"
    );
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(vec![
        Event::Connect,
        Event::Send(b"ab\n".to_vec()),
        Event::Send(b"cd".to_vec()),
    ]);
    run(&mut machine, task, &mut host);
    assert!(host.trace.contains("display \"ab\\nc\""), "{}", host.trace);
}

#[test]
fn assumed_screens_always_succeed() {
    let statements = "FORCE_SPMENU(TP_PANEL, SPI_TPUSER, 1)\nSET_CURSOR(TPDISPLAY, 1, 1, s)\nWRITE (s)\n\
                      DEF_SCREEN('a', 'b', s)\nWRITE (s)\nSET_LANG('ENGLISH', s)\nWRITE (s)";
    assert_eq!(shown("s: INTEGER", statements), " 0| 0| 0");
}

#[test]
fn assumed_a_joint_position_of_the_group_keeps_the_axes_that_the_arm_has() {
    let declarations = "a: ARRAY[10] OF REAL\nj: JOINTPOS\nn, s: INTEGER";
    let statements = "FOR n = 1 TO 10 DO\na[n] = n\nENDFOR\nCNV_REL_JPOS(a, j, s)\n\
                      WRITE (s, J_IN_RANGE(j))\na[9] = a[10]\nCNV_JPOS_REL(j, a, s)\nWRITE (s, a[6], a[7])";
    assert_eq!(
        shown(declarations, statements),
        " 0TRUE| 0 6.000000E+00 7.000000E+00"
    );
}
