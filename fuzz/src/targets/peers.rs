//! The shipped programs with peers, operators, faults and times in any order.
//!
//! Whatever happens, nothing panics and nothing grows; and the same events give the same state, however time is cut
//! between them.

use std::collections::BTreeSet;
use std::net::SocketAddr;

use karel_emulator::controller::Advance;
use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};
use karel_emulator::faults::{Direction, FaultBody, FaultKind, Memory, Scope};
use karel_emulator::ledger::PoseMmDeg;
use karel_emulator::{
    CmosMemory, Controller, ControllerConfig, ControllerOption, GripperConfig, OperatingMode,
    Operation, ProgramSource,
};
use kinematics::ArmModel;

use super::core::{check_bounds, check_effects, ms, seen};
use crate::choices::Choices;

const EIGHT_READS: &str = include_str!("../../../karel-emulator/tests/programs/eight_reads.kl");
const SOCK_SERVER: &str = include_str!("../../../programs/sock_server.kl");

/// What peers of the programs really send.
const LINES: &[&[u8]] = &[
    b"600000 200000 600000 -180000 30000 0 300 1",
    b"9000000 0 0 0 0 0 300 1",
    b"a b c d e f g h\n",
    b"S 1 15283\r\n",
    b"X 88\r\n",
    b"\r\n",
    b"1 2 3",
];

/// # Panics
/// If that finds something.
pub fn run(data: &[u8]) {
    let whole = outcome(data, 1_000_000);
    let pieces = outcome(data, 3);
    assert_eq!(whole, pieces, "time in pieces is the same time");
}

fn config(choices: &mut Choices<'_>) -> ControllerConfig {
    let model = ArmModel::builtin("fanuc-m20ia").expect("the arm is built in");
    let one = |text: &str| {
        ControllerConfig::new("fuzz", model).with_program(ProgramSource::new("server.kl", text))
    };
    let mut config = match choices.below(4) {
        0 => one(SOCK_SERVER),
        1 => ControllerConfig::cell_server("fuzz", model).with_gripper(GripperConfig::default()),
        2 => ControllerConfig::seed_status("fuzz", model),
        _ => one(EIGHT_READS),
    };
    config.limits.ledger_entries = 200;
    config.limits.alarms = 50;
    config.limits.instructions_per_ms = 500;
    config.seed = u64::from(choices.byte());
    config
}

/// What is seen at the end, and all effects on the way.
fn outcome(data: &[u8], piece: u64) -> String {
    let mut choices = Choices::new(data);
    let config = config(&mut choices);
    let mut core = Controller::try_new(&config).expect("what is shipped loads");
    let mut world = World::default();
    let mut now = 0;
    advance(&mut core, &mut now, 1, piece, &mut world);
    for _ in 0..60 {
        if choices.is_over() {
            break;
        }
        step(&mut core, &mut choices, &mut now, piece, &mut world);
        advance(&mut core, &mut now, 0, piece, &mut world);
    }
    let _mended = core.clear_faults();
    advance(&mut core, &mut now, 5_000, piece, &mut world);
    check_bounds(&core);
    format!("{}\n{:?}", seen(&mut core), world.effects)
}

#[derive(Default)]
struct World {
    accepting: BTreeSet<u8>,
    open: BTreeSet<u64>,
    /// Every connection there ever was.
    known: BTreeSet<u64>,
    next: u64,
    effects: Vec<String>,
}

fn advance(core: &mut Controller, now: &mut u64, by: u64, piece: u64, world: &mut World) {
    let until = *now + by;
    loop {
        *now = (*now + piece).min(until);
        // As the driver does it: effects leave at the moment at which they happen.
        while core.advance(ms(*now)) == Advance::Worked {
            take(core, world);
        }
        take(core, world);
        if *now >= until {
            return;
        }
    }
}

fn take(core: &mut Controller, world: &mut World) {
    let effects = core.take_effects();
    check_effects(&effects, &world.known);
    for effect in effects {
        match &effect {
            Effect::Accept { tag, .. } => {
                let _new = world.accepting.insert(tag.number());
            }
            Effect::StopAccepting { tag } | Effect::StopListening { tag } => {
                let _was = world.accepting.remove(&tag.number());
            }
            Effect::Reset { connection } | Effect::Close { connection } => {
                let _was = world.open.remove(&connection.0);
            }
            Effect::Connect { .. } | Effect::Keep { .. } | Effect::Send { .. } => {}
        }
        world.effects.push(format!("{effect:?}"));
    }
}

