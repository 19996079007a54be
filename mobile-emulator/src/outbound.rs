//! Signals on their way to the cell: numbered, in order, sent until they are answered.

use std::collections::VecDeque;
use std::time::Duration;

use api::{SignalBody, SignalData, SignalName};
use jiff::Timestamp;
use uuid::Uuid;

use crate::fault::{LostNumber, SignalFault};
use crate::fault_book::FaultBook;

/// Signals that may wait. A robot writes a few for each order; so many mean that the cell was away for very long.
const QUEUE: usize = 1000;

/// What came of sending a signal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SendOutcome {
    /// The cell answered.
    Answered {
        /// The HTTP status.
        status: u16,
        /// `accepted`, `duplicate`, `parked`, or the code of the problem.
        answer: String,
    },
    /// It waits for an earlier number, which this robot has lost.
    Gap {
        /// That number.
        expected: u64,
    },
    /// It did not, or answered that it cannot.
    Unanswered {
        /// Why.
        reason: String,
    },
}

/// A signal to send now.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sending {
    pub(crate) signal: SignalBody,
    pub(crate) attempt: u32,
}

/// What the outbound side has to tell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Dispatch {
    Send(Box<Sending>),
    /// A fault took it.
    Lost(SignalName, Option<u64>),
}

#[derive(Clone, Debug)]
struct Pending {
    name: SignalName,
    session: Option<Uuid>,
    at: Timestamp,
    data: SignalData,
    resync: bool,
    seq: Option<u64>,
    attempts: u32,
    not_before: Duration,
    trouble: Trouble,
}

/// What the faults do to a signal.
#[derive(Clone, Debug, Default)]
struct Trouble {
    lose_transmissions: u32,
    lose_answers: u32,
    copies: u32,
    overtaken: bool,
    lost: Option<LostNumber>,
}

/// How long to wait before a signal is sent again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Backoff {
    pub(crate) first: Duration,
    pub(crate) last: Duration,
}

#[derive(Clone, Debug)]
pub(crate) struct Outbound {
    boot: u64,
    last_seq: u64,
    queue: VecDeque<Pending>,
    in_flight: bool,
    backoff: Backoff,
}

impl Outbound {
    pub(crate) fn new(boot: u64, backoff: Backoff) -> Self {
        Self {
            boot,
            last_seq: 0,
            queue: VecDeque::new(),
            in_flight: false,
            backoff,
        }
    }

    pub(crate) fn last_seq(&self) -> u64 {
        self.last_seq
    }

    pub(crate) fn waiting(&self) -> usize {
        self.queue.len()
    }

    /// Writes a signal; it is numbered when it first leaves. False if there is no room.
    pub(crate) fn write(
        &mut self,
        name: SignalName,
        session: Option<Uuid>,
        (at, now): (Timestamp, Duration),
        data: SignalData,
        faults: &mut FaultBook,
    ) -> bool {
        if name == SignalName::MrHeartbeat {
            // A heartbeat tells of now; one that waits unsent is replaced.
            let waiting = self.queue.iter_mut().skip(usize::from(self.in_flight));
            for pending in waiting {
                if pending.name == name && pending.seq.is_none() && !pending.resync {
                    pending.at = at;
                    pending.session = session;
                    pending.data = data;
                    return true;
                }
            }
        }
        if self.queue.len() >= QUEUE {
            return false;
        }
        let (trouble, delay) = trouble_for(name, faults);
        self.queue.push_back(Pending {
            name,
            session,
            at,
            data,
            resync: false,
            seq: None,
            attempts: 0,
            not_before: now.saturating_add(delay),
            trouble,
        });
        true
    }

