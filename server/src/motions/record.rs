//! One motion: what was asked for, how far it has come, and how the API shows it.

use std::borrow::Cow;
use std::sync::Arc;

use api::{
    DecisionBody, Evidence, Motion, MotionState, MotionType, Outcome, PoseBody, ProblemCode,
};
use jiff::Timestamp;
use journal::{Observation, OutputLevel, Standstill, Target};
use kinematics::{PendantJoints, Pose, Xyzwpr};
use units::{Degrees, Millimeters};
use uuid::Uuid;

use super::book::Entry;
use super::intent::{degrees, mdeg};
use crate::config::RobotPlan;
use crate::request_id::RequestId;
use crate::target::Prepared;
use crate::wire_bodies::{joints_body, pose_body, shown};

/// What the controller is asked to do, in the numbers of the wire: thousandths of millimeters and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Asked {
    pub(crate) motion_type: MotionType,
    /// X, Y, Z, W, P, R.
    pub(crate) point: [i32; 6],
    pub(crate) speed: Speed,
    /// Where the joints are expected to end.
    pub(crate) joints: PendantJoints,
    /// Whether the controller is given the joints, and not the pose.
    pub(crate) to_joints: bool,
    /// All that is asked for is this level of an output; the arm stays where `point` and `joints` say.
    pub(crate) output: Option<OutputLevel>,
    /// The pose it was counted from, for a relative motion.
    pub(crate) from: Option<[i32; 6]>,
}

/// A programmed speed, in the unit the controller takes.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Speed {
    MmPerSec(u16),
    /// Of the joints' fastest.
    Percent(u8),
}

/// A motion and how far it has come.
#[derive(Clone, Debug)]
pub(crate) struct Record {
    pub(crate) id: Uuid,
    pub(crate) asked: Asked,
    pub(crate) created_at: Timestamp,
    pub(crate) request_id: RequestId,
    pub(crate) principal: Arc<str>,
    pub(crate) reason: Option<String>,
    pub(crate) not_after: Option<Timestamp>,
    pub(crate) progress: Progress,
    pub(crate) decision: Option<DecisionBody>,
    /// Whether the journal has its intent.
    pub(crate) in_journal: bool,
}

/// How far a motion has come.
#[derive(Clone, Debug)]
pub(crate) enum Progress {
    Queued,
    Dispatched,
    /// The controller took it, and its end will be known.
    Accepted,
    Executing,
    Ended {
        at: Timestamp,
        end: End,
    },
}

/// How a motion ended, as far as the server can know.
#[derive(Clone, Debug)]
pub(crate) enum End {
    /// Taken, by a controller that tells no more.
    Accepted,
    /// Seen at the target, standing; or a person says so.
    Succeeded { seen: Option<Arc<Observation>> },
    Rejected {
        text: Cow<'static, str>,
        code: ProblemCode,
    },
    NotExecuted {
        code: ProblemCode,
        why: Option<Arc<str>>,
    },
    /// It began and did not get there.
    Interrupted {
        code: ProblemCode,
        seen: Option<Arc<Observation>>,
    },
    InDoubt {
        code: ProblemCode,
        text: Option<String>,
        why: Option<Arc<str>>,
        seen: Option<Arc<Observation>>,
    },
}

impl Asked {
    /// What a controller of tier 0 is asked to do.
    pub(crate) fn of(prepared: &Prepared) -> Self {
        Self {
            motion_type: prepared.motion_type,
            point: prepared.wire.thousandths(),
            speed: Speed::MmPerSec(prepared.wire.speed()),
            joints: rounded(&prepared.joints),
            to_joints: false,
            output: None,
            from: None,
        }
    }
}

/// Joints as the journal keeps them, so that a motion shows the same before and after a restart.
pub(crate) fn rounded(joints: &PendantJoints) -> PendantJoints {
    PendantJoints::from_degrees(joints.degrees().map(|value| degrees(mdeg(value))))
}

