//! Statements.

use super::{Action, ConditionVerb, Conditions, Expr, Name, Path, Signaled, When};
use crate::span::Span;

#[derive(Debug)]
pub(crate) struct Stmt {
    pub(crate) kind: StmtKind,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum StmtKind {
    Label(Name),
    Assign {
        target: Path,
        value: Expr,
    },
    Call {
        name: Name,
        args: Vec<Expr>,
    },
    If {
        condition: Expr,
        then: Vec<Stmt>,
        otherwise: Vec<Stmt>,
    },
    While {
        condition: Expr,
        body: Vec<Stmt>,
    },
    For {
        counter: Name,
        from: Expr,
        to: Expr,
        direction: Direction,
        body: Vec<Stmt>,
    },
    Repeat {
        body: Vec<Stmt>,
        until: Expr,
    },
    Select {
        value: Expr,
        cases: Vec<Case>,
        otherwise: Option<Vec<Stmt>>,
    },
    Goto(Name),
    Return(Option<Expr>),
    Read {
        file: Option<Path>,
        items: Vec<Item>,
    },
    Write {
        file: Option<Path>,
        items: Vec<Item>,
    },
    OpenFile {
        file: Path,
        mode: Expr,
        name: Expr,
    },
    CloseFile(Path),
    CancelFile(Path),
    /// What stops, holds or lets go on what moves.
    Motion(MotionVerb),
    /// Names in the body are first looked for in these.
    Using {
        places: Vec<Path>,
        body: Vec<Stmt>,
    },
    Delay(Expr),
    /// `CONNECT TIMER TO variable`.
    ConnectTimer(Path),
    /// `DISCONNECT TIMER variable`.
    DisconnectTimer(Path),
    WaitFor(Conditions),
    Move {
        form: MoveForm,
        /// `VIA`: a position on the arc of a circular motion.
        via: Option<Expr>,
        waits: Waits,
        /// Conditions that are looked at while it moves.
        whens: Vec<When>,
        /// `UNTIL`: the motion is canceled when this holds.
        until: Option<Conditions>,
    },
    /// `CONDITION[n]: .. ENDCONDITION`.
    Condition {
        number: Expr,
        with: Vec<(Path, Expr)>,
        whens: Vec<When>,
    },
    /// `ENABLE CONDITION[n]` and its sisters.
    ConditionState {
        verb: ConditionVerb,
        number: Expr,
    },
    /// `NOABORT` and its sisters.
    Action(Action),
    /// `SIGNAL EVENT[n]`, `SIGNAL SEMAPHORE[n]`.
    Signal {
        what: Signaled,
        number: Expr,
    },
    /// `ABORT`, `PAUSE`, `CONTINUE`, of the own or of another task.
    Task {
        verb: TaskVerb,
        task: Option<Expr>,
    },
    /// `PULSE port FOR milliseconds`.
    Pulse {
        port: Path,
        time: Expr,
        waits: Waits,
    },
    /// `OPEN HAND n` and its sisters.
    Hand {
        verb: HandVerb,
        number: Expr,
    },
}

/// Where a MOVE goes.
#[derive(Debug)]
pub(crate) enum MoveForm {
    To(Expr),
    /// `NEAR p BY d`: short of a position, along its approach.
    Near {
        target: Expr,
        distance: Expr,
    },
    /// `AXIS n BY d`: one joint.
    Axis {
        axis: Expr,
        distance: Expr,
    },
    /// `RELATIVE v`: from where the tool is, in the user frame.
    Relative(Expr),
    /// `ABOUT v BY a`: turns the tool.
    About {
        vector: Expr,
        angle: Expr,
    },
    /// `AWAY d`: back from where the tool is.
    Away(Expr),
    /// `ALONG path`, `ALONG path[i..j]`.
    Along(Path),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TaskVerb {
    Abort,
    Pause,
    Continue,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionVerb {
    Cancel,
    Stop,
    Resume,
    Hold,
    Unhold,
    Attach,
    Release,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HandVerb {
    Open,
    Close,
    Relax,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Up,
    Down,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Waits {
    Yes,
    No,
}

#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) values: Vec<Expr>,
    pub(crate) body: Vec<Stmt>,
}

/// An item of a READ or a WRITE with its format specifiers.
#[derive(Debug)]
pub(crate) struct Item {
    pub(crate) kind: ItemKind,
    pub(crate) formats: Vec<Expr>,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum ItemKind {
    Value(Expr),
    /// `CR`.
    LineEnd,
}
