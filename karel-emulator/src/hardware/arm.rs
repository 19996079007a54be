//! The arm: motions in, ledger entries out.

use std::time::Duration;

use karel::{
    MotionId, MotionPath, MotionRequest, Position, Progress, Status, TaskId, TpTarget, Value, Wait,
};
use kinematics::PendantJoints;

use super::{Hardware, MotionTag};
use crate::ledger::LedgerEvent;
use crate::motion::convert::{pendant_joints, pose_of_target};
use crate::motion::linear::INTP_SPEED;
use crate::motion::path::SPEED_LIMIT;
use crate::motion::{
    Added, Brake, Happening, Motion, OnCircle, Pace, Path, Refusal, ToolSpeed, corner,
};
use crate::sysvars::codes::{motype, termtype};

/// MOTN-999: this controller does not simulate what the program asks for. A number of our own.
const MOTN_NOT_SIMULATED: Status = Status::new(15, 999);

/// MOTN-054: a position on the arc is missing, or there is one that nothing needs.
///
/// ASSUMPTION: the number is from memory of error lists; and that a VIA which no arc needs is refused.
const MOTN_VIA: Status = Status::new(15, 54);

/// MOTN-998: the motion was cancelled. A number of our own.
const MOTN_CANCELLED: Status = Status::new(15, 998);

/// The motion group of the arm; there is no other.
const GROUP: i32 = 1;

impl Hardware {
    /// Queues a motion, or says what to wait for, or refuses it.
    pub(super) fn queue_motion(
        &mut self,
        task: TaskId,
        request: &MotionRequest,
    ) -> Progress<Result<MotionId, Status>> {
        if !self.executor.has_room() {
            return Progress::Pending(Wait::MotionQueue);
        }
        self.last_motion += 1;
        let speed = self.variables.real("$SPEED").map(f64::from);
        let tag = MotionTag {
            id: MotionId(self.last_motion),
            task,
            kind: self.kind(request),
            speed_percent: None,
            command: None,
            target: pose_of_target(&request.target),
            speed_mm_s: *speed.as_ref().unwrap_or(&0.0),
            program: request.program.clone(),
            line: request.line,
            origin: self.origins.get(&task).cloned().unwrap_or_default(),
        };
        let planned = self
            .may_move()
            .and_then(|()| only_group(request.group))
            .and_then(|()| speed.map_err(|status| Refusal::new(status, "$SPEED has no value")))
            .and_then(|speed| {
                let (frame, tool) = self.frames()?;
                let path = self.karel_path(request, speed, (frame, tool))?;
                Ok(self.at_speed_of_mode(path, &tool))
            });
        let rounding = rounding_of(self.variables.integer("$TERMTYPE"));
        Progress::Ready(self.take_planned(task, &tag, planned, rounding))
    }

    /// Queues a motion for which there is room, or refuses it.
    pub(super) fn take_planned(
        &mut self,
        task: TaskId,
        tag: &MotionTag,
        planned: Result<Path, Refusal>,
        rounding: Option<f64>,
    ) -> Result<MotionId, Status> {
        match planned {
            Ok(path) => Ok(self.enqueue(tag, path, rounding)),
            Err(refusal) => {
                let status = refusal.status;
                self.refuse(tag, &refusal);
                let _replaced = self.refusals.insert(task, refusal);
                Err(status)
            }
        }
    }

    /// Whether, and how, a motion has met its termination criterion: at a corner that may be rounded, before its end.
    pub(super) fn outcome(&self, motion: MotionId) -> Progress<Status> {
        match self.standstill(motion) {
            Progress::Pending(_) if self.passed == Some(motion) => Progress::Ready(Status::OK),
            other @ (Progress::Pending(_) | Progress::Ready(_)) => other,
        }
    }

    /// Whether, and how, a motion has ended for good: the arm stands still, or another motion has taken over.
    pub(super) fn standstill(&self, motion: MotionId) -> Progress<Status> {
        let ended = self.outcomes.iter().find(|(id, _)| *id == motion);
        ended.map_or(Progress::Pending(Wait::Motion(motion)), |(_, status)| {
            Progress::Ready(*status)
        })
    }

    /// The position of the tool in the KAREL motion environment.
    pub(super) fn tool_position(
        &mut self,
        task: TaskId,
        group: i32,
    ) -> Result<karel::XyzwprExt, Status> {
        let joints = self.reported_joints();
        let position = only_group(group).and_then(|()| {
            let (frame, tool) = self.frames()?;
            self.planner.position(&joints, &frame, &tool)
        });
        position.map_err(|refusal| self.keep_refusal(task, refusal))
    }

