//! Motion instructions: `J PR[1] R[2]% FINE`, `L P[3:place] 250mm/sec CNT50 ACC80`.

use super::{
    Beside, BesideWhen, Branch, Index, Instruction, Motion, MotionTarget, Operand, Shift, Speed,
    SpeedUnit, Wrist,
    instruction::{Line, Then},
    scan::{Scanned, Scanner},
};
use crate::host::Interpolation;

impl Scanner<'_> {
    /// Whether the line starts with `J P`, `L P`, `C P` or `A P`.
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
            self.expect("A")?;
            Interpolation::CircleArc
        };
        let first = self.place_to_go()?;
        let (via, target) = if interpolation == Interpolation::Circular {
            (Some(first), self.place_to_go()?)
        } else {
            (None, first)
        };
        let speed = self.speed(interpolation)?;
        let rounding = self.termination()?;
        let mut motion = Motion {
            interpolation,
            via: via.map(|(via, _)| MotionTarget::Register(via)),
            target: MotionTarget::Register(target.0),
            speed,
            rounding,
            acceleration: None,
            offset: Shift::No,
            tool_offset: Shift::No,
            incremental: false,
            wrist: Wrist::AsTaught,
            skip: None,
            skip_jumps: false,
            skip_keeps: None,
            beside: None,
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
            } else if self.eat_word("INC") {
                motion.incremental = true;
            } else if self.eat_word("Wjnt") {
                if interpolation == Interpolation::Joint {
                    return Err(self.wrong(0, "a motion J has no Wjnt"));
                }
                motion.wrist = Wrist::AsJoints;
            } else if self.eat_word("MROT") {
                if interpolation != Interpolation::Joint {
                    return Err(self.wrong(0, "only a motion J has MROT"));
                }
                motion.wrist = Wrist::LeastRotation;
            } else if self.eat("AP_LD") || self.eat("RT_LD") {
                // ASSUMPTION: the way is straight near its ends anyhow, up to the corner that CNT rounds.
                let _distance = self.operand()?;
            } else if let Some(beside) = self.beside()? {
                motion.beside = Some(beside);
            } else if let Some(absent) = self.absent_option() {
                return Ok(Line::Done(Instruction::Absent(absent)));
            } else if self.eat_word("SkipJump") {
                self.expect(",")?;
                skip = Some(self.label()?);
                motion.skip_jumps = true;
            } else if self.eat_word("Skip") {
                self.expect(",")?;
                skip = Some(self.label()?);
                motion.skip_keeps = self.kept_position()?;
            } else if !self.eat_word("PTH") {
                return Err(self.expected("an option of a motion"));
            }
        }
        if motion.incremental
            && matches!(
                &motion.beside,
                Some(Beside {
                    when: BesideWhen::Near(_),
                    ..
                })
            )
        {
            return Err(self.unsupported("DB together with INC"));
        }
        if motion.incremental && interpolation == Interpolation::CircleArc {
            return Err(self.unsupported("A together with INC"));
        }
        Ok(Line::Move {
            motion: Box::new(motion),
            target: target.1,
            via: via.and_then(|(_, taught)| taught),
            skip,
        })
    }

    /// `TB .70sec,CALL PROGRAM`, `DB 10.0mm,DO[1]=ON`.
    fn beside(&mut self) -> Scanned<Option<Beside>> {
        let (when, unit): (fn(Operand) -> BesideWhen, _) =
            if self.eat_word("TA") || self.eat_word("TIME AFTER") {
                (BesideWhen::After, "sec")
            } else if self.eat_word("TB") || self.eat_word("TIME BEFORE") {
                (BesideWhen::Before, "sec")
            } else if self.eat_word("DB") {
                (BesideWhen::Near, "mm")
            } else {
                return Ok(None);
            };
        let when = when(self.operand()?);
        self.expect(unit)?;
        let comma = self.eat(",");
        if !comma && !self.sees("CALL") {
            return Err(self.expected("`,`"));
        }
        let action = match self.then()? {
            Then::Call(call) => Branch::Call(call),
            Then::Assign(place, value) => Branch::Assign(place, value),
            Then::Pulse(port, index, width) => Branch::Pulse(port, index, width),
            Then::Jump(_) => return Err(self.wrong(0, "TA, TB and DB call or assign")),
        };
        Ok(Some(Beside { when, action }))
    }

    /// `,PR[2]=LPOS` behind `Skip,LBL[1]`.
    fn kept_position(&mut self) -> Scanned<Option<(Index, Operand)>> {
        if !self.eat(",PR") {
            return Ok(None);
        }
        let register = self.index()?;
        self.expect("=")?;
        if self.eat_word("LPOS") {
            return Ok(Some((register, Operand::LinearPosition)));
        }
        if self.eat_word("JPOS") {
            return Ok(Some((register, Operand::JointPosition)));
        }
        Err(self.expected("LPOS or JPOS"))
    }

    /// `Offset`, `Offset,PR[3]`.
    fn shift(&mut self) -> Scanned<Shift> {
        if self.eat(",PR") {
            return self.index().map(Shift::Register);
        }
        Ok(Shift::Condition)
    }

    /// `PR[1]`, `P[3:place]`, `P[R[1]]`: the register, or that number in the `/POS` section.
    fn place_to_go(&mut self) -> Scanned<(Index, Option<Index>)> {
        if self.eat_word("PR") {
            return Ok((self.index()?, None));
        }
        self.expect("P")?;
        let index = self.index()?;
        Ok((index, Some(index)))
    }

    /// `50%`, `R[1]mm/sec`, `max_speed`.
    fn speed(&mut self, interpolation: Interpolation) -> Scanned<Speed> {
        if self.eat_word("max_speed") {
            if interpolation == Interpolation::Joint {
                return Err(self.wrong(0, "a motion J has no max_speed, it is 100%"));
            }
            return Ok(Speed::Greatest);
        }
        let speed = self.operand()?;
        Ok(Speed::Of(speed, self.unit(interpolation)?))
    }

    fn unit(&mut self, interpolation: Interpolation) -> Scanned<SpeedUnit> {
        let units = [
            ("%", SpeedUnit::Percent),
            ("mm/sec", SpeedUnit::MmPerSec),
            ("cm/min", SpeedUnit::CmPerMin),
            ("inch/min", SpeedUnit::InchPerMin),
            ("deg/sec", SpeedUnit::DegPerSec),
            ("msec", SpeedUnit::Milliseconds),
            ("sec", SpeedUnit::Seconds),
        ];
        let found = units.into_iter().find(|(text, _)| self.eat(text));
        let Some((text, unit)) = found else {
            let what = "`%`, `mm/sec`, `cm/min`, `inch/min`, `deg/sec`, `sec` or `msec`";
            return Err(self.expected(what));
        };
        let fits = match unit {
            SpeedUnit::Percent => interpolation == Interpolation::Joint,
            SpeedUnit::Seconds | SpeedUnit::Milliseconds => true,
            SpeedUnit::MmPerSec
            | SpeedUnit::CmPerMin
            | SpeedUnit::InchPerMin
            | SpeedUnit::DegPerSec => interpolation != Interpolation::Joint,
        };
        if !fits {
            let letter = match interpolation {
                Interpolation::Joint => "J",
                Interpolation::Linear => "L",
                Interpolation::Circular => "C",
                Interpolation::CircleArc => "A",
            };
            return Err(self.wrong(0, format!("a motion {letter} has no speed in {text}")));
        }
        Ok(unit)
    }

    /// `FINE`, `CNT50`, `CNT R[3]`.
    fn termination(&mut self) -> Scanned<Option<Operand>> {
        if self.eat_word("FINE") {
            return Ok(None);
        }
        if self.eat("CNT") {
            let rounding = self.operand()?;
            if matches!(
                rounding,
                Operand::Integer(0..=100) | Operand::Number(_) | Operand::Argument(_)
            ) {
                return Ok(Some(rounding));
            }
            return Err(self.wrong(0, "CNT is 0 to 100"));
        }
        Err(self.expected("FINE or CNT"))
    }
}
