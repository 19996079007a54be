//! A job in a cell where something goes wrong: what is done to it, and how it is judged.

use std::sync::Arc;
use std::time::Duration;

use cell::world::PartAt;
use karel_emulator::{LedgerEvent, Operation, VirtualController};
use mobile_emulator::{Fault, LedgerEvent as MobileEvent, MobileRobot};
use serde_json::{Value, json};

use crate::faults_wire::Wires;
use crate::kit::{A_JOB, SETUP, TestCell};

/// How long something has to stay away, for a test to believe that it does not happen: 10 s of the cell.
const A_WHILE: Duration = Duration::from_millis(500);

#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Which {
    Delivery,
    Pickup,
}

/// A job of either workflow. A delivery brings load-1 from the left slot to rack/d; a pickup takes load-2 from rack/a
/// in the right slot to the warehouse.
pub(crate) struct Run {
    pub(crate) cell: TestCell,
    pub(crate) which: Which,
    pub(crate) job: String,
}

impl Which {
    pub(crate) const fn load(self) -> &'static str {
        match self {
            Self::Delivery => "load-1",
            Self::Pickup => "load-2",
        }
    }

    pub(crate) const fn slot(self) -> &'static str {
        match self {
            Self::Delivery => "left",
            Self::Pickup => "right",
        }
    }

    pub(crate) const fn place(self) -> &'static str {
        match self {
            Self::Delivery => "rack/d",
            Self::Pickup => "rack/a",
        }
    }

    fn in_slot(self) -> PartAt {
        PartAt::Slot {
            mobile_robot: "mr1".to_owned(),
            slot: self.slot().to_owned(),
        }
    }

    fn in_place(self) -> PartAt {
        PartAt::Place(self.place().to_owned())
    }

    /// Where the load is at the beginning.
    pub(crate) fn source(self) -> PartAt {
        match self {
            Self::Delivery => self.in_slot(),
            Self::Pickup => self.in_place(),
        }
    }

    /// Where the arm puts it.
    pub(crate) fn target(self) -> PartAt {
        match self {
            Self::Delivery => self.in_place(),
            Self::Pickup => self.in_slot(),
        }
    }

    /// The phase in which the arm is at the mobile robot.
    pub(crate) const fn phase_in_zone(self) -> &'static str {
        match self {
            Self::Delivery => "APPROACH",
            Self::Pickup => "PLACE_APPROACH",
        }
    }

    async fn ask(self, cell: &TestCell, more: &Value) -> String {
        let item = json!({
            "load_id": self.load(), "type": "crate", "mr_slot": self.slot(), "place": self.place(),
        });
        let mut params = json!({"mobile_robot": "mr1", "point": "handover/front", "items": [item]});
        if self == Self::Pickup {
            params["destination"] = "warehouse/gate".into();
            params["complete_on"] = "DELIVERED".into();
        }
        for (key, value) in more.as_object().into_iter().flatten() {
            if key == "alternates" {
                params["items"][0]["alternates"] = value.clone();
            } else {
                params[key] = value.clone();
            }
        }
        let workflow = match self {
            Self::Delivery => "delivery-and-placement",
            Self::Pickup => "pickup-and-delivery",
        };
        cell.job(workflow, params).await
    }
}

impl Run {
    /// An ordinary job.
    pub(crate) async fn start(which: Which) -> Self {
        Self::with(which, &[], Value::Null).await
    }

    /// A job with more parameters, whose mobile robot has these faults from the beginning.
    pub(crate) async fn with(which: Which, faults: &[Fault], more: Value) -> Self {
        Self::on(TestCell::start().await, which, faults, more).await
    }

    /// A job in a cell whose set-up says something else.
    pub(crate) async fn with_setup(
        which: Which,
        (from, to): (&str, &str),
        faults: &[Fault],
        more: Value,
    ) -> Self {
        assert!(SETUP.contains(from), "the set-up has {from}");
        let cell = TestCell::with_setup(&SETUP.replacen(from, to, 1)).await;
        Self::on(cell, which, faults, more).await
    }

    /// A job in a cell that was made for it.
    pub(crate) async fn on(cell: TestCell, which: Which, faults: &[Fault], more: Value) -> Self {
        for fault in faults {
            let _number = mobile(&cell).set_fault(fault.clone()).await.unwrap();
        }
        let job = which.ask(&cell, &more).await;
        Self { cell, which, job }
    }

    pub(crate) fn wires(&self) -> &Wires {
        self.cell.wires.as_ref().expect("lines that can be cut")
    }

    /// The arm moves so slowly that it is in the zone for longer than a mobile robot may be silent.
    pub(crate) async fn slowly(&self) {
        self.cell.controller().set_override(20).await.unwrap();
    }

