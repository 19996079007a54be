//! Programs that signals start: RSR and PNS.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use common::arm;
use common::tp::{Core, listing};
use karel::{Number, Port, PortValue};
use karel_emulator::{ControllerConfig, Operation, ProgramSelection, RemoteStart};

/// Two programs that count in `R[1]` and `R[2]` and take a second, and one that belongs to nobody.
fn cell(selection: ProgramSelection, base: u16) -> Core {
    let prefix = match selection {
        ProgramSelection::Rsr => "RSR",
        ProgramSelection::Pns => "PNS",
    };
    let mut config = ControllerConfig::new("remote", arm());
    for number in [1, 2] {
        let name = format!("{prefix}{:04}", number + base);
        let count = format!("R[{number}]=R[{number}]+1");
        config = config.with_program(listing(&name, &[&count, "WAIT 1.00(sec)"], ""));
    }
    config.remote_start = Some(RemoteStart { selection, base });
    let mut core = Core::of(&config);
    for register in 1..=2 {
        core.0.set_item(&format!("R[{register}]"), "0").unwrap();
    }
    core
}

impl Core {
    fn signal(&mut self, number: u16, on: bool) {
        let value = PortValue::Switch(on);
        self.0.set_input(Port::UserIn, number, value).unwrap();
    }

    fn pulse(&mut self, number: u16) {
        self.signal(number, true);
        self.advance(0.1);
        self.signal(number, false);
        self.advance(0.01);
    }

    /// The outputs `UO` that are on.
    fn shown(&self) -> Vec<u16> {
        let ports = self.0.state().ports.into_iter();
        let users = ports.filter_map(|port| {
            let number = port.port.strip_prefix("UOUT[")?.strip_suffix(']')?;
            number.parse().ok()
        });
        users.collect()
    }

    fn counts(&self) -> [i32; 2] {
        [1, 2].map(|number| match self.0.registers().number(number) {
            Ok(Number::Integer(count)) => count,
            other => panic!("{other:?}"),
        })
    }
}

#[test]
fn assumed_a_service_request_is_acknowledged_and_starts_its_program_when_the_one_before_has_ended()
{
    let mut core = cell(ProgramSelection::Rsr, 0);
    core.advance(0.1);
    // Commands are enabled, the system is ready; nothing runs.
    assert_eq!(core.shown(), [1, 2]);
    core.pulse(9);
    core.pulse(10);
    core.pulse(10);
    // PROGRUN, BUSY, and both acknowledgements.
    assert_eq!(core.shown(), [1, 2, 3, 10, 11, 12]);
    assert_eq!(core.counts(), [1, 0], "the second one waits");
    core.advance(0.5);
    assert_eq!(core.shown(), [1, 2, 3, 10]);
    core.advance(0.5);
    assert_eq!(core.counts(), [1, 1]);
    core.advance(2.0);
    assert_eq!(
        core.counts(),
        [1, 1],
        "asked twice while it waited is asked once"
    );
    assert_eq!(core.shown(), [1, 2]);
}

#[test]
fn assumed_a_request_that_a_program_disabled_is_neither_acknowledged_nor_started() {
    let mut config = ControllerConfig::new("remote", arm());
    let lines = ["RSR[2]=DISABLE", "RSR[3]=DISABLE", "RSR[3]=ENABLE"];
    for (number, lines) in [(1, &lines[..]), (2, &["R[2]=1"]), (3, &["R[3]=1"])] {
        config = config.with_program(listing(&format!("RSR000{number}"), lines, ""));
    }
    config.remote_start = Some(RemoteStart {
        selection: ProgramSelection::Rsr,
        base: 0,
    });
    let mut core = Core::of(&config);
    core.advance(0.1);
    core.pulse(9);
    core.advance(1.0);
    core.pulse(10);
    assert_eq!(core.shown(), [1, 2], "ACK2 is off");
    core.pulse(11);
    core.advance(1.0);
    let [second, third] = [2, 3].map(|number| core.0.registers().number(number).unwrap());
    assert_eq!([second, third], [Number::Integer(0), Number::Integer(1)]);
}

