//! System variables that a program may name, with their types.
//!
//! The values are the host's; the checker only has to know what type an expression has. `#` stands
//! for one subscript.

use crate::{
    syspath::{Step, SysPath},
    types::{MAX_STRING, PositionKind, TextLength, Type},
};

/// How a table row writes a type.
#[derive(Clone, Copy)]
enum Row {
    Integer,
    Real,
    Boolean,
    Text,
    Position,
}

impl Row {
    fn ty(self) -> Type {
        match self {
            Row::Integer => Type::Integer,
            Row::Real => Type::Real,
            Row::Boolean => Type::Boolean,
            Row::Text => Type::Text(TextLength::AtMost(u32::try_from(MAX_STRING).unwrap_or(0))),
            Row::Position => Type::Position(PositionKind::Position),
        }
    }
}

#[rustfmt::skip]
const TABLE: &[(&str, Row)] = &[
    ("$DEFPULSE", Row::Integer),
    ("$DMAURST", Row::Boolean),
    ("$FAST_CLOCK", Row::Integer),
    ("$GROUP[#].$MOTYPE", Row::Integer),
    ("$GROUP[#].$ORIENT_TYPE", Row::Integer),
    ("$GROUP[#].$ROTSPEED", Row::Real),
    ("$GROUP[#].$SPEED", Row::Real),
    ("$GROUP[#].$SPEEDLIM", Row::Real),
    ("$GROUP[#].$TERMTYPE", Row::Integer),
    ("$GROUP[#].$UFRAME", Row::Position),
    ("$GROUP[#].$UTOOL", Row::Position),
    ("$HOSTC_CFG[#].$MODE", Row::Text),
    ("$HOSTC_CFG[#].$OPER", Row::Integer),
    ("$HOSTC_CFG[#].$PROTOCOL", Row::Text),
    ("$HOSTC_CFG[#].$REMOTE", Row::Text),
    ("$HOSTC_CFG[#].$SERVER_PORT", Row::Integer),
    ("$HOSTC_CFG[#].$STATE", Row::Integer),
    ("$HOSTC_CFG[#].$STRT_REMOTE", Row::Text),
    ("$HOSTC_CFG[#].$TIMEOUT", Row::Integer),
    ("$HOSTS_CFG[#].$MODE", Row::Text),
    ("$HOSTS_CFG[#].$OPER", Row::Integer),
    ("$HOSTS_CFG[#].$PROTOCOL", Row::Text),
    ("$HOSTS_CFG[#].$REMOTE", Row::Text),
    ("$HOSTS_CFG[#].$SERVER_PORT", Row::Integer),
    ("$HOSTS_CFG[#].$STATE", Row::Integer),
    ("$HOSTS_CFG[#].$STRT_REMOTE", Row::Text),
    ("$HOSTS_CFG[#].$TIMEOUT", Row::Integer),
    ("$JCR_GRP[#].$JOG_COORD", Row::Integer),
    ("$MCR.$GENOVERRIDE", Row::Integer),
    ("$MNUFRAME[#,#]", Row::Position),
    ("$MNUFRAMENUM[#]", Row::Integer),
    ("$MNUTOOL[#,#]", Row::Position),
    ("$MNUTOOLNUM[#]", Row::Integer),
    ("$MOR.$SAFETY_STAT", Row::Integer),
    ("$MOR_GRP[#].$ROB_MOVE", Row::Boolean),
    ("$MOR_GRP[#].$SERVO_READY", Row::Boolean),
    ("$MOTYPE", Row::Integer),
    ("$NILPOS", Row::Position),
    ("$ORIENT_TYPE", Row::Integer),
    ("$PRO_CFG.$INS_PWR", Row::Real),
    ("$ROTSPEED", Row::Real),
    ("$SCAN_TIME", Row::Integer),
    ("$SCR_GRP[#].$SV_CODE_ID", Row::Text),
    ("$SPEED", Row::Real),
    ("$SPEEDLIM", Row::Real),
    ("$TERMTYPE", Row::Integer),
    ("$UALRM_MSG[#]", Row::Text),
    ("$UFRAME", Row::Position),
    ("$UTOOL", Row::Position),
    ("$WAITTMOUT", Row::Integer),
];

/// Type of the system variable with this pattern (`$MNUFRAME[#,#]`), if it is known.
pub(crate) fn type_of_pattern(pattern: &str) -> Option<Type> {
    TABLE
        .iter()
        .find(|(known, _)| *known == pattern)
        .map(|(_, row)| row.ty())
}

/// Type of the system variable at `path`, if it is known.
pub(crate) fn type_of_path(path: &SysPath) -> Option<Type> {
    type_of_pattern(&pattern(path))
}

/// A known system variable whose name is near, for a help line.
pub(crate) fn suggestion(pattern: &str) -> Option<&'static str> {
    let root = pattern.split(['.', '[']).next()?;
    let same_root = TABLE
        .iter()
        .find(|(known, _)| known.split(['.', '[']).next() == Some(root));
    same_root.map(|(known, _)| *known)
}

fn pattern(path: &SysPath) -> String {
    let mut pattern = String::new();
    for step in path.steps() {
        match step {
            Step::Name(name) => {
                if !pattern.is_empty() {
                    pattern.push('.');
                }
                pattern.push_str(name);
            }
            Step::Index(subscripts) => pattern.push_str(&subscript_pattern(subscripts.len())),
        }
    }
    pattern
}

/// `[#,#]` for two subscripts.
pub(crate) fn subscript_pattern(count: usize) -> String {
    format!("[{}]", vec!["#"; count].join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_finds_the_type_of_its_variable() {
        let path = SysPath::parse("$mnuframe[1, 8]").unwrap();
        assert_eq!(
            type_of_path(&path),
            Some(Type::Position(PositionKind::Position))
        );
        assert_eq!(type_of_path(&SysPath::parse("$NO_SUCH").unwrap()), None);
        assert_eq!(
            suggestion("$HOSTS_CFG[#].$PORT"),
            Some("$HOSTS_CFG[#].$MODE")
        );
    }
}
