//! Status codes of a controller: facility times 1000 plus number, zero for success.

use std::fmt;

/// What a built-in, an I/O statement or the host answers: `0`, or `facility * 1000 + number`.
///
/// `Display` writes the controller's own notation, `HOST-144` or `INTP-311`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Status(pub i32);

impl Status {
    /// Success.
    pub const OK: Status = Status(0);

    /// FILE-021: end of file.
    pub const FILE_END: Status = Status(2021);
    /// FILE-014: the file does not exist.
    ///
    /// ASSUMPTION: this number and those of FILE-013 and FILE-005 are from memory of error lists.
    pub const FILE_NOT_FOUND: Status = Status(2014);
    /// FILE-013: the file exists already.
    pub const FILE_EXISTS: Status = Status(2013);
    /// FILE-005: the device is full.
    pub const FILE_DEVICE_FULL: Status = Status(2005);
    /// FILE-007: the device does not exist or is not mounted.
    ///
    /// ASSUMPTION: the number is ours; programs in the field only compare with 0.
    pub const FILE_NO_DEVICE: Status = Status(2007);
    /// Nothing can be read now from a pipe that does not wait.
    pub const WOULD_BLOCK: Status = Status(282);
    /// FILE-032: illegal parameter, such as an open mode that does not exist.
    pub const FILE_ILLEGAL_PARAMETER: Status = Status(2032);
    /// PROG-001: a program that shall run runs already.
    ///
    /// ASSUMPTION: this number and that of PROG-002 are ours; programs in the field only compare
    /// with 0.
    pub const PROG_RUNNING: Status = Status(3001);
    /// PROG-002: a task that shall be ended or looked at does not run, or cannot be started.
    pub const PROG_NO_TASK: Status = Status(3002);
    /// MEMO-004: the program is needed as it is.
    pub const MEMO_IN_USE: Status = Status(7004);
    /// MEMO-015: the program exists already.
    pub const MEMO_EXISTS: Status = Status(7015);
    /// MEMO-073: the program does not exist.
    pub const MEMO_NO_PROGRAM: Status = Status(7073);

    /// INTP-213: an alarm of a user, `UALM`.
    ///
    /// ASSUMPTION: the number is from memory of error lists.
    pub const INTP_USER_ALARM: Status = Status(12213);
    /// INTP-216: a TP program has no such label.
    ///
    /// ASSUMPTION: the number is ours.
    pub const INTP_LABEL: Status = Status(12216);
    /// INTP-252: a taught position is for another frame or tool than the active one.
    ///
    /// ASSUMPTION: the number is from memory of error lists.
    pub const INTP_FRAME: Status = Status(12252);
    /// INTP-302: the call stack is full.
    pub const INTP_STACK_OVERFLOW: Status = Status(12302);
    /// INTP-303: a limit of the interpreter was exceeded.
    pub const INTP_LIMIT: Status = Status(12303);
    /// INTP-304: array lengths differ.
    pub const INTP_ARRAY_LENGTH: Status = Status(12304);
    /// INTP-307: a number is divided by zero.
    ///
    /// ASSUMPTION: the number is from memory of error lists.
    pub const INTP_DIVIDE_BY_ZERO: Status = Status(12307);
    /// INTP-308: no CASE of a SELECT matched and there was no ELSE.
    pub const INTP_NO_CASE: Status = Status(12308);
    /// INTP-310: subscript out of range.
    pub const INTP_SUBSCRIPT: Status = Status(12310);
    /// INTP-311: uninitialized data is used.
    pub const INTP_UNINIT: Status = Status(12311);
    /// INTP-316: a routine or program cannot be called.
    pub const INTP_CALL_FAILED: Status = Status(12316);
    /// INTP-319: the type of a value does not fit.
    pub const INTP_TYPE: Status = Status(12319);
    /// INTP-320: the built-in does not exist on this controller.
    pub const INTP_UNDEFINED_BUILTIN: Status = Status(12320);
    /// INTP-321: a function reached its END without a RETURN.
    ///
    /// ASSUMPTION: the number is from memory of error lists.
    pub const INTP_MISSING_RETURN: Status = Status(12321);
    /// INTP-322: bad argument of a built-in.
    pub const INTP_ARGUMENT: Status = Status(12322);
    /// INTP-323: arithmetic overflow.
    pub const INTP_OVERFLOW: Status = Status(12323);
    /// INTP-326: the file variable is already in use.
    pub const INTP_FILE_IN_USE: Status = Status(12326);
    /// INTP-327: the file cannot be opened.
    pub const INTP_OPEN_FAILED: Status = Status(12327);
    /// INTP-328: the file is not open.
    pub const INTP_NOT_OPEN: Status = Status(12328);
    /// INTP-330: a write failed.
    pub const INTP_WRITE_FAILED: Status = Status(12330);
    /// INTP-332: too little data for a read.
    pub const INTP_SHORT_DATA: Status = Status(12332);
    /// INTP-333: the characters do not form a value of the type that is read.
    pub const INTP_ILLEGAL_DATA: Status = Status(12333);
    /// INTP-334: a read failed.
    pub const INTP_READ_FAILED: Status = Status(12334);

