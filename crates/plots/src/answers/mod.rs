//! The answers of the API, drawn. The numbers are those of the answers; nothing is computed anew but the ellipsoid of
//! [`velocities`].

mod arm;
mod calibration;
mod ellipsoid;
mod motion;
mod rates;
mod reach;
mod route;
mod solid;
mod trajectory;
mod transfer;
mod wheels;

pub use arm::{Labeled, branches, posture};
pub use calibration::{Taught, TaughtBy, calibration};
pub use ellipsoid::velocities;
pub use motion::{velocity_motion, velocity_motion_joints};
pub use rates::rates;
pub use reach::reach;
pub use route::route;
pub use trajectory::{TrajectoryLook, joints_in_time, tool_in_space, tool_in_time};
pub use transfer::transfer;
pub use wheels::{Drive, DriveSample, wheels};

use api::PoseBody;

use crate::ticks::number;

/// Numbers for a title: to the thousandth, without needless zeros.
fn listed(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(|value| short(*value)).collect();
    texts.join(", ")
}

fn short(value: f64) -> String {
    number((value * 1000.0).round() / 1000.0)
}

/// A pose for a note.
fn pose_text(pose: &PoseBody) -> String {
    let place = listed(&[pose.x_mm, pose.y_mm, pose.z_mm]);
    let turn = listed(&[pose.w_deg, pose.p_deg, pose.r_deg]);
    format!("X, Y, Z = {place} mm; W, P, R = {turn}°")
}
