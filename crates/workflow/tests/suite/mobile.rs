//! What mobile robots say and do: lost numbers, loads that are gone, orders that are refused or given up.

use super::usual::m1;
use super::world::{World, delivery, fixed, operator, pickup};
use uuid::Uuid;
use workflow::{
    Answer, Detail, Fact, Fault, Input, InstantAction, JobState, Location, Message, Refusal, Reply,
    SessionState, Signal, SignalAnswer, SignalKind, SlotLoad,
};

/// A world whose mobile robots say only what the test says.
fn quiet() -> World {
    let mut w = World::new();
    for mobile in w.mobiles.values_mut() {
        mobile.beats = false;
    }
    w
}

fn signal(w: &World, seq: u64, kind: SignalKind) -> Signal {
    Signal {
        mobile_robot: "m1".into(),
        session: None,
        boot: 1,
        seq,
        kind,
        at_ms: None,
        resync: false,
        state: w.mobiles["m1"].state.clone(),
    }
}

fn say(w: &mut World, signal: Signal) -> SignalAnswer {
    match w.input(Input::Signal(Box::new(signal))) {
        Ok(Reply::Signal(answer)) => answer,
        other => panic!("{other:?}"),
    }
}

const TAKEN: SignalAnswer = SignalAnswer::Accepted { duplicate: false };

/// F23: what is lost for ever does not keep the mobile robot silent for ever, and is not acted on if it comes after all.
#[test]
fn f23_a_gap_is_closed_by_a_heartbeat_that_gives_the_lost_numbers_up() {
    let mut w = quiet();
    for seq in 1..=4 {
        let beat = signal(&w, seq, SignalKind::MrHeartbeat);
        assert_eq!(say(&mut w, beat), TAKEN);
    }
    // 5 and 6 are lost. 7 uses nothing up, however often it comes.
    let gap = SignalAnswer::Gap {
        boot: 1,
        expected: 5,
        got: 7,
    };
    for _twice in 0..2 {
        let seventh = signal(&w, 7, SignalKind::MrMode);
        assert_eq!(say(&mut w, seventh), gap);
    }
    let only_heartbeats = Signal {
        resync: true,
        ..signal(&w, 8, SignalKind::MrMode)
    };
    let refused = w.input(Input::Signal(Box::new(only_heartbeats)));
    assert!(matches!(refused, Err(Refusal::Invalid { item, .. }) if item == "resync"));
    let resync = Signal {
        resync: true,
        ..signal(&w, 8, SignalKind::MrHeartbeat)
    };
    assert_eq!(say(&mut w, resync.clone()), TAKEN);
    assert_eq!(
        say(&mut w, resync),
        SignalAnswer::Accepted { duplicate: true }
    );
    let ninth = signal(&w, 9, SignalKind::MrMode);
    assert_eq!(say(&mut w, ninth), TAKEN);
    // The lost ones come after all, over a restart too: journaled, and nothing else.
    for seq in [5, 6, 7] {
        let state = w.cell.mobile_robots();
        let mut late = signal(&w, seq, SignalKind::LoadChanged);
        late.state.loads = Some(Vec::new());
        let before = w.journal.len();
        assert_eq!(
            say(&mut w, late.clone()),
            SignalAnswer::Late { duplicate: false }
        );
        assert_eq!(w.journal.len(), before + 1, "kept as a record");
        assert_eq!(w.cell.mobile_robots(), state, "and not acted on");
        assert_eq!(say(&mut w, late), SignalAnswer::Late { duplicate: true });
        w.crash();
    }
    assert!(w.cell.custody().iter().all(|l| !matches!(
        l.load.location,
        Location::Unknown { .. } | Location::Delivered { .. }
    )));
    let tenth = signal(&w, 10, SignalKind::MrMode);
    assert_eq!(say(&mut w, tenth), TAKEN);
}

