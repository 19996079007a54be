//! An arm of the catalogue, and how it is solved.

use api::arms::{ArmOutside, ArmSolver, ArmTask};
use kinematics::serial::{
    FiveLinkArm, JointValues, SerialArm, SerialError, Task, TextbookArm, WristError,
};
use kinematics::{ArmModel, PendantJoints, Pose};
use units::Millimeters;

use crate::convert::{outside_body, shown};
use crate::refusal::{Refusal, RefusalKind};

/// An arm of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Arm {
    pub(crate) serial: &'static SerialArm,
    pub(crate) closed: Option<&'static ArmModel>,
}

impl Arm {
    /// The arm of this name.
    ///
    /// # Errors
    /// There is none; the names there are.
    pub fn named(model: &str) -> Result<Arm, Refusal> {
        let serial = SerialArm::builtin(model).ok_or_else(|| {
            let names: Vec<&str> = SerialArm::catalog().iter().map(SerialArm::name).collect();
            let detail = format!(
                "there is no arm model {model:?}; there are {}",
                names.join(", ")
            );
            Refusal::new(RefusalKind::UnknownModel, "", detail)
        })?;
        Ok(Arm {
            serial,
            closed: ArmModel::builtin(model),
        })
    }

    /// All arms of the catalogue.
    pub(crate) fn all() -> impl Iterator<Item = Arm> {
        SerialArm::catalog().iter().map(|serial| Arm {
            serial,
            closed: ArmModel::builtin(serial.name()),
        })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.serial.name()
    }

    pub(crate) fn task(&self, asked: Option<ArmTask>) -> ArmTask {
        // Four joints of a SCARA turn about the vertical, which the general rule does not know.
        let own = || match self.serial.degrees_of_freedom() {
            4 => ArmTask::PositionAndHeading,
            joints => task_body(Task::for_joints(joints)),
        };
        asked.unwrap_or_else(own)
    }

    /// How its inverse kinematics are solved, the way that is taken by itself first.
    pub(crate) fn solvers(&self) -> Vec<ArmSolver> {
        let mut solvers = Vec::new();
        if self.closed.is_some() {
            solvers.push(ArmSolver::ClosedForm);
        }
        if self.textbook().is_some() {
            solvers.push(ArmSolver::Textbook);
        }
        let quartic = self
            .serial
            .inverse_spherical(&Pose::identity(), &self.serial.home());
        if !matches!(quartic, Err(WristError::NotCovered { .. })) {
            solvers.push(ArmSolver::Quartic);
        }
        if self.five_link().is_some() {
            solvers.push(ArmSolver::FiveLink);
        }
        solvers.push(ArmSolver::DampedLeastSquares);
        solvers
    }

    /// The asked way, or the arm's own.
    pub(crate) fn solver(&self, asked: Option<ArmSolver>) -> Result<ArmSolver, Refusal> {
        let solvers = self.solvers();
        match asked {
            None => Ok(solvers
                .first()
                .copied()
                .unwrap_or(ArmSolver::DampedLeastSquares)),
            Some(asked) if solvers.contains(&asked) => Ok(asked),
            Some(asked) => {
                let names: Vec<String> = solvers.iter().map(|s| format!("{s:?}")).collect();
                let detail = format!(
                    "{asked:?} does not cover {}; what does: {}",
                    self.name(),
                    names.join(", ")
                );
                Err(Refusal::invalid("method", detail))
            }
        }
    }

    /// The arm of table 1.1 with the lengths of the catalogue's file.
    pub(crate) fn textbook(&self) -> Option<TextbookArm> {
        if self.name() != "textbook-6r" {
            return None;
        }
        let [j1, j2, _, j4, _, j6] = self.serial.joint_list() else {
            return None;
        };
        let [d1, a2, d4, d6] = [j1.d, j2.a, j4.d, j6.d].map(Millimeters);
        TextbookArm::try_new(d1, a2, d4, d6).ok()
    }

