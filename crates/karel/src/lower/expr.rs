//! Expressions and calls.

use super::{Lowering, add_row, count};
use crate::{
    ast::Relation,
    ir::{BuiltinSite, Op, Outward, Rare},
    typed::{
        Arg, BuiltinCall, Call, Callee, Constant, Expr, ExprKind, Op as BinaryOp, SystemPlace,
    },
    types::{TextLength, Type},
    value::Text,
};

impl Lowering<'_> {
    /// Pushes a value: a scalar itself, anything larger as the address of its first cell.
    pub(super) fn value(&mut self, expr: &Expr) {
        if expr.ty.is_scalar() {
            self.scalar(expr);
        } else {
            self.aggregate(expr);
        }
    }

    pub(super) fn scalar(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Constant(constant) => self.constant(constant),
            ExprKind::Place(place) => self.load(place),
            ExprKind::System(place) => {
                let row = self.system(place);
                self.emit(Op::Outward(Outward::LoadSystem(row)));
            }
            ExprKind::Port(place) => {
                self.scalar(&place.number);
                self.emit(Op::Outward(Outward::LoadPort(place.port)));
            }
            ExprKind::Call(call) => self.call(call),
            ExprKind::Builtin(call) => self.builtin(call),
            ExprKind::Negate(operand) => {
                self.scalar(operand);
                let integer = operand.ty == Type::Integer;
                self.emit(if integer {
                    Op::Rare(Rare::NegateInteger)
                } else {
                    Op::Rare(Rare::NegateReal)
                });
            }
            ExprKind::Not(operand) => {
                self.scalar(operand);
                let integer = operand.ty == Type::Integer;
                self.emit(if integer {
                    Op::Rare(Rare::NotInteger)
                } else {
                    Op::Rare(Rare::NotBoolean)
                });
            }
            ExprKind::Binary { op, left, right } => {
                self.scalar(left);
                self.scalar(right);
                self.emit(binary_op(*op, &left.ty));
            }
            ExprKind::ToReal(operand) => {
                self.scalar(operand);
                self.emit(Op::IntegerToReal);
            }
            ExprKind::ToPosition(_) | ExprKind::ToJoints(_) => self.aggregate(expr),
        }
    }

    fn constant(&mut self, constant: &Constant) {
        let op = match constant {
            Constant::Integer(value) => Op::PushInteger(*value),
            Constant::Real(value) => Op::PushReal(*value),
            Constant::Boolean(value) => Op::PushBoolean(*value),
            Constant::Text(text) => Op::PushText(self.text(text)),
        };
        self.emit(op);
    }

    fn text(&mut self, text: &Text) -> u32 {
        if let Some(row) = self.texts.get(text.as_bytes()) {
            return *row;
        }
        let row = add_row(&mut self.code.texts, text.clone());
        let _ = self.texts.insert(text.as_bytes().to_vec(), row);
        row
    }

    /// Pushes the address of a value of several cells; of a temporary if it has no place.
    fn aggregate(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Place(place) => self.reference(place),
            ExprKind::System(place) => {
                let temp = self.temporary(expr.ty.size());
                self.emit(Op::AddressLocal(temp));
                let row = self.system(place);
                self.emit(Op::Outward(Outward::LoadSystem(row)));
                self.emit(Op::AddressLocal(temp));
            }
            ExprKind::Call(call) => {
                let temp = self.temporary(expr.ty.size());
                self.emit(Op::AddressLocal(temp));
                self.call(call);
                self.emit(Op::AddressLocal(temp));
            }
            ExprKind::Builtin(call) => {
                let temp = self.temporary(expr.ty.size());
                self.emit(Op::AddressLocal(temp));
                self.builtin(call);
                self.emit(Op::AddressLocal(temp));
            }
            ExprKind::ToJoints(inner) => {
                let temp = self.temporary(expr.ty.size());
                self.emit(Op::AddressLocal(temp));
                self.copy_joints(inner, &expr.ty);
                self.emit(Op::AddressLocal(temp));
            }
            ExprKind::ToPosition(inner) => {
                let temp = self.temporary(expr.ty.size());
                self.emit(Op::AddressLocal(temp));
                self.copy_position(inner, &expr.ty);
                self.emit(Op::AddressLocal(temp));
            }
            ExprKind::Constant(_)
            | ExprKind::Port(_)
            | ExprKind::Negate(_)
            | ExprKind::Not(_)
            | ExprKind::Binary { .. }
            | ExprKind::ToReal(_) => self.scalar(expr),
        }
    }

    /// Copies `source` to the address on the stack, which holds a value of type `target`.
    pub(super) fn copy_to_address(&mut self, source: &Expr, target: &Type) {
        match (&source.kind, target) {
            (ExprKind::ToPosition(inner), Type::Position(_)) => self.copy_position(inner, target),
            (_, Type::Position(_)) => self.copy_position(source, target),
            (ExprKind::ToJoints(inner), _) => self.copy_joints(inner, target),
            _ => {
                self.value(source);
                self.emit(Op::Rare(Rare::CopyCells(target.size())));
            }
        }
    }

    fn copy_joints(&mut self, source: &Expr, target: &Type) {
        self.aggregate(source);
        self.emit(Op::Rare(Rare::CopyJoints {
            from: source.ty.size(),
            to: target.size(),
        }));
    }

    fn copy_position(&mut self, source: &Expr, target: &Type) {
        self.aggregate(source);
        let kind = |ty: &Type| {
            ty.position_kind()
                .expect("the checker converts only positions")
        };
        self.emit(Op::Rare(Rare::CopyPosition {
            from: kind(&source.ty),
            to: kind(target),
            // A built-in that fails has a status for it, and no position.
            may_lack: matches!(source.kind, ExprKind::Builtin(_)),
        }));
    }

    /// The arguments of a call, then the call. The address for a result of several cells, if
    /// there is one, was pushed before.
    pub(super) fn call(&mut self, call: &Call) {
        for arg in &call.args {
            self.argument(arg);
        }
        if self.in_actions {
            self.emit(Op::Outward(Outward::ActionGate));
        }
        self.emit(match call.callee {
            Callee::Here(routine) => Op::Call(routine),
            Callee::External(row) => Op::Outward(Outward::CallExternal(row)),
        });
    }

    pub(super) fn builtin(&mut self, call: &BuiltinCall) {
        let mut outputs: Vec<(u32, &SystemPlace)> = Vec::new();
        for arg in &call.args {
            if let Arg::System(place) = arg {
                outputs.push((self.system_output(place), place));
            } else {
                self.argument(arg);
            }
        }
        let result_in_memory = call
            .result
            .as_ref()
            .is_some_and(|result| !result.is_scalar());
        let site = BuiltinSite {
            builtin: call.builtin,
            types: call.types.clone(),
            operands: count(call.args.len()) + u32::from(result_in_memory),
            result_in_memory,
        };
        let row = add_row(&mut self.code.builtins, site);
        self.emit(Op::Outward(Outward::Builtin(row)));
        for (temp, place) in outputs {
            self.emit(Op::AddressLocal(temp));
            let row = self.system(place);
            self.emit(Op::Outward(Outward::ReturnSystem(row)));
        }
    }

    /// A system variable as an output: a temporary with its value, whose address is pushed.
    fn system_output(&mut self, place: &SystemPlace) -> u32 {
        let temp = self.temporary(place.ty.size());
        self.emit(Op::AddressLocal(temp));
        let row = self.system(place);
        self.emit(Op::Outward(Outward::FetchSystem(row)));
        self.emit(Op::AddressLocal(temp));
        if let Type::Text(TextLength::AtMost(length)) = place.ty {
            self.emit(Op::Extra(length));
        }
        temp
    }

    fn argument(&mut self, arg: &Arg) {
        match arg {
            Arg::Reference(place) => self.reference(place),
            Arg::OpenArray { place, lengths } => {
                self.address(place);
                self.emit(Op::Extra(*lengths));
            }
            Arg::ByName {
                program,
                variable,
                formal,
            } => {
                self.scalar(program);
                self.scalar(variable);
                let row = add_row(&mut self.code.types, formal.clone());
                self.emit(Op::Outward(Outward::ByName(row)));
            }
            Arg::Copy { value, formal } => self.copied_argument(value, formal),
            Arg::Value(value) => self.value(value),
            Arg::Discard | Arg::System(_) => self.emit(Op::PushDiscard),
        }
    }

    /// Puts a copy of the value into a temporary and pushes its address.
    fn copied_argument(&mut self, value: &Expr, formal: &Type) {
        let temp = self.temporary(formal.size());
        if formal.is_scalar() {
            self.scalar(value);
            if let Type::Text(TextLength::AtMost(length)) = formal {
                self.emit(Op::Truncate(*length));
            }
            self.emit(Op::StoreLocal(temp));
        } else {
            self.emit(Op::AddressLocal(temp));
            self.copy_to_address(value, formal);
        }
        self.emit(Op::AddressLocal(temp));
        let most = count(crate::types::MAX_STRING);
        let any = (*formal == Type::TEXT).then_some(most);
        if let Some(length) = formal.length().or(any) {
            self.emit(Op::Extra(length));
        }
    }
}

