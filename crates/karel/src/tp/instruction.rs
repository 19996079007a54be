//! The instructions of a line, but motion.

use super::{
    Call, Expr, ForHead, Index, Instruction, Operand, Operator, Place,
    scan::{Scanned, Scanner},
};
use crate::{ast::Relation, check::nearest, port::Port};

/// A line whose jumps still name labels, and whose blocks are not matched.
#[derive(Debug)]
pub(super) enum Line {
    Label(i32),
    Jump(Index),
    If(Expr, Then),
    IfThen(Expr),
    Else,
    EndIf,
    For(ForHead),
    EndFor,
    /// A case of a SELECT, the first one if `is_first`; the last one without a condition.
    Case {
        condition: Option<Expr>,
        then: Then,
        is_first: bool,
    },
    WaitFor(Expr, Option<Index>),
    Done(Instruction),
    /// A motion; its target, and the position on its arc, are of the `/POS` section if they have a
    /// number.
    Move {
        motion: Box<super::Motion>,
        target: Option<Index>,
        via: Option<Index>,
        skip: Option<Index>,
    },
}

/// What follows a condition.
#[derive(Debug)]
pub(super) enum Then {
    Jump(Index),
    Call(Call),
    Assign(Place, Expr),
    Pulse(Port, Index, Option<Operand>),
}

/// First words of instructions.
const INSTRUCTIONS: &[&str] = &[
    "ABORT",
    "CALL",
    "ELSE",
    "END",
    "ENDFOR",
    "ENDIF",
    "FOR",
    "IF",
    "JMP",
    "LBL",
    "MESSAGE",
    "MONITOR",
    "OFFSET",
    "OVERRIDE",
    "PAUSE",
    "PAYLOAD",
    "RSR",
    "RUN",
    "SELECT",
    "SKIP",
    "TIMER",
    "TOOL_OFFSET",
    "UALM",
    "UFRAME_NUM",
    "UTOOL_NUM",
    "WAIT",
    "WHEN",
];

/// Most arguments of a CALL.
///
/// ASSUMPTION: programs of the field have up to 14.
const MOST_ARGUMENTS: usize = 30;

