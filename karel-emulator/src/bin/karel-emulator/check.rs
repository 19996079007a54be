//! `karel-emulator check`: what is wrong with KAREL programs.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use karel::Program;

use crate::includes::Folder;

/// Check KAREL programs and TP listings (`.ls`) without running them.
///
/// Every error and warning is printed with its source line. The exit code is 0 if there is no error, 1 if there is
/// one, 2 if a file cannot be read.
#[derive(Debug, clap::Args)]
pub(crate) struct Check {
    /// KAREL sources, or listings of TP programs.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Check {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let mut errors = 0_usize;
        for path in &self.files {
            let text =
                std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
            match Program::from_file(&text, &path.display().to_string(), &Folder::of(path)) {
                Ok(program) => {
                    for warning in program.warnings() {
                        eprintln!("{warning}");
                    }
                }
                Err(diagnostics) => {
                    errors += diagnostics.len();
                    for diagnostic in diagnostics {
                        eprintln!("{diagnostic}");
                    }
                }
            }
        }
        Ok(if errors == 0 {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(1)
        })
    }
}
