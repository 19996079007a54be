//! An arm's body, as far as keep-out zones are concerned: the lines between its joints, thickened.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CT is the tool T in the cell C"
)]

use kinematics::{PendantJoints, Pose};
use nalgebra::{Matrix4, Point3};
use units::Radians;

use super::geometry::{Capsule, origin_of};
use super::model::Arm;

impl Arm {
    /// The tool center point in the cell frame, `X_CT`, at joint values.
    pub(crate) fn tip(&self, joints: &PendantJoints) -> Pose {
        self.X_CW * self.model.forward(joints) * self.tool.X_FT
    }

    /// `X_WF`, the flange in the arm's world, of the tool center point in the cell frame.
    pub(crate) fn flange_of(&self, X_CT: &Pose) -> Pose {
        self.X_CW.inverse() * *X_CT * self.tool.X_FT.inverse()
    }

    /// Upper arm, elbow, forearm, wrist and tool as capsules in the cell frame.
    ///
    /// The pedestal below the shoulder is not among them: it does not move. A gripped load is not either, unless the
    /// tool's radius counts it in.
    pub(crate) fn capsules(&self, joints: &PendantJoints) -> [Capsule; 5] {
        let chain = self.model.chain(joints).radians();
        let mut so_far = Matrix4::identity();
        let mut origins = [Point3::origin(); 6];
        for ((origin, link), q) in origins.iter_mut().zip(self.model.dh()).zip(chain) {
            so_far *= link.transform(Radians(q));
            let p = so_far.column(3);
            *origin = self.X_CW.isometry() * Point3::new(p.x, p.y, p.z);
        }
        let [shoulder, elbow, forearm, wrist, _, flange] = origins;
        let tip = origin_of(&self.tip(joints));
        let body = |from, to| Capsule {
            from,
            to,
            radius: self.body_radius.0,
        };
        [
            body(shoulder, elbow),
            body(elbow, forearm),
            body(forearm, wrist),
            body(wrist, flange),
            Capsule {
                from: flange,
                to: tip,
                radius: self.tool.radius.0,
            },
        ]
    }
}
