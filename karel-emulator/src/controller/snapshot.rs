//! The controller as people and tests see it.

use karel::{FileId, Wait};

use super::{Controller, Task};
use crate::fidelity::{Fidelity, Note, Profile};
use crate::hardware::gripping::Gripper;
use crate::ledger::seconds;
use crate::state::{JointLimit, State, TagView, TaskState, TaskWord};

impl Controller {
    /// Which controller this is.
    #[must_use]
    pub fn profile(&self) -> Profile {
        let hardware = &self.hardware;
        Profile {
            fidelity: hardware.fidelity,
            generation: hardware.generation,
            version: hardware.generation.version().to_owned(),
            byte_order: self.machine.byte_order().into(),
            interpolation_period_ms: hardware.interpolation_period.millis(),
            missing_options: hardware.missing.iter().copied().collect(),
        }
    }

    /// Lets the controller explain itself, or be silent.
    pub fn set_fidelity(&mut self, fidelity: Fidelity) {
        self.hardware.fidelity = fidelity;
    }

    /// What a kind controller has said, above a number, oldest first.
    #[must_use]
    pub fn notes(&self, after: u64) -> Vec<Note> {
        self.hardware.notes.after(after).cloned().collect()
    }

    /// A snapshot for people and tests.
    #[must_use]
    pub fn state(&self) -> State {
        let hardware = &self.hardware;
        let model = hardware.planner.model();
        let joints = hardware.executor.joints(hardware.now);
        // Without usable frames, the flange in the world is what there is to show.
        let (frame, tool) = hardware.frames().unwrap_or_default();
        let pose = hardware
            .planner
            .pose(&joints, &frame, &tool)
            .unwrap_or_default();
        State {
            controller: hardware.name.to_string(),
            model: model.name().to_owned(),
            time_s: seconds(hardware.now),
            power_cycles: self.power_cycles,
            joints_deg: joints.degrees().into(),
            limits_deg: kinematics::Axis::ALL
                .into_iter()
                .map(|axis| {
                    let limits = model.limits(axis);
                    let joint = axis.to_string();
                    JointLimit {
                        joint,
                        min_deg: limits.min.0,
                        max_deg: limits.max.0,
                    }
                })
                .collect(),
            pose,
            configuration: model.configuration(&joints).to_string(),
            moving: hardware.executor.is_moving(),
            held: hardware.executor.is_held(),
            mode: hardware.operator.mode,
            pendant_enabled: hardware.operator.pendant,
            emergency_stop: hardware.operator.stops != 0,
            hold: hardware.operator.hold,
            power_on: self.off_until.is_none(),
            servo_power: hardware.drives_powered(),
            single_step: self.single_step,
            idle: self.is_idle(),
            faults: self.fault_count(),
            gripper: hardware.gripper.as_ref().map(Gripper::view),
            override_percent: hardware.override_percent,
            motion_queue: hardware.executor.queued(),
            tasks: self
                .tasks
                .iter()
                .filter_map(|task| self.task_state(task))
                .collect(),
            tags: hardware
                .tags
                .iter()
                .filter(|slot| slot.task.is_some())
                .map(|slot| TagView {
                    tag: slot.tag.to_string(),
                    port: slot.port,
                    state: slot.word().to_owned(),
                    peer: slot.connection().map(|connection| connection.peer),
                })
                .collect(),
            ports: hardware.ports.view(),
            fidelity: hardware.fidelity,
            generation: hardware.generation,
            note_seq: hardware.notes.last_seq(),
            active_alarms: hardware.alarms.active(),
            ledger_seq: hardware.ledger.last_seq(),
        }
    }

    fn task_state(&self, task: &Task) -> Option<TaskState> {
        let view = self.machine.task(task.id)?;
        let paused = self.machine.is_paused(task.id);
        let (state, detail) = task_in_words(&view.state, paused);
        let hint = match &view.state {
            karel::TaskState::Blocked(wait) if !paused => self.hardware.hint(wait),
            karel::TaskState::Blocked(_)
            | karel::TaskState::Ready
            | karel::TaskState::Ended
            | karel::TaskState::Aborted(_) => None,
        };
        Some(TaskState {
            name: view.name.to_string(),
            program: view.program.to_string(),
            state,
            line: view.line,
            detail,
            hint,
        })
    }
}

/// What a task does, and what it waits for or what ended it.
pub(crate) fn task_in_words(state: &karel::TaskState, paused: bool) -> (TaskWord, Option<String>) {
    match state {
        karel::TaskState::Ready | karel::TaskState::Blocked(_) if paused => {
            (TaskWord::Waiting, Some(wait_in_words(&Wait::Continue)))
        }
        karel::TaskState::Ready => (TaskWord::Running, None),
        karel::TaskState::Blocked(wait) => (TaskWord::Waiting, Some(wait_in_words(wait))),
        karel::TaskState::Ended => (TaskWord::Ended, None),
        karel::TaskState::Aborted(error) => (TaskWord::Aborted, Some(error.to_string())),
    }
}

fn wait_in_words(wait: &Wait) -> String {
    match wait {
        Wait::Readable(FileId::KEYBOARD) => "waits for the pendant's keyboard".to_owned(),
        Wait::ReadableUntil(FileId::KEYBOARD, time) => {
            format!(
                "waits for the pendant's keyboard until {:.3} s",
                seconds(*time)
            )
        }
        Wait::Readable(_) => "waits for bytes".to_owned(),
        Wait::ReadableUntil(_, time) => format!("waits for bytes until {:.3} s", seconds(*time)),
        Wait::Writable(_) => "waits until the peer takes bytes".to_owned(),
        Wait::Connect(tag) => format!("waits for a client on {tag}:"),
        Wait::MotionQueue => "waits for a place in the motion queue".to_owned(),
        Wait::Motion(motion) => format!("waits for the end of motion {}", motion.0),
        Wait::Continue => "is paused".to_owned(),
        Wait::Until(time) => format!("waits until {:.3} s", seconds(*time)),
    }
}
