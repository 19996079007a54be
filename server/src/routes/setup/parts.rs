//! The parts of a set-up as resources of their own.

use std::sync::Arc;

use api::setup::SetupRevision;
use api::{ProblemCode, Violation};
use axum::Json;
use axum::extract::{FromRequestParts, Request, State};
use axum::http::HeaderMap;
use axum::http::request::Parts;
use axum::response::Response;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::body::{based_on, part, tagged};
use super::problems::ChangeProblem;
use crate::problem::Problem;
use crate::routes::params::{param, path_params};
use crate::routes::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::setup::{ChangeError, Edit, Part, Resource, SetupBook, find, parse_part, put, remove};
use crate::state::{App, shown};

/// What a path names: the cell, and what follows it by the names of the route.
pub(super) struct Named {
    pairs: Vec<(String, String)>,
}

impl FromRequestParts<Arc<App>> for Named {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        let _cell = param(&params, "cell")?;
        let pairs = params
            .iter()
            .map(|(key, value)| (key.to_owned(), value.to_owned()));
        Ok(Self {
            pairs: pairs.collect(),
        })
    }
}

impl Named {
    pub(super) fn get(&self, name: &str) -> String {
        let mut pairs = self.pairs.iter();
        let found = pairs.find(|(key, _)| key == name);
        found.map(|(_, value)| value.clone()).unwrap_or_default()
    }

    /// A number in a path. What is no number is the number of nothing.
    pub(super) fn number(&self, name: &str) -> u8 {
        self.get(name).parse().unwrap_or(0)
    }

    pub(super) fn book(&self, app: &App) -> Result<Arc<SetupBook>, Problem> {
        Ok(Arc::clone(&app.cell(&self.get("cell"))?.setup))
    }
}

fn get_part<P: Part>(app: &App, named: &Named, resource: &Resource) -> Result<Response, Problem> {
    let kept = named.book(app)?.current();
    match find::<P>(&kept.file, resource) {
        Some(part) => Ok(tagged(&kept.etag, Json(part))),
        None => Err(not_there(resource)),
    }
}

async fn put_part<P: Part>(
    app: &App,
    named: &Named,
    resource: Resource,
    headers: &HeaderMap,
    request: Request,
) -> Result<Response, Problem> {
    let book = named.book(app)?;
    let based_on = based_on(headers)?;
    let text = part(request, &app.server).await?;
    let body: P = parse_part(&text)?;
    if body.resource() != resource {
        let (body, path) = (
            shown(&body.resource().to_string()),
            shown(&resource.to_string()),
        );
        let message = format!("the body is `{body}`; the path names `{path}`");
        return Err(
            Problem::new(ProblemCode::Validation, message.clone()).violations(vec![Violation {
                item: "body".to_owned(),
                message,
                ..Violation::default()
            }]),
        );
    }
    let changing = book.change(based_on, resource, move |file| {
        put(file, body);
        Ok(Edit::Put)
    });
    Ok(answer(changing.await?))
}

async fn delete_part<P: Part>(
    app: &App,
    named: &Named,
    resource: Resource,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let book = named.book(app)?;
    let based_on = based_on(headers)?;
    let gone = resource.clone();
    let changing = book.change(based_on, resource, move |file| {
        if remove::<P>(file, &gone) {
            Ok(Edit::Delete)
        } else {
            Err(ChangeError::NotThere { resource: gone })
        }
    });
    Ok(answer(changing.await?))
}

fn answer(changed: SetupRevision) -> Response {
    tagged(&changed.etag.clone(), Json(changed))
}

fn not_there(resource: &Resource) -> Problem {
    Problem::not_found(format!(
        "there is no `{}` in the set-up",
        shown(&resource.to_string())
    ))
}

