//! Which controller this is, and what it says about itself.

use axum::extract::{Json, State as Shared};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::{router::OpenApiRouter, routes};

use super::super::Visitors;
use super::parts::{AnyProblem, Asked, Body, Refusal};
use crate::fidelity::{Fidelity, Note, Profile};
use crate::virtual_controller::visit;

pub(super) fn routes() -> OpenApiRouter<Visitors> {
    OpenApiRouter::new()
        .routes(routes!(get_profile, set_profile))
        .routes(routes!(list_notes))
}

/// What can be changed while it runs; what is missing stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfilePatch {
    /// How much the controller says about itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fidelity: Option<Fidelity>,
}

/// What the controller has said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct NoteList {
    /// Oldest first; the last 500 are kept.
    pub notes: Vec<Note>,
    /// The cursor for what comes after these.
    #[serde(default)]
    pub next: u64,
}

/// Which notes.
#[derive(Clone, Copy, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
struct NotesQuery {
    /// Only those with a greater number: the cursor.
    #[serde(default)]
    after: u64,
    /// If there is none, wait for one up to so many seconds, at most 30.
    wait_s: Option<f64>,
}

/// Shows which controller this is: its fidelity, its generation, the order of bytes, the options that are missing.
#[utoipa::path(get, path = "/api/v1/profile", tag = "state",
    responses((status = 200, description = "The profile.", body = Profile), AnyProblem))]
async fn get_profile(Shared(visitors): Shared<Visitors>) -> Result<Json<Profile>, Refusal> {
    let profile = visit(&visitors.commands, |driver| driver.core.profile());
    Ok(Json(profile.await?))
}

/// Lets the controller explain itself, or be as silent as a real one.
#[utoipa::path(patch, path = "/api/v1/profile", tag = "state", request_body = ProfilePatch,
    responses((status = 200, description = "The profile.", body = Profile), AnyProblem))]
async fn set_profile(
    Shared(visitors): Shared<Visitors>,
    Body(ProfilePatch { fidelity }): Body<ProfilePatch>,
) -> Result<Json<Profile>, Refusal> {
    let profile = visit(&visitors.commands, move |driver| {
        if let Some(fidelity) = fidelity {
            driver.core.set_fidelity(fidelity);
        }
        driver.core.profile()
    });
    Ok(Json(profile.await?))
}

/// Lists what a kind controller has said about itself: why a client waits, a number is none, a pose is out of reach.
/// Waits for something new, if asked to.
#[utoipa::path(get, path = "/api/v1/notes", tag = "state", params(NotesQuery),
    responses((status = 200, description = "The notes.", body = NoteList), AnyProblem))]
async fn list_notes(
    Shared(mut visitors): Shared<Visitors>,
    Asked(NotesQuery { after, wait_s }): Asked<NotesQuery>,
) -> Result<Json<NoteList>, Refusal> {
    if let Some(wait_s) = wait_s {
        visitors
            .wait(wait_s, |state| state.note_seq > after)
            .await?;
    }
    let notes = visit(&visitors.commands, move |driver| driver.core.notes(after)).await?;
    let next = notes.last().map_or(after, |note| note.seq);
    Ok(Json(NoteList { notes, next }))
}
