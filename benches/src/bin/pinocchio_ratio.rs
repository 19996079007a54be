//! Prints how our Jacobian and inverse dynamics compare with Pinocchio's, and whether the targets
//! are met: `cargo xtask bench pinocchio`, which compiles Pinocchio's side.

use std::hint::black_box;

use anyhow::{Context as _, Result, ensure};
use benches::arms::{Case, arm, cases};
use benches::compare::{in_turn, time};
use benches::dynamics::{chain_states, coupling, heavy_arm, states};
use benches::pinocchio::{Peer, Task};
use benches::targets::Table;
use clap::Parser;
use kinematics::dynamics::{InverseDynamics, JointState, Load};
use kinematics::{ArmModel, Instructions, PendantJoints};

const STATES: usize = 10_000;
const REPEATS: usize = 31;
/// In each repeat, after one that does not count: the two sides are two processes, and what the
/// change from one to the other takes out of the caches is not what is measured.
const PASSES: u32 = 5;
/// The largest difference of a result: of a Jacobian in meters, of a torque as a part of the
/// largest one. It is what one side rounds otherwise.
const SAME: f64 = 1e-9;

/// Pinocchio's side, compiled.
#[derive(Debug, Parser)]
struct Options {
    /// For every x86-64.
    #[arg(long)]
    portable: String,
    /// For x86-64 with AVX2 and fused multiplication.
    #[arg(long)]
    avx2: String,
}

/// How many times faster than Pinocchio.
#[derive(Clone, Copy)]
struct Targets {
    one: f64,
    batch: f64,
}

const PORTABLE: Targets = Targets {
    one: 2.5,
    batch: 2.5,
};
const AVX2: Targets = Targets {
    one: 2.5,
    batch: 15.0,
};

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() -> Result<()> {
    let options = Options::parse();
    let cases = cases(STATES);
    println!(
        "M-20iA, {STATES} random states, {REPEATS} repeats of {PASSES} passes in turn, median, CPU time; Pinocchio 4.1.0 with -O3, \
         compiled for the same instructions"
    );
    for (name, instructions, program, targets) in [
        (
            "portable",
            Instructions::Portable,
            &options.portable,
            PORTABLE,
        ),
        ("AVX2", Instructions::Avx2, &options.avx2, AVX2),
    ] {
        match arm().with(instructions) {
            Some(arm) => report(name, &arm, instructions, program, &cases, targets)?,
            None => println!("\n{name}: not on this machine"),
        }
    }
    Ok(())
}

fn report(
    name: &str,
    arm: &ArmModel,
    instructions: Instructions,
    program: &str,
    cases: &[Case],
    targets: Targets,
) -> Result<()> {
    let heavy = heavy_arm()?;
    let states = states(&heavy, cases)?;
    let dynamics = InverseDynamics::of(&heavy, &Load::default())?;
    let dynamics = dynamics.with(instructions).context("the arm has them")?;
    let coupling = coupling(&heavy);
    let mut peer = Peer::start(program, &heavy, &chain_states(&heavy, &states))?;
    let table = Table::new(name);
    jacobian(&table, arm, cases, &coupling, &mut peer, targets)?;
    inverse_dynamics(&table, &dynamics, &states, &coupling, &mut peer, targets)
}

fn jacobian(
    table: &Table,
    arm: &ArmModel,
    cases: &[Case],
    coupling: &[Vec<f64>],
    peer: &mut Peer,
    targets: Targets,
) -> Result<()> {
    let joints: Vec<PendantJoints> = cases.iter().map(|case| case.joints).collect();
    let theirs = peer.results(Task::Jacobian, STATES)?;
    let mut worst = 0.0;
    arm.jacobian_batch(&joints, |index, batch| {
        let Some((joints, theirs)) = joints.get(index).zip(theirs.get(index)) else {
            worst = f64::INFINITY;
            return;
        };
        let wanted = by_displayed(coupling, theirs);
        for ours in [batch, &arm.jacobian(joints)] {
            worst = largest(worst, difference(&in_meters(ours.as_slice()), &wanted));
        }
    });
    ensure!(worst <= SAME, "the Jacobians differ by {worst:.1e}");
    table.at_most("largest difference of a Jacobian, m", worst, SAME);
    measured(
        table,
        ["Jacobian", "Jacobian, a batch"],
        targets,
        (peer, Task::Jacobian),
        || time(&joints, &mut |joints| arm.jacobian(joints)),
        || {
            arm.jacobian_batch(&joints, |_, jacobian| {
                let _ = black_box(jacobian);
            });
        },
    )
}