/// A signal that is parked has its turn before the heartbeat that gives its predecessor up.
#[test]
fn f23_what_is_parked_is_not_given_up() {
    let mut w = quiet();
    let first = signal(&w, 1, SignalKind::MrMode);
    assert_eq!(say(&mut w, first), TAKEN);
    let third = signal(&w, 3, SignalKind::MrMode);
    assert_eq!(say(&mut w, third.clone()), SignalAnswer::Parked);
    let resync = Signal {
        resync: true,
        ..signal(&w, 6, SignalKind::MrHeartbeat)
    };
    assert_eq!(say(&mut w, resync), TAKEN);
    assert_eq!(
        say(&mut w, third),
        SignalAnswer::Accepted { duplicate: true }
    );
    for lost in [2, 4, 5] {
        let late = signal(&w, lost, SignalKind::MrMode);
        assert_eq!(say(&mut w, late), SignalAnswer::Late { duplicate: false });
    }
}

/// Where the cell believes a load to be.
fn believed(w: &World, load: &str) -> Location {
    let all = w.cell.custody();
    let load = all.into_iter().find(|l| l.id == load);
    load.unwrap().load.location
}

/// A load that the mobile robot does not have any more, and that nobody ordered off it.
#[test]
fn f10_a_load_that_a_mobile_robot_no_longer_has_is_asked_about() {
    let mut w = quiet();
    let mut changed = signal(&w, 1, SignalKind::LoadChanged);
    // L1 is in s1 as it should be; L2 is gone.
    changed.state.loads = Some(vec![SlotLoad {
        slot: "s1".into(),
        load: Some("L1".into()),
    }]);
    assert_eq!(say(&mut w, changed), TAKEN);
    assert!(matches!(
        believed(&w, "L2"),
        Location::Unknown { arm: None }
    ));
    assert!(matches!(believed(&w, "L1"), Location::MobileRobot { .. }));
    let question = w.open_question().unwrap().question;
    assert_eq!(
        (question.fault, question.load.as_deref(), question.job),
        (Fault::PartLost, Some("L2"), None)
    );
    let rack = fixed("rack/b");
    let detail = |load: &str| Detail::Custody {
        load: load.into(),
        confirm: load.into(),
        location: rack.clone(),
    };
    assert!(w.answer(Answer::SetCustody, detail("L1")).is_err());
    assert!(w.answer(Answer::SetCustody, Detail::None).is_err());
    let _reply = w.answer(Answer::SetCustody, detail("L2")).unwrap();
    assert_eq!(believed(&w, "L2"), rack);
    assert!(w.open_question().is_none());
    w.crash();
    assert_eq!(believed(&w, "L2"), rack);
    assert!(w.open_question().is_none());
}

/// No sensors is not the same as no loads.
#[test]
fn loads_that_are_not_told_are_not_gone() {
    let mut w = quiet();
    let mut changed = signal(&w, 1, SignalKind::LoadChanged);
    changed.state.loads = None;
    assert_eq!(say(&mut w, changed), TAKEN);
    assert!(w.open_question().is_none());
    let mut empty = signal(&w, 2, SignalKind::LoadChanged);
    empty.state.loads = Some(Vec::new());
    assert_eq!(say(&mut w, empty), TAKEN);
    let open = w.cell.interventions().iter().filter(|i| i.open).count();
    assert_eq!(open, 2, "L1 and L2");
}

fn in_transport(w: &mut World) -> (Uuid, Uuid) {
    m1(w).delivers = false;
    let mut spec = pickup();
    spec.expected_transport_ms = Some(10_000);
    let job = w.create(spec);
    let away = w.run(120_000, |w| {
        w.cell
            .sessions(0)
            .iter()
            .any(|s| s.state == SessionState::Released)
    });
    assert!(away, "{}", w.story());
    let begun = w.journal.iter().find_map(|fact| match fact {
        Fact::TransportBegun { order, .. } => Some(*order),
        _ => None,
    });
    (job, begun.unwrap())
}

/// At the destination its order explains that the load is gone; what nobody ordered off is asked about.
#[test]
fn b15_only_what_the_order_names_is_delivered() {
    let mut w = World::new();
    let (job, order) = in_transport(&mut w);
    // It has taken everything off at the destination, L1 and L2 of others too.
    let m = m1(&mut w);
    m.seq += 1;
    let seq = m.seq;
    m.state.at_point = Some("warehouse".into());
    let mut changed = signal(&w, seq, SignalKind::LoadChanged);
    changed.state.order = Some(order);
    changed.state.loads = Some(Vec::new());
    assert_eq!(say(&mut w, changed), TAKEN);
    assert_eq!(
        believed(&w, "P1"),
        Location::Delivered {
            destination: "warehouse".into()
        }
    );
    for load in ["L1", "L2"] {
        assert!(matches!(
            believed(&w, load),
            Location::Unknown { arm: None }
        ));
    }
    let asked = w.cell.interventions().iter().filter(|i| i.open).count();
    assert_eq!(asked, 2);
    assert_eq!(w.state(job), JobState::Suspended);
}

