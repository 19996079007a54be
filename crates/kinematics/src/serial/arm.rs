//! The model of an arm of any joints.
#![expect(
    clippy::indexing_slicing,
    reason = "vectors and matrices of nalgebra, indexed within the shape they were made with"
)]

use std::sync::LazyLock;

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Rotation3, Vector3};

use crate::capsule::Capsule;
use crate::dynamics::LinkInertia;
use crate::frames::Frames;
use crate::pose::Pose;
use crate::serial::error::{OutsideRange, SerialError};
use crate::serial::file::{self, SerialModelError};
use crate::serial::values::JointValues;

/// A value of a joint beyond this many degrees or millimeters is no joint value.
pub(crate) const MAX_VALUE: f64 = 1e6;
/// A joint exactly at its limit is inside: unit conversions may move it by this much (radians or
/// millimeters).
pub(crate) const AT_LIMIT: f64 = 1e-9;

/// What a joint does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// It turns: theta is the variable, values in radians (degrees at the edge).
    Revolute,
    /// It slides: d is the variable, values in millimeters.
    Prismatic,
}

impl JointKind {
    /// The unit at the edge.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            JointKind::Revolute => "deg",
            JointKind::Prismatic => "mm",
        }
    }

    /// From the unit of the edge to the one inside.
    #[must_use]
    pub fn inside(self, value: f64) -> f64 {
        match self {
            JointKind::Revolute => value.to_radians(),
            JointKind::Prismatic => value,
        }
    }

    /// From the unit inside to the one of the edge.
    #[must_use]
    pub fn shown(self, value: f64) -> f64 {
        match self {
            JointKind::Revolute => value.to_degrees(),
            JointKind::Prismatic => value,
        }
    }
}

/// A joint with its link, in the standard convention; lengths in millimeters, angles in radians,
/// ranges, speeds and accelerations in the joint's own unit (radians or millimeters).
#[derive(Clone, Debug, PartialEq)]
pub struct SerialJoint {
    /// `J1`.
    pub name: String,
    /// What it does.
    pub kind: JointKind,
    /// Along the common normal.
    pub a: f64,
    /// The twist about the common normal.
    pub alpha: f64,
    /// Along the axis; for a prismatic joint the part that does not change (0 unless the
    /// conversion from the modified convention left one).
    pub d: f64,
    /// About the axis; for a revolute joint 0, the zero shift is in `offset`.
    pub theta: f64,
    /// 1 or -1: the direction in which the display counts.
    pub sign: f64,
    /// The chain's value where the display shows 0.
    pub offset: f64,
    /// Other joints whose displayed values add to this one's: index and factor.
    pub couplings: Vec<(usize, f64)>,
    /// The lowest legal value.
    pub min: f64,
    /// The highest legal value.
    pub max: f64,
    /// The highest speed.
    pub max_speed: f64,
    /// The highest acceleration.
    pub max_acceleration: f64,
    /// The highest jerk.
    pub max_jerk: f64,
    /// Where the joint stands at home.
    pub home: f64,
    /// What the link weighs, in its frame (behind the joint, in the standard convention); none if
    /// the model file does not say.
    pub inertia: Option<LinkInertia>,
}

impl SerialJoint {
    /// Is the value inside the range, apart from rounding?
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        value >= self.min - AT_LIMIT && value <= self.max + AT_LIMIT
    }

    /// The report of a value outside the range.
    #[must_use]
    pub fn outside(&self, value: f64) -> OutsideRange {
        OutsideRange {
            joint: self.name.clone(),
            value: self.kind.shown(value),
            min: self.kind.shown(self.min),
            max: self.kind.shown(self.max),
            kind: self.kind,
        }
    }
}

/// An arm of any number of revolute and prismatic joints in a row.
#[derive(Clone, Debug)]
pub struct SerialArm {
    pub(crate) name: String,
    pub(crate) manufacturer: String,
    pub(crate) joints: Vec<SerialJoint>,
    /// `X_W0`: where the chain begins.
    pub(crate) base: Isometry3<f64>,
    /// `X_nF`: from the last frame to the flange.
    pub(crate) flange: Isometry3<f64>,
    /// What of each link does not move: `Tz(d) Tx(a) Rx(alpha)` of a revolute joint, with
    /// `Rz(theta)` of a prismatic one.
    pub(crate) fixed: Vec<(Matrix3<f64>, Vector3<f64>)>,
    /// Chain values from displayed ones: `q = coupling * J + offsets`.
    pub(crate) coupling: DMatrix<f64>,
    pub(crate) offsets: DVector<f64>,
    /// The sum of all link lengths and strokes, in millimeters: nothing of the arm is farther from
    /// its base.
    pub(crate) span: f64,
    pub(crate) capsules: Vec<Capsule>,
}

