//! Values and conditions: `R[1]+1`, `(DI[1] AND !F[2] OR R[3]>=5)`.

use super::{
    Arithmetic, Expr, FrameKind, Function, Index, Operand, Operator,
    scan::{Scanned, Scanner},
};
use crate::{ast::Relation, port::Port, syspath::SysPath};

/// Operands by the word before their bracket.
const PORTS: &[(&str, Port)] = &[
    ("F", Port::Flag),
    ("DI", Port::DigitalIn),
    ("DO", Port::DigitalOut),
    ("RI", Port::RobotIn),
    ("RO", Port::RobotOut),
    ("GI", Port::GroupIn),
    ("GO", Port::GroupOut),
    ("AI", Port::AnalogIn),
    ("AO", Port::AnalogOut),
    ("UI", Port::UserIn),
    ("UO", Port::UserOut),
    ("SI", Port::PanelIn),
    ("SO", Port::PanelOut),
];

/// Functions by their words, and how many values each has; the first three stand without brackets.
const FUNCTIONS: &[(&str, Function, usize)] = &[
    ("STRLEN", Function::Length, 1),
    ("SUBSTR", Function::Part, 3),
    ("FINDSTR", Function::Find, 2),
    ("ABS", Function::Abs, 1),
    ("SQRT", Function::Sqrt, 1),
    ("SIN", Function::Sin, 1),
    ("COS", Function::Cos, 1),
    ("TAN", Function::Tan, 1),
    ("ASIN", Function::Asin, 1),
    ("ACOS", Function::Acos, 1),
    ("ATAN", Function::Atan, 1),
    ("ATAN2", Function::Atan2, 2),
    ("LN", Function::Ln, 1),
    ("EXP", Function::Exp, 1),
    ("ROUND", Function::Round, 1),
    ("TRUNC", Function::Trunc, 1),
];

/// Parentheses in each other, and operators of one level in a row.
const DEEPEST: u32 = 16;
const MOST_TERMS: usize = 16;

/// Operators by level, those that bind least first.
const LEVELS: [&[(&str, Operator)]; 5] = [
    &[("OR", Operator::Or)],
    &[("AND", Operator::And)],
    &[
        ("<>", Operator::Relation(Relation::NotEqual)),
        ("<=", Operator::Relation(Relation::LessEqual)),
        (">=", Operator::Relation(Relation::GreaterEqual)),
        ("=", Operator::Relation(Relation::Equal)),
        ("<", Operator::Relation(Relation::Less)),
        (">", Operator::Relation(Relation::Greater)),
    ],
    &[
        ("+", Operator::Arithmetic(Arithmetic::Add)),
        ("-", Operator::Arithmetic(Arithmetic::Subtract)),
    ],
    &[
        ("DIV", Operator::Arithmetic(Arithmetic::Div)),
        ("MOD", Operator::Arithmetic(Arithmetic::Mod)),
        ("*", Operator::Arithmetic(Arithmetic::Multiply)),
        ("/", Operator::Arithmetic(Arithmetic::Divide)),
    ],
];

