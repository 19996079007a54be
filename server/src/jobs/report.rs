//! What a job took, from the journal's clocks.

use std::collections::BTreeMap;
use std::time::Duration;

use api::{
    AttemptReport, DecisionReport, FaultReport, JobReport, JobState, PhaseKind, PhaseReport,
    StateTime, WorkflowName,
};
use jiff::Timestamp;
use journal::{Clocks, Epoch};
use uuid::Uuid;
use workflow::{Fact, Phase, PlannedStep, StepState, Why, Workflow};

use super::shown::{created_at, fault_name, state_of, workflow_name};
use super::story::{Chapter, History};
use crate::words::word;

/// Time since the first record. Within one epoch the monotonic clock counts; over a start of the server, the wall
/// clock, and never backwards.
#[derive(Debug, Default)]
pub(super) struct Elapsed {
    last: Option<(Epoch, Clocks)>,
    total: Duration,
}

impl Elapsed {
    /// Milliseconds until this record.
    pub(super) fn at(&mut self, chapter: &Chapter) -> u64 {
        if let Some((epoch, at)) = self.last {
            let passed = if epoch == chapter.epoch {
                chapter.at.monotonic.saturating_sub(at.monotonic)
            } else {
                let wall = chapter.at.wall.duration_since(at.wall);
                Duration::try_from(wall).unwrap_or_default()
            };
            self.total = self.total.saturating_add(passed);
        }
        self.last = Some((chapter.epoch, chapter.at));
        u64::try_from(self.total.as_millis()).unwrap_or(u64::MAX)
    }
}

/// What a job took. `now`, by the wall clock and in the journal's epoch, is the end so far of a job that is not over.
pub(crate) fn report(cell: &str, history: &History, now: (Timestamp, Epoch)) -> JobReport {
    let mut elapsed = Elapsed::default();
    let first = history.chapters.first().map(|chapter| chapter.at.wall);
    let mut run = Run::begin(0, first.unwrap_or_else(|| created_at(history.job)), 1);
    let mut workflow = Workflow::DeliveryAndPlacement;
    let mut epoch = None;
    for chapter in &history.chapters {
        let now = elapsed.at(chapter);
        run.now = now;
        if epoch
            .replace(chapter.epoch)
            .is_some_and(|e| e != chapter.epoch)
        {
            run.restarts += 1;
        }
        for (_, fact) in &chapter.facts {
            if let Fact::JobCreated { spec, .. } = fact {
                workflow = spec.workflow;
            }
            if matches!(
                fact,
                Fact::JobMoved {
                    to: workflow::JobState::Idle,
                    ..
                }
            ) {
                run = Run::begin(now, chapter.at.wall, run.number + 1);
                continue;
            }
            run.take(fact, chapter.at.wall);
        }
    }
    if let Some(last) = history.chapters.last()
        && !run.state.0.is_final()
    {
        let (wall, epoch) = now;
        if last.epoch != epoch {
            run.restarts += 1;
        }
        let since = Duration::try_from(wall.duration_since(last.at.wall)).unwrap_or_default();
        run.now += u64::try_from(since.as_millis()).unwrap_or(0);
    }
    run.finish(cell, history.job, workflow)
}

/// One run of a job: from the queue to its end.
#[derive(Debug)]
struct Run {
    number: u32,
    begun: u64,
    begun_at: Timestamp,
    now: u64,
    ended_at: Option<Timestamp>,
    state: (workflow::JobState, u64),
    states: Vec<StateTime>,
    plan: Vec<PlannedStep>,
    phases: Vec<PhaseReport>,
    faults: Vec<FaultReport>,
    decisions: Vec<DecisionReport>,
    asked: BTreeMap<Uuid, u64>,
    restarts: u32,
}

impl Run {
    fn begin(begun: u64, begun_at: Timestamp, number: u32) -> Self {
        Self {
            number,
            begun,
            begun_at,
            now: begun,
            ended_at: None,
            state: (workflow::JobState::Idle, begun),
            states: Vec::new(),
            plan: Vec::new(),
            phases: Vec::new(),
            faults: Vec::new(),
            decisions: Vec::new(),
            asked: BTreeMap::new(),
            restarts: 0,
        }
    }

    fn at(&self) -> u64 {
        self.now - self.begun
    }

    fn take(&mut self, fact: &Fact, wall: Timestamp) {
        if let Fact::Planned { steps, .. } = fact {
            self.plan.extend(steps.iter().cloned());
        } else if let Fact::StepMoved { step, to, text, .. } = fact {
            self.step(*step, *to, text);
        } else if let Fact::FaultNoted { fault, text, .. } = fact {
            self.faults.push(FaultReport {
                at_ms: self.at(),
                fault: fault_name(*fault),
                text: text.clone(),
            });
        } else if let Fact::Asked { question } = fact {
            let _new = self.asked.insert(question.id, self.now);
        } else if let Fact::Answered {
            intervention,
            decided,
        } = fact
        {
            let asked = self.asked.get(intervention);
            self.decisions.push(DecisionReport {
                at_ms: self.at(),
                principal: decided.principal.clone(),
                decision: word(&decided.answer),
                intervention: Some(*intervention),
                open_ms: asked.map(|asked| self.now - asked),
                reason: decided.reason.clone(),
            });
        } else if let Fact::JobMoved { to, why, text, .. } = fact {
            self.leave_state();
            self.state = (*to, self.now);
            self.ended_at = to.is_final().then_some(wall);
            if let Why::Human { principal } = why {
                self.decisions.push(DecisionReport {
                    at_ms: self.at(),
                    principal: principal.clone(),
                    decision: word(to),
                    intervention: None,
                    open_ms: None,
                    reason: text.clone(),
                });
            }
        }
    }

