//! docs/robotics.md: each of its commands is run, says what stands below it, and draws the picture that is in docs/plots.
//!
//! `UPDATE_PLOTS=1` (or `cargo xtask plots`) writes the pictures instead of comparing them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail, ensure};

const DOCUMENT: &str = include_str!("../../docs/robotics.md");
/// A line of the document that stands for any number of lines.
const AND_SO_ON: &str = "...";

/// A command of the document, and what it says there.
#[derive(Debug)]
struct Shown {
    words: Vec<String>,
    /// What it exits with.
    code: i32,
    output: Vec<String>,
}

/// The lines of the `console` blocks: `$ ` begins a command, a backslash goes on, `# exit code 1` ends one.
fn shown() -> Vec<Shown> {
    let mut all = Vec::new();
    let mut lines = DOCUMENT.lines();
    while lines.by_ref().any(|line| line == "```console") {
        for line in lines.by_ref().take_while(|line| *line != "```") {
            if let Some(command) = line.strip_prefix("$ ") {
                all.push(Shown {
                    words: vec![command.to_owned()],
                    code: 0,
                    output: Vec::new(),
                });
                continue;
            }
            let Some(last) = all.last_mut() else { continue };
            match last.words.last_mut() {
                Some(words) if words.ends_with('\\') => {
                    let _ = words.pop();
                    words.push_str(line.trim());
                }
                _ => last.output.push(line.to_owned()),
            }
        }
    }
    for shown in &mut all {
        let line = shown.words.concat();
        let (command, code) = match line.split_once("  # exit code ") {
            Some((command, code)) => (command, code.trim().parse().unwrap_or(-1)),
            None => (&*line, 0),
        };
        shown.code = code;
        shown.words = command.split_whitespace().map(str::to_owned).collect();
    }
    all
}

fn is_picture(name: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|extension| extension == "svg")
}

impl Shown {
    /// The file after `--plot`.
    fn picture(&self) -> Option<&str> {
        let option = self.words.iter().position(|word| word == "--plot")?;
        self.words.get(option + 1).map(String::as_str)
    }

    /// Runs it with `folder` as the root of the project.
    fn run(&self, folder: &Path) -> Result<()> {
        let (program, arguments) = self.words.split_first().context("an empty command")?;
        ensure!(
            program == "cellctl",
            "{program} is no command of this document"
        );
        let output = Command::new(env!("CARGO_BIN_EXE_cellctl"))
            .env_clear()
            .current_dir(folder)
            .args(arguments)
            .output()?;
        let said = String::from_utf8(output.stdout)? + &String::from_utf8(output.stderr)?;
        ensure!(
            output.status.code() == Some(self.code),
            "{:?} instead of {}: {said}",
            output.status.code(),
            self.code
        );
        self.compare(&said)
    }

    fn compare(&self, said: &str) -> Result<()> {
        let mut said_lines = said.lines().map(str::trim_end);
        let mut anything = false;
        for wanted in &self.output {
            if wanted == AND_SO_ON {
                anything = true;
                continue;
            }
            let found = if anything {
                said_lines.any(|line| line == wanted)
            } else {
                said_lines.next() == Some(wanted)
            };
            anything = false;
            ensure!(found, "it does not say `{wanted}` there, but:\n{said}");
        }
        Ok(())
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// What a reader sees in a drawing: its texts, and how many lines, shapes and dots.
///
/// Not its bytes: another processor may round the last digit of a place differently.
fn seen(svg: &str) -> (Vec<&str>, Vec<usize>) {
    let mut lines = svg.lines();
    let mut texts = Vec::new();
    while let Some(line) = lines.next() {
        if line.starts_with("<text ") {
            texts.extend(lines.next());
        }
    }
    let shapes = ["<polyline ", "<line ", "<rect ", "<polygon ", "<circle "];
    let counts = shapes.map(|shape| svg.matches(shape).count());
    (texts, counts.to_vec())
}

#[test]
fn every_command_of_the_document_does_what_the_document_says() -> Result<()> {
    let update = std::env::var_os("UPDATE_PLOTS").is_some();
    let folder = tempfile::tempdir()?;
    let (drawn, kept) = (folder.path().join("docs/plots"), root().join("docs/plots"));
    std::fs::create_dir_all(&drawn)?;
    for entry in std::fs::read_dir(&kept)? {
        let path = entry?.path();
        let is_question = path.extension().is_some_and(|ending| ending == "toml");
        if let (true, Some(name)) = (is_question, path.file_name()) {
            let _bytes = std::fs::copy(&path, drawn.join(name))?;
        }
    }
    let all = shown();
    ensure!(all.len() > 25, "only {} commands were found", all.len());
    let mut pictures = BTreeSet::new();
    for shown in &all {
        let line = shown.words.join(" ");
        shown.run(folder.path()).with_context(|| line.clone())?;
        let Some(picture) = shown.picture() else {
            continue;
        };
        ensure!(
            pictures.insert(picture.to_owned()),
            "{line}: {picture} is drawn twice"
        );
        let new = std::fs::read_to_string(folder.path().join(picture))?;
        ensure!(new.len() < 100_000, "{picture} has {} bytes", new.len());
        if update {
            std::fs::write(root().join(picture), new)?;
            continue;
        }
        let old = std::fs::read_to_string(root().join(picture))
            .with_context(|| format!("{picture}; `cargo xtask plots` draws it"))?;
        if seen(&old) != seen(&new) {
            bail!(
                "{picture} is another one now; `cargo xtask plots` draws it anew, then look at it"
            );
        }
    }
    // The pictures in the text, and those in the folder, are those that were drawn.
    let mut in_text = BTreeSet::new();
    for part in DOCUMENT.split("](plots/").skip(1) {
        let name = part.split(')').next().unwrap_or_default();
        if is_picture(name) {
            let _new = in_text.insert(format!("docs/plots/{name}"));
        }
    }
    let mut in_folder = BTreeSet::new();
    for entry in std::fs::read_dir(&kept)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if is_picture(&name) {
            let _new = in_folder.insert(format!("docs/plots/{name}"));
        }
    }
    assert_eq!(in_text, pictures, "in the text, and drawn");
    assert_eq!(in_folder, pictures, "in docs/plots, and drawn");
    Ok(())
}
