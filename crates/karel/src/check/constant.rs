//! Constants: what a CONST section may say, and what is predefined.

use super::{Checker, scope::Symbol};
use crate::{
    ast::{BinaryOp, Expr, ExprKind, UnaryOp},
    typed::Constant,
    value::Text,
};

/// Constants that every program knows.
///
/// ASSUMPTION: the numbers of the motion, termination and task types are from descriptions of the
/// language; a program compares and assigns only the names.
pub(super) fn predefined(name: &str) -> Option<Constant> {
    Some(match name {
        "TRUE" | "ON" => Constant::Boolean(true),
        "FALSE" | "OFF" => Constant::Boolean(false),
        "MAXINT" => Constant::Integer(i32::MAX),
        "MININT" => Constant::Integer(i32::MIN),
        "DEG_2_RAD" => Constant::Real(std::f32::consts::PI / 180.0),
        "RAD_2_DEG" => Constant::Real(180.0 / std::f32::consts::PI),
        "ATR_IA" => Constant::Integer(crate::status::attribute::IMMEDIATE),
        "ATR_TIMEOUT" => Constant::Integer(crate::status::attribute::TIMEOUT),
        "ATR_UF" => Constant::Integer(crate::status::attribute::UNFORMATTED),
        "ATR_FIELD" => Constant::Integer(crate::status::attribute::FIELD),
        "ATR_EOL" => Constant::Integer(crate::status::attribute::END_OF_LINE),
        "ATR_PASSALL" => Constant::Integer(crate::status::attribute::PASS_ALL),
        "ATR_READAHD" => Constant::Integer(crate::status::attribute::READ_AHEAD),
        "ATR_REVERSE" => Constant::Integer(crate::status::attribute::REVERSE),
        "ATR_PIPOVADV" => Constant::Integer(crate::status::attribute::PIPE_OVERFLOW),
        "ATR_PIPWAIT" => Constant::Integer(crate::status::attribute::PIPE_WAIT),
        "ATR_XONOFF" => Constant::Integer(crate::status::attribute::FLOW),
        "ATR_MODEM" => Constant::Integer(crate::status::attribute::MODEM),
        "TP_PANEL" => Constant::Integer(0),
        "CRT_PANEL" => Constant::Integer(1),
        _ if name.starts_with("SPI_") => return screen(name),
        _ if name.starts_with("TPE_") || name.starts_with("PT_") => return editing(name),
        "TSK_STATUS" => Constant::Integer(crate::status::task::STATUS),
        "TSK_LINENUM" => Constant::Integer(crate::status::task::LINE),
        "TSK_PROGNAME" => Constant::Integer(crate::status::task::PROGRAM),
        "PG_RUNNING" => Constant::Integer(crate::status::task::RUNNING),
        "PG_PAUSED" => Constant::Integer(crate::status::task::PAUSED),
        "PG_ABORTED" => Constant::Integer(crate::status::task::ABORTED),
        "AT_PROG_TYPE" => Constant::Integer(crate::status::attribute_of_program::TYPE),
        "AT_PROG_NAME" => Constant::Integer(crate::status::attribute_of_program::NAME),
        "AT_COMMENT" => Constant::Integer(crate::status::attribute_of_program::COMMENT),
        "AT_PROG_SIZE" => Constant::Integer(crate::status::attribute_of_program::SIZE),
        "FINE" => Constant::Integer(1),
        "COARSE" => Constant::Integer(2),
        "NOSETTLE" => Constant::Integer(3),
        "NODECEL" => Constant::Integer(4),
        "VARDECEL" => Constant::Integer(5),
        "JOINT" => Constant::Integer(6),
        "LINEAR" => Constant::Integer(7),
        "CIRCULAR" => Constant::Integer(8),
        _ => return None,
    })
}

/// For `OPEN_TPE` and `CREATE_TPE`.
fn editing(name: &str) -> Option<Constant> {
    Some(Constant::Integer(match name {
        "TPE_RDACC" => crate::status::open_mode::READ,
        "TPE_RWACC" => crate::status::open_mode::WRITE,
        "TPE_NOREJ" | "PT_MNE_UNDEF" => 0,
        "TPE_RDREJ" | "PT_MNE_JOB" => 1,
        "TPE_WRTREJ" | "PT_MNE_PROC" => 2,
        "TPE_ALLREJ" | "PT_MNE_MACRO" => 3,
        _ => return None,
    }))
}

/// Screens of the pendant, for `FORCE_SPMENU`.
fn screen(name: &str) -> Option<Constant> {
    const SCREENS: &[&str] = &[
        "SPI_TPUSER",
        "SPI_TPUSER2",
        "SPI_TPALARM",
        "SPI_TPPROG",
        "SPI_TPSELECT",
        "SPI_TPFILE",
        "SPI_TPDATA",
        "SPI_TPPOSN",
        "SPI_TPIO",
        "SPI_TPSTATUS",
        "SPI_TPSETUP",
        "SPI_TPTEST",
        "SPI_TPHAND",
        "SPI_TPMANFUNC",
        "SPI_TPSYSVAR",
    ];
    let index = SCREENS.iter().position(|known| *known == name)?;
    i32::try_from(index + 1).ok().map(Constant::Integer)
}

