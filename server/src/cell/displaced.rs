//! Whether an arm stands where the last motion of a job left it, or somebody else moved it since (C10).

use protocol::v2::StatusLine;
use uuid::Uuid;

use crate::link::cell_server::Observed;
use crate::motions::{Asked, Book, End, apart, thousandths_of};

/// Further than this from where it was left, an arm was moved. Brakes let an arm sink by less, and a hand that jogs
/// moves it further.
const TURNED_DEG: f64 = 0.5;
const APART_MM: f64 = 2.0;

/// Where the last motion of a job left the arm.
#[derive(Clone, Copy, Debug)]
enum Left {
    /// J1 to J6, mdeg.
    Joints([i32; 6]),
    /// X, Y, Z in um, W, P, R in mdeg, in the controller's active frames.
    Point([i32; 6]),
}

/// Remembers where an arm was left.
#[derive(Debug, Default)]
pub(super) struct Whereabouts(Option<Noticed>);

/// The end of a motion, as it was noticed.
#[derive(Debug)]
struct Noticed {
    motion: Uuid,
    /// The status line of that moment may be older than the end: only later ones count.
    at: u64,
    left: Option<Left>,
}

impl Whereabouts {
    /// Whether the arm stands elsewhere than where the motions of `principal` left it. A motion that arrived left it at
    /// its target, one that was interrupted where it was seen to stand, and any other one where it is first seen to
    /// stand afterwards.
    pub(super) fn is_displaced(&mut self, seen: &Observed, book: &Book, principal: &str) -> bool {
        let Some((motion, asked, end)) = book.left_by(principal) else {
            return false;
        };
        if self.0.as_ref().is_none_or(|known| known.motion != motion) {
            self.0 = Some(Noticed {
                motion,
                at: seen.count,
                left: left_at(&asked, &end),
            });
        }
        let line = &seen.line;
        match &mut self.0 {
            Some(noticed) if seen.count > noticed.at && !line.moving && !line.held => {
                let here = || Left::Joints(line.joints.thousandths());
                is_away(noticed.left.get_or_insert_with(here), line)
            }
            Some(_) | None => false,
        }
    }
}

/// What the end of a motion says about where it left the arm.
fn left_at(asked: &Asked, end: &End) -> Option<Left> {
    match end {
        End::Succeeded { seen: Some(_) } if asked.to_joints => {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "joint limits are far below what fits"
            )]
            let mdeg = asked
                .joints
                .degrees()
                .map(|deg| (deg * 1_000.0).round() as i32);
            Some(Left::Joints(mdeg))
        }
        End::Succeeded { seen: Some(_) } => Some(Left::Point(asked.point)),
        End::Interrupted {
            seen: Some(seen), ..
        } => Some(Left::Point(thousandths_of(&seen.pose))),
        End::Succeeded { seen: None }
        | End::Interrupted { seen: None, .. }
        | End::Accepted
        | End::Rejected { .. }
        | End::NotExecuted { .. }
        | End::InDoubt { .. } => None,
    }
}

fn is_away(left: &Left, line: &StatusLine) -> bool {
    match left {
        Left::Joints(joints) => joints
            .iter()
            .zip(line.joints.thousandths())
            .any(|(was, is)| f64::from(was.abs_diff(is)) / 1_000.0 > TURNED_DEG),
        Left::Point(point) => {
            let apart = apart(*point, line.pose.thousandths());
            apart.is_none_or(|(mm, deg)| mm > APART_MM || deg > TURNED_DEG)
        }
    }
}
