//! Arms, tools, zones and taught poses.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CT is the tool T in the cell C"
)]

use api::setup::{BoxBody, PlaceKind, PoseFrame, ToolSetup, ZoneKind};
use kinematics::{Configuration, Pose};
use nalgebra::Point3;
use units::Millimeters;

use super::refs::{Refs, Which};
use super::{joints, pose, unique};
use crate::setup::faults::Faults;
use crate::setup::geometry::{ZoneBox, origin_of};
use crate::setup::model::{Arm, Taught, Tool, Zone};
use crate::setup::text::{check_id, check_name};

const TOOL_NUMBERS: std::ops::RangeInclusive<u8> = 1..=10;
const RADIUS_MM: (f64, f64) = (0.0, 1_000.0);
const APPROACH_MM: (f64, f64) = (1.0, 1_000.0);
/// No tool is longer, in millimeters.
const MAX_TOOL_MM: f64 = 3_000.0;
const BODY_RADIUS: Millimeters = Millimeters(100.0);
const TOOL_RADIUS: Millimeters = Millimeters(50.0);

pub(super) fn zones(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Zone> {
    let zones = &refs.file.zones;
    unique(
        faults,
        named(zones, "zones", |zone| zone.id.as_str()),
        |id| format!("`{id}`"),
    );
    let mut checked = Vec::with_capacity(zones.len());
    for (index, zone) in zones.iter().enumerate() {
        let item = format!("zones[{index}]");
        check_id(faults, format!("{item}.id"), &zone.id);
        check_name(faults, format!("{item}.name"), zone.name.as_deref());
        let robots = refs.scope(
            faults,
            &format!("{item}.robots"),
            zone.robots.as_ref(),
            Which::Any,
        );
        if let Some(bounds) = bounds(faults, &format!("{item}.box"), &zone.bounds) {
            checked.push(Zone {
                id: zone.id.clone(),
                kind: zone.kind,
                robots,
                bounds,
            });
        }
    }
    checked
}

fn bounds(faults: &mut Faults, item: &str, body: &BoxBody) -> Option<ZoneBox> {
    let BoxBody { min, max } = body;
    let mut legal = true;
    for (axis, low, high) in [
        ("x_mm", min.x_mm, max.x_mm),
        ("y_mm", min.y_mm, max.y_mm),
        ("z_mm", min.z_mm, max.z_mm),
    ] {
        let low_is = faults.number(format!("{item}.min.{axis}"), low, super::SIZE_MM);
        let high_is = faults.number(format!("{item}.max.{axis}"), high, super::SIZE_MM);
        legal &= low_is.is_some() && high_is.is_some();
        if legal && low >= high {
            faults.add(
                format!("{item}.max.{axis}"),
                format!("is {high}, which is not above min.{axis} {low}"),
            );
            legal = false;
        }
    }
    legal.then(|| ZoneBox {
        min: Point3::new(min.x_mm, min.y_mm, min.z_mm),
        max: Point3::new(max.x_mm, max.y_mm, max.z_mm),
    })
}

pub(super) fn arms(faults: &mut Faults, refs: &Refs<'_>, zones: &[Zone]) -> Vec<Arm> {
    tools(faults, refs);
    let arms = &refs.file.arms;
    unique(faults, named(arms, "arms", |arm| arm.id.as_str()), |id| {
        format!("`{id}`")
    });
    let mut checked = Vec::with_capacity(arms.len());
    for (index, body) in arms.iter().enumerate() {
        let item = format!("arms[{index}]");
        let Some(robot) = refs.robot(&body.id) else {
            let known: Vec<_> = refs.robots.iter().map(|robot| robot.id.as_str()).collect();
            faults.add(
                format!("{item}.id"),
                format!(
                    "`{}` is no robot of the cell's configuration; there are {}",
                    crate::state::shown(&body.id),
                    known.join(", ")
                ),
            );
            continue;
        };
        let radius = radius(
            faults,
            &item,
            "body_radius_mm",
            body.body_radius_mm,
            BODY_RADIUS,
        );
        let X_CW = pose(faults, &format!("{item}.base"), &body.base);
        let model = robot.model;
        let safe = joints(faults, &format!("{item}.safe"), body.safe, model);
        let home = match body.home {
            Some(home) => joints(faults, &format!("{item}.home"), home, model),
            None => Some(model.home()),
        };
        let tool = refs.tool(&body.id, body.tool);
        if tool.is_none() {
            let known: Vec<_> = refs
                .file
                .tools
                .iter()
                .filter(|tool| tool.arm == body.id)
                .collect();
            let known: Vec<_> = known.iter().map(|tool| tool.number.to_string()).collect();
            faults.add(
                format!("{item}.tool"),
                format!(
                    "{} is no tool of `{}`; there are {}",
                    body.tool,
                    body.id,
                    list(&known)
                ),
            );
        }
        let tool = tool.and_then(tool_of);
        if let (Some(X_CW), Some(safe), Some(home), Some(tool), Some(body_radius)) =
            (X_CW, safe, home, tool, radius)
        {
            let arm = Arm {
                id: body.id.clone(),
                model,
                controller_frames: robot.frames,
                X_CW,
                body_radius,
                tool,
                safe,
                home,
            };
            safe_is_safe(faults, &item, &arm, zones);
            checked.push(arm);
        }
    }
    checked
}

/// A safe pose inside a hand-over zone would hold a mobile robot up for ever.
fn safe_is_safe(faults: &mut Faults, item: &str, arm: &Arm, zones: &[Zone]) {
    let X_CT = arm.X_CW * arm.model.forward(&arm.safe) * arm.tool.X_FT;
    let tip = origin_of(&X_CT);
    for zone in zones {
        let handover = zone.kind == ZoneKind::Handover && zone.robots.includes(&arm.id);
        if handover && zone.bounds.contains(&tip) {
            faults.add(
                format!("{item}.safe"),
                format!(
                    "the tool center point at x {:.1}, y {:.1}, z {:.1} mm is inside the hand-over zone `{}`",
                    tip.x, tip.y, tip.z, zone.id
                ),
            );
        }
    }
}

fn list(known: &[String]) -> String {
    if known.is_empty() {
        "none".to_owned()
    } else {
        known.join(", ")
    }
}

fn tools(faults: &mut Faults, refs: &Refs<'_>) {
    let tools = &refs.file.tools;
    unique(
        faults,
        tools.iter().enumerate().map(|(index, tool)| {
            (
                format!("tools[{index}].number"),
                (tool.arm.as_str(), tool.number),
            )
        }),
        |(arm, number)| format!("tool {number} of `{arm}`"),
    );
    for (index, tool) in tools.iter().enumerate() {
        let item = format!("tools[{index}]");
        let _robot = refs.arm(faults, format!("{item}.arm"), &tool.arm);
        check_name(faults, format!("{item}.name"), tool.name.as_deref());
        if !TOOL_NUMBERS.contains(&tool.number) {
            let number = tool.number;
            faults.add(
                format!("{item}.number"),
                format!("is {number}; it must be from 1 to 10"),
            );
        }
        let _radius = radius(faults, &item, "radius_mm", tool.radius_mm, TOOL_RADIUS);
        if let Some(X_FT) = pose(faults, &format!("{item}.frame"), &tool.frame) {
            let length = X_FT.isometry().translation.vector.norm();
            if length > MAX_TOOL_MM {
                faults.add(
                    format!("{item}.frame"),
                    format!("its center point is {length:.1} mm from the flange; at most {MAX_TOOL_MM} is taken"),
                );
            }
        }
        if let Some(record) = &tool.calibration {
            let points = f64::from(record.points);
            let item = format!("{item}.calibration");
            let _ = faults.number(format!("{item}.points"), points, (4.0, 100.0));
            let _ = faults.number(format!("{item}.rms_mm"), record.rms_mm, (0.0, 10.0));
            let _ = faults.number(format!("{item}.max_mm"), record.max_mm, (0.0, 10.0));
        }
    }
}

/// A tool whose faults, if any, are told of where it stands.
fn tool_of(body: &ToolSetup) -> Option<Tool> {
    let unheard = &mut Faults::default();
    Some(Tool {
        number: body.number,
        X_FT: pose(unheard, "", &body.frame)?,
        radius: radius(unheard, "", "", body.radius_mm, TOOL_RADIUS)?,
    })
}

fn radius(
    faults: &mut Faults,
    item: &str,
    key: &str,
    value: Option<f64>,
    default: Millimeters,
) -> Option<Millimeters> {
    match value {
        None => Some(default),
        Some(value) => faults
            .number(format!("{item}.{key}"), value, RADIUS_MM)
            .map(Millimeters),
    }
}

pub(super) fn taught(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Taught> {
    let bodies = &refs.file.taught_poses;
    unique(
        faults,
        bodies.iter().enumerate().map(|(index, body)| {
            let key = (body.arm.as_str(), body.place.as_str());
            (format!("taught_poses[{index}]"), key)
        }),
        |(arm, place)| format!("`{place}` for `{arm}`"),
    );
    let mut checked = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let item = format!("taught_poses[{index}]");
        let robot = refs.arm(faults, format!("{item}.arm"), &body.arm);
        let place = refs.place(faults, format!("{item}.place"), &body.place);
        if let Some(place) = place
            && place.kind == PlaceKind::OnMobileRobot
            && let Some(point) = &place.point
            && let Some(at) = refs.point(&mut Faults::default(), String::new(), point)
            && !at.arms.contains(&body.arm)
        {
            faults.add(
                format!("{item}.arm"),
                format!(
                    "`{}` does not work at `{point}`, where `{}` is; there work {}",
                    body.arm,
                    body.place,
                    list(&at.arms)
                ),
            );
        }
        let configuration = body.configuration.parse::<Configuration>();
        if let Err(error) = &configuration {
            faults.add(format!("{item}.configuration"), error.to_string());
        }
        let approach = faults.number(format!("{item}.approach_mm"), body.approach_mm, APPROACH_MM);
        let lift = match body.lift_mm {
            None => approach,
            Some(lift) => faults.number(format!("{item}.lift_mm"), lift, APPROACH_MM),
        };
        let X = pose(faults, &format!("{item}.pose"), &body.pose);
        let base = refs.file.arms.iter().find(|arm| arm.id == body.arm);
        let X_CW = base.and_then(|arm| pose(&mut Faults::default(), "", &arm.base));
        if let (
            Some(_),
            Some(_),
            Ok(configuration),
            Some(approach),
            Some(lift),
            Some(X),
            Some(X_CW),
        ) = (robot, place, configuration, approach, lift, X, X_CW)
        {
            checked.push(Taught {
                arm: body.arm.clone(),
                place: body.place.clone(),
                X_CT: in_cell(body.frame, &X_CW, X),
                configuration,
                approach: Millimeters(approach),
                lift: Millimeters(lift),
            });
        }
    }
    checked
}

/// A pose in the cell frame, of a pose in the frame it is written in.
pub(in crate::setup) fn in_cell(frame: PoseFrame, X_CW: &Pose, X: Pose) -> Pose {
    match frame {
        PoseFrame::Cell => X,
        PoseFrame::Arm => *X_CW * X,
    }
}

/// The paths and ids of a list.
pub(super) fn named<'a, T>(
    list: &'a [T],
    name: &'a str,
    id: impl Fn(&'a T) -> &'a str + 'a,
) -> impl Iterator<Item = (String, &'a str)> {
    let entries = list.iter().enumerate();
    entries.map(move |(index, entry)| (format!("{name}[{index}].id"), id(entry)))
}
