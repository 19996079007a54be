//! Workflows in a little world: both of them without a fault, with every fault of the matrix, and with thousands of
//! seeds of bad luck.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::wildcard_enum_match_arm,
    clippy::panic,
    clippy::cast_possible_truncation,
    clippy::print_stdout,
    clippy::too_many_lines,
    clippy::struct_excessive_bools,
    clippy::type_complexity,
    clippy::enum_glob_use,
    clippy::manual_is_multiple_of,
    clippy::match_same_arms,
    reason = "a test stops where it is wrong"
)]

mod any_moment;
mod c10;
mod faults;
mod gaps;
mod happy;
mod mobile;
mod props;
mod sim;
mod usual;
mod world;
