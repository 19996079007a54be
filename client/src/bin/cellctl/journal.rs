//! `cellctl journal`: a journal file, checked or written out. It needs no server, and the server may be running.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use journal::{Digest, Head, Position, VerifyError};
use serde::Serialize;

use crate::failure::{Failure, with_cause};
use crate::report::{Exit, Report};

/// Check a journal file, or write it out.
///
/// Exit codes: 0 it holds; 1 it does not, and the first broken record is named; 3 it cannot be read.
///
/// Examples:
///   cellctl journal verify cell.journal
///   cellctl journal verify cell.journal --archive archive/*.jsonl
///   cellctl journal export cell.journal --output cell.jsonl
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct JournalArgs {
    #[command(subcommand)]
    command: JournalCommand,
}

#[derive(Debug, Subcommand)]
enum JournalCommand {
    /// Check every record, the chain of their hashes, and what was made from them.
    Verify {
        /// The journal's file.
        file: PathBuf,
        /// A last record known from elsewhere, POSITION:HASH: shows an end that was cut off.
        #[arg(long, value_name = "POSITION:HASH", value_parser = head)]
        head: Option<Head>,
        /// Files that removed records were written out to, in their order: together with the journal they are the whole
        /// chain from the first record on.
        #[arg(long, value_name = "FILE", num_args = 1..)]
        archive: Vec<PathBuf>,
    },
    /// Write the records as lines of JSON, byte for byte as they were hashed.
    Export {
        /// The journal's file.
        file: PathBuf,
        /// Where to; the standard output where absent. It must not be there yet.
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
    },
}

