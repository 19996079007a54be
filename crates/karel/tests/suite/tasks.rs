//! Several tasks: started, looked at and ended by each other.

use std::time::Duration;

use karel::{Machine, Program, Run, TaskState, Wait};

use crate::host::{ScriptedHost, machine_with};

fn load(machine: &mut Machine, source: &str) {
    let program = Program::parse_and_check(source.as_bytes(), "more.kl")
        .unwrap_or_else(|diagnostics| panic!("{}", karel::render(&diagnostics)));
    machine.load(program).unwrap();
}

/// Runs all tasks in turn, `fuel` instructions each, until none can go on.
fn run_all(machine: &mut Machine, host: &mut ScriptedHost, fuel: u32) {
    for _ in 0..10_000 {
        let mut waits = Vec::new();
        let mut worked = false;
        for id in machine.tasks().collect::<Vec<_>>() {
            if !machine.is_alive(id) {
                continue;
            }
            match machine.run(id, fuel, host).run {
                Run::OutOfFuel => worked = true,
                Run::Blocked(wait) => waits.push(wait),
                Run::Ended | Run::Aborted(_) => {}
            }
        }
        waits.sort_by_key(|wait| match wait {
            Wait::Until(until) | Wait::ReadableUntil(_, until) => *until,
            Wait::Readable(_)
            | Wait::Writable(_)
            | Wait::Connect(_)
            | Wait::MotionQueue
            | Wait::Motion(_)
            | Wait::Continue => Duration::MAX,
        });
        if !worked && !waits.iter().any(|wait| host.satisfy(wait)) {
            return;
        }
    }
    panic!("out of patience");
}

fn displayed(main: &str, others: &[&str]) -> String {
    let (mut machine, _) = machine_with(main.as_bytes(), "t.kl");
    for other in others {
        load(&mut machine, other);
    }
    let mut host = ScriptedHost::new(Vec::new());
    run_all(&mut machine, &mut host, 50);
    let lines = host
        .trace
        .lines()
        .filter_map(|line| line.strip_prefix("display \""));
    lines.map(|line| line.trim_end_matches('"')).collect()
}

const START: &str = "RUN_TASK('other', 1, FALSE, FALSE, 0, s)";

#[test]
fn a_task_starts_another_and_both_run() {
    let main = format!(
        "PROGRAM t\nVAR s, i: INTEGER\nBEGIN\n{START}\nWRITE (s)\nFOR i = 1 TO 3 DO\nDELAY 10\n\
         WRITE ('t')\nENDFOR\nEND t\n"
    );
    let other = "PROGRAM other\nVAR i: INTEGER\nBEGIN\nFOR i = 1 TO 3 DO\nWRITE ('o')\nDELAY 10\n\
                 ENDFOR\nEND other\n";
    assert_eq!(displayed(&main, &[other]), " 0tototo");
}

#[test]
fn a_task_that_runs_or_is_not_loaded_cannot_be_started() {
    let main = format!(
        "PROGRAM t\nVAR s: INTEGER\nBEGIN\n{START}\n{START}\nWRITE (s)\n\
         RUN_TASK('T', 1, FALSE, FALSE, 0, s)\nWRITE (s)\nRUN_TASK('gone', 1, FALSE, FALSE, 0, s)\n\
         WRITE (s)\nRUN_TASK('other', 7, FALSE, FALSE, 0, s)\nWRITE (s)\nEND t\n"
    );
    let other = "PROGRAM other\nBEGIN\nEND other\n";
    assert_eq!(displayed(&main, &[other]), " 3001 3001 7073 12322");
}

