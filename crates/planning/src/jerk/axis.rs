//! When one joint can be where it should.

use super::phases::Phases;
use super::side::{Shape, Side, Task};
use crate::state::State;

/// One joint's task, seen from both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    upper: Side,
    /// The mirrored task: its largest displacement is our least.
    lower: Side,
    distance: f64,
    /// Positions closer than this are the same.
    slack: f64,
    edges: Edges,
    /// From rest to rest: both sides are the same, and every duration from the shortest is possible.
    rests: bool,
}

/// Which of the two extreme profiles a joint follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Profile {
    Upper(Phases),
    Lower(Phases),
    /// `weight` times the first, the rest of the second.
    Mean {
        upper: Phases,
        lower: Phases,
        weight: f64,
    },
}

/// A duration between which and the next one profiles exist, or do not.
#[derive(Clone, Copy, Debug)]
struct Edge {
    time: f64,
    /// The only displacement there is at this time.
    distance: f64,
    profile: Profile,
}

type Edges = [Option<Edge>; 4];

/// The shortest time for a displacement, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct Earliest {
    pub(super) time: f64,
    pub(super) profile: Profile,
}

impl Axis {
    pub(super) fn new(task: Task, distance: f64) -> Axis {
        let rests = task.is_from_rest_to_rest();
        let upper = Side::new(task);
        let lower = if rests {
            upper
        } else {
            Side::new(task.mirrored())
        };
        let span = task.velocity * task.velocity / task.acceleration
            + task.acceleration * task.velocity / task.jerk;
        Axis {
            upper,
            lower,
            distance,
            slack: 1e-13 * (distance.abs() + span),
            edges: if rests {
                [None; 4]
            } else {
                edges(&upper, &lower)
            },
            rests,
        }
    }

    /// A place for a joint that is not looked at yet.
    pub(super) fn nothing() -> Axis {
        let task = Task {
            start: State::default(),
            goal: State::default(),
            velocity: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
        };
        let side = Side::new(task);
        Axis {
            upper: side,
            lower: side,
            distance: 0.0,
            slack: 0.0,
            edges: [None; 4],
            rests: true,
        }
    }

    /// The shortest time of at least `from` in which the displacement can be reached exactly.
    pub(super) fn earliest(&self, from: f64) -> Option<Earliest> {
        if self.rests {
            let shortest = self.upper.task.shortest_between_rests(self.distance.abs());
            if from > shortest {
                let profile = self.lasting(from)?;
                return Some(Earliest {
                    time: from,
                    profile,
                });
            }
            let phases = match self.upper.shape_at(shortest) {
                Some(shape) => self.upper.task.phases(&shape),
                // Nothing to do.
                None => Phases::default(),
            };
            let profile = if self.distance >= 0.0 {
                Profile::Upper(phases)
            } else {
                Profile::Lower(phases)
            };
            return Some(Earliest {
                time: shortest,
                profile,
            });
        }
        let mut segment_start = None;
        for edge in self.edges.iter().flatten() {
            if let Some(before) = segment_start.replace(edge)
                && edge.time > from
                && let Some(found) = self.within(before, Some(edge), from)
            {
                return Some(found);
            }
        }
        self.within(segment_start?, None, from)
    }

    /// The profile of exactly `time` seconds that reaches the displacement.
    pub(super) fn lasting(&self, time: f64) -> Option<Profile> {
        let profile = |side: &Side| {
            let phases = side.task.phases(&side.shape_at(time)?);
            let end = phases.end(side.task.start, side.task.jerk);
            Some((phases, end.position))
        };
        let (upper, most) = profile(&self.upper)?;
        let (lower, least) = if self.rests {
            (upper, -most)
        } else {
            let (lower, least) = profile(&self.lower)?;
            (lower, -least)
        };
        if self.distance > most + self.slack || self.distance < least - self.slack {
            return None;
        }
        if most - self.distance <= self.slack {
            return Some(Profile::Upper(upper));
        }
        if self.distance - least <= self.slack {
            return Some(Profile::Lower(lower));
        }
        Some(Profile::Mean {
            upper,
            lower,
            weight: (self.distance - least) / (most - least),
        })
    }

