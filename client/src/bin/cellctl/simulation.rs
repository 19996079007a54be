//! What `cellctl job simulate` says.

use std::fmt::Write as _;

use api::{JobSimulation, LoadLocation, SimulationEnd};

use crate::job::{phases, seconds};
use crate::text::{self, Table, word};

/// The answer first, then how it comes about.
pub(crate) fn sentences(simulation: &JobSimulation) -> String {
    let report = &simulation.report;
    let mut facts = vec![
        ("simulated", word(report.workflow)),
        ("outcome", outcome(simulation)),
    ];
    if let Some(fault) = &simulation.fault {
        facts.push(("fault", format!("{} {}", fault.code, fault.name)));
    }
    if !simulation.text.is_empty() {
        facts.push(("why", simulation.text.clone()));
    }
    facts.push(("cycle time", format!("{} s", seconds(report.cycle_ms))));
    if report.queued_ms > 0 {
        facts.push(("in the queue", format!("{} s", seconds(report.queued_ms))));
    }
    facts.push(("it took", format!("{} s", seconds(simulation.wall_ms))));
    let mut said = text::facts(&facts);
    said.push_str(&phases(report));
    if !simulation.motions.is_empty() {
        said.push('\n');
        said.push_str(&motions(simulation));
    }
    let mut lines: Vec<(u64, String)> = Vec::new();
    for permit in &simulation.permits {
        let who = match (permit.arm_entry_permit, permit.mr_move_permit) {
            (true, _) => "the arm may enter",
            (false, true) => "the mobile robot may move",
            (false, false) => "nobody may",
        };
        lines.push((permit.at_ms, format!("{}: {who}", permit.point)));
    }
    for moved in &simulation.custody {
        lines.push((
            moved.at_ms,
            format!("{} is {}", moved.load, location(&moved.to)),
        ));
    }
    for asked in &simulation.interventions {
        let text = format!(
            "a person is asked ({}): {} [{}]",
            asked.fault.code,
            asked.question,
            asked.answers.join(", ")
        );
        lines.push((asked.at_ms, text));
    }
    for fault in &report.faults {
        let text = format!("{} {}: {}", fault.fault.code, fault.fault.name, fault.text);
        lines.push((fault.at_ms, text));
    }
    lines.sort_by_key(|(at, _)| *at);
    if !lines.is_empty() {
        let mut table = Table::new(&[">at s", "permits, loads, faults"]);
        for (at, line) in lines {
            table.row([seconds(at), line]);
        }
        said.push('\n');
        said.push_str(&table.to_string());
    }
    for violation in &simulation.violations {
        let _string = writeln!(
            said,
            "  VIOLATION at {} s, {}: {}",
            seconds(violation.at_ms),
            violation.source,
            violation.text
        );
    }
    for assumption in &simulation.assumptions {
        let _string = writeln!(said, "  supposed: {assumption}");
    }
    said.push_str("\nNothing real has moved.");
    said
}

fn outcome(simulation: &JobSimulation) -> String {
    let state = word(simulation.outcome);
    let violations = match simulation.violations.len() {
        0 => String::new(),
        1 => ", with 1 violation".to_owned(),
        count => format!(", with {count} violations"),
    };
    let why = match simulation.ended {
        SimulationEnd::JobOver => "",
        SimulationEnd::AsksAPerson => " until a person decides",
        SimulationEnd::SimulatedTimeLimit => " still, at the limit of simulated time",
        SimulationEnd::WallTimeLimit => " still, at the limit of real time",
    };
    format!("{state}{why}{violations}")
}

fn motions(simulation: &JobSimulation) -> String {
    let mut table = Table::new(&["arm", "motion", ">from s", ">took s", "end"]);
    for motion in &simulation.motions {
        table.row([
            motion.arm.clone(),
            motion.action.clone(),
            seconds(motion.begin_ms),
            seconds(motion.duration_ms),
            motion.end.clone().unwrap_or_else(|| "runs".to_owned()),
        ]);
    }
    table.to_string()
}

fn location(at: &LoadLocation) -> String {
    match at {
        LoadLocation::Fixed { place } => format!("in {place}"),
        LoadLocation::Gripper { arm } => format!("in the gripper of {arm}"),
        LoadLocation::MobileRobot { mobile_robot, slot } => {
            format!("on {mobile_robot}, {slot}")
        }
        LoadLocation::Delivered { destination } => format!("delivered to {destination}"),
        LoadLocation::Unknown { .. } => "nobody knows where".to_owned(),
    }
}