    /// INTP-360: a direction of length 0.
    pub const INTP_ZERO_VECTOR: Status = Status(12360);

    /// INTP-335: a file variable that is a window cannot be opened, read or closed so.
    pub const INTP_PREDEFINED: Status = Status(12335);

    /// INTP-358: a READ gave up waiting, see `ATR_TIMEOUT`.
    pub const INTP_READ_TIMEOUT: Status = Status(12358);

    /// INTP-383: a PATH has no such node.
    pub const INTP_PATH_NODE: Status = Status(12383);

    /// QMGR-001: the queue is full.
    pub const QUEUE_FULL: Status = Status(61001);
    /// QMGR-002: there is no such entry, or none at all.
    pub const QUEUE_ENTRY: Status = Status(61002);

    /// DICT-005: there is no such dictionary, or no such element.
    pub const DICT_MISSING: Status = Status(33005);

    /// PRIO-002: illegal port number.
    pub const PRIO_PORT_NUMBER: Status = Status(13002);

    /// MOTN-017: the position is outside of the joint limits.
    ///
    /// ASSUMPTION: this number and that of MOTN-018 are from memory of error lists; programs in
    /// the field only compare with 0.
    pub const MOTN_LIMIT: Status = Status(15017);
    /// MOTN-018: the position is not reachable.
    pub const MOTN_UNREACHABLE: Status = Status(15018);

    /// VARS-011: the variable name does not exist.
    ///
    /// ASSUMPTION: this number and that of VARS-012 are ours; programs in the field only compare
    /// with 0.
    pub const VARS_UNKNOWN: Status = Status(16011);
    /// VARS-012: the value's type does not fit the variable.
    pub const VARS_TYPE: Status = Status(16012);
    /// VARS-013: a variable of this name exists, or is the program's own.
    ///
    /// ASSUMPTION: this number and those of MEMO-004 and DICT-005 are ours; programs in the field
    /// only compare with 0.
    pub const VARS_EXISTS: Status = Status(16013);
    /// VARS-024: the array index is out of range.
    pub const VARS_INDEX: Status = Status(16024);

    /// HOST-144: the tag is not defined, not started, or already connected.
    pub const HOST_TAG: Status = Status(67144);
    /// HOST-178: a host does not answer, or may not be asked.
    ///
    /// ASSUMPTION: the number is ours; programs in the field only compare with 0.
    pub const HOST_NO_ANSWER: Status = Status(67178);
    /// HOST-213: the peer closed its side of the connection.
    pub const HOST_PEER_CLOSED: Status = Status(67213);

    /// Composes a status from a facility code and a number.
    #[must_use]
    pub const fn new(facility: i32, number: i32) -> Status {
        Status(facility * 1000 + number)
    }

    /// Whether this is success.
    #[must_use]
    pub const fn is_ok(self) -> bool {
        self.0 == 0
    }

    /// The facility code, 12 for INTP.
    #[must_use]
    pub const fn facility(self) -> i32 {
        self.0 / 1000
    }

    /// The number within the facility, 311 for INTP-311.
    #[must_use]
    pub const fn number(self) -> i32 {
        self.0 % 1000
    }

    /// The code of a facility by its four letters.
    #[must_use]
    pub fn facility_code(name: &str) -> Option<i32> {
        let mut known = FACILITIES.iter();
        known
            .find(|(_, known)| known.eq_ignore_ascii_case(name))
            .map(|(code, _)| *code)
    }

