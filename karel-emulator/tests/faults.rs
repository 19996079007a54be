//! Injected faults do what they say, where they say it, for as long as they say it.

#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::too_many_lines,
    reason = "a helper that fails stops its test, and what is drawn is small"
)]

mod common;

use std::io::ErrorKind;
use std::time::Duration;

use common::{ACCEPTED, LINE, PORT, Stepped, call, config_of, read_to_end, sock_server, within};
use karel::{Port, PortValue};
use karel_emulator::controller::{PortSet, ValueBody};
use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};
use karel_emulator::faults::{ControllerOption, Direction, Memory, Scope};
use karel_emulator::ledger::PoseMmDeg;
use karel_emulator::state::TaskWord;
use karel_emulator::{Controller, FaultBody, FaultError, FaultKind};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

fn inward() -> Scope {
    Scope {
        port: Some(PORT),
        direction: Direction::In,
        ..Scope::default()
    }
}

async fn inject(cell: &Stepped, fault: FaultBody) -> u64 {
    cell.controller.inject(fault).await.unwrap()
}

async fn active(cell: &Stepped) -> usize {
    cell.controller.state().await.unwrap().faults
}

/// Connects, sends the line of the examples, and hands the connection back; the controller's time stands still.
async fn send(cell: &Stepped) -> TcpStream {
    let mut stream = within(TcpStream::connect(cell.address().await))
        .await
        .unwrap();
    stream.write_all(LINE).await.unwrap();
    cell.advance(0.01).await;
    stream
}

#[tokio::test]
async fn a_delay_holds_the_command_for_its_time_and_the_next_one_not_at_all() {
    let cell = Stepped::start(&sock_server());
    let delay = FaultKind::Delay {
        ms: 500,
        jitter_ms: 0,
    };
    let _id = inject(&cell, FaultBody::new(delay).within(inward()).times(1)).await;
    let mut stream = send(&cell).await;
    cell.advance(0.4).await;
    assert_eq!(cell.controller.ledger().await.unwrap().len(), 0, "not yet");
    cell.advance(0.2).await;
    assert_eq!(read_to_end(&mut stream).await, ACCEPTED);
    assert_eq!(
        active(&cell).await,
        0,
        "it has struck as often as it should"
    );
    cell.until_standstill().await;
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
}

#[tokio::test]
async fn a_command_in_pieces_of_one_byte_is_the_same_command() {
    let cell = Stepped::start(&sock_server());
    let split = FaultKind::Split {
        bytes: 1,
        gap_ms: 2,
    };
    let _id = inject(&cell, FaultBody::new(split).within(inward())).await;
    let mut stream = send(&cell).await;
    cell.advance(1.0).await;
    assert_eq!(read_to_end(&mut stream).await, ACCEPTED);
    let ledger = cell.controller.ledger().await.unwrap();
    assert!((ledger[0].target_pose.x_mm - 600.0).abs() < 1e-3);
}

#[tokio::test]
async fn lost_and_truncated_bytes_leave_the_program_waiting_as_on_the_real_one() {
    for fault in [FaultKind::Drop, FaultKind::Truncate { keep: 10 }] {
        let cell = Stepped::start(&sock_server());
        let _id = inject(&cell, FaultBody::new(fault).within(inward()).times(1)).await;
        let _stream = send(&cell).await;
        cell.advance(20.0).await;
        let state = cell.controller.state().await.unwrap();
        assert_eq!(state.tasks[0].detail.as_deref(), Some("waits for bytes"));
        assert_eq!(state.ledger_seq, 0);
    }
}

#[tokio::test]
async fn the_same_seed_corrupts_the_same_bytes() {
    let run = async |seed| {
        let mut config = sock_server();
        config.seed = seed;
        let outward = Scope {
            direction: Direction::Out,
            ..Scope::default()
        };
        let corrupt = FaultKind::Corrupt { bytes: 3 };
        config.faults = vec![FaultBody::new(corrupt).within(outward)];
        let cell = Stepped::start(&config);
        let mut stream = send(&cell).await;
        let mut reply = Vec::new();
        let _count = within(stream.read_to_end(&mut reply)).await.unwrap();
        reply
    };
    let first = run(1).await;
    let differ = first
        .iter()
        .zip(ACCEPTED.as_bytes())
        .filter(|(a, b)| a != b);
    assert_eq!((first.len(), differ.count()), (ACCEPTED.len(), 3));
    assert_eq!(run(1).await, first);
    assert_ne!(run(2).await, first);
}

