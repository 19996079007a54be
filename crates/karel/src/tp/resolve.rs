//! Labels and blocks become instructions, numbers of positions their values.

use std::{collections::BTreeMap, sync::Arc};

use super::{
    Branch, ForHead, Goal, Index, Instruction, Labels, Motion, MotionTarget, Positions,
    instruction::{Line, Then},
};
use crate::{diagnostic::Reports, host::Interpolation, span::Span};

/// What a block has at its end, or in its middle.
#[derive(Default)]
struct Blocks {
    /// Of an IF, an ELSE and a FOR: the instruction to go on with. Of an ENDFOR: its FOR.
    to: BTreeMap<u32, u32>,
    heads: BTreeMap<u32, ForHead>,
}

pub(super) fn resolve(
    lines: Vec<(Line, Span)>,
    taught: Positions,
    reports: &mut Reports,
) -> Vec<Instruction> {
    let mut labels = BTreeMap::new();
    for (at, (line, span)) in (0_u32..).zip(&lines) {
        if let Line::Label(label) = line
            && labels.insert(*label, at).is_some()
        {
            reports.error(*span, format!("LBL[{label}] is there twice"));
        }
    }
    let blocks = match_blocks(&lines, reports);
    let selects = ends_of_selects(&lines);
    let mut resolver = Resolver {
        labels: Arc::new(labels),
        taught: Arc::new(taught),
        reports,
    };
    let mut resolved = Vec::with_capacity(lines.len());
    for (at, (line, span)) in (0_u32..).zip(lines) {
        let to = blocks.to.get(&at).copied().unwrap_or(at);
        let instruction = match line {
            Line::Label(_) | Line::EndIf => Instruction::Nothing,
            Line::Jump(label) => Instruction::Goto(resolver.label(label, span)),
            Line::If(condition, then) => Instruction::If {
                condition,
                then: resolver.then(then, span),
            },
            Line::IfThen(condition) => Instruction::Unless { condition, to },
            Line::Else => Instruction::Jump(to),
            Line::For(head) => Instruction::For { head, behind: to },
            Line::EndFor => match blocks.heads.get(&at) {
                Some(head) => Instruction::EndFor {
                    head: head.clone(),
                    again: to,
                },
                None => Instruction::Nothing,
            },
            Line::Case {
                condition, then, ..
            } => Instruction::Case {
                condition,
                then: resolver.then(then, span),
                behind: selects.get(&at).copied().unwrap_or(at),
            },
            Line::WaitFor(condition, timeout) => Instruction::WaitFor {
                condition,
                timeout: timeout.map(|label| resolver.label(label, span)),
            },
            Line::Done(instruction) => instruction,
            Line::Move {
                mut motion,
                target,
                via,
                skip,
            } => {
                if let Some(n) = target {
                    motion.target = resolver.position(n, span);
                }
                if let Some(n) = via {
                    motion.via = Some(resolver.position(n, span));
                }
                motion.skip = skip.map(|label| resolver.label(label, span));
                Instruction::Move(motion)
            }
        };
        resolved.push(instruction);
    }
    complete_arcs(&mut resolved);
    resolved
}

/// Each `A` names one place: three of them, one after the other, make a circle.
///
/// ASSUMPTION: the way to the first one is straight; that to the second is on the circle through the first three, that to
/// each later one on the circle through it and the two before. Two alone are straight lines. What is between them and is
/// no motion does not matter.
fn complete_arcs(instructions: &mut [Instruction]) {
    let mut moves: Vec<&mut Motion> = Vec::new();
    for instruction in instructions {
        if let Instruction::Move(motion) = instruction {
            moves.push(motion);
        }
    }
    let places: Vec<Option<MotionTarget>> = moves
        .iter()
        .map(|motion| {
            let is_arc = motion.interpolation == Interpolation::CircleArc;
            is_arc.then(|| motion.target.clone())
        })
        .collect();
    let place = |at: Option<usize>| places.get(at?)?.clone();
    for (at, motion) in moves.iter_mut().enumerate() {
        if place(Some(at)).is_none() {
            continue;
        }
        let before = |by: usize| place(at.checked_sub(by));
        motion.via = match (before(2), before(1), place(Some(at + 1))) {
            (_, None, _) | (None, Some(_), None) => None,
            (Some(third), Some(_), _) | (None, Some(_), Some(third)) => Some(third),
        };
        if motion.via.is_none() {
            motion.interpolation = Interpolation::Linear;
        }
    }
}

