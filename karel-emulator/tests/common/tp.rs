//! TP programs in tests, and a controller whose time the test moves by itself.

use std::time::Duration;

use karel_emulator::{Controller, ControllerConfig, LedgerEvent, ProgramSource};

use super::arm;

/// A listing with these lines and this `/POS` section.
pub(crate) fn listing(name: &str, lines: &[&str], positions: &str) -> ProgramSource {
    let numbered = lines.iter().enumerate();
    let numbered = numbered.map(|(n, line)| format!("{:4}:{line} ;\n", n + 1));
    let body: Vec<String> = numbered.collect();
    let body = body.concat();
    let text = format!("/PROG  {name}\n/ATTR\n/MN\n{body}/POS\n{positions}/END\n");
    ProgramSource::new(format!("{name}.ls"), text)
}

/// `P[n]` of the world and tool 1.
pub(crate) fn position(n: u32, [x, y, z, w, p, r]: [f64; 6]) -> String {
    format!(
        "P[{n}:\"here\"]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x} mm,\tY = {y} mm,\tZ = {z} mm,\n\tW = {w} deg,\tP = {p} deg,\tR = {r} deg\n}};\n"
    )
}

/// `P[n]` in joints.
pub(crate) fn joints(n: u32, degrees: [f64; 6]) -> String {
    let axes = degrees.iter().enumerate();
    let axes: Vec<String> = axes
        .map(|(n, value)| format!("J{} = {value} deg", n + 1))
        .collect();
    let axes = axes.join(", ");
    format!("P[{n}]{{\n   GP1:\n\tUF : F, UT : F,\n\t{axes}\n}};\n")
}

/// Three places that make a right angle: `P[1]` to `P[2]` along y, `P[2]` to `P[3]` along z, 200 mm each.
pub(crate) fn corner() -> String {
    let place = |n, y, z| position(n, [900.0, y, z, 180.0, 0.0, 0.0]);
    place(1, -200.0, 700.0) + &place(2, 0.0, 700.0) + &place(3, 0.0, 900.0)
}

/// A controller that runs a listing of these lines.
pub(crate) struct Core(pub(crate) Controller);

impl Core {
    pub(crate) fn moves(lines: &[&str], positions: &str) -> Self {
        Self::of(&config(lines, positions))
    }

    pub(crate) fn of(config: &ControllerConfig) -> Self {
        Self(Controller::try_new(config).unwrap())
    }

    pub(crate) fn now(&self) -> f64 {
        self.0.now().as_secs_f64()
    }

    pub(crate) fn advance(&mut self, seconds: f64) {
        let until = self.0.now() + Duration::from_secs_f64(seconds);
        self.0.advance_fully(until);
    }

    /// Where the tool is, mm.
    pub(crate) fn tool(&self) -> [f64; 3] {
        let pose = self.0.state().pose;
        [pose.x_mm, pose.y_mm, pose.z_mm]
    }

    /// Moves time by 2 ms until something holds.
    pub(crate) fn until(&mut self, mut holds: impl FnMut(&Self) -> bool) {
        for _ in 0..30_000 {
            if holds(self) {
                return;
            }
            self.advance(0.002);
        }
        panic!(
            "it never holds: {:#?} {:#?}",
            self.0.state(),
            self.0.alarms()
        );
    }

    /// Until no task runs and the arm stands still.
    pub(crate) fn finish(&mut self) {
        self.advance(0.001);
        self.until(|core| core.0.state().idle);
    }

    pub(crate) fn events(&self) -> Vec<(u64, LedgerEvent)> {
        let ledger = self.0.ledger(0);
        ledger
            .iter()
            .map(|entry| (entry.motion, entry.event))
            .collect()
    }

    pub(crate) fn started(&self, motion: u64) -> bool {
        self.events().contains(&(motion, LedgerEvent::Started))
    }

    /// How long a motion took that has ended, s.
    pub(crate) fn lasted(&self, motion: u64) -> f64 {
        let ledger = self.0.ledger(0);
        let mut ends = ledger.iter().rev();
        let end = ends.find(|entry| entry.motion == motion).unwrap();
        assert_eq!(end.event, LedgerEvent::Finished, "{end:?}");
        end.duration_s.unwrap()
    }

    pub(crate) fn last_alarm(&self) -> String {
        self.0.alarms().last().unwrap().headline()
    }
}

pub(crate) fn config(lines: &[&str], positions: &str) -> ControllerConfig {
    ControllerConfig::new("tp", arm()).with_program(listing("moves", lines, positions))
}

pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}
