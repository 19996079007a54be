//! Variables, their parts, and system variables.

use super::{
    Checker,
    constant::predefined,
    scope::{Symbol, nearest},
};
use crate::{
    ast::{Expr, Name, Path, PathStep},
    span::Span,
    sysvars,
    typed::{self, Place, Step, SystemPlace, SystemStep},
    types::Type,
};

impl Checker<'_> {
    /// A variable or a part of one; reports and returns `None` if the path is something else.
    pub(super) fn place(&mut self, path: &Path) -> Option<Place> {
        if path.root.text.starts_with('$') {
            let message = format!(
                "a system variable such as `{}` cannot stand here",
                path.root.text
            );
            self.reports
                .error_with_help(path.span, message, "use a variable of the program");
            return None;
        }
        let mut place = match self.using_field(&path.root.text) {
            Some(field) => field,
            None => self.root_place(path)?,
        };
        for step in &path.steps {
            match step {
                PathStep::Field(name) => self.field_step(&mut place, name)?,
                PathStep::Index { subscripts, span } => {
                    self.index_step(&mut place, subscripts, *span)?;
                }
                PathStep::Range { span, .. } => {
                    let message = "a range of nodes stands only in MOVE ALONG";
                    self.reports.error(*span, message);
                    return None;
                }
            }
        }
        Some(place)
    }

    /// The variable at the start of a path.
    fn root_place(&mut self, path: &Path) -> Option<Place> {
        let (root, ty) = match self.find_symbol(&path.root.text) {
            Some(Symbol::Variable { root, ty }) => (*root, ty.clone()),
            Some(Symbol::Constant(_)) => {
                let message = format!("`{}` is a constant, not a variable", path.root.text);
                self.reports.error(path.root.span, message);
                return None;
            }
            Some(Symbol::Type(_)) => {
                let message = format!("`{}` is a type, not a variable", path.root.text);
                self.reports.error(path.root.span, message);
                return None;
            }
            None if self.port_array(path).is_some() => {
                let message = format!("a port such as {} cannot stand here", path.root.text);
                self.reports
                    .error_with_help(path.span, message, "use a variable of the program");
                return None;
            }
            None if self.is_predefined_file(path) => {
                return Some(self.window_place(&path.root.text));
            }
            None if predefined(&path.root.text).is_some() => {
                let message = format!("`{}` is a constant, not a variable", path.root.text);
                self.reports.error(path.root.span, message);
                return None;
            }
            None => {
                self.undeclared(&path.root);
                return None;
            }
        };
        Some(Place {
            root,
            steps: Vec::new(),
            ty,
        })
    }

    pub(super) fn window_place(&mut self, name: &str) -> Place {
        let cell = self.window(name);
        Place {
            root: typed::Root::Global(cell),
            steps: Vec::new(),
            ty: Type::File,
        }
    }

    /// The cell of a FILE variable that exists without a declaration.
    fn window(&mut self, name: &str) -> u32 {
        if let Some((_, cell)) = self.windows.iter().find(|(known, _)| known == name) {
            return *cell;
        }
        let cell = self.globals.allocate(&Type::File);
        self.windows.push((name.to_owned(), cell));
        cell
    }

    fn field_step(&mut self, place: &mut Place, name: &Name) -> Option<()> {
        let Some((offset, ty)) = place.ty.field(&name.text) else {
            if place.ty != Type::Error {
                let message = format!("{} has no field `{}`", place.ty, name.text);
                self.reports.error(name.span, message);
            }
            return None;
        };
        place.steps.push(Step::Offset(offset));
        place.ty = ty;
        Some(())
    }

    fn index_step(&mut self, place: &mut Place, subscripts: &[Expr], span: Span) -> Option<()> {
        let checked: Vec<typed::Expr> = subscripts
            .iter()
            .map(|subscript| self.integer(subscript))
            .collect();
        if let Type::Path(path) = place.ty.clone() {
            let [subscript] = <[typed::Expr; 1]>::try_from(checked)
                .map_err(|checked| {
                    let message = format!("a PATH takes 1 subscript, here are {}", checked.len());
                    self.reports.error(span, message);
                })
                .ok()?;
            place.ty = path.node.clone();
            place.steps.push(Step::Node(Box::new(subscript)));
            return Some(());
        }
        let Type::Array(array) = place.ty.clone() else {
            if place.ty != Type::Error {
                self.reports
                    .error(span, format!("{} is not an array", place.ty));
            }
            return None;
        };
        let expected = array.dims.len().max(1);
        if checked.len() != expected {
            let noun = if expected == 1 {
                "subscript"
            } else {
                "subscripts"
            };
            let message = format!(
                "{} takes {expected} {noun}, here are {}",
                place.ty,
                checked.len()
            );
            self.reports.error(span, message);
            return None;
        }
        let open_texts = array.dims.is_empty() && array.element == Type::TEXT;
        let element_cells = if open_texts {
            // The reference tells the length of the strings, too.
            0
        } else {
            array.element.size()
        };
        place.ty = array.element.clone();
        if array.is_open_grid() {
            place.steps.push(Step::OpenGrid {
                subscripts: checked,
                element_cells,
            });
        } else if !array.dims.is_empty() {
            let dims = array.dims.clone();
            place.steps.push(Step::Index {
                subscripts: checked,
                dims,
                element_cells,
            });
        } else if let Some(subscript) = checked.into_iter().next() {
            place.steps.push(Step::OpenIndex {
                subscript,
                element_cells,
            });
        }
        Some(())
    }

    pub(super) fn undeclared(&mut self, name: &Name) {
        if self.is_hidden(name) {
            return;
        }
        if name.text.starts_with("ATR_") {
            let message = format!("the file attribute {} is not supported yet", name.text);
            return self.reports.error(name.span, message);
        }
        let message = format!("`{}` is not declared", name.text);
        self.report_unknown(name, &message, &[]);
    }

    /// Reports with the nearest known name as help.
    pub(super) fn report_unknown(&mut self, name: &Name, message: &str, more: &[&str]) {
        let locals = self.locals.symbols.keys();
        let known = locals
            .chain(self.globals.symbols.keys())
            .chain(self.routines.keys());
        let known = known.map(String::as_str).chain(more.iter().copied());
        match nearest(&name.text, known).map(str::to_owned) {
            Some(near) => {
                let help = format!("there is `{near}`");
                self.reports.error_with_help(name.span, message, help);
            }
            None => self.reports.error(name.span, message),
        }
    }

    /// A system variable, or a component of one such as `$UTOOL.x`.
    pub(super) fn system_place(&mut self, path: &Path) -> Option<SystemPlace> {
        let mut pattern = path.root.text.clone();
        let mut steps = vec![SystemStep::Name(path.root.text.clone())];
        let mut component = None;
        for (index, step) in path.steps.iter().enumerate() {
            match step {
                PathStep::Field(name) if name.text.starts_with('$') => {
                    pattern.push('.');
                    pattern.push_str(&name.text);
                    steps.push(SystemStep::Name(name.text.clone()));
                }
                PathStep::Field(name) => {
                    if index + 1 < path.steps.len() {
                        self.reports
                            .error(name.span, "nothing can follow a component");
                        return None;
                    }
                    component = Some(name);
                }
                PathStep::Index { subscripts, .. } => {
                    let checked: Vec<_> = subscripts
                        .iter()
                        .map(|subscript| self.integer(subscript))
                        .collect();
                    pattern.push_str(&sysvars::subscript_pattern(checked.len()));
                    steps.push(SystemStep::Index(checked));
                }
                PathStep::Range { span, .. } => {
                    let message = "a range of nodes stands only in MOVE ALONG";
                    self.reports.error(*span, message);
                    return None;
                }
            }
        }
        let Some(whole) = sysvars::type_of_pattern(&pattern) else {
            let message = format!("the system variable `{pattern}` is not known");
            match sysvars::suggestion(&pattern) {
                Some(known) => {
                    self.reports
                        .error_with_help(path.span, message, format!("there is `{known}`"));
                }
                None => self.reports.error_with_help(
                    path.span,
                    message,
                    "GET_VAR and SET_VAR ask the controller at run time",
                ),
            }
            return None;
        };
        let Some(name) = component else {
            return Some(SystemPlace {
                steps,
                component: None,
                ty: whole,
            });
        };
        let Some((offset, ty)) = whole.field(&name.text) else {
            self.reports
                .error(name.span, format!("{whole} has no field `{}`", name.text));
            return None;
        };
        Some(SystemPlace {
            steps,
            component: Some(offset),
            ty,
        })
    }

    /// What a path without parentheses means in an expression.
    pub(super) fn path_expression(&mut self, path: &Path) -> Option<typed::Expr> {
        use typed::ExprKind;
        let name = &path.root;
        if name.text.starts_with('$') {
            let place = self.system_place(path)?;
            return Some(typed::Expr {
                ty: place.ty.clone(),
                kind: ExprKind::System(place),
            });
        }
        if self.using_field(&name.text).is_some() {
            let place = self.place(path)?;
            return Some(typed::Expr {
                ty: place.ty.of_value(),
                kind: ExprKind::Place(place),
            });
        }
        if let Some(port) = self.port_array(path) {
            return self.port_expression(port, path);
        }
        let constant = match self.find_symbol(&name.text) {
            Some(Symbol::Constant(constant)) => Some(constant.clone()),
            Some(Symbol::Variable { .. } | Symbol::Type(_)) => {
                let place = self.place(path)?;
                return Some(typed::Expr {
                    ty: place.ty.of_value(),
                    kind: ExprKind::Place(place),
                });
            }
            None => None,
        };
        if let Some(constant) = constant {
            self.refuse_steps(path)?;
            return Some(typed::Expr {
                ty: constant.ty(),
                kind: ExprKind::Constant(constant),
            });
        }
        // A function without arguments is called without parentheses.
        if self.is_routine(&name.text) {
            self.refuse_steps(path)?;
            return self.function_call(name, &[]);
        }
        if self.is_predefined_file(path) {
            let place = self.place(path)?;
            return Some(typed::Expr {
                ty: place.ty.of_value(),
                kind: ExprKind::Place(place),
            });
        }
        if let Some(constant) = predefined(&name.text) {
            self.refuse_steps(path)?;
            return Some(typed::Expr {
                ty: constant.ty(),
                kind: ExprKind::Constant(constant),
            });
        }
        self.undeclared(name);
        None
    }

    fn refuse_steps(&mut self, path: &Path) -> Option<()> {
        if path.steps.is_empty() {
            return Some(());
        }
        let message = format!("`{}` has no fields and no subscripts", path.root.text);
        self.reports.error(path.span, message);
        None
    }
}
