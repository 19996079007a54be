use api::setup::{
    CalibrationBody, CalibrationResult, SetupCheck, SetupFile, SetupRevision, TeachBody,
    TeachResult,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::ClientError;
use crate::http::{Effect, Http};

/// Something with the entity tag of the set-up it belongs to: what a change based on it names.
#[derive(Clone, Debug, PartialEq)]
pub struct Tagged<T> {
    /// The tag, quotes included.
    pub etag: String,
    /// The thing itself.
    pub value: T,
}

/// The form a set-up is written in.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum SetupForm {
    /// TOML.
    Toml,
    /// JSON.
    Json,
}

/// A set-up as a text, unread: the server reads it, and says what is wrong with it by line and by key.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupText {
    /// Its form.
    pub form: SetupForm,
    /// The text.
    pub text: String,
}

impl SetupForm {
    fn media_type(self) -> &'static str {
        match self {
            Self::Toml => "application/toml",
            Self::Json => "application/json",
        }
    }
}

/// The operator's set-up of one cell. Cheap to clone.
///
/// Every change names the revision it is based on. If somebody else was faster it is refused with a problem
/// `precondition-failed`, and nothing is changed. After [`ClientError::Timeout`] and [`ClientError::Interrupted`] a
/// change may have been made: read the set-up again. No call here moves a robot.
#[derive(Clone, Debug)]
pub struct CellSetup {
    http: Http,
    cell: String,
}

impl CellSetup {
    pub(crate) fn new(http: Http, cell: &str) -> Self {
        Self {
            http,
            cell: cell.to_owned(),
        }
    }

    /// The cell's id.
    #[must_use]
    pub fn cell(&self) -> &str {
        &self.cell
    }

    /// The whole set-up.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell; else as all calls.
    pub async fn get(&self) -> Result<Tagged<SetupFile>, ClientError> {
        self.http
            .get(&self.path(&[]), Effect::Question)
            .tagged_json()
            .await
    }

    /// The whole set-up as a text.
    ///
    /// # Errors
    /// As [`CellSetup::get`].
    pub async fn export(&self, form: SetupForm) -> Result<Tagged<String>, ClientError> {
        self.http
            .get(&self.path(&[]), Effect::Question)
            .accept(form.media_type())
            .tagged_text()
            .await
    }

    /// Puts a whole set-up in the place of the one with this tag.
    ///
    /// # Errors
    /// Problems `validation` with everything wrong with it, `precondition-failed`, `resource-in-use`; else as
    /// [`CellSetup::get`].
    pub async fn import(&self, text: SetupText, etag: &str) -> Result<SetupRevision, ClientError> {
        self.http
            .put(&self.path(&[]), Effect::Question)
            .if_match(etag)
            .text_body(text.form.media_type(), text.text)
            .json()
            .await
    }

    /// Plans every taught pose of a set-up, or of the one that holds. Nothing moves, nothing is imported.
    ///
    /// # Errors
    /// A problem `validation` with everything wrong with it, where it is no set-up that could be planned; else as
    /// [`CellSetup::get`].
    pub async fn check(&self, text: Option<SetupText>) -> Result<SetupCheck, ClientError> {
        let request = self.http.post(&self.path(&["check"]), Effect::Question);
        let request = match text {
            Some(text) => request.text_body(text.form.media_type(), text.text),
            None => request,
        };
        request.json().await
    }

    /// One part, by its path below the set-up, e.g. `["places", "rack/a"]`.
    ///
    /// # Errors
    /// A problem `not-found` if there is no such cell or part; else as all calls.
    pub async fn part<T: DeserializeOwned>(&self, path: &[&str]) -> Result<Tagged<T>, ClientError> {
        self.http
            .get(&self.path(path), Effect::Question)
            .tagged_json()
            .await
    }

    /// Puts a part in, or in the place of the one with its id.
    ///
    /// # Errors
    /// As [`CellSetup::import`].
    pub async fn put_part<T: Serialize>(
        &self,
        path: &[&str],
        part: &T,
        etag: &str,
    ) -> Result<SetupRevision, ClientError> {
        self.http
            .put(&self.path(path), Effect::Question)
            .if_match(etag)
            .body(part)
            .json()
            .await
    }

    /// Deletes a part.
    ///
    /// # Errors
    /// A problem `still-referenced` with the list if other parts refer to it; else as [`CellSetup::import`].
    pub async fn delete_part(
        &self,
        path: &[&str],
        etag: &str,
    ) -> Result<SetupRevision, ClientError> {
        self.http
            .delete(&self.path(path), Effect::Question)
            .if_match(etag)
            .json()
            .await
    }

    /// Teaches a pose: the arm's actual one, or the one in the body.
    ///
    /// # Errors
    /// A problem `no-actual-pose` if the controller does not report one; else as [`CellSetup::import`].
    pub async fn teach(
        &self,
        arm: &str,
        place: &str,
        body: &TeachBody,
        etag: &str,
    ) -> Result<TeachResult, ClientError> {
        let path = self.path(&["taught-poses", arm, place, "teach"]);
        self.http
            .post(&path, Effect::Question)
            .if_match(etag)
            .body(body)
            .json()
            .await
    }

    /// Computes a tool center point from postures that hold its tip at one point. Nothing is kept.
    ///
    /// # Errors
    /// A problem `calibration-refused` if the postures do not determine it or do not agree; else as
    /// [`CellSetup::get`].
    pub async fn calibrate(
        &self,
        arm: &str,
        tool: u8,
        body: &CalibrationBody,
    ) -> Result<CalibrationResult, ClientError> {
        let number = tool.to_string();
        let path = self.path(&["tools", arm, &number, "calibrate"]);
        self.http
            .post(&path, Effect::Question)
            .body(body)
            .json()
            .await
    }

    fn path<'a>(&'a self, rest: &[&'a str]) -> Vec<&'a str> {
        let mut path = vec!["api", "v1", "cells", &self.cell, "setup"];
        path.extend(rest);
        path
    }
}
