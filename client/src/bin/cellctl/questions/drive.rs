//! A mecanum base that drives a route, for the drawing of its wheels.

use std::time::Duration;

use api::paths::PlanRouteResult;
use clap::{Args, ValueEnum};
use mobile_base::{
    Approach, Dimensions, DriveState, FollowerSettings, Leg, Localization, MecanumBase, PlanarPose,
    Point, PointGains, PointLaw, Robot, RobotSettings, Route, TrackingLaw, Waypoint,
    WaypointHeading,
};
use plots::answers::{Drive, DriveSample};
use units::{Degrees, Millimeters, MmPerSec, MmPerSec2, PerSecond, RadPerSec, Radians};

use crate::failure::Failure;
use crate::numbers::finite;

/// One step of the calculation.
const STEP: Duration = Duration::from_millis(10);
/// A drive that takes longer is not drawn.
const LONGEST: Duration = Duration::from_hours(1);

/// The base that drives the route, for `--view wheels`.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "The base of --view wheels")]
pub(super) struct BaseArgs {
    /// The radius of the wheels, over the rollers, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, default_value_t = 100.0, allow_hyphen_values = true)]
    wheel_radius: f64,
    /// From the front axle to the rear axle, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, default_value_t = 600.0, allow_hyphen_values = true)]
    wheelbase: f64,
    /// From the left wheels to the right ones, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, default_value_t = 400.0, allow_hyphen_values = true)]
    track: f64,
    /// The highest speed of a wheel, in rad/s.
    #[arg(long, value_name = "RAD_S", value_parser = finite, default_value_t = 12.0, allow_hyphen_values = true)]
    max_wheel_speed: f64,
    /// The base's speed, in mm/s.
    #[arg(long, value_name = "MM_S", value_parser = finite, default_value_t = 800.0, allow_hyphen_values = true)]
    base_speed: f64,
    /// How it gains speed and brakes, in mm/s2.
    #[arg(long, value_name = "MM_S2", value_parser = finite, default_value_t = 1000.0, allow_hyphen_values = true)]
    base_acceleration: f64,
    /// Where it looks.
    #[arg(long, value_enum, default_value = "along")]
    heading: HeadingArg,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum HeadingArg {
    /// Mode 1: where it drives.
    Along,
    /// Mode 2: always along X of the floor.
    Hold,
}

/// Drives the route from start to goal. A corner is passed so near that the disc stays clear.
pub(super) fn along(route: &PlanRouteResult, base: &BaseArgs) -> Result<(String, Drive), Failure> {
    let out_of_range =
        |error: mobile_base::OutOfRange| Failure::Usage(format!("the base: {error}"));
    let dimensions = Dimensions {
        wheel_radius: Millimeters(base.wheel_radius),
        wheelbase: Millimeters(base.wheelbase),
        track: Millimeters(base.track),
        max_wheel_speed: RadPerSec(base.max_wheel_speed),
    };
    let settings = RobotSettings {
        base: MecanumBase::try_new(&dimensions).map_err(out_of_range)?,
        follower: FollowerSettings {
            point_law: PointLaw::try_new(&PointGains {
                speed: MmPerSec(base.base_speed),
                turn: PerSecond(2.0),
                approach: Approach::Tanh {
                    scale: Millimeters(300.0),
                },
            })
            .map_err(out_of_range)?,
            tracking_law: TrackingLaw::try_new([PerSecond(2.0); 3]).map_err(out_of_range)?,
            acceleration: MmPerSec2(base.base_acceleration),
            heading_tolerance: Degrees(0.5).into(),
            max_deviation: Millimeters(200.0),
        },
        guard: None,
        localization: Localization::Exact,
    };
    let points: Vec<Point> = route
        .points_mm
        .iter()
        .map(|&[x, y]| Point::try_new(Millimeters(x), Millimeters(y)))
        .collect::<Result<_, _>>()
        .map_err(out_of_range)?;
    let tolerance = Millimeters(route.clearance_mm.clamp(1.0, 50.0));
    let heading = match base.heading {
        HeadingArg::Along => WaypointHeading::FixedCourse {
            course: Radians(0.0),
        },
        HeadingArg::Hold => WaypointHeading::Hold,
    };
    let legs: Vec<Leg> = points
        .iter()
        .skip(1)
        .map(|point| {
            Leg::Waypoint(Waypoint {
                point: *point,
                tolerance,
                heading,
            })
        })
        .collect();
    let first_way = route.points_mm.iter().zip(route.points_mm.iter().skip(1));
    let looks = first_way
        .map(|(a, b)| match base.heading {
            HeadingArg::Along => (b[1] - a[1]).atan2(b[0] - a[0]),
            HeadingArg::Hold => 0.0,
        })
        .next()
        .unwrap_or(0.0);
    let [x, y] = route.points_mm.first().copied().unwrap_or_default();
    let start = PlanarPose::try_new(Millimeters(x), Millimeters(y), Radians(looks))
        .map_err(out_of_range)?;
    let mut robot = Robot::try_new(settings, start).map_err(out_of_range)?;
    robot
        .start(Route::try_new(legs).map_err(out_of_range)?)
        .map_err(out_of_range)?;
    let drive = Drive {
        samples: driven(&mut robot)?,
        max_wheel_speed_rad_s: base.max_wheel_speed,
    };
    let mode = match base.heading {
        HeadingArg::Along => "looking where it drives (mode 1)",
        HeadingArg::Hold => "keeping its heading (mode 2)",
    };
    Ok((format!("A mecanum base on the route, {mode}"), drive))
}

fn driven(robot: &mut Robot) -> Result<Vec<DriveSample>, Failure> {
    let mut time = Duration::ZERO;
    let mut samples = vec![sample(robot, time)];
    loop {
        let state = robot
            .step(STEP)
            .map_err(|error| Failure::Usage(format!("driving the route: {error}")))?;
        time += STEP;
        samples.push(sample(robot, time));
        match state {
            Some(DriveState::Driving) if time < LONGEST => {}
            Some(DriveState::Arrived(_)) | None => return Ok(samples),
            Some(DriveState::Driving) => {
                return Err(Failure::Usage(format!(
                    "the drive takes more than {} s; a faster base can be drawn (--base-speed)",
                    LONGEST.as_secs()
                )));
            }
            Some(DriveState::Stopped(why)) => {
                return Err(Failure::Usage(format!("the base stopped: {why:?}")));
            }
        }
    }
}

fn sample(robot: &Robot, time: Duration) -> DriveSample {
    let pose = robot.pose();
    let twist = robot.twist();
    DriveSample {
        time_s: time.as_secs_f64(),
        x_mm: pose.position().x().0,
        y_mm: pose.position().y().0,
        heading_deg: pose.heading().0.to_degrees(),
        speed_mm_s: twist.speed().0,
        turn_deg_s: twist.turn.0.to_degrees(),
        wheels_rad_s: robot.wheel_speeds().0.map(|speed| speed.0),
    }
}
