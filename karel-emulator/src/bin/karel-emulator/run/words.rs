//! Choices of the command line, as words.

use clap::ValueEnum;
use karel_emulator::ControllerGeneration;

#[derive(Clone, Copy, Debug, ValueEnum)]
#[value(rename_all = "UPPER")]
pub(super) enum MissingOption {
    /// KAREL.
    R632,
    /// User Socket Messaging.
    R648,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum Second {
    /// It waits for its turn.
    Backlog,
    /// It is refused.
    Refuse,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum FidelityWord {
    /// As silent as a real one.
    Faithful,
    /// It explains itself.
    Kind,
}

/// How signals choose a program.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum SelectionWord {
    /// Robot service request.
    Rsr,
    /// Program number select.
    Pns,
}

/// The generation of a controller, on a command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum GenerationWord {
    /// Whatever any of them accepts.
    Any,
    /// R-30iA, system software 7.
    V7,
    /// R-30iB Plus, system software 9.
    V9,
}

impl From<GenerationWord> for ControllerGeneration {
    fn from(word: GenerationWord) -> Self {
        match word {
            GenerationWord::Any => Self::Any,
            GenerationWord::V7 => Self::V7,
            GenerationWord::V9 => Self::V9,
        }
    }
}