#[tokio::test]
async fn a_stall_holds_both_ways_and_lets_everything_go_when_it_is_cleared() {
    let cell = Stepped::start(&sock_server());
    let id = inject(&cell, FaultBody::new(FaultKind::Stall)).await;
    let mut stream = send(&cell).await;
    cell.advance(5.0).await;
    assert_eq!(cell.controller.state().await.unwrap().ledger_seq, 0);
    cell.controller
        .with(move |core| core.clear_fault(id))
        .await
        .unwrap()
        .unwrap();
    cell.advance(0.1).await;
    assert_eq!(read_to_end(&mut stream).await, ACCEPTED);
    let again = cell
        .controller
        .with(move |core| core.clear_fault(id))
        .await
        .unwrap();
    assert_eq!(again, Err(FaultError::NoSuchFault { id }));
}

#[tokio::test]
async fn a_half_open_peer_holds_the_tag_although_it_has_gone() {
    let cell = Stepped::start(&sock_server());
    let _id = inject(&cell, FaultBody::new(FaultKind::HalfOpen).for_ms(10_000)).await;
    drop(send(&cell).await);
    cell.advance(9.0).await;
    let state = cell.controller.state().await.unwrap();
    assert_eq!(
        state.tags[0].state, "connected",
        "nobody told the controller"
    );
    assert_eq!(state.ledger_seq, 0);
}

#[tokio::test]
async fn a_reset_is_seen_by_both_sides() {
    let cell = Stepped::start(&sock_server());
    let mut stream = within(TcpStream::connect(cell.address().await))
        .await
        .unwrap();
    stream.write_all(b"600000 ").await.unwrap();
    cell.advance(0.1).await;
    let _id = inject(&cell, FaultBody::new(FaultKind::Reset)).await;
    let mut byte = [0];
    let read = within(stream.read(&mut byte)).await;
    assert_eq!(read.unwrap_err().kind(), ErrorKind::ConnectionReset);
    cell.advance(1.0).await;
    assert_eq!(
        call(cell.address().await, LINE).await,
        ACCEPTED,
        "the next client is served"
    );
}

#[tokio::test]
async fn a_frozen_controller_runs_nothing_and_moves_nothing_until_it_thaws() {
    let cell = Stepped::start(&sock_server());
    let _reply = call(cell.address().await, LINE).await;
    cell.advance(0.3).await;
    let _id = inject(&cell, FaultBody::new(FaultKind::Freeze).for_ms(60_000)).await;
    cell.advance(5.0).await;
    let state = cell.controller.state().await.unwrap();
    assert!(state.held && !state.moving, "{state:?}");
    let mut stream = send(&cell).await;
    cell.advance(5.0).await;
    assert_eq!(
        cell.controller.state().await.unwrap().tags[0].state,
        "connected"
    );
    cell.advance(60.0).await;
    assert_eq!(read_to_end(&mut stream).await, ACCEPTED);
    cell.until_standstill().await;
    assert_eq!(active(&cell).await, 0);
}

#[tokio::test]
async fn a_wedged_tag_serves_nobody_until_the_power_is_cycled() {
    let cell = Stepped::start(&sock_server());
    let fault = || {
        FaultBody::new(FaultKind::WedgeTag {
            tag: "S3".to_owned(),
        })
    };
    let id = inject(&cell, fault()).await;
    let again = cell.controller.inject(fault()).await;
    let fault = "wedge_tag";
    assert_eq!(again, Err(FaultError::Active { fault, id }));
    let mut stream = send(&cell).await;
    cell.advance(30.0).await;
    assert_eq!(
        cell.controller.state().await.unwrap().ledger_seq,
        0,
        "it connects, and that is all"
    );
    cell.controller
        .power_cycle(karel_emulator::CmosMemory::Kept)
        .await
        .unwrap();
    cell.advance(1.0).await;
    assert_eq!(active(&cell).await, 0);
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
    // The kernel let the first client in before the reboot, and drops it with the port.
    let mut rest = Vec::new();
    let _ended = within(stream.read_to_end(&mut rest)).await;
    assert!(rest.is_empty());
}

