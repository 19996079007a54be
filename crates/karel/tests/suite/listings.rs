//! TP programs: what their lines do, and what is refused.

use karel::{Limits, Machine, Number, Program, TaskState};

use crate::host::{ScriptedHost, run};

fn listing(lines: &[&str]) -> String {
    let head = "/PROG  T\n/ATTR\nOWNER = X;\n/MN\n".to_owned();
    let numbered = lines.iter().enumerate();
    let lines: Vec<String> = numbered
        .map(|(n, line)| format!("{:4}:  {line}    ;\n", n + 1))
        .collect();
    head + &lines.concat() + "/POS\n/END\n"
}

/// `R[1]` to `R[4]` after the program has run, or the error that ended it.
fn registers(lines: &[&str], others: &[&str]) -> Result<[Number; 4], String> {
    let mut machine = Machine::new(Limits::default());
    let text = listing(lines);
    machine
        .load(Program::parse_listing(text.as_bytes(), "t.ls").unwrap())
        .unwrap();
    for other in others {
        let program = Program::from_file(
            other.as_bytes(),
            if other.starts_with("/PROG") {
                "o.ls"
            } else {
                "o.kl"
            },
            &karel::IncludeFiles::default(),
        );
        machine.load(program.unwrap()).unwrap();
    }
    let task = machine.start("t").unwrap();
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    match machine.task(task).unwrap().state {
        TaskState::Ended => {}
        TaskState::Aborted(error) => return Err(error.to_string()),
        other @ (TaskState::Ready | TaskState::Blocked(_)) => panic!("{other:?}"),
    }
    Ok([1, 2, 3, 4].map(|n| machine.registers().number(n).unwrap()))
}

fn integers(lines: &[&str], others: &[&str]) -> [i32; 4] {
    registers(lines, others)
        .unwrap()
        .map(|number| match number {
            Number::Integer(value) => value,
            Number::Real(value) => panic!("{value}"),
        })
}

#[test]
fn registers_are_calculated_and_jumped_by() {
    let lines = [
        "R[1:counter]=0",
        "LBL[1:again]",
        "R[1]=R[1]+1",
        "R[2]=R[2]+R[1]*1",
        "IF R[1]<5,JMP LBL[1]",
    ];
    // A mixture of operators is refused, so it is written apart.
    let text = listing(&lines);
    assert!(Program::parse_listing(text.as_bytes(), "t.ls").is_err());
    let lines = [
        "R[1:counter]=0",
        "LBL[1:again]",
        "R[1]=R[1]+1",
        "R[2]=R[2]+R[1]",
        "R[R[1]]=R[1]",
        "IF R[1]<5 AND R[1]<>4,JMP LBL[1]",
        "R[3]=17 DIV 5",
        "R[4]=(-17)",
        "JMP LBL[2]",
        "R[4]=99",
        "LBL[2]",
    ];
    assert_eq!(integers(&lines, &[])[2..], [3, -17]);
}

#[test]
fn divisions_are_real_and_a_division_by_zero_ends_the_task() {
    let found = registers(&["R[1]=7/2", "R[2]=7 MOD 4"], &[]).unwrap();
    assert_eq!(found[..2], [Number::Real(3.5), Number::Integer(3)]);
    let error = registers(&["R[1]=7/0"], &[]).unwrap_err();
    assert!(
        error.contains("INTP-307") && error.contains("(T, 1)"),
        "{error}"
    );
}

#[test]
fn calls_come_back_and_end_ends_only_the_program_that_is_called() {
    let inner = "/PROG INNER\n/ATTR\n/MN\n   1:  R[2]=2 ;\n   2:  END ;\n   3:  R[2]=9 ;\n/END\n";
    let karel = "PROGRAM kl\nVAR s : INTEGER\nBEGIN\n  SET_INT_REG(3, 3, s)\nEND kl\n";
    let lines = ["R[1]=1", "CALL INNER", "CALL KL", "R[4]=4"];
    assert_eq!(integers(&lines, &[inner, karel]), [1, 2, 3, 4]);
    let error = registers(&["CALL NOWHERE"], &[]).unwrap_err();
    assert!(error.contains("no program NOWHERE"), "{error}");
}

