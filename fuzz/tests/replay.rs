//! Every seed and every former finding passes its target, without libFuzzer.

use std::fs;
use std::path::Path;

use fuzz::choices::Choices;
use fuzz::{TARGETS, grammar, targets};

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

#[test]
fn every_name_of_a_target_is_its_own() {
    for target in TARGETS {
        let same = TARGETS.iter().filter(|other| other.name == target.name);
        assert_eq!(same.count(), 1, "{}", target.name);
    }
}
