//! The link in virtual time, over pipes, against a fake controller that keeps a ledger. What the link says is judged
//! by that ledger.

mod command_port;
mod fake;
mod harness;
mod identity;
mod lifecycle;
mod random;
mod seed;
mod serve;
mod status_port;
mod stopping;
mod tables;
