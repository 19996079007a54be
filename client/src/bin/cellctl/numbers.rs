//! Numbers from the command line: finite, or a usage error.

use api::{JointsBody, PoseBody};
use clap::Args;

/// A finite number.
///
/// # Errors
/// A sentence for clap to show if `text` is no number, or one that no coordinate can be.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text
        .parse()
        .map_err(|_| "not a number; write it like -180 or 0.5".to_owned())?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err("not a finite number".to_owned())
    }
}

/// A pose as six arguments in a row.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct PoseArgs {
    /// X in millimeters.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    x: f64,
    /// Y in millimeters.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    y: f64,
    /// Z in millimeters.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    z: f64,
    /// W, about the fixed X axis, in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    w: f64,
    /// P, about the fixed Y axis, in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    p: f64,
    /// R, about the fixed Z axis, in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    r: f64,
}

impl From<PoseArgs> for PoseBody {
    fn from(PoseArgs { x, y, z, w, p, r }: PoseArgs) -> Self {
        [x, y, z, w, p, r].into()
    }
}

/// Joint values as six arguments in a row.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct JointArgs {
    /// J1 in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    j1: f64,
    /// J2 in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    j2: f64,
    /// J3 in degrees, against the horizontal, as on the pendant.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    j3: f64,
    /// J4 in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    j4: f64,
    /// J5 in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    j5: f64,
    /// J6 in degrees.
    #[arg(allow_hyphen_values = true, value_parser = finite)]
    j6: f64,
}

impl From<JointArgs> for JointsBody {
    fn from(
        JointArgs {
            j1,
            j2,
            j3,
            j4,
            j5,
            j6,
        }: JointArgs,
    ) -> Self {
        [j1, j2, j3, j4, j5, j6].into()
    }
}

/// The six values of an option such as `--joints`; clap has counted them.
pub(crate) fn six(values: &[f64]) -> Option<JointsBody> {
    <[f64; 6]>::try_from(values).ok().map(JointsBody::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_numbers_pass() {
        assert_eq!(finite("-180"), Ok(-180.0));
        assert_eq!(finite(".5"), Ok(0.5));
        for text in [
            "nan", "NaN", "inf", "-inf", "infinity", "1e999", "", "1,5", "0x10", "12mm",
        ] {
            assert!(finite(text).is_err(), "{text} passed");
        }
    }
}
