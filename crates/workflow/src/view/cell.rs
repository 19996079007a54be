//! What a cell shows of itself.

use uuid::Uuid;

use crate::cell::Cell;
use crate::claims::{Holder, Resource};
use crate::ids::Millis;
use crate::intervention::Allowed;
use crate::job::{Job, JobState};
use crate::permits::Permit;
use crate::signal::OutMessage;
use crate::timers::TimerKey;

use super::{
    ClaimView, InterventionView, JobView, LoadView, MobileRobotView, OperationView, SessionView,
    StepView, TimerView,
};

impl Cell {
    fn timer(&self, now: Millis, key: &TimerKey) -> Option<TimerView> {
        let wait = self.live.timers.get(key).filter(|w| !w.fired)?;
        Some(TimerView {
            timer: key.clone(),
            left_ms: wait.running.at.saturating_sub(now),
            total_ms: wait.running.total_ms,
        })
    }

    fn timers_where(&self, now: Millis, which: impl Fn(&TimerKey) -> bool) -> Vec<TimerView> {
        self.live
            .timers
            .keys()
            .filter(|k| which(k))
            .filter_map(|k| self.timer(now, k))
            .collect()
    }

    /// All waits that run.
    #[must_use]
    pub fn timers(&self, now: Millis) -> Vec<TimerView> {
        self.timers_where(now, |_| true)
    }

    /// One job.
    #[must_use]
    pub fn job(&self, now: Millis, id: Uuid) -> Option<JobView> {
        let job = self.book.jobs.get(&id)?;
        let left = |key: &TimerKey| self.timer(now, key).map(|t| t.left_ms);
        let operation = |op: Uuid| {
            let found = self.book.ops.get(&op)?;
            Some(OperationView {
                op,
                arm: found.arm.clone(),
                action: found.action.clone(),
                state: found.state,
                left_ms: left(&TimerKey::Operation { op }),
            })
        };
        let steps: Vec<_> = job
            .steps
            .iter()
            .enumerate()
            .map(|(number, s)| StepView {
                number,
                phase: s.plan.phase,
                code: s.plan.phase.code(job.spec.workflow),
                item: s.plan.item,
                place: s.plan.place.clone(),
                state: s.state,
                attempt: s.attempt,
                undo: s.plan.undo,
                recovery: s.plan.phase.recovery(),
                needs: s.plan.needs.clone(),
                operation: s.op.and_then(operation),
                left_ms: left(&TimerKey::Step {
                    job: id,
                    step: number,
                }),
            })
            .collect();
        let current = job
            .current()
            .and_then(|i| job.step(i))
            .map(|s| s.plan.phase);
        Some(JobView {
            id,
            number: job.number,
            spec: job.spec.clone(),
            trigger: job.trigger.clone(),
            state: job.state,
            why: job.why.clone(),
            text: self.text_of(job),
            arm: job.arm.clone(),
            mobile_robot: job.mobile_robot.clone(),
            session: job.session,
            items: job.items.clone(),
            phase: current,
            code: current.map(|p| p.code(job.spec.workflow)),
            steps,
            compensation: job.compensation,
            intervention: self.book.question_of(id).map(|i| i.question.id),
            faults: job.faults.clone(),
            claims: self
                .book
                .claims
                .0
                .iter()
                .filter(|(_, by)| **by == Holder::Job(id))
                .map(|(r, _)| r.clone())
                .collect(),
            timers: self.timers_where(now, |key| match key {
                TimerKey::Queue { job: j }
                | TimerKey::Deadline { job: j }
                | TimerKey::Step { job: j, .. }
                | TimerKey::State { job: j }
                | TimerKey::Prefetch { job: j } => *j == id,
                TimerKey::Operation { op } => self.book.ops.get(op).is_some_and(|o| o.job == id),
                TimerKey::Session { session } => job.session == Some(*session),
                TimerKey::Heartbeat { mobile_robot } => {
                    job.mobile_robot.as_ref() == Some(mobile_robot)
                }
                TimerKey::Safe { arm } | TimerKey::ArmSeen { arm } => job.arm.as_ref() == Some(arm),
                TimerKey::Parked { .. } | TimerKey::Question { .. } => false,
            }),
        })
    }

    /// Why a job is where it is; of one in the queue what it waits for.
    fn text_of(&self, job: &Job) -> String {
        if job.state == JobState::Idle && job.text.is_empty() {
            self.waits_for(job).unwrap_or_default()
        } else {
            job.text.clone()
        }
    }

    /// All jobs that are remembered, oldest first.
    #[must_use]
    pub fn jobs(&self, now: Millis) -> Vec<JobView> {
        let mut all: Vec<_> = self
            .book
            .jobs
            .keys()
            .filter_map(|id| self.job(now, *id))
            .collect();
        all.sort_by_key(|j| j.number);
        all
    }

