use std::collections::{BTreeMap, HashSet};
use std::time::Duration;

use axum::http::Uri;
use kinematics::{ArmModel, Configuration, Frames, Pose, Xyzwpr};
use units::{Degrees, Millimeters};

use super::plan::{MAX_DEADLINE_MS, count, id, in_range};
use super::{CellSection, ConfigError, FrameSection, RobotSection, SetupSource};
use crate::link::ControllerAddress;

/// A checked cell.
#[derive(Clone, Debug)]
pub struct CellPlan {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) robots: Vec<RobotPlan>,
    pub(crate) setup: Option<SetupSource>,
    /// By the mobile robot's id.
    pub(crate) push_urls: BTreeMap<String, Uri>,
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
    /// Where the controller's status program listens; unused at tier 0.
    pub(crate) status_controller: ControllerAddress,
    pub(crate) tolerance: Tolerance,
    pub(crate) frame_numbers: FrameNumbers,
    /// Seconds of the controller's clock in a second.
    pub(crate) time_scale: f64,
    pub(crate) configuration: Configuration,
    pub(crate) frames: Frames,
    pub(crate) max_speed: u16,
    pub(crate) queue_capacity: usize,
    pub(crate) connect_timeout: Duration,
    pub(crate) reply_timeout: Duration,
    pub(crate) deadline: Duration,
}

/// How far from its target a motion may end and still have arrived.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub(crate) position: Millimeters,
    /// Of the orientation, and of each joint.
    pub(crate) rotation: Degrees,
}

/// The numbers of the frames that must be active on the controller; `None` takes any.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameNumbers {
    pub(crate) user_frame: Option<u8>,
    pub(crate) tool: Option<u8>,
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
            push_urls: push_urls(key, &section.push_urls)?,
            setup: section.setup.clone(),
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
            api::Tier::SeedStatus | api::Tier::CellServer => api::Completion::Observable,
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
        let controller: ControllerAddress = section
            .controller
            .parse()
            .map_err(|error| ConfigError::new(at("controller"), format!("{error}")))?;
        let status_controller = match (&section.status_controller, section.tier) {
            (Some(_), api::Tier::Seed) => {
                return Err(ConfigError::new(
                    at("status_controller"),
                    "a controller of tier `seed` has no status program".to_owned(),
                ));
            }
            (Some(address), _) => address
                .parse()
                .map_err(|error| ConfigError::new(at("status_controller"), format!("{error}")))?,
            (None, api::Tier::Seed) => controller.clone(),
            (None, _) => controller.next_port().ok_or_else(|| {
                ConfigError::new(
                    at("status_controller"),
                    format!("is absent, and there is no port after that of `{controller}`"),
                )
            })?,
        };
        let between = |name: &str, value: f64, min: f64, max: f64| {
            if (min..=max).contains(&value) {
                Ok(value)
            } else {
                let problem = format!("{value} is not a number of {min} to {max}");
                Err(ConfigError::new(at(name), problem))
            }
        };
        Ok(Self {
            cell: cell.to_owned(),
            name: section.name.clone().unwrap_or_else(|| robot.clone()),
            id: robot,
            model: ArmModel::builtin(&section.model)
                .ok_or_else(|| unknown_model(at("model"), &section.model))?,
            controller,
            tier: section.tier,
            status_controller,
            tolerance: Tolerance {
                position: Millimeters(between(
                    "position_tolerance_mm",
                    section.position_tolerance_mm,
                    0.001,
                    100.0,
                )?),
                rotation: Degrees(between(
                    "rotation_tolerance_deg",
                    section.rotation_tolerance_deg,
                    0.001,
                    45.0,
                )?),
            },
            frame_numbers: FrameNumbers {
                user_frame: section.user_frame_number,
                tool: section.tool_number,
            },
            time_scale: between("time_scale", section.time_scale, 0.01, 1_000.0)?,
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

fn push_urls(
    key: &str,
    urls: &BTreeMap<String, String>,
) -> Result<BTreeMap<String, Uri>, ConfigError> {
    let checked = urls.iter().map(|(robot, url)| {
        let key = format!("{key}.push_urls.{robot}");
        let robot = id(&key, robot)?;
        let parsed = url.parse::<Uri>().ok().filter(|parsed| {
            parsed.scheme_str() == Some("http")
                && parsed.host().is_some_and(|host| !host.is_empty())
        });
        let parsed = parsed.ok_or_else(|| {
            ConfigError::new(key, format!("`{url}` is not `http://host:port/path`"))
        })?;
        Ok((robot, parsed))
    });
    checked.collect()
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
