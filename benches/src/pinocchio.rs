//! Pinocchio (C++) as a process of its own: it is given a chain and its states, and then says its
//! results and its times, pass by pass, so that both sides run in turn.

use std::io::{BufRead as _, BufReader, BufWriter, Lines, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result, bail, ensure};
use kinematics::serial::{JointKind, SerialArm};
use kinematics::{Pose, Xyzwpr};
use units::{Degrees, Millimeters};

/// Positions, velocities and accelerations of the table's variables, in radians and meters.
pub type ChainState = [Vec<f64>; 3];

/// What is asked of it.
#[derive(Clone, Copy, Debug)]
pub enum Task {
    /// `computeJointJacobians` and `getJointJacobian` of the last joint in the world's directions.
    Jacobian,
    /// `rnea`
    InverseDynamics,
}

impl Task {
    fn word(self) -> &'static str {
        match self {
            Task::Jacobian => "jacobian",
            Task::InverseDynamics => "rnea",
        }
    }
}

/// The running process.
#[derive(Debug)]
pub struct Peer {
    child: Child,
    commands: BufWriter<ChildStdin>,
    answers: Lines<BufReader<ChildStdout>>,
}

impl Peer {
    /// Starts `program` with the arm's table and these states.
    ///
    /// # Errors
    /// It cannot be started, or does not listen.
    pub fn start(program: &str, arm: &SerialArm, states: &[ChainState]) -> Result<Self> {
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("starting {program}"))?;
        let commands = BufWriter::new(child.stdin.take().context("the peer has no input")?);
        let output = child.stdout.take().context("the peer has no output")?;
        let mut peer = Self {
            child,
            commands,
            answers: BufReader::new(output).lines(),
        };
        peer.describe(arm)?;
        writeln!(peer.commands, "states {}", states.len())?;
        for state in states {
            let numbers: Vec<String> = state.iter().flatten().map(f64::to_string).collect();
            writeln!(peer.commands, "{}", numbers.join(" "))?;
        }
        Ok(peer)
    }

    /// The table as placements between joint axes. Each joint's frame is behind the link's way along
    /// the axis, so the last one is the flange if the last row has neither length nor twist.
    fn describe(&mut self, arm: &SerialArm) -> Result<()> {
        writeln!(self.commands, "chain {}", arm.degrees_of_freedom())?;
        let (mut a, mut twist) = (0.0, 0.0_f64);
        for joint in arm.joint_list() {
            let kind = match joint.kind {
                JointKind::Revolute => "R",
                JointKind::Prismatic => "P",
            };
            let (s, c) = twist.sin_cos();
            let d = joint.d / 1000.0;
            let place = [a / 1000.0, -s * d, c * d];
            let turn = [1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c];
            let inertia = joint
                .inertia
                .with_context(|| format!("{} has no inertia", joint.name))?;
            // From the link's frame of the table to the joint's.
            let inertia = inertia.seen_from(&Pose::try_from_xyzwpr(&Xyzwpr::new(
                [joint.a, 0.0, 0.0].map(Millimeters),
                [joint.alpha.to_degrees(), 0.0, 0.0].map(Degrees),
            ))?);
            let center = inertia.center_of_mass_m();
            let moments = inertia.inertia_kg_m2();
            let [xx, xy, xz] = [moments.m11, moments.m12, moments.m13];
            let [yy, yz, zz] = [moments.m22, moments.m23, moments.m33];
            let mass = [inertia.mass_kg(), center.x, center.y, center.z];
            let moments = [xx, xy, xz, yy, yz, zz];
            let parts: [&[f64]; 4] = [&turn, &place, &mass, &moments];
            let numbers: Vec<String> = parts.concat().iter().map(f64::to_string).collect();
            writeln!(self.commands, "{kind} {}", numbers.join(" "))?;
            (a, twist) = (joint.a, joint.alpha);
        }
        ensure!(
            a == 0.0 && twist == 0.0,
            "the last row of {} is not along its axis",
            arm.name()
        );
        Ok(())
    }

    /// The numbers of each state.
    ///
    /// # Errors
    /// The process ended, or said something else.
    pub fn results(&mut self, task: Task, states: usize) -> Result<Vec<Vec<f64>>> {
        writeln!(self.commands, "results {}", task.word())?;
        self.commands.flush()?;
        (0..states).map(|_| self.numbers()).collect()
    }

    /// Passes over all states, after one that does not count: nanoseconds a state, of its thread's
    /// CPU time.
    ///
    /// # Errors
    /// As [`Self::results`].
    pub fn run(&mut self, task: Task, passes: u32) -> Result<f64> {
        writeln!(self.commands, "run {} {passes}", task.word())?;
        self.commands.flush()?;
        match self.numbers()?.as_slice() {
            [nanoseconds] => Ok(*nanoseconds),
            other => bail!("the peer gave {} numbers for a time", other.len()),
        }
    }

    fn numbers(&mut self) -> Result<Vec<f64>> {
        let line = self.answers.next().context("the peer ended")??;
        let numbers = line.split_whitespace().map(str::parse);
        numbers
            .collect::<Result<_, _>>()
            .with_context(|| format!("the peer said {line:?}"))
    }
}

/// It ends when its input does.
impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
