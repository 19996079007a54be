//! The machine: programs, their variables, and tasks that execute them in slices.

mod arithmetic;
mod calls;
pub(crate) mod cell;
pub(crate) mod created;
pub(crate) mod dictionaries;
mod errors;
mod exec;
pub(crate) mod fault;
mod handler_states;
mod handlers;
pub(crate) mod inspect;
mod link;
mod loaded;
mod moving;
mod operands;
mod outward;
pub(crate) mod paths;
mod ports;
mod power;
mod pulse;
mod rare;
mod read_item;
pub(crate) mod semaphore;
mod slice;
mod system;
pub(crate) mod task;
mod tasks;
pub(crate) mod teaching;
mod timer;
mod tp;
mod tp_assign;
mod tp_calculate;
mod tp_function;
mod tp_motion;
pub(crate) mod tp_value;
mod tp_wait;
mod tp_watch;
mod transfer;
mod variables;
mod verbs;
mod writing;

use std::time::Duration;

use crate::{
    host::{Host, TaskId},
    ir::Op,
    port::{Comments, PortSetup},
    program::Program,
    registers::Registers,
    run::{ByteOrder, Limits, TaskState, TaskView},
};
use cell::Cell;
use created::Created;
use dictionaries::Dictionaries;
pub(crate) use loaded::Loaded;
use paths::Paths;
use pulse::Pulses;
use semaphore::Semaphores;
use timer::Timers;

pub(crate) use arithmetic::{finite, real, whole};
pub use errors::{LoadError, StartError};
pub use inspect::VariableView;
use slice::{call_stack, open_file, runtime_error};
pub(crate) use system::{component_of, set_component};
use task::Task;
pub(crate) use tasks::Tasks;
use teaching::Teaching;
pub(crate) use variables::{Names, find as find_variable, locate as locate_variable};

/// Programs and tasks of one controller.
///
/// Variables of a program keep their values as long as the program is loaded, whatever happens to
/// its tasks; variables of a routine start uninitialized at every call.
#[derive(Debug)]
pub struct Machine {
    limits: Limits,
    programs: Vec<Loaded>,
    globals: Vec<Cell>,
    tasks: Tasks,
    registers: Registers,
    timers: Timers,
    semaphores: Semaphores,
    pulses: Pulses,
    byte_order: ByteOrder,
    /// Comments of ports.
    comments: Comments,
    paths: Paths,
    created: Created,
    dictionaries: Dictionaries,
    port_setup: PortSetup,
    teaching: Teaching,
}

impl Machine {
    /// A machine without programs.
    #[must_use]
    pub fn new(limits: Limits) -> Machine {
        let globals = Vec::new();
        Machine {
            limits,
            programs: Vec::new(),
            globals,
            tasks: Tasks::default(),
            registers: Registers::new(limits.registers),
            timers: Timers::default(),
            semaphores: Semaphores::default(),
            pulses: Pulses::default(),
            byte_order: ByteOrder::default(),
            comments: Comments::default(),
            paths: Paths::default(),
            created: Created::default(),
            dictionaries: Dictionaries::default(),
            port_setup: PortSetup::default(),
            teaching: Teaching::default(),
        }
    }

    /// The order of bytes in binary files (`ATR_UF`); big endian if nobody says it.
    #[must_use]
    pub fn byte_order(&self) -> ByteOrder {
        self.byte_order
    }

    /// The same, set.
    pub fn set_byte_order(&mut self, order: ByteOrder) {
        self.byte_order = order;
    }

    /// Loads a program; its variables are uninitialized.
    ///
    /// # Errors
    /// Its name is taken, or too many are loaded.
    pub fn load(&mut self, program: Program) -> Result<(), LoadError> {
        if self.find_program(program.name()).is_some() {
            return Err(LoadError::Duplicate(program.name().to_owned()));
        }
        if self.programs.len() >= self.limits.programs {
            return Err(LoadError::TooMany(self.programs.len()));
        }
        let links = self.link(&program)?;
        self.check_shared(&program)?;
        let base = self.globals.len();
        self.globals
            .resize(base + program.global_cells as usize, Cell::Uninit);
        for file in &program.global_files {
            if let Some(cell) = self.globals.get_mut(base + *file as usize) {
                *cell = Cell::File(program.closed_file(*file));
            }
        }
        for (path, size) in &program.global_paths {
            if let Some(cell) = self.globals.get_mut(base + *path as usize) {
                *cell = self.paths.add(*size);
            }
        }
        let base = u32::try_from(base).unwrap_or(u32::MAX);
        self.programs.push(Loaded {
            program,
            base,
            links,
        });
        self.link_variables();
        Ok(())
    }