    /// Looks at the durations from one edge to the next (or for good), and from `from` on.
    fn within(&self, first: &Edge, last: Option<&Edge>, from: f64) -> Option<Earliest> {
        let end = last.map_or(f64::INFINITY, |edge| edge.time);
        if let Some(last) = last {
            // Between the edges that are not joined by profiles there are none.
            let _ = self.upper.shape_at(0.5 * (first.time + last.time))?;
        }
        let start = first.time.max(from);
        let (most, least, at_edge) = if first.time >= from {
            (first.distance, first.distance, true)
        } else {
            let (most, _) = self.upper.reach(start)?;
            let (least, _) = self.lower.reach(start)?;
            (most, -least, false)
        };
        if self.distance <= most + self.slack && self.distance >= least - self.slack {
            let profile = if at_edge {
                first.profile
            } else {
                self.lasting(start)?
            };
            return Some(Earliest {
                time: start,
                profile,
            });
        }
        let (side, distance) = if self.distance > most {
            (&self.upper, self.distance)
        } else {
            (&self.lower, -self.distance)
        };
        let reached = if self.distance > most { most } else { -least };
        let time = first_root(side, distance, (start, reached), end)?;
        let phases = side.task.phases(&side.shape_at(time)?);
        let profile = if self.distance > most {
            Profile::Upper(phases)
        } else {
            Profile::Lower(phases)
        };
        Some(Earliest { time, profile })
    }
}

/// The durations at which only one profile exists: those that reach the goal's velocity by one
/// change of the jerk, up and down or down and up. From the first to the second there are profiles,
/// from the second to the third none, and after the last there are for good.
fn edges(upper: &Side, lower: &Side) -> Edges {
    let mut edges: Edges = [None; 4];
    let mut slots = edges.iter_mut();
    for (side, sign) in [(upper, 1.0), (lower, -1.0)] {
        let task = &side.task;
        let (a0, af) = (task.start.acceleration, task.goal.acceleration);
        let limit = task.acceleration;
        // Up to the peak and down to the end, seen from this side.
        let square =
            0.5 * (a0 * a0 + af * af) + task.jerk * (task.goal.velocity - task.start.velocity);
        let peaks = if square < 0.0 {
            [None, None]
        } else if square > limit * limit {
            let hold = (square - limit * limit) / (task.jerk * limit);
            [Some((limit, hold)), None]
        } else {
            let root = square.sqrt();
            // With both accelerations at zero or above, the shallow one cannot be.
            let shallow = (a0 < 0.0 && af < 0.0 && root > 0.0).then_some((-root, 0.0));
            [Some((root, 0.0)), shallow]
        };
        for (peak, hold) in peaks.into_iter().flatten() {
            let slack = 1e-12 * limit;
            if peak < a0 - slack || peak < af - slack {
                continue;
            }
            let shape = Shape {
                peak,
                peak_hold: hold,
                trough: af,
                trough_hold: 0.0,
                cruise: None,
            };
            let phases = task.phases(&shape);
            let profile = if sign > 0.0 {
                Profile::Upper(phases)
            } else {
                Profile::Lower(phases)
            };
            if let Some(slot) = slots.next() {
                *slot = Some(Edge {
                    time: task.duration(&shape),
                    distance: sign * phases.end(task.start, task.jerk).position,
                    profile,
                });
            }
        }
    }
    edges.sort_unstable_by(|a, b| {
        let time = |edge: &Option<Edge>| edge.map_or(f64::INFINITY, |edge| edge.time);
        time(a).total_cmp(&time(b))
    });
    edges
}

