//! What came back: the sorting of answers into values and errors.

use std::time::Duration;

use api::{LegacyValidation, Outcome, Problem};
use reqwest::{Response, StatusCode, header};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::ClientError;
use crate::http::{Effect, REQUEST_ID};

/// The largest body this client reads, in bytes, but for answers that take long to compute. A larger one is a
/// [`ClientError::Protocol`].
pub const MAX_ANSWER_BYTES: usize = 1024 * 1024;

/// The same for what is computed at length and answered in full: samples of a trajectory, counts of a grid.
const MAX_LONG_ANSWER_BYTES: usize = 32 * 1024 * 1024;

const EXCERPT_CHARS: usize = 200;

/// A request on its way: what every error about it tells.
#[derive(Debug)]
pub(crate) struct Call {
    pub(crate) url: String,
    pub(crate) request_id: String,
    pub(crate) timeout: Duration,
    pub(crate) effect: Effect,
}

impl Call {
    /// The largest body that is read.
    fn largest(&self) -> usize {
        match self.effect {
            Effect::Question | Effect::Command(_) => MAX_ANSWER_BYTES,
            Effect::LongQuestion(_) => MAX_LONG_ANSWER_BYTES,
        }
    }

    /// What is known of the effect when the request may have been sent and no answer tells.
    fn outcome_in_doubt(&self) -> Outcome {
        match self.effect {
            Effect::Question | Effect::LongQuestion(_) => Outcome::None,
            Effect::Command(_) => Outcome::Unknown,
        }
    }

    /// The transport gave up.
    pub(crate) fn broken(self, error: reqwest::Error) -> ClientError {
        let outcome = self.outcome_in_doubt();
        let url = self.url;
        let request_id = self.request_id;
        // The address is told already; a cause that repeats it hides itself.
        let source = error.without_url();
        if source.is_connect() || source.is_builder() {
            ClientError::Unreachable {
                url,
                source: source.into(),
            }
        } else if source.is_timeout() {
            ClientError::Timeout {
                url,
                after: self.timeout,
                outcome,
                request_id,
            }
        } else {
            ClientError::Interrupted {
                url,
                outcome,
                request_id,
                source: source.into(),
            }
        }
    }
}

/// The part of a refusal that everyone writes: the thesis's routes, the virtual controller's panel, and a server whose
/// problem codes are newer than this client.
#[derive(Deserialize)]
struct BareRefusal {
    detail: String,
    #[serde(default)]
    outcome: Option<Outcome>,
}

/// An answer, read to its end.
#[derive(Debug)]
pub(crate) struct Answer {
    call: Call,
    status: StatusCode,
    is_problem: bool,
    etag: Option<String>,
    body: Vec<u8>,
}

impl Answer {
    /// Reads the body, at most as much of it as such an answer may have.
    pub(crate) async fn read(call: Call, mut response: Response) -> Result<Self, ClientError> {
        let answers = response.headers().get(REQUEST_ID).cloned();
        let mut answer = Self {
            status: response.status(),
            is_problem: is_problem(&response),
            etag: etag(&response),
            call,
            body: Vec::new(),
        };
        let largest = answer.call.largest();
        loop {
            match response.chunk().await {
                Ok(Some(chunk)) if answer.body.len() + chunk.len() <= largest => {
                    answer.body.extend_from_slice(&chunk);
                }
                Ok(Some(_)) => {
                    return Err(answer.strange(format!("a body of more than {largest} bytes")));
                }
                Ok(None) => break,
                Err(error) => return Err(answer.call.broken(error)),
            }
        }
        match answers {
            Some(id) if id.as_bytes() != answer.call.request_id.as_bytes() => {
                Err(answer.strange("the id of another request".to_owned()))
            }
            Some(_) | None => Ok(answer),
        }
    }

    pub(crate) fn status(&self) -> StatusCode {
        self.status
    }

