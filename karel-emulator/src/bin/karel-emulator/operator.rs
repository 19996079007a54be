//! `karel-emulator operator`: keys and switches of a running controller.

use std::process::ExitCode;

use clap::{Subcommand, ValueEnum};
use serde_json::{Value, json};

use crate::http::{LinkError, Panel, escape, put};
use crate::remote::word;

/// Press the keys and turn the switches of a running controller.
#[derive(Debug, clap::Args)]
pub(crate) struct Operator {
    #[command(flatten)]
    panel: Panel,
    #[command(subcommand)]
    key: Key,
}

#[derive(Debug, Subcommand)]
enum Key {
    /// HOLD: tasks pause, the arm brakes on its path.
    Hold,
    /// CYCLE START: what is paused goes on.
    Start,
    /// RESET: no alarm is active any more.
    Reset,
    /// The mode switch: T1, T2 or AUTO.
    Mode {
        #[arg(value_parser = ["T1", "T2", "AUTO"], ignore_case = true)]
        mode: String,
    },
    /// The teach pendant's switch.
    Pendant { switch: Switch },
    /// The enabling switch of the pendant: held (on) or released (off)
    Deadman { switch: Switch },
    /// The fence
    Fence { gate: Gate },
    /// The emergency stop: on is pressed.
    EmergencyStop { switch: Switch },
    /// Servo power.
    Servo { switch: Switch },
    /// The STEP key: tasks pause after each line.
    Step { switch: Switch },
    /// The general override in percent.
    Override {
        #[arg(value_parser = clap::value_parser!(i32).range(0..=100))]
        percent: i32,
    },
    /// Start a program as a task.
    Run { program: String },
    /// Abort a task, or all if none is named.
    Abort { task: Option<String> },
    /// Pause a task.
    Pause { task: String },
    /// Let a paused task go on.
    Continue { task: String },
    /// Let a paused task execute one line.
    StepTask { task: String },
    /// Type at the pendant's keyboard, and press ENTER.
    Type {
        text: String,
        /// Without ENTER.
        #[arg(long)]
        no_enter: bool,
    },
    /// Switch the power off and on.
    PowerCycle {
        /// The battery was changed too late: variables in CMOS and registers are lost.
        #[arg(long)]
        lose_memory: bool,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Gate {
    Open,
    Closed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

impl Operator {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let answer = self.press()?;
        put(&in_words(&answer));
        Ok(ExitCode::SUCCESS)
    }

    fn press(&self) -> Result<Value, LinkError> {
        let panel = self.panel;
        let press = |path: &str| panel.post(path, &json!({}));
        let turn = |key: &str, value: Value| panel.patch("/api/v1/operator", &json!({key: value}));
        let on = |switch: &Switch| json!(*switch == Switch::On);
        let task =
            |name: &str, verb: &str| press(&format!("/api/v1/tasks/{}/{verb}", escape(name)));
        match &self.key {
            Key::Hold => press("/api/v1/hold"),
            Key::Start => press("/api/v1/cycle-start"),
            Key::Reset => press("/api/v1/reset"),
            Key::Mode { mode } => turn("mode", json!(mode.to_ascii_uppercase())),
            Key::Pendant { switch } => turn("pendant_enabled", on(switch)),
            Key::Deadman { switch } => turn("deadman_held", on(switch)),
            Key::Fence { gate } => turn("fence_open", json!(*gate == Gate::Open)),
            Key::EmergencyStop { switch } => turn("emergency_stop", on(switch)),
            Key::Servo { switch } => turn("servo_power", on(switch)),
            Key::Step { switch } => turn("single_step", on(switch)),
            Key::Override { percent } => turn("override_percent", json!(percent)),
            Key::Run { program } => press(&format!("/api/v1/programs/{}/run", escape(program))),
            Key::Abort { task: None } => press("/api/v1/abort-all"),
            Key::Abort { task: Some(name) } => task(name, "abort"),
            Key::Pause { task: name } => task(name, "pause"),
            Key::Continue { task: name } => task(name, "continue"),
            Key::StepTask { task: name } => task(name, "step"),
            Key::Type { text, no_enter } => {
                let enter = if *no_enter { "" } else { "\n" };
                panel.post(
                    "/api/v1/keyboard",
                    &json!({"text": format!("{text}{enter}")}),
                )
            }
            Key::PowerCycle { lose_memory } => {
                let memory = if *lose_memory { "lost" } else { "kept" };
                panel.post("/api/v1/power-cycle", &json!({"memory": memory}))
            }
        }
    }
}

fn in_words(answer: &Value) -> String {
    let facts = answer.as_object().into_iter().flatten();
    let facts = facts.filter(|(_, value)| !value.is_array());
    let facts: Vec<String> = facts
        .filter(|(_, value)| !value.is_null())
        .map(|(key, value)| format!("{key} {}", word(value)))
        .collect();
    if facts.is_empty() {
        return "done\n".to_owned();
    }
    format!("{}\n", facts.join(", "))
}
