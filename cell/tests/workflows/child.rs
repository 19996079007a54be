//! The real program as a child process, which can be killed.

use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// What a program of its own needs to know.
#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) config: std::path::PathBuf,
    pub(crate) parts_at: String,
}

impl Program {
    /// Writes its files: a configuration with a journal and a set-up on disk.
    pub(crate) fn prepare(folder: &Path, config: &str, setup: &str, parts_at: String) -> Self {
        let setup_at = folder.join("setup.toml");
        std::fs::write(&setup_at, setup).unwrap();
        let cell = "[[cells]]\nid = 'demo'\n";
        assert!(config.contains(cell), "the cell's section");
        let config = config.replace(cell, &format!("{cell}setup = 'setup.toml'\n"));
        let journal = "[journal]\npath = 'cell.journal'\nallow_volatile_filesystem = true\n";
        let at = folder.join("robocell.toml");
        std::fs::write(&at, format!("{config}{journal}")).unwrap();
        Self {
            config: at,
            parts_at,
        }
    }

    pub(crate) fn start(&self, listen: SocketAddr) -> Child {
        Command::new(env!("CARGO_BIN_EXE_robocell"))
            .arg("--config")
            .arg(&self.config)
            .args(["--listen", &listen.to_string(), "--demo", "--log", "error"])
            .args(["--parts-at", &self.parts_at])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .unwrap()
    }
}
