//! Alarms: what the controller complains about, newest last.

use std::collections::VecDeque;

use karel::Status;
use serde::{Deserialize, Serialize};

/// How much an alarm stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing stops.
    Warn,
    /// Tasks pause.
    Pause,
    /// The task is aborted.
    Abort,
}

/// What an alarm says whose program adds no words: those that public programs post. Words of our own.
pub(crate) fn meaning(status: Status) -> &'static str {
    match status {
        Status::FILE_ILLEGAL_PARAMETER => "Illegal parameter",
        Status::INTP_UNINIT => "Uninitialized data is used",
        Status::PRIO_PORT_NUMBER => "Illegal port number",
        Status::HOST_TAG => "Communication tag error",
        _ => "",
    }
}

/// One alarm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Alarm {
    /// Counts from 1.
    pub seq: u64,
    /// Controller time since power-on.
    pub time_s: f64,
    /// Four letters, such as `MOTN`.
    pub facility: String,
    /// The number within the facility.
    pub number: u32,
    /// What is wrong, in one sentence, with names, values and limits.
    pub text: String,
    /// How much it stops.
    pub severity: Severity,
    /// The program that caused it.
    pub program: Option<String>,
    /// Its source line.
    pub line: Option<u32>,
    /// Not yet reset.
    pub active: bool,
}

impl Alarm {
    /// `MOTN-017 text`, as the pendant's alarm line.
    #[must_use]
    pub fn headline(&self) -> String {
        format!("{}-{:03} {}", self.facility, self.number, self.text)
    }
}

/// The newest alarms, up to a bound; what fell off is counted.
#[derive(Debug)]
pub struct AlarmLog {
    alarms: VecDeque<Alarm>,
    capacity: usize,
    dropped: u64,
    last_seq: u64,
}

impl AlarmLog {
    /// An empty log of at most `capacity` alarms.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self {
            alarms: VecDeque::new(),
            capacity,
            dropped: 0,
            last_seq: 0,
        }
    }

    /// Adds an alarm; its number is set here. A warning does not stay active.
    pub fn post(&mut self, mut alarm: Alarm) {
        self.last_seq += 1;
        alarm.seq = self.last_seq;
        alarm.active = alarm.severity != Severity::Warn;
        if self.alarms.len() >= self.capacity {
            let _oldest = self.alarms.pop_front();
            self.dropped += 1;
        }
        self.alarms.push_back(alarm);
    }

    /// RESET: no alarm is active any more. The history stays.
    pub fn reset(&mut self) {
        for alarm in &mut self.alarms {
            alarm.active = false;
        }
    }

    /// Oldest first.
    #[must_use]
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Alarm> {
        self.alarms.iter()
    }

    /// How many alarms are active.
    #[must_use]
    pub fn active(&self) -> usize {
        self.alarms.iter().filter(|alarm| alarm.active).count()
    }

    /// How many alarms were dropped because the log was full.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alarm(severity: Severity) -> Alarm {
        Alarm {
            seq: 0,
            time_s: 1.5,
            facility: "MOTN".to_owned(),
            number: 17,
            text: "Limit error.".to_owned(),
            severity,
            program: None,
            line: None,
            active: false,
        }
    }

    #[test]
    fn reset_keeps_the_history_and_clears_what_is_active() {
        let mut log = AlarmLog::new(10);
        log.post(alarm(Severity::Abort));
        log.post(alarm(Severity::Warn));
        assert_eq!(log.active(), 1);
        log.reset();
        assert_eq!(log.active(), 0);
        assert_eq!(log.iter().count(), 2);
    }

    #[test]
    fn a_full_log_counts_what_it_drops() {
        let mut log = AlarmLog::new(1);
        log.post(alarm(Severity::Warn));
        log.post(alarm(Severity::Warn));
        assert_eq!((log.iter().count(), log.dropped()), (1, 1));
        assert_eq!(
            log.iter().next().unwrap().headline(),
            "MOTN-017 Limit error."
        );
    }
}
