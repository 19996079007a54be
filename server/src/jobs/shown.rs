//! The workflows' views as the API's bodies.

use api::{
    ClaimBody, Compensation, FaultName, Job, JobCommand, JobFault, JobItem, JobItemBody,
    JobOperation, JobParams, JobReason, JobState, JobStep, JobSummary, Load, LoadLocation,
    OnCancelWithLoad, PointPermits, Session, SessionState, StepState, TimerBody, WorkflowName,
};
use jiff::Timestamp;
use uuid::Uuid;
use workflow::view::{JobView, LoadView, OperationView, SessionView, StepView, TimerView};
use workflow::{
    Cell, Command, CountingIds, Fault, Holder, Input, Location, NewJob, Permit, Principal,
    Resource, Role, TimerKey, Why, Workflow,
};

use crate::cell::CellClock;
use crate::wire_bodies::floor_pose;
use crate::words::{action, word};

/// Everything a caller may do with a job.
const COMMANDS: [(JobCommand, Command); 10] = [
    (JobCommand::Hold, Command::Hold),
    (JobCommand::Unhold, Command::Unhold),
    (JobCommand::Stop, Command::Stop),
    (JobCommand::Abort, Command::Abort),
    (JobCommand::RetryStep, Command::RetryStep),
    (JobCommand::SkipStep, Command::SkipStep),
    (JobCommand::CompleteManually, Command::CompleteManually),
    (JobCommand::Compensate, Command::Compensate),
    (JobCommand::Clear, Command::Clear),
    (JobCommand::Reset, Command::Reset),
];

/// A job as it is now.
pub(crate) fn job(
    name: &str,
    cell: &Cell,
    view: &JobView,
    clock: &CellClock,
    now: Timestamp,
) -> Job {
    let (reason, fault, principal) = reason_of(&view.why);
    Job {
        id: view.id,
        cell: name.to_owned(),
        number: view.number,
        created_at: created_at(view.id),
        workflow: workflow_name(view.spec.workflow),
        params: params(&view.spec),
        priority: view.spec.priority,
        deadline: view.spec.deadline.map(|at| clock.wall_at(now, at)),
        trigger: view.trigger.clone(),
        state: state_of(view.state),
        reason,
        text: view.text.clone(),
        fault,
        principal,
        queue_position: queue_position(cell, view.id),
        phase: view.phase.map(|phase| word(&phase)),
        code: view.code.map(str::to_owned),
        arm: view.arm.clone(),
        mobile_robot: view.mobile_robot.clone(),
        session: view.session,
        items: view.items.iter().map(item).collect(),
        steps: view.steps.iter().map(step).collect(),
        compensation: match view.compensation {
            workflow::Compensation::None => Compensation::None,
            workflow::Compensation::Running => Compensation::Running,
            workflow::Compensation::Done => Compensation::Done,
            workflow::Compensation::Blocked => Compensation::Blocked,
        },
        intervention: view.intervention,
        faults: view
            .faults
            .iter()
            .map(|note| JobFault {
                fault: fault_name(note.fault),
                text: note.text.clone(),
            })
            .collect(),
        claims: view.claims.iter().map(claim).collect(),
        timers: view.timers.iter().map(timer).collect(),
        commands: commands(cell, view.id, clock),
    }
}

/// A job in a list.
pub(crate) fn summary(cell: &Cell, view: &JobView) -> JobSummary {
    let needed = view
        .steps
        .iter()
        .filter(|step| step.state != workflow::StepState::Dropped);
    let done = needed.clone().filter(|step| {
        matches!(
            step.state,
            workflow::StepState::Succeeded | workflow::StepState::Skipped
        )
    });
    JobSummary {
        id: view.id,
        number: view.number,
        created_at: created_at(view.id),
        workflow: workflow_name(view.spec.workflow),
        point: view.spec.point.clone(),
        state: state_of(view.state),
        reason: reason_of(&view.why).0,
        text: view.text.clone(),
        code: view.code.map(str::to_owned),
        phase: view.phase.map(|phase| word(&phase)),
        steps_done: done.count(),
        steps: needed.count(),
        arm: view.arm.clone(),
        mobile_robot: view.mobile_robot.clone(),
        intervention: view.intervention,
        queue_position: queue_position(cell, view.id),
    }
}

fn queue_position(cell: &Cell, job: Uuid) -> Option<usize> {
    let index = cell
        .queue()
        .into_iter()
        .position(|waiting| waiting == job)?;
    Some(index + 1)
}

/// What the cell would not refuse now: each command is tried on paper, which changes nothing.
fn commands(cell: &Cell, job: Uuid, clock: &CellClock) -> Vec<JobCommand> {
    let possible = |command: Command| {
        let principal = Principal {
            name: "nobody".to_owned(),
            role: Role::Operator,
        };
        let input = Input::JobCommand {
            job,
            command,
            principal,
            reason: "on paper".to_owned(),
        };
        let decided = cell.decide(clock.now(), input, &mut CountingIds::default());
        decided.is_ok_and(|decision| decision.reply == workflow::Reply::Done)
    };
    COMMANDS
        .into_iter()
        .filter(|(_, command)| possible(*command))
        .map(|(shown, _)| shown)
        .collect()
}

