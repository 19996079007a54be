//! The person beside the cells.
//!
//! Machine and virtual parts share their processors: where this machine stands still for a quarter of a second, the
//! cells see arms and mobile robots that are not heard for seconds, do what they have to, and ask. The person looks
//! where things truly are and answers. On a machine that keeps up there is nothing to do.

use std::time::Duration;

use cell::world::PartAt;
use karel_emulator::gripper::GripperPosition;
use serde_json::{Value, json};

use crate::plant::LoadedPlant;
use crate::setup::{self, ARMS, CELLS};

/// What to answer where nothing has to be looked at, the best first.
const BEST: [&str; 10] = [
    "resume",
    "replan",
    "did_not_happen",
    "retry",
    "rescan",
    "redispatch",
    "confirm_still",
    "mark_delivered",
    "put_back",
    "hold",
];

/// Answers what is asked, for as long as it is polled; each answer that was taken goes into `said`.
pub(crate) async fn answers(
    plant: LoadedPlant,
    said: std::rc::Rc<std::cell::RefCell<Vec<String>>>,
) {
    loop {
        for cell in 0..CELLS {
            let base = format!("/api/v1/cells/{}/interventions", setup::cell_id(cell));
            let list = plant.get(&base).await;
            for question in list["interventions"].as_array().into_iter().flatten() {
                // A motion in doubt of a job is decided with the job.
                if question["kind"] != "job" {
                    continue;
                }
                let Some(body) = answer_to(&plant, cell, question).await else {
                    continue;
                };
                let id = question["id"].as_str().unwrap();
                let (status, answer) = plant.post(&format!("{base}/{id}/respond"), &body).await;
                match status {
                    200..300 => said.borrow_mut().push(format!(
                        "{}: {} {}",
                        question["fault"]["code"], question["question"], body["answer"]
                    )),
                    // Its cause went away meanwhile, or it is too early: looked at again.
                    404 | 409 => {}
                    _ => panic!("{status} {answer}\nto {body}\nof {question}"),
                }
            }
        }
        tokio::time::sleep(Duration::from_millis(250)).await;
    }
}

async fn answer_to(plant: &LoadedPlant, cell: usize, question: &Value) -> Option<Value> {
    let allowed: Vec<_> = question["allowed"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|allowed| allowed["answer"].as_str())
        .collect();
    let with = |answer: &str| json!({"answer": answer, "reason": "a person looked"});
    if allowed.contains(&"set_custody") {
        let load = question["load"].as_str()?;
        let at = plant.world(cell).parts().get(load).cloned()?;
        let mut body = with("set_custody");
        body["custody"] = json!({"confirm": load, "location": location(&at)?});
        return Some(body);
    }
    // A grip is looked at: it happened, or it did not.
    let text = question["question"].as_str()?.to_lowercase();
    let (closes, opens) = (
        text.contains("closing the gripper"),
        text.contains("opening the gripper"),
    );
    if (closes || opens) && allowed.contains(&"happened") {
        let arm = ARMS.iter().position(|arm| question["robot"] == **arm)?;
        let state = plant.controller(cell, arm).state().await.unwrap();
        let gripper = state.gripper?;
        let happened = match gripper.position {
            // It is looked at again when it stands.
            GripperPosition::Closing | GripperPosition::Opening => return None,
            GripperPosition::Open => opens,
            GripperPosition::Closed => closes && gripper.part.is_some(),
        };
        return Some(with(if happened {
            "happened"
        } else {
            "did_not_happen"
        }));
    }
    let best = BEST.into_iter().find(|best| allowed.contains(best));
    Some(with(best.unwrap_or_else(|| {
        panic!("nothing sensible to answer to {question}")
    })))
}

/// How the API says where a part truly is.
fn location(at: &PartAt) -> Option<Value> {
    Some(match at {
        PartAt::Place(place) => json!({"at": "FIXED", "place": place}),
        PartAt::Slot { mobile_robot, slot } => {
            json!({"at": "MOBILE_ROBOT", "mobile_robot": mobile_robot, "slot": slot})
        }
        PartAt::Gripper(controller) => {
            let arm = ARMS.get(controller.rsplit('-').next()?.parse::<usize>().ok()? - 1)?;
            json!({"at": "GRIPPER", "arm": arm})
        }
        PartAt::Away(mobile_robot) => {
            json!({"at": "DELIVERED", "destination": format!("gates/{mobile_robot}")})
        }
        PartAt::Floor(_) => return None,
    })
}
