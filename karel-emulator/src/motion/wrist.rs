//! `Wjnt`: the tool stays on its way, the wrist goes as in a joint motion, so its singularity does not matter.

use karel::Status;
use kinematics::{ArmModel, Frames, PendantJoints, Pose};

use super::planner::Refusal;

/// Steps of Newton's method; from one sample to the next it needs three.
const MOST_STEPS: u32 = 20;
/// How near the tool has to come, mm.
const NEAR: f64 = 1e-7;
/// Degrees by which an axis is turned to see what that does.
const NUDGE: f64 = 1e-4;

pub(super) struct WristJoint<'a> {
    pub(super) model: &'a ArmModel,
    pub(super) frames: &'a Frames,
    /// Joints at the start and at the end.
    pub(super) ends: &'a (PendantJoints, PendantJoints),
}

impl WristJoint<'_> {
    /// The joints with the wrist at this share of its way, the tool where it is in `tcp`, and the first three axes near
    /// those `before`.
    ///
    /// ASSUMPTION: only the place of the tool is kept, its orientation is what the wrist makes of it.
    pub(super) fn at(
        &self,
        tcp: &Pose,
        share: f64,
        before: &PendantJoints,
    ) -> Result<PendantJoints, Refusal> {
        let (from, to) = self.ends;
        if share >= 1.0 {
            return Ok(*to);
        }
        let [j1, j2, j3, ..] = before.degrees();
        let ([.., a4, a5, a6], [.., b4, b5, b6]) = (from.degrees(), to.degrees());
        let wrist = [(a4, b4), (a5, b5), (a6, b6)].map(|(a, b)| a + (b - a) * share);
        let wanted: [f64; 3] = tcp.isometry().translation.vector.into();
        let mut arm = [j1, j2, j3];
        for _ in 0..MOST_STEPS {
            let here = self.place(arm, wrist);
            let error = minus(wanted, here);
            if dot(error, error) < NEAR * NEAR {
                let joints = PendantJoints::from_degrees(whole(arm, wrist));
                self.model.check_limits(&joints).map_err(|violations| {
                    let text = format!("Limit error on the way: {violations}");
                    Refusal::new(Status::MOTN_LIMIT, text)
                })?;
                return Ok(joints);
            }
            let [a1, a2, a3] = arm;
            let column = |nudged: [f64; 3]| {
                minus(self.place(nudged, wrist), here).map(|change| change / NUDGE)
            };
            let a = column([a1 + NUDGE, a2, a3]);
            let b = column([a1, a2 + NUDGE, a3]);
            let c = column([a1, a2, a3 + NUDGE]);
            let volume = dot(a, cross(b, c));
            if volume.abs() < 1e-9 {
                break;
            }
            arm = [
                a1 + dot(error, cross(b, c)) / volume,
                a2 + dot(error, cross(c, a)) / volume,
                a3 + dot(error, cross(a, b)) / volume,
            ];
        }
        let text = "Position not reachable: no place of the arm keeps the tool on its way (Wjnt)";
        Err(Refusal::new(Status::MOTN_UNREACHABLE, text))
    }

    /// Where the tool is in the user frame, mm.
    fn place(&self, arm: [f64; 3], wrist: [f64; 3]) -> [f64; 3] {
        let joints = PendantJoints::from_degrees(whole(arm, wrist));
        let tcp = self.frames.tcp_in_user_frame(&self.model.forward(&joints));
        tcp.isometry().translation.vector.into()
    }
}

fn whole([a, b, c]: [f64; 3], [d, e, f]: [f64; 3]) -> [f64; 6] {
    [a, b, c, d, e, f]
}

fn minus([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

fn dot([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}
