//! Jobs that signals start.

use api::SignalName;
use api::setup::{TriggerBody, TriggerOn};
use workflow::{Millis, SignalKind, Trigger};

use super::refs::Refs;
use super::unique;
use crate::jobs::job_of_parts;
use crate::setup::faults::Faults;
use crate::setup::text::check_id;

const DEADLINE_S: (f64, f64) = (1.0, 604_800.0);

pub(super) fn triggers(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Trigger> {
    let bodies = &refs.file.triggers;
    let named = bodies.iter().enumerate();
    let named = named.map(|(index, body)| (format!("triggers[{index}].id"), body.id.as_str()));
    unique(faults, named, |id| format!("`{id}`"));
    let mut checked = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        checked.extend(trigger(faults, refs, &format!("triggers[{index}]"), body));
    }
    checked
}

fn trigger(
    faults: &mut Faults,
    refs: &Refs<'_>,
    item: &str,
    body: &TriggerBody,
) -> Option<Trigger> {
    let TriggerBody {
        id,
        enabled,
        on,
        job,
    } = body;
    check_id(faults, format!("{item}.id"), id);
    let signal = signal(faults, &format!("{item}.on.signal"), on.signal);
    if let Some(robot) = &on.mobile_robot {
        let _found = refs.mobile_robot(faults, format!("{item}.on.mobile_robot"), robot);
    }
    let points = points(faults, refs, &format!("{item}.on"), on);
    let deadline = match job.deadline_s {
        None => Some(None),
        Some(seconds) => faults
            .number(format!("{item}.job.deadline_s"), seconds, DEADLINE_S)
            .map(Some),
    };
    let params = format!("{item}.job.params");
    fits(faults, refs, &params, &job.params);
    let made = match job_of_parts(job.workflow, &job.params, job.priority) {
        Ok(made) => Some(made),
        Err(violations) => {
            for mut violation in violations {
                violation.item = format!("{item}.job.{}", violation.item);
                faults.push(violation);
            }
            None
        }
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from a second to a week"
    )]
    let milliseconds = |seconds: f64| (seconds * 1_000.0).round() as Millis;
    Some(Trigger {
        id: id.clone(),
        enabled: *enabled,
        signal: signal?,
        mobile_robot: on.mobile_robot.clone(),
        points: points?,
        deadline_ms: deadline?.map(milliseconds),
        job: made?,
    })
}

/// The signals of a mobile robot that comes by itself. The others belong to an order; heartbeats are not kept.
fn signal(faults: &mut Faults, item: &str, name: SignalName) -> Option<SignalKind> {
    let kind = match name {
        SignalName::MrArrived => SignalKind::MrArrived,
        SignalName::MrDocked => SignalKind::MrDocked,
        SignalName::MrReady => SignalKind::MrReady,
        SignalName::MrMode => SignalKind::MrMode,
        SignalName::LoadChanged => SignalKind::LoadChanged,
        SignalName::MrAssigned
        | SignalName::MrClear
        | SignalName::MrDelivered
        | SignalName::MrHeartbeat
        | SignalName::MrFault
        | SignalName::MrRejected
        | SignalName::MrDockFailed => {
            faults.add(
                item,
                format!(
                    "`{}` starts no job; there are MR_ARRIVED, MR_DOCKED, MR_READY, MR_MODE, LOAD_CHANGED",
                    name.as_str()
                ),
            );
            return None;
        }
    };
    Some(kind)
}

/// The points where the signal counts; none where it counts anywhere.
fn points(faults: &mut Faults, refs: &Refs<'_>, item: &str, on: &TriggerOn) -> Option<Vec<String>> {
    match (&on.station, &on.point) {
        (None, None) => Some(Vec::new()),
        (None, Some(point)) => {
            let _found = refs.point(faults, format!("{item}.point"), point)?;
            Some(vec![point.clone()])
        }
        (Some(station), None) => {
            let found = refs.station(faults, format!("{item}.station"), station)?;
            let all = found.points.iter();
            let all: Vec<_> = all.map(|point| format!("{station}/{}", point.id)).collect();
            if all.is_empty() {
                faults.add(
                    format!("{item}.station"),
                    format!("`{station}` has no point, so no signal would be meant"),
                );
                return None;
            }
            Some(all)
        }
        (Some(_), Some(_)) => {
            faults.add(item, "has `station` and `point`; one of them is enough");
            None
        }
    }
}

/// What the parameters name is there. Whether it fits what is so then, is found out when the job is made.
fn fits(faults: &mut Faults, refs: &Refs<'_>, item: &str, params: &api::JobParams) {
    let point = refs.point(faults, format!("{item}.point"), &params.point);
    if let Some(arms) = point.map(|point| &point.arms) {
        if arms.is_empty() {
            faults.add(
                format!("{item}.point"),
                format!("no arm works at `{}`", params.point),
            );
        }
        if let Some(arm) = &params.arm
            && refs.arm(faults, format!("{item}.arm"), arm).is_some()
            && !arms.contains(arm)
        {
            faults.add(
                format!("{item}.arm"),
                format!("`{arm}` does not work at `{}`", params.point),
            );
        }
    }
    if let Some(robot) = params.mobile_robot.as_ref().filter(|id| *id != "any") {
        let _found = refs.mobile_robot(faults, format!("{item}.mobile_robot"), robot);
    }
    if let Some(place) = &params.reject_slot {
        let _found = refs.place(faults, format!("{item}.reject_slot"), place);
    }
    if let Some(destination) = &params.destination {
        let mut all = refs.file.destinations.iter();
        if !all.any(|known| known.point == *destination) {
            let all = refs.file.destinations.iter();
            let known: Vec<_> = all.map(|known| known.point.as_str()).collect();
            faults.add(
                format!("{item}.destination"),
                format!(
                    "`{}` is no point of a destination; there are {}",
                    crate::state::shown(destination),
                    known.join(", ")
                ),
            );
        }
    }
    let robots = &refs.file.mobile_robots;
    for (index, one) in params.items.iter().enumerate().take(32) {
        let item = format!("{item}.items[{index}]");
        for (key, place) in std::iter::once(("place", &one.place))
            .chain(one.alternates.iter().map(|place| ("alternates", place)))
        {
            let _found = refs.place(faults, format!("{item}.{key}"), place);
        }
        let known = robots
            .iter()
            .any(|robot| robot.slots.iter().any(|slot| slot.id == one.mr_slot));
        if !known {
            faults.add(
                format!("{item}.mr_slot"),
                format!(
                    "`{}` is no slot of a mobile robot",
                    crate::state::shown(&one.mr_slot)
                ),
            );
        }
    }
}
