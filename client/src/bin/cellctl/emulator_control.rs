//! `cellctl emulator`, where it touches: tasks, values, keys, time, faults.
//!
//! The answers are the control interface's own, shown as they are: `key value` for people, JSON with `--json`.

use clap::Subcommand;
use client::{Change, EmulatorClient};
use serde_json::{Value, json};

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};

/// What the control interface does. The panel must be open for it: `karel-emulator run` opens it.
#[derive(Debug, Subcommand)]
pub(crate) enum Control {
    /// List the tasks with their call stacks.
    Tasks,
    /// Show a variable, a register or a port: `[PROG]VAR`, `$NAME`, `R[n]`, `PR[n]`, `SR[n]`, `F[n]`, `DIN[n]`, ..
    Get { item: String },
    /// Set a variable, a register or a port; the value is JSON, ON, OFF, or text.
    Set {
        item: String,
        #[arg(allow_hyphen_values = true)]
        value: String,
    },
    /// HOLD: tasks pause, the arm brakes on its path.
    Hold,
    /// CYCLE START: what is paused goes on.
    Start,
    /// RESET: no alarm is active any more.
    Reset,
    /// Press or release the emergency stop.
    EmergencyStop {
        #[arg(value_parser = ["on", "off"])]
        switch: String,
    },
    /// Turn the mode switch.
    Mode {
        #[arg(value_parser = ["T1", "T2", "AUTO"], ignore_case = true)]
        mode: String,
    },
    /// Set the general override in percent.
    Override {
        #[arg(value_parser = clap::value_parser!(i32).range(0..=100))]
        percent: i32,
    },
    /// Switch the power off and on.
    PowerCycle {
        /// The battery was changed too late: variables in CMOS and registers are lost.
        #[arg(long)]
        lose_memory: bool,
    },
    /// Stop the controller's time, let it go on, or let some milliseconds pass.
    Time {
        #[arg(value_parser = ["show", "pause", "run", "step"])]
        what: String,
        /// For `step`.
        #[arg(required_if_eq("what", "step"))]
        ms: Option<u64>,
    },
    /// List the faults that were injected.
    Faults,
    /// Inject a fault, as JSON: `"freeze"`, or `{"fault": {"delay": {"ms": 200}}, "scope": {"port": 59002}, "times": 3}`.
    Fault { fault: String },
    /// Mend a fault, or all if none is named.
    ClearFault { id: Option<u64> },
}

pub(crate) async fn run(
    control: &Control,
    emulator: &EmulatorClient,
    context: &Context,
) -> Result<Report, Failure> {
    let press = async |path| emulator.change(Change::Post, path, Some(&json!({}))).await;
    let turn = async |key: &str, value: Value| {
        let body = json!({key: value});
        emulator
            .change(Change::Patch, &["operator"], Some(&body))
            .await
    };
    let answer = match control {
        Control::Tasks => emulator.ask(&["tasks"], &[]).await,
        Control::Get { item } => get(emulator, item).await,
        Control::Set { item, value } => set(emulator, item, value).await,
        Control::Hold => press(&["hold"]).await,
        Control::Start => press(&["cycle-start"]).await,
        Control::Reset => press(&["reset"]).await,
        Control::EmergencyStop { switch } => turn("emergency_stop", json!(switch == "on")).await,
        Control::Mode { mode } => turn("mode", json!(mode.to_ascii_uppercase())).await,
        Control::Override { percent } => turn("override_percent", json!(percent)).await,
        Control::PowerCycle { lose_memory } => {
            let body = json!({"memory": if *lose_memory { "lost" } else { "kept" }});
            let path = ["power-cycle"];
            emulator.change(Change::Post, &path, Some(&body)).await
        }
        Control::Time { what, ms } => time(emulator, what, *ms).await,
        Control::Faults => emulator.ask(&["faults"], &[]).await,
        Control::Fault { fault } => {
            let body = fault_of(fault)?;
            let path = ["faults"];
            emulator.change(Change::Post, &path, Some(&body)).await
        }
        Control::ClearFault { id: None } => {
            emulator.change(Change::Delete, &["faults"], None).await
        }
        Control::ClearFault { id: Some(id) } => {
            let id = id.to_string();
            emulator
                .change(Change::Delete, &["faults", &id], None)
                .await
        }
    }?;
    Ok(context.report(Exit::Done, &answer, in_words))
}

/// What an item's name says it is.
fn is_variable(item: &str) -> bool {
    item.trim_start().starts_with(['[', '$'])
}

fn is_register(item: &str) -> bool {
    let name = item.split('[').next().unwrap_or_default();
    ["R", "PR", "SR", "F"].contains(&name.trim().to_ascii_uppercase().as_str())
}