fn inverse_dynamics(
    table: &Table,
    dynamics: &InverseDynamics,
    states: &[JointState],
    coupling: &[Vec<f64>],
    peer: &mut Peer,
    targets: Targets,
) -> Result<()> {
    let theirs = peer.results(Task::InverseDynamics, STATES)?;
    let (mut worst, mut size) = (0.0, 0.0);
    dynamics.torques_batch(states, |index, batch| {
        let Some((state, theirs)) = states.get(index).zip(theirs.get(index)) else {
            worst = f64::INFINITY;
            return;
        };
        let wanted = by_displayed(coupling, theirs);
        size = wanted
            .iter()
            .map(|torque| torque.abs())
            .fold(size, f64::max);
        let one = dynamics.torques(state).unwrap_or_default();
        for ours in [batch, &one] {
            worst = largest(worst, difference(ours, &wanted));
        }
    })?;
    let part = worst / size;
    ensure!(
        part <= SAME,
        "the torques differ by {worst:.1e} of {size:.0} N m"
    );
    table.at_most("largest difference of a torque, part", part, SAME);
    let mut torques = [0.0; 6];
    measured(
        table,
        ["inverse dynamics", "inverse dynamics, a batch"],
        targets,
        (peer, Task::InverseDynamics),
        || {
            let one = &mut |state: &JointState| {
                let done = dynamics.torques_into(state, &mut torques);
                (done.is_ok(), black_box(&torques)[0])
            };
            time(states, one)
        },
        || {
            let done = dynamics.torques_batch(states, |_, torques| {
                let _ = black_box(torques);
            });
            let _ = black_box(done.is_ok());
        },
    )
}

/// One state at a time and a batch of them, each in turn with the peer.
fn measured(
    table: &Table,
    [name, name_batch]: [&str; 2],
    targets: Targets,
    (peer, task): (&mut Peer, Task),
    mut one: impl FnMut() -> f64,
    mut batch: impl FnMut(),
) -> Result<()> {
    let mut failed = None;
    let mut theirs = || {
        peer.run(task, PASSES).unwrap_or_else(|error| {
            failed = Some(error);
            f64::NAN
        })
    };
    let found = in_turn(REPEATS, || passes(&mut one), &mut theirs);
    table.ratio(name, found, Some(targets.one));
    let mut all = || time(&[()], &mut |()| batch()) / 1e4;
    let found = in_turn(REPEATS, || passes(&mut all), &mut theirs);
    table.ratio(name_batch, found, Some(targets.batch));
    failed.map_or(Ok(()), Err)
}

/// The mean of as many passes as the peer makes.
fn passes(pass: &mut impl FnMut() -> f64) -> f64 {
    let _ = pass();
    (0..PASSES).map(|_| pass()).sum::<f64>() / f64::from(PASSES)
}

/// What belongs to the table's variables, as it belongs to the displayed values: columns of a
/// Jacobian, or torques.
fn by_displayed(coupling: &[Vec<f64>], theirs: &[f64]) -> Vec<f64> {
    let rows = theirs.len() / coupling.len();
    let mut wanted = vec![0.0; theirs.len()];
    for (factors, column) in coupling.iter().zip(theirs.chunks(rows)) {
        for (factor, wanted) in factors.iter().zip(wanted.chunks_mut(rows)) {
            for (wanted, value) in wanted.iter_mut().zip(column) {
                *wanted += factor * value;
            }
        }
    }
    wanted
}

/// The upper three rows of each column are lengths.
fn in_meters(columns: &[f64]) -> Vec<f64> {
    let rows = columns.iter().enumerate();
    rows.map(|(index, value)| {
        if index % 6 < 3 {
            value / 1000.0
        } else {
            *value
        }
    })
    .collect()
}

fn difference(ours: &[f64], wanted: &[f64]) -> f64 {
    if ours.len() != wanted.len() {
        return f64::INFINITY;
    }
    let pairs = ours.iter().zip(wanted);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, largest)
}

/// Not a number is the largest there is.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::INFINITY
    } else {
        a.max(b)
    }
}
