//! Set-ups as operators write them, right and wrong.

mod calibrating;
mod checking;
mod documents;
mod keeping;
mod refusing;
mod resolving;
mod support;
mod teaching;
mod triggers;
mod workflows;
