//! Typed tree to instructions.

mod condition;
mod expr;
mod motion;
mod place;
mod stmt;
mod transfer;

use std::collections::HashMap;

use crate::{
    check::Checked,
    ir::{Code, Op, Outward, RoutineCode, Signature},
    span::Source,
    tp::Instruction,
    typed::Routine,
};

/// Lowers a program that was checked without errors.
pub(crate) fn lower(program: &Checked, source: &Source) -> Code {
    let mut lowering = Lowering {
        source,
        code: Code::default(),
        texts: HashMap::new(),
        line: 0,
        temp: 0,
        most_cells: 0,
        labels: Vec::new(),
        gotos: Vec::new(),
        is_main: true,
        in_actions: false,
        next_routine: count(program.routines.len()),
        deferred: Vec::new(),
        edges: 0,
    };
    for (index, routine) in program.routines.iter().enumerate() {
        lowering.is_main = index == 0;
        lowering.routine(routine);
    }
    lowering.is_main = false;
    lowering.handlers();
    lowering.code.externals.clone_from(&program.externals);
    lowering.code
}

/// The code of a TP program: one instruction for each line, and the end.
pub(crate) fn listing(name: &std::sync::Arc<str>, instructions: Vec<Instruction>) -> Code {
    let lines = count(instructions.len());
    let mut code = Code {
        ops: (0..lines)
            .map(|row| Op::Outward(Outward::Tp(row)))
            .collect(),
        lines: (1..=lines).collect(),
        tp: instructions,
        ..Code::default()
    };
    code.ops.push(Op::Outward(Outward::EndProgram));
    code.lines.push(lines + 1);
    code.routines.push(RoutineCode {
        name: name.clone(),
        signature: Signature {
            params: Vec::new(),
            result: None,
        },
        entry: 0,
        args: 0,
        frame_cells: 0,
        files: Vec::new(),
        paths: Vec::new(),
    });
    code
}

struct Lowering<'a> {
    source: &'a Source,
    code: Code,
    texts: HashMap<Vec<u8>, u32>,
    /// Source line of the statement that is lowered.
    line: u32,
    /// Next free frame cell for temporaries of a statement.
    temp: u32,
    /// Most frame cells that the routine needs.
    most_cells: u32,
    /// Instruction of each label, once known.
    labels: Vec<Option<usize>>,
    /// Jumps to labels, patched at the end of the routine.
    gotos: Vec<(usize, u32)>,
    is_main: bool,
    /// The actions of a condition handler are lowered.
    in_actions: bool,
    /// Number of the next routine of a condition handler.
    next_routine: u32,
    /// Conditions and actions that become routines behind those of the program.
    deferred: Vec<condition::Deferred<'a>>,
    /// Edges of ports in the condition that is lowered.
    edges: u32,
}

impl<'a> Lowering<'a> {
    fn routine(&mut self, routine: &'a Routine) {
        self.temp = routine.frame_cells;
        self.most_cells = routine.frame_cells;
        self.labels = vec![None; routine.labels as usize];
        self.line = self.source.line(routine.end);
        let entry = self.here();
        self.stmts(&routine.body);
        self.line = self.source.line(routine.end);
        self.emit(if self.is_main {
            Op::Outward(Outward::EndProgram)
        } else if routine.signature.result.is_some() {
            Op::Outward(Outward::MissingReturn)
        } else {
            Op::Return
        });
        self.patch_gotos();
        self.code.routines.push(RoutineCode {
            name: routine.name.as_str().into(),
            signature: routine.signature.clone(),
            entry: count(entry),
            args: routine.first_local,
            frame_cells: self.most_cells,
            files: routine.files.clone(),
            paths: routine.paths.clone(),
        });
    }

    fn patch_gotos(&mut self) {
        for (jump, label) in std::mem::take(&mut self.gotos) {
            if let Some(target) = self.labels.get(label as usize).copied().flatten() {
                self.patch_to(jump, target);
            }
        }
    }

    fn emit(&mut self, op: Op) {
        self.code.ops.push(op);
        self.code.lines.push(self.line);
    }

    /// The next instruction.
    fn here(&self) -> usize {
        self.code.ops.len()
    }

    /// Emits a jump that is patched later, and returns where it is.
    fn emit_jump(&mut self, op: fn(u32) -> Op) -> usize {
        let at = self.here();
        self.emit(op(0));
        at
    }

    /// Lets an earlier jump go to the next instruction.
    fn patch(&mut self, jump: usize) {
        self.patch_to(jump, self.here());
    }

    fn patch_to(&mut self, jump: usize, target: usize) {
        if let Some(Op::Jump(to) | Op::JumpIfFalse(to) | Op::JumpIfTrue(to)) =
            self.code.ops.get_mut(jump)
        {
            *to = count(target);
        }
    }

    /// Frame cells for a value that lives until the end of the statement.
    fn temporary(&mut self, cells: u32) -> u32 {
        let cell = self.temp;
        // What is too large to run is refused when it is called.
        self.temp = self.temp.saturating_add(cells);
        self.most_cells = self.most_cells.max(self.temp);
        cell
    }
}

/// A table row or an instruction number; sources are far too short to exceed it.
fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// Adds a row to a table and returns its number.
fn add_row<T>(table: &mut Vec<T>, row: T) -> u32 {
    table.push(row);
    count(table.len() - 1)
}