#[test]
fn waits_take_their_time_and_conditions_may_be_in_parentheses() {
    let lines = [
        "WAIT   1.50(sec)",
        "R[1]=1",
        "WAIT R[1]=1",
        "WAIT (R[1]=1 OR R[2]=5)",
        "IF (R[1]=1),JMP LBL[1]",
        "R[2]=2",
        "LBL[1]",
        "!remark",
        "",
        "END",
    ];
    assert_eq!(integers(&lines, &[]), [1, 0, 0, 0]);
}

/// Programs of the field have such lines, and a controller loads them.
#[test]
fn labels_and_positions_that_are_not_there_are_warnings_with_their_line() {
    for (line, reason) in [
        ("J P[7] 100% FINE", "P[7] was not taught"),
        ("WAIT DI[1]=ON TIMEOUT,LBL[9]", "there is no LBL[9]"),
        ("JMP LBL[5]", "there is no LBL[5]"),
    ] {
        let text = listing(&["!first", line]);
        let program = Program::parse_listing(text.as_bytes(), "t.ls").unwrap();
        let [warning] = program.warnings() else {
            panic!("{line}: {:?}", program.warnings());
        };
        assert_eq!((warning.message.as_str(), warning.line), (reason, 6));
    }
}

#[test]
fn what_makes_no_sense_is_an_error_with_its_line() {
    for (line, reason) in [
        (
            "C P[1] 100mm/sec FINE",
            "expected `P`, found `100mm/sec FINE`",
        ),
        (
            "A PR[1] 100mm/sec FINE INC",
            "A together with INC is not supported yet",
        ),
        (
            "J PR[1] 100mm/sec FINE",
            "a motion J has no speed in mm/sec",
        ),
        ("L PR[1] 100% FINE", "a motion L has no speed in %"),
        ("L PR[1] 100mm/sec", "expected FINE or CNT"),
        ("L PR[1] 100mm/sec CNT101", "CNT is 0 to 100"),
        ("IF (R[1]=1) THEN", "the block has no end"),
        ("ELSE", "ELSE without IF .. THEN"),
        ("ENDIF", "ENDIF without IF .. THEN"),
        ("ENDFOR", "ENDFOR without FOR"),
        ("FOR R[1]=1 TO 3", "the block has no end"),
        (
            "IF R[1]=1 AND R[2]=2 OR R[3]=3,JMP LBL[1]",
            "AND and OR in one condition without parentheses",
        ),
        (
            "R[1]=((((((((((((((((((1))))))))))))))))))",
            "so many parentheses",
        ),
        ("R[1,2]=5", "only PR has components"),
        (
            "L PR[1] 100mm/sec FINE NEVER",
            "expected an option of a motion, found `NEVER`",
        ),
        ("L PR[1] 2hours FINE", "expected `%`, `mm/sec`"),
        ("RSR[1]=ON", "expected ENABLE or DISABLE"),
        ("J PR[1] max_speed FINE", "a motion J has no max_speed"),
        ("CALL A(\"Part=1)", "expected `\"`"),
        ("L PR[1] 9mm/sec FINE TB 1sec DO[1]=ON", "expected `,`"),
        ("$A..B=1", "is no variable"),
        (
            "R[1]=",
            "expected a number, a register or an input or output",
        ),
        ("R[1]=1 2", "expected the end of the instruction, found `2`"),
        ("R[99999999999]=1", "`99999999999` is not a number"),
        ("DI[1]=ON", "an input cannot be assigned"),
        ("R[1", "expected `]`"),
    ] {
        let text = listing(&["!first", line]);
        let errors = Program::parse_listing(text.as_bytes(), "t.ls").unwrap_err();
        let first = errors.first().unwrap();
        assert!(first.message.contains(reason), "{line}: {}", first.message);
        assert_eq!(first.line, 6, "{line}");
    }
}

