//! The time of a robot: real, scaled, or stepped by a test.

use std::time::Duration;

use tokio::sync::{mpsc, oneshot};
use tokio::time::Instant;

use crate::error::RobotStopped;

/// Steps that may be asked for before the first is done.
const STEP_QUEUE: usize = 16;

/// The largest time scale: a robot's year in about nine hours.
const MAX_SCALE: f64 = 1000.0;

/// What makes the time of one robot pass.
#[derive(Debug)]
pub struct Clock {
    pub(crate) kind: Kind,
}

#[derive(Debug)]
pub(crate) enum Kind {
    Running { scale: f64 },
    Stepped { steps: mpsc::Receiver<Step> },
}

/// A request to a stepped robot.
#[derive(Debug)]
pub(crate) struct Step {
    pub(crate) by: Duration,
    pub(crate) done: oneshot::Sender<Duration>,
}

impl Clock {
    /// A second is a second.
    #[must_use]
    pub fn real() -> Self {
        Self {
            kind: Kind::Running { scale: 1.0 },
        }
    }

    /// `scale` robot seconds in a second, above 0 and up to 1000; `None` beyond.
    #[must_use]
    pub fn scaled(scale: f64) -> Option<Self> {
        (scale > 0.0 && scale <= MAX_SCALE).then_some(Self {
            kind: Kind::Running { scale },
        })
    }

    pub(crate) fn is_stepped(&self) -> bool {
        matches!(self.kind, Kind::Stepped { .. })
    }

    /// Time passes only in the hands of the [`Stepper`].
    #[must_use]
    pub fn stepped() -> (Self, Stepper) {
        let (sender, steps) = mpsc::channel(STEP_QUEUE);
        (
            Self {
                kind: Kind::Stepped { steps },
            },
            Stepper { sender },
        )
    }
}

/// Makes the time of a stepped robot pass.
///
/// The robot asks for its messages when a step begins, at fixed times within, and when it ends; its time stands while a
/// question or a signal is on its way. So a cell that answers the same sees the same history every time.
#[derive(Clone, Debug)]
pub struct Stepper {
    sender: mpsc::Sender<Step>,
}

impl Stepper {
    /// Lets `by` of robot time pass, waits until nothing more happens, and answers with the new time.
    ///
    /// # Errors
    /// The robot has stopped.
    pub async fn advance(&self, by: Duration) -> Result<Duration, RobotStopped> {
        let (done, answer) = oneshot::channel();
        self.sender
            .send(Step { by, done })
            .await
            .map_err(|_| RobotStopped)?;
        answer.await.map_err(|_| RobotStopped)
    }

    /// Lets everything happen that needs no time.
    ///
    /// # Errors
    /// The robot has stopped.
    pub async fn settle(&self) -> Result<Duration, RobotStopped> {
        self.advance(Duration::ZERO).await
    }
}

/// The clock as the driver keeps it.
#[derive(Debug)]
pub(crate) enum Timekeeper {
    Running { origin: Instant, scale: f64 },
    Stepped(mpsc::Receiver<Step>),
}

impl Timekeeper {
    pub(crate) fn start(clock: Clock) -> Self {
        match clock.kind {
            Kind::Running { scale } => Self::Running {
                origin: Instant::now(),
                scale,
            },
            Kind::Stepped { steps } => Self::Stepped(steps),
        }
    }

    /// The time the robot should have reached by now; none of its own if it is stepped.
    pub(crate) fn target(&self) -> Duration {
        match self {
            Self::Running { origin, scale } => origin.elapsed().mul_f64(*scale),
            Self::Stepped(_) => Duration::ZERO,
        }
    }

    /// When the robot reaches `time`, if it does so without help.
    pub(crate) fn instant_of(&self, time: Duration) -> Option<Instant> {
        match self {
            Self::Running { origin, scale } => {
                let wall = Duration::try_from_secs_f64(time.as_secs_f64() / scale).ok()?;
                origin.checked_add(wall)
            }
            Self::Stepped(_) => None,
        }
    }

    /// The next step; never, if time runs by itself or the stepper is gone.
    pub(crate) async fn next_step(&mut self) -> Step {
        if let Self::Stepped(steps) = self
            && let Some(step) = steps.recv().await
        {
            return step;
        }
        std::future::pending().await
    }
}
