//! Changes of one thing, if it is known.

use std::sync::Arc;

use crate::book::Mobile;
use crate::cell::Cell;
use crate::job::{Job, Step};
use crate::session::Session;

impl Cell {
    pub(super) fn job_mut(&mut self, job: &uuid::Uuid, change: impl FnOnce(&mut Job)) {
        if let Some(found) = self.book.jobs.get_mut(job) {
            change(Arc::make_mut(found));
        }
    }

    pub(super) fn step_mut(
        &mut self,
        job: &uuid::Uuid,
        step: usize,
        change: impl FnOnce(&mut Step),
    ) {
        self.job_mut(job, |j| {
            if let Some(found) = j.steps.get_mut(step) {
                change(found);
            }
        });
    }

    pub(super) fn session_mut(&mut self, session: &uuid::Uuid, change: impl FnOnce(&mut Session)) {
        if let Some(found) = self.book.sessions.get_mut(session) {
            change(Arc::make_mut(found));
        }
    }

    pub(super) fn mobile_mut(&mut self, mobile_robot: &str, change: impl FnOnce(&mut Mobile)) {
        change(Arc::make_mut(
            self.book
                .mobiles
                .entry(mobile_robot.to_owned())
                .or_default(),
        ));
    }
}