    /// Starts a task at the main body of a program. Names have no case.
    ///
    /// # Errors
    /// The program is not loaded or runs already, or too many tasks exist.
    pub fn start(&mut self, program: &str) -> Result<TaskId, StartError> {
        self.tasks.start(&self.programs, &self.limits, program)
    }

    /// What can be seen of a task; `None` if there is no such task.
    #[must_use]
    pub fn task(&self, id: TaskId) -> Option<TaskView> {
        let task = self.tasks.get(id)?;
        let program = &self.programs.get(task.program)?.program;
        let calls = call_stack(task, &self.programs);
        Some(TaskView {
            name: task.name.clone(),
            program: program.name_arc(),
            line: calls.first().map_or(0, |innermost| innermost.line),
            state: task.state.clone(),
            calls,
        })
    }

    /// The tasks that exist, ended ones included, oldest first.
    pub fn tasks(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.tasks.ids()
    }

    /// Whether a task exists and has not ended.
    #[must_use]
    pub fn is_alive(&self, id: TaskId) -> bool {
        self.tasks.get(id).is_some_and(|task| is_alive(&task.state))
    }

    /// Changes whenever a task was started, or ended by another: a caller that schedules tasks then
    /// looks at [`Machine::tasks`] again.
    #[must_use]
    pub fn task_changes(&self) -> u64 {
        self.tasks.changes()
    }

    /// Ends a task between two instructions. Its connections stay open until a program
    /// disconnects them, as on a controller; what moves is the host's business.
    pub fn abort(&mut self, id: TaskId, host: &mut dyn Host) {
        let _was_alive = self.tasks.end(id, host);
    }

    /// Asks a task to end. Its condition handlers see that (`WHEN ABORT`) and may refuse with
    /// `NOABORT`; without one it ends as by [`Machine::abort`].
    ///
    /// A task that is alive after this is to be run, whatever it waits for: see
    /// [`Machine::wants_to_run`].
    pub fn request_abort(&mut self, id: TaskId, host: &mut dyn Host) {
        let _was_alive = self.tasks.request_end(id, host);
    }

    /// Whether a task has something to do although it waits: its condition handlers have to see
    /// that somebody wants it to end.
    #[must_use]
    pub fn wants_to_run(&self, id: TaskId) -> bool {
        self.tasks.get(id).is_some_and(|task| task.scan_now)
    }

    /// When [`Machine::follow`] has something to do.
    #[must_use]
    pub fn next_due(&self) -> Option<Duration> {
        self.pulses.next()
    }

    /// Does what is due and needs no task: ends pulses.
    pub fn follow(&mut self, host: &mut dyn Host) {
        self.pulses.follow(host);
    }

    /// Pauses a task: it executes nothing until [`Machine::resume`]. `false` if it is not alive or
    /// paused already. What moves is the host's business.
    pub fn pause(&mut self, id: TaskId) -> bool {
        self.tasks.pause(id)
    }

    /// Lets a paused task go on. `false` if it is not paused.
    pub fn resume(&mut self, id: TaskId) -> bool {
        self.tasks.resume(id)
    }

    /// Whether a task is paused.
    #[must_use]
    pub fn is_paused(&self, id: TaskId) -> bool {
        self.tasks.get(id).is_some_and(|task| task.paused)
    }

    /// The root program of a task.
    #[must_use]
    pub fn root_program(&self, id: TaskId) -> Option<&Program> {
        let name = &self.tasks.get(id)?.name;
        let index = self.find_program(name)?;
        self.programs.get(index).map(|loaded| &loaded.program)
    }

    /// The registers.
    #[must_use]
    pub fn registers(&self) -> &Registers {
        &self.registers
    }

    /// The registers, for an operator or a TP program.
    pub fn registers_mut(&mut self) -> &mut Registers {
        &mut self.registers
    }

    /// Names of the programs that are loaded, upper case, oldest first.
    pub fn programs(&self) -> impl Iterator<Item = &str> + '_ {
        let there = self.programs.iter().filter(|loaded| !loaded.is_deleted());
        there.map(|loaded| loaded.program.name())
    }

    fn find_program(&self, name: &str) -> Option<usize> {
        self.programs
            .iter()
            .position(|loaded| loaded.program.name().eq_ignore_ascii_case(name))
    }
}

fn is_alive(state: &TaskState) -> bool {
    matches!(state, TaskState::Ready | TaskState::Blocked(_))
}

/// Instructions stay small: the hot loop copies them.
const _: () = assert!(size_of::<Op>() <= 12 && size_of::<Cell>() <= 24);