impl Scanner<'_> {
    /// A value or condition. Outside of parentheses there is no mixed logic.
    pub(super) fn expression(&mut self) -> Scanned<Expr> {
        let value = self.watched_expression()?;
        if changes(&value) {
            let what = "ON+, OFF- or ERR_NUM outside of WAIT, SKIP CONDITION and WHEN";
            return Err(self.unsupported(what));
        }
        Ok(value)
    }

    /// The same, where it is looked at again and again: `ON+`, `OFF-` and `ERR_NUM` are there, too.
    pub(super) fn watched_expression(&mut self) -> Scanned<Expr> {
        let value = self.level(0, DEEPEST)?;
        if mixes(&value, is_sum, is_product) {
            let help = "write it in parentheses, or in two lines";
            return Err(self.refused("+ and - with other operators in one line", help));
        }
        if mixes(&value, |op| op == Operator::And, |op| op == Operator::Or) {
            let help = "write the whole condition in parentheses";
            return Err(self.refused("AND and OR in one condition without parentheses", help));
        }
        Ok(value)
    }

    fn level(&mut self, level: usize, depth: u32) -> Scanned<Expr> {
        let Some(operators) = LEVELS.get(level) else {
            return self.factor(depth);
        };
        let mut left = self.level(level + 1, depth)?;
        let mut terms = 1;
        while let Some(operator) = self.one_of(operators) {
            terms += 1;
            if terms > MOST_TERMS {
                return Err(self.unsupported("so many tests or terms in one line"));
            }
            if let (Operator::Relation(Relation::Equal), Expr::Operand(Operand::Port(port, index))) =
                (operator, &left)
                && let Some(rising) = self.edge()
            {
                left = Expr::Edge {
                    port: *port,
                    index: *index,
                    rising,
                };
                continue;
            }
            let right = self.level(level + 1, depth)?;
            left = Expr::Binary(operator, Box::new(left), Box::new(right));
        }
        Ok(left)
    }

    fn one_of(&mut self, operators: &[(&str, Operator)]) -> Option<Operator> {
        let found = operators.iter().find(|(text, _)| {
            if text.starts_with(|c: char| c.is_ascii_alphabetic()) {
                self.eat_word(text)
            } else {
                self.eat(text)
            }
        });
        found.map(|(_, operator)| *operator)
    }

    fn factor(&mut self, depth: u32) -> Scanned<Expr> {
        let Some(deeper) = depth.checked_sub(1) else {
            return Err(self.unsupported("so many parentheses in each other"));
        };
        if self.eat("!") {
            return Ok(Expr::Not(Box::new(self.factor(deeper)?)));
        }
        if self.eat("(") {
            let inner = self.level(0, deeper)?;
            self.expect(")")?;
            return Ok(Expr::Group(Box::new(inner)));
        }
        self.operand().map(Expr::Operand)
    }

    pub(super) fn port(&mut self) -> Option<Port> {
        let found = PORTS.iter().find(|(word, _)| self.eat_word(word));
        found.map(|(_, port)| *port)
    }

    /// `5`, `(-1)`, `ON`, `R[3]`, `DI[2:part]`, `AR[1]`, `'text'`, `ABS[R[1]]`, `STRLEN SR[1]`.
    pub(super) fn operand(&mut self) -> Scanned<Operand> {
        for (word, function, count) in FUNCTIONS {
            if self.eat_word(word) {
                let brackets =
                    !matches!(function, Function::Length | Function::Part | Function::Find);
                if brackets {
                    self.expect("[")?;
                }
                let mut values = vec![self.plain_operand()?];
                while values.len() < *count {
                    self.expect(",")?;
                    values.push(self.plain_operand()?);
                }
                if brackets {
                    self.expect("]")?;
                }
                return Ok(Operand::Function(*function, values.into()));
            }
        }
        self.plain_operand()
    }

    fn plain_operand(&mut self) -> Scanned<Operand> {
        if self.is_unset() {
            return Ok(Operand::Unset);
        }
        if self.eat_word("ON") || self.eat_word("TRUE") {
            return Ok(Operand::Switch(true));
        }
        if self.eat_word("OFF") || self.eat_word("FALSE") {
            return Ok(Operand::Switch(false));
        }
        if self.eat_word("PR") {
            return Ok(match self.register_or_component()? {
                (register, None) => Operand::Position(register),
                (register, Some(component)) => Operand::Component(register, component),
            });
        }
        if self.sees("P[") && self.eat_word("P") {
            return Ok(Operand::Taught(self.index()?));
        }
        if let Some(register) = self.vision_register()? {
            return Ok(Operand::Absent(register));
        }
        if self.eat_word("ERR_NUM") {
            return Ok(Operand::ErrorNumber);
        }
        if self.eat_word("SR") {
            return Ok(Operand::Text(self.index()?));
        }
        if self.eat_word("AR") {
            return Ok(Operand::Argument(self.index()?));
        }
        if self.eat_word("R") {
            return Ok(Operand::Number(self.index()?));
        }
        if self.eat_word("TIMER") {
            return Ok(Operand::Timer(self.index()?));
        }
        if self.eat_word("LPOS") {
            return Ok(Operand::LinearPosition);
        }
        if self.eat_word("JPOS") {
            return Ok(Operand::JointPosition);
        }
        if let Some(kind) = self.frame_number_word() {
            return Ok(Operand::FrameNumber(kind));
        }
        if let Some(kind) = self.frame_word() {
            return Ok(Operand::Frame(kind, self.index()?));
        }
        if let Some(port) = self.port() {
            return Ok(Operand::Port(port, self.index()?));
        }
        if self.sees("$") {
            return Ok(Operand::System(self.system_path()?));
        }
        if self.eat("'") {
            let text = crate::span::latin1(self.quoted()?);
            return Ok(Operand::Literal(text.as_str().into()));
        }
        if self.eat("(") {
            let number = self.constant()?;
            self.expect(")")?;
            return Ok(number);
        }
        self.constant()
    }

    pub(super) fn frame_number_word(&mut self) -> Option<FrameKind> {
        if self.eat_word("UFRAME_NUM") {
            return Some(FrameKind::User);
        }
        self.eat_word("UTOOL_NUM").then_some(FrameKind::Tool)
    }

    pub(super) fn frame_word(&mut self) -> Option<FrameKind> {
        if self.eat_word("UFRAME") {
            return Some(FrameKind::User);
        }
        self.eat_word("UTOOL").then_some(FrameKind::Tool)
    }

    /// `$WAITTMOUT`, `$MCR.$GENOVERRIDE`, `$MNUFRAME[1,2]`.
    pub(super) fn system_path(&mut self) -> Scanned<SysPath> {
        let text = self.path_text();
        SysPath::parse(&text)
            .map_err(|error| self.wrong(0, format!("{text} is no variable: {}", error.problem)))
    }

    fn constant(&mut self) -> Scanned<Operand> {
        let text = self.number("a number, a register or an input or output")?;
        if let Ok(value) = text.parse() {
            return Ok(Operand::Integer(value));
        }
        match text.parse::<f32>() {
            Ok(value) if value.is_finite() => Ok(Operand::Real(value)),
            Ok(_) | Err(_) => Err(self.expected("a number that a register can hold")),
        }
    }

    /// `[1]`, `[1:comment]`, `[R[1:comment]]`, `[AR[1]]`.
    pub(super) fn index(&mut self) -> Scanned<Index> {
        match self.register_or_component()? {
            (index, None) => Ok(index),
            (_, Some(_)) => Err(self.wrong(0, "only PR has components")),
        }
    }

    /// `[1]` or `[1,2]`.
    pub(super) fn register_or_component(&mut self) -> Scanned<(Index, Option<Index>)> {
        self.expect("[")?;
        let index = self.subscript()?;
        let component = if self.eat(",") {
            Some(self.subscript()?)
        } else {
            None
        };
        let _comment = self.rest_of_bracket()?;
        Ok((index, component))
    }

    /// What the pendant shows where nobody has entered a value yet.
    pub(super) fn is_unset(&mut self) -> bool {
        let from = self.here();
        if !(self.eat("...") || self.eat_word("Constant")) {
            return false;
        }
        let message = "nobody has entered what belongs here: INTP-311 for who comes here";
        self.suspicious(from, message);
        true
    }

    fn subscript(&mut self) -> Scanned<Index> {
        if self.is_unset() {
            return Ok(Index::Unset);
        }
        let make = if self.eat_word("R") {
            Index::Register
        } else if self.eat_word("AR") {
            Index::Argument
        } else {
            return self.integer("a number").map(Index::Fixed);
        };
        self.expect("[")?;
        let number = self.integer("a register's number")?;
        let _comment = self.rest_of_bracket()?;
        Ok(make(number))
    }
}

