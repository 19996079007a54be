//! Values as the control interface writes them, and what can be wrong with them.

use karel::{Config, JointPosition, Number, Position, PositionRegister, Text, Value, XyzwprExt};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::programs::shown;
use crate::ports::SetInputError;

/// A value of a variable or a register. Lengths are millimeters, angles degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(
    untagged,
    expecting = "it must be true or false, a number, a text, {x_mm, y_mm, z_mm, w_deg, p_deg, r_deg, configuration?} or \
                 {joints_deg: [1 to 9 numbers]}"
)]
pub enum ValueBody {
    /// `BOOLEAN`.
    Boolean(bool),
    /// `INTEGER`.
    Integer(i32),
    /// `REAL`.
    Real(f32),
    /// `STRING`, one character for each byte; or `CONFIG`, such as `N U T, 0, 0, 0`.
    Text(String),
    /// A cartesian position.
    Pose(PoseValue),
    /// Joints.
    Joints(JointsValue),
}

/// A cartesian position with its configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "the six components")]
pub struct PoseValue {
    pub x_mm: f32,
    pub y_mm: f32,
    pub z_mm: f32,
    pub w_deg: f32,
    pub p_deg: f32,
    pub r_deg: f32,
    /// Such as `N U T, 0, 0, 0`, which it is if it is missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
}

/// Joint angles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct JointsValue {
    /// One to nine axes.
    #[schema(min_items = 1, max_items = 9)]
    pub joints_deg: Vec<f32>,
}

/// A variable, or a part of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct VariableItem {
    /// Its path from the program.
    pub path: String,
    /// Its type; unknown for system variables.
    #[serde(rename = "type")]
    pub type_name: Option<String>,
    /// Its value, `null` if it is uninitialized.
    pub value: Option<ValueBody>,
}

/// A register that was used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegisterView {
    /// `R[3]`, `PR[1]`, `SR[2]` or `F[5]`.
    pub register: String,
    /// Its value, `null` for a position register that was never set.
    pub value: Option<ValueBody>,
}

/// A port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct IoView {
    /// `DIN[3]`.
    pub port: String,
    /// Switches are 0 or 1.
    pub value: i32,
    /// Whether programs see a simulated value.
    pub simulated: bool,
}

/// Why something cannot be read or set; nothing has changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DataError {
    /// No such item.
    #[error("there is no {what}: {reason}")]
    Missing {
        /// The item.
        what: String,
        /// What is known instead.
        reason: String,
    },
    /// A value that it cannot have.
    #[error("{what} cannot be {value}: {reason}")]
    Value {
        /// The item.
        what: String,
        /// What was given.
        value: String,
        /// What it can be.
        reason: String,
    },
    /// Text that is no path or register.
    #[error("{text:?} is no {wanted}: {reason}")]
    Syntax {
        /// What was given.
        text: String,
        /// What it should be.
        wanted: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// An input that cannot be set.
    #[error(transparent)]
    Input(#[from] SetInputError),
    /// The controller stopped.
    #[error(transparent)]
    Stopped(#[from] crate::error::ControllerStopped),
}

/// A value from the text of a command line.
///
/// # Errors
/// A position that cannot be read.
pub fn value_of_text(item: &str, text: &str) -> Result<Option<ValueBody>, DataError> {
    let text = text.trim();
    match text.to_ascii_uppercase().as_str() {
        "ON" => return Ok(Some(ValueBody::Boolean(true))),
        "OFF" => return Ok(Some(ValueBody::Boolean(false))),
        _ => {}
    }
    match serde_json::from_str::<Option<ValueBody>>(text) {
        Ok(value) => Ok(value),
        Err(error) if text.starts_with(['{', '"']) => Err(DataError::Value {
            what: shown(item),
            value: shown(text),
            reason: format!("it cannot be read: {error}"),
        }),
        Err(_) => Ok(Some(ValueBody::Text(text.to_owned()))),
    }
}

pub(super) fn in_words(value: Option<&ValueBody>) -> String {
    let text = serde_json::to_string(&value).unwrap_or_default();
    text.chars().take(80).collect()
}

/// The values that a body can mean: an integer may be a REAL, and text a CONFIG.
pub(super) fn candidates(
    what: &str,
    body: Option<&ValueBody>,
) -> Result<Vec<Option<Value>>, DataError> {
    let Some(body) = body else {
        return Ok(vec![None]);
    };
    let mut list = vec![Some(value_of(what, body)?)];
    match body {
        #[expect(
            clippy::cast_precision_loss,
            reason = "KAREL's own INTEGER to REAL conversion"
        )]
        ValueBody::Integer(value) => list.push(Some(Value::Real(*value as f32))),
        ValueBody::Text(text) => {
            if let Some(config) = Config::parse(text) {
                list.push(Some(Value::Config(config)));
            }
        }
        ValueBody::Boolean(_) | ValueBody::Real(_) | ValueBody::Pose(_) | ValueBody::Joints(_) => {}
    }
    Ok(list)
}

