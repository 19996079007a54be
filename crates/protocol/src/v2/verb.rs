use super::error::DecodeError;
use super::fields::Fields;
use super::line::LineWriter;
use super::values::Percent;

/// What the server asks on the status port. Each is answered by one line.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Verb {
    /// Status; a heartbeat if the epoch is not below the highest seen.
    Status {
        /// The writer's epoch.
        epoch: u32,
    },
    /// Fence: from now on lower epochs are stale, and the outstanding nonce is dead.
    Fence {
        /// The writer's epoch.
        epoch: u32,
    },
    /// Stop the running motion by a controlled deceleration; the outstanding nonce is dead.
    Stop,
    /// Hold the running motion.
    Hold,
    /// Go on with the motion on hold.
    Continue,
    /// Set the general override.
    Override(Percent),
}

impl Verb {
    /// The line, with its end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut line;
        match *self {
            Self::Status { epoch } => {
                line = LineWriter::new("S");
                let _line = line.integer(epoch);
            }
            Self::Fence { epoch } => {
                line = LineWriter::new("F");
                let _line = line.integer(epoch);
            }
            Self::Stop => line = LineWriter::new("X"),
            Self::Hold => line = LineWriter::new("P"),
            Self::Continue => line = LineWriter::new("C"),
            Self::Override(percent) => {
                line = LineWriter::new("G");
                percent.write(&mut line);
            }
        }
        line.finish()
    }

    /// Reads a line without its end.
    ///
    /// # Errors
    /// The line is not a verb in its canonical form.
    pub fn decode(line: &[u8]) -> Result<Self, DecodeError> {
        let (kind, mut fields) = Fields::open(line)?;
        let verb = match kind {
            b"S" => Self::Status {
                epoch: fields.count("the epoch")?,
            },
            b"F" => Self::Fence {
                epoch: fields.count("the epoch")?,
            },
            b"X" => Self::Stop,
            b"P" => Self::Hold,
            b"C" => Self::Continue,
            b"G" => Self::Override(Percent::read(&mut fields)?),
            _ => {
                return Err(DecodeError::Kind {
                    expected: "S, F, X, P, C, G",
                });
            }
        };
        fields.end()?;
        Ok(verb)
    }
}
