//! One target under libFuzzer: `FUZZ_TARGET` names it, the arguments are libFuzzer's. `cargo xtask fuzz` does it all.
//!
//! With `FUZZ_SEEDS=FOLDER` it only writes the seeds there and prints libFuzzer's flags for the target; without a target,
//! it prints their names.
#![no_main]

use std::path::Path;
use std::process::exit;
use std::sync::OnceLock;

static TARGET: OnceLock<fuzz::Target> = OnceLock::new();

libfuzzer_sys::fuzz_target!(
    init: prepare(),
    |data| {
        if let Some(target) = TARGET.get() {
            (target.run)(data);
        }
    }
);

#[expect(clippy::print_stdout, reason = "its output is what it was asked for")]
fn prepare() {
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    let Some(target) = fuzz::find(&name) else {
        for target in fuzz::TARGETS {
            println!("{}", target.name);
        }
        exit(i32::from(!name.is_empty()));
    };
    if let Ok(folder) = std::env::var("FUZZ_SEEDS") {
        match fuzz::seeds::write(target, Path::new(&folder)) {
            Ok(flags) => {
                println!("{}", flags.join("\n"));
                exit(0);
            }
            Err(error) => {
                println!("writing seeds into {folder}: {error}");
                exit(1);
            }
        }
    }
    let _first = TARGET.set(target);
}
