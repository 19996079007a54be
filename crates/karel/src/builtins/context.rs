//! What the code of a built-in asks of its arguments and its surroundings.

use super::{Context, variable};
use crate::{
    host::{FileOperation, InputEnd, OpenMode, Progress},
    machine::{
        Names,
        cell::{Address, Cell},
        fault::Fault,
    },
    position::{JointPosition, XyzwprExt},
    status::Status,
    types::{PositionKind, Type},
    value::Text,
};

impl Context<'_> {
    /// What finds a variable by its name.
    pub(super) fn names(&self) -> Names<'_> {
        Names {
            programs: self.programs,
            paths: self.paths,
            created: self.created,
            globals: self.memory.globals,
        }
    }

    /// Says why something that is correct has another effect than many expect.
    pub(super) fn explain(&mut self, why: &dyn Fn() -> String) {
        let place = (self.program.name(), self.running.line);
        self.host.explain(self.task, place, why);
    }

    pub(super) fn arg(&self, number: usize) -> &Cell {
        let index = number + usize::from(self.site.result_in_memory);
        self.operands
            .get(index)
            .expect("the checker counts arguments")
    }

    pub(super) fn has_arg(&self, number: usize) -> bool {
        number < self.site.types.len()
    }

    pub(super) fn ty(&self, number: usize) -> &Type {
        self.site
            .types
            .get(number)
            .expect("the checker counts arguments")
    }

    pub(super) fn integer(&self, number: usize) -> i32 {
        self.arg(number).expect_integer()
    }

    pub(super) fn real(&self, number: usize) -> f32 {
        self.arg(number).expect_real()
    }

    pub(super) fn text(&self, number: usize) -> Text {
        self.arg(number).expect_text()
    }

    pub(super) fn boolean(&self, number: usize) -> bool {
        *self.arg(number) == Cell::Boolean(true)
    }

    /// The value of an argument that is read and written.
    pub(super) fn in_out(&self, number: usize) -> &Cell {
        self.memory.get(self.variable(number))
    }

    /// The address of a variable, `None` if a constant stands in its place.
    pub(super) fn address(&self, number: usize) -> Option<Address> {
        let arg = self.arg(number);
        (*arg != Cell::Uninit).then(|| arg.expect_address())
    }

    /// The address of a variable that the checker insists on.
    pub(super) fn variable(&self, number: usize) -> Address {
        self.address(number)
            .expect("the checker insists on a variable")
    }

    /// Where a result of several cells goes.
    pub(super) fn result(&self) -> Address {
        self.operands
            .first()
            .expect("lowering pushes the result's address")
            .expect_address()
    }

    pub(super) fn joints(&self, number: usize) -> Result<JointPosition, Fault> {
        let Type::Joints(kind) = self.ty(number) else {
            unreachable!("the checker insists on a JOINTPOS")
        };
        self.memory.joints(self.variable(number), *kind)
    }

    pub(super) fn position(&self, number: usize, kind: PositionKind) -> Result<XyzwprExt, Fault> {
        self.memory.position(self.variable(number), kind)
    }

    pub(super) fn put(&mut self, number: usize, value: Cell) {
        if let Some(address) = self.address(number) {
            self.memory.set(address, value);
        }
    }

    pub(super) fn put_status(&mut self, number: usize, status: Status) {
        self.put(number, Cell::Integer(status.0));
    }

    /// The elements of an array of strings.
    pub(super) fn texts(&self, number: usize) -> Vec<Option<String>> {
        let at = self.variable(number);
        let length = variable::array_length(self.ty(number), at.extra);
        let cells = (0..length).map(|offset| self.memory.get(at.plus(offset)));
        let texts = cells.map(|cell| {
            let has_value = *cell != Cell::Uninit;
            has_value.then(|| cell.expect_text().to_string_lossless())
        });
        texts.collect()
    }

    /// Stores texts into an array of strings from its first element on, as many as fit, cut to the
    /// length of its strings. How many those were.
    pub(super) fn put_texts(&mut self, number: usize, texts: impl Iterator<Item = Text>) -> i32 {
        let at = self.variable(number);
        let room = variable::array_length(self.ty(number), at.extra);
        let mut longest = crate::types::split_text_array(at.extra).1;
        if let Type::Array(array) = self.ty(number) {
            longest = array.element.length().unwrap_or(longest);
        }
        let mut count = 0;
        for (mut text, offset) in texts.zip(0..room) {
            text.truncate(longest as usize);
            self.memory.set(at.plus(offset), Cell::Text(text));
            count += 1;
        }
        count
    }

    /// The bytes of a file that can be read at once.
    pub(super) fn read_file(&mut self, name: &str) -> Result<Vec<u8>, Status> {
        let file = self.host.open_file(self.task, OpenMode::ReadOnly, name)?;
        let input = self.host.input(file);
        let bytes = match input.end {
            InputEnd::Closed(_) => Ok(input.bytes.to_vec()),
            // A connection or a pipe.
            InputEnd::Open => Err(Status::FILE_ILLEGAL_PARAMETER),
        };
        let _closed = self.host.close_file(file);
        bytes
    }

    /// Replaces a file.
    pub(super) fn write_file(&mut self, name: &str, bytes: &[u8]) -> Result<(), Status> {
        let _none = self
            .host
            .file_operation(self.task, FileOperation::Delete(name));
        let file = self.host.open_file(self.task, OpenMode::ReadWrite, name)?;
        let written = self.host.output(file, bytes);
        let closed = self.host.close_file(file);
        match written {
            Progress::Ready(status) if !status.is_ok() => Err(status),
            Progress::Ready(_) if !closed.is_ok() => Err(closed),
            Progress::Ready(_) => Ok(()),
            Progress::Pending(_) => Err(Status::INTP_WRITE_FAILED),
        }
    }

    /// Stores a string, cut to the variable's length.
    pub(super) fn put_text(&mut self, number: usize, mut text: Text) {
        if let Some(address) = self.address(number) {
            let length = self.ty(number).length().unwrap_or(address.extra);
            text.truncate(length as usize);
            self.memory.set(address, Cell::Text(text));
        }
    }
}
