use super::error::DecodeError;
use super::fields::Fields;
use super::line::LineWriter;
use super::reply::FinishStatus;
use super::values::MotionNumber;

/// What the controller writes at once on a connection to its command port.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct Greeting {
    /// Counts the starts of the controller.
    pub boot: u32,
    /// The highest epoch seen: lower ones are stale.
    pub epoch_max: u32,
    /// The command accepted last.
    pub accepted: MotionNumber,
    /// The command finished last.
    pub finished: MotionNumber,
    /// How it finished.
    pub finish: FinishStatus,
    /// What the one command on this connection must carry, within 500 ms of the controller's clock.
    pub nonce: i32,
}

impl Greeting {
    /// The line, with its end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut line = LineWriter::new("V2");
        let _line = line.integer(self.boot).integer(self.epoch_max);
        self.accepted.write(&mut line);
        self.finished.write(&mut line);
        let _line = line.integer(self.finish.code()).integer(self.nonce);
        line.finish()
    }

    /// Reads a line without its end.
    ///
    /// # Errors
    /// The line is not a greeting of this version in its canonical form.
    pub fn decode(line: &[u8]) -> Result<Self, DecodeError> {
        let (kind, mut fields) = Fields::open(line)?;
        if kind != b"V2" {
            return Err(DecodeError::Kind { expected: "V2" });
        }
        let greeting = Self {
            boot: fields.count("the boot counter")?,
            epoch_max: fields.count("the highest epoch")?,
            accepted: MotionNumber::read(&mut fields, "the accepted epoch", "the accepted number")?,
            finished: MotionNumber::read(&mut fields, "the finished epoch", "the finished number")?,
            finish: FinishStatus::read(&mut fields)?,
            nonce: fields.integer("the nonce")?,
        };
        fields.end()?;
        Ok(greeting)
    }
}
