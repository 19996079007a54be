//! Motions of TP programs, and holding what moves.

use karel::{
    Interpolation, MotionId, Number, Position, Progress, Registers, Status, TaskId, TpMotion,
    TpSpeed, TpTarget, Wait,
};
use kinematics::{ArmModel, PendantJoints};

use super::{Hardware, MotionTag};
use crate::ledger::{CommandId, LedgerEvent, MotionKind, PoseMmDeg};
use crate::motion::convert::{joint_position, pendant_joints, pose_of_target};
use crate::motion::linear::INTP_SPEED;
use crate::motion::path::SPEED_LIMIT;
use crate::motion::{OnCircle, Pace, Path, Refusal, ToolSpeed};

/// PROG-040: another task moves the motion group.
///
/// ASSUMPTION: the number is from memory of error lists.
const PROG_LOCKED: Status = Status::new(3, 40);
impl Hardware {
    /// Queues a motion of a TP program, or says what to wait for, or refuses it.
    pub(super) fn queue_tp_motion(
        &mut self,
        task: TaskId,
        motion: &TpMotion,
        registers: &Registers,
    ) -> Progress<Result<MotionId, Status>> {
        if !self.executor.has_room() {
            return Progress::Pending(Wait::MotionQueue);
        }
        self.last_motion += 1;
        let (kind, speed_mm_s, speed_percent) = speed_of(motion);
        let tag = MotionTag {
            id: MotionId(self.last_motion),
            task,
            kind,
            target: self.tp_target_pose(&motion.target),
            speed_mm_s,
            speed_percent,
            command: self.command_of(registers),
            program: motion.program.clone(),
            line: motion.line,
            origin: self.origins.get(&task).cloned().unwrap_or_default(),
        };
        let planned = self
            .may_move()
            .and_then(|()| self.group_is_free(task))
            .and_then(|()| self.tp_path(motion));
        let rounding = motion.rounding_percent.map(f64::from);
        Progress::Ready(self.take_planned(task, &tag, planned, rounding))
    }

    /// Pauses what a task moves; the arm brakes on its path.
    pub(crate) fn hold_motions_of(&mut self, task: TaskId) {
        let mine = self
            .executor
            .current()
            .is_some_and(|motion| motion.tag.task == task);
        if mine {
            self.hold_arm(false);
        }
    }

    /// Lets the held motion of a task go on, unless the operator holds everything.
    pub(crate) fn continue_motions_of(&mut self, task: TaskId) {
        let mine = self
            .executor
            .current()
            .is_some_and(|motion| motion.tag.task == task);
        if mine && !self.operator.hold {
            self.resume_arm();
        }
    }

    /// What was held goes on.
    pub(crate) fn resume_arm(&mut self) {
        let resumed = self.executor.resume(self.now).cloned();
        if let Some(tag) = resumed {
            self.note_pause(LedgerEvent::Resumed, &tag);
        }
    }

    pub(super) fn note_pause(&mut self, event: LedgerEvent, tag: &MotionTag) {
        let joints = self.executor.joints(self.now);
        let entry = self.entry(event, tag, &joints);
        self.ledger.push(entry);
    }

    /// The frames that are selected for TP programs.
    pub(crate) fn tp_frames(&self) -> Result<(Position, Position), Refusal> {
        let selected = |number: &str, frame: &str| {
            let unreadable = |status| Refusal::new(status, format!("{number} has no value"));
            match self.variables.integer(number).map_err(unreadable)? {
                // Number 0 is the world, or the flange.
                0 => Ok(Position::default()),
                n => {
                    let name = format!("{frame}[1,{n}]");
                    let found = self.variables.position(&name);
                    found.map_err(|status| Refusal::new(status, format!("{name} has no value")))
                }
            }
        };
        Ok((
            selected("$MNUFRAMENUM[1]", "$MNUFRAME")?,
            selected("$MNUTOOLNUM[1]", "$MNUTOOL")?,
        ))
    }

