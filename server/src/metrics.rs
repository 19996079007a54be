//! Counters and histograms of one server, in the Prometheus text format.
//!
//! The recorder belongs to the server, not to the process: two servers in one test do not share their counts. Its
//! handles are taken once, at start, so that counting on the path of a command is an atomic addition, without a
//! lookup by labels. Labels come from fixed sets: routes of the router, methods, statuses, robots of the
//! configuration, outcomes of the link.

use std::collections::HashMap;
use std::fmt;
use std::sync::{PoisonError, RwLock};
use std::time::Duration;

use api::LinkState;
use axum::http::{Method, StatusCode};
use metrics::{
    Counter, Gauge, Histogram, Key, KeyName, Label, Level, Metadata, Recorder as _, Unit,
};
use metrics_exporter_prometheus::{
    BuildError, Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};
use protocol::Reply;

use crate::config::RobotPlan;
use crate::link::cell_server::MotionEnd;
use crate::link::{LinkError, cell_server};

const HTTP_REQUESTS: &str = "robocell_http_requests_total";
const HTTP_SECONDS: &str = "robocell_http_request_duration_seconds";
const LINK_COMMANDS: &str = "robocell_link_commands_total";
const LINK_CONNECT_SECONDS: &str = "robocell_link_connect_duration_seconds";
const LINK_REPLY_SECONDS: &str = "robocell_link_reply_duration_seconds";
const LINK_QUEUED: &str = "robocell_link_queued_commands";
const TASKS: &str = "robocell_tasks";
const CONTROLLER_STATE: &str = "cell_controller_link_state";
const CONTROLLER_RTT: &str = "cell_controller_rtt_seconds";

/// Bounds of the histograms in seconds: from a local exchange to a command at its deadline.
const BUCKETS: [f64; 12] = [
    0.000_1, 0.000_25, 0.000_5, 0.001, 0.002_5, 0.005, 0.01, 0.05, 0.25, 1.0, 5.0, 30.0,
];

const METADATA: Metadata<'static> = Metadata::new(module_path!(), Level::INFO, None);

/// The counts of one server.
pub(crate) struct Metrics {
    recorder: PrometheusRecorder,
    handle: PrometheusHandle,
    routes: HashMap<String, RouteCounts>,
    /// Requests whose path is none of the routes.
    elsewhere: RouteCounts,
}

/// The counts of one route.
struct RouteCounts {
    label: String,
    seen: RwLock<HashMap<Kind, (Counter, Histogram)>>,
}

