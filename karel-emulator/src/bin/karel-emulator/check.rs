//! `karel-emulator check`: what is wrong with KAREL programs.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Context;
use karel::{Diagnostic, Limits, Machine, Program, Severity};
use karel_emulator::ControllerGeneration;
use serde::Serialize;

use crate::http::put;
use crate::includes::Folder;
use crate::run::GenerationWord;

/// Check KAREL programs and TP listings (`.ls`) without running them.
///
/// Every error and warning of every file is printed with its source line and a caret, and how many there are at the end. The exit code is 0 if there is no
/// error, 1 if there is one, 2 if a file cannot be read.
#[derive(Debug, clap::Args)]
pub(crate) struct Check {
    /// KAREL sources, or listings of TP programs.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Look for `%INCLUDE` files in this folder, too; can be given several times.
    #[arg(long = "include", value_name = "FOLDER")]
    includes: Vec<PathBuf>,
    /// Also check that the programs fit together: no name twice, and routines and variables FROM another program as
    /// that program has them.
    #[arg(long)]
    together: bool,
    /// The generation of the controller that they are for: `v9` has no MOVE, `v7` has strings of 128 and names of 12
    /// characters.
    #[arg(long, value_enum, default_value_t = GenerationWord::Any)]
    generation: GenerationWord,
    /// Print one JSON document on the standard output instead.
    #[arg(long)]
    json: bool,
}

/// What was found, for machines.
#[derive(Debug, Default, Serialize)]
struct Findings {
    errors: usize,
    warnings: usize,
    files: Vec<Checked>,
    diagnostics: Vec<Finding>,
}

#[derive(Debug, Serialize)]
struct Checked {
    file: String,
    /// The name after PROGRAM, if there is no error.
    program: Option<String>,
}

#[derive(Debug, Serialize)]
struct Finding {
    severity: &'static str,
    message: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    help: Option<String>,
    file: String,
    /// From 1; `null` if it is about the whole file.
    line: Option<u32>,
    /// From 1, in bytes.
    column: Option<u32>,
    /// How many columns it is about.
    length: Option<usize>,
    source_line: Option<String>,
}

impl Findings {
    /// `2 files, 0 errors, 1 warning`.
    fn summary(&self) -> String {
        let count = |number: usize, what: &str| {
            let plural = if number == 1 { "" } else { "s" };
            format!("{number} {what}{plural}")
        };
        let files = count(self.files.len(), "file");
        let errors = count(self.errors, "error");
        format!("{files}, {errors}, {}", count(self.warnings, "warning"))
    }
}

impl Check {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let mut findings = Findings::default();
        let generation = ControllerGeneration::from(self.generation).into();
        let mut machine = Machine::new(Limits::default());
        for path in &self.files {
            let text =
                std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
            let file = path.display().to_string();
            let folder = Folder::of(path).and(&self.includes);
            let mut checked = Checked {
                file: file.clone(),
                program: None,
            };
            match Program::from_file_for(&text, &file, &folder, generation) {
                Ok(program) => {
                    for warning in program.warnings() {
                        self.tell(&mut findings, warning);
                    }
                    checked.program = Some(program.name().to_owned());
                    if self.together
                        && let Err(error) = machine.load(program)
                    {
                        self.tell_about_file(&mut findings, &file, error.to_string());
                    }
                }
                Err(diagnostics) => {
                    for diagnostic in &diagnostics {
                        self.tell(&mut findings, diagnostic);
                    }
                }
            }
            findings.files.push(checked);
        }
        if self.json {
            let text = serde_json::to_string_pretty(&findings).context("writing the findings")?;
            put(&(text + "\n"));
        } else {
            eprintln!("{}", findings.summary());
        }
        Ok(if findings.errors == 0 {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(1)
        })
    }

    fn tell(&self, findings: &mut Findings, diagnostic: &Diagnostic) {
        let severity = match diagnostic.severity {
            Severity::Error => {
                findings.errors += 1;
                "error"
            }
            Severity::Warning => {
                findings.warnings += 1;
                "warning"
            }
        };
        if !self.json {
            eprintln!("{diagnostic}");
            return;
        }
        let (_, length) = diagnostic.carets;
        findings.diagnostics.push(Finding {
            severity,
            message: diagnostic.message.clone(),
            help: diagnostic.help.clone(),
            file: diagnostic.file.to_string(),
            line: Some(diagnostic.line),
            column: Some(diagnostic.column),
            length: Some(length),
            source_line: Some(diagnostic.source_line.clone()),
        });
    }

    fn tell_about_file(&self, findings: &mut Findings, file: &str, message: String) {
        findings.errors += 1;
        if !self.json {
            eprintln!("error: {message}\n --> {file}");
            return;
        }
        findings.diagnostics.push(Finding {
            severity: "error",
            message,
            help: None,
            file: file.to_owned(),
            line: None,
            column: None,
            length: None,
            source_line: None,
        });
    }
}
