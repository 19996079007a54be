//! Messages pushed to a mobile robot, for one that does not fetch them.
//!
//! The address comes from the configuration and from nowhere else. Whatever answers there is not trusted: it has three
//! seconds and 256 KiB, is followed nowhere, and has taken a message only if it says so.

use std::error::Error;
use std::time::Duration;

use api::OutboxMessage;
use reqwest::redirect::Policy;
use reqwest::{Client, StatusCode};
use serde::Deserialize;
use thiserror::Error;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use super::outbox::Outboxes;

/// For everything, from the connection to the end of the answer.
const DEADLINE: Duration = Duration::from_secs(3);
const MAX_ANSWER: usize = 256 * 1024;
const FIRST_PAUSE: Duration = Duration::from_millis(250);
const LAST_PAUSE: Duration = Duration::from_secs(8);

/// Why it is not known that a message was taken. It may have been.
#[derive(Debug, Error)]
enum Untaken {
    #[error("no answer within {} s", DEADLINE.as_secs())]
    Silent(#[source] reqwest::Error),
    #[error("the exchange failed")]
    Failed(#[source] reqwest::Error),
    #[error("the answer has status {0}")]
    Status(StatusCode),
    #[error("the answer is longer than {MAX_ANSWER} bytes")]
    TooLong,
    #[error("the answer is not the number of the message, as JSON: `{{\"n\": {n}}}`")]
    NotTheNumber { n: u64 },
}

/// What a mobile robot answers to a message it has taken.
#[derive(Deserialize)]
struct Taken {
    n: u64,
}

/// Pushes the messages for a mobile robot, one after the other, until `stop` is cancelled.
pub(crate) async fn push(robot: String, url: String, outboxes: Outboxes, stop: CancellationToken) {
    let client = Client::builder()
        .no_proxy()
        .redirect(Policy::none())
        .retry(reqwest::retry::never())
        .timeout(DEADLINE)
        .build();
    match client {
        Ok(client) => {
            let pushing = push_all(&robot, &url, &client, &outboxes);
            let _stopped = stop.run_until_cancelled(pushing).await;
        }
        Err(error) => tracing::error!(
            mobile_robot.id = robot,
            error = &error as &dyn Error,
            "messages are not pushed"
        ),
    }
}

async fn push_all(robot: &str, url: &str, client: &Client, outboxes: &Outboxes) {
    let mut news = outboxes.watch();
    let (mut pause, mut away) = (FIRST_PAUSE, false);
    loop {
        news.mark_unchanged();
        // Read anew for each attempt: a permit that was taken back meanwhile must not be pushed any more.
        let next = outboxes.after(robot, 0).into_iter().next();
        let Some(message) = next else {
            if news.changed().await.is_err() {
                return;
            }
            continue;
        };
        match offer(client, url, &message).await {
            Ok(()) => {
                if away {
                    tracing::info!(mobile_robot.id = robot, "messages are pushed again");
                }
                (pause, away) = (FIRST_PAUSE, false);
                if let Err(refused) = outboxes.acknowledge(robot, message.n).await {
                    // It stays in the outbox and is pushed again; the robot knows it by its number.
                    tracing::debug!(?refused, mobile_robot.id = robot, "a push was not kept");
                    sleep(pause).await;
                }
            }
            Err(untaken) => {
                if !away {
                    tracing::warn!(
                        mobile_robot.id = robot,
                        n = message.n,
                        error = &untaken as &dyn Error,
                        "a message was pushed in vain; it is tried again, and can be fetched"
                    );
                }
                away = true;
                sleep(pause).await;
                pause = (pause * 2).min(LAST_PAUSE);
            }
        }
    }
}

/// Offers a message once.
async fn offer(client: &Client, url: &str, message: &OutboxMessage) -> Result<(), Untaken> {
    let sorted = |error: reqwest::Error| {
        if error.is_timeout() {
            Untaken::Silent(error.without_url())
        } else {
            Untaken::Failed(error.without_url())
        }
    };
    let sent = client.post(url).json(message).send().await;
    let mut answer = sent.map_err(sorted)?;
    if !answer.status().is_success() {
        return Err(Untaken::Status(answer.status()));
    }
    let mut body = Vec::new();
    while let Some(chunk) = answer.chunk().await.map_err(sorted)? {
        if body.len() + chunk.len() > MAX_ANSWER {
            return Err(Untaken::TooLong);
        }
        body.extend_from_slice(&chunk);
    }
    let n = message.n;
    match serde_json::from_slice::<Taken>(&body) {
        Ok(taken) if taken.n == n => Ok(()),
        Ok(_) | Err(_) => Err(Untaken::NotTheNumber { n }),
    }
}