/// The order to take off names the job's loads and no other.
#[test]
fn b13_the_order_says_what_to_take_off() {
    let mut w = World::new();
    let job = w.create(pickup());
    w.complete(job);
    let last = m1(&mut w).got.iter().rev().find_map(|m| match m {
        Message::TransportOrder { unload, .. } => unload.clone(),
        _ => None,
    });
    let p1 = SlotLoad {
        slot: "s3".into(),
        load: Some("P1".into()),
    };
    assert_eq!(last, Some(vec![p1]));
    // What it brings is not to be taken off anywhere.
    let mut w = World::new();
    let job = w.create(delivery());
    w.complete(job);
    assert!(m1(&mut w).got.iter().all(|m| !matches!(
        m,
        Message::TransportOrder {
            unload: Some(_),
            ..
        }
    )));
}

/// F20: the order that is sent again is the same one, and its answer is known by it.
#[test]
fn f20_a_transport_that_is_refused_is_asked_about_at_once() {
    let mut w = World::new();
    let (job, order) = in_transport(&mut w);
    let resent = |w: &World| {
        w.journal
            .iter()
            .filter_map(|fact| match fact {
                Fact::Told {
                    session,
                    message:
                        Message::TransportOrder {
                            order: o, update, ..
                        },
                    ..
                } if *o == order => Some((*session, *update)),
                _ => None,
            })
            .collect::<Vec<_>>()
    };
    let before = resent(&w);
    let session = before.last().unwrap().0;
    assert!(session.is_some());
    assert!(w.run(120_000, |w| resent(w).len() > before.len()));
    assert_eq!(
        resent(&w).last(),
        before.last(),
        "the same order, by its session"
    );
    // It refuses: its session is closed, and still it is the answer.
    let m = m1(&mut w);
    m.seq += 1;
    m.sending.clear();
    let seq = m.seq;
    let mut refused = signal(&w, seq, SignalKind::MrRejected);
    (refused.session, refused.state.order) = (session, Some(order));
    assert_eq!(say(&mut w, refused), TAKEN);
    let question = w.open_question().expect("a question").question;
    assert_eq!(question.fault, Fault::TransportFailed);
    assert!(
        question.question.contains("refused"),
        "{}",
        question.question
    );
    assert_eq!(question.job, Some(job));
}

fn until_dock_question(w: &mut World) -> Uuid {
    m1(w).dock_error_mm = 50.0;
    let job = w.create(delivery());
    let asked = w.run(1_500_000, |w| {
        w.open_question()
            .is_some_and(|q| q.question.fault == Fault::DockFailed)
    });
    assert!(asked, "{}", w.story());
    job
}

/// F3, given up: it backs out, and comes again with a new order.
#[test]
fn f03_docking_that_is_given_up_begins_anew() {
    let mut w = World::new();
    let job = until_dock_question(&mut w);
    m1(&mut w).dock_error_mm = 0.0;
    let _reply = w.answer(Answer::Redispatch, Detail::None).unwrap();
    w.complete(job);
    let got = &m1(&mut w).got;
    assert!(got.contains(&Message::SkipRetry));
    let orders: std::collections::BTreeSet<_> = got
        .iter()
        .filter_map(|m| match m {
            Message::TransportOrder { order, .. } => Some(*order),
            _ => None,
        })
        .collect();
    assert_eq!(orders.len(), 2);
    assert_eq!(w.asked.len(), 1, "F3's question is not replaced by another");
}

/// F3, tried once more by a person's word.
#[test]
fn f03_docking_is_tried_again_by_answer() {
    let mut w = World::new();
    let job = until_dock_question(&mut w);
    m1(&mut w).dock_error_mm = 0.0;
    let _reply = w.answer(Answer::Retry, Detail::None).unwrap();
    w.complete(job);
    assert_eq!(w.asked.len(), 1);
}