    /// Keeps the words for the alarm that the status becomes.
    pub(super) fn keep_refusal(&mut self, task: TaskId, refusal: Refusal) -> Status {
        let status = refusal.status;
        let _replaced = self.refusals.insert(task, refusal);
        status
    }

    /// `$UFRAME` and `$UTOOL`.
    pub(crate) fn frames(&self) -> Result<(karel::Position, karel::Position), Refusal> {
        let frame = |name: &str| {
            self.variables
                .position(name)
                .map_err(|status| Refusal::new(status, format!("{name} has no value")))
        };
        Ok((frame("$UFRAME")?, frame("$UTOOL")?))
    }

    /// Notes what has become of the motions up to now.
    pub(crate) fn follow_motions(&mut self) {
        while let Some(happening) = self.executor.due(self.now) {
            match happening {
                Happening::Started(tag) => self.note_start(&tag),
                Happening::Passes(tag) => self.note_pass(&tag),
                Happening::Held(tag) => self.note_pause(LedgerEvent::Held, &tag),
                Happening::Ended(end) => self.note_end(&end),
            }
        }
        self.follow_drives();
    }

    /// Where programs see the arm.
    ///
    /// ASSUMPTION: while it moves, where it was at the last interpolation period.
    pub(super) fn reported_joints(&self) -> PendantJoints {
        let mut at = self.now;
        if self.executor.is_moving() {
            let into = at.as_nanos() % self.interpolation_period.duration().as_nanos();
            at -= Duration::from_nanos(u64::try_from(into).unwrap_or(0));
        }
        self.executor.joints(at)
    }

    /// The task ended with an error: the arm brakes if it moves for that task.
    ///
    /// ASSUMPTION: as the severity "abort" of an alarm is documented, a decelerated stop.
    pub(crate) fn stop_arm_of(&mut self, task: TaskId, reason: &str) {
        let mine = self
            .executor
            .current()
            .is_some_and(|motion| motion.tag.task == task);
        if mine {
            self.stop_arm(reason);
        }
    }

    /// Brakes what moves and drops the pending motion.
    pub(crate) fn stop_arm(&mut self, reason: &str) {
        self.brake(reason, MOTN_CANCELLED);
    }

    /// As [`Self::stop_arm`], but who waits for the motion goes on with this status.
    pub(super) fn brake(&mut self, reason: &str, status: Status) {
        reason.clone_into(&mut self.stop_reason);
        self.stop_status = status;
        if let Some(dropped) = self.executor.stop(self.now, Brake::Controlled) {
            self.note_end(&dropped);
        }
    }

    /// Follows `$MCR.$GENOVERRIDE`.
    pub(crate) fn follow_override(&mut self) {
        if let Ok(percent) = self.variables.integer("$MCR.$GENOVERRIDE")
            && let percent = self
                .override_limit
                .map_or(percent, |limit| percent.min(limit))
            && percent != self.override_percent
        {
            self.override_percent = percent;
            self.executor.set_rate(self.now, f64::from(percent) / 100.0);
        }
    }

    /// The way of a MOVE, as `$MOTYPE` says.
    fn karel_path(
        &self,
        request: &MotionRequest,
        speed: f64,
        (frame, tool): (Position, Position),
    ) -> Result<Path, Refusal> {
        let from = self.executor.tail();
        if let Some(joints) = &request.joints {
            self.planner.within_limits(joints)?;
            let to = pendant_joints(joints)?;
            return self.joint_path(from, to, speed);
        }
        let motype = match request.path {
            MotionPath::Straight => Ok(motype::LINEAR),
            MotionPath::AsSet => self.variables.integer("$MOTYPE"),
        };
        let motype = motype.map_err(|status| Refusal::new(status, "$MOTYPE has no value"))?;
        let target = TpTarget::Cartesian(request.target);
        let rotation_deg_s = self
            .variables
            .real("$ROTSPEED")
            .map_or(f64::INFINITY, f64::from);
        let pace = Pace {
            speed: ToolSpeed::MmPerSec(speed),
            rotation_deg_s,
            acceleration: 1.0,
        };
        let (frames, pace) = ((&frame, &tool), (&pace, false));
        match (motype, request.via) {
            (motype::CIRCULAR, Some(via)) => {
                let via = TpTarget::Cartesian(via);
                let via = (&via, OnCircle::OnTheWay, &target);
                self.planner.circular(from, via, frames, pace)
            }
            (motype::CIRCULAR, None) => {
                let text = "A MOVE with $MOTYPE = CIRCULAR needs a VIA";
                Err(Refusal::new(MOTN_VIA, text))
            }
            (motype::JOINT | motype::LINEAR, Some(_)) => {
                let text = "A MOVE with VIA needs $MOTYPE = CIRCULAR";
                Err(Refusal::new(MOTN_VIA, text))
            }
            (motype::JOINT, None) => {
                let to = self.planner.joints(&request.target, &frame, &tool)?;
                self.joint_path(from, to, speed)
            }
            (motype::LINEAR, None) => self.planner.linear(from, &target, frames, pace),
            (other, _) => {
                let text = format!("$MOTYPE = {other} is no motion type");
                Err(Refusal::new(MOTN_NOT_SIMULATED, text))
            }
        }
    }

