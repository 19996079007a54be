//! `karel-emulator fault`: break something on purpose.

#![expect(
    clippy::indexing_slicing,
    reason = "a JSON value is null where it has no such key"
)]

use std::process::ExitCode;

use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Map, Value, json};

use crate::http::{Panel, print_json, put};
use crate::remote::word;

/// Break something on purpose at a running controller, list what is broken, and mend it.
///
/// Faults of the wire hit the bytes between clients and the program: everywhere, or in a scope of port, tag, connection
/// and direction; a number of times, for a time, or until they are cleared. Times are controller time.
#[derive(Debug, Args)]
pub(crate) struct Fault {
    #[command(flatten)]
    panel: Panel,
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// List the faults that are active.
    List {
        /// Print the JSON of the controller instead.
        #[arg(long)]
        json: bool,
    },
    /// Mend a fault, or all if none is named.
    Clear { id: Option<u64> },
    /// Wire: bytes vanish.
    Drop(Wire),
    /// Wire: bytes arrive later, in order.
    Delay {
        /// How much later.
        #[arg(long)]
        ms: u64,
        /// Up to this much more, drawn anew for each piece.
        #[arg(long, default_value_t = 0)]
        jitter_ms: u64,
        #[command(flatten)]
        wire: Wire,
    },
    /// Wire: bytes arrive in pieces.
    Split {
        /// Length of a piece.
        #[arg(long)]
        bytes: usize,
        /// Time between two pieces.
        #[arg(long, default_value_t = 1)]
        gap_ms: u64,
        #[command(flatten)]
        wire: Wire,
    },
    /// Wire: only the beginning of what was sent at once arrives.
    Truncate {
        /// How many bytes are left.
        #[arg(long)]
        keep: usize,
        #[command(flatten)]
        wire: Wire,
    },
    /// Wire: bytes arrive changed.
    Corrupt {
        /// How many bytes of each piece.
        #[arg(long, default_value_t = 1)]
        bytes: usize,
        #[command(flatten)]
        wire: Wire,
    },
    /// Wire: nothing passes until the fault ends, and then everything.
    Stall(Wire),
    /// Wire: the peer is gone and nobody says so.
    HalfOpen(Wire),
    /// Wire: the connections are reset now.
    Reset(Wire),
    /// The controller hangs: no task runs, connections stay open and silent.
    Freeze(Span),
    /// A server tag answers HOST-144 to everything until the power is switched off and on.
    WedgeTag {
        /// S1 to S8.
        tag: String,
        #[command(flatten)]
        span: Span,
    },
    /// The power goes off, and on again after a time.
    PowerLoss {
        /// The battery was changed too late: variables in CMOS and registers are lost.
        #[arg(long)]
        lose_memory: bool,
        /// How long the power is off.
        #[arg(long, default_value_t = 0)]
        off_ms: u64,
    },
    /// The servos lose their power.
    ServoOff(Span),
    /// A tool frame is wrong.
    WrongToolFrame {
        /// x,y,z in mm and w,p,r in degrees.
        #[arg(value_name = "X,Y,Z,W,P,R", allow_hyphen_values = true)]
        frame: String,
        /// Number of the tool; the selected one if not given.
        #[arg(long)]
        tool: Option<i32>,
        #[command(flatten)]
        span: Span,
    },
    /// The controller was delivered without an option; it is switched off and on for that.
    OptionMissing {
        /// R632 (KAREL) or R648 (User Socket Messaging).
        #[arg(value_parser = ["R632", "R648"], ignore_case = true)]
        option: String,
        #[command(flatten)]
        span: Span,
    },
    /// Somebody turned the general override down, and holds it there.
    SlowOverride {
        /// The highest override that is reached.
        percent: i32,
        #[command(flatten)]
        span: Span,
    },
}

/// How long a fault lasts.
#[derive(Args, Clone, Debug)]
struct Span {
    /// For so many milliseconds; until it is cleared if not given.
    #[arg(long, value_name = "MS")]
    for_ms: Option<u64>,
}

