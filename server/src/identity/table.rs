//! The one table that says who may call what. A route that is not in it is refused to everybody.

use std::collections::HashMap;
use std::sync::LazyLock;

use axum::http::Method;
use utoipa::openapi::OpenApi;
use utoipa::openapi::path::{HttpMethod, PathItem};

use super::access::Access;
use crate::router;

const GET: &str = "GET";
const POST: &str = "POST";
const PUT: &str = "PUT";
const DELETE: &str = "DELETE";

/// Method, route, least role. Names in braces stand for any name, and `**` at the end for whatever follows; the first
/// line that fits counts.
#[rustfmt::skip]
const TABLE: &[(&str, &str, Access)] = &[
    // For whoever watches the process, and for whoever reads how to use it.
    (GET, "/livez", Access::Open),
    (GET, "/readyz", Access::Open),
    (GET, "/version", Access::Open),
    (GET, "/api/v1/problems", Access::Open),
    (GET, "/api/v1/problems/{code}", Access::Open),
    (GET, "/problems", Access::Open),
    (GET, "/problems/{code}", Access::Open),
    (GET, "/metrics", Access::Viewer),
    // Who is who.
    (GET, "/api/v1/me", Access::Anyone),
    (GET, "/api/v1/tokens", Access::Admin),
    (POST, "/api/v1/tokens", Access::Admin),
    (DELETE, "/api/v1/tokens/{id}", Access::Admin),
    (POST, "/api/v1/tokens/{id}/rotate", Access::Admin),
    // The cell.
    (GET, "/api/v1/cells", Access::Viewer),
    (GET, "/api/v1/cells/{cell}", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/control-authority", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/control-authority", Access::Control),
    (PUT, "/api/v1/cells/{cell}/control-authority/{lease}", Access::Control),
    (DELETE, "/api/v1/cells/{cell}/control-authority/{lease}", Access::Control),
    (POST, "/api/v1/cells/{cell}/control-authority/{lease}/transfer", Access::Control),
    (GET, "/api/v1/cells/{cell}/audit", Access::Auditor),
    // Its robots.
    (GET, "/api/v1/cells/{cell}/robots", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/robots/{robot}", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/robots/{robot}/description", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/robots/{robot}/state", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/kinematics/forward", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/kinematics/inverse", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/stop", Access::Anyone),
    (GET, "/api/v1/cells/{cell}/robots/{robot}/motions", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/motions", Access::Operator),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/motions/preview", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/robots/{robot}/motions/{id}", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/motions/{id}/cancel", Access::Operator),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/motions/{id}/pause", Access::Operator),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/motions/{id}/resume", Access::Operator),
    (GET, "/api/v1/cells/{cell}/robots/{robot}/speed-override", Access::Viewer),
    (PUT, "/api/v1/cells/{cell}/robots/{robot}/speed-override", Access::Operator),
    (GET, "/api/v1/cells/{cell}/events", Access::Viewer),
    // Questions about arm models and floors: nothing of a cell is shown or changed.
    (GET, "/api/v1/arms", Access::Viewer),
    (GET, "/api/v1/arms/{model}", Access::Viewer),
    (POST, "/api/v1/arms/{model}/forward", Access::Viewer),
    (POST, "/api/v1/arms/{model}/inverse", Access::Viewer),
    (POST, "/api/v1/arms/{model}/jacobian", Access::Viewer),
    (POST, "/api/v1/arms/{model}/rates", Access::Viewer),
    (
        POST,
        "/api/v1/arms/{model}/inverse-dynamics",
        Access::Viewer,
    ),
    (POST, "/api/v1/arms/{model}/calibrate-tool", Access::Viewer),
    (POST, "/api/v1/arms/{model}/velocity-motion", Access::Viewer),
    (POST, "/api/v1/arms/{model}/reachability", Access::Viewer),
    (POST, "/api/v1/arms/{model}/trajectories", Access::Viewer),
    (POST, "/api/v1/arms/{model}/tool-paths", Access::Viewer),
    (POST, "/api/v1/arms/{model}/transfers", Access::Viewer),
    (POST, "/api/v1/routes/plan", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/routes/plan", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/reachability", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/robots/{robot}/kinematics/jacobian", Access::Viewer),
    // Its mobile robots.
    (GET, "/api/v1/cells/{cell}/mobile-robots", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/state", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/signals", Access::MobileRobot),
    (GET, "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/outbox", Access::MobileRobot),
    (POST, "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/instant-actions", Access::Operator),
    // Jobs, and what they work with.
    (GET, "/api/v1/cells/{cell}/state", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/jobs", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/jobs", Access::Operator),
    (POST, "/api/v1/cells/{cell}/jobs/simulate", Access::Operator),
    (GET, "/api/v1/cells/{cell}/jobs/{job}", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/jobs/{job}/commands", Access::Operator),
    (GET, "/api/v1/cells/{cell}/jobs/{job}/events", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/jobs/{job}/report", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/sessions", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/sessions/{session}", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/stations/{station}/points/{point}/sessions", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/loads", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/loads/{load}", Access::Viewer),
    (PUT, "/api/v1/cells/{cell}/loads/{load}/custody", Access::Operator),
    // What asks a person.
    (GET, "/api/v1/cells/{cell}/interventions", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/interventions/{id}", Access::Viewer),
    (POST, "/api/v1/cells/{cell}/interventions/{id}/respond", Access::Operator),
    // Its set-up.
    (GET, "/api/v1/cells/{cell}/setup", Access::Viewer),
    (PUT, "/api/v1/cells/{cell}/setup", Access::Integrator),
    (POST, "/api/v1/cells/{cell}/setup/check", Access::Viewer),
    (GET, "/api/v1/cells/{cell}/setup/**", Access::Viewer),
    (PUT, "/api/v1/cells/{cell}/setup/**", Access::Integrator),
    (POST, "/api/v1/cells/{cell}/setup/**", Access::Integrator),
    (DELETE, "/api/v1/cells/{cell}/setup/**", Access::Integrator),
    // The thesis's own routes.
    (POST, "/fanuc/move", Access::Operator),
    (POST, "/fanuc/home", Access::Operator),
    (POST, "/fanuc/delta", Access::Operator),
];

/// The pages beside the documented routes. They show how to use the API and hold nothing of the cell.
const PAGES: [&str; 5] = [
    "/",
    "/docs",
    "/docs/",
    "/docs/{*rest}",
    "/api/v1/openapi.json",
];

/// What the table says of one request.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Rule {
    /// The route exists and asks this.
    Needs { access: Access, place: Place },
    /// The route has no such method; the router says so.
    NoSuchMethod,
    /// The table does not know it: refused.
    Missing,
}

/// Where a path names a cell and a mobile robot: numbers of its segments.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub(crate) struct Place {
    pub(crate) cell: Option<usize>,
    pub(crate) mobile_robot: Option<usize>,
}

