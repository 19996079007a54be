//! The way out: addresses, time limits and request ids. What comes back is sorted in `answer`.

use std::time::Duration;

use api::{ControlToken, TokenSecret};
use reqwest::header::{self, HeaderValue};
use reqwest::{Method, RequestBuilder, StatusCode, Url};
use serde::Serialize;
use serde::de::DeserializeOwned;
use uuid::Uuid;

use crate::answer::{Answer, Call};
use crate::{ClientError, Tagged};

/// How long an idle connection is kept. Servers close theirs after some seconds; a command that meets such a close on its
/// way would be in doubt for nothing.
const IDLE: Duration = Duration::from_secs(2);
/// The longest id the server takes for its own.
const MAX_REQUEST_ID: usize = 64;
/// More than the longest token of a server.
const MAX_TOKEN: usize = 200;
/// For what lasts as long as somebody listens.
const NO_LIMIT: Duration = Duration::from_hours(365 * 24);
pub(crate) const REQUEST_ID: &str = "x-request-id";
const CONTROL_TOKEN: &str = "control-token";

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
    /// It only asks for something that takes long; wait this long for the answer.
    LongQuestion(Duration),
    /// It may move the robot; wait this long for the answer.
    Command(Duration),
}

/// The transport under both clients. Cheap to clone: the connections are shared.
#[derive(Clone, Debug)]
pub(crate) struct Http {
    inner: reqwest::Client,
    base: Url,
    request_id: Option<String>,
    token: Option<HeaderValue>,
    control: Option<ControlToken>,
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
            token: None,
            control: None,
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

    pub(crate) fn with_token(&self, token: &TokenSecret) -> Result<Self, ClientError> {
        let text = token.reveal();
        let legal = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
        let looks_like_one =
            text.starts_with("cell_") && text.len() <= MAX_TOKEN && text.bytes().all(legal);
        let mut value = HeaderValue::from_str(&format!("Bearer {text}"))
            .ok()
            .filter(|_| looks_like_one)
            .ok_or(ClientError::Token)?;
        // Debug does not show it then.
        value.set_sensitive(true);
        Ok(Self {
            token: Some(value),
            ..self.clone()
        })
    }

    pub(crate) fn with_control(&self, token: ControlToken) -> Self {
        Self {
            control: Some(token),
            ..self.clone()
        }
    }

    pub(crate) fn get(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::GET, path, effect)
    }

    pub(crate) fn post(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::POST, path, effect)
    }

    pub(crate) fn patch(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::PATCH, path, effect)
    }

    pub(crate) fn put(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::PUT, path, effect)
    }

    pub(crate) fn delete(&self, path: &[&str], effect: Effect) -> Exchange {
        self.exchange(Method::DELETE, path, effect)
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
            Effect::LongQuestion(timeout) | Effect::Command(timeout) => timeout,
        };
        let mut request = self
            .inner
            .request(method, url.clone())
            .timeout(timeout)
            .header(REQUEST_ID, &request_id);
        if let Some(token) = &self.token {
            request = request.header(header::AUTHORIZATION, token);
        }
        if let (Some(control), Effect::Command(_)) = (self.control, effect) {
            request = request.header(CONTROL_TOKEN, control.to_string());
        }
        Exchange {
            request,
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
    /// Waits this long for the answer instead of the usual time.
    pub(crate) fn within(mut self, timeout: Duration) -> Self {
        self.request = self.request.timeout(timeout);
        self.call.timeout = timeout;
        self
    }

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

    /// A body that is text already.
    pub(crate) fn text_body(mut self, media_type: &'static str, text: String) -> Self {
        self.request = self
            .request
            .header(header::CONTENT_TYPE, media_type)
            .body(text);
        self
    }

    pub(crate) fn accept(mut self, media_type: &'static str) -> Self {
        self.request = self.request.header(header::ACCEPT, media_type);
        self
    }

    /// The entity tag that a change is based on.
    pub(crate) fn if_match(mut self, etag: &str) -> Self {
        self.request = self.request.header(header::IF_MATCH, etag);
        self
    }

    /// Sends the request and reads a JSON answer with its entity tag.
    pub(crate) async fn tagged_json<T: DeserializeOwned>(self) -> Result<Tagged<T>, ClientError> {
        let answer = self.send().await?.success()?;
        let etag = answer.etag()?;
        Ok(Tagged {
            etag,
            value: answer.json()?,
        })
    }

    /// Sends the request and reads a text answer with its entity tag.
    pub(crate) async fn tagged_text(self) -> Result<Tagged<String>, ClientError> {
        let answer = self.send().await?.success()?;
        let etag = answer.etag()?;
        Ok(Tagged {
            etag,
            value: answer.text()?,
        })
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

    /// As [`Exchange::json`], where an empty answer is `null`.
    pub(crate) async fn json_or_nothing(self) -> Result<serde_json::Value, ClientError> {
        let answer = self.send().await?.success()?;
        if answer.status() == StatusCode::NO_CONTENT {
            return Ok(serde_json::Value::Null);
        }
        answer.json()
    }

    /// Sends the request and reads a text answer.
    pub(crate) async fn text(self) -> Result<String, ClientError> {
        self.send().await?.success()?.text()
    }

    /// Sends the request and leaves the answer open, once it has begun with a yes. Only the beginning has a time limit.
    pub(crate) async fn stream(self) -> Result<reqwest::Response, ClientError> {
        let Self { request, call } = self;
        let begun = tokio::time::timeout(call.timeout, request.timeout(NO_LIMIT).send());
        let response = match begun.await {
            Ok(Ok(response)) => response,
            Ok(Err(error)) => return Err(call.broken(error)),
            Err(_) => {
                return Err(ClientError::Timeout {
                    after: call.timeout,
                    outcome: api::Outcome::None,
                    url: call.url,
                    request_id: call.request_id,
                });
            }
        };
        if response.status().is_success() {
            Ok(response)
        } else {
            match Answer::read(call, response).await?.success() {
                Err(refused) => Err(refused),
                Ok(_) => unreachable!("the status said no"),
            }
        }
    }

    async fn send(self) -> Result<Answer, ClientError> {
        let response = match self.request.send().await {
            Ok(response) => response,
            Err(error) => return Err(self.call.broken(error)),
        };
        Answer::read(self.call, response).await
    }
}
