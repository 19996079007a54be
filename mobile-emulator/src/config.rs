//! What a virtual mobile robot is made of, as its file writes it.
//!
//! Units are in the keys. What the numbers make is checked when the robot starts, see
//! [`ConfigError`].

use std::net::SocketAddr;

use api::{FloorAreaBody, FloorPoseBody, OperatingMode};
use serde::Deserialize;

use crate::core::Core;
use crate::error::ConfigError;
use crate::fault::Fault;

/// A mobile robot. Every key has a default, so `MobileConfig::default()` is a robot that drives.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct MobileConfig {
    /// The robot's id, as the cell knows it: 1 to 64 of `A-Z a-z 0-9 . _ -`.
    pub id: String,
    /// The number of its first start. Absent: seconds since 1970, so that it grows when the process starts again; 1
    /// with a stepped clock.
    pub boot: Option<u64>,
    /// One step of its control laws, 1 to 100.
    pub step_ms: u64,
    /// Between two heartbeats, 0.1 to 60.
    pub heartbeat_s: f64,
    /// The operating mode at the start.
    pub mode: OperatingMode,
    /// Where it stands at the start.
    pub start: FloorPoseBody,
    /// Its wheels.
    pub base: BaseSection,
    /// Its outline.
    pub footprint: FootprintSection,
    /// How it drives.
    pub drive: DriveSection,
    /// How it docks.
    pub docking: DockingSection,
    /// How it stops before obstacles, and before zones it has no permit for.
    pub guard: GuardSection,
    /// How it knows where it is.
    pub localization: LocalizationSection,
    /// Its battery.
    pub battery: BatterySection,
    /// How it talks to the cell.
    pub link: LinkSection,
    /// It sees what lies in its slots. Without, it tells of no loads at all, which is not the same as telling of none.
    pub detects_loads: bool,
    /// Its load slots, at most 64.
    pub slots: Vec<SlotSection>,
    /// The places of its own map, at most 1000.
    pub points: Vec<PointSection>,
    /// What stands around.
    pub obstacles: Vec<ObstacleSection>,
    /// What goes wrong.
    pub faults: Vec<Fault>,
    /// Its page and state view; none where absent.
    pub view: Option<ViewSection>,
}

/// `[base]`: four mecanum wheels.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct BaseSection {
    /// Radius of the wheels, over the rollers.
    pub wheel_radius_mm: f64,
    /// From the front axle to the rear axle.
    pub wheelbase_mm: f64,
    /// From the left wheels to the right ones.
    pub track_mm: f64,
    /// The highest speed of a wheel.
    pub max_wheel_speed_rad_s: f64,
}

/// `[footprint]`: a rectangle around the middle of the wheels.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct FootprintSection {
    /// Along x of the robot.
    pub length_mm: f64,
    /// Along y of the robot.
    pub width_mm: f64,
}

/// `[drive]`: between places.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct DriveSection {
    /// The highest speed.
    pub speed_mm_s: f64,
    /// Starting and braking.
    pub acceleration_mm_s2: f64,
    /// The rate at which an error of the heading decays.
    pub turn_rate_per_s: f64,
    /// f(rho) of the law.
    pub approach: ApproachSection,
    /// The rates at which errors along x, y and of the heading decay on a path.
    pub tracking_rates_per_s: [f64; 3],
    /// How routes lead through their places.
    pub route: RouteShape,
    /// A place on the way is passed this near.
    pub waypoint_tolerance_mm: f64,
    /// The heading at the end of a drive.
    pub heading_tolerance_deg: f64,
    /// Across a path, which sets the speed in its bends.
    pub lateral_acceleration_mm_s2: f64,
    /// Tighter bends of a path are refused.
    pub min_radius_mm: f64,
    /// Farther from its path than this it stops.
    pub max_deviation_mm: f64,
}

/// f(rho): how the speed falls towards the target.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(tag = "law", rename_all = "SCREAMING_SNAKE_CASE", deny_unknown_fields)]
pub enum ApproachSection {
    /// sign(rho).
    Sign {},
    /// (1 - e^(-k rho)) / (1 + e^(-k rho)).
    Exponential {
        /// k.
        k_per_mm: f64,
    },
    /// tanh(rho / scale).
    Tanh {
        /// At this distance the speed is 76 % of the full one.
        scale_mm: f64,
    },
}

/// How a route leads through its places.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum RouteShape {
    /// Straight from one to the next.
    #[default]
    Waypoints,
    /// Along a cubic spline through all of them.
    Spline,
}

/// `[docking]`: the last of the way.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct DockingSection {
    /// The highest speed.
    pub speed_mm_s: f64,
    /// The law's tanh(rho / scale).
    pub scale_mm: f64,
    /// How far before the dock it stops and looks for it, 10 to 10,000.
    pub standoff_mm: f64,
    /// How near the dock it must stand, where the order does not say.
    pub tolerance_mm: f64,
    /// The same for the heading.
    pub tolerance_deg: f64,
    /// A point without a zone of its own has a square one, this far around the dock.
    pub default_zone_mm: f64,
}

/// `[guard]`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct GuardSection {
    /// It comes no nearer.
    pub stop_distance_mm: f64,
    /// Once stopped, it goes on when there is this much room.
    pub resume_distance_mm: f64,
    /// How it brakes.
    pub deceleration_mm_s2: f64,
}

/// `[localization]`: dead reckoning, corrected by the marker of a dock.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct LocalizationSection {
    /// Standard deviation of a wheel's angle after one radian.
    pub noise_deg: f64,
    /// The same seed gives the same errors.
    pub seed: u64,
}

