//! Facts about jobs, in words.

use workflow::Fact;

use super::super::known::Known;
use super::{Said, said};
use crate::words::{because, word};

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
#[expect(
    clippy::too_many_lines,
    reason = "one arm for each fact, most of them one line"
)]
pub(super) fn of_job(known: &Known, fact: &Fact) -> Option<Said> {
    let (kind, job, text) = match fact {
        Fact::JobCreated { job, spec, .. } => (
            "robocell.job.created",
            job,
            format!(
                "a job was created: {} at {}",
                word(&spec.workflow),
                spec.point
            ),
        ),
        Fact::JobAssigned {
            job,
            arm,
            mobile_robot,
        } => (
            "robocell.job.assigned",
            job,
            format!("the job has {arm} and {mobile_robot}"),
        ),
        Fact::JobMoved { job, to, text, .. } => (
            "robocell.job.state",
            job,
            format!("the job is {}{}", word(to), because(text)),
        ),
        Fact::FaultNoted { job, fault, text } => (
            "robocell.job.fault",
            job,
            format!("{} {}{}", fault.code(), word(fault), because(text)),
        ),
        Fact::Planned { job, steps, .. } => (
            "robocell.job.planned",
            job,
            format!("{} steps were planned", steps.len()),
        ),
        Fact::StepMoved {
            job,
            step,
            to,
            attempt,
            text,
        } => (
            "robocell.step.state",
            job,
            match attempt {
                0 | 1 => format!(
                    "{} is {}{}",
                    known.step(job, *step),
                    word(to),
                    because(text)
                ),
                _ => format!(
                    "{} is {} (attempt {attempt}){}",
                    known.step(job, *step),
                    word(to),
                    because(text)
                ),
            },
        ),
        Fact::StepRedirected { job, step, place } => (
            "robocell.step.redirected",
            job,
            format!("{} goes to {place}", known.step(job, *step)),
        ),
        Fact::StepResent { job, step } => (
            "robocell.step.resent",
            job,
            format!(
                "{} is tried or waited for once more",
                known.step(job, *step)
            ),
        ),
        Fact::CompensationMoved { job, to } => (
            "robocell.job.compensation",
            job,
            format!("undoing is {}", word(to)),
        ),
        Fact::LoadsAccepted { job } => (
            "robocell.job.loads-accepted",
            job,
            "a person accepted the loads as they are".to_owned(),
        ),
        Fact::Redispatched { job } => (
            "robocell.job.redispatched",
            job,
            "the mobile robot is called anew".to_owned(),
        ),
        Fact::ArmByHand { job, displaced } => (
            "robocell.job.arm-by-hand",
            job,
            if *displaced {
                "the arm was moved by hand".to_owned()
            } else {
                "the pendant was enabled, or the mode changed".to_owned()
            },
        ),
        Fact::ArmByHandDecided { job } => (
            "robocell.job.arm-by-hand-decided",
            job,
            "a person said how the arm goes on".to_owned(),
        ),
        Fact::OpStarted {
            job,
            step,
            arm,
            action,
            ..
        } => (
            "robocell.operation.started",
            job,
            format!(
                "{arm} begins {}: {}",
                known.step(job, *step),
                crate::words::action(action)
            ),
        ),
        _ => return None,
    };
    Some(said(kind, Some(*job), text))
}
