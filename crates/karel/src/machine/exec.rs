//! The loop that executes instructions.
//!
//! Instructions that may wait look at their operands without taking them, so that they can be
//! executed again when the wait is over. Nothing here recurses.

use super::{
    Loaded, arithmetic,
    cell::{Address, Cell, FileCell, Memory},
    fault::Fault,
    task::{Caller, Pending, Task},
};
use crate::{
    ast::Waits,
    builtins::{Context, Outcome},
    host::{Host, MotionRequest, MoveEnd, Progress, TaskId, Wait},
    ir::Op,
    program::Program,
    run::Limits,
    status::Status,
    types::{MAX_STRING, PositionKind},
    value::{Text, real_of},
};

pub(super) struct Exec<'a> {
    pub(super) id: TaskId,
    pub(super) program: &'a Program,
    pub(super) global_base: u32,
    pub(super) globals: &'a mut Vec<Cell>,
    pub(super) programs: &'a [Loaded],
    pub(super) task: &'a mut Task,
    pub(super) host: &'a mut dyn Host,
    pub(super) limits: &'a Limits,
}

/// Why the loop stopped.
pub(super) enum Stop {
    OutOfFuel,
    Blocked(Wait),
    Ended,
    Failed(Fault),
}

/// What follows an instruction.
pub(super) enum Flow {
    /// The instruction after it.
    Next,
    /// The task's counter was set.
    Jumped,
    /// The same instruction again, later.
    Blocked(Wait),
    Ended,
}

