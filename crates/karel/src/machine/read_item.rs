//! The items of a READ: their formats, their values, and what is left without one.

use std::time::Duration;

use super::{
    cell::{Address, Cell, FileCell, FileFlag},
    exec::Exec,
    transfer::{not_open, part_operands, readable},
};
use crate::{
    binary,
    host::FileId,
    ir::{ReadPart, ScalarType},
    position::Config,
    run::ByteOrder,
    status::Status,
    text_reader::{self, ItemFormat, ItemKind, ReadResult, ReadValue},
    text_writer,
    types::{MAX_STRING, Small},
};

impl Exec<'_> {
    pub(super) fn read_format(
        &self,
        part: &ReadPart,
        below: usize,
        line_end: u8,
    ) -> (Option<Address>, Result<ItemFormat, Status>) {
        let line_end = (line_end != 0).then_some(line_end);
        match part {
            ReadPart::LineEnd => (
                None,
                Ok(ItemFormat {
                    kind: ItemKind::LineEnd,
                    width: None,
                    line_end,
                }),
            ),
            ReadPart::Value { ty, formats } => {
                let target = self.operand_address(below);
                let format = |number: usize| self.operand(below - number).expect_integer();
                let width = (*formats >= 1).then(|| format(1));
                let second = (*formats >= 2).then(|| format(2));
                let format = item_format(*ty, target.extra, width, second);
                let format = format.map(|format| ItemFormat { line_end, ..format });
                (Some(target), format)
            }
        }
    }

    /// ASSUMPTION: the time of `ATR_TIMEOUT` counts for each READ statement from its start; what
    /// was received stays for the next READ.
    pub(super) fn deadline(&self, file: FileCell) -> Option<Duration> {
        let timeout = Duration::from_millis(file.timeout_ms.into());
        (file.timeout_ms > 0).then(|| self.host.now().saturating_add(timeout))
    }

    /// The item, or the file that has to bring more for it.
    pub(super) fn read_item(
        &mut self,
        file: &mut FileCell,
        format: Result<ItemFormat, Status>,
    ) -> Result<Result<ReadValue, Status>, FileId> {
        let Some(id) = readable(*file) else {
            return Ok(Err(not_open(*file)));
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

    /// As [`Self::read_item`], of binary data.
    pub(super) fn read_binary(
        &mut self,
        file: &mut FileCell,
        part: &ReadPart,
        below: usize,
    ) -> Result<Result<ReadValue, Status>, FileId> {
        let Some(id) = file.file else {
            return Ok(Err(not_open(*file)));
        };
        let ReadPart::Value { ty, formats } = part else {
            return Ok(Ok(ReadValue::Nothing));
        };
        let length = self.operand_address(below).extra;
        let width = (*formats >= 1).then(|| self.operand(below - 1).expect_integer());
        let width = match width.map(usize::try_from).transpose() {
            Ok(width) if width.is_none_or(|width| width <= text_writer::MAX_WIDTH) => width,
            Ok(_) | Err(_) => return Ok(Err(Status::INTP_ARGUMENT)),
        };
        let order = self.order_of(*file);
        let input = self.host.input(id);
        let (consumed, result) = binary::read_item(input, *ty, length, width, order);
        if consumed > 0 {
            self.host.consume(id, consumed);
        }
        match result {
            ReadResult::Incomplete => Err(id),
            ReadResult::Value(value) => Ok(Ok(value)),
            ReadResult::Failed(status) => Ok(Err(status)),
        }
    }

    pub(super) fn order_of(&self, file: FileCell) -> ByteOrder {
        if file.has(FileFlag::Reverse) {
            self.byte_order.reversed()
        } else {
            self.byte_order
        }
    }

    pub(super) fn store_read(&mut self, target: Address, value: ReadValue) {
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
    pub(super) fn clear_rest(&mut self, parts: &[ReadPart], mut below: usize) {
        for part in parts {
            if let ReadPart::Value { .. } = part {
                let target = self.operand_address(below);
                self.memory().set(target, Cell::Uninit);
            }
            below = below.saturating_sub(part_operands(part));
        }
    }
}

/// The configuration that a text is, or the bytes of a binary file.
pub(super) fn config_of(value: &ReadValue) -> Option<Config> {
    match value {
        ReadValue::Text(text) => Config::parse(&text.to_string_lossless()),
        ReadValue::Integer(word) => Some(binary::config(word.cast_unsigned())),
        ReadValue::Real(_) | ReadValue::Boolean(_) | ReadValue::Nothing => None,
    }
}

/// Whether a SHORT or a BYTE can hold what was read.
pub(super) fn fits(part: &ReadPart, value: &ReadValue) -> bool {
    let small = match part {
        ReadPart::Value {
            ty: ScalarType::Short,
            ..
        } => Small::Short,
        ReadPart::Value {
            ty: ScalarType::Byte,
            ..
        } => Small::Byte,
        ReadPart::Value { .. } | ReadPart::LineEnd => return true,
    };
    let (least, most) = small.range();
    !matches!(value, ReadValue::Integer(value) if !(least..=most).contains(value))
}

pub(super) fn item_format(
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
        (ScalarType::Integer | ScalarType::Short | ScalarType::Byte, None | Some(0)) => {
            ItemKind::Integer { base: 10 }
        }
        (ScalarType::Integer | ScalarType::Short | ScalarType::Byte, Some(base)) => {
            match u32::try_from(base) {
                Ok(base @ 2..=16) => ItemKind::Integer { base },
                Ok(_) | Err(_) => return Err(Status::INTP_ARGUMENT),
            }
        }
        // It ends with its line.
        (ScalarType::Config, _) => ItemKind::Text { length: MAX_STRING },
        (ScalarType::Real, _) => ItemKind::Real,
        (ScalarType::Boolean, _) => ItemKind::Boolean,
        (ScalarType::Text, None | Some(0)) => ItemKind::Text {
            length: length as usize,
        },
        // Quoted strings are not supported.
        (ScalarType::Text, Some(_)) => return Err(Status::INTP_ARGUMENT),
    };
    Ok(ItemFormat {
        kind,
        width,
        line_end: None,
    })
}
