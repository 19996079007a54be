//! Programs and tasks in the hands of an operator.

use karel::{Status, TaskId, TaskView};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Controller, Phase};
use crate::alarms::Severity;
use crate::faults::ControllerOption;

/// A program that is loaded.
#[derive(Clone, Debug)]
pub(super) struct Loaded {
    pub(super) name: String,
    pub(super) kind: ProgramKind,
    pub(super) file: String,
}

/// The language of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ProgramKind {
    /// KAREL.
    Karel,
    /// A listing of a TP program.
    Tp,
}

impl ProgramKind {
    /// By the extension, as the loader does.
    pub(super) fn of_file(file: &str) -> Self {
        let extension = file.rsplit_once('.').map(|(_, extension)| extension);
        if extension.is_some_and(|extension| extension.eq_ignore_ascii_case("ls")) {
            Self::Tp
        } else {
            Self::Karel
        }
    }
}

/// A program that is loaded, as an operator sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ProgramView {
    /// The name after PROGRAM, upper case.
    pub name: String,
    /// Its language.
    pub kind: ProgramKind,
    /// The file that it was loaded from; empty for one that a program has made.
    pub file: String,
    /// Whether a task of it is alive.
    pub running: bool,
    /// Whether it runs from power-on.
    pub at_power_on: bool,
}

/// A task as it is seen.
#[derive(Clone, Debug)]
pub struct TaskSeen {
    /// Its number.
    pub id: TaskId,
    /// Its place and state, the call stack among it.
    pub view: TaskView,
    /// Whether it executes nothing until it is continued.
    pub paused: bool,
}

/// Why a program or a task does not do what was asked; nothing has changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TaskError {
    /// No such program.
    #[error("there is no program {name}; there are: {known}")]
    NoProgram {
        /// What was given.
        name: String,
        /// All of them.
        known: String,
    },
    /// No such task.
    #[error("there is no task {name}; there are: {known}")]
    NoTask {
        /// What was given.
        name: String,
        /// All of them.
        known: String,
    },
    /// It cannot start, or go on.
    #[error("{0}")]
    Cannot(String),
    /// The controller has no such option.
    #[error("the option {option} is missing, and {name} is a KAREL program")]
    Option {
        /// The program.
        name: String,
        /// The option.
        option: ControllerOption,
    },
    /// The controller stopped.
    #[error(transparent)]
    Stopped(#[from] crate::error::ControllerStopped),
}

impl Controller {
    /// The programs that are loaded, in the order in which they were given.
    #[must_use]
    pub fn programs(&self) -> Vec<ProgramView> {
        let view = |program: &Loaded| ProgramView {
            name: program.name.clone(),
            kind: program.kind,
            file: program.file.clone(),
            running: self
                .machine
                .task_of(&program.name)
                .is_some_and(|task| self.machine.is_alive(task)),
            at_power_on: self
                .run
                .iter()
                .any(|name| name.eq_ignore_ascii_case(&program.name)),
        };
        // Programs delete and make others.
        let there: Vec<&str> = self.machine.programs().collect();
        let known = self.loaded.iter();
        let known = known.filter(|program| there.contains(&program.name.as_str()));
        let made = there.iter().filter(|name| !self.is_known(name));
        let made = made.map(|name| Loaded {
            name: (*name).to_owned(),
            kind: ProgramKind::Tp,
            file: String::new(),
        });
        known
            .map(view)
            .chain(made.map(|made| view(&made)))
            .collect()
    }

    fn is_known(&self, name: &str) -> bool {
        let mut loaded = self.loaded.iter();
        loaded.any(|program| program.name.eq_ignore_ascii_case(name))
    }

    /// Starts a program as a task.
    ///
    /// # Errors
    /// It is not loaded, runs already, needs an option that is missing, or the power is off.
    pub fn run_program(&mut self, name: &str) -> Result<(), TaskError> {
        if self.off_until.is_some() {
            return Err(TaskError::Cannot("the power is off".to_owned()));
        }
        let _task = self.start_task(name)?;
        self.follow_tasks();
        Ok(())
    }

    pub(super) fn start_task(&mut self, name: &str) -> Result<TaskId, TaskError> {
        let programs = self.programs();
        let mut found = programs.iter();
        let Some(program) = found.find(|program| program.name.eq_ignore_ascii_case(name)) else {
            let known: Vec<&str> = programs.iter().map(|p| p.name.as_str()).collect();
            return Err(TaskError::NoProgram {
                name: shown(name),
                known: known.join(", "),
            });
        };
        let option = ControllerOption::R632;
        if program.kind == ProgramKind::Karel && self.hardware.missing.contains(&option) {
            let name = program.name.clone();
            return Err(TaskError::Option { name, option });
        }
        let started = self.machine.start(name);
        started.map_err(|error| TaskError::Cannot(error.to_string()))
    }

