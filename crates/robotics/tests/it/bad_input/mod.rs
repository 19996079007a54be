//! Every question with an item that is none: the path of the item, and what is wrong with it.

mod arms;
mod planning;

use robotics::Refusal;

const M20: &str = "fanuc-m20ia";
const HOME: [f64; 6] = [0.0, 0.0, 0.0, 0.0, -90.0, 0.0];
const NAN: f64 = f64::NAN;

/// Every refusal names the path, and says this.
#[track_caller]
fn assert_refused<T: std::fmt::Debug>(answer: Result<T, Refusal>, path: &str, says: &str) {
    let Err(refused) = answer else {
        panic!("it was taken: {answer:?}");
    };
    assert_eq!(refused.path, path, "{refused}");
    assert!(refused.detail.contains(says), "{refused}");
}
