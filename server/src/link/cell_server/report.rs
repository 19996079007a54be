//! What the API shows of a tier-2 robot.

use api::{ControllerState, JointsBody, OperationalMode, PoseBody, PoseSource};
use protocol::v2::{OperatingMode, WireJoints, WirePose};
use tokio::time::Instant;

use super::readiness::alarm_name;
use super::view::{ControllerView, Observed};

impl ControllerView {
    /// The controller's last report, with its age.
    pub(crate) fn controller_state(&self) -> Option<ControllerState> {
        let Observed { line, at, .. } = self.status?;
        let levels = |bits: u8| [0, 1, 2, 3, 4, 5, 6, 7].map(|bit| bits >> bit & 1 == 1);
        let age = Instant::now().saturating_duration_since(at);
        Some(ControllerState {
            age_ms: u64::try_from(age.as_millis()).unwrap_or(u64::MAX),
            joints: joints_body(&line.joints),
            moving: line.moving,
            held: line.held,
            mode: match line.mode {
                OperatingMode::T1 => OperationalMode::ManualReducedSpeed,
                OperatingMode::T2 => OperationalMode::ManualHighSpeed,
                OperatingMode::Auto => OperationalMode::Automatic,
            },
            pendant_enabled: line.pendant,
            alarm: (line.alarm != 0).then(|| alarm_name(line.alarm)),
            speed_override_percent: line.speed_override,
            user_frame: line.user_frame,
            tool: line.tool,
            dead_man: line.dead_man,
            outputs: levels(line.outputs),
            inputs: levels(line.inputs),
            boot: line.boot,
            not_ready: self.not_ready.map(|reason| reason.to_string()),
        })
    }

    /// The pose the controller last reported, and where it comes from.
    pub(crate) fn pose(&self) -> (Option<PoseBody>, PoseSource) {
        match self.status {
            Some(observed) => (Some(pose_body(&observed.line.pose)), PoseSource::Controller),
            None => (None, PoseSource::Unknown),
        }
    }
}

fn pose_body(pose: &WirePose) -> PoseBody {
    let ([x, y, z], [w, p, r]) = (pose.position(), pose.rotation());
    [x.0, y.0, z.0, w.0, p.0, r.0].into()
}

fn joints_body(joints: &WireJoints) -> JointsBody {
    joints.degrees().map(|joint| joint.0).into()
}