/// The table, arranged for looking up by the router's own templates.
#[derive(Debug)]
pub(crate) struct Rules(HashMap<String, Template>);

#[derive(Debug)]
struct Template {
    place: Place,
    methods: Vec<(Method, Option<Access>)>,
}

static RULES: LazyLock<Rules> = LazyLock::new(|| Rules::of(&router::documented().1));

/// What the table says of a method and a route's template.
pub(crate) fn rule(method: &Method, template: &str) -> Rule {
    RULES.find(method, template)
}

impl Rules {
    /// Joins the document's routes with the table.
    pub(crate) fn of(document: &OpenApi) -> Self {
        let documented = document.paths.paths.iter().map(|(path, item)| {
            let methods = methods(item)
                .map(|method| {
                    let access = access(method.as_str(), path);
                    (method, access)
                })
                .collect();
            (path.clone(), Template::new(path, methods))
        });
        let pages = PAGES.iter().map(|page| {
            let methods = vec![(Method::GET, Some(Access::Open))];
            ((*page).to_owned(), Template::new(page, methods))
        });
        Self(documented.chain(pages).collect())
    }

    /// Documented routes without an entry: nobody can call them.
    #[cfg(test)]
    pub(crate) fn missing(&self) -> Vec<String> {
        let routes = self.0.iter().flat_map(|(path, template)| {
            let missing = template
                .methods
                .iter()
                .filter(|(_, access)| access.is_none());
            missing.map(move |(method, _)| format!("{method} {path}"))
        });
        routes.collect()
    }

    fn find(&self, method: &Method, template: &str) -> Rule {
        let Some(template) = self.0.get(template) else {
            return Rule::Missing;
        };
        let method = if *method == Method::HEAD {
            &Method::GET
        } else {
            method
        };
        let known = template.methods.iter().find(|(known, _)| known == method);
        match known {
            Some((_, Some(access))) => Rule::Needs {
                access: *access,
                place: template.place,
            },
            Some((_, None)) => Rule::Missing,
            None => Rule::NoSuchMethod,
        }
    }
}

impl Template {
    fn new(path: &str, methods: Vec<(Method, Option<Access>)>) -> Self {
        let after = |collection: &str| {
            let mut segments = path.split('/').enumerate();
            let _found = segments.find(|(_, segment)| *segment == collection)?;
            segments
                .next()
                .filter(|(_, segment)| segment.starts_with('{'))
                .map(|(index, _)| index)
        };
        let place = Place {
            cell: after("cells"),
            mobile_robot: after("mobile-robots"),
        };
        Self { place, methods }
    }
}

