//! What TP programs look at again and again: edges, alarms, and what a motion does besides.

use std::time::Duration;

use super::{
    exec::{Exec, Flow},
    fault::Fault,
    task::{Argument, BesideAction, BesideMotion, Moment, Seen, Trigger, Watch},
    tp_value::{Term, no_such},
};
use crate::{
    host::{MotionId, Progress, TpMotion, TpTarget},
    port::{Port, PortValue},
    registers::{Number, PositionRegister},
    status::Status,
    tp::{BesideWhen, Branch, Expr, Goal, Index, Motion},
};

/// Motions whose TA, TB and DB a task has not carried out.
///
/// ASSUMPTION: more than two motions are never on their way, so this is enough.
const MOST_BESIDE: usize = 16;

impl Exec<'_> {
    /// Whether a condition holds that is looked at again and again.
    pub(super) fn tp_sees(&mut self, watch: Watch, condition: &Expr) -> Result<bool, Fault> {
        self.task.tp.watch = watch;
        let holds = self.tp_holds(condition);
        self.task.tp.watch = Watch::Line;
        holds
    }

    /// A condition is looked at for the first time.
    pub(super) fn tp_forget(&mut self, watch: Watch) {
        self.task.tp.seen.retain(|seen| seen.watch != watch);
        self.task.tp.alarms.retain(|(of, _)| *of != watch);
    }

    /// ASSUMPTION: an edge is a change between two looks; what happened before the first one does not count.
    pub(super) fn tp_edge(
        &mut self,
        port: Port,
        index: Index,
        rising: bool,
    ) -> Result<bool, Fault> {
        let n = self.tp_index(index)?;
        let now = match self.host.port(port, n) {
            Ok(PortValue::Switch(on)) => on,
            Ok(PortValue::Number(_)) => {
                let message = format!("{}[{n}] has no edges", port.name());
                return Err(Fault::new(Status::INTP_TYPE, message));
            }
            Err(status) => return Err(no_such(port.name(), n, status)),
        };
        let watch = self.task.tp.watch;
        let mut known = self.task.tp.seen.iter_mut();
        let known = known.find(|seen| (seen.watch, seen.port, seen.number) == (watch, port, n));
        let before = if let Some(seen) = known {
            std::mem::replace(&mut seen.on, now)
        } else {
            self.task.tp.seen.push(Seen {
                watch,
                port,
                number: n,
                on: now,
            });
            now
        };
        Ok(before != now && now == rising)
    }

    /// ASSUMPTION: facility times 1000 plus number of the newest alarm since the condition is looked at, else 0.
    pub(super) fn tp_error_number(&mut self) -> Term {
        let newest = self.host.alarm(i32::MAX);
        let (seq, code) = newest.map_or((0, 0), |alarm| (alarm.seq, alarm.code));
        let watch = self.task.tp.watch;
        let known = self.task.tp.alarms.iter().find(|(of, _)| *of == watch);
        let since = known.map(|(_, since)| *since);
        if since.is_none() {
            self.task.tp.alarms.push((watch, seq));
        }
        let new = since.is_some_and(|since| seq > since);
        Term::Number(Number::Integer(if new { code } else { 0 }))
    }

    pub(super) fn tp_goto(&mut self, goal: &Goal) -> Result<Flow, Fault> {
        let number = match goal {
            Goal::At(line) => return Ok(self.jump(*line)),
            Goal::Missing(number) => *number,
            Goal::By(index, labels) => {
                let number = self.tp_index(*index)?;
                if let Some(line) = labels.get(&number) {
                    return Ok(self.jump(*line));
                }
                number
            }
        };
        Err(Fault::new(
            Status::INTP_LABEL,
            format!("There is no LBL[{number}]"),
        ))
    }

    /// Notes what a motion that was started does besides.
    pub(super) fn tp_begin_beside(
        &mut self,
        motion: &Motion,
        id: MotionId,
        target: Option<&TpMotion>,
    ) -> Result<(), Fault> {
        let (Some(beside), Some(request)) = (&motion.beside, target) else {
            return Ok(());
        };
        let moment = match &beside.when {
            BesideWhen::After(time) => Moment::After(self.tp_seconds(time)?, None),
            BesideWhen::Before(time) => Moment::Before(self.tp_seconds(time)?),
            BesideWhen::Near(distance) => {
                let distance = self.tp_real(distance, "DB")?;
                if distance.is_nan() || distance < 0.0 {
                    return Err(Fault::argument(format!("DB {distance} mm")));
                }
                Moment::Near(distance, self.tp_place(&request.target)?)
            }
        };
        if self.task.tp.beside.len() >= MOST_BESIDE {
            return Err(Fault::new(Status::INTP_LIMIT, "Too many TA, TB and DB"));
        }
        let action = match &beside.action {
            // ASSUMPTION: what the program is given is what its line says when the motion starts.
            Branch::Call(call) => {
                BesideAction::Call(call.program.clone(), self.tp_arguments(call)?)
            }
            other @ (Branch::Jump(_) | Branch::Assign(..) | Branch::Pulse(..)) => {
                BesideAction::Do(other.clone())
            }
        };
        self.task.tp.beside.push(BesideMotion {
            motion: id,
            moment,
            action,
            next: self.host.now(),
        });
        Ok(())
    }

    fn tp_seconds(&mut self, time: &crate::tp::Operand) -> Result<Duration, Fault> {
        let seconds = self.tp_real(time, "TA and TB")?;
        Duration::try_from_secs_f32(seconds)
            .map_err(|_| Fault::argument(format!("TA or TB {seconds} sec")))
    }

    /// Where a target is, in the user frame.
    fn tp_place(&mut self, target: &TpTarget) -> Result<[f32; 3], Fault> {
        let position = match target {
            TpTarget::Cartesian(position) => *position,
            TpTarget::Joints(joints) => {
                let (frame, tool) = self.tp_frames()?;
                let found = self
                    .host
                    .joints_to_position(self.id, joints, &frame, &tool, 1);
                found.map_err(|status| Fault::from_host(status, "DB has no target"))?
            }
        };
        Ok([position.x, position.y, position.z])
    }

    /// Carries out what motions do besides, if it is time.
    ///
    /// ASSUMPTION: looked at every interpolation period; what is still to be done when the motion has ended is done then,
    /// and nothing is done of a motion that was canceled or has failed.
    pub(super) fn look_beside(&mut self, now: Duration) -> Result<(), Fault> {
        let next = self.next_look();
        let mut at = 0;
        while let Some(beside) = self.task.tp.beside.get_mut(at) {
            at += 1;
            if beside.next > now {
                continue;
            }
            beside.next = next;
            let (motion, moment) = (beside.motion, beside.moment);
            self.looked = self.looked.saturating_add(1);
            let ended = self.host.motion_rests(motion);
            if matches!(ended, Progress::Ready(status) if !status.is_ok()) {
                at -= 1;
                let _dropped = self.task.tp.beside.remove(at);
                continue;
            }
            let ended = matches!(ended, Progress::Ready(_));
            let due = match moment {
                Moment::Before(time) => {
                    let left = self.host.motion_left(motion);
                    ended || left.is_some_and(|left| left <= time)
                }
                Moment::Near(distance, place) => {
                    let runs = self.host.motion_left(motion).is_some();
                    ended || (runs && self.tp_distance(place)? <= distance)
                }
                Moment::After(time, None) => {
                    if ended && let Some(beside) = self.task.tp.beside.get_mut(at - 1) {
                        let due = now.saturating_add(time);
                        beside.moment = Moment::After(time, Some(due));
                        beside.next = due;
                    }
                    ended && time.is_zero()
                }
                Moment::After(_, Some(due)) => due <= now,
            };
            if due {
                at -= 1;
                let done = self.task.tp.beside.remove(at);
                match done.action {
                    BesideAction::Call(program, arguments) => {
                        return self.tp_trigger(&program, arguments);
                    }
                    BesideAction::Do(action) => self.tp_act(&action)?,
                }
            }
        }
        Ok(())
    }

    /// A program is to interrupt the task.
    pub(super) fn tp_trigger(
        &mut self,
        program: &str,
        arguments: Vec<Argument>,
    ) -> Result<(), Fault> {
        let mut programs = self.programs.iter();
        let Some(called) = programs.position(|loaded| loaded.name() == program) else {
            let message = format!("There is no program {program}");
            return Err(Fault::new(Status::INTP_CALL_FAILED, message));
        };
        let call = Trigger::Call(called, arguments);
        self.task.triggered.push_back(call);
        Ok(())
    }

    fn tp_act(&mut self, action: &Branch) -> Result<(), Fault> {
        let _flow = match action {
            Branch::Assign(place, value) => self.tp_assign(place, value)?,
            Branch::Pulse(port, index, width) => self.tp_pulse((*port, *index), width.as_ref())?,
            Branch::Jump(_) | Branch::Call(_) => Flow::Next,
        };
        Ok(())
    }

    fn tp_distance(&mut self, [x, y, z]: [f32; 3]) -> Result<f32, Fault> {
        let here = self.tp_operand(&crate::tp::Operand::LinearPosition)?;
        let Term::Position(PositionRegister::Cartesian(here)) = here else {
            return Ok(f32::INFINITY);
        };
        let [x, y, z] = [here.x - x, here.y - y, here.z - z];
        Ok((x * x + y * y + z * z).sqrt())
    }
}
