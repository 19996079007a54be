//! Whether what is written here is there after a power loss.

use std::path::{Path, PathBuf};

/// What is asked of the filesystem under a journal.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Filesystem {
    /// On Linux, one that is known to lose what was synced, or to lock badly, is refused: memory, and network.
    #[default]
    Checked,
    /// Whoever opens the journal answers for it.
    Trusted,
}

/// Filesystems in memory lose everything; on network filesystems neither fsync nor SQLite's locks can be relied on.
const REFUSED: [&str; 11] = [
    "9p",
    "afs",
    "ceph",
    "cifs",
    "fuse.sshfs",
    "nfs",
    "nfs4",
    "ramfs",
    "smb3",
    "tmpfs",
    "vboxsf",
];

/// Why the directory's filesystem does not do, if it is known not to.
pub(super) fn objection(directory: &Path) -> Option<String> {
    // Not Linux, or a sandbox that hides it: nothing is known against it.
    let mounts = std::fs::read_to_string("/proc/self/mountinfo").ok()?;
    objection_in(&mounts, directory)
}

/// proc(5): `36 35 98:0 /root /mount/point rw,noatime master:1 - ext4 /dev/sda1 rw,errors=continue`.
fn objection_in(mounts: &str, directory: &Path) -> Option<String> {
    let (_, kind, options) = mounts
        .lines()
        .filter_map(parse)
        .filter(|(point, ..)| directory.starts_with(point))
        // The last one of several on the same point is the one on top.
        .max_by_key(|(point, ..)| point.components().count())?;
    if REFUSED.contains(&kind) {
        return Some(kind.to_owned());
    }
    let volatile = kind == "overlay" && options.split(',').any(|option| option == "volatile");
    volatile.then(|| "overlay, mounted volatile".to_owned())
}

fn parse(line: &str) -> Option<(PathBuf, &str, &str)> {
    let (left, right) = line.split_once(" - ")?;
    let point = unescape(left.split(' ').nth(4)?);
    let mut right = right.split(' ');
    let kind = right.next()?;
    Some((point, kind, right.nth(1).unwrap_or_default()))
}

fn unescape(text: &str) -> PathBuf {
    text.replace("\\040", " ")
        .replace("\\011", "\t")
        .replace("\\012", "\n")
        .replace("\\134", "\\")
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOUNTS: &str = "\
22 1 254:0 / / rw,relatime - ext4 /dev/vda rw
23 22 0:20 / /dev/shm rw - tmpfs tmpfs rw
24 22 0:30 / /mnt/my\\040share rw - nfs4 host:/x rw
25 22 0:40 / /box rw master:1 - overlay overlay rw,lowerdir=/l,volatile
26 22 0:41 / /sound rw - overlay overlay rw,lowerdir=/l
";

    fn refused(path: &str) -> Option<String> {
        objection_in(MOUNTS, Path::new(path))
    }

    #[test]
    fn memory_and_network_are_refused_and_disks_are_not() {
        assert_eq!(refused("/var/lib/cell"), None);
        assert_eq!(refused("/dev/shm/cell"), Some("tmpfs".into()));
        assert_eq!(refused("/dev/shmem"), None);
        assert_eq!(refused("/mnt/my share/a"), Some("nfs4".into()));
        assert_eq!(
            refused("/box/cell"),
            Some("overlay, mounted volatile".into())
        );
        assert_eq!(refused("/sound/cell"), None);
    }

    #[test]
    fn the_last_mount_on_a_point_is_the_one_that_counts() {
        let mounts = format!("{MOUNTS}27 22 0:50 / / rw - tmpfs tmpfs rw\n");
        assert_eq!(
            objection_in(&mounts, Path::new("/var")),
            Some("tmpfs".into())
        );
    }
}
