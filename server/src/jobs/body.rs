//! What callers ask for, checked and in the words of the workflows.

use std::ops::RangeInclusive;

use api::{
    JobBody, JobCommand, JobItemBody, JobParams, LoadLocation, OnCancelWithLoad, ProblemCode,
    Role as ApiRole, Violation, WorkflowName,
};
use jiff::Timestamp;
use workflow::{
    Command, CompleteOn, ItemParams, Location, Millis, NewJob, OnCancel, Role, Workflow,
};

use crate::cell::CellClock;
use crate::identity::Principal;
use crate::problem::Problem;

/// The longest name of a thing of the set-up, in characters.
const MAX_NAME: usize = 128;
/// The longest reason, in characters.
const MAX_REASON: usize = 500;
/// The most items of one job: its plan has to fit into one record of the journal.
const MAX_ITEMS: usize = 32;
/// The most alternates of one item.
const MAX_ALTERNATES: usize = 16;
/// The longest drive, in seconds.
const MAX_DRIVE_S: f64 = 86_400.0;
/// How much one job may be preferred to another.
const PRIORITIES: RangeInclusive<i32> = -100..=100;
/// What stands for any mobile robot.
const ANY: &str = "any";

/// Everything wrong with a body, gathered.
#[derive(Debug, Default)]
struct Wrong(Vec<Violation>);

impl Wrong {
    fn say(&mut self, item: impl Into<String>, message: impl Into<String>) {
        self.0.push(Violation {
            item: item.into(),
            message: message.into(),
            ..Violation::default()
        });
    }

    fn range(&mut self, item: &str, value: f64, min: f64, max: f64, unit: &str) {
        self.0.push(Violation {
            item: item.to_owned(),
            message: format!("{value} is not from {min} to {max}{unit}"),
            value: value.is_finite().then_some(value),
            min: Some(min),
            max: Some(max),
        });
    }

    fn name(&mut self, item: &str, name: &str) {
        let length = name.chars().count();
        if !(1..=MAX_NAME).contains(&length) {
            self.say(
                item,
                format!("{length} characters; 1 to {MAX_NAME} are possible"),
            );
        }
    }

    fn finish(self) -> Result<(), Problem> {
        let Some(first) = self.0.first() else {
            return Ok(());
        };
        let detail = format!("{}: {}", first.item, first.message);
        Err(Problem::not_sent(ProblemCode::Validation, detail).violations(self.0))
    }
}

/// A new job; its deadline is on the cell's clock.
///
/// # Errors
/// `validation` with everything that is wrong whatever the set-up is. What has to fit the set-up the cell checks.
pub(crate) fn new_job(
    body: &JobBody,
    clock: &CellClock,
    now: Timestamp,
) -> Result<NewJob, Problem> {
    let JobBody {
        workflow,
        params,
        priority,
        deadline,
    } = body;
    let (mut wrong, job) = parts(*workflow, params, *priority);
    if let Some(deadline) = deadline.filter(|deadline| *deadline <= now) {
        wrong.say("deadline", format!("{deadline} has passed: it is {now:.0}"));
    }
    wrong.finish()?;
    Ok(NewJob {
        deadline: deadline.map(|deadline| clock.at(now, deadline)),
        ..job
    })
}

/// A job without a deadline.
///
/// # Errors
/// Everything that is wrong whatever the set-up is.
pub(crate) fn job_of_parts(
    workflow: WorkflowName,
    params: &JobParams,
    priority: i32,
) -> Result<NewJob, Vec<Violation>> {
    let (wrong, job) = parts(workflow, params, priority);
    if wrong.0.is_empty() {
        Ok(job)
    } else {
        Err(wrong.0)
    }
}

fn parts(workflow: WorkflowName, params: &JobParams, priority: i32) -> (Wrong, NewJob) {
    let mut wrong = Wrong::default();
    names(&mut wrong, params);
    if !PRIORITIES.contains(&priority) {
        let (min, max) = (*PRIORITIES.start(), *PRIORITIES.end());
        wrong.range(
            "priority",
            f64::from(priority),
            f64::from(min),
            f64::from(max),
            "",
        );
    }
    if !(1..=MAX_ITEMS).contains(&params.items.len()) {
        let count = params.items.len();
        wrong.0.push(Violation {
            item: "params.items".to_owned(),
            message: format!("{count} items; 1 to {MAX_ITEMS} are possible"),
            value: u32::try_from(count).ok().map(f64::from),
            min: Some(1.0),
            max: Some(32.0),
        });
    }
    if !(1..=10).contains(&params.max_attempts) {
        let value = f64::from(params.max_attempts);
        wrong.range("params.max_attempts", value, 1.0, 10.0, "");
    }
    let mut drive = |item: &str, seconds: Option<f64>| -> Option<Millis> {
        let seconds = seconds?;
        if !(0.0..=MAX_DRIVE_S).contains(&seconds) {
            wrong.range(item, seconds, 0.0, MAX_DRIVE_S, " s");
            return None;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to a day"
        )]
        Some((seconds * 1_000.0).round() as Millis)
    };
    let expected_arrival_ms = drive("params.expected_arrival_s", params.expected_arrival_s);
    let expected_transport_ms = drive("params.expected_transport_s", params.expected_transport_s);
    let job = NewJob {
        workflow: match workflow {
            WorkflowName::DeliveryAndPlacement => Workflow::DeliveryAndPlacement,
            WorkflowName::PickupAndDelivery => Workflow::PickupAndDelivery,
        },
        mobile_robot: params.mobile_robot.clone().filter(|id| id != ANY),
        arm: params.arm.clone(),
        point: params.point.clone(),
        items: params.items.iter().map(item_params).collect(),
        early_release: params.early_release,
        prefetch: params.prefetch,
        on_cancel_with_load: match params.on_cancel_with_load {
            OnCancelWithLoad::Complete => OnCancel::Complete,
            OnCancelWithLoad::ReturnToMr => OnCancel::ReturnToMr,
            OnCancelWithLoad::RejectBin => OnCancel::RejectBin,
            OnCancelWithLoad::Hold => OnCancel::Hold,
        },
        reject_slot: params.reject_slot.clone(),
        max_attempts: params.max_attempts,
        destination: params.destination.clone(),
        complete_on: match params.complete_on {
            api::CompleteOn::Departed => CompleteOn::Departed,
            api::CompleteOn::Delivered => CompleteOn::Delivered,
        },
        priority,
        deadline: None,
        expected_arrival_ms,
        expected_transport_ms,
    };
    (wrong, job)
}