/// `[battery]`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct BatterySection {
    /// At the start.
    pub charge_percent: f64,
    /// What driving takes.
    pub drain_percent_per_km: f64,
    /// What standing takes.
    pub drain_percent_per_h: f64,
    /// Below this it warns.
    pub low_percent: f64,
    /// At this it stands.
    pub empty_percent: f64,
}

/// `[link]`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct LinkSection {
    /// Whether it asks for its messages, or only takes what is pushed.
    pub poll: bool,
    /// How long one question for messages waits, 0 to 30.
    pub poll_wait_s: u32,
    /// Between two questions in stepped time, 10 to 10,000.
    pub step_poll_ms: u64,
    /// An unanswered signal is sent again after this time, then twice as long each time..
    pub retry_first_ms: u64,
    /// .. up to this.
    pub retry_last_ms: u64,
}

/// `[[slots]]`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct SlotSection {
    /// The slot.
    pub id: String,
    /// What lies in it at the start.
    #[serde(default)]
    pub load: Option<String>,
}

/// `[[points]]`: a place of the robot's map.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PointSection {
    /// `station/point`.
    pub id: String,
    /// Where the robot stands there.
    pub pose: FloorPoseBody,
    /// The zone it needs a permit for.
    #[serde(default)]
    pub zone: Option<FloorAreaBody>,
    /// As a destination: all loads are taken off here after this time; they stay where absent.
    #[serde(default)]
    pub unload_s: Option<f64>,
}

/// `[[obstacles]]`: round.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "a circle")]
pub struct ObstacleSection {
    pub x_mm: f64,
    pub y_mm: f64,
    pub radius_mm: f64,
}

/// `[view]`: page and state over HTTP. It changes the robot for anybody who connects.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ViewSection {
    /// Where; port 0 for any free one.
    pub address: SocketAddr,
    /// Permit an address that other machines can reach.
    #[serde(default)]
    pub expose_to_network: bool,
}

impl MobileConfig {
    /// The default robot with this id.
    #[must_use]
    pub fn new(id: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            ..Self::default()
        }
    }

    /// With one more slot, and what lies in it.
    #[must_use]
    pub fn with_slot(mut self, id: &str, load: Option<&str>) -> Self {
        self.slots.push(SlotSection {
            id: id.to_owned(),
            load: load.map(str::to_owned),
        });
        self
    }

    /// With one more fault.
    #[must_use]
    pub fn with_fault(mut self, fault: Fault) -> Self {
        self.faults.push(fault);
        self
    }

    /// Whether it makes a robot, without starting one.
    ///
    /// # Errors
    /// The first key that does not fit.
    pub fn check(&self) -> Result<(), ConfigError> {
        Core::try_new(self, jiff::Timestamp::UNIX_EPOCH, 1).map(drop)
    }

    /// Reads a file's text.
    ///
    /// # Errors
    /// Not TOML, or a key that is unknown, missing or of the wrong type; the message names line and key.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }
}

impl Default for MobileConfig {
    fn default() -> Self {
        Self {
            id: "mr1".to_owned(),
            boot: None,
            step_ms: 10,
            heartbeat_s: 1.0,
            mode: OperatingMode::Automatic,
            start: FloorPoseBody::default(),
            base: BaseSection::default(),
            footprint: FootprintSection::default(),
            drive: DriveSection::default(),
            docking: DockingSection::default(),
            guard: GuardSection::default(),
            localization: LocalizationSection::default(),
            battery: BatterySection::default(),
            link: LinkSection::default(),
            detects_loads: true,
            slots: Vec::new(),
            points: Vec::new(),
            obstacles: Vec::new(),
            faults: Vec::new(),
            view: None,
        }
    }
}

impl Default for BaseSection {
    fn default() -> Self {
        Self {
            wheel_radius_mm: 100.0,
            wheelbase_mm: 600.0,
            track_mm: 400.0,
            max_wheel_speed_rad_s: 20.0,
        }
    }
}

impl Default for FootprintSection {
    fn default() -> Self {
        Self {
            length_mm: 800.0,
            width_mm: 600.0,
        }
    }
}

impl Default for DriveSection {
    fn default() -> Self {
        Self {
            speed_mm_s: 800.0,
            acceleration_mm_s2: 800.0,
            turn_rate_per_s: 2.0,
            approach: ApproachSection::Tanh { scale_mm: 300.0 },
            tracking_rates_per_s: [2.0; 3],
            route: RouteShape::Waypoints,
            waypoint_tolerance_mm: 100.0,
            heading_tolerance_deg: 1.0,
            lateral_acceleration_mm_s2: 600.0,
            min_radius_mm: 200.0,
            max_deviation_mm: 300.0,
        }
    }
}

impl Default for DockingSection {
    fn default() -> Self {
        Self {
            speed_mm_s: 150.0,
            scale_mm: 50.0,
            standoff_mm: 500.0,
            tolerance_mm: 5.0,
            tolerance_deg: 0.5,
            default_zone_mm: 1500.0,
        }
    }
}

impl Default for GuardSection {
    fn default() -> Self {
        Self {
            stop_distance_mm: 100.0,
            resume_distance_mm: 150.0,
            deceleration_mm_s2: 800.0,
        }
    }
}

impl Default for LocalizationSection {
    fn default() -> Self {
        Self {
            noise_deg: 0.0,
            seed: 1,
        }
    }
}

impl Default for BatterySection {
    fn default() -> Self {
        Self {
            charge_percent: 100.0,
            drain_percent_per_km: 2.0,
            drain_percent_per_h: 1.0,
            low_percent: 20.0,
            empty_percent: 2.0,
        }
    }
}

impl Default for LinkSection {
    fn default() -> Self {
        Self {
            poll: true,
            poll_wait_s: 20,
            step_poll_ms: 100,
            retry_first_ms: 250,
            retry_last_ms: 8000,
        }
    }
}