fn step(
    core: &mut Controller,
    choices: &mut Choices<'_>,
    now: &mut u64,
    piece: u64,
    world: &mut World,
) {
    match choices.below(12) {
        0 | 1 => connect(core, choices, world),
        2 => {
            let line = *choices.one_of(LINES);
            send(core, choices, world, line);
        }
        3 => {
            let bytes = choices.bytes(200);
            send(core, choices, world, bytes);
        }
        4 => {
            if let Some(connection) = any_open(choices, world) {
                core.event(Event::PeerClosed { connection });
            }
        }
        5 => {
            if let Some(connection) = any_open(choices, world) {
                let _was = world.open.remove(&connection.0);
                core.event(Event::PeerLost { connection });
            }
        }
        6 | 7 => {
            let by = [1, 9, 120, 700, 2_500, 30_000];
            let by = *choices.one_of(&by);
            advance(core, now, by, piece, world);
        }
        8 => {
            let _refused = core.inject(fault(choices)).map_err(|e| e.to_string());
        }
        9 => {
            let _mended = core.clear_faults();
        }
        10 => {
            let _refused = core.operate(operation(choices)).map_err(|e| e.to_string());
        }
        _ => match choices.below(4) {
            0 => core.abort_all(),
            1 => core.power_cycle(CmosMemory::Kept),
            2 => core.power_cycle(CmosMemory::Lost),
            _ => {
                let count = usize::from(choices.byte());
                if let Some(connection) = any_open(choices, world) {
                    core.event(Event::Sent { connection, count });
                }
            }
        },
    }
}

fn connect(core: &mut Controller, choices: &mut Choices<'_>, world: &mut World) {
    let tags: Vec<u8> = world.accepting.iter().copied().collect();
    if tags.is_empty() {
        return;
    }
    let number = *choices.one_of(&tags);
    let _accepted = world.accepting.remove(&number);
    world.next += 1;
    let _new = world.known.insert(world.next);
    let _new = world.open.insert(world.next);
    core.event(Event::Connected {
        tag: Tag::try_new(number).expect("it was accepting"),
        connection: ConnectionId(world.next),
        peer: SocketAddr::from(([127, 0, 0, 1], 4000)),
    });
}

fn any_open(choices: &mut Choices<'_>, world: &World) -> Option<ConnectionId> {
    let open: Vec<u64> = world.open.iter().copied().collect();
    (!open.is_empty()).then(|| ConnectionId(*choices.one_of(&open)))
}

fn send(core: &mut Controller, choices: &mut Choices<'_>, world: &World, bytes: &[u8]) {
    let Some(connection) = any_open(choices, world) else {
        return;
    };
    let room = core.room(connection).min(bytes.len());
    let bytes = bytes.get(..room).unwrap_or_default().to_vec();
    if !bytes.is_empty() {
        core.event(Event::Bytes {
            connection,
            bytes,
            request_id: None,
        });
    }
}

fn fault(choices: &mut Choices<'_>) -> FaultBody {
    let number = usize::from(choices.byte());
    let fault = match choices.below(17) {
        0 => FaultKind::Drop,
        1 => FaultKind::Delay {
            ms: number as u64,
            jitter_ms: u64::from(choices.byte()),
        },
        2 => FaultKind::Split {
            bytes: number % 8,
            gap_ms: u64::from(choices.byte()) % 20,
        },
        3 => FaultKind::Truncate { keep: number },
        4 => FaultKind::Corrupt { bytes: number % 4 },
        5 => FaultKind::Stall,
        6 => FaultKind::HalfOpen,
        7 => FaultKind::Reset,
        8 => FaultKind::Freeze,
        9 => FaultKind::WedgeTag {
            tag: format!("S{}", number % 10),
        },
        10 => FaultKind::PowerLoss {
            memory: Memory::Kept,
            off_ms: number as u64,
        },
        11 => FaultKind::PowerLoss {
            memory: Memory::Lost,
            off_ms: 0,
        },
        12 => FaultKind::ServoOff,
        13 => FaultKind::WrongToolFrame {
            tool: choices.below(2).eq(&0).then_some(1),
            frame: PoseMmDeg {
                x_mm: f64::from(choices.byte()),
                y_mm: 0.0,
                z_mm: 10.0,
                w_deg: 0.0,
                p_deg: 5.0,
                r_deg: 0.0,
            },
        },
        14 => FaultKind::OptionMissing {
            option: ControllerOption::R632,
        },
        15 => FaultKind::OptionMissing {
            option: ControllerOption::R648,
        },
        _ => FaultKind::SlowOverride {
            percent: i32::from(choices.byte()),
        },
    };
    let mut body = FaultBody::new(fault);
    if choices.below(2) == 1 {
        body = body.for_ms(u64::from(choices.short()));
    }
    if choices.below(3) == 1 {
        body = body.times(u32::from(choices.byte()));
    }
    if choices.below(3) == 1 {
        body = body.within(Scope {
            port: Some(59_002),
            tag: None,
            connection: None,
            direction: Direction::In,
        });
    }
    body
}

fn operation(choices: &mut Choices<'_>) -> Operation {
    let on = choices.below(2) == 1;
    match choices.below(11) {
        0 => Operation::SetMode(*choices.one_of(&[
            OperatingMode::Auto,
            OperatingMode::T1,
            OperatingMode::T2,
        ])),
        1 => Operation::SetPendant(on),
        2 => Operation::EmergencyStop(on),
        3 => Operation::Hold,
        4 => Operation::CycleStart,
        5 => Operation::Reset,
        6 => Operation::SetOverride(i32::from(choices.byte())),
        7 => Operation::SetServoPower(on),
        8 => Operation::SetSingleStep(on),
        9 => Operation::JamGripper(on),
        _ => Operation::LosePart,
    }
}
