//! The tree after checking: every name is a place in memory, every expression has its type, every
//! conversion is written out.

use crate::{
    ast::{
        Action, ConditionVerb, Direction, Edge, HandVerb, MotionVerb, NodeSide, Relation, Signaled,
        TaskVerb, Waits,
    },
    builtins::Builtin,
    ir::Signature,
    port::Port,
    span::Span,
    types::{PositionKind, Type},
    value::Text,
};

#[derive(Debug)]
pub(crate) struct Routine {
    pub(crate) name: String,
    /// Cells of the frame: result reference if any, parameters, locals.
    pub(crate) frame_cells: u32,
    /// First frame cell behind the parameters.
    pub(crate) first_local: u32,
    /// Cells of FILE locals, which are closed when the routine returns.
    pub(crate) files: Vec<u32>,
    /// Cells of PATH locals, and the size of a node.
    pub(crate) paths: Vec<(u32, u32)>,
    pub(crate) signature: Signature,
    pub(crate) labels: u32,
    pub(crate) body: Vec<Stmt>,
    pub(crate) end: Span,
}

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

#[derive(Debug)]
pub(crate) enum Target {
    Place(Place),
    System(SystemPlace),
    Port(PortPlace),
}

/// A port of an array.
#[derive(Debug)]
pub(crate) struct PortPlace {
    pub(crate) port: Port,
    pub(crate) number: Box<Expr>,
}

#[derive(Debug)]
pub(crate) struct Expr {
    pub(crate) kind: ExprKind,
    pub(crate) ty: Type,
}

#[derive(Debug)]
pub(crate) enum ExprKind {
    Constant(Constant),
    Place(Place),
    System(SystemPlace),
    Port(PortPlace),
    Call(Call),
    Builtin(BuiltinCall),
    Negate(Box<Expr>),
    Not(Box<Expr>),
    Binary {
        op: Op,
        left: Box<Expr>,
        right: Box<Expr>,
    },
    /// INTEGER to REAL.
    ToReal(Box<Expr>),
    /// One cartesian type to another, the expression's.
    ToPosition(Box<Expr>),
    /// One joint type to another, the expression's.
    ToJoints(Box<Expr>),
}

/// Binary operators; both operands have the same type, which selects the instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Op {
    Add,
    Subtract,
    Multiply,
    Divide,
    Div,
    Mod,
    And,
    Or,
    Concatenate,
    Relation(Relation),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Constant {
    Integer(i32),
    Real(f32),
    Boolean(bool),
    Text(Text),
}

impl Constant {
    pub(crate) fn ty(&self) -> Type {
        match self {
            Constant::Integer(_) => Type::Integer,
            Constant::Real(_) => Type::Real,
            Constant::Boolean(_) => Type::Boolean,
            Constant::Text(_) => Type::TEXT,
        }
    }
}

/// A variable or a part of one.
#[derive(Debug)]
pub(crate) struct Place {
    pub(crate) root: Root,
    pub(crate) steps: Vec<Step>,
    pub(crate) ty: Type,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Root {
    /// A cell of the program's variables.
    Global(u32),
    /// A cell of the frame.
    Local(u32),
    /// A cell of the frame that holds a reference.
    Param(u32),
    /// A cell of the program's variables that holds the address of another program's.
    Shared(u32),
}

#[derive(Debug)]
pub(crate) enum Step {
    Offset(u32),
    Index {
        subscripts: Vec<Expr>,
        dims: Vec<u32>,
        element_cells: u32,
    },
    /// Into an open array of several dimensions, whose lengths the reference carries.
    OpenGrid {
        subscripts: Vec<Expr>,
        element_cells: u32,
    },
    /// A node of a PATH.
    Node(Box<Expr>),
    /// Into an open array, whose length the reference carries; 0 cells mean strings whose length it
    /// carries as well.
    OpenIndex {
        subscript: Expr,
        element_cells: u32,
    },
}

/// A system variable, or a component of one.
#[derive(Debug)]
pub(crate) struct SystemPlace {
    pub(crate) steps: Vec<SystemStep>,
    /// Cell of a component within the variable's value.
    pub(crate) component: Option<u32>,
    /// Type of what is meant.
    pub(crate) ty: Type,
}

#[derive(Debug)]
pub(crate) enum SystemStep {
    Name(String),
    Index(Vec<Expr>),
}

#[derive(Debug)]
pub(crate) struct Call {
    pub(crate) callee: Callee,
    pub(crate) args: Vec<Arg>,
    pub(crate) result: Option<Type>,
}

/// Which routine is called.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Callee {
    /// By its number among the routines of the program.
    Here(u32),
    /// By a row of the table of externals.
    External(u32),
}

#[derive(Debug)]
pub(crate) struct BuiltinCall {
    pub(crate) builtin: &'static Builtin,
    pub(crate) args: Vec<Arg>,
    /// Types of the actual arguments; built-ins that take any type look at them.
    pub(crate) types: Vec<Type>,
    pub(crate) result: Option<Type>,
}

#[derive(Debug)]
pub(crate) enum Arg {
    /// The variable itself; may be uninitialized.
    Reference(Place),
    /// An array where several lengths are open: those of dimensions, or those of an array and of its
    /// strings.
    OpenArray { place: Place, lengths: u32 },
    /// `BYNAME`: a variable of this type that is found when the call is made.
    ByName {
        program: Expr,
        variable: Expr,
        formal: Type,
    },
    /// A copy in a temporary variable of this type.
    Copy { value: Expr, formal: Type },
    /// A scalar on the operand stack, or the address of a temporary.
    Value(Expr),
    /// A system variable as an output: copied in before and out after the call.
    System(SystemPlace),
    /// A constant where a built-in would write: it does not.
    Discard,
}