async fn get(emulator: &EmulatorClient, item: &str) -> Result<Value, client::ClientError> {
    if is_variable(item) {
        emulator.ask(&["variable"], &[("path", item)]).await
    } else if is_register(item) {
        emulator.ask(&["registers", item], &[]).await
    } else {
        emulator.ask(&["io", item], &[]).await
    }
}

async fn set(
    emulator: &EmulatorClient,
    item: &str,
    text: &str,
) -> Result<Value, client::ClientError> {
    let switch = match text.to_ascii_uppercase().as_str() {
        "ON" => Some(true),
        "OFF" => Some(false),
        _ => None,
    };
    let value = switch.map_or_else(
        || serde_json::from_str(text).unwrap_or_else(|_| json!(text)),
        |on| json!(on),
    );
    if is_variable(item) {
        let body = json!({"path": item, "value": value});
        emulator
            .change(Change::Put, &["variable"], Some(&body))
            .await
    } else if is_register(item) {
        let body = json!({"value": value});
        emulator
            .change(Change::Put, &["registers", item], Some(&body))
            .await
    } else {
        // A port's value is a number.
        let number = value.as_bool().map(|on| json!(i32::from(on)));
        let body = json!({"value": number.unwrap_or(value)});
        emulator
            .change(Change::Put, &["io", item], Some(&body))
            .await
    }
}

async fn time(
    emulator: &EmulatorClient,
    what: &str,
    ms: Option<u64>,
) -> Result<Value, client::ClientError> {
    let patch = |paused: bool| json!({"paused": paused});
    match (what, ms) {
        ("pause", _) => {
            let body = patch(true);
            emulator.change(Change::Patch, &["time"], Some(&body)).await
        }
        ("run", _) => {
            let body = patch(false);
            emulator.change(Change::Patch, &["time"], Some(&body)).await
        }
        ("step", Some(ms)) => {
            let body = json!({"ms": ms});
            let path = ["time", "step"];
            emulator.change(Change::Post, &path, Some(&body)).await
        }
        _ => emulator.ask(&["time"], &[]).await,
    }
}

/// A name alone is a fault without options.
fn fault_of(text: &str) -> Result<Value, Failure> {
    if text.chars().all(|c| c.is_ascii_lowercase() || c == '_') {
        return Ok(json!({"fault": text}));
    }
    let value: Value = serde_json::from_str(text)
        .map_err(|error| Failure::Usage(format!("the fault is no JSON: {error}")))?;
    if value.is_string() {
        return Ok(json!({"fault": value}));
    }
    Ok(value)
}

/// An answer for people: lists one item a line, objects as `key value`.
fn in_words(answer: &Value) -> String {
    if answer.is_null() {
        return "done".to_owned();
    }
    let Some(object) = answer.as_object() else {
        return answer.to_string();
    };
    let lists: Vec<&Vec<Value>> = object.values().filter_map(Value::as_array).collect();
    if let [list] = lists.as_slice() {
        if list.is_empty() {
            return "none".to_owned();
        }
        let lines: Vec<String> = list.iter().map(facts).collect();
        return lines.join("\n");
    }
    facts(answer)
}

fn facts(value: &Value) -> String {
    let Some(object) = value.as_object() else {
        return value.to_string();
    };
    let shown = object.iter().filter(|(_, value)| !value.is_null());
    let parts: Vec<String> = shown
        .map(|(key, value)| match value.as_str() {
            Some(text) => format!("{key} {text}"),
            None => format!("{key} {value}"),
        })
        .collect();
    parts.join("  ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_a_name_or_json() {
        assert_eq!(fault_of("freeze").unwrap(), json!({"fault": "freeze"}));
        assert_eq!(fault_of("\"drop\"").unwrap(), json!({"fault": "drop"}));
        let whole = r#"{"fault": {"delay": {"ms": 5}}, "times": 1}"#;
        assert_eq!(fault_of(whole).unwrap()["times"], 1);
        assert!(fault_of("{").is_err());
    }

    #[test]
    fn items_say_what_they_are() {
        assert!(is_variable("[PROG]n") && is_variable("$UTOOL"));
        assert!(is_register("pr[3]") && is_register("F[1]"));
        assert!(!is_register("DIN[3]") && !is_variable("DIN[3]"));
    }

    #[test]
    fn answers_are_one_item_a_line() {
        let answer = json!({"faults": [{"id": 1, "fault": "freeze", "until_s": null}]});
        assert_eq!(in_words(&answer), "fault freeze  id 1");
        assert_eq!(in_words(&json!({"faults": []})), "none");
        assert_eq!(in_words(&Value::Null), "done");
    }
}