    /// The facility's four-letter name, if this crate knows it.
    #[must_use]
    pub fn facility_name(self) -> Option<&'static str> {
        let facility = self.facility();
        FACILITIES
            .iter()
            .find(|(code, _)| *code == facility)
            .map(|(_, name)| *name)
    }
}

/// What `SET_FILE_ATR` sets.
///
/// ASSUMPTION: the numbers are ours; programs use the names.
pub(crate) mod attribute {
    /// `ATR_IA`: each WRITE is sent at once, as all are here.
    pub(crate) const IMMEDIATE: i32 = 1;
    /// `ATR_TIMEOUT`: milliseconds of a READ.
    pub(crate) const TIMEOUT: i32 = 2;
    /// `ATR_UF`: binary data.
    pub(crate) const UNFORMATTED: i32 = 3;
    /// `ATR_FIELD`: a field is read as a whole.
    pub(crate) const FIELD: i32 = 4;
    /// `ATR_EOL`: the code of the byte that ends a line.
    pub(crate) const END_OF_LINE: i32 = 5;
    /// `ATR_PASSALL`: no byte is special.
    pub(crate) const PASS_ALL: i32 = 6;
    /// `ATR_READAHD`: size of the buffer.
    pub(crate) const READ_AHEAD: i32 = 7;
    /// `ATR_REVERSE`: the other order of bytes.
    pub(crate) const REVERSE: i32 = 8;
    /// `ATR_PIPOVADV`: bytes that an overflow skips.
    pub(crate) const PIPE_OVERFLOW: i32 = 9;
    /// `ATR_PIPWAIT`: a READ waits for data.
    pub(crate) const PIPE_WAIT: i32 = 10;
    /// `ATR_XONOFF`: flow control of a serial line.
    pub(crate) const FLOW: i32 = 11;
    /// `ATR_MODEM`: lines of a serial port.
    pub(crate) const MODEM: i32 = 12;
}

/// What `GET_TSK_INFO` asks for and answers.
///
/// ASSUMPTION: the numbers are ours; programs use the names.
pub(crate) mod task {
    /// `TSK_STATUS`.
    pub(crate) const STATUS: i32 = 1;
    /// `TSK_LINENUM`.
    pub(crate) const LINE: i32 = 2;
    /// `TSK_PROGNAME`.
    pub(crate) const PROGRAM: i32 = 3;
    /// `PG_RUNNING`.
    pub(crate) const RUNNING: i32 = 1;
    /// `PG_PAUSED`.
    pub(crate) const PAUSED: i32 = 2;
    /// `PG_ABORTED`: ended, or never started.
    pub(crate) const ABORTED: i32 = 3;
}

/// How `OPEN_TPE` opens a program.
pub(crate) mod open_mode {
    /// `TPE_RDACC`.
    pub(crate) const READ: i32 = 1;
    /// `TPE_RWACC`.
    pub(crate) const WRITE: i32 = 2;
}

/// What `GET_ATTR_PRG` asks for.
pub(crate) mod attribute_of_program {
    /// `AT_PROG_TYPE`.
    pub(crate) const TYPE: i32 = 1;
    /// `AT_PROG_NAME`.
    pub(crate) const NAME: i32 = 2;
    /// `AT_COMMENT`.
    pub(crate) const COMMENT: i32 = 4;
    /// `AT_PROG_SIZE`.
    pub(crate) const SIZE: i32 = 5;
}

const FACILITIES: &[(i32, &str)] = &[
    (2, "FILE"),
    (3, "PROG"),
    (7, "MEMO"),
    (11, "SRVO"),
    (12, "INTP"),
    (13, "PRIO"),
    (15, "MOTN"),
    (16, "VARS"),
    (24, "SYST"),
    (33, "DICT"),
    (61, "QMGR"),
    (67, "HOST"),
    (85, "FRSY"),
];

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.facility_name() {
            Some(name) => write!(f, "{name}-{:03}", self.number()),
            None => write!(f, "{}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_reads_like_on_the_pendant() {
        assert_eq!(Status::HOST_TAG.to_string(), "HOST-144");
        assert_eq!(Status::INTP_UNINIT.to_string(), "INTP-311");
        assert_eq!(Status::PRIO_PORT_NUMBER.to_string(), "PRIO-002");
    }

    #[test]
    fn a_status_of_an_unknown_facility_reads_as_its_number() {
        assert_eq!(Status(282).to_string(), "282");
        assert_eq!(Status(99_001).to_string(), "99001");
    }
}
