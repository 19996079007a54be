//! Motion instructions: `J PR[1] R[2]% FINE`, `L P[3:place] 250mm/sec CNT50 ACC80`.

use super::{
    Motion, MotionTarget, Operand, SpeedUnit,
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
        } else {
            return Err(self.unsupported("a motion on an arc"));
        };
        let mut taught = None;
        let target = if self.eat_word("PR") {
            self.index()?
        } else {
            self.expect("P")?;
            let index = self.index()?;
            match index {
                super::Index::Fixed(number) => taught = Some(number),
                super::Index::Register(_) => {
                    return Err(self.unsupported("a position whose number is in a register"));
                }
            }
            index
        };
        let speed = self.operand()?;
        let unit = self.unit(interpolation)?;
        self.termination()?;
        let mut acceleration = None;
        if self.eat("ACC") {
            acceleration = Some(self.operand()?);
        }
        if !self.at_end() {
            return Err(self.unsupported("this option of a motion"));
        }
        let motion = Motion {
            interpolation,
            target: MotionTarget::Register(target),
            speed,
            unit,
            acceleration,
        };
        Ok(Line::Move(motion, taught))
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
            return match self.operand()? {
                Operand::Integer(0..=100) | Operand::Number(_) => Ok(()),
                _ => Err(self.wrong(0, "CNT is 0 to 100")),
            };
        }
        Err(self.expected("FINE or CNT"))
    }
}
