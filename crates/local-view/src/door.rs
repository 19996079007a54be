//! Who may come in: people and programs at this machine, not the pages of other origins that they look at.

use axum::Router;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::Response;

use crate::problem;

/// A page runs its own script and asks its own origin, nothing else.
const CONTENT_POLICY: &str = "default-src 'none'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Headers of every answer.
const HEADERS: [(HeaderName, &str); 3] = [
    (header::CONTENT_SECURITY_POLICY, CONTENT_POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::CACHE_CONTROL, "no-store"),
];

/// What stands around the routes of a view.
#[derive(Clone, Copy, Debug)]
pub struct Door {
    thing: &'static str,
    exposed: bool,
}

impl Door {
    /// The door of a view on loopback; `thing` is what its problems call it, as in "the panel answers to …".
    #[must_use]
    pub const fn local(thing: &'static str) -> Self {
        Self {
            thing,
            exposed: false,
        }
    }

    /// The same, where the configuration shows the view to other machines: it answers to any name.
    #[must_use]
    pub const fn exposed(self, exposed: bool) -> Self {
        Self { exposed, ..self }
    }

    /// `routes` behind this door, with problems for paths and methods that there are not.
    ///
    /// A request that names another host, or changes something for a page of another origin, is answered with 403.
    pub fn around(self, routes: Router) -> Router {
        routes
            .fallback(async move |request: Request| self.not_found(&request))
            .method_not_allowed_fallback(not_allowed)
            .layer(middleware::from_fn_with_state(self, guard))
    }

    fn not_found(self, request: &Request) -> Response {
        let text = format!(
            "there is no {} on this {}",
            request.uri().path(),
            self.thing
        );
        problem(StatusCode::NOT_FOUND, &text)
    }

    /// Why these headers are refused.
    fn refusal(self, method: &Method, headers: &HeaderMap) -> Option<String> {
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
        let host = text(header::HOST);
        // A name that somebody else points to this machine makes a page of theirs one of "the same" origin.
        if !self.exposed && !host.is_some_and(is_local_name) {
            return Some(format!("the {} answers to loopback names only", self.thing));
        }
        let changes = !matches!(*method, Method::GET | Method::HEAD);
        (changes && is_foreign(headers, host))
            .then(|| "the request comes from a page of another origin".to_owned())
    }
}

async fn guard(State(door): State<Door>, request: Request, next: Next) -> Response {
    let mut response = match door.refusal(request.method(), request.headers()) {
        None => next.run(request).await,
        Some(reason) => problem(StatusCode::FORBIDDEN, &reason),
    };
    for (name, value) in HEADERS {
        let _previous = response
            .headers_mut()
            .insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn not_allowed(request: Request) -> Response {
    let text = format!(
        "{} cannot be sent to {}",
        request.method(),
        request.uri().path()
    );
    problem(StatusCode::METHOD_NOT_ALLOWED, &text)
}

/// Whether a browser says that the page of another origin, another port of this machine included, sent these headers.
fn is_foreign(headers: &HeaderMap, host: Option<&str>) -> bool {
    let elsewhere = headers.get(header::ORIGIN).is_some_and(|origin| {
        let origin = origin.to_str().ok();
        let own = origin.and_then(|origin| origin.strip_prefix("http://"));
        own.is_none() || own != host
    });
    let cross_site = headers
        .get("sec-fetch-site")
        .is_some_and(|site| site == "cross-site");
    elsewhere || cross_site
}

/// Whether a `Host`, with or without a port, names this machine's loopback.
#[must_use]
pub fn is_local_name(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    };
    name.eq_ignore_ascii_case("localhost")
        || name
            .parse::<std::net::IpAddr>()
            .is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use axum::body::Body;
    use axum::routing::{get, post};
    use tower::ServiceExt as _;

    use super::*;

    #[test]
    fn only_loopback_names_are_local() {
        for name in [
            "localhost",
            "LOCALHOST:8081",
            "127.0.0.1",
            "127.0.0.1:8081",
            "[::1]:8081",
        ] {
            assert!(is_local_name(name), "{name}");
        }
        for name in [
            "evil.example",
            "127.0.0.1.evil.example:80",
            "10.0.0.1",
            "",
            "[fe80::1]",
        ] {
            assert!(!is_local_name(name), "{name}");
        }
    }

    async fn answer(door: Door, method: Method, path: &str, headers: &[(&str, &str)]) -> Response {
        let routes = Router::new()
            .route("/look", get(|| async { "seen" }))
            .route("/change", post(|| async { "changed" }));
        let mut request = Request::builder().method(method).uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let request = request.body(Body::empty()).unwrap();
        door.around(routes).oneshot(request).await.unwrap()
    }

    #[tokio::test]
    async fn pages_of_other_origins_change_nothing() {
        let door = Door::local("panel");
        let host = ("host", "127.0.0.1:8081");
        for (headers, status) in [
            (&[host][..], 200),
            (&[host, ("origin", "http://127.0.0.1:8081")], 200),
            (&[host, ("origin", "http://127.0.0.1:3000")], 403),
            (&[host, ("origin", "http://evil.example")], 403),
            (&[host, ("origin", "null")], 403),
            (&[host, ("sec-fetch-site", "cross-site")], 403),
            (&[("host", "evil.example")], 403),
            (&[], 403),
        ] {
            let reply = answer(door, Method::POST, "/change", headers).await;
            assert_eq!(reply.status().as_u16(), status, "{headers:?}");
        }
        let named = [("host", "robot.example:8083")];
        let refused = answer(door, Method::GET, "/look", &named).await;
        assert_eq!(refused.status(), StatusCode::FORBIDDEN);
        let seen = answer(door.exposed(true), Method::GET, "/look", &named).await;
        assert_eq!(seen.status(), StatusCode::OK);
    }

    #[tokio::test]
    async fn every_answer_forbids_framing_and_says_what_is_wrong() {
        let host = [("host", "localhost")];
        for (method, path, status) in [
            (Method::GET, "/look", 200),
            (Method::GET, "/nothing", 404),
            (Method::GET, "/change", 405),
        ] {
            let reply = answer(Door::local("panel"), method, path, &host).await;
            assert_eq!(reply.status().as_u16(), status, "{path}");
            for (name, value) in HEADERS {
                assert_eq!(reply.headers().get(name).unwrap(), value, "{path}");
            }
        }
    }
}
