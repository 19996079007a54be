//! Controller time: real, scaled, or stepped by a test.

use std::time::Duration;

use tokio::sync::{mpsc, oneshot};
use tokio::time::Instant;

use crate::error::ControllerStopped;

/// Steps that may be asked for before the first is done.
const STEP_QUEUE: usize = 16;

/// The largest time scale: a controller year in about nine hours.
const MAX_SCALE: f64 = 1000.0;

/// What makes the time of one controller pass.
#[derive(Debug)]
pub struct Clock {
    pub(crate) kind: Kind,
}

#[derive(Debug)]
pub(crate) enum Kind {
    Running { scale: f64 },
    Stepped { steps: mpsc::Receiver<Step> },
}

/// A request to a stepped controller.
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

    /// `scale` controller seconds in a second, above 0 and up to 1000; `None` beyond.
    #[must_use]
    pub fn scaled(scale: f64) -> Option<Self> {
        (scale > 0.0 && scale <= MAX_SCALE).then_some(Self {
            kind: Kind::Running { scale },
        })
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

/// Makes the time of a stepped controller pass.
///
/// Everything that the operating system has received for the controller when a step begins is handled before time
/// moves, and at each moment at which the controller does something, the sockets are looked at again. So a test that
/// talks to the controller and steps it in turn sees the same history every time.
#[derive(Clone, Debug)]
pub struct Stepper {
    sender: mpsc::Sender<Step>,
}

impl Stepper {
    /// Lets `by` of controller time pass, waits until nothing more happens, and answers with the new time.
    ///
    /// # Errors
    /// The controller has stopped.
    pub async fn advance(&self, by: Duration) -> Result<Duration, ControllerStopped> {
        let (done, answer) = oneshot::channel();
        self.sender
            .send(Step { by, done })
            .await
            .map_err(|_| ControllerStopped)?;
        answer.await.map_err(|_| ControllerStopped)
    }

    /// Lets everything happen that needs no time.
    ///
    /// # Errors
    /// The controller has stopped.
    pub async fn settle(&self) -> Result<Duration, ControllerStopped> {
        self.advance(Duration::ZERO).await
    }
}

/// The clock as the driver keeps it.
#[derive(Debug)]
pub(crate) enum Timekeeper {
    Running { origin: Instant, scale: f64 },
    Stepped(Stepping),
}

/// The state of a stepped clock.
#[derive(Debug)]
pub(crate) struct Stepping {
    pub(crate) steps: mpsc::Receiver<Step>,
    pub(crate) target: Duration,
    pub(crate) done: Option<oneshot::Sender<Duration>>,
}

impl Timekeeper {
    pub(crate) fn start(clock: Clock) -> Self {
        match clock.kind {
            Kind::Running { scale } => Self::Running {
                origin: Instant::now(),
                scale,
            },
            Kind::Stepped { steps } => Self::Stepped(Stepping {
                steps,
                target: Duration::ZERO,
                done: None,
            }),
        }
    }

    /// The time the controller should have reached by now.
    pub(crate) fn target(&self) -> Duration {
        match self {
            Self::Running { origin, scale } => origin.elapsed().mul_f64(*scale),
            Self::Stepped(stepping) => stepping.target,
        }
    }

    /// When the controller reaches `time`, if it does so without help.
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
        if let Self::Stepped(stepping) = self
            && let Some(step) = stepping.steps.recv().await
        {
            return step;
        }
        std::future::pending().await
    }
}
