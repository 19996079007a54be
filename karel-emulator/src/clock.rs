//! Controller time: real, scaled, or stepped by a test.

use std::time::Duration;

use tokio::sync::{mpsc, oneshot};
use tokio::time::Instant;

use crate::error::ControllerStopped;

/// Steps that may be asked for before the first is done.
const STEP_QUEUE: usize = 16;

/// The largest time scale: a controller year in about nine hours.
const MAX_SCALE: f64 = 1000.0;

/// The longest step that can be asked for at once: a day.
const MAX_STEP_MS: u64 = 86_400_000;

/// What makes the time of one controller pass.
#[derive(Debug)]
pub struct Clock {
    pub(crate) kind: Kind,
}

#[derive(Debug)]
pub(crate) enum Kind {
    Running { scale: f64 },
    Unhurried,
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

    /// Time jumps to whatever is due next, as fast as this machine can; with nothing due it stands still.
    ///
    /// For programs that talk to nobody: a client outside would find every timeout over.
    #[must_use]
    pub fn unhurried() -> Self {
        Self {
            kind: Kind::Unhurried,
        }
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
pub(crate) struct Timekeeper {
    pace: Pace,
    /// Controller seconds in a second, while time runs.
    scale: f64,
    /// How time goes on after a pause.
    paused: Option<Pause>,
    /// The hands of a test.
    steps: Option<mpsc::Receiver<Step>>,
    /// Where time stands still.
    target: Duration,
    /// The step under way.
    done: Option<oneshot::Sender<Duration>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    Running { origin: Instant, base: Duration },
    Unhurried,
    Still,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Pause {
    FromRunning,
    FromUnhurried,
}

/// How time passes, as people see it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
pub struct TimeView {
    /// Controller time since the first power-on.
    pub time_s: f64,
    /// Whether time stands still.
    pub paused: bool,
    /// Controller seconds in a second; `null` if time jumps to whatever is due next.
    pub scale: Option<f64>,
    /// Whether a test has the time in its hands: nobody else can change it then.
    pub stepped: bool,
}

/// Why the time was not changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TimeError {
    /// A scale beyond the limits.
    #[error("the time scale is {0}, it must be above 0 and at most {MAX_SCALE}")]
    Scale(f64),
    /// A step beyond the limits.
    #[error("the step is {0} ms, it must be 1 to {MAX_STEP_MS}")]
    Step(u64),
    /// A step while time runs.
    #[error("time runs: pause it before stepping it")]
    NotPaused,
    /// A second step.
    #[error("a step is under way")]
    Busy,
    /// The time is in the hands of a test.
    #[error("the time is stepped by the program that started this controller")]
    Stepped,
    /// The controller stopped.
    #[error(transparent)]
    Stopped(#[from] ControllerStopped),
}

impl Timekeeper {
    pub(crate) fn start(clock: Clock) -> Self {
        let (pace, scale, steps) = match clock.kind {
            Kind::Running { scale } => (Pace::running(Duration::ZERO), scale, None),
            Kind::Unhurried => (Pace::Unhurried, 1.0, None),
            Kind::Stepped { steps } => (Pace::Still, 1.0, Some(steps)),
        };
        Self {
            pace,
            scale,
            paused: None,
            steps,
            target: Duration::ZERO,
            done: None,
        }
    }

    /// The time the controller should have reached by now.
    pub(crate) fn target(&self, now: Duration, next: Option<Duration>) -> Duration {
        match self.pace {
            Pace::Running { origin, base } => {
                base.saturating_add(origin.elapsed().mul_f64(self.scale))
            }
            Pace::Unhurried => next.unwrap_or(now).max(now),
            Pace::Still => self.target,
        }
    }

    /// When the controller reaches `time`, if it does so without help.
    pub(crate) fn instant_of(&self, time: Duration) -> Option<Instant> {
        match self.pace {
            Pace::Running { origin, base } => {
                let ahead = time.saturating_sub(base).as_secs_f64() / self.scale;
                origin.checked_add(Duration::try_from_secs_f64(ahead).ok()?)
            }
            Pace::Unhurried => Some(Instant::now()),
            Pace::Still => None,
        }
    }

    /// Whether time stands still but for steps.
    pub(crate) fn is_still(&self) -> bool {
        self.pace == Pace::Still
    }

    /// Whether a step is under way.
    pub(crate) fn is_stepping(&self) -> bool {
        self.done.is_some()
    }

    /// Lets a step begin.
    pub(crate) fn begin(&mut self, now: Duration, step: Step) {
        self.target = now.saturating_add(step.by);
        self.done = Some(step.done);
    }

    /// The controller has reached the target.
    pub(crate) fn finish_step(&mut self, now: Duration) {
        if let Some(done) = self.done.take() {
            // Nobody waits any more if the test gave up.
            let _given_up = done.send(now);
        }
    }

    /// The next step of a test; never, if there is none.
    pub(crate) async fn next_step(&mut self) -> Step {
        if let Some(steps) = &mut self.steps
            && let Some(step) = steps.recv().await
        {
            return step;
        }
        std::future::pending().await
    }

    pub(crate) fn view(&self, now: Duration) -> TimeView {
        let unhurried = self.pace == Pace::Unhurried || self.paused == Some(Pause::FromUnhurried);
        TimeView {
            time_s: crate::ledger::seconds(now),
            paused: self.is_still(),
            scale: (!unhurried).then_some(self.scale),
            stepped: self.steps.is_some(),
        }
    }

    /// Stops time, or lets it go on as before.
    pub(crate) fn pause(&mut self, now: Duration, paused: bool) -> Result<(), TimeError> {
        self.check_free()?;
        match (paused, self.pace) {
            (true, Pace::Running { .. }) => self.paused = Some(Pause::FromRunning),
            (true, Pace::Unhurried) => self.paused = Some(Pause::FromUnhurried),
            (true, Pace::Still) | (false, Pace::Running { .. } | Pace::Unhurried) => return Ok(()),
            (false, Pace::Still) => {
                self.finish_step(now);
                self.pace = match self.paused.take() {
                    Some(Pause::FromUnhurried) => Pace::Unhurried,
                    Some(Pause::FromRunning) | None => Pace::running(now),
                };
                return Ok(());
            }
        }
        self.pace = Pace::Still;
        self.target = now;
        Ok(())
    }

    /// Changes the time scale; a clock that does not hurry gets one.
    pub(crate) fn set_scale(&mut self, now: Duration, scale: f64) -> Result<(), TimeError> {
        self.check_free()?;
        if !(scale > 0.0 && scale <= MAX_SCALE) {
            return Err(TimeError::Scale(scale));
        }
        self.scale = scale;
        if self.is_still() {
            self.paused = Some(Pause::FromRunning);
        } else {
            self.pace = Pace::running(now);
        }
        Ok(())
    }

    /// Lets some time pass while it stands still; the answer comes when it has.
    pub(crate) fn step(
        &mut self,
        now: Duration,
        ms: u64,
    ) -> Result<oneshot::Receiver<Duration>, TimeError> {
        self.check_free()?;
        if !(1..=MAX_STEP_MS).contains(&ms) {
            return Err(TimeError::Step(ms));
        }
        if !self.is_still() {
            return Err(TimeError::NotPaused);
        }
        if self.is_stepping() {
            return Err(TimeError::Busy);
        }
        let (done, answer) = oneshot::channel();
        let by = Duration::from_millis(ms);
        self.begin(now, Step { by, done });
        Ok(answer)
    }

    fn check_free(&self) -> Result<(), TimeError> {
        if self.steps.is_some() {
            return Err(TimeError::Stepped);
        }
        Ok(())
    }
}

impl Pace {
    fn running(base: Duration) -> Self {
        Self::Running {
            origin: Instant::now(),
            base,
        }
    }
}
