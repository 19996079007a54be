//! The cell: all state, folded from facts. `decide` changes nothing, `apply` decides nothing.

use std::sync::Arc;

use crate::book::{Book, Live};
use crate::custody::{Custody, Load};
use crate::effect::Effect;
use crate::fact::Fact;
use crate::ids::{IdSource, Millis};
use crate::input::{Decision, Input, Refusal};
use crate::setup::Setup;
use crate::work::Work;

/// The state of a cell.
///
/// After a start of the process: [`Cell::new`], [`Cell::replay`] for each durable fact, then decide and apply
/// [`Input::Recover`]. From then on, for each input: [`Cell::decide`], keep the durable facts as one record,
/// [`Cell::apply`] each fact, carry out the effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    pub(crate) setup: Arc<Setup>,
    pub(crate) book: Book,
    pub(crate) live: Live,
}

impl Cell {
    /// A cell without facts. `setup` is what the journal began with: later ones are facts.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let loads = setup
            .loads
            .iter()
            .map(|l| {
                (
                    l.id.clone(),
                    Load {
                        kind: l.kind.clone(),
                        location: l.at.clone(),
                    },
                )
            })
            .collect();
        let book = Book {
            custody: Arc::new(Custody(loads)),
            ..Book::default()
        };
        Self {
            setup: Arc::new(setup),
            book,
            live: Live::default(),
        }
    }

    /// The configuration in force.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// What `input` leads to now. Nothing changes until the facts are applied.
    ///
    /// # Errors
    /// [`Refusal`]: the input is not possible; nothing has to be kept.
    pub fn decide(
        &self,
        now: Millis,
        input: Input,
        ids: &mut dyn IdSource,
    ) -> Result<Decision, Refusal> {
        Work::new(self.clone(), now, ids).decide(input)
    }

    /// Folds a fact that was just decided and kept, and says what has to be done because of it.
    #[must_use]
    pub fn apply(&mut self, now: Millis, fact: &Fact) -> Vec<Effect> {
        let effects = self.fold(Some(now), fact);
        self.schedule(now);
        effects
    }

    /// Folds a fact of an earlier process: no permit, no timer, no effect.
    pub fn replay(&mut self, fact: &Fact) {
        drop(self.fold(None, fact));
    }

    /// When [`Input::Tick`] is due.
    #[must_use]
    pub fn next_deadline(&self) -> Option<Millis> {
        self.live
            .timers
            .values()
            .filter(|w| !w.fired)
            .map(|w| w.running.at)
            .min()
    }

    /// Whether a job has not come to its end.
    #[must_use]
    pub fn is_open(&self, job: uuid::Uuid) -> bool {
        let found = self.book.jobs.get(&job);
        found.is_some_and(|job| !job.state.is_final())
    }

    /// Whether two cells hold the same durable state, whatever they see right now.
    #[must_use]
    pub fn same_book(&self, other: &Self) -> bool {
        self.setup == other.setup && self.book == other.book
    }
}
