//! The outermost layer: request id, span, time limit, panics, problems, counts. One layer instead of six, because
//! every one costs each request an allocation and a call through a pointer.

use std::panic::AssertUnwindSafe;
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;

use api::{Outcome, ProblemCode};
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::Response;
use tokio::time::{Instant, timeout};
use tracing::Instrument as _;

use crate::problem::Problem;
use crate::request_id::{self, RequestId};
use crate::state::App;

pub(crate) async fn edge(
    State(app): State<Arc<App>>,
    mut request: Request,
    next: Next,
) -> Response {
    let started = Instant::now();
    let request_id = RequestId::of(request.headers(), || app.clock.now());
    let _none = request.extensions_mut().insert(request_id.clone());
    let method = request.method().clone();
    let uri = request.uri().clone();
    let route = request.extensions().get::<MatchedPath>().cloned();
    let span =
        tracing::info_span!("request", request_id = &*request_id, %method, path = uri.path());

    let handled = catch_panic(next.run(request)).instrument(span.clone());
    let mut response = match timeout(app.server.request_timeout, handled).await {
        Ok(Some(response)) => response,
        Ok(None) => problem_response(internal(&method)),
        Err(_) => problem_response(
            Problem::new(
                ProblemCode::RequestTimeout,
                format!(
                    "the request was not answered within {} ms",
                    app.server.request_timeout.as_millis()
                ),
            )
            .outcome(outcome_after(&method)),
        ),
    };
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        response = problem.into_answer(uri.path(), &request_id);
    } else if response.status() == StatusCode::METHOD_NOT_ALLOWED {
        response = method_not_allowed(&method, &response, uri.path(), &request_id);
    }
    if let Ok(value) = HeaderValue::from_str(&request_id) {
        let _none = response.headers_mut().insert(request_id::HEADER, value);
    }
    let took = started.elapsed();
    let status = response.status();
    app.metrics.request(
        route.as_ref().map(MatchedPath::as_str),
        &method,
        status,
        took,
    );
    span.in_scope(|| tracing::debug!(status = status.as_u16(), ?took, "answered"));
    response
}

/// `None` where the handler panicked: a defect of the server, which costs this request and no other.
async fn catch_panic(handled: impl Future<Output = Response>) -> Option<Response> {
    let mut handled = pin!(handled);
    std::future::poll_fn(|context| {
        let polled = std::panic::catch_unwind(AssertUnwindSafe(|| handled.as_mut().poll(context)));
        match polled {
            Ok(Poll::Pending) => Poll::Pending,
            Ok(Poll::Ready(response)) => Poll::Ready(Some(response)),
            Err(panic) => {
                let message = panic
                    .downcast_ref::<&str>()
                    .copied()
                    .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
                    .unwrap_or("no message");
                tracing::error!(message, "a handler panicked");
                Poll::Ready(None)
            }
        }
    })
    .await
}

fn problem_response(problem: Problem) -> Response {
    use axum::response::IntoResponse as _;
    problem.into_response()
}

fn internal(method: &Method) -> Problem {
    Problem::new(
        ProblemCode::Internal,
        "a defect of the server; its log says more under this request id",
    )
    .outcome(outcome_after(method))
}

/// What is known after a handler was cut off: anything that may have commanded a robot may have done so.
fn outcome_after(method: &Method) -> Outcome {
    if *method == Method::POST {
        Outcome::Unknown
    } else {
        Outcome::None
    }
}

fn method_not_allowed(method: &Method, bare: &Response, path: &str, request_id: &str) -> Response {
    let allow = bare.headers().get(header::ALLOW).cloned();
    let allowed = allow
        .as_ref()
        .and_then(|allow| allow.to_str().ok())
        .unwrap_or("none");
    let detail = format!("{method} is not allowed here; allowed: {allowed}");
    let mut response =
        Problem::new(ProblemCode::MethodNotAllowed, detail).into_answer(path, request_id);
    if let Some(allow) = allow {
        let _none = response.headers_mut().insert(header::ALLOW, allow);
    }
    response
}
