//! READ and WRITE.

use super::Checker;
use crate::{
    ast,
    ast::{Item, ItemKind, Path},
    span::Span,
    typed::{Expr, ReadItem, StmtKind, WriteItem},
    types::{JointKind, Type},
};

/// Most values of one item.
const MAX_PARTS: u32 = 1000;

/// File variables that exist without a declaration; WRITE shows their text on the pendant.
pub(super) const PREDEFINED: &[&str] = &[
    "CRTERROR",
    "CRTFUNC",
    "CRTPROMPT",
    "CRTSTATUS",
    "INPUT",
    "OUTPUT",
    "TPDISPLAY",
    "TPERROR",
    "TPFUNC",
    "TPPROMPT",
    "TPSTATUS",
];

impl Checker<'_> {
    pub(super) fn read(&mut self, file: Option<&Path>, items: &[Item]) -> Option<StmtKind> {
        let checked: Vec<Option<ReadItem>> =
            items.iter().map(|item| self.read_item(item)).collect();
        let file = match file {
            Some(path) => self.file(path)?,
            // The keyboard of the pendant.
            None => self.window_place("INPUT"),
        };
        let items = checked.into_iter().collect::<Option<Vec<_>>>()?;
        Some(StmtKind::Read { file, items })
    }

    fn read_item(&mut self, item: &Item) -> Option<ReadItem> {
        let formats = self.formats(item)?;
        let ItemKind::Value(value) = &item.kind else {
            return Some(ReadItem::LineEnd);
        };
        let ast::ExprKind::Path(path) = &value.kind else {
            self.reports.error(value.span, "READ needs a variable here");
            return None;
        };
        let place = self.place(path)?;
        self.expect_transferable("READ", &place.ty, value.span)?;
        Some(ReadItem::Value { place, formats })
    }

    pub(super) fn write(&mut self, file: Option<&Path>, items: &[Item]) -> Option<StmtKind> {
        let checked: Vec<Option<WriteItem>> =
            items.iter().map(|item| self.write_item(item)).collect();
        let file = match file {
            Some(path) if self.is_predefined_file(path) => None,
            Some(path) => Some(self.file(path)?),
            None => None,
        };
        let items = checked.into_iter().collect::<Option<Vec<_>>>()?;
        Some(StmtKind::Write { file, items })
    }

    fn write_item(&mut self, item: &Item) -> Option<WriteItem> {
        let formats = self.formats(item)?;
        let ItemKind::Value(written) = &item.kind else {
            return Some(WriteItem::LineEnd);
        };
        let value = self.expr(written);
        self.expect_transferable("WRITE", &value.ty, written.span)?;
        Some(WriteItem::Value { value, formats })
    }

    /// Whether values of this type have a text form; of arrays and positions, their parts.
    fn expect_transferable(&mut self, statement: &str, ty: &Type, span: Span) -> Option<()> {
        if ty.is_vector() {
            return Some(());
        }
        match ty {
            Type::Joints(JointKind::OfGroup) if statement == "READ" => {
                let message = "READ of JOINTPOS does not know the number of axes";
                let help = "use JOINTPOS6, or an array and CNV_REL_JPOS";
                self.reports.error_with_help(span, message, help);
                None
            }
            Type::Integer
            | Type::Real
            | Type::Boolean
            | Type::Text(_)
            | Type::Config
            | Type::Small(_)
            | Type::Joints(_)
            | Type::Position(_) => Some(()),
            Type::Array(array) if array.is_open() => {
                let message = format!("{statement} of {ty} needs its elements");
                self.reports.error(span, message);
                None
            }
            Type::Array(array) => {
                if ty.size() > MAX_PARTS {
                    let message = format!("{statement} of more than {MAX_PARTS} values at once");
                    self.reports.error(span, message);
                    return None;
                }
                self.expect_transferable(statement, &array.element, span)
            }
            Type::Error => None,
            Type::File | Type::Path(_) | Type::Structure(_) => {
                let message = format!("{statement} of {ty} needs its parts");
                self.reports.error(span, message);
                None
            }
        }
    }

    fn formats(&mut self, item: &Item) -> Option<Vec<Expr>> {
        if matches!(item.kind, ItemKind::LineEnd) && !item.formats.is_empty() {
            self.reports.error(item.span, "CR takes no format");
            return None;
        }
        Some(
            item.formats
                .iter()
                .map(|format| self.integer(format))
                .collect(),
        )
    }

    pub(super) fn is_predefined_file(&self, path: &Path) -> bool {
        path.steps.is_empty()
            && PREDEFINED.contains(&path.root.text.as_str())
            && !self.is_declared(&path.root.text)
    }
}
