//! The way out: addresses, time limits and request ids. What comes back is sorted in `answer`.

use std::time::Duration;

use reqwest::{Method, RequestBuilder, StatusCode, Url};
use serde::Serialize;
use serde::de::DeserializeOwned;
use uuid::Uuid;

use crate::ClientError;
use crate::answer::{Answer, Call};

/// How long an idle connection is kept. Servers close theirs after some seconds; a command that meets such a close on its
/// way would be in doubt for nothing.
const IDLE: Duration = Duration::from_secs(2);
/// The longest id the server takes for its own.
const MAX_REQUEST_ID: usize = 64;
pub(crate) const REQUEST_ID: &str = "x-request-id";

/// How long to wait for what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timeouts {
    /// For a connection.
    pub connect: Duration,
    /// For the answer to a question: nothing on the robot depends on it.
    pub question: Duration,
    /// For the answer to a command without a deadline of its own. Longer than the longest deadline a server grants,
    /// so that the server's verdict is heard: giving up earlier turns a known outcome into an unknown one.
    pub command: Duration,
}

impl Default for Timeouts {
    /// 3 s to connect, 10 s for a question, 80 s for a command.
    fn default() -> Self {
        Self {
            connect: Duration::from_secs(3),
            question: Duration::from_secs(10),
            command: Duration::from_secs(80),
        }
    }
}

/// What a request may do to the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Effect {
    /// It only asks.
    Question,
    /// It may move the robot; wait this long for the answer.
    Command(Duration),
}

/// The transport under both clients. Cheap to clone: the connections are shared.
#[derive(Clone, Debug)]
pub(crate) struct Http {
    inner: reqwest::Client,
    base: Url,
    request_id: Option<String>,
    pub(crate) timeouts: Timeouts,
}

impl Http {
    pub(crate) fn new(base_url: &str, timeouts: Timeouts) -> Result<Self, ClientError> {
        let refuse = |reason: String| ClientError::BaseUrl {
            url: base_url.to_owned(),
            reason,
        };
        let base = Url::parse(base_url).map_err(|error| refuse(error.to_string()))?;
        if base.scheme() != "http" {
            return Err(refuse("it must begin with http://".to_owned()));
        }
        if base.query().is_some() || base.fragment().is_some() {
            return Err(refuse("a query or fragment has no place in it".to_owned()));
        }
        // A proxy named in the environment, a redirect or a silent retry could each carry a motion to a place, or a
        // second time, that nobody asked for.
        let inner = reqwest::Client::builder()
            .no_proxy()
            .redirect(reqwest::redirect::Policy::none())
            .retry(reqwest::retry::never())
            .connect_timeout(timeouts.connect)
            .pool_idle_timeout(IDLE)
            .build()
            .map_err(|error| refuse(error.to_string()))?;
        Ok(Self {
            inner,
            base,
            request_id: None,
            timeouts,
        })
    }

    pub(crate) fn with_request_id(&self, request_id: &str) -> Result<Self, ClientError> {
        let legal = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
        if !(1..=MAX_REQUEST_ID).contains(&request_id.len()) || !request_id.bytes().all(legal) {
            return Err(ClientError::RequestId {
                id: request_id.to_owned(),
            });
        }
        Ok(Self {
            request_id: Some(request_id.to_owned()),
            ..self.clone()
        })
    }

    pub(crate) fn get(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::GET, path, effect)
    }

    pub(crate) fn post(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::POST, path, effect)
    }

    pub(crate) fn put(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::PUT, path, effect)
    }

    fn exchange(&self, method: Method, path: &[&str], effect: Effect) -> Exchange {
        let mut url = self.base.clone();
        // Only URLs that cannot be a base (`mailto:`) have no segments, and `new` admits none of those.
        if let Ok(mut segments) = url.path_segments_mut() {
            let _ = segments.pop_if_empty().extend(path);
        }
        let request_id = self
            .request_id
            .clone()
            .unwrap_or_else(|| Uuid::now_v7().to_string());
        let timeout = match effect {
            Effect::Question => self.timeouts.question,
            Effect::Command(timeout) => timeout,
        };
        Exchange {
            request: self
                .inner
                .request(method, url.clone())
                .timeout(timeout)
                .header(REQUEST_ID, &request_id),
            call: Call {
                url: url.into(),
                request_id,
                timeout,
                effect,
            },
        }
    }
}

/// A request about to be sent.
#[derive(Debug)]
pub(crate) struct Exchange {
    request: RequestBuilder,
    call: Call,
}

impl Exchange {
    pub(crate) fn query<T: Serialize + ?Sized>(mut self, query: &T) -> Self {
        self.request = self.request.query(query);
        self
    }

    pub(crate) fn header(mut self, name: &'static str, value: &str) -> Self {
        self.request = self.request.header(name, value);
        self
    }

    pub(crate) fn body<T: Serialize + ?Sized>(mut self, body: &T) -> Self {
        self.request = self.request.json(body);
        self
    }

    /// Sends the request and reads a JSON answer.
    pub(crate) async fn json<T: DeserializeOwned>(self) -> Result<T, ClientError> {
        self.send().await?.success()?.json()
    }

    /// As [`Exchange::json`], where an answer with this status is a value, too.
    pub(crate) async fn json_even_at<T: DeserializeOwned>(
        self,
        status: StatusCode,
    ) -> Result<T, ClientError> {
        let answer = self.send().await?;
        if answer.status() == status {
            answer.json()
        } else {
            answer.success()?.json()
        }
    }

    /// Sends the request and reads a text answer.
    pub(crate) async fn text(self) -> Result<String, ClientError> {
        self.send().await?.success()?.text()
    }

    async fn send(self) -> Result<Answer, ClientError> {
        let response = match self.request.send().await {
            Ok(response) => response,
            Err(error) => return Err(self.call.broken(error)),
        };
        Answer::read(self.call, response).await
    }
}
