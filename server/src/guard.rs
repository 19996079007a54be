//! What keeps a web page from driving a robot through the browser of somebody who may.
//!
//! A page from elsewhere can make a browser send requests here, and can have its own name resolve to this machine.
//! So a request that changes something must not come from another site, and a host name in `Host` must be one the
//! configuration lists. Programs that are no browsers send neither header that this looks at.

use std::net::{Ipv4Addr, Ipv6Addr};

use api::{Outcome, ProblemCode};
use axum::http::{HeaderMap, Method, header};

use crate::problem::{Problem, outcome_of_nothing_sent};

/// Refuses what a page from elsewhere may have made a browser send.
pub(crate) fn check(
    method: &Method,
    headers: &HeaderMap,
    allowed_hosts: &[String],
) -> Result<(), Problem> {
    let host = headers.get(header::HOST);
    let host = match host.map(|value| value.to_str()) {
        None => None,
        Some(Ok(host)) if is_allowed(host, allowed_hosts) => Some(host),
        Some(_) => {
            return Err(Problem::new(
                ProblemCode::HostNotAllowed,
                "the Host header names neither an address, nor localhost, nor a host of `server.allowed_hosts`",
            )
            .outcome(outcome_of_nothing_sent(method)));
        }
    };
    let changes = !matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS);
    if changes && is_from_elsewhere(headers, host) {
        return Err(cross_site(Outcome::NotSent));
    }
    Ok(())
}

/// Whether a page from elsewhere made the browser send this, which for a stream of events is reason enough.
pub(crate) fn is_for_another_site(headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST);
    is_from_elsewhere(headers, host.and_then(|host| host.to_str().ok()))
}

/// The answer to what another site's page made the browser send.
pub(crate) fn cross_site(outcome: Outcome) -> Problem {
    Problem::new(
        ProblemCode::CrossSiteRequest,
        "a page of another site made the browser send this request",
    )
    .outcome(outcome)
}

fn is_allowed(host: &str, allowed: &[String]) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let bracketed = name
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'));
    bracketed.is_some_and(|address| address.parse::<Ipv6Addr>().is_ok())
        || name.parse::<Ipv4Addr>().is_ok()
        || name.eq_ignore_ascii_case("localhost")
        || allowed
            .iter()
            .any(|allowed| allowed.eq_ignore_ascii_case(name))
}

fn is_from_elsewhere(headers: &HeaderMap, host: Option<&str>) -> bool {
    if let Some(site) = headers.get("sec-fetch-site") {
        return site != "same-origin" && site != "none";
    }
    let Some(origin) = headers.get(header::ORIGIN) else {
        return false;
    };
    let authority = origin
        .to_str()
        .ok()
        .and_then(|origin| origin.split_once("://"))
        .map(|(_, authority)| authority);
    authority.is_none() || authority != host
}

#[cfg(test)]
mod tests {
    use axum::http::{HeaderName, HeaderValue};

    use super::*;

    fn checked(method: &Method, headers: &[(&str, &str)]) -> Option<ProblemCode> {
        let headers = headers
            .iter()
            .map(|(name, value)| {
                (
                    name.parse::<HeaderName>().unwrap(),
                    HeaderValue::from_str(value).unwrap(),
                )
            })
            .collect();
        let allowed = ["cell.plant.example".to_owned()];
        check(method, &headers, &allowed)
            .err()
            .map(|problem| problem.code())
    }

    #[test]
    fn addresses_localhost_and_listed_names_are_hosts() {
        for host in [
            "127.0.0.1:8080",
            "10.1.2.3",
            "[::1]:8080",
            "[::1]",
            "LocalHost:1",
            "cell.plant.example",
        ] {
            assert_eq!(checked(&Method::GET, &[("host", host)]), None, "{host}");
        }
        assert_eq!(checked(&Method::POST, &[]), None);
    }

    /// Covers: X6.
    #[test]
    fn a_name_that_was_made_to_resolve_to_this_machine_is_refused() {
        for host in [
            "evil.example",
            "evil.example:8080",
            "127.0.0.1.evil.example",
            "",
            "[::1",
            "cell",
        ] {
            let code = checked(&Method::GET, &[("host", host)]);
            assert_eq!(code, Some(ProblemCode::HostNotAllowed), "{host}");
        }
    }

    /// Covers: X5.
    #[test]
    fn a_command_from_another_sites_page_is_refused() {
        let host = ("host", "127.0.0.1:8080");
        for other in [
            ("sec-fetch-site", "cross-site"),
            ("sec-fetch-site", "same-site"),
            ("origin", "http://evil.example"),
            ("origin", "http://127.0.0.1:8081"),
            ("origin", "null"),
        ] {
            let code = checked(&Method::POST, &[host, other]);
            assert_eq!(code, Some(ProblemCode::CrossSiteRequest), "{other:?}");
            assert_eq!(checked(&Method::GET, &[host, other]), None);
        }
        for own in [
            ("sec-fetch-site", "same-origin"),
            ("sec-fetch-site", "none"),
            ("origin", "http://127.0.0.1:8080"),
        ] {
            assert_eq!(checked(&Method::POST, &[host, own]), None, "{own:?}");
        }
    }
}