/// When an id was made: those of a cell's driver carry it.
pub(super) fn created_at(id: Uuid) -> Timestamp {
    let made = id.get_timestamp().map(|made| made.to_unix());
    made.and_then(|(seconds, nanos)| {
        let seconds = i64::try_from(seconds).ok()?;
        Timestamp::new(seconds, i32::try_from(nanos).ok()?).ok()
    })
    .unwrap_or(Timestamp::UNIX_EPOCH)
}

pub(super) fn workflow_name(workflow: Workflow) -> WorkflowName {
    match workflow {
        Workflow::DeliveryAndPlacement => WorkflowName::DeliveryAndPlacement,
        Workflow::PickupAndDelivery => WorkflowName::PickupAndDelivery,
    }
}

fn params(spec: &NewJob) -> JobParams {
    #[expect(clippy::cast_precision_loss, reason = "at most a day of milliseconds")]
    let seconds = |ms: u64| ms as f64 / 1_000.0;
    JobParams {
        mobile_robot: spec.mobile_robot.clone(),
        arm: spec.arm.clone(),
        point: spec.point.clone(),
        items: spec
            .items
            .iter()
            .map(|item| JobItemBody {
                load_id: item.load_id.clone(),
                load_type: item.kind.clone(),
                mr_slot: item.mr_slot.clone(),
                place: item.place.clone(),
                alternates: item.alternates.clone(),
            })
            .collect(),
        early_release: spec.early_release,
        prefetch: spec.prefetch,
        on_cancel_with_load: match spec.on_cancel_with_load {
            workflow::OnCancel::Complete => OnCancelWithLoad::Complete,
            workflow::OnCancel::ReturnToMr => OnCancelWithLoad::ReturnToMr,
            workflow::OnCancel::RejectBin => OnCancelWithLoad::RejectBin,
            workflow::OnCancel::Hold => OnCancelWithLoad::Hold,
        },
        reject_slot: spec.reject_slot.clone(),
        max_attempts: spec.max_attempts,
        destination: spec.destination.clone(),
        complete_on: match spec.complete_on {
            workflow::CompleteOn::Departed => api::CompleteOn::Departed,
            workflow::CompleteOn::Delivered => api::CompleteOn::Delivered,
        },
        expected_arrival_s: spec.expected_arrival_ms.map(seconds),
        expected_transport_s: spec.expected_transport_ms.map(seconds),
    }
}

fn reason_of(why: &Why) -> (JobReason, Option<FaultName>, Option<String>) {
    match why {
        Why::Course => (JobReason::Course, None, None),
        Why::Awaiting => (JobReason::Awaiting, None, None),
        Why::Fault { fault } => (JobReason::Fault, Some(fault_name(*fault)), None),
        Why::Recovering => (JobReason::Recovering, None, None),
        Why::Human { principal } => (JobReason::Person, None, Some(principal.clone())),
        Why::DeadlinePassed => (JobReason::DeadlinePassed, None, None),
    }
}

pub(crate) fn fault_name(fault: Fault) -> FaultName {
    FaultName {
        code: fault.code(),
        name: word(&fault),
    }
}

pub(crate) fn state_of(state: workflow::JobState) -> JobState {
    use workflow::JobState as From;
    match state {
        From::Idle => JobState::Idle,
        From::Starting => JobState::Starting,
        From::Execute => JobState::Execute,
        From::Completing => JobState::Completing,
        From::Complete => JobState::Complete,
        From::Holding => JobState::Holding,
        From::Held => JobState::Held,
        From::Unholding => JobState::Unholding,
        From::Suspending => JobState::Suspending,
        From::Suspended => JobState::Suspended,
        From::Unsuspending => JobState::Unsuspending,
        From::Stopping => JobState::Stopping,
        From::Stopped => JobState::Stopped,
        From::Aborting => JobState::Aborting,
        From::Aborted => JobState::Aborted,
        From::Clearing => JobState::Clearing,
        From::Resetting => JobState::Resetting,
    }
}

fn item(item: &workflow::Item) -> JobItem {
    JobItem {
        load: item.load.clone(),
        load_type: item.kind.clone(),
        mr_slot: item.slot.clone(),
        place: item.place.clone(),
        alternates: item.alternates.clone(),
    }
}

fn step(step: &StepView) -> JobStep {
    JobStep {
        number: step.number,
        phase: word(&step.phase),
        code: step.code.to_owned(),
        item: step.item,
        place: step.place.as_ref().map(ToString::to_string),
        state: match step.state {
            workflow::StepState::Pending => StepState::Pending,
            workflow::StepState::Running => StepState::Running,
            workflow::StepState::Retriable => StepState::Retriable,
            workflow::StepState::Succeeded => StepState::Succeeded,
            workflow::StepState::Skipped => StepState::Skipped,
            workflow::StepState::Failed => StepState::Failed,
            workflow::StepState::Dropped => StepState::Dropped,
        },
        attempt: step.attempt,
        undo: step.undo,
        recovery: word(&step.recovery),
        needs: step.needs.clone(),
        operation: step.operation.as_ref().map(operation),
        left_ms: step.left_ms,
    }
}

