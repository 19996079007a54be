//! Statements about files and motion.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{HandVerb, Item, ItemKind, MotionVerb, StmtKind},
    token::{Keyword, Symbol, TokenKind},
};

impl Parser<'_> {
    /// READ and WRITE differ only in what their items may be, and the checker knows that.
    pub(super) fn transfer_statement(&mut self, keyword: Keyword) -> Parsed<StmtKind> {
        self.position += 1;
        let file = if self.at_symbol(Symbol::LeftParen) {
            None
        } else {
            Some(self.path()?)
        };
        let _ = self.expect_symbol(Symbol::LeftParen)?;
        let mut items = Vec::new();
        loop {
            items.push(self.item()?);
            if !self.eat_symbol(Symbol::Comma) {
                break;
            }
        }
        let _ = self.expect_symbol(Symbol::RightParen)?;
        Ok(if keyword == Keyword::Read {
            StmtKind::Read { file, items }
        } else {
            StmtKind::Write { file, items }
        })
    }

    fn item(&mut self) -> Parsed<Item> {
        let start = self.peek().span;
        let kind = if self.eat_keyword(Keyword::Cr) {
            ItemKind::LineEnd
        } else {
            ItemKind::Value(self.expression()?)
        };
        let mut formats = Vec::new();
        while self.at_symbol(Symbol::DoubleColon) {
            let at = self.bump().span;
            if formats.len() == 2 {
                self.reports
                    .error(at, "an item has at most two format specifiers");
                return Err(Reported);
            }
            formats.push(self.simple()?);
        }
        Ok(Item {
            kind,
            formats,
            span: start.to(self.previous_span()),
        })
    }

    pub(super) fn open_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        if self.at_word("HAND") {
            return self.hand_statement(HandVerb::Open);
        }
        self.expect_word("FILE")?;
        let file = self.path()?;
        let _ = self.expect_symbol(Symbol::LeftParen)?;
        let mode = self.expression()?;
        let _ = self.expect_symbol(Symbol::Comma)?;
        let name = self.expression()?;
        let _ = self.expect_symbol(Symbol::RightParen)?;
        Ok(StmtKind::OpenFile { file, mode, name })
    }

    pub(super) fn close_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        if self.at_word("HAND") {
            return self.hand_statement(HandVerb::Close);
        }
        self.expect_word("FILE")?;
        Ok(StmtKind::CloseFile(self.path()?))
    }

    pub(super) fn cancel_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        if self.at_word("FILE") {
            self.position += 1;
            return Ok(StmtKind::CancelFile(self.path()?));
        }
        self.groups()?;
        Ok(StmtKind::Motion(MotionVerb::Cancel))
    }

    pub(super) fn at_word(&self, word: &str) -> bool {
        self.ahead_is_word(0, word)
    }

    /// Whether the token after `ahead` others is this word.
    pub(super) fn ahead_is_word(&self, ahead: usize, word: &str) -> bool {
        let token = self.peek_ahead(ahead);
        token.kind == TokenKind::Name
            && self
                .source
                .slice(token.span)
                .eq_ignore_ascii_case(word.as_bytes())
    }

    pub(super) fn expect_word(&mut self, word: &str) -> Parsed<()> {
        if self.at_word(word) {
            self.position += 1;
            return Ok(());
        }
        Err(self.expected(word))
    }
}
