//! The interpreter's view of the controller.

use std::time::Duration;

use karel::{
    AlarmView, FileId, FileOperation, HandAction, Host, Input, JointPosition, MotionId,
    MotionRequest, OpenMode, Port, PortValue, Position, ProgramAlarm, Progress, Registers,
    RuntimeError, Status, SysPath, SysValue, TaskId, TpMotion, Value, XyzwprExt,
};

use super::Hardware;
use super::arm::only_group;
use super::operator::OperatingMode;
use crate::motion::convert::{joint_position, pendant_joints};
use crate::ports::SetInputError;
use crate::sysvars::Reading;

impl Host for Hardware {
    fn now(&self) -> Duration {
        self.now
    }

    fn interpolation_period(&self) -> Duration {
        self.interpolation_period.duration()
    }

    fn reset(&mut self) -> bool {
        self.reset_alarms()
    }

    fn explain(&mut self, _task: TaskId, place: (&str, u32), why: &dyn Fn() -> String) {
        if self.is_kind() {
            self.note(Some(place), why());
        }
    }

    fn msg_connect(&mut self, task: TaskId, tag: &str) -> Progress<Status> {
        self.connect(task, tag)
    }

    fn msg_disco(&mut self, task: TaskId, tag: &str) -> Status {
        self.disconnect(task, tag)
    }

    fn open_file(&mut self, task: TaskId, mode: OpenMode, name: &str) -> Result<FileId, Status> {
        self.open(task, mode, name)
    }

    fn close_file(&mut self, file: FileId) -> Status {
        self.close(file)
    }

    fn cancel_file(&mut self, file: FileId) -> Status {
        self.cancel(file)
    }

