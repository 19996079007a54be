//! The loop that executes instructions.
//!
//! Instructions that may wait look at their operands without taking them, so that they can be
//! executed again when the wait is over. Nothing here recurses.

use super::{
    Loaded, Tasks, arithmetic,
    cell::{Address, Cell, Memory},
    created::Created,
    dictionaries::Dictionaries,
    fault::Fault,
    paths::Paths,
    pulse::Pulses,
    semaphore::Semaphores,
    task::Task,
    teaching::Teaching,
    timer::Timers,
};
use crate::{
    error::RuntimeError,
    host::{Host, TaskId, Wait},
    ir::Op,
    port::{Comments, PortSetup},
    program::Program,
    registers::Registers,
    run::{ByteOrder, Limits},
    status::Status,
    value::real_of,
};

pub(super) struct Exec<'a> {
    pub(super) id: TaskId,
    pub(super) program: &'a Program,
    pub(super) global_base: u32,
    pub(super) globals: &'a mut Vec<Cell>,
    pub(super) programs: &'a [Loaded],
    /// All tasks but this one.
    pub(super) others: &'a mut Tasks,
    pub(super) registers: &'a mut Registers,
    pub(super) timers: &'a mut Timers,
    pub(super) semaphores: &'a mut Semaphores,
    pub(super) pulses: &'a mut Pulses,
    pub(super) byte_order: ByteOrder,
    pub(super) comments: &'a mut Comments,
    pub(super) paths: &'a mut Paths,
    pub(super) created: &'a mut Created,
    pub(super) dictionaries: &'a mut Dictionaries,
    pub(super) port_setup: &'a mut PortSetup,
    pub(super) teaching: &'a mut Teaching,
    pub(super) task: &'a mut Task,
    pub(super) host: &'a mut dyn Host,
    pub(super) limits: &'a Limits,
    /// Instructions that looks at conditions have cost.
    pub(super) looked: u32,
}

/// Why the loop stopped.
pub(super) enum Stop {
    OutOfFuel,
    Blocked(Wait),
    Ended,
    /// Conditions are to be looked at, or the task is to pause.
    Yield,
    Failed(Fault),
    /// The error was posted.
    Aborted(RuntimeError),
}

/// What follows an instruction.
pub(super) enum Flow {
    /// The instruction after it.
    Next,
    /// The task's counter was set.
    Jumped,
    /// The same instruction again, later.
    Blocked(Wait),
    /// The slice looks around before it goes on where the task's counter is.
    Yield,
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
                Ok(Flow::Yield) => return (Stop::Yield, used + 1),
                Err(fault) => return (Stop::Failed(fault), used + 1),
            }
        }
        (Stop::OutOfFuel, fuel)
    }

    /// One instruction, outside of the loop.
    #[inline(never)]
    pub(super) fn single(&mut self, op: Op) -> Result<Flow, Fault> {
        self.step(op)
    }

    #[expect(
        clippy::inline_always,
        reason = "measured: the loop is a sixth faster with it"
    )]
    #[inline(always)]
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
            Op::Rare(op) => self.rare(op)?,
            Op::Call(routine) => return self.call(routine),
            Op::Return => return Ok(self.return_from_call()),
            Op::Outward(op) => return self.outward(op),
        }
        Ok(Flow::Next)
    }

    #[inline]
    pub(super) fn memory(&mut self) -> Memory<'_> {
        Memory {
            globals: self.globals,
            frames: &mut self.task.frames,
        }
    }

    #[inline]
    pub(super) fn global(&self, cell: u32) -> Address {
        Address::global(self.global_base + cell)
    }

    #[inline]
    fn local(&self, cell: u32) -> Address {
        Address::frame(index_u32(self.task.base) + cell)
    }

    #[inline]
    fn param(&self, cell: u32) -> Address {
        let cell = self.task.frames.get(self.task.base + cell as usize);
        cell.expect("a call fills its parameters").expect_address()
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

    pub(super) fn unresolved_variable(&self, cell: u32) -> Fault {
        let mut shared = self.program.shared.iter();
        let name = shared.find(|shared| shared.cell == cell).map_or_else(
            || "variable".to_owned(),
            |shared| format!("variable {} of a program {}", shared.name, shared.program),
        );
        Fault::new(Status::VARS_UNKNOWN, format!("There is no {name}"))
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
            let subscript = self.operand(below).expect_integer();
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

    #[inline]
    pub(super) fn jump(&mut self, target: u32) -> Flow {
        self.task.pc = target as usize;
        Flow::Jumped
    }
}

pub(super) fn subscript_offset(subscript: i32, length: u32) -> Result<u32, Fault> {
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