const BUILTIN: [(&str, &str); 6] = [
    ("fanuc-m20ia", include_str!("../../models/fanuc_m20ia.toml")),
    (
        "fanuc-m20ia-machine",
        include_str!("../../models/fanuc_m20ia_machine.toml"),
    ),
    ("textbook-6r", include_str!("../../models/textbook_6r.toml")),
    ("five-link", include_str!("../../models/five_link.toml")),
    ("scara", include_str!("../../models/scara.toml")),
    ("seven-joint", include_str!("../../models/seven_joint.toml")),
];

static CATALOG: LazyLock<Vec<SerialArm>> = LazyLock::new(|| {
    let read = |(_, text): &(&str, &str)| {
        SerialArm::from_toml(text).expect("the built-in model files are valid: a test reads them")
    };
    BUILTIN.iter().map(read).collect()
});

impl SerialArm {
    /// Reads a model file.
    ///
    /// # Errors
    /// Names the joint, the key, the value and the limit of what is wrong.
    pub fn from_toml(text: &str) -> Result<SerialArm, SerialModelError> {
        file::read(text)
    }

    /// An arm of the catalogue.
    #[must_use]
    pub fn builtin(name: &str) -> Option<&'static SerialArm> {
        CATALOG.iter().find(|arm| arm.name == name)
    }

    /// The arms of the catalogue.
    #[must_use]
    pub fn catalog() -> &'static [SerialArm] {
        &CATALOG
    }

    /// The arm of joints in the standard convention between `base` (`X_W0`) and `flange` (`X_nF`).
    pub(crate) fn from_parts(
        name: String,
        manufacturer: String,
        joints: Vec<SerialJoint>,
        base: Isometry3<f64>,
        flange: Isometry3<f64>,
    ) -> SerialArm {
        let n = joints.len();
        let mut coupling = DMatrix::zeros(n, n);
        let mut offsets = DVector::zeros(n);
        for (i, joint) in joints.iter().enumerate() {
            coupling[(i, i)] = joint.sign;
            offsets[i] = joint.offset;
            for (other, factor) in &joint.couplings {
                coupling[(i, *other)] += factor;
            }
        }
        let fixed = joints
            .iter()
            .map(|joint| {
                let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), joint.theta);
                let twist = exact_twist(joint.alpha);
                (
                    turn.matrix() * twist,
                    turn * Vector3::new(joint.a, 0.0, joint.d),
                )
            })
            .collect();
        let stroke = |joint: &SerialJoint| match joint.kind {
            JointKind::Revolute => 0.0,
            JointKind::Prismatic => joint.min.abs().max(joint.max.abs()) + joint.offset.abs(),
        };
        let span = joints
            .iter()
            .map(|joint| joint.a.hypot(joint.d) + stroke(joint))
            .sum::<f64>()
            + flange.translation.vector.norm();
        SerialArm {
            name,
            manufacturer,
            joints,
            base,
            flange,
            fixed,
            coupling,
            offsets,
            span,
            capsules: Vec::new(),
        }
    }

    /// The same arm with links that weigh what somebody measured, base first, each in its link's
    /// frame in the standard convention.
    ///
    /// # Errors
    /// They are not as many as the arm has joints.
    pub fn with_inertias(&self, inertias: &[LinkInertia]) -> Result<SerialArm, SerialError> {
        self.check_count(inertias.len())?;
        let mut arm = self.clone();
        for (joint, inertia) in arm.joints.iter_mut().zip(inertias) {
            joint.inertia = Some(*inertia);
        }
        Ok(arm)
    }

    pub(crate) fn with_capsules(self, capsules: Vec<Capsule>) -> SerialArm {
        SerialArm { capsules, ..self }
    }

    /// As in the file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Who builds it.
    #[must_use]
    pub fn manufacturer(&self) -> &str {
        &self.manufacturer
    }

    /// The joints, base first, in the standard convention whatever the file's was.
    #[must_use]
    pub fn joint_list(&self) -> &[SerialJoint] {
        &self.joints
    }

    /// How many joints there are.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        self.joints.len()
    }

    /// The sum of all link lengths and strokes in millimeters: the flange is never farther from the
    /// base. It is also the length by which translations and rotations are made comparable.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.span
    }

    /// The capsules the arm is made of; none if the model file has none.
    #[must_use]
    pub fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }

    /// `X_W0`: where the chain begins in the world.
    #[must_use]
    pub fn base(&self) -> Pose {
        Pose::from_parts(self.base.translation.vector, self.base.rotation)
    }

    /// `X_nF`: from the last frame of the table to the flange.
    #[must_use]
    pub fn flange(&self) -> Pose {
        Pose::from_parts(self.flange.translation.vector, self.flange.rotation)
    }

    /// The same arm seen from a user frame and with a tool: its "world" is the user frame, its
    /// "flange" the tool, so that every pose is `X_UT` and every Jacobian the tool's.
    #[must_use]
    pub fn with_frames(&self, frames: &Frames) -> SerialArm {
        SerialArm::from_parts(
            self.name.clone(),
            self.manufacturer.clone(),
            self.joints.clone(),
            frames.user_frame.isometry().inverse() * self.base,
            self.flange * frames.tool.isometry(),
        )
    }

    /// Joint values from degrees and millimeters, base first. Ranges are not checked; see
    /// [`Self::check_ranges`].
    ///
    /// # Errors
    /// The number of values is not the number of joints, or one is not a finite number.
    pub fn joints(&self, shown: &[f64]) -> Result<JointValues, SerialError> {
        self.check_count(shown.len())?;
        for (joint, &value) in self.joints.iter().zip(shown) {
            check_value(joint, value)?;
        }
        let inside = self.joints.iter().zip(shown);
        Ok(self.values(inside.map(|(joint, value)| joint.kind.inside(*value))))
    }

    /// Joint values from radians and millimeters, base first.
    ///
    /// # Errors
    /// As [`Self::joints`].
    pub fn joints_from_radians(&self, values: &[f64]) -> Result<JointValues, SerialError> {
        self.check_count(values.len())?;
        for (joint, &value) in self.joints.iter().zip(values) {
            check_value(joint, joint.kind.shown(value))?;
        }
        Ok(self.values(values.iter().copied()))
    }

    pub(crate) fn values(&self, values: impl Iterator<Item = f64>) -> JointValues {
        JointValues(DVector::from_iterator(self.joints.len(), values))
    }

    /// Degrees and millimeters, base first, as the display shows them.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn shown(&self, joints: &JointValues) -> Result<Vec<f64>, SerialError> {
        self.check_count(joints.len())?;
        let pairs = self.joints.iter().zip(joints.as_slice());
        Ok(pairs.map(|(joint, v)| joint.kind.shown(*v)).collect())
    }

    /// Where the arm stands when nobody said otherwise.
    #[must_use]
    pub fn home(&self) -> JointValues {
        self.values(self.joints.iter().map(|joint| joint.home))
    }

    /// Joint values inside the ranges: of each joint, by its place in the row, the `part` (0 to 1) of its range.
    pub fn spread_over_ranges(&self, mut part: impl FnMut(usize) -> f64) -> JointValues {
        let joints = self.joints.iter().enumerate();
        self.values(joints.map(|(index, joint)| {
            let part = part(index).clamp(0.0, 1.0);
            joint.min + part * (joint.max - joint.min)
        }))
    }

    /// The values of the Denavit-Hartenberg table's variables at these displayed values: radians and millimeters.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn chain_values(&self, joints: &JointValues) -> Result<Vec<f64>, SerialError> {
        self.check_count(joints.len())?;
        Ok(self.chain(joints).as_slice().to_vec())
    }

    /// The values of the Denavit-Hartenberg table at these displayed values.
    pub(crate) fn chain(&self, joints: &JointValues) -> DVector<f64> {
        &self.coupling * &joints.0 + &self.offsets
    }

    /// Every joint outside its range, base first; none means that all are inside.
    ///
    /// # Errors
    /// The values are another arm's.
    pub fn check_ranges(&self, joints: &JointValues) -> Result<Vec<OutsideRange>, SerialError> {
        self.check_count(joints.len())?;
        Ok(self.outside(joints))
    }

    pub(crate) fn outside(&self, joints: &JointValues) -> Vec<OutsideRange> {
        let pairs = self.joints.iter().zip(joints.as_slice());
        pairs
            .filter(|(joint, value)| !joint.contains(**value))
            .map(|(joint, value)| joint.outside(*value))
            .collect()
    }

    pub(crate) fn check_count(&self, given: usize) -> Result<(), SerialError> {
        if given == self.joints.len() {
            Ok(())
        } else {
            Err(SerialError::JointCount {
                arm: self.name.clone(),
                wanted: self.joints.len(),
                given,
            })
        }
    }
}

fn check_value(joint: &SerialJoint, value: f64) -> Result<(), SerialError> {
    if value.is_nan() || value.abs() > MAX_VALUE {
        return Err(SerialError::NotAValue {
            joint: joint.name.clone(),
            value,
            max: MAX_VALUE,
            kind: joint.kind,
        });
    }
    Ok(())
}

/// `Rx(alpha)`, with the right angles exact: a table says -90, not -1.5707963267948966.
fn exact_twist(alpha: f64) -> Matrix3<f64> {
    let (mut s, mut c) = alpha.sin_cos();
    for value in [&mut s, &mut c] {
        if value.abs() < 1e-15 || (value.abs() - 1.0).abs() < 1e-15 {
            *value = value.round();
        }
    }
    Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}
