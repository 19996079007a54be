//! The configuration file: the server's sections and those of the virtual controllers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use karel_emulator::{ControllerGeneration, Fidelity};
use serde::Deserialize;
use server::config::{CellSection, IdentitySection, JournalSection, ServerSection, SetupSource};

/// Where a supervised server of the demo keeps its journal.
pub(crate) const JOURNAL: &str = "ROBOCELL_DEMO_JOURNAL";

/// What runs when no file is named.
const DEMO: &str = include_str!("../demo.toml");
/// The set-up that the demo begins with. It is kept in memory: each start is a fresh one.
const DEMO_SETUP: &str = include_str!("../demo.setup.toml");

/// The file as it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct File {
    /// `[server]`.
    #[serde(default)]
    pub(crate) server: ServerSection,
    /// `[identity]`.
    pub(crate) identity: Option<IdentitySection>,
    /// `[journal]`.
    #[serde(default)]
    pub(crate) journal: JournalSection,
    /// `[[cells]]`.
    #[serde(default)]
    pub(crate) cells: Vec<CellSection>,
    /// `[[virtual_controllers]]`.
    #[serde(default)]
    pub(crate) virtual_controllers: Vec<VirtualControllerSection>,
    /// `[[virtual_mobile_robots]]`.
    #[serde(default)]
    pub(crate) virtual_mobile_robots: Vec<VirtualMobileRobotSection>,
}

/// `[[virtual_mobile_robots]]`: a mobile robot that runs in this process.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VirtualMobileRobotSection {
    /// The cell it belongs to.
    pub(crate) cell: String,
    /// Its id in the cell's set-up, which says its slots, its outline and where it begins.
    pub(crate) id: String,
    /// How it drives, docks and fails: a file of `mobile-emulator`, relative to the configuration file.
    pub(crate) config: Option<PathBuf>,
    /// Where it stands at the start, in the cell frame; at its home where absent.
    pub(crate) start: Option<StartSection>,
    /// Where its page and state view listen, a loopback `address:port`; none where absent.
    pub(crate) view: Option<String>,
    /// Its token, in a file of its own; needed where the server asks for tokens.
    pub(crate) token_file: Option<PathBuf>,
    /// Its seconds in a second.
    #[serde(default = "real_time")]
    pub(crate) time_scale: f64,
}

/// Where a mobile robot stands at the start.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StartSection {
    pub(crate) x_mm: f64,
    pub(crate) y_mm: f64,
    pub(crate) heading_deg: f64,
}

/// The programs a virtual controller runs.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Runs {
    /// The thesis's socket server (tier `seed`).
    #[default]
    SockServer,
    /// The same with the status program beside it (tier `seed_status`).
    SeedStatus,
    /// This project's cell server (tier `cell_server`), with a gripper.
    CellServer,
}

/// `[[virtual_controllers]]`: a controller that runs in this process.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VirtualControllerSection {
    /// Its name; robots refer to it as `virtual:NAME`.
    pub(crate) name: String,
    /// The arm model.
    pub(crate) model: String,
    /// The programs of this project it runs, where `programs` names no others.
    #[serde(default)]
    pub(crate) runs: Runs,
    /// KAREL programs to load, relative to the configuration file; the first one runs.
    #[serde(default)]
    pub(crate) programs: Vec<PathBuf>,
    /// The program's port robots connect to.
    #[serde(default = "seed_port")]
    pub(crate) robot_port: u16,
    /// From a port as the program names it to a port of this machine, 0 for any free one.
    #[serde(default)]
    pub(crate) ports: BTreeMap<u16, u16>,
    /// Where its panel listens, a loopback `address:port`; no panel where absent.
    pub(crate) panel: Option<String>,
    /// What the panel lets its visitors do.
    #[serde(default)]
    pub(crate) panel_access: PanelAccess,
    /// Where the arm stands at power-on, pendant joints; the model's home where absent.
    pub(crate) start_joints_deg: Option<[f64; 6]>,
    /// Controller seconds in a second.
    #[serde(default = "real_time")]
    pub(crate) time_scale: f64,
    /// What happens to a second client while the first is served.
    #[serde(default)]
    pub(crate) second_client: SecondClientWord,
    /// `faithful`, as silent as a real one, or `kind`: it explains itself in its log and at its control interface.
    #[serde(default)]
    pub(crate) fidelity: Fidelity,
    /// `any`, `v7` (R-30iA, KAREL moves the arm) or `v9` (R-30iB Plus, only TP programs do).
    #[serde(default)]
    pub(crate) generation: ControllerGeneration,
}

