//! Ids and names: what may stand in them.
//!
//! Names reach pages, terminals, logs and other machines. So what could be markup, a control sequence or a trick with
//! the direction of writing is refused here, once, instead of being escaped in each of those places and forgotten in
//! one. Ids never name files.

use super::faults::Faults;
use crate::state::shown;

const MAX_ID: usize = 64;
const MAX_NAME: usize = 100;

/// Whether a text is an id: `[a-z0-9][a-z0-9_-]{0,63}`.
pub(crate) fn is_id(text: &str) -> bool {
    let letter = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
    text.len() <= MAX_ID
        && text.bytes().next().is_some_and(letter)
        && text
            .bytes()
            .all(|byte| letter(byte) || byte == b'_' || byte == b'-')
}

/// Whether a text is the id of a place: an id, or two with a slash between.
fn is_place_id(text: &str) -> bool {
    match text.split_once('/') {
        Some((group, place)) => is_id(group) && is_id(place),
        None => is_id(text),
    }
}

/// An id; told of where it is none.
pub(crate) fn check_id(faults: &mut Faults, item: String, id: &str) {
    if !is_id(id) {
        let id = shown(id);
        faults.add(
            item,
            format!("`{id}` does not match [a-z0-9][a-z0-9_-]{{0,63}}"),
        );
    }
}

/// The id of a place; told of where it is none.
pub(crate) fn check_place_id(faults: &mut Faults, item: String, id: &str) {
    if !is_place_id(id) {
        let id = shown(id);
        faults.add(
            item,
            format!(
                "`{id}` is neither [a-z0-9][a-z0-9_-]{{0,63}} nor two of them with a slash between"
            ),
        );
    }
}

/// A name for people; told of where it holds what people cannot read.
pub(crate) fn check_name(faults: &mut Faults, item: String, name: Option<&str>) {
    let Some(name) = name else { return };
    let length = name.chars().count();
    if length == 0 || length > MAX_NAME || name.trim() != name {
        let name = shown(name);
        faults.add(
            item,
            format!("`{name}` is not a name: 1 to {MAX_NAME} characters, no blank at either end"),
        );
    } else if let Some(refused) = name.chars().find(|c| is_refused(*c)) {
        faults.add(
            item,
            format!(
                "holds {}; a name has no control characters and none of < > & \" ` \\",
                refused.escape_unicode()
            ),
        );
    }
}

/// Control characters, markup, and what turns the direction of writing or is not seen at all.
fn is_refused(c: char) -> bool {
    c.is_control()
        || matches!(c, '<' | '>' | '&' | '"' | '`' | '\\')
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(name: &str) -> bool {
        let mut faults = Faults::default();
        check_name(&mut faults, "name".to_owned(), Some(name));
        !faults.is_empty()
    }

    #[test]
    fn x11_names_with_markup_or_control_characters_are_refused() {
        for name in [
            "<script>alert(1)</script>",
            "a&lt;b",
            "a\u{1b}[2Jb",
            "a\r\nb",
            "a\0b",
            "\u{202e}gnp.exe",
            "zero\u{200b}width",
            "",
            " a",
        ] {
            assert!(refused(name), "{name:?}");
        }
        assert!(refused(&"x".repeat(101)));
        for name in [
            "Rack A, row 1",
            "Übergabe 1",
            "стол №2",
            "O'Brien's bench (left)",
        ] {
            assert!(!refused(name), "{name:?}");
        }
    }

    #[test]
    fn x16_an_id_is_no_path() {
        for id in [
            "..", "../a", "a/..", "/a", "a/", "a//b", "A", "a.b", "a b", "", "a/b/c", "-a",
        ] {
            assert!(!is_place_id(id), "{id:?}");
        }
        assert!(is_place_id("rack/a-1") && is_place_id("reject") && !is_id("rack/a"));
    }
}
