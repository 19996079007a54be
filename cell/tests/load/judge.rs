//! What has to be true after hours of work, by the emulators' own accounts.

use cell::world::PartAt;
use karel_emulator::LedgerEvent;
use mobile_emulator::LedgerEvent as MobileEvent;
use serde_json::{Value, json};

use crate::plant::LoadedPlant;
use crate::setup::{self, ARMS, CELLS, MOBILES};
use crate::worker::Done;

pub(crate) async fn everything(plant: &LoadedPlant, done: &Done) {
    let motions = nothing_twice(plant).await;
    no_violation(plant).await;
    loads_are_where_they_are_said_to_be(plant, done).await;
    each_job_is_over(plant, done).await;
    nothing_is_left(plant).await;
    eprintln!("{motions} commands carried out, each once and in order");
}

/// No command of the wire began twice, none in another order than that of its numbers, and each grip is one.
async fn nothing_twice(plant: &LoadedPlant) -> usize {
    let mut all = 0;
    for cell in 0..CELLS {
        for arm in 0..ARMS.len() {
            let ledger = plant.controller(cell, arm).ledger().await.unwrap();
            let name = setup::controller(cell, arm);
            assert!(
                ledger.first().is_some_and(|first| first.seq == 1),
                "the ledger of {name} is whole"
            );
            let started: Vec<_> = ledger
                .iter()
                .filter(|entry| entry.event == LedgerEvent::Started)
                .filter_map(|entry| entry.command.as_ref().map(|id| (id.epoch, id.seq)))
                .collect();
            let mut sorted = started.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(
                started, sorted,
                "{name}: a motion began twice, or out of order"
            );
            let ended_badly: Vec<_> = ledger
                .iter()
                .filter(|entry| matches!(entry.event, LedgerEvent::Refused | LedgerEvent::Lost))
                .collect();
            assert!(ended_badly.is_empty(), "{name}: {ended_badly:#?}");
            let mut held: Option<&str> = None;
            for entry in &ledger {
                if entry.event == LedgerEvent::Gripped {
                    assert_eq!(held, None, "{name}: {entry:?}");
                    held = entry.part.as_deref();
                } else if entry.event == LedgerEvent::Released {
                    assert_eq!(held, entry.part.as_deref(), "{name}: {entry:?}");
                    held = None;
                }
            }
            assert_eq!(held, None, "{name}: its gripper is empty at the end");
            all += started.len();
        }
    }
    all
}

async fn no_violation(plant: &LoadedPlant) {
    for cell in 0..CELLS {
        for mobile in 0..MOBILES.len() {
            let ledger = plant.mobile_robot(cell, mobile).ledger().await.unwrap();
            assert_eq!(ledger[0].n, 1, "the ledger of {cell}/{mobile} is whole");
            let violations: Vec<_> = ledger
                .iter()
                .filter(|entry| matches!(entry.event, MobileEvent::Violation { .. }))
                .collect();
            assert!(violations.is_empty(), "{cell}/{mobile}: {violations:#?}");
        }
    }
}

/// Every crate in exactly one place by the world's account, and in the same by the server's.
async fn loads_are_where_they_are_said_to_be(plant: &LoadedPlant, done: &Done) {
    for cell in 0..CELLS {
        let parts = plant.world(cell).parts();
        let path = format!("/api/v1/cells/{}/loads", setup::cell_id(cell));
        let said = plant.get(&path).await;
        let said = said["loads"].as_array().unwrap();
        let mine = done.crates.iter().filter(|(of, ..)| *of == cell);
        assert_eq!(parts.len(), mine.clone().count(), "{parts:#?}");
        for (_, load, place) in mine {
            let at = &parts[load];
            let shown = said.iter().find(|one| one["id"] == **load);
            if let Some(place) = place {
                assert_eq!(*at, PartAt::Place(place.clone()), "{load}");
                let shown = shown.unwrap_or_else(|| panic!("{load} is not listed"));
                assert_eq!(
                    shown["location"],
                    json!({"at": "FIXED", "place": place}),
                    "{load}"
                );
                continue;
            }
            assert!(matches!(at, PartAt::Away(_)), "{load} is {at:?}");
            // The oldest that have left may be forgotten.
            if let Some(shown) = shown {
                assert_eq!(shown["location"]["at"], "DELIVERED", "{load}");
            }
        }
        for shown in said {
            let known = done
                .crates
                .iter()
                .any(|(of, load, _)| *of == cell && *load == shown["id"]);
            assert!(known, "the server has a crate nobody brought: {shown}");
        }
    }
}

async fn each_job_is_over(plant: &LoadedPlant, done: &Done) {
    for (cell, job) in &done.all {
        let path = format!("/api/v1/cells/{}/jobs/{job}", setup::cell_id(*cell));
        let job = plant.get(&path).await;
        assert_eq!(job["state"], "COMPLETE", "{job:#}");
    }
}

/// Nothing waits for anybody any more: no message, no session, no question, no claim.
async fn nothing_is_left(plant: &LoadedPlant) {
    for cell in 0..CELLS {
        let base = format!("/api/v1/cells/{}", setup::cell_id(cell));
        let questions = plant.get(&format!("{base}/interventions")).await;
        let open = questions["interventions"].as_array().unwrap();
        assert!(open.is_empty(), "{open:#?}");
        plant
            .wait("the sessions to close", async |plant| {
                let sessions = plant.get(&format!("{base}/sessions")).await;
                let closed =
                    |one: &Value| matches!(one["state"].as_str(), Some("RELEASED" | "CANCELED"));
                let all = sessions["sessions"].as_array()?;
                all.iter().all(closed).then_some(())
            })
            .await;
        for mobile in MOBILES {
            plant
                .wait("the outbox to be empty", async |plant| {
                    let path = format!("{base}/mobile-robots/{mobile}/outbox?after=0");
                    let outbox = plant.get(&path).await;
                    outbox["messages"].as_array()?.is_empty().then_some(())
                })
                .await;
        }
    }
}
