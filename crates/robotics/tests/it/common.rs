//! What the tests share.

use api::PoseBody;
use api::arms::{ArmForwardBody, ArmFrames};

pub(crate) fn pose(numbers: [f64; 6]) -> PoseBody {
    numbers.into()
}

pub(crate) fn forward_of(joints: &[f64]) -> ArmForwardBody {
    ArmForwardBody {
        joints_deg_mm: joints.to_vec(),
        frames: ArmFrames::default(),
    }
}

/// Are the numbers the wanted ones, within `by`?
#[track_caller]
pub(crate) fn assert_near<const N: usize>(is: &[f64], wanted: [f64; N], by: f64) {
    assert_eq!(is.len(), N, "{is:?}");
    for (number, expected) in is.iter().zip(wanted) {
        let close = (number - expected).abs() <= by;
        assert!(close, "{is:?} instead of {wanted:?}");
    }
}