    fn input(&self, file: FileId) -> Input<'_> {
        self.input_of(file)
    }

    fn consume(&mut self, file: FileId, count: usize) {
        self.consume_input(file, count);
    }

    fn output(&mut self, file: FileId, bytes: &[u8]) -> Progress<Status> {
        self.write(file, bytes)
    }

    fn display(&mut self, _task: TaskId, text: &[u8]) {
        self.show(text);
    }

    fn system_variable(&self, _task: TaskId, path: &SysPath) -> Result<Value, Status> {
        match self.variables.get(path)? {
            Reading::Value(value) => Ok(value),
            Reading::Live(live) => Ok(self.live(live)),
        }
    }

    fn set_system_variable(
        &mut self,
        _task: TaskId,
        path: &SysPath,
        value: SysValue,
    ) -> Result<(), Status> {
        self.variables.set(path, value)?;
        self.follow_override();
        Ok(())
    }

    fn current_position(&mut self, task: TaskId, group: i32) -> Result<XyzwprExt, Status> {
        self.tool_position(task, group)
    }

    fn check_position(
        &mut self,
        _task: TaskId,
        position: &XyzwprExt,
        user_frame: &Position,
        tool: &Position,
        group: i32,
    ) -> Status {
        let solved =
            only_group(group).and_then(|()| self.planner.joints(position, user_frame, tool));
        match solved {
            Ok(_) => Status::OK,
            Err(refusal) => {
                tracing::info!(
                    controller = %self.name,
                    "CHECK_EPOS answers {}: {}.", refusal.status, refusal.text,
                );
                let text = format!("CHECK_EPOS answers {}: {}", refusal.status, refusal.text);
                self.note(None, text);
                refusal.status
            }
        }
    }

    fn port(&self, port: Port, number: i32) -> Result<PortValue, Status> {
        if matches!(port, Port::PanelIn | Port::PanelOut) {
            return self.panel_port(port, number);
        }
        self.ports.get(port, number)
    }

    fn set_port(
        &mut self,
        task: TaskId,
        port: Port,
        number: i32,
        value: PortValue,
    ) -> Result<(), Status> {
        if self.ports.set(port, number, value)? {
            tracing::debug!(
                controller = %self.name, task = task.0,
                "A program set {port}[{number}] to {value:?}.",
            );
        }
        self.gripper_output(port, number, value);
        Ok(())
    }

    fn port_is_simulated(&self, port: Port, number: i32) -> bool {
        u16::try_from(number).is_ok_and(|number| self.ports.is_simulated(port, number))
    }

    fn simulate_port(
        &mut self,
        _task: TaskId,
        port: Port,
        number: i32,
        value: Option<PortValue>,
    ) -> Result<(), Status> {
        let number = u16::try_from(number).map_err(|_| Status::PRIO_PORT_NUMBER)?;
        let done = match value {
            Some(value) => self.ports.simulate(port, number, value),
            None => self.ports.end_simulation(port, number),
        };
        done.map_err(|error| match error {
            SetInputError::NoSuchPort { .. } => Status::PRIO_PORT_NUMBER,
            SetInputError::NotAnInput { .. }
            | SetInputError::Value { .. }
            | SetInputError::Stopped(_) => Status::INTP_ARGUMENT,
        })
    }

    fn hand(&mut self, task: TaskId, action: HandAction, number: i32) -> Result<(), Status> {
        self.move_hand(task, action, number)
    }

    /// ASSUMPTION: what was asked for before is not forgotten.
    fn enable_request(&mut self, _task: TaskId, number: i32, on: bool) -> Result<(), Status> {
        let index = u32::try_from(number).ok().and_then(|n| n.checked_sub(1));
        let Some(bit) = index.and_then(|index| 1_u8.checked_shl(index)) else {
            return Err(Status::INTP_ARGUMENT);
        };
        if on {
            self.requests_off &= !bit;
        } else {
            self.requests_off |= bit;
        }
        Ok(())
    }

    fn current_joints(&mut self, task: TaskId, group: i32) -> Result<JointPosition, Status> {
        only_group(group).map_err(|refusal| self.keep_refusal(task, refusal))?;
        Ok(joint_position(&self.reported_joints()))
    }

    fn check_joints(&mut self, _task: TaskId, joints: &JointPosition, group: i32) -> Status {
        let checked = only_group(group).and_then(|()| self.planner.within_limits(joints));
        checked.err().map_or(Status::OK, |refusal| refusal.status)
    }

    fn joints_to_position(
        &mut self,
        _task: TaskId,
        joints: &JointPosition,
        user_frame: &Position,
        tool: &Position,
        group: i32,
    ) -> Result<XyzwprExt, Status> {
        let position = only_group(group).and_then(|()| {
            let joints = pendant_joints(joints)?;
            self.planner.position(&joints, user_frame, tool)
        });
        position.map_err(|refusal| refusal.status)
    }

    fn position_to_joints(
        &mut self,
        _task: TaskId,
        position: &XyzwprExt,
        user_frame: &Position,
        tool: &Position,
        group: i32,
    ) -> Result<JointPosition, Status> {
        let solved =
            only_group(group).and_then(|()| self.planner.joints(position, user_frame, tool));
        let joints = solved.map_err(|refusal| refusal.status)?;
        Ok(joint_position(&joints))
    }

    fn start_motion(
        &mut self,
        task: TaskId,
        motion: MotionRequest,
    ) -> Progress<Result<MotionId, Status>> {
        self.queue_motion(task, &motion)
    }

    fn motion_ended(&mut self, motion: MotionId) -> Progress<Status> {
        self.outcome(motion)
    }

    fn motion_left(&self, motion: MotionId) -> Option<Duration> {
        let running = self.executor.current()?.tag.id == motion;
        let end = self.executor.next_due().filter(|_| running)?;
        Some(end.saturating_sub(self.now))
    }

    fn motion_rests(&mut self, motion: MotionId) -> Progress<Status> {
        self.standstill(motion)
    }

    fn start_tp_motion(
        &mut self,
        task: TaskId,
        motion: TpMotion,
        registers: &Registers,
    ) -> Progress<Result<MotionId, Status>> {
        self.queue_tp_motion(task, &motion, registers)
    }

    fn hold_motions(&mut self, task: TaskId) {
        self.hold_motions_of(task);
    }

    fn continue_motions(&mut self, task: TaskId) {
        self.continue_motions_of(task);
    }

    fn in_auto_mode(&self) -> bool {
        self.operator.mode == OperatingMode::Auto
    }

    fn pendant_enabled(&self) -> bool {
        self.operator.pendant
    }

    fn alarm(&self, newest: i32) -> Option<AlarmView> {
        self.alarm_view(newest)
    }

    fn cancel_arm(&mut self, task: TaskId) {
        let reason = format!("CANCEL by task {}", task.0);
        self.brake(&reason, Status::OK);
    }

    fn hold_arm(&mut self, _task: TaskId) {
        Hardware::hold_arm(self, false);
    }

    fn resume_arm(&mut self, _task: TaskId) {
        Hardware::resume_arm(self);
    }

    fn ping(&mut self, _task: TaskId, host: &str) -> Status {
        self.answer_of(host)
    }

    fn raise_alarm(&mut self, task: TaskId, alarm: ProgramAlarm) {
        self.alarm_of_program(task, &alarm);
    }

    fn file_operation(&mut self, _task: TaskId, operation: FileOperation<'_>) -> Status {
        let status = self.devices.operate(operation);
        self.keep_files();
        status
    }

    fn list_files(&mut self, _task: TaskId, pattern: &str) -> Result<Vec<String>, Status> {
        self.devices.list(pattern)
    }

    fn cancel_motions(&mut self, task: TaskId) {
        self.stop_arm_of(task, "The task was aborted by another");
    }

    fn post_alarm(&mut self, task: TaskId, alarm: &RuntimeError) {
        self.post_error(task, alarm);
    }
}
