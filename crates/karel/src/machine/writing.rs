//! WRITE: items become bytes, and one piece for the host.

use super::{
    cell::{Cell, FileCell, FileFlag},
    exec::{Exec, Flow, row_of},
    fault::Fault,
    transfer::not_open,
};
use crate::{
    binary,
    host::{FileId, Progress, Wait},
    ir::{WritePart, WriteShape},
    status::Status,
    text_writer,
};

impl Exec<'_> {
    /// Formats all items and hands them to the host in one piece.
    pub(super) fn write(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let shape = row_of(&program.code.writes, row);
        let operands = shape.operands as usize;
        let mut file = FileCell::default();
        let at = shape.to_file.then(|| self.operand_address(operands - 1));
        if let Some(at) = at {
            file = self.memory().file(at);
        }
        let formatted = self.formatted(shape, file);
        let Some(at) = at.filter(|_| !file.has(FileFlag::Window)) else {
            self.host.display(self.id, &formatted.map_err(bad_format)?);
            if let Some(at) = at {
                file.status = 0;
                self.memory().set_file(at, file);
            }
            self.drop_operands(operands);
            return Ok(Flow::Next);
        };
        let status = match (file.file, formatted) {
            (None, _) => not_open(file),
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

    fn formatted(&self, shape: &WriteShape, file: FileCell) -> Result<Vec<u8>, Status> {
        let binary = file.has(FileFlag::Binary).then(|| self.order_of(file));
        let line_end = [file.line_end];
        let line_end = match (binary, file.line_end) {
            // Only flushes, and everything is sent at once.
            (Some(_), _) => &[],
            (None, 0) => text_writer::LINE_END,
            (None, _) => line_end.as_slice(),
        };
        let mut out = Vec::new();
        let mut below = shape.operands as usize - usize::from(shape.to_file);
        for part in &shape.items {
            let WritePart::Value {
                ty,
                formats,
                follows,
            } = part
            else {
                out.extend_from_slice(line_end);
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
            if let Some(order) = binary
                && let Some(word) = word_of(value)
            {
                binary::number(&mut out, word, *ty, order);
                continue;
            }
            let start = out.len();
            match value {
                Cell::Integer(value) => text_writer::integer(&mut out, *value, width),
                Cell::Real(value) => text_writer::real(&mut out, *value, width, digits),
                Cell::Boolean(value) => text_writer::boolean(&mut out, *value, width),
                Cell::Text(value) => text_writer::text(&mut out, value.as_bytes(), width),
                Cell::Config(value) => {
                    out.push(b' ');
                    text_writer::text(&mut out, value.to_string().as_bytes(), None);
                }
                // An axis that a JOINTPOS does not have.
                Cell::Uninit => {}
                Cell::File(_) | Cell::Path(_) | Cell::Address(_) => {
                    unreachable!("the checker refuses WRITE of {value:?}")
                }
            }
            if *follows && out.get(start).is_some_and(|first| *first != b' ') {
                out.insert(start, b' ');
            }
        }
        Ok(out)
    }
}

/// The bits of a number for a binary file.
fn word_of(cell: &Cell) -> Option<u32> {
    match cell {
        Cell::Integer(value) => Some(value.cast_unsigned()),
        Cell::Real(value) => Some(value.to_bits()),
        Cell::Boolean(value) => Some(u32::from(*value)),
        Cell::Config(config) => Some(binary::config_word(*config)),
        Cell::Uninit | Cell::Text(_) | Cell::File(_) | Cell::Path(_) | Cell::Address(_) => None,
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
