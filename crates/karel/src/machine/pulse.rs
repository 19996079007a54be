//! Ports that a PULSE has turned and that turn back by themselves.

use std::time::Duration;

use crate::{
    host::{Host, TaskId},
    port::{Port, PortValue},
};

#[derive(Debug, Default)]
pub(crate) struct Pulses(Vec<Pulse>);

#[derive(Debug)]
struct Pulse {
    task: TaskId,
    port: Port,
    number: i32,
    back: PortValue,
    at: Duration,
}

impl Pulses {
    /// Most that can be on at a time.
    pub(crate) const MOST: usize = 256;

    /// Notes a pulse. `false` if there are too many.
    pub(crate) fn add(
        &mut self,
        task: TaskId,
        (port, number): (Port, i32),
        back: PortValue,
        at: Duration,
    ) -> bool {
        if self.0.len() >= Pulses::MOST {
            return false;
        }
        self.0.push(Pulse {
            task,
            port,
            number,
            back,
            at,
        });
        true
    }

    pub(crate) fn next(&self) -> Option<Duration> {
        self.0.iter().map(|pulse| pulse.at).min()
    }

    /// Ends those whose time is over, in the order in which they began.
    pub(crate) fn follow(&mut self, host: &mut dyn Host) {
        let now = host.now();
        self.0.retain(|pulse| {
            let over = pulse.at <= now;
            if over {
                // The port was there when the pulse began; without it there is nothing to turn back.
                let _ = host.set_port(pulse.task, pulse.port, pulse.number, pulse.back);
            }
            !over
        });
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}