fn is_sum(operator: Operator) -> bool {
    matches!(
        operator,
        Operator::Arithmetic(Arithmetic::Add | Arithmetic::Subtract)
    )
}

fn is_product(operator: Operator) -> bool {
    matches!(operator, Operator::Arithmetic(_)) && !is_sum(operator)
}

/// Whether a condition needs to be looked at again and again.
fn changes(expr: &Expr) -> bool {
    match expr {
        Expr::Edge { .. } => true,
        Expr::Operand(operand) => *operand == Operand::ErrorNumber,
        Expr::Group(inner) | Expr::Not(inner) => changes(inner),
        Expr::Binary(_, left, right) => changes(left) || changes(right),
    }
}

/// Whether operators of both kinds are there outside of parentheses.
fn mixes(expr: &Expr, one: fn(Operator) -> bool, other: fn(Operator) -> bool) -> bool {
    has(expr, one) && has(expr, other)
}

fn has(expr: &Expr, kind: fn(Operator) -> bool) -> bool {
    match expr {
        Expr::Operand(_) | Expr::Group(_) | Expr::Edge { .. } => false,
        Expr::Not(inner) => has(inner, kind),
        Expr::Binary(operator, left, right) => {
            kind(*operator) || has(left, kind) || has(right, kind)
        }
    }
}
