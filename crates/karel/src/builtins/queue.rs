//! Queues: an array of INTEGERs that a `QUEUE_TYPE` turns into a ring.
//!
//! ASSUMPTION: sequence numbers count from 1 and stay in a row: an entry that is inserted or deleted
//! moves those of all newer ones.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{
        cell::{Address, Cell},
        fault::Fault,
    },
    status::Status,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "APPEND_QUEUE", params: &[Param::Integer, Param::Queue, Param::IntegerArray, Param::OutInteger, Param::OutInteger], required: 5, returns: Returns::Nothing, code: append },
    Builtin { name: "COPY_QUEUE", params: &[Param::Queue, Param::IntegerArray, Param::Integer, Param::Integer, Param::IntegerArray, Param::OutInteger, Param::OutInteger], required: 7, returns: Returns::Nothing, code: copy },
    Builtin { name: "DELETE_QUEUE", params: &[Param::Integer, Param::Queue, Param::IntegerArray, Param::OutInteger], required: 4, returns: Returns::Nothing, code: delete },
    Builtin { name: "GET_QUEUE", params: &[Param::Queue, Param::IntegerArray, Param::OutInteger, Param::OutInteger, Param::OutInteger], required: 5, returns: Returns::Nothing, code: get },
    Builtin { name: "INIT_QUEUE", params: &[Param::Queue], required: 1, returns: Returns::Nothing, code: init },
    Builtin { name: "INSERT_QUEUE", params: &[Param::Integer, Param::Integer, Param::Queue, Param::IntegerArray, Param::OutInteger], required: 5, returns: Returns::Nothing, code: insert },
    Builtin { name: "MODIFY_QUEUE", params: &[Param::Integer, Param::Integer, Param::Queue, Param::IntegerArray, Param::OutInteger], required: 5, returns: Returns::Nothing, code: modify },
];

/// A queue and its data, as far as they make sense together.
struct Queue {
    at: Address,
    data: Address,
    room: u32,
    first: u32,
    count: u32,
    /// Of the oldest entry.
    sequence: i32,
}

impl Queue {
    /// An uninitialized one, or one whose numbers do not fit the array, is an error.
    fn of(context: &Context<'_>, queue: usize, data: usize) -> Result<Queue, Fault> {
        let at = context.variable(queue);
        let mut numbers = [0; 3];
        for (number, offset) in numbers.iter_mut().zip(0..) {
            let Cell::Integer(value) = context.memory.get(at.plus(offset)) else {
                return Err(Fault::uninit());
            };
            *number = *value;
        }
        let data_at = context.variable(data);
        let room = super::variable::array_length(context.ty(data), data_at.extra);
        let [first, count, sequence] = numbers;
        let queue = Queue {
            at,
            data: data_at,
            room,
            first: u32::try_from(first).unwrap_or(u32::MAX),
            count: u32::try_from(count).unwrap_or(u32::MAX),
            sequence,
        };
        if room == 0 || queue.first >= room || queue.count > room || sequence < 1 {
            return Err(Fault::argument("The queue does not fit its array"));
        }
        Ok(queue)
    }

    fn place(&self, index: u32) -> Address {
        self.data.plus((self.first + index) % self.room)
    }

    /// The index of an entry by its sequence number.
    fn index(&self, sequence: i32) -> Result<u32, Status> {
        let index = sequence.checked_sub(self.sequence);
        let index = index.and_then(|index| u32::try_from(index).ok());
        let there = |index: &u32| *index < self.count;
        index.filter(there).ok_or(Status::QUEUE_ENTRY)
    }

    fn newest(&self) -> i32 {
        let count = i32::try_from(self.count).unwrap_or(i32::MAX);
        self.sequence.saturating_add(count) - 1
    }

    fn store(&self, context: &mut Context<'_>) {
        // The numbers of a queue that was used for long begin again.
        let sequence = if self.count == 0 && self.sequence > i32::MAX / 2 {
            1
        } else {
            self.sequence
        };
        let signed = |number: u32| i32::try_from(number).unwrap_or(i32::MAX);
        for (number, offset) in [signed(self.first), signed(self.count), sequence]
            .into_iter()
            .zip(0..)
        {
            context
                .memory
                .set(self.at.plus(offset), Cell::Integer(number));
        }
    }
}

