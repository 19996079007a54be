//! Signals out and messages in, while time passes by itself.

use std::time::Duration;

use api::{OutboxMessage, OutboxQuery, SignalBody};
use client::MobileRobotClient;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::cell;
use crate::config::LinkSection;
use crate::outbound::SendOutcome;

/// One signal is on its way at a time; after a crash another may already want to be.
const SENDS: usize = 4;
const NEWS: usize = 16;
const FIRST_PAUSE: Duration = Duration::from_millis(250);
const LAST_PAUSE: Duration = Duration::from_secs(8);

/// What came from the cell.
#[derive(Debug)]
pub(super) enum News {
    Outcome(Box<SignalBody>, SendOutcome),
    /// Messages, and where to say that they are taken.
    Messages(Vec<OutboxMessage>, oneshot::Sender<()>),
    Away(String),
}

/// The two tasks that talk to the cell.
#[derive(Debug)]
pub(super) struct Link {
    sends: mpsc::Sender<SignalBody>,
    news: mpsc::Receiver<News>,
    after: watch::Sender<Option<u64>>,
}

impl Link {
    pub(super) fn start(
        robot: &MobileRobotClient,
        settings: &LinkSection,
        stop: &CancellationToken,
        tracker: &TaskTracker,
    ) -> Self {
        let (sends, waiting) = mpsc::channel(SENDS);
        let (sender, news) = mpsc::channel(NEWS);
        let (after, listen) = watch::channel(None);
        let posting = post_all(robot.clone(), waiting, sender.clone());
        let guard = stop.clone();
        let _task = tracker.spawn(async move { guard.run_until_cancelled(posting).await });
        if settings.poll {
            let listening = listen_for_ever(robot.clone(), settings.poll_wait_s, listen, sender);
            let guard = stop.clone();
            let _task = tracker.spawn(async move { guard.run_until_cancelled(listening).await });
        }
        Self { sends, news, after }
    }

    /// Sends a signal; its outcome is news.
    pub(super) fn send(
        &mut self,
        signal: SignalBody,
    ) -> Result<(), (Box<SignalBody>, SendOutcome)> {
        self.sends.try_send(signal).map_err(|error| {
            let reason = "too many signals are on their way".to_owned();
            let outcome = SendOutcome::Unanswered { reason };
            (Box::new(error.into_inner()), outcome)
        })
    }

    pub(super) async fn news(&mut self) -> Option<News> {
        self.news.recv().await
    }

    /// The last message the robot has taken; nothing while it cannot take any.
    pub(super) fn listen_after(&mut self, after: Option<u64>) {
        let _changed = self.after.send_if_modified(|known| {
            let changed = *known != after;
            *known = after;
            changed
        });
    }
}

async fn post_all(
    robot: MobileRobotClient,
    mut waiting: mpsc::Receiver<SignalBody>,
    news: mpsc::Sender<News>,
) {
    while let Some(signal) = waiting.recv().await {
        let outcome = cell::post(&robot, &signal).await;
        if news
            .send(News::Outcome(Box::new(signal), outcome))
            .await
            .is_err()
        {
            return;
        }
    }
}

async fn listen_for_ever(
    robot: MobileRobotClient,
    wait_s: u32,
    mut listen: watch::Receiver<Option<u64>>,
    news: mpsc::Sender<News>,
) {
    let mut pause = FIRST_PAUSE;
    loop {
        let after = match listen.wait_for(Option::is_some).await {
            Ok(after) => after.unwrap_or_default(),
            Err(_stopped) => return,
        };
        let told = match cell::poll(&robot, OutboxQuery { after, wait_s }).await {
            Ok(messages) => {
                // A server that answers at once with nothing is not asked at once again.
                let empty = messages.is_empty();
                pause = FIRST_PAUSE;
                let (taken, wait) = oneshot::channel();
                let told = news.send(News::Messages(messages, taken)).await;
                let _taken = wait.await;
                if empty {
                    sleep(Duration::from_millis(20)).await;
                }
                told
            }
            Err(reason) => {
                let told = news.send(News::Away(reason)).await;
                sleep(pause).await;
                pause = (pause * 2).min(LAST_PAUSE);
                told
            }
        };
        if told.is_err() {
            return;
        }
    }
}
