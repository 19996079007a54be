//! MOVE in all of its forms.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{MoveForm, StmtKind, Waits},
    token::{Keyword, TokenKind},
};

impl Parser<'_> {
    pub(super) fn move_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        let form = self.move_form()?;
        let via = if self.at_word("VIA") {
            self.position += 1;
            Some(self.expression()?)
        } else {
            None
        };
        let waits = if self.eat_keyword(Keyword::NoWait) {
            Waits::No
        } else {
            Waits::Yes
        };
        let (whens, until) = self.move_clauses()?;
        Ok(StmtKind::Move {
            form,
            via,
            waits,
            whens,
            until,
        })
    }

    fn move_form(&mut self) -> Parsed<MoveForm> {
        if self.eat_keyword(Keyword::To) {
            return Ok(MoveForm::To(self.expression()?));
        }
        let word = self.peek();
        if word.kind != TokenKind::Name {
            return Err(self.expected("TO"));
        }
        let name = self.name_of(word.span);
        self.position += 1;
        Ok(match name.text.as_str() {
            "NEAR" => MoveForm::Near {
                target: self.expression()?,
                distance: self.by()?,
            },
            "AXIS" => MoveForm::Axis {
                axis: self.expression()?,
                distance: self.by()?,
            },
            "RELATIVE" => MoveForm::Relative(self.expression()?),
            "ABOUT" => MoveForm::About {
                vector: self.expression()?,
                angle: self.by()?,
            },
            "AWAY" => MoveForm::Away(self.expression()?),
            "ALONG" => MoveForm::Along(self.path()?),
            _ => {
                let message = format!("there is no MOVE {}", name.text);
                let help = "a MOVE is TO, NEAR, AXIS, RELATIVE, ABOUT, AWAY or ALONG";
                self.reports.error_with_help(name.span, message, help);
                return Err(Reported);
            }
        })
    }

    fn by(&mut self) -> Parsed<crate::ast::Expr> {
        self.expect_word("BY")?;
        self.expression()
    }
}
