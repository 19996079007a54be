//! The outermost layer: request id, span, time limit, panics, problems, counts. One layer instead of six, because
//! every one costs each request an allocation and a call through a pointer.

use std::panic::AssertUnwindSafe;
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

use api::{Outcome, ProblemCode};
use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse as _, Response};
use tokio::time::{Instant, timeout};
use tracing::{Instrument as _, field};

use crate::connections::StreamPlace;
use crate::guard;
use crate::identity::{Asked, Principal};
use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::request_id::{self, RequestId};
use crate::serve::Peer;
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
    // At the default level it does not exist: making it costs a tenth of a request's instructions, and every line
    // logged at that level names its request itself.
    let span = tracing::debug_span!("request", request_id = &*request_id, %method, path = uri.path(), principal = field::Empty);

    let limit = app.server.request_timeout;
    let for_another = guard::is_for_another_site(request.headers());
    let admitted = guard::check(&method, request.headers(), &app.server.allowed_hosts)
        .and_then(|()| admit(&app, &mut request, route.as_ref(), &request_id));
    let who = admitted.as_ref().ok().cloned();
    let mut response = match admitted {
        Ok(principal) => {
            let _same = span.record("principal", principal.name());
            let handled = catch_panic(next.run(request), &request_id).instrument(span.clone());
            match timeout(limit, handled).await {
                Ok(Some(response)) => response,
                Ok(None) => internal(&method).into_response(),
                Err(_) => too_long(&method, limit).into_response(),
            }
        }
        Err(problem) => problem.into_response(),
    };
    if let Some(problem) = response.extensions_mut().remove::<Problem>() {
        response = problem.into_answer(uri.path(), &request_id);
    } else if response.status() == StatusCode::METHOD_NOT_ALLOWED {
        response = method_not_allowed(&method, &response, uri.path(), &request_id);
    }
    if is_event_stream(&response) && for_another {
        // Its page could not read it, but would hold a place that others need.
        response = guard::cross_site(Outcome::None).into_answer(uri.path(), &request_id);
    } else if is_event_stream(&response) {
        response = place_stream(&app, response, uri.path(), &request_id);
    }
    add_headers(response.headers_mut(), &request_id);
    let took = started.elapsed();
    let status = response.status();
    app.metrics.request(
        route.as_ref().map(MatchedPath::as_str),
        &method,
        status,
        took,
    );
    match who.filter(|who| who.token().is_some() && !method.is_safe()) {
        Some(who) => tracing::info!(
            request_id = &*request_id,
            principal = who.name(),
            %method,
            path = uri.path(),
            status = status.as_u16(),
            "answered"
        ),
        None => span.in_scope(|| tracing::debug!(status = status.as_u16(), ?took, "answered")),
    }
    response
}

/// Finds out who is asking and whether they may. The token goes no further than this.
fn admit(
    app: &App,
    request: &mut Request,
    route: Option<&MatchedPath>,
    request_id: &str,
) -> Result<Principal, Problem> {
    let asked = Asked {
        method: request.method(),
        route: route.map(MatchedPath::as_str),
        path: request.uri().path(),
        headers: request.headers(),
        peer: request.extensions().get::<Peer>().map(|peer| peer.0),
        request_id,
    };
    let principal = match app.identity.admit(&asked, &*app.clock) {
        Ok(principal) => principal,
        Err(not) => {
            if let Some(who) = &not.worth_noting {
                app.refusals
                    .note(&*app.audit, who, &asked, not.problem.code());
            }
            return Err(not.problem);
        }
    };
    let _token = request.headers_mut().remove(header::AUTHORIZATION);
    let _none = request.extensions_mut().insert(principal.clone());
    Ok(principal)
}

fn is_event_stream(response: &Response) -> bool {
    let content_type = response.headers().get(header::CONTENT_TYPE);
    content_type.is_some_and(|value| value.as_bytes().starts_with(b"text/event-stream"))
}

/// A stream of events lasts: it has a place of its own kind, or it is not begun.
fn place_stream(app: &App, mut stream: Response, path: &str, request_id: &str) -> Response {
    let Ok(permit) = Arc::clone(&app.streams).try_acquire_owned() else {
        let detail = format!(
            "{} streams of events are open, and no more may be",
            app.server.max_event_streams
        );
        return Problem::new(ProblemCode::ServerBusy, detail)
            .retry_after_a_second()
            .into_answer(path, request_id);
    };
    let place = StreamPlace::from(permit);
    let _none = stream.extensions_mut().insert(place);
    stream
}

/// Adds what every answer has: its id, and that no other page may frame it or take it for something else.
fn add_headers(headers: &mut HeaderMap, request_id: &str) {
    let id = HeaderValue::from_str(request_id).unwrap_or(HeaderValue::from_static(""));
    for (name, value) in [
        (request_id::HEADER, id),
        (
            header::X_CONTENT_TYPE_OPTIONS,
            HeaderValue::from_static("nosniff"),
        ),
    ] {
        let _none = headers.insert(name, value);
    }
    // A page may be stricter than that.
    let _policy = headers
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static("frame-ancestors 'none'"));
}

