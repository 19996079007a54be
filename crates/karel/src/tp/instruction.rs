//! The instructions of a line, but motion.

use super::{
    Arithmetic, Branch, Condition, Expr, Index, Instruction, Operand, Place, Test,
    scan::{Scanned, Scanner},
};
use crate::{ast::Relation, port::Port};

/// A line whose jumps still name labels.
#[derive(Debug)]
pub(super) enum Line {
    Label(i32),
    Jump(i32),
    IfJump(Condition, i32),
    Done(Instruction),
    /// A motion, to a position of the `/POS` section if it has a number.
    Move(super::Motion, Option<i32>),
}

/// Operands by the word before their bracket.
const PORTS: &[(&str, Port)] = &[
    ("F", Port::Flag),
    ("DI", Port::DigitalIn),
    ("DO", Port::DigitalOut),
    ("RI", Port::RobotIn),
    ("RO", Port::RobotOut),
];

/// Tests of one condition, and terms of one sum.
const MOST_TERMS: usize = 16;

/// Words of instructions that are TP and not run yet.
const NOT_YET: &[&str] = &[
    "ABORT",
    "ACC",
    "AR",
    "C",
    "CALL",
    "COL",
    "DO",
    "ELSE",
    "ENDFOR",
    "ENDIF",
    "FOR",
    "GI",
    "GO",
    "JOINT_MAX_SPEED",
    "LINEAR_MAX_SPEED",
    "MESSAGE",
    "MONITOR",
    "OFFSET",
    "OVERRIDE",
    "PAUSE",
    "PAYLOAD",
    "PULSE",
    "RSR",
    "SELECT",
    "SKIP",
    "SR",
    "TIMER",
    "TOOL_OFFSET",
    "UALM",
    "UO",
];

