//! What a subcommand works with: the server, the robot that is meant, the form of the answer.

use std::path::Path;
use std::time::Duration;

use api::{AcquireBody, CellSummary, ControlToken, Station};
use client::{Client, EmulatorClient, HeldControl, Robot, Timeouts};
use serde::Serialize;
use uuid::Uuid;

use crate::cli::Global;
use crate::credentials;
use crate::failure::Failure;
use crate::report::{Exit, Report};

/// The options that every subcommand shares, made ready for use.
#[derive(Debug)]
pub(crate) struct Context {
    /// All requests of one run of `cellctl` carry one request id.
    pub(crate) client: Client,
    server: String,
    global: Global,
}

/// Where the server of a demo listens.
const USUAL_SERVER: &str = "http://127.0.0.1:8080";

impl Context {
    /// With the token there is for the server, where one is wanted.
    pub(crate) fn new(global: Global, wants_token: bool) -> Result<Self, Failure> {
        let server = global.server.as_deref().unwrap_or(USUAL_SERVER).to_owned();
        let mut client = Client::with_timeouts(&server, timeouts(&global))?
            .with_request_id(&Uuid::now_v7().to_string())?;
        if wants_token
            && let Some(token) = credentials::token_for(&server, global.token_file.as_deref())?
        {
            client = client.with_token(&token)?;
        }
        Ok(Self {
            client,
            server,
            global,
        })
    }

    /// The panel of the virtual controller.
    pub(crate) fn emulator(&self) -> Result<EmulatorClient, Failure> {
        let emulator =
            EmulatorClient::with_timeouts(&self.global.emulator, timeouts(&self.global))?;
        Ok(emulator)
    }

    /// The robot that is meant: the one named, or the only one there is.
    pub(crate) async fn robot(&self) -> Result<Robot, Failure> {
        if let (Some(cell), Some(robot)) = (&self.global.cell, &self.global.robot) {
            return Ok(self.client.robot(cell, robot));
        }
        let cells = match &self.global.cell {
            Some(cell) => vec![self.client.cell(cell).await?],
            None => self.client.cells().await?,
        };
        let (cell, robot) = only_robot(&cells, self.global.robot.as_deref())?;
        Ok(self.client.robot(cell, robot))
    }

    /// The cell that is meant: the one named, or the only one there is.
    pub(crate) async fn cell(&self) -> Result<String, Failure> {
        if let Some(cell) = &self.global.cell {
            return Ok(cell.clone());
        }
        let cells = self.client.cells().await?;
        match cells.as_slice() {
            [only] => Ok(only.id.clone()),
            several => Err(Failure::Which {
                why: format!("the server has {} cells", several.len()),
                all: several
                    .iter()
                    .map(|cell| format!("--cell {}", cell.id))
                    .collect(),
            }),
        }
    }

    /// Whether a program reads the answers.
    pub(crate) fn json(&self) -> bool {
        self.global.json
    }

    /// The server's address, as it was given.
    pub(crate) fn server(&self) -> &str {
        &self.server
    }

    /// Whether somebody said which server.
    pub(crate) fn names_a_server(&self) -> bool {
        self.global.server.is_some()
    }

    pub(crate) fn token_file(&self) -> Option<&Path> {
        self.global.token_file.as_deref()
    }

    /// Takes control of a robot's cell, or uses what was taken before.
    pub(crate) async fn control_of(
        &self,
        robot: &Robot,
        token: Option<ControlToken>,
        reason: &str,
    ) -> Result<(Robot, Option<HeldControl>), Failure> {
        let held = if token.is_none() {
            let body = AcquireBody {
                station: Station::Remote,
                ttl_s: None,
                loss_behavior: None,
                reason: reason.to_owned(),
                preempt: false,
            };
            Some(self.client.control(robot.cell()).hold(&body).await?)
        } else {
            None
        };
        let token = token.or(held.as_ref().map(HeldControl::token));
        let client = token.map(|token| self.client.with_control(token));
        let client = client.as_ref().unwrap_or(&self.client);
        Ok((client.robot(robot.cell(), robot.id()), held))
    }

    /// An answer, as JSON or as text for people.
    pub(crate) fn report<T: Serialize>(
        &self,
        exit: Exit,
        body: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Report {
        if self.global.json {
            Report::json(exit, body)
        } else {
            Report::text(exit, &text(body))
        }
    }
}

fn timeouts(global: &Global) -> Timeouts {
    match global.timeout_ms.map(Duration::from_millis) {
        Some(timeout) => Timeouts {
            connect: timeout.min(Timeouts::default().connect),
            question: timeout,
            command: timeout,
        },
        None => Timeouts::default(),
    }
}

/// Cell and id of the robot called `wanted`, or of the only robot.
fn only_robot<'a>(
    cells: &'a [CellSummary],
    wanted: Option<&str>,
) -> Result<(&'a str, &'a str), Failure> {
    let robots = || {
        cells.iter().flat_map(|cell| {
            let ids = cell.robots.iter().map(|robot| robot.id.as_str());
            ids.map(|id| (cell.id.as_str(), id))
        })
    };
    let mut candidates = robots().filter(|(_, id)| wanted.is_none_or(|wanted| wanted == *id));
    match (candidates.next(), candidates.next()) {
        (Some(only), None) => Ok(only),
        (first, _) => {
            let all: Vec<String> = robots()
                .map(|(cell, id)| format!("--cell {cell} --robot {id}"))
                .collect();
            let why = match (first, wanted) {
                (None, Some(wanted)) => format!("there is no robot `{wanted}`"),
                (None, None) => "the server has no robot".to_owned(),
                (Some(_), _) => "more than one robot could be meant".to_owned(),
            };
            Err(Failure::Which { why, all })
        }
    }
}

#[cfg(test)]
mod tests {
    use api::{RobotSummary, Tier};

    use super::*;

    fn cell(id: &str, robots: &[&str]) -> CellSummary {
        let robots = robots.iter().map(|id| RobotSummary {
            id: (*id).to_owned(),
            name: String::new(),
            model: String::new(),
            tier: Tier::Seed,
        });
        CellSummary {
            id: id.to_owned(),
            name: String::new(),
            robots: robots.collect(),
        }
    }

    #[test]
    fn the_only_robot_needs_no_name() {
        let cells = [cell("empty", &[]), cell("demo", &["r1"])];
        assert_eq!(only_robot(&cells, None).unwrap(), ("demo", "r1"));
    }

    #[test]
    fn a_robot_is_never_guessed() {
        let cells = [cell("a", &["r1", "r2"]), cell("b", &["r1"])];
        for wanted in [None, Some("r1"), Some("r9")] {
            let Err(Failure::Which { all, .. }) = only_robot(&cells, wanted) else {
                panic!("{wanted:?} was guessed");
            };
            assert_eq!(all.len(), 3);
        }
        assert_eq!(only_robot(&cells, Some("r2")).unwrap(), ("a", "r2"));
    }
}