/// F3: it takes every RETRY and does nothing about any. The same question comes again, and every way out of it but this
/// one is open: the job stops, and the point is free for others once it has left.
#[test]
fn f03_a_mobile_robot_that_ignores_retry_is_asked_about_again_and_can_be_given_up() {
    let mut w = World::new();
    let job = until_dock_question(&mut w);
    m1(&mut w).obeys_retry = false;
    for asked in 2..4 {
        let _reply = w.answer(Answer::Retry, Detail::None).unwrap();
        let again = |w: &World| w.asked.len() == asked && w.open_question().is_some();
        assert!(w.run(200_000, again), "{}", w.story());
        let question = w.open_question().unwrap().question;
        assert_eq!(question.fault, Fault::DockFailed);
        for way in [Answer::Retry, Answer::Redispatch, Answer::Cancel] {
            assert!(question.answers.contains(&way), "{question:?}");
        }
    }
    cancel(&mut w, job);
}

/// The question is answered with the end of the job, and what the job had is free soon after.
fn cancel(w: &mut World, job: Uuid) {
    let _reply = w.answer(Answer::Cancel, Detail::None).unwrap();
    assert!(w.run(120_000, |w| w.state(job) == JobState::Stopped));
    assert!(
        w.run(60_000, |w| w.cell.claims().is_empty()),
        "{}",
        w.story()
    );
}

/// F3, canceled: it may not stay in the zone, so it gets the permit to drive out.
#[test]
fn f03_a_mobile_robot_that_gave_up_in_the_zone_may_leave_it() {
    let mut w = World::new();
    let job = until_dock_question(&mut w);
    cancel(&mut w, job);
    let got = &m1(&mut w).got;
    let canceled = got
        .iter()
        .position(|m| matches!(m, Message::CancelOrder { .. }))
        .unwrap();
    assert!(
        got[canceled..].contains(&Message::MovePermit { granted: true }),
        "{got:?}"
    );
}

/// An order is not given to a mobile robot that is still busy with the one before.
#[test]
fn a3_an_order_waits_until_the_one_before_is_over() {
    let mut w = World::new();
    let earlier = Uuid::from_u128(4711);
    m1(&mut w).state.order = Some(earlier);
    assert!(w.run(5_000, |w| {
        w.cell
            .mobile_robots()
            .iter()
            .any(|m| m.state.as_ref().is_some_and(|s| s.order == Some(earlier)))
    }));
    let job = w.create(delivery());
    let _waited = w.run(3_000, |_| false);
    assert!(m1(&mut w).got.is_empty(), "{:?}", m1(&mut w).got);
    m1(&mut w).state.order = None;
    w.complete(job);
}

fn triggered(change: impl FnOnce(&mut workflow::Trigger)) -> World {
    let mut setup = super::world::setup();
    let mut job = delivery();
    job.mobile_robot = None;
    let mut trigger = workflow::Trigger {
        id: "unload".into(),
        enabled: true,
        signal: SignalKind::MrArrived,
        mobile_robot: None,
        points: vec![super::world::POINT.into()],
        deadline_ms: Some(600_000),
        job,
    };
    change(&mut trigger);
    setup.triggers.push(trigger);
    World::with(setup, 1, super::world::Odds::default())
}

/// It comes by itself: the number of the signal, or `None` if it could not be sent.
fn arrives(w: &mut World) -> Signal {
    let m = m1(w);
    m.state.at_point = Some(super::world::POINT.into());
    w.say("m1", SignalKind::MrArrived);
    let m = m1(w);
    m.state.at_point = None;
    m.sending.back().unwrap().clone()
}

fn skipped(w: &World) -> Vec<String> {
    let skipped = w.journal.iter().filter_map(|fact| match fact {
        Fact::TriggerSkipped { text, .. } => Some(text.clone()),
        _ => None,
    });
    skipped.collect()
}

