//! The program's frame, sections, types and routines.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{
        Decl, Dim, Directive, Memory, Name, Param, Program, Routine, RoutineBody, Stmt, Storage,
        TypeExpr, TypeKind,
    },
    span::{Span, latin1},
    token::{Keyword, Symbol, TokenKind},
};

impl Parser<'_> {
    pub(super) fn program(&mut self) -> Parsed<Program> {
        let mut directives = Vec::new();
        self.skip_blank(&mut directives);
        self.refuse_include_file()?;
        let _ = self.expect_keyword(Keyword::Program)?;
        let name = self.expect_name("the program's name")?;
        let mut decls = self.declarations(&mut directives, Place::Program);
        let (body, end) = self.body(&name, "program")?;
        decls.extend(self.declarations(&mut directives, Place::AfterEnd));
        if self.peek().kind != TokenKind::EndOfFile && !self.reports.is_full() {
            let _ = self.expected("ROUTINE or the end of the file");
        }
        Ok(Program {
            name,
            directives,
            decls,
            body,
            end,
        })
    }

    /// An include file starts with a section; it is no program of its own.
    fn refuse_include_file(&mut self) -> Parsed<()> {
        let token = self.peek();
        let section = [
            Keyword::Const,
            Keyword::Type,
            Keyword::Var,
            Keyword::Routine,
        ];
        if !section
            .iter()
            .any(|keyword| token.kind == TokenKind::Keyword(*keyword))
        {
            return Ok(());
        }
        let message = format!("expected PROGRAM, found {}", self.describe(token));
        let help = "this looks like a file for %INCLUDE, not like a program";
        self.reports.error_with_help(token.span, message, help);
        Err(Reported)
    }

    /// `BEGIN stmts END name`.
    fn body(&mut self, name: &Name, what: &str) -> Parsed<(Vec<Stmt>, Span)> {
        let _ = self.expect_keyword(Keyword::Begin)?;
        self.open_blocks.push(&[Keyword::End]);
        let stmts = self.block();
        let _ = self.open_blocks.pop();
        let end = self.expect_keyword(Keyword::End)?;
        let closing = self.expect_name(&format!("the {what}'s name after END"))?;
        if closing.text != name.text {
            let message = format!(
                "END names `{}`, but this {what} is `{}`",
                closing.text, name.text
            );
            self.reports.error(closing.span, message);
        }
        Ok((stmts, end.to(closing.span)))
    }

    /// Line ends, semicolons and directives between declarations.
    fn skip_blank(&mut self, directives: &mut Vec<Directive>) {
        loop {
            self.skip_separators();
            let token = self.peek();
            if token.kind != TokenKind::Directive {
                return;
            }
            self.position += 1;
            directives.push(directive(self.source.slice(token.span), token.span));
        }
    }

    fn declarations(&mut self, directives: &mut Vec<Directive>, place: Place) -> Vec<Decl> {
        let mut decls = Vec::new();
        let mut section = None;
        loop {
            self.skip_blank(directives);
            let token = self.peek();
            let start = self.position;
            let parsed = match (token.kind, section) {
                (
                    TokenKind::Keyword(found @ (Keyword::Const | Keyword::Type | Keyword::Var)),
                    _,
                ) => {
                    self.position += 1;
                    section = Some(found);
                    continue;
                }
                (TokenKind::Keyword(Keyword::Routine), _) if place != Place::Routine => {
                    section = None;
                    self.nested(Self::routine)
                        .map(|routine| decls.push(Decl::Routine(routine)))
                }
                (TokenKind::Name, Some(Keyword::Const)) => {
                    self.constant().map(|decl| decls.push(decl))
                }
                (TokenKind::Name, Some(Keyword::Type)) => {
                    self.type_declaration().map(|decl| decls.push(decl))
                }
                (TokenKind::Name, Some(_)) => self.variables().map(|decl| decls.push(decl)),
                _ if self.ends_declarations(place) => return decls,
                _ => Err(self.expected("CONST, TYPE, VAR, ROUTINE or BEGIN")),
            };
            if let Err(Reported) = parsed {
                self.skip_to_separator();
                if self.position == start {
                    self.position += 1;
                }
            }
        }
    }

    fn ends_declarations(&self, place: Place) -> bool {
        self.peek().kind == TokenKind::EndOfFile
            || self.reports.is_full()
            || (place != Place::AfterEnd && self.at_keyword(Keyword::Begin))
            || (place == Place::Routine && self.at_keyword(Keyword::End))
    }

    fn constant(&mut self) -> Parsed<Decl> {
        let name = self.expect_name("a constant")?;
        let _ = self.expect_symbol(Symbol::Equal)?;
        let value = self.simple()?;
        self.expect_separator()?;
        Ok(Decl::Const { name, value })
    }

    fn type_declaration(&mut self) -> Parsed<Decl> {
        let name = self.expect_name("a type")?;
        if self.eat_keyword(Keyword::From) {
            // The type is declared here in full; FROM only says which program shares it.
            let _ = self.expect_name("a program")?;
        }
        let _ = self.expect_symbol(Symbol::Equal)?;
        let ty = self.type_expression()?;
        self.expect_separator()?;
        Ok(Decl::Type { name, ty })
    }

    fn variables(&mut self) -> Parsed<Decl> {
        let names = self.name_list("a variable")?;
        let mut storage = None;
        if self.peek().kind == TokenKind::Name
            && latin1(self.source.slice(self.peek().span)).eq_ignore_ascii_case("IN")
        {
            self.position += 1;
            storage = Some(self.storage()?);
        }
        let mut home = None;
        if self.eat_keyword(Keyword::From) {
            home = Some(self.expect_name("a program")?);
        }
        let _ = self.expect_symbol(Symbol::Colon)?;
        let ty = self.type_expression()?;
        self.expect_separator()?;
        Ok(Decl::Var {
            names,
            storage,
            home,
            ty,
        })
    }

    fn storage(&mut self) -> Parsed<Storage> {
        let name = self.expect_name("CMOS, DRAM, SHADOW or UNINIT_DRAM")?;
        let memory = match name.text.as_str() {
            "CMOS" | "SHADOW" => Memory::Cmos,
            "DRAM" | "UNINIT_DRAM" => Memory::Dram,
            other => {
                let message =
                    format!("expected CMOS, DRAM, SHADOW or UNINIT_DRAM, found `{other}`");
                self.reports.error(name.span, message);
                return Err(Reported);
            }
        };
        Ok(Storage {
            memory,
            span: name.span,
        })
    }

    fn name_list(&mut self, what: &str) -> Parsed<Vec<Name>> {
        let mut names = vec![self.expect_name(what)?];
        while self.eat_symbol(Symbol::Comma) {
            names.push(self.expect_name(what)?);
        }
        Ok(names)
    }

    fn expect_separator(&mut self) -> Parsed<()> {
        if self.at_separator() || self.peek().kind == TokenKind::EndOfFile {
            return Ok(());
        }
        Err(self.expected("the end of the declaration"))
    }

    fn routine(&mut self) -> Parsed<Routine> {
        let _ = self.expect_keyword(Keyword::Routine)?;
        let name = self.expect_name("the routine's name")?;
        let params = if self.at_symbol(Symbol::LeftParen) {
            self.params()?
        } else {
            Vec::new()
        };
        let result = if self.eat_symbol(Symbol::Colon) {
            Some(self.type_expression()?)
        } else {
            None
        };
        if self.eat_keyword(Keyword::From) {
            let program = self.expect_name("a program")?;
            return Ok(Routine {
                name,
                params,
                result,
                body: RoutineBody::From(program),
            });
        }
        let mut directives = Vec::new();
        let decls = self.declarations(&mut directives, Place::Routine);
        let (stmts, end) = self.body(&name, "routine")?;
        Ok(Routine {
            name,
            params,
            result,
            body: RoutineBody::Here { decls, stmts, end },
        })
    }

    fn params(&mut self) -> Parsed<Vec<Param>> {
        let _ = self.expect_symbol(Symbol::LeftParen)?;
        let mut params = Vec::new();
        while !self.eat_symbol(Symbol::RightParen) {
            let names = self.name_list("a parameter")?;
            let _ = self.expect_symbol(Symbol::Colon)?;
            let ty = self.type_expression()?;
            params.push(Param { names, ty });
            if !self.eat_symbol(Symbol::Semicolon) && !self.at_symbol(Symbol::RightParen) {
                return Err(self.expected("`;` or `)`"));
            }
        }
        Ok(params)
    }

    pub(super) fn type_expression(&mut self) -> Parsed<TypeExpr> {
        let start = self.peek().span;
        let kind = if self.eat_keyword(Keyword::Array) {
            let dims = if self.at_symbol(Symbol::LeftBracket) {
                self.dims()?
            } else {
                Vec::new()
            };
            let _ = self.expect_keyword(Keyword::Of)?;
            let element = self.nested(Self::type_expression)?;
            TypeKind::Array {
                dims,
                element: Box::new(element),
            }
        } else if self.eat_keyword(Keyword::Structure) {
            self.nested(Self::structure)?
        } else {
            let name = self.expect_name("a type")?;
            if name.text == "STRING" {
                TypeKind::Text(self.string_length()?)
            } else {
                self.type_suffix(name)?
            }
        };
        Ok(TypeExpr {
            kind,
            span: start.to(self.previous_span()),
        })
    }

    fn string_length(&mut self) -> Parsed<Option<Box<crate::ast::Expr>>> {
        if !self.eat_symbol(Symbol::LeftBracket) {
            return Ok(None);
        }
        let length = self.simple()?;
        let _ = self.expect_symbol(Symbol::RightBracket)?;
        Ok(Some(Box::new(length)))
    }

    /// What may follow the name of a type: the parts of a PATH, `IN GROUP[1]`.
    fn type_suffix(&mut self, name: Name) -> Parsed<TypeKind> {
        let is_path = name.text == "PATH";
        let part = self.path_part();
        if is_path && part.is_some() {
            let (mut header, mut node) = (None, None);
            while let Some(word) = self.path_part() {
                self.skip_separators();
                let at = self.bump().span;
                let _ = self.expect_symbol(Symbol::Equal)?;
                let ty = Box::new(self.nested(Self::type_expression)?);
                let slot = if word == "PATHHEADER" {
                    &mut header
                } else {
                    &mut node
                };
                if slot.replace(ty).is_some() {
                    self.reports.error(at, format!("{word} stands here twice"));
                }
                let _ = self.eat_symbol(Symbol::Comma);
            }
            return Ok(TypeKind::Path { header, node });
        }
        if self.at_word("IN") {
            self.position += 1;
            self.groups()?;
            return Ok(TypeKind::Name(name));
        }
        if self.peek().kind == TokenKind::Name {
            let message = format!("nothing can follow the type {} here", name.text);
            let span = self.peek().span;
            self.reports.error(span, message);
            return Err(Reported);
        }
        Ok(if is_path {
            TypeKind::Path {
                header: None,
                node: None,
            }
        } else {
            TypeKind::Name(name)
        })
    }

    /// The word of the next part of a PATH, which may stand on a line of its own.
    fn path_part(&self) -> Option<&'static str> {
        let mut ahead = 0;
        while self.peek_ahead(ahead).kind == TokenKind::LineEnd {
            ahead += 1;
        }
        let words = ["PATHHEADER", "NODEDATA"];
        let word = words
            .into_iter()
            .find(|word| self.ahead_is_word(ahead, word))?;
        let equal = self.peek_ahead(ahead + 1).kind == TokenKind::Symbol(Symbol::Equal);
        equal.then_some(word)
    }

    fn dims(&mut self) -> Parsed<Vec<Dim>> {
        let _ = self.expect_symbol(Symbol::LeftBracket)?;
        let mut dims = Vec::new();
        loop {
            if self.at_symbol(Symbol::Star) {
                dims.push(Dim::Open(self.bump().span));
            } else {
                dims.push(Dim::Length(self.simple()?));
            }
            if !self.eat_symbol(Symbol::Comma) {
                let _ = self.expect_symbol(Symbol::RightBracket)?;
                return Ok(dims);
            }
        }
    }

    fn structure(&mut self) -> Parsed<TypeKind> {
        let mut fields = Vec::new();
        loop {
            self.skip_separators();
            if self.eat_keyword(Keyword::EndStructure) {
                return Ok(TypeKind::Structure(fields));
            }
            let names = self.name_list("a field or ENDSTRUCTURE")?;
            let _ = self.expect_symbol(Symbol::Colon)?;
            let ty = self.type_expression()?;
            fields.push(Param { names, ty });
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Program,
    /// After the END of the main body.
    AfterEnd,
    /// Inside a routine, which holds no routines.
    Routine,
}

pub(super) fn directive(text: &[u8], span: Span) -> Directive {
    let text = latin1(text);
    let word_end = text.find([' ', '\t', '=']).unwrap_or(text.len());
    let (name, rest) = text.split_at_checked(word_end).unwrap_or((&text, ""));
    Directive {
        name: name.to_ascii_uppercase(),
        argument: rest
            .trim_start_matches([' ', '\t', '='])
            .trim_end()
            .to_owned(),
        span,
    }
}
