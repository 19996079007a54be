//! Declarations: constants, types, variables, routine signatures.

use std::sync::Arc;

use super::{Checker, Home, Signature, scope::Symbol};
use crate::{
    ast::{Decl, Dim, Expr, Name, Param, Routine, RoutineBody, TypeExpr, TypeKind},
    typed::{Constant, Root},
    types::{
        ArrayType, Field, MAX_CELLS, MAX_STRING, MAX_TYPE_DEPTH, PositionKind, StructureType,
        TextLength, Type,
    },
};

/// Types of KAREL that this crate does not run yet.
const NOT_YET: &[&str] = &[
    "BYTE",
    "CAM_SETUP",
    "COMMON_ASSOC",
    "GROUP_ASSOC",
    "JOINTPOS",
    "JOINTPOS1",
    "JOINTPOS2",
    "JOINTPOS3",
    "JOINTPOS4",
    "JOINTPOS5",
    "JOINTPOS6",
    "JOINTPOS7",
    "JOINTPOS8",
    "JOINTPOS9",
    "MODEL",
    "PATH",
    "QUEUE_TYPE",
    "SHORT",
    "STD_PTH_NODE",
    "VECTOR",
    "VIS_PROCESS",
];

impl Checker<'_> {
    /// Declares everything but routines, in the order of the source.
    pub(super) fn declare(&mut self, decls: &[Decl], global: bool) {
        for decl in decls {
            match decl {
                Decl::Const { name, value } => {
                    if let Some(constant) = self.constant_value(value) {
                        self.declare_symbol(name, Symbol::Constant(constant), global);
                    }
                }
                Decl::Type { name, ty } => {
                    let ty = self.type_of(ty, Some(&name.text));
                    self.declare_symbol(name, Symbol::Type(ty), global);
                }
                Decl::Var { names, ty: written } => {
                    let ty = self.type_of(written, None);
                    self.refuse_open(&ty, written);
                    for name in names {
                        self.declare_variable(name, &ty, global);
                    }
                }
                Decl::Routine(_) => {}
            }
        }
    }

    fn declare_variable(&mut self, name: &Name, ty: &Type, global: bool) {
        let scope = if global {
            &mut self.globals
        } else {
            &mut self.locals
        };
        let cell = scope.allocate(ty);
        if scope.cells > MAX_CELLS {
            let message = format!(
                "`{}` needs more than {MAX_CELLS} cells of memory",
                name.text
            );
            self.reports.error(name.span, message);
        }
        let root = if global {
            Root::Global(cell)
        } else {
            Root::Local(cell)
        };
        self.declare_symbol(
            name,
            Symbol::Variable {
                root,
                ty: ty.clone(),
            },
            global,
        );
    }

    fn declare_symbol(&mut self, name: &Name, symbol: Symbol, global: bool) {
        let scope = if global {
            &mut self.globals
        } else {
            &mut self.locals
        };
        if let Some(Symbol::Constant(old)) = scope.symbols.get(&name.text)
            && matches!(&symbol, Symbol::Constant(new) if new == old)
        {
            return;
        }
        if scope.symbols.contains_key(&name.text) {
            self.reports
                .error(name.span, format!("`{}` is declared twice", name.text));
        } else {
            let _ = scope.symbols.insert(name.text.clone(), symbol);
        }
    }

    pub(super) fn find_symbol(&self, name: &str) -> Option<&Symbol> {
        self.locals
            .symbols
            .get(name)
            .or_else(|| self.globals.symbols.get(name))
    }

    /// Signatures of all routines, so that bodies may call in any order.
    pub(super) fn declare_routines(&mut self, decls: &[Decl]) {
        let mut bodies = 0;
        for decl in decls {
            let Decl::Routine(routine) = decl else {
                continue;
            };
            let home = match &routine.body {
                RoutineBody::Here { .. } => {
                    bodies += 1;
                    Home::Here(bodies)
                }
                RoutineBody::From(program) if program.text == self.program => Home::Promised,
                RoutineBody::From(program) => Home::External(program.text.clone()),
            };
            self.declare_routine(routine, home);
        }
        for signature in &self.signatures {
            if signature.home == Home::Promised {
                let message = format!("the body of `{}` is missing", signature.name);
                self.reports.error(signature.span, message);
            }
        }
    }

    fn declare_routine(&mut self, routine: &Routine, home: Home) {
        let promised = self.routines.get(&routine.name.text).copied();
        if let Some(index) = promised
            && let Some(earlier) = self.signatures.get_mut(index)
        {
            if earlier.home == Home::Promised && matches!(home, Home::Here(_)) {
                earlier.home = home;
                if !routine.params.is_empty() || routine.result.is_some() {
                    self.reports.error_with_help(
                        routine.name.span,
                        format!("`{}` repeats its parameters", routine.name.text),
                        "the declaration with FROM has them; the body starts with the name alone",
                    );
                }
            } else {
                let message = format!("the routine `{}` is declared twice", routine.name.text);
                self.reports.error(routine.name.span, message);
            }
            return;
        }
        let mut params = Vec::new();
        for param in &routine.params {
            let ty = self.type_of(&param.ty, None);
            params.extend(param.names.iter().map(|name| (name.clone(), ty.clone())));
        }
        let result = routine.result.as_ref().map(|written| {
            let ty = self.type_of(written, None);
            if !matches!(ty, Type::Text(_)) {
                self.refuse_open(&ty, written);
            }
            if ty.holds_file() {
                self.reports
                    .error(written.span, "a function cannot return a FILE");
            }
            ty
        });
        let name = routine.name.text.clone();
        let signature = Signature {
            name: name.clone(),
            span: routine.name.span,
            params,
            result,
            home,
        };
        let _ = self.routines.insert(name, self.signatures.len());
        self.signatures.push(signature);
    }

    /// Gives the parameters of a routine their frame cells; a result that does not fit on the
    /// operand stack gets a cell before them, for the reference to the caller's copy.
    pub(super) fn declare_params(&mut self, signature: &Signature) {
        if signature
            .result
            .as_ref()
            .is_some_and(|result| !result.is_scalar())
        {
            self.locals.cells += 1;
        }
        for (name, ty) in &signature.params {
            let cell = self.locals.cells;
            self.locals.cells += 1;
            let symbol = Symbol::Variable {
                root: Root::Param(cell),
                ty: ty.clone(),
            };
            self.declare_symbol(name, symbol, false);
        }
    }

    pub(super) fn type_of(&mut self, written: &TypeExpr, declared_as: Option<&str>) -> Type {
        match &written.kind {
            TypeKind::Name(name) => self.named_type(name),
            TypeKind::Text(None) => Type::TEXT,
            TypeKind::Text(Some(length)) => match self.length(length, MAX_STRING) {
                Some(length) => Type::Text(TextLength::AtMost(length)),
                None => Type::Error,
            },
            TypeKind::Array { dims, element } => self.array_type(dims, element),
            TypeKind::Structure(fields) => self.structure_type(fields, declared_as, written),
        }
    }

    fn named_type(&mut self, name: &Name) -> Type {
        if let Some(Symbol::Type(ty)) = self.find_symbol(&name.text) {
            return ty.clone();
        }
        match name.text.as_str() {
            "INTEGER" => Type::Integer,
            "REAL" => Type::Real,
            "BOOLEAN" => Type::Boolean,
            "FILE" => Type::File,
            "CONFIG" => Type::Config,
            "POSITION" => Type::Position(PositionKind::Position),
            "XYZWPR" => Type::Position(PositionKind::Xyzwpr),
            "XYZWPREXT" => Type::Position(PositionKind::XyzwprExt),
            text if NOT_YET.contains(&text) => {
                self.reports
                    .error(name.span, format!("the type {text} is not supported yet"));
                Type::Error
            }
            text => {
                self.report_unknown(name, &format!("there is no type `{text}`"), &BASIC_TYPES);
                Type::Error
            }
        }
    }

    fn array_type(&mut self, dims: &[Dim], element: &TypeExpr) -> Type {
        let element_type = self.type_of(element, None);
        self.refuse_open(&element_type, element);
        let mut lengths = Vec::new();
        for dim in dims {
            match dim {
                Dim::Length(length) => match self.length(length, MAX_CELLS as usize) {
                    Some(length) => lengths.push(length),
                    None => return Type::Error,
                },
                Dim::Open(_) if dims.len() == 1 => {}
                Dim::Open(span) => {
                    let message = "open arrays of several dimensions are not supported yet";
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
    fn refuse_open(&mut self, ty: &Type, written: &TypeExpr) {
        let open = match ty {
            Type::Text(TextLength::Any) => true,
            Type::Array(array) => array.dims.is_empty(),
            Type::Integer
            | Type::Real
            | Type::Boolean
            | Type::Text(_)
            | Type::File
            | Type::Config
            | Type::Position(_)
            | Type::Structure(_)
            | Type::Error => false,
        };
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