fn init(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let at = context.variable(0);
    for (number, offset) in [0, 0, 1].into_iter().zip(0..) {
        context.memory.set(at.plus(offset), Cell::Integer(number));
    }
    Ok(Outcome::Done)
}

/// `APPEND_QUEUE(value, queue, data, sequence number, status)`.
fn append(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mut queue = Queue::of(context, 1, 2)?;
    let status = if queue.count < queue.room {
        let value = context.integer(0);
        context
            .memory
            .set(queue.place(queue.count), Cell::Integer(value));
        queue.count += 1;
        context.put(3, Cell::Integer(queue.newest()));
        queue.store(context);
        Status::OK
    } else {
        Status::QUEUE_FULL
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

/// `GET_QUEUE(queue, data, value, status, sequence number)`: takes the oldest entry.
fn get(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mut queue = Queue::of(context, 0, 1)?;
    let status = if queue.count > 0 {
        let value = context.memory.get(queue.place(0)).clone();
        context.put(2, value);
        context.put(4, Cell::Integer(queue.sequence));
        queue.first = (queue.first + 1) % queue.room;
        queue.count -= 1;
        queue.sequence = queue.sequence.saturating_add(1);
        queue.store(context);
        Status::OK
    } else {
        Status::QUEUE_ENTRY
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// `DELETE_QUEUE(sequence number, queue, data, status)`.
fn delete(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mut queue = Queue::of(context, 1, 2)?;
    let status = match queue.index(context.integer(0)) {
        Ok(index) => {
            for to in index..queue.count - 1 {
                let cell = context.memory.get(queue.place(to + 1)).clone();
                context.memory.set(queue.place(to), cell);
            }
            queue.count -= 1;
            queue.store(context);
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(3, status);
    Ok(Outcome::Done)
}

/// `INSERT_QUEUE(value, sequence number, queue, data, status)`: before the entry of that number.
fn insert(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let mut queue = Queue::of(context, 2, 3)?;
    let status = match queue.index(context.integer(1)) {
        Ok(_) if queue.count == queue.room => Status::QUEUE_FULL,
        Ok(index) => {
            for from in (index..queue.count).rev() {
                let cell = context.memory.get(queue.place(from)).clone();
                context.memory.set(queue.place(from + 1), cell);
            }
            let value = context.integer(0);
            context.memory.set(queue.place(index), Cell::Integer(value));
            queue.count += 1;
            queue.store(context);
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

/// `MODIFY_QUEUE(value, sequence number, queue, data, status)`.
fn modify(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let queue = Queue::of(context, 2, 3)?;
    let status = match queue.index(context.integer(1)) {
        Ok(index) => {
            let value = context.integer(0);
            context.memory.set(queue.place(index), Cell::Integer(value));
            Status::OK
        }
        Err(status) => status,
    };
    context.put_status(4, status);
    Ok(Outcome::Done)
}

/// `COPY_QUEUE(queue, data, sequence number, skip, out, count, status)`: from the entry of that
/// number on, 0 being the oldest, without taking them.
fn copy(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let queue = Queue::of(context, 0, 1)?;
    let skip = u32::try_from(context.integer(3)).unwrap_or(0);
    let start = match context.integer(2) {
        0 => Ok(0),
        sequence => queue.index(sequence),
    };
    let out = context.variable(4);
    let room = super::variable::array_length(context.ty(4), out.extra);
    let (count, status) = match start {
        Ok(start) => {
            let mut count = 0;
            let indices = start.saturating_add(skip)..queue.count;
            for (index, offset) in indices.zip(0..room) {
                let cell = context.memory.get(queue.place(index)).clone();
                context.memory.set(out.plus(offset), cell);
                count += 1;
            }
            (count, Status::OK)
        }
        Err(status) => (0, status),
    };
    context.put(5, Cell::Integer(count));
    context.put_status(6, status);
    Ok(Outcome::Done)
}
