//! Arm models.

use std::sync::LazyLock;

use units::{DegPerSec, DegPerSec2, DegPerSec3, Degrees, Millimeters};

use crate::branches::{Branches, Solution};
use crate::capsule::Capsule;
use crate::configuration::{Configuration, Elbow, Flip, Front, turns_of};
use crate::coupling::Coupling;
use crate::dh::DhLink;
use crate::forward;
use crate::geometry::Geometry;
use crate::ik_error::IkError;
use crate::inverse;
use crate::joints::{Axis, ChainJoints, PendantJoints};
use crate::lanes::{Instructions, Level};
use crate::limits::{LimitViolations, Limits};
use crate::model_file::{self, ModelError};
use crate::pose::Pose;
use crate::posture::Posture;
use crate::select::{self, Seed};
use crate::singularity::Singularity;

static FANUC_M20IA: LazyLock<ArmModel> = LazyLock::new(|| {
    ArmModel::from_toml(include_str!("../models/fanuc_m20ia.toml"))
        .expect("the built-in model files are valid: a test reads them")
});

static FANUC_M20IA_MACHINE: LazyLock<ArmModel> = LazyLock::new(|| {
    ArmModel::from_toml(include_str!("../models/fanuc_m20ia_machine.toml"))
        .expect("the built-in model files are valid: a test reads them")
});

/// A six-axis arm with an ortho-parallel basis and a spherical wrist, out of a model file.
#[derive(Clone, Debug)]
pub struct ArmModel {
    pub(crate) name: String,
    pub(crate) manufacturer: String,
    pub(crate) dh: [DhLink; 6],
    pub(crate) geometry: Geometry,
    pub(crate) coupling: Coupling,
    /// Which sign of J5 is `N`.
    pub(crate) no_flip_sign: f64,
    pub(crate) limits: [Limits; 6],
    pub(crate) max_speeds: [DegPerSec; 6],
    pub(crate) max_accelerations: [DegPerSec2; 6],
    pub(crate) max_jerks: [DegPerSec3; 6],
    pub(crate) home: PendantJoints,
    /// The angles, in radians, about which a solution's joints are shown.
    pub(crate) shown_middles: [f64; 6],
    /// The instructions its functions are made of.
    pub(crate) level: Level,
    pub(crate) capsules: Vec<Capsule>,
}

impl ArmModel {
    /// Reads a model file.
    ///
    /// # Errors
    /// Names the key, the value and the limit of what is wrong; an arm whose axes the closed form
    /// does not cover is refused too.
    pub fn from_toml(text: &str) -> Result<ArmModel, ModelError> {
        model_file::read(text)
    }