/// P1: one job for one signal, whenever the process dies and however often the signal is sent.
#[test]
fn a_mobile_robot_that_comes_by_itself_starts_one_job() {
    let mut w = triggered(|_| {});
    let signal = arrives(&mut w);
    assert!(w.run(2_000, |w| !w.cell.jobs(w.now).is_empty()));
    for _again in 0..3 {
        let answer = say(&mut w, signal.clone());
        assert_eq!(answer, SignalAnswer::Accepted { duplicate: true });
        w.crash();
    }
    let jobs = w.cell.jobs(w.now);
    assert_eq!(jobs.len(), 1);
    assert_eq!(jobs[0].trigger.as_deref(), Some("unload"));
    // It says so once more while that job is open, without an order yet: nothing is started.
    let again = jobs[0].id;
    w.complete(again);
    assert_eq!(w.cell.jobs(w.now).len(), 1);
    // The record has where it came from.
    let origin = w.journal.iter().find_map(|fact| match fact {
        Fact::JobCreated { origin, .. } => origin.clone(),
        _ => None,
    });
    let wanted = format!("m1/{}/{}", signal.boot, signal.seq);
    assert_eq!(origin, Some(wanted));
}

/// P1: it dies right after the record that has both, before anything of it was carried out or answered.
#[test]
fn p1_a_crash_right_after_the_record_starts_no_second_job() {
    let mut w = triggered(|_| {});
    let _signal = arrives(&mut w);
    let next: Vec<_> = (1..200).map(|n| w.records + n).collect();
    w.crash_at = next;
    assert!(w.run(5_000, |w| !w.cell.jobs(w.now).is_empty()));
    w.crash_at.clear();
    assert!(w.crashes > 0);
    let job = w.cell.jobs(w.now)[0].id;
    w.complete(job);
    assert_eq!(w.cell.jobs(w.now).len(), 1);
}

/// While its job is open, or while it carries nothing, a signal starts nothing, and the record says why.
#[test]
fn a_trigger_does_not_bounce() {
    let mut w = triggered(|t| t.deadline_ms = None);
    w.may_act = false;
    w.crash();
    let _first = arrives(&mut w);
    assert!(w.run(2_000, |w| !w.cell.jobs(w.now).is_empty()));
    let _second = arrives(&mut w);
    assert!(w.run(5_000, |w| !skipped(w).is_empty()));
    assert!(skipped(&w)[0].contains("is not over"), "{:?}", skipped(&w));
    assert_eq!(w.cell.jobs(w.now).len(), 1);
    let mut w = triggered(|_| {});
    w.loads.retain(|load, _| load.starts_with('P'));
    let _empty = arrives(&mut w);
    assert!(w.run(5_000, |w| !skipped(w).is_empty()));
    assert!(skipped(&w)[0].contains("carries nothing"));
    assert!(w.cell.jobs(w.now).is_empty());
}

/// What is not meant starts nothing.
#[test]
fn a_trigger_fires_only_where_it_is_meant() {
    let cases: [fn(&mut workflow::Trigger); 4] = [
        |t| t.enabled = false,
        |t| t.signal = SignalKind::MrReady,
        |t| t.mobile_robot = Some("m2".into()),
        |t| t.points = vec!["station/2".into()],
    ];
    for change in cases {
        let mut w = triggered(change);
        let _signal = arrives(&mut w);
        assert!(w.run(2_000, |w| w.mobiles["m1"].sending.is_empty()));
        assert!(w.cell.jobs(w.now).is_empty());
        assert!(skipped(&w).is_empty());
    }
    // Anywhere will do where no point is named.
    let mut w = triggered(|t| t.points.clear());
    let _signal = arrives(&mut w);
    assert!(w.run(2_000, |w| !w.cell.jobs(w.now).is_empty()));
    // With an order of the cell it is expected, and no news.
    let mut w = triggered(|t| t.points.clear());
    let job = w.create(delivery());
    w.complete(job);
    assert_eq!(w.cell.jobs(w.now).len(), 1);
}

fn instant(w: &mut World, action: InstantAction) -> Result<Reply, Refusal> {
    w.input(Input::InstantAction {
        mobile_robot: "m1".into(),
        action,
        principal: operator(),
        reason: None,
    })
}

