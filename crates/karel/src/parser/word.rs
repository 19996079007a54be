//! Statements that begin with a word that is no reserved one: tasks, conditions, hands, motion.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{Action, ConditionVerb, HandVerb, MotionVerb, Name, Signaled, StmtKind, TaskVerb, Waits},
    token::{Keyword, Symbol, TokenKind},
};

impl Parser<'_> {
    /// The statement that this word begins; `None` if it begins none and is a name.
    pub(super) fn word_statement(&mut self, word: &Name) -> Parsed<Option<StmtKind>> {
        let text = word.text.as_str();
        if let Some(verb) = TaskVerb::of_word(text) {
            return self.task_statement(verb).map(Some);
        }
        if let Some(verb) = ConditionVerb::of_word(text) {
            self.position += 1;
            let _ = self.expect_keyword(Keyword::Condition)?;
            let number = self.bracketed()?;
            return Ok(Some(StmtKind::ConditionState { verb, number }));
        }
        if let Some(action) = Action::of_word(text) {
            self.position += 1;
            return Ok(Some(StmtKind::Action(action)));
        }
        if let Some(verb) = MotionVerb::of_word(text) {
            self.position += 1;
            self.groups()?;
            return Ok(Some(StmtKind::Motion(verb)));
        }
        // OPEN and CLOSE are reserved words.
        if let Some(verb) = HandVerb::of_word(text) {
            self.position += 1;
            return self.hand_statement(verb).map(Some);
        }
        Ok(match text {
            "SIGNAL" => Some(self.signal_statement()?),
            "PULSE" => Some(self.pulse_statement()?),
            _ => None,
        })
    }

    /// `ABORT`, `PAUSE PROGRAM[n]`.
    pub(super) fn task_statement(&mut self, verb: TaskVerb) -> Parsed<StmtKind> {
        self.position += 1;
        let task = self.program_number()?;
        Ok(StmtKind::Task { verb, task })
    }

    fn signal_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        let word = self.expect_name("EVENT or SEMAPHORE")?;
        let Some(what) = Signaled::of_word(&word.text) else {
            let message = format!("expected EVENT or SEMAPHORE, found `{}`", word.text);
            self.reports.error(word.span, message);
            return Err(Reported);
        };
        let number = self.bracketed()?;
        Ok(StmtKind::Signal { what, number })
    }

    fn pulse_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        let port = self.path()?;
        let _ = self.expect_keyword(Keyword::For)?;
        let time = self.expression()?;
        let waits = if self.eat_keyword(Keyword::NoWait) {
            Waits::No
        } else {
            Waits::Yes
        };
        Ok(StmtKind::Pulse { port, time, waits })
    }

    /// `HAND n`, after OPEN, CLOSE or RELAX.
    pub(super) fn hand_statement(&mut self, verb: HandVerb) -> Parsed<StmtKind> {
        self.expect_word("HAND")?;
        let number = self.expression()?;
        Ok(StmtKind::Hand { verb, number })
    }

    /// `GROUP[1, 2]`, or nothing. There is one motion group, so only its number 1 is legal.
    pub(super) fn groups(&mut self) -> Parsed<()> {
        if !self.at_word("GROUP") {
            return Ok(());
        }
        self.position += 1;
        let _ = self.expect_symbol(Symbol::LeftBracket)?;
        loop {
            let token = self.peek();
            let _ = self.expression()?;
            let one = token.kind == TokenKind::Integer && self.source.slice(token.span) == b"1";
            if !one {
                let message = "motion groups other than 1 are not supported";
                self.reports.error(token.span, message);
            }
            if !self.eat_symbol(Symbol::Comma) {
                let _ = self.expect_symbol(Symbol::RightBracket)?;
                return Ok(());
            }
        }
    }
}
