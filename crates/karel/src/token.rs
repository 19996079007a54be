//! Tokens of KAREL.

use crate::span::Span;

/// A token and where it stands. Its text is in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: TokenKind,
    pub(crate) span: Span,
}

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// A name, `$` included.
    Name,
    Keyword(Keyword),
    Integer,
    Real,
    /// A string, quotes included.
    Text,
    /// `%NAME ...` up to the end of its line.
    Directive,
    Symbol(Symbol),
    /// A line end that separates statements.
    LineEnd,
    EndOfFile,
}

macro_rules! keywords {
    ($($name:ident $text:literal,)*) => {
        /// A reserved word that the parser looks for.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Keyword { $($name,)* }

        impl Keyword {
            /// All of them, for look-up.
            const ALL: &[(&str, Keyword)] = &[$(($text, Keyword::$name),)*];

            pub(crate) fn text(self) -> &'static str {
                match self { $(Keyword::$name => $text,)* }
            }
        }
    };
}

keywords! {
    Abort "ABORT", And "AND", Array "ARRAY", Begin "BEGIN", Cancel "CANCEL", Case "CASE",
    Close "CLOSE", Condition "CONDITION", Const "CONST", Cr "CR", Delay "DELAY", Div "DIV",
    Do "DO", Downto "DOWNTO", Else "ELSE", End "END", EndCondition "ENDCONDITION",
    EndFor "ENDFOR", EndIf "ENDIF", EndMove "ENDMOVE", EndSelect "ENDSELECT",
    EndStructure "ENDSTRUCTURE", EndUsing "ENDUSING", EndWhile "ENDWHILE", For "FOR",
    From "FROM", Goto "GOTO", If "IF", Mod "MOD", Move "MOVE", Not "NOT", NoWait "NOWAIT",
    Of "OF", Open "OPEN", Or "OR", Program "PROGRAM", Read "READ", Repeat "REPEAT",
    Return "RETURN", Routine "ROUTINE", Select "SELECT", Structure "STRUCTURE", Then "THEN",
    To "TO", Type "TYPE", Until "UNTIL", Using "USING", Var "VAR", Wait "WAIT",
    When "WHEN", While "WHILE", Write "WRITE",
}

impl Keyword {
    /// Looks a word up, in any case.
    pub(crate) fn find(word: &[u8]) -> Option<Keyword> {
        let same = |text: &str| text.as_bytes().eq_ignore_ascii_case(word);
        Keyword::ALL
            .iter()
            .find(|(text, _)| same(text))
            .map(|(_, keyword)| *keyword)
    }

    /// Whether the word starts or ends a statement or a section, so that it cannot stand inside
    /// parentheses: the lexer resynchronizes at it when a parenthesis was never closed.
    pub(crate) fn is_structural(self) -> bool {
        match self {
            Keyword::And
            | Keyword::Array
            | Keyword::Cr
            | Keyword::Div
            | Keyword::Mod
            | Keyword::Not
            | Keyword::Or
            | Keyword::Of => false,
            Keyword::Abort
            | Keyword::Begin
            | Keyword::Cancel
            | Keyword::Case
            | Keyword::Close
            | Keyword::Condition
            | Keyword::Const
            | Keyword::Delay
            | Keyword::Do
            | Keyword::Downto
            | Keyword::Else
            | Keyword::End
            | Keyword::EndCondition
            | Keyword::EndFor
            | Keyword::EndIf
            | Keyword::EndMove
            | Keyword::EndSelect
            | Keyword::EndStructure
            | Keyword::EndUsing
            | Keyword::EndWhile
            | Keyword::For
            | Keyword::From
            | Keyword::Goto
            | Keyword::If
            | Keyword::Move
            | Keyword::NoWait
            | Keyword::Open
            | Keyword::Program
            | Keyword::Read
            | Keyword::Repeat
            | Keyword::Return
            | Keyword::Routine
            | Keyword::Select
            | Keyword::Structure
            | Keyword::Then
            | Keyword::To
            | Keyword::Type
            | Keyword::Until
            | Keyword::Using
            | Keyword::Var
            | Keyword::Wait
            | Keyword::When
            | Keyword::While
            | Keyword::Write => true,
        }
    }
}

macro_rules! symbols {
    ($($name:ident $text:literal,)*) => {
        /// Punctuation and operators.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Symbol { $($name,)* }

        impl Symbol {
            /// Longer symbols before their prefixes.
            pub(crate) const ALL: &[(&str, Symbol)] = &[$(($text, Symbol::$name),)*];

            pub(crate) fn text(self) -> &'static str {
                match self { $(Symbol::$name => $text,)* }
            }
        }
    };
}

symbols! {
    ApproxEqual ">=<", LessEqual "<=", GreaterEqual ">=", NotEqual "<>", Less "<", Greater ">",
    DoubleColon "::", Colon ":", DoubleDot "..", Dot ".", Comma ",", Semicolon ";",
    LeftParen "(", RightParen ")", LeftBracket "[", RightBracket "]", Plus "+", Minus "-",
    Star "*", Slash "/", Equal "=", At "@", Hash "#", Bar "|",
}
