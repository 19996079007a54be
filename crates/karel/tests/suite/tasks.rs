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
