//! The configuration file: the server's sections and those of the virtual controllers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::Deserialize;
use server::config::{CellSection, JournalSection, ServerSection};

/// What runs when no file is named.
const DEMO: &str = include_str!("../demo.toml");

/// The file as it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct File {
    /// `[server]`.
    #[serde(default)]
    pub(crate) server: ServerSection,
    /// `[journal]`.
    #[serde(default)]
    pub(crate) journal: JournalSection,
    /// `[[cells]]`.
    #[serde(default)]
    pub(crate) cells: Vec<CellSection>,
    /// `[[virtual_controllers]]`.
    #[serde(default)]
    pub(crate) virtual_controllers: Vec<VirtualControllerSection>,
}

/// `[[virtual_controllers]]`: a controller that runs in this process.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VirtualControllerSection {
    /// Its name; robots refer to it as `virtual:NAME`.
    pub(crate) name: String,
    /// The arm model.
    pub(crate) model: String,
    /// KAREL programs to load, relative to the configuration file; the first one runs.
    /// The socket server of this project where absent.
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
    /// Where the arm stands at power-on, pendant joints; the model's home where absent.
    pub(crate) start_joints_deg: Option<[f64; 6]>,
    /// Controller seconds in a second.
    #[serde(default = "real_time")]
    pub(crate) time_scale: f64,
    /// What happens to a second client while the first is served.
    #[serde(default)]
    pub(crate) second_client: SecondClientWord,
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
        let file = toml::from_str(DEMO).context("reading the built-in demo configuration")?;
        return Ok(Loaded {
            file,
            folder: PathBuf::new(),
            name: "the demo configuration".into(),
        });
    };
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {name}"))?;
    let file = toml::from_str(&text).with_context(|| format!("in {name}"))?;
    let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    Ok(Loaded { file, folder, name })
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
        assert_eq!(load(None).unwrap().file.cells.len(), 1);
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
