//! Files: OPEN, CLOSE, CANCEL, READ.
//!
//! I/O never ends a task: what went wrong is in the FILE variable, for `IO_STATUS`.

use super::{
    cell::{Address, Cell, FileCell, FileFlag},
    exec::{Exec, Flow, row_of},
    read_item::{config_of, fits},
    task::Pending,
};
use crate::{
    host::{FileId, OpenMode, Wait},
    ir::{Op, Outward, ReadPart},
    status::Status,
    text_reader::LineState,
};

impl Exec<'_> {
    pub(super) fn open_file(&mut self) -> Flow {
        let (name, mode, at) = (self.pop_text(), self.pop_text(), self.pop_address());
        let mut file = self.memory().file(at);
        let mode = match mode.as_bytes().trim_ascii().to_ascii_uppercase().as_slice() {
            b"RO" => Some(OpenMode::ReadOnly),
            b"RW" => Some(OpenMode::ReadWrite),
            b"AP" => Some(OpenMode::Append),
            b"UD" => Some(OpenMode::Update),
            _ => None,
        };
        let name = name.to_string_lossless();
        let status = match mode {
            _ if file.has(FileFlag::Window) => Status::INTP_PREDEFINED,
            _ if file.file.is_some() => Status::INTP_FILE_IN_USE,
            None => Status::FILE_ILLEGAL_PARAMETER,
            Some(_) if is_keyboard(&name) => {
                file.file = Some(FileId::KEYBOARD);
                file.line_state = LineState::Inside;
                Status::OK
            }
            Some(mode) => match self.host.open_file(self.id, mode, &name) {
                Ok(id) => {
                    if is_pipe(&name) {
                        file.set(FileFlag::Pipe);
                    }
                    file.file = Some(id);
                    file.line_state = LineState::Inside;
                    Status::OK
                }
                Err(status) => status,
            },
        };
        file.status = status.0;
        self.memory().set_file(at, file);
        Flow::Next
    }

    /// Closing a file that is not open is status 0.
    pub(super) fn close_file(&mut self) -> Flow {
        let at = self.pop_address();
        let file = self.memory().file(at);
        let open = file.file.filter(|id| *id != FileId::KEYBOARD);
        let status = open.map_or(Status::OK, |id| self.host.close_file(id));
        self.memory().set_file(at, file.closed(status.0));
        Flow::Next
    }

    pub(super) fn cancel_file(&mut self) -> Flow {
        let at = self.pop_address();
        self.cancel_interrupted(at);
        let mut file = self.memory().file(at);
        let status = file.file.map_or(Status::OK, |id| self.host.cancel_file(id));
        file.status = status.0;
        self.memory().set_file(at, file);
        Flow::Next
    }

    /// A condition handler cancels the READ that it interrupted.
    fn cancel_interrupted(&mut self, at: Address) {
        if !self.task.interrupted {
            return;
        }
        let mut callers = self.task.callers.iter_mut().rev();
        let Some(caller) = callers.find(|caller| caller.interrupted.is_some()) else {
            return;
        };
        let loaded = self.programs.get(caller.program);
        let op = loaded.and_then(|loaded| loaded.program.code.ops.get(caller.pc).copied());
        let Some(Op::Outward(Outward::Read(row))) = op else {
            return;
        };
        let shape = loaded.and_then(|loaded| loaded.program.code.reads.get(row as usize));
        let operands = shape.map_or(0, |shape| shape.operands as usize);
        // Below the operands of the handler, which has none now, are those of the READ.
        let file = self.task.operands.len().checked_sub(operands);
        let file = file.and_then(|index| self.task.operands.get(index));
        let pending = caller.interrupted.as_deref_mut();
        if let (Some(Cell::Address(file)), Some(Pending::Read { cancelled, .. })) = (file, pending)
            && *file == at
        {
            *cancelled = true;
        }
    }

    /// Reads the items of a READ one by one. Items that are done stay done while the task waits.
    /// After the first that fails, all others of the statement become uninitialized.
    pub(super) fn read(&mut self, row: u32) -> Flow {
        let program = self.program;
        let shape = row_of(&program.code.reads, row);
        let operands = shape.operands as usize;
        let at = self.operand_address(operands - 1);
        let mut file = self.memory().file(at);
        let (mut item, mut operand, until, cancelled) = match self.task.pending {
            Pending::Read {
                item,
                operand,
                until,
                cancelled,
            } => (item, operand, until, cancelled),
            Pending::None
            | Pending::Until(_)
            | Pending::Motion(_)
            | Pending::Along
            | Pending::Skipped(_)
            | Pending::Deadline(_)
            | Pending::Paused
            | Pending::GivesUp => (0, 1, self.deadline(file), false),
        };
        file.status = 0;
        while let Some(part) = shape.items.get(item) {
            let below = (operands - 1).saturating_sub(operand);
            let (target, format) = self.read_format(part, below, file.line_end);
            let item_read = if file.has(FileFlag::Binary) {
                self.read_binary(&mut file, part, below)
            } else {
                self.read_item(&mut file, format)
            };
            match item_read {
                Err(_) if cancelled => {
                    file.status = Status::INTP_READ_FAILED.0;
                    self.clear_rest(shape.items.get(item..).unwrap_or_default(), below);
                    break;
                }
                // A pipe waits only if it is told to.
                Err(_) if file.has(FileFlag::Pipe) && !file.has(FileFlag::PipeWaits) => {
                    file.status = Status::WOULD_BLOCK.0;
                    self.clear_rest(shape.items.get(item..).unwrap_or_default(), below);
                    break;
                }
                Err(_) if until.is_some_and(|until| until <= self.host.now()) => {
                    file.status = Status::INTP_READ_TIMEOUT.0;
                    self.clear_rest(shape.items.get(item..).unwrap_or_default(), below);
                    break;
                }
                Err(id) => {
                    self.memory().set_file(at, file);
                    self.task.pending = Pending::Read {
                        item,
                        operand,
                        until,
                        cancelled,
                    };
                    return Flow::Blocked(match until {
                        Some(until) => Wait::ReadableUntil(id, until),
                        None => Wait::Readable(id),
                    });
                }
                Ok(Ok(value)) if !fits(part, &value) => {
                    file.status = Status::INTP_ILLEGAL_DATA.0;
                    self.clear_rest(shape.items.get(item..).unwrap_or_default(), below);
                    break;
                }
                Ok(Ok(value)) if part.is_config() && config_of(&value).is_none() => {
                    file.status = Status::INTP_ILLEGAL_DATA.0;
                    self.clear_rest(shape.items.get(item..).unwrap_or_default(), below);
                    break;
                }
                Ok(Ok(value)) if part.is_config() => {
                    if let (Some(target), Some(config)) = (target, config_of(&value)) {
                        self.memory().set(target, Cell::Config(config));
                    }
                }
                Ok(Ok(value)) => {
                    if let Some(target) = target {
                        self.store_read(target, value);
                    }
                }
                Ok(Err(status)) => {
                    file.status = status.0;
                    self.clear_rest(shape.items.get(item..).unwrap_or_default(), below);
                    break;
                }
            }
            operand += part_operands(part);
            item += 1;
        }
        self.task.pending = Pending::None;
        self.memory().set_file(at, file);
        self.drop_operands(operands);
        Flow::Next
    }
}

fn is_pipe(name: &str) -> bool {
    device(name).eq_ignore_ascii_case("PIP")
}

/// `KB:TPKB` and its like.
fn is_keyboard(name: &str) -> bool {
    name.contains(':') && device(name).eq_ignore_ascii_case("KB")
}

fn device(name: &str) -> &str {
    name.split(':').next().unwrap_or_default().trim()
}

/// The file that a READ reads: that of a window is the keyboard of the pendant.
pub(super) fn readable(file: FileCell) -> Option<FileId> {
    let window = file.has(FileFlag::Window).then_some(FileId::KEYBOARD);
    file.file.or(window)
}

pub(super) fn not_open(file: FileCell) -> Status {
    if file.has(FileFlag::Window) {
        Status::INTP_PREDEFINED
    } else {
        Status::INTP_NOT_OPEN
    }
}

pub(super) fn part_operands(part: &ReadPart) -> usize {
    match part {
        ReadPart::Value { formats, .. } => 1 + *formats as usize,
        ReadPart::LineEnd => 0,
    }
}