#[tokio::test]
async fn without_the_battery_registers_are_lost_and_with_it_they_are_kept() {
    let cell = Stepped::start(&sock_server());
    let set = || {
        cell.controller
            .with(|core| core.set_register("R[5]", Some(&ValueBody::Integer(7))))
    };
    let get = || cell.controller.with(|core| core.register("R[5]").unwrap());
    for (memory, left) in [(Memory::Kept, 7), (Memory::Lost, 0)] {
        set().await.unwrap().unwrap();
        let off_ms = 2_000;
        let _id = inject(
            &cell,
            FaultBody::new(FaultKind::PowerLoss { memory, off_ms }),
        )
        .await;
        let state = cell.controller.state().await.unwrap();
        assert!(!state.power_on && state.tasks.is_empty());
        let started = cell
            .controller
            .with(|core| core.run_program("sock_server"))
            .await
            .unwrap();
        assert!(started.unwrap_err().to_string().contains("power is off"));
        cell.advance(2.5).await;
        let state = cell.controller.state().await.unwrap();
        assert!(state.power_on && state.tasks.len() == 1);
        assert_eq!(get().await.unwrap(), Some(ValueBody::Integer(left)));
    }
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
}

#[tokio::test]
async fn without_servo_power_no_motion_starts_until_it_is_back_and_reset() {
    let cell = Stepped::start(&sock_server());
    let _reply = call(cell.address().await, LINE).await;
    cell.advance(0.3).await;
    let _id = inject(&cell, FaultBody::new(FaultKind::ServoOff).for_ms(5_000)).await;
    cell.advance(2.0).await;
    let state = cell.controller.state().await.unwrap();
    assert!(!state.servo_power && state.held && !state.moving);
    cell.controller.reset().await.unwrap();
    assert!(
        cell.controller.cycle_start().await.is_err(),
        "still without power"
    );
    cell.advance(4.0).await;
    cell.controller.reset().await.unwrap();
    cell.controller.cycle_start().await.unwrap();
    cell.until_standstill().await;
    let state = cell.controller.state().await.unwrap();
    assert!((state.pose.x_mm - 600.0).abs() < 1e-2, "{:?}", state.pose);
}

#[tokio::test]
async fn a_wrong_tool_frame_moves_the_flange_elsewhere_and_is_mended() {
    let program = "PROGRAM here\nBEGIN\n  DELAY 1000000\nEND here\n";
    let cell = Stepped::start(&config_of(program, &[]));
    let before = cell.controller.state().await.unwrap().pose;
    let frame = PoseMmDeg {
        z_mm: 100.0,
        ..PoseMmDeg::default()
    };
    let fault = FaultBody::new(FaultKind::WrongToolFrame { tool: None, frame }).for_ms(1_000);
    let _id = inject(&cell, fault).await;
    let tool = cell
        .controller
        .with(|core| core.variable("$MNUTOOL[1,1].z"))
        .await
        .unwrap();
    assert_eq!(tool, Ok(Some(ValueBody::Real(100.0))));
    let pose = cell.controller.state().await.unwrap().pose;
    let moved = (pose.x_mm - before.x_mm)
        .hypot(pose.y_mm - before.y_mm)
        .hypot(pose.z_mm - before.z_mm);
    assert!((moved - 100.0).abs() < 1e-3, "{moved}");
    cell.advance(1.5).await;
    assert_eq!(cell.controller.state().await.unwrap().pose, before);
}

