//! The byte protocols of the KAREL programs on controllers, both directions: here the seed program's, in [`v2`] that of
//! `cell_server`.
//!
//! A client connects, writes one command and reads one reply; the controller then closes the connection.
//!
//! ```text
//! command   X Y Z W P R SPEED 1        decimal integers: thousandths of mm and of degrees, mm/s, the digit 1
//! reply     SUCESS: MOVEMENT COMPLETE  the motion was taken (one "C"; it has not ended, it has not even begun)
//!           ERROR: POINT UNREACHABLE   CHECK_EPOS said no, or the speed is out of range
//!           ERROR: INCORRECT INPUT     a value was missing or was not a number
//! ```
//!
//! Neither side writes a line end. Nothing here does I/O or reads a clock.
//!
//! ```
//! use protocol::{MoveCommand, Reply, ReplyDecode, Stream};
//! use units::{Degrees, Millimeters, MmPerSec};
//!
//! let command = MoveCommand {
//!     x: Millimeters(600.0), y: Millimeters(200.0), z: Millimeters(600.0),
//!     w: Degrees(-180.0), p: Degrees(30.0), r: Degrees(0.0),
//!     speed: MmPerSec(300.0),
//! };
//! let wire = command.to_wire()?;
//! assert_eq!(&*wire.encode(), b"600000 200000 600000 -180000 30000 0 300 1");
//!
//! let reply = protocol::decode_reply(b"ERROR: POINT UNREACHABLE", Stream::Open);
//! assert_eq!(reply, ReplyDecode::Reply(Reply::Unreachable));
//! # Ok::<(), protocol::CommandError>(())
//! ```

mod bytes;
mod command;
mod decode;
mod reply;
pub mod v2;

pub use bytes::{CommandBytes, MAX_COMMAND_BYTES};
pub use command::{CommandError, Item, MAX_SPEED, MIN_SPEED, MoveCommand, WireMove, seed_fence};
pub use decode::{DecodeError, decode_command};
pub use reply::{Reply, ReplyDecode, Stream, decode_reply};
