//! User frames and tool frames.

use axum::extract::{Json, Path, State as Shared};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Body, Refusal};
use crate::controller::{Controller, DataError, PoseValue, ValueBody};
use crate::virtual_controller::visit;

/// Frames that the pendant's menu has.
const FRAMES: i32 = 10;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(get_frames))
        .routes(routes!(set_frame))
        .routes(routes!(select_frame))
}

/// A frame of the pendant's menu.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrameView {
    /// 1 to 10.
    pub number: i32,
    /// Where it is, `null` if it has no value.
    pub frame: Option<ValueBody>,
}

/// All frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Frames {
    /// `$MNUFRAME[1,n]`.
    pub user: Vec<FrameView>,
    /// `$MNUTOOL[1,n]`.
    pub tool: Vec<FrameView>,
    /// `$MNUFRAMENUM[1]`, 0 for the world.
    pub selected_user: Option<ValueBody>,
    /// `$MNUTOOLNUM[1]`, 0 for the flange.
    pub selected_tool: Option<ValueBody>,
    /// `$UFRAME`, of KAREL programs.
    pub uframe: Option<ValueBody>,
    /// `$UTOOL`, of KAREL programs.
    pub utool: Option<ValueBody>,
}

/// The number of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SelectedFrame {
    /// 0 to 10.
    pub number: i32,
}

fn frames(core: &mut Controller) -> Result<Frames, DataError> {
    let mut menu = |name: &str| {
        let frame = |number| {
            let path = format!("{name}[1,{number}]");
            let frame = core.variable(&path)?;
            Ok::<_, DataError>(FrameView { number, frame })
        };
        (1..=FRAMES).map(frame).collect::<Result<Vec<_>, _>>()
    };
    Ok(Frames {
        user: menu("$MNUFRAME")?,
        tool: menu("$MNUTOOL")?,
        selected_user: core.variable("$MNUFRAMENUM[1]")?,
        selected_tool: core.variable("$MNUTOOLNUM[1]")?,
        uframe: core.variable("$UFRAME")?,
        utool: core.variable("$UTOOL")?,
    })
}

fn kind_of(kind: &str) -> Result<(&'static str, &'static str), Refusal> {
    match kind {
        "user" => Ok(("$MNUFRAME", "$MNUFRAMENUM[1]")),
        "tool" => Ok(("$MNUTOOL", "$MNUTOOLNUM[1]")),
        _ => {
            let text = format!("{kind:?} is no kind of frames: user or tool");
            Err(Refusal::new(StatusCode::NOT_FOUND, text))
        }
    }
}

/// Shows all frames and which are selected.
#[utoipa::path(get, path = "/api/v1/frames", tag = "frames",
    responses((status = 200, description = "The frames.", body = Frames), AnyProblem))]
async fn get_frames(Shared(visitors): Shared<Visitors>) -> Result<Json<Frames>, Refusal> {
    Ok(Json(
        visit(&visitors.commands, |driver| frames(&mut driver.core)).await??,
    ))
}

/// Sets a frame of the pendant's menu.
#[utoipa::path(put, path = "/api/v1/frames/{kind}/{number}", tag = "frames", request_body = PoseValue,
    params(("kind" = String, Path, description = "`user` or `tool`."), ("number" = i32, Path, description = "1 to 10.")),
    responses((status = 200, description = "The frames.", body = Frames), AnyProblem))]
async fn set_frame(
    Shared(visitors): Shared<Visitors>,
    Path((kind, number)): Path<(String, String)>,
    Body(pose): Body<PoseValue>,
) -> Result<Json<Frames>, Refusal> {
    let (name, _) = kind_of(&kind)?;
    let parsed = number.parse::<i32>().ok();
    let Some(number) = parsed.filter(|n| (1..=FRAMES).contains(n)) else {
        let text = format!("there is no frame {number:?}, they go from 1 to {FRAMES}");
        return Err(Refusal::new(StatusCode::NOT_FOUND, text));
    };
    let path = format!("{name}[1,{number}]");
    set(&visitors, path, ValueBody::Pose(pose)).await
}

/// Selects a frame.
#[utoipa::path(put, path = "/api/v1/selected-frames/{kind}", tag = "frames", request_body = SelectedFrame,
    params(("kind" = String, Path, description = "`user` or `tool`.")),
    responses((status = 200, description = "The frames.", body = Frames), AnyProblem))]
async fn select_frame(
    Shared(visitors): Shared<Visitors>,
    Path(kind): Path<String>,
    Body(SelectedFrame { number }): Body<SelectedFrame>,
) -> Result<Json<Frames>, Refusal> {
    let (_, selected) = kind_of(&kind)?;
    if !(0..=FRAMES).contains(&number) {
        return Err(Refusal::range("number", number, "0 to 10"));
    }
    set(&visitors, selected.to_owned(), ValueBody::Integer(number)).await
}

async fn set(visitors: &Visitors, path: String, value: ValueBody) -> Result<Json<Frames>, Refusal> {
    let answer = visit(&visitors.commands, move |driver| {
        driver.core.set_variable(&path, Some(&value))?;
        frames(&mut driver.core)
    });
    Ok(Json(answer.await??))
}
