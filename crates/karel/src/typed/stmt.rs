//! Statements, with what they name resolved.

use super::{BuiltinCall, Call, Expr, Place, PortPlace, Target};
use crate::{
    ast::{
        Action, ConditionVerb, Direction, Edge, HandVerb, MotionVerb, NodeSide, Signaled, TaskVerb,
        Waits,
    },
    span::Span,
    types::PositionKind,
};

#[derive(Debug)]
pub(crate) struct Stmt {
    pub(crate) kind: StmtKind,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum StmtKind {
    Label(u32),
    Goto(u32),
    Assign {
        target: Target,
        value: Expr,
    },
    Call(Call),
    Builtin(BuiltinCall),
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
        counter: Place,
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
    Return(Option<Expr>),
    Read {
        file: Place,
        items: Vec<ReadItem>,
    },
    Write {
        file: Option<Place>,
        items: Vec<WriteItem>,
    },
    OpenFile {
        file: Place,
        mode: Expr,
        name: Expr,
    },
    CloseFile(Place),
    CancelFile(Place),
    Motion(MotionVerb),
    /// References to structures go to frame cells, then the body follows.
    Using {
        places: Vec<(Place, u32)>,
        body: Vec<Stmt>,
    },
    Delay(Expr),
    ConnectTimer(Place),
    DisconnectTimer(Place),
    /// They are looked at again and again until they hold.
    WaitFor(Conditions),
    Move {
        form: MoveForm,
        via: Option<Expr>,
        waits: Waits,
        whens: Vec<When>,
        until: Option<Conditions>,
    },
    Condition {
        number: Expr,
        /// `$SCAN_TIME` in milliseconds.
        period: Option<Expr>,
        whens: Vec<When>,
    },
    ConditionState {
        verb: ConditionVerb,
        number: Expr,
    },
    Action(Action),
    Signal {
        what: Signaled,
        number: Expr,
    },
    Task {
        verb: TaskVerb,
        task: Option<Expr>,
    },
    Pulse {
        port: PortPlace,
        time: Expr,
        waits: Waits,
    },
    Hand {
        verb: HandVerb,
        number: Expr,
    },
}

/// Where a MOVE goes; see [`crate::ast::MoveForm`].
#[derive(Debug)]
pub(crate) enum MoveForm {
    To(Expr),
    Near {
        target: Expr,
        distance: Expr,
    },
    Axis {
        axis: Expr,
        distance: Expr,
    },
    Relative(Expr),
    About {
        vector: Expr,
        angle: Expr,
    },
    Away(Expr),
    Along {
        path: Place,
        /// First and last node; none for all of them.
        range: Option<(Expr, Expr)>,
        /// Where the position of a node is in it.
        offset: u32,
        kind: PositionKind,
    },
}

/// Conditions of a WHEN, an UNTIL or a WAIT FOR.
#[derive(Debug)]
pub(crate) struct Conditions {
    pub(crate) terms: Vec<Condition>,
    pub(crate) all: bool,
}

#[derive(Debug)]
pub(crate) enum Condition {
    State(Expr),
    Task {
        verb: TaskVerb,
        task: Option<Expr>,
    },
    Error(Option<Expr>),
    Signaled {
        what: Signaled,
        number: Expr,
    },
    PowerUp,
    Edge {
        port: PortPlace,
        edge: Edge,
    },
    AtNode(Option<Expr>),
    NodeTime {
        time: Expr,
        side: NodeSide,
        node: Expr,
    },
}

#[derive(Debug)]
pub(crate) struct When {
    pub(crate) conditions: Conditions,
    pub(crate) actions: Vec<Stmt>,
    pub(crate) span: Span,
    /// Labels of the actions.
    pub(crate) labels: u32,
    /// Frame cells that the actions need besides temporaries.
    pub(crate) frame_cells: u32,
}

#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) values: Vec<Expr>,
    pub(crate) body: Vec<Stmt>,
}

#[derive(Debug)]
pub(crate) enum ReadItem {
    Value { place: Place, formats: Vec<Expr> },
    LineEnd,
}

#[derive(Debug)]
pub(crate) enum WriteItem {
    Value { value: Expr, formats: Vec<Expr> },
    LineEnd,
}