/// The least role of a documented route, for the document.
pub(crate) fn access(method: &str, path: &str) -> Option<Access> {
    TABLE
        .iter()
        .find(|(known, template, _)| *known == method && covers(template, path))
        .map(|(_, _, access)| *access)
}

/// Whether a line of the table is about a route.
fn covers(line: &str, path: &str) -> bool {
    let Some(begin) = line.strip_suffix("/**") else {
        return is_same(line, path);
    };
    let segments = begin.split('/').count();
    let beginning: Vec<_> = path.split('/').take(segments).collect();
    path.split('/').count() > segments && is_same(begin, &beginning.join("/"))
}

/// Whether two templates are one, whatever their parameters are called.
fn is_same(one: &str, other: &str) -> bool {
    let name = |segment: &str| segment.starts_with('{');
    let mut pairs = one.split('/').zip(other.split('/'));
    one.split('/').count() == other.split('/').count()
        && pairs.all(|(one, other)| one == other || (name(one) && name(other)))
}

/// The methods of a documented path.
pub(crate) fn methods(item: &PathItem) -> impl Iterator<Item = Method> {
    let all = [
        (HttpMethod::Get, &item.get),
        (HttpMethod::Put, &item.put),
        (HttpMethod::Post, &item.post),
        (HttpMethod::Delete, &item.delete),
        (HttpMethod::Options, &item.options),
        (HttpMethod::Head, &item.head),
        (HttpMethod::Patch, &item.patch),
        (HttpMethod::Trace, &item.trace),
    ];
    all.into_iter()
        .filter(|(_, operation)| operation.is_some())
        .map(|(method, _)| match method {
            HttpMethod::Get => Method::GET,
            HttpMethod::Put => Method::PUT,
            HttpMethod::Post => Method::POST,
            HttpMethod::Delete => Method::DELETE,
            HttpMethod::Options => Method::OPTIONS,
            HttpMethod::Head => Method::HEAD,
            HttpMethod::Patch => Method::PATCH,
            HttpMethod::Trace => Method::TRACE,
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_route_has_an_entry() {
        let missing = RULES.missing();
        assert!(missing.is_empty(), "add these to TABLE: {missing:#?}");
    }

    #[test]
    fn the_table_has_each_route_once() {
        for (index, (method, path, _)) in TABLE.iter().enumerate() {
            let later = TABLE.iter().skip(index + 1);
            let twice = later.filter(|(m, p, _)| m == method && is_same(p, path));
            assert_eq!(twice.count(), 0, "{method} {path}");
        }
    }

    #[test]
    fn a_family_of_routes_covers_what_is_below_it_and_no_more() {
        let least = |method, path| access(method, path);
        let below = "/api/v1/cells/{cell}/setup/tools/{arm}/{number}";
        assert_eq!(least(PUT, below), Some(Access::Integrator));
        assert_eq!(least(GET, below), Some(Access::Viewer));
        let check = "/api/v1/cells/{c}/setup/check";
        assert_eq!(least(POST, check), Some(Access::Viewer));
        assert_eq!(least(POST, "/api/v1/cells/{cell}/setups"), None);
        assert_eq!(least(DELETE, "/api/v1/cells/{cell}/setup"), None);
        assert_eq!(least("PATCH", below), None);
    }

    #[test]
    fn what_the_table_does_not_know_is_refused() {
        assert_eq!(RULES.find(&Method::GET, "/debug"), Rule::Missing);
        assert_eq!(RULES.find(&Method::PATCH, "/livez"), Rule::NoSuchMethod);
        let mut document = router::documented().1;
        let item = document.paths.paths.get("/livez").cloned().unwrap();
        let _old = document.paths.paths.insert("/new".to_owned(), item);
        let rules = Rules::of(&document);
        assert_eq!(rules.find(&Method::GET, "/new"), Rule::Missing);
        assert_eq!(rules.missing(), ["GET /new"]);
    }

    #[test]
    fn a_path_says_which_cell_and_which_mobile_robot() {
        let template = Template::new(
            "/api/v1/cells/{cell}/mobile-robots/{mr}/signals",
            Vec::new(),
        );
        assert_eq!(
            (template.place.cell, template.place.mobile_robot),
            (Some(4), Some(6))
        );
        assert_eq!(
            Template::new("/api/v1/cells", Vec::new()).place,
            Place::default()
        );
    }
}
