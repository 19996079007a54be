//! The system variables and their values at power-on.

use std::collections::BTreeMap;

use karel::{Position, Text, Value};

use super::codes::{motype, termtype};
use super::{Kind, Live, Source, Variable};
use crate::fidelity::ControllerGeneration;
use crate::motion::path::SPEED_LIMIT;

const ANY: Kind = Kind::Integer {
    min: i32::MIN,
    max: i32::MAX,
};
const PORT: Kind = Kind::Integer {
    min: 0,
    max: 65_535,
};
const NAME: Kind = Kind::Text { max: 32 };

/// Instructions with words of their own.
const MACROS: i32 = 40;
const MACRO_NAME: Kind = Kind::Text { max: 36 };

/// Words of `UALM[1]` and so on.
const USER_ALARMS: i32 = 10;

/// Frames and tools that the pendant can select.
const MENU_FRAMES: i32 = 10;

/// `$STATE` of a tag that programs may use.
const TAG_STARTED: i32 = 3;

pub(super) fn power_on(generation: ControllerGeneration) -> BTreeMap<String, Variable> {
    let mut table = Table::default();
    for number in 1..=8 {
        table.tag(&format!("$HOSTS_CFG[{number}]"));
        table.tag(&format!("$HOSTC_CFG[{number}]"));
    }
    table.motion_environment();
    table.menu_frames();
    table.rest(generation);
    table.0
}

#[derive(Default)]
struct Table(BTreeMap<String, Variable>);

impl Table {
    fn stored(&mut self, path: impl Into<String>, kind: Kind, value: Value) {
        let variable = Variable {
            kind,
            source: Source::Stored,
            value: Some(value),
        };
        let _previous = self.0.insert(path.into(), variable);
    }

    fn integer(&mut self, path: impl Into<String>, kind: Kind, value: i32) {
        self.stored(path, kind, Value::Integer(value));
    }

    fn live(&mut self, path: &str, kind: Kind, live: Live) {
        let variable = Variable {
            kind,
            source: Source::Live(live),
            value: None,
        };
        let _previous = self.0.insert(path.to_owned(), variable);
    }

    fn position(&mut self, path: impl Into<String>) {
        self.stored(path, Kind::Position, Value::Position(Position::default()));
    }

    /// ASSUMPTION: every tag is defined and started at power-on, which on a controller is the work of its setup menu.
    fn tag(&mut self, root: &str) {
        self.stored(
            format!("{root}.$PROTOCOL"),
            NAME,
            Value::String(Text::from("SM")),
        );
        self.integer(
            format!("{root}.$STATE"),
            Kind::Integer { min: 0, max: 3 },
            TAG_STARTED,
        );
        self.integer(format!("{root}.$SERVER_PORT"), PORT, 0);
        self.integer(format!("{root}.$TIMEOUT"), ANY, 0);
        self.integer(format!("{root}.$OPER"), ANY, TAG_STARTED);
        for name in [
            "$REMOTE",
            "$STRT_REMOTE",
            "$MODE",
            "$COMMENT",
            "$DEVICE",
            "$PATH",
        ] {
            self.stored(
                format!("{root}.{name}"),
                NAME,
                Value::String(Text::from("")),
            );
        }
    }

    /// ASSUMPTION: one motion environment for all tasks; on a controller each task starts with a copy of it.
    fn motion_environment(&mut self) {
        let max = speed_limit();
        self.stored("$SPEED", Kind::Real { above: 0.0, max }, Value::Real(300.0));
        self.stored(
            "$SPEEDLIM",
            Kind::Real { above: 0.0, max },
            Value::Real(max),
        );
        let rotation = Kind::Real {
            above: 0.0,
            max: 1e4,
        };
        self.stored("$ROTSPEED", rotation, Value::Real(500.0));
        self.integer("$MOTYPE", ANY, motype::JOINT);
        self.integer("$TERMTYPE", ANY, termtype::FINE);
        self.integer("$ORIENT_TYPE", ANY, 1);
        self.position("$UFRAME");
        self.position("$UTOOL");
    }

    fn menu_frames(&mut self) {
        for number in 1..=MENU_FRAMES {
            self.position(format!("$MNUFRAME[1,{number}]"));
            self.position(format!("$MNUTOOL[1,{number}]"));
        }
        let frame = Kind::Integer {
            min: 0,
            max: MENU_FRAMES,
        };
        self.integer("$MNUFRAMENUM[1]", frame, 0);
        self.integer("$MNUTOOLNUM[1]", frame, 1);
    }

    fn rest(&mut self, generation: ControllerGeneration) {
        // ASSUMPTION: 0 is legal and holds the arm where it is.
        self.integer("$MCR.$GENOVERRIDE", Kind::Integer { min: 0, max: 100 }, 100);
        self.stored("$DMAURST", Kind::Boolean, Value::Boolean(false));
        self.integer("$JCR_GRP[1].$JOG_COORD", ANY, 0);
        // Hundredths of a second.
        let width = Kind::Integer {
            min: 1,
            max: 1_000_000,
        };
        self.integer("$WAITTMOUT", width, 3000);
        // Tenths of a second.
        self.integer("$DEFPULSE", Kind::Integer { min: 1, max: 255 }, 4);
        for n in 1..=USER_ALARMS {
            let words = Value::String(Text::from(""));
            self.stored(format!("$UALRM_MSG[{n}]"), NAME, words);
        }
        for n in 1..=MACROS {
            for name in ["$MACRO_NAME", "$PROG_NAME"] {
                let words = Value::String(Text::from(""));
                self.stored(format!("$MACROTABLE[{n}].{name}"), MACRO_NAME, words);
            }
        }
        self.integer("$SCAN_TIME", Kind::Integer { min: 1, max: 4096 }, 32);
        self.live("$MOR.$SAFETY_STAT", ANY, Live::SafetyStatus);
        self.live("$MOR_GRP[1].$SERVO_READY", Kind::Boolean, Live::ServoReady);
        self.live("$MOR_GRP[1].$ROB_MOVE", Kind::Boolean, Live::RobotMoves);
        self.live("$FAST_CLOCK", ANY, Live::FastClock);
        let power = Kind::Real {
            above: -1.0,
            max: 1e6,
        };
        self.live("$PRO_CFG.$INS_PWR", power, Live::Power);
        let version = Value::String(Text::from(generation.version()));
        self.stored("$SCR_GRP[1].$SV_CODE_ID", NAME, version);
        self.position("$NILPOS");
        self.integer("$NUM_GROUP", Kind::Integer { min: 1, max: 1 }, 1);
    }
}

#[expect(clippy::cast_possible_truncation, reason = "2000 is exact in 32 bits")]
fn speed_limit() -> f32 {
    SPEED_LIMIT.0 as f32
}
