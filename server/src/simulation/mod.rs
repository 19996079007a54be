//! Jobs in virtual time: the seam to whoever has virtual robots, and the story such a job leaves in its journal.
//!
//! The server knows no emulator. It says what the cell is like now ([`Scene`]), and the caller that started it brings
//! what plays it ([`JobSimulator`]); a server without one says so.

mod scene;
mod story;

use std::fmt;
use std::pin::Pin;

use api::setup::SetupFile;
use api::{FloorPoseBody, JobBody, JobSimulation};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub(crate) use scene::scene;
pub use story::{SimulatedStory, StoryError, simulated_story};

/// A simulation under way. Dropping it ends it, and everything that it started.
pub type Simulating =
    Pin<Box<dyn Future<Output = Result<Box<JobSimulation>, SimulationError>> + Send>>;

/// Plays jobs against virtual robots of its own, which share nothing with the cell's.
pub trait JobSimulator: fmt::Debug + Send + Sync + 'static {
    /// Plays one job from a scene. It bounds its own time, and what it tells then is what was known so far.
    fn simulate(&self, scene: Scene) -> Simulating;
}

/// Why there is no result.
#[derive(Debug, Error)]
#[error("{reason}")]
pub struct SimulationError {
    /// In a sentence.
    pub reason: String,
}

/// A cell as it is now, and the job that is to be played in it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Scene {
    /// The cell.
    pub cell: String,
    /// Its set-up, with every load where it is now.
    pub setup: SetupFile,
    /// Its arms.
    pub arms: Vec<SceneArm>,
    /// Where its mobile robots stand, those that are not where they wait.
    pub mobile_robots: Vec<SceneMobileRobot>,
    /// The job.
    pub job: JobBody,
    /// The time.
    pub now: Timestamp,
    /// What had to be supposed, in sentences.
    pub assumptions: Vec<String>,
}

/// An arm of a scene.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SceneArm {
    /// Its id.
    pub id: String,
    /// Its pendant joints in degrees; the set-up's safe pose where absent.
    pub joints_deg: Option<[f64; 6]>,
    /// The controller's general override in percent; 100 where absent.
    pub speed_override: Option<u8>,
}

/// A mobile robot of a scene.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SceneMobileRobot {
    /// Its id.
    pub id: String,
    /// Where it stands, in the cell frame.
    pub pose: FloorPoseBody,
}
