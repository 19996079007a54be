//! `mobile-emulator check`: what is wrong with configuration files.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context as _;

use crate::file::load;

/// Check configuration files without running a robot.
///
/// The exit code is 0 if all of them make a robot, 1 if one does not.
#[derive(Debug, clap::Args)]
pub(crate) struct Check {
    /// Configuration files.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Check {
    pub(crate) fn run(&self) -> ExitCode {
        let mut wrong = 0_usize;
        for path in &self.files {
            let checked = load(path).and_then(|config| {
                config
                    .check()
                    .with_context(|| format!("in {}", path.display()))
            });
            if let Err(error) = checked {
                wrong += 1;
                eprintln!("{error:#}");
            }
        }
        if wrong == 0 {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(1)
        }
    }
}
