//! Memory: a row of cells for the program's variables, another for the frames of a task.

mod memory;

use crate::{host::FileId, position::Config, text_reader::LineState, value::Text};

pub(crate) use memory::Memory;

/// One scalar value, or none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    Uninit,
    Integer(i32),
    Real(f32),
    Boolean(bool),
    Text(Text),
    Config(Config),
    File(FileCell),
    /// The number of a PATH.
    Path(u32),
    /// A reference, in parameter cells and on the operand stack.
    Address(Address),
}

/// The checker typed every operand, so a cell of another type is a bug of the lowering.
impl Cell {
    #[inline]
    pub(crate) fn expect_integer(&self) -> i32 {
        let Cell::Integer(value) = self else {
            unreachable!("INTEGER expected, found {self:?}")
        };
        *value
    }

    #[inline]
    pub(crate) fn expect_real(&self) -> f32 {
        let Cell::Real(value) = self else {
            unreachable!("REAL expected, found {self:?}")
        };
        *value
    }

    pub(crate) fn expect_text(&self) -> Text {
        let Cell::Text(value) = self else {
            unreachable!("STRING expected, found {self:?}")
        };
        value.clone()
    }

    pub(crate) fn expect_path(&self) -> u32 {
        let Cell::Path(value) = self else {
            unreachable!("PATH expected, found {self:?}")
        };
        *value
    }

    /// The number of the PATH that it is.
    pub(crate) fn path(&self) -> Option<u32> {
        if let Cell::Path(path) = self {
            Some(*path)
        } else {
            None
        }
    }

    #[inline]
    pub(crate) fn expect_address(&self) -> Address {
        let Cell::Address(value) = self else {
            unreachable!("address expected, found {self:?}")
        };
        *value
    }
}

/// The state of a FILE variable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FileCell {
    pub(crate) file: Option<FileId>,
    /// What `IO_STATUS` answers.
    pub(crate) status: i32,
    pub(crate) line_state: LineState,
    /// `ATR_TIMEOUT` in milliseconds, 0 for none. It stays when the file is closed.
    pub(crate) timeout_ms: u32,
    /// A set of [`FileFlag`]; those of attributes stay, too.
    flags: u8,
    /// `ATR_EOL`, 0 for CR and LF.
    pub(crate) line_end: u8,
}

/// What is true or not of a FILE variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileFlag {
    /// `ATR_UF`.
    Binary = 1,
    /// `ATR_REVERSE`.
    Reverse = 2,
    /// `ATR_PIPWAIT`.
    PipeWaits = 4,
    /// The file is a pipe.
    Pipe = 8,
    /// A window of the pendant, which is never opened.
    Window = 16,
}

impl FileCell {
    pub(crate) fn has(self, flag: FileFlag) -> bool {
        self.flags & flag as u8 != 0
    }

    pub(crate) fn set(&mut self, flag: FileFlag) {
        self.flags |= flag as u8;
    }

    pub(crate) fn unset(&mut self, flag: FileFlag) {
        self.flags &= !(flag as u8);
    }

    /// The same variable without a file.
    pub(crate) fn closed(mut self, status: i32) -> FileCell {
        self.unset(FileFlag::Pipe);
        FileCell {
            file: None,
            status,
            line_state: LineState::Inside,
            ..self
        }
    }
}

/// Where a cell is, and a length that belongs to the reference: of an open array or a string.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Address {
    cell: u32,
    pub(crate) extra: u32,
}

/// Marks addresses of frames; variables of programs have smaller ones.
const FRAME_BIT: u32 = 1 << 31;

impl Address {
    pub(crate) fn global(cell: u32) -> Address {
        Address { cell, extra: 0 }
    }

    pub(crate) fn frame(cell: u32) -> Address {
        Address {
            cell: cell | FRAME_BIT,
            extra: 0,
        }
    }

    /// Its place among the variables of the programs.
    pub(crate) fn global_index(self) -> usize {
        self.cell as usize
    }

    pub(crate) fn plus(self, cells: u32) -> Address {
        Address {
            cell: self.cell + cells,
            extra: self.extra,
        }
    }

    pub(crate) fn with_extra(self, extra: u32) -> Address {
        Address {
            cell: self.cell,
            extra,
        }
    }
}