    /// What can be seen of a task, its call stack among it.
    ///
    /// # Errors
    /// There is no such task.
    pub fn task(&self, name: &str) -> Result<TaskSeen, TaskError> {
        let found = self.machine.task_of(name);
        found
            .and_then(|id| self.seen(id))
            .ok_or_else(|| self.no_task(name))
    }

    fn seen(&self, id: TaskId) -> Option<TaskSeen> {
        let view = self.machine.task(id)?;
        let paused = self.machine.is_paused(id);
        Some(TaskSeen { id, view, paused })
    }

    /// Every task, its call stack among it.
    pub fn tasks_seen(&self) -> impl Iterator<Item = TaskSeen> + '_ {
        let ids = self.tasks.iter().map(|task| task.id);
        ids.filter_map(|id| self.seen(id))
    }

    /// Asks a task to end, as the ABORT key does: its `WHEN ABORT` may refuse with `NOABORT`. The arm brakes if it moves
    /// for a task that ends. Its connections stay open and silent.
    ///
    /// # Errors
    /// There is no such task.
    pub fn abort_task(&mut self, name: &str) -> Result<(), TaskError> {
        let id = self.task(name)?.id;
        self.machine.request_abort(id, &mut self.hardware);
        let text = format!("The task {} was aborted by the operator", shown(name));
        if !self.machine.is_alive(id) {
            self.hardware.stop_arm_of(id, &text);
        }
        self.hardware
            .post(super::SYST_ABORTED, text, Severity::Warn);
        self.follow_tasks();
        self.wake_tasks();
        Ok(())
    }

    /// Pauses a task; the arm brakes on its path if it moves for it.
    ///
    /// # Errors
    /// There is no such task, or it is not alive.
    pub fn pause_task(&mut self, name: &str) -> Result<(), TaskError> {
        let id = self.task(name)?.id;
        if !self.machine.is_alive(id) {
            return Err(TaskError::Cannot(format!(
                "the task {} is over",
                shown(name)
            )));
        }
        let _was_running = self.machine.pause(id);
        self.hardware.hold_motions_of(id);
        self.follow_tasks();
        Ok(())
    }

    /// Lets a paused task go on: for good, or for one line.
    ///
    /// # Errors
    /// There is no such task, it is not paused, or something forbids it.
    pub fn continue_task(&mut self, name: &str, lines: Lines) -> Result<(), TaskError> {
        let id = self.task(name)?.id;
        if !self.machine.is_paused(id) {
            return Err(TaskError::Cannot(format!(
                "the task {} is not paused",
                shown(name)
            )));
        }
        if let Some(reason) = self.hardware.start_obstacle() {
            return Err(TaskError::Cannot(format!(
                "the task cannot go on: {reason}"
            )));
        }
        let _was_paused = self.machine.resume(id);
        if lines == Lines::One || self.single_step {
            self.step_one_line(id);
        }
        self.hardware.continue_motions_of(id);
        self.follow_tasks();
        Ok(())
    }

    /// Whether nothing will ever happen here without something from outside.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.next_wake().is_none()
    }

    /// The task called a built-in that does not exist without an option: it ends.
    pub(super) fn after_missing_call(&mut self, id: TaskId) -> Option<karel::Run> {
        let builtin = self.hardware.missing_call.take()?;
        let option = ControllerOption::R648;
        let message = format!("Undefined built-in {builtin}: the option {option} is missing");
        let status = Status::INTP_UNDEFINED_BUILTIN;
        let _was_alive = self.machine.fail(id, status, message, &mut self.hardware);
        match self.machine.task(id)?.state {
            karel::TaskState::Aborted(error) => Some(karel::Run::Aborted(error)),
            karel::TaskState::Ready | karel::TaskState::Blocked(_) | karel::TaskState::Ended => {
                Some(karel::Run::Ended)
            }
        }
    }

    /// Whether a task is alive; for tests and tools that wait for the end.
    #[must_use]
    pub fn has_live_tasks(&self) -> bool {
        self.tasks
            .iter()
            .any(|task| !matches!(task.phase, Phase::Over))
    }

    fn no_task(&self, name: &str) -> TaskError {
        let names = self.tasks_seen().map(|seen| seen.view.name.to_string());
        let known: Vec<String> = names.collect();
        TaskError::NoTask {
            name: shown(name),
            known: if known.is_empty() {
                "none".to_owned()
            } else {
                known.join(", ")
            },
        }
    }
}

/// How far a task goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lines {
    /// To its end.
    All,
    /// For one line.
    One,
}

/// A name from outside, short enough for a message.
pub(super) fn shown(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(64).collect()
}
