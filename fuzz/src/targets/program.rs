//! Drawn programs that are correct: they load, they run, and they run the same however time is cut and watched.

use karel_emulator::{Controller, ProgramSource};

use super::core::{check_bounds, config, ms, seen};
use crate::choices::Choices;
use crate::grammar;

/// Controller time that a program gets.
const MILLISECONDS: u64 = 400;

/// # Panics
/// If that finds something.
pub fn run(data: &[u8]) {
    let mut choices = Choices::new(data);
    let cut = 1 + u64::from(choices.byte());
    let source = grammar::program(&mut choices);
    twice(&source, cut);
}

/// Runs a program at once, and in pieces of `cut` milliseconds with its lines traced.
///
/// # Panics
/// If it is refused, goes beyond a bound, or the two differ: findings.
pub fn twice(source: &str, cut: u64) {
    let mut config = config()
        .with_program(ProgramSource::new("fuzzed.kl", source))
        .with_program(ProgramSource::new("helper.kl", grammar::HELPER));
    let mut whole = Controller::try_new(&config)
        .unwrap_or_else(|error| panic!("a correct program is refused: {error}\n{source}"));
    whole.advance_fully(ms(MILLISECONDS));
    check_bounds(&whole);
    config.trace = true;
    let mut pieces = Controller::try_new(&config).expect("it was loaded before");
    let mut now = 0;
    while now < MILLISECONDS {
        now = (now + cut).min(MILLISECONDS);
        pieces.advance_fully(ms(now));
    }
    let effects = whole.take_effects();
    assert_eq!(effects, pieces.take_effects(), "{source}");
    assert_eq!(seen(&mut whole), seen(&mut pieces), "{source}");
}
