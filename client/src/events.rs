//! The stream of what happens in a cell.

mod sse;

use std::time::Duration;

use api::{CellEvent, CellStatus, EventGap, EventsQuery};
use reqwest::Response;
use serde::de::DeserializeOwned;
use tokio::time::{sleep, timeout};

use crate::http::{Effect, Http};
use crate::{Client, ClientError};
use sse::{Block, Parser, SseError};

/// A server says something every 15 s. After this long it is taken for gone.
const SILENCE: Duration = Duration::from_secs(40);
const FIRST_PAUSE: Duration = Duration::from_millis(250);
const LAST_PAUSE: Duration = Duration::from_secs(8);
/// Events of one record; more are not remembered as told.
const MAX_PARTIAL: usize = 4_096;

/// What a stream tells.
#[derive(Debug)]
pub enum Told {
    /// Something happened.
    Event(Box<CellEvent>),
    /// Events are missing: what is known of the cell has to be fetched anew.
    Gap(EventGap),
    /// The state of the cell, where it was asked for.
    Status(CellStatus),
    /// The connection is lost, and made again from where it was. Events are not lost by this.
    Lost(ClientError),
    /// The connection stands, for the first time or again.
    Connected,
}

/// What happens in one cell, from one event on, over lost connections and restarts of the server.
#[derive(Debug)]
pub struct EventStream {
    http: Http,
    cell: String,
    query: EventsQuery,
    last: Option<String>,
    /// Events that were told of the record that is not done with.
    partial: Vec<String>,
    open: Option<Open>,
    pause: Duration,
    wait: bool,
}

#[derive(Debug)]
struct Open {
    response: Response,
    parser: Parser,
}

impl Client {
    /// What happens in a cell: from `query.from` on, or from now on. Nothing is sent before the first
    /// [`EventStream::next`].
    #[must_use]
    pub fn events(&self, cell: &str, query: EventsQuery) -> EventStream {
        EventStream {
            http: self.http.clone(),
            cell: cell.to_owned(),
            last: query.from.clone(),
            query: EventsQuery {
                from: None,
                ..query
            },
            partial: Vec::new(),
            open: None,
            pause: FIRST_PAUSE,
            wait: false,
        }
    }
}

impl EventStream {
    /// The id of the last record whose events were all told: where another stream would go on.
    #[must_use]
    pub fn last_id(&self) -> Option<&str> {
        self.last.as_deref()
    }

    /// The next thing to know. It waits as long as nothing happens, and may be dropped and called again.
    ///
    /// # Errors
    /// What will not be better at another attempt: no such cell, a token that is not taken, an id that is none. A lost
    /// connection is [`Told::Lost`].
    pub async fn next(&mut self) -> Result<Told, ClientError> {
        loop {
            if self.open.is_none() {
                return self.connect().await;
            }
            match self.block().await {
                Ok(Some(block)) => {
                    if let Some(told) = self.take(block)? {
                        return Ok(told);
                    }
                }
                Ok(None) => {}
                Err(error) => {
                    self.open = None;
                    return Ok(Told::Lost(error));
                }
            }
        }
    }

    async fn connect(&mut self) -> Result<Told, ClientError> {
        if self.wait {
            sleep(self.pause).await;
            self.pause = (self.pause * 2).min(LAST_PAUSE);
        }
        self.wait = true;
        let path = ["api", "v1", "cells", &self.cell, "events"];
        let mut exchange = self
            .http
            .get(&path, Effect::Question)
            .accept("text/event-stream")
            .query(&self.query);
        if let Some(last) = &self.last {
            exchange = exchange.header("last-event-id", last);
        }
        match exchange.stream().await {
            Ok(response) => {
                self.open = Some(Open {
                    response,
                    parser: Parser::default(),
                });
                Ok(Told::Connected)
            }
            Err(error) if heals(&error) => Ok(Told::Lost(error)),
            Err(error) => Err(error),
        }
    }

    /// A block of the stream; none where more has to be read.
    async fn block(&mut self) -> Result<Option<Block>, ClientError> {
        let Some(open) = &mut self.open else {
            return Ok(None);
        };
        if let Some(block) = open.parser.next() {
            return Ok(Some(block));
        }
        let url = open.response.url().to_string();
        let chunk = match timeout(SILENCE, open.response.chunk()).await {
            Ok(Ok(Some(chunk))) => chunk,
            Ok(Ok(None)) => return Err(interrupted(url, "the server ended the stream".into())),
            Ok(Err(error)) => return Err(interrupted(url, error.without_url().into())),
            Err(_) => {
                return Err(ClientError::Timeout {
                    url,
                    after: SILENCE,
                    outcome: api::Outcome::None,
                    request_id: String::new(),
                });
            }
        };
        let pushed = open.parser.push(&chunk);
        pushed.map_err(|error| protocol(url, &error))?;
        Ok(None)
    }

    fn take(&mut self, block: Block) -> Result<Option<Told>, ClientError> {
        // Something came: the next break is a new one.
        self.pause = FIRST_PAUSE;
        let Block { event, id, data } = block;
        let told = match (event.as_str(), data) {
            ("gap", Some(data)) => Some(Told::Gap(self.read(&data)?)),
            ("status", Some(data)) => Some(Told::Status(self.read(&data)?)),
            ("" | "message", Some(data)) => {
                let event: Box<CellEvent> = self.read(&data)?;
                if self.partial.contains(&event.id) {
                    None
                } else {
                    if id.is_none() && self.partial.len() < MAX_PARTIAL {
                        self.partial.push(event.id.clone());
                    }
                    Some(Told::Event(event))
                }
            }
            // Nothing but an id, or of a later version of the server.
            (_, _) => None,
        };
        if let Some(id) = id {
            self.last = Some(id);
            self.partial.clear();
        }
        Ok(told)
    }

    fn read<T: DeserializeOwned>(&self, data: &str) -> Result<T, ClientError> {
        serde_json::from_str(data).map_err(|error| ClientError::Protocol {
            url: format!("the stream of cell {}", self.cell),
            status: 200,
            reason: format!("an event that is none: {error}"),
            excerpt: excerpt(data),
            outcome: api::Outcome::None,
            request_id: String::new(),
        })
    }
}

/// Whether another attempt may go better.
fn heals(error: &ClientError) -> bool {
    match error.status() {
        Some(status) => status >= 500 || status == 429 || status == 408,
        None => matches!(
            error,
            ClientError::Unreachable { .. }
                | ClientError::Timeout { .. }
                | ClientError::Interrupted { .. }
        ),
    }
}

fn interrupted(url: String, source: Box<dyn std::error::Error + Send + Sync>) -> ClientError {
    ClientError::Interrupted {
        url,
        outcome: api::Outcome::None,
        request_id: String::new(),
        source,
    }
}

fn protocol(url: String, error: &SseError) -> ClientError {
    ClientError::Protocol {
        url,
        status: 200,
        reason: error.to_string(),
        excerpt: String::new(),
        outcome: api::Outcome::None,
        request_id: String::new(),
    }
}

fn excerpt(text: &str) -> String {
    text.chars()
        .take(200)
        .flat_map(char::escape_debug)
        .collect()
}
