//! A job's parameters against the configuration and the books. Every error names its item.

use std::collections::BTreeSet;

use crate::cell::Cell;
use crate::custody::Location;
use crate::ids::Millis;
use crate::input::Refusal;
use crate::job::Item;
use crate::job::params::{CompleteOn, NewJob, OnCancel, Workflow};
use crate::setup::PlaceRef;

/// Most items of one job, and most jobs that wait or run.
const MOST_ITEMS: usize = 64;
const MOST_JOBS: usize = 200;

/// The items of a valid job.
#[expect(
    clippy::too_many_lines,
    reason = "one check after the other, each naming its item"
)]
pub(crate) fn items_of(cell: &Cell, spec: &NewJob, now: Millis) -> Result<Vec<Item>, Refusal> {
    let open = cell
        .book
        .jobs
        .values()
        .filter(|j| !j.state.is_final())
        .count();
    if open >= MOST_JOBS {
        return Err(Refusal::Conflict {
            command: "create-job".into(),
            text: format!("{open} jobs are open; the limit is {MOST_JOBS}"),
        });
    }
    let Some(point) = cell.setup.point(&spec.point) else {
        return bad("point", format!("{} is not configured", spec.point));
    };
    if let Some(id) = &spec.mobile_robot
        && cell.setup.mobile_robot(id).is_none()
    {
        return bad("mobile_robot", format!("{id} is not configured"));
    }
    if let Some(id) = &spec.arm
        && !point.arms.contains(id)
    {
        return bad("arm", format!("{id} does not reach {}", point.id));
    }
    if spec.items.is_empty() || spec.items.len() > MOST_ITEMS {
        return bad(
            "items",
            format!("{} items; 1 to {MOST_ITEMS} are possible", spec.items.len()),
        );
    }
    if !(1..=10).contains(&spec.max_attempts) {
        return bad(
            "max_attempts",
            format!("{}; 1 to 10 are possible", spec.max_attempts),
        );
    }
    if spec.deadline.is_some_and(|at| at <= now) {
        return bad("deadline", "it has passed".into());
    }
    let delivery = spec.workflow == Workflow::DeliveryAndPlacement;
    if delivery && (spec.prefetch || spec.destination.is_some()) {
        return bad(
            "prefetch",
            "prefetch and destination belong to pickup-and-delivery".into(),
        );
    }
    if !delivery && spec.early_release {
        return bad(
            "early_release",
            "it belongs to delivery-and-placement".into(),
        );
    }
    match &spec.destination {
        Some(id) if !cell.setup.destinations.contains(id) => {
            return bad("destination", format!("{id} is not configured"));
        }
        None if spec.complete_on == CompleteOn::Delivered => {
            return bad("destination", "complete_on DELIVERED needs one".into());
        }
        Some(_) | None => {}
    }
    match &spec.reject_slot {
        Some(id) if cell.setup.place(id).is_none() => {
            return bad("reject_slot", format!("{id} is not configured"));
        }
        None if spec.on_cancel_with_load == OnCancel::RejectBin => {
            return bad(
                "reject_slot",
                "on_cancel_with_load REJECT_BIN needs one".into(),
            );
        }
        Some(_) | None => {}
    }
    let mut used = BTreeSet::new();
    for (index, item) in spec.items.iter().enumerate() {
        check_item(cell, spec, index)?;
        let names = [
            Some(format!("slot {}", item.mr_slot)),
            cell.setup
                .is_single(&Location::Fixed {
                    place: item.place.clone(),
                })
                .then(|| format!("place {}", item.place)),
            item.load_id.as_ref().map(|l| format!("load {l}")),
        ];
        for name in names.into_iter().flatten() {
            if !used.insert(name.clone()) {
                return bad(&format!("items[{index}]"), format!("{name} is used twice"));
            }
        }
    }
    let arms = point
        .arms
        .iter()
        .filter(|a| spec.arm.as_ref().is_none_or(|named| named == *a));
    let mut missing = format!("no arm reaches {}", point.id);
    for arm in arms {
        match untaught(cell, spec, arm) {
            None => return Ok(spec.items.iter().map(|i| item_of(cell, spec, i)).collect()),
            Some((index, place)) => {
                missing = format!("items[{index}]: {arm} was not taught {place}");
            }
        }
    }
    bad("items", missing)
}

