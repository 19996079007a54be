//! The OpenAPI document, made from the routes.

use utoipa::openapi::{InfoBuilder, LicenseBuilder, OpenApi, tag::TagBuilder};

use crate::router;

const DESCRIPTION: &str = "\
Drives robot arms through the socket server of their controllers.

Lengths are millimeters, angles degrees; the unit is in the key. W, P and R are rotations about the fixed X, Y and Z \
axes: R = Rz(r) Ry(p) Rx(w). Errors are problems of RFC 9457 with a stable `code`, and with an `outcome` that says \
what is known of the command: `NOT_SENT`, `REJECTED`, or `UNKNOWN` where the robot may have moved. A command is sent \
at most once.

This is not a safety function: emergency stop and guards are hard-wired in the controller.";

const TAGS: [(&str, &str); 8] = [
    ("motions", "Moving a robot, and what became of it."),
    ("interventions", "What only a person can decide."),
    ("robots", "What a robot is, and what is known of it now."),
    (
        "kinematics",
        "Between poses and joint values; nothing is sent.",
    ),
    ("cells", "The cells and their robots."),
    (
        "fanuc",
        "The source thesis's own routes and answers, for its clients: one robot, the configuration's `legacy_robot`.",
    ),
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
    document
}
