//! Programs that the signals of a cell's controller start: RSR and PNS, with the signals around them.
//!
//! The signals are those of the user operator panel, `UI` and `UO` of TP programs, `UIN` and `UOUT` of KAREL.
//!
//! ASSUMPTION: numbers and meanings of the signals are those of the vendor's manuals as their readers quote them; `IMSTP`
//! acts as the external emergency stop, `SFSPD` and `ENBL` pause what runs, `CSTOPI` lets the program that runs go on and
//! forgets the requests that wait. The robot is at no perch, the battery is good.

use std::collections::VecDeque;
use std::time::Duration;

use karel::{Interruption, Port, PortValue, Status};

use super::Controller;
use crate::alarms::Severity;
use crate::hardware::operator::OperatingMode;
use crate::hardware::safety::StopSource;

/// How signals choose the program that they start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramSelection {
    /// Robot service request: a signal of its own for each of eight programs, `RSR0001` to `RSR0008`. What is asked for
    /// while a program runs is started when that has ended.
    Rsr,
    /// Program number select: eight signals are a number, `PNSTROBE` chooses `PNS0001` to `PNS0255`, and `PROD_START`
    /// starts it.
    Pns,
}

/// Programs are started by signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RemoteStart {
    /// How they choose.
    pub selection: ProgramSelection,
    /// Added to the number of the signals: with 100, RSR1 starts `RSR0101`.
    pub base: u16,
}

/// Numbers of the inputs.
mod input {
    pub(super) const IMSTP: u16 = 1;
    pub(super) const HOLD: u16 = 2;
    pub(super) const SFSPD: u16 = 3;
    pub(super) const CSTOPI: u16 = 4;
    pub(super) const FAULT_RESET: u16 = 5;
    pub(super) const START: u16 = 6;
    pub(super) const ENBL: u16 = 8;
    /// RSR1 to RSR8, PNS1 to PNS8.
    pub(super) const FIRST_REQUEST: u16 = 9;
    pub(super) const PNSTROBE: u16 = 17;
    pub(super) const PROD_START: u16 = 18;
    pub(super) const LAST: u16 = PROD_START;
}

/// Numbers of the outputs.
mod output {
    pub(super) const CMDENBL: u16 = 1;
    pub(super) const SYSRDY: u16 = 2;
    pub(super) const PROGRUN: u16 = 3;
    pub(super) const PAUSED: u16 = 4;
    pub(super) const HELD: u16 = 5;
    pub(super) const FAULT: u16 = 6;
    pub(super) const TPENBL: u16 = 8;
    pub(super) const BUSY: u16 = 10;
    /// ACK1 to ACK8, SNO1 to SNO8.
    pub(super) const FIRST_ANSWER: u16 = 11;
    pub(super) const SNACK: u16 = 19;
}

/// Requests, or bits of a number.
const REQUESTS: u16 = 8;

/// How long an acknowledgement is on.
///
/// ASSUMPTION: what controllers are delivered with.
const PULSE: Duration = Duration::from_millis(400);

/// What is known of the signals.
#[derive(Debug)]
pub(super) struct Remote {
    start: RemoteStart,
    /// The inputs as they were at the last look, the first in bit 0.
    before: u32,
    /// Requests that wait for the end of what runs.
    queue: VecDeque<u16>,
    /// `PNSTROBE` chose this number.
    chosen: u16,
    /// Until when the acknowledgements are on: eight, and `SNACK`.
    pulses: [Option<Duration>; 9],
}

impl Remote {
    pub(super) fn new(start: RemoteStart) -> Self {
        Self {
            start,
            before: AT_REST,
            queue: VecDeque::new(),
            chosen: 0,
            pulses: [None; 9],
        }
    }

    /// When the next acknowledgement ends.
    pub(super) fn next_due(&self) -> Option<Duration> {
        self.pulses.iter().flatten().min().copied()
    }

    /// Nothing is waited for any more.
    pub(super) fn forget(&mut self) {
        self.queue.clear();
        self.chosen = 0;
        self.pulses = [None; 9];
    }

    fn acknowledge(&mut self, index: u16, now: Duration) {
        if let Some(pulse) = self.pulses.get_mut(usize::from(index)) {
            *pulse = Some(now.saturating_add(PULSE));
        }
    }

    fn program(&self, number: u16) -> String {
        let prefix = match self.start.selection {
            ProgramSelection::Rsr => "RSR",
            ProgramSelection::Pns => "PNS",
        };
        format!("{prefix}{:04}", number.saturating_add(self.start.base))
    }
}

/// The signals that are closed while nobody touches them: `IMSTP`, `HOLD`, `SFSPD` and `ENBL`.
const AT_REST: u32 = bit(input::IMSTP) | bit(input::HOLD) | bit(input::SFSPD) | bit(input::ENBL);

const fn bit(number: u16) -> u32 {
    1 << (number - 1)
}

impl Controller {
    /// The signals that must be on are on, as if they were wired.
    pub(super) fn wire_remote(&mut self) {
        for number in 1..=input::LAST {
            if self.remote.is_some() && AT_REST & bit(number) != 0 {
                let on = PortValue::Switch(true);
                let _changed = self.hardware.ports.set(Port::UserIn, number.into(), on);
            }
        }
        self.follow_signals();
    }

    /// Does what the signals ask for, and shows what became of it.
    pub(super) fn follow_signals(&mut self) {
        if self.off_until.is_some() || self.faults.frozen {
            return;
        }
        let Some(mut remote) = self.remote.take() else {
            return;
        };
        let now = self.user_inputs();
        let rising = now & !remote.before;
        let falling = remote.before & !now;
        remote.before = now;
        if rising | falling != 0 {
            self.take_edges(&mut remote, now, rising, falling);
            self.follow_tasks();
            self.wake_tasks();
        }
        self.start_next(&mut remote);
        self.show_outputs(&mut remote, now);
        self.remote = Some(remote);
    }

