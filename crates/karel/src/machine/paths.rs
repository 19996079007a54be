//! Nodes of PATH variables.
//!
//! A node is a row of cells behind the variables of the programs, so that a reference to a part of
//! it is an address as any other. A node that is deleted stays with its path for the next one: what
//! a stale reference reads has the right type whatever happens.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    cell::{Address, Cell, Memory},
    fault::Fault,
};
use crate::status::Status;

/// Most PATHs of all routines that run.
pub(crate) const MAX_LOCAL: usize = 10_000;

/// Most nodes of a path, and most cells of all nodes.
const MAX_NODES: usize = 10_000;
const MAX_NODE_CELLS: u32 = 1 << 18;

/// The paths of a machine by the numbers in their cells.
#[derive(Debug, Default)]
pub(crate) struct Paths {
    all: Vec<Nodes>,
    /// Cells of all nodes.
    cells: u32,
    /// Paths of routines that run, and of tasks that ended without returning from them.
    local: BTreeSet<u32>,
    /// Paths of routines that returned, by the size of their nodes.
    free: BTreeMap<u32, Vec<u32>>,
}

#[derive(Debug, Default)]
struct Nodes {
    size: u32,
    /// First cells.
    used: Vec<u32>,
    spare: Vec<u32>,
}

impl Paths {
    /// A path without nodes; `size` cells make a node.
    pub(crate) fn add(&mut self, size: u32) -> Cell {
        self.all.push(Nodes {
            size,
            ..Nodes::default()
        });
        Cell::Path(u32::try_from(self.all.len() - 1).unwrap_or(u32::MAX))
    }

    /// As [`Paths::add`], for a routine that is called.
    pub(crate) fn add_local(&mut self, size: u32) -> Cell {
        let free = self.free.get_mut(&size).and_then(Vec::pop);
        let cell = free.map_or_else(|| self.add(size), Cell::Path);
        let _new = self.local.insert(cell.expect_path());
        cell
    }

    /// Whether so many more routines' paths are within bounds.
    pub(crate) fn has_room(&self, more: usize) -> bool {
        self.local.len() + more <= MAX_LOCAL
    }

    /// The routine of a path is over; its nodes are kept for the next one. Others stay.
    pub(crate) fn free(&mut self, path: u32) {
        if self.local.remove(&path) {
            self.clear(path);
            let size = self.node_cells(path);
            self.free.entry(size).or_default().push(path);
        }
    }

    /// Frees the paths of all routines but these.
    pub(crate) fn keep_only(&mut self, used: &BTreeSet<u32>) {
        for path in self.local.difference(used).copied().collect::<Vec<_>>() {
            self.free(path);
        }
    }

    fn nodes(&self, path: u32) -> &Nodes {
        let nodes = self.all.get(path as usize);
        nodes.expect("loading numbers the paths")
    }

    fn nodes_mut(&mut self, path: u32) -> &mut Nodes {
        let nodes = self.all.get_mut(path as usize);
        nodes.expect("loading numbers the paths")
    }

    pub(crate) fn len(&self, path: u32) -> usize {
        self.nodes(path).used.len()
    }

    pub(crate) fn node_cells(&self, path: u32) -> u32 {
        self.nodes(path).size
    }

    /// The place of a node, the first being 1.
    pub(crate) fn node(&self, path: u32, number: i32) -> Option<Address> {
        let index = usize::try_from(number).ok()?.checked_sub(1)?;
        let cell = self.nodes(path).used.get(index)?;
        Some(Address::global(*cell))
    }

    /// As [`Paths::node`], or INTP-383.
    pub(crate) fn expect_node(&self, path: u32, number: i32) -> Result<Address, Fault> {
        self.node(path, number).ok_or_else(|| {
            let message = format!("There is no node {number}, the path has {}", self.len(path));
            Fault::new(Status::INTP_PATH_NODE, message)
        })
    }

    /// Puts an uninitialized node behind `before` others. `false` if there is no room for more.
    pub(crate) fn insert(&mut self, path: u32, before: usize, memory: &mut Memory<'_>) -> bool {
        let size = self.node_cells(path);
        if self.len(path) >= MAX_NODES {
            return false;
        }
        let first = if let Some(spare) = self.nodes_mut(path).spare.pop() {
            for offset in 0..size {
                memory.set(Address::global(spare).plus(offset), Cell::Uninit);
            }
            spare
        } else {
            let cells = self.cells.saturating_add(size);
            let Ok(first) = u32::try_from(memory.globals.len()) else {
                return false;
            };
            if cells > MAX_NODE_CELLS {
                return false;
            }
            self.cells = cells;
            let end = memory.globals.len() + size as usize;
            memory.globals.resize(end, Cell::Uninit);
            first
        };
        let nodes = &mut self.nodes_mut(path).used;
        nodes.insert(before.min(nodes.len()), first);
        true
    }

    /// Takes a node out, the first being 0.
    pub(crate) fn remove(&mut self, path: u32, index: usize) {
        let nodes = self.nodes_mut(path);
        if index < nodes.used.len() {
            let first = nodes.used.remove(index);
            nodes.spare.push(first);
        }
    }

    pub(crate) fn clear(&mut self, path: u32) {
        let nodes = self.nodes_mut(path);
        let gone = std::mem::take(&mut nodes.used);
        nodes.spare.extend(gone);
    }

    pub(crate) fn clear_all(&mut self) {
        for nodes in &mut self.all {
            let gone = std::mem::take(&mut nodes.used);
            nodes.spare.extend(gone);
        }
        // The tasks are gone, too.
        self.keep_only(&BTreeSet::new());
    }
}