/// What a panel lets its visitors do: whoever reaches its loopback address.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PanelAccess {
    /// Look.
    #[default]
    LookOnly,
    /// Operate the controller and break it on purpose, as `cellctl emulator` does.
    Control,
}

/// What happens to a second client.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum SecondClientWord {
    /// It waits for its turn.
    #[default]
    Backlog,
    /// It is refused.
    Refuse,
}

/// A file, and the folder its paths are relative to.
#[derive(Clone, Debug)]
pub(crate) struct Loaded {
    pub(crate) file: File,
    pub(crate) folder: PathBuf,
    /// What to call it in messages.
    pub(crate) name: String,
}

/// Reads `path`, or the demo's configuration.
///
/// # Errors
/// The file cannot be read, is not TOML, or has a key that does not fit; the message names the file, line and key.
pub(crate) fn load(path: Option<&Path>) -> Result<Loaded> {
    let Some(path) = path else {
        let mut file: File =
            toml::from_str(DEMO).context("reading the built-in demo configuration")?;
        for cell in file.cells.iter_mut().filter(|cell| cell.id == "line") {
            cell.setup = Some(SetupSource::Memory(DEMO_SETUP.to_owned()));
        }
        if let Some(path) = std::env::var_os(JOURNAL) {
            file.journal.path = Some(path.into());
            // A folder for temporary files may be in memory, and the demo has nothing to lose.
            file.journal.allow_volatile_filesystem = true;
        }
        return Ok(Loaded {
            file,
            folder: PathBuf::new(),
            name: "the demo configuration".into(),
        });
    };
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {name}"))?;
    let mut file: File = toml::from_str(&text).with_context(|| format!("in {name}"))?;
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    for cell in &mut file.cells {
        if let Some(SetupSource::File(setup)) = &mut cell.setup {
            *setup = folder.join(&*setup);
        }
    }
    Ok(Loaded { file, folder, name })
}

impl Loaded {
    /// A configuration from text, with the set-up that its cells begin with.
    ///
    /// # Errors
    /// It is not TOML, or a key does not fit.
    pub(crate) fn from_text(config: &str, setup: &str) -> Result<Self> {
        let mut file: File = toml::from_str(config).context("reading the configuration")?;
        for cell in &mut file.cells {
            cell.setup = Some(SetupSource::Memory(setup.to_owned()));
        }
        Ok(Self {
            file,
            folder: PathBuf::new(),
            name: "a configuration of text".into(),
        })
    }
}

fn seed_port() -> u16 {
    59002
}

fn real_time() -> f64 {
    1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_demo_and_the_example_are_read() {
        assert_eq!(load(None).unwrap().file.cells.len(), 2);
        let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("plant.example.toml");
        let example = load(Some(&example)).unwrap().file;
        assert_eq!(example.cells.len(), 2);
        assert_eq!(example.virtual_controllers[1].ports[&59002], 59003);
    }

    #[test]
    fn a_key_in_the_wrong_unit_is_named_with_the_right_one() {
        let text = "[[cells]]\nid='c'\n[[cells.robots]]\nid='r'\nmodel='m'\ncontroller='a:1'\nreply_timeout_s=2";
        let error = toml::from_str::<File>(text).unwrap_err().to_string();
        assert!(error.contains("reply_timeout_s"), "{error}");
        assert!(error.contains("`reply_timeout_ms`"), "{error}");
    }
}
