//! What comes from outside, put to the test by libFuzzer: sources, listings, bytes of peers, requests, files.
//!
//! Each [target](TARGETS) takes bytes and panics where a promise is broken; a panic, a hang and too much memory are
//! findings. `cargo xtask fuzz` runs them all with coverage guidance on a stable compiler; the tests of this crate
//! run every seed and every former finding (`fuzz/findings/TARGET/`) through its target without libFuzzer.

pub mod choices;
pub mod everywhere;
pub mod grammar;
pub mod seeds;
pub mod targets;
pub mod words;

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name on the command line.
    pub name: &'static str,
    /// Takes one input; panics if that finds something.
    pub run: fn(&[u8]),
    /// Inputs to begin with.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// The longest input that is tried.
    pub longest: usize,
    /// Words that inputs are made of.
    pub words: &'static [&'static str],
}

/// All targets.
pub const TARGETS: &[Target] = &[
    Target {
        name: "karel_source",
        run: targets::source::karel,
        seeds: seeds::karel,
        longest: 4096,
        words: words::KAREL,
    },
    Target {
        name: "tp_source",
        run: targets::source::listing,
        seeds: seeds::listings,
        longest: 4096,
        words: words::LISTING,
    },
    Target {
        name: "karel_program",
        run: targets::program::run,
        seeds: seeds::choices,
        longest: 1024,
        words: &[],
    },
    Target {
        name: "reading",
        run: targets::reading::run,
        seeds: seeds::readings,
        longest: 1024,
        words: words::DATA,
    },
    Target {
        name: "peers",
        run: targets::peers::run,
        seeds: seeds::peers,
        longest: 2048,
        words: &[],
    },
    Target {
        name: "control",
        run: targets::control::run,
        seeds: seeds::requests,
        longest: 4096,
        words: words::REQUESTS,
    },
    Target {
        name: "files",
        run: targets::files::run,
        seeds: seeds::files,
        longest: 4096,
        words: words::ARM,
    },
    Target {
        name: "wire",
        run: targets::wire::run,
        seeds: seeds::wire,
        longest: 2048,
        words: words::WIRE,
    },
];

/// The target of this name.
#[must_use]
pub fn find(name: &str) -> Option<Target> {
    TARGETS.iter().copied().find(|target| target.name == name)
}
