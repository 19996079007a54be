//! The problems groups of routes share, for the OpenAPI document.

#![expect(dead_code, reason = "the variants exist for their descriptions only")]

use api::Problem;
use utoipa::IntoResponses;

/// What can be wrong with any request.
#[derive(IntoResponses)]
pub(crate) enum AnyProblem {
    /// `request-timeout`: the body did not arrive, or the request was not answered, in time.
    #[response(status = 408, content_type = "application/problem+json")]
    Timeout(Problem),
    /// `unauthorized`: no token, or none that is valid.
    #[response(
        status = 401,
        content_type = "application/problem+json",
        headers(("www-authenticate" = String, description = "`Bearer`"))
    )]
    Unauthorized(Problem),
    /// `forbidden`: the token's role or scope does not allow it. `cross-site-request`: a page of another site made a
    /// browser send the request.
    #[response(status = 403, content_type = "application/problem+json")]
    Forbidden(Problem),
    /// `rate-limited`: too many tokens from this address were not valid.
    #[response(
        status = 429,
        content_type = "application/problem+json",
        headers(("retry-after" = u32, description = "Seconds after which to try again."))
    )]
    RateLimited(Problem),
    /// `host-not-allowed`: the Host header names a host this server does not answer for.
    #[response(status = 421, content_type = "application/problem+json")]
    Host(Problem),
    /// `internal`: a defect of the server.
    #[response(status = 500, content_type = "application/problem+json")]
    Internal(Problem),
}

/// `forbidden`: the token's role or scope does not allow it. `cross-site-request`: a page of another site made a
/// browser send the request.
#[derive(IntoResponses)]
#[response(status = 403, content_type = "application/problem+json")]
pub(crate) struct CrossSite(Problem);

/// What can be wrong with the form of a JSON body.
#[derive(IntoResponses)]
pub(crate) enum BodyProblem {
    /// `payload-too-large`
    #[response(status = 413, content_type = "application/problem+json")]
    TooLarge(Problem),
    /// `unsupported-media-type`
    #[response(status = 415, content_type = "application/problem+json")]
    MediaType(Problem),
}

/// `invalid-json`
#[derive(IntoResponses)]
#[response(status = 400, content_type = "application/problem+json")]
pub(crate) struct InvalidJson(Problem);

/// `not-found`: no such cell, robot or motion.
#[derive(IntoResponses)]
#[response(status = 404, content_type = "application/problem+json")]
pub(crate) struct NotFound(Problem);

/// What a controller's link can answer a command with.
#[derive(IntoResponses)]
pub(crate) enum LinkProblem {
    /// `controller-protocol`: the controller's answer is not understood; the motion is in doubt.
    #[response(status = 502, content_type = "application/problem+json")]
    Protocol(Problem),
    /// `controller-busy`, `controller-disconnected`, `journal-unavailable` or `shutting-down`: not sent.
    #[response(
        status = 503,
        content_type = "application/problem+json",
        headers(("retry-after" = u32, description = "Seconds after which to try again."))
    )]
    Unavailable(Problem),
    /// `journal-full`: the intent could not be kept, so nothing was sent.
    #[response(status = 507, content_type = "application/problem+json")]
    Full(Problem),
    /// `controller-timeout`: no answer in time; the motion is in doubt.
    #[response(status = 504, content_type = "application/problem+json")]
    Timeout(Problem),
}

/// Why a cell cannot take a request now. Nothing has changed.
#[derive(IntoResponses)]
pub(crate) enum KeptProblem {
    /// `journal-unavailable`: it could not be kept, so it does not hold. `cell-not-ready`, `shutting-down`.
    #[response(
        status = 503,
        content_type = "application/problem+json",
        headers(("retry-after" = u32, description = "Seconds after which to try again."))
    )]
    Unavailable(Problem),
    /// `journal-full`: the same, for want of room on the disk.
    #[response(status = 507, content_type = "application/problem+json")]
    Full(Problem),
}

/// What is wrong without control of the cell. That it was lost is a 409 of each route's own.
#[derive(IntoResponses)]
pub(crate) enum ControlProblem {
    /// `control-held`: somebody else has control of the cell; `control` says who, since when and until when.
    #[response(status = 423, content_type = "application/problem+json")]
    Held(Problem),
    /// `control-required`: the request has no `Control-Token`.
    #[response(status = 428, content_type = "application/problem+json")]
    Required(Problem),
}
