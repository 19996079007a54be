//! The library and the real `cellctl` binary against a server that answers what the test says.

mod cellctl_access;
mod cellctl_answers;
mod cellctl_emulator;
mod cellctl_failures;
mod cellctl_journal;
mod cellctl_usage;
mod fake;
mod library;
mod mobile;
mod samples;
