//! Prints how our Jacobian compares with Pinocchio's, and whether the targets are met:
//! `cargo xtask bench pinocchio`, which compiles Pinocchio's side.

use std::hint::black_box;

use anyhow::{Context as _, Result, ensure};
use benches::arms::{Case, arm, cases};
use benches::compare::{in_turn, time};
use benches::pinocchio::{ChainState, Peer, Task};
use benches::targets::Table;
use clap::Parser;
use kinematics::serial::SerialArm;
use kinematics::{ArmModel, Instructions, PendantJoints};

const STATES: usize = 10_000;
const REPEATS: usize = 31;
/// Largest difference of a result, in meters and radians: what one side rounds otherwise.
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
struct Targets {
    one: f64,
    batch: f64,
}

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() -> Result<()> {
    let options = Options::parse();
    let cases = cases(STATES);
    println!(
        "M-20iA, {STATES} random states, {REPEATS} repeats in turn, median, CPU time; Pinocchio 4.1.0 with -O3, \
         compiled with the same instructions"
    );
    for (name, instructions, program, targets) in [
        (
            "portable",
            Instructions::Portable,
            &options.portable,
            Targets {
                one: 2.5,
                batch: 2.5,
            },
        ),
        (
            "AVX2",
            Instructions::Avx2,
            &options.avx2,
            Targets {
                one: 2.5,
                batch: 15.0,
            },
        ),
    ] {
        match arm().with(instructions) {
            Some(arm) => report(name, &arm, program, &cases, &targets)?,
            None => println!("\n{name}: not on this machine"),
        }
    }
    Ok(())
}

fn report(
    name: &str,
    arm: &ArmModel,
    program: &str,
    cases: &[Case],
    targets: &Targets,
) -> Result<()> {
    let serial = SerialArm::builtin(arm.name()).context("the arm is in the catalog")?;
    let joints: Vec<PendantJoints> = cases.iter().map(|case| case.joints).collect();
    let states: Vec<ChainState> = joints
        .iter()
        .map(|joints| {
            [
                arm.chain(joints).radians().to_vec(),
                vec![0.0; 6],
                vec![0.0; 6],
            ]
        })
        .collect();
    let mut peer = Peer::start(program, serial, &states)?;

    let table = Table::new(name);
    let chain = peer.results(Task::Jacobian, STATES)?;
    let mut worst: f64 = 0.0;
    arm.jacobian_batch(&joints, |index, ours| {
        let Some((joints, theirs)) = joints.get(index).zip(chain.get(index)) else {
            worst = f64::INFINITY;
            return;
        };
        for ours in [ours, &arm.jacobian(joints)] {
            worst = worst.max(difference(serial, ours.as_slice(), theirs));
        }
    });
    ensure!(worst <= SAME, "the Jacobians differ by {worst:.1e}");
    table.at_most("largest difference of a Jacobian, m", worst, SAME);
    let mut failed = None;
    let mut theirs = || {
        peer.run(Task::Jacobian).unwrap_or_else(|error| {
            failed = Some(error);
            f64::NAN
        })
    };
    let one = in_turn(
        REPEATS,
        || time(&joints, &mut |joints| arm.jacobian(joints)),
        &mut theirs,
    );
    table.ratio("Jacobian", one, Some(targets.one));
    let batch = in_turn(
        REPEATS,
        || {
            let all = &mut |(): &()| {
                arm.jacobian_batch(&joints, |_, jacobian| {
                    let _ = black_box(jacobian);
                });
            };
            time(&[()], all) / 1e4
        },
        &mut theirs,
    );
    table.ratio("Jacobian, a batch", batch, Some(targets.batch));
    failed.map_or(Ok(()), Err)
}

/// The largest difference between our Jacobian, in millimeters by the displayed joints, and
/// theirs, in meters by the table's variables.
fn difference(arm: &SerialArm, ours: &[f64], theirs: &[f64]) -> f64 {
    let (theirs, _) = theirs.as_chunks::<6>();
    let (ours, _) = ours.as_chunks::<6>();
    let mut worst: f64 = if ours.len() == theirs.len() {
        0.0
    } else {
        f64::INFINITY
    };
    for (displayed, ours) in ours.iter().enumerate() {
        let mut wanted = [0.0; 6];
        for (index, (joint, column)) in arm.joint_list().iter().zip(theirs).enumerate() {
            let coupled = joint
                .couplings
                .iter()
                .filter(|(other, _)| *other == displayed);
            let own = if index == displayed { joint.sign } else { 0.0 };
            let factor = coupled.map(|(_, factor)| factor).sum::<f64>() + own;
            for (wanted, value) in wanted.iter_mut().zip(column) {
                *wanted += factor * value;
            }
        }
        for (row, (ours, wanted)) in ours.iter().zip(wanted).enumerate() {
            let ours = if row < 3 { ours / 1000.0 } else { *ours };
            // Not a number is the largest difference there is.
            let off = (ours - wanted).abs();
            worst = if off.is_nan() {
                f64::INFINITY
            } else {
                worst.max(off)
            };
        }
    }
    worst
}
