//! Jacobians, joint rates, and motion by a velocity vector.

use api::arms::{
    ArmDecomposition, ArmJacobianBody, ArmJacobianResult, ArmMotionEnd, ArmMotionSample,
    ArmRatesBody, ArmRatesResult, ArmTwist, ArmVelocityMotionBody, ArmVelocityMotionResult,
};
use kinematics::serial::{
    Angles, Jacobian, JointKind, JointValues, MotionEnd, MotionError, RepresentationSingular,
    Twist, VelocityCommand, VelocityError, WristError,
};
use nalgebra::Vector3;

use crate::arm::{Arm, task_of};
use crate::convert::{frames_of, outside_body, shown};
use crate::forward::tcp;
use crate::refusal::{Refusal, RefusalKind, count_or, length, within};

const MOST_STEPS: u32 = 5000;

/// Geometric and analytic Jacobians of the tool, rank, manipulability, and what is lost at a singular posture.
///
/// Textbook (1.78) to (1.80), 1.4.5 for `decomposition`, (1.84) to (1.89) for ZYZ angles, and the same for W, P, R; (1.90) for the rank;
/// Yoshikawa's manipulability. Rows and columns are in millimeters and degrees.
///
/// # Errors
/// No such model, joints or frames that are none.
pub fn jacobian(model: &str, body: &ArmJacobianBody) -> Result<ArmJacobianResult, Refusal> {
    let arm = Arm::named(model)?;
    let joints = arm.joints("joints_deg_mm", &body.joints_deg_mm)?;
    let framed = arm.serial.with_frames(&frames_of(&body.frames)?);
    let of_joints = |error| Refusal::invalid("joints_deg_mm", error);
    let geometric = framed.jacobian(&joints).map_err(of_joints)?;
    let analytic = |angles| match framed.analytic_jacobian(&joints, angles) {
        Ok(jacobian) => Ok((Some(rows(&arm, &jacobian)), None)),
        Err(RepresentationSingular::Joints(error)) => Err(of_joints(error)),
        Err(error @ (RepresentationSingular::Zyz { .. } | RepresentationSingular::Wpr { .. })) => {
            Ok((None, Some(error.to_string())))
        }
    };
    let (analytic_zyz, zyz_singular) = analytic(Angles::Zyz)?;
    let (analytic_wpr, wpr_singular) = analytic(Angles::Wpr)?;
    let task = arm.task(body.task);
    let dexterity = framed
        .dexterity(&joints, task_of(task))
        .map_err(of_joints)?;
    let size = task_of(task).size();
    Ok(ArmJacobianResult {
        geometric: rows(&arm, &geometric),
        analytic_zyz,
        zyz_singular,
        analytic_wpr,
        wpr_singular,
        task,
        rank: dexterity.rank,
        full_rank: size.min(arm.serial.degrees_of_freedom()),
        manipulability: dexterity.manipulability,
        decomposition: decomposition(&arm, &joints)?,
        condition: Some(dexterity.condition).filter(|condition| condition.is_finite()),
        singular_values: dexterity.singular_values,
        lost: dexterity.lost.iter().map(twist_body).collect(),
        free_deg_mm_s: dexterity
            .free
            .iter()
            .map(|motion| own_units(&arm, motion))
            .collect(),
    })
}

/// Of an arm with a spherical wrist; the frames of the question change nothing about it.
fn decomposition(arm: &Arm, joints: &JointValues) -> Result<Option<ArmDecomposition>, Refusal> {
    match arm.serial.singularity_decomposition(joints) {
        Ok(apart) => Ok(Some(ArmDecomposition {
            arm_rank: apart.arm_rank,
            wrist_rank: apart.wrist_rank,
            arm_determinant_mm3: shown(apart.arm_determinant()),
            wrist_determinant: shown(apart.wrist_determinant()),
        })),
        Err(WristError::Joints(error)) => Err(Refusal::invalid("joints_deg_mm", error)),
        Err(
            WristError::NotCovered { .. }
            | WristError::WristCenterOutOfReach { .. }
            | WristError::RotationOutOfReach { .. },
        ) => Ok(None),
    }
}