    /// Which command the program carries out, if the configuration says where it notes that.
    fn command_of(&self, registers: &Registers) -> Option<CommandId> {
        let (epoch, seq) = self.command_registers?;
        let number = |n: u16| match registers.number(n.into()) {
            Ok(Number::Integer(value)) => u32::try_from(value).ok(),
            Ok(Number::Real(_)) | Err(_) => None,
        };
        Some(CommandId {
            epoch: number(epoch)?,
            seq: number(seq)?,
        })
    }

    fn group_is_free(&self, task: TaskId) -> Result<(), Refusal> {
        let other = self
            .executor
            .current()
            .filter(|motion| motion.tag.task != task);
        match other {
            None => Ok(()),
            Some(motion) => {
                let text = format!("The program {} moves the arm", motion.tag.program);
                Err(Refusal::new(PROG_LOCKED, text))
            }
        }
    }

    fn tp_path(&self, motion: &TpMotion) -> Result<Path, Refusal> {
        let acceleration = f64::from(motion.acceleration_percent) / 100.0;
        // NaN fails every comparison.
        if !(acceleration > 0.0 && acceleration <= 1.5) {
            let percent = motion.acceleration_percent;
            return Err(refused(format!(
                "ACC is {percent}, it must be above 0 and at most 150"
            )));
        }
        let (frame, tool) = self.tp_frames()?;
        let frames = (&frame, &tool);
        let from = self.executor.tail();
        let target = self.tp_end(motion, &motion.target, &from, frames)?;
        if motion.interpolation == Interpolation::Joint {
            let path = self.tp_joint_path((motion, &target), from, frames, acceleration)?;
            return Ok(self.at_speed_of_mode(path, &tool));
        }
        let pace = Pace {
            speed: tool_speed(motion.speed)?,
            rotation_deg_s: f64::INFINITY,
            acceleration,
        };
        let pace = (&pace, motion.wrist_joint);
        let path = match &motion.via {
            None => self.planner.linear(from, &target, frames, pace),
            Some(via) => {
                let via = self.tp_end(motion, via, &from, frames)?;
                let place = match motion.interpolation {
                    Interpolation::CircleArc => OnCircle::Elsewhere,
                    Interpolation::Joint | Interpolation::Linear | Interpolation::Circular => {
                        OnCircle::OnTheWay
                    }
                };
                self.planner
                    .circular(from, (&via, place, &target), frames, pace)
            }
        };
        Ok(self.at_speed_of_mode(path?, &tool))
    }

    fn tp_joint_path(
        &self,
        (motion, target): (&TpMotion, &TpTarget),
        from: PendantJoints,
        (frame, tool): (&Position, &Position),
        acceleration: f64,
    ) -> Result<Path, Refusal> {
        let to = match target {
            TpTarget::Cartesian(position) => self.planner.joints(position, frame, tool)?,
            TpTarget::Joints(joints) => {
                self.planner.within_limits(joints)?;
                pendant_joints(joints)?
            }
        };
        let model = self.planner.model();
        let to = if motion.least_rotation {
            nearest_turns(model, from, to)
        } else {
            to
        };
        let path = |part: f64| Path::joint_at(model, from, to, part, acceleration);
        match motion.speed {
            TpSpeed::Percent(percent) if percent > 0.0 && percent <= 100.0 => {
                Ok(path(f64::from(percent) / 100.0))
            }
            TpSpeed::Percent(percent) => Err(refused(format!(
                "The speed is {percent} %, it must be above 0 and at most 100"
            ))),
            TpSpeed::Seconds(seconds) => {
                path(1.0).lasting(f64::from(seconds)).map_err(|shortest| {
                    refused(format!(
                        "The motion cannot take {seconds} s, {shortest:.3} s is the shortest"
                    ))
                })
            }
            TpSpeed::MmPerSec(_) | TpSpeed::DegPerSec(_) | TpSpeed::Greatest => Err(refused(
                "The unit of the speed does not fit the motion".to_owned(),
            )),
        }
    }

