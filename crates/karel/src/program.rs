//! A program that was parsed, checked and lowered.

use std::{collections::HashMap, sync::Arc};

use crate::{
    check,
    diagnostic::{Diagnostic, Reports},
    include::{IncludeFiles, Includes},
    ir::Code,
    lower, parser, sexpr,
    span::Source,
    types::Type,
};

/// A KAREL program, ready to be loaded into a [`crate::Machine`].
#[derive(Debug)]
pub struct Program {
    name: Arc<str>,
    warnings: Vec<Diagnostic>,
    pub(crate) code: Code,
    pub(crate) globals: HashMap<String, (u32, Type)>,
    pub(crate) global_cells: u32,
    pub(crate) global_files: Vec<u32>,
    /// Names of the variables that keep their values without power.
    pub(crate) persistent: Vec<String>,
}

impl Program {
    /// Translates a source. `source` is Latin-1 with LF or CRLF line ends; `file_name` is only
    /// for messages.
    ///
    /// # Errors
    /// Everything that was found, in the order of the source, warnings included.
    pub fn parse_and_check(source: &[u8], file_name: &str) -> Result<Program, Vec<Diagnostic>> {
        Program::with_includes(source, file_name, &IncludeFiles::default())
    }

    /// Translates a source whose `%INCLUDE` directives find their files in `includes`.
    ///
    /// A statement of an included file has the line of that file and the name of this program, as
    /// on a controller.
    ///
    /// # Errors
    /// As [`Program::parse_and_check`], and files that are not found or include themselves.
    pub fn with_includes(
        source: &[u8],
        file_name: &str,
        includes: &dyn Includes,
    ) -> Result<Program, Vec<Diagnostic>> {
        let mut source = Source::new(source, file_name);
        let mut reports = Reports::default();
        let Some(tree) = parser::parse(&mut source, Some(includes), &mut reports) else {
            return Err(reports.into_diagnostics(&source));
        };
        let checked = check::check(&tree, &mut reports);
        if reports.has_errors() {
            return Err(reports.into_diagnostics(&source));
        }
        let code = lower::lower(&checked, &source);
        Ok(Program {
            name: checked.name.as_str().into(),
            warnings: reports.into_diagnostics(&source),
            code,
            globals: checked.globals,
            global_cells: checked.global_cells,
            global_files: checked.global_files,
            persistent: checked.persistent,
        })
    }

    /// The name after PROGRAM, upper case.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What is suspicious but legal.
    #[must_use]
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    pub(crate) fn name_arc(&self) -> Arc<str> {
        self.name.clone()
    }
}

/// Parses `source` and writes its tree as S-expressions, one statement a line; what it includes
/// is not looked at.
///
/// # Errors
/// What the lexer and the parser found.
pub fn syntax_tree(source: &[u8], file_name: &str) -> Result<String, Vec<Diagnostic>> {
    let mut source = Source::new(source, file_name);
    let mut reports = Reports::default();
    match parser::parse(&mut source, None, &mut reports) {
        Some(tree) if !reports.has_errors() => Ok(sexpr::program(&tree)),
        Some(_) | None => Err(reports.into_diagnostics(&source)),
    }
}