    /// All axes together, at `$SPEED` of `$SPEEDLIM`.
    fn joint_path(
        &self,
        from: PendantJoints,
        to: PendantJoints,
        speed: f64,
    ) -> Result<Path, Refusal> {
        let limit = self
            .variables
            .real("$SPEEDLIM")
            .map_or(SPEED_LIMIT.0, f64::from);
        if speed > limit {
            let text = format!("$SPEED is {speed}, $SPEEDLIM is {limit}");
            return Err(Refusal::new(INTP_SPEED, text));
        }
        let model = self.planner.model();
        Ok(Path::joint_at(model, from, to, speed / limit, 1.0))
    }

    fn enqueue(&mut self, tag: &MotionTag, path: Path, rounding: Option<f64>) -> MotionId {
        let id = tag.id;
        let motion = Motion {
            path,
            rounding,
            tag: tag.clone(),
        };
        let model = self.planner.model();
        let round =
            |before: &Path, after: &Path, overlap| corner::plan(model, before, after, overlap);
        match self.executor.add(self.now, motion, round) {
            Added::Started => self.note_start(tag),
            // `queue_motion` has looked for room.
            Added::Waits | Added::NoRoom => {}
        }
        id
    }

    /// The operator holds the arm: it brakes on its path, and what is added waits.
    pub(crate) fn hold_arm(&mut self, frozen: bool) {
        self.executor.hold(self.now, frozen, Brake::Controlled);
        self.follow_motions();
    }

    /// `$PRO_CFG.$INS_PWR`.
    ///
    /// ASSUMPTION: 0.1 kW for the electronics, 0.15 kW for servos with power, and 5 W for each degree a second of each joint:
    /// enough to see a motion in a client's diagram, and no measurement.
    fn power_kw(&self) -> f32 {
        const PERIOD: std::time::Duration = std::time::Duration::from_millis(1);
        if !self.drives_powered() {
            return 0.1;
        }
        let now = self.executor.joints(self.now).degrees();
        let before = self.executor.joints(self.now.saturating_sub(PERIOD));
        let traveled = now.iter().zip(before.degrees()).map(|(a, b)| (a - b).abs());
        let deg_per_s: f64 = traveled.sum::<f64>() / PERIOD.as_secs_f64();
        #[expect(clippy::cast_possible_truncation, reason = "a few kilowatts")]
        let moving = (0.005 * deg_per_s) as f32;
        0.25 + moving
    }

    pub(super) fn live(&self, live: crate::sysvars::Live) -> Value {
        match live {
            crate::sysvars::Live::RobotMoves => Value::Boolean(self.executor.is_moving()),
            crate::sysvars::Live::Power => Value::Real(self.power_kw()),
            crate::sysvars::Live::SafetyStatus => Value::Integer(self.safety_status()),
            crate::sysvars::Live::ServoReady => Value::Boolean(self.drives_powered()),
            crate::sysvars::Live::FastClock => {
                let wrapped = self.now.as_millis() % (1 << 31);
                Value::Integer(i32::try_from(wrapped).unwrap_or(0))
            }
        }
    }
}

/// Refuses any group but the arm's.
pub(super) fn only_group(group: i32) -> Result<(), Refusal> {
    if group == GROUP {
        Ok(())
    } else {
        let text = format!("motion group {group} does not exist, this controller has group 1 only");
        Err(Refusal::new(Status::MOTN_UNREACHABLE, text))
    }
}

/// How much the corner behind a MOVE is rounded, as `$TERMTYPE` says.
///
/// ASSUMPTION: NODECEL as CNT100, VARDECEL as CNT50; FINE, COARSE and NOSETTLE end at a standstill, which takes no
/// time to settle here.
fn rounding_of(termtype: Result<i32, Status>) -> Option<f64> {
    match termtype {
        Ok(termtype::NODECEL) => Some(100.0),
        Ok(termtype::VARDECEL) => Some(50.0),
        Ok(_) | Err(_) => None,
    }
}
