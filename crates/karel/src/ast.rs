//! The tree that the parser builds: what the source says, nothing resolved yet.

use crate::span::Span;

/// A name in upper case, `$` included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Name {
    pub(crate) text: String,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) name: Name,
    pub(crate) directives: Vec<Directive>,
    pub(crate) decls: Vec<Decl>,
    pub(crate) body: Vec<Stmt>,
    /// The END of the main body.
    pub(crate) end: Span,
}

#[derive(Debug)]
pub(crate) struct Directive {
    /// `%NAME` in upper case.
    pub(crate) name: String,
    /// What follows the name, without `=`.
    pub(crate) argument: String,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum Decl {
    Const {
        name: Name,
        value: Expr,
    },
    Type {
        name: Name,
        ty: TypeExpr,
    },
    Var {
        names: Vec<Name>,
        storage: Option<Storage>,
        /// `FROM program`: the variables are that program's.
        home: Option<Name>,
        ty: TypeExpr,
    },
    Routine(Routine),
}

/// `IN ..`: where a variable lives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Storage {
    pub(crate) memory: Memory,
    pub(crate) span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Memory {
    /// Keeps its contents without power: CMOS, and SHADOW, which is a faster copy of it.
    Cmos,
    /// Loses them: DRAM and `UNINIT_DRAM`.
    Dram,
}

#[derive(Debug)]
pub(crate) struct Routine {
    pub(crate) name: Name,
    pub(crate) params: Vec<Param>,
    pub(crate) result: Option<TypeExpr>,
    pub(crate) body: RoutineBody,
}

#[derive(Debug)]
pub(crate) enum RoutineBody {
    /// `FROM program`.
    From(Name),
    Here {
        decls: Vec<Decl>,
        stmts: Vec<Stmt>,
        end: Span,
    },
}

#[derive(Debug)]
pub(crate) struct Param {
    pub(crate) names: Vec<Name>,
    pub(crate) ty: TypeExpr,
}

#[derive(Debug)]
pub(crate) struct TypeExpr {
    pub(crate) kind: TypeKind,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum TypeKind {
    Name(Name),
    /// `STRING[n]` or `STRING`.
    Text(Option<Box<Expr>>),
    /// `ARRAY[d, ..] OF t`; no dimensions for an open array.
    Array {
        dims: Vec<Dim>,
        element: Box<TypeExpr>,
    },
    Structure(Vec<Param>),
    /// `PATH PATHHEADER = t, NODEDATA = t`.
    Path {
        header: Option<Box<TypeExpr>>,
        node: Option<Box<TypeExpr>>,
    },
}

#[derive(Debug)]
pub(crate) enum Dim {
    Length(Expr),
    /// `*`.
    Open(Span),
}

#[derive(Debug)]
pub(crate) struct Expr {
    pub(crate) kind: ExprKind,
    pub(crate) span: Span,
    /// Levels of the tree below and including this one.
    pub(crate) height: u16,
}

#[derive(Debug)]
pub(crate) enum ExprKind {
    /// Digits; the checker knows the range.
    Integer(i64),
    Real(f32),
    Text(Vec<u8>),
    Path(Path),
    Call {
        name: Name,
        args: Vec<Expr>,
    },
    Unary {
        op: UnaryOp,
        operand: Box<Expr>,
    },
    Binary {
        op: BinaryOp,
        left: Box<Expr>,
        right: Box<Expr>,
    },
    /// `(x)`: by value, even if x is a variable.
    Paren(Box<Expr>),
    /// Something was reported here already.
    Error,
}

/// A variable with subscripts and fields.
#[derive(Debug)]
pub(crate) struct Path {
    pub(crate) root: Name,
    pub(crate) steps: Vec<PathStep>,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum PathStep {
    Field(Name),
    Index {
        subscripts: Vec<Expr>,
        span: Span,
    },
    /// `[first..last]`, nodes of a PATH.
    Range {
        first: Box<Expr>,
        last: Box<Expr>,
        span: Span,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnaryOp {
    Plus,
    Minus,
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryOp {
    Add,
    Subtract,
    Multiply,
    Divide,
    Div,
    Mod,
    And,
    Or,
    Relation(Relation),
    /// `>=<`, equal within a tolerance.
    Approx,
    /// `:`, frame composition.
    Compose,
    /// `@`, inner product.
    Inner,
    /// `#`, cross product.
    Cross,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Equal,
    NotEqual,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
}

impl Relation {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Relation::Equal => "=",
            Relation::NotEqual => "<>",
            Relation::Less => "<",
            Relation::Greater => ">",
            Relation::LessEqual => "<=",
            Relation::GreaterEqual => ">=",
        }
    }
}

impl BinaryOp {
    pub(crate) fn text(self) -> &'static str {
        match self {
            BinaryOp::Add => "+",
            BinaryOp::Subtract => "-",
            BinaryOp::Multiply => "*",
            BinaryOp::Divide => "/",
            BinaryOp::Div => "DIV",
            BinaryOp::Mod => "MOD",
            BinaryOp::And => "AND",
            BinaryOp::Or => "OR",
            BinaryOp::Relation(relation) => relation.text(),
            BinaryOp::Approx => ">=<",
            BinaryOp::Compose => ":",
            BinaryOp::Inner => "@",
            BinaryOp::Cross => "#",
        }
    }
}

impl UnaryOp {
    pub(crate) fn text(self) -> &'static str {
        match self {
            UnaryOp::Plus => "+",
            UnaryOp::Minus => "-",
            UnaryOp::Not => "NOT",
        }
    }
}

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

/// Conditions of a WHEN, an UNTIL or a WAIT FOR.
#[derive(Debug)]
pub(crate) struct Conditions {
    pub(crate) terms: Vec<Condition>,
    /// Joined by `AND` or commas; else by `OR`.
    pub(crate) all: bool,
}

#[derive(Debug)]
pub(crate) enum Condition {
    /// A state.
    Expr(Expr),
    /// `ABORT`, `PAUSE PROGRAM[n]`.
    Task {
        verb: TaskVerb,
        task: Option<Expr>,
    },
    /// `ERROR[n]`; `ERROR[*]` is any.
    Error(Option<Expr>),
    /// `EVENT[n]`, `SEMAPHORE[n]`.
    Signaled {
        what: Signaled,
        number: Expr,
    },
    PowerUp,
    /// `DIN[n]+`, `DIN[n]-`.
    Edge {
        port: Path,
        edge: Edge,
    },
    /// `AT NODE[n]`; `AT NODE[*]` is any.
    AtNode {
        node: Option<Expr>,
        at: Span,
    },
    /// `TIME t BEFORE NODE[n]`, `TIME t AFTER NODE[n]`, in milliseconds.
    NodeTime {
        time: Expr,
        side: NodeSide,
        node: Expr,
        at: Span,
    },
}

/// Conditions and what is done when they hold.
#[derive(Debug)]
pub(crate) struct When {
    pub(crate) conditions: Conditions,
    pub(crate) actions: Vec<Stmt>,
    pub(crate) span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edge {
    Rising,
    Falling,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeSide {
    Before,
    After,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signaled {
    Event,
    Semaphore,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TaskVerb {
    Abort,
    Pause,
    Continue,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConditionVerb {
    Enable,
    Disable,
    Purge,
}

/// What stands only among the actions of a condition handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    NoAbort,
    NoPause,
    Unpause,
    NoMessage,
    Restore,
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

macro_rules! words {
    ($($name:ident { $($variant:ident $text:literal)* })*) => {
        $(impl $name {
            /// The word in a program, in capitals.
            pub(crate) fn text(self) -> &'static str {
                match self { $($name::$variant => $text,)* }
            }

            /// The one that this word in capitals means.
            pub(crate) fn of_word(word: &str) -> Option<$name> {
                match word { $($text => Some($name::$variant),)* _ => None }
            }
        })*
    };
}

words! {
    Signaled { Event "EVENT" Semaphore "SEMAPHORE" }
    TaskVerb { Abort "ABORT" Pause "PAUSE" Continue "CONTINUE" }
    ConditionVerb { Enable "ENABLE" Disable "DISABLE" Purge "PURGE" }
    Action {
        NoAbort "NOABORT" NoPause "NOPAUSE" Unpause "UNPAUSE" NoMessage "NOMESSAGE"
        Restore "RESTORE"
    }
    MotionVerb {
        Cancel "CANCEL" Stop "STOP" Resume "RESUME" Hold "HOLD" Unhold "UNHOLD" Attach "ATTACH"
        Release "RELEASE"
    }
    NodeSide { Before "BEFORE" After "AFTER" }
    HandVerb { Open "OPEN" Close "CLOSE" Relax "RELAX" }
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
