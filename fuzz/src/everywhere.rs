//! The grammar without chance: each template in each hole where it may stand, below each kind of statement.
//!
//! What is drawn at random meets a template in a certain place once in many thousand programs; a template that is
//! not correct there would be found by a fuzzer on some other day.

use std::collections::{BTreeSet, VecDeque};

use crate::grammar::{program_of, templates_of};

/// Holes whose places have rules of their own, so that all that is below them is tried there.
const PLACES: [&str; 4] = ["{nd}", "{c}", "{b3}", "{a}"];
/// Holes that hold statements again, which are tried by themselves.
const STATEMENTS: [&str; 2] = ["l", "main"];
/// Statements of one program.
const TOGETHER: usize = 150;

/// Which template stands in which hole of the one before; every other hole has its first template.
type Way = Vec<(usize, &'static str)>;

/// Programs that have each template in each hole of each statement, and below the holes of conditions and actions also
/// each template in each hole of those.
#[must_use]
pub fn programs() -> Vec<String> {
    let mut statements = Vec::new();
    for statement in templates_of("s") {
        let all = PLACES.iter().any(|place| statement.contains(place));
        for way in ways(statement, all) {
            statements.push(filled(statement, &way));
        }
    }
    let together = statements.chunks(TOGETHER);
    together.map(|some| program_of(&some.join("\n"))).collect()
}

fn ways(statement: &'static str, all: bool) -> Vec<Way> {
    let mut found = Vec::new();
    let mut known = BTreeSet::new();
    let mut next = VecDeque::from([(statement, Way::new())]);
    while let Some((template, way)) = next.pop_front() {
        for (number, hole) in holes(template).enumerate() {
            if STATEMENTS.contains(&hole) {
                continue;
            }
            for below in templates_of(hole) {
                let mut way = way.clone();
                way.push((number, *below));
                if all && known.insert(*below) {
                    next.push_back((*below, way.clone()));
                }
                found.push(way);
            }
        }
    }
    found
}

fn holes(template: &'static str) -> impl Iterator<Item = &'static str> {
    let behind = template.split('{').skip(1);
    behind.filter_map(|text| text.split('}').next())
}

/// A template with this way in it.
fn filled(template: &'static str, way: &[(usize, &'static str)]) -> String {
    let mut parts = template.split('{');
    let mut text = parts.next().unwrap_or_default().to_owned();
    for (number, part) in parts.enumerate() {
        let (hole, behind) = part.split_once('}').expect("a hole ends");
        text += &match way {
            [(at, chosen), further @ ..] if *at == number => filled(chosen, further),
            _ => filled(first(hole), &[]),
        };
        text += behind;
    }
    text
}

fn first(hole: &str) -> &'static str {
    templates_of(hole).first().expect("a row has a template")
}
