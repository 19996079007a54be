//! `karel-emulator time`: the time of a running controller.

#![expect(
    clippy::indexing_slicing,
    reason = "a JSON value is null where it has no such key"
)]

use std::process::ExitCode;

use clap::Subcommand;
use serde_json::json;

use crate::http::{Panel, put};

/// Pause, step or scale the time of a running controller.
#[derive(Debug, clap::Args)]
pub(crate) struct Time {
    #[command(flatten)]
    panel: Panel,
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Show it.
    Show,
    /// It stands still.
    Pause,
    /// It goes on.
    Run,
    /// Let some milliseconds pass while it stands still.
    Step {
        #[arg(value_name = "MS")]
        ms: u64,
    },
    /// Controller seconds in a second, above 0 and up to 1000.
    Scale {
        #[arg(value_name = "N")]
        scale: f64,
    },
}

impl Time {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let panel = self.panel;
        let patch = |body| panel.patch("/api/v1/time", &body);
        let time = match self.what {
            What::Show => panel.get("/api/v1/time"),
            What::Pause => patch(json!({"paused": true})),
            What::Run => patch(json!({"paused": false})),
            What::Step { ms } => panel.post("/api/v1/time/step", &json!({"ms": ms})),
            What::Scale { scale } => patch(json!({"scale": scale})),
        }?;
        let pace = if time["paused"] == true {
            "it stands still".to_owned()
        } else {
            match time["scale"].as_f64() {
                Some(scale) => format!("{scale} controller seconds in a second"),
                None => "as fast as it can".to_owned(),
            }
        };
        put(&format!(
            "{:.6} s, {pace}\n",
            time["time_s"].as_f64().unwrap_or(0.0)
        ));
        Ok(ExitCode::SUCCESS)
    }
}
