//! MOVE: where to, and what becomes of it.

use std::time::Duration;

use super::{
    cell::{Address, Cell},
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::{Along, Pending, Signal},
};
use crate::{
    ast::{NodeSide, Waits},
    frame::{Frame, Vector},
    host::{MotionId, MotionPath, MotionRequest, MoveEnd, Progress},
    ir::{MoveKind, NodeShape},
    position::{JointPosition, XyzwprExt},
    status::Status,
    types::PositionKind,
};

/// The motion group of every MOVE.
const GROUP: i32 = 1;

/// Nodes of a MOVE ALONG whose times are remembered.
const REMEMBERED_NODES: usize = 1000;

/// What a motion goes to.
struct Goal {
    target: XyzwprExt,
    via: Option<XyzwprExt>,
    joints: Option<JointPosition>,
    path: MotionPath,
}

impl Goal {
    fn to(target: XyzwprExt) -> Goal {
        Goal {
            target,
            via: None,
            joints: None,
            path: MotionPath::AsSet,
        }
    }

    fn straight(target: XyzwprExt) -> Goal {
        Goal {
            path: MotionPath::Straight,
            ..Goal::to(target)
        }
    }
}

impl Exec<'_> {
    /// Conditions are looked at before the statement goes on.
    fn moves_with_conditions(&mut self, motion: MotionId, waits: Waits, operands: usize) -> Flow {
        if waits == Waits::Yes {
            self.task.pending = Pending::Motion(motion);
        } else {
            self.drop_operands(operands);
            self.task.pc += 1;
        }
        Flow::Yield
    }

    pub(super) fn move_arm(&mut self, kind: MoveKind, waits: Waits) -> Result<Flow, Fault> {
        let operands = match kind {
            MoveKind::To | MoveKind::Relative | MoveKind::Away => 1,
            MoveKind::Via | MoveKind::Near | MoveKind::Axis | MoveKind::About => 2,
            MoveKind::NearVia => 3,
        };
        let motion = if let Pending::Motion(motion) = self.task.pending {
            motion
        } else {
            let goal = self.goal(kind)?;
            match self.begin(goal, waits)? {
                Err(blocked) => return Ok(blocked),
                Ok(motion) => {
                    if self.local_starts(motion) {
                        return Ok(self.moves_with_conditions(motion, waits, operands));
                    }
                    motion
                }
            }
        };
        if waits == Waits::Yes {
            self.task.pending = Pending::Motion(motion);
            if let Some(blocked) = self.still_moves(motion)? {
                return Ok(blocked);
            }
            self.task.pending = Pending::None;
            self.local_ends(motion);
        }
        self.drop_operands(operands);
        Ok(Flow::Next)
    }

    /// Asks the host for a motion; it may have to wait for a place in the queue.
    fn begin(&mut self, goal: Goal, waits: Waits) -> Result<Result<MotionId, Flow>, Fault> {
        let request = MotionRequest {
            target: goal.target,
            via: goal.via,
            joints: goal.joints,
            path: goal.path,
            group: GROUP,
            end: match waits {
                Waits::Yes => MoveEnd::Wait,
                Waits::No => MoveEnd::NoWait,
            },
            program: self.program.name_arc(),
            line: self.line(),
        };
        match self.host.start_motion(self.id, request) {
            Progress::Pending(wait) => Ok(Err(Flow::Blocked(wait))),
            Progress::Ready(Ok(motion)) => Ok(Ok(motion)),
            Progress::Ready(Err(status)) => Err(Fault::from_host(status, "The motion was refused")),
        }
    }

    fn still_moves(&mut self, motion: MotionId) -> Result<Option<Flow>, Fault> {
        match self.host.motion_ended(motion) {
            Progress::Pending(wait) => Ok(Some(Flow::Blocked(wait))),
            Progress::Ready(status) if !status.is_ok() => {
                Err(Fault::from_host(status, "The motion failed"))
            }
            Progress::Ready(_) => Ok(None),
        }
    }

    fn goal(&mut self, kind: MoveKind) -> Result<Goal, Fault> {
        let position = |exec: &mut Self, below: usize| {
            let at = exec.operand_address(below);
            exec.memory().position(at, PositionKind::XyzwprExt)
        };
        Ok(match kind {
            MoveKind::To => Goal::to(position(self, 0)?),
            MoveKind::Via => Goal {
                via: Some(position(self, 1)?),
                ..Goal::to(position(self, 0)?)
            },
            MoveKind::Near | MoveKind::NearVia => {
                let distance = self.operand(0).expect_real();
                let target = position(self, 1)?;
                let via = if kind == MoveKind::NearVia {
                    Some(position(self, 2)?)
                } else {
                    None
                };
                Goal {
                    via,
                    ..Goal::to(back(&target, distance)?)
                }
            }
            MoveKind::Away => {
                let distance = self.operand(0).expect_real();
                let here = self.here()?;
                Goal::straight(back(&here, distance)?)
            }
            MoveKind::Relative => {
                let by = self.vector(0)?;
                let here = self.here()?;
                let frame = Frame::from(&here);
                Goal::straight(placed(&frame.moved(by), &here)?)
            }
            MoveKind::About => {
                let angle = self.operand(0).expect_real();
                let Some(axis) = self.vector(1)?.unit() else {
                    let message = "MOVE ABOUT a vector of length 0";
                    return Err(Fault::new(Status::INTP_ZERO_VECTOR, message));
                };
                let here = self.here()?;
                let frame = Frame::from(&here);
                Goal::straight(placed(&frame.turned(axis, f64::from(angle)), &here)?)
            }
            MoveKind::Axis => self.axis()?,
        })
    }

    /// Where the tool is now.
    ///
    /// ASSUMPTION: with a motion under way, where the arm is at this moment.
    fn here(&mut self) -> Result<XyzwprExt, Fault> {
        let here = self.host.current_position(self.id, GROUP);
        here.map_err(|status| Fault::from_host(status, "The position is not known"))
    }

    fn vector(&mut self, below: usize) -> Result<Vector, Fault> {
        let at = self.operand_address(below);
        let mut components = [0.0; 3];
        for (component, offset) in components.iter_mut().zip(0..) {
            let Cell::Real(value) = *self.memory().get(at.plus(offset)) else {
                return Err(Fault::uninit());
            };
            *component = f64::from(value);
        }
        Ok(Vector(components))
    }

    /// `AXIS n BY d`: degrees, or millimeters of a linear axis.
    fn axis(&mut self) -> Result<Goal, Fault> {
        let (distance, number) = (
            self.operand(0).expect_real(),
            self.operand(1).expect_integer(),
        );
        let joints = self.host.current_joints(self.id, GROUP);
        let mut joints =
            joints.map_err(|status| Fault::from_host(status, "The joints are not known"))?;
        let count = joints.axes.len();
        let index = usize::try_from(number).ok().and_then(|n| n.checked_sub(1));
        let Some(axis) = index.and_then(|index| joints.axes.get_mut(index)) else {
            let message = format!("MOVE AXIS {number}, the arm has {count} axes");
            return Err(Fault::argument(message));
        };
        *axis = super::finite(*axis + distance)?;
        let target = self.here()?;
        Ok(Goal {
            joints: Some(joints),
            ..Goal::to(target)
        })
    }

    /// `ALONG path`: node after node.
    ///
    /// ASSUMPTION: the arm stands still at each node, and what a node says besides its position
    /// changes nothing; NOWAIT goes on when the motion to the last node is queued; a path without
    /// nodes is INTP-383; with the first node behind the last one the path is followed backwards.
    pub(super) fn move_along(&mut self, row: u32, waits: Waits) -> Result<Flow, Fault> {
        let program = self.program;
        let shape = *row_of(&program.code.nodes, row);
        let at = self.operand_address(2);
        let path = self.memory().get(at).expect_path();
        if !matches!(self.task.pending, Pending::Along) {
            let along = self.first_node(path)?;
            self.task.along.push(along);
            self.task.pending = Pending::Along;
        }
        let result = self.follow(path, shape, waits);
        match &result {
            Ok(Flow::Blocked(_) | Flow::Yield) => return result,
            Ok(Flow::Next | Flow::Jumped | Flow::Ended) | Err(_) => {}
        }
        if let Some(along) = self.task.along.pop()
            && let Some(motion) = along.motion
            && waits == Waits::Yes
        {
            self.local_ends(motion);
        }
        self.task.pending = Pending::None;
        self.drop_operands(3);
        result
    }

    fn first_node(&mut self, path: u32) -> Result<Along, Fault> {
        let (node, last) = match (self.operand(1), self.operand(0)) {
            (Cell::Integer(first), Cell::Integer(last)) => (*first, *last),
            _ => (1, i32::try_from(self.paths.len(path)).unwrap_or(i32::MAX)),
        };
        let _both = (
            self.paths.expect_node(path, node)?,
            self.paths.expect_node(path, last)?,
        );
        Ok(Along {
            node,
            last,
            motion: None,
            passed: false,
            watched: false,
            reached: Vec::new(),
        })
    }

    fn follow(&mut self, path: u32, shape: NodeShape, waits: Waits) -> Result<Flow, Fault> {
        loop {
            let Some(along) = self.task.along.last() else {
                return Ok(Flow::Next);
            };
            let (node, last, running) = (along.node, along.last, along.motion);
            if let Some(motion) = running.filter(|_| !along.passed) {
                if waits == Waits::No && node == last {
                    return Ok(Flow::Next);
                }
                if let Some(blocked) = self.still_moves(motion)? {
                    return Ok(blocked);
                }
                if self.reaches(node) {
                    return Ok(Flow::Yield);
                }
            }
            if running.is_some() && node == last {
                return Ok(Flow::Next);
            }
            let next = match running {
                None => node,
                Some(_) if node < last => node + 1,
                Some(_) => node - 1,
            };
            let place = self.paths.expect_node(path, next)?;
            let target = self.node_position(place.plus(shape.offset), shape.kind)?;
            let motion = match self.begin(Goal::to(target), waits)? {
                Ok(motion) => motion,
                Err(blocked) => return Ok(blocked),
            };
            if let Some(before) = running {
                self.local_goes_on(before, motion);
            }
            let is_first = running.is_none();
            let watched = is_first && self.local_starts(motion);
            if let Some(along) = self.task.along.last_mut() {
                along.node = next;
                along.motion = Some(motion);
                along.passed = false;
                along.watched |= watched;
            }
            if is_first && self.reaches(0) {
                return Ok(Flow::Yield);
            }
        }
    }

    /// Notes that a node was reached; whether conditions are to be looked at.
    fn reaches(&mut self, node: i32) -> bool {
        let now = self.host.now();
        let Some(along) = self.task.along.last_mut() else {
            return false;
        };
        along.passed = node != 0;
        if along.reached.len() < REMEMBERED_NODES {
            along.reached.push((node, now));
        }
        if !along.watched {
            return false;
        }
        self.task.signal(Signal::Node(node));
        self.task.scan_now = true;
        true
    }

    fn node_position(&mut self, at: Address, kind: PositionKind) -> Result<XyzwprExt, Fault> {
        self.memory().position(at, kind)
    }

    /// `TIME t BEFORE NODE[n]`, `TIME t AFTER NODE[n]`.
    ///
    /// ASSUMPTION: they hold from that moment on.
    pub(super) fn node_time(&mut self, side: NodeSide, milliseconds: i32, node: i32) -> bool {
        let Ok(milliseconds) = u64::try_from(milliseconds) else {
            return false;
        };
        let time = Duration::from_millis(milliseconds);
        let now = self.host.now();
        let Some(along) = self.task.along.last() else {
            return false;
        };
        let reached = along.reached.iter().rev().find(|(of, _)| *of == node);
        match (side, reached) {
            (NodeSide::After, None) => false,
            (NodeSide::After, Some((_, at))) => now >= at.saturating_add(time),
            (NodeSide::Before, Some(_)) => true,
            (NodeSide::Before, None) => {
                let left = along
                    .motion
                    .filter(|_| along.node == node)
                    .and_then(|motion| self.host.motion_left(motion));
                left.is_some_and(|left| left <= time)
            }
        }
    }
}

/// A position back along its approach.
fn back(from: &XyzwprExt, distance: f32) -> Result<XyzwprExt, Fault> {
    let frame = Frame::from(from);
    let by = frame.axis(2).times(-f64::from(distance));
    placed(&frame.moved(by), from)
}

/// The frame as a position with the configuration and the extended axes of another.
fn placed(frame: &Frame, like: &XyzwprExt) -> Result<XyzwprExt, Fault> {
    let mut components = [0.0; 6];
    for (component, value) in components.iter_mut().zip(frame.components()) {
        *component = super::real(value)?;
    }
    let [x, y, z, w, p, r] = components;
    Ok(XyzwprExt {
        x,
        y,
        z,
        w,
        p,
        r,
        ..*like
    })
}
