//! A bare fdatasync: what the disk leaves of a durable intent at best.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};

use crate::client::Answered;
use crate::schedule::Load;

/// Appends a page and has it kept, at this rate, by turns on one file a worker.
pub(crate) fn load(directory: &Path, rate: f64) -> Load {
    let directory = directory.to_owned();
    Load::new("bare fdatasync", rate, 2, move |_worker| {
        let file = tempfile::tempfile_in(&directory).context("a file to write to");
        Box::new({
            let mut file = file;
            move |_number| append(&mut file)
        })
    })
}

fn append(file: &mut Result<File>) -> Result<Answered> {
    let Ok(file) = file else {
        anyhow::bail!("there is no file to write to");
    };
    file.write_all(&[b'x'; 4096])?;
    file.sync_data()?;
    Ok(Answered {
        expected: true,
        reopened: false,
    })
}