    /// The queue in the order in which jobs are looked at: the number in the queue of each waiting job.
    #[must_use]
    pub fn queue(&self) -> Vec<Uuid> {
        let mut waiting: Vec<_> = self
            .book
            .jobs
            .values()
            .filter(|j| j.state == JobState::Idle)
            .map(|j| {
                let deadline = j.spec.deadline.unwrap_or(Millis::MAX);
                (std::cmp::Reverse(j.spec.priority), deadline, j.number, j.id)
            })
            .collect();
        waiting.sort_unstable();
        waiting.into_iter().map(|(.., id)| id).collect()
    }

    /// All sessions that are remembered, oldest first.
    #[must_use]
    pub fn sessions(&self, now: Millis) -> Vec<SessionView> {
        let mut all: Vec<_> = self.book.sessions.values().collect();
        all.sort_by_key(|s| s.number);
        all.into_iter()
            .map(|s| SessionView {
                id: s.id,
                point: s.point.clone(),
                job: s.job,
                mobile_robot: s.mobile_robot.clone(),
                state: s.state,
                faulted_from: s.faulted.map(|(from, _)| from),
                fault: s.faulted.map(|(_, fault)| fault),
                arm_entry_permit: self.permit_of(s) == Permit::ArmEntry,
                mr_move_permit: self.permit_of(s) == Permit::MrMove,
                order: s.order,
                order_update: s.update,
                docked: s.docked,
                intervention: self.book.question_of_session(s.id).map(|i| i.question.id),
                timers: self.timers_where(now, |key| {
                    matches!(key, TimerKey::Session { session } if *session == s.id)
                        || matches!(key, TimerKey::Heartbeat { mobile_robot }
                            if *mobile_robot == s.mobile_robot && !s.state.is_closed())
                }),
            })
            .collect()
    }

    /// Where every load is.
    #[must_use]
    pub fn custody(&self) -> Vec<LoadView> {
        self.book
            .custody
            .0
            .iter()
            .map(|(id, load)| LoadView {
                id: id.clone(),
                load: load.clone(),
                claimed_by: self.book.claims.0.get(&Resource::Load(id.clone())).copied(),
            })
            .collect()
    }

    /// All questions that are remembered, oldest first.
    #[must_use]
    pub fn interventions(&self) -> Vec<InterventionView> {
        let mut all: Vec<_> = self.book.interventions.values().collect();
        all.sort_by_key(|i| i.number);
        all.into_iter()
            .map(|i| InterventionView {
                number: i.number,
                question: i.question.clone(),
                code: i.question.fault.code(),
                allowed: i
                    .question
                    .answers
                    .iter()
                    .map(|a| Allowed {
                        answer: *a,
                        consequence: a.consequence(),
                        role: a.needs(),
                    })
                    .collect(),
                open: i.is_open(),
                decided: i.decided.clone(),
                withdrawn: i.withdrawn.clone(),
            })
            .collect()
    }

    /// The permit of each point.
    #[must_use]
    pub fn permits(&self) -> Vec<(String, Permit)> {
        self.setup
            .points
            .iter()
            .map(|p| {
                let of = |s: &std::sync::Arc<crate::session::Session>| self.permit_of(s);
                let here = self.book.sessions.values().filter(|s| s.point == p.id);
                let permit = here
                    .map(of)
                    .find(|p| *p != Permit::None)
                    .unwrap_or_default();
                (p.id.clone(), permit)
            })
            .collect()
    }

    /// All configured mobile robots.
    #[must_use]
    pub fn mobile_robots(&self) -> Vec<MobileRobotView> {
        self.setup
            .mobile_robots
            .iter()
            .map(|m| {
                let kept = self.book.mobiles.get(&m.id);
                let live = self.live.mobiles.get(&m.id);
                MobileRobotView {
                    id: m.id.clone(),
                    slots: m.slots.clone(),
                    heard: self.mobile_seen(&m.id).is_some(),
                    state: live.and_then(|l| l.state.clone()),
                    boot: live.map_or_else(|| kept.map_or(0, |k| k.boot), |l| l.boot),
                    last_seq: live.map_or_else(|| kept.map_or(0, |k| k.seq), |l| l.seq),
                    session: self.book.open_session_of(&m.id).map(|s| s.id),
                    destination: kept
                        .and_then(|k| k.transport.as_ref())
                        .map(|t| t.destination.clone()),
                    waiting_messages: kept.map_or(0, |k| k.outbox.len()),
                }
            })
            .collect()
    }

    /// Messages for a mobile robot with a number above `after`.
    #[must_use]
    pub fn outbox(&self, mobile_robot: &str, after: u64) -> Vec<OutMessage> {
        let all = self.book.mobiles.get(mobile_robot).map(|m| &m.outbox);
        all.into_iter()
            .flatten()
            .filter(|m| m.n > after)
            .cloned()
            .collect()
    }

    /// Who has what.
    #[must_use]
    pub fn claims(&self) -> Vec<ClaimView> {
        self.book
            .claims
            .0
            .iter()
            .map(|(resource, by)| ClaimView {
                resource: resource.clone(),
                by: *by,
            })
            .collect()
    }
}
