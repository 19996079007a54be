//! Instructions that are a word and perhaps an operand.

use super::{
    Instruction, TimerAction,
    scan::{Scanned, Scanner},
};
use crate::span::latin1;

impl Scanner<'_> {
    /// Instructions that are a word and perhaps an operand.
    pub(super) fn simple(&mut self) -> Scanned<Option<Instruction>> {
        let done = if self.eat_word("CALL") {
            if self.is_unset() {
                Instruction::Unfinished
            } else {
                Instruction::Call(self.callee()?)
            }
        } else if self.eat_word("RUN") {
            Instruction::Run(self.name("a program")?.into())
        } else if self.eat_word("END") {
            Instruction::End
        } else if self.eat_word("ABORT") {
            Instruction::Abort
        } else if self.eat_word("PAUSE") {
            Instruction::Pause
        } else if self.eat_word("MESSAGE") {
            self.expect("[")?;
            let text = latin1(self.rest_of_bracket()?);
            Instruction::Message(text.trim().into())
        } else if self.eat_word("PAYLOAD") {
            // ASSUMPTION: the load changes no motion of this controller.
            let _schedule = self.index()?;
            Instruction::Nothing
        } else if self.eat("LOCK PREG") || self.eat("UNLOCK PREG") {
            // ASSUMPTION: each line reads its position registers when it is executed, so nothing is to be locked.
            Instruction::Nothing
        } else if self.eat("COL DETECT") {
            // ASSUMPTION: this arm hits nothing, so there is nothing to detect.
            self.on_or_off()?;
            Instruction::Nothing
        } else if self.eat("COL GUARD") || self.eat("STICK DETECT") {
            // ASSUMPTION: as COL DETECT.
            if self.eat_word("ADJUST") {
                let _sensitivity = self.operand()?;
            } else {
                self.on_or_off()?;
            }
            Instruction::Nothing
        } else if self.eat_word("SOFTFLOAT") {
            // ASSUMPTION: nothing pushes this arm, so it yields to nothing.
            if !self.eat_word("END") {
                let _schedule = self.index()?;
            }
            Instruction::Nothing
        } else if self.eat("FOLLOW UP") {
            // ASSUMPTION: as SOFTFLOAT.
            Instruction::Nothing
        } else if self.eat_word("TIMER") {
            self.timer()?
        } else if self.eat_word("RSR") {
            let signal = self.index()?;
            self.expect("=")?;
            let on = self.eat_word("ENABLE");
            if !on && !self.eat_word("DISABLE") {
                return Err(self.expected("ENABLE or DISABLE"));
            }
            Instruction::EnableRequest(signal, on)
        } else if self.eat_word("UALM") {
            Instruction::UserAlarm(self.index()?)
        } else if self.eat_word("MONITOR") {
            let on = !self.eat_word("END");
            Instruction::Monitor(self.name("a program")?.into(), on)
        } else if self.eat_word("WHEN") {
            let condition = self.watched_expression()?;
            self.expect(",")?;
            self.expect("CALL")?;
            Instruction::When(condition, self.callee()?)
        } else if self.eat_word("OVERRIDE") {
            self.expect("=")?;
            let percent = self.operand()?;
            let _percent = self.eat("%");
            Instruction::Override(percent)
        } else if self.eat_word("SKIP") {
            self.expect("CONDITION")?;
            Instruction::SkipCondition(self.watched_expression()?)
        } else if self.eat_word("OFFSET") {
            self.offset_condition(false)?
        } else if self.eat_word("TOOL_OFFSET") {
            self.offset_condition(true)?
        } else {
            return Ok(None);
        };
        Ok(Some(done))
    }

    fn on_or_off(&mut self) -> Scanned<()> {
        if self.eat_word("ON") || self.eat_word("OFF") {
            return Ok(());
        }
        Err(self.expected("ON or OFF"))
    }

    /// `TIMER[1]=START`, `STOP`, `RESET`.
    fn timer(&mut self) -> Scanned<Instruction> {
        let index = self.index()?;
        self.expect("=")?;
        let action = if self.eat_word("START") {
            TimerAction::Start
        } else if self.eat_word("STOP") {
            TimerAction::Stop
        } else if self.eat_word("RESET") {
            TimerAction::Reset
        } else {
            return Err(self.expected("START, STOP or RESET"));
        };
        Ok(Instruction::Timer(index, action))
    }

    fn offset_condition(&mut self, tool: bool) -> Scanned<Instruction> {
        self.expect("CONDITION")?;
        self.expect("PR")?;
        let register = self.index()?;
        Ok(Instruction::OffsetCondition { tool, register })
    }
}
