//! Why an instruction failed: a status and its text, the place is added by the machine.

use std::borrow::Cow;

use crate::status::Status;

#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) status: Status,
    pub(crate) message: Cow<'static, str>,
}

impl Fault {
    pub(crate) fn new(status: Status, message: impl Into<Cow<'static, str>>) -> Fault {
        Fault {
            status,
            message: message.into(),
        }
    }

    pub(crate) fn uninit() -> Fault {
        Fault::new(Status::INTP_UNINIT, "Uninitialized data is used")
    }

    pub(crate) fn overflow() -> Fault {
        Fault::new(Status::INTP_OVERFLOW, "Value overflow")
    }

    pub(crate) fn divide_by_zero() -> Fault {
        Fault::new(Status::INTP_DIVIDE_BY_ZERO, "Division by zero")
    }

    pub(crate) fn argument(message: impl Into<Cow<'static, str>>) -> Fault {
        Fault::new(Status::INTP_ARGUMENT, message)
    }

    /// A status from the host that ends the task.
    pub(crate) fn from_host(status: Status, doing: &'static str) -> Fault {
        Fault::new(status, doing)
    }
}