fn binary_op(op: BinaryOp, operands: &Type) -> Op {
    let integer = *operands == Type::Integer;
    match op {
        BinaryOp::Add => pick(integer, Op::AddInteger, Op::AddReal),
        BinaryOp::Subtract => pick(integer, Op::SubtractInteger, Op::SubtractReal),
        BinaryOp::Multiply => pick(integer, Op::MultiplyInteger, Op::MultiplyReal),
        BinaryOp::Divide => Op::DivideReal,
        BinaryOp::Div => Op::DivInteger,
        BinaryOp::Mod => Op::ModInteger,
        BinaryOp::And => pick(integer, Op::AndInteger, Op::AndBoolean),
        BinaryOp::Or => pick(integer, Op::OrInteger, Op::OrBoolean),
        BinaryOp::Concatenate => Op::Rare(Rare::Concatenate),
        BinaryOp::Relation(relation) => comparison(relation, operands),
    }
}

fn pick(first: bool, yes: Op, no: Op) -> Op {
    if first { yes } else { no }
}

fn comparison(relation: Relation, operands: &Type) -> Op {
    match operands {
        Type::Real => Op::CompareReal(relation),
        Type::Text(_) => Op::Rare(Rare::CompareText(relation)),
        Type::Boolean => Op::Rare(Rare::CompareBoolean(relation)),
        Type::Integer
        | Type::Small(_)
        | Type::File
        | Type::Config
        | Type::Position(_)
        | Type::Joints(_)
        | Type::Array(_)
        | Type::Structure(_)
        | Type::Path(_)
        | Type::Error => Op::CompareInteger(relation),
    }
}
