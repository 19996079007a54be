//! One request and its answer, as far as the connection's standing is concerned.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use axum::Router;
use axum::body::Body as AnswerBody;
use axum::http::{HeaderValue, Request, Response, header};
use bytes::Bytes;
use hyper::body::{Body, Frame, Incoming, SizeHint};
use tokio::sync::OwnedSemaphorePermit;
use tower::Service as _;

use super::standing::{Phase, Standing};

/// A place for a stream of events. The edge puts it into the extensions of such an answer, and it is held until the
/// stream ends.
#[derive(Clone, Debug)]
pub(crate) struct StreamPlace {
    _held: Arc<OwnedSemaphorePermit>,
}

impl From<OwnedSemaphorePermit> for StreamPlace {
    fn from(permit: OwnedSemaphorePermit) -> Self {
        Self {
            _held: Arc::new(permit),
        }
    }
}

/// Has the router answer, and notes how far the request has come.
pub(crate) async fn answer(
    mut router: Router,
    standing: Arc<Standing>,
    request: Request<Incoming>,
) -> Result<Response<Leaving>, Infallible> {
    standing.enter(if request.body().is_end_stream() {
        Phase::Handling
    } else {
        Phase::Body
    });
    let request = request.map(|body| Arriving {
        body,
        standing: Arc::clone(&standing),
    });
    let mut response = router.call(request).await?;
    let stream = response.extensions_mut().remove::<StreamPlace>();
    if stream.is_some() {
        standing.enter(Phase::Streaming);
        standing.give_back();
        // The connection has no place of the common kind any more, so no further request may come on it.
        let close = HeaderValue::from_static("close");
        let _none = response.headers_mut().insert(header::CONNECTION, close);
    } else {
        standing.enter(Phase::Answering);
    }
    Ok(response.map(|body| Leaving {
        body,
        standing,
        _stream: stream,
    }))
}

/// A request's body, whose end is noted.
#[derive(Debug)]
struct Arriving {
    body: Incoming,
    standing: Arc<Standing>,
}

impl Body for Arriving {
    type Data = Bytes;
    type Error = hyper::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, hyper::Error>>> {
        let polled = Pin::new(&mut self.body).poll_frame(context);
        if matches!(polled, Poll::Ready(None)) || self.body.is_end_stream() {
            self.standing.pass(Phase::Body, Phase::Handling);
        }
        polled
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

/// An answer's body. It is dropped once all of it was handed over.
#[derive(Debug)]
pub(crate) struct Leaving {
    body: AnswerBody,
    standing: Arc<Standing>,
    _stream: Option<StreamPlace>,
}

impl Body for Leaving {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

impl Drop for Leaving {
    fn drop(&mut self) {
        self.standing.enter(Phase::Sent);
    }
}