/// What tells the requests of a route apart: the method's label and the status.
type Kind = (&'static str, StatusCode);

impl Metrics {
    /// Counters for the given routes, as templates: `/api/v1/cells/{cell}`.
    pub(crate) fn new(routes: impl Iterator<Item = String>) -> Result<Self, BuildError> {
        let seconds = Matcher::Suffix("_seconds".to_owned());
        let recorder = PrometheusBuilder::new()
            .set_buckets_for_metric(seconds, &BUCKETS)?
            .build_recorder();
        describe(&recorder);
        Ok(Self {
            handle: recorder.handle(),
            recorder,
            routes: routes
                .map(|route| (route.clone(), RouteCounts::new(route)))
                .collect(),
            elsewhere: RouteCounts::new("other".to_owned()),
        })
    }

    /// Counts an answered request.
    pub(crate) fn request(
        &self,
        route: Option<&str>,
        method: &Method,
        status: StatusCode,
        took: Duration,
    ) {
        let counts = route
            .and_then(|route| self.routes.get(route))
            .unwrap_or(&self.elsewhere);
        let key = (method_label(method), status);
        let read = counts.seen.read().unwrap_or_else(PoisonError::into_inner);
        if let Some((requests, seconds)) = read.get(&key) {
            requests.increment(1);
            seconds.record(took.as_secs_f64());
            return;
        }
        drop(read);
        let labels = vec![
            Label::new("route", counts.label.clone()),
            Label::from_static_parts("method", key.0),
        ];
        let seconds = self.histogram(HTTP_SECONDS, labels.clone());
        let mut labels = labels;
        labels.push(Label::new("status", status.as_str().to_owned()));
        let requests = self.counter(HTTP_REQUESTS, labels);
        requests.increment(1);
        seconds.record(took.as_secs_f64());
        let mut write = counts.seen.write().unwrap_or_else(PoisonError::into_inner);
        // Another thread may have put the same handles there; they count into the same place.
        drop(write.insert(key, (requests, seconds)));
    }

    /// The counts of a robot's link.
    pub(crate) fn link(&self, plan: &RobotPlan) -> LinkMetrics {
        let labels = || {
            vec![
                Label::new("cell", plan.cell.clone()),
                Label::new("robot", plan.id.clone()),
            ]
        };
        let outcome = |outcome| {
            let mut labels = labels();
            labels.push(Label::from_static_parts("outcome", outcome));
            self.counter(LINK_COMMANDS, labels)
        };
        LinkMetrics {
            accepted: outcome("accepted"),
            rejected: outcome("rejected"),
            failed: LinkError::METRIC_LABELS.map(|label| (label, outcome(label))),
            connect: self.histogram(LINK_CONNECT_SECONDS, labels()),
            reply: self.histogram(LINK_REPLY_SECONDS, labels()),
            queued: self
                .recorder
                .register_gauge(&Key::from_parts(LINK_QUEUED, labels()), &METADATA),
        }
    }

    /// The counts of the link to a robot's `cell_server` controller.
    pub(crate) fn controller_link(&self, plan: &RobotPlan) -> ControllerMetrics {
        let labels = || {
            vec![
                Label::new("cell", plan.cell.clone()),
                Label::new("robot", plan.id.clone()),
            ]
        };
        let outcome = |outcome| {
            let mut labels = labels();
            labels.push(Label::from_static_parts("outcome", outcome));
            self.counter(LINK_COMMANDS, labels)
        };
        let gauge = |name: &'static str| {
            let key = Key::from_parts(name, labels());
            self.recorder.register_gauge(&key, &METADATA)
        };
        ControllerMetrics {
            ended: ["arrived", "rejected", "interrupted"].map(|label| (label, outcome(label))),
            failed: cell_server::LinkError::METRIC_LABELS.map(|label| (label, outcome(label))),
            connect: self.histogram(LINK_CONNECT_SECONDS, labels()),
            reply: self.histogram(LINK_REPLY_SECONDS, labels()),
            round_trip: self.histogram(CONTROLLER_RTT, labels()),
            queued: gauge(LINK_QUEUED),
            state: gauge(CONTROLLER_STATE),
        }
    }

    /// How many tasks there are now.
    pub(crate) fn tasks(&self, count: usize) {
        let key = Key::from_static_name(TASKS);
        #[expect(clippy::cast_precision_loss, reason = "a count of tasks")]
        self.recorder
            .register_gauge(&key, &METADATA)
            .set(count as f64);
    }

    /// All counts in the text format.
    pub(crate) fn render(&self) -> String {
        self.handle.render()
    }

    /// Moves the recorded durations into their buckets. Until then each takes memory, so this runs every few
    /// seconds whether anybody reads the metrics or not.
    pub(crate) fn upkeep(&self) {
        self.handle.run_upkeep();
    }

    fn counter(&self, name: &'static str, labels: Vec<Label>) -> Counter {
        let key = Key::from_parts(name, labels);
        self.recorder.register_counter(&key, &METADATA)
    }

    fn histogram(&self, name: &'static str, labels: Vec<Label>) -> Histogram {
        let key = Key::from_parts(name, labels);
        self.recorder.register_histogram(&key, &METADATA)
    }
}

impl RouteCounts {
    fn new(label: String) -> Self {
        Self {
            label,
            seen: RwLock::new(HashMap::new()),
        }
    }
}

impl fmt::Debug for Metrics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Metrics")
            .field("routes", &self.routes.len())
            .finish_non_exhaustive()
    }
}

