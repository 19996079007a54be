//! The fake controller's two ports, and what goes wrong on them.
#![expect(
    clippy::wildcard_enum_match_arm,
    reason = "a fault concerns one step of a connection; the other steps let it pass"
)]

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use protocol::v2::{LineDecoder, Reply, Request, StatusReply, Verb};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, DuplexStream, duplex};
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;

use super::fake::{Brain, Event};
use crate::link::{Connector, ControllerAddress};

/// What goes wrong with one connection to the command port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fault {
    None,
    Refused,
    DropBeforeGreeting,
    NoGreeting,
    LateGreeting(Duration),
    CorruptGreeting,
    DropAfterGreeting,
    /// The command is read and forgotten.
    DropAfterRead,
    /// The command is read late.
    LateRead(Duration),
    /// Answered with this, whatever was sent.
    Answer(Reply),
    DropAfterAccept,
    CorruptAck,
    SilentAfterAccept,
    DropAfterAck,
    /// The answer comes byte by byte.
    Drip(Duration),
    CorruptDone,
    SilentAfterAck,
}

/// How the status port behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Status {
    Well,
    Refused,
    /// Connections are never made.
    BlackHole,
    /// Connected, and nothing is read.
    Silent,
    /// Every line is obeyed, no answer gets through.
    Deaf,
    /// Answers come this late.
    Late(Duration),
    /// The next answer has a changed byte; then well.
    Corrupt,
    /// The next line is answered by ERR; then well.
    Malformed,
    /// The next line is followed by the end of the connection; then well.
    Drop,
}

#[derive(Clone, Debug)]
pub(super) struct Fake(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    brain: Mutex<Brain>,
    faults: Mutex<VecDeque<Fault>>,
    status: Mutex<Status>,
    /// Replaced when power is lost: every connection ends.
    power: Mutex<CancellationToken>,
    /// When the status port was asked for a connection.
    attempts: Mutex<Vec<Instant>>,
    turn: tokio::sync::Mutex<()>,
    /// The pose server listens on the command port.
    seed: AtomicBool,
}

pub(super) const COMMAND: &str = "127.0.0.1:59002";

impl Fake {
    pub(super) fn new() -> Self {
        Self(Arc::new(Inner {
            brain: Mutex::new(Brain::new()),
            faults: Mutex::default(),
            status: Mutex::new(Status::Well),
            power: Mutex::default(),
            attempts: Mutex::default(),
            turn: tokio::sync::Mutex::default(),
            seed: AtomicBool::new(false),
        }))
    }

    /// A controller of tier 1.
    pub(super) fn seed() -> Self {
        let fake = Self::new();
        fake.0.seed.store(true, Ordering::Relaxed);
        fake
    }

    /// Puts another controller at the address; gives the one that was there.
    pub(super) fn swap(&self, other: Brain) -> Brain {
        std::mem::replace(&mut *self.brain(), other)
    }