/// Found by the fuzzer: the message quoted the line end, or half of the section, and pointed at its beginning.
#[test]
fn what_is_wrong_in_a_taught_position_is_said_on_one_line_at_its_place() {
    let position = |body: &str| {
        let text = format!("/PROG T\n/MN\n/POS\nP[1]{{\n  GP1:\n{body}\n}};\n/END\n");
        let found = Program::parse_listing(text.as_bytes(), "t.ls").unwrap_err();
        (found[0].message.clone(), found[0].line)
    };
    let cut = position("UF : 0, UT : 1,\nJ1 CNT50 deg");
    assert_eq!(cut, ("expected `=`, found `CNT50 deg`".to_owned(), 7));
    let quote = position("UF : 0, UT : 1, CONFIG : 'N U T\nX = 1 mm");
    assert_eq!(quote.1, 6, "{}", quote.0);
    assert_eq!(quote.0, "expected `'`, found `N U T`");
    let number = position("UF : 0, UT : 1,\nJ1 = 1.2.3 deg");
    assert_eq!(number, ("`1.2.3` is not a number".to_owned(), 7));
    let config = position("UF : 0, UT : 1,\nCONFIG : 'X Y Z',");
    assert_eq!(config, ("'X Y Z' is not a configuration".to_owned(), 7));
}

#[test]
fn what_is_no_listing_gets_one_clear_message() {
    for (text, reason) in [
        ("", "empty"),
        ("hello", "expected /PROG"),
        ("/PROG\n/END\n", "expected the program's name"),
        ("/PROG T\n/MN\n", "/END is missing"),
        (
            "/PROG T\n/MN\nR[1]=1 ;\n/END\n",
            "expected a line number and `:`",
        ),
        ("/PROG T\n/WHAT\n/END\n", "the section /WHAT is not known"),
        ("\u{7f}ELF", "0x7F"),
    ] {
        let errors = Program::parse_listing(text.as_bytes(), "t.ls").unwrap_err();
        let all = karel::render(&errors);
        assert!(all.contains(reason), "{text:?}: {all}");
    }
}

#[test]
fn no_beginning_and_no_damage_of_a_listing_makes_the_parser_panic() {
    let text = include_str!("../../../../programs/cell_line.ls");
    for end in 0..text.len() {
        if let Some(part) = text.get(..end) {
            let _parsed = Program::parse_listing(part.as_bytes(), "t.ls");
        }
        for byte in [0, b'[', b';', 0xff] {
            let mut damaged = text.as_bytes().to_vec();
            damaged[end] = byte;
            let _parsed = Program::parse_listing(&damaged, "t.ls");
        }
    }
}

#[test]
fn blocks_run_what_their_condition_says_and_may_be_in_each_other() {
    let lines = [
        "FOR R[1]=1 TO 4",
        "IF (R[1]=2 OR R[1]=3 AND !(R[1]<>3)) THEN",
        "R[2]=R[2]+R[1]",
        "ELSE",
        "FOR R[4]=3 DOWNTO 2",
        "R[3]=R[3]+1",
        "ENDFOR",
        "ENDIF",
        "ENDFOR",
        "FOR R[5]=3 TO 2",
        "R[2]=99",
        "ENDFOR",
    ];
    // 2 and 3 are added, 1 and 4 count twice; counters keep their last values.
    assert_eq!(integers(&lines, &[]), [4, 5, 4, 2]);
}

#[test]
fn a_select_takes_one_case_and_a_call_comes_back_behind_it() {
    let inner = "/PROG INNER\n/ATTR\n/MN\n   1:  R[1]=AR[1] ;\n   2:  R[3]=R[3]+1 ;\n/END\n";
    let select = |value: &'static str| {
        let first = format!("R[1]={value}");
        let lines = [
            first.as_str(),
            "SELECT R[1]=1,JMP LBL[1]",
            "=2,CALL INNER(3)",
            "=3,JMP LBL[3]",
            "ELSE,JMP LBL[9]",
            "R[2]=2",
            "END",
            "LBL[1]",
            "R[2]=1",
            "END",
            "LBL[3]",
            "R[2]=3",
            "END",
            "LBL[9]",
            "R[2]=9",
        ];
        integers(&lines, &[inner])
    };
    assert_eq!(select("1")[1], 1);
    assert_eq!(select("2"), [3, 2, 1, 0]);
    assert_eq!(select("3")[1], 3);
    assert_eq!(select("7")[1], 9);
}

