//! docs/fidelity.md: rules that no document at hand states, the place in the source that decides each, and its tests.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use serde::Deserialize;

use crate::command::root;

/// The crates whose guesses are marked.
const CRATES: [&str; 2] = ["crates/karel", "karel-emulator"];
/// Where golden programs are.
/// Golden programs, and where their listings are.
const CASES: [(&str, &str); 3] = [
    ("crates/karel/tests/cases", "kl"),
    ("crates/karel/tests/cases/tp", "ls"),
    ("karel-emulator/tests/cases", "ls"),
];
const MARK: &str = "ASSUMPTION:";
/// What an item begins with.
const ITEMS: [&str; 6] = ["fn", "const", "struct", "enum", "static", "mod"];

const HEAD: &str = "\
# How a rule is known, where it is decided, and what holds it

Written by `cargo xtask fidelity` from fidelity.toml and the source; not edited by hand. A test compares.

No vendor document was at hand. So every rule that is not plain from public programs is decided in one place, which is easy to change,
and a test says what happens. `reported`: users or authors of a driver saw it on a controller. `working`: a public program that works
needs it. `assumed`: a guess.

[`cargo xtask conformance`](emulator.md#the-public-drivers) runs the three public drivers, unmodified, and checks what their clients see.
";

/// docs/fidelity.toml.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    /// Rule, how sure, place, tests.
    rules: Vec<(String, Known, String, Vec<String>)>,
}

/// How a rule is known.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum Known {
    Reported,
    Working,
    Assumed,
}

impl Known {
    fn name(self) -> &'static str {
        match self {
            Self::Reported => "reported",
            Self::Working => "working",
            Self::Assumed => "assumed",
        }
    }
}

/// A guess that is marked in the source.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Guess {
    file: String,
    item: String,
    text: String,
}

/// Writes docs/fidelity.md.
pub(crate) fn write() -> Result<()> {
    fs::write(root().join("docs/fidelity.md"), page()?).context("writing docs/fidelity.md")
}

/// The page as it should be now.
///
/// # Errors
/// A row of the list names a place or a test that is not there.
pub(crate) fn page() -> Result<String> {
    let text = fs::read_to_string(root().join("docs/fidelity.toml"));
    let text = text.context("reading docs/fidelity.toml")?;
    let List { rules } = toml::from_str(&text).context("in docs/fidelity.toml")?;
    let tests = tests()?;
    let mut wrong = Vec::new();
    let mut page = HEAD.to_owned();
    for (number, word) in [Known::Reported, Known::Working, Known::Assumed]
        .map(|known| (rules.iter().filter(|rule| rule.1 == known).count(), known))
    {
        let end = if word == Known::Assumed {
            ".\n\n"
        } else {
            ", "
        };
        write!(page, "{number} {}{end}", word.name())?;
    }
    page.push_str("| rule | known | decided in | tests |\n|---|---|---|---|\n");
    let mut decided = BTreeSet::new();
    for (rule, known, place, names) in &rules {
        let Some((file, item)) = place.split_once("::") else {
            bail!("{place:?} is not file::item");
        };
        if !fs::read_to_string(root().join(file)).is_ok_and(|text| defines(&text, item)) {
            wrong.push(format!("{place} is not there: {rule}"));
        }
        if names.is_empty() {
            wrong.push(format!("no test: {rule}"));
        }
        let mut links = Vec::new();
        for name in names {
            match tests.iter().find(|(_, test)| test == name) {
                Some((file, _)) => links.push(format!("[`{name}`](../{file})")),
                None => wrong.push(format!("there is no test {name}: {rule}")),
            }
        }
        let _new = decided.insert((file.to_owned(), item.to_owned()));
        let (links, known) = (links.join(", "), known.name());
        writeln!(
            page,
            "| {rule} | {known} | [`{item}`](../{file}) | {links} |"
        )?;
    }
    if !wrong.is_empty() {
        bail!("docs/fidelity.toml: {}", wrong.join("; "));
    }
    let mut guesses = guesses()?;
    let all = guesses.len();
    guesses.retain(|Guess { file, item, .. }| {
        // A mark of a whole file is settled by any rule that is decided there.
        let whole = file.ends_with(&format!("/{item}"));
        let settles = |(place, name): &(String, String)| place == file && (whole || name == item);
        !decided.iter().any(settles)
    });
    writeln!(
        page,
        "\n## Smaller guesses\n\n\
         {all} places in the source are marked `{MARK}`; these are the {} that no rule above is decided in. Numbers of alarms and \
         codes of constants are most of them; programs in the field use the names, or compare with 0.\n\n\
         | decided in | guess |\n|---|---|",
        guesses.len()
    )?;
    for Guess { file, item, text } in guesses {
        let text = text.replace('|', "\\|");
        writeln!(page, "| [`{item}`](../{file}) | {text} |")?;
    }
    Ok(page)
}