/// The first time after `start` at which `side` reaches `distance`, which is beyond what it reaches
/// at the start.
fn first_root(side: &Side, distance: f64, start: (f64, f64), end: f64) -> Option<f64> {
    let (from, reached) = start;
    let middle = |a: f64, b: f64| 0.5 * (a + b);
    // Where both accelerations have one sign, longer may also mean less far: the reach rises, falls
    // and rises again, and bends the other way only once.
    if let Some(bend) = bend_of(side)
        && bend > from
    {
        let bend = bend.min(end);
        let (_, slope) = side.reach(bend)?;
        let top = if slope >= 0.0 {
            bend
        } else {
            // The slope falls up to the bend; where it crosses zero the reach is largest.
            let (mut rising, mut falling) = (from, bend);
            for _ in 0..60 {
                let between = middle(rising, falling);
                match side.reach(between) {
                    Some((_, slope)) if slope < 0.0 => falling = between,
                    Some(_) | None => rising = between,
                }
            }
            falling
        };
        let (at_top, _) = side.reach(top)?;
        if at_top >= distance {
            return bracketed(side, distance, start, (top, at_top));
        }
        if bend >= end {
            return None;
        }
        let (at_bend, _) = side.reach(bend)?;
        return convex_root(side, distance, (bend, at_bend), end);
    }
    convex_root(side, distance, (from, reached), end)
}

/// Where the reach is convex, or straight, from `start` on.
fn convex_root(side: &Side, distance: f64, start: (f64, f64), end: f64) -> Option<f64> {
    if end.is_finite() {
        let (reached, _) = side.reach(end)?;
        return (reached >= distance)
            .then(|| bracketed(side, distance, start, (end, reached)))
            .flatten();
    }
    let d_cruise = side.d_cruise();
    if distance >= d_cruise {
        let from = side.t_cruise.max(start.0);
        let (reached, _) = side.reach(from)?;
        return Some(from + (distance - reached) / side.task.velocity);
    }
    bracketed(side, distance, start, (side.t_cruise, d_cruise))
}

/// The time at which the reach stops bending downwards, if it ever does so: with `z` the square of
/// the accelerations' way, `k² / (8 z) + 3 z / 8` is least; held at the limit, where the other
/// acceleration is a quarter of it.
fn bend_of(side: &Side) -> Option<f64> {
    let (a0, af) = (side.task.start.acceleration, side.task.goal.acceleration);
    let below = a0 < 0.0 && side.k < 0.0;
    let above = af > 0.0 && side.k > 0.0;
    if !below && !above {
        return None;
    }
    let (k, limit) = (side.k.abs(), side.task.acceleration);
    let free = (k / 3.0_f64.sqrt()).sqrt();
    // The deeper of the two accelerations there.
    let deepest = 0.5 * (k / free + free);
    let way = if deepest <= limit {
        free
    } else {
        (0.5625 * limit * limit + k) / (2.0 * limit)
    };
    Some(side.time_of_way(way))
}

/// Newton's method with the curvature of the last two slopes, between two times; halving where it
/// would leave them.
fn bracketed(side: &Side, distance: f64, low: (f64, f64), high: (f64, f64)) -> Option<f64> {
    let ((mut low, at_low), (mut high, at_high)) = (low, high);
    if at_high <= distance {
        return Some(high);
    }
    // The reach grows with the cube of the time at first: this is not far off.
    let share = (distance - at_low) / (at_high - at_low);
    let mut time = low + (high - low) * share.clamp(0.0, 1.0).cbrt();
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..100 {
        let (reached, slope) = side.reach(time)?;
        let miss = reached - distance;
        if miss < 0.0 {
            low = time;
        } else {
            high = time;
        }
        let bend = before.map_or(0.0, |(then, slope_then)| {
            (slope - slope_then) / (time - then)
        });
        before = Some((time, slope));
        let root = (slope * slope - 2.0 * bend * miss).sqrt();
        let step = if root.is_finite() && slope > 0.0 {
            2.0 * miss / (slope + root)
        } else {
            miss / slope
        };
        let next = time - step;
        if step.abs() <= 4.0 * f64::EPSILON * time {
            return Some(next);
        }
        time = if next > low && next < high {
            next
        } else {
            0.5 * (low + high)
        };
        if high - low <= 4.0 * f64::EPSILON * high {
            return Some(high);
        }
    }
    Some(high)
}
