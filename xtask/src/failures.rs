//! docs/failures.md: what can go wrong, what must happen then, and the tests that prove it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::Deserialize;

/// The list of failures, as in docs/failures.toml.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    groups: BTreeMap<String, String>,
    /// Id to fault and behavior.
    failures: BTreeMap<String, (String, String)>,
}

/// A test, by the file it stands in and its name.
#[derive(Clone, Debug, Eq, Ord, PartialEq, PartialOrd)]
struct Test {
    file: String,
    name: String,
}

/// Writes docs/failures.md.
pub(crate) fn write() -> Result<()> {
    fs::write(root().join("docs/failures.md"), page()?).context("writing docs/failures.md")
}

/// The page as it should be now.
pub(crate) fn page() -> Result<String> {
    let path = root().join("docs/failures.toml");
    let text = fs::read_to_string(&path).context("reading docs/failures.toml")?;
    let list: List = toml::from_str(&text).context("in docs/failures.toml")?;
    let covering = covering(&list)?;
    let mut page = String::from(
        "# What can go wrong, and the test that proves what happens then\n\n\
         Written by `cargo xtask failures` from failures.toml and the tests; not edited by hand.\n",
    );
    let total = list.failures.len();
    let covered = list
        .failures
        .keys()
        .filter(|id| covering.contains_key(*id))
        .count();
    writeln!(page, "\n**{covered} of {total} covered.**")?;
    for (letter, title) in &list.groups {
        let mut ids: Vec<_> = list
            .failures
            .iter()
            .filter(|(id, _)| id.trim_end_matches(|digit: char| digit.is_ascii_digit()) == letter)
            .collect();
        ids.sort_by_key(|(id, _)| number(id));
        let covered = ids
            .iter()
            .filter(|(id, _)| covering.contains_key(*id))
            .count();
        writeln!(page, "\n## {letter}. {title}: {covered} of {}\n", ids.len())?;
        page.push_str("| id | what goes wrong | what happens | tests |\n|---|---|---|---|\n");
        for (id, (fault, behavior)) in ids {
            let tests = covering
                .get(id)
                .map_or_else(|| "none yet".to_owned(), |tests| names(tests));
            writeln!(page, "| {id} | {fault} | {behavior} | {tests} |")?;
        }
    }
    Ok(page)
}

fn names(tests: &[Test]) -> String {
    tests
        .iter()
        .map(|test| format!("[`{}`](../{})", test.name, test.file))
        .collect::<Vec<_>>()
        .join(", ")
}

/// The tests of each id.
fn covering(list: &List) -> Result<BTreeMap<String, Vec<Test>>> {
    let mut covering: BTreeMap<String, Vec<Test>> = BTreeMap::new();
    for path in sources(&root())? {
        let text = fs::read_to_string(&path)?;
        let file = path
            .strip_prefix(root())
            .unwrap_or(&path)
            .display()
            .to_string();
        for (name, ids) in tests_of(&text) {
            for id in ids.into_iter().filter(|id| list.failures.contains_key(id)) {
                covering.entry(id).or_default().push(Test {
                    file: file.clone(),
                    name: name.clone(),
                });
            }
        }
    }
    for tests in covering.values_mut() {
        tests.sort();
        tests.dedup();
    }
    Ok(covering)
}

/// Every test of a source text with the ids its name and its documentation name.
fn tests_of(text: &str) -> Vec<(String, Vec<String>)> {
    let mut found = Vec::new();
    let mut ids = Vec::new();
    let mut is_test = false;
    for line in text.lines().map(str::trim) {
        if let Some(doc) = line.strip_prefix("///") {
            ids.extend(ids_in(doc));
        } else if line.starts_with("#[") {
            is_test |= ["#[test]", "#[tokio::test", "#[sqlx::test"]
                .iter()
                .any(|attribute| line.starts_with(attribute));
        } else if let Some(name) = function_name(line) {
            if is_test {
                ids.extend(id_of_name(name));
                found.push((name.to_owned(), std::mem::take(&mut ids)));
            }
            ids.clear();
            is_test = false;
        } else if !line.is_empty() && !is_test && !line.starts_with("//") {
            ids.clear();
        }
    }
    found
}

fn function_name(line: &str) -> Option<&str> {
    let rest = line
        .strip_prefix("async fn ")
        .or_else(|| line.strip_prefix("fn "))?;
    rest.split(['(', '<']).next()
}

/// `h6_same_key` is about H6, `f09_grip_fails` about F9.
fn id_of_name(name: &str) -> Vec<String> {
    // A test may begin with several ids: `h6_h7_...`.
    name.split('_').map_while(canonical).collect()
}

/// The ids in a line of documentation that begins with `Covers:` or with an id: T1 alone may also be the mode of a
/// controller.
fn ids_in(doc: &str) -> Vec<String> {
    let doc = doc.trim();
    let list = doc.strip_prefix("Covers:").unwrap_or(doc);
    list.split([' ', ',', '.', ':', ';', '/', '(', ')'])
        .filter(|word| !word.is_empty())
        .map_while(|word| {
            let is_upper = word.starts_with(|char: char| char.is_ascii_uppercase());
            is_upper.then(|| canonical(word)).flatten()
        })
        .collect()
}

/// `f09` and `F9` are F9; anything else is not an id.
fn canonical(word: &str) -> Option<String> {
    let letter = word.chars().next()?.to_ascii_uppercase();
    let digits = word.get(1..)?;
    let is_number =
        (1..=2).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_digit());
    let number: u32 = digits.parse().ok().filter(|_| is_number)?;
    letter
        .is_ascii_uppercase()
        .then(|| format!("{letter}{number}"))
}

fn number(id: &str) -> u32 {
    id.get(1..)
        .and_then(|digits| digits.parse().ok())
        .unwrap_or(0)
}

/// The Rust files of the workspace, in a stable order.
fn sources(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            if path.is_dir() {
                // This package's own tests contain examples, and cover nothing.
                if name != "target"
                    && name != "xtask"
                    && !name.starts_with('.')
                    && name != "node_modules"
                {
                    open.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_covers_what_its_name_and_its_documentation_name() {
        let text = "
            /// Covers: H6, P12 and not T1.
            #[tokio::test(flavor = \"current_thread\")]
            async fn f09_a_key_is_used_twice() {}

            /// H1 is mentioned on something that is no test.
            fn helper() {}

            #[test]
            fn m1_m2_signals() {}
        ";
        assert_eq!(
            tests_of(text),
            [
                (
                    "f09_a_key_is_used_twice".to_owned(),
                    vec!["H6".to_owned(), "P12".to_owned(), "F9".to_owned()]
                ),
                (
                    "m1_m2_signals".to_owned(),
                    vec!["M1".to_owned(), "M2".to_owned()]
                ),
            ]
        );
    }

    #[test]
    fn the_page_is_current() {
        let written = fs::read_to_string(root().join("docs/failures.md")).unwrap_or_default();
        assert!(
            written == page().unwrap(),
            "docs/failures.md is not what the tests say; run `cargo xtask failures`"
        );
    }
}