    fn leave_state(&mut self) {
        let (state, since) = self.state;
        let (state, passed) = (state_of(state), self.now - since);
        match self.states.iter_mut().find(|known| known.state == state) {
            Some(known) => known.duration_ms += passed,
            None => self.states.push(StateTime {
                state,
                duration_ms: passed,
            }),
        }
    }

    fn step(&mut self, step: usize, to: StepState, text: &str) {
        let at = self.at();
        let known = self.phases.iter().position(|phase| phase.step == step);
        if to == StepState::Running {
            self.end_attempt(known, at, None, "");
            let index = known.or_else(|| self.begin_phase(step, at));
            if let Some(phase) = index.and_then(|index| self.phases.get_mut(index)) {
                phase.end = None;
                phase.attempts.push(AttemptReport {
                    begin_ms: at,
                    duration_ms: 0,
                    end: None,
                    text: String::new(),
                });
            }
        } else {
            self.end_attempt(known, at, Some(to), text);
        }
    }

    fn begin_phase(&mut self, step: usize, at: u64) -> Option<usize> {
        let planned = self.plan.get(step)?;
        self.phases.push(PhaseReport {
            step,
            code: String::new(),
            phase: word(&planned.phase),
            kind: kind_of(planned),
            item: planned.item,
            place: planned.place.as_ref().map(ToString::to_string),
            begin_ms: at,
            duration_ms: 0,
            end: None,
            attempts: Vec::new(),
        });
        Some(self.phases.len() - 1)
    }

    fn end_attempt(&mut self, phase: Option<usize>, at: u64, to: Option<StepState>, text: &str) {
        let Some(phase) = phase.and_then(|index| self.phases.get_mut(index)) else {
            return;
        };
        let end = to.map(|to| word(&to));
        if let Some(attempt) = phase.attempts.last_mut().filter(|a| a.end.is_none()) {
            attempt.duration_ms = at - attempt.begin_ms;
            attempt.end = Some(end.clone().unwrap_or_else(|| "REPEATED".to_owned()));
            text.clone_into(&mut attempt.text);
        }
        // Dropped after it was done is still done.
        if to.is_some_and(|to| to != StepState::Pending) {
            phase.end = end;
        }
    }

    fn finish(mut self, cell: &str, job: Uuid, workflow: Workflow) -> JobReport {
        self.leave_state();
        let total_ms = self.at();
        for phase in &mut self.phases {
            if let Some(last) = phase.attempts.last_mut().filter(|a| a.end.is_none()) {
                last.duration_ms = total_ms - last.begin_ms;
            }
            phase.duration_ms = phase.attempts.iter().map(|a| a.duration_ms).sum();
            if let Some(planned) = self.plan.get(phase.step) {
                planned.phase.code(workflow).clone_into(&mut phase.code);
            }
        }
        self.phases
            .sort_by_key(|phase| (phase.begin_ms, phase.step));
        let queued = self
            .states
            .iter()
            .find(|known| known.state == JobState::Idle);
        let queued_ms = queued.map_or(0, |known| known.duration_ms);
        let workflow: WorkflowName = workflow_name(workflow);
        JobReport {
            job,
            cell: cell.to_owned(),
            workflow,
            state: state_of(self.state.0),
            created_at: created_at(job),
            run: self.number,
            begun_at: self.begun_at,
            ended_at: self.ended_at,
            total_ms,
            queued_ms,
            cycle_ms: total_ms - queued_ms,
            states: self.states,
            phases: self.phases,
            faults: self.faults,
            decisions: self.decisions,
            restarts: self.restarts,
        }
    }
}

fn kind_of(step: &PlannedStep) -> PhaseKind {
    if step.undo {
        return PhaseKind::Undo;
    }
    match step.phase {
        Phase::Reserve | Phase::Precheck => PhaseKind::Prepare,
        Phase::Call | Phase::Await | Phase::Dock | Phase::Exit | Phase::Transport => {
            PhaseKind::MobileRobot
        }
        Phase::VerifyLoad
        | Phase::VerifyEmpty
        | Phase::Permit
        | Phase::ReleaseMr
        | Phase::VerifyOnMr => PhaseKind::HandOver,
        Phase::Approach
        | Phase::Grip
        | Phase::LiftClear
        | Phase::PlaceApproach
        | Phase::Release
        | Phase::Retreat => PhaseKind::Arm,
        Phase::Close => PhaseKind::Close,
        Phase::BackOut | Phase::Dismiss => PhaseKind::Undo,
    }
}
