use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio_util::task::AbortOnDropHandle;

use crate::Gate;

/// The seed program's yes, spelled as it spells it.
pub const ACCEPTED: &[u8] = b"SUCESS: MOVEMENT COMPLETE";
/// The seed program's no to a point or a speed.
pub const UNREACHABLE: &[u8] = b"ERROR: POINT UNREACHABLE";
/// The seed program's no to what is not eight integers.
pub const INCORRECT_INPUT: &[u8] = b"ERROR: INCORRECT INPUT";

/// Longest command that is kept, in bytes.
const MAX_COMMAND: usize = 4096;

/// What the robot does with one connection.
#[derive(Clone, Debug)]
pub enum Turn {
    /// Reads a command, writes these bytes, closes.
    Reply(Vec<u8>),
    /// Reads a command, waits for the gate, writes these bytes, closes.
    Late(Gate, Vec<u8>),
    /// Reads, and never says anything; the connection stays open until the other side closes it.
    Silent,
    /// Closes before reading anything.
    CloseAtOnce,
    /// Reads a command and closes without a word.
    CloseWithoutReply,
}

impl Turn {
    /// Reads a command, writes `reply`, closes.
    #[must_use]
    pub fn reply(reply: &[u8]) -> Self {
        Self::Reply(reply.to_vec())
    }

    /// Reads a command, answers what no program of ours answers, closes.
    #[must_use]
    pub fn garbage() -> Self {
        Self::reply(b"\xff\x00SUCCESS\r\nERROR")
    }
}

/// A controller that answers what its script says, and remembers what it was told.
///
/// Each connection takes the next turn of the script; the last turn is taken again and again. Unlike the seed program
/// it serves connections at the same time, so that one that is held back does not hide the next.
#[derive(Debug)]
pub struct FakeRobot {
    address: SocketAddr,
    received: Arc<Mutex<Vec<Vec<u8>>>>,
    _task: AbortOnDropHandle<()>,
}

impl FakeRobot {
    /// A robot on a free port with these turns; with none at all it accepts every command.
    ///
    /// # Errors
    /// If no port can be opened.
    pub async fn start(script: impl IntoIterator<Item = Turn>) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0").await?;
        let address = listener.local_addr()?;
        let received = Arc::new(Mutex::new(Vec::new()));
        let script: Vec<Turn> = script.into_iter().collect();
        let task = tokio::spawn(serve(listener, script, Arc::clone(&received)));
        Ok(Self {
            address,
            received,
            _task: AbortOnDropHandle::new(task),
        })
    }

    /// Where the robot listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What came over each connection so far, in the order of connecting. Bytes that are no text are replaced.
    #[must_use]
    pub fn received(&self) -> Vec<String> {
        let received = self.received.lock().unwrap_or_else(PoisonError::into_inner);
        received
            .iter()
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
            .collect()
    }
}

async fn serve(listener: TcpListener, script: Vec<Turn>, received: Arc<Mutex<Vec<Vec<u8>>>>) {
    let mut turns = script.into_iter();
    let mut turn = Turn::reply(ACCEPTED);
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            Ok((socket, _)) = listener.accept() => {
                turn = turns.next().unwrap_or(turn);
                let record = Record::new(&received);
                let connection = take_turn(socket, turn.clone(), record);
                let _ = connections.spawn(async move {
                    // The other side may break off whenever it likes: that is its business, and its test's.
                    let _ = connection.await;
                });
            }
            Some(_) = connections.join_next() => {}
        }
    }
}

/// The place of one connection in the robot's memory.
struct Record {
    all: Arc<Mutex<Vec<Vec<u8>>>>,
    index: usize,
}

impl Record {
    fn new(all: &Arc<Mutex<Vec<Vec<u8>>>>) -> Self {
        let mut commands = all.lock().unwrap_or_else(PoisonError::into_inner);
        commands.push(Vec::new());
        Self {
            all: Arc::clone(all),
            index: commands.len() - 1,
        }
    }

    /// Keeps `bytes`, and tells whether the command is complete.
    fn add(&self, bytes: &[u8]) -> bool {
        let mut commands = self.all.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(command) = commands.get_mut(self.index) else {
            return false;
        };
        command.extend_from_slice(bytes);
        is_complete(command) || command.len() >= MAX_COMMAND
    }
}

async fn take_turn(mut socket: TcpStream, turn: Turn, record: Record) -> io::Result<()> {
    match turn {
        Turn::CloseAtOnce => Ok(()),
        Turn::CloseWithoutReply => read_command(&mut socket, &record).await,
        Turn::Silent => {
            read_command(&mut socket, &record).await?;
            // Not another byte is kept: whatever comes now is no part of the command.
            let mut rest = [0; 256];
            while socket.read(&mut rest).await? > 0 {}
            Ok(())
        }
        Turn::Reply(reply) => {
            read_command(&mut socket, &record).await?;
            socket.write_all(&reply).await?;
            socket.shutdown().await
        }
        Turn::Late(gate, reply) => {
            read_command(&mut socket, &record).await?;
            gate.pass().await;
            socket.write_all(&reply).await?;
            socket.shutdown().await
        }
    }
}

/// Reads until the command is complete or the other side ends it.
async fn read_command(socket: &mut TcpStream, record: &Record) -> io::Result<()> {
    let mut buffer = [0; 512];
    loop {
        let count = socket.read(&mut buffer).await?;
        if count == 0 || record.add(buffer.get(..count).unwrap_or_default()) {
            return Ok(());
        }
    }
}

/// Whether these are seven fields and the first character of the eighth, as the seed program reads them: no line end
/// tells, and none is sent.
fn is_complete(command: &[u8]) -> bool {
    let fields = command
        .split(u8::is_ascii_whitespace)
        .filter(|field| !field.is_empty());
    fields.count() >= 8
}