#[test]
fn a_task_is_seen_running_and_ended() {
    let main = format!(
        "PROGRAM t\nVAR s, n, v: INTEGER\nname, p: STRING[12]\nBEGIN\n\
         GET_TSK_INFO('OTHER', 0, TSK_STATUS, v, '', s)\nWRITE (v = PG_ABORTED)\n{START}\nDELAY 1\n\
         name = 'other'\nGET_TSK_INFO(name, n, TSK_STATUS, v, '', s)\n\
         WRITE (v = PG_RUNNING, name, UNINIT(n))\nname = ''\n\
         GET_TSK_INFO(name, n, TSK_LINENUM, v, '', s)\nWRITE (v)\n\
         GET_TSK_INFO(name, n, TSK_PROGNAME, 0, p, s)\nWRITE (p)\n\
         GET_TSK_INFO('T', 0, TSK_STATUS, v, '', s)\nWRITE (v = PG_RUNNING)\nDELAY 100\n\
         GET_TSK_INFO(name, n, TSK_STATUS, v, '', s)\nWRITE (v = PG_ABORTED)\n\
         GET_TSK_INFO('gone', 0, TSK_STATUS, v, '', s)\nWRITE (s)\nEND t\n"
    );
    let other = "PROGRAM other\nBEGIN\n\nDELAY 50\nEND other\n";
    assert_eq!(
        displayed(&main, &[other]),
        "TRUETRUEOTHERFALSE 4OTHERTRUETRUE 7073"
    );
}

#[test]
fn a_task_ends_another_and_itself() {
    let main = format!(
        "PROGRAM t\nVAR s: INTEGER\nBEGIN\n{START}\nDELAY 5\nABORT_TASK('other', TRUE, TRUE, s)\n\
         WRITE (s)\nABORT_TASK('other', TRUE, TRUE, s)\nWRITE (s)\n\
         ABORT_TASK('T', TRUE, FALSE, s)\nWRITE ('not reached')\nEND t\n"
    );
    let other = "PROGRAM other\nBEGIN\nWHILE TRUE DO\nENDWHILE\nEND other\n";
    assert_eq!(displayed(&main, &[other]), " 0 3002");
}

#[test]
fn the_name_of_the_program_is_that_of_the_routine() {
    let main = "PROGRAM t\nROUTINE r FROM other\nBEGIN\nWRITE (CURR_PROG)\nr\nEND t\n";
    let other = "PROGRAM other\nROUTINE r\nBEGIN\nWRITE (CURR_PROG)\nEND r\nBEGIN\nEND other\n";
    assert_eq!(displayed(main, &[other]), "TOTHER");
}

#[test]
fn one_endless_task_does_not_stop_the_other() {
    let source = "PROGRAM t\nVAR s: INTEGER\nBEGIN\nRUN_TASK('other', 1, FALSE, FALSE, 0, s)\n\
                  WHILE TRUE DO\nENDWHILE\nEND t\n";
    let (mut machine, main) = machine_with(source.as_bytes(), "t.kl");
    load(
        &mut machine,
        "PROGRAM other\nBEGIN\nWRITE ('o')\nEND other\n",
    );
    let mut host = ScriptedHost::new(Vec::new());
    let changes = machine.task_changes();
    assert_eq!(machine.run(main, 100, &mut host).run, Run::OutOfFuel);
    assert_ne!(machine.task_changes(), changes, "a scheduler can see it");
    let other = machine.task_of("other").unwrap();
    assert_eq!(machine.run(other, 100, &mut host).run, Run::Ended);
    assert_eq!(machine.task(main).unwrap().state, TaskState::Ready);
}

const STATE: &str = "PROGRAM state
VAR
  n IN CMOS : INTEGER
  word : STRING[4]
  list : ARRAY[3] OF REAL
ROUTINE raise(by : INTEGER)
BEGIN
  n = n + by
END raise
BEGIN
END state
";

#[test]
fn variables_of_another_program_are_one_with_those_of_that_program() {
    let main = "PROGRAM t
VAR
  n FROM state : INTEGER
  word FROM state : STRING[4]
  list FROM state : ARRAY[3] OF REAL
  i : INTEGER
ROUTINE raise(by : INTEGER) FROM state
BEGIN
  WRITE (UNINIT(n))
  n = 5
  raise(2)
  WRITE (n)
  word = 'longer'
  WRITE (word)
  FOR i = 1 TO 3 DO
    list[i] = i
  ENDFOR
  WRITE (list[2]::3::1)
END t
";
    assert_eq!(displayed(main, &[STATE]), "TRUE 7long2.0");
}

