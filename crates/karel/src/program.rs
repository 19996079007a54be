//! A program that was parsed, checked and lowered.

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    check,
    diagnostic::{Diagnostic, Reports},
    generation::Generation,
    include::{IncludeFiles, Includes},
    ir::{Attributes, Code, SharedVariable},
    lower,
    machine::cell::{FileCell, FileFlag},
    parser, sexpr,
    span::Source,
    tp,
    types::Type,
    vendor_file,
};

/// A KAREL program, ready to be loaded into a [`crate::Machine`].
#[derive(Debug)]
pub struct Program {
    name: Arc<str>,
    warnings: Vec<Diagnostic>,
    pub(crate) code: Code,
    pub(crate) globals: BTreeMap<String, (u32, Type)>,
    pub(crate) global_cells: u32,
    pub(crate) global_files: Vec<u32>,
    /// Types that it declares.
    pub(crate) types: BTreeMap<String, Type>,
    /// PATH variables, and the size of a node of each.
    pub(crate) global_paths: Vec<(u32, u32)>,
    /// FILE variables that are windows of the pendant.
    pub(crate) windows: Vec<u32>,
    /// Names of the variables that keep their values without power.
    pub(crate) persistent: Vec<String>,
    /// Variables of other programs.
    pub(crate) shared: Vec<SharedVariable>,
    pub(crate) attributes: Attributes,
    /// A TP program.
    pub(crate) is_listing: bool,
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
        Program::for_generation(source, file_name, includes, Generation::Any)
    }

    /// Translates a source for one generation of controllers: what that does not translate is an error, names that are
    /// too long for it are warnings.
    ///
    /// # Errors
    /// As [`Program::with_includes`].
    pub fn for_generation(
        source: &[u8],
        file_name: &str,
        includes: &dyn Includes,
        generation: Generation,
    ) -> Result<Program, Vec<Diagnostic>> {
        let mut source = Source::new(source, file_name);
        let mut reports = Reports::default();
        let Some(tree) = parser::parse(&mut source, Some(includes), &mut reports) else {
            return Err(reports.into_diagnostics(&source));
        };
        let checked = check::check(&tree, generation, &mut reports);
        if reports.has_errors() {
            return Err(reports.into_diagnostics(&source));
        }
        let code = lower::lower(&checked, &source);
        Ok(Program {
            name: checked.name.as_str().into(),
            warnings: reports.into_diagnostics(&source),
            code,
            globals: checked.globals,
            types: checked.types,
            global_cells: checked.global_cells,
            global_files: checked.global_files,
            global_paths: checked.global_paths,
            windows: checked.windows,
            persistent: checked.persistent,
            shared: checked.shared,
            attributes: checked.attributes,
            is_listing: false,
        })
    }

    /// Translates the listing (`.ls`) of a TP program. `source` is Latin-1; the lines of its
    /// instructions count from 1, as the pendant numbers them.
    ///
    /// # Errors
    /// Everything that was found, in the order of the source. Instructions that are legal and not
    /// run yet are among it.
    pub fn parse_listing(source: &[u8], file_name: &str) -> Result<Program, Vec<Diagnostic>> {
        let source = Source::new(source, file_name);
        let mut reports = Reports::default();
        let listing = tp::parse(&source, &mut reports);
        let Some(listing) = listing.filter(|_| !reports.has_errors()) else {
            return Err(reports.into_diagnostics(&source));
        };
        let mut program =
            Program::of_listing(&listing.name, listing.instructions, listing.positions);
        program.warnings = reports.into_diagnostics(&source);
        Ok(program)
    }

    /// A TP program of instructions and positions.
    pub(crate) fn of_listing(
        name: &str,
        instructions: Vec<tp::Instruction>,
        positions: BTreeMap<i32, Arc<tp::Taught>>,
    ) -> Program {
        let name: Arc<str> = name.into();
        let mut code = lower::listing(&name, instructions);
        code.positions = positions;
        Program {
            name,
            warnings: Vec::new(),
            code,
            globals: BTreeMap::new(),
            types: BTreeMap::new(),
            global_cells: 0,
            global_files: Vec::new(),
            global_paths: Vec::new(),
            windows: Vec::new(),
            persistent: Vec::new(),
            shared: Vec::new(),
            attributes: Attributes::default(),
            is_listing: true,
        }
    }

    /// Translates a program by the kind that its file name says: `.ls` is a listing of a TP program,
    /// anything else is KAREL.
    ///
    /// # Errors
    /// As [`Program::with_includes`] and [`Program::parse_listing`].
    pub fn from_file(
        source: &[u8],
        file_name: &str,
        includes: &dyn Includes,
    ) -> Result<Program, Vec<Diagnostic>> {
        Program::from_file_for(source, file_name, includes, Generation::Any)
    }

    /// As [`Program::from_file`], for one generation of controllers.
    ///
    /// # Errors
    /// As [`Program::for_generation`] and [`Program::parse_listing`].
    pub fn from_file_for(
        source: &[u8],
        file_name: &str,
        includes: &dyn Includes,
        generation: Generation,
    ) -> Result<Program, Vec<Diagnostic>> {
        if let Some(refusal) = vendor_file::refusal(file_name) {
            return Err(refusal);
        }
        let extension = file_name.rsplit_once('.').map(|(_, extension)| extension);
        if extension.is_some_and(|extension| extension.eq_ignore_ascii_case("ls")) {
            return Program::parse_listing(source, file_name);
        }
        Program::for_generation(source, file_name, includes, generation)
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

    /// Whether a task of this program goes on when what pauses others comes from there.
    #[must_use]
    pub fn is_pausable(&self, by: Interruption) -> bool {
        let Attributes { no_pause, .. } = self.attributes;
        match by {
            Interruption::Error => !no_pause.error,
            Interruption::Command => !no_pause.command,
            Interruption::PendantEnabled => !no_pause.pendant,
        }
    }

    /// Whether a task of this program has control of the motion group: `CANCEL`, `STOP` and their kind reach no motion
    /// without it. Without `%NOLOCKGROUP` it has.
    #[must_use]
    pub fn locks_group(&self) -> bool {
        !self.attributes.free_of_group
    }

    /// Whether an alarm of the severity "abort" ends a task of this program.
    #[must_use]
    pub fn is_abortable_by_error(&self) -> bool {
        !self.attributes.no_abort.error
    }

    /// What a FILE variable of the program is before anything is opened.
    pub(crate) fn closed_file(&self, cell: u32) -> FileCell {
        let mut file = FileCell::default();
        if self.windows.contains(&cell) {
            file.set(FileFlag::Window);
        }
        file
    }

    pub(crate) fn name_arc(&self) -> Arc<str> {
        self.name.clone()
    }
}

/// What pauses tasks that are not protected against it by `%NOPAUSE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interruption {
    /// An alarm.
    Error,
    /// The HOLD key, or an input of the same meaning.
    Command,
    /// The teach pendant was enabled.
    PendantEnabled,
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
