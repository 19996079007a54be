//! Every seed and every former finding passes its target, without libFuzzer.

use std::fs;
use std::path::Path;

use fuzz::choices::Choices;
use fuzz::{TARGETS, everywhere, grammar, targets};
use karel_emulator::{Controller, ControllerConfig, ProgramSource};

/// Covers: K6, K7.
#[test]
fn seeds_and_former_findings_pass() {
    for target in TARGETS {
        let seeds = (target.seeds)();
        assert!(!seeds.is_empty(), "{} has no seeds", target.name);
        for seed in seeds.iter().take(80) {
            (target.run)(seed);
        }
        let findings = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("findings")
            .join(target.name);
        let Ok(entries) = fs::read_dir(findings) else {
            continue;
        };
        for entry in entries {
            (target.run)(&fs::read(entry.unwrap().path()).unwrap());
        }
    }
}

#[test]
fn every_statement_of_the_grammar_is_correct_and_runs() {
    let mut number = 0;
    while let Some(source) = grammar::one_statement(number, &mut Choices::new(b"")) {
        targets::program::twice(&source, 7);
        number += 1;
    }
    assert!(number > 100, "{number} statements");
}

/// Programs that are drawn to see that the checker takes them.
const DRAWN: u64 = 6_000;
/// Bytes that each of them is drawn from.
const BYTES: usize = 600;

#[test]
fn drawn_programs_are_correct() {
    let config =
        targets::core::config().with_program(ProgramSource::new("helper.kl", grammar::HELPER));
    let mut state = 1;
    for _ in 0..DRAWN {
        let bytes: Vec<u8> = std::iter::repeat_with(|| draw(&mut state))
            .take(BYTES)
            .collect();
        let source = grammar::program(&mut Choices::new(&bytes));
        loads(&config, source);
    }
}

#[test]
fn each_template_is_correct_wherever_it_may_stand() {
    let config =
        targets::core::config().with_program(ProgramSource::new("helper.kl", grammar::HELPER));
    let programs = everywhere::programs();
    assert!(programs.len() > 50, "{} programs", programs.len());
    for source in programs {
        loads(&config, source);
    }
}

fn loads(config: &ControllerConfig, source: String) {
    let program = ProgramSource::new("fuzzed.kl", source);
    if let Err(refused) = Controller::try_new(&config.clone().with_program(program)) {
        panic!("{refused}");
    }
}

/// The next byte of a linear congruential generator (Knuth's MMIX constants); the high bits are the random ones.
fn draw(state: &mut u64) -> u8 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    state.to_be_bytes()[0]
}

#[test]
fn every_name_of_a_target_is_its_own() {
    for target in TARGETS {
        let same = TARGETS.iter().filter(|other| other.name == target.name);
        assert_eq!(same.count(), 1, "{}", target.name);
    }
}