/// Which bytes, how often, how long.
#[derive(Args, Clone, Debug)]
struct Wire {
    /// Only at this port, as the program names it.
    #[arg(long)]
    port: Option<u16>,
    /// Only at this server tag, S1 to S8.
    #[arg(long)]
    tag: Option<String>,
    /// Only this connection; they count from 1.
    #[arg(long)]
    connection: Option<u64>,
    /// Only to the program, or only from it.
    #[arg(long, value_enum, default_value_t = Way::Both)]
    direction: Way,
    /// Only the next so many pieces.
    #[arg(long, value_name = "N")]
    times: Option<u32>,
    #[command(flatten)]
    span: Span,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Way {
    In,
    Out,
    Both,
}

impl Fault {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let body = match &self.what {
            What::List { json } => {
                let list = self.panel.get("/api/v1/faults")?;
                if *json {
                    print_json(&list);
                } else {
                    show(&list);
                }
                return Ok(ExitCode::SUCCESS);
            }
            What::Clear { id: None } => {
                let cleared = self.panel.delete("/api/v1/faults")?;
                put(&format!("{} cleared\n", word(&cleared["cleared"])));
                return Ok(ExitCode::SUCCESS);
            }
            What::Clear { id: Some(id) } => {
                let _none = self.panel.delete(&format!("/api/v1/faults/{id}"))?;
                put("1 cleared\n");
                return Ok(ExitCode::SUCCESS);
            }
            What::Drop(wire) => wire.body(&json!("drop")),
            What::Delay {
                ms,
                jitter_ms,
                wire,
            } => wire.body(&json!({"delay": {"ms": ms, "jitter_ms": jitter_ms}})),
            What::Split {
                bytes,
                gap_ms,
                wire,
            } => wire.body(&json!({"split": {"bytes": bytes, "gap_ms": gap_ms}})),
            What::Truncate { keep, wire } => wire.body(&json!({"truncate": {"keep": keep}})),
            What::Corrupt { bytes, wire } => wire.body(&json!({"corrupt": {"bytes": bytes}})),
            What::Stall(wire) => wire.body(&json!("stall")),
            What::HalfOpen(wire) => wire.body(&json!("half_open")),
            What::Reset(wire) => wire.body(&json!("reset")),
            What::Freeze(span) => span.body(&json!("freeze")),
            What::WedgeTag { tag, span } => span.body(&json!({"wedge_tag": {"tag": tag}})),
            What::PowerLoss {
                lose_memory,
                off_ms,
            } => {
                let memory = if *lose_memory { "lost" } else { "kept" };
                json!({"fault": {"power_loss": {"memory": memory, "off_ms": off_ms}}})
            }
            What::ServoOff(span) => span.body(&json!("servo_off")),
            What::WrongToolFrame { frame, tool, span } => {
                let frame = frame_of(frame)?;
                span.body(&json!({"wrong_tool_frame": {"tool": tool, "frame": frame}}))
            }
            What::OptionMissing { option, span } => {
                let option = option.to_ascii_uppercase();
                span.body(&json!({"option_missing": {"option": option}}))
            }
            What::SlowOverride { percent, span } => {
                span.body(&json!({"slow_override": {"percent": percent}}))
            }
        };
        let answer = self.panel.post("/api/v1/faults", &body)?;
        put(&format!("fault {}\n", word(&answer["id"])));
        Ok(ExitCode::SUCCESS)
    }
}

impl Span {
    fn body(&self, fault: &Value) -> Value {
        let mut body = json!({"fault": fault});
        if let Some(ms) = self.for_ms {
            body["for_ms"] = json!(ms);
        }
        body
    }
}

impl Wire {
    fn body(&self, fault: &Value) -> Value {
        let mut body = self.span.body(fault);
        let mut scope = Map::new();
        let mut put = |key: &str, value: Option<Value>| {
            if let Some(value) = value {
                let _new = scope.insert(key.to_owned(), value);
            }
        };
        put("port", self.port.map(|port| json!(port)));
        put("tag", self.tag.as_ref().map(|tag| json!(tag)));
        put("connection", self.connection.map(|number| json!(number)));
        let direction = match self.direction {
            Way::In => "in",
            Way::Out => "out",
            Way::Both => "both",
        };
        put("direction", Some(json!(direction)));
        body["scope"] = Value::Object(scope);
        if let Some(times) = self.times {
            body["times"] = json!(times);
        }
        body
    }
}

fn frame_of(text: &str) -> anyhow::Result<Value> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>())
        .collect::<Result<_, _>>()
        .map_err(|error| anyhow::anyhow!("{text:?}: {error}"))?;
    let [x, y, z, w, p, r] = <[f64; 6]>::try_from(parts)
        .map_err(|_| anyhow::anyhow!("{text:?} are not six numbers, separated by commas"))?;
    Ok(json!({"x_mm": x, "y_mm": y, "z_mm": z, "w_deg": w, "p_deg": p, "r_deg": r}))
}

fn show(list: &Value) {
    let faults = list["faults"].as_array().map_or(&[][..], Vec::as_slice);
    if faults.is_empty() {
        put("No fault is active.\n");
    }
    for fault in faults {
        put(&format!("{}\n", in_words(fault)));
    }
}

/// A fault on one line.
pub(crate) fn in_words(fault: &Value) -> String {
    let mut parts = vec![format!("{:>3}", word(&fault["id"])), word(&fault["fault"])];
    let scope = &fault["scope"];
    for key in ["port", "tag", "connection"] {
        if !scope[key].is_null() {
            parts.push(format!("{key} {}", word(&scope[key])));
        }
    }
    if let Some(way @ ("in" | "out")) = scope["direction"].as_str() {
        parts.push(way.to_owned());
    }
    if !fault["times_left"].is_null() {
        parts.push(format!("{} times left", word(&fault["times_left"])));
    }
    if let Some(until) = fault["until_s"].as_f64() {
        parts.push(format!("until {until:.3} s"));
    }
    parts.push(format!("struck {}", word(&fault["struck"])));
    parts.join("  ")
}
