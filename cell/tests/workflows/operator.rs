//! A person in the cell: looks where things truly are, and answers what only a person can.

use std::time::{Duration, Instant};

use cell::world::PartAt;
use karel_emulator::gripper::GripperPosition;
use serde_json::{Value, json};

use crate::kit::TestCell;

/// What a person said, for the report of a test.
#[derive(Debug)]
#[expect(dead_code, reason = "shown where a test fails")]
pub(crate) struct Said {
    pub(crate) fault: String,
    pub(crate) question: String,
    pub(crate) answer: String,
}

impl TestCell {
    /// Answers every open question by what is true, and clears what was aborted; what was said.
    pub(crate) async fn answer_everything(&self) -> Vec<Said> {
        let mut said = Vec::new();
        for question in self.questions().await {
            let body = self.answer_to(&question).await;
            let path = format!(
                "/interventions/{}/respond",
                question["id"].as_str().unwrap()
            );
            let (status, answer) = self.post(&path, &body).await;
            // Between the question and the answer its cause may have gone away.
            let gone = matches!(status.as_u16(), 404 | 409);
            assert!(
                status.is_success() || gone,
                "{status} {answer}\nto {body}\nof {question}"
            );
            if gone {
                // Refused for now, e.g. until a mobile robot is heard again: a person looks again a moment later.
                continue;
            }
            said.push(Said {
                fault: question["fault"]["code"].to_string(),
                question: question["question"].to_string(),
                answer: body["answer"].to_string(),
            });
        }
        said
    }

    pub(crate) async fn questions(&self) -> Vec<Value> {
        let list = self.get("/interventions").await;
        let list = list["interventions"].as_array().cloned();
        // A motion in doubt of a job is decided with the job.
        let mut list = list.unwrap_or_default();
        list.retain(|question| question["kind"] == "job");
        list
    }

    async fn answer_to(&self, question: &Value) -> Value {
        let allowed: Vec<_> = question["allowed"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(|allowed| allowed["answer"].as_str())
            .collect();
        let with = |answer: &str| json!({"answer": answer, "reason": "a person looked"});
        if allowed.contains(&"set_custody") {
            let load = question["load"].as_str().unwrap();
            let mut body = with("set_custody");
            body["custody"] = json!({"confirm": load, "location": location(&self.truly_at(load))});
            return body;
        }
        // A grip is looked at: it happened, or it did not.
        let text = question["question"]
            .as_str()
            .unwrap_or_default()
            .to_lowercase();
        let is_grip = text.starts_with("grip") || text.contains("close");
        let is_release = text.starts_with("release") || text.contains("open");
        if (is_grip || is_release) && allowed.contains(&"happened") {
            let state = self.controller().state().await.unwrap();
            let gripper = state.gripper.expect("a gripper");
            let happened = if is_grip {
                gripper.part.is_some()
            } else {
                gripper.part.is_none() && gripper.position == GripperPosition::Open
            };
            if happened {
                return with("happened");
            }
            if allowed.contains(&"did_not_happen") {
                return with("did_not_happen");
            }
        }
        let best = [
            "resume",
            "replan",
            "did_not_happen",
            "retry",
            "rescan",
            "redispatch",
            "confirm_still",
            "mark_delivered",
            "put_back",
            "cancel",
            "abort",
        ];
        let answer = best.into_iter().find(|best| allowed.contains(best));
        with(answer.unwrap_or_else(|| panic!("nothing sensible to answer to {question}")))
    }

    /// Plays the person until a job is over; the job then, and what was said.
    pub(crate) async fn see_through(&self, job: &str) -> (Value, Vec<Said>) {
        let mut all = Vec::new();
        let until = Instant::now() + crate::kit::A_JOB;
        loop {
            assert!(
                Instant::now() < until,
                "{job} does not end: {:#?}\n{all:#?}",
                self.questions().await
            );
            let path = format!("/jobs/{job}");
            let now = self
                .wait(
                    "the job is over, or a person is needed",
                    crate::kit::A_JOB,
                    async |cell| {
                        let job = cell.get(&path).await;
                        let state = job["state"].as_str()?;
                        let over = matches!(state, "COMPLETE" | "STOPPED" | "ABORTED");
                        (over || !cell.questions().await.is_empty()).then_some(job)
                    },
                )
                .await;
            let said = self.answer_everything().await;
            let asked = !said.is_empty();
            if !asked {
                self.after(Duration::from_millis(20)).await;
            }
            all.extend(said);
            match now["state"].as_str() {
                Some("COMPLETE" | "STOPPED") => return (now, all),
                Some("ABORTED") if !asked => {
                    let body = json!({"command": "clear", "reason": "a person looked"});
                    let (status, answer) = self.post(&format!("{path}/commands"), &body).await;
                    assert!(status.is_success(), "{status} {answer}");
                }
                _ => {}
            }
            assert!(
                all.len() < 20,
                "the same is asked again and again: {all:#?}"
            );
        }
    }
}

/// How the API says where a part truly is.
pub(crate) fn location(at: &PartAt) -> Value {
    match at {
        PartAt::Place(place) => json!({"at": "FIXED", "place": place}),
        PartAt::Slot { mobile_robot, slot } => {
            json!({"at": "MOBILE_ROBOT", "mobile_robot": mobile_robot, "slot": slot})
        }
        PartAt::Gripper(_) => json!({"at": "GRIPPER", "arm": "r1"}),
        PartAt::Away(_) => json!({"at": "DELIVERED", "destination": "warehouse/gate"}),
        PartAt::Floor(_) => json!({"at": "UNKNOWN"}),
    }
}
