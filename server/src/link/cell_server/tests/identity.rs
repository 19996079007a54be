//! Whose controller it is, and whether what it says can be true.

use std::time::Duration;

use api::LinkState;
use kinematics::{ArmModel, Frames, Pose, Xyzwpr};
use protocol::v2::{WireJoints, WirePose};
use tokio::time::sleep;
use units::{Degrees, Millimeters};

use super::fake::{Brain, Event};
use super::harness::{BASE, Harness, arrived, link_plan, section, to};
use super::serve::{Fake, Status};
use crate::link::cell_server::plan::Arm;
use crate::link::cell_server::{CellServerPlan, ControllerView, LinkError, MotionEnd, NotReady};

fn is_stranger(view: &ControllerView) -> bool {
    matches!(view.not_ready, Some(NotReady::OtherController { .. }))
}

/// Another controller at the address, its memory younger than that of the one that was fenced.
async fn another_controller_comes(cell: &Harness) -> Brain {
    let known = cell.fake.swap(Brain::new());
    cell.fake.cut();
    cell.until("the other one is noticed", is_stranger).await;
    known
}

/// Covers: N9. The address leads to another controller: it is neither fenced nor moved, and the right one is taken again.
#[tokio::test(start_paused = true)]
async fn c12_another_controller_at_the_address_is_refused_and_left_alone() {
    let cell = Harness::start().await;
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    let known = another_controller_comes(&cell).await;
    let (motion, _) = cell.submit(to(200.0));
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::NotReady(NotReady::OtherController { .. })
            }
        ),
        "{end:?}"
    );
    sleep(Duration::from_mins(1)).await;
    assert!(is_stranger(&cell.link.view()));
    assert!(cell.fake.ledger().is_empty(), "not even a fence reached it");

    let _other = cell.fake.swap(known);
    cell.fake.cut();
    cell.until_state(LinkState::Control).await;
    assert!(arrived(&*cell.carry_out(to(200.0)).await));
}

/// Two machines have the address: the status port is one's, the command port the other's.
#[tokio::test(start_paused = true)]
async fn n6_a_command_port_of_another_machine_is_noticed_by_its_greeting() {
    let cell = Harness::start().await;
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    // No line comes from the status port meanwhile, so that only the greeting can tell.
    cell.until_idle().await;
    cell.fake.brain().status.epoch_max = 0;
    let (motion, _) = cell.submit(to(200.0));
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::NotReady(NotReady::OtherController { .. } | NotReady::NotFenced)
            }
        ),
        "{end:?}"
    );
    let moved = |event: &Event| matches!(event, Event::Started(number) if number.seq == 2);
    assert!(!cell.fake.ledger().iter().any(moved));
}

/// All links go at once, and come back in another order: each by itself, and none before its turn.
#[tokio::test(start_paused = true)]
async fn n8_links_that_were_all_lost_come_back_one_by_one_in_any_order() {
    let cells = [(); 8].map(|()| Harness::on(&Fake::new(), BASE));
    for cell in &cells {
        cell.until_state(LinkState::Control).await;
        cell.fake.set_status(Status::BlackHole);
        cell.fake.cut();
    }
    for cell in &cells {
        cell.until("it is lost", |view| !view.is_connected()).await;
    }
    for turn in [5, 0, 7, 2, 1, 6, 3, 4] {
        cells[turn].fake.set_status(Status::Well);
        cells[turn].until_state(LinkState::Control).await;
        assert!(arrived(&*cells[turn].carry_out(to(100.0)).await));
        let back = |cell: &&Harness| cell.link.view().is_connected();
        let well = |cell: &&Harness| cell.fake.is_well();
        assert_eq!(
            cells.iter().filter(back).count(),
            cells.iter().filter(well).count()
        );
    }
}

fn arm() -> Arm {
    let model = ArmModel::builtin("fanuc-m20ia").unwrap();
    Arm {
        model,
        frames: Frames::default(),
    }
}

fn wire(pose: &Pose) -> WirePose {
    let at = pose.xyzwpr();
    WirePose::try_new([at.x, at.y, at.z], [at.w, at.p, at.r]).unwrap()
}

/// A fake that stands at these joints, and says so.
fn standing(joints: [f64; 6], arm: &Arm) -> Fake {
    let fake = Fake::new();
    {
        let mut brain = fake.brain();
        let said = kinematics::PendantJoints::from_degrees(joints);
        brain.status.joints = WireJoints::try_new(joints.map(Degrees)).unwrap();
        brain.status.pose = wire(&arm.frames.tcp_in_user_frame(&arm.model.forward(&said)));
    }
    fake
}

fn with(fake: &Fake, arm: Arm) -> Harness {
    let plan = CellServerPlan {
        arm: Some(arm),
        ..link_plan(section())
    };
    Harness::of_plan(fake, BASE, plan)
}

const JOINTS: [f64; 6] = [10.0, 20.0, -30.0, 5.0, -60.0, 15.0];

#[tokio::test(start_paused = true)]
async fn c13_a_pose_that_its_joints_do_not_give_is_refused_until_it_is_plausible() {
    let cell = with(&standing(JOINTS, &arm()), arm());
    cell.until_state(LinkState::Control).await;
    // The pulse counts of J1 are lost, the pose is remembered.
    let remembered = cell.fake.brain().status.joints;
    let mut shifted = JOINTS;
    shifted[0] += 30.0;
    cell.fake.brain().status.joints = WireJoints::try_new(shifted.map(Degrees)).unwrap();
    cell.until("the pose is implausible", |view| {
        matches!(view.not_ready, Some(NotReady::ImplausiblePose { .. }))
    })
    .await;
    let (motion, _) = cell.submit(to(100.0));
    let end = cell.end(motion).await;
    assert!(matches!(&*end, MotionEnd::NotSent { .. }), "{end:?}");
    cell.fake.brain().status.joints = remembered;
    cell.until_state(LinkState::Control).await;
}

#[tokio::test(start_paused = true)]
async fn c13_joints_beyond_their_limits_are_refused() {
    let mut beyond = JOINTS;
    beyond[4] = 200.0;
    let cell = with(&standing(beyond, &arm()), arm());
    cell.until("a joint is implausible", |view| {
        matches!(view.not_ready, Some(NotReady::ImplausibleJoint { axis, .. }) if axis == kinematics::Axis::J5)
    })
    .await;
    let said = cell.link.view().not_ready.unwrap().to_string();
    assert!(said.contains("J5") && said.contains("200"), "{said}");
}

/// The robot is configured with a tool of 100 mm, and the controller counts from the flange.
#[tokio::test(start_paused = true)]
async fn h13_another_tool_than_the_configured_one_is_refused_by_where_it_puts_the_pose() {
    let tool = Pose::try_from_xyzwpr(&Xyzwpr {
        x: Millimeters(0.0),
        y: Millimeters(0.0),
        z: Millimeters(100.0),
        w: Degrees(0.0),
        p: Degrees(0.0),
        r: Degrees(0.0),
    })
    .unwrap();
    let configured = Arm {
        frames: Frames {
            tool,
            ..Frames::default()
        },
        ..arm()
    };
    let cell = with(&standing(JOINTS, &arm()), configured);
    cell.until("the tool is another one", |view| {
        matches!(view.not_ready, Some(NotReady::ImplausiblePose { apart_um, .. }) if apart_um.abs_diff(100_000) < 10)
    })
    .await;
}
