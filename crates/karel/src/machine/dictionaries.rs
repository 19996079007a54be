//! Dictionaries: numbered texts that programs show.
//!
//! ASSUMPTION: a dictionary is read from its source text (`.utx`); the translated form is not known.
//! An element begins with `$`, its number, which may be left out, and a name that nothing needs; its
//! text is strings in `"` and words such as `&new_line`. A line that begins with `*` is a remark.

use std::collections::BTreeMap;

use crate::value::Text;

/// Most elements of a dictionary, and most dictionaries.
const MOST_ELEMENTS: usize = 4096;
const MOST: usize = 64;

/// By name, upper case.
#[derive(Debug, Default)]
pub(crate) struct Dictionaries(BTreeMap<String, Dictionary>);

/// The lines of each element.
type Dictionary = BTreeMap<i32, Vec<Text>>;

impl Dictionaries {
    /// `false` if there are too many.
    pub(crate) fn add(&mut self, name: String, dictionary: Dictionary) -> bool {
        let fits = self.0.len() < MOST || self.0.contains_key(&name);
        if fits {
            let _before = self.0.insert(name, dictionary);
        }
        fits
    }

    pub(crate) fn remove(&mut self, name: &str) -> bool {
        self.0.remove(name).is_some()
    }

    pub(crate) fn element(&self, name: &str, number: i32) -> Option<&[Text]> {
        self.0.get(name)?.get(&number).map(Vec::as_slice)
    }
}

/// The byte of a word behind `&`.
fn code(word: &[u8]) -> Option<u8> {
    Some(match word {
        b"clear_win" => 128,
        b"clear_2_eol" => 129,
        b"clear_2_eow" => 130,
        b"home" => 137,
        b"blink" => 138,
        b"reverse" => 139,
        b"bold" => 140,
        b"under_line" => 141,
        b"standard" => 143,
        _ => return None,
    })
}

/// Reads a source; `None` if it is none.
pub(crate) fn parse(source: &[u8]) -> Option<Dictionary> {
    let mut elements = Dictionary::new();
    let mut number = -1;
    for line in source.split(|byte| *byte == b'\n') {
        let mut rest = line.trim_ascii();
        if rest.is_empty() || rest.starts_with(b"*") {
            continue;
        }
        if let Some(head) = rest.strip_prefix(b"$") {
            let digits = head.iter().take_while(|byte| byte.is_ascii_digit()).count();
            let (digits, after) = head.split_at_checked(digits)?;
            number = if digits.is_empty() {
                number + 1
            } else {
                std::str::from_utf8(digits).ok()?.parse().ok()?
            };
            if elements.len() >= MOST_ELEMENTS || number == i32::MAX {
                return None;
            }
            let _before = elements.insert(number, vec![Text::default()]);
            let name = after
                .iter()
                .take_while(|byte| **byte != b'"' && **byte != b'&');
            rest = after.get(name.count()..)?;
        }
        texts(rest, elements.get_mut(&number)?)?;
    }
    Some(elements)
}

/// Strings and words of a line.
fn texts(mut rest: &[u8], lines: &mut Vec<Text>) -> Option<()> {
    loop {
        rest = rest.trim_ascii();
        let Some((first, after)) = rest.split_first() else {
            return Some(());
        };
        match first {
            b'"' => {
                let end = after.iter().position(|byte| *byte == b'"')?;
                append(lines, after.get(..end)?);
                rest = after.get(end + 1..)?;
                // A doubled one is one.
                if rest.starts_with(b"\"") {
                    append(lines, b"\"");
                }
            }
            b'&' => {
                let word = |byte: &&u8| byte.is_ascii_alphanumeric() || **byte == b'_';
                let length = after.iter().take_while(word).count();
                let word = after.get(..length)?.to_ascii_lowercase();
                if word == b"new_line" {
                    lines.push(Text::default());
                } else {
                    append(lines, &[code(&word)?]);
                }
                rest = after.get(length..)?;
            }
            _ => return None,
        }
    }
}

fn append(lines: &mut [Text], bytes: &[u8]) {
    if let Some(line) = lines.last_mut() {
        line.append(bytes, crate::types::MAX_STRING);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assumed_form_of_a_dictionary() {
        let source = b"* remark\r\n$,first\r\n\"one\" &new_line\r\n\"two \"\"2\"\"\"\r\n$7 \"x\" &home\n$\n\"y\"\n";
        let elements = parse(source).unwrap();
        let lines = |number: i32| -> Vec<String> {
            elements[&number].iter().map(Text::to_string).collect()
        };
        assert_eq!(lines(0), ["one", "two \"2\""]);
        assert_eq!(elements[&7][0].as_bytes(), b"x\x89");
        assert_eq!(lines(8), ["y"]);
        for wrong in ["text", "$ \"open", "$ &strange", "\"before\""] {
            assert_eq!(parse(wrong.as_bytes()), None, "{wrong}");
        }
    }
}
