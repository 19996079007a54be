//! Values that cross the boundary between the machine and its host.

use std::{fmt, sync::Arc};

use crate::position::{Config, JointPosition, Position, Xyzwpr, XyzwprExt};

/// A KAREL string: at most 254 bytes, any byte allowed, cheap to clone.
#[derive(Clone, Default, PartialEq, Eq, Hash)]
pub struct Text(Arc<Vec<u8>>);

impl Text {
    /// Takes over `bytes`; the length is the caller's business.
    #[must_use]
    pub fn new(bytes: Vec<u8>) -> Text {
        Text(Arc::new(bytes))
    }

    /// The bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    /// The text, one character for each byte (Latin-1).
    #[must_use]
    pub fn to_string_lossless(&self) -> String {
        self.0.iter().map(|byte| char::from(*byte)).collect()
    }

    /// Cuts the text on the right to at most `limit` bytes, in place when nobody else holds it.
    pub(crate) fn truncate(&mut self, limit: usize) {
        if self.0.len() > limit {
            Arc::make_mut(&mut self.0).truncate(limit);
        }
    }

    /// Appends `tail` and cuts the result to `limit` bytes.
    pub(crate) fn append(&mut self, tail: &[u8], limit: usize) {
        let bytes = Arc::make_mut(&mut self.0);
        bytes.extend_from_slice(tail);
        bytes.truncate(limit);
    }
}

impl From<&str> for Text {
    /// Takes the characters as Latin-1; a character above U+00FF becomes `?`.
    fn from(text: &str) -> Text {
        Text::new(
            text.chars()
                .map(|c| u8::try_from(c).unwrap_or(b'?'))
                .collect(),
        )
    }
}

impl From<&[u8]> for Text {
    fn from(bytes: &[u8]) -> Text {
        Text::new(bytes.to_vec())
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.to_string_lossless())
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.to_string_lossless(), f)
    }
}

/// An initialized value of a system variable or of a program's variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `INTEGER`, 32-bit signed.
    Integer(i32),
    /// `REAL`, 32-bit.
    Real(f32),
    /// `BOOLEAN`.
    Boolean(bool),
    /// `STRING`.
    String(Text),
    /// `CONFIG`.
    Config(Config),
    /// `XYZWPR`, millimeters and degrees.
    Xyzwpr(Xyzwpr),
    /// `XYZWPREXT`, millimeters and degrees.
    XyzwprExt(XyzwprExt),
    /// `POSITION`, millimeters and degrees.
    Position(Position),
    /// `JOINTPOS`, degrees, millimeters for linear axes.
    Joints(JointPosition),
}

impl Value {
    /// The value as a cartesian position with extended axes, if it is one of the three kinds.
    #[must_use]
    pub fn as_xyzwprext(&self) -> Option<XyzwprExt> {
        match self {
            Value::Xyzwpr(position) => Some((*position).into()),
            Value::XyzwprExt(position) => Some(*position),
            Value::Position(position) => Some((*position).into()),
            Value::Integer(_)
            | Value::Real(_)
            | Value::Boolean(_)
            | Value::String(_)
            | Value::Config(_)
            | Value::Joints(_) => None,
        }
    }
}

/// What is stored into a system variable: a value, or the state of having none.
#[derive(Clone, Debug, PartialEq)]
pub enum SysValue {
    /// An initialized value.
    Value(Value),
    /// The target becomes uninitialized (`SET_VAR` with an uninitialized argument).
    Uninit,
}

impl From<Value> for SysValue {
    fn from(value: Value) -> SysValue {
        SysValue::Value(value)
    }
}

/// INTEGER to REAL, rounded to the nearest `f32`.
#[expect(
    clippy::cast_precision_loss,
    reason = "a REAL has 24 bits; KAREL rounds here as well"
)]
pub(crate) fn real_of(integer: i32) -> f32 {
    integer as f32
}
