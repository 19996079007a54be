//! The `/POS` section: positions that were taught.

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

use super::{
    Taught,
    scan::{Scanned, Scanner},
};
use crate::{
    diagnostic::Reports,
    host::TpTarget,
    position::{Config, JointPosition, XyzwprExt},
    span::{Span, latin1},
};

/// Reads positions up to the end of `bytes`, which start at `start` of the file.
pub(super) fn positions(
    bytes: &[u8],
    start: usize,
    reports: &mut Reports,
) -> BTreeMap<i32, Arc<Taught>> {
    let mut found = BTreeMap::new();
    let mut numbers = BTreeSet::new();
    let mut scanner = Scanner::new(bytes, start, reports);
    while !scanner.at_end() {
        let Ok((number, taught)) = scanner.position() else {
            break;
        };
        if !numbers.insert(number) {
            let message = format!("P[{number}] is there twice");
            scanner.reports.error(Span::new(start, start + 1), message);
        }
        if let Some(taught) = taught {
            let _none = found.insert(number, Arc::new(taught));
        }
    }
    found
}

impl Scanner<'_> {
    /// `P[1:"comment"]{ GP1: UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0', X = 1.0 mm, .. };`. One that was never
    /// taught has stars instead of numbers, and is `None`.
    fn position(&mut self) -> Scanned<(i32, Option<Taught>)> {
        self.expect("P")?;
        self.expect("[")?;
        let number = self.integer("a position's number")?;
        let _comment = self.rest_of_bracket()?;
        self.expect("{")?;
        if self.sees("GP") && !self.sees("GP1:") {
            self.skip_groups()?;
            return Ok((number, None));
        }
        self.expect("GP1:")?;
        self.expect("UF")?;
        let frame = self.frame_number()?;
        self.expect(",")?;
        self.expect("UT")?;
        let tool = self.frame_number()?;
        let _comma = self.eat(",");
        let target = if self.eat("CONFIG") {
            self.expect(":")?;
            self.expect("'")?;
            let from = self.here();
            let text = latin1(self.up_to(b'\'')?);
            let Some(config) = Config::parse(&text) else {
                return Err(self.wrong(from, format!("'{text}' is not a configuration")));
            };
            let _comma = self.eat(",");
            let place = self.values(["X", "Y", "Z"], "mm")?;
            let turn = self.values(["W", "P", "R"], "deg")?;
            place.zip(turn).map(|([x, y, z], [w, p, r])| {
                TpTarget::Cartesian(XyzwprExt {
                    x,
                    y,
                    z,
                    w,
                    p,
                    r,
                    config,
                    ext: [0.0; 3],
                })
            })
        } else {
            let axes = self.values(["J1", "J2", "J3", "J4", "J5", "J6"], "deg")?;
            axes.map(|axes| {
                TpTarget::Joints(JointPosition {
                    axes: axes.to_vec(),
                })
            })
        };
        if self.sees("GP") || self.sees("E1") {
            self.skip_groups()?;
        } else {
            self.expect("}")?;
            self.expect(";")?;
        }
        let taught = target.map(|target| Taught {
            number,
            frame,
            tool,
            target,
        });
        Ok((number, taught))
    }

    /// Axes beyond six and groups beyond the first, to the end of the position.
    ///
    /// ASSUMPTION: this arm moves as if they were not there.
    fn skip_groups(&mut self) -> Scanned<()> {
        let from = self.here();
        while !self.eat("}") {
            self.up_to_any(b"\n}")?;
        }
        self.suspicious(
            from,
            "other groups, and axes beyond six, are left out: this arm has six",
        );
        self.expect(";")
    }

    /// `: 3`, or `: F` for whatever is active.
    fn frame_number(&mut self) -> Scanned<Option<i32>> {
        self.expect(":")?;
        if self.eat_word("F") {
            return Ok(None);
        }
        self.integer("a frame's number").map(Some)
    }

    /// `X = 600.000 mm, Y = ..`; `None` with `X = ********  mm`.
    fn values<const N: usize>(
        &mut self,
        names: [&str; N],
        unit: &str,
    ) -> Scanned<Option<[f32; N]>> {
        let mut values = [0.0; N];
        let mut is_taught = true;
        for (name, value) in names.into_iter().zip(&mut values) {
            self.expect(name)?;
            self.expect("=")?;
            let from = self.here();
            if self.eat("*") {
                while self.eat("*") {}
                is_taught = false;
                self.expect(unit)?;
                let _comma = self.eat(",");
                continue;
            }
            let text = self.number("a number")?;
            *value = match text.parse::<f32>() {
                Ok(number) if number.is_finite() => number,
                Ok(_) | Err(_) => return Err(self.wrong(from, format!("`{text}` is not a number"))),
            };
            self.expect(unit)?;
            let _comma = self.eat(",");
        }
        Ok(is_taught.then_some(values))
    }
}