#[derive(Debug, Default, Serialize)]
struct Verified {
    holds: bool,
    /// Records that are there.
    #[serde(skip_serializing_if = "Option::is_none")]
    records: Option<u64>,
    /// The last record that was removed.
    #[serde(skip_serializing_if = "Option::is_none")]
    removed_through: Option<String>,
    /// Whether archives were given, and are what was removed.
    #[serde(skip_serializing_if = "Option::is_none")]
    archives_match: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    snapshots: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    head: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    epoch: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    open_motions: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    open_jobs: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    first_broken: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

pub(crate) async fn run(args: JournalArgs, json: bool) -> Result<Report, Failure> {
    match args.command {
        JournalCommand::Verify {
            file,
            head,
            archive,
        } => Ok(verify(&file, head, &archive, json).await),
        JournalCommand::Export { file, output } => Ok(export(&file, output.as_deref(), json).await),
    }
}

async fn verify(file: &Path, known: Option<Head>, archives: &[PathBuf], json: bool) -> Report {
    if !file.exists() {
        return missing(file, json);
    }
    let archived = match proved(archives) {
        Ok(archived) => archived,
        Err(report) => return report,
    };
    let (exit, verified) = match journal::verify(file, known).await {
        Ok(report) => {
            let matches = archived.map(|archived| archived == report.base);
            let gone = report.base != Head::EMPTY;
            let verified = Verified {
                holds: matches != Some(false),
                records: Some(report.head.position.0 - report.base.position.0),
                removed_through: gone.then(|| said(report.base)),
                archives_match: matches,
                snapshots: Some(report.snapshots),
                head: Some(said(report.head)),
                epoch: Some(report.epoch.0),
                open_motions: Some(report.open_motions),
                open_jobs: Some(report.open_jobs),
                first_broken: None,
                problem: archived.filter(|_| matches == Some(false)).map(|archived| {
                    format!(
                        "the archives end at {}, and the records here begin behind {}",
                        said(archived),
                        said(report.base)
                    )
                }),
            };
            let exit = if verified.holds {
                Exit::Done
            } else {
                Exit::Refused
            };
            (exit, verified)
        }
        Err(error) => (exit_of(&error), broken(&error)),
    };
    if json {
        return Report::json(exit, &verified);
    }
    match &verified.problem {
        None => Report::text(exit, &sentence(&verified)),
        Some(problem) => Report::error(exit, &format!("cellctl: {}: {problem}", file.display())),
    }
}

/// The database's own words for a file that is not there tell nobody so.
fn missing(file: &Path, json: bool) -> Report {
    let problem = "there is no such file; `[journal] path` of the configuration names the journal";
    if json {
        return Report::json(
            Exit::Link,
            &Verified {
                problem: Some(problem.to_owned()),
                ..Verified::default()
            },
        );
    }
    Report::error(
        Exit::Link,
        &format!("cellctl: {}: {problem}", file.display()),
    )
}

/// What was checked, what it proves, and what it cannot.
fn sentence(verified: &Verified) -> String {
    let mut lines = vec![format!(
        "The journal holds: {} records, epoch {}, {} motions without an end.",
        verified.records.unwrap_or_default(),
        verified.epoch.unwrap_or_default(),
        verified.open_motions.unwrap_or_default(),
    )];
    if let Some(snapshots) = verified.snapshots.filter(|count| *count > 0) {
        lines.push(format!(
            "{snapshots} snapshots, each the one its record tells of."
        ));
    }
    match (&verified.removed_through, verified.archives_match) {
        (Some(removed), Some(true)) => lines.push(format!(
            "The records up to {removed} were removed, and the archives are what they were: one chain."
        )),
        (Some(removed), _) => lines.push(format!(
            "The records up to {removed} were removed. What they said is not proved by this file; their archives, \
             given with --archive, prove it."
        )),
        (None, _) => {}
    }
    lines.push(format!(
        "head {}",
        verified.head.as_deref().unwrap_or_default()
    ));
    lines.push(
        "Kept elsewhere and given with --head, it shows later that nothing was cut off at the end."
            .to_owned(),
    );
    lines.join("\n")
}

fn said(head: Head) -> String {
    format!("{}:{}", head.position, head.hash)
}

/// The last record of the archives; none where none were given.
fn proved(archives: &[PathBuf]) -> Result<Option<Head>, Report> {
    if archives.is_empty() {
        return Ok(None);
    }
    let mut files = Vec::with_capacity(archives.len());
    for path in archives {
        match File::open(path) {
            Ok(file) => files.push(BufReader::new(file)),
            Err(error) => {
                let text = format!("cellctl: {}: {error}", path.display());
                return Err(Report::error(Exit::Usage, &text));
            }
        }
    }
    journal::verify_archives(files).map(Some).map_err(|error| {
        let problem = broken(&error).problem.unwrap_or_default();
        Report::error(
            exit_of(&error),
            &format!("cellctl: the archives: {problem}"),
        )
    })
}

async fn export(file: &Path, output: Option<&Path>, json: bool) -> Report {
    // Never over another file: an export may be the only copy.
    let opened: io::Result<Box<dyn Write>> = match output {
        Some(path) => {
            File::create_new(path).map(|file| Box::new(BufWriter::new(file)) as Box<dyn Write>)
        }
        None => Ok(Box::new(BufWriter::new(io::stdout()))),
    };
    let mut lines = match opened {
        Ok(lines) => lines,
        Err(error) => {
            let path = output.unwrap_or(Path::new("standard output")).display();
            return Report::error(Exit::Usage, &format!("cellctl: {path}: {error}"));
        }
    };
    match journal::export(file, &mut lines).await {
        Ok(head) if output.is_some() => {
            let text = format!(
                "{} records.\nhead {}:{}",
                head.position, head.position, head.hash
            );
            if json {
                let head = format!("{}:{}", head.position, head.hash);
                Report::json(Exit::Done, &serde_json::json!({ "head": head }))
            } else {
                Report::text(Exit::Done, &text)
            }
        }
        // The standard output has the lines and nothing else.
        Ok(_) => Report {
            stdout: String::new(),
            stderr: String::new(),
            exit: Exit::Done,
        },
        Err(error) => Report::error(
            exit_of(&error),
            &format!(
                "cellctl: {}: {}",
                file.display(),
                broken(&error).problem.unwrap_or_default()
            ),
        ),
    }
}

/// 1 where the journal says something wrong, 3 where it says nothing.
fn exit_of(error: &VerifyError) -> Exit {
    match error {
        VerifyError::Broken(_)
        | VerifyError::Rule { .. }
        | VerifyError::Index { .. }
        | VerifyError::File { .. }
        | VerifyError::Export { .. }
        | VerifyError::Unexplained { .. }
        | VerifyError::Snapshot { .. }
        | VerifyError::Line(_) => Exit::Refused,
        VerifyError::Open { .. }
        | VerifyError::Read { .. }
        | VerifyError::Lines(_)
        | VerifyError::Make(_)
        | VerifyError::Write(_) => Exit::Link,
    }
}

fn broken(error: &VerifyError) -> Verified {
    let mut problem = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(source) = cause {
        problem = with_cause(problem, &source.to_string());
        cause = source.source();
    }
    let first_broken = match error {
        VerifyError::Broken(broken) => Some(broken.position()),
        VerifyError::Rule { position, .. } | VerifyError::Export { position, .. } => {
            Some(*position)
        }
        VerifyError::Unexplained { base } => Some(base.next()),
        VerifyError::Open { .. }
        | VerifyError::Read { .. }
        | VerifyError::Snapshot { .. }
        | VerifyError::Index { .. }
        | VerifyError::File { .. }
        | VerifyError::Line(_)
        | VerifyError::Lines(_)
        | VerifyError::Make(_)
        | VerifyError::Write(_) => None,
    };
    Verified {
        holds: false,
        records: None,
        removed_through: None,
        archives_match: None,
        snapshots: None,
        head: None,
        epoch: None,
        open_motions: None,
        open_jobs: None,
        first_broken: first_broken.map(|position| position.0),
        problem: Some(problem),
    }
}

fn head(text: &str) -> Result<Head, String> {
    let wrong = || "write it POSITION:HASH, as `verify` shows it".to_owned();
    let (position, hash) = text.split_once(':').ok_or_else(wrong)?;
    let hash: Digest = hash.parse().map_err(|_| wrong())?;
    Ok(Head {
        position: Position(position.parse().map_err(|_| wrong())?),
        hash,
    })
}
