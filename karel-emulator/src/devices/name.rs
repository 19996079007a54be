//! Names of files.

use karel::Status;

/// Devices that hold files.
///
/// ASSUMPTION: all of them are there and empty at first, and all but `RD:` keep their files without power.
pub(super) const DEVICES: [&str; 7] = ["RD", "MC", "FR", "UD1", "UT1", "MD", "FRA"];

/// The device of a name without one.
pub(super) const DEFAULT_DEVICE: &str = "MC";

/// A file by its device and its name in capitals.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileName {
    pub(super) device: String,
    pub(super) name: String,
}

impl FileName {
    /// Reads `MC:log.txt`, `RD:\\dir\\x.dt`, `PIP:queue`; `None` if the name is none or reaches out of its device.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim().to_ascii_uppercase();
        let (device, name) = text.split_once(':').unwrap_or((DEFAULT_DEVICE, &text));
        let name = name.replace('\\', "/");
        let name = name.strip_prefix('/').unwrap_or(&name);
        let parts: Vec<&str> = name.split('/').collect();
        let good = |part: &&str| {
            let plain = |c: char| c.is_ascii_alphanumeric() || "_-.$~#@ ".contains(c);
            !part.is_empty()
                && part.len() <= 64
                && !part.starts_with(['.', ' '])
                && !part.ends_with(['.', ' '])
                && part.chars().all(plain)
        };
        if parts.len() > 8 || !parts.iter().all(good) {
            return None;
        }
        Some(Self {
            device: device.trim().to_owned(),
            name: name.to_owned(),
        })
    }

    pub(super) fn is_pipe(&self) -> bool {
        self.device == "PIP"
    }

    pub(super) fn checked(text: &str) -> Result<Self, Status> {
        let name = Self::parse(text).ok_or(Status::FILE_ILLEGAL_PARAMETER)?;
        if name.is_pipe() || DEVICES.contains(&name.device.as_str()) {
            Ok(name)
        } else {
            Err(Status::FILE_NO_DEVICE)
        }
    }
}

impl std::fmt::Display for FileName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.device, self.name)
    }
}
