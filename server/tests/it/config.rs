//! The configuration: what is refused names its key, value and limit.

use serde::Deserialize;
use server::config::{CellSection, ServerSection};
use server::{ConfigError, Plan};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    server: ServerSection,
    #[serde(default)]
    cells: Vec<CellSection>,
}

const TWO_ROBOTS: &str = r#"
[server]
listen = "127.0.0.1:8080"
legacy_robot = "c1/r2"

[[cells]]
id = "c1"
name = "Cell one"

[[cells.robots]]
id = "r1"
model = "fanuc-m20ia"
controller = "127.0.0.1:59002"

[[cells.robots]]
id = "r2"
name = "The other"
model = "fanuc-m20ia"
controller = "robot-2.plant.example:59002"
tier = "seed"
configuration = "N U T, 0, 0, 0"
max_speed_mm_s = 500
queue_capacity = 4
tool = { z_mm = 120 }
"#;

fn plan(text: &str) -> Result<Plan, ConfigError> {
    let file: File = toml::from_str(text).unwrap();
    Plan::try_new(&file.server, &file.cells)
}

#[test]
fn a_configuration_that_fits_is_taken() {
    let plan = plan(TWO_ROBOTS).unwrap();
    assert_eq!(plan.server().listen.to_string(), "127.0.0.1:8080");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn a_value_that_does_not_fit_is_named_by_its_key_with_its_limit() {
    let cases = [
        (
            "queue_capacity = 4",
            "queue_capacity = 0",
            "cells[0].robots[1].queue_capacity: 0 is below 1",
        ),
        (
            "queue_capacity = 4",
            "queue_capacity = 1001",
            "cells[0].robots[1].queue_capacity: 1001 is above 1000",
        ),
        (
            "max_speed_mm_s = 500",
            "max_speed_mm_s = 2000",
            "cells[0].robots[1].max_speed_mm_s: 2000 is above 1999",
        ),
        (
            "max_speed_mm_s = 500",
            "deadline_ms = 60001",
            "cells[0].robots[1].deadline_ms: 60001 is above 60000",
        ),
        (
            "max_speed_mm_s = 500",
            "connect_timeout_ms = 0",
            "cells[0].robots[1].connect_timeout_ms: 0 is below 1",
        ),
        (
            "id = \"r2\"",
            "id = \"r1\"",
            "cells[0].robots[1].id: `r1` is the id of an earlier robot of the cell",
        ),
        (
            "id = \"r2\"",
            "id = \"R 2\"",
            "cells[0].robots[1].id: `R 2` does not match [a-z0-9][a-z0-9_-]{0,63}",
        ),
        ("id = \"c1\"", "id = \"\"", "cells[0].id: `` does not match"),
        (
            "robot-2.plant.example:59002",
            "robot-2",
            "cells[0].robots[1].controller: `robot-2` is not `host:port`",
        ),
        (
            "N U T, 0, 0, 0",
            "X U T",
            "cells[0].robots[1].configuration: ",
        ),
        ("z_mm = 120", "z_mm = 1e12", "cells[0].robots[1].tool: "),
        ("z_mm = 120", "z_mm = nan", "cells[0].robots[1].tool: "),
        (
            "tier = \"seed\"",
            "tier = \"seed_status\"\nstatus_controller = \"robot-2\"",
            "cells[0].robots[1].status_controller: `robot-2` is not `host:port`",
        ),
        (
            "tier = \"seed\"",
            "tier = \"seed\"\nstatus_controller = \"robot-2:59003\"",
            "cells[0].robots[1].status_controller: a controller of tier `seed` has no",
        ),
        (
            "tier = \"seed\"",
            "tier = \"cell_server\"\nstatus_controller = \"robot-2\"",
            "cells[0].robots[1].status_controller: `robot-2` is not `host:port`",
        ),
        (
            "robot-2.plant.example:59002\"\ntier = \"seed\"",
            "robot-2.plant.example:65535\"\ntier = \"cell_server\"",
            "cells[0].robots[1].status_controller: is absent, and there is no port after",
        ),
        (
            "max_speed_mm_s = 500",
            "position_tolerance_mm = 0",
            "cells[0].robots[1].position_tolerance_mm: 0 is not a number of 0.001 to 100",
        ),
        (
            "max_speed_mm_s = 500",
            "rotation_tolerance_deg = nan",
            "cells[0].robots[1].rotation_tolerance_deg: NaN is not a number of 0.001 to 45",
        ),
        (
            "max_speed_mm_s = 500",
            "time_scale = 1e9",
            "cells[0].robots[1].time_scale: 1000000000 is not a number of 0.01 to 1000",
        ),
        (
            "127.0.0.1:8080",
            "localhost",
            "server.listen: `localhost` is not `address:port`",
        ),
        (
            "127.0.0.1:8080",
            "0.0.0.0:8080",
            "server.listen: other machines reach 0.0.0.0:8080",
        ),
        (
            "c1/r2",
            "c1/r3",
            "server.legacy_robot: `c1/r3` is none of the robots: c1/r1, c1/r2",
        ),
        (
            "legacy_robot = \"c1/r2\"",
            "",
            "server.legacy_robot: is absent, and there are several robots: c1/r1, c1/r2",
        ),
        ("legacy_robot = \"c1/r2\"", "max_body_bytes = 10", "server."),
        (
            "legacy_robot = \"c1/r2\"",
            "legacy_robot = \"c1/r2\"\nrequest_timeout_ms = 1000",
            "server.request_timeout_ms: 1000 is below 71000",
        ),
    ];
    for (good, bad, message) in cases {
        let text = TWO_ROBOTS.replacen(good, bad, 1);
        assert_ne!(text, TWO_ROBOTS, "{good}");
        let error = plan(&text).unwrap_err();
        assert!(error.to_string().starts_with(message), "{error}");
        assert!(message.starts_with(error.key()) || error.key().starts_with("server."));
    }
}

#[test]
fn a_model_that_is_unknown_is_answered_with_those_that_are() {
    let text = TWO_ROBOTS.replacen("fanuc-m20ia", "acme-1", 1);
    let error = plan(&text).unwrap_err();
    assert_eq!(error.key(), "cells[0].robots[0].model");
    assert!(error.to_string().contains("fanuc-m20ia"), "{error}");
}

#[test]
fn an_unknown_key_is_refused() {
    for line in ["speed = 5", "port = 1"] {
        let text = TWO_ROBOTS.replacen("queue_capacity = 4", line, 1);
        let error = toml::from_str::<File>(&text).unwrap_err();
        assert!(error.to_string().contains("unknown field"), "{error}");
    }
}

#[test]
fn a_cell_without_a_robot_cannot_serve() {
    let error = plan("").unwrap_err();
    assert_eq!(error.to_string(), "cells: there is no robot");
}
