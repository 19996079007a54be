//! The control interface: what a person or a test does at the controller, over HTTP with an OpenAPI document.
//!
//! Its visitors have no names, so it is reached on loopback only, and changes nothing unless the configuration says so.
//! What a page of another origin sends does not get past the panel's door.

mod alarms;
mod data;
mod faults;
mod frames;
mod operator;
mod parts;
mod profile;
mod programs;
mod time;
mod watch;

use axum::Router;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Request, State as Shared};
use axum::http::{Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::Response;
use axum::routing::get;
use local_view::problem;
use utoipa::openapi::{InfoBuilder, LicenseBuilder, OpenApi, tag::TagBuilder};
use utoipa_axum::router::OpenApiRouter;

use super::Visitors;
use crate::config::ControlAccess;

pub use alarms::{AlarmBody, AlarmList};
pub use data::{
    IoList, PathQuery, RegisterList, SetIo, SetSimulation, SetVariable, ValueOnly, VariableList,
};
pub use faults::{Cleared, FaultId, FaultList};
pub use frames::{FrameView, Frames, SelectedFrame};
pub use operator::{KeyboardBody, OperatorPatch, OperatorView, PowerBody};
pub use parts::ProblemBody;
pub use profile::{NoteList, ProfilePatch};
pub use programs::{CallView, ProgramList, TaskDetail, TaskList};
pub use time::{StepBody, TimePatch};
pub use watch::{LedgerList, Screen, SetTrace, TraceList};

/// Longest body of a request.
const BODY_BYTES: usize = 64 * 1024;

const DESCRIPTION: &str = "\
What an operator, a test or a broken part does at a virtual FANUC controller: programs and tasks, variables, registers, \
I/O, frames, alarms, the operator's keys and switches, time, and injected faults; and the ledger, the truth about what the \
arm did.

Lengths are millimeters, angles degrees, times seconds or milliseconds of controller time; the unit is in the key. \
Errors are problems of RFC 9457 whose detail names the item, its value and its limit; nothing has changed then.

It is reached on loopback only and asks for no token: whoever runs programs on this machine may do this. It controls a \
simulation and is no safety function.";

const TAGS: [(&str, &str); 8] = [
    (
        "state",
        "The controller at one look, the ledger, the trace.",
    ),
    ("programs", "Programs and their tasks."),
    (
        "variables",
        "Variables of programs and of the system, registers.",
    ),
    (
        "io",
        "Ports: the world's side, the program's side, simulation.",
    ),
    ("frames", "User frames and tool frames."),
    ("operator", "Keys, switches, alarms, power."),
    ("time", "Controller time: pause, step, scale."),
    ("faults", "What is broken on purpose."),
];

fn documented() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .merge(watch::routes())
        .merge(profile::routes())
        .merge(programs::routes())
        .merge(data::routes())
        .merge(frames::routes())
        .merge(operator::routes())
        .merge(alarms::routes())
        .merge(time::routes())
        .merge(faults::routes())
}

/// The routes of the control interface.
pub(super) fn router(visitors: Visitors) -> Router {
    let (routes, document) = documented().split_for_parts();
    // It cannot fail: the document is text, numbers and lists. It is written once, a copy for each answer is cheap.
    let document = complete(document).to_json().unwrap_or_default();
    let document = Bytes::from(document);
    let json = [(header::CONTENT_TYPE, "application/json")];
    routes
        .route(
            "/api/v1/openapi.json",
            get(async move || (json, document.clone())),
        )
        .layer(DefaultBodyLimit::max(BODY_BYTES))
        .route_layer(middleware::from_fn_with_state(visitors.clone(), guard))
        .with_state(visitors)
}

/// The OpenAPI document of the control interface, as YAML.
///
/// # Errors
/// The document could not be written; only a defect of this crate can cause this.
pub fn openapi_yaml() -> Result<String, std::io::Error> {
    let document = complete(documented().split_for_parts().1);
    document.to_yaml().map_err(std::io::Error::other)
}

fn complete(mut document: OpenApi) -> OpenApi {
    document.info = InfoBuilder::new()
        .title("karel-emulator control interface")
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

/// Changes are for whom the configuration lets.
async fn guard(Shared(visitors): Shared<Visitors>, request: Request, next: Next) -> Response {
    let looks = matches!(*request.method(), Method::GET | Method::HEAD);
    match visitors.access {
        ControlAccess::Control => next.run(request).await,
        ControlAccess::LookOnly if looks => next.run(request).await,
        ControlAccess::LookOnly => {
            let text = "this panel can look and not touch: the configuration does not open the control interface";
            problem(StatusCode::FORBIDDEN, text)
        }
    }
}
