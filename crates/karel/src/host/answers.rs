//! What the machine and its host tell each other.

use std::{sync::Arc, time::Duration};

use crate::status::Status;

/// An open file, named by the host. Never reused while a program may still hold it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

impl FileId {
    /// The keyboard of the pendant, which needs no OPEN: what an operator types is its
    /// [`Host::input`](super::Host::input). A host must give this number to no file of its own.
    pub const KEYBOARD: FileId = FileId(u32::MAX);
}

/// A motion that was started, named by the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MotionId(pub u64);

/// A task, named by the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TaskId(pub u32);

/// The answer to a call that may have to wait.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress<T> {
    /// The answer.
    Ready(T),
    /// The task waits; the call is repeated with the same arguments when the wait may be over.
    Pending(Wait),
}

/// What a suspended task waits for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wait {
    /// More bytes, or the end, of a file.
    Readable(FileId),
    /// As `Readable`, but only until this moment of the controller's clock.
    ReadableUntil(FileId, Duration),
    /// Room to write to a file.
    Writable(FileId),
    /// A client on a tag, in upper case and without colon: `S3`.
    Connect(String),
    /// A free place in the motion queue.
    MotionQueue,
    /// The end of a motion.
    Motion(MotionId),
    /// A moment of the controller's clock, time since power-on.
    Until(Duration),
    /// That somebody continues the task, which is paused; see [`crate::Machine::resume`].
    Continue,
}

/// Bytes that arrived and were not consumed yet.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The bytes, oldest first.
    pub bytes: &'a [u8],
    /// Whether more can follow.
    pub end: InputEnd,
}

/// Whether more bytes can follow those in an [`Input`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputEnd {
    /// More may come.
    Open,
    /// Nothing more comes, and this is what a READ beyond the end reports.
    Closed(Status),
}

/// The mode of an OPEN FILE.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OpenMode {
    /// `RO`.
    ReadOnly,
    /// `RW`.
    ReadWrite,
    /// `AP`.
    Append,
    /// `UD`.
    Update,
}

/// What a program wants a hand to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HandAction {
    /// `OPEN HAND`.
    Open,
    /// `CLOSE HAND`.
    Close,
    /// `RELAX HAND`.
    Relax,
}

/// An alarm as `ERR_DATA` reports it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlarmView {
    /// Its number in the history.
    pub seq: i32,
    /// Facility times 1000 plus number.
    pub code: i32,
    /// Its text.
    pub message: String,
    /// 0 for a warning, higher for what stops more.
    pub severity: i32,
    /// The program that caused it, or nothing.
    pub program: String,
}

/// An alarm that a program raises with `POST_ERR`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramAlarm {
    /// Facility and number.
    pub status: Status,
    /// The program's own words.
    pub text: String,
    /// What it does to the tasks.
    pub severity: AlarmSeverity,
    /// Program of the statement, upper case.
    pub program: Arc<str>,
    /// Physical source line of the statement, from 1.
    pub line: u32,
}

/// What an alarm of a program does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AlarmSeverity {
    /// It is only shown.
    Warn,
    /// Tasks pause.
    Pause,
    /// Tasks end, and what moves is canceled.
    Abort,
}

/// Something that is done with files that are not open. Names are as the program wrote them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileOperation<'a> {
    /// `COPY_FILE`.
    Copy {
        /// The source.
        from: &'a str,
        /// The copy.
        to: &'a str,
        /// Whether a file that is there is replaced.
        overwrite: bool,
    },
    /// `DELETE_FILE`.
    Delete(&'a str),
    /// `RENAME_FILE`.
    Rename {
        /// The file.
        from: &'a str,
        /// Its new name, on the same device.
        to: &'a str,
    },
    /// `MOUNT_DEV`, `DISMOUNT_DEV`: whether the device is there.
    Mount(&'a str),
    /// `FORMAT_DEV`: every file of the device is deleted.
    Format(&'a str),
}
