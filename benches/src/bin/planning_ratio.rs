//! Prints how our trajectories compare with rsruckig, what planning among obstacles takes, and
//! whether the targets are met: `cargo xtask bench planning`.

use benches::compare::{compare, cpu_seconds};
use benches::targets::Table;
use kinematics::serial::SerialArm;
use kinematics::{Pose, Xyzwpr};
use planning::arm::{ArmShape, Obstacle, Scene, Workplace};
use planning::jerk::{JointMove, MotionLimits};
use planning::{Sampling, State, Wanted};
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use rsruckig::prelude::{InputParameter, Ruckig, ThrowErrorHandler, Trajectory};
use units::{Degrees, Millimeters};

const MOVES: usize = 5000;
const REPEATS: usize = 31;

struct Move {
    start: [State; 6],
    goal: [State; 6],
    limits: [MotionLimits; 6],
    theirs: InputParameter<6>,
}

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() -> anyhow::Result<()> {
    println!("six joints, {MOVES} random moves, {REPEATS} repeats in turn, median, CPU time");
    let table = Table::new("beside rsruckig 3.0.1");
    for (name, moving) in [("rest to rest", 0.0), ("any state to any state", 1.0)] {
        let moves = moves(moving)?;
        let mut otg = Ruckig::<6, ThrowErrorHandler>::new(None, 0.01);
        let mut trajectory = Trajectory::<6>::new(None);
        let mut worst: f64 = 0.0;
        for case in &moves {
            let ours = JointMove::try_new(&case.start, &case.goal, &case.limits)?.duration();
            if otg.calculate(&case.theirs, &mut trajectory).is_ok() {
                worst = worst.max((ours - trajectory.get_duration()).abs());
            }
        }
        let found = compare(
            &moves,
            REPEATS,
            |case| JointMove::try_new(&case.start, &case.goal, &case.limits),
            |case| otg.calculate(&case.theirs, &mut trajectory).is_ok(),
        );
        table.ratio(name, found, Some(1.2));
        println!(
            "{:<46} {worst:>9.1e}",
            "  longest difference of a duration, s"
        );
    }
    let (median, worst, solved) = transfers()?;
    table.at_most("arm transfer, 10 obstacles, median, ms", median, 50.0);
    println!("  100 seeds, {solved} solved, the worst in {worst:.1} ms");
    Ok(())
}

#[expect(
    clippy::indexing_slicing,
    reason = "the peer's arrays have six places, as ours"
)]
fn moves(moving: f64) -> anyhow::Result<Vec<Move>> {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let unit = Uniform::new(-1.0, 1.0)?;
    let mut next = || unit.sample(&mut random);
    let mut moves = Vec::with_capacity(MOVES);
    for _ in 0..MOVES {
        let mut case = Move {
            start: [State::default(); 6],
            goal: [State::default(); 6],
            limits: [MotionLimits {
                velocity: 1.0,
                acceleration: 1.0,
                jerk: 1.0,
            }; 6],
            theirs: InputParameter::new(None),
        };
        let joints = case.start.iter_mut().zip(&mut case.goal);
        for (joint, ((start, goal), limits)) in joints.zip(&mut case.limits).enumerate() {
            limits.velocity = 2.0 + next();
            limits.acceleration = 4.0 + 2.0 * next();
            limits.jerk = 20.0 + 10.0 * next();
            // Half the limits: no acceleration leads beyond the highest velocity.
            let mut state = || State {
                position: 3.0 * next(),
                velocity: 0.5 * moving * limits.velocity * next(),
                acceleration: 0.5 * moving * limits.acceleration * next(),
            };
            (*start, *goal) = (state(), state());
            let theirs = &mut case.theirs;
            theirs.current_position[joint] = start.position;
            theirs.current_velocity[joint] = start.velocity;
            theirs.current_acceleration[joint] = start.acceleration;
            theirs.target_position[joint] = goal.position;
            theirs.target_velocity[joint] = goal.velocity;
            theirs.target_acceleration[joint] = goal.acceleration;
            theirs.max_velocity[joint] = limits.velocity;
            theirs.max_acceleration[joint] = limits.acceleration;
            theirs.max_jerk[joint] = limits.jerk;
        }
        moves.push(case);
    }
    Ok(moves)
}

/// Milliseconds of the median and of the worst, and how many found a way.
fn transfers() -> anyhow::Result<(f64, f64, usize)> {
    let arm = SerialArm::builtin("fanuc-m20ia").ok_or_else(|| anyhow::anyhow!("no such arm"))?;
    let shape = ArmShape::of_model(arm)?;
    let scene = Scene::try_new(&obstacles()?)?;
    let start = arm.joints(&[45.0, 20.0, -20.0, 0.0, -70.0, 0.0])?;
    let goal = arm.joints(&[-45.0, 20.0, -20.0, 0.0, -70.0, 0.0])?;
    let place = Workplace {
        arm,
        shape: &shape,
        scene: &scene,
        margin: Millimeters(20.0),
    };
    let mut times = Vec::new();
    let mut solved = 0;
    for seed in 0..100 {
        let sampling = Sampling {
            seed,
            ..Sampling::default()
        };
        let begun = cpu_seconds();
        let found = place.transfer(&start, &goal, &sampling, Wanted::ALWAYS);
        times.push((cpu_seconds() - begun) * 1e3);
        solved += usize::from(found.is_ok());
    }
    times.sort_by(f64::total_cmp);
    let at = |index: usize| times.get(index).copied().unwrap_or(f64::NAN);
    Ok((at(times.len() / 2), at(times.len() - 1), solved))
}

/// The scene of planning's own tests.
fn obstacles() -> anyhow::Result<Vec<Obstacle>> {
    let at = |x: f64, y: f64, z: f64| {
        let position = [x, y, z].map(Millimeters);
        Pose::try_from_xyzwpr(&Xyzwpr::new(position, [Degrees(0.0); 3]))
    };
    let mut all = Vec::new();
    for ([x, y, z], size) in [
        ([900.0, 900.0, -200.0], [500.0, 500.0, 400.0]),
        ([900.0, -900.0, -200.0], [500.0, 500.0, 400.0]),
        ([1300.0, 0.0, 300.0], [100.0, 300.0, 1400.0]),
        ([-800.0, 0.0, 600.0], [200.0, 2000.0, 1200.0]),
        ([1000.0, 0.0, 1500.0], [600.0, 600.0, 50.0]),
    ] {
        all.push(Obstacle::Box {
            pose: at(x, y, z)?,
            size: size.map(Millimeters),
        });
    }
    for (x, y, radius, height) in [
        (800.0, 250.0, 60.0, 900.0),
        (800.0, -250.0, 60.0, 900.0),
        (1100.0, 400.0, 50.0, 1000.0),
        (1100.0, -400.0, 50.0, 1000.0),
    ] {
        all.push(Obstacle::Cylinder {
            pose: at(x, y, height / 2.0 - 400.0)?,
            radius: Millimeters(radius),
            height: Millimeters(height),
        });
    }
    all.push(Obstacle::KeepOut {
        min: [700.0, -100.0, -500.0].map(Millimeters),
        max: [1000.0, 100.0, 500.0].map(Millimeters),
    });
    Ok(all)
}
