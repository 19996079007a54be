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
///
/// A test is a function below a test's attribute, or what is registered by a line `name, other_name => ...;` of a
/// macro of the same file that writes such functions.
fn tests_of(text: &str) -> Vec<(String, Vec<String>)> {
    let registrars = registrars(text);
    let mut found = Vec::new();
    let mut ids = Vec::new();
    let mut is_test = false;
    let mut within = Within::Code;
    for line in text.lines() {
        let indent = line.len() - line.trim_start().len();
        let line = line.trim();
        if let Within::Macro { ends_at } | Within::Registration { ends_at } = within
            && indent <= ends_at
            && line.starts_with(['}', ')'])
        {
            within = Within::Code;
            ids.clear();
        } else if matches!(within, Within::Macro { .. }) {
            // What it writes has no name yet.
        } else if let Some(doc) = line.strip_prefix("///") {
            ids.extend(ids_in(doc));
        } else if matches!(within, Within::Registration { .. }) {
            let names = registered(line);
            for name in names {
                let mut all = ids.clone();
                all.extend(id_of_name(name));
                found.push((name.to_owned(), all));
            }
            if !line.starts_with("#[") && !line.starts_with("//") {
                ids.clear();
            }
        } else if line.starts_with("macro_rules!") && !line.ends_with('}') {
            within = Within::Macro { ends_at: indent };
        } else if registrars.iter().any(|name| opens(line, name)) {
            within = Within::Registration { ends_at: indent };
            ids.clear();
        } else if line.starts_with("#[") {
            is_test |= is_attribute(line);
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

/// Where a line stands. What begins at an indentation ends with a bracket at the same one, as `cargo fmt` writes it.
#[derive(Clone, Copy)]
enum Within {
    Code,
    /// The rules of a macro.
    Macro {
        ends_at: usize,
    },
    /// The lines handed to a macro that registers tests.
    Registration {
        ends_at: usize,
    },
}

/// The macros of a source text that write tests.
fn registrars(text: &str) -> Vec<&str> {
    let mut names = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let indent = line.len() - line.trim_start().len();
        let Some(name) = line.trim().strip_prefix("macro_rules!") else {
            continue;
        };
        let name = name.trim().trim_end_matches(['{', '(']).trim();
        let mut body = lines.by_ref().take_while(|line| {
            let ends = line.trim().starts_with(['}', ')']);
            !(ends && line.len() - line.trim_start().len() <= indent)
        });
        // The whole body is read, so that the search for the next macro goes on behind it.
        if body.by_ref().any(is_attribute) {
            names.push(name);
        }
        body.for_each(drop);
    }
    names
}

/// Whether a line holds the attribute of a test.
fn is_attribute(line: &str) -> bool {
    ["#[test]", "#[tokio::test", "#[sqlx::test"]
        .iter()
        .any(|attribute| line.contains(attribute))
}

/// Whether a line begins the call of a macro that goes on in the next lines.
fn opens(line: &str, name: &str) -> bool {
    line.strip_prefix(name)
        .and_then(|rest| rest.strip_prefix('!'))
        .is_some_and(|rest| matches!(rest.trim(), "{" | "("))
}

/// The names before the arrow of `name, other_name => ...;`.
fn registered(line: &str) -> Vec<&str> {
    let Some((names, _)) = line.split_once("=>") else {
        return Vec::new();
    };
    let is_name = |name: &&str| {
        !name.is_empty()
            && name
                .bytes()
                .all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
    };
    let names: Vec<&str> = names.split(',').map(str::trim).collect();
    if names.iter().all(is_name) {
        names
    } else {
        Vec::new()
    }
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
    fn a_macro_that_writes_tests_registers_each_name_before_an_arrow() {
        let text = "
            macro_rules! tests {
                ($($name:ident => $test:expr;)*) => {
                    $(#[tokio::test(flavor = \"multi_thread\")] async fn $name() { $test.await; })*
                };
            }

            macro_rules! both {
                ($($a:ident, $b:ident => $test:ident;)*) => {
                    $(#[test] fn $a() { $test(A); } #[test] fn $b() { $test(B); })*
                };
            }

            macro_rules! words {
                ($($name:ident => $word:expr;)*) => { $(const $name: &str = $word;)* };
            }

            tests! {
                f07_an_alarm_holds_a => faults::alarm(A);
                /// Covers: P12.
                f10_a_part_is_lost_a => faults::lost(A, PartAt::Place(\"reject\".to_owned()));
                the_rest => faults::rest(A);
            }

            words! {
                f11_not_a_test => \"F11\";
            }

            both! {
                f08_an_answer_a, f08_an_answer_b => f08;
            }

            fn f08(which: Which) {}

            #[test]
            fn f09_an_ordinary_one() {
                match it { f12_not_a_test => 1 }
            }
        ";
        let ids = |ids: &[&str]| ids.iter().map(|&id| id.to_owned()).collect::<Vec<_>>();
        assert_eq!(
            tests_of(text),
            [
                ("f07_an_alarm_holds_a".to_owned(), ids(&["F7"])),
                ("f10_a_part_is_lost_a".to_owned(), ids(&["P12", "F10"])),
                ("the_rest".to_owned(), ids(&[])),
                ("f08_an_answer_a".to_owned(), ids(&["F8"])),
                ("f08_an_answer_b".to_owned(), ids(&["F8"])),
                ("f09_an_ordinary_one".to_owned(), ids(&["F9"])),
            ]
        );
    }

    #[test]
    fn an_id_may_be_padded_with_a_zero_and_nothing_else_is_one() {
        assert_eq!(id_of_name("f07_an_alarm"), ["F7"]);
        assert_eq!(id_of_name("h6_h07_keys"), ["H6", "H7"]);
        for name in [
            "f",
            "f0x7_a",
            "f123_a",
            "ff7_a",
            "\u{e9}7_a",
            "_f7",
            "f07a_b",
        ] {
            assert_eq!(id_of_name(name), [""; 0], "{name}");
        }
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
