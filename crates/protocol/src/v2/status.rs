use super::error::DecodeError;
use super::fields::Fields;
use super::line::LineWriter;
use super::reply::{ErrorCode, FinishStatus};
use super::values::{MotionNumber, WireJoints, WirePose};

/// The key switch of the controller.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum OperatingMode {
    /// T1: by hand, at reduced speed.
    T1,
    /// T2: by hand, at full speed.
    T2,
    /// AUTO.
    Auto,
}

/// The controller as it describes itself.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "these are the flags of the line, one for one"
)]
pub struct StatusLine {
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
    /// The arm moves.
    pub moving: bool,
    /// The motion is on hold.
    pub held: bool,
    /// The key switch.
    pub mode: OperatingMode,
    /// The teach pendant is enabled.
    pub pendant: bool,
    /// The alarm: facility * 1000 + number, 0 for none.
    pub alarm: u32,
    /// The general override in percent; 0 stands still.
    pub speed_override: u8,
    /// The active user frame.
    pub user_frame: u8,
    /// The active tool.
    pub tool: u8,
    /// The dead-man stopped a motion, and no new epoch has come since.
    pub dead_man: bool,
    /// DO1 to DO8, DO1 in the lowest bit.
    pub outputs: u8,
    /// DI1 to DI8, DI1 in the lowest bit.
    pub inputs: u8,
    /// The tool center point in the active frames.
    pub pose: WirePose,
    /// The joint values as on the pendant.
    pub joints: WireJoints,
}

impl StatusLine {
    /// The level of a digital output, 1 to 8; `false` beyond.
    #[must_use]
    pub fn output(&self, number: u8) -> bool {
        bit(self.outputs, number)
    }

    /// The level of a digital input, 1 to 8; `false` beyond.
    #[must_use]
    pub fn input(&self, number: u8) -> bool {
        bit(self.inputs, number)
    }

    /// The line, with its end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut line = LineWriter::new("ST");
        let _line = line.integer(self.boot).integer(self.epoch_max);
        self.accepted.write(&mut line);
        self.finished.write(&mut line);
        let mode = match self.mode {
            OperatingMode::T1 => "1",
            OperatingMode::T2 => "2",
            OperatingMode::Auto => "3",
        };
        let _line = line
            .integer(self.finish.code())
            .flag(self.moving)
            .flag(self.held)
            .word(mode)
            .flag(self.pendant)
            .integer(self.alarm)
            .integer(self.speed_override)
            .integer(self.user_frame)
            .integer(self.tool)
            .flag(self.dead_man)
            .integer(self.outputs)
            .integer(self.inputs);
        self.pose.write(&mut line);
        self.joints.write(&mut line);
        line.finish()
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        Ok(Self {
            boot: fields.count("the boot counter")?,
            epoch_max: fields.count("the highest epoch")?,
            accepted: MotionNumber::read(fields, "the accepted epoch", "the accepted number")?,
            finished: MotionNumber::read(fields, "the finished epoch", "the finished number")?,
            finish: FinishStatus::read(fields)?,
            moving: fields.flag("moving")?,
            held: fields.flag("held")?,
            mode: match fields.in_range("the mode", 1, 3)? {
                1 => OperatingMode::T1,
                2 => OperatingMode::T2,
                _ => OperatingMode::Auto,
            },
            pendant: fields.flag("the pendant")?,
            alarm: fields.count("the alarm")?,
            speed_override: fields.small("the override", 100)?,
            user_frame: fields.small("the user frame", u8::MAX)?,
            tool: fields.small("the tool", u8::MAX)?,
            dead_man: fields.flag("the dead-man")?,
            outputs: fields.small("the outputs", u8::MAX)?,
            inputs: fields.small("the inputs", u8::MAX)?,
            pose: WirePose::read(fields)?,
            joints: WireJoints::read(fields)?,
        })
    }
}

fn bit(levels: u8, number: u8) -> bool {
    (1..=8).contains(&number) && levels >> (number - 1) & 1 == 1
}

/// What the controller answers on its status port.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum StatusReply {
    /// The verb was carried out; this is the controller after it.
    Status(StatusLine),
    /// The verb was not understood.
    Malformed,
}

impl StatusReply {
    /// The line, with its end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Self::Status(status) => status.encode(),
            Self::Malformed => {
                let mut line = LineWriter::new("ERR");
                let _line = line.integer(ErrorCode::Malformed.code());
                line.finish()
            }
        }
    }

    /// Reads a line without its end.
    ///
    /// # Errors
    /// The line is not an answer of the status port in its canonical form.
    pub fn decode(line: &[u8]) -> Result<Self, DecodeError> {
        let (kind, mut fields) = Fields::open(line)?;
        let reply = match kind {
            b"ST" => Self::Status(StatusLine::read(&mut fields)?),
            b"ERR" => {
                let _malformed = fields.in_range("the error code", 1, 1)?;
                Self::Malformed
            }
            _ => {
                return Err(DecodeError::Kind {
                    expected: "ST, ERR",
                });
            }
        };
        fields.end()?;
        Ok(reply)
    }
}
