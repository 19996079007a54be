//! Files: OPEN, CLOSE, CANCEL, READ, WRITE.
//!
//! I/O never ends a task: what went wrong is in the FILE variable, for `IO_STATUS`.

use std::time::Duration;

use super::{
    cell::{Address, Cell, FileCell},
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::Pending,
};
use crate::{
    host::{FileId, OpenMode, Progress, Wait},
    ir::{ReadPart, ScalarType, WritePart, WriteShape},
    status::Status,
    text_reader::{self, ItemFormat, ItemKind, LineState, ReadResult, ReadValue},
    text_writer,
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
        let status = match mode {
            _ if file.file.is_some() => Status::INTP_FILE_IN_USE,
            None => Status::FILE_ILLEGAL_PARAMETER,
            Some(mode) => match self
                .host
                .open_file(self.id, mode, &name.to_string_lossless())
            {
                Ok(id) => {
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
        let status = file.file.map_or(Status::OK, |id| self.host.close_file(id));
        self.memory().set_file(
            at,
            FileCell {
                status: status.0,
                timeout_ms: file.timeout_ms,
                ..FileCell::default()
            },
        );
        Flow::Next
    }

    pub(super) fn cancel_file(&mut self) -> Flow {
        let at = self.pop_address();
        let mut file = self.memory().file(at);
        let status = file.file.map_or(Status::OK, |id| self.host.cancel_file(id));
        file.status = status.0;
        self.memory().set_file(at, file);
        Flow::Next
    }

    /// Reads the items of a READ one by one. Items that are done stay done while the task waits.
    /// After the first that fails, all others of the statement become uninitialized.
    pub(super) fn read(&mut self, row: u32) -> Flow {
        let program = self.program;
        let shape = row_of(&program.code.reads, row);
        let operands = shape.operands as usize;
        let at = self.operand_address(operands - 1);
        let mut file = self.memory().file(at);
        let (mut item, mut operand, until) = match self.task.pending {
            Pending::Read {
                item,
                operand,
                until,
            } => (item, operand, until),
            Pending::None
            | Pending::Until(_)
            | Pending::Motion(_)
            | Pending::Deadline(_)
            | Pending::Paused => (0, 1, self.deadline(file)),
        };
        file.status = 0;
        while let Some(part) = shape.items.get(item) {
            let below = (operands - 1).saturating_sub(operand);
            let (target, format) = self.read_format(part, below);
            match self.read_item(&mut file, format) {
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
                    };
                    return Flow::Blocked(match until {
                        Some(until) => Wait::ReadableUntil(id, until),
                        None => Wait::Readable(id),
                    });
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

    fn read_format(
        &self,
        part: &ReadPart,
        below: usize,
    ) -> (Option<Address>, Result<ItemFormat, Status>) {
        match part {
            ReadPart::LineEnd => (
                None,
                Ok(ItemFormat {
                    kind: ItemKind::LineEnd,
                    width: None,
                }),
            ),
            ReadPart::Value { ty, formats } => {
                let target = self.operand_address(below);
                let format = |number: usize| self.operand(below - number).expect_integer();
                let width = (*formats >= 1).then(|| format(1));
                let second = (*formats >= 2).then(|| format(2));
                (Some(target), item_format(*ty, target.extra, width, second))
            }
        }
    }

    /// ASSUMPTION: the time of `ATR_TIMEOUT` counts for each READ statement from its start; what
    /// was received stays for the next READ.
    fn deadline(&self, file: FileCell) -> Option<Duration> {
        let timeout = Duration::from_millis(file.timeout_ms.into());
        (file.timeout_ms > 0).then(|| self.host.now().saturating_add(timeout))
    }

    /// The item, or the file that has to bring more for it.
    fn read_item(
        &mut self,
        file: &mut FileCell,
        format: Result<ItemFormat, Status>,
    ) -> Result<Result<ReadValue, Status>, FileId> {
        let Some(id) = file.file else {
            return Ok(Err(Status::INTP_NOT_OPEN));
        };
        let format = match format {
            Ok(format) => format,
            Err(status) => return Ok(Err(status)),
        };
        let reading = text_reader::read_item(self.host.input(id), file.line_state, format);
        file.line_state = reading.line_state;
        if reading.consumed > 0 {
            self.host.consume(id, reading.consumed);
        }
        match reading.result {
            ReadResult::Incomplete => Err(id),
            ReadResult::Value(value) => Ok(Ok(value)),
            ReadResult::Failed(status) => Ok(Err(status)),
        }
    }

    fn store_read(&mut self, target: Address, value: ReadValue) {
        let cell = match value {
            ReadValue::Integer(value) => Cell::Integer(value),
            ReadValue::Real(value) => Cell::Real(value),
            ReadValue::Boolean(value) => Cell::Boolean(value),
            ReadValue::Text(value) => Cell::Text(value),
            ReadValue::Nothing => return,
        };
        self.memory().set(target, cell);
    }

    /// Makes the variables of these items uninitialized; `below` is the first one's operand.
    fn clear_rest(&mut self, parts: &[ReadPart], mut below: usize) {
        for part in parts {
            if let ReadPart::Value { .. } = part {
                let target = self.operand_address(below);
                self.memory().set(target, Cell::Uninit);
            }
            below = below.saturating_sub(part_operands(part));
        }
    }

    /// Formats all items and hands them to the host in one piece.
    pub(super) fn write(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let shape = row_of(&program.code.writes, row);
        let operands = shape.operands as usize;
        let formatted = self.formatted(shape);
        if !shape.to_file {
            self.host.display(self.id, &formatted.map_err(bad_format)?);
            self.drop_operands(operands);
            return Ok(Flow::Next);
        }
        let at = self.operand_address(operands - 1);
        let mut file = self.memory().file(at);
        let status = match (file.file, formatted) {
            (None, _) => Status::INTP_NOT_OPEN,
            (Some(_), Err(status)) => status,
            (Some(id), Ok(bytes)) => match self.output(id, &bytes) {
                Ok(status) => status,
                Err(wait) => return Ok(Flow::Blocked(wait)),
            },
        };
        file.status = status.0;
        self.memory().set_file(at, file);
        self.drop_operands(operands);
        Ok(Flow::Next)
    }

    fn output(&mut self, id: FileId, bytes: &[u8]) -> Result<Status, Wait> {
        if bytes.is_empty() {
            return Ok(Status::OK);
        }
        match self.host.output(id, bytes) {
            Progress::Ready(status) => Ok(status),
            Progress::Pending(wait) => Err(wait),
        }
    }

    fn formatted(&self, shape: &WriteShape) -> Result<Vec<u8>, Status> {
        let mut out = Vec::new();
        let mut below = shape.operands as usize - usize::from(shape.to_file);
        for part in &shape.items {
            let WritePart::Value { formats } = part else {
                out.extend_from_slice(text_writer::LINE_END);
                continue;
            };
            below -= 1;
            let value = self.operand(below);
            let mut widths = [None, None];
            for width in widths.iter_mut().take(*formats as usize) {
                below -= 1;
                *width = Some(write_width(self.operand(below))?);
            }
            let [width, digits] = widths;
            match value {
                Cell::Integer(value) => text_writer::integer(&mut out, *value, width),
                Cell::Real(value) => text_writer::real(&mut out, *value, width, digits),
                Cell::Boolean(value) => text_writer::boolean(&mut out, *value, width),
                Cell::Text(value) => text_writer::text(&mut out, value.as_bytes(), width),
                Cell::Uninit | Cell::Config(_) | Cell::File(_) | Cell::Address(_) => {
                    unreachable!("the checker refuses WRITE of {value:?}")
                }
            }
        }
        Ok(out)
    }
}

fn bad_format(status: Status) -> Fault {
    Fault::new(status, "Invalid format specifier in WRITE")
}

fn write_width(cell: &Cell) -> Result<usize, Status> {
    let width = usize::try_from(cell.expect_integer()).ok();
    width
        .filter(|width| *width <= text_writer::MAX_WIDTH)
        .ok_or(Status::INTP_ARGUMENT)
}

fn part_operands(part: &ReadPart) -> usize {
    match part {
        ReadPart::Value { formats, .. } => 1 + *formats as usize,
        ReadPart::LineEnd => 0,
    }
}

fn item_format(
    ty: ScalarType,
    length: u32,
    width: Option<i32>,
    second: Option<i32>,
) -> Result<ItemFormat, Status> {
    let width = match width {
        Some(width) => Some(usize::try_from(width).map_err(|_| Status::INTP_ARGUMENT)?),
        None => None,
    };
    let kind = match (ty, second) {
        (ScalarType::Integer, None | Some(0)) => ItemKind::Integer { base: 10 },
        (ScalarType::Integer, Some(base)) => match u32::try_from(base) {
            Ok(base @ 2..=16) => ItemKind::Integer { base },
            Ok(_) | Err(_) => return Err(Status::INTP_ARGUMENT),
        },
        (ScalarType::Real, _) => ItemKind::Real,
        (ScalarType::Boolean, _) => ItemKind::Boolean,
        (ScalarType::Text, None | Some(0)) => ItemKind::Text {
            length: length as usize,
        },
        // Quoted strings are not supported.
        (ScalarType::Text, Some(_)) => return Err(Status::INTP_ARGUMENT),
    };
    Ok(ItemFormat { kind, width })
}
