use std::collections::HashSet;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use thiserror::Error;

use crate::identity::Identity;

use super::{CellPlan, CellSection, ServerSection};
use crate::setup::{SetupBook, StoreError};
use crate::simulation::JobSimulator;

/// The longest deadline a command may have, in milliseconds: its own `deadline_ms` or the robot's.
pub(crate) const MAX_DEADLINE_MS: u64 = 60_000;

/// A checked configuration: what the server runs on.
#[derive(Clone, Debug)]
pub struct Plan {
    pub(crate) server: ServerPlan,
    pub(crate) cells: Vec<CellPlan>,
    /// Indices of the cell and of the robot the seed's own routes drive.
    pub(crate) legacy: (usize, usize),
    /// Who callers are; a server does not start without.
    pub(crate) identity: Option<Identity>,
    /// What plays jobs in virtual time, if anything does.
    pub(crate) simulator: Option<Arc<dyn JobSimulator>>,
}

/// The listener and its limits, checked.
#[derive(Clone, Debug)]
pub struct ServerPlan {
    /// Where to listen.
    pub listen: SocketAddr,
    pub(crate) allowed_hosts: Vec<String>,
    pub(crate) max_body_bytes: usize,
    pub(crate) header_timeout: Duration,
    pub(crate) idle_timeout: Duration,
    pub(crate) body_timeout: Duration,
    pub(crate) write_timeout: Duration,
    pub(crate) request_timeout: Duration,
    pub(crate) shutdown_timeout: Duration,
    pub(crate) max_connections: usize,
    pub(crate) max_waiting_per_address: usize,
    pub(crate) max_event_streams: usize,
}

impl Plan {
    /// Checks the sections of a configuration file.
    ///
    /// # Errors
    /// The first key whose value does not fit, by its path in the file, with the value and the limit.
    pub fn try_new(server: &ServerSection, cells: &[CellSection]) -> Result<Self, ConfigError> {
        let mut ids = HashSet::new();
        let mut checked = Vec::with_capacity(cells.len());
        for (index, cell) in cells.iter().enumerate() {
            let key = format!("cells[{index}]");
            if !ids.insert(cell.id.as_str()) {
                return Err(ConfigError::new(
                    format!("{key}.id"),
                    format!("`{}` is the id of an earlier cell", cell.id),
                ));
            }
            checked.push(CellPlan::try_new(&key, cell)?);
        }
        let legacy = legacy_robot(server.legacy_robot.as_deref(), &checked)?;
        Ok(Self {
            server: ServerPlan::try_new(server)?,
            cells: checked,
            legacy,
            identity: server.demo.then(Identity::demo),
            simulator: None,
        })
    }

    /// Gives the server the tokens its callers must have.
    ///
    /// # Errors
    /// The plan is one of a demo: `server.demo` and tokens exclude one another.
    pub fn with_identity(mut self, identity: Identity) -> Result<Self, ConfigError> {
        if self.identity.as_ref().is_some_and(Identity::is_demo) && !identity.is_demo() {
            let problem =
                "is true, and there is an [identity] section; only one of the two can hold";
            return Err(ConfigError::new("server.demo", problem.to_owned()));
        }
        self.identity = Some(identity);
        Ok(self)
    }

    /// Gives the server what plays jobs in virtual time. Without it, it says that it cannot.
    #[must_use]
    pub fn with_simulator(mut self, simulator: Arc<dyn JobSimulator>) -> Self {
        self.simulator = Some(simulator);
        self
    }

    /// Reads the set-up of every cell and checks it, and keeps nothing of it: for a check before the start.
    ///
    /// # Errors
    /// The first set-up that cannot be read or does not fit its cell; with everything wrong with it.
    pub fn check_setups(&self) -> Result<(), StoreError> {
        for cell in &self.cells {
            let robots = cell.robots.iter().cloned().map(Arc::new).collect();
            let _book = SetupBook::open(cell.setup.as_ref(), robots)?;
        }
        Ok(())
    }

    /// The listener and its limits.
    #[must_use]
    pub fn server(&self) -> &ServerPlan {
        &self.server
    }
}

