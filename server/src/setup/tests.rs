//! Set-ups as operators write them, right and wrong.

mod support;

mod checking;