/// The point the thousandths stand for.
pub(crate) fn point_of_thousandths(point: [i32; 6]) -> Xyzwpr {
    let [x, y, z, w, p, r] = point.map(|value| f64::from(value) / 1000.0);
    Xyzwpr {
        x: Millimeters(x),
        y: Millimeters(y),
        z: Millimeters(z),
        w: Degrees(w),
        p: Degrees(p),
        r: Degrees(r),
    }
}

pub(crate) fn target_of([x_um, y_um, z_um, w_mdeg, p_mdeg, r_mdeg]: [i32; 6]) -> Target {
    Target {
        x_um,
        y_um,
        z_um,
        w_mdeg,
        p_mdeg,
        r_mdeg,
    }
}

pub(crate) fn thousandths_of(target: &Target) -> [i32; 6] {
    let Target {
        x_um,
        y_um,
        z_um,
        w_mdeg,
        p_mdeg,
        r_mdeg,
    } = *target;
    [x_um, y_um, z_um, w_mdeg, p_mdeg, r_mdeg]
}

fn pose_of(point: [i32; 6]) -> PoseBody {
    pose_body(&point_of_thousandths(point))
}

impl Progress {
    pub(crate) fn end(&self) -> Option<&End> {
        match self {
            Self::Ended { end, .. } => Some(end),
            Self::Queued | Self::Dispatched | Self::Accepted | Self::Executing => None,
        }
    }

    pub(crate) fn is_in_doubt(&self) -> bool {
        matches!(self.end(), Some(End::InDoubt { .. }))
    }

    pub(crate) fn state(&self) -> MotionState {
        match self {
            Self::Queued => MotionState::Queued,
            Self::Dispatched => MotionState::Dispatched,
            Self::Accepted => MotionState::Accepted,
            Self::Executing => MotionState::Executing,
            Self::Ended { end, .. } => end.state(),
        }
    }
}

impl End {
    pub(crate) fn state(&self) -> MotionState {
        match self {
            Self::Accepted => MotionState::Accepted,
            Self::Succeeded { .. } => MotionState::Succeeded,
            Self::Rejected { .. } => MotionState::Rejected,
            Self::NotExecuted { code, .. } if *code == ProblemCode::DeadlinePassed => {
                MotionState::Expired
            }
            Self::NotExecuted { code, .. } | Self::Interrupted { code, .. }
                if matches!(
                    code,
                    ProblemCode::MotionCanceled | ProblemCode::StoppedBeforeSent
                ) =>
            {
                MotionState::Canceled
            }
            Self::NotExecuted { .. } => MotionState::NotExecuted,
            Self::Interrupted { .. } => MotionState::Failed,
            Self::InDoubt { .. } => MotionState::InDoubt,
        }
    }

    pub(crate) fn code(&self) -> Option<ProblemCode> {
        match self {
            Self::Accepted | Self::Succeeded { .. } => None,
            Self::Rejected { code, .. }
            | Self::NotExecuted { code, .. }
            | Self::Interrupted { code, .. }
            | Self::InDoubt { code, .. } => Some(*code),
        }
    }

    /// What is known of the effect, where the motion did not do what it was to do.
    pub(crate) fn outcome(&self) -> Option<Outcome> {
        match self {
            Self::Accepted | Self::Succeeded { .. } => None,
            Self::Rejected { .. } => Some(Outcome::Rejected),
            Self::NotExecuted { .. } => Some(Outcome::NotSent),
            // It moved, and where it stopped is not where it was to go.
            Self::Interrupted { .. } | Self::InDoubt { .. } => Some(Outcome::Unknown),
        }
    }

    pub(crate) fn controller_text(&self) -> Option<&str> {
        match self {
            Self::Accepted => Some(protocol::Reply::Accepted.text()),
            Self::Rejected { text, .. } => Some(text),
            Self::InDoubt { text, .. } => text.as_deref(),
            Self::Succeeded { .. } | Self::NotExecuted { .. } | Self::Interrupted { .. } => None,
        }
    }