impl ServerPlan {
    fn try_new(section: &ServerSection) -> Result<Self, ConfigError> {
        let listen: SocketAddr = section.listen.parse().map_err(|_| {
            ConfigError::new(
                "server.listen",
                format!(
                    "`{}` is not `address:port` with a numeric address",
                    section.listen
                ),
            )
        })?;
        if !listen.ip().is_loopback() && section.demo {
            return Err(ConfigError::new(
                "server.listen",
                format!(
                    "other machines reach {listen}, and in demo mode everybody may do everything; a demo listens on a loopback address"
                ),
            ));
        }
        if !listen.ip().is_loopback() && !section.allow_remote {
            return Err(ConfigError::new(
                "server.listen",
                format!(
                    "other machines reach {listen}, and tokens would pass in clear text; end TLS in front of the server, and permit it with `allow_remote = true`"
                ),
            ));
        }
        let millis = |name: &str, value, min, max| {
            in_range(&format!("server.{name}"), value, min, max).map(Duration::from_millis)
        };
        let body_timeout = millis("body_timeout_ms", section.body_timeout_ms, 1, 60_000)?;
        Ok(Self {
            listen,
            allowed_hosts: section.allowed_hosts.clone(),
            max_body_bytes: count(
                "server.max_body_bytes",
                section.max_body_bytes,
                1_024,
                1 << 20,
            )?,
            header_timeout: millis("header_timeout_ms", section.header_timeout_ms, 1, 60_000)?,
            idle_timeout: millis("idle_timeout_ms", section.idle_timeout_ms, 1, 600_000)?,
            body_timeout,
            write_timeout: millis("write_timeout_ms", section.write_timeout_ms, 1, 60_000)?,
            // Longer than anything a handler waits for on its own, so that it only ends what is stuck.
            request_timeout: millis(
                "request_timeout_ms",
                section.request_timeout_ms,
                MAX_DEADLINE_MS + section.body_timeout_ms + 1_000,
                600_000,
            )?,
            shutdown_timeout: millis(
                "shutdown_timeout_ms",
                section.shutdown_timeout_ms,
                1,
                60_000,
            )?,
            max_connections: count("server.max_connections", section.max_connections, 1, 10_000)?,
            max_waiting_per_address: count(
                "server.max_waiting_per_address",
                section.max_waiting_per_address,
                1,
                10_000,
            )?,
            max_event_streams: count(
                "server.max_event_streams",
                section.max_event_streams,
                0,
                10_000,
            )?,
        })
    }
}

fn legacy_robot(name: Option<&str>, cells: &[CellPlan]) -> Result<(usize, usize), ConfigError> {
    let robots = || {
        cells.iter().enumerate().flat_map(|(at, cell)| {
            cell.robots
                .iter()
                .enumerate()
                .map(move |(robot_at, robot)| ((at, robot_at), format!("{}/{}", cell.id, robot.id)))
        })
    };
    let known = || {
        robots()
            .map(|(_, known)| known)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let key = "server.legacy_robot";
    match name {
        Some(name) => robots()
            .find(|(_, known)| known == name)
            .map(|(at, _)| at)
            .ok_or_else(|| {
                ConfigError::new(key, format!("`{name}` is none of the robots: {}", known()))
            }),
        None => match (robots().next(), robots().nth(1)) {
            (Some((at, _)), None) => Ok(at),
            (Some(_), Some(_)) => Err(ConfigError::new(
                key,
                format!("is absent, and there are several robots: {}", known()),
            )),
            (None, _) => Err(ConfigError::new("cells", "there is no robot".to_owned())),
        },
    }
}

/// A key of the configuration whose value does not fit.
#[derive(Clone, Debug, Eq, Error, PartialEq)]
#[error("{key}: {problem}")]
pub struct ConfigError {
    key: String,
    problem: String,
}

impl ConfigError {
    pub(super) fn new(key: impl Into<String>, problem: String) -> Self {
        Self {
            key: key.into(),
            problem,
        }
    }

    /// The key's path in the file, e.g. `cells[0].robots[1].queue_capacity`.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }
}

/// The value, or an error that names the key, the value and the limit it breaks.
pub(super) fn in_range(key: &str, value: u64, min: u64, max: u64) -> Result<u64, ConfigError> {
    if value < min {
        return Err(ConfigError::new(key, format!("{value} is below {min}")));
    }
    if value > max {
        return Err(ConfigError::new(key, format!("{value} is above {max}")));
    }
    Ok(value)
}

pub(super) fn count(key: &str, value: u64, min: u64, max: u64) -> Result<usize, ConfigError> {
    let value = in_range(key, value, min, max)?;
    usize::try_from(value)
        .map_err(|_| ConfigError::new(key, format!("{value} does not fit this machine")))
}

pub(super) fn id(key: &str, id: &str) -> Result<String, ConfigError> {
    let letter = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
    let legal = id.len() <= 64
        && id.bytes().next().is_some_and(letter)
        && id
            .bytes()
            .all(|byte| letter(byte) || byte == b'_' || byte == b'-');
    if legal {
        Ok(id.to_owned())
    } else {
        Err(ConfigError::new(
            key,
            format!("`{id}` does not match [a-z0-9][a-z0-9_-]{{0,63}}"),
        ))
    }
}
