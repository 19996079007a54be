//! What operators of TP programs make of two values.

use super::{fault::Fault, tp_value::Term};
use crate::{
    ast::Relation,
    registers::{Number, PositionRegister},
    status::Status,
    tp::{Arithmetic, Operator},
    value::real_of,
};

pub(super) fn component_of(position: &mut PositionRegister, component: i32) -> Option<&mut f32> {
    match position {
        PositionRegister::Cartesian(p) => match component {
            1 => Some(&mut p.x),
            2 => Some(&mut p.y),
            3 => Some(&mut p.z),
            4 => Some(&mut p.w),
            5 => Some(&mut p.p),
            6 => Some(&mut p.r),
            _ => None,
        },
        PositionRegister::Joints(joints) => {
            let index = usize::try_from(component).ok()?.checked_sub(1)?;
            joints.axes.get_mut(index)
        }
        PositionRegister::Unset => None,
    }
}

pub(super) fn number_in(text: &str) -> Number {
    let text = text.trim();
    let whole = text.parse().ok().map(Number::Integer);
    let real = || text.parse::<f32>().ok().filter(|value| value.is_finite());
    whole
        .or_else(|| real().map(Number::Real))
        .unwrap_or(Number::Integer(0))
}

pub(super) fn number_text(number: Number) -> String {
    match number {
        Number::Integer(value) => value.to_string(),
        Number::Real(value) => value.to_string(),
    }
}

pub(super) fn combine(operator: Operator, left: Term, right: Term) -> Result<Term, Fault> {
    match (operator, left, right) {
        (Operator::And, Term::Switch(a), Term::Switch(b)) => Ok(Term::Switch(a && b)),
        (Operator::Or, Term::Switch(a), Term::Switch(b)) => Ok(Term::Switch(a || b)),
        (Operator::Relation(relation), a, b) => compare(&a, relation, &b).map(Term::Switch),
        (Operator::Arithmetic(operator), Term::Number(a), Term::Number(b)) => {
            calculate(operator, a, b).map(Term::Number)
        }
        (Operator::Arithmetic(Arithmetic::Add), Term::Text(a), Term::Text(b)) => {
            Ok(Term::Text(a + &b))
        }
        (
            Operator::Arithmetic(operator @ (Arithmetic::Add | Arithmetic::Subtract)),
            Term::Position(a),
            Term::Position(b),
        ) => sum_of_positions(operator, a, &b).map(Term::Position),
        (operator, a, b) => {
            let message = format!("{a:?} {operator:?} {b:?} is nothing that can be calculated");
            Err(Fault::new(Status::INTP_TYPE, message))
        }
    }
}

/// Component by component; the configuration stays that of the left one.
fn sum_of_positions(
    operator: Arithmetic,
    mut left: PositionRegister,
    right: &PositionRegister,
) -> Result<PositionRegister, Fault> {
    let mut right = right.clone();
    let same = matches!(
        (&left, &right),
        (
            PositionRegister::Cartesian(_),
            PositionRegister::Cartesian(_)
        ) | (PositionRegister::Joints(_), PositionRegister::Joints(_))
    );
    if !same {
        let message = "Positions that are added need values of the same kind";
        return Err(Fault::new(Status::INTP_TYPE, message));
    }
    for component in 1..=6 {
        if let (Some(value), Some(other)) = (
            component_of(&mut left, component),
            component_of(&mut right, component),
        ) {
            let sum = if operator == Arithmetic::Add {
                *value + *other
            } else {
                *value - *other
            };
            *value = super::finite(sum)?;
        }
    }
    Ok(left)
}

fn calculate(operator: Arithmetic, a: Number, b: Number) -> Result<Number, Fault> {
    if let (Number::Integer(a), Number::Integer(b)) = (a, b)
        && operator != Arithmetic::Divide
    {
        if b == 0 && matches!(operator, Arithmetic::Div | Arithmetic::Mod) {
            return Err(Fault::divide_by_zero());
        }
        let result = match operator {
            Arithmetic::Add => a.checked_add(b),
            Arithmetic::Subtract => a.checked_sub(b),
            Arithmetic::Multiply => a.checked_mul(b),
            Arithmetic::Div => a.checked_div(b),
            Arithmetic::Mod => a.checked_rem(b),
            Arithmetic::Divide => None,
        };
        return result.map(Number::Integer).ok_or_else(Fault::overflow);
    }
    let (a, b) = (real(a), real(b));
    let result = match operator {
        Arithmetic::Add => a + b,
        Arithmetic::Subtract => a - b,
        Arithmetic::Multiply => a * b,
        Arithmetic::Divide | Arithmetic::Div | Arithmetic::Mod if b == 0.0 => {
            return Err(Fault::divide_by_zero());
        }
        Arithmetic::Divide => a / b,
        Arithmetic::Div => (a / b).trunc(),
        Arithmetic::Mod => a % b,
    };
    super::finite(result).map(Number::Real)
}

pub(super) fn real(number: Number) -> f32 {
    match number {
        Number::Integer(value) => real_of(value),
        Number::Real(value) => value,
    }
}

fn compare(left: &Term, relation: Relation, right: &Term) -> Result<bool, Fault> {
    let order = match (left, right) {
        (Term::Number(Number::Integer(a)), Term::Number(Number::Integer(b))) => a.cmp(b),
        (Term::Number(a), Term::Number(b)) => super::arithmetic::order(real(*a), real(*b)),
        (Term::Text(a), Term::Text(b)) => a.cmp(b),
        (Term::Switch(a), Term::Switch(b))
            if matches!(relation, Relation::Equal | Relation::NotEqual) =>
        {
            a.cmp(b)
        }
        _ => {
            let message = format!("{left:?} cannot be compared with {right:?}");
            return Err(Fault::new(Status::INTP_TYPE, message));
        }
    };
    Ok(super::arithmetic::holds(relation, order))
}
