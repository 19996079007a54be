//! Why programs are not loaded or started.

/// Why a program cannot be loaded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoadError {
    /// A program of this name is loaded.
    #[error("program {0} is loaded already")]
    Duplicate(String),
    /// The machine's limit.
    #[error("{0} programs are loaded, which is the limit")]
    TooMany(usize),
    /// Two programs disagree about a routine that one calls and the other has.
    #[error(
        "{caller} declares the routine {routine} FROM {program} with other parameters or another result"
    )]
    Signature {
        /// The program that declares it with FROM.
        caller: String,
        /// The routine.
        routine: String,
        /// The program that has its body.
        program: String,
    },
    /// Two programs disagree about a variable that they share.
    #[error("{user} declares the variable {variable} FROM {program} with another type")]
    Variable {
        /// The program that declares it with FROM.
        user: String,
        /// The variable.
        variable: String,
        /// The program that has it.
        program: String,
    },
}

/// Why a program cannot be started.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StartError {
    /// No program of this name is loaded.
    #[error("program {0} is not loaded")]
    NotLoaded(String),
    /// A task of this program runs already.
    #[error("program {0} is running already")]
    Running(String),
    /// The machine's limit.
    #[error("{0} tasks exist, which is the limit")]
    TooMany(usize),
    /// The main body needs more memory than a task may have.
    #[error("the main body needs {cells} cells of memory, a task may have {limit}")]
    TooLarge {
        /// What it needs.
        cells: usize,
        /// [`crate::Limits::stack_cells`].
        limit: usize,
    },
}