impl Checker<'_> {
    /// The value of a constant expression; reports and returns `None` if it is not one.
    pub(super) fn constant_value(&mut self, expr: &Expr) -> Option<Constant> {
        match self.fold(expr) {
            Ok(constant) => Some(constant),
            Err(Fold::NotConstant) => {
                self.reports.error_with_help(
                    expr.span,
                    "this is not a constant",
                    "constants are literals, other constants and sums of them",
                );
                None
            }
            Err(Fold::OutOfRange) => {
                self.reports
                    .error(expr.span, "this INTEGER does not fit into 32 bits");
                None
            }
            Err(Fold::TooLong(bytes)) => {
                self.too_long(bytes, expr.span);
                None
            }
            Err(Fold::Reported) => None,
        }
    }

    fn fold(&self, expr: &Expr) -> Result<Constant, Fold> {
        match &expr.kind {
            ExprKind::Integer(value) => integer(*value),
            ExprKind::Real(value) => Ok(Constant::Real(*value)),
            ExprKind::Text(bytes) if bytes.len() > self.generation.longest_string() => {
                Err(Fold::TooLong(bytes.len()))
            }
            ExprKind::Text(bytes) => Ok(Constant::Text(Text::new(bytes.clone()))),
            ExprKind::Paren(inner) => self.fold(inner),
            ExprKind::Path(path) if path.steps.is_empty() => {
                match self.find_symbol(&path.root.text) {
                    Some(Symbol::Constant(constant)) => Ok(constant.clone()),
                    Some(Symbol::Variable { .. } | Symbol::Type(_)) => Err(Fold::NotConstant),
                    None => predefined(&path.root.text).ok_or(Fold::NotConstant),
                }
            }
            ExprKind::Unary {
                op: UnaryOp::Minus,
                operand,
            } => {
                if let ExprKind::Integer(value) = operand.kind {
                    return integer(value.saturating_neg());
                }
                match self.fold(operand)? {
                    Constant::Integer(value) => value
                        .checked_neg()
                        .map(Constant::Integer)
                        .ok_or(Fold::OutOfRange),
                    Constant::Real(value) => Ok(Constant::Real(-value)),
                    Constant::Boolean(_) | Constant::Text(_) => Err(Fold::NotConstant),
                }
            }
            ExprKind::Unary {
                op: UnaryOp::Plus,
                operand,
            } => self.fold(operand),
            ExprKind::Binary { op, left, right } => {
                combine(*op, self.fold(left)?, self.fold(right)?)
            }
            ExprKind::Call { name, args } if name.text == "CHR" => match args.as_slice() {
                [code] => match self.fold(code)? {
                    Constant::Integer(code) => {
                        let byte = u8::try_from(code).map_err(|_| Fold::OutOfRange)?;
                        Ok(Constant::Text(Text::new(vec![byte])))
                    }
                    Constant::Real(_) | Constant::Boolean(_) | Constant::Text(_) => {
                        Err(Fold::NotConstant)
                    }
                },
                _ => Err(Fold::NotConstant),
            },
            ExprKind::Error => Err(Fold::Reported),
            ExprKind::Path(_)
            | ExprKind::Call { .. }
            | ExprKind::Unary {
                op: UnaryOp::Not, ..
            } => Err(Fold::NotConstant),
        }
    }
}

enum Fold {
    NotConstant,
    OutOfRange,
    /// A string of so many bytes.
    TooLong(usize),
    Reported,
}

fn integer(value: i64) -> Result<Constant, Fold> {
    i32::try_from(value)
        .map(Constant::Integer)
        .map_err(|_| Fold::OutOfRange)
}

fn combine(op: BinaryOp, left: Constant, right: Constant) -> Result<Constant, Fold> {
    match (op, left, right) {
        (BinaryOp::Add, Constant::Integer(a), Constant::Integer(b)) => {
            integer(i64::from(a) + i64::from(b))
        }
        (BinaryOp::Subtract, Constant::Integer(a), Constant::Integer(b)) => {
            integer(i64::from(a) - i64::from(b))
        }
        (BinaryOp::Multiply, Constant::Integer(a), Constant::Integer(b)) => {
            integer(i64::from(a) * i64::from(b))
        }
        (BinaryOp::Add, Constant::Text(mut a), Constant::Text(b)) => {
            a.append(b.as_bytes(), crate::types::MAX_STRING);
            Ok(Constant::Text(a))
        }
        _ => Err(Fold::NotConstant),
    }
}