    pub(crate) fn load(&self) -> &'static str {
        self.which.load()
    }

    pub(crate) fn mobile(&self) -> Arc<MobileRobot> {
        mobile(&self.cell)
    }

    pub(crate) fn arm(&self) -> &VirtualController {
        self.cell.assembly.controller("vc1").expect("vc1")
    }

    /// Something happens to the mobile robot.
    pub(crate) async fn fault(&self, fault: Fault) {
        let _number = self.mobile().set_fault(fault).await.unwrap();
    }

    pub(crate) async fn faults_end(&self) {
        let _count = self.mobile().clear_faults().await.unwrap();
    }

    /// Something happens to the arm.
    pub(crate) async fn operate(&self, operation: Operation) {
        self.arm().operate(operation).await.unwrap();
    }

    /// A person moves a part.
    pub(crate) fn moves_part(&self, part: &str, to: PartAt) {
        let world = self.cell.assembly.plant().world("demo").expect("a world");
        world.move_part(part, to);
    }

    pub(crate) async fn job(&self) -> Value {
        self.cell.get(&format!("/jobs/{}", self.job)).await
    }

    /// Waits until the job is in a state.
    pub(crate) async fn until(&self, state: &str) -> Value {
        self.cell.wait_for_job(&self.job, &[state]).await
    }

    /// Waits until a step of this phase runs.
    pub(crate) async fn until_phase(&self, phase: &str) {
        let what = format!("a running step {phase}");
        self.cell
            .wait(&what, A_JOB, async |_| {
                let job = self.job().await;
                let steps = job["steps"].as_array()?;
                let runs = |step: &&Value| step["phase"] == phase && step["state"] == "RUNNING";
                steps.iter().find(runs).map(drop)
            })
            .await;
    }

    /// Waits until the arm moves among the mobile robot's slots.
    pub(crate) async fn until_in_zone(&self) {
        self.until_phase(self.which.phase_in_zone()).await;
        self.cell
            .wait("the arm moves in the zone", A_JOB, async |_| {
                let state = self.arm().state().await.unwrap();
                let at = state.pose;
                // Z counts from axis 2, 525 mm above the floor, and the flange is above the tool's tip.
                (state.moving && at.x_mm > 700.0 && at.y_mm.abs() < 600.0 && at.z_mm < 500.0)
                    .then_some(())
            })
            .await;
    }

    /// Stops the arm in the middle of a motion of this phase, as an operator's HOLD does: whatever happens next happens
    /// in the middle, however slow this machine is. CYCLE START lets the motion go on.
    pub(crate) async fn hold_in_motion(&self, phase: &str) {
        let what = format!("the arm held in a motion of {phase}");
        self.cell
            .wait(&what, A_JOB, async |_| {
                let job = self.job().await;
                let mut steps = job["steps"].as_array()?.iter();
                let runs = steps.any(|step| step["phase"] == phase && step["state"] == "RUNNING");
                (runs && self.arm().state().await.unwrap().moving).then_some(())?;
                self.operate(Operation::Hold).await;
                self.cell
                    .wait("the arm stands", A_JOB, async |_| {
                        let state = self.arm().state().await.unwrap();
                        (!state.moving).then_some(())
                    })
                    .await;
                if self.arm().state().await.unwrap().held {
                    return Some(());
                }
                // It had just arrived: the next motion, then.
                self.operate(Operation::CycleStart).await;
                None
            })
            .await;
    }

    /// Waits until the controller takes commands again, by the server's own account.
    pub(crate) async fn until_ready(&self) {
        self.cell
            .wait("the controller is ready", A_JOB, async |cell| {
                let state = cell.get("/robots/r1/state").await;
                let controller = state["controller"].as_object()?;
                (!controller.contains_key("not_ready")).then_some(())
            })
            .await;
    }

    /// The controller loses power in the middle of a motion of this phase: what became of the motion it does not know.
    pub(crate) async fn power_cycle_in_motion(&self, phase: &str) {
        self.hold_in_motion(phase).await;
        self.arm()
            .power_cycle(karel_emulator::CmosMemory::Kept)
            .await
            .unwrap();
        self.operate(Operation::CycleStart).await;
    }

    /// Waits for a question about a fault that this may be answered to.
    pub(crate) async fn asked_for(&self, fault: &str, answer: &str) -> Question {
        let what = format!("a question about {fault} with the answer {answer}");
        self.cell
            .wait(&what, A_JOB, async |cell| {
                let open = cell.get("/interventions").await;
                let asked = open["interventions"].as_array()?;
                let of = |one: &&Value| one["fault"]["code"] == fault && one["job"] == *self.job;
                let found = asked.iter().find(of).cloned().map(Question)?;
                found.answers().contains(&answer).then_some(found)
            })
            .await
    }

    /// Waits until no motion has begun and not ended, by the arm's own ledger.
    pub(crate) async fn until_arm_stands(&self) {
        self.cell
            .wait("the arm stands", A_JOB, async |_| {
                let state = self.arm().state().await.unwrap();
                (!state.moving && state.motion_queue == 0).then_some(())
            })
            .await;
    }

    /// Waits until the load is in the gripper, by the world's own account.
    pub(crate) async fn until_gripped(&self) {
        self.cell
            .wait("the load in the gripper", A_JOB, async |cell| {
                matches!(cell.truly_at(self.load()), PartAt::Gripper(_)).then_some(())
            })
            .await;
    }

    /// Waits for a question about a fault.
    pub(crate) async fn asked(&self, fault: &str) -> Question {
        self.asked_with(fault, "").await
    }

    /// Waits for a question about a fault in these words: one that was asked earlier may be put in others.
    pub(crate) async fn asked_with(&self, fault: &str, words: &str) -> Question {
        let what = format!("a question about {fault} with the words {words:?}");
        self.cell
            .wait(&what, A_JOB, async |cell| {
                let open = cell.get("/interventions").await;
                let asked = open["interventions"].as_array()?;
                let of = |one: &&Value| {
                    let text = one["question"].as_str().unwrap_or_default();
                    one["fault"]["code"] == fault && one["job"] == *self.job && text.contains(words)
                };
                asked.iter().find(of).cloned().map(Question)
            })
            .await
    }

    /// Nobody is asked anything now.
    pub(crate) async fn assert_nobody_asked(&self) {
        let open = self.cell.get("/interventions").await;
        assert_eq!(open["interventions"], json!([]));
    }

    /// Plays a person who looks where things truly are, until the job is over; then judges it.
    pub(crate) async fn complete_with_a_person(&self) {
        let (ended, said) = self.cell.see_through(&self.job).await;
        assert_eq!(ended["state"], "COMPLETE", "{ended:#}\n{said:#?}");
        self.complete().await;
    }

    pub(crate) async fn answer(&self, question: &Question, answer: &str) {
        self.answer_with(question, json!({"answer": answer})).await;
    }

    pub(crate) async fn answer_with(&self, question: &Question, body: Value) {
        let (status, said) = self.try_answer(question, body).await;
        let now = self.question_now(question).await;
        assert_eq!(status, 200, "{said}\n{now}");
    }

    /// The question as it is now.
    pub(crate) async fn question_now(&self, question: &Question) -> Value {
        self.cell
            .get(&format!("/interventions/{}", question.id()))
            .await
    }

    pub(crate) async fn try_answer(&self, question: &Question, mut body: Value) -> (u16, Value) {
        body["reason"] = "a test".into();
        let path = format!("/interventions/{}/respond", question.id());
        let (status, said) = self.cell.post(&path, &body).await;
        (status.as_u16(), said)
    }

    pub(crate) async fn command(&self, command: &str) {
        let (status, said) = self.try_command(command).await;
        assert!((200..300).contains(&status), "{command}: {status} {said}");
    }

    pub(crate) async fn try_command(&self, command: &str) -> (u16, Value) {
        let path = format!("/jobs/{}/commands", self.job);
        let body = json!({"command": command, "reason": "a test"});
        let (status, said) = self.cell.post(&path, &body).await;
        (status.as_u16(), said)
    }

    /// Whether a fault is noted at the job.
    pub(crate) async fn has(&self, fault: &str) -> bool {
        let job = self.job().await;
        let mut noted = job["faults"].as_array().into_iter().flatten();
        noted.any(|one| one["code"] == fault)
    }

    /// Waits until a fault is noted at the job.
    pub(crate) async fn until_has(&self, fault: &str) {
        let what = format!("{fault} noted at the job");
        self.cell
            .wait(&what, A_JOB, async |_| self.has(fault).await.then_some(()))
            .await;
    }

    pub(crate) async fn until_no_permits(&self) {
        self.cell
            .wait("no permits", A_JOB, async |cell| {
                let sessions = cell.get("/sessions").await;
                let sessions = sessions["sessions"].as_array()?;
                let none = sessions.iter().all(|session| {
                    session["arm_entry_permit"] == false && session["mr_move_permit"] == false
                });
                none.then_some(())
            })
            .await;
    }

    /// The arm may not enter. (The mobile robot may still drive, to dock again or to leave.)
    pub(crate) async fn assert_no_arm_permit(&self) {
        let sessions = self.cell.get("/sessions").await;
        let sessions = sessions["sessions"].as_array().unwrap();
        let none = sessions
            .iter()
            .all(|session| session["arm_entry_permit"] == false);
        assert!(none, "{sessions:?}");
    }

    /// Waits until the arm stands out of the zone.
    pub(crate) async fn until_out_of_zone(&self) {
        self.cell
            .wait("the arm stands out of the zone", A_JOB, async |_| {
                let state = self.arm().state().await.unwrap();
                (!state.moving && (state.pose.x_mm < 600.0 || state.pose.z_mm > 600.0))
                    .then_some(())
            })
            .await;
    }

    /// For a while the arm begins nothing, and the job stays in its state.
    pub(crate) async fn nothing_moves(&self) {
        let before = self.arm().state().await.unwrap().ledger_seq;
        let state = self.job().await["state"].clone();
        let until = std::time::Instant::now() + A_WHILE;
        self.cell
            .wait("a while", A_JOB, async |_| {
                let ledger = self.arm().ledger_after(before).await.unwrap();
                let begun = ledger
                    .iter()
                    .find(|entry| entry.event == LedgerEvent::Started);
                assert!(begun.is_none(), "the arm began to move: {begun:?}");
                let now = self.job().await["state"].clone();
                let settled = [
                    ("SUSPENDING", "SUSPENDED"),
                    ("HOLDING", "HELD"),
                    ("ABORTING", "ABORTED"),
                ];
                let settles = settled
                    .iter()
                    .any(|(from, to)| state == *from && now == *to);
                assert!(now == state || settles, "{state} became {now}");
                (std::time::Instant::now() >= until).then_some(())
            })
            .await;
    }

    /// Waits for the end of the job, and judges it: the load is where it belongs, and all did only what they may.
    pub(crate) async fn complete(&self) {
        let _job = self.until("COMPLETE").await;
        match self.which {
            Which::Delivery => self.assert_at(&self.which.target()).await,
            Which::Pickup => {
                let at = self.cell.truly_at(self.load());
                assert!(matches!(at, PartAt::Away(_)), "{at:?}");
                let custody = self.cell.custody(self.load()).await;
                assert_eq!(custody["location"]["at"], "DELIVERED");
            }
        }
        self.assert_orderly().await;
    }

    /// The load is there, and the server says so.
    pub(crate) async fn assert_at(&self, at: &PartAt) {
        assert_eq!(self.cell.truly_at(self.load()), *at);
        let booked = self.cell.custody(self.load()).await["location"].clone();
        let expected = match at {
            PartAt::Place(place) => json!({"at": "FIXED", "place": place}),
            PartAt::Slot { mobile_robot, slot } => {
                json!({"at": "MOBILE_ROBOT", "mobile_robot": mobile_robot, "slot": slot})
            }
            PartAt::Gripper(_) => json!({"at": "GRIPPER", "arm": "r1"}),
            PartAt::Away(_) | PartAt::Floor(_) => panic!("no custody is compared with {at:?}"),
        };
        assert_eq!(booked, expected);
    }

    /// The load is where the server says it is, wherever that is.
    pub(crate) async fn assert_at_hand(&self) {
        let booked = self.cell.custody(self.load()).await["location"].clone();
        assert_eq!(
            booked,
            crate::operator::location(&self.cell.truly_at(self.load()))
        );
    }

    /// The arm never went among the mobile robot's slots, by its own ledger.
    pub(crate) async fn assert_never_entered(&self) {
        for entry in self.cell.ledger().await {
            let at = entry.target_pose;
            let inside = at.x_mm > 700.0 && at.y_mm.abs() < 600.0 && at.z_mm < 500.0;
            assert!(!inside, "{entry:?}");
        }
    }

    /// No motion twice, no drive without a permit, no load moved while the mobile robot may move.
    pub(crate) async fn assert_orderly(&self) {
        self.cell.assert_nothing_twice().await;
        let ledger = self.mobile().ledger().await.unwrap();
        let violation = ledger
            .iter()
            .find(|entry| matches!(entry.event, MobileEvent::Violation { .. }));
        assert!(violation.is_none(), "{violation:?}");
    }

    /// How often the mobile robot got a message of a kind.
    pub(crate) async fn told(&self, wanted: &str) -> usize {
        let ledger = self.mobile().ledger().await.unwrap();
        let messages = ledger.iter().filter(
            |entry| matches!(&entry.event, MobileEvent::Message { kind, .. } if *kind == wanted),
        );
        messages.count()
    }
}

fn mobile(cell: &TestCell) -> Arc<MobileRobot> {
    let robots = cell.assembly.plant().mobile_robots();
    Arc::clone(robots.first().expect("mr1"))
}

/// A question to a person.
pub(crate) struct Question(pub(crate) Value);

impl Question {
    pub(crate) fn id(&self) -> &str {
        self.0["id"].as_str().expect("an id")
    }

    /// What may be answered.
    pub(crate) fn answers(&self) -> Vec<&str> {
        let allowed = self.0["allowed"].as_array().expect("answers");
        allowed
            .iter()
            .filter_map(|one| one["answer"].as_str())
            .collect()
    }
}
