//! Registers, which KAREL programs share with TP programs and with the pendant: `R[n]`, `SR[n]`,
//! `PR[n]`.

use serde::{Deserialize, Serialize};

use crate::{
    position::{JointPosition, XyzwprExt},
    status::Status,
    types::MAX_STRING,
};

/// How many registers there are of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegisterCounts {
    /// `R[1]` to this.
    pub numbers: u16,
    /// `SR[1]` to this.
    pub strings: u16,
    /// `PR[1]` to this.
    pub positions: u16,
}

/// As many as a controller has when it is delivered.
impl Default for RegisterCounts {
    fn default() -> RegisterCounts {
        RegisterCounts {
            numbers: 200,
            strings: 25,
            positions: 100,
        }
    }
}

/// `R[n]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Number {
    /// `INTEGER`.
    Integer(i32),
    /// `REAL`.
    Real(f32),
}

/// `PR[n]` of motion group 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PositionRegister {
    /// Nothing was stored.
    #[default]
    Unset,
    /// A pose, in the frame of whoever uses it.
    Cartesian(XyzwprExt),
    /// Joints.
    Joints(JointPosition),
}

/// All registers of a controller. They keep their contents without power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Registers {
    numbers: Vec<Number>,
    strings: Vec<String>,
    positions: Vec<PositionRegister>,
}

impl Registers {
    /// Numbers are 0, strings are empty, positions are not set.
    #[must_use]
    pub fn new(counts: RegisterCounts) -> Registers {
        Registers {
            numbers: vec![Number::Integer(0); counts.numbers.into()],
            strings: vec![String::new(); counts.strings.into()],
            positions: vec![PositionRegister::Unset; counts.positions.into()],
        }
    }

    /// `R[n]`.
    ///
    /// # Errors
    /// [`Status::VARS_INDEX`] if there is no such register; also for the others.
    pub fn number(&self, n: i32) -> Result<Number, Status> {
        element(&self.numbers, n).copied()
    }

    /// Sets `R[n]`.
    ///
    /// # Errors
    /// No such register.
    pub fn set_number(&mut self, n: i32, value: Number) -> Result<(), Status> {
        set(&mut self.numbers, n, value)
    }

    /// `SR[n]`, one character for each byte.
    ///
    /// # Errors
    /// No such register.
    pub fn string(&self, n: i32) -> Result<&str, Status> {
        element(&self.strings, n).map(String::as_str)
    }

    /// Sets `SR[n]`.
    ///
    /// # Errors
    /// No such register; [`Status::INTP_ARGUMENT`] for more than 254 characters.
    pub fn set_string(&mut self, n: i32, value: String) -> Result<(), Status> {
        if value.chars().count() > MAX_STRING {
            return Err(Status::INTP_ARGUMENT);
        }
        set(&mut self.strings, n, value)
    }

    /// `PR[n]`.
    ///
    /// # Errors
    /// No such register.
    pub fn position(&self, n: i32) -> Result<&PositionRegister, Status> {
        element(&self.positions, n)
    }

    /// Sets `PR[n]`.
    ///
    /// # Errors
    /// No such register.
    pub fn set_position(&mut self, n: i32, value: PositionRegister) -> Result<(), Status> {
        set(&mut self.positions, n, value)
    }
}

impl Default for Registers {
    fn default() -> Registers {
        Registers::new(RegisterCounts::default())
    }
}

fn index(n: i32) -> Result<usize, Status> {
    let index = usize::try_from(n).ok().and_then(|n| n.checked_sub(1));
    index.ok_or(Status::VARS_INDEX)
}

fn element<T>(list: &[T], n: i32) -> Result<&T, Status> {
    list.get(index(n)?).ok_or(Status::VARS_INDEX)
}

fn set<T>(list: &mut [T], n: i32, value: T) -> Result<(), Status> {
    let slot = list.get_mut(index(n)?).ok_or(Status::VARS_INDEX)?;
    *slot = value;
    Ok(())
}
