//! The tasks of a machine: starting, ending and finding them.

use std::{collections::BTreeMap, sync::Arc};

use super::{
    Loaded, StartError,
    cell::Cell,
    is_alive, open_file,
    task::{Ending, Signal, Task},
};
use crate::{
    ast::TaskVerb,
    host::{Host, TaskId},
    run::{Limits, TaskState},
};

/// Every task, ended ones included; without the one that runs while it runs.
#[derive(Debug, Default)]
pub(crate) struct Tasks {
    by_id: BTreeMap<TaskId, Task>,
    /// Name of the task that is taken out.
    running: Option<(TaskId, Arc<str>)>,
    last: u32,
    changes: u64,
    /// What the task that runs did to others and has not heard of yet.
    deeds: Vec<Signal>,
}

impl Tasks {
    /// Starts a task at the main body of a program. A task of the same name that ended is gone then.
    pub(crate) fn start(
        &mut self,
        programs: &[Loaded],
        limits: &Limits,
        program: &str,
    ) -> Result<TaskId, StartError> {
        let name: Arc<str> = program.to_ascii_uppercase().into();
        let found = programs.iter().zip(0..);
        let mut found = found.filter(|(loaded, _)| *loaded.program.name() == *name);
        let Some((loaded, index)) = found.next() else {
            return Err(StartError::NotLoaded(name.to_string()));
        };
        let same = self.by_id.values().find(|task| task.name == name);
        let runs = self.running.as_ref().is_some_and(|(_, own)| *own == name);
        if runs || same.is_some_and(|task| is_alive(&task.state)) {
            return Err(StartError::Running(name.to_string()));
        }
        self.by_id.retain(|_, task| task.name != name);
        let count = self.by_id.len() + usize::from(self.running.is_some());
        if count >= limits.tasks {
            return Err(StartError::TooMany(count));
        }
        let main = loaded.program.code.routines.first();
        let cells = main.map_or(0, |main| main.frame_cells as usize);
        if cells > limits.stack_cells {
            return Err(StartError::TooLarge {
                cells,
                limit: limits.stack_cells,
            });
        }
        self.last = self.last.wrapping_add(1);
        self.changes += 1;
        let id = TaskId(self.last);
        let entry = main.map_or(0, |main| main.entry as usize);
        let task = Task::new(name, index, entry, cells);
        let _none = self.by_id.insert(id, task);
        Ok(id)
    }

    /// Ends a task, if it is alive. Whether it was.
    pub(crate) fn end(&mut self, id: TaskId, host: &mut dyn Host) -> bool {
        let Some(task) = self.by_id.get_mut(&id) else {
            return false;
        };
        if !is_alive(&task.state) {
            return false;
        }
        for file in task.frames.iter().filter_map(open_file) {
            let _ = host.close_file(file);
        }
        task.state = TaskState::Ended;
        task.paused = false;
        task.ending = Ending::No;
        self.changes += 1;
        self.broadcast(Signal::Task(TaskVerb::Abort, id));
        true
    }

    /// Asks a task to end: its condition handlers see that, and may refuse. Whether it was alive.
    pub(crate) fn request_end(&mut self, id: TaskId, host: &mut dyn Host) -> bool {
        match self.by_id.get_mut(&id) {
            Some(task) if is_alive(&task.state) && task.sees_its_end() => {
                task.ending = Ending::Requested;
                task.scan_now = true;
                self.changes += 1;
                self.broadcast(Signal::Task(TaskVerb::Abort, id));
                true
            }
            Some(_) | None => self.end(id, host),
        }
    }

    /// Tells every task but the one that runs what happened; that one hears by [`Tasks::take_deeds`] what it did.
    pub(crate) fn broadcast(&mut self, signal: Signal) {
        let runs = self.running.as_ref().map(|(id, _)| *id);
        if runs.is_some_and(|id| matches!(signal, Signal::Task(_, of) if of != id)) {
            self.deeds.push(signal);
        }
        for (id, task) in &mut self.by_id {
            task.signal(signal);
            // What happens to a task itself is seen before it does anything else.
            let own = matches!(signal, Signal::Task(_, of) if of == *id);
            task.scan_now |= own && task.has_enabled_handlers() && is_alive(&task.state);
        }
    }

    /// What the task that runs did to others since it was asked last.
    pub(crate) fn take_deeds(&mut self) -> Vec<Signal> {
        std::mem::take(&mut self.deeds)
    }

    /// Says in other words how a task ended.
    pub(crate) fn set_state(&mut self, id: TaskId, state: TaskState) {
        if let Some(task) = self.by_id.get_mut(&id) {
            task.state = state;
        }
    }

    /// Pauses a task that is alive. Whether that changed anything.
    pub(crate) fn pause(&mut self, id: TaskId) -> bool {
        let changed = self
            .by_id
            .get_mut(&id)
            .filter(|task| is_alive(&task.state) && !task.paused)
            .map(|task| task.paused = true);
        self.changes += u64::from(changed.is_some());
        if changed.is_some() {
            self.broadcast(Signal::Task(TaskVerb::Pause, id));
        }
        changed.is_some()
    }

    /// Lets a paused task go on. Whether it was paused.
    pub(crate) fn resume(&mut self, id: TaskId) -> bool {
        let changed = self
            .by_id
            .get_mut(&id)
            .filter(|task| task.paused)
            .map(|task| task.paused = false);
        self.changes += u64::from(changed.is_some());
        if changed.is_some() {
            self.broadcast(Signal::Task(TaskVerb::Continue, id));
        }
        changed.is_some()
    }

    /// Forgets every task; their numbers are not used again.
    pub(crate) fn clear(&mut self) {
        self.by_id.clear();
        self.changes += 1;
    }

    pub(crate) fn get(&self, id: TaskId) -> Option<&Task> {
        self.by_id.get(&id)
    }

    /// The task with this name, which has no case; not the one that runs.
    pub(crate) fn named(&self, name: &str) -> Option<(TaskId, &Task)> {
        let mut tasks = self.by_id.iter();
        let found = tasks.find(|(_, task)| task.name.eq_ignore_ascii_case(name));
        found.map(|(id, task)| (*id, task))
    }

    pub(crate) fn ids(&self) -> impl Iterator<Item = TaskId> + '_ {
        self.by_id.keys().copied()
    }

    /// Whether a task that is alive is in a program, also as a caller; the one that runs is not looked at.
    pub(crate) fn is_executed(&self, program: usize) -> bool {
        let mut alive = self.by_id.values().filter(|task| is_alive(&task.state));
        alive.any(|task| {
            let mut callers = task.callers.iter();
            task.program == program || callers.any(|caller| caller.program == program)
        })
    }

    /// The frames of every task that is alive; not of the one that runs.
    pub(crate) fn live_frames(&self) -> impl Iterator<Item = &Cell> {
        let alive = self.by_id.values().filter(|task| is_alive(&task.state));
        alive.flat_map(|task| &task.frames)
    }

    pub(crate) fn changes(&self) -> u64 {
        self.changes
    }

    pub(crate) fn take(&mut self, id: TaskId) -> Option<Task> {
        let task = self.by_id.remove(&id)?;
        self.running = Some((id, task.name.clone()));
        Some(task)
    }

    pub(crate) fn put_back(&mut self, id: TaskId, task: Task) {
        self.running = None;
        self.deeds.clear();
        let _none = self.by_id.insert(id, task);
    }
}