/// The three routes of one kind of part.
macro_rules! part_routes {
    ($($body:path, $what:tt, $path:tt, [$($param:tt)*], $named:ident => $resource:expr,
        $get:ident, $put:ident, $delete:ident;)*) => {
        $(
            #[utoipa::path(
                get, path = $path, summary = concat!("Shows ", $what, "."), tag = "setup", params(("cell" = String, Path, description = "The cell's id."), $($param)*),
                responses(
                    (status = 200, description = "It.", body = $body,
                        headers(("etag" = String, description = "Of the whole set-up; for `If-Match`."))),
                    NotFound, AnyProblem,
                ),
            )]
            pub(super) async fn $get(
                State(app): State<Arc<App>>,
                $named: Named,
            ) -> Result<Response, Problem> {
                let resource = $resource;
                get_part::<$body>(&app, &$named, &resource)
            }

            #[utoipa::path(
                put, path = $path,
                summary = concat!("Puts ", $what, " in, or in the place of the one with its id."),
                description = "The whole set-up must fit afterwards.", tag = "setup",
                params(("cell" = String, Path, description = "The cell's id."), $($param)*
                    ("if-match" = String, Header, description = "The entity tag the change is based on.")),
                request_body = $body,
                responses(
                    (status = 200, description = "It holds now.", body = SetupRevision,
                        headers(("etag" = String, description = "Of the whole set-up now."))),
                    ChangeProblem, CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
                ),
            )]
            pub(super) async fn $put(
                State(app): State<Arc<App>>,
                $named: Named,
                headers: HeaderMap,
                request: Request,
            ) -> Result<Response, Problem> {
                let resource = $resource;
                put_part::<$body>(&app, &$named, resource, &headers, request).await
            }

            #[utoipa::path(
                delete, path = $path, summary = concat!("Deletes ", $what, "."),
                description = "Refused, with the list, while other parts refer to it.", tag = "setup",
                params(("cell" = String, Path, description = "The cell's id."), $($param)*
                    ("if-match" = String, Header, description = "The entity tag the change is based on.")),
                responses(
                    (status = 200, description = "It is gone.", body = SetupRevision,
                        headers(("etag" = String, description = "Of the whole set-up now."))),
                    ChangeProblem, CrossSite, NotFound, AnyProblem,
                ),
            )]
            pub(super) async fn $delete(
                State(app): State<Arc<App>>,
                $named: Named,
                headers: HeaderMap,
            ) -> Result<Response, Problem> {
                let resource = $resource;
                delete_part::<$body>(&app, &$named, resource, &headers).await
            }
        )*

        /// The routes of the parts.
        pub(super) fn documented() -> OpenApiRouter<Arc<App>> {
            OpenApiRouter::new()$(.routes(routes!($get, $put, $delete)))*
        }
    };
}

part_routes! {
    api::setup::ArmSetup, "an arm's place in the cell", "/api/v1/cells/{cell}/setup/arms/{arm}",
        [("arm" = String, Path, description = "The arm's id."),],
        named => Resource::Arm(named.get("arm")),
        get_setup_arm, put_setup_arm, delete_setup_arm;
    api::setup::ToolSetup, "a tool", "/api/v1/cells/{cell}/setup/tools/{arm}/{number}",
        [("arm" = String, Path, description = "The arm's id."), ("number" = u8, Path, description = "The tool's number."),],
        named => Resource::Tool { arm: named.get("arm"), number: named.number("number") },
        get_tool, put_tool, delete_tool;
    api::setup::ZoneBody, "a zone", "/api/v1/cells/{cell}/setup/zones/{zone}",
        [("zone" = String, Path, description = "The zone's id."),],
        named => Resource::Zone(named.get("zone")),
        get_zone, put_zone, delete_zone;
    api::setup::StationBody, "a station", "/api/v1/cells/{cell}/setup/stations/{station}",
        [("station" = String, Path, description = "The station's id."),],
        named => Resource::Station(named.get("station")),
        get_station, put_station, delete_station;
    api::setup::PlaceBody, "a place", "/api/v1/cells/{cell}/setup/places/{place}",
        [("place" = String, Path, description = "The place's id; a slash in it is written %2F."),],
        named => Resource::Place(named.get("place")),
        get_place, put_place, delete_place;
    api::setup::TaughtPoseBody, "a taught pose", "/api/v1/cells/{cell}/setup/taught-poses/{arm}/{place}",
        [("arm" = String, Path, description = "The arm's id."),
         ("place" = String, Path, description = "The place's id; a slash in it is written %2F."),],
        named => Resource::TaughtPose { arm: named.get("arm"), place: named.get("place") },
        get_taught_pose, put_taught_pose, delete_taught_pose;
    api::setup::DestinationBody, "a destination", "/api/v1/cells/{cell}/setup/destinations/{destination}",
        [("destination" = String, Path, description = "The destination's id."),],
        named => Resource::Destination(named.get("destination")),
        get_destination, put_destination, delete_destination;
    api::setup::MobileRobotSetup, "a mobile robot's description", "/api/v1/cells/{cell}/setup/mobile-robots/{mobile_robot}",
        [("mobile_robot" = String, Path, description = "The mobile robot's id."),],
        named => Resource::MobileRobot(named.get("mobile_robot")),
        get_mobile_robot_setup, put_mobile_robot_setup, delete_mobile_robot_setup;
    api::setup::RouteBody, "a route", "/api/v1/cells/{cell}/setup/routes/{route}",
        [("route" = String, Path, description = "The route's id."),],
        named => Resource::Route(named.get("route")),
        get_route, put_route, delete_route;
    api::setup::LoadBody, "a load", "/api/v1/cells/{cell}/setup/loads/{load}",
        [("load" = String, Path, description = "The load's id."),],
        named => Resource::Load(named.get("load")),
        get_load_setup, put_load_setup, delete_load_setup;
    api::setup::TriggerBody, "a trigger", "/api/v1/cells/{cell}/setup/triggers/{trigger}",
        [("trigger" = String, Path, description = "The trigger's id."),],
        named => Resource::Trigger(named.get("trigger")),
        get_trigger, put_trigger, delete_trigger;
}