#[tokio::test]
async fn a_held_override_makes_motions_slow_whatever_the_program_says() {
    let cell = Stepped::start(&sock_server());
    let id = inject(
        &cell,
        FaultBody::new(FaultKind::SlowOverride { percent: 5 }),
    )
    .await;
    let _reply = call(cell.address().await, LINE).await;
    cell.advance(0.1).await;
    assert_eq!(cell.controller.state().await.unwrap().override_percent, 5);
    cell.controller
        .with(move |core| core.clear_fault(id))
        .await
        .unwrap()
        .unwrap();
    assert_eq!(
        cell.controller.state().await.unwrap().override_percent,
        25,
        "the program's own"
    );
}

/// INTP-320 is what users without the option report.
#[tokio::test]
async fn without_r648_a_program_that_needs_sockets_ends_with_intp_320() {
    let mut config = sock_server();
    config.missing_options = [ControllerOption::R648].into();
    let cell = Stepped::start(&config);
    cell.advance(1.0).await;
    assert_eq!(cell.task_word().await, TaskWord::Aborted);
    let alarms = cell.controller.alarms().await.unwrap();
    let alarm = alarms
        .iter()
        .find(|alarm| alarm.facility == "INTP")
        .unwrap();
    assert_eq!(alarm.number, 320);
    assert!(
        alarm.text.contains("MSG_CONNECT") && alarm.text.contains("R648"),
        "{}",
        alarm.text
    );
    assert!(alarm.line.is_some());
}

#[tokio::test]
async fn without_r632_no_karel_program_starts_until_the_option_is_there() {
    let cell = Stepped::start(&sock_server());
    let option = ControllerOption::R632;
    let id = inject(&cell, FaultBody::new(FaultKind::OptionMissing { option })).await;
    cell.advance(1.0).await;
    let state = cell.controller.state().await.unwrap();
    assert!(state.tasks.is_empty());
    let started = cell
        .controller
        .with(|core| core.run_program("SOCK_SERVER"))
        .await
        .unwrap();
    assert!(started.unwrap_err().to_string().contains("R632"));
    cell.controller
        .with(move |core| core.clear_fault(id))
        .await
        .unwrap()
        .unwrap();
    cell.advance(1.0).await;
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
}

#[tokio::test]
async fn faults_are_bounded_and_what_is_wrong_is_named() {
    let cell = Stepped::start(&sock_server());
    for _ in 0..karel_emulator::faults::MAX_FAULTS {
        let _id = inject(
            &cell,
            FaultBody::new(FaultKind::Drop).within(Scope {
                connection: Some(9_999),
                ..Scope::default()
            }),
        )
        .await;
    }
    let one_more = cell
        .controller
        .inject(FaultBody::new(FaultKind::Drop))
        .await;
    assert_eq!(one_more, Err(FaultError::TooMany));
    let cleared = cell
        .controller
        .with(Controller::clear_faults)
        .await
        .unwrap();
    assert_eq!((cleared, active(&cell).await), (64, 0));
    assert_eq!(call(cell.address().await, LINE).await, ACCEPTED);
}

#[tokio::test]
async fn a_simulated_input_hides_the_world() {
    let program = "PROGRAM look\nBEGIN\n  WAIT FOR DIN[3] = ON\nEND look\n";
    let cell = Stepped::start(&config_of(program, &[]));
    let set = |set| cell.controller.with(move |core| core.set_io("DIN[3]", set));
    set(PortSet::Simulate(0)).await.unwrap().unwrap();
    cell.controller
        .set_input(Port::DigitalIn, 3, PortValue::Switch(true))
        .await
        .unwrap();
    cell.advance(1.0).await;
    assert_eq!(
        cell.task_word().await,
        TaskWord::Waiting,
        "it sees the simulated one"
    );
    set(PortSet::EndSimulation).await.unwrap().unwrap();
    cell.advance(1.0).await;
    assert_eq!(cell.task_word().await, TaskWord::Ended);
}

