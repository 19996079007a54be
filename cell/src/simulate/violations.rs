//! What must not happen, by the emulators' own accounts.

use anyhow::Result;
use api::{Load, LoadLocation, SimulatedViolation};
use karel_emulator::LedgerEvent as ArmEvent;
use mobile_emulator::LedgerEvent as MobileEvent;

use crate::Assembly;
use crate::world::{PartAt, World};

/// Everything that must not happen and did. `offset_ms` is when the job began, on the emulators' clocks.
pub(super) async fn violations(
    assembly: &Assembly,
    cell: &str,
    offset_ms: u64,
    end_ms: u64,
    booked: &[Load],
) -> Result<Vec<SimulatedViolation>> {
    let mut found = Vec::new();
    let plant = assembly.plant();
    for robot in plant.mobile_robots() {
        for entry in robot.ledger().await? {
            if let MobileEvent::Violation { detail, .. } = &entry.event {
                found.push(SimulatedViolation {
                    at_ms: since(entry.time_s, offset_ms),
                    source: robot.id().to_owned(),
                    text: detail.clone(),
                });
            }
        }
    }
    for part in &plant.controllers {
        for entry in part.controller.ledger().await? {
            let alarm = entry.alarm.as_deref().unwrap_or("no alarm is given");
            let text = match entry.event {
                ArmEvent::Refused => format!("the controller refused a motion: {alarm}"),
                ArmEvent::Lost => "a part fell out of the gripper".to_owned(),
                ArmEvent::Started
                | ArmEvent::Finished
                | ArmEvent::Passed
                | ArmEvent::Cancelled
                | ArmEvent::Held
                | ArmEvent::Resumed
                | ArmEvent::Gripped
                | ArmEvent::Released
                | ArmEvent::Jogged => continue,
            };
            found.push(SimulatedViolation {
                at_ms: since(entry.time_s, offset_ms),
                source: part.name.clone(),
                text,
            });
        }
    }
    let truly = plant.world(cell).map(World::parts);
    for (part, at) in truly.unwrap_or_default() {
        let load = booked.iter().find(|load| load.id == part);
        let text = match (&at, load) {
            (PartAt::Floor(_), _) => "it lies on the floor".to_owned(),
            (_, Some(load)) if !agrees(&at, &load.location) => {
                format!("it is booked elsewhere than it truly is: {at:?}")
            }
            (_, Some(_) | None) => continue,
        };
        found.push(SimulatedViolation {
            at_ms: end_ms,
            source: part,
            text,
        });
    }
    found.sort_by_key(|violation| violation.at_ms);
    Ok(found)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "two hours in milliseconds, not negative"
)]
fn since(time_s: f64, offset_ms: u64) -> u64 {
    ((time_s * 1_000.0).max(0.0).round() as u64).saturating_sub(offset_ms)
}

/// Whether a load is where it is said to be. Destinations have several names; away is away. In a simulation the
/// virtual controller has the name of its arm.
fn agrees(truly: &PartAt, booked: &LoadLocation) -> bool {
    match (truly, booked) {
        (PartAt::Place(is), LoadLocation::Fixed { place }) => is == place,
        (PartAt::Gripper(is), LoadLocation::Gripper { arm }) => is == arm,
        (
            PartAt::Slot { mobile_robot, slot },
            LoadLocation::MobileRobot {
                mobile_robot: said,
                slot: said_slot,
            },
        ) => (mobile_robot, slot) == (said, said_slot),
        // What a mobile robot unloads at its destination is booked there when it says so, a moment later.
        (PartAt::Away(_), LoadLocation::Delivered { .. } | LoadLocation::MobileRobot { .. }) => {
            true
        }
        (
            PartAt::Place(_)
            | PartAt::Gripper(_)
            | PartAt::Slot { .. }
            | PartAt::Away(_)
            | PartAt::Floor(_),
            LoadLocation::Fixed { .. }
            | LoadLocation::Gripper { .. }
            | LoadLocation::MobileRobot { .. }
            | LoadLocation::Delivered { .. }
            | LoadLocation::Unknown { .. },
        ) => false,
    }
}