    /// The entity tag, which the answer must have.
    pub(crate) fn etag(&self) -> Result<String, ClientError> {
        let etag = self.etag.clone();
        etag.ok_or_else(|| ClientError::Protocol {
            status: self.status.as_u16(),
            reason: "no entity tag".to_owned(),
            excerpt: excerpt(&self.body),
            outcome: self.call.outcome_in_doubt(),
            url: self.call.url.clone(),
            request_id: self.call.request_id.clone(),
        })
    }

    /// This answer, if its status says yes.
    pub(crate) fn success(self) -> Result<Self, ClientError> {
        if self.status.is_success() {
            Ok(self)
        } else {
            Err(self.refusal())
        }
    }

    pub(crate) fn json<T: DeserializeOwned>(self) -> Result<T, ClientError> {
        serde_json::from_slice(&self.body)
            .map_err(|error| self.strange(format!("a body that does not fit ({error})")))
    }

    pub(crate) fn text(mut self) -> Result<String, ClientError> {
        String::from_utf8(std::mem::take(&mut self.body)).map_err(|error| {
            self.body = error.into_bytes();
            self.strange("a body that is not UTF-8".to_owned())
        })
    }

    fn refusal(self) -> ClientError {
        if self.is_problem
            && let Ok(mut problem) = serde_json::from_slice::<Problem>(&self.body)
        {
            let _ = problem.request_id.get_or_insert(self.call.request_id);
            return ClientError::Problem(Box::new(problem));
        }
        if let Ok(bare) = serde_json::from_slice::<BareRefusal>(&self.body) {
            return ClientError::Refused {
                status: self.status.as_u16(),
                detail: bare.detail,
                outcome: bare.outcome.unwrap_or_else(|| self.outcome_by_status()),
                request_id: self.call.request_id,
            };
        }
        match serde_json::from_slice(&self.body) {
            Ok(LegacyValidation { detail }) => ClientError::Invalid {
                items: detail,
                request_id: self.call.request_id,
            },
            Err(_) => self.strange("a body that is no problem document".to_owned()),
        }
    }

    /// The seed's shape has no place for the outcome; what its statuses tell is all there is.
    fn outcome_by_status(&self) -> Outcome {
        match (self.call.effect, self.status) {
            (Effect::Question | Effect::LongQuestion(_), _) => Outcome::None,
            (Effect::Command(_), StatusCode::CONFLICT) => Outcome::Rejected,
            (Effect::Command(_), StatusCode::SERVICE_UNAVAILABLE) => Outcome::NotSent,
            (Effect::Command(_), status) if status.is_client_error() => Outcome::NotSent,
            (Effect::Command(_), _) => Outcome::Unknown,
        }
    }

    fn strange(self, reason: String) -> ClientError {
        ClientError::Protocol {
            status: self.status.as_u16(),
            reason,
            excerpt: excerpt(&self.body),
            outcome: self.call.outcome_in_doubt(),
            url: self.call.url,
            request_id: self.call.request_id,
        }
    }
}

fn etag(response: &Response) -> Option<String> {
    let value = response.headers().get(header::ETAG)?;
    value.to_str().ok().map(str::to_owned)
}

fn is_problem(response: &Response) -> bool {
    response
        .headers()
        .get(header::CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.split(';').next())
        .is_some_and(|media| {
            media
                .trim()
                .eq_ignore_ascii_case("application/problem+json")
        })
}

/// The beginning of a body, fit for a terminal.
fn excerpt(body: &[u8]) -> String {
    String::from_utf8_lossy(body)
        .chars()
        .take(EXCERPT_CHARS)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excerpt_is_short_and_moves_no_cursor() {
        let body = "\u{1b}[2Jé".repeat(200);
        let excerpt = excerpt(body.as_bytes());
        assert_eq!(excerpt.chars().count(), EXCERPT_CHARS);
        assert!(excerpt.starts_with(" [2Jé"));
    }
}