impl Exec<'_> {
    /// Executes at most `fuel` instructions; returns why it stopped and how many it were.
    pub(super) fn run(&mut self, fuel: u32) -> (Stop, u32) {
        for used in 0..fuel {
            let op = *self
                .program
                .code
                .ops
                .get(self.task.pc)
                .expect("code ends with a return");
            match self.step(op) {
                Ok(Flow::Next) => self.task.pc += 1,
                Ok(Flow::Jumped) => {}
                Ok(Flow::Blocked(wait)) => return (Stop::Blocked(wait), used + 1),
                Ok(Flow::Ended) => return (Stop::Ended, used + 1),
                Err(fault) => return (Stop::Failed(fault), used + 1),
            }
        }
        (Stop::OutOfFuel, fuel)
    }

    #[inline]
    fn step(&mut self, op: Op) -> Result<Flow, Fault> {
        match op {
            Op::PushInteger(value) => self.push(Cell::Integer(value)),
            Op::PushReal(value) => self.push(Cell::Real(value)),
            Op::PushBoolean(value) => self.push(Cell::Boolean(value)),
            Op::PushText(row) => {
                let text = row_of(&self.program.code.texts, row).clone();
                self.push(Cell::Text(text));
            }
            Op::PushDiscard => self.push(Cell::Uninit),
            Op::LoadGlobal(cell) => self.load(self.global(cell))?,
            Op::LoadLocal(cell) => self.load(self.local(cell))?,
            Op::LoadParam(cell) => self.load(self.param(cell))?,
            Op::LoadIndirect => {
                let address = self.pop_address();
                self.load(address)?;
            }
            Op::AddressGlobal(cell) => self.push(Cell::Address(self.global(cell))),
            Op::AddressLocal(cell) => self.push(Cell::Address(self.local(cell))),
            Op::AddressParam(cell) => self.push(Cell::Address(self.param(cell))),
            Op::Offset(cells) => self.change_address(|address| address.plus(cells)),
            Op::Extra(extra) => self.change_address(|address| address.with_extra(extra)),
            Op::Index(row) => self.index(row)?,
            Op::OpenIndex(cells) => self.open_index(cells)?,
            Op::StoreGlobal(cell) => self.store(self.global(cell)),
            Op::StoreLocal(cell) => self.store(self.local(cell)),
            Op::StoreParam(cell) => self.store(self.param(cell)),
            Op::StoreTextParam(cell) => {
                let address = self.param(cell);
                self.truncate(address.extra);
                self.store(address);
            }
            Op::StoreIndirect => {
                let value = self.pop();
                let address = self.pop_address();
                self.memory().set(address, value);
            }
            Op::Truncate(length) => self.truncate(length),
            Op::Jump(target) => return Ok(self.jump(target)),
            Op::JumpIfFalse(target) => {
                if !self.pop_boolean() {
                    return Ok(self.jump(target));
                }
            }
            Op::JumpIfTrue(target) => {
                if self.pop_boolean() {
                    return Ok(self.jump(target));
                }
            }
            Op::IntegerToReal => {
                let value = self.pop_integer();
                self.push(Cell::Real(real_of(value)));
            }
            Op::AddInteger => self.integers(arithmetic::add)?,
            Op::SubtractInteger => self.integers(arithmetic::subtract)?,
            Op::MultiplyInteger => self.integers(arithmetic::multiply)?,
            Op::DivInteger => self.integers(arithmetic::div)?,
            Op::ModInteger => self.integers(arithmetic::modulo)?,
            Op::AndInteger => self.integers(|a, b| Ok(a & b))?,
            Op::OrInteger => self.integers(|a, b| Ok(a | b))?,
            Op::AddReal => self.reals(|a, b| arithmetic::finite(a + b))?,
            Op::SubtractReal => self.reals(|a, b| arithmetic::finite(a - b))?,
            Op::MultiplyReal => self.reals(|a, b| arithmetic::finite(a * b))?,
            Op::DivideReal => self.reals(arithmetic::divide)?,
            Op::AndBoolean => self.booleans(|a, b| a && b),
            Op::OrBoolean => self.booleans(|a, b| a || b),
            Op::CompareInteger(relation) => {
                let (b, a) = (self.pop_integer(), self.pop_integer());
                self.push(Cell::Boolean(arithmetic::holds(relation, a.cmp(&b))));
            }
            Op::CompareReal(relation) => {
                let (b, a) = (self.pop_real(), self.pop_real());
                self.push(Cell::Boolean(arithmetic::holds(
                    relation,
                    arithmetic::order(a, b),
                )));
            }
            Op::NegateInteger
            | Op::NegateReal
            | Op::NotBoolean
            | Op::NotInteger
            | Op::Concatenate
            | Op::CompareText(_)
            | Op::CompareBoolean(_)
            | Op::CopyCells(_)
            | Op::CopyPosition { .. } => self.rare(op)?,
            Op::Call(routine) => return self.call(routine),
            Op::Return => return Ok(self.return_from_call()),
            Op::MissingReturn
            | Op::NoCase
            | Op::EndTask
            | Op::Builtin(_)
            | Op::LoadSystem(_)
            | Op::StoreSystem(_)
            | Op::FetchSystem(_)
            | Op::ReturnSystem(_)
            | Op::OpenFile
            | Op::CloseFile
            | Op::CancelFile
            | Op::Read(_)
            | Op::Write(_)
            | Op::Delay
            | Op::Move(_) => return self.outward(op),
        }
        Ok(Flow::Next)
    }

    /// Instructions that are too seldom to make the hot loop larger.
    #[inline(never)]
    fn rare(&mut self, op: Op) -> Result<(), Fault> {
        match op {
            Op::NegateInteger => {
                let value = self.pop_integer();
                self.push(Cell::Integer(
                    value.checked_neg().ok_or_else(Fault::overflow)?,
                ));
            }
            Op::NegateReal => {
                let value = self.pop_real();
                self.push(Cell::Real(-value));
            }
            Op::NotBoolean => {
                let value = self.pop_boolean();
                self.push(Cell::Boolean(!value));
            }
            Op::NotInteger => {
                let value = self.pop_integer();
                self.push(Cell::Integer(!value));
            }
            Op::Concatenate => {
                let (b, mut a) = (self.pop_text(), self.pop_text());
                a.append(b.as_bytes(), MAX_STRING);
                self.push(Cell::Text(a));
            }
            Op::CompareText(relation) => {
                let (b, a) = (self.pop_text(), self.pop_text());
                let order = a.as_bytes().cmp(b.as_bytes());
                self.push(Cell::Boolean(arithmetic::holds(relation, order)));
            }
            Op::CompareBoolean(relation) => {
                let (b, a) = (self.pop_boolean(), self.pop_boolean());
                self.push(Cell::Boolean(arithmetic::holds(relation, a.cmp(&b))));
            }
            Op::CopyCells(cells) => {
                let (from, to) = (self.pop_address(), self.pop_address());
                self.memory().copy_cells(from, to, cells);
            }
            Op::CopyPosition {
                from: from_kind,
                to: to_kind,
            } => {
                let (from, to) = (self.pop_address(), self.pop_address());
                let position = self.memory().position(from, from_kind)?;
                self.memory().set_position(to, to_kind, &position);
            }
            _ => unreachable!("not a rare instruction: {op:?}"),
        }
        Ok(())
    }

    /// Instructions that leave the machine, or end something.
    #[inline(never)]
    fn outward(&mut self, op: Op) -> Result<Flow, Fault> {
        match op {
            Op::MissingReturn => Err(Fault::new(
                Status::new(12, 321),
                "END of a function without RETURN",
            )),
            Op::NoCase => Err(Fault::new(Status::INTP_NO_CASE, "No match in CASE")),
            Op::EndTask => {
                self.close_locals(0);
                Ok(Flow::Ended)
            }
            Op::Builtin(row) => self.builtin(row),
            Op::LoadSystem(row) => self.load_system(row),
            Op::StoreSystem(row) => self.store_system(row),
            Op::FetchSystem(row) => self.fetch_system(row),
            Op::ReturnSystem(row) => self.return_system(row),
            Op::OpenFile => self.open_file(),
            Op::CloseFile => Ok(self.close_file()),
            Op::CancelFile => Ok(self.cancel_file()),
            Op::Read(row) => Ok(self.read(row)),
            Op::Write(row) => self.write(row),
            Op::Delay => self.delay(),
            Op::Move(waits) => self.move_to(waits),
            _ => unreachable!("not an outward instruction: {op:?}"),
        }
    }

    // Operands.

    #[inline]
    pub(super) fn push(&mut self, cell: Cell) {
        self.task.operands.push(cell);
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Cell {
        self.task
            .operands
            .pop()
            .expect("lowering balances the stack")
    }

    #[inline]
    pub(super) fn pop_integer(&mut self) -> i32 {
        match self.pop() {
            Cell::Integer(value) => value,
            other => unreachable!("INTEGER expected on the stack, found {other:?}"),
        }
    }

    #[inline]
    fn pop_real(&mut self) -> f32 {
        match self.pop() {
            Cell::Real(value) => value,
            other => unreachable!("REAL expected on the stack, found {other:?}"),
        }
    }

    #[inline]
    fn pop_boolean(&mut self) -> bool {
        match self.pop() {
            Cell::Boolean(value) => value,
            other => unreachable!("BOOLEAN expected on the stack, found {other:?}"),
        }
    }

    pub(super) fn pop_text(&mut self) -> Text {
        match self.pop() {
            Cell::Text(value) => value,
            other => unreachable!("STRING expected on the stack, found {other:?}"),
        }
    }

    #[inline]
    pub(super) fn pop_address(&mut self) -> Address {
        match self.pop() {
            Cell::Address(address) => address,
            other => unreachable!("an address expected on the stack, found {other:?}"),
        }
    }

    /// The operand this far below the top, the top being 0.
    pub(super) fn operand(&self, below: usize) -> &Cell {
        let index = self.task.operands.len().wrapping_sub(below + 1);
        self.task
            .operands
            .get(index)
            .expect("lowering balances the stack")
    }

    pub(super) fn operand_address(&self, below: usize) -> Address {
        match self.operand(below) {
            Cell::Address(address) => *address,
            other => unreachable!("an address expected on the stack, found {other:?}"),
        }
    }

    pub(super) fn drop_operands(&mut self, count: usize) {
        let left = self.task.operands.len().saturating_sub(count);
        self.task.operands.truncate(left);
    }

    #[inline]
    fn change_address(&mut self, change: impl FnOnce(Address) -> Address) {
        let address = self.pop_address();
        self.push(Cell::Address(change(address)));
    }

    #[inline]
    fn integers(
        &mut self,
        compute: impl FnOnce(i32, i32) -> Result<i32, Fault>,
    ) -> Result<(), Fault> {
        let (b, a) = (self.pop_integer(), self.pop_integer());
        self.push(Cell::Integer(compute(a, b)?));
        Ok(())
    }

    #[inline]
    fn reals(&mut self, compute: impl FnOnce(f32, f32) -> Result<f32, Fault>) -> Result<(), Fault> {
        let (b, a) = (self.pop_real(), self.pop_real());
        self.push(Cell::Real(compute(a, b)?));
        Ok(())
    }

    #[inline]
    fn booleans(&mut self, compute: impl FnOnce(bool, bool) -> bool) {
        let (b, a) = (self.pop_boolean(), self.pop_boolean());
        self.push(Cell::Boolean(compute(a, b)));
    }

    // Memory.

    #[inline]
    pub(super) fn memory(&mut self) -> Memory<'_> {
        Memory {
            globals: self.globals,
            frames: &mut self.task.frames,
        }
    }

    #[inline]
    fn global(&self, cell: u32) -> Address {
        Address::global(self.global_base + cell)
    }

    #[inline]
    fn local(&self, cell: u32) -> Address {
        Address::frame(index_u32(self.task.base) + cell)
    }

    #[inline]
    fn param(&self, cell: u32) -> Address {
        match self.task.frames.get(self.task.base + cell as usize) {
            Some(Cell::Address(address)) => *address,
            other => unreachable!("a parameter holds {other:?}"),
        }
    }

    #[inline]
    fn load(&mut self, address: Address) -> Result<(), Fault> {
        let cell = self.memory().get(address).clone();
        if cell == Cell::Uninit {
            return Err(Fault::uninit());
        }
        self.push(cell);
        Ok(())
    }

    #[inline]
    fn store(&mut self, address: Address) {
        let value = self.pop();
        self.memory().set(address, value);
    }

    fn truncate(&mut self, length: u32) {
        if let Some(Cell::Text(text)) = self.task.operands.last_mut() {
            text.truncate(length as usize);
        }
    }

    fn index(&mut self, row: u32) -> Result<(), Fault> {
        let program = self.program;
        let shape = row_of(&program.code.shapes, row);
        let mut offset = 0;
        for (below, dim) in (0..shape.dims.len()).rev().zip(&shape.dims) {
            let Cell::Integer(subscript) = *self.operand(below) else {
                unreachable!("INTEGER subscript expected");
            };
            offset = offset * dim + subscript_offset(subscript, *dim)?;
        }
        self.drop_operands(shape.dims.len());
        self.change_address(|address| address.plus(offset * shape.element_cells));
        Ok(())
    }

    fn open_index(&mut self, element_cells: u32) -> Result<(), Fault> {
        let subscript = self.pop_integer();
        let address = self.pop_address();
        let offset = subscript_offset(subscript, address.extra)?;
        self.push(Cell::Address(address.plus(offset * element_cells)));
        Ok(())
    }

    // Control.

    #[inline]
    fn jump(&mut self, target: u32) -> Flow {
        self.task.pc = target as usize;
        Flow::Jumped
    }

    fn call(&mut self, routine: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let code = row_of(&program.code.routines, routine);
        let base = self.task.frames.len();
        let cells = base + code.frame_cells as usize;
        if self.task.callers.len() >= self.limits.call_depth || cells > self.limits.stack_cells {
            return Err(Fault::new(Status::INTP_STACK_OVERFLOW, "Stack overflow"));
        }
        self.task.callers.push(Caller {
            routine: self.task.routine,
            pc: self.task.pc + 1,
            base: self.task.base,
        });
        let args = self.task.operands.len() - code.args as usize;
        self.task.frames.extend(self.task.operands.drain(args..));
        self.task.frames.resize(cells, Cell::Uninit);
        for file in &code.files {
            if let Some(cell) = self.task.frames.get_mut(base + *file as usize) {
                *cell = Cell::File(FileCell::default());
            }
        }
        self.task.base = base;
        self.task.routine = routine;
        Ok(self.jump(code.entry))
    }

    fn return_from_call(&mut self) -> Flow {
        let program = self.program;
        let has_files = !row_of(&program.code.routines, self.task.routine)
            .files
            .is_empty();
        if has_files {
            self.close_locals(self.task.base);
        }
        let Some(caller) = self.task.callers.pop() else {
            return Flow::Ended;
        };
        self.task.frames.truncate(self.task.base);
        self.task.base = caller.base;
        self.task.routine = caller.routine;
        self.task.pc = caller.pc;
        Flow::Jumped
    }

    /// Closes the FILE variables of frames that go away.
    fn close_locals(&mut self, from: usize) {
        let cells = self.task.frames.get(from..).unwrap_or_default();
        for file in cells.iter().filter_map(super::open_file) {
            let _ = self.host.close_file(file);
        }
    }

    fn builtin(&mut self, row: u32) -> Result<Flow, Fault> {
        if let Some(flow) = self.pause_is_over() {
            return Ok(flow);
        }
        let program = self.program;
        let site = row_of(&program.code.builtins, row);
        let count = site.operands as usize;
        let start = self.task.operands.len() - count;
        let mut context = Context {
            task: self.id,
            program: self.program,
            programs: self.programs,
            host: self.host,
            memory: Memory {
                globals: self.globals,
                frames: &mut self.task.frames,
            },
            operands: self.task.operands.get(start..).unwrap_or_default(),
            site,
        };
        let outcome = (site.builtin.code)(&mut context)?;
        match outcome {
            Outcome::Pending(wait) => return Ok(Flow::Blocked(wait)),
            Outcome::Done => self.drop_operands(count),
            Outcome::Value(value) => {
                self.drop_operands(count);
                self.push(value);
            }
            Outcome::DoneThenPause(pause) => {
                self.drop_operands(count);
                let until = self.host.now() + pause;
                self.task.pending = Pending::Until(until);
                return Ok(Flow::Blocked(Wait::Until(until)));
            }
        }
        Ok(Flow::Next)
    }

    /// If the instruction is a pause that was begun: whether it goes on waiting.
    fn pause_is_over(&mut self) -> Option<Flow> {
        let Pending::Until(until) = self.task.pending else {
            return None;
        };
        if self.host.now() < until {
            return Some(Flow::Blocked(Wait::Until(until)));
        }
        self.task.pending = Pending::None;
        Some(Flow::Next)
    }

    fn delay(&mut self) -> Result<Flow, Fault> {
        if let Some(flow) = self.pause_is_over() {
            return Ok(flow);
        }
        let milliseconds = self.pop_integer();
        let Ok(milliseconds) = u64::try_from(milliseconds) else {
            return Err(Fault::argument(format!(
                "DELAY of {milliseconds} ms, less than 0"
            )));
        };
        let until = self.host.now() + std::time::Duration::from_millis(milliseconds);
        self.task.pending = Pending::Until(until);
        Ok(Flow::Blocked(Wait::Until(until)))
    }

    fn move_to(&mut self, waits: Waits) -> Result<Flow, Fault> {
        let motion = if let Pending::Motion(motion) = self.task.pending {
            motion
        } else {
            let at = self.operand_address(0);
            let target = self.memory().position(at, PositionKind::XyzwprExt)?;
            let request = MotionRequest {
                target,
                group: 1,
                end: match waits {
                    Waits::Yes => MoveEnd::Wait,
                    Waits::No => MoveEnd::NoWait,
                },
                program: self.program.name_arc(),
                line: self
                    .program
                    .code
                    .lines
                    .get(self.task.pc)
                    .copied()
                    .unwrap_or(0),
            };
            match self.host.start_motion(self.id, request) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(Ok(motion)) => motion,
                Progress::Ready(Err(status)) => {
                    return Err(Fault::from_host(status, "The motion was refused"));
                }
            }
        };
        if waits == Waits::Yes {
            self.task.pending = Pending::Motion(motion);
            match self.host.motion_ended(motion) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(status) if !status.is_ok() => {
                    return Err(Fault::from_host(status, "The motion failed"));
                }
                Progress::Ready(_) => self.task.pending = Pending::None,
            }
        }
        self.drop_operands(1);
        Ok(Flow::Next)
    }
}

fn subscript_offset(subscript: i32, length: u32) -> Result<u32, Fault> {
    match u32::try_from(subscript) {
        Ok(index) if (1..=length).contains(&index) => Ok(index - 1),
        Ok(_) | Err(_) => Err(Fault::new(
            Status::INTP_SUBSCRIPT,
            format!("Invalid subscript {subscript}, the array has {length} elements"),
        )),
    }
}

/// A row of a table of the code.
#[inline]
pub(super) fn row_of<T>(table: &[T], row: u32) -> &T {
    table.get(row as usize).expect("lowering filled its tables")
}

fn index_u32(index: usize) -> u32 {
    u32::try_from(index).expect("frames are limited far below 32 bits")
}
