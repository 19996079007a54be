//! The configuration, checked: what a robot is made of.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use api::{MAX_OUTBOX_WAIT_S, MAX_SIGNAL_ITEMS, SlotLoadBody};
use mobile_base::{
    Approach, Dimensions, Follower, FollowerSettings, Footprint, Guard, GuardSettings, Leg,
    Localization, MecanumBase, Obstacle, PathLimits, PlanarPose, Point, PointGains, PointLaw,
    Route, TrackingLaw, Waypoint, WaypointHeading,
};
use units::{Degrees, Millimeters, MmPerSec, MmPerSec2, PerMillimeter, PerSecond, RadPerSec};

use crate::config::{ApproachSection, BatterySection, MobileConfig, RouteShape};
use crate::error::{ConfigError, id, number};
use crate::floor::{Zone, pose_of};
use crate::outbound::Backoff;

const MAX_POINTS: usize = 1000;
const MAX_OBSTACLES: usize = 1000;

/// A robot's parts. See [`MobileConfig`] for what they are.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) id: String,
    pub(crate) step: Duration,
    pub(crate) heartbeat: Duration,
    pub(crate) start: PlanarPose,
    pub(crate) base: MecanumBase,
    pub(crate) footprint: Footprint,
    pub(crate) guard: GuardSettings,
    pub(crate) driving: FollowerSettings,
    pub(crate) docking: FollowerSettings,
    pub(crate) localization: Localization,
    pub(crate) route: RouteShape,
    pub(crate) path_limits: PathLimits,
    pub(crate) waypoint_tolerance: Millimeters,
    pub(crate) standoff_mm: f64,
    pub(crate) tolerance_mm: f64,
    pub(crate) tolerance_deg: f64,
    pub(crate) default_zone_mm: f64,
    pub(crate) battery: BatterySection,
    pub(crate) backoff: Backoff,
    pub(crate) detects_loads: bool,
    pub(crate) slots: Vec<SlotLoadBody>,
    pub(crate) places: BTreeMap<String, Place>,
    pub(crate) obstacles: Vec<Obstacle>,
}

/// A place of the robot's map.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) pose: PlanarPose,
    pub(crate) zone: Option<Zone>,
    pub(crate) unload: Option<Duration>,
}

impl Plan {
    pub(crate) fn try_new(config: &MobileConfig) -> Result<Self, ConfigError> {
        let key = |key: &'static str, value, range| {
            number(key, value, range).map_err(|error| ConfigError::new(key, error))
        };
        let _ = id("id", &config.id).map_err(|error| ConfigError::new("id", error))?;
        if config.id.contains('/') {
            return Err(ConfigError::new("id", "a robot's id has no `/`"));
        }
        if !(1..=100).contains(&config.step_ms) {
            let reason = format!("is {}; it must be from 1 to 100", config.step_ms);
            return Err(ConfigError::new("step_ms", reason));
        }
        let heartbeat = key("heartbeat_s", config.heartbeat_s, (0.1, 60.0))?;
        let base = MecanumBase::try_new(&Dimensions {
            wheel_radius: Millimeters(config.base.wheel_radius_mm),
            wheelbase: Millimeters(config.base.wheelbase_mm),
            track: Millimeters(config.base.track_mm),
            max_wheel_speed: RadPerSec(config.base.max_wheel_speed_rad_s),
        })
        .map_err(ConfigError::in_section("base"))?;
        let footprint = Footprint::rectangle(
            Millimeters(config.footprint.length_mm),
            Millimeters(config.footprint.width_mm),
        )
        .map_err(ConfigError::in_section("footprint"))?;
        let guard = GuardSettings {
            footprint: footprint.clone(),
            stop_distance: Millimeters(config.guard.stop_distance_mm),
            resume_distance: Millimeters(config.guard.resume_distance_mm),
            deceleration: MmPerSec2(config.guard.deceleration_mm_s2),
        };
        let (driving, docking) = laws(config)?;
        let docks = &config.docking;
        let tolerance_deg = key("docking.tolerance_deg", docks.tolerance_deg, (0.01, 45.0))?;
        let plan = Self {
            id: config.id.clone(),
            step: Duration::from_millis(config.step_ms),
            heartbeat: Duration::from_secs_f64(heartbeat),
            start: pose_of(&config.start).map_err(ConfigError::in_section("start"))?,
            base,
            footprint,
            guard,
            driving,
            docking,
            localization: Localization::Odometry {
                noise: Degrees(config.localization.noise_deg).into(),
                seed: config.localization.seed,
            },
            route: config.drive.route,
            path_limits: PathLimits {
                speed: MmPerSec(config.drive.speed_mm_s),
                acceleration: MmPerSec2(config.drive.acceleration_mm_s2),
                lateral_acceleration: MmPerSec2(config.drive.lateral_acceleration_mm_s2),
                min_radius: Millimeters(config.drive.min_radius_mm),
            },
            waypoint_tolerance: Millimeters(key(
                "drive.waypoint_tolerance_mm",
                config.drive.waypoint_tolerance_mm,
                (1.0, 10_000.0),
            )?),
            standoff_mm: key("docking.standoff_mm", docks.standoff_mm, (10.0, 1e4))?,
            tolerance_mm: key("docking.tolerance_mm", docks.tolerance_mm, (0.5, 1e3))?,
            tolerance_deg,
            default_zone_mm: key("docking.default_zone_mm", docks.default_zone_mm, (1.0, 1e5))?,
            battery: battery(&config.battery)?,
            backoff: backoff(config)?,
            detects_loads: config.detects_loads,
            slots: slots(config)?,
            places: places(config)?,
            obstacles: obstacles(config)?,
        };
        // The follower refuses what it is given only when it is made.
        for (section, settings) in [("drive", &plan.driving), ("docking", &plan.docking)] {
            let there = Leg::Waypoint(Waypoint {
                point: plan.start.position(),
                tolerance: plan.waypoint_tolerance,
                heading: WaypointHeading::Hold,
            });
            let made = Route::try_new(vec![there])
                .and_then(|route| Follower::try_new(plan.base, settings, route, plan.start));
            let _follower = made.map_err(ConfigError::in_section(section))?;
        }
        let _guard =
            Guard::try_new(plan.guard.clone()).map_err(ConfigError::in_section("guard"))?;
        for (number, fault) in config.faults.iter().enumerate() {
            let refuse = |error| ConfigError::new(format!("faults[{number}]"), error);
            fault.check().map_err(refuse)?;
        }
        if config.link.poll_wait_s > MAX_OUTBOX_WAIT_S {
            let wait = config.link.poll_wait_s;
            let reason = format!("is {wait}; it must be from 0 to {MAX_OUTBOX_WAIT_S}");
            return Err(ConfigError::new("link.poll_wait_s", reason));
        }
        if !(10..=10_000).contains(&config.link.step_poll_ms) {
            let reason = format!(
                "is {}; it must be from 10 to 10000",
                config.link.step_poll_ms
            );
            return Err(ConfigError::new("link.step_poll_ms", reason));
        }
        Ok(plan)
    }
}

