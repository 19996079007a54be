//! Who is asking, and the tokens of the server.

use api::{AuditList, Me, NewToken, RotateBody, TokenBody, TokenInfo, TokenList};

use crate::http::{Effect, Exchange};
use crate::{Client, ClientError, Page};

impl Client {
    /// Who the server takes this client for.
    ///
    /// # Errors
    /// A problem `unauthorized` without a valid token; else as all calls.
    pub async fn me(&self) -> Result<Me, ClientError> {
        let path = ["api", "v1", "me"];
        self.http.get(&path, Effect::Question).json().await
    }

    /// A page of who did what in a cell, the newest first. For integrators and admins.
    ///
    /// # Errors
    /// A problem `forbidden` for anybody else, `not-found` if there is no such cell; else as all calls.
    pub async fn audit(&self, cell: &str, page: &Page) -> Result<AuditList, ClientError> {
        let path = ["api", "v1", "cells", cell, "audit"];
        let exchange = self.http.get(&path, Effect::Question);
        exchange.query(page).json().await
    }

    /// Every token, newest first. For admins.
    ///
    /// # Errors
    /// A problem `forbidden` for anybody else; else as all calls.
    pub async fn tokens(&self) -> Result<TokenList, ClientError> {
        let path = ["api", "v1", "tokens"];
        self.http.get(&path, Effect::Question).json().await
    }

    /// Makes a token. Its text is in the answer, this once. For admins.
    ///
    /// # Errors
    /// A problem `name-taken`, `validation` or `forbidden`; else as all calls.
    pub async fn create_token(&self, body: &TokenBody) -> Result<NewToken, ClientError> {
        self.post(&[]).body(body).json().await
    }

    /// Revokes a token. For admins.
    ///
    /// # Errors
    /// A problem `not-found`, `last-admin` or `forbidden`; else as all calls.
    pub async fn revoke_token(&self, id: &str) -> Result<TokenInfo, ClientError> {
        let path = ["api", "v1", "tokens", id];
        self.http.delete(&path, Effect::Question).json().await
    }

    /// Gives a token a new secret; the old one stays valid for `overlap_s` seconds. For admins.
    ///
    /// # Errors
    /// A problem `not-found`, `validation` or `forbidden`; else as all calls.
    pub async fn rotate_token(&self, id: &str, overlap_s: u32) -> Result<NewToken, ClientError> {
        let body = RotateBody { overlap_s };
        self.post(&[id, "rotate"]).body(&body).json().await
    }

    fn post(&self, rest: &[&str]) -> Exchange {
        let mut path = vec!["api", "v1", "tokens"];
        path.extend(rest);
        self.http.post(&path, Effect::Question)
    }
}
