//! `CLEAR`: what is taken out of memory.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{
    Builtin, Context, Outcome, Param, Returns,
    teaching::PAUSE,
    variable_file::{MAX_PARTS, extension, paths_of, program_of},
};
use crate::{
    machine::{
        fault::Fault,
        inspect::{address, parts_of},
    },
    status::Status,
    types::Type,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CLEAR", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: clear },
];

/// `CLEAR('PROGRAM.VR', status)`: its variables lose their values. `CLEAR('PROGRAM.TP', status)`: a TP program is
/// deleted.
///
/// ASSUMPTION: without an extension it is what the program is; a program that is open or that a task executes, and a
/// KAREL program, is status 7004.
fn clear(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let file = context.text(0).to_string_lossless();
    let name = program_of(&file);
    let mut programs = context.programs.iter().enumerate();
    let found = programs.find(|(_, loaded)| loaded.name() == name);
    let status = match found {
        None => Status::MEMO_NO_PROGRAM,
        Some(_) if extension(&file) == "VR" => {
            clear_variables(context, &name);
            Status::OK
        }
        Some((index, loaded))
            if loaded.is_listing()
                && matches!(extension(&file).as_str(), "" | "TP")
                && !context.teaching.is_open(&name)
                && !is_executed(context, index) =>
        {
            context.teaching.deleted.push(name);
            context.put_status(1, Status::OK);
            return Ok(Outcome::DoneThenPause(PAUSE));
        }
        Some(_) => Status::MEMO_IN_USE,
    };
    context.put_status(1, status);
    Ok(Outcome::Done)
}

/// Whether a task is in the program, also as a caller of what it executes.
fn is_executed(context: &Context<'_>, program: usize) -> bool {
    let own = context
        .callers
        .iter()
        .any(|caller| caller.program == program);
    own || context.tasks.is_executed(program)
}

fn clear_variables(context: &mut Context<'_>, program: &str) {
    let Some(loaded) = context.programs.iter().find(|of| of.name() == program) else {
        return;
    };
    let parts = parts_of(context.names(), loaded, MAX_PARTS);
    for (_, cell, ty) in parts {
        if ty != Type::File {
            context.memory.clear(address(cell, &ty), &ty);
        }
    }
    for (name, ty) in loaded.variables() {
        for (_, path) in paths_of(context.names(), program, name, ty) {
            context.paths.clear(path);
        }
    }
}