/// In millimeters and degrees, for each degree or millimeter of a joint.
fn rows(arm: &Arm, jacobian: &Jacobian) -> Vec<Vec<f64>> {
    let of_row = |(index, row): (usize, nalgebra::RowDVector<f64>)| {
        let values = row.iter().zip(arm.serial.joint_list());
        values
            .map(|(value, joint)| {
                let value = value * joint.kind.inside(1.0);
                // The lower three rows are angles.
                shown(if index < 3 { value } else { value.to_degrees() })
            })
            .collect()
    };
    let all = jacobian.row_iter().map(nalgebra::Matrix::into_owned);
    all.enumerate().map(of_row).collect()
}

fn twist_body(twist: &Twist) -> ArmTwist {
    let list = |v: &Vector3<f64>| [v.x, v.y, v.z];
    ArmTwist {
        linear_mm_s: list(&twist.linear).map(shown),
        angular_deg_s: list(&twist.angular).map(|rate| shown(rate.to_degrees())),
    }
}

fn own_units(arm: &Arm, values: &[f64]) -> Vec<f64> {
    let pairs = arm.serial.joint_list().iter().zip(values);
    pairs
        .map(|(joint, value)| shown(joint.kind.shown(*value)))
        .collect()
}

/// Joint rates that give the tool a velocity, with motion to spare where the arm has more joints than the task needs.
///
/// Textbook (1.91) for fewer joints, (1.92) for as many, (1.93) with rho = `null_motion_deg_mm_s` for more.
///
/// # Errors
/// No such model, an item out of its range, or what of the velocity cannot be made here, with the rank.
pub fn rates(model: &str, body: &ArmRatesBody) -> Result<ArmRatesResult, Refusal> {
    let arm = Arm::named(model)?;
    let joints = arm.joints("joints_deg_mm", &body.joints_deg_mm)?;
    let framed = arm.serial.with_frames(&frames_of(&body.frames)?);
    let linear = vector("velocity.linear_mm_s", body.velocity.linear_mm_s, "mm/s")?;
    let angular = vector(
        "velocity.angular_deg_s",
        body.velocity.angular_deg_s,
        "deg/s",
    )?;
    let twist = Twist {
        linear,
        angular: angular.map(f64::to_radians),
    };
    let null_motion = match &body.null_motion_deg_mm_s {
        Some(rates) => {
            let path = "null_motion_deg_mm_s";
            length(path, rates.len(), [joints.len(); 2], "rates")?;
            for (index, rate) in rates.iter().enumerate() {
                let _ = within(&format!("{path}[{index}]"), *rate, [-1e6, 1e6], "")?;
            }
            let kinds = arm.serial.joint_list().iter().map(|joint| joint.kind);
            Some(
                kinds
                    .zip(rates)
                    .map(|(kind, rate)| kind.inside(*rate))
                    .collect::<Vec<f64>>(),
            )
        }
        None => None,
    };
    let task = arm.task(body.task);
    let solved = framed.rates(&joints, &twist, task_of(task), null_motion.as_deref());
    let solved = solved.map_err(|error| match error {
        VelocityError::Joints(error) => Refusal::invalid("joints_deg_mm", error),
        VelocityError::NotAVelocity { .. } => Refusal::invalid("velocity", error),
        VelocityError::NullMotion { .. } => Refusal::invalid("null_motion_deg_mm_s", error),
        VelocityError::Incompatible { .. } => {
            Refusal::new(RefusalKind::Singular, "velocity", error)
        }
    })?;
    Ok(ArmRatesResult {
        rates_deg_mm_s: own_units(&arm, &solved.rates),
        load: shown(solved.load),
        task,
        rank: solved.rank,
    })
}

fn vector(path: &str, values: [f64; 3], unit: &str) -> Result<Vector3<f64>, Refusal> {
    for (index, value) in values.into_iter().enumerate() {
        let _ = within(&format!("{path}[{index}]"), value, [-1e6, 1e6], unit)?;
    }
    Ok(Vector3::from(values))
}

