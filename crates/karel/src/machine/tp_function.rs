//! Functions of TP programs: of texts and of numbers.

use super::{exec::Exec, fault::Fault, tp_calculate, tp_value::Term};
use crate::{
    registers::Number,
    status::Status,
    tp::{Function, Operand},
};

impl Exec<'_> {
    pub(super) fn tp_function(
        &mut self,
        function: Function,
        operands: &[Operand],
    ) -> Result<Term, Fault> {
        let mut values = Vec::with_capacity(operands.len());
        for operand in operands {
            values.push(self.tp_operand(operand)?);
        }
        match (function, values.as_slice()) {
            (Function::Length, [Term::Text(text)]) => Ok(count(text.chars().count())),
            (Function::Find, [Term::Text(text), Term::Text(part)]) => Ok(find(text, part)),
            (Function::Part, [Term::Text(text), Term::Number(from), Term::Number(length)]) => {
                part(text, *from, *length).map(Term::Text)
            }
            (_, [Term::Number(value)]) => of_number(function, *value).map(Term::Number),
            (Function::Atan2, [Term::Number(x), Term::Number(y)]) => {
                // ASSUMPTION: the values stand in the order of KAREL's ATAN2.
                let [x, y] = [x, y].map(|value| f64::from(tp_calculate::real(*value)));
                let angle = super::real(y.atan2(x).to_degrees())?;
                Ok(Term::Number(Number::Real(angle)))
            }
            _ => {
                let message = format!("{function:?} cannot be made of {values:?}");
                Err(Fault::new(Status::INTP_TYPE, message))
            }
        }
    }
}

fn count(count: usize) -> Term {
    Term::Number(Number::Integer(i32::try_from(count).unwrap_or(i32::MAX)))
}

/// Where a text begins in another, from 1; 0 if it is not there.
///
/// ASSUMPTION: as `INDEX`, an empty text is nowhere.
fn find(text: &str, part: &str) -> Term {
    let at = text.find(part).filter(|_| !part.is_empty());
    count(at.map_or(0, |at| {
        let before = text.get(..at).unwrap_or_default();
        before.chars().count() + 1
    }))
}

/// ASSUMPTION: as `SUB_STR`: beyond the end it is shorter and no error, a start below 1 or a negative length is INTP-322.
fn part(text: &str, from: Number, length: Number) -> Result<String, Fault> {
    let (Number::Integer(from), Number::Integer(length)) = (from, length) else {
        return Err(Fault::argument("SUBSTR needs whole numbers"));
    };
    let skip = usize::try_from(from)
        .ok()
        .and_then(|from| from.checked_sub(1));
    match (skip, usize::try_from(length)) {
        (Some(skip), Ok(length)) => Ok(text.chars().skip(skip).take(length).collect()),
        _ => Err(Fault::argument(format!(
            "SUBSTR from {from}, {length} characters"
        ))),
    }
}

/// Angles are degrees.
fn of_number(function: Function, value: Number) -> Result<Number, Fault> {
    if let (Function::Abs, Number::Integer(value)) = (function, value) {
        let value = value.checked_abs().ok_or_else(Fault::overflow)?;
        return Ok(Number::Integer(value));
    }
    let short = tp_calculate::real(value);
    let x = f64::from(short);
    let result = match function {
        Function::Abs => x.abs(),
        Function::Sqrt if x >= 0.0 => x.sqrt(),
        Function::Sin => x.to_radians().sin(),
        Function::Cos => x.to_radians().cos(),
        Function::Tan => x.to_radians().tan(),
        Function::Asin if x.abs() <= 1.0 => x.asin().to_degrees(),
        Function::Acos if x.abs() <= 1.0 => x.acos().to_degrees(),
        Function::Atan => x.atan().to_degrees(),
        Function::Ln if x > 0.0 => x.ln(),
        Function::Exp => x.exp(),
        Function::Round | Function::Trunc => {
            let rounded = if function == Function::Round {
                short.round()
            } else {
                short.trunc()
            };
            return super::whole(rounded).map(Number::Integer);
        }
        Function::Sqrt
        | Function::Asin
        | Function::Acos
        | Function::Ln
        | Function::Atan2
        | Function::Length
        | Function::Part
        | Function::Find => {
            let name = format!("{function:?}").to_ascii_uppercase();
            return Err(Fault::argument(format!("{name} of {x}")));
        }
    };
    super::real(result).map(Number::Real)
}