pub(super) fn value_of(what: &str, body: &ValueBody) -> Result<Value, DataError> {
    let wrong = |reason: &str| DataError::Value {
        what: shown(what),
        value: in_words(Some(body)),
        reason: reason.to_owned(),
    };
    let finite = |value: &f32| value.is_finite();
    Ok(match body {
        ValueBody::Boolean(on) => Value::Boolean(*on),
        ValueBody::Integer(value) => Value::Integer(*value),
        ValueBody::Real(value) if finite(value) => Value::Real(*value),
        ValueBody::Real(_) => return Err(wrong("a REAL is finite, up to 3.4e38")),
        ValueBody::Text(text) => {
            if text.chars().any(|c| u32::from(c) > 255) {
                return Err(wrong("a string holds Latin-1 characters"));
            }
            if text.chars().count() > 254 {
                return Err(wrong("a string holds at most 254 characters"));
            }
            Value::String(Text::from(text.as_str()))
        }
        ValueBody::Pose(pose) => {
            let config = match &pose.configuration {
                None => Config::default(),
                Some(text) => Config::parse(text)
                    .ok_or_else(|| wrong("the configuration is written as N U T, 0, 0, 0"))?,
            };
            let all = [
                pose.x_mm, pose.y_mm, pose.z_mm, pose.w_deg, pose.p_deg, pose.r_deg,
            ];
            if !all.iter().all(finite) {
                return Err(wrong("its components are finite"));
            }
            let [x, y, z, w, p, r] = all;
            Value::Position(Position {
                x,
                y,
                z,
                w,
                p,
                r,
                config,
            })
        }
        ValueBody::Joints(JointsValue { joints_deg }) => {
            if !(1..=9).contains(&joints_deg.len()) {
                return Err(wrong("there are 1 to 9 joints"));
            }
            if !joints_deg.iter().all(finite) {
                return Err(wrong("its joints are finite"));
            }
            let axes = joints_deg.clone();
            Value::Joints(JointPosition { axes })
        }
    })
}

impl From<&Value> for ValueBody {
    fn from(value: &Value) -> Self {
        match value {
            Value::Integer(value) => Self::Integer(*value),
            Value::Real(value) => Self::Real(*value),
            Value::Boolean(on) => Self::Boolean(*on),
            Value::String(text) => Self::Text(text.to_string_lossless()),
            Value::Config(config) => Self::Text(config.to_string()),
            Value::Joints(joints) => Self::Joints(JointsValue {
                joints_deg: joints.axes.clone(),
            }),
            Value::Xyzwpr(pose) => pose_body(&(*pose).into()),
            Value::XyzwprExt(pose) => pose_body(pose),
            Value::Position(pose) => pose_body(&(*pose).into()),
        }
    }
}

fn pose_body(pose: &XyzwprExt) -> ValueBody {
    ValueBody::Pose(PoseValue {
        x_mm: pose.x,
        y_mm: pose.y,
        z_mm: pose.z,
        w_deg: pose.w,
        p_deg: pose.p,
        r_deg: pose.r,
        configuration: Some(pose.config.to_string()),
    })
}

pub(super) fn number_body(number: Number) -> ValueBody {
    match number {
        Number::Integer(value) => ValueBody::Integer(value),
        Number::Real(value) => ValueBody::Real(value),
    }
}

pub(super) fn position_body(position: &PositionRegister) -> Option<ValueBody> {
    match position {
        PositionRegister::Unset => None,
        PositionRegister::Cartesian(pose) => Some(pose_body(pose)),
        PositionRegister::Joints(joints) => Some(ValueBody::Joints(JointsValue {
            joints_deg: joints.axes.clone(),
        })),
    }
}