/// What a job has begun, the job ends.
#[test]
fn an_instant_action_does_not_interfere_with_a_job() {
    let mut w = World::new();
    let told = |w: &World| w.mobiles["m1"].got.last().cloned();
    let _reply = instant(&mut w, InstantAction::StateRequest).unwrap();
    assert_eq!(told(&w), Some(Message::StateRequest));
    let viewer = w.input(Input::InstantAction {
        mobile_robot: "m1".into(),
        action: InstantAction::StartPause,
        principal: workflow::Principal {
            name: "vic".into(),
            role: workflow::Role::Viewer,
        },
        reason: None,
    });
    assert!(matches!(viewer, Err(Refusal::Forbidden { .. })));
    let none = instant(&mut w, InstantAction::CancelOrder { order: None });
    assert!(matches!(none, Err(Refusal::Conflict { text, .. }) if text.contains("no order")));
    let foreign = Uuid::from_u128(4711);
    let cancel = InstantAction::CancelOrder {
        order: Some(foreign),
    };
    let _reply = instant(&mut w, cancel).unwrap();
    assert_eq!(told(&w), Some(Message::CancelOrder { order: foreign }));
    let job = w.create(delivery());
    assert!(w.run(60_000, |w| w.arm_inside(&w.arms["r1"])));
    for action in [
        InstantAction::CancelOrder { order: None },
        InstantAction::Retry,
        InstantAction::SkipRetry,
    ] {
        let refused = instant(&mut w, action);
        assert!(
            matches!(&refused, Err(Refusal::Conflict { text, .. }) if text.contains("stop")),
            "{refused:?}"
        );
    }
    let _reply = instant(&mut w, InstantAction::StartPause).unwrap();
    let refused = instant(&mut w, InstantAction::StopPause);
    assert!(
        matches!(refused, Err(Refusal::Interlock { .. })),
        "{refused:?}"
    );
    assert!(w.run(60_000, |w| !w.arm_inside(&w.arms["r1"])));
    assert!(w.run(60_000, instant_ends));
    let _reply = instant(&mut w, InstantAction::StopPause).unwrap();
    w.complete(job);
    let acted = w
        .journal
        .iter()
        .filter(|f| matches!(f, Fact::InstantActed { .. }));
    assert_eq!(
        acted.count(),
        4,
        "each in the record, and none that was refused"
    );
}

/// The arm is out, by its own word.
fn instant_ends(w: &World) -> bool {
    w.cell
        .sessions(0)
        .iter()
        .all(|s| s.state == SessionState::ExitGranted)
}

/// A world whose mobile robots drive no faster than this, as the set-up has it.
fn no_faster(max_speed_mm_s: u32) -> World {
    let mut setup = super::world::setup();
    for robot in &mut setup.mobile_robots {
        robot.max_speed_mm_s = Some(max_speed_mm_s);
    }
    World::with(setup, 1, super::world::Odds::default())
}

/// Why docking failed, and how many facts came before each.
fn failed_docks(w: &World) -> Vec<(usize, String)> {
    let facts = w.journal.iter().enumerate();
    let failed = facts.filter_map(|(at, fact)| match fact {
        Fact::FaultNoted {
            fault: Fault::DockFailed,
            text,
            ..
        } => Some((at, text.clone())),
        _ => None,
    });
    failed.collect()
}

/// The pose that a mobile robot tells goes farther than it can drive: it does not know where it is, whatever it says of
/// that. It is told to dock anew, and the arm comes near only after it did without another jump.
///
/// Covers: M5.
#[test]
fn m5_a_pose_that_jumped_lets_no_arm_in_until_it_docked_anew() {
    let mut w = no_faster(200);
    let job = w.create(delivery());
    w.complete(job);
    let failed = failed_docks(&w);
    let [(at, text)] = &failed[..] else {
        panic!("{failed:?}");
    };
    assert!(
        text.contains("200 mm/s") && text.contains("does not know where it is"),
        "{text}"
    );
    let docked = w.journal.iter().position(|fact| {
        matches!(
            fact,
            Fact::SessionMoved {
                to: SessionState::Docked,
                ..
            }
        )
    });
    assert!(docked.is_some_and(|docked| docked > *at), "{failed:?}");
    let retries = m1(&mut w).got.iter();
    assert_eq!(retries.filter(|m| **m == Message::Retry).count(), 1);

    let mut w = no_faster(100_000);
    let job = w.create(delivery());
    w.complete(job);
    assert_eq!(failed_docks(&w), []);
}
