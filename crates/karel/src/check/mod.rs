//! Resolves names and types everything; reports every error it finds.

mod argument;
mod call;
mod condition;
mod constant;
mod decl;
mod expr;
mod motion;
mod place;
mod port;
mod scope;
mod stmt;
mod transfer;
mod using;
mod written_type;

use std::collections::{BTreeMap, HashMap};

use crate::{
    ast,
    diagnostic::Reports,
    generation::Generation,
    ir::{self, External},
    span::Span,
    typed::Routine,
    types::{MAX_CELLS, Type},
};

use scope::Scope;
pub(crate) use scope::nearest;

/// A checked program, not yet lowered.
#[derive(Debug)]
pub(crate) struct Checked {
    pub(crate) name: String,
    /// Variables of the program by name: first cell and type.
    pub(crate) globals: BTreeMap<String, (u32, Type)>,
    pub(crate) global_cells: u32,
    /// Cells of the globals that are FILE variables.
    pub(crate) global_files: Vec<u32>,
    /// Cells of the globals that are PATH variables, and the size of a node.
    pub(crate) global_paths: Vec<(u32, u32)>,
    /// Cells of the FILE variables that are windows of the pendant.
    pub(crate) windows: Vec<u32>,
    /// Types by name.
    pub(crate) types: BTreeMap<String, Type>,
    /// Names of the variables that keep their values without power.
    pub(crate) persistent: Vec<String>,
    /// Variables of other programs.
    pub(crate) shared: Vec<ir::SharedVariable>,
    /// What may interrupt its tasks.
    pub(crate) attributes: ir::Attributes,
    /// Routines of other programs that are called.
    pub(crate) externals: Vec<External>,
    /// The main body first.
    pub(crate) routines: Vec<Routine>,
}

/// Checks `program`. The result is meaningful only if no errors were reported.
pub(crate) fn check(
    program: &ast::Program,
    generation: Generation,
    reports: &mut Reports,
) -> Checked {
    let mut checker = Checker {
        reports,
        generation,
        program: program.name.text.clone(),
        globals: Scope::default(),
        locals: Scope::default(),
        routines: HashMap::new(),
        signatures: Vec::new(),
        externals: Vec::new(),
        shared: Vec::new(),
        attributes: ir::Attributes::default(),
        cmos_vars: false,
        persistent: Vec::new(),
        frame: Frame::default(),
        windows: Vec::new(),
        handler: None,
        along: false,
    };
    checker.directives(&program.directives);
    checker.program(program)
}

struct Checker<'a> {
    reports: &'a mut Reports,
    generation: Generation,
    program: String,
    globals: Scope,
    locals: Scope,
    /// Routines by name, as indices of `signatures`.
    routines: HashMap<String, usize>,
    signatures: Vec<Signature>,
    externals: Vec<External>,
    shared: Vec<ir::SharedVariable>,
    attributes: ir::Attributes,
    /// `%CMOSVARS`.
    cmos_vars: bool,
    /// Variables that keep their values without power.
    persistent: Vec<String>,
    frame: Frame,
    /// FILE variables that exist without a declaration, and their cells.
    windows: Vec<(String, u32)>,
    /// What is checked belongs to a condition handler.
    handler: Option<Handler>,
    /// Conditions of a MOVE ALONG are checked.
    along: bool,
}