/// `None` where the handler panicked: a defect of the server, which costs this request and no other.
async fn catch_panic(
    handled: impl Future<Output = Response>,
    request_id: &str,
) -> Option<Response> {
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
                tracing::error!(request_id, message, "a handler panicked");
                Poll::Ready(None)
            }
        }
    })
    .await
}

fn too_long(method: &Method, limit: Duration) -> Problem {
    let detail = format!(
        "the request was not answered within {} ms",
        limit.as_millis()
    );
    Problem::new(ProblemCode::RequestTimeout, detail).outcome(outcome_after(method))
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

/// axum's own answer is empty; its `Allow` header is kept, or added by the router outside of this layer.
fn method_not_allowed(method: &Method, bare: &Response, path: &str, request_id: &str) -> Response {
    let detail = format!("{method} is not allowed here; the Allow header says what is");
    let problem = Problem::new(ProblemCode::MethodNotAllowed, detail)
        .outcome(outcome_of_nothing_sent(method));
    let mut response = problem.into_answer(path, request_id);
    if let Some(allow) = bare.headers().get(header::ALLOW) {
        let _none = response.headers_mut().insert(header::ALLOW, allow.clone());
    }
    response
}

#[cfg(test)]
mod tests {
    use axum::body::{Body, to_bytes};
    use axum::routing::{get, post};
    use axum::{Router, middleware};
    use tokio_util::sync::CancellationToken;
    use tokio_util::task::TaskTracker;
    use tower::ServiceExt as _;

    use super::*;
    use crate::config::{CellSection, Plan, RobotSection, ServerSection};
    use crate::{Seams, SharedJournal, SystemClock, TcpConnector};

    async fn app() -> Arc<App> {
        app_with(&demo()).await
    }

    fn demo() -> ServerSection {
        ServerSection {
            demo: true,
            ..ServerSection::default()
        }
    }

    async fn app_with(server: &ServerSection) -> Arc<App> {
        let cell = CellSection {
            id: "c1".to_owned(),
            name: None,
            setup: None,
            push_urls: std::collections::BTreeMap::new(),
            robots: vec![RobotSection::new("r1", "fanuc-m20ia", "127.0.0.1:1")],
        };
        let plan = Plan::try_new(server, &[cell]).unwrap();
        let seams = Seams {
            connector: TcpConnector::default(),
            clock: Arc::new(SystemClock),
            journal: SharedJournal::volatile(),
        };
        let (tracker, stop) = (TaskTracker::new(), CancellationToken::new());
        let routes = std::iter::empty();
        Arc::new(
            App::start(plan, seams, routes, &tracker, &stop)
                .await
                .unwrap(),
        )
    }

    async fn problem_of(router: Router<Arc<App>>) -> (StatusCode, api::Problem) {
        let app = app().await;
        let router = router
            .layer(middleware::from_fn_with_state(Arc::clone(&app), edge))
            .with_state(app);
        let request = Request::post("/fanuc/home").body(Body::empty()).unwrap();
        let response = router.oneshot(request).await.unwrap();
        let status = response.status();
        let body = to_bytes(response.into_body(), 10_000).await.unwrap();
        (status, serde_json::from_slice(&body).unwrap())
    }

    /// Covers: R9.
    #[tokio::test]
    async fn a_panic_in_a_handler_is_a_problem_and_leaves_open_what_was_done() {
        let router = Router::new().route("/fanuc/home", post(async || -> () { panic!("secret") }));
        let (status, problem) = problem_of(router).await;
        assert_eq!(status, StatusCode::INTERNAL_SERVER_ERROR);
        assert_eq!(problem.code, ProblemCode::Internal);
        assert_eq!(problem.outcome, Outcome::Unknown);
        assert!(!problem.detail.contains("secret"));
    }

    #[tokio::test(start_paused = true)]
    async fn a_handler_that_is_stuck_is_cut_off() {
        let router = Router::new().route(
            "/fanuc/home",
            post(async || std::future::pending::<()>().await),
        );
        let (status, problem) = problem_of(router).await;
        assert_eq!(status, StatusCode::REQUEST_TIMEOUT);
        assert_eq!(problem.outcome, Outcome::Unknown);
        assert!(problem.detail.contains("75000 ms"), "{}", problem.detail);
    }

    #[tokio::test]
    async fn streams_of_events_have_places_of_their_own() {
        let app = app_with(&ServerSection {
            max_event_streams: 1,
            ..demo()
        })
        .await;
        let events = async || ([(header::CONTENT_TYPE, "text/event-stream")], "");
        let router = Router::new()
            .route("/", get(events))
            .layer(middleware::from_fn_with_state(Arc::clone(&app), edge))
            .with_state(app);
        let asked = || {
            let request = Request::get("/").body(Body::empty()).unwrap();
            router.clone().oneshot(request)
        };
        let first = asked().await.unwrap();
        assert_eq!(first.status(), StatusCode::OK);
        let second = asked().await.unwrap();
        assert_eq!(second.status(), StatusCode::SERVICE_UNAVAILABLE);
        assert_eq!(second.headers()["retry-after"], "1");
        let body = to_bytes(second.into_body(), 10_000).await.unwrap();
        let problem: api::Problem = serde_json::from_slice(&body).unwrap();
        assert_eq!(problem.code, ProblemCode::ServerBusy);
        drop(first);
        assert_eq!(asked().await.unwrap().status(), StatusCode::OK);
    }
}
