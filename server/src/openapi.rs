//! The OpenAPI document, made from the routes.

use axum::http::Method;
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{InfoBuilder, LicenseBuilder, OpenApi, tag::TagBuilder};

use crate::identity::{self, Access};
use crate::router;

/// What the document calls the way in.
const BEARER: &str = "bearer";

const DESCRIPTION: &str = "\
Drives robot arms through the socket server of their controllers.

Lengths are millimeters, angles degrees; the unit is in the key. W, P and R are rotations about the fixed X, Y and Z \
axes: R = Rz(r) Ry(p) Rx(w). Whoever moves a robot holds control of its cell and sends its \
`Control-Token`. Errors are problems of RFC 9457 with a stable `code`, and with an `outcome` that says \
what is known of the command: `NOT_SENT`, `REJECTED`, or `UNKNOWN` where the robot may have moved. A command is sent \
at most once.

This is not a safety function: emergency stop and guards are hard-wired in the controller.";

const TAGS: [(&str, &str); 18] = [
    ("motions", "Moving a robot, and what became of it."),
    (
        "jobs",
        "The group workflows: arms and mobile robots together. A job is asked for, waits in the queue, and runs by itself.",
    ),
    (
        "mobile-robots",
        "What mobile robots tell the cell, and what it tells them.",
    ),
    ("events", "What happens, live and from the journal."),
    ("interventions", "What only a person can decide."),
    (
        "hand-over",
        "Sessions at the points where arms and mobile robots meet: states, permits, timers.",
    ),
    (
        "loads",
        "Where each load is, how that is known, and what to do where it is not.",
    ),
    ("robots", "What a robot is, and what is known of it now."),
    (
        "kinematics",
        "Between poses and joint values; nothing is sent.",
    ),
    (
        "arms",
        "Questions about arm models, of any number of joints: kinematics, reach, trajectories, ways among obstacles. No \
         robot of a cell is concerned.",
    ),
    ("paths", "Paths of a disc-shaped robot among polygons."),
    ("cells", "The cells and their robots."),
    (
        "setup",
        "The operator's set-up of a cell: whole, part by part, checked, taught. Changes name the entity tag they are based on.",
    ),
    (
        "fanuc",
        "The source thesis's own routes and answers, for its clients: one robot, the configuration's `legacy_robot`.",
    ),
    (
        "control",
        "Who may move the robots of a cell now: one party at a time, kept by heartbeats.",
    ),
    ("identity", "Who is asking, and the tokens."),
    ("problems", "The kinds of problems, by their stable codes."),
    ("health", "For whoever watches the server."),
];

/// The OpenAPI 3.1 document of the server.
#[must_use]
pub fn openapi() -> OpenApi {
    complete(router::documented().1)
}

/// The document as YAML, as `openapi.yaml` holds it.
///
/// # Errors
/// The document could not be written; only a defect of the server can cause this.
pub fn openapi_yaml() -> Result<String, OpenApiError> {
    openapi().to_yaml().map_err(|error| OpenApiError {
        message: error.to_string(),
    })
}

/// The document could not be written as YAML.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[error("writing the OpenAPI document: {message}")]
pub struct OpenApiError {
    message: String,
}

/// Adds what belongs to no single route.
pub(crate) fn complete(mut document: OpenApi) -> OpenApi {
    document.info = InfoBuilder::new()
        .title("robocell")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some(DESCRIPTION))
        .license(Some(
            LicenseBuilder::new()
                .name(env!("CARGO_PKG_LICENSE"))
                .identifier(Some(env!("CARGO_PKG_LICENSE")))
                .build(),
        ))
        .build();
    let tag = |(name, text)| TagBuilder::new().name(name).description(Some(text)).build();
    document.tags = Some(TAGS.map(tag).into());
    secure(&mut document);
    document
}

/// Says of each operation which role it needs, from the table that decides it.
fn secure(document: &mut OpenApi) {
    let scheme = HttpBuilder::new()
        .scheme(HttpAuthScheme::Bearer)
        .bearer_format("cell_<id>_<secret>")
        .description(Some(
            "A token of this server: `cellctl tokens create`. In demo mode none is needed.",
        ))
        .build();
    document
        .components
        .get_or_insert_default()
        .add_security_scheme(BEARER, SecurityScheme::Http(scheme));
    for (path, item) in &mut document.paths.paths {
        let methods: Vec<_> = identity::methods(item).collect();
        for method in methods {
            let Some(operation) = operation(item, &method) else {
                continue;
            };
            let access = identity::least_role(method.as_str(), path);
            let Some(access) = access.filter(|access| *access != Access::Open) else {
                operation.security = Some(Vec::new());
                continue;
            };
            let none: [&str; 0] = [];
            operation.security = Some(vec![SecurityRequirement::new(BEARER, none)]);
            let role = format!("Needs: {access}.");
            operation.description = Some(match operation.description.take() {
                Some(text) => format!("{text}\n\n{role}"),
                None => role,
            });
        }
    }
}

fn operation<'a>(item: &'a mut PathItem, method: &Method) -> Option<&'a mut Operation> {
    let operation = match *method {
        Method::GET => &mut item.get,
        Method::PUT => &mut item.put,
        Method::POST => &mut item.post,
        Method::DELETE => &mut item.delete,
        Method::PATCH => &mut item.patch,
        _ => return None,
    };
    operation.as_mut()
}
