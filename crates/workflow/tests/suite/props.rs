//! No sequence of inputs panics, breaks an invariant, or folds differently when it is replayed.

use super::world::{POINT, ZONE, delivery, fixed, integrator, pickup};
use proptest::prelude::*;
use uuid::Uuid;
use workflow::{
    Answer, ArmSeen, BasePose, Cell, Command, CountingIds, Detail, Fact, Input, JobState,
    MobileMode, MobileState, OpResult, Safety, Signal, SignalKind, SlotLoad,
};

const KINDS: [SignalKind; 12] = [
    SignalKind::MrAssigned,
    SignalKind::MrArrived,
    SignalKind::MrDocked,
    SignalKind::MrReady,
    SignalKind::MrClear,
    SignalKind::MrDelivered,
    SignalKind::LoadChanged,
    SignalKind::MrHeartbeat,
    SignalKind::MrFault,
    SignalKind::MrMode,
    SignalKind::MrRejected,
    SignalKind::MrDockFailed,
];

const COMMANDS: [Command; 10] = [
    Command::Hold,
    Command::Unhold,
    Command::Stop,
    Command::Abort,
    Command::RetryStep,
    Command::SkipStep,
    Command::CompleteManually,
    Command::Compensate,
    Command::Clear,
    Command::Reset,
];

