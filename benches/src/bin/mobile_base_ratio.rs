//! Prints how many control steps of the mobile base a core makes in a second: `cargo run --release -p
//! benches --bin mobile_base_ratio`.
//!
//! A step is what a controller does and what its base then does: law, wheel limits, inverse
//! kinematics, limit check, forward kinematics, an exact arc.

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use mobile_base::{
    Approach, BodyTwist, Dimensions, FollowerSettings, Footprint, GuardSettings, HeadingReference,
    Leg, Localization, MecanumBase, Obstacle, PlanarPose, Point, PointGains, PointLaw, Reference,
    Robot, RobotSettings, Route, TrackingLaw, Waypoint, WaypointHeading, WorldTwist,
};
use units::{Degrees, Millimeters, MmPerSec, MmPerSec2, PerSecond, RadPerSec, Radians};

const GOAL: f64 = 5e6;
const STEPS: u32 = 500_000;
const REPEATS: usize = 31;
const STEP: Duration = Duration::from_millis(10);

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() -> Result<()> {
    let base = base()?;
    let law = law()?;
    let tracking = TrackingLaw::try_new([PerSecond(2.0); 3])?;
    println!(
        "steps a second on one core, {REPEATS} repeats of {STEPS} steps; the goal is {GOAL:.0}"
    );
    println!("{:<40} {:>12} {:>7} {:>12}", "", "median", "", "best");
    let row = |name: &str, rates: Rates| {
        let Rates { median, best } = rates;
        let ratio = median / GOAL;
        println!("{name:<40} {median:>12.0} {ratio:>6.2}x {best:>12.0}");
    };
    let target = Point::try_new(Millimeters(0.0), Millimeters(0.0))?;
    let mode_1 = rate(|pose, _| {
        let wanted = law.fixed_course(pose, target, Radians(0.3));
        drive(&base, pose, &wanted)
    })?;
    row("mode 1, course fixed to the body (8)", mode_1);
    let heading = HeadingReference {
        angle: Radians(1.0),
        rate: RadPerSec(0.2),
    };
    let mode_2 = rate(|pose, _| {
        let wanted = law.free_heading(pose, target, black_box(&heading));
        drive(&base, pose, &wanted)
    })?;
    row("mode 2, heading free (10)", mode_2);
    let tracked = rate(|pose, number| {
        let reference = circle(f64::from(number) * STEP.as_secs_f64())?;
        drive(&base, pose, &tracking.command(pose, &reference))
    })?;
    row("tracking a circle (11), circle included", tracked);
    row("robot on a route, four obstacles", robot_rate(base)?);
    Ok(())
}

/// Steps a second, over the repeats. The best one is what a core does that nobody else uses.
struct Rates {
    median: f64,
    best: f64,
}

impl Rates {
    fn of(mut run: impl FnMut() -> Result<f64>) -> Result<Rates> {
        // Once to warm up.
        let _ = run()?;
        let mut rates = (0..REPEATS).map(|_| run()).collect::<Result<Vec<_>>>()?;
        rates.sort_by(f64::total_cmp);
        let (median, best) = (rates.get(REPEATS / 2), rates.last());
        let (median, best) = median.zip(best).context("no repeats")?;
        Ok(Rates {
            median: *median,
            best: *best,
        })
    }
}

/// Limits, wheels, and where the base is then.
fn drive(base: &MecanumBase, pose: PlanarPose, wanted: &BodyTwist) -> Result<PlanarPose> {
    let wheels = base.inverse(&base.scale_to_limits(wanted)?.twist);
    base.check(&wheels)?;
    Ok(pose.moved_by(&base.displacement(&wheels.over(STEP)))?)
}

/// Steps a second. The base starts anew from time to time, so that it never just stands.
fn rate(mut step: impl FnMut(PlanarPose, u32) -> Result<PlanarPose>) -> Result<Rates> {
    let start = PlanarPose::try_new(Millimeters(3000.0), Millimeters(-2000.0), Radians(0.4))?;
    let run = || -> Result<f64> {
        let begun = Instant::now();
        let mut pose = start;
        for number in 0..STEPS {
            if number % 500 == 0 {
                pose = black_box(start);
            }
            pose = step(pose, number)?;
        }
        let _ = black_box(pose);
        Ok(f64::from(STEPS) / begun.elapsed().as_secs_f64())
    };
    Rates::of(run)
}

fn circle(time: f64) -> Result<Reference> {
    let (sin, cos) = (0.5 * time).sin_cos();
    Ok(Reference {
        pose: PlanarPose::try_new(
            Millimeters(1000.0 * cos),
            Millimeters(1000.0 * sin),
            Radians(0.2 * time),
        )?,
        velocity: WorldTwist {
            x: MmPerSec(-500.0 * sin),
            y: MmPerSec(500.0 * cos),
            turn: RadPerSec(0.2),
        },
    })
}

/// The whole simulated robot: odometry with noise, guard, follower.
fn robot_rate(base: MecanumBase) -> Result<Rates> {
    let follower = FollowerSettings {
        point_law: law()?,
        tracking_law: TrackingLaw::try_new([PerSecond(2.0); 3])?,
        acceleration: MmPerSec2(800.0),
        heading_tolerance: Degrees(0.5).into(),
        max_deviation: Millimeters(300.0),
    };
    let settings = RobotSettings {
        base,
        follower,
        guard: Some(GuardSettings {
            footprint: Footprint::rectangle(Millimeters(800.0), Millimeters(600.0))?,
            stop_distance: Millimeters(200.0),
            resume_distance: Millimeters(300.0),
            deceleration: MmPerSec2(800.0),
        }),
        localization: Localization::Odometry {
            noise: Radians(0.001),
            seed: 1,
        },
    };
    let corners = [(4e3, 4e3), (-4e3, 4e3), (-4e3, -4e3), (4e3, -4e3)];
    let point = |(x, y)| Point::try_new(Millimeters(x), Millimeters(y));
    let mut robot = Robot::try_new(settings, PlanarPose::default())?;
    let mut obstacles = Vec::new();
    let mut legs = Vec::new();
    for (x, y) in corners {
        obstacles.push(Obstacle::disc(point((x, y))?, Millimeters(300.0))?);
        legs.push(Leg::Waypoint(Waypoint {
            point: point((0.6 * x, 0.6 * y))?,
            tolerance: Millimeters(5.0),
            heading: WaypointHeading::Hold,
        }));
    }
    robot.set_obstacles(obstacles);
    let route = Route::try_new(legs)?;
    Rates::of(|| {
        let begun = Instant::now();
        for number in 0..STEPS {
            if number % 2000 == 0 {
                robot.start(route.clone())?;
            }
            let _ = black_box(robot.step(STEP)?);
        }
        Ok(f64::from(STEPS) / begun.elapsed().as_secs_f64())
    })
}

fn base() -> Result<MecanumBase> {
    Ok(MecanumBase::try_new(&Dimensions {
        wheel_radius: Millimeters(100.0),
        wheelbase: Millimeters(600.0),
        track: Millimeters(400.0),
        max_wheel_speed: RadPerSec(20.0),
    })?)
}

fn law() -> Result<PointLaw> {
    Ok(PointLaw::try_new(&PointGains {
        speed: MmPerSec(800.0),
        turn: PerSecond(2.0),
        approach: Approach::Tanh {
            scale: Millimeters(300.0),
        },
    })?)
}
