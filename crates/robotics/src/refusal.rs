//! Why a question was not answered.

use std::fmt;

use planning::BrokenOff;

/// What kind of refusal it is.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum RefusalKind {
    /// There is no such arm model.
    UnknownModel,
    /// An item of the question is out of its range, of the wrong length, or does not fit the others.
    Invalid,
    /// The arm does not reach what was asked for.
    OutOfReach,
    /// A joint would be beyond its range.
    JointLimit,
    /// The arm cannot do it at a singular posture.
    Singular,
    /// There is no way, or none was found within what was allowed.
    NoWay,
    /// Nobody waited for the answer any more.
    BrokenOff,
}

/// Why a question was not answered: the item, its value, its limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// What kind it is.
    pub kind: RefusalKind,
    /// The item's path in the body, such as `poses[3].x_mm`; empty if it is about the question as a whole.
    pub path: String,
    /// What is wrong with it, with value and limit.
    pub detail: String,
    /// The value, in the item's own unit, if it is one number.
    pub value: Option<f64>,
    /// The smallest legal value.
    pub min: Option<f64>,
    /// The largest legal value.
    pub max: Option<f64>,
}

impl std::error::Error for Refusal {}

/// `poses[3].x_mm: x is 2000000 mm; it must be a number from -1000000 mm to 1000000 mm`
impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        f.write_str(&self.detail)
    }
}

impl Refusal {
    pub(crate) fn new(
        kind: RefusalKind,
        path: impl Into<String>,
        detail: impl fmt::Display,
    ) -> Self {
        Self {
            kind,
            path: path.into(),
            detail: detail.to_string(),
            value: None,
            min: None,
            max: None,
        }
    }

    pub(crate) fn invalid(path: impl Into<String>, detail: impl fmt::Display) -> Self {
        Self::new(RefusalKind::Invalid, path, detail)
    }

    /// Of a number that is not from `min` to `max`.
    pub(crate) fn out_of_range(
        path: impl Into<String>,
        value: f64,
        [min, max]: [f64; 2],
        unit: &str,
    ) -> Self {
        let space = if unit.is_empty() { "" } else { " " };
        let detail =
            format!("it is {value}{space}{unit}; it must be from {min} to {max}{space}{unit}");
        Self {
            value: Some(value),
            min: Some(min),
            max: Some(max),
            ..Self::invalid(path, detail)
        }
    }

    pub(crate) fn broken_off(error: BrokenOff) -> Self {
        Self::new(RefusalKind::BrokenOff, "", error)
    }

    /// As [`Self::out_of_range`], of an item that an inner check named.
    pub(crate) fn with_value(mut self, value: f64) -> Self {
        self.value = Some(value);
        self
    }
}

/// The number, if it is from `min` to `max`.
pub(crate) fn within(
    path: &str,
    value: f64,
    [min, max]: [f64; 2],
    unit: &str,
) -> Result<f64, Refusal> {
    // A NaN is in no range.
    if (min..=max).contains(&value) {
        return Ok(value);
    }
    Err(Refusal::out_of_range(path, value, [min, max], unit))
}

/// The number, or what it is where nobody says; if it is from `min` to `max`.
pub(crate) fn within_or(
    path: &str,
    value: Option<f64>,
    absent: f64,
    range: [f64; 2],
    unit: &str,
) -> Result<f64, Refusal> {
    within(path, value.unwrap_or(absent), range, unit)
}

/// A count, or what it is where nobody says; if it is from `min` to `max`.
pub(crate) fn count_or(
    path: &str,
    value: Option<u32>,
    absent: u32,
    [min, max]: [u32; 2],
) -> Result<u32, Refusal> {
    let value = value.unwrap_or(absent);
    let _ = within(path, f64::from(value), [f64::from(min), f64::from(max)], "")?;
    Ok(value)
}

/// Is the list as long as it may be?
pub(crate) fn length(
    path: &str,
    given: usize,
    [min, max]: [usize; 2],
    what: &str,
) -> Result<(), Refusal> {
    if (min..=max).contains(&given) {
        return Ok(());
    }
    let wanted = if min == max {
        format!("it must be {min}")
    } else {
        format!("it must be {min} to {max}")
    };
    Err(Refusal {
        value: number(given),
        min: number(min),
        max: number(max),
        ..Refusal::invalid(path, format!("{given} {what} were given; {wanted}"))
    })
}

/// A count as a number.
pub(crate) fn number(count: usize) -> Option<f64> {
    u32::try_from(count).ok().map(f64::from)
}