    pub(super) fn brain(&self) -> MutexGuard<'_, Brain> {
        self.0.brain.lock().unwrap()
    }

    pub(super) fn then(&self, fault: Fault) {
        self.0.faults.lock().unwrap().push_back(fault);
    }

    pub(super) fn clear_faults(&self) {
        self.0.faults.lock().unwrap().clear();
    }

    pub(super) fn set_status(&self, status: Status) {
        *self.0.status.lock().unwrap() = status;
    }

    /// Ends every connection.
    pub(super) fn cut(&self) {
        let old = std::mem::take(&mut *self.0.power.lock().unwrap());
        old.cancel();
    }

    pub(super) fn lose_power(&self) {
        self.cut();
        self.brain().lose_power();
    }

    pub(super) fn is_well(&self) -> bool {
        self.status() == Status::Well
    }

    pub(super) fn attempts(&self) -> Vec<Instant> {
        std::mem::take(&mut self.0.attempts.lock().unwrap())
    }

    pub(super) fn ledger(&self) -> Vec<Event> {
        self.brain().ledger.clone()
    }

    fn status(&self) -> Status {
        *self.0.status.lock().unwrap()
    }

    /// A fault that happens once.
    fn take_status(&self) -> Status {
        let mut status = self.0.status.lock().unwrap();
        match *status {
            once @ (Status::Corrupt | Status::Malformed | Status::Drop) => {
                *status = Status::Well;
                once
            }
            lasting => lasting,
        }
    }

    async fn serve_command(self, mut stream: DuplexStream, fault: Fault) -> io::Result<()> {
        let _turn = self.0.turn.lock().await;
        match fault {
            Fault::DropBeforeGreeting => return Ok(()),
            Fault::NoGreeting => return until_hangup(&mut stream).await,
            Fault::LateGreeting(late) => sleep(late).await,
            _ => {}
        }
        let mut greeting = self.brain().greet().encode();
        if fault == Fault::CorruptGreeting {
            corrupt(&mut greeting);
        }
        stream.write_all(&greeting).await?;
        if fault == Fault::DropAfterGreeting {
            return Ok(());
        }
        let mut lines = Lines::default();
        let read = timeout(Duration::from_millis(500), lines.next(&mut stream));
        let Ok(Ok(Some(line))) = read.await else {
            return Ok(());
        };
        match fault {
            Fault::DropAfterRead => {
                if let Ok(request) = Request::decode(&line) {
                    self.brain().ledger.push(Event::Received(request.number));
                }
                return Ok(());
            }
            Fault::LateRead(late) => sleep(late).await,
            Fault::Answer(reply) => {
                if let Ok(request) = Request::decode(&line) {
                    self.brain().ledger.push(Event::Received(request.number));
                }
                return stream.write_all(&reply.encode()).await;
            }
            _ => {}
        }
        let Ok(request) = Request::decode(&line) else {
            let malformed = Reply::Err(protocol::v2::ErrorCode::Malformed);
            return stream.write_all(&malformed.encode()).await;
        };
        let number = request.number;
        let taken = self.brain().take(&request);
        if let Err(reply) = taken {
            return stream.write_all(&reply.encode()).await;
        }
        let mut ack = Reply::Ack(number).encode();
        match fault {
            Fault::DropAfterAccept => return Ok(()),
            Fault::SilentAfterAccept => return until_hangup(&mut stream).await,
            Fault::CorruptAck => corrupt(&mut ack),
            _ => {}
        }
        stream.write_all(&ack).await?;
        match fault {
            Fault::DropAfterAck => return Ok(()),
            Fault::SilentAfterAck => return until_hangup(&mut stream).await,
            _ => {}
        }
        while !self.brain().has_finished(number) {
            sleep(Duration::from_millis(10)).await;
        }
        let (finish, pose) = {
            let brain = self.brain();
            (brain.status.finish, brain.status.pose)
        };
        let mut done = Reply::Done {
            number,
            finish,
            pose,
        }
        .encode();
        if fault == Fault::CorruptDone {
            corrupt(&mut done);
        }
        stream.write_all(&done).await
    }

    /// One connection of the pose server: a command, a text, closed.
    async fn serve_seed(self, mut stream: DuplexStream, fault: Fault) -> io::Result<()> {
        let _turn = self.0.turn.lock().await;
        let mut bytes = Vec::new();
        let command = loop {
            if stream.read_buf(&mut bytes).await? == 0 {
                return Ok(());
            }
            if bytes == *protocol::seed_fence() {
                return stream
                    .write_all(protocol::Reply::Unreachable.text().as_bytes())
                    .await;
            }
            if let Ok(command) = protocol::decode_command(&bytes) {
                break command;
            }
        };
        match fault {
            Fault::DropAfterRead => return Ok(()),
            Fault::LateRead(late) => sleep(late).await,
            _ => {}
        }
        self.brain().take_seed(&command);
        match fault {
            Fault::DropAfterAccept => Ok(()),
            Fault::SilentAfterAccept => until_hangup(&mut stream).await,
            Fault::Drip(pause) => {
                for byte in protocol::Reply::Accepted.text().bytes() {
                    stream.write_all(&[byte]).await?;
                    sleep(pause).await;
                }
                Ok(())
            }
            _ => {
                stream
                    .write_all(protocol::Reply::Accepted.text().as_bytes())
                    .await
            }
        }
    }

    async fn serve_status(self, mut stream: DuplexStream) -> io::Result<()> {
        let mut lines = Lines::default();
        loop {
            let Some(line) = lines.next(&mut stream).await? else {
                return Ok(());
            };
            while self.status() == Status::Silent {
                sleep(Duration::from_millis(10)).await;
            }
            let status = self.take_status();
            let mut answer = match Verb::decode(&line) {
                Ok(verb) if status != Status::Malformed => {
                    StatusReply::Status(self.brain().obey(verb))
                }
                _ => StatusReply::Malformed,
            }
            .encode();
            match status {
                Status::Deaf => continue,
                Status::Drop => return Ok(()),
                Status::Corrupt => corrupt(&mut answer),
                Status::Late(late) => sleep(late).await,
                _ => {}
            }
            stream.write_all(&answer).await?;
        }
    }
}

impl Connector for Fake {
    type Stream = DuplexStream;

    async fn connect(&self, address: &ControllerAddress) -> io::Result<DuplexStream> {
        let power = self.0.power.lock().unwrap().clone();
        let (ours, theirs) = duplex(4096);
        let fake = self.clone();
        if address.to_string() == COMMAND {
            let fault = self.0.faults.lock().unwrap().pop_front();
            let fault = fault.unwrap_or(Fault::None);
            if fault == Fault::Refused {
                return Err(io::ErrorKind::ConnectionRefused.into());
            }
            let seed = self.0.seed.load(Ordering::Relaxed);
            drop(tokio::spawn(async move {
                let serving = async {
                    if seed {
                        fake.serve_seed(theirs, fault).await
                    } else {
                        fake.serve_command(theirs, fault).await
                    }
                };
                power.run_until_cancelled(serving).await
            }));
        } else {
            self.0.attempts.lock().unwrap().push(Instant::now());
            match self.status() {
                Status::Refused => return Err(io::ErrorKind::ConnectionRefused.into()),
                Status::BlackHole => std::future::pending().await,
                _ => {}
            }
            drop(tokio::spawn(async move {
                power.run_until_cancelled(fake.serve_status(theirs)).await
            }));
        }
        Ok(ours)
    }
}

/// Changes a digit, which the checksum must notice.
fn corrupt(line: &mut [u8]) {
    let digit = line.iter_mut().find(|byte| byte.is_ascii_digit()).unwrap();
    *digit = if *digit == b'7' { b'3' } else { b'7' };
}

async fn until_hangup(stream: &mut DuplexStream) -> io::Result<()> {
    let mut byte = [0];
    while stream.read(&mut byte).await? > 0 {}
    Ok(())
}

#[derive(Default)]
struct Lines {
    decoder: LineDecoder,
}

impl Lines {
    async fn next(&mut self, stream: &mut DuplexStream) -> io::Result<Option<Vec<u8>>> {
        let mut byte = [0];
        while stream.read(&mut byte).await? > 0 {
            if let Some(line) = self.decoder.push(byte[0]).unwrap() {
                return Ok(Some(line.to_vec()));
            }
        }
        Ok(None)
    }
}
