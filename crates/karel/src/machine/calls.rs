//! Calls and returns.
//!
//! A frame is a range of cells: references to the arguments, then locals and temporaries. Callers
//! wait in a list, not on the stack of this process.

use super::{
    cell::{Cell, FileCell},
    exec::{Exec, Flow, row_of},
    fault::Fault,
    paths::MAX_LOCAL,
    task::{Argument, Caller, Ending, Signal},
};
use crate::{ast::TaskVerb, ir::External, program::Program, status::Status};

impl Exec<'_> {
    /// Calls a routine of the program that runs.
    pub(super) fn call(&mut self, routine: u32) -> Result<Flow, Fault> {
        self.enter(self.program, routine)
    }

    /// Calls a routine of another program; from here on that program's variables are the globals.
    pub(super) fn call_external(&mut self, row: u32) -> Result<Flow, Fault> {
        let loaded = self.programs.get(self.task.program);
        let link = loaded.and_then(|loaded| loaded.links.get(row as usize).copied().flatten());
        let target = link.and_then(|link| Some((link, self.programs.get(link.program)?)));
        let Some((link, target)) = target else {
            let External {
                program, routine, ..
            } = row_of(&self.program.code.externals, row);
            let message = format!("There is no routine {routine} of a program {program}");
            return Err(Fault::new(Status::INTP_CALL_FAILED, message));
        };
        let flow = self.enter(&target.program, link.routine)?;
        self.switch_program(link.program);
        Ok(flow)
    }

    /// Calls a whole program by its name, from the first statement at or behind a line.
    pub(super) fn call_program_at(&mut self, name: &str, line: u32) -> Result<Flow, Fault> {
        let flow = self.call_program(name)?;
        if line > 1 {
            let code = &self.program.code;
            let main = code.routines.first();
            let entry = main.map_or(0, |main| main.entry as usize);
            let mut lines = code.lines.iter().enumerate().skip(entry);
            let Some((pc, _)) = lines.find(|(_, of)| **of >= line) else {
                let message = format!("{name} has no line {line}");
                return Err(Fault::new(Status::INTP_CALL_FAILED, message));
            };
            self.task.pc = pc;
        }
        Ok(flow)
    }

    /// Calls a whole program by its name, in this task.
    pub(super) fn call_program(&mut self, name: &str) -> Result<Flow, Fault> {
        let mut programs = self.programs.iter().enumerate();
        let found = programs.find(|(_, loaded)| loaded.name() == name);
        let Some((index, loaded)) = found else {
            let message = format!("There is no program {name}");
            return Err(Fault::new(Status::INTP_CALL_FAILED, message));
        };
        let flow = self.enter(&loaded.program, 0)?;
        self.switch_program(index);
        let depth = self.task.callers.len();
        self.task.tp.arguments.push((depth, Vec::new()));
        Ok(flow)
    }

    /// As [`Exec::call_program`], with arguments.
    pub(super) fn call_with(
        &mut self,
        name: &str,
        arguments: Vec<Argument>,
    ) -> Result<Flow, Fault> {
        let flow = self.call_program(name)?;
        if let Some((_, given)) = self.task.tp.arguments.last_mut() {
            *given = arguments;
        }
        Ok(flow)
    }

    /// The end of a program: back to the caller, or the end of the task.
    pub(super) fn end_program(&mut self) -> Flow {
        if self.task.callers.is_empty() {
            self.close_locals(0);
            return Flow::Ended;
        }
        self.return_from_call()
    }

    /// Source line of the instruction.
    pub(super) fn line(&self) -> u32 {
        let lines = &self.program.code.lines;
        lines.get(self.task.pc).copied().unwrap_or(0)
    }

    /// Lets instructions and globals be those of a program.
    pub(super) fn switch_program(&mut self, index: usize) {
        let loaded = self.programs.get(index);
        let loaded = loaded.expect("programs are never unloaded");
        self.program = &loaded.program;
        self.global_base = loaded.base;
        self.task.program = index;
    }

    /// The task ends by its own ABORT, as soon as its condition handlers have seen that.
    pub(super) fn end_task(&mut self) -> Flow {
        if self.task.sees_its_end() {
            self.task.ending = Ending::Own;
            self.task.scan_now = true;
            self.task.signal(Signal::Task(TaskVerb::Abort, self.id));
            return Flow::Yield;
        }
        self.close_locals(0);
        Flow::Ended
    }

    fn enter(&mut self, program: &Program, routine: u32) -> Result<Flow, Fault> {
        let code = row_of(&program.code.routines, routine);
        let base = self.task.frames.len();
        let cells = base + code.frame_cells as usize;
        if self.task.callers.len() >= self.limits.call_depth || cells > self.limits.stack_cells {
            return Err(Fault::new(Status::INTP_STACK_OVERFLOW, "Stack overflow"));
        }
        self.make_room_for_paths(code.paths.len())?;
        self.task.callers.push(Caller {
            program: self.task.program,
            routine: self.task.routine,
            pc: self.task.pc + 1,
            base: self.task.base,
            interrupted: None,
        });
        let args = self.task.operands.len() - code.args as usize;
        self.task.frames.extend(self.task.operands.drain(args..));
        self.task.frames.resize(cells, Cell::Uninit);
        for file in &code.files {
            if let Some(cell) = self.task.frames.get_mut(base + *file as usize) {
                *cell = Cell::File(FileCell::default());
            }
        }
        for (path, size) in &code.paths {
            if let Some(cell) = self.task.frames.get_mut(base + *path as usize) {
                *cell = self.paths.add_local(*size);
            }
        }
        self.task.base = base;
        self.task.routine = routine;
        Ok(self.jump(code.entry))
    }

    pub(super) fn return_from_call(&mut self) -> Flow {
        let program = self.program;
        let code = row_of(&program.code.routines, self.task.routine);
        if !code.files.is_empty() || !code.paths.is_empty() {
            self.close_locals(self.task.base);
        }
        let Some(caller) = self.task.callers.pop() else {
            return Flow::Ended;
        };
        // They go away with the program that they were given to.
        let depth = self.task.callers.len();
        if let Some((of, _)) = self.task.tp.arguments.last()
            && *of > depth
        {
            let _gone = self.task.tp.arguments.pop();
        }
        self.task.frames.truncate(self.task.base);
        self.task.base = caller.base;
        self.task.routine = caller.routine;
        self.task.pc = caller.pc;
        if caller.program != self.task.program {
            self.switch_program(caller.program);
        }
        if let Some(pending) = caller.interrupted {
            self.task.pending = *pending;
            self.task.interrupted = false;
            self.task.unpaused = false;
            return Flow::Yield;
        }
        Flow::Jumped
    }

    /// Closes the FILE variables of frames that go away, and frees the nodes of their PATHs.
    pub(super) fn close_locals(&mut self, from: usize) {
        let cells = self.task.frames.get(from..).unwrap_or_default();
        for file in cells.iter().filter_map(super::open_file) {
            let _ = self.host.close_file(file);
        }
        for path in cells.iter().filter_map(Cell::path) {
            self.paths.free(path);
        }
    }

    /// Frees the PATHs of tasks that are over, if there are many of routines.
    fn make_room_for_paths(&mut self, more: usize) -> Result<(), Fault> {
        if more == 0 || self.paths.has_room(more) {
            return Ok(());
        }
        let others = self.others.live_frames();
        let own = self.task.frames.iter();
        let used = others.chain(own).filter_map(Cell::path).collect();
        self.paths.keep_only(&used);
        if self.paths.has_room(more) {
            return Ok(());
        }
        let message = format!("Stack overflow: routines have more than {MAX_LOCAL} PATHs");
        Err(Fault::new(Status::INTP_STACK_OVERFLOW, message))
    }
}
