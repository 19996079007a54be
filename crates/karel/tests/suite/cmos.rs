//! What programs remember without power.

use karel::{Cmos, Machine, Program, Scalar, SysPath, Value};

use crate::host::{ScriptedHost, machine_with, run};

const SOURCE: &str = "PROGRAM t
TYPE
  job_t = STRUCTURE
    id : INTEGER
    at : XYZWPR
    names : ARRAY[2] OF STRING[4]
  ENDSTRUCTURE
VAR
  epoch IN CMOS : INTEGER
  job IN SHADOW : job_t
  seen IN DRAM : INTEGER
  plain : INTEGER
BEGIN
  IF UNINIT(epoch) THEN
    epoch = 0
  ENDIF
  epoch = epoch + 1
  seen = 7
  plain = 7
  job.id = epoch
  job.at.x = 1.5
  job.names[2] = 'abc'
  WRITE (epoch, UNINIT(job.at.y))
END t
";

fn value(machine: &mut Machine, path: &str) -> Option<Value> {
    machine
        .variable("t", &SysPath::parse(path).unwrap())
        .unwrap()
}

#[test]
fn variables_in_cmos_survive_a_power_cycle_and_others_do_not() {
    let (mut machine, task) = machine_with(SOURCE.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    let memory = machine.export_cmos();
    machine.power_cycle();
    assert_eq!(value(&mut machine, "epoch"), None);
    assert_eq!(machine.tasks().count(), 0);
    assert_eq!(machine.import_cmos(&memory), Vec::<String>::new());
    assert_eq!(value(&mut machine, "epoch"), Some(Value::Integer(1)));
    assert_eq!(value(&mut machine, "job.at.x"), Some(Value::Real(1.5)));
    assert_eq!(
        value(&mut machine, "job.names[2]"),
        Some(Value::String("abc".into()))
    );
    assert_eq!(value(&mut machine, "job.names[1]"), None, "it had no value");
    assert_eq!(value(&mut machine, "seen"), None);
    assert_eq!(value(&mut machine, "plain"), None);
    let task = machine.start("t").unwrap();
    run(&mut machine, task, &mut host);
    assert_eq!(value(&mut machine, "epoch"), Some(Value::Integer(2)));
}

#[test]
fn assumed_cmosvars_keeps_every_variable_without_a_storage_of_its_own() {
    let source = "PROGRAM t\n%CMOSVARS\nVAR a: INTEGER\nb IN DRAM: INTEGER\nf: FILE\nBEGIN\na = 1\nb = 2\nEND t\n";
    let (mut machine, task) = machine_with(source.as_bytes(), "t.kl");
    run(&mut machine, task, &mut ScriptedHost::new(Vec::new()));
    let memory = machine.export_cmos();
    let names: Vec<&String> = memory.programs["T"].keys().collect();
    assert_eq!(names, ["A", "F"]);
    machine.power_cycle();
    assert!(machine.import_cmos(&memory).is_empty());
    assert_eq!(value(&mut machine, "a"), Some(Value::Integer(1)));
    let task = machine.start("t").unwrap();
    run(&mut machine, task, &mut ScriptedHost::new(Vec::new()));
}

#[test]
fn what_no_longer_fits_is_named_and_left_alone() {
    let (mut machine, task) = machine_with(SOURCE.as_bytes(), "t.kl");
    run(&mut machine, task, &mut ScriptedHost::new(Vec::new()));
    let mut memory = machine.export_cmos();
    let variables = memory.programs.get_mut("T").unwrap();
    let _old = variables.insert("EPOCH".to_owned(), vec![Some(Scalar::Real(1.0))]);
    let _old = variables.insert("PLAIN".to_owned(), vec![Some(Scalar::Integer(1))]);
    let job = variables.get_mut("JOB").unwrap();
    let last = job.len() - 1;
    job[last] = Some(Scalar::String("too long".to_owned()));
    let _old = memory
        .programs
        .insert("GONE".to_owned(), [("X".to_owned(), vec![None])].into());
    let refused = machine.import_cmos(&memory);
    assert_eq!(refused, ["[GONE]X", "[T]EPOCH", "[T]JOB", "[T]PLAIN"]);
    assert_eq!(value(&mut machine, "epoch"), Some(Value::Integer(1)));
    assert_eq!(machine.import_cmos(&Cmos::default()), Vec::<String>::new());
}

#[test]
fn a_variable_of_a_routine_is_never_kept() {
    let source = b"PROGRAM t\nROUTINE r\nVAR a IN CMOS: INTEGER\nBEGIN\nEND r\nBEGIN\nEND t\n";
    let errors = Program::parse_and_check(source, "t.kl").unwrap_err();
    assert!(
        errors[0].message.contains("only variables of the program"),
        "{errors:?}"
    );
    let source = b"PROGRAM t\nVAR a IN RAM: INTEGER\nBEGIN\nEND t\n";
    let errors = Program::parse_and_check(source, "t.kl").unwrap_err();
    assert!(errors[0].message.contains("found `RAM`"), "{errors:?}");
}

#[test]
fn a_path_in_cmos_keeps_its_nodes_and_another_loses_them() {
    let source = b"PROGRAM t
TYPE
  head_t = STRUCTURE
    tag : STRING[4]
  ENDSTRUCTURE
  node_t = STRUCTURE
    n : INTEGER
    x : REAL
  ENDSTRUCTURE
VAR
  kept IN CMOS : PATH PATHHEADER = head_t, NODEDATA = node_t
  lost : PATH NODEDATA = node_t
  status : INTEGER
BEGIN
  APPEND_NODE(kept, status)
  APPEND_NODE(kept, status)
  APPEND_NODE(lost, status)
  kept[2].n = 5
  kept.tag = 'ab'
  lost[1].n = 6
END t
";
    let (mut machine, task) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    let (views, more) = machine.variables_of("t", 100).unwrap();
    let paths: Vec<&str> = views.iter().map(|view| view.path.as_str()).collect();
    let expected = [
        "KEPT.TAG",
        "KEPT[1].N",
        "KEPT[1].X",
        "KEPT[2].N",
        "KEPT[2].X",
        "LOST[1].N",
        "LOST[1].X",
        "STATUS",
    ];
    assert_eq!((paths.as_slice(), more), (&expected[..], false));
    let memory = machine.export_cmos();
    machine.power_cycle();
    let gone = SysPath::parse("kept[1].n").unwrap();
    assert!(machine.variable("t", &gone).is_err(), "no node is there");
    assert_eq!(machine.import_cmos(&memory), Vec::<String>::new());
    assert_eq!(value(&mut machine, "kept[2].n"), Some(Value::Integer(5)));
    assert_eq!(value(&mut machine, "kept[1].n"), None);
    assert_eq!(
        value(&mut machine, "kept.tag"),
        Some(Value::String("ab".into()))
    );
    assert!(
        machine
            .variable("t", &SysPath::parse("lost[1].n").unwrap())
            .is_err()
    );
    // Nodes of another shape are refused.
    let mut other = memory.clone();
    let nodes = other
        .paths
        .get_mut("T")
        .and_then(|paths| paths.get_mut("KEPT"));
    nodes.unwrap().push(vec![Some(Scalar::Boolean(true))]);
    assert_eq!(machine.import_cmos(&other), ["[T]KEPT"]);
}

#[test]
fn paths_in_structures_and_arrays_are_kept_in_cmos_too() {
    let source = b"PROGRAM t
TYPE
  job_t = STRUCTURE
    way : PATH NODEDATA = INTEGER
    legs : ARRAY[2] OF PATH NODEDATA = INTEGER
  ENDSTRUCTURE
VAR
  kept IN CMOS : ARRAY[2] OF job_t
  lost : job_t
  status : INTEGER
BEGIN
  APPEND_NODE(kept[2].legs[1], status)
  APPEND_NODE(kept[2].legs[1], status)
  kept[2].legs[1][2] = 5
  APPEND_NODE(lost.way, status)
  lost.way[1] = 6
END t
";
    let (mut machine, task) = machine_with(source, "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    run(&mut machine, task, &mut host);
    let memory = machine.export_cmos();
    machine.power_cycle();
    assert_eq!(machine.import_cmos(&memory), Vec::<String>::new());
    let kept = "kept[2].legs[1][2]";
    assert_eq!(value(&mut machine, kept), Some(Value::Integer(5)));
    assert!(
        machine
            .variable("t", &SysPath::parse("lost.way[1]").unwrap())
            .is_err()
    );
}