impl Plan {
    /// The zones of its map, by their points.
    pub(crate) fn zones(&self) -> BTreeMap<String, Zone> {
        let zones = self.places.iter().filter_map(|(name, place)| {
            let zone = place.zone.clone()?;
            Some((name.clone(), zone))
        });
        zones.collect()
    }
}

/// How it follows routes, and how it docks.
fn laws(config: &MobileConfig) -> Result<(FollowerSettings, FollowerSettings), ConfigError> {
    let drive = &config.drive;
    let approach = match drive.approach {
        ApproachSection::Sign {} => Approach::Sign,
        ApproachSection::Exponential { k_per_mm } => Approach::Exponential {
            k: PerMillimeter(k_per_mm),
        },
        ApproachSection::Tanh { scale_mm } => Approach::Tanh {
            scale: Millimeters(scale_mm),
        },
    };
    let driving = FollowerSettings {
        point_law: PointLaw::try_new(&PointGains {
            speed: MmPerSec(drive.speed_mm_s),
            turn: PerSecond(drive.turn_rate_per_s),
            approach,
        })
        .map_err(ConfigError::in_section("drive"))?,
        tracking_law: TrackingLaw::try_new(drive.tracking_rates_per_s.map(PerSecond))
            .map_err(ConfigError::in_section("drive.tracking_rates_per_s"))?,
        acceleration: MmPerSec2(drive.acceleration_mm_s2),
        heading_tolerance: Degrees(drive.heading_tolerance_deg).into(),
        max_deviation: Millimeters(drive.max_deviation_mm),
    };
    let docking = FollowerSettings {
        point_law: PointLaw::try_new(&PointGains {
            speed: MmPerSec(config.docking.speed_mm_s),
            turn: PerSecond(drive.turn_rate_per_s),
            approach: Approach::Tanh {
                scale: Millimeters(config.docking.scale_mm),
            },
        })
        .map_err(ConfigError::in_section("docking"))?,
        // A fifth of what is asked, so that the dock is met and not just touched.
        heading_tolerance: Degrees(0.2 * config.docking.tolerance_deg).into(),
        ..driving
    };
    Ok((driving, docking))
}

