//! The arrows drawn in ARCHITECTURE.md are the arrows between the packages.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

type Arrows = BTreeMap<String, BTreeSet<String>>;

#[test]
fn the_arrows_in_the_architecture_page_are_the_real_ones() {
    let drawn = drawn_arrows();
    let real = real_arrows();
    for (package, dependencies) in &real {
        let Some(drawn) = drawn.get(package) else {
            panic!("ARCHITECTURE.md does not show the package `{package}`");
        };
        assert_eq!(
            drawn, dependencies,
            "ARCHITECTURE.md (left) and Cargo.toml (right) of `{package}`"
        );
    }
    let unknown: Vec<_> = drawn
        .keys()
        .filter(|package| !real.contains_key(*package))
        .collect();
    assert!(
        unknown.is_empty(),
        "ARCHITECTURE.md shows packages that do not exist: {unknown:?}"
    );
}

#[test]
fn the_emulator_never_links_the_protocol_crate() {
    let real = real_arrows();
    let mut reached = BTreeSet::new();
    let mut open = vec!["karel-emulator".to_owned()];
    while let Some(package) = open.pop() {
        for dependency in real.get(&package).into_iter().flatten() {
            if reached.insert(dependency.clone()) {
                open.push(dependency.clone());
            }
        }
    }
    assert!(
        !reached.contains("protocol"),
        "the wire format must be written twice; see ARCHITECTURE.md"
    );
}

/// Lines of the form `path/  what it is  -> a, b` inside the code block of ARCHITECTURE.md.
fn drawn_arrows() -> Arrows {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let block = text
        .split("```")
        .nth(1)
        .expect("ARCHITECTURE.md has a code block");
    let mut arrows = Arrows::new();
    for line in block.lines() {
        let Some((left, right)) = line.rsplit_once(" -> ") else {
            continue;
        };
        let path = left
            .split_whitespace()
            .next()
            .expect("a path stands before the arrow");
        let path = path.trim_end_matches('/');
        let package = path.rsplit_once('/').map_or(path, |(_, name)| name);
        let dependencies = right.split(',').map(str::trim);
        let dependencies = dependencies
            .filter(|name| !name.is_empty() && *name != "nothing")
            .map(String::from);
        let before = arrows.insert(package.to_owned(), dependencies.collect());
        assert!(before.is_none(), "ARCHITECTURE.md shows `{package}` twice");
    }
    arrows
}

/// Normal (not development or build) dependencies between the packages of this workspace.
fn real_arrows() -> Arrows {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--format-version",
            "1",
            "--offline",
        ])
        .current_dir(root())
        .output()
        .expect("cargo metadata runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let packages = list(&metadata, "packages");
    let names: BTreeSet<String> = packages
        .iter()
        .map(|package| text(package, "name"))
        .collect();
    let inside = |package: &Value| -> BTreeSet<String> {
        let dependencies = list(package, "dependencies").into_iter();
        let normal = dependencies.filter(|dependency| text(dependency, "kind").is_empty());
        normal
            .map(|dependency| text(&dependency, "name"))
            .filter(|name| names.contains(name))
            .collect()
    };
    packages
        .iter()
        .map(|package| (text(package, "name"), inside(package)))
        .collect()
}

fn list(value: &Value, key: &str) -> Vec<Value> {
    value
        .get(key)
        .and_then(Value::as_array)
        .cloned()
        .unwrap_or_default()
}

/// Empty where the key is null: a normal dependency has no kind.
fn text(value: &Value, key: &str) -> String {
    value
        .get(key)
        .and_then(Value::as_str)
        .unwrap_or_default()
        .to_owned()
}

fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
