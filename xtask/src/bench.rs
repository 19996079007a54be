//! Benchmarks against the peers, each with both sides in one run.

use anyhow::Result;
use clap::ValueEnum;

use crate::command::cargo;
use crate::pinocchio;

/// The benchmarks.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Which {
    /// Forward and inverse kinematics beside rs-opw-kinematics: the table of ratios.
    Kinematics,
    /// The same by criterion, with its statistics and plots.
    KinematicsCriterion,
    /// The Jacobian and inverse dynamics beside Pinocchio (C++), which is installed into target/ and compiled; x86-64 with a
    /// C++ compiler.
    Pinocchio,
    /// Trajectories beside rsruckig, and the arm's transfer among obstacles.
    Planning,
    /// A tier-0 move beside raw TCP and a bare axum route.
    Bridge,
    /// The service goals: latencies with and without an attack, memory, open files, restart.
    Service,
    /// Steps a second of the mobile base's control laws.
    MobileBase,
    /// The virtual controller: statements a second beside Lua, controller time, a hundred of them, memory.
    Emulator,
    /// Idle memory and time to the first response of the whole cell.
    Footprint,
}

/// Runs one benchmark, in release mode.
pub(crate) fn run(which: Which, args: &[String]) -> Result<()> {
    match which {
        Which::Kinematics => binary("kinematics_ratio", args),
        Which::KinematicsCriterion => cargo(
            &[
                "bench",
                "--package",
                "benches",
                "--bench",
                "kinematics",
                "--",
            ],
            args,
        ),
        Which::Pinocchio => {
            let peers = pinocchio::peers()?;
            binary("pinocchio_ratio", &[&peers, args].concat())
        }
        Which::Planning => binary("planning_ratio", args),
        Which::Bridge => binary("bridge", args),
        Which::Service => binary("service", args),
        Which::MobileBase => binary("mobile_base_ratio", args),
        Which::Emulator => cargo(
            &["run", "--release", "--package", "emulator-bench", "--"],
            args,
        ),
        Which::Footprint => {
            cargo(&["build", "--release", "--package", "cell"], &[])?;
            binary("footprint", args)
        }
    }
}

fn binary(name: &str, args: &[String]) -> Result<()> {
    cargo(
        &[
            "run",
            "--release",
            "--package",
            "benches",
            "--bin",
            name,
            "--",
        ],
        args,
    )
}
