//! Declarations: constants, types, variables, routine signatures.

use super::{Checker, Home, Signature, scope::Symbol};
use crate::{
    ast::{Decl, Memory, Name, Routine, RoutineBody, Storage},
    ir::SharedVariable,
    typed::Root,
    types::{MAX_CELLS, MAX_PATHS, Type},
};

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
                Decl::Var {
                    names,
                    storage,
                    home,
                    ty: written,
                } => {
                    let ty = self.type_of(written, None);
                    self.refuse_open(&ty, written);
                    self.refuse_small(&ty, written);
                    if let Some(home) = home
                        && home.text != self.program
                    {
                        for name in names {
                            self.declare_shared(name, home, &ty, global);
                        }
                        continue;
                    }
                    let memory = self.memory(*storage, global);
                    for name in names {
                        if memory == Memory::Cmos {
                            self.persistent.push(name.text.clone());
                        }
                        self.declare_variable(name, &ty, global);
                    }
                }
                Decl::Routine(_) => {}
            }
        }
    }

    /// Where variables of this declaration live.
    ///
    /// ASSUMPTION: without `IN`, `%CMOSVARS` decides; variables of routines are never kept.
    fn memory(&mut self, storage: Option<Storage>, global: bool) -> Memory {
        match storage {
            Some(storage) if !global => {
                let message = "only variables of the program have a storage of their own";
                self.reports.error(storage.span, message);
                Memory::Dram
            }
            Some(storage) => storage.memory,
            None if global && self.cmos_vars => Memory::Cmos,
            None => Memory::Dram,
        }
    }

    fn declare_variable(&mut self, name: &Name, ty: &Type, global: bool) {
        let scope = if global {
            &mut self.globals
        } else {
            &mut self.locals
        };
        let before = scope.paths.len();
        let cell = scope.allocate(ty);
        if scope.cells > MAX_CELLS {
            let message = format!(
                "`{}` needs more than {MAX_CELLS} cells of memory",
                name.text
            );
            self.reports.error(name.span, message);
        }
        if before <= MAX_PATHS && scope.paths.len() > MAX_PATHS {
            let message = format!("`{}` makes more than {MAX_PATHS} PATHs", name.text);
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

    /// A variable of another program: a cell that holds its address.
    fn declare_shared(&mut self, name: &Name, home: &Name, ty: &Type, global: bool) {
        if !global {
            let message = "only a program can use variables of another, not a routine";
            return self.reports.error(home.span, message);
        }
        if ty.holds_file() {
            let message = "a FILE variable cannot be shared between programs";
            return self.reports.error(name.span, message);
        }
        let cell = self.globals.cells;
        self.globals.cells = self.globals.cells.saturating_add(1);
        self.shared.push(SharedVariable {
            name: name.text.clone(),
            program: home.text.clone(),
            cell,
            ty: ty.clone(),
        });
        let symbol = Symbol::Variable {
            root: Root::Shared(cell),
            ty: ty.clone(),
        };
        self.declare_symbol(name, symbol, true);
    }

    fn declare_symbol(&mut self, name: &Name, symbol: Symbol, global: bool) {
        self.name_length(name);
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
        self.name_length(&routine.name);
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
            self.refuse_small(&ty, &param.ty);
            params.extend(param.names.iter().map(|name| (name.clone(), ty.clone())));
        }
        let result = routine.result.as_ref().map(|written| {
            let ty = self.type_of(written, None);
            self.refuse_small(&ty, written);
            if !matches!(ty, Type::Text(_)) {
                self.refuse_open(&ty, written);
            }
            if !ty.is_copied() {
                self.reports
                    .error(written.span, "a function cannot return a FILE or a PATH");
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
}
