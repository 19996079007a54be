//! `karel-emulator state`, `get` and `set`: looking at a running controller and changing its values.

#![expect(
    clippy::indexing_slicing,
    reason = "a JSON value is null where it has no such key"
)]

use std::process::ExitCode;

use anyhow::bail;
use karel_emulator::controller::{ItemKind, kind_of, value_of_text};
use serde_json::{Value, json};

use crate::http::{Panel, clean, escape, print_json, put};
use crate::watch::page;

/// Show a running controller at one look: tasks, joints, I/O, alarms, faults.
#[derive(Debug, clap::Args)]
pub(crate) struct State {
    #[command(flatten)]
    panel: Panel,
    /// Print the JSON of the controller instead.
    #[arg(long)]
    json: bool,
}

impl State {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        if self.json {
            print_json(&self.panel.get("/api/v1/state")?);
        } else {
            put(&page(self.panel)?);
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Show a variable, a register, a port, or all variables of a program.
#[derive(Debug, clap::Args)]
pub(crate) struct Get {
    #[command(flatten)]
    panel: Panel,
    /// `[PROG]VAR.FIELD`, `$NAME`, `R[n]`, `PR[n]`, `SR[n]`, `F[n]`, `DIN[n]`, `DOUT[n]`, ..; or `[PROG]` for all variables of a program.
    item: String,
    /// Print the JSON of the controller instead.
    #[arg(long)]
    json: bool,
}

impl Get {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let item = self.item.trim();
        let program = item
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'));
        if let Some(program) = program {
            let list = self
                .panel
                .get(&format!("/api/v1/variables?program={}", escape(program)))?;
            if self.json {
                print_json(&list);
                return Ok(ExitCode::SUCCESS);
            }
            for variable in list["variables"].as_array().into_iter().flatten() {
                put(&format!(
                    "{} = {}\n",
                    word(&variable["path"]),
                    variable["value"]
                ));
            }
            if list["more"] == true {
                put("..\n");
            }
            return Ok(ExitCode::SUCCESS);
        }
        let answer = self.panel.get(&path_of(item))?;
        if self.json {
            print_json(&answer);
        } else {
            put(&format!("{}\n", clean(&answer["value"].to_string())));
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Set a variable, a register or a port; or simulate an input.
#[derive(Debug, clap::Args)]
pub(crate) struct Set {
    #[command(flatten)]
    panel: Panel,
    /// As for `get`.
    item: String,
    /// A number, true, false, ON, OFF, text, null, or a position such as `{"joints_deg": [..]}`.
    #[arg(allow_hyphen_values = true, required_unless_present = "end_simulation")]
    value: Option<String>,
    /// Programs see this value, whatever the world puts on the input.
    #[arg(long)]
    simulate: bool,
    /// Programs see again what the world puts on the input.
    #[arg(long, conflicts_with_all = ["simulate", "value"])]
    end_simulation: bool,
}

impl Set {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let item = self.item.trim();
        let kind = kind_of(item);
        let port = format!("/api/v1/io/{}", escape(item));
        if (self.simulate || self.end_simulation) && kind != ItemKind::Port {
            bail!("{} is no input, only inputs are simulated", clean(item));
        }
        if self.end_simulation {
            let _port = self.panel.delete(&format!("{port}/simulation"))?;
            return Ok(ExitCode::SUCCESS);
        }
        let text = self.value.as_deref().unwrap_or_default();
        let value = json!(value_of_text(item, text)?);
        let _answer = match kind {
            ItemKind::Variable => {
                let body = json!({"path": item, "value": value});
                self.panel.put("/api/v1/variable", &body)?
            }
            ItemKind::Register => self.panel.put(&path_of(item), &json!({"value": value}))?,
            ItemKind::Port => {
                let switch = value.as_bool().map(|on| json!(i32::from(on)));
                let number = switch.unwrap_or(value);
                let end = if self.simulate { "/simulation" } else { "" };
                self.panel
                    .put(&format!("{port}{end}"), &json!({"value": number}))?
            }
        };
        Ok(ExitCode::SUCCESS)
    }
}

fn path_of(item: &str) -> String {
    let escaped = escape(item);
    match kind_of(item) {
        ItemKind::Variable => format!("/api/v1/variable?path={escaped}"),
        ItemKind::Register => format!("/api/v1/registers/{escaped}"),
        ItemKind::Port => format!("/api/v1/io/{escaped}"),
    }
}

/// A JSON string as text for people.
pub(crate) fn word(value: &Value) -> String {
    match value.as_str() {
        Some(text) => clean(text),
        None if value.is_null() => String::new(),
        None => value.to_string(),
    }
}
