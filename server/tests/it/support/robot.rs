use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;

/// What a robot does with a command.
#[derive(Clone, Debug)]
pub(crate) enum Act {
    /// Writes the text and closes, as the seed program does.
    Reply(&'static str),
    /// Writes the text byte by byte and closes.
    ReplyInSingleBytes(&'static str),
    /// Writes as many bytes and closes.
    Flood(usize),
    /// Writes the text and leaves the connection open.
    ReplyAndStayOpen(&'static str),
    /// Closes without a word, or after the beginning of one.
    CloseAfter(&'static str),
    /// Says nothing and stays.
    Silence,
    /// As `Reply`, once the test has released it.
    Held(&'static str),
}

pub(crate) const ACCEPTED: &str = "SUCESS: MOVEMENT COMPLETE";

/// A controller that reads commands and follows a script.
pub(crate) struct FakeRobot {
    pub(crate) address: SocketAddr,
    seen: Arc<Mutex<Seen>>,
    gate: Arc<Semaphore>,
}

#[derive(Default)]
struct Seen {
    connections: usize,
    commands: Vec<String>,
}

impl FakeRobot {
    /// Follows `script`, one act a command; the last one repeats.
    pub(crate) async fn start(script: impl Into<Vec<Act>>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let seen = Arc::new(Mutex::new(Seen::default()));
        let gate = Arc::new(Semaphore::new(0));
        let (task_seen, task_gate) = (Arc::clone(&seen), Arc::clone(&gate));
        let script = script.into();
        drop(tokio::spawn(async move {
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                let number = {
                    let mut seen = task_seen.lock().unwrap();
                    seen.connections += 1;
                    seen.connections - 1
                };
                let act = script.get(number).or(script.last()).unwrap().clone();
                // One connection at a time, as a controller's tag. An error is the server hanging up.
                let _ended = serve(stream, act, &task_seen, &task_gate).await;
            }
        }));
        Self {
            address,
            seen,
            gate,
        }
    }

    /// A robot that takes every command.
    pub(crate) async fn accepting() -> Self {
        Self::start([Act::Reply(ACCEPTED)]).await
    }

    /// The commands received, as text.
    pub(crate) fn commands(&self) -> Vec<String> {
        self.seen.lock().unwrap().commands.clone()
    }

    /// Fails if anything reached the robot, a connection included.
    pub(crate) fn assert_untouched(&self) {
        let seen = self.seen.lock().unwrap();
        assert_eq!((seen.connections, seen.commands.as_slice()), (0, &[][..]));
    }

    /// Lets one held command be answered.
    pub(crate) fn release(&self) {
        self.gate.add_permits(1);
    }
}

async fn serve(
    mut stream: TcpStream,
    act: Act,
    seen: &Mutex<Seen>,
    gate: &Semaphore,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let mut received = Vec::new();
    while protocol::decode_command(&received).is_err() {
        if stream.read_buf(&mut received).await? == 0 {
            return Ok(());
        }
    }
    let text = String::from_utf8(received).unwrap();
    seen.lock().unwrap().commands.push(text);
    match act {
        Act::Reply(text) | Act::CloseAfter(text) => stream.write_all(text.as_bytes()).await,
        Act::ReplyInSingleBytes(text) => {
            for byte in text.bytes() {
                stream.write_all(&[byte]).await?;
                tokio::task::yield_now().await;
            }
            Ok(())
        }
        Act::Flood(bytes) => stream.write_all(&vec![b'x'; bytes]).await,
        Act::ReplyAndStayOpen(text) => {
            stream.write_all(text.as_bytes()).await?;
            wait_for_hangup(&mut stream).await
        }
        Act::Silence => wait_for_hangup(&mut stream).await,
        Act::Held(text) => {
            gate.acquire().await.unwrap().forget();
            stream.write_all(text.as_bytes()).await
        }
    }
}

async fn wait_for_hangup(stream: &mut TcpStream) -> io::Result<()> {
    let mut byte = [0];
    while stream.read(&mut byte).await? > 0 {}
    Ok(())
}
