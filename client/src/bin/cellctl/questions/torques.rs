//! `cellctl arm torques`.

use api::arms::{
    ArmDescription, ArmInertia, ArmInverseDynamicsBody, ArmInverseDynamicsResult, ArmJointKind,
};
use clap::Args;

use super::desk::Desk;
use super::input::{FileArgs, Numbers, PostureArgs, Row};
use super::show::finish;
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::{Exit, Report};
use crate::text::{Table, thousandths};

/// Calculate the torques of the joints for a motion: what holds the arm, what its velocities and accelerations take.
///
/// The model has to say what its links weigh; the numbers of another arm go into a file, as `links`.
///
/// Examples:
///   cellctl arm torques five-link 0 45 -60 0 30
///   cellctl arm torques five-link 0 45 -60 0 30 --velocities 30,0,0,0,0 --accelerations 0,90,0,0,0 --payload 0.5
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct TorquesArgs {
    #[command(flatten)]
    posture: PostureArgs,
    /// The joints' velocities, in degrees or mm a second; 0 if absent.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    velocities: Option<Numbers>,
    /// The joints' accelerations, in degrees or mm a second squared; 0 if absent.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    accelerations: Option<Numbers>,
    /// What is fixed to the flange, in kg.
    #[arg(long, value_name = "KG", value_parser = finite, allow_negative_numbers = true)]
    payload: Option<f64>,
    /// Its center of mass in the flange's frame, in meters; the flange's origin if absent.
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        requires = "payload"
    )]
    payload_center: Option<Row<3>>,
    /// The free fall in the arm's world, in m/s^2; 9.80665 along -Z if absent.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    gravity: Option<Row<3>>,
    #[command(flatten)]
    file: FileArgs,
}

pub(super) async fn run(args: TorquesArgs, context: &Context) -> Result<Report, Failure> {
    let PostureArgs { model, joints } = args.posture;
    let body = args.file.question(|| {
        Ok(ArmInverseDynamicsBody {
            joints_deg_mm: joints,
            velocities_deg_mm_s: args.velocities.map(|Numbers(rates)| rates),
            accelerations_deg_mm_s2: args.accelerations.map(|Numbers(rates)| rates),
            payload: args.payload.map(|mass_kg| ArmInertia {
                mass_kg,
                center_of_mass_m: args.payload_center.unwrap_or(Row([0.0; 3])).0,
                inertia_kg_m2: None,
            }),
            gravity_m_s2: args.gravity.map(|Row(gravity)| gravity),
            links: None,
        })
    })?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.inverse_dynamics(&model, &body).await?;
    finish(context, Exit::Done, &answer, None, |answer| {
        torques(&arm, answer)
    })
}

fn torques(arm: &ArmDescription, answer: &ArmInverseDynamicsResult) -> String {
    let mut table = Table::new(&[
        "joint",
        ">torque",
        ">gravity",
        ">velocity",
        ">acceleration",
        "unit",
    ]);
    let parts = answer.torques_nm_n.iter().zip(&answer.gravity_nm_n);
    let parts = parts
        .zip(&answer.velocity_nm_n)
        .zip(&answer.acceleration_nm_n);
    for (joint, (((torque, gravity), velocity), acceleration)) in arm.joints.iter().zip(parts) {
        let unit = match joint.kind {
            ArmJointKind::Revolute => "N m",
            ArmJointKind::Prismatic => "N",
        };
        table.row([
            joint.name.clone(),
            thousandths(*torque),
            thousandths(*gravity),
            thousandths(*velocity),
            thousandths(*acceleration),
            unit.to_owned(),
        ]);
    }
    format!(
        "{} W of mechanical power\n\n{table}",
        thousandths(answer.power_w)
    )
}