    /// The paper's arm with the lengths of the catalogue's file; its l3 and l4 lie in one line and come in as their
    /// sum, of which the paper's figure has four sevenths before D.
    pub(crate) fn five_link(&self) -> Option<FiveLinkArm> {
        if self.name() != "five-link" {
            return None;
        }
        let [a, b, _, d, e] = self.serial.joint_list() else {
            return None;
        };
        let l34 = d.d.abs();
        let l3 = l34 * 4.0 / 7.0;
        FiveLinkArm::try_new([a.a, b.a, l3, l34 - l3, e.a]).ok()
    }

    /// Joint values at `path` of the question, ranges not checked.
    pub(crate) fn joints(&self, path: &str, values: &[f64]) -> Result<JointValues, Refusal> {
        self.serial.joints(values).map_err(|error| match &error {
            SerialError::JointCount { .. } => Refusal::invalid(path, error),
            SerialError::NotAValue {
                joint, value, max, ..
            } => {
                let index = self.index(joint);
                Refusal {
                    min: Some(-max),
                    max: Some(*max),
                    ..Refusal::invalid(format!("{path}[{index}]"), &error).with_value(*value)
                }
            }
        })
    }

    /// The same, inside the ranges.
    pub(crate) fn joints_inside(&self, path: &str, values: &[f64]) -> Result<JointValues, Refusal> {
        let joints = self.joints(path, values)?;
        match self.outside(&joints).first() {
            None => Ok(joints),
            Some(outside) => Err(self.outside_refusal(path, outside)),
        }
    }

    pub(crate) fn outside_refusal(&self, path: &str, outside: &ArmOutside) -> Refusal {
        let ArmOutside {
            joint,
            value_deg_mm: value,
            min_deg_mm: min,
            max_deg_mm: max,
        } = outside;
        let index = self.index(joint);
        let unit = self
            .serial
            .joint_list()
            .get(index)
            .map_or("", |joint| joint.kind.unit());
        let detail = format!("{joint} is {value} {unit}; its range is {min} to {max} {unit}");
        Refusal {
            value: Some(*value),
            min: Some(*min),
            max: Some(*max),
            ..Refusal::new(RefusalKind::JointLimit, format!("{path}[{index}]"), detail)
        }
    }

    pub(crate) fn index(&self, name: &str) -> usize {
        let mut joints = self.serial.joint_list().iter();
        joints.position(|joint| joint.name == name).unwrap_or(0)
    }

    /// Degrees and millimeters, as people read them.
    pub(crate) fn shown(&self, joints: &JointValues) -> Vec<f64> {
        let pairs = self.serial.joint_list().iter().zip(joints.as_slice());
        pairs
            .map(|(joint, value)| shown(joint.kind.shown(*value)))
            .collect()
    }

    pub(crate) fn outside(&self, joints: &JointValues) -> Vec<ArmOutside> {
        let pairs = self.serial.joint_list().iter().zip(joints.as_slice());
        pairs
            .filter(|(joint, value)| !joint.contains(**value))
            .map(|(joint, value)| outside_body(&joint.outside(*value)))
            .collect()
    }

    /// The joints of an arm that the closed form covers.
    pub(crate) fn pendant(joints: &[f64]) -> Option<PendantJoints> {
        let degrees: [f64; 6] = joints.try_into().ok()?;
        Some(PendantJoints::from_degrees(degrees))
    }

    /// The configuration of an arm that the closed form covers.
    pub(crate) fn configuration(&self, degrees: &[f64]) -> Option<String> {
        let joints = Self::pendant(degrees)?;
        Some(self.closed?.configuration(&joints).to_string())
    }
}

pub(crate) fn task_body(task: Task) -> ArmTask {
    match task {
        Task::Pose => ArmTask::Pose,
        Task::PositionAndAxis => ArmTask::PositionAndAxis,
        Task::PositionAndHeading => ArmTask::PositionAndHeading,
        Task::Position => ArmTask::Position,
    }
}

pub(crate) fn task_of(task: ArmTask) -> Task {
    match task {
        ArmTask::Pose => Task::Pose,
        ArmTask::PositionAndAxis => Task::PositionAndAxis,
        ArmTask::PositionAndHeading => Task::PositionAndHeading,
        ArmTask::Position => Task::Position,
    }
}
