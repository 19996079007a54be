//! Nodes of paths.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{
        cell::{Address, Cell},
        fault::Fault,
    },
    status::Status,
    types::{PathType, Small, Type},
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "APPEND_NODE", params: &[Param::Path, Param::OutInteger], required: 2, returns: Returns::Nothing, code: append },
    Builtin { name: "COPY_PATH", params: &[Param::Path, Param::Integer, Param::Integer, Param::Path, Param::OutInteger], required: 5, returns: Returns::Nothing, code: copy },
    Builtin { name: "DELETE_NODE", params: &[Param::Path, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: delete },
    Builtin { name: "INSERT_NODE", params: &[Param::Path, Param::Integer, Param::OutInteger], required: 3, returns: Returns::Nothing, code: insert },
    Builtin { name: "NODE_SIZE", params: &[Param::Path], required: 1, returns: Returns::Integer, code: node_size },
    Builtin { name: "PATH_LEN", params: &[Param::Path], required: 1, returns: Returns::Integer, code: length },
];

fn path(context: &Context<'_>, number: usize) -> u32 {
    context.memory.get(context.variable(number)).expect_path()
}

fn path_type<'a>(context: &'a Context<'_>, number: usize) -> &'a PathType {
    let Type::Path(ty) = context.ty(number) else {
        unreachable!("the checker insists on a PATH")
    };
    ty
}

fn length(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let length = context.paths.len(path(context, 0));
    let length = i32::try_from(length).unwrap_or(i32::MAX);
    Ok(Outcome::Value(Cell::Integer(length)))
}

/// The new node is uninitialized.
fn append(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let path = path(context, 0);
    let last = context.paths.len(path);
    let status = put(context, path, last);
    context.put_status(1, status);
    Ok(Outcome::Done)
}

fn put(context: &mut Context<'_>, path: u32, before: usize) -> Status {
    if context.paths.insert(path, before, &mut context.memory) {
        Status::OK
    } else {
        Status::INTP_LIMIT
    }
}

/// The index of a node that is there.
fn index(context: &Context<'_>, path: u32, number: i32) -> Result<usize, Status> {
    let index = usize::try_from(number).ok().and_then(|n| n.checked_sub(1));
    let there = |index: &usize| *index < context.paths.len(path);
    index.filter(there).ok_or(Status::INTP_PATH_NODE)
}

/// The new node is before the one that had its number, and uninitialized.
fn insert(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let path = path(context, 0);
    let status = match index(context, path, context.integer(1)) {
        Ok(index) => put(context, path, index),
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

fn delete(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let path = path(context, 0);
    let status = match index(context, path, context.integer(1)) {
        Ok(index) => {
            context.paths.remove(path, index);
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// `COPY_PATH(source, first, last, target, status)`: the target loses what it had; 0 and 0 are all
/// nodes; backwards if the first is behind the last.
///
/// ASSUMPTION: the header is copied, too; nodes of another type are status 12319.
fn copy(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let status = copied(context).err().unwrap_or(Status::OK);
    context.put_status(4, status);
    Ok(Outcome::Done)
}

fn copied(context: &mut Context<'_>) -> Result<(), Status> {
    let (source, target) = (path(context, 0), path(context, 3));
    let same_header = path_type(context, 0).header == path_type(context, 3).header;
    if path_type(context, 0).node != path_type(context, 3).node {
        return Err(Status::INTP_TYPE);
    }
    let (mut first, mut last) = (context.integer(1), context.integer(2));
    let mut numbers: Vec<i32> = Vec::new();
    if (first, last) == (0, 0) {
        (first, last) = (1, i32::try_from(context.paths.len(source)).unwrap_or(0));
        numbers.extend(first..=last);
    } else {
        let _there = (
            index(context, source, first)?,
            index(context, source, last)?,
        );
        if first <= last {
            numbers.extend(first..=last);
        } else {
            numbers.extend((last..=first).rev());
        }
    }
    let size = context.paths.node_cells(source);
    let cells = |context: &Context<'_>, at: Address, size: u32| -> Vec<Cell> {
        let cells = 0..size;
        cells
            .map(|offset| context.memory.get(at.plus(offset)).clone())
            .collect()
    };
    let mut nodes = Vec::new();
    for number in numbers {
        let at = context.paths.node(source, number);
        nodes.push(cells(context, at.ok_or(Status::INTP_PATH_NODE)?, size));
    }
    context.paths.clear(target);
    for (node, number) in nodes.into_iter().zip(1..) {
        let length = context.paths.len(target);
        if !context.paths.insert(target, length, &mut context.memory) {
            return Err(Status::INTP_LIMIT);
        }
        let at = context
            .paths
            .node(target, number)
            .ok_or(Status::INTP_PATH_NODE)?;
        for (cell, offset) in node.into_iter().zip(0..) {
            context.memory.set(at.plus(offset), cell);
        }
    }
    if same_header {
        let header = context.ty(0).size() - 1;
        let (from, to) = (context.variable(0).plus(1), context.variable(3).plus(1));
        context.memory.copy_cells(from, to, header);
    }
    Ok(())
}

/// Bytes of a node.
fn node_size(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let bytes = bytes_of(&path_type(context, 0).node);
    let bytes = i32::try_from(bytes).unwrap_or(i32::MAX);
    Ok(Outcome::Value(Cell::Integer(bytes)))
}

/// ASSUMPTION: numbers, BOOLEANs and configurations have four bytes, a string its length and two
/// more, and nothing is aligned.
pub(super) fn bytes_of(ty: &Type) -> u64 {
    let mut leaves = Vec::new();
    ty.leaves(&mut leaves);
    let bytes = leaves.iter().map(|leaf| match leaf {
        Type::Text(_) => u64::from(leaf.length().unwrap_or(0)) + 2,
        Type::Small(Small::Short) => 2,
        Type::Small(Small::Byte) => 1,
        Type::Integer
        | Type::Real
        | Type::Boolean
        | Type::Config
        | Type::File
        | Type::Position(_)
        | Type::Joints(_)
        | Type::Array(_)
        | Type::Structure(_)
        | Type::Path(_)
        | Type::Error => 4,
    });
    bytes.sum()
}