    /// A position of a motion; of `INC`, counted from where the motion starts, both of them of a `C`.
    fn tp_end(
        &self,
        motion: &TpMotion,
        position: &TpTarget,
        from: &PendantJoints,
        (frame, tool): (&Position, &Position),
    ) -> Result<TpTarget, Refusal> {
        if !motion.incremental {
            return Ok(position.clone());
        }
        Ok(match position {
            TpTarget::Joints(by) => {
                let mut joints = joint_position(from);
                for (axis, by) in joints.axes.iter_mut().zip(&by.axes) {
                    *axis += by;
                }
                TpTarget::Joints(joints)
            }
            TpTarget::Cartesian(by) => {
                let mut end = self.planner.position(from, frame, tool)?;
                end.x += by.x;
                end.y += by.y;
                end.z += by.z;
                end.w += by.w;
                end.p += by.p;
                end.r += by.r;
                TpTarget::Cartesian(end)
            }
        })
    }

    fn tp_target_pose(&self, target: &TpTarget) -> PoseMmDeg {
        match target {
            TpTarget::Cartesian(position) => pose_of_target(position),
            TpTarget::Joints(joints) => {
                let joints = pendant_joints(joints).ok();
                let frames = self.tp_frames().ok();
                let pose = joints
                    .zip(frames)
                    .and_then(|(joints, (frame, tool))| self.planner.pose(&joints, &frame, &tool));
                pose.unwrap_or_default()
            }
        }
    }
}

/// A speed of the tool that can be.
fn tool_speed(speed: TpSpeed) -> Result<ToolSpeed, Refusal> {
    let limit = SPEED_LIMIT.0;
    match speed {
        TpSpeed::MmPerSec(speed) => {
            let speed = f64::from(speed);
            if speed > 0.0 && speed <= limit {
                return Ok(ToolSpeed::MmPerSec(speed));
            }
            Err(refused(format!(
                "The speed is {speed} mm/s, it must be above 0 and at most {limit}"
            )))
        }
        TpSpeed::Greatest => Ok(ToolSpeed::Greatest),
        TpSpeed::DegPerSec(speed) if speed > 0.0 => Ok(ToolSpeed::DegPerSec(speed.into())),
        TpSpeed::Seconds(seconds) if seconds > 0.0 => Ok(ToolSpeed::Seconds(seconds.into())),
        TpSpeed::DegPerSec(_) | TpSpeed::Seconds(_) | TpSpeed::Percent(_) => {
            Err(refused(format!("{speed:?} is no speed of this motion")))
        }
    }
}

/// The same place with J4 and J6 turned as little as possible, inside of their limits.
///
/// ASSUMPTION: the wrist is not turned over.
fn nearest_turns(model: &ArmModel, from: PendantJoints, to: PendantJoints) -> PendantJoints {
    let mut nearest = to;
    for axis in [3, 5] {
        let turned = (-2_i32..=2).filter_map(|turns| {
            let mut degrees = nearest.degrees();
            *degrees.get_mut(axis)? += 360.0 * f64::from(turns);
            let joints = PendantJoints::try_from_degrees(degrees).ok()?;
            model.check_limits(&joints).is_ok().then_some(joints)
        });
        let way = |joints: &PendantJoints| {
            let [a, b] = [joints, &from].map(|joints| joints.degrees().get(axis).copied());
            (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs()
        };
        nearest = turned
            .min_by(|a, b| way(a).total_cmp(&way(b)))
            .unwrap_or(nearest);
    }
    nearest
}

fn refused(text: String) -> Refusal {
    Refusal::new(INTP_SPEED, text)
}

/// Kind, speed in mm/s, and speed in percent if it is one. A percentage stands for that part of `$SPEEDLIM`; a time or a
/// rotation is no such speed, and is 0.
fn speed_of(motion: &TpMotion) -> (MotionKind, f64, Option<f64>) {
    let kind = match motion.interpolation {
        Interpolation::Joint => MotionKind::Joint,
        Interpolation::Linear => MotionKind::Linear,
        Interpolation::Circular | Interpolation::CircleArc => MotionKind::Circular,
    };
    match motion.speed {
        TpSpeed::MmPerSec(speed) => (kind, f64::from(speed), None),
        TpSpeed::Percent(percent) => {
            let percent = f64::from(percent);
            (kind, percent / 100.0 * SPEED_LIMIT.0, Some(percent))
        }
        TpSpeed::DegPerSec(_) | TpSpeed::Seconds(_) | TpSpeed::Greatest => (kind, 0.0, None),
    }
}