/// An input out of numbers: mostly sensible, sometimes not.
fn input(cell: &Cell, now: u64, kind: u8, n: u64, seq: &mut u64) -> Input {
    let pick = |len: usize| usize::try_from(n).unwrap() % len.max(1);
    let jobs = cell.jobs(now);
    let job = jobs.get(pick(jobs.len()));
    let op = job.and_then(|j| j.steps.iter().find_map(|s| s.operation.clone()));
    match kind % 16 {
        0 => Input::CreateJob {
            job: Box::new(if n % 2 == 0 { delivery() } else { pickup() }),
        },
        1 => Input::JobCommand {
            job: job.map_or(Uuid::nil(), |j| j.id),
            command: COMMANDS[pick(COMMANDS.len())],
            principal: integrator(),
            reason: "because".into(),
        },
        2..=5 => {
            *seq += u64::from(n % 11 != 0) + u64::from(n % 13 == 0);
            let session = cell.sessions(now).last().map(|s| s.id);
            let order = cell.sessions(now).last().and_then(|s| s.order);
            let docked = n % 5 != 0;
            Input::Signal(Box::new(Signal {
                mobile_robot: "m1".into(),
                session: session.filter(|_| n % 3 != 0),
                boot: 1 + n / 1000,
                seq: *seq,
                kind: KINDS[pick(KINDS.len())],
                at_ms: None,
                resync: false,
                state: MobileState {
                    pose: BasePose {
                        x_mm: if docked { 1000.0 } else { 0.0 },
                        y_mm: 0.0,
                        heading_deg: 90.0,
                    },
                    driving: n % 7 == 0,
                    localized: n % 17 != 0,
                    battery_percent: 50.0,
                    mode: if n % 19 == 0 {
                        MobileMode::Manual
                    } else {
                        MobileMode::Automatic
                    },
                    loads: Some(vec![SlotLoad {
                        slot: "s1".into(),
                        load: Some("L1".into()),
                    }]),
                    order,
                    at_point: docked.then(|| POINT.into()),
                    errors: vec![],
                },
            }))
        }
        6..=9 => {
            let id = op.as_ref().map_or(Uuid::nil(), |o| o.op);
            let result = match (n % 9, op.map(|o| o.action)) {
                (0, _) => OpResult::InDoubt { text: "?".into() },
                (1, _) => OpResult::NotExecuted { text: "no".into() },
                (2, _) => OpResult::Interrupted { text: "cut".into() },
                (3, _) => OpResult::Rejected {
                    text: "alarm".into(),
                },
                (_, Some(workflow::Action::Grip { action })) => {
                    let close = action == workflow::GripAction::Close;
                    OpResult::Gripped {
                        closed: close,
                        open: !close,
                        part_present: close ^ (n % 10 == 0),
                    }
                }
                (_, Some(workflow::Action::Precheck { .. })) => {
                    OpResult::Prechecked { failures: vec![] }
                }
                (_, Some(workflow::Action::Move { .. }) | None) => OpResult::Arrived,
            };
            Input::OperationEnded { op: id, result }
        }
        10..=12 => Input::ArmObserved(ArmSeen {
            arm: if n % 4 == 0 { "r2" } else { "r1" }.into(),
            link: n % 23 != 0,
            ready: n % 29 != 0,
            still: n % 5 != 0,
            manual: n % 31 == 0,
            displaced: n % 37 == 0,
            safety: match n % 41 {
                0 => Safety::EmergencyStop,
                1 => Safety::ProtectiveStop,
                _ => Safety::Normal,
            },
            zones: if n % 6 == 0 {
                vec![ZONE.into()]
            } else {
                vec![]
            },
            part_present: None,
        }),
        13 => {
            let open = cell.interventions().into_iter().find(|i| i.open);
            let answer = open.as_ref().map_or(Answer::Resume, |i| {
                i.question.answers[pick(i.question.answers.len())]
            });
            let load = open
                .as_ref()
                .and_then(|i| i.question.load.clone())
                .unwrap_or_default();
            let location = fixed("bin");
            let detail = match answer {
                Answer::SetCustody => Detail::Custody {
                    load: load.clone(),
                    confirm: load,
                    location,
                },
                Answer::ChooseMobileRobot | Answer::SwapMobileRobot => Detail::MobileRobot {
                    mobile_robot: "m2".into(),
                },
                Answer::ChooseSlot => Detail::Place {
                    place: "rack/b".into(),
                },
                _ => Detail::None,
            };
            Input::Respond {
                intervention: open.map_or(Uuid::nil(), |i| i.question.id),
                answer,
                detail,
                principal: integrator(),
                reason: "looked".into(),
            }
        }
        14 => match n % 5 {
            0 => Input::Recover,
            1 => Input::Control {
                jobs_may_act: n % 2 == 0,
            },
            2 => Input::OutboxTaken {
                mobile_robot: "m1".into(),
                n: n % 50,
            },
            3 => Input::OperationPlanned {
                op: Uuid::nil(),
                expected_ms: n,
            },
            _ => Input::Control { jobs_may_act: true },
        },
        _ => Input::Tick,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn any_sequence_of_inputs_is_survived(script in prop::collection::vec((any::<u8>(), 0_u64..3000, 0_u64..4000), 1..150)) {
        let setup = super::world::setup();
        let mut cell = Cell::new(setup.clone());
        let mut ids = CountingIds::default();
        let (mut now, mut seq) = (0, 0);
        let mut kept: Vec<Fact> = vec![];
        let first = [Input::Recover, Input::Control { jobs_may_act: true }];
        let count = script.len();
        let mut inputs: Vec<Option<Input>> = first.into_iter().map(Some).collect();
        inputs.extend((0..count).map(|_| None));
        for (index, given) in inputs.into_iter().enumerate() {
            let (kind, n, wait) = script.get(index.wrapping_sub(2)).copied().unwrap_or((15, 0, 0));
            now += wait;
            let next = given.unwrap_or_else(|| input(&cell, now, kind, n, &mut seq));
            let before = cell.clone();
            let Ok(decision) = cell.decide(now, next.clone(), &mut ids) else {
                prop_assert!(cell == before, "a refusal changed something");
                continue;
            };
            prop_assert!(cell == before, "deciding changed something");
            for fact in &decision.facts {
                let _effects = cell.apply(now, fact);
            }
            kept.extend(decision.facts.into_iter().filter(Fact::is_durable));
            let broken = cell.violations();
            prop_assert!(broken.is_empty(), "{broken:?} after {next:?}");
        }
        let mut again = Cell::new(setup);
        for fact in &kept {
            again.replay(&serde_json::from_str(&serde_json::to_string(fact).unwrap()).unwrap());
        }
        prop_assert!(again.same_book(&cell), "replay differs");
        let kept = serde_json::to_string(&cell.snapshot()).unwrap();
        let kept = Cell::of_snapshot(serde_json::from_str(&kept).unwrap());
        prop_assert!(kept.same_book(&cell), "a snapshot differs");
        prop_assert!(again.jobs(now).iter().all(|j| j.state != JobState::Complete || j.claims.is_empty()));
    }
}