/// Lengths of names. That they name something is the cell's matter.
fn names(wrong: &mut Wrong, params: &JobParams) {
    wrong.name("params.point", &params.point);
    for (item, name) in [
        ("params.mobile_robot", &params.mobile_robot),
        ("params.arm", &params.arm),
        ("params.reject_slot", &params.reject_slot),
        ("params.destination", &params.destination),
    ] {
        if let Some(name) = name {
            wrong.name(item, name);
        }
    }
    for (index, item) in params.items.iter().enumerate().take(MAX_ITEMS) {
        let at = |field: &str| format!("params.items[{index}].{field}");
        wrong.name(&at("type"), &item.load_type);
        wrong.name(&at("mr_slot"), &item.mr_slot);
        wrong.name(&at("place"), &item.place);
        if let Some(load) = &item.load_id {
            wrong.name(&at("load_id"), load);
        }
        if item.alternates.len() > MAX_ALTERNATES {
            let count = item.alternates.len();
            wrong.say(
                at("alternates"),
                format!("{count} places; at most {MAX_ALTERNATES} are possible"),
            );
        }
        for (number, place) in item.alternates.iter().enumerate().take(MAX_ALTERNATES) {
            wrong.name(&at(&format!("alternates[{number}]")), place);
        }
    }
}

fn item_params(item: &JobItemBody) -> ItemParams {
    ItemParams {
        load_id: item.load_id.clone(),
        kind: item.load_type.clone(),
        mr_slot: item.mr_slot.clone(),
        place: item.place.clone(),
        alternates: item.alternates.clone(),
    }
}

/// A reason: 1 to 500 characters, not only blanks.
///
/// # Errors
/// `validation`, naming the length and the limit.
pub(crate) fn reason(text: &str) -> Result<(), Problem> {
    let length = text.chars().count();
    let mut wrong = Wrong::default();
    if text.trim().is_empty() || length > MAX_REASON {
        wrong.say(
            "reason",
            format!("{length} characters; say in 1 to {MAX_REASON} why"),
        );
    }
    wrong.finish()
}

/// A person, or a program, with the role that counts in the cell: an admin manages tokens and moves nothing.
pub(crate) fn principal(caller: &Principal) -> workflow::Principal {
    let role = if caller.has(ApiRole::Integrator) {
        Role::Integrator
    } else if caller.has(ApiRole::Operator) {
        Role::Operator
    } else {
        Role::Viewer
    };
    workflow::Principal {
        name: caller.name().to_owned(),
        role,
    }
}

pub(crate) fn command(command: JobCommand) -> Command {
    match command {
        JobCommand::Hold => Command::Hold,
        JobCommand::Unhold => Command::Unhold,
        JobCommand::Stop => Command::Stop,
        JobCommand::Abort => Command::Abort,
        JobCommand::RetryStep => Command::RetryStep,
        JobCommand::SkipStep => Command::SkipStep,
        JobCommand::CompleteManually => Command::CompleteManually,
        JobCommand::Compensate => Command::Compensate,
        JobCommand::Clear => Command::Clear,
        JobCommand::Reset => Command::Reset,
    }
}

/// Where a load is, in the workflows' words.
pub(crate) fn location(location: &LoadLocation) -> Location {
    match location.clone() {
        LoadLocation::Fixed { place } => Location::Fixed { place },
        LoadLocation::Gripper { arm } => Location::Gripper { arm },
        LoadLocation::MobileRobot { mobile_robot, slot } => {
            Location::MobileRobot { mobile_robot, slot }
        }
        LoadLocation::Delivered { destination } => Location::Delivered { destination },
        LoadLocation::Unknown { arm } => Location::Unknown { arm },
    }
}
