use std::collections::HashSet;
use std::time::Duration;

use kinematics::{ArmModel, Configuration, Frames, Pose, Xyzwpr};
use units::{Degrees, Millimeters};

use super::plan::{MAX_DEADLINE_MS, count, id, in_range};
use super::{CellSection, ConfigError, FrameSection, RobotSection};
use crate::link::ControllerAddress;

/// A checked cell.
#[derive(Clone, Debug)]
pub struct CellPlan {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) robots: Vec<RobotPlan>,
}

/// A checked robot.
#[derive(Clone, Debug)]
pub struct RobotPlan {
    pub(crate) cell: String,
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) model: &'static ArmModel,
    pub(crate) controller: ControllerAddress,
    pub(crate) tier: api::Tier,
    pub(crate) configuration: Configuration,
    pub(crate) frames: Frames,
    pub(crate) max_speed: u16,
    pub(crate) queue_capacity: usize,
    pub(crate) connect_timeout: Duration,
    pub(crate) reply_timeout: Duration,
    pub(crate) deadline: Duration,
}

impl CellPlan {
    pub(super) fn try_new(key: &str, section: &CellSection) -> Result<Self, ConfigError> {
        let cell = id(&format!("{key}.id"), &section.id)?;
        let mut ids = HashSet::new();
        let mut robots = Vec::with_capacity(section.robots.len());
        for (index, robot) in section.robots.iter().enumerate() {
            let key = format!("{key}.robots[{index}]");
            if !ids.insert(robot.id.as_str()) {
                return Err(ConfigError::new(
                    format!("{key}.id"),
                    format!("`{}` is the id of an earlier robot of the cell", robot.id),
                ));
            }
            robots.push(RobotPlan::try_new(&key, &cell, robot)?);
        }
        Ok(Self {
            name: section.name.clone().unwrap_or_else(|| cell.clone()),
            id: cell,
            robots,
        })
    }
}

impl RobotPlan {
    /// What can be known of a motion's end.
    pub(crate) fn completion(&self) -> api::Completion {
        match self.tier {
            api::Tier::Seed => api::Completion::NotObservable,
        }
    }

    fn try_new(key: &str, cell: &str, section: &RobotSection) -> Result<Self, ConfigError> {
        let at = |name: &str| format!("{key}.{name}");
        let robot = id(&at("id"), &section.id)?;
        let millis =
            |name: &str, value, max| in_range(&at(name), value, 1, max).map(Duration::from_millis);
        let max_speed = in_range(
            &at("max_speed_mm_s"),
            section.max_speed_mm_s,
            u64::from(protocol::MIN_SPEED),
            u64::from(protocol::MAX_SPEED),
        )?;
        Ok(Self {
            cell: cell.to_owned(),
            name: section.name.clone().unwrap_or_else(|| robot.clone()),
            id: robot,
            model: ArmModel::builtin(&section.model)
                .ok_or_else(|| unknown_model(at("model"), &section.model))?,
            controller: section
                .controller
                .parse()
                .map_err(|error| ConfigError::new(at("controller"), format!("{error}")))?,
            tier: section.tier,
            configuration: section.configuration.parse().map_err(|error| {
                ConfigError::new(
                    at("configuration"),
                    format!("`{}`: {error}", section.configuration),
                )
            })?,
            frames: Frames {
                tool: frame(at("tool"), &section.tool)?,
                user_frame: frame(at("user_frame"), &section.user_frame)?,
            },
            max_speed: u16::try_from(max_speed).unwrap_or(protocol::MAX_SPEED),
            queue_capacity: count(&at("queue_capacity"), section.queue_capacity, 1, 1_000)?,
            connect_timeout: millis("connect_timeout_ms", section.connect_timeout_ms, 30_000)?,
            reply_timeout: millis(
                "reply_timeout_ms",
                section.reply_timeout_ms,
                MAX_DEADLINE_MS,
            )?,
            deadline: millis("deadline_ms", section.deadline_ms, MAX_DEADLINE_MS)?,
        })
    }
}

fn unknown_model(key: String, model: &str) -> ConfigError {
    let known = ArmModel::builtin_names().join(", ");
    ConfigError::new(key, format!("`{model}` is none of the models: {known}"))
}

fn frame(key: String, section: &FrameSection) -> Result<Pose, ConfigError> {
    Pose::try_from_xyzwpr(&Xyzwpr {
        x: Millimeters(section.x_mm),
        y: Millimeters(section.y_mm),
        z: Millimeters(section.z_mm),
        w: Degrees(section.w_deg),
        p: Degrees(section.p_deg),
        r: Degrees(section.r_deg),
    })
    .map_err(|error| ConfigError::new(key, error.to_string()))
}