/// Faults of every kind in any order, while clients come, send and go: nothing panics, nothing runs for ever, and when
/// all is mended and switched off and on, the next client is served.
#[test]
fn whatever_is_broken_in_whatever_order_can_be_mended() {
    for seed in 0..60_u64 {
        let mut config = sock_server();
        config.seed = seed;
        let mut core = Controller::try_new(&config).unwrap();
        let mut number = seed;
        let mut draw = |below: u64| {
            number = number
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (number >> 33) % below
        };
        let mut clients = 0;
        let mut accepting = false;
        for _ in 0..60 {
            let for_ms = Some(draw(3_000) + 1).filter(|_| draw(2) == 0);
            let kind = match draw(16) {
                0 => FaultKind::Drop,
                1 => FaultKind::Delay {
                    ms: draw(900),
                    jitter_ms: draw(300),
                },
                2 => FaultKind::Split {
                    bytes: 1 + draw(9) as usize,
                    gap_ms: draw(30),
                },
                3 => FaultKind::Truncate {
                    keep: draw(30) as usize,
                },
                4 => FaultKind::Corrupt {
                    bytes: 1 + draw(9) as usize,
                },
                5 => FaultKind::Stall,
                6 => FaultKind::HalfOpen,
                7 => FaultKind::Reset,
                8 => FaultKind::Freeze,
                9 => FaultKind::WedgeTag {
                    tag: "S3".to_owned(),
                },
                10 => FaultKind::PowerLoss {
                    memory: Memory::Lost,
                    off_ms: draw(2_000),
                },
                11 => FaultKind::ServoOff,
                12 => FaultKind::WrongToolFrame {
                    tool: None,
                    frame: PoseMmDeg::default(),
                },
                13 => FaultKind::OptionMissing {
                    option: ControllerOption::R648,
                },
                14 => FaultKind::SlowOverride {
                    percent: 1 + draw(100) as i32,
                },
                _ => {
                    let _count = core.clear_faults();
                    continue;
                }
            };
            let mut body = FaultBody::new(kind);
            body.for_ms = for_ms;
            // Some cannot be, twice or with an end of their own: that is said and changes nothing.
            let _refused = core.inject(body).is_err();
            for effect in core.take_effects() {
                match effect {
                    Effect::Accept { .. } => accepting = true,
                    Effect::StopAccepting { .. } | Effect::StopListening { .. } => {
                        accepting = false;
                    }
                    Effect::Connect { .. }
                    | Effect::Keep { .. }
                    | Effect::Send { .. }
                    | Effect::Close { .. }
                    | Effect::Reset { .. } => {}
                }
            }
            if accepting {
                clients += 1;
                accepting = false;
                let connection = ConnectionId(clients);
                let tag = Tag::try_new(3).unwrap();
                let peer = ([127, 0, 0, 1], 40_000).into();
                core.event(Event::Connected {
                    tag,
                    connection,
                    peer,
                });
            }
            if clients > 0 {
                let connection = ConnectionId(clients);
                core.event(match draw(4) {
                    0 => Event::PeerClosed { connection },
                    1 => Event::PeerLost { connection },
                    _ => Event::Bytes {
                        connection,
                        bytes: LINE.to_vec(),
                        request_id: None,
                    },
                });
            }
            let until = core.now() + Duration::from_millis(draw(700));
            core.advance_fully(until);
        }
        let _count = core.clear_faults();
        core.power_cycle(karel_emulator::CmosMemory::Lost);
        core.reset();
        let until = core.now() + Duration::from_secs(1);
        core.advance_fully(until);
        let effects = core.take_effects();
        assert!(
            effects
                .iter()
                .any(|effect| matches!(effect, Effect::Accept { .. })),
            "seed {seed}: {effects:?}"
        );
        let (connection, tag) = (ConnectionId(clients + 1), Tag::try_new(3).unwrap());
        let peer = ([127, 0, 0, 1], 40_000).into();
        core.event(Event::Connected {
            tag,
            connection,
            peer,
        });
        core.advance_fully(until);
        core.event(Event::Bytes {
            connection,
            bytes: LINE.to_vec(),
            request_id: None,
        });
        core.advance_fully(until);
        let sent = core.take_effects().into_iter().any(
            |effect| matches!(effect, Effect::Send { bytes, .. } if bytes == ACCEPTED.as_bytes()),
        );
        assert!(sent, "seed {seed}: the next client is served");
        assert!(core.faults().is_empty());
    }
}