fn operation(operation: &OperationView) -> JobOperation {
    JobOperation {
        id: operation.op,
        arm: operation.arm.clone(),
        action: action(&operation.action),
        state: word(&operation.state),
        left_ms: operation.left_ms,
    }
}

fn claim(resource: &Resource) -> ClaimBody {
    let (kind, id) = match resource {
        Resource::Point(id) => ("point", id),
        Resource::Arm(id) => ("arm", id),
        Resource::Place(id) => ("place", id),
        Resource::MobileRobot(id) => ("mobile_robot", id),
        Resource::Load(id) => ("load", id),
    };
    ClaimBody {
        resource: kind.to_owned(),
        id: id.clone(),
    }
}

fn timer(view: &TimerView) -> TimerBody {
    let (timer, of) = match &view.timer {
        TimerKey::Queue { .. } => ("queue", None),
        TimerKey::Deadline { .. } => ("deadline", None),
        TimerKey::Step { step, .. } => ("step", Some(step.to_string())),
        TimerKey::State { .. } => ("state", None),
        TimerKey::Prefetch { .. } => ("prefetch", None),
        TimerKey::Operation { op } => ("operation", Some(op.to_string())),
        TimerKey::Safe { arm } => ("safe", Some(arm.clone())),
        TimerKey::Session { session } => ("session", Some(session.to_string())),
        TimerKey::Heartbeat { mobile_robot } => ("heartbeat", Some(mobile_robot.clone())),
        TimerKey::ArmSeen { arm } => ("arm_seen", Some(arm.clone())),
        TimerKey::Parked { mobile_robot } => ("parked", Some(mobile_robot.clone())),
        TimerKey::Question { intervention } => ("question", Some(intervention.to_string())),
    };
    TimerBody {
        timer: timer.to_owned(),
        of,
        left_ms: view.left_ms,
        total_ms: view.total_ms,
    }
}

/// A hand-over session as it is now.
pub(crate) fn session(view: &SessionView) -> Session {
    Session {
        id: view.id,
        point: view.point.clone(),
        job: view.job,
        mobile_robot: view.mobile_robot.clone(),
        state: session_state(view.state),
        closed: view.state.is_closed(),
        faulted_from: view.faulted_from.map(session_state),
        fault: view.fault.map(fault_name),
        arm_entry_permit: view.arm_entry_permit,
        mr_move_permit: view.mr_move_permit,
        order: view.order,
        order_update: view.order_update,
        docked: view.docked.map(floor_pose),
        intervention: view.intervention,
        timers: view.timers.iter().map(timer).collect(),
    }
}

fn session_state(state: workflow::SessionState) -> SessionState {
    use workflow::SessionState as From;
    match state {
        From::Reserved => SessionState::Reserved,
        From::AccessPending => SessionState::AccessPending,
        From::AccessGranted => SessionState::AccessGranted,
        From::Positioned => SessionState::Positioned,
        From::Docked => SessionState::Docked,
        From::TransferReady => SessionState::TransferReady,
        From::Transferring => SessionState::Transferring,
        From::TransferDone => SessionState::TransferDone,
        From::ExitGranted => SessionState::ExitGranted,
        From::Exited => SessionState::Exited,
        From::Released => SessionState::Released,
        From::Faulted => SessionState::Faulted,
        From::Canceling => SessionState::Canceling,
        From::Canceled => SessionState::Canceled,
    }
}

/// The permits of each point.
pub(crate) fn permits(cell: &Cell, sessions: &[SessionView]) -> Vec<PointPermits> {
    cell.permits()
        .into_iter()
        .map(|(point, permit)| PointPermits {
            arm_entry_permit: permit == Permit::ArmEntry,
            mr_move_permit: permit == Permit::MrMove,
            session: sessions
                .iter()
                .find(|session| session.point == point && !session.state.is_closed())
                .map(|session| session.id),
            point,
        })
        .collect()
}

/// A load and where it is.
pub(crate) fn load(view: &LoadView) -> Load {
    Load {
        id: view.id.clone(),
        load_type: view.load.kind.clone(),
        location: load_location(&view.load.location),
        job: view.claimed_by.and_then(|by| match by {
            Holder::Job(job) => Some(job),
            Holder::Session(_) => None,
        }),
    }
}

pub(crate) fn load_location(location: &Location) -> LoadLocation {
    match location.clone() {
        Location::Fixed { place } => LoadLocation::Fixed { place },
        Location::Gripper { arm } => LoadLocation::Gripper { arm },
        Location::MobileRobot { mobile_robot, slot } => {
            LoadLocation::MobileRobot { mobile_robot, slot }
        }
        Location::Delivered { destination } => LoadLocation::Delivered { destination },
        Location::Unknown { arm } => LoadLocation::Unknown { arm },
    }
}