fn battery(section: &BatterySection) -> Result<BatterySection, ConfigError> {
    let key = |key: &'static str, value, range| {
        number(key, value, range).map_err(|error| ConfigError::new(key, error))
    };
    let _ = key(
        "battery.charge_percent",
        section.charge_percent,
        (0.0, 100.0),
    )?;
    let drains = (0.0, 1e6);
    let _ = key(
        "battery.drain_percent_per_km",
        section.drain_percent_per_km,
        drains,
    )?;
    let _ = key(
        "battery.drain_percent_per_h",
        section.drain_percent_per_h,
        drains,
    )?;
    let low = key("battery.low_percent", section.low_percent, (0.0, 100.0))?;
    let _ = key("battery.empty_percent", section.empty_percent, (0.0, low))?;
    Ok(section.clone())
}

fn backoff(config: &MobileConfig) -> Result<Backoff, ConfigError> {
    let (first, last) = (config.link.retry_first_ms, config.link.retry_last_ms);
    if !(1..=60_000).contains(&first) {
        let reason = format!("is {first}; it must be from 1 to 60000");
        return Err(ConfigError::new("link.retry_first_ms", reason));
    }
    if !(first..=600_000).contains(&last) {
        let reason = format!("is {last}; it must be from retry_first_ms ({first}) to 600000");
        return Err(ConfigError::new("link.retry_last_ms", reason));
    }
    Ok(Backoff {
        first: Duration::from_millis(first),
        last: Duration::from_millis(last),
    })
}

fn slots(config: &MobileConfig) -> Result<Vec<SlotLoadBody>, ConfigError> {
    let count = config.slots.len();
    if count > MAX_SIGNAL_ITEMS {
        let reason = format!("{count} slots; at most {MAX_SIGNAL_ITEMS}");
        return Err(ConfigError::new("slots", reason));
    }
    let (mut ids, mut loads) = (BTreeSet::new(), BTreeSet::new());
    for (number, slot) in config.slots.iter().enumerate() {
        let refuse =
            |key: &str, reason: String| ConfigError::new(format!("slots[{number}].{key}"), reason);
        let _ = id("the slot", &slot.id).map_err(|error| refuse("id", error.to_string()))?;
        if !ids.insert(&slot.id) {
            return Err(refuse("id", format!("there are two slots `{}`", slot.id)));
        }
        if let Some(load) = &slot.load {
            let _ = id("the load", load).map_err(|error| refuse("load", error.to_string()))?;
            if !loads.insert(load) {
                return Err(refuse("load", format!("`{load}` lies in two slots")));
            }
        }
    }
    let slots = config.slots.iter().map(|slot| SlotLoadBody {
        slot: slot.id.clone(),
        load: slot.load.clone(),
    });
    Ok(slots.collect())
}

fn places(config: &MobileConfig) -> Result<BTreeMap<String, Place>, ConfigError> {
    let count = config.points.len();
    if count > MAX_POINTS {
        let reason = format!("{count} points; at most {MAX_POINTS}");
        return Err(ConfigError::new("points", reason));
    }
    let mut places = BTreeMap::new();
    for (number, point) in config.points.iter().enumerate() {
        let refuse =
            |key: &str, reason: String| ConfigError::new(format!("points[{number}].{key}"), reason);
        let _ = id("the point", &point.id).map_err(|error| refuse("id", error.to_string()))?;
        let unload = point.unload_s.map(|seconds| {
            crate::error::number("unload_s", seconds, (0.0, 86_400.0))
                .map(Duration::from_secs_f64)
                .map_err(|error| refuse("unload_s", error.to_string()))
        });
        let place = Place {
            pose: pose_of(&point.pose).map_err(|error| refuse("pose", error.to_string()))?,
            zone: point
                .zone
                .map(|area| Zone::try_new(area).map_err(|reason| refuse("zone", reason)))
                .transpose()?,
            unload: unload.transpose()?,
        };
        if places.insert(point.id.clone(), place).is_some() {
            return Err(refuse("id", format!("there are two points `{}`", point.id)));
        }
    }
    Ok(places)
}

fn obstacles(config: &MobileConfig) -> Result<Vec<Obstacle>, ConfigError> {
    let count = config.obstacles.len();
    if count > MAX_OBSTACLES {
        let reason = format!("{count} obstacles; at most {MAX_OBSTACLES}");
        return Err(ConfigError::new("obstacles", reason));
    }
    let each = config.obstacles.iter().enumerate().map(|(number, one)| {
        Point::try_new(Millimeters(one.x_mm), Millimeters(one.y_mm))
            .and_then(|center| Obstacle::disc(center, Millimeters(one.radius_mm)))
            .map_err(|error| ConfigError::new(format!("obstacles[{number}]"), error))
    });
    each.collect()
}
