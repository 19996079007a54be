use std::time::Duration;

use tokio::time::{Instant, MissedTickBehavior, interval, timeout_at};

/// How often a condition is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// What one look at a condition saw.
#[derive(Clone, Debug, Eq, PartialEq)]
pub enum Look<T> {
    /// The condition holds.
    Ready(T),
    /// It does not hold yet.
    NotYet {
        /// What was seen instead, for the message of a timeout: `J2 at 41.7°, target 45.0°`.
        last: String,
    },
}

impl<T> Look<T> {
    /// The condition does not hold yet; this was seen instead.
    pub fn not_yet(last: impl Into<String>) -> Self {
        Self::NotYet { last: last.into() }
    }
}

/// A condition that did not come to hold.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[error("timed out after {max:?} waiting for {what}; last: {last}")]
pub struct TimedOut {
    /// What was waited for.
    pub what: String,
    /// How long.
    pub max: Duration,
    /// What the last look saw.
    pub last: String,
}

/// Waits until `condition` is ready, at most `max`.
///
/// `what` completes the sentence "waiting for …". The condition is looked at every few milliseconds; one that hangs is
/// given up on at the same moment as one that says no.
///
/// ```
/// # #[tokio::main(flavor = "current_thread")]
/// # async fn main() -> Result<(), tests::TimedOut> {
/// use std::time::Duration;
/// use tests::{Look, wait_until};
///
/// let mut count = 0;
/// let ready = wait_until("the third look", Duration::from_secs(10), async || {
///     count += 1;
///     if count == 3 { Look::Ready(count) } else { Look::not_yet(format!("look {count}")) }
/// })
/// .await?;
/// assert_eq!(ready, 3);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`TimedOut`], with what the last look saw.
pub async fn wait_until<T>(
    what: &str,
    max: Duration,
    mut condition: impl AsyncFnMut() -> Look<T>,
) -> Result<T, TimedOut> {
    let end = Instant::now() + max;
    let mut ticks = interval(LOOK_EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut seen = "nothing: the first look did not end".to_owned();
    loop {
        let _ = ticks.tick().await;
        match timeout_at(end, condition()).await {
            Ok(Look::Ready(value)) => return Ok(value),
            Ok(Look::NotYet { last }) => seen = last,
            Err(_) => {}
        }
        if Instant::now() >= end {
            return Err(TimedOut {
                what: what.to_owned(),
                max,
                last: seen,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_timeout_says_what_was_missing() {
        let timed_out = wait_until("the arm at 45°", Duration::from_secs(2), async || {
            Look::<()>::not_yet("J2 at 41.7°")
        })
        .await
        .unwrap_err();
        assert_eq!(
            timed_out.to_string(),
            "timed out after 2s waiting for the arm at 45°; last: J2 at 41.7°"
        );
    }

    #[tokio::test(start_paused = true)]
    async fn a_look_that_hangs_is_given_up_on() {
        let mut looks = 0;
        let timed_out = wait_until("an answer", Duration::from_secs(2), async || {
            looks += 1;
            if looks == 2 {
                std::future::pending::<()>().await;
            }
            Look::<()>::not_yet("no answer")
        })
        .await
        .unwrap_err();
        assert_eq!(timed_out.last, "no answer");
    }

    #[tokio::test(start_paused = true)]
    async fn a_condition_that_holds_is_not_waited_for() {
        let max = Duration::ZERO;
        assert_eq!(wait_until("it", max, async || Look::Ready(7)).await, Ok(7));
    }
}
