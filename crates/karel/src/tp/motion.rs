//! Motion instructions: `J PR[1] R[2]% FINE`, `L P[3:place] 250mm/sec CNT50 ACC80`.

use super::{
    Index, Motion, MotionTarget, Operand, Shift, SpeedUnit,
    instruction::Line,
    scan::{Scanned, Scanner},
};
use crate::host::Interpolation;

impl Scanner<'_> {
    /// Whether the line starts with `J P`, `L P` or `C P`.
    pub(super) fn motion_follows(&mut self) -> bool {
        ["J P", "L P", "C P", "A P"]
            .into_iter()
            .any(|start| self.sees(start))
    }

    pub(super) fn motion(&mut self) -> Scanned<Line> {
        let interpolation = if self.eat_word("J") {
            Interpolation::Joint
        } else if self.eat_word("L") {
            Interpolation::Linear
        } else if self.eat_word("C") {
            Interpolation::Circular
        } else {
            return Err(self.unsupported("a motion of arcs (A)"));
        };
        let first = self.place_to_go()?;
        let (via, target) = if interpolation == Interpolation::Circular {
            (Some(first), self.place_to_go()?)
        } else {
            (None, first)
        };
        let speed = self.operand()?;
        let unit = self.unit(interpolation)?;
        self.termination()?;
        let mut motion = Motion {
            interpolation,
            via: via.map(|(via, _)| MotionTarget::Register(via)),
            target: MotionTarget::Register(target.0),
            speed,
            unit,
            acceleration: None,
            offset: Shift::No,
            tool_offset: Shift::No,
            skip: None,
        };
        let mut skip = None;
        while !self.at_end() {
            let _comma = self.eat(",");
            if self.eat("ACC") {
                motion.acceleration = Some(self.operand()?);
            } else if self.eat_word("Tool_Offset") {
                motion.tool_offset = self.shift()?;
            } else if self.eat_word("Offset") {
                motion.offset = self.shift()?;
            } else if self.eat_word("Skip") {
                self.expect(",")?;
                skip = Some(self.label()?);
            } else if !self.eat_word("PTH") {
                return Err(self.unsupported("this option of a motion"));
            }
        }
        Ok(Line::Move {
            motion,
            target: target.1,
            via: via.and_then(|(_, taught)| taught),
            skip,
        })
    }

    /// `Offset`, `Offset,PR[3]`.
    fn shift(&mut self) -> Scanned<Shift> {
        if self.eat(",PR") {
            return self.index().map(Shift::Register);
        }
        Ok(Shift::Condition)
    }

    /// `PR[1]`, `P[3:place]`: the number of the register, or of the taught position twice.
    fn place_to_go(&mut self) -> Scanned<(Index, Option<i32>)> {
        if self.eat_word("PR") {
            return Ok((self.index()?, None));
        }
        self.expect("P")?;
        match self.index()? {
            index @ Index::Fixed(number) => Ok((index, Some(number))),
            Index::Register(_) | Index::Argument(_) => {
                Err(self.unsupported("a position whose number is in a register"))
            }
        }
    }

    fn unit(&mut self, interpolation: Interpolation) -> Scanned<SpeedUnit> {
        let units = [
            ("%", SpeedUnit::Percent),
            ("mm/sec", SpeedUnit::MmPerSec),
            ("cm/min", SpeedUnit::CmPerMin),
        ];
        for other in ["deg/sec", "sec", "msec", "inch/min"] {
            if self.eat_word(other) {
                return Err(self.unsupported(&format!("a speed in {other}")));
            }
        }
        let found = units.into_iter().find(|(text, _)| self.eat(text));
        let Some((text, unit)) = found else {
            return Err(self.expected("`%`, `mm/sec` or `cm/min`"));
        };
        let fits = (unit == SpeedUnit::Percent) == (interpolation == Interpolation::Joint);
        if !fits {
            let letter = match interpolation {
                Interpolation::Joint => "J",
                Interpolation::Linear => "L",
                Interpolation::Circular => "C",
            };
            return Err(self.wrong(0, format!("a motion {letter} has no speed in {text}")));
        }
        Ok(unit)
    }

    /// `FINE`, `CNT50`, `CNT R[3]`.
    ///
    /// ASSUMPTION: every motion of this version ends at a standstill, as if it were FINE.
    fn termination(&mut self) -> Scanned<()> {
        if self.eat_word("FINE") {
            return Ok(());
        }
        if self.eat("CNT") {
            let rounding = self.operand()?;
            if matches!(rounding, Operand::Integer(0..=100) | Operand::Number(_)) {
                return Ok(());
            }
            return Err(self.wrong(0, "CNT is 0 to 100"));
        }
        Err(self.expected("FINE or CNT"))
    }
}