impl Scanner<'_> {
    /// The instruction of a line that is not empty. `selects` is what the lines of a SELECT before
    /// it compare.
    pub(super) fn line(&mut self, selects: &mut Option<Operand>) -> Scanned<Line> {
        if self.sees("!") || self.sees("//") || self.sees("--") {
            return Ok(Line::Done(Instruction::Nothing));
        }
        let line = self.one_line(selects)?;
        if !matches!(line, Line::Case { .. }) {
            *selects = None;
        }
        if !self.at_end() {
            return Err(self.expected("the end of the instruction"));
        }
        Ok(line)
    }

    fn one_line(&mut self, selects: &mut Option<Operand>) -> Scanned<Line> {
        if self.eat_word("SELECT") {
            let operand = self.operand()?;
            *selects = Some(operand.clone());
            return self.case(operand, true);
        }
        if let Some(operand) = selects.clone() {
            if self.sees("=") {
                return self.case(operand, false);
            }
            if self.eat_word("ELSE") {
                *selects = None;
                self.expect(",")?;
                return Ok(Line::Case {
                    condition: None,
                    then: self.then()?,
                    is_first: false,
                });
            }
        }
        Ok(if self.sees("LBL") {
            match self.label()? {
                Index::Fixed(label) => Line::Label(label),
                Index::Register(_) | Index::Argument(_) | Index::Unset => {
                    return Err(self.wrong(0, "a label is a number; only a jump can look it up"));
                }
            }
        } else if self.eat_word("JMP") {
            Line::Jump(self.label()?)
        } else if self.eat_word("IF") {
            self.if_line()?
        } else if self.eat_word("ELSE") {
            Line::Else
        } else if self.eat_word("ENDIF") {
            Line::EndIf
        } else if self.eat_word("FOR") {
            self.for_line()?
        } else if self.eat_word("ENDFOR") {
            Line::EndFor
        } else if !self.is_only("WAIT") // Cells have macros of that name.
             && self.eat_word("WAIT")
        {
            self.wait()?
        } else if self.motion_follows() {
            self.motion()?
        } else if let Some(done) = self.simple()? {
            Line::Done(done)
        } else if let Some(absent) = self.absent_instruction() {
            Line::Done(Instruction::Absent(absent))
        } else if let Some(call) = self.macro_call()? {
            Line::Done(Instruction::Macro(call))
        } else {
            let (target, value) = self.assignment()?;
            Line::Done(match value {
                Assigned::Value(value) => Instruction::Assign { target, value },
                Assigned::Pulse(width) => {
                    let (port, index) = self.pulsed(&target)?;
                    Instruction::Pulse(port, index, width)
                }
            })
        })
    }

    /// `LBL[1:comment]`, `LBL[R[1]]`.
    pub(super) fn label(&mut self) -> Scanned<Index> {
        self.expect("LBL")?;
        self.index()
    }

    /// An instruction of words that belong to no other: a macro.
    ///
    /// ASSUMPTION: words that are nearly those of an instruction are an error of who typed them.
    fn macro_call(&mut self) -> Scanned<Option<Call>> {
        let Some(words) = self.words() else {
            return Ok(None);
        };
        let first = words
            .split(' ')
            .next()
            .unwrap_or_default()
            .to_ascii_uppercase();
        if first.len() < 3 {
            return Ok(None);
        }
        if let Some(meant) = nearest(&first, INSTRUCTIONS.iter().copied())
            && !self.is_only("WAIT")
        {
            let error = self.expected("an instruction");
            self.reports.help(&format!("is {meant} meant?"));
            return Err(error);
        }
        let from = self.here();
        self.take_words(&words);
        let message = format!("`{words}` is taken for a macro, which $MACROTABLE explains");
        self.suspicious(from, message);
        let arguments = self.arguments()?;
        Ok(Some(Call {
            program: words.into(),
            arguments,
        }))
    }

    pub(super) fn callee(&mut self) -> Scanned<Call> {
        let program = self.name("a program")?.into();
        let arguments = self.arguments()?;
        Ok(Call { program, arguments })
    }

    fn arguments(&mut self) -> Scanned<Vec<Operand>> {
        let mut arguments = Vec::new();
        if self.eat("(") {
            loop {
                if arguments.len() >= MOST_ARGUMENTS {
                    return Err(self.wrong(0, format!("more than {MOST_ARGUMENTS} arguments")));
                }
                self.argument_name()?;
                arguments.push(self.operand()?);
                if !self.eat(",") {
                    break;
                }
            }
            self.expect(")")?;
        }
        Ok(arguments)
    }

    /// `"Part ID"=`: the pendant shows what an argument is called, its place is what counts.
    fn argument_name(&mut self) -> Scanned<()> {
        if self.eat("\"") {
            let _name = self.up_to(b'"')?;
            self.expect("=")?;
        }
        Ok(())
    }

    fn pulsed(&mut self, target: &Place) -> Scanned<(Port, Index)> {
        let Place::Port(port, index) = target else {
            return Err(self.wrong(0, "only an output can be pulsed"));
        };
        Ok((*port, *index))
    }

    pub(super) fn then(&mut self) -> Scanned<Then> {
        if self.eat_word("JMP") {
            return Ok(Then::Jump(self.label()?));
        }
        if self.eat_word("CALL") {
            return Ok(Then::Call(self.callee()?));
        }
        match self.assignment()? {
            (place, Assigned::Value(value)) => Ok(Then::Assign(place, value)),
            (target, Assigned::Pulse(width)) => {
                let (port, index) = self.pulsed(&target)?;
                Ok(Then::Pulse(port, index, width))
            }
        }
    }

    fn if_line(&mut self) -> Scanned<Line> {
        let condition = self.expression()?;
        if self.eat_word("THEN") {
            return Ok(Line::IfThen(condition));
        }
        self.expect(",")?;
        Ok(Line::If(condition, self.then()?))
    }

    /// `=2,JMP LBL[2]`.
    fn case(&mut self, operand: Operand, is_first: bool) -> Scanned<Line> {
        self.expect("=")?;
        let value = self.operand()?;
        self.expect(",")?;
        let [left, right] = [operand, value].map(|side| Box::new(Expr::Operand(side)));
        let equal = Operator::Relation(Relation::Equal);
        Ok(Line::Case {
            condition: Some(Expr::Binary(equal, left, right)),
            then: self.then()?,
            is_first,
        })
    }

    /// `R[1]=1 TO 5`.
    fn for_line(&mut self) -> Scanned<Line> {
        self.expect("R")?;
        let counter = self.index()?;
        self.expect("=")?;
        let from = self.operand()?;
        let down = self.eat_word("DOWNTO");
        if !down && !self.eat_word("TO") {
            return Err(self.expected("TO or DOWNTO"));
        }
        let to = self.operand()?;
        Ok(Line::For(ForHead {
            counter,
            from,
            to,
            down,
        }))
    }

    /// `WAIT   1.50(sec)`, `WAIT R[3]`, `WAIT DI[1]=ON TIMEOUT,LBL[2]`.
    fn wait(&mut self) -> Scanned<Line> {
        let value = self.watched_expression()?;
        if let Expr::Operand(time) = &value
            && (self.eat("(sec)")
                || (self.at_end()
                    && matches!(
                        time,
                        Operand::Integer(_) | Operand::Real(_) | Operand::Number(_)
                    )))
        {
            return Ok(Line::Done(Instruction::WaitSeconds(time.clone())));
        }
        let mut timeout = None;
        let _comma = self.eat(",");
        if self.eat_word("TIMEOUT") {
            self.expect(",")?;
            timeout = Some(self.label()?);
        }
        Ok(Line::WaitFor(value, timeout))
    }

    fn assignment(&mut self) -> Scanned<(Place, Assigned)> {
        let target = self.place()?;
        self.expect("=")?;
        if self.eat_word("PULSE") {
            let mut width = None;
            if self.eat(",") {
                width = Some(self.operand()?);
                self.expect("sec")?;
            }
            return Ok((target, Assigned::Pulse(width)));
        }
        Ok((target, Assigned::Value(self.expression()?)))
    }

    fn place(&mut self) -> Scanned<Place> {
        if let Some(kind) = self.frame_number_word() {
            return Ok(Place::FrameNumber(kind));
        }
        if let Some(kind) = self.frame_word() {
            return Ok(Place::Frame(kind, self.index()?));
        }
        if self.eat_word("PR") {
            return Ok(match self.register_or_component()? {
                (register, None) => Place::Position(register),
                (register, Some(component)) => Place::Component(register, component),
            });
        }
        if self.eat_word("P") {
            return Ok(Place::Taught(self.index()?));
        }
        if self.eat_word("R") {
            return Ok(Place::Number(self.index()?));
        }
        if self.eat_word("SR") {
            return Ok(Place::Text(self.index()?));
        }
        if self.sees("$") {
            return Ok(Place::System(self.system_path()?));
        }
        if let Some(port) = self.port() {
            if port.is_input() {
                return Err(self.wrong(0, "an input cannot be assigned"));
            }
            return Ok(Place::Port(port, self.index()?));
        }
        Err(self.expected("an instruction"))
    }
}

/// The right side of an assignment.
enum Assigned {
    Value(Expr),
    Pulse(Option<Operand>),
}