/// The tool moved with a constant velocity V for a time T, or with a speed along its own Z, as far as it goes.
///
/// The paper's section 6, for any arm: the tool stays on the line and keeps its rotation as far as the task asks. The
/// motion ends before a joint leaves its range, would have to be too fast, or at a singular posture, and says which.
///
/// # Errors
/// No such model; a start, velocity, time or number of steps that is none.
pub fn velocity_motion(
    model: &str,
    body: &ArmVelocityMotionBody,
) -> Result<ArmVelocityMotionResult, Refusal> {
    let arm = Arm::named(model)?;
    let start = arm.joints_inside("start_deg_mm", &body.start_deg_mm)?;
    let framed = arm.serial.with_frames(&frames_of(&body.frames)?);
    let steps = count_or("steps", body.steps, 100, [1, MOST_STEPS])?;
    let _ = within("time_s", body.time_s, [1e-6, 3600.0], "s")?;
    let (path, command) = match (body.velocity_mm_s, body.along_tool_mm_s) {
        (Some(velocity), None) => {
            let path = "velocity_mm_s";
            (
                path,
                VelocityCommand::Vector(vector(path, velocity, "mm/s")?),
            )
        }
        (None, Some(speed)) => {
            let path = "along_tool_mm_s";
            let speed = within(path, speed, [1e-9, 100_000.0], "mm/s")?;
            (path, VelocityCommand::AlongTool(speed))
        }
        (Some(_), Some(_)) => {
            let detail = "there is velocity_mm_s too; give one of them";
            return Err(Refusal::invalid("along_tool_mm_s", detail));
        }
        (None, None) => return Err(Refusal::invalid("velocity_mm_s", "it is missing")),
    };
    let task = task_of(arm.task(body.task));
    let steps = usize::try_from(steps).unwrap_or(1);
    let motion = framed.move_by_velocity(&start, command, body.time_s, steps, task);
    let motion = motion.map_err(|error| match error {
        MotionError::Joints(error) => Refusal::invalid("start_deg_mm", error),
        MotionError::StartOutside(outside) => {
            arm.outside_refusal("start_deg_mm", &outside_body(&outside))
        }
        MotionError::Value { .. } => Refusal::invalid(path, error),
    })?;
    let samples: Vec<ArmMotionSample> = motion
        .samples
        .iter()
        .map(|sample| ArmMotionSample {
            time_s: sample.time_s,
            joints_deg_mm: arm.shown(&sample.joints),
            tcp_mm: tcp(&framed, &sample.joints),
        })
        .collect();
    let (end, detail, outside) = told(&motion.end, &arm);
    Ok(ArmVelocityMotionResult {
        moved_s: samples.last().map_or(0.0, |sample| sample.time_s),
        samples,
        end,
        detail,
        outside,
    })
}

type Told = (ArmMotionEnd, Option<String>, Option<api::arms::ArmOutside>);

fn told(end: &MotionEnd, arm: &Arm) -> Told {
    match end {
        MotionEnd::Completed => (ArmMotionEnd::Completed, None, None),
        MotionEnd::Limit(outside) => (
            ArmMotionEnd::Limit,
            Some(outside.to_string()),
            Some(outside_body(outside)),
        ),
        MotionEnd::TooFast { joint, load } => {
            let joints = arm.serial.joint_list();
            let speed = joints
                .iter()
                .find(|known| known.name == *joint)
                .map(|joint| {
                    let unit = match joint.kind {
                        JointKind::Revolute => "deg/s",
                        JointKind::Prismatic => "mm/s",
                    };
                    (joint.kind.shown(joint.max_speed), unit)
                });
            let (most, unit) = speed.unwrap_or((0.0, ""));
            let detail = format!(
                "{joint} would have to move at {:.3} {unit}, its highest speed is {most:.3} {unit}",
                load * most
            );
            (ArmMotionEnd::TooFast, Some(detail), None)
        }
        MotionEnd::Singular { ratio } => {
            let detail = format!(
                "the smallest singular value is {ratio:.2e} of the largest: a singular posture, or the end of the reach"
            );
            (ArmMotionEnd::Singular, Some(detail), None)
        }
    }
}
