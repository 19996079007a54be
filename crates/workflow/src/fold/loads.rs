//! Facts about loads: where each of them is, and which ones are still kept in the books.

use std::sync::Arc;

use crate::book::REMEMBERED;
use crate::cell::Cell;
use crate::custody::{Load, Location};

impl Cell {
    pub(super) fn fold_custody(&mut self, load: &str, to: &Location) {
        if matches!(to, Location::Delivered { .. }) {
            self.book.delivered.retain(|known| known != load);
            self.book.delivered.push_back(load.to_owned());
            self.forget_delivered();
        }
        let custody = Arc::make_mut(&mut self.book.custody);
        let before = custody
            .0
            .get_mut(load)
            .map(|found| std::mem::replace(&mut found.location, to.clone()));
        // What the part sensor said before is about another situation.
        for at in before.iter().chain([to]) {
            if let Location::Gripper { arm } = at
                && let Some(live) = self.live.arms.get_mut(arm)
            {
                live.seen.part_present = None;
            }
        }
    }

    /// Takes a configuration; loads that are new appear where it says.
    pub(super) fn install(&mut self, setup: &crate::Setup) {
        let before = std::mem::replace(&mut self.setup, Arc::new(setup.clone()));
        let custody = Arc::make_mut(&mut self.book.custody);
        // A load that was delivered, and that the set-up does not name any more, is nobody's.
        for load in &before.loads {
            let named = setup.loads.iter().any(|known| known.id == load.id);
            let gone = custody
                .of(&load.id)
                .is_some_and(|at| matches!(at, Location::Delivered { .. }));
            if gone && !named {
                drop(custody.0.remove(&load.id));
            }
        }
        for load in &setup.loads {
            if !custody.0.contains_key(&load.id) {
                let new = Load {
                    kind: load.kind.clone(),
                    location: load.at.clone(),
                };
                drop(custody.0.insert(load.id.clone(), new));
            }
        }
    }

    /// What a mobile robot took away stays in the books for a while, and then only in the journal. What the set-up
    /// names stays: its next change would bring it back to where it was at first.
    pub(super) fn forget_delivered(&mut self) {
        let setup = Arc::clone(&self.setup);
        let named = |load: &String| setup.loads.iter().any(|known| known.id == *load);
        let mut surplus = self.book.delivered.len().saturating_sub(REMEMBERED);
        let custody = Arc::make_mut(&mut self.book.custody);
        let claims = &self.book.claims;
        self.book.delivered.retain(|load| {
            let gone = custody
                .of(load)
                .is_some_and(|at| matches!(at, Location::Delivered { .. }));
            let claimed = !claims.is_free(&crate::Resource::Load(load.clone()));
            if surplus == 0 || claimed {
                return true;
            }
            surplus -= 1;
            if gone && !named(load) {
                drop(custody.0.remove(load));
            }
            false
        });
    }

    /// A load that is nowhere else.
    pub(crate) fn is_free(&self, location: &Location) -> bool {
        !self.setup.is_single(location) || self.book.custody.at(location).is_none()
    }
}