#[test]
fn a_shared_variable_that_is_not_there_ends_the_task_and_one_of_another_type_is_not_loaded() {
    let main = "PROGRAM t\nVAR n FROM nowhere : INTEGER\nBEGIN\nn = 1\nEND t\n";
    let (mut machine, task) = machine_with(main.as_bytes(), "t.kl");
    let mut host = ScriptedHost::new(Vec::new());
    let Run::Aborted(error) = machine.run(task, 100, &mut host).run else {
        panic!("it runs");
    };
    assert_eq!(error.message, "There is no variable N of a program NOWHERE");
    let other = "PROGRAM u\nVAR n FROM state : REAL\nBEGIN\nEND u\n";
    load(&mut machine, STATE);
    let program = karel::Program::parse_and_check(other.as_bytes(), "u.kl").unwrap();
    let refused = machine.load(program).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "U declares the variable N FROM STATE with another type"
    );
}

#[test]
fn a_timer_counts_milliseconds_until_it_is_disconnected() {
    let main = "PROGRAM t
VAR ms : INTEGER
BEGIN
  ms = 0
  CONNECT TIMER TO ms
  DELAY 250
  WRITE (ms)
  ms = 1000
  DELAY 8
  WRITE (ms)
  DISCONNECT TIMER ms
  DELAY 100
  WRITE (ms)
END t
";
    assert_eq!(displayed(main, &[]), " 250 1008 1008");
}

#[test]
fn a_semaphore_lets_one_in_and_a_wait_for_it_ends() {
    let main = format!(
        "PROGRAM t\nVAR s: INTEGER\nlate: BOOLEAN\nBEGIN\nCLEAR_SEMA(3)\n{START}\n\
         PEND_SEMA(3, 10, late)\nWRITE (late)\nPEND_SEMA(3, -1, late)\nWRITE (late)\n\
         POST_SEMA(3)\nPEND_SEMA(3, 0, late)\nWRITE (late)\nPEND_SEMA(3, 0, late)\n\
         WRITE (late)\nPEND_SEMA(99, 0, late)\nEND t\n"
    );
    let other = "PROGRAM other\nBEGIN\nDELAY 50\nPOST_SEMA(3)\nEND other\n";
    assert_eq!(displayed(&main, &[other]), "TRUEFALSEFALSETRUE");
}

#[test]
fn a_paused_task_executes_nothing_until_it_is_continued() {
    let main = format!(
        "PROGRAM t\nVAR s, v: INTEGER\nBEGIN\n{START}\nDELAY 5\n\
         PAUSE_TASK('other', TRUE, TRUE, s)\nWRITE (s)\n\
         PAUSE_TASK('other', TRUE, TRUE, s)\nWRITE (s)\n\
         GET_TSK_INFO('OTHER', 0, TSK_STATUS, v, '', s)\nWRITE (v = PG_PAUSED)\nDELAY 100\n\
         WRITE ('.')\nCONT_TASK('other', s)\nWRITE (s)\nDELAY 50\n\
         CONT_TASK('other', s)\nWRITE (s)\nEND t\n"
    );
    let other = "PROGRAM other\nBEGIN\nDELAY 20\nWRITE ('o')\nEND other\n";
    assert_eq!(displayed(&main, &[other]), " 0 3002TRUE. 0o 3002");
}

#[test]
fn configurations_are_read_as_the_pendant_and_as_programs_write_them() {
    let main = "PROGRAM t
VAR
  c : CONFIG
  s : INTEGER
  text : STRING[20]
BEGIN
  CNV_STR_CONF('NUT000', c, s)
  CNV_CONF_STR(c, text)
  WRITE (s, '/', text, '/')
  CNV_STR_CONF('F D B, 0, -1, 2', c, s)
  CNV_CONF_STR(c, text)
  WRITE (s, '/', text, '/')
  CNV_STR_CONF('XUT000', c, s)
  WRITE (s, UNINIT(c))
END t
";
    assert_eq!(
        displayed(main, &[]),
        " 0/N U T, 0, 0, 0/ 0/F D B, 0, -1, 2/ 12322TRUE"
    );
}
