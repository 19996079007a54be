//! C10: a person jogs the arm between two steps of a job. It is seen, the job waits for a confirmation, and then the
//! way begins from where the arm really is: joint by joint to the safe pose, never along a line.

use karel_emulator::ledger::JointsDeg;
use karel_emulator::ledger::MotionKind;
use karel_emulator::{LedgerEvent, OperatingMode, Operation};
use serde_json::Value;

use crate::kit::TestCell;
use crate::run::{Run, Which};

/// The arm stands between two motions of a held job.
async fn between(which: Which) -> Run {
    let run = Run::on(TestCell::start().await, which, &[], Value::Null).await;
    run.until_gripped().await;
    run.command("hold").await;
    let _job = run.until("HELD").await;
    run.until_arm_stands().await;
    run.assert_nobody_asked().await;
    run
}

impl Run {
    /// T1, the pendant, six degrees of each big axis, and AUTO again. Tasks that paused go on.
    async fn jog(&self) {
        self.operate(Operation::SetMode(OperatingMode::T1)).await;
        self.operate(Operation::SetPendant(true)).await;
        let mut to = self.arm().state().await.unwrap().joints_deg;
        to.j1 += if to.j1 > 0.0 { -6.0 } else { 6.0 };
        self.operate(Operation::Jog(to)).await;
        self.operate(Operation::SetPendant(false)).await;
        self.operate(Operation::SetMode(OperatingMode::Auto)).await;
        self.operate(Operation::Reset).await;
        self.operate(Operation::CycleStart).await;
    }

    async fn joints(&self) -> JointsDeg {
        self.arm().state().await.unwrap().joints_deg
    }

    /// Asked about and held; the arm waits for the answer, and the first thing it does then is to leave.
    async fn assert_confirmed_first(&self) {
        let question = self.asked_with("F22", "moved by hand").await;
        assert_eq!(question.answers(), ["replan", "cancel", "abort"]);
        let _job = self.until("HELD").await;
        self.until_ready().await;
        self.nothing_moves().await;
        let (status, said) = self.try_command("unhold").await;
        assert_eq!(status, 409, "{said}");

        let stood = self.joints().await;
        let before = self.arm().state().await.unwrap().ledger_seq;
        self.answer(&question, "replan").await;
        self.complete().await;
        let after = self.arm().ledger_after(before).await.unwrap();
        let first = after
            .iter()
            .find(|entry| entry.event == LedgerEvent::Started)
            .expect("it goes on");
        assert_eq!(first.kind, MotionKind::Joint, "{first:#?}");
        assert!(near(first.from_deg, stood), "{first:#?}");
        let safe = JointsDeg::from([90.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
        let to = first.to_deg.expect("a target");
        assert!(near(to, safe), "{first:#?}");
    }
}

fn near(a: JointsDeg, b: JointsDeg) -> bool {
    let (a, b): ([f64; 6], [f64; 6]) = (a.into(), b.into());
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.01)
}

async fn jogged_while_held(which: Which) {
    let run = between(which).await;
    run.jog().await;
    run.assert_confirmed_first().await;
}

/// The server was not there to see it: where the arm was left is in the journal.
async fn jogged_while_the_server_was_away(which: Which) {
    let mut run = between(which).await;
    run.cell.pull_the_plug();
    run.jog().await;
    run.cell.start_server().await;
    run.assert_confirmed_first().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn c10_a_jogged_arm_is_seen_and_planned_again_in_a_delivery() {
    jogged_while_held(Which::Delivery).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn c10_a_jogged_arm_is_seen_and_planned_again_in_a_pickup() {
    jogged_while_held(Which::Pickup).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn c10_an_arm_that_was_jogged_while_the_server_was_away_is_seen_in_a_delivery() {
    jogged_while_the_server_was_away(Which::Delivery).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn c10_an_arm_that_was_jogged_while_the_server_was_away_is_seen_in_a_pickup() {
    jogged_while_the_server_was_away(Which::Pickup).await;
}
