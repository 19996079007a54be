//! Version 2 of the wire: the lines of the tier-2 controller program, both directions.
//!
//! A line is ASCII: a word that says what it is, decimal integers, and a checksum over everything before the last
//! blank. Lengths are thousandths of a millimeter, angles thousandths of a degree. The command port takes one
//! command a connection: [`Greeting`], [`Request`], [`Reply`]. The status port takes a [`Verb`] at a time and answers
//! each with a [`StatusReply`].
//!
//! A line is taken only in its canonical form: one blank between two tokens, no plus sign, no leading zero. So a
//! changed byte is noticed, by the checksum or by the form, and a program that writes another form is found at once.
//!
//! ```
//! use protocol::v2::{Command, MotionNumber, Percent, Move, Request, WireConfiguration, WirePose};
//! use units::{Degrees, Millimeters};
//!
//! let pose = WirePose::try_new(
//!     [Millimeters(985.0), Millimeters(0.0), Millimeters(940.0)],
//!     [Degrees(-180.0), Degrees(0.0), Degrees(0.0)],
//! )?;
//! let request = Request {
//!     number: MotionNumber { epoch: 7_000, seq: 1 },
//!     nonce: 4_711,
//!     command: Command::Move(Move::Joint {
//!         pose,
//!         speed: Percent::try_new(30)?,
//!         configuration: WireConfiguration::default(),
//!     }),
//! };
//! let line = request.encode();
//! assert_eq!(line, b"M 7000 1 4711 1 985000 0 940000 -180000 0 0 30 N U T 0 0 0 41294\r\n");
//! assert_eq!(Request::decode(line.trim_ascii_end())?, request);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod command;
mod error;
mod fields;
mod greeting;
mod line;
mod reply;
mod status;
mod values;
mod verb;

pub use command::{Command, Elbow, Flip, Front, Move, Output, Request, WireConfiguration};
pub use error::{DecodeError, ValueError};
pub use greeting::Greeting;
pub use line::{LineDecoder, LineTooLong, MAX_LINE_BYTES, checksum};
pub use reply::{ErrorCode, FinishStatus, Reply};
pub use status::{OperatingMode, StatusLine, StatusReply};
pub use values::{LARGEST, LinearSpeed, MotionNumber, OutputNumber, Percent, WireJoints, WirePose};
pub use verb::Verb;
