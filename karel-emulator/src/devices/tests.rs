use std::io;

use super::*;

fn opened(devices: &mut Devices, number: u32, mode: OpenMode, name: &str) -> FileId {
    let file = FileId(number);
    devices.open(file, mode, name).unwrap();
    file
}

#[test]
fn names_stay_inside_of_their_device() {
    for good in [
        "RD:log.txt",
        "mc:\\dir\\x.dt",
        "plain",
        "PIP:q",
        "FR:a/b/c.kl",
    ] {
        assert!(FileName::parse(good).is_some(), "{good}");
    }
    for bad in [
        "MC:..\\x",
        "MC:../x",
        "MC:a/../../x",
        "MC:",
        "RD:a//b",
        "MC:.hidden",
        "MC:a:b",
        "MC:x\0y",
        "MC:a/..",
        "MC:C:\\x",
        "MC:a?b",
        "MC://x",
    ] {
        assert_eq!(FileName::parse(bad), None, "{bad:?}");
    }
    let mut devices = Devices::default();
    let outside = devices.open(FileId(1), OpenMode::ReadWrite, "MC:../../etc/passwd");
    assert_eq!(outside, Err(Status::FILE_ILLEGAL_PARAMETER));
    let elsewhere = devices.open(FileId(1), OpenMode::ReadWrite, "XYZ:a");
    assert_eq!(elsewhere, Err(Status::FILE_NO_DEVICE));
}

#[test]
fn a_file_is_written_read_added_to_and_deleted() {
    let mut devices = Devices::default();
    let missing = devices.open(FileId(1), OpenMode::ReadOnly, "RD:a.txt");
    assert_eq!(missing, Err(Status::FILE_NOT_FOUND));
    let file = opened(&mut devices, 1, OpenMode::ReadWrite, "RD:a.txt");
    assert_eq!(devices.write(file, b"one").0, Status::OK);
    devices.close(file);
    let file = opened(&mut devices, 2, OpenMode::Append, "rd:A.TXT");
    assert_eq!(devices.write(file, b"two").0, Status::OK);
    devices.close(file);
    let file = opened(&mut devices, 3, OpenMode::ReadOnly, "RD:A.TXT");
    assert_eq!(devices.input(file).bytes, b"onetwo");
    devices.consume(file, 4);
    assert_eq!(devices.input(file).bytes, b"wo");
    assert_eq!(devices.write(file, b"x").0, Status::INTP_WRITE_FAILED);
    devices.close(file);
    let changed: Vec<String> = devices
        .take_changed()
        .into_iter()
        .map(|(name, bytes)| format!("{name} {:?}", bytes.map(|bytes| bytes.len())))
        .collect();
    assert_eq!(changed, ["RD:A.TXT Some(3)", "RD:A.TXT Some(6)"]);
    assert_eq!(
        devices.operate(FileOperation::Delete("RD:a.txt")),
        Status::OK
    );
    let again = devices.operate(FileOperation::Delete("RD:a.txt"));
    assert_eq!(again, Status::FILE_NOT_FOUND);
}

#[test]
fn a_device_is_full_at_its_limit() {
    let mut devices = Devices::default();
    let file = opened(&mut devices, 1, OpenMode::ReadWrite, "MC:big");
    let chunk = vec![0; MAX_FILE];
    assert_eq!(devices.write(file, &chunk).0, Status::OK);
    assert_eq!(devices.write(file, b"x").0, Status::FILE_DEVICE_FULL);
}

#[test]
fn assumed_pipe_loses_its_oldest_bytes() {
    let mut devices = Devices::default();
    let writer = opened(&mut devices, 1, OpenMode::ReadWrite, "PIP:q");
    let reader = opened(&mut devices, 2, OpenMode::ReadOnly, "pip:Q");
    let (status, readers) = devices.write(writer, &vec![b'a'; MAX_PIPE]);
    assert_eq!((status, readers.contains(&reader)), (Status::OK, true));
    assert_eq!(devices.write(writer, b"end").0, Status::OK);
    let input = devices.input(reader);
    assert_eq!(input.bytes.len(), MAX_PIPE);
    assert!(input.bytes.ends_with(b"aend"));
}

#[test]
fn patterns_have_stars() {
    assert!(matches(b"*.TXT", b"A.TXT"));
    assert!(matches(b"*", b""));
    assert!(matches(b"A*B*C", b"AXXBYYBC"));
    assert!(!matches(b"*.TXT", b"A.DT"));
    // Many stars cost little.
    let many = b"*A".repeat(30);
    assert!(!matches(&many, &[b'A'; 20]));
}

#[test]
fn a_folder_gets_what_programs_close_and_nothing_outside() {
    let root = std::env::temp_dir().join(format!("robocell-devices-{}", std::process::id()));
    std::fs::create_dir_all(root.join("MC")).unwrap();
    std::fs::write(root.join("MC/old.txt"), b"old").unwrap();
    let folder = Folder::try_new(&root).unwrap();
    let name = FileName::parse("MC:new.txt").unwrap();
    folder.keep(&name, Some(b"new")).unwrap();
    let read = folder.read().unwrap();
    let names: Vec<String> = read.iter().map(|(name, _)| name.to_string()).collect();
    assert!(names.contains(&"MC:OLD.TXT".to_owned()), "{names:?}");
    assert!(names.contains(&"MC:NEW.TXT".to_owned()), "{names:?}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/tmp", root.join("RD")).unwrap();
        let name = FileName::parse("RD:out.txt").unwrap();
        let refused = folder.keep(&name, Some(b"x")).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::PermissionDenied);
    }
    folder.keep(&name, None).unwrap();
    std::fs::remove_dir_all(&root).unwrap();
}