/// The part of a condition handler that is being checked.
#[derive(Debug)]
struct Handler {
    /// Variables of the routine around, which it cannot use.
    hidden: Vec<String>,
    part: HandlerPart,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum HandlerPart {
    Condition,
    Actions,
}

/// What a call of a routine needs to know.
#[derive(Clone, Debug)]
struct Signature {
    name: String,
    span: Span,
    params: Vec<(ast::Name, Type)>,
    result: Option<Type>,
    home: Home,
}

impl Signature {
    fn types(&self) -> Vec<Type> {
        self.params.iter().map(|(_, ty)| ty.clone()).collect()
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Home {
    /// A body was found; its number among the routines of the program.
    Here(u32),
    /// Declared with FROM the own program; the body follows.
    Promised,
    /// In another program.
    External(String),
}

/// What is known of the routine whose body is being checked.
#[derive(Debug, Default)]
struct Frame {
    result: Option<Type>,
    is_main: bool,
    labels: HashMap<String, Label>,
    next_label: u32,
    returns_value: bool,
    /// Structures of the USING statements around, innermost last: frame cell of the reference, type.
    using: Vec<(u32, Type)>,
}

#[derive(Debug)]
struct Label {
    id: u32,
    defined: bool,
    first_use: Span,
    /// Cells of the USING statements around it, outermost first.
    using: Vec<u32>,
    /// The same of each GOTO.
    gotos: Vec<(Span, Vec<u32>)>,
}

/// Directives that change nothing here: they concern menus, storage or the translator.
const KNOWN_DIRECTIVES: &[&str] = &[
    "%ALPHABETIZE",
    "%CMOSVARS",
    "%CMOS2SHADOW",
    "%COMMENT",
    "%CRTDEVICE",
    "%DEFGROUP",
    "%DELAY",
    "%ENVIRONMENT",
    "%INVISIBLE",
    "%LOCKGROUP",
    "%NOABORT",
    "%NOBUSYLAMP",
    "%NOLOCKGROUP",
    "%NOPAUSE",
    "%NOPAUSESHFT",
    "%PRIORITY",
    "%SHADOWVARS",
    "%STACKSIZE",
    "%SYSTEM",
    "%TIMESLICE",
    "%TPMOTION",
    "%UNINITVARS",
    "%UNINITDRAM",
];

impl Checker<'_> {
    fn directives(&mut self, directives: &[ast::Directive]) {
        for directive in directives {
            let name = directive.name.as_str();
            if name == "%NOPAUSE" {
                self.attributes.no_pause = ir::Sources::parse(&directive.argument);
            }
            if name == "%NOABORT" {
                self.attributes.no_abort = ir::Sources::parse(&directive.argument);
            }
            self.attributes.free_of_group |= name == "%NOLOCKGROUP";
            self.cmos_vars |= matches!(name, "%CMOSVARS" | "%SHADOWVARS");
            if !KNOWN_DIRECTIVES.contains(&name) {
                self.reports.warning(
                    directive.span,
                    format!("unknown directive {name} is ignored"),
                );
            }
        }
    }

    /// `MOVE`, in any of its forms.
    fn karel_motion(&mut self, span: Span) {
        if !self.generation.has_motion() {
            let message = format!("MOVE is not translated for {}", self.generation.name());
            let help = "let a TP program move: CALL_PROGLIN, or RUN_TASK, with the target in a position register";
            self.reports.error_with_help(span, message, help);
        }
    }

    fn name_length(&mut self, name: &ast::Name) {
        let (length, most) = (name.text.len(), self.generation.longest_name());
        if length > most {
            let generation = self.generation.name();
            let message = format!(
                "`{}` has {length} characters, {generation} has names of at most {most}",
                name.text
            );
            self.reports.warning(name.span, message);
        }
    }

    fn program(mut self, program: &ast::Program) -> Checked {
        self.name_length(&program.name);
        self.declare(&program.decls, true);
        self.declare_routines(&program.decls);
        let mut routines = vec![self.main_body(program)];
        for decl in &program.decls {
            if let ast::Decl::Routine(routine) = decl
                && let ast::RoutineBody::Here { decls, stmts, end } = &routine.body
            {
                routines.push(self.routine_body(routine, decls, stmts, *end));
            }
        }
        if self.globals.cells > MAX_CELLS {
            let message = format!("the variables need more than {MAX_CELLS} cells of memory");
            self.reports.error(program.name.span, message);
        }
        Checked {
            name: self.program,
            global_cells: self.globals.cells,
            global_files: self.globals.files.clone(),
            global_paths: self.globals.paths.clone(),
            types: self.globals.types(),
            globals: self.globals.into_variables(),
            externals: self.externals,
            shared: self.shared,
            windows: self.windows.into_iter().map(|(_, cell)| cell).collect(),
            attributes: self.attributes,
            persistent: self.persistent,
            routines,
        }
    }

    fn main_body(&mut self, program: &ast::Program) -> Routine {
        self.locals = Scope::default();
        self.frame = Frame {
            is_main: true,
            ..Frame::default()
        };
        let body = self.stmts(&program.body);
        let signature = ir::Signature {
            params: Vec::new(),
            result: None,
        };
        let frame = (signature, 0);
        self.finish_routine(&program.name.text, frame, body, program.end)
    }

    fn routine_body(
        &mut self,
        routine: &ast::Routine,
        decls: &[ast::Decl],
        stmts: &[ast::Stmt],
        end: Span,
    ) -> Routine {
        self.locals = Scope::default();
        self.frame = Frame::default();
        let mut params = Vec::new();
        if let Some(index) = self.routines.get(&routine.name.text)
            && let Some(signature) = self.signatures.get(*index).cloned()
        {
            self.frame.result.clone_from(&signature.result);
            self.declare_params(&signature);
            params = signature.types();
        }
        let first_local = self.locals.cells;
        self.declare(decls, false);
        let body = self.stmts(stmts);
        if self.frame.result.is_some() && !self.frame.returns_value {
            let message = format!("the function `{}` never returns a value", routine.name.text);
            self.reports.warning(routine.name.span, message);
        }
        let result = self.frame.result.take();
        let frame = (ir::Signature { params, result }, first_local);
        self.finish_routine(&routine.name.text, frame, body, end)
    }

    fn refuse_missing_labels(&mut self) {
        let labels = std::mem::take(&mut self.frame.labels);
        let mut into: Vec<(Span, &str)> = Vec::new();
        for (name, label) in labels.iter().filter(|(_, label)| label.defined) {
            let gotos = label.gotos.iter();
            let wrong = gotos.filter(|(_, using)| !using.starts_with(&label.using));
            into.extend(wrong.map(|(span, _)| (*span, name.as_str())));
        }
        into.sort_by_key(|(span, _)| span.start);
        for (span, name) in into {
            let message = format!("GOTO cannot jump into the USING around `{name}`");
            self.reports.error(span, message);
        }
        let missing = labels.into_iter().filter(|(_, label)| !label.defined);
        let mut missing: Vec<_> = missing.collect();
        missing.sort_by_key(|(_, label)| label.first_use.start);
        for (name, label) in missing {
            let message = format!("there is no label `{name}` in this routine");
            self.reports.error(label.first_use, message);
        }
    }

    fn finish_routine(
        &mut self,
        name: &str,
        (signature, first_local): (ir::Signature, u32),
        body: Vec<crate::typed::Stmt>,
        end: Span,
    ) -> Routine {
        self.refuse_missing_labels();
        Routine {
            name: name.to_owned(),
            frame_cells: self.locals.cells,
            first_local,
            files: self.locals.files.clone(),
            paths: self.locals.paths.clone(),
            signature,
            labels: self.frame.next_label,
            body,
            end,
        }
    }
}
