//! Who is asking, and the tokens.

use std::sync::Arc;

use api::{Me, NewToken, RotateBody, TokenBody, TokenInfo, TokenList};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::StatusCode;
use axum::http::request::Parts;
use journal::AuditResult;

use super::params::{param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::extract::JsonBody;
use crate::identity::{Principal, TokenId, entry};
use crate::problem::Problem;
use crate::request_id::RequestId;
use crate::state::App;

/// Says who is asking.
///
/// In demo mode it is `demo`, with every role.
#[utoipa::path(
    get, path = "/api/v1/me", tag = "identity",
    responses((status = 200, description = "The principal behind this request.", body = Me), AnyProblem),
)]
pub(super) async fn me(principal: Principal) -> Json<Me> {
    Json(principal.me())
}

/// Lists the tokens, newest first.
///
/// Their secrets are not among it: the server keeps only a hash of each.
#[utoipa::path(
    get, path = "/api/v1/tokens", tag = "identity",
    responses(
        (status = 200, description = "Every token.", body = TokenList),
        (status = 409, description = "`demo-mode`: there are no tokens.", body = api::Problem, content_type = "application/problem+json"),
        AnyProblem,
    ),
)]
pub(super) async fn list_tokens(State(app): State<Arc<App>>) -> Result<Json<TokenList>, Problem> {
    let tokens = app.identity.list(app.clock.now())?;
    Ok(Json(TokenList { tokens }))
}

/// Makes a token.
///
/// The answer holds the token's text, this once.
#[utoipa::path(
    post, path = "/api/v1/tokens", tag = "identity",
    request_body = TokenBody,
    responses(
        (status = 201, description = "The token.", body = NewToken),
        (status = 409, description = "`name-taken`: a valid token has this name. `demo-mode`: there are no tokens.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the body does not fit.", body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`not-recorded`: it could not be written down, and was not made.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn create_token(
    State(app): State<Arc<App>>,
    principal: Principal,
    request_id: RequestId,
    JsonBody(body): JsonBody<TokenBody>,
) -> Result<(StatusCode, Json<NewToken>), Problem> {
    let object = format!("{} `{}`", body.role, crate::state::shown(&body.name));
    let audited = audited(
        &app,
        &principal,
        "token.create",
        &object,
        &request_id,
        async { app.identity.create(body, &principal, app.clock.now()).await },
    );
    Ok((StatusCode::CREATED, Json(audited.await?)))
}

/// Revokes a token.
///
/// From now on it opens nothing, and control that its holder has is lost. Revoking it again changes nothing. The last
/// valid admin token stays.
#[utoipa::path(
    delete, path = "/api/v1/tokens/{id}", tag = "identity",
    params(("id" = String, Path, description = "The token's public id: the part between the underscores.")),
    responses(
        (status = 200, description = "The token, revoked.", body = TokenInfo),
        (status = 409, description = "`last-admin`: nobody could manage tokens without it. `demo-mode`: there are no tokens.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, NotFound, AnyProblem,
    ),
)]
pub(super) async fn revoke_token(
    State(app): State<Arc<App>>,
    principal: Principal,
    request_id: RequestId,
    TokenOf(id): TokenOf,
) -> Result<Json<TokenInfo>, Problem> {
    // At once, and noted: no disk keeps anybody from closing a door.
    let revoked = app.identity.revoke(&id, app.clock.now()).await;
    let mut about = entry(&principal, "token.revoke", id.as_str(), &request_id);
    if revoked.is_err() {
        about.result = AuditResult::Failed;
    }
    app.audit.note(about);
    Ok(Json(revoked?))
}

/// Gives a token a new secret.
///
/// The answer is a new token with the name, role, scope and lifetime of the old one, which stays valid for
/// `overlap_s`.
#[utoipa::path(
    post, path = "/api/v1/tokens/{id}/rotate", tag = "identity",
    params(("id" = String, Path, description = "The token's public id: the part between the underscores.")),
    request_body = RotateBody,
    responses(
        (status = 201, description = "The new token.", body = NewToken),
        (status = 409, description = "`demo-mode`: there are no tokens.", body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: the body does not fit.", body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`not-recorded`: it could not be written down, and was not done.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn rotate_token(
    State(app): State<Arc<App>>,
    principal: Principal,
    request_id: RequestId,
    TokenOf(id): TokenOf,
    JsonBody(body): JsonBody<RotateBody>,
) -> Result<(StatusCode, Json<NewToken>), Problem> {
    let audited = audited(
        &app,
        &principal,
        "token.rotate",
        id.as_str(),
        &request_id,
        async {
            let now = app.clock.now();
            app.identity.rotate(&id, body, &principal, now).await
        },
    );
    Ok((StatusCode::CREATED, Json(audited.await?)))
}

/// Records that something is done before it is done, and where it was not, that, too: a token opens doors for months,
/// and there is none of which nobody knows who made it.
async fn audited<T>(
    app: &App,
    principal: &Principal,
    action: &str,
    object: &str,
    request_id: &str,
    act: impl Future<Output = Result<T, Problem>>,
) -> Result<T, Problem> {
    let mut about = entry(principal, action, object, request_id);
    let done = match app.audit.record(about.clone()).await {
        Ok(()) => act.await,
        Err(error) => Err(error.into()),
    };
    if done.is_err() {
        // Also where the entry was given up on: it may get into the journal after all.
        about.result = AuditResult::Failed;
        app.audit.note(about);
    }
    done
}

/// The token a path names. What is no id cannot be the id of a token.
pub(super) struct TokenOf(TokenId);

impl FromRequestParts<Arc<App>> for TokenOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        TokenId::parse(param(&params, "id")?)
            .map(Self)
            .ok_or_else(|| {
                Problem::not_found("the token's id is not 16 digits of base 16")
                    .outcome(crate::problem::outcome_of_nothing_sent(&parts.method))
            })
    }
}
