//! The arm: motions in, ledger entries out.

use karel::{MotionId, MotionPath, MotionRequest, Progress, Status, TaskId, TpTarget, Value, Wait};
use kinematics::PendantJoints;
use units::MmPerSec;

use super::operator::Operator;
use super::{Hardware, MotionTag, Wake};
use crate::ledger::{LedgerEntry, LedgerEvent, MotionKind, seconds};
use crate::motion::planner::{pendant_joints, pose_mm_deg, pose_of_target};
use crate::motion::{Added, Motion, MotionEnd, Outcome, Path, Refusal};
use crate::sysvars::codes::motype;

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

/// How many ended motions are remembered for tasks that wait for them: more than can be queued.
const REMEMBERED_OUTCOMES: usize = 16;

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
            .and_then(|speed| self.karel_path(request, speed));
        Progress::Ready(self.take_planned(task, &tag, planned))
    }

    /// Queues a motion for which there is room, or refuses it.
    pub(super) fn take_planned(
        &mut self,
        task: TaskId,
        tag: &MotionTag,
        planned: Result<Path, Refusal>,
    ) -> Result<MotionId, Status> {
        match planned {
            Ok(path) => Ok(self.enqueue(tag, path)),
            Err(refusal) => {
                let status = refusal.status;
                self.refuse(tag, &refusal);
                let _replaced = self.refusals.insert(task, refusal);
                Err(status)
            }
        }
    }

    /// Whether, and how, a motion has ended.
    pub(super) fn outcome(&self, motion: MotionId) -> Progress<Status> {
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
        let joints = self.executor.joints(self.now);
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

    /// Ends the motions whose time has come.
    pub(crate) fn end_motions(&mut self) {
        self.note_holds();
        while let Some((end, started)) = self.executor.end_due(self.now) {
            let started = started.cloned();
            self.note_end(&end);
            if let Some(tag) = started {
                self.note_start(&tag);
            }
        }
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

    /// Brakes the running motion and drops the pending one.
    pub(crate) fn stop_arm(&mut self, reason: &str) {
        self.brake(reason, MOTN_CANCELLED);
    }

    /// As [`Self::stop_arm`], but who waits for the motion goes on with this status.
    pub(super) fn brake(&mut self, reason: &str, status: Status) {
        reason.clone_into(&mut self.stop_reason);
        self.stop_status = status;
        if let Some(dropped) = self.executor.stop(self.now) {
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
    fn karel_path(&self, request: &MotionRequest, speed: f64) -> Result<Path, Refusal> {
        let (frame, tool) = self.frames()?;
        let from = self.executor.tail();
        if let Some(joints) = &request.joints {
            self.planner.within_limits(joints)?;
            let to = pendant_joints(joints)?;
            return Ok(Path::joint(self.planner.model(), from, to, MmPerSec(speed)));
        }
        let motype = match request.path {
            MotionPath::Straight => Ok(motype::LINEAR),
            MotionPath::AsSet => self.variables.integer("$MOTYPE"),
        };
        let motype = motype.map_err(|status| Refusal::new(status, "$MOTYPE has no value"))?;
        let target = TpTarget::Cartesian(request.target);
        let (frames, speeds) = ((&frame, &tool), (speed, 1.0));
        match (motype, request.via) {
            (motype::CIRCULAR, Some(via)) => {
                let via = TpTarget::Cartesian(via);
                self.planner.circular(from, (&via, &target), frames, speeds)
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
                let model = self.planner.model();
                Ok(Path::joint(model, from, to, MmPerSec(speed)))
            }
            (motype::LINEAR, None) => self.planner.linear(from, &target, frames, speeds),
            (other, _) => {
                let text = format!("$MOTYPE = {other} is no motion type");
                Err(Refusal::new(MOTN_NOT_SIMULATED, text))
            }
        }
    }

    fn enqueue(&mut self, tag: &MotionTag, path: Path) -> MotionId {
        let id = tag.id;
        match self.executor.add(
            self.now,
            Motion {
                path,
                tag: tag.clone(),
            },
        ) {
            Added::Started => self.note_start(tag),
            // `queue_motion` has looked for room.
            Added::Waits | Added::NoRoom => {}
        }
        id
    }

    fn note_start(&mut self, tag: &MotionTag) {
        let rate = f64::from(self.override_percent) / 100.0;
        let Some(path) = self.executor.current().map(|motion| motion.path.clone()) else {
            return;
        };
        let mut entry = self.entry(LedgerEvent::Started, tag, path.from());
        entry.to_deg = Some(path.to().degrees().into());
        let duration_s = (rate > 0.0).then(|| to_micros(path.duration() / rate));
        entry.duration_s = duration_s;
        tracing::info!(
            controller = %self.name,
            motion = tag.id.0,
            request_id = tag.origin.request_id.as_deref(),
            peer = tag.origin.peer.map(tracing::field::display),
            speed_mm_s = tag.speed_mm_s,
            override_percent = self.override_percent,
            duration_s,
            "The arm starts motion {} to {}.",
            tag.id.0, tag.target,
        );
        self.ledger.push(entry);
        // The queue has moved up, or the motion went past it.
        self.wakes.push(Wake::MotionQueue);
    }

    fn note_end(&mut self, end: &MotionEnd<MotionTag>) {
        let tag = &end.motion.tag;
        let (event, status, word) = match end.outcome {
            Outcome::Finished => (LedgerEvent::Finished, Status::OK, "finished"),
            Outcome::Cancelled => (LedgerEvent::Cancelled, self.stop_status, "was stopped in"),
        };
        let mut entry = self.entry(event, tag, end.motion.path.from());
        entry.time_s = seconds(end.at);
        entry.to_deg = Some(end.joints.degrees().into());
        entry.duration_s = end
            .started
            .map(|started| seconds(end.at.saturating_sub(started)));
        if end.outcome == Outcome::Cancelled {
            entry.alarm = Some(self.stop_reason.clone());
        }
        tracing::info!(
            controller = %self.name,
            motion = tag.id.0,
            request_id = tag.origin.request_id.as_deref(),
            "The arm {word} motion {}.", tag.id.0,
        );
        self.ledger.push(entry);
        if self.outcomes.len() >= REMEMBERED_OUTCOMES {
            let _oldest = self.outcomes.pop_front();
        }
        self.outcomes.push_back((tag.id, status));
        self.wakes.extend([Wake::Motion(tag.id), Wake::MotionQueue]);
    }

    fn refuse(&mut self, tag: &MotionTag, refusal: &Refusal) {
        let mut entry = self.entry(LedgerEvent::Refused, tag, &self.executor.tail());
        entry.alarm = Some(refusal.headline());
        self.ledger.push(entry);
    }

    pub(super) fn entry(
        &self,
        event: LedgerEvent,
        tag: &MotionTag,
        from: &PendantJoints,
    ) -> LedgerEntry {
        LedgerEntry {
            seq: 0,
            time_s: seconds(self.now),
            event,
            motion: tag.id.0,
            kind: tag.kind,
            from_deg: from.degrees().into(),
            to_deg: None,
            target_pose: tag.target,
            speed_mm_s: tag.speed_mm_s,
            speed_percent: tag.speed_percent,
            command: tag.command,
            part: None,
            override_percent: self.override_percent,
            program: tag.program.to_string(),
            line: tag.line,
            peer: tag.origin.peer,
            request_id: tag.origin.request_id.clone(),
            alarm: None,
            duration_s: None,
        }
    }

    /// As `$MOTYPE` says, unless the statement says it.
    fn kind(&self, request: &MotionRequest) -> MotionKind {
        if request.joints.is_some() {
            return MotionKind::Joint;
        }
        if request.path == MotionPath::Straight {
            return MotionKind::Linear;
        }
        match self.variables.integer("$MOTYPE") {
            Ok(motype::LINEAR) => MotionKind::Linear,
            Ok(motype::CIRCULAR) => MotionKind::Circular,
            Ok(_) | Err(_) => MotionKind::Joint,
        }
    }

    /// A person moved the arm with the pendant.
    pub(super) fn note_jog(&mut self, from: &PendantJoints, to: &PendantJoints) {
        let tag = MotionTag {
            id: MotionId(0),
            task: TaskId(0),
            kind: MotionKind::Joint,
            target: pose_mm_deg(&self.planner.tcp_in_world(to, &karel::Position::default())),
            speed_mm_s: 0.0,
            speed_percent: None,
            command: None,
            program: "".into(),
            line: 0,
            origin: super::Origin::default(),
        };
        let mut entry = self.entry(LedgerEvent::Jogged, &tag, from);
        entry.to_deg = Some(to.degrees().into());
        self.ledger.push(entry);
    }

    /// The operator holds the arm: it brakes on its path, and what is added waits.
    pub(crate) fn hold_arm(&mut self, frozen: bool) {
        self.executor.hold(self.now, frozen);
        self.note_holds();
    }

    pub(super) fn live(&self, live: crate::sysvars::Live) -> Value {
        match live {
            crate::sysvars::Live::RobotMoves => Value::Boolean(self.executor.is_moving()),
            crate::sysvars::Live::SafetyStatus => Value::Integer(self.safety_status()),
            crate::sysvars::Live::ServoReady => {
                let Operator {
                    emergency_stop,
                    servo_off,
                    ..
                } = self.operator;
                Value::Boolean(!emergency_stop && !servo_off)
            }
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

fn to_micros(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}
