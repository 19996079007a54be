use super::error::DecodeError;
use super::fields::Fields;
use super::line::LineWriter;
use super::values::{LinearSpeed, MotionNumber, OutputNumber, Percent, WireJoints, WirePose};

/// What the controller is to do.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Command {
    /// Move the arm.
    Move(Move),
    /// Set a digital output.
    Output(Output),
}

/// A motion.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Move {
    /// All joints start and stop together; the target is a pose.
    Joint {
        /// Where to.
        pose: WirePose,
        /// Percent of the fastest joint motion.
        speed: Percent,
        /// Which of the joint sets that reach the pose.
        configuration: WireConfiguration,
    },
    /// The tool center point on a straight line.
    Linear {
        /// Where to.
        pose: WirePose,
        /// Along the line.
        speed: LinearSpeed,
        /// Which of the joint sets that reach the pose.
        configuration: WireConfiguration,
    },
    /// All joints start and stop together; the target is joint values.
    Joints {
        /// Where to.
        joints: WireJoints,
        /// Percent of the fastest joint motion.
        speed: Percent,
    },
}

/// A level of a digital output: absolute, so that setting it twice does no more than setting it once.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct Output {
    /// Which one.
    pub output: OutputNumber,
    /// Its level.
    pub on: bool,
}

/// Which side of J5 = 0 the wrist is on.
#[derive(Clone, Copy, Debug, Default, Eq, Hash, PartialEq)]
pub enum Flip {
    /// `N`.
    #[default]
    NoFlip,
    /// `F`.
    Flip,
}

/// Which side of the line from shoulder to wrist center the elbow is on.
#[derive(Clone, Copy, Debug, Default, Eq, Hash, PartialEq)]
pub enum Elbow {
    /// `U`.
    #[default]
    Up,
    /// `D`.
    Down,
}

/// Which side of axis 1 the wrist center is on.
#[derive(Clone, Copy, Debug, Default, Eq, Hash, PartialEq)]
pub enum Front {
    /// `T`.
    #[default]
    Toward,
    /// `B`.
    Back,
}

/// The configuration of a target, as the wire carries it: `N U T 0 0 0`.
#[derive(Clone, Copy, Debug, Default, Eq, Hash, PartialEq)]
pub struct WireConfiguration {
    /// `N` or `F`.
    pub flip: Flip,
    /// `U` or `D`.
    pub elbow: Elbow,
    /// `T` or `B`.
    pub front: Front,
    /// Turn numbers of J4, J5 and J6.
    pub turns: [i8; 3],
}

impl WireConfiguration {
    fn write(self, line: &mut LineWriter) {
        let flip = match self.flip {
            Flip::NoFlip => "N",
            Flip::Flip => "F",
        };
        let elbow = match self.elbow {
            Elbow::Up => "U",
            Elbow::Down => "D",
        };
        let front = match self.front {
            Front::Toward => "T",
            Front::Back => "B",
        };
        let _line = line.word(flip).word(elbow).word(front);
        for turn in self.turns {
            let _line = line.integer(turn);
        }
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        let letter = |item, expected| Err(DecodeError::Letter { item, expected });
        let flip = match fields.token("the flip")? {
            b"N" => Flip::NoFlip,
            b"F" => Flip::Flip,
            _ => return letter("the flip", "N or F"),
        };
        let elbow = match fields.token("the elbow")? {
            b"U" => Elbow::Up,
            b"D" => Elbow::Down,
            _ => return letter("the elbow", "U or D"),
        };
        let front = match fields.token("the front")? {
            b"T" => Front::Toward,
            b"B" => Front::Back,
            _ => return letter("the front", "T or B"),
        };
        let mut turns = [0; 3];
        for (turn, item) in turns.iter_mut().zip(["turn 4", "turn 5", "turn 6"]) {
            *turn = i8::try_from(fields.in_range(item, -128, 127)?).unwrap_or(0);
        }
        Ok(Self {
            flip,
            elbow,
            front,
            turns,
        })
    }
}

/// A command as the server sends it, once, on a connection of its own.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct Request {
    /// The command's number.
    pub number: MotionNumber,
    /// The nonce of the greeting it answers: a command that was delayed has an old one.
    pub nonce: i32,
    /// What to do.
    pub command: Command,
}

impl Request {
    /// The line, with its end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let kind = match self.command {
            Command::Move(_) => "M",
            Command::Output(_) => "O",
        };
        let mut line = LineWriter::new(kind);
        self.number.write(&mut line);
        let _line = line.integer(self.nonce);
        match self.command {
            Command::Move(motion) => motion.write(&mut line),
            Command::Output(Output { output, on }) => {
                output.write(&mut line);
                let _line = line.flag(on);
            }
        }
        line.finish()
    }

    /// Reads a line without its end.
    ///
    /// # Errors
    /// The line is not a command in its canonical form.
    pub fn decode(line: &[u8]) -> Result<Self, DecodeError> {
        let (kind, mut fields) = Fields::open(line)?;
        if !matches!(kind, b"M" | b"O") {
            return Err(DecodeError::Kind { expected: "M, O" });
        }
        let number = MotionNumber::read(&mut fields, "the epoch", "the number")?;
        let nonce = fields.integer("the nonce")?;
        let command = if kind == b"M" {
            Command::Move(Move::read(&mut fields)?)
        } else {
            Command::Output(Output {
                output: OutputNumber::read(&mut fields)?,
                on: fields.flag("the level")?,
            })
        };
        fields.end()?;
        Ok(Self {
            number,
            nonce,
            command,
        })
    }
}

impl Move {
    fn write(self, line: &mut LineWriter) {
        match self {
            Self::Joint {
                pose,
                speed,
                configuration,
            } => {
                let _line = line.word("1");
                pose.write(line);
                speed.write(line);
                configuration.write(line);
            }
            Self::Linear {
                pose,
                speed,
                configuration,
            } => {
                let _line = line.word("2");
                pose.write(line);
                speed.write(line);
                configuration.write(line);
            }
            Self::Joints { joints, speed } => {
                let _line = line.word("3");
                joints.write(line);
                speed.write(line);
                // Sent because every motion has as many tokens, and ignored by the program.
                WireConfiguration::default().write(line);
            }
        }
    }

    fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        Ok(match fields.in_range("the kind of motion", 1, 3)? {
            1 => Self::Joint {
                pose: WirePose::read(fields)?,
                speed: Percent::read(fields)?,
                configuration: WireConfiguration::read(fields)?,
            },
            2 => Self::Linear {
                pose: WirePose::read(fields)?,
                speed: LinearSpeed::read(fields)?,
                configuration: WireConfiguration::read(fields)?,
            },
            _ => {
                let joints = WireJoints::read(fields)?;
                let speed = Percent::read(fields)?;
                let _ignored = WireConfiguration::read(fields)?;
                Self::Joints { joints, speed }
            }
        })
    }
}
