//! What the ledger and those who wait are told of motions.

use karel::{MotionId, MotionPath, MotionRequest, Status, TaskId};
use kinematics::PendantJoints;

use super::{Hardware, MotionTag, Wake};
use crate::ledger::{LedgerEntry, LedgerEvent, MotionKind, seconds};
use crate::motion::convert::pose_mm_deg;
use crate::motion::{MotionEnd, Outcome, Refusal};
use crate::sysvars::codes::motype;

/// How many ended motions are remembered for tasks that wait for them: more than can be queued.
const REMEMBERED_OUTCOMES: usize = 16;

impl Hardware {
    pub(super) fn note_start(&mut self, tag: &MotionTag) {
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

    /// The program that waits for the motion goes on.
    pub(super) fn note_pass(&mut self, tag: &MotionTag) {
        self.passed = Some(tag.id);
        self.wakes.push(Wake::Motion(tag.id));
    }

    pub(super) fn note_end(&mut self, end: &MotionEnd<MotionTag>) {
        let tag = &end.motion.tag;
        let (event, status, word) = match end.outcome {
            Outcome::Finished => (LedgerEvent::Finished, Status::OK, "finished"),
            Outcome::Passed => (LedgerEvent::Passed, Status::OK, "went around the corner of"),
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

    pub(super) fn refuse(&mut self, tag: &MotionTag, refusal: &Refusal) {
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
    pub(super) fn kind(&self, request: &MotionRequest) -> MotionKind {
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
}

fn to_micros(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}
