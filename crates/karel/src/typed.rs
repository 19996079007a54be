//! The tree after checking: every name is a place in memory, every expression has its type, every
//! conversion is written out.

mod stmt;

use crate::{
    ast::Relation, builtins::Builtin, ir::Signature, port::Port, span::Span, types::Type,
    value::Text,
};

pub(crate) use stmt::{
    Case, Condition, Conditions, MoveForm, ReadItem, Stmt, StmtKind, When, WriteItem,
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