    /// A model that comes with this crate.
    #[must_use]
    pub fn builtin(name: &str) -> Option<&'static ArmModel> {
        match name {
            "fanuc-m20ia" => Some(&FANUC_M20IA),
            "fanuc-m20ia-machine" => Some(&FANUC_M20IA_MACHINE),
            _ => None,
        }
    }

    /// The models that come with this crate.
    #[must_use]
    pub fn builtin_names() -> &'static [&'static str] {
        &["fanuc-m20ia", "fanuc-m20ia-machine"]
    }

    /// The same arm, computed with other instructions; `None` if this machine does not have them.
    ///
    /// A model that was read uses the best there are; the others are to compare with. The results
    /// are the same but for rounding.
    #[must_use]
    pub fn with(&self, instructions: Instructions) -> Option<ArmModel> {
        let level = instructions.level()?;
        Some(ArmModel {
            level,
            ..self.clone()
        })
    }

    /// As in the file, `fanuc-m20ia`.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Who builds it.
    #[must_use]
    pub fn manufacturer(&self) -> &str {
        &self.manufacturer
    }

    /// The Denavit-Hartenberg table, base first.
    #[must_use]
    pub fn dh(&self) -> &[DhLink; 6] {
        &self.dh
    }

    /// The range of an axis, as the pendant counts it.
    #[must_use]
    pub fn limits(&self, axis: Axis) -> Limits {
        axis.of(&self.limits)
    }

    /// The highest speed of an axis.
    #[must_use]
    pub fn max_speed(&self, axis: Axis) -> DegPerSec {
        axis.of(&self.max_speeds)
    }

    /// The highest acceleration of an axis.
    #[must_use]
    pub fn max_acceleration(&self, axis: Axis) -> DegPerSec2 {
        axis.of(&self.max_accelerations)
    }

    /// The highest jerk of an axis: how fast its acceleration may change.
    #[must_use]
    pub fn max_jerk(&self, axis: Axis) -> DegPerSec3 {
        axis.of(&self.max_jerks)
    }

    /// Where the arm stands when a cell starts.
    #[must_use]
    pub fn home(&self) -> PendantJoints {
        self.home
    }

    /// The longest distance of the wrist center from axis 1, as data sheets give the reach.
    #[must_use]
    pub fn reach(&self) -> Millimeters {
        Millimeters(self.geometry.reach)
    }

    /// The capsules the arm is made of, for checks of collisions; none if the model file has none.
    #[must_use]
    pub fn capsules(&self) -> &[Capsule] {
        &self.capsules
    }

    /// The chain's angles of the pendant's joints.
    #[must_use]
    pub fn chain(&self, joints: &PendantJoints) -> ChainJoints {
        ChainJoints::from_radians(self.coupling.chain(&joints.radians()))
    }

    /// The pendant's joints of the chain's angles; the inverse of [`Self::chain`].
    #[must_use]
    pub fn pendant(&self, joints: &ChainJoints) -> PendantJoints {
        PendantJoints::from_radians(self.coupling.pendant(&joints.radians()))
    }

    /// `X_WF`, the flange in the world, at `joints`; translation in millimeters.
    ///
    /// The product (12) of the thesis with its table 1. Limits are not checked; see
    /// [`Self::check_limits`].
    #[must_use]
    pub fn forward(&self, joints: &PendantJoints) -> Pose {
        forward::flange(self.level, &self.geometry, &self.chain(joints))
    }

    /// Are all joints inside their limits?
    ///
    /// # Errors
    /// Every joint that is not, with its value, limits and excess.
    pub fn check_limits(&self, joints: &PendantJoints) -> Result<(), LimitViolations> {
        let violations = LimitViolations::of(self, joints);
        if violations.is_empty() {
            Ok(())
        } else {
            Err(violations)
        }
    }

    /// The configuration of a posture, with its turn numbers.
    ///
    /// At a singularity two branches meet and the first letter of each pair is given: N, U, T.
    #[must_use]
    pub fn configuration(&self, joints: &PendantJoints) -> Configuration {
        let posture = Posture::of(&self.geometry, &self.chain(joints));
        self.configuration_of(&posture, turns_of(joints))
    }

    pub(crate) fn configuration_of(&self, posture: &Posture, turns: [i8; 3]) -> Configuration {
        let flipped = self.no_flip_sign * posture.sin_q5 < 0.0;
        Configuration {
            flip: if flipped { Flip::Flip } else { Flip::NoFlip },
            elbow: if posture.elbow < 0.0 {
                Elbow::Down
            } else {
                Elbow::Up
            },
            front: if posture.front < 0.0 {
                Front::Back
            } else {
                Front::Toward
            },
            turns,
        }
    }

    /// How far a posture is from the singularities.
    #[must_use]
    pub fn singularity(&self, joints: &PendantJoints) -> Singularity {
        Posture::of(&self.geometry, &self.chain(joints)).singularity(&self.geometry)
    }

    /// Every joint set that reaches `X_WF`, inside the limits or not, each checked by the forward
    /// kinematics: to 1 nm and 1e-9 rad.
    ///
    /// J1, J2 and J3 are given on the turn nearest to the middle of their range, J4, J5 and J6
    /// between -180 and 180 degrees; the other turns are [`Self::inverse`]'s business. Where a
    /// singularity leaves a joint free, it is the one nearest to home.
    ///
    /// # Errors
    /// [`IkError::OutOfReach`], with the excess.
    #[inline]
    pub fn inverse_all(&self, X_WF: &Pose) -> Result<Branches, IkError> {
        let mut branches = Branches::new();
        inverse::collect(self, X_WF, &self.home, &mut branches)?;
        Ok(branches)
    }

    /// The joint set inside the limits that `seed` asks for.
    ///
    /// # Errors
    /// Out of reach, beyond a joint limit in every branch, or not in the configuration asked for;
    /// with the numbers.
    pub fn inverse(&self, X_WF: &Pose, seed: Seed) -> Result<Solution, IkError> {
        select::select(self, X_WF, seed)
    }

    /// The margins of `joints`.
    pub(crate) fn margins(&self, joints: &PendantJoints) -> [Degrees; 6] {
        Axis::ALL.map(|axis| self.limits(axis).margin(joints.of(axis)))
    }
}
