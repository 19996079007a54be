//! `cellctl describe`.

use api::RobotDescription;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, Table, word};

pub(crate) async fn run(context: &Context) -> Result<Report, Failure> {
    let description = context.robot().await?.describe().await?;
    Ok(context.report(Exit::Done, &description, sentences))
}

fn sentences(robot: &RobotDescription) -> String {
    let mut table = Table::new(&["joint", ">min deg", ">max deg", ">deg/s"]);
    for joint in &robot.joints {
        table.row([
            joint.joint.clone(),
            text::thousandths(joint.min_deg),
            text::thousandths(joint.max_deg),
            format!("{:.1}", joint.max_speed_deg_s),
        ]);
    }
    let facts = [
        (
            "robot",
            format!("{} in {} ({})", robot.id, robot.cell, robot.name),
        ),
        ("arm", format!("{} {}", robot.manufacturer, robot.model)),
        (
            "controller",
            format!("{}, tier {}", robot.controller_address, word(robot.tier)),
        ),
        ("configuration", robot.configuration.clone()),
        ("reach", format!("{:.1} mm", robot.reach_mm)),
        ("speed", format!("up to {} mm/s", robot.max_speed_mm_s)),
        ("home", text::joints(robot.home)),
        ("tool", text::pose(&robot.tool)),
        ("user frame", text::pose(&robot.user_frame)),
    ];
    format!("{}\n{table}", text::facts(&facts))
}