    fn take_edges(&mut self, remote: &mut Remote, now: u32, rising: u32, falling: u32) {
        let on = |edges: u32, number: u16| edges & bit(number) != 0;
        for (edges, active) in [(falling, true), (rising, false)] {
            if on(edges, input::IMSTP) {
                self.safety_stop(StopSource::External, active);
            }
        }
        if on(falling, input::HOLD) {
            self.hardware.operator.hold = true;
            self.pause_tasks(Interruption::Command);
            self.hardware.hold_arm(true);
        }
        if on(falling, input::SFSPD) || on(falling, input::ENBL) {
            self.interrupt(Interruption::Command);
        }
        if on(rising, input::CSTOPI) {
            remote.queue.clear();
        }
        if on(rising, input::FAULT_RESET) {
            self.reset();
        }
        // What follows starts something.
        if !self.commands_enabled(now) {
            return;
        }
        if on(falling, input::START) {
            // What keeps the tasks from going on is an alarm, or seen at the outputs.
            let _refused = self.cycle_start();
        }
        let time = self.hardware.now;
        match remote.start.selection {
            ProgramSelection::Rsr => {
                let off = self.hardware.requests_off;
                for index in 0..REQUESTS {
                    let enabled = off >> index & 1 == 0;
                    if enabled && on(rising, input::FIRST_REQUEST + index) {
                        remote.acknowledge(index, time);
                        if !remote.queue.contains(&index) {
                            remote.queue.push_back(index);
                        }
                    }
                }
            }
            ProgramSelection::Pns if self.program_runs() => {}
            ProgramSelection::Pns => {
                if on(rising, input::PNSTROBE) {
                    let bits = now >> (input::FIRST_REQUEST - 1) & 0xff;
                    remote.chosen = u16::try_from(bits).unwrap_or(0);
                    remote.acknowledge(REQUESTS, time);
                }
                if on(falling, input::PROD_START) && remote.chosen != 0 {
                    let name = remote.program(remote.chosen);
                    self.start_by_signal(&name);
                }
            }
        }
    }

    /// The next request, if nothing runs.
    fn start_next(&mut self, remote: &mut Remote) {
        if !remote.queue.is_empty()
            && !self.program_runs()
            && self.commands_enabled(remote.before)
            && let Some(index) = remote.queue.pop_front()
        {
            let name = remote.program(index + 1);
            self.start_by_signal(&name);
        }
    }

    fn start_by_signal(&mut self, name: &str) {
        match self.start_task(name) {
            Ok(_task) => self.follow_tasks(),
            Err(error) => {
                let text = format!("The signals ask for {name}: {error}");
                self.hardware
                    .post(Status::MEMO_NO_PROGRAM, text, Severity::Warn);
            }
        }
    }

    /// A program that can move the arm runs or is paused; a server in the background is none.
    fn program_runs(&self) -> bool {
        self.moving_tasks().next().is_some()
    }

    fn moving_tasks(&self) -> impl Iterator<Item = karel::TaskId> + '_ {
        let alive = self.machine.tasks().filter(|id| self.machine.is_alive(*id));
        alive.filter(|id| {
            let program = self.machine.root_program(*id);
            program.is_some_and(karel::Program::locks_group)
        })
    }

    /// `CMDENBL`: signals may start something.
    fn commands_enabled(&self, inputs: u32) -> bool {
        let operator = &self.hardware.operator;
        inputs & AT_REST == AT_REST
            && operator.mode == OperatingMode::Auto
            && !operator.pendant
            && self.hardware.drives_powered()
            && self.hardware.alarms.active() == 0
    }

    fn user_inputs(&self) -> u32 {
        let on = |number: &u16| {
            let port = self.hardware.ports.get(Port::UserIn, i32::from(*number));
            port == Ok(PortValue::Switch(true))
        };
        (1..=input::LAST).filter(on).map(bit).sum()
    }

    fn show_outputs(&mut self, remote: &mut Remote, inputs: u32) {
        let now = self.hardware.now;
        for pulse in &mut remote.pulses {
            *pulse = pulse.filter(|end| *end > now);
        }
        let paused = |id: &karel::TaskId| self.machine.is_paused(*id);
        let (any_paused, any_runs) = (
            self.moving_tasks().any(|id| paused(&id)),
            self.moving_tasks().any(|id| !paused(&id)),
        );
        let operator = &self.hardware.operator;
        let mut shown = vec![
            (output::CMDENBL, self.commands_enabled(inputs)),
            (output::SYSRDY, self.hardware.drives_powered()),
            (output::PROGRUN, any_runs),
            (output::PAUSED, any_paused),
            (output::HELD, operator.hold),
            (output::FAULT, self.hardware.alarms.active() > 0),
            (output::TPENBL, operator.pendant),
            (output::BUSY, any_runs),
        ];
        let (answers, snack) = match remote.start.selection {
            ProgramSelection::Rsr => {
                let mut pulses = remote.pulses.iter().zip(0..REQUESTS);
                let on =
                    |(pulse, index): (&Option<Duration>, u16)| u16::from(pulse.is_some()) << index;
                (pulses.by_ref().map(on).sum(), false)
            }
            ProgramSelection::Pns => (remote.chosen, matches!(remote.pulses, [.., Some(_)])),
        };
        shown.push((output::SNACK, snack));
        for index in 0..REQUESTS {
            shown.push((output::FIRST_ANSWER + index, answers >> index & 1 == 1));
        }
        for (number, on) in shown {
            let value = PortValue::Switch(on);
            let _changed = self.hardware.ports.set(Port::UserOut, number.into(), value);
        }
    }
}
