//! The tree that the parser builds: what the source says, nothing resolved yet.

mod condition;
mod expr;
mod stmt;

use crate::span::Span;

pub(crate) use condition::{
    Action, Condition, ConditionVerb, Conditions, Edge, NodeSide, Signaled, When,
};
pub(crate) use expr::{BinaryOp, Expr, ExprKind, Path, PathStep, Relation, UnaryOp};
pub(crate) use stmt::{
    Case, Direction, HandVerb, Item, ItemKind, MotionVerb, MoveForm, Stmt, StmtKind, TaskVerb,
    Waits,
};

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