    pub(crate) fn why(&self) -> Option<&str> {
        match self {
            Self::NotExecuted { why, .. } | Self::InDoubt { why, .. } => why.as_deref(),
            Self::Accepted
            | Self::Succeeded { .. }
            | Self::Rejected { .. }
            | Self::Interrupted { .. } => None,
        }
    }

    pub(crate) fn seen(&self) -> Option<&Observation> {
        match self {
            Self::Succeeded { seen }
            | Self::Interrupted { seen, .. }
            | Self::InDoubt { seen, .. } => seen.as_deref(),
            Self::Accepted | Self::Rejected { .. } | Self::NotExecuted { .. } => None,
        }
    }
}

impl Record {
    /// What was entered when it began.
    pub(crate) fn entry(&self) -> Entry {
        Entry {
            asked: self.asked,
            request_id: self.request_id.clone(),
            principal: Arc::clone(&self.principal),
            reason: self.reason.clone(),
            not_after: self.not_after,
        }
    }

    /// The resource as the API shows it.
    pub(crate) fn body(&self, plan: &RobotPlan) -> Motion {
        let end = self.progress.end();
        let ended_at = match &self.progress {
            Progress::Ended { at, .. } => Some(*at),
            Progress::Queued | Progress::Dispatched | Progress::Accepted | Progress::Executing => {
                None
            }
        };
        let (speed_mm_s, speed_percent) = match self.asked.speed {
            Speed::MmPerSec(speed) => (Some(f64::from(speed)), None),
            Speed::Percent(percent) => (None, Some(percent)),
        };
        Motion {
            id: self.id,
            cell: plan.cell.clone(),
            robot: plan.id.clone(),
            motion_type: self.asked.motion_type,
            state: self.progress.state(),
            completion: plan.completion(),
            tier: plan.tier,
            target: pose_of(self.asked.point),
            expected_joints: joints_body(&self.asked.joints),
            speed_mm_s,
            speed_percent,
            counted_from: self.asked.from.map(pose_of),
            principal: self.principal.to_string(),
            created_at: self.created_at,
            not_after: self.not_after,
            ended_at,
            controller_text: end.and_then(End::controller_text).map(str::to_owned),
            code: end.and_then(End::code),
            outcome: end.and_then(End::outcome),
            request_id: self.request_id.to_string(),
            reason: self.reason.clone(),
            evidence: end
                .and_then(End::seen)
                .and_then(|seen| evidence(seen, self.asked.point)),
            decision: self.decision.clone(),
        }
    }
}

/// What was read of an arm, compared with where it was to go.
pub(crate) fn evidence(seen: &Observation, target: [i32; 6]) -> Option<Evidence> {
    let read = thousandths_of(&seen.pose);
    let (distance_mm, angle_deg) = apart(read, target)?;
    Some(Evidence {
        pose: pose_of(read),
        distance_mm: shown(distance_mm),
        angle_deg: shown(angle_deg),
        standing: seen.standstill == Standstill::Standing,
        held: match seen.hold {
            journal::Hold::Free => Some(false),
            journal::Hold::Held => Some(true),
            journal::Hold::Unknown => None,
        },
        mode: match seen.mode {
            journal::Mode::T1 => Some("T1".to_owned()),
            journal::Mode::T2 => Some("T2".to_owned()),
            journal::Mode::Auto => Some("AUTO".to_owned()),
            journal::Mode::Unknown => None,
        },
        boot: seen.boot,
        alarm: seen.alarm.clone(),
        fence_at: seen.fence_at,
        read_at: seen.second_at,
    })
}

/// The distance in millimeters and the angle in degrees between two poses, if both are poses.
pub(crate) fn apart(a: [i32; 6], b: [i32; 6]) -> Option<(f64, f64)> {
    let a = Pose::try_from_xyzwpr(&point_of_thousandths(a)).ok()?;
    let b = Pose::try_from_xyzwpr(&point_of_thousandths(b)).ok()?;
    let (distance, angle) = a.distance_to(&b);
    Some((distance.0, angle.0.to_degrees()))
}