impl Scanner<'_> {
    /// The instruction of a line that is not empty.
    pub(super) fn line(&mut self) -> Scanned<Line> {
        if self.sees("!") || self.sees("//") || self.sees("--eg:") {
            return Ok(Line::Done(Instruction::Nothing));
        }
        let line = if self.sees("LBL") {
            Line::Label(self.label()?)
        } else if self.eat_word("JMP") {
            Line::Jump(self.label()?)
        } else if self.eat_word("IF") {
            self.if_line()?
        } else if self.eat_word("WAIT") {
            self.wait()?
        } else if self.eat_word("CALL") {
            Line::Done(Instruction::Call(self.callee()?))
        } else if self.eat_word("RUN") {
            Line::Done(Instruction::Run(self.name("a program")?.into()))
        } else if self.eat_word("END") {
            Line::Done(Instruction::End)
        } else if self.eat_word("ABORT") {
            Line::Done(Instruction::Abort)
        } else if self.motion_follows() {
            self.motion()?
        } else {
            self.assignment()?
        };
        if !self.at_end() {
            return Err(self.expected("the end of the instruction"));
        }
        Ok(line)
    }

    fn label(&mut self) -> Scanned<i32> {
        self.expect("LBL")?;
        match self.index()? {
            Index::Fixed(number) => Ok(number),
            Index::Register(_) => Err(self.unsupported("a label whose number is in a register")),
        }
    }

    fn callee(&mut self) -> Scanned<std::sync::Arc<str>> {
        let name = self.name("a program")?;
        if self.sees("(") {
            return Err(self.unsupported("CALL with arguments"));
        }
        Ok(name.into())
    }

    fn if_line(&mut self) -> Scanned<Line> {
        let condition = self.condition()?;
        if self.eat_word("THEN") {
            return Err(self.unsupported("IF .. THEN"));
        }
        self.expect(",")?;
        if self.eat_word("JMP") {
            return Ok(Line::IfJump(condition, self.label()?));
        }
        if self.eat_word("CALL") {
            let then = Branch::Call(self.callee()?);
            return Ok(Line::Done(Instruction::If { condition, then }));
        }
        Err(self.expected("JMP or CALL"))
    }

    fn wait(&mut self) -> Scanned<Line> {
        self.skip_blanks();
        // `WAIT   1.50(sec)`, `WAIT R[3]`: an operand alone is a time, unless it is on or off.
        if !self.sees("(") && !self.eat("!") {
            let time = self.operand()?;
            if self.eat("(sec)") || (self.at_end() && matches!(time, Operand::Number(_))) {
                return Ok(Line::Done(Instruction::WaitSeconds(time)));
            }
            let condition = self.condition_from(false, Some((false, time)))?;
            return Ok(Line::Done(Instruction::WaitFor(condition)));
        }
        let condition = self.condition()?;
        if self.eat(",") {
            return Err(self.unsupported("WAIT with TIMEOUT"));
        }
        Ok(Line::Done(Instruction::WaitFor(condition)))
    }

    /// `R[1]>0 AND DI[3]=ON`, or the same in parentheses.
    fn condition(&mut self) -> Scanned<Condition> {
        let parentheses = self.eat("(");
        self.condition_from(parentheses, None)
    }

    fn condition_from(
        &mut self,
        parentheses: bool,
        mut begun: Option<(bool, Operand)>,
    ) -> Scanned<Condition> {
        let mut tests = Vec::new();
        let mut all = None;
        loop {
            let (negated, left) = match begun.take() {
                Some(begun) => begun,
                None => (self.eat("!"), self.operand()?),
            };
            let mut right = None;
            if let Some(relation) = self.relation() {
                right = Some((relation, self.operand()?));
            }
            tests.push(Test {
                negated,
                left,
                right,
            });
            let and = self.eat_word("AND");
            if !and && !self.eat_word("OR") {
                break;
            }
            if all.is_some_and(|all| all != and) {
                return Err(self.unsupported("AND and OR in one condition"));
            }
            if tests.len() >= MOST_TERMS {
                return Err(self.unsupported("so many tests in one condition"));
            }
            all = Some(and);
        }
        if parentheses {
            self.expect(")")?;
        }
        Ok(Condition {
            all: all.unwrap_or(true),
            tests,
        })
    }

    fn relation(&mut self) -> Option<Relation> {
        let relations = [
            ("<>", Relation::NotEqual),
            ("<=", Relation::LessEqual),
            (">=", Relation::GreaterEqual),
            ("=", Relation::Equal),
            ("<", Relation::Less),
            (">", Relation::Greater),
        ];
        let found = relations.into_iter().find(|(text, _)| self.eat(text));
        found.map(|(_, relation)| relation)
    }

    fn assignment(&mut self) -> Scanned<Line> {
        let target = self.place()?;
        self.expect("=")?;
        let parentheses = self.eat("(");
        let negated = self.eat("!");
        let first = self.operand()?;
        let mut rest: Vec<(Arithmetic, Operand)> = Vec::new();
        while let Some(operator) = self.arithmetic() {
            let mixed = |(other, _): &(Arithmetic, Operand)| is_sum(*other) != is_sum(operator);
            if rest.iter().any(mixed) {
                return Err(self.unsupported("a mixture of + - with other operators in one line"));
            }
            if rest.len() >= MOST_TERMS {
                return Err(self.unsupported("such a long sum"));
            }
            rest.push((operator, self.operand()?));
        }
        if parentheses {
            self.expect(")")?;
        }
        let value = Expr {
            negated,
            first,
            rest,
        };
        Ok(Line::Done(Instruction::Assign { target, value }))
    }

    fn arithmetic(&mut self) -> Option<Arithmetic> {
        let words = [("DIV", Arithmetic::Div), ("MOD", Arithmetic::Mod)];
        if let Some((_, found)) = words.into_iter().find(|(word, _)| self.eat_word(word)) {
            return Some(found);
        }
        let signs = [
            ("+", Arithmetic::Add),
            ("-", Arithmetic::Subtract),
            ("*", Arithmetic::Multiply),
            ("/", Arithmetic::Divide),
        ];
        let found = signs.into_iter().find(|(sign, _)| self.eat(sign));
        found.map(|(_, found)| found)
    }

    fn place(&mut self) -> Scanned<Place> {
        if self.eat_word("UFRAME_NUM") {
            return Ok(Place::UserFrame);
        }
        if self.eat_word("UTOOL_NUM") {
            return Ok(Place::Tool);
        }
        if self.eat_word("PR") {
            return Ok(Place::Position(self.index()?));
        }
        if self.eat_word("R") {
            return Ok(Place::Number(self.index()?));
        }
        if let Some(port) = self.port() {
            if port.is_input() {
                return Err(self.unsupported("an assignment to an input"));
            }
            return Ok(Place::Port(port, self.index()?));
        }
        for word in NOT_YET {
            if self.eat_word(word) {
                return Err(self.unsupported(&format!("the instruction {word}")));
            }
        }
        Err(self.expected("an instruction"))
    }

    fn port(&mut self) -> Option<Port> {
        let found = PORTS.iter().find(|(word, _)| self.eat_word(word));
        found.map(|(_, port)| *port)
    }

    /// `5`, `(-1)`, `ON`, `R[3]`, `DI[2:part]`.
    pub(super) fn operand(&mut self) -> Scanned<Operand> {
        if self.eat_word("ON") || self.eat_word("TRUE") {
            return Ok(Operand::Switch(true));
        }
        if self.eat_word("OFF") || self.eat_word("FALSE") {
            return Ok(Operand::Switch(false));
        }
        if self.eat_word("PR") {
            return Ok(Operand::Position(self.index()?));
        }
        if self.eat_word("R") {
            return Ok(Operand::Number(self.index()?));
        }
        if let Some(port) = self.port() {
            return Ok(Operand::Port(port, self.index()?));
        }
        if self.eat("(") {
            let number = self.constant()?;
            self.expect(")")?;
            return Ok(number);
        }
        self.constant()
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

    /// `[1]`, `[1:comment]`, `[R[1:comment]]`.
    pub(super) fn index(&mut self) -> Scanned<Index> {
        self.expect("[")?;
        let index = if self.eat_word("R") {
            self.expect("[")?;
            let number = self.integer("a register's number")?;
            let _comment = self.up_to(b']')?;
            Index::Register(number)
        } else {
            Index::Fixed(self.integer("a number")?)
        };
        if self.sees(",") {
            return Err(self.unsupported("a component of a position register"));
        }
        let _comment = self.up_to(b']')?;
        Ok(index)
    }
}

fn is_sum(operator: Arithmetic) -> bool {
    matches!(operator, Arithmetic::Add | Arithmetic::Subtract)
}
