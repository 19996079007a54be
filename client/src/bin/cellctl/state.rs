//! `cellctl state`.

use api::{LinkState, PoseSource, RobotState};

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text;

pub(crate) async fn run(context: &Context) -> Result<Report, Failure> {
    let state = context.robot().await?.state().await?;
    Ok(context.report(Exit::Done, &state, sentences))
}

fn sentences(state: &RobotState) -> String {
    let link = match state.link.state {
        LinkState::Untried => "untried: no command has been sent yet",
        LinkState::Busy => "busy: a command is on its way",
        LinkState::Answering => "answering: the last command was answered",
        LinkState::Disconnected => "disconnected: the last connection was refused or timed out",
        LinkState::Degraded => "degraded: the last answer did not tell, or came late",
        LinkState::Connecting => "connecting",
        LinkState::Monitor => "monitor: the controller is watched, no motion would be sent now",
        LinkState::Control => "control: the controller is watched and takes motions",
    };
    let (pose, source) = match (state.pose_source, &state.pose) {
        (PoseSource::LastAcceptedTarget, Some(pose)) => (
            text::pose(pose),
            "the last accepted target; the arm may be on its way to it, or have been moved by hand",
        ),
        (PoseSource::Controller, Some(pose)) => (text::pose(pose), "the controller's own report"),
        (PoseSource::LastAcceptedTarget | PoseSource::Controller | PoseSource::Unknown, _) => (
            "unknown".to_owned(),
            "no accepted target: none yet, or a motion in doubt since",
        ),
    };
    let mut facts = vec![
        ("robot", format!("{} in {}", state.id, state.cell)),
        ("link", link.to_owned()),
        ("pose", pose),
        ("", source.to_owned()),
        (
            "queue",
            format!("{} of {}", state.queued, state.queue_capacity),
        ),
    ];
    if let Some(controller) = &state.controller {
        let moving = if controller.moving {
            "moving"
        } else {
            "standing"
        };
        facts.push((
            "controller",
            format!("{moving}, said {} ms ago", controller.age_ms),
        ));
        if let Some(why) = &controller.not_ready {
            facts.push(("not ready", why.clone()));
        }
    }
    if let Some(at) = state.link.last_answer_at {
        facts.push(("answered", format!("{at:.3}")));
    }
    if let Some(failure) = state.link.last_failure {
        facts.push(("failure", failure.title().to_owned()));
    }
    if let Some(motion) = state.last_motion {
        facts.push(("motion", motion.to_string()));
    }
    text::facts(&facts)
}