fn describe(recorder: &PrometheusRecorder) {
    let counter = |name: &'static str, unit, text: &'static str| {
        recorder.describe_counter(KeyName::from_const_str(name), unit, text.into());
    };
    let seconds = |name: &'static str, text: &'static str| {
        let unit = Some(Unit::Seconds);
        recorder.describe_histogram(KeyName::from_const_str(name), unit, text.into());
    };
    counter(HTTP_REQUESTS, None, "Requests answered.");
    counter(
        LINK_COMMANDS,
        None,
        "Commands to controllers, by what became of them.",
    );
    seconds(HTTP_SECONDS, "From the head of a request to its answer.");
    seconds(LINK_CONNECT_SECONDS, "Connecting to a controller.");
    seconds(
        LINK_REPLY_SECONDS,
        "From the command to the controller's reply.",
    );
    seconds(
        CONTROLLER_RTT,
        "From a line on a controller's status port to its answer.",
    );
    recorder.describe_gauge(
        KeyName::from_const_str(LINK_QUEUED),
        None,
        "Commands waiting for a controller's link.".into(),
    );
    recorder.describe_gauge(
        KeyName::from_const_str(TASKS),
        None,
        "Tasks of the server that are not over: one for each link, connection and stream, and a few of its own.".into(),
    );
    recorder.describe_gauge(
        KeyName::from_const_str(CONTROLLER_STATE),
        None,
        "The state of a controller's link: 0 disconnected, 1 connecting, 2 degraded, 3 monitor, 4 control.".into(),
    );
}

/// The label of a method; what is none of HTTP's own shares one, so that a caller cannot make labels.
fn method_label(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::DELETE => "DELETE",
        Method::HEAD => "HEAD",
        Method::OPTIONS => "OPTIONS",
        Method::PATCH => "PATCH",
        _ => "other",
    }
}

/// The counts of one robot's link.
#[derive(Clone, Debug)]
pub(crate) struct LinkMetrics {
    accepted: Counter,
    rejected: Counter,
    failed: [(&'static str, Counter); LinkError::METRIC_LABELS.len()],
    connect: Histogram,
    reply: Histogram,
    queued: Gauge,
}

impl LinkMetrics {
    pub(crate) fn connected(&self, took: Duration) {
        self.connect.record(took.as_secs_f64());
    }

    pub(crate) fn replied(&self, took: Duration) {
        self.reply.record(took.as_secs_f64());
    }

    pub(crate) fn reply(&self, reply: Reply) {
        match reply {
            Reply::Accepted => self.accepted.increment(1),
            Reply::Unreachable | Reply::IncorrectInput => self.rejected.increment(1),
        }
    }

    pub(crate) fn failure(&self, error: &LinkError) {
        let label = error.metric_label();
        if let Some((_, counter)) = self.failed.iter().find(|(known, _)| *known == label) {
            counter.increment(1);
        }
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "a queue holds a thousand at most"
    )]
    pub(crate) fn queued(&self, depth: usize) {
        self.queued.set(depth as f64);
    }
}

/// The counts of the link to one robot's `cell_server` controller.
#[derive(Clone, Debug)]
pub(crate) struct ControllerMetrics {
    ended: [(&'static str, Counter); 3],
    failed: [(&'static str, Counter); cell_server::LinkError::METRIC_LABELS.len()],
    connect: Histogram,
    reply: Histogram,
    round_trip: Histogram,
    queued: Gauge,
    state: Gauge,
}

impl ControllerMetrics {
    /// From a command's turn to the controller's greeting.
    pub(crate) fn connected(&self, took: Duration) {
        self.connect.record(took.as_secs_f64());
    }

    /// From the command to the controller's acceptance.
    pub(crate) fn replied(&self, took: Duration) {
        self.reply.record(took.as_secs_f64());
    }

    /// From a line on the status port to its answer.
    pub(crate) fn round_trip(&self, took: Duration) {
        self.round_trip.record(took.as_secs_f64());
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "a queue holds a thousand at most"
    )]
    pub(crate) fn queued(&self, depth: usize) {
        self.queued.set(depth as f64);
    }

    pub(crate) fn state(&self, state: LinkState) {
        self.state.set(match state {
            LinkState::Disconnected
            | LinkState::Untried
            | LinkState::Busy
            | LinkState::Answering => 0.0,
            LinkState::Connecting => 1.0,
            LinkState::Degraded => 2.0,
            LinkState::Monitor => 3.0,
            LinkState::Control => 4.0,
        });
    }

    pub(crate) fn ended(&self, end: &MotionEnd) {
        let label = match end {
            MotionEnd::Arrived { .. } => "arrived",
            MotionEnd::Rejected { .. } => "rejected",
            MotionEnd::Interrupted { .. } => "interrupted",
            MotionEnd::NotSent { error } | MotionEnd::InDoubt { error, .. } => error.metric_label(),
        };
        let counters = self.ended.iter().chain(&self.failed);
        for (_, counter) in counters.filter(|(known, _)| *known == label) {
            counter.increment(1);
        }
    }
}
