//! The query of a list: `limit=50&cursor=…`.

use std::sync::Arc;

use axum::extract::{FromRequestParts, Query};
use axum::http::Uri;
use axum::http::request::Parts;
use journal::Position;
use uuid::Uuid;

use super::params::invalid;
use crate::problem::Problem;
use crate::state::{App, shown};

/// The longest page.
pub(super) const MAX_PAGE: usize = 200;

/// Where a page of a list begins: what the page before gave as `next_cursor`.
pub(super) trait Cursor: Sized + Send {
    /// The entries of a page where the caller does not say.
    const DEFAULT_LIMIT: usize;

    /// `None` where it cannot be one of this list.
    fn parse(text: &str) -> Option<Self>;
}

/// A motion's id: the page has what is older.
impl Cursor for Uuid {
    const DEFAULT_LIMIT: usize = 50;

    fn parse(text: &str) -> Option<Self> {
        Self::parse_str(text).ok()
    }
}

/// A record's place in the journal: the page has what is older.
impl Cursor for Position {
    const DEFAULT_LIMIT: usize = 100;

    fn parse(text: &str) -> Option<Self> {
        // SQLite's integers are signed, and so is the largest place there is.
        let at: i64 = text.parse().ok()?;
        u64::try_from(at).ok().map(Self)
    }
}

/// A page of a list.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) struct Page<C> {
    pub(super) limit: usize,
    /// Absent: from the beginning of the list.
    pub(super) cursor: Option<C>,
}

impl<C: Cursor> Page<C> {
    /// Reads the query of a list that has no other parameters.
    fn of(uri: &Uri) -> Result<Self, Problem> {
        Self::with_filter(uri, None, |_| Ok(()))
    }

    /// Reads the query of a list with a parameter of its own, which may come several times.
    pub(super) fn with_filter(
        uri: &Uri,
        filter: Option<&str>,
        mut add: impl FnMut(&str) -> Result<(), Problem>,
    ) -> Result<Self, Problem> {
        let pairs = Query::<Vec<(String, String)>>::try_from_uri(uri)
            .map_err(|error| invalid("query", error.body_text(), None))?;
        let (mut limit, mut cursor) = (None, None);
        for (key, value) in pairs.0 {
            let twice = match key.as_str() {
                "limit" => limit.replace(limit_of(&value)?).is_some(),
                "cursor" => cursor.replace(cursor_of::<C>(&value)?).is_some(),
                key if Some(key) == filter => {
                    add(&value)?;
                    false
                }
                _ => return Err(unknown(&key, filter)),
            };
            if twice {
                return Err(invalid(&key, "given twice".to_owned(), None));
            }
        }
        Ok(Self {
            limit: limit.unwrap_or(C::DEFAULT_LIMIT),
            cursor,
        })
    }
}

impl<C: Cursor> FromRequestParts<Arc<App>> for Page<C> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        Self::of(&parts.uri)
    }
}

fn limit_of(text: &str) -> Result<usize, Problem> {
    let value: Option<usize> = text.parse().ok();
    value
        .filter(|value| (1..=MAX_PAGE).contains(value))
        .ok_or_else(|| {
            let text = shown(text);
            let message = format!("`{text}` is not a whole number of 1 to {MAX_PAGE}");
            invalid("limit", message, text.parse().ok())
        })
}

fn cursor_of<C: Cursor>(text: &str) -> Result<C, Problem> {
    C::parse(text).ok_or_else(|| {
        let message = format!("`{}` is not a `next_cursor` of this list", shown(text));
        invalid("cursor", message, None)
    })
}

fn unknown(key: &str, filter: Option<&str>) -> Problem {
    let message = match filter {
        Some(filter) => format!("unknown; the parameters are `{filter}`, `limit` and `cursor`"),
        None => "unknown; the parameters are `limit` and `cursor`".to_owned(),
    };
    invalid(&shown(key), message, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page<C: Cursor>(query: &str) -> Result<Page<C>, Problem> {
        Page::of(&format!("/list?{query}").parse().unwrap())
    }

    /// Covers: R8.
    #[test]
    fn a_page_has_a_limit_and_a_beginning() {
        assert_eq!(page::<Uuid>("").unwrap().limit, 50);
        assert_eq!(page::<Position>("").unwrap().limit, 100);
        let id = Uuid::from_u128(7);
        let asked = page(&format!("cursor={id}&limit=200")).unwrap();
        assert_eq!(
            asked,
            Page {
                limit: 200,
                cursor: Some(id)
            }
        );
    }

    #[test]
    fn a_query_that_does_not_fit_is_refused() {
        for query in [
            "limit=0",
            "limit=201",
            "limit=-1",
            "limit=1.5",
            "limit=",
            "limit=1&limit=2",
            "cursor=x",
            "offset=1",
            "limit=%ff",
        ] {
            assert!(page::<Uuid>(query).is_err(), "{query}");
        }
    }

    #[test]
    fn a_place_in_the_journal_is_one_that_it_can_have() {
        let last = page::<Position>("cursor=9223372036854775807").unwrap();
        assert_eq!(last.cursor, Some(Position(i64::MAX.cast_unsigned())));
        for query in ["cursor=-1", "cursor=9223372036854775808", "cursor=1-0"] {
            assert!(page::<Position>(query).is_err(), "{query}");
        }
    }
}
