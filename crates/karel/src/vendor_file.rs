//! Files of a controller that are no source: what they are, and what can be loaded in their place.

use crate::{
    diagnostic::{Diagnostic, Reports},
    span::{Source, Span},
};

/// What a file of this extension is, and what helps.
fn known(extension: &str) -> Option<(&'static str, &'static str)> {
    Some(match extension {
        "PC" => (
            "a translated KAREL program",
            "load its source, the `.kl` file from which it was translated",
        ),
        "TP" => (
            "a TP program in the controller's own form",
            "load its listing, the `.ls` file, which the controller writes as its ASCII form",
        ),
        "VR" | "SV" | "IO" => (
            "values in the controller's own form",
            "set them with `--set ITEM=VALUE`, or `--set @FILE` with a line for each",
        ),
        "VA" => (
            "a listing of variables",
            "set them with `--set ITEM=VALUE`, or `--set @FILE` with a line for each",
        ),
        "TX" => (
            "a translated dictionary",
            "put its source, the `.utx` file, where ADD_DICT looks for it",
        ),
        "MN" | "MR" | "DF" | "ST" => (
            "part of a controller's backup",
            "programs are `.kl` sources and `.ls` listings",
        ),
        _ => return None,
    })
}

/// Why a file cannot be a program, by its extension.
pub(crate) fn refusal(file_name: &str) -> Option<Vec<Diagnostic>> {
    let (_, extension) = file_name.rsplit_once('.')?;
    let (what, help) = known(&extension.to_ascii_uppercase())?;
    // What is in it would only be noise.
    let source = Source::new(&[], file_name);
    let mut reports = Reports::default();
    let message = format!(
        "this is {what} (.{}), no program's source",
        extension.to_ascii_lowercase()
    );
    reports.error_with_help(Span::new(0, 0), message, help);
    Some(reports.into_diagnostics(&source))
}