#[test]
fn a_request_that_there_is_not_ends_the_program_that_names_it() {
    for number in [0, 9] {
        let line = format!("RSR[{number}]=ENABLE");
        let mut core = Core::moves(&[&line], "");
        core.advance(0.1);
        let alarm = core.last_alarm();
        let wanted = format!("There is no RSR[{number}]");
        assert!(
            alarm.starts_with("INTP-322") && alarm.contains(&wanted),
            "{alarm}"
        );
    }
}

#[test]
fn assumed_cstopi_forgets_what_waits_and_lets_the_program_that_runs_end() {
    let mut core = cell(ProgramSelection::Rsr, 0);
    core.pulse(9);
    core.pulse(10);
    core.pulse(4);
    core.advance(3.0);
    assert_eq!(core.counts(), [1, 0]);
}

#[test]
fn assumed_a_strobe_chooses_a_program_by_its_number_and_prod_start_starts_it() {
    let mut core = cell(ProgramSelection::Pns, 100);
    // Number 2, and the strobe.
    core.signal(10, true);
    core.signal(17, true);
    core.advance(0.05);
    // SNO2 and SNACK.
    assert_eq!(core.shown(), [1, 2, 12, 19]);
    core.signal(17, false);
    core.signal(10, false);
    core.advance(0.5);
    assert_eq!(core.shown(), [1, 2, 12], "the number stays");
    assert_eq!(core.counts(), [0, 0], "it is only chosen");
    core.signal(18, true);
    core.advance(0.1);
    assert_eq!(core.counts(), [0, 0], "the signal has to go off");
    core.signal(18, false);
    core.advance(0.1);
    assert_eq!(core.counts(), [0, 1]);
    // While it runs another one cannot be chosen.
    core.signal(9, true);
    core.pulse(17);
    assert_eq!(core.shown(), [1, 2, 3, 10, 12]);
    core.advance(2.0);
    core.pulse(18);
    assert_eq!(core.counts(), [0, 2]);
}

#[test]
fn a_program_that_is_not_there_is_an_alarm_and_a_fault_reset_ends_alarms() {
    let mut core = cell(ProgramSelection::Rsr, 0);
    core.pulse(16);
    let alarm = core.last_alarm();
    assert!(
        alarm.starts_with("MEMO-073") && alarm.contains("RSR0008"),
        "{alarm}"
    );
    core.advance(0.5);
    core.signal(1, false);
    core.advance(0.01);
    // The external emergency stop: not enabled, a fault; after the arm stood still the drives are off.
    assert_eq!(core.shown(), [6]);
    core.pulse(9);
    assert_eq!(core.counts(), [0, 0]);
    core.signal(1, true);
    core.pulse(5);
    assert_eq!(core.shown(), [1, 2]);
    core.pulse(9);
    assert_eq!(core.counts(), [1, 0]);
}

#[test]
fn hold_pauses_and_start_goes_on() {
    let mut core = cell(ProgramSelection::Rsr, 0);
    core.pulse(9);
    core.signal(2, false);
    core.advance(0.1);
    // PAUSED and HELD; commands are not enabled without the signal.
    assert_eq!(core.shown(), [2, 4, 5, 11]);
    core.signal(2, true);
    core.advance(0.5);
    assert_eq!(core.shown(), [1, 2, 4, 5]);
    core.pulse(6);
    assert_eq!(core.shown(), [1, 2, 3, 10]);
    core.advance(2.0);
    assert_eq!(core.shown(), [1, 2]);
}

#[test]
fn signals_start_nothing_while_the_pendant_is_enabled() {
    let mut core = cell(ProgramSelection::Rsr, 0);
    core.0.operate(Operation::SetPendant(true)).unwrap();
    core.pulse(9);
    core.advance(1.0);
    // SYSRDY and TPENBL.
    assert_eq!((core.shown(), core.counts()), (vec![2, 8], [0, 0]));
}

#[test]
fn without_the_choice_the_signals_are_inputs_as_others() {
    let mut config = ControllerConfig::new("plain", arm());
    config = config.with_program(listing("RSR0001", &["R[1]=R[1]+1"], ""));
    config.run = Vec::new();
    let mut core = Core::of(&config);
    core.finish();
    core.pulse(9);
    assert_eq!(core.shown(), [0_u16; 0]);
}
