//! The gripper at work.

use std::time::Duration;

use karel::{Port, PortValue};
use kinematics::Pose;

use super::{Hardware, MotionTag, Origin};
use crate::gripper::{GripperConfig, GripperPosition, GripperView, SharedWorkpieces};
use crate::ledger::{LedgerEvent, MotionKind};

/// A gripper and what is in it.
///
/// ASSUMPTION: it holds its position without power, and moves only when a program changes the output; so a controller
/// that is switched on again, all outputs off, does not drop the part.
#[derive(Debug)]
pub(crate) struct Gripper {
    config: GripperConfig,
    workpieces: Option<SharedWorkpieces>,
    position: GripperPosition,
    /// When it arrives, while it moves and is not jammed.
    arrives: Option<Duration>,
    jammed: bool,
    part: Option<String>,
}

impl Gripper {
    pub(crate) fn new(config: GripperConfig, workpieces: Option<SharedWorkpieces>) -> Self {
        Self {
            config,
            workpieces,
            position: GripperPosition::Open,
            arrives: None,
            jammed: false,
            part: None,
        }
    }

    pub(crate) fn view(&self) -> GripperView {
        GripperView {
            position: self.position,
            jammed: self.jammed,
            part: self.part.clone(),
        }
    }

    fn is_moving(&self) -> bool {
        matches!(
            self.position,
            GripperPosition::Opening | GripperPosition::Closing
        )
    }
}

impl Hardware {
    /// A program set the output to this level.
    pub(super) fn gripper_output(&mut self, port: Port, number: i32, value: PortValue) {
        let now = self.now;
        let Some(gripper) = &mut self.gripper else {
            return;
        };
        if port != Port::DigitalOut || number != i32::from(gripper.config.close_output) {
            return;
        }
        let close = value == PortValue::Switch(true);
        let heads_there = match gripper.position {
            GripperPosition::Open | GripperPosition::Opening => !close,
            GripperPosition::Closed | GripperPosition::Closing => close,
        };
        if heads_there {
            return;
        }
        gripper.position = if close {
            GripperPosition::Closing
        } else {
            GripperPosition::Opening
        };
        gripper.arrives = (!gripper.jammed).then(|| now + gripper.config.travel);
        self.show_gripper();
    }

    /// When the gripper arrives.
    pub(crate) fn gripper_arrives(&self) -> Option<Duration> {
        self.gripper.as_ref().and_then(|gripper| gripper.arrives)
    }

    /// Ends the gripper's travel if its time has come.
    pub(crate) fn end_gripping(&mut self) {
        let due = self.gripper_arrives().filter(|at| *at <= self.now);
        if due.is_none() {
            return;
        }
        let tcp = self.tcp_in_world();
        let name = self.name.clone();
        let Some(gripper) = &mut self.gripper else {
            return;
        };
        gripper.arrives = None;
        let mut event = None;
        match gripper.position {
            GripperPosition::Closing => {
                gripper.position = GripperPosition::Closed;
                if gripper.part.is_none()
                    && let Some(SharedWorkpieces(workpieces)) = &gripper.workpieces
                {
                    gripper.part = workpieces.close_at(&name, &tcp);
                    event = gripper
                        .part
                        .clone()
                        .map(|part| (LedgerEvent::Gripped, part));
                }
            }
            GripperPosition::Opening => {
                gripper.position = GripperPosition::Open;
                if let Some(part) = gripper.part.take() {
                    if let Some(SharedWorkpieces(workpieces)) = &gripper.workpieces {
                        workpieces.open_at(&name, &part, &tcp);
                    }
                    event = Some((LedgerEvent::Released, part));
                }
            }
            GripperPosition::Open | GripperPosition::Closed => {}
        }
        self.show_gripper();
        if let Some((event, part)) = event {
            self.note_part(event, part, &tcp);
        }
    }

    /// The gripper cannot move any more, or can again. `false` if there is no gripper.
    pub(crate) fn jam_gripper(&mut self, jammed: bool) -> bool {
        let now = self.now;
        let Some(gripper) = &mut self.gripper else {
            return false;
        };
        gripper.jammed = jammed;
        let moves = gripper.is_moving() && !jammed;
        gripper.arrives = moves.then(|| now + gripper.config.travel);
        true
    }

    /// The part falls out of the gripper. `false` if there is none in it.
    pub(crate) fn lose_part(&mut self) -> bool {
        let lost = self
            .gripper
            .as_mut()
            .and_then(|gripper| gripper.part.take());
        let Some(part) = lost else {
            return false;
        };
        let tcp = self.tcp_in_world();
        self.show_gripper();
        self.note_part(LedgerEvent::Lost, part, &tcp);
        true
    }

    /// Puts the state of the gripper on its inputs.
    pub(super) fn show_gripper(&mut self) {
        let Some(gripper) = &self.gripper else {
            return;
        };
        let GripperConfig {
            closed_input,
            open_input,
            part_input,
            ..
        } = gripper.config;
        let levels = [
            (closed_input, gripper.position == GripperPosition::Closed),
            (open_input, gripper.position == GripperPosition::Open),
            (part_input, gripper.part.is_some()),
        ];
        for (number, on) in levels {
            // An input that does not exist was refused when the controller was built.
            let _changed = self
                .ports
                .set(Port::DigitalIn, number.into(), PortValue::Switch(on));
        }
    }

    /// The tool center point of the active tool in the world.
    fn tcp_in_world(&self) -> Pose {
        let joints = self.executor.joints(self.now);
        let tool = self.tp_frames().map(|(_, tool)| tool).unwrap_or_default();
        self.planner.tcp_in_world(&joints, &tool)
    }

    fn note_part(&mut self, event: LedgerEvent, part: String, tcp: &Pose) {
        let joints = self.executor.joints(self.now);
        let tag = MotionTag {
            id: karel::MotionId(0),
            task: karel::TaskId(0),
            kind: MotionKind::Joint,
            target: crate::motion::convert::pose_mm_deg(tcp),
            speed_mm_s: 0.0,
            speed_percent: None,
            command: None,
            program: "".into(),
            line: 0,
            origin: Origin::default(),
        };
        tracing::info!(controller = %self.name, part, "The gripper: {event:?}.");
        let mut entry = self.entry(event, &tag, &joints);
        entry.part = Some(part);
        self.ledger.push(entry);
    }
}
