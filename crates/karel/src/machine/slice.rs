//! One slice of a task, and what it leaves behind.

use super::{
    Loaded, Machine,
    cell::Cell,
    exec::{Exec, Stop},
    fault::Fault,
    task::{Signal, Task},
};
use crate::{
    ast::TaskVerb,
    error::{CallSite, RuntimeError},
    host::{Host, TaskId},
    run::{Run, Slice, TaskState},
    tp::Instruction,
};

impl Machine {
    /// Executes a task until it waits, ends, or has used up `fuel` instructions. The conditions that are looked at in
    /// between are counted too, and may go beyond that: cut into smaller slices, a task uses the same in all.
    ///
    /// A task that ended, or that does not exist, reports its end and uses nothing.
    pub fn run(&mut self, id: TaskId, fuel: u32, host: &mut dyn Host) -> Slice {
        // The task is taken out, so that its statements can start and end others.
        let Some(mut task) = self.tasks.take(id) else {
            return Slice {
                run: Run::Ended,
                used: 0,
                wake_by: None,
            };
        };
        let slice = self.run_task(id, &mut task, fuel, host);
        self.tasks.put_back(id, task);
        self.take_taught();
        slice
    }

    /// What a slice has done to TP programs.
    fn take_taught(&mut self) {
        if !self.teaching.is_due() {
            return;
        }
        for name in std::mem::take(&mut self.teaching.deleted) {
            self.teaching.forget(&name);
            let index = self.find_program(&name);
            if let Some(loaded) = index.and_then(|index| self.programs.get_mut(index)) {
                // Its place stays: tasks and links name programs by their places.
                loaded.delete();
            }
        }
        for program in std::mem::take(&mut self.teaching.made) {
            // The built-in has looked whether there is room and no such program.
            let mut gone = self.programs.iter_mut();
            if let Some(place) = gone.find(|loaded| loaded.is_deleted()) {
                place.program = program;
            } else {
                let _loaded = self.load(program);
            }
        }
        for (name, line) in std::mem::take(&mut self.teaching.blanked) {
            let index = self.find_program(&name);
            let loaded = index.and_then(|index| self.programs.get_mut(index));
            let row = usize::try_from(line).unwrap_or(0).wrapping_sub(1);
            let slot = loaded.and_then(|loaded| loaded.program.code.tp.get_mut(row));
            if let Some(instruction) = slot {
                *instruction = Instruction::Nothing;
            }
        }
    }

    fn run_task(&mut self, id: TaskId, task: &mut Task, fuel: u32, host: &mut dyn Host) -> Slice {
        let over = match &task.state {
            TaskState::Ready | TaskState::Blocked(_) => None,
            TaskState::Ended => Some(Run::Ended),
            TaskState::Aborted(error) => Some(Run::Aborted(error.clone())),
        };
        if let Some(run) = over {
            return Slice {
                run,
                used: 0,
                wake_by: None,
            };
        }
        self.pulses.follow(host);
        self.timers.follow(host.now(), &mut self.globals);
        let loaded = self.programs.get(task.program);
        let loaded = loaded.expect("programs are never unloaded");
        if std::mem::take(&mut task.is_new) {
            close_left_open(loaded, &mut self.globals, host);
        }
        let mut exec = Exec {
            id,
            program: &loaded.program,
            global_base: loaded.base,
            globals: &mut self.globals,
            programs: &self.programs,
            others: &mut self.tasks,
            registers: &mut self.registers,
            timers: &mut self.timers,
            semaphores: &mut self.semaphores,
            pulses: &mut self.pulses,
            byte_order: self.byte_order,
            comments: &mut self.comments,
            paths: &mut self.paths,
            created: &mut self.created,
            dictionaries: &mut self.dictionaries,
            port_setup: &mut self.port_setup,
            teaching: &mut self.teaching,
            task,
            host,
            limits: &self.limits,
            looked: 0,
        };
        let (stop, used) = exec.slice(fuel);
        let run = match stop {
            Stop::OutOfFuel | Stop::Yield => Run::OutOfFuel,
            Stop::Blocked(wait) => Run::Blocked(wait),
            Stop::Ended => Run::Ended,
            Stop::Aborted(error) => Run::Aborted(error),
            Stop::Failed(_) => unreachable!("a slice ends with an error that was posted"),
        };
        if matches!(run, Run::Ended | Run::Aborted(_)) {
            task.handlers.clear();
            task.tp.monitors.clear();
            task.tp.beside.clear();
            self.tasks.broadcast(Signal::Task(TaskVerb::Abort, id));
        }
        task.state = match &run {
            Run::OutOfFuel => TaskState::Ready,
            Run::Blocked(wait) => TaskState::Blocked(wait.clone()),
            Run::Ended => TaskState::Ended,
            Run::Aborted(error) => TaskState::Aborted(error.clone()),
        };
        Slice {
            run,
            used,
            wake_by: task.next_scan(),
        }
    }
}

/// A program that starts finds its FILE variables closed.
///
/// ASSUMPTION: a run that was aborted leaves its connection open, but not its FILE variables, so
/// that the next run can open them again.
fn close_left_open(loaded: &Loaded, globals: &mut [Cell], host: &mut dyn Host) {
    for file in &loaded.program.global_files {
        if let Some(cell) = globals.get_mut((loaded.base + file) as usize) {
            if let Some(file) = open_file(cell) {
                let _ = host.close_file(file);
            }
            *cell = Cell::File(loaded.program.closed_file(*file));
        }
    }
}

pub(super) fn open_file(cell: &Cell) -> Option<crate::host::FileId> {
    match cell {
        Cell::File(file) => file.file,
        Cell::Uninit
        | Cell::Integer(_)
        | Cell::Real(_)
        | Cell::Boolean(_)
        | Cell::Text(_)
        | Cell::Config(_)
        | Cell::Path(_)
        | Cell::Address(_) => None,
    }
}

/// The call stack, innermost first. A caller's counter is already behind its call.
pub(super) fn call_stack(task: &Task, programs: &[Loaded]) -> Vec<CallSite> {
    let site = |program: usize, routine: u32, pc: usize| {
        let program = &programs.get(program)?.program;
        let code = program.code.routines.get(routine as usize);
        Some(CallSite {
            program: program.name_arc(),
            routine: code.map_or_else(|| program.name_arc(), |code| code.name.clone()),
            line: program.code.lines.get(pc).copied().unwrap_or(0),
        })
    };
    let innermost = site(task.program, task.routine, task.pc);
    let callers = task.callers.iter().rev();
    let callers = callers.map(|caller| {
        let behind = usize::from(caller.interrupted.is_none());
        site(
            caller.program,
            caller.routine,
            caller.pc.saturating_sub(behind),
        )
    });
    std::iter::once(innermost)
        .chain(callers)
        .flatten()
        .collect()
}

pub(super) fn runtime_error(fault: Fault, task: &Task, programs: &[Loaded]) -> RuntimeError {
    let calls = call_stack(task, programs);
    let innermost = calls.first();
    RuntimeError {
        status: fault.status,
        message: fault.message.into_owned(),
        program: innermost.map_or_else(|| task.name.clone(), |site| site.program.clone()),
        line: innermost.map_or(0, |site| site.line),
        calls,
    }
}
