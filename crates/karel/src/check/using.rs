//! USING: names that are fields of a structure.

use super::Checker;
use crate::{
    ast::{self, Path},
    typed::{Place, Root, Step, StmtKind},
    types::Type,
};

impl Checker<'_> {
    /// The structures are found once, at the head; the innermost one that has a field gives it.
    ///
    /// ASSUMPTION: a subscript in the head that changes in the body changes nothing.
    pub(super) fn using(&mut self, paths: &[Path], body: &[ast::Stmt]) -> StmtKind {
        let before = self.frame.using.len();
        let mut places = Vec::new();
        for path in paths {
            let Some(place) = self.place(path) else {
                continue;
            };
            if !matches!(place.ty, Type::Structure(_) | Type::Position(_)) {
                if place.ty != Type::Error {
                    let message = format!("{} has no fields to use", place.ty);
                    self.reports.error(path.span, message);
                }
                continue;
            }
            let cell = self.locals.cells;
            self.locals.cells += 1;
            self.frame.using.push((cell, place.ty.clone()));
            places.push((place, cell));
        }
        let body = self.stmts(body);
        self.frame.using.truncate(before);
        StmtKind::Using { places, body }
    }

    /// The field of a structure of a USING around that has this name.
    pub(super) fn using_field(&self, name: &str) -> Option<Place> {
        self.frame.using.iter().rev().find_map(|(cell, ty)| {
            let (offset, ty) = ty.field(name)?;
            Some(Place {
                root: Root::Param(*cell),
                steps: vec![Step::Offset(offset)],
                ty,
            })
        })
    }
}