struct Resolver<'a> {
    labels: Arc<Labels>,
    taught: Arc<Positions>,
    reports: &'a mut Reports,
}

impl Resolver<'_> {
    /// A label that is not there is found by who goes there: programs of the field have such lines.
    fn label(&mut self, label: Index, span: Span) -> Goal {
        let Index::Fixed(number) = label else {
            return Goal::By(label, self.labels.clone());
        };
        if let Some(at) = self.labels.get(&number) {
            return Goal::At(*at);
        }
        let message = format!("there is no LBL[{number}]");
        self.reports.warning(span, message);
        Goal::Missing(number)
    }

    fn then(&mut self, then: Then, span: Span) -> Branch {
        match then {
            Then::Jump(label) => Branch::Jump(self.label(label, span)),
            Then::Call(call) => Branch::Call(call),
            Then::Assign(place, value) => Branch::Assign(place, value),
            Then::Pulse(port, index, width) => Branch::Pulse(port, index, width),
        }
    }

    fn position(&mut self, index: Index, span: Span) -> MotionTarget {
        let Index::Fixed(number) = index else {
            return MotionTarget::TaughtBy(index, self.taught.clone());
        };
        if let Some(taught) = self.taught.get(&number) {
            return MotionTarget::Taught(taught.clone());
        }
        // Who goes there finds out, unless a program has taught it until then.
        let message = format!("P[{number}] was not taught");
        self.reports.warning(span, message);
        MotionTarget::TaughtBy(index, self.taught.clone())
    }
}

/// Behind the last case of the SELECT that a case belongs to.
fn ends_of_selects(lines: &[(Line, Span)]) -> BTreeMap<u32, u32> {
    let mut ends = BTreeMap::new();
    let mut end = 0;
    let numbered: Vec<(u32, &(Line, Span))> = (0_u32..).zip(lines).collect();
    for (at, (line, _)) in numbered.into_iter().rev() {
        if let Line::Case { is_first, .. } = line {
            if end == 0 {
                end = at + 1;
            }
            let _none = ends.insert(at, end);
            if *is_first {
                end = 0;
            }
        }
    }
    ends
}

fn match_blocks(lines: &[(Line, Span)], reports: &mut Reports) -> Blocks {
    enum Open<'a> {
        If,
        Else,
        For(&'a ForHead),
    }
    let mut blocks = Blocks::default();
    let mut open: Vec<(Open<'_>, u32, Span)> = Vec::new();
    for (at, (line, span)) in (0_u32..).zip(lines) {
        match line {
            Line::IfThen(_) => open.push((Open::If, at, *span)),
            Line::For(head) => open.push((Open::For(head), at, *span)),
            Line::Else => match open.pop() {
                Some((Open::If, begin, _)) => {
                    let _none = blocks.to.insert(begin, at + 1);
                    open.push((Open::Else, at, *span));
                }
                _ => reports.error(*span, "ELSE without IF .. THEN"),
            },
            Line::EndIf => match open.pop() {
                Some((Open::If | Open::Else, begin, _)) => {
                    let _none = blocks.to.insert(begin, at + 1);
                }
                _ => reports.error(*span, "ENDIF without IF .. THEN"),
            },
            Line::EndFor => match open.pop() {
                Some((Open::For(head), begin, _)) => {
                    let _none = blocks.to.insert(begin, at + 1);
                    let _none = blocks.to.insert(at, begin + 1);
                    let _none = blocks.heads.insert(at, head.clone());
                }
                _ => reports.error(*span, "ENDFOR without FOR"),
            },
            Line::Label(_)
            | Line::Jump(_)
            | Line::If(..)
            | Line::Case { .. }
            | Line::WaitFor(..)
            | Line::Done(_)
            | Line::Move { .. } => {}
        }
    }
    for (_, _, span) in open {
        reports.error(span, "the block has no end");
    }
    blocks
}