#[test]
fn arguments_reach_tp_and_karel_and_end_with_their_program() {
    let inner = "/PROG INNER\n/ATTR\n/MN\n   1:  R[AR[1]]=AR[2]+1 ;\n   2:  CALL DEEP ;\n/END\n";
    let deep = "/PROG DEEP\n/ATTR\n/MN\n   1:  R[4]=AR[1] ;\n/END\n";
    let error = registers(&["CALL INNER(1,41)"], &[inner, deep]).unwrap_err();
    assert!(error.contains("AR[1] was not given"), "{error}");
    let karel = "PROGRAM kl
VAR t, i, s : INTEGER
    r : REAL
    c : STRING[10]
ROUTINE inside
BEGIN
  GET_TPE_PRM(1, t, i, r, c, s)
END inside
BEGIN
  inside
  SET_INT_REG(1, t * 1000 + i, s)
  GET_TPE_PRM(2, t, i, r, c, s)
  SET_REAL_REG(2, r + t, s)
  GET_TPE_PRM(3, t, i, r, c, s)
  SET_INT_REG(3, t * 100 + STR_LEN(c), s)
  GET_TPE_PRM(4, t, i, r, c, s)
  SET_INT_REG(4, s, s)
END kl
";
    let found = registers(&["R[1]=7", "CALL KL(R[1],1.5,'grip')"], &[karel]).unwrap();
    let wanted = [
        Number::Integer(1007),
        Number::Real(3.5),
        Number::Integer(304),
        Number::Integer(12311),
    ];
    assert_eq!(found, wanted);
}

#[test]
fn texts_and_components_of_positions_are_calculated() {
    let lines = [
        "SR[1]='12'",
        "SR[2]=SR[1]+'3'",
        "R[1]=SR[2]",
        "PR[1,2]=10",
        "PR[2,2]=5",
        "PR[3]=PR[1]-PR[2]",
        "R[2]=PR[3,2]*2",
        "IF SR[2]='123',R[3]=(1+2*3)",
        "R[4]=(R[1]>100 AND SR[1]<>SR[2])",
    ];
    let error = registers(&lines, &[]).unwrap_err();
    assert!(error.contains("(T, 9)"), "a switch is no number: {error}");
    let found = registers(&lines[..8], &[]).unwrap();
    let wanted = [Number::Integer(123), Number::Real(10.0), Number::Integer(7)];
    assert_eq!(found[..3], wanted);
}

#[test]
fn a_wait_that_takes_too_long_goes_to_its_label() {
    let lines = [
        "WAIT R[1]=1 TIMEOUT,LBL[1]",
        "R[2]=1",
        "LBL[1]",
        "R[3]=1",
        "WAIT (R[3]=1) TIMEOUT,LBL[2]",
        "R[4]=1",
        "LBL[2]",
    ];
    assert_eq!(integers(&lines, &[]), [0, 0, 1, 1]);
}

/// A listing with more warnings than are shown.
fn with_many_warnings(last: &str) -> String {
    let mut lines = vec!["IF R[1]=0,JMP LBL[1]"];
    lines.extend(["Open Hand"; 70]);
    lines.extend(["LBL[1]", "R[1]=5", last]);
    listing(&lines)
}

#[test]
fn an_error_behind_many_warnings_is_one() {
    let text = with_many_warnings("R[1]=");
    let errors = Program::parse_listing(text.as_bytes(), "t.ls").unwrap_err();
    let last = errors.last().unwrap();
    assert!(last.message.starts_with("expected a number"), "{last}");
}

#[test]
fn lines_behind_many_warnings_are_executed() {
    let text = with_many_warnings("R[2]=6");
    let program = Program::parse_listing(text.as_bytes(), "t.ls").unwrap();
    let mut machine = Machine::new(Limits::default());
    machine.load(program).unwrap();
    let task = machine.start("t").unwrap();
    run(&mut machine, task, &mut ScriptedHost::new(Vec::new()));
    let found = [1, 2].map(|n| machine.registers().number(n).unwrap());
    assert_eq!(found, [Number::Integer(5), Number::Integer(6)]);
}
