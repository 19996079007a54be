//! Instructions and options of motions that need what this controller does not have.
//!
//! A listing that has one is loaded with a warning, so that the rest of a cell's programs can be tried; who comes to the
//! line gets the same error as who calls a built-in of an option that is not there.

use super::{
    Absent,
    scan::{Scanned, Scanner},
};

const VISION: &str = "iRVision";
const ARC: &str = "arc welding (ArcTool)";
const SPOT: &str = "spot welding (SpotTool)";
const SEALING: &str = "dispensing (DispenseTool)";
const TOUCH: &str = "touch sensing";
const SEAM: &str = "seam tracking";
const LINE: &str = "line tracking";
const PALLETS: &str = "the palletizing option";
const SENSORS: &str = "the sensor interface";
const RECOVERY: &str = "the error recovery option";
const CALIBRATION: &str = "cell calibration";
const GROUPS: &str = "more than one motion group";
const AXES: &str = "extended axes";
const FORCE: &str = "a force sensor";
const LIMITS: &str = "speed limits of a program, which are not simulated";
const PATHS: &str = "the constant path option";

/// How a line begins, and what it needs.
///
/// ASSUMPTION: names of options as their users write them.
const INSTRUCTIONS: &[(&str, &str)] = &[
    ("VISION", VISION),
    ("LOCK VREG", VISION),
    ("UNLOCK VREG", VISION),
    ("Arc Start", ARC),
    ("Arc End", ARC),
    ("Weld Start", ARC),
    ("Weld End", ARC),
    ("Weave", ARC),
    ("SPOT[", SPOT),
    ("Seal Start", SEALING),
    ("Seal End", SEALING),
    ("Search Start", TOUCH),
    ("Search End", TOUCH),
    ("Touch Offset", TOUCH),
    ("Touch Ofst", TOUCH),
    ("Track TAST", SEAM),
    ("Track End", SEAM),
    ("LINE[", LINE),
    ("LINECOUNT[", LINE),
    ("SETLINE[", LINE),
    ("SETTRIG", LINE),
    ("SELBOUND", LINE),
    ("STOP_TRACKING", LINE),
    ("DEFENC", LINE),
    ("PALLETIZING-", PALLETS),
    ("PL[", PALLETS),
    ("SEND R[", SENSORS),
    ("RCV R[", SENSORS),
    ("ERROR_PROG", RECOVERY),
    ("RESUME_PROG", RECOVERY),
    ("MAINT_PROG", RECOVERY),
    ("RETURN_PATH_DSBL", RECOVERY),
    ("UFrame_Start[", CALIBRATION),
    ("UFrame_End[", CALIBRATION),
    ("Detect_Point[", CALIBRATION),
    ("FORCE CTRL[", FORCE),
    ("JOINT_MAX_SPEED[", LIMITS),
    ("LINEAR_MAX_SPEED", LIMITS),
];

/// The same of the options of a motion.
const OPTIONS: &[(&str, &str)] = &[
    ("VOFFSET", VISION),
    ("Arc Start", ARC),
    ("Arc End", ARC),
    ("Weld Start", ARC),
    ("Weld End", ARC),
    ("SPOT[", SPOT),
    ("Search", TOUCH),
    ("COORD", GROUPS),
    ("RTCP", "a remote tool center point"),
    ("Ind.EV", AXES),
    ("EV", AXES),
    ("BREAK", "what is not simulated"),
    ("CR", PATHS),
    ("CD", PATHS),
    ("PSPD", PATHS),
];

impl Scanner<'_> {
    /// An instruction of an option that is not there; the rest of its line is taken.
    pub(super) fn absent_instruction(&mut self) -> Option<Absent> {
        let needs = self.needs(INSTRUCTIONS)?;
        let what = self.first_words();
        Some(self.not_there(what, needs))
    }

    /// An option of a motion; the rest of its line is taken.
    pub(super) fn absent_option(&mut self) -> Option<Absent> {
        let needs = self.needs(OPTIONS)?;
        let what = format!("{} of a motion", self.first_words());
        Some(self.not_there(what, needs))
    }

    fn needs(&mut self, table: &[(&str, &'static str)]) -> Option<&'static str> {
        let found = table.iter().find(|(start, _)| self.begins_with(start));
        found.map(|(_, needs)| *needs)
    }

    /// `VR[1]`, `VR[R[1]].OFFSET`, `VR[1].FOUND_POS[1]`.
    pub(super) fn vision_register(&mut self) -> Scanned<Option<Absent>> {
        if !self.sees("VR[") {
            return Ok(None);
        }
        let from = self.here();
        self.expect("VR")?;
        let _register = self.index()?;
        while self.eat(".") {
            let _dollar = self.eat("$");
            let _field = self.name("what a vision register has")?;
            if self.sees("[") {
                let _index = self.index()?;
            }
        }
        let absent = Absent {
            what: "VR".into(),
            needs: VISION,
        };
        self.warn_of(from, &absent);
        Ok(Some(absent))
    }

    fn not_there(&mut self, what: String, needs: &'static str) -> Absent {
        let from = self.here();
        self.take_all();
        let absent = Absent {
            what: what.into(),
            needs,
        };
        self.warn_of(from, &absent);
        absent
    }

    fn warn_of(&mut self, from: usize, absent: &Absent) {
        let Absent { what, needs } = absent;
        let message = format!("{what} needs {needs}: INTP-320 for who comes here");
        self.suspicious(from, message);
    }
}