    /// The next thing to do with the signals, if it is time.
    pub(crate) fn dispatch(&mut self, now: Duration) -> Option<Dispatch> {
        if self.in_flight {
            return None;
        }
        let head = self.queue.front()?;
        if head.trouble.overtaken {
            let _after = self.queue.get(1)?;
            let first = self.number_at(0);
            let second = self.number_at(1);
            if let Some(head) = self.queue.front_mut() {
                head.trouble.overtaken = false;
                head.seq = first;
            }
            if let Some(next) = self.queue.get_mut(1) {
                next.seq = second;
            }
            self.queue.swap(0, 1);
        }
        let head = self.queue.front()?;
        if now < head.not_before {
            return None;
        }
        if let Some(number) = head.trouble.lost {
            let seq = match number {
                LostNumber::Unused => head.seq,
                LostNumber::Consumed => self.number_at(0),
            };
            let lost = self.queue.pop_front()?;
            return Some(Dispatch::Lost(lost.name, seq));
        }
        let seq = self.number_at(0);
        let boot = self.boot;
        let backoff = self.backoff;
        let head = self.queue.front_mut()?;
        head.seq = seq;
        head.attempts = head.attempts.saturating_add(1);
        if head.trouble.lose_transmissions > 0 {
            head.trouble.lose_transmissions -= 1;
            head.not_before = now.saturating_add(backoff.after(head.attempts));
            return Some(Dispatch::Lost(head.name, seq));
        }
        self.in_flight = true;
        Some(Dispatch::Send(Box::new(Sending {
            signal: SignalBody {
                session: head.session,
                seq: seq?,
                boot,
                signal: head.name,
                resync: head.resync,
                at: head.at,
                data: head.data.clone(),
            },
            attempt: head.attempts,
        })))
    }

    /// Takes the outcome of what was sent last. Whether it is done with.
    pub(crate) fn outcome(&mut self, answered: bool, now: Duration) -> bool {
        self.in_flight = false;
        let backoff = self.backoff;
        let Some(head) = self.queue.front_mut() else {
            return true;
        };
        if answered && head.trouble.lose_answers == 0 && head.trouble.copies == 0 {
            let _done = self.queue.pop_front();
            return true;
        }
        if answered && head.trouble.lose_answers == 0 {
            head.trouble.copies -= 1;
            return false;
        }
        head.trouble.lose_answers = head
            .trouble
            .lose_answers
            .saturating_sub(u32::from(answered));
        head.not_before = now.saturating_add(backoff.after(head.attempts));
        false
    }

    /// The cell waits for a signal that does not exist any more: a heartbeat says so, under a number of its own. What
    /// waits comes after it, also under new numbers, because those it had are given up.
    pub(crate) fn resync(&mut self, at: Timestamp, now: Duration, data: SignalData) {
        self.in_flight = false;
        for pending in &mut self.queue {
            pending.seq = None;
        }
        self.queue.push_front(Pending {
            name: SignalName::MrHeartbeat,
            session: None,
            at,
            data,
            resync: true,
            seq: None,
            attempts: 0,
            not_before: now,
            trouble: Trouble::default(),
        });
    }

    /// When something is to be sent, if nothing is on its way.
    pub(crate) fn next_wake(&self) -> Option<Duration> {
        let head = self.queue.front()?;
        let waits = self.in_flight || (head.trouble.overtaken && self.queue.len() < 2);
        (!waits).then_some(head.not_before)
    }

    /// The number of a waiting signal: its own, or the next.
    fn number_at(&mut self, index: usize) -> Option<u64> {
        let pending = self.queue.get_mut(index)?;
        if pending.seq.is_none() {
            self.last_seq += 1;
            pending.seq = Some(self.last_seq);
        }
        pending.seq
    }
}

impl Backoff {
    fn after(self, attempts: u32) -> Duration {
        let doublings = attempts.saturating_sub(1).min(16);
        self.first.saturating_mul(1 << doublings).min(self.last)
    }
}

/// What the faults that are set do to a signal of this name.
fn trouble_for(name: SignalName, faults: &mut FaultBook) -> (Trouble, Duration) {
    let mut trouble = Trouble::default();
    let mut delay = Duration::ZERO;
    for fault in faults.for_signal(name) {
        match fault {
            SignalFault::Lose(transmissions) => trouble.lose_transmissions = transmissions,
            SignalFault::LoseForEver(number) => trouble.lost = Some(number),
            SignalFault::LoseAnswers(answers) => trouble.lose_answers = answers,
            SignalFault::Delay(seconds) => {
                delay = Duration::try_from_secs_f64(seconds).unwrap_or_default();
            }
            SignalFault::Copies(copies) => trouble.copies = copies,
            SignalFault::Overtaken => trouble.overtaken = true,
        }
    }
    (trouble, delay)
}