/// Every test by its file: functions below a test's attribute or in a test's module, and golden programs.
fn tests() -> Result<Vec<(String, String)>> {
    let mut tests = Vec::new();
    for file in CRATES.iter().flat_map(|name| sources(&root().join(name))) {
        let text = fs::read_to_string(&file)?;
        let file = relative(&file);
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        let mut is_test = false;
        for line in lines {
            if line.starts_with("#[test]") || line.starts_with("#[tokio::test") {
                is_test = true;
            } else if let Some((name, _)) = line
                .trim_start_matches("async ")
                .strip_prefix("fn ")
                .and_then(|rest| rest.split_once('('))
            {
                if is_test {
                    tests.push((file.clone(), name.to_owned()));
                }
                is_test = false;
            }
        }
    }
    for (folder, extension) in CASES {
        for entry in fs::read_dir(root().join(folder)).context("reading the golden programs")? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if Path::new(&name)
                .extension()
                .is_some_and(|end| end == extension)
            {
                tests.push((format!("{folder}/{name}"), name));
            }
        }
    }
    Ok(tests)
}

/// The marks in the source, with the items that they stand at.
fn guesses() -> Result<Vec<Guess>> {
    let mut found = Vec::new();
    for file in CRATES
        .iter()
        .flat_map(|name| sources(&root().join(name).join("src")))
    {
        let text = fs::read_to_string(&file)?;
        let lines: Vec<&str> = text.lines().collect();
        let file = relative(&file);
        for (at, line) in lines.iter().enumerate() {
            let Some((before, _)) = line.split_once(MARK) else {
                continue;
            };
            // A mark inside of a sentence about marks is none.
            if before.contains('`') {
                continue;
            }
            let item = if before.trim_start().starts_with("//!") {
                file.rsplit('/').next().unwrap_or_default().to_owned()
            } else if before.trim_start().starts_with("///") {
                let mut below = lines.iter().skip(at + 1);
                let item = below.find_map(|line| {
                    let line = line.trim();
                    let passed = line.starts_with("//") || line.starts_with("#[");
                    (!passed).then(|| named(line).unwrap_or(line.trim_end_matches([',', ' '])))
                });
                item.unwrap_or_default().to_owned()
            } else {
                let mut above = lines.iter().take(at).rev();
                let function = above.find_map(|line| named(line.trim()));
                function.unwrap_or_default().to_owned()
            };
            let text = sentence(&lines, at);
            found.push(Guess {
                file: file.clone(),
                item,
                text,
            });
        }
    }
    found.sort();
    Ok(found)
}

/// The comment from the mark on, to the end of its first sentence.
fn sentence(lines: &[&str], at: usize) -> String {
    let mut text = String::new();
    for line in lines.iter().skip(at) {
        let Some(comment) = line.trim().strip_prefix("//") else {
            break;
        };
        let comment = comment.trim_start_matches(['/', '!']).trim();
        let comment = comment
            .split_once(MARK)
            .map_or(comment, |(_, rest)| rest.trim());
        if comment.is_empty() {
            break;
        }
        if !text.is_empty() {
            text.push(' ');
        }
        text.push_str(comment);
        if let Some((first, _)) = text.split_once(". ") {
            return first.to_owned();
        }
    }
    text.trim_end_matches('.').to_owned()
}

/// The name of the item that a line begins.
fn named(line: &str) -> Option<&str> {
    let words = line.split_whitespace().skip_while(|word| {
        word.starts_with("pub") || matches!(*word, "async" | "super)" | "crate)")
    });
    let mut words = words.skip_while(|word| *word == "const" && line.contains("const fn"));
    let kind = words.next()?;
    let name = words.next().filter(|_| ITEMS.contains(&kind))?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_');
    Some(name.get(..end.unwrap_or(name.len())).unwrap_or(name))
}

/// Whether a source text has an item of this name.
fn defines(text: &str, item: &str) -> bool {
    text.lines().any(|line| named(line.trim()) == Some(item))
}

/// All source files of a folder, in order.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
        .unwrap_or_default();
    entries.sort();
    for entry in entries {
        if entry.is_dir() {
            files.extend(sources(&entry));
        } else if entry.extension().is_some_and(|end| end == "rs") {
            files.push(entry);
        }
    }
    files
}

fn relative(file: &Path) -> String {
    let relative = file.strip_prefix(root()).unwrap_or(file);
    relative.display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_has_its_place_and_its_tests_and_the_page_is_current() {
        let kept = fs::read_to_string(root().join("docs/fidelity.md")).unwrap_or_default();
        let page = page().unwrap();
        assert!(
            kept == page,
            "run `cargo xtask fidelity` and look at what changes"
        );
    }

    #[test]
    fn items_are_found_by_their_names() {
        for (line, name) in [
            (
                "pub(super) fn token(&mut self, kind: Kind) {",
                Some("token"),
            ),
            (
                "pub(crate) const LINE_END: &[u8] = b\"\";",
                Some("LINE_END"),
            ),
            ("pub const fn new(code: i32) -> Self {", Some("new")),
            ("async fn run<T>(f: T) {", Some("run")),
            ("pub struct Executor<T> {", Some("Executor")),
            ("let x = 1;", None),
            ("// fn no(", None),
        ] {
            assert_eq!(named(line), name, "{line}");
        }
    }

    #[test]
    fn a_sentence_ends_at_its_point_or_with_the_comment() {
        let lines = ["/// ASSUMPTION: one", "/// and two. Three.", "fn x() {}"];
        assert_eq!(sentence(&lines, 0), "one and two");
        let lines = ["// ASSUMPTION: one", "let x = 1;"];
        assert_eq!(sentence(&lines, 0), "one");
    }
}
