//! Types as a program writes them: names, strings, arrays, structures.

use std::sync::Arc;

use super::{Checker, scope::Symbol};
use crate::{
    ast::{Dim, Expr, Name, Param, TypeExpr, TypeKind},
    typed::Constant,
    types::{
        ArrayType, Field, MAX_CELLS, MAX_NODE, MAX_OPEN_DIMS, MAX_TYPE_DEPTH, PathType,
        StructureType, TextLength, Type, absent,
    },
};

const BASIC_TYPES: [&str; 8] = [
    "INTEGER",
    "REAL",
    "BOOLEAN",
    "STRING",
    "FILE",
    "POSITION",
    "XYZWPR",
    "XYZWPREXT",
];

impl Checker<'_> {
    pub(super) fn type_of(&mut self, written: &TypeExpr, declared_as: Option<&str>) -> Type {
        match &written.kind {
            TypeKind::Name(name) => self.named_type(name),
            TypeKind::Text(None) => Type::TEXT,
            TypeKind::Text(Some(length)) => {
                match self.length(length, self.generation.longest_string()) {
                    Some(length) => Type::Text(TextLength::AtMost(length)),
                    None => Type::Error,
                }
            }
            TypeKind::Array { dims, element } => self.array_type(dims, element),
            TypeKind::Structure(fields) => self.structure_type(fields, declared_as, written),
            TypeKind::Path { header, node } => {
                self.path_type(header.as_deref(), node.as_deref(), written)
            }
        }
    }

    fn named_type(&mut self, name: &Name) -> Type {
        if let Some(Symbol::Type(ty)) = self.find_symbol(&name.text) {
            return ty.clone();
        }
        if let Some(ty) = Type::named(&name.text) {
            return ty;
        }
        let text = &name.text;
        if let Some((ty, used_by)) = absent(text) {
            let message = format!(
                "{text} belongs to what is not there ({used_by}): built-ins that use it are INTP-320"
            );
            self.reports.warning(name.span, message);
            return ty;
        }
        self.report_unknown(name, &format!("there is no type `{text}`"), &BASIC_TYPES);
        Type::Error
    }

    /// BYTE and SHORT save room where there are many of them, and nowhere else.
    pub(super) fn refuse_small(&mut self, ty: &Type, written: &TypeExpr) {
        if matches!(ty, Type::Small(_)) {
            let message = format!("{ty} can only be an element of an array or a field");
            let help = "use INTEGER";
            self.reports.error_with_help(written.span, message, help);
        }
    }

    fn array_type(&mut self, dims: &[Dim], element: &TypeExpr) -> Type {
        let element_type = self.type_of(element, None);
        let open = dims.is_empty() || matches!(dims, [Dim::Open(_)]);
        if !(open && element_type == Type::TEXT) {
            self.refuse_open(&element_type, element);
        }
        let all_open = dims.iter().all(|dim| matches!(dim, Dim::Open(_)));
        let mut lengths = Vec::new();
        for dim in dims {
            match dim {
                Dim::Length(length) => match self.length(length, MAX_CELLS as usize) {
                    Some(length) => lengths.push(length),
                    None => return Type::Error,
                },
                Dim::Open(_) if dims.len() == 1 => {}
                Dim::Open(_) if all_open && dims.len() <= MAX_OPEN_DIMS => lengths.push(0),
                Dim::Open(span) => {
                    let message = format!(
                        "open dimensions stand alone, and there are at most {MAX_OPEN_DIMS}"
                    );
                    self.reports.error(*span, message);
                    return Type::Error;
                }
            }
        }
        let depth = 1 + element_type.depth();
        let array = ArrayType {
            dims: lengths,
            element: element_type,
            depth,
        };
        self.limited(Type::Array(Arc::new(array)), element)
    }

    fn structure_type(
        &mut self,
        written: &[Param],
        declared_as: Option<&str>,
        whole: &TypeExpr,
    ) -> Type {
        let Some(name) = declared_as else {
            let message = "a STRUCTURE needs a name of its own, in a TYPE section";
            self.reports.error(whole.span, message);
            return Type::Error;
        };
        let mut fields: Vec<Field> = Vec::new();
        let mut size = 0_u32;
        for group in written {
            let ty = self.type_of(&group.ty, None);
            self.refuse_open(&ty, &group.ty);
            for field in &group.names {
                if fields.iter().any(|known| known.name == field.text) {
                    self.reports
                        .error(field.span, format!("`{}` is declared twice", field.text));
                }
                fields.push(Field {
                    name: field.text.clone(),
                    ty: ty.clone(),
                    offset: size,
                });
                size = size.saturating_add(ty.size());
            }
        }
        let depth = 1 + fields
            .iter()
            .map(|field| field.ty.depth())
            .max()
            .unwrap_or(0);
        let structure = StructureType {
            name: name.to_owned(),
            fields,
            size,
            depth,
        };
        self.limited(Type::Structure(Arc::new(structure)), whole)
    }

    /// `PATH PATHHEADER = t, NODEDATA = t`.
    ///
    /// ASSUMPTION: a header is a structure; both parts hold neither FILEs nor other paths.
    fn path_type(
        &mut self,
        header: Option<&TypeExpr>,
        node: Option<&TypeExpr>,
        whole: &TypeExpr,
    ) -> Type {
        let header = header.map(|written| {
            let ty = self.path_part(written);
            if !matches!(ty, Type::Structure(_) | Type::Error) {
                let message = format!("a PATHHEADER must be a STRUCTURE, this is {ty}");
                self.reports.error(written.span, message);
            }
            ty
        });
        let node = node.map_or_else(Type::standard_node, |written| self.path_part(written));
        let depth = header.as_ref().map_or(0, Type::depth).max(node.depth());
        let path = PathType {
            header,
            node,
            depth: depth + 1,
        };
        self.limited(Type::Path(Arc::new(path)), whole)
    }

    fn path_part(&mut self, written: &TypeExpr) -> Type {
        let ty = self.type_of(written, None);
        self.refuse_open(&ty, written);
        if !ty.is_copied() {
            let message = "a FILE or a PATH cannot be in a PATH";
            self.reports.error(written.span, message);
            return Type::Error;
        }
        if ty.size() > MAX_NODE {
            let message = format!("a node has more than {MAX_NODE} cells of memory");
            self.reports.error(written.span, message);
        }
        ty
    }

    fn limited(&mut self, ty: Type, written: &TypeExpr) -> Type {
        let message = if ty.depth() > MAX_TYPE_DEPTH {
            format!("more than {MAX_TYPE_DEPTH} arrays and structures in each other")
        } else if ty.size() > MAX_CELLS {
            format!("a value of this type needs more than {MAX_CELLS} cells of memory")
        } else {
            return ty;
        };
        self.reports.error(written.span, message);
        Type::Error
    }

    /// A length of a string or an array: a constant from 1 to `most`.
    fn length(&mut self, written: &Expr, most: usize) -> Option<u32> {
        let constant = self.constant_value(written)?;
        if let Constant::Integer(value) = constant
            && let Ok(length) = u32::try_from(value)
            && (1..=most).contains(&(length as usize))
        {
            return Some(length);
        }
        self.reports.error(
            written.span,
            format!("a length must be an INTEGER from 1 to {most}"),
        );
        None
    }

    /// Strings and arrays without a length are for parameters only.
    pub(super) fn refuse_open(&mut self, ty: &Type, written: &TypeExpr) {
        let open = *ty == Type::TEXT || matches!(ty, Type::Array(array) if array.is_open());
        if open {
            let message = format!("{ty} needs a length here");
            self.reports.error_with_help(
                written.span,
                message,
                "only parameters may leave it open",
            );
        }
    }
}
