//! Types that only built-ins of missing options use: variables of them can be declared and filled.

use std::sync::Arc;

use super::{ArrayType, Small, TextLength, Type, standard::structure};

const FORMS: &str = "forms, lists and tables of the pendant's screen";
const VISION: &str = "vision";

const SHORT: Type = Type::Small(Small::Short);

/// A type by its upper-case name, and what uses it.
///
/// ASSUMPTION: the fields are from memory; programs fill them and nothing here looks at them.
pub(crate) fn absent(name: &str) -> Option<(Type, &'static str)> {
    let (fields, used_by) = match name {
        "DISP_DAT_T" => (display_data(), FORMS),
        "COL_DESC_T" => (column(), FORMS),
        "XWORK_T" => (vec![("WORK", Type::Integer)], FORMS),
        "CAM_SETUP" | "MODEL" | "VIS_PROCESS" => (vec![("WORK", Type::Integer)], VISION),
        _ => return None,
    };
    Some((structure(name, &fields), used_by))
}

/// What `DISCTRL_LIST` shows.
fn display_data() -> Vec<(&'static str, Type)> {
    vec![
        ("WIN_START", shorts(4)),
        ("WIN_END", shorts(4)),
        ("CURR_WIN", SHORT),
        ("CURSOR_ROW", SHORT),
        ("LINS_PER_PG", SHORT),
        ("CURS_ST_COL", shorts(10)),
        ("CURS_EN_COL", shorts(10)),
        ("CURR_POS", SHORT),
        ("IN_START", SHORT),
        ("IN_END", SHORT),
        ("CURR_START", SHORT),
        ("CURR_END", SHORT),
        ("MAX_NUMBER", SHORT),
    ]
}

/// A column of `DISCTRL_TBL` and `INIT_TBL`.
fn column() -> Vec<(&'static str, Type)> {
    let text = |length| Type::Text(TextLength::AtMost(length));
    vec![
        ("ITEM_TYPE", Type::Integer),
        ("START_COL", Type::Integer),
        ("FIELD_WIDTH", Type::Integer),
        ("NUM_ELE", Type::Integer),
        ("ENUM_DICT", text(4)),
        ("ENUM_ELE", Type::Integer),
        ("FORMAT_SPEC", text(8)),
        ("MAX_INTEGER", Type::Integer),
        ("MIN_INTEGER", Type::Integer),
        ("MAX_REAL", Type::Real),
        ("MIN_REAL", Type::Real),
        ("CLEAR_FLAG", Type::Boolean),
        ("LOWER_CASE", Type::Boolean),
    ]
}

fn shorts(length: u32) -> Type {
    Type::Array(Arc::new(ArrayType {
        dims: vec![length],
        element: SHORT,
        depth: 1,
    }))
}
