//! MOVE in all of its forms.

use super::{Checker, HandlerPart};
use crate::{
    ast,
    ast::{Path, PathStep},
    typed::{Expr, MoveForm, StmtKind},
    types::{PositionKind, Type},
};

const TARGET: Type = Type::Position(PositionKind::XyzwprExt);

impl Checker<'_> {
    pub(super) fn move_statement(
        &mut self,
        (form, via): (&ast::MoveForm, Option<&ast::Expr>),
        waits: ast::Waits,
        whens: &[ast::When],
        until: Option<&ast::Conditions>,
    ) -> Option<StmtKind> {
        let checked = self.move_form(form);
        if let Some(via) = via
            && !matches!(form, ast::MoveForm::To(_) | ast::MoveForm::Near { .. })
        {
            let message = "VIA stands only in MOVE TO and MOVE NEAR";
            self.reports.error(via.span, message);
        }
        let via = via.map(|via| self.expr_of(via, &TARGET));
        let along = matches!(form, ast::MoveForm::Along(_));
        let outer = std::mem::replace(&mut self.along, along);
        let whens = self.whens(whens);
        let until = until.map(|conditions| {
            self.in_handler(HandlerPart::Condition, |checker| {
                checker.conditions(conditions)
            })
        });
        self.along = outer;
        let (whens, until) = (whens?, until.map_or(Some(None), |until| until.map(Some))?);
        Some(StmtKind::Move {
            form: checked?,
            via,
            waits,
            whens,
            until,
        })
    }

    fn move_form(&mut self, form: &ast::MoveForm) -> Option<MoveForm> {
        Some(match form {
            ast::MoveForm::To(target) => MoveForm::To(self.expr_of(target, &TARGET)),
            ast::MoveForm::Near { target, distance } => MoveForm::Near {
                target: self.expr_of(target, &TARGET),
                distance: self.expr_of(distance, &Type::Real),
            },
            ast::MoveForm::Axis { axis, distance } => MoveForm::Axis {
                axis: self.integer(axis),
                distance: self.expr_of(distance, &Type::Real),
            },
            ast::MoveForm::Relative(vector) => {
                MoveForm::Relative(self.expr_of(vector, &Type::vector()))
            }
            ast::MoveForm::About { vector, angle } => MoveForm::About {
                vector: self.expr_of(vector, &Type::vector()),
                angle: self.expr_of(angle, &Type::Real),
            },
            ast::MoveForm::Away(distance) => MoveForm::Away(self.expr_of(distance, &Type::Real)),
            ast::MoveForm::Along(path) => self.along(path)?,
        })
    }

    /// `path`, or `path[first..last]`.
    fn along(&mut self, path: &Path) -> Option<MoveForm> {
        let (range, whole) = match path.steps.as_slice() {
            [steps @ .., PathStep::Range { first, last, .. }] => {
                let range: (Expr, Expr) = (self.integer(first), self.integer(last));
                (Some(range), steps)
            }
            steps => (None, steps),
        };
        if !whole.is_empty() {
            let message = "MOVE ALONG takes a PATH or some of its nodes, `p[1..3]`";
            self.reports.error(path.span, message);
            return None;
        }
        let whole = Path {
            root: path.root.clone(),
            steps: Vec::new(),
            span: path.root.span,
        };
        let place = self.place(&whole)?;
        let Type::Path(ty) = &place.ty else {
            if place.ty != Type::Error {
                let message = format!("expected a PATH, this is {}", place.ty);
                self.reports.error(path.root.span, message);
            }
            return None;
        };
        let Some((offset, kind)) = position_of(&ty.node) else {
            let message = format!("the nodes of {} have no position", place.ty);
            self.reports.error(path.root.span, message);
            return None;
        };
        Some(MoveForm::Along {
            path: place,
            range,
            offset,
            kind,
        })
    }
}

/// Where the position is in a node.
///
/// ASSUMPTION: the first field that is a POSITION, XYZWPR or XYZWPREXT.
fn position_of(node: &Type) -> Option<(u32, PositionKind)> {
    match node {
        Type::Position(kind) => Some((0, *kind)),
        Type::Structure(structure) => {
            let fields = &mut structure.fields.iter();
            fields.find_map(|field| Some((field.offset, field.ty.position_kind()?)))
        }
        Type::Integer
        | Type::Real
        | Type::Boolean
        | Type::Text(_)
        | Type::File
        | Type::Config
        | Type::Joints(_)
        | Type::Small(_)
        | Type::Array(_)
        | Type::Path(_)
        | Type::Error => None,
    }
}
