//! The set-up of one cell as everyone sees it: the revision that holds, and the one door through which it changes.

use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

use api::setup::{SetupFile, SetupRevision};
use thiserror::Error;
use tokio::sync::{Mutex, Semaphore, watch};

use super::document::{Form, write_setup};
use super::faults::SetupErrors;
use super::model::Setup;
use super::resource::{Resource, touched};
use super::store::{self, FileStore, MemoryStore, SetupStore, StoreError};
use super::ways::ForbiddenWay;
use crate::config::{RobotPlan, SetupSource};

/// One look at ways at a time.
static LOOKING: Semaphore = Semaphore::const_new(1);

/// A revision of a set-up.
#[derive(Debug)]
pub(crate) struct Kept {
    pub(crate) revision: u64,
    /// A strong entity tag, quotes included: the revision, and a digest of the content, so that a file that was edited
    /// by hand between two runs does not pass for the one before.
    pub(crate) etag: String,
    pub(crate) file: SetupFile,
    pub(crate) setup: Setup,
    /// Of each taught pose, in the order of the set-up.
    ways: Vec<OnceLock<Option<ForbiddenWay>>>,
}

/// Whether running work uses a part of the set-up, and what does.
pub(crate) type InUse = Arc<dyn Fn(&Resource) -> Option<String> + Send + Sync>;

/// The set-up of a cell.
pub(crate) struct SetupBook {
    robots: Vec<Arc<RobotPlan>>,
    store: Arc<dyn SetupStore>,
    /// One change at a time.
    door: Mutex<()>,
    current: watch::Sender<Arc<Kept>>,
    in_use: RwLock<Option<InUse>>,
}

impl fmt::Debug for SetupBook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SetupBook")
            .field("store", &self.store)
            .field("etag", &self.current.borrow().etag)
            .finish_non_exhaustive()
    }
}

/// Which revision a change is based on: what `If-Match` names.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct BasedOn(pub(crate) Vec<String>);

/// Why an edit failed, so that its faults get the right name.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Edit {
    /// Something is put in.
    Put,
    /// Something is taken out: what does not fit afterwards are references to it.
    Delete,
}

/// Why a set-up was not changed.
#[derive(Debug, Error)]
pub(crate) enum ChangeError {
    #[error("the set-up was changed meanwhile: its entity tag is {etag} now")]
    Stale { etag: String },
    #[error("there is no `{resource}` in the set-up")]
    NotThere { resource: Resource },
    #[error(transparent)]
    Invalid(SetupErrors),
    #[error("other parts of the set-up refer to `{resource}`")]
    Referenced { resource: Resource, by: SetupErrors },
    #[error("`{resource}` cannot be changed now: {reason}")]
    InUse { resource: Resource, reason: String },
    #[error(transparent)]
    NotKept(#[from] StoreError),
}

impl SetupBook {
    /// Reads a cell's set-up from where it is kept.
    ///
    /// # Errors
    /// It cannot be read, or does not fit the cell.
    pub(crate) fn open(
        source: Option<&SetupSource>,
        robots: Vec<Arc<RobotPlan>>,
    ) -> Result<Self, StoreError> {
        let mut path = PathBuf::from("(in memory)");
        let (store, kept): (Arc<dyn SetupStore>, _) = match source {
            None => (Arc::new(MemoryStore), None),
            Some(SetupSource::Memory(text)) => {
                let file = store::parse(text.as_bytes(), &path)?;
                (Arc::new(MemoryStore), Some((1, file)))
            }
            Some(SetupSource::File(at)) => {
                path.clone_from(at);
                let store = FileStore::new(at.clone());
                let kept = store.read()?;
                (Arc::new(store), kept)
            }
        };
        let (revision, file) = kept.unwrap_or_else(|| (1, SetupFile::empty()));
        let kept = Kept::try_new(revision, file, &robots).map_err(|errors| StoreError::Unfit {
            path,
            reason: errors.to_string(),
        })?;
        Ok(Self {
            robots,
            store,
            door: Mutex::new(()),
            current: watch::Sender::new(Arc::new(kept)),
            in_use: RwLock::new(None),
        })
    }

    /// The revision that holds now.
    pub(crate) fn current(&self) -> Arc<Kept> {
        Arc::clone(&self.current.borrow())
    }

    /// Tells of every change.
    pub(crate) fn watch(&self) -> watch::Receiver<Arc<Kept>> {
        self.current.subscribe()
    }

    /// Asks `in_use` before each change, for every part that the change touches.
    pub(crate) fn refuse_while(&self, in_use: InUse) {
        let mut asked = self.in_use.write().unwrap_or_else(PoisonError::into_inner);
        *asked = Some(in_use);
    }

    /// Checks a set-up for this cell, without keeping it.
    ///
    /// # Errors
    /// Everything wrong with it.
    pub(crate) fn checked(&self, file: &SetupFile) -> Result<Setup, SetupErrors> {
        Setup::try_new(file, &self.robots)
    }