fn item_of(cell: &Cell, spec: &NewJob, item: &crate::job::params::ItemParams) -> Item {
    let at = Location::Fixed {
        place: item.place.clone(),
    };
    let load = item.load_id.clone().or_else(|| {
        // In B the load is wherever it is picked: the books know its name.
        let pickup = spec.workflow == Workflow::PickupAndDelivery;
        cell.book
            .custody
            .at(&at)
            .filter(|_| pickup)
            .map(str::to_owned)
    });
    Item {
        load,
        kind: item.kind.clone(),
        slot: item.mr_slot.clone(),
        place: item.place.clone(),
        alternates: item.alternates.clone(),
    }
}

fn check_item(cell: &Cell, spec: &NewJob, index: usize) -> Result<(), Refusal> {
    let Some(item) = spec.items.get(index) else {
        return Ok(());
    };
    let name = |field: &str| format!("items[{index}].{field}");
    let Some(place) = cell.setup.place(&item.place) else {
        return bad(&name("place"), format!("{} is not configured", item.place));
    };
    if !place.accepts.is_empty() && !place.accepts.contains(&item.kind) {
        return bad(
            &name("type"),
            format!("{} does not take {}", place.id, item.kind),
        );
    }
    for id in &item.alternates {
        let Some(place) = cell.setup.place(id) else {
            return bad(&name("alternates"), format!("{id} is not configured"));
        };
        if !place.accepts.is_empty() && !place.accepts.contains(&item.kind) {
            return bad(
                &name("alternates"),
                format!("{id} does not take {}", item.kind),
            );
        }
    }
    let has_slot = cell.setup.mobile_robots.iter().any(|m| {
        m.slots.contains(&item.mr_slot) && spec.mobile_robot.as_ref().is_none_or(|id| *id == m.id)
    });
    if !has_slot {
        return bad(
            &name("mr_slot"),
            format!("no mobile robot of this job has {}", item.mr_slot),
        );
    }
    let delivery = spec.workflow == Workflow::DeliveryAndPlacement;
    if !delivery && !item.alternates.is_empty() {
        return bad(
            &name("alternates"),
            "they belong to delivery-and-placement".into(),
        );
    }
    let at = Location::Fixed {
        place: item.place.clone(),
    };
    let load = match &item.load_id {
        Some(id) => match cell.book.custody.0.get(id) {
            Some(load) => Some((id, load)),
            None if delivery => None,
            None => return bad(&name("load_id"), format!("{id} is not known")),
        },
        None => None,
    };
    if let Some((id, load)) = load {
        if load.kind != item.kind {
            return bad(
                &name("type"),
                format!("{id} is {}, not {}", load.kind, item.kind),
            );
        }
        let fits = match &load.location {
            Location::MobileRobot { mobile_robot, slot } => {
                delivery
                    && *slot == item.mr_slot
                    && spec
                        .mobile_robot
                        .as_ref()
                        .is_none_or(|named| named == mobile_robot)
            }
            here @ Location::Fixed { .. } => !delivery && *here == at,
            Location::Gripper { .. } | Location::Delivered { .. } | Location::Unknown { .. } => {
                false
            }
        };
        if !fits {
            return bad(&name("load_id"), format!("{id} is at {}", load.location));
        }
    }
    if !delivery && cell.book.custody.at(&at).is_none() {
        return bad(
            &name("place"),
            format!("no load is booked at {}", item.place),
        );
    }
    Ok(())
}

/// The first place of a job that an arm was not taught.
fn untaught(cell: &Cell, spec: &NewJob, arm: &str) -> Option<(usize, PlaceRef)> {
    spec.items.iter().enumerate().find_map(|(index, item)| {
        let slot = PlaceRef::MobileRobot {
            point: spec.point.clone(),
            slot: item.mr_slot.clone(),
        };
        [slot, PlaceRef::fixed(item.place.clone())]
            .into_iter()
            .find(|place| !cell.setup.is_taught(arm, place))
            .map(|place| (index, place))
    })
}

fn bad<T>(item: &str, problem: String) -> Result<T, Refusal> {
    Err(Refusal::Invalid {
        item: item.to_owned(),
        problem,
    })
}