    /// Changes the set-up: all of the edit, or nothing.
    ///
    /// Once begun it is carried to its end, also if the caller goes away.
    ///
    /// # Errors
    /// The edit is based on another revision, does not fit, touches what is in use, or cannot be kept.
    pub(crate) async fn change(
        self: &Arc<Self>,
        based_on: BasedOn,
        resource: Resource,
        edit: impl FnOnce(&mut SetupFile) -> Result<Edit, ChangeError> + Send + 'static,
    ) -> Result<SetupRevision, ChangeError> {
        let this = Arc::clone(self);
        let changing =
            tokio::spawn(async move { this.change_now(&based_on, resource, edit).await });
        match changing.await {
            Ok(changed) => changed,
            Err(error) => match error.try_into_panic() {
                Ok(panic) => std::panic::resume_unwind(panic),
                Err(_) => unreachable!("nobody cancels a change"),
            },
        }
    }

    async fn change_now(
        &self,
        based_on: &BasedOn,
        resource: Resource,
        edit: impl FnOnce(&mut SetupFile) -> Result<Edit, ChangeError>,
    ) -> Result<SetupRevision, ChangeError> {
        let _alone = self.door.lock().await;
        let before = self.current();
        if !based_on.0.contains(&before.etag) {
            return Err(ChangeError::Stale {
                etag: before.etag.clone(),
            });
        }
        let mut file = before.file.clone();
        let edit = edit(&mut file)?;
        let changed = touched(&before.file, &file);
        if changed.is_empty() {
            return Ok(before.revision_of(&changed));
        }
        let after = Kept::try_new(before.revision + 1, file, &self.robots);
        let after = after.map_err(|errors| match edit {
            Edit::Put => ChangeError::Invalid(errors),
            Edit::Delete => ChangeError::Referenced {
                resource,
                by: errors,
            },
        })?;
        self.ask_whether_in_use(&changed)?;
        let answer = after.revision_of(&changed);
        let kept = self.store.keep(after.revision, after.file.clone()).await;
        match kept {
            Ok(()) => {}
            // The file is the new one, whatever a power failure does to it.
            Err(error @ StoreError::InDoubt { .. }) => {
                let _before = self.current.send_replace(Arc::new(after));
                return Err(error.into());
            }
            Err(error) => return Err(error.into()),
        }
        tracing::info!(revision = after.revision, changed = ?answer.changed, "the set-up was changed");
        let _before = self.current.send_replace(Arc::new(after));
        Ok(answer)
    }

    fn ask_whether_in_use(&self, changed: &[Resource]) -> Result<(), ChangeError> {
        let in_use = self
            .in_use
            .read()
            .unwrap_or_else(PoisonError::into_inner)
            .clone();
        let Some(in_use) = in_use else { return Ok(()) };
        for resource in changed {
            if let Some(reason) = in_use(resource) {
                return Err(ChangeError::InUse {
                    resource: resource.clone(),
                    reason,
                });
            }
        }
        Ok(())
    }
}

impl Kept {
    fn try_new(
        revision: u64,
        file: SetupFile,
        robots: &[Arc<RobotPlan>],
    ) -> Result<Self, SetupErrors> {
        let setup = Setup::try_new(&file, robots)?;
        let ways = setup.taught.iter().map(|_| OnceLock::new()).collect();
        let digest = fnv1a(write_setup(&file, Form::Json).as_bytes());
        Ok(Self {
            revision,
            etag: format!("\"{revision}-{digest:016x}\""),
            file,
            setup,
            ways,
        })
    }

    /// What is wrong with the ways of a job to these taught poses and back; each is looked at once in a revision, and off
    /// the threads that answer.
    pub(crate) async fn look_at_ways(self: &Arc<Self>, taught: Vec<usize>) {
        let unknown = |index: &usize| self.ways.get(*index).is_some_and(|way| way.get().is_none());
        if !taught.iter().any(unknown) {
            return;
        }
        let this = Arc::clone(self);
        let Ok(_alone) = LOOKING.acquire().await else {
            unreachable!("nobody closes it");
        };
        let looking = tokio::task::spawn_blocking(move || {
            for index in taught {
                let _known = this.forbidden_way(index);
            }
        });
        // After a panic of its own whoever asks looks again.
        let _ended = looking.await;
    }

    /// The first way of a job to a taught pose, or back, that leads where it may not.
    pub(crate) fn forbidden_way(&self, taught: usize) -> Option<&ForbiddenWay> {
        let way = self.ways.get(taught)?;
        let look = || self.setup.forbidden_way(self.setup.taught.get(taught)?);
        way.get_or_init(look).as_ref()
    }

    fn revision_of(&self, changed: &[Resource]) -> SetupRevision {
        SetupRevision {
            revision: self.revision,
            etag: self.etag.clone(),
            changed: changed.iter().map(Resource::to_string).collect(),
        }
    }
}

/// FNV-1a, 64 bits. It tells two revisions apart and guards nothing.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
