//! Descent in a potential field, with random walks out of its local minima.

use std::f64::consts::TAU;

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use super::Point;
use super::floor::{Floor, PlaneError, within};
use super::polygon::between;
use super::route::Route;
use super::sketch::Sketch;
use crate::wanted::Wanted;

/// What the field is made of, and how long it is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// `k_a` of (2.8).
    pub attraction: f64,
    /// `k_r` of (2.9), in mm⁴ for each unit of `k_a`.
    pub repulsion: f64,
    /// `delta_0` of (2.9), mm: obstacles farther away are not felt.
    pub influence: f64,
    /// The longest step, mm.
    pub step: f64,
    /// Steps of the longest random walk.
    pub walk: u32,
    /// All steps together, after which the search is given up.
    pub most_steps: u32,
    /// Of the random walks: the same seed gives the same path.
    pub seed: u64,
}

impl Default for Field {
    fn default() -> Self {
        Field {
            attraction: 1.0,
            repulsion: 1e8,
            influence: 150.0,
            step: 20.0,
            walk: 400,
            most_steps: 400_000,
            seed: 0,
        }
    }
}

/// Walks from one minimum before an earlier place of the path is tried.
const WALKS: u32 = 20;
/// A step is halved so often before a place counts as a minimum.
const HALVINGS: u32 = 6;

/// A path by descent in the potential (2.7)-(2.10), its detours left out.
///
/// The step of (2.11) is the longest of a step, a half, a quarter and so on that leads down and is
/// free. From a local minimum, random walks of random length are tried until one leads to a lower
/// minimum; after twenty in vain, the path is cut back to a random earlier place (Barraquand and
/// Latombe's randomized path planner).
///
/// # Errors
/// Start or goal where the robot cannot stand, a number of the field that is out of range, or no
/// path within the steps allowed, which does not prove that there is none.
pub fn potential(
    floor: &Floor,
    start: Point,
    goal: Point,
    field: &Field,
) -> Result<Route, PlaneError> {
    Ok(potential_sketched(floor, start, goal, field, Wanted::ALWAYS)?.0)
}

/// As [`potential`], with the steps that led to the goal, detours and all, as long as the path is `wanted`.
///
/// # Errors
/// As [`potential`]; [`PlaneError::BrokenOff`].
pub fn potential_sketched(
    floor: &Floor,
    start: Point,
    goal: Point,
    field: &Field,
    wanted: Wanted<'_>,
) -> Result<(Route, Sketch), PlaneError> {
    let _ = within("attraction of the field", field.attraction, 1e-9, 1e9)?;
    let _ = within("repulsion of the field", field.repulsion, 0.0, 1e15)?;
    let _ = within("influence of the field", field.influence, 1e-3, 1e6)?;
    let _ = within("step of the field", field.step, 1e-2, 1e5)?;
    floor.check("start", start)?;
    floor.check("goal", goal)?;
    let mut search = Search {
        floor,
        goal,
        field,
        random: Pcg64Mcg::seed_from_u64(field.seed),
        left: field.most_steps,
        wanted,
    };
    let mut path = vec![start];
    search.descend(&mut path);
    while !search.arrived(&path) {
        let least = search.value(search.end(&path));
        let mut escaped = false;
        for _ in 0..WALKS {
            wanted.check()?;
            if search.left == 0 {
                return Err(PlaneError::GaveUp {
                    method: "potential field",
                    effort: field.most_steps,
                    unit: "steps",
                });
            }
            let mut trial = vec![search.end(&path)];
            search.walk(&mut trial);
            search.descend(&mut trial);
            if search.arrived(&trial) || search.value(search.end(&trial)) < 0.999 * least {
                path.extend(trial.into_iter().skip(1));
                escaped = true;
                break;
            }
        }
        if !escaped {
            let kept = 1.0 + search.uniform() * count(path.len());
            let kept = path.len().min(floor_of(kept));
            path.truncate(kept);
            search.walk(&mut path);
        }
    }
    path.push(goal);
    let steps = path.iter().zip(path.iter().skip(1));
    let sketch = Sketch {
        cells: Vec::new(),
        edges: steps.map(|(a, b)| [*a, *b]).collect(),
    };
    Ok((Route::new(path).shortened(floor, wanted)?, sketch))
}

struct Search<'a> {
    floor: &'a Floor,
    goal: Point,
    field: &'a Field,
    random: Pcg64Mcg,
    left: u32,
    wanted: Wanted<'a>,
}

impl Search<'_> {
    fn goes_on(&self) -> bool {
        self.left > 0 && !self.wanted.is_over()
    }

    fn end(&self, path: &[Point]) -> Point {
        path.last().copied().unwrap_or(self.goal)
    }

    fn arrived(&self, path: &[Point]) -> bool {
        let end = self.end(path);
        between(end, self.goal) <= self.field.step && self.floor.is_free(end, self.goal)
    }

    fn uniform(&mut self) -> f64 {
        Uniform::new(0.0, 1.0).map_or(0.5, |unit| unit.sample(&mut self.random))
    }

    /// (2.7) to (2.9).
    fn value(&self, point: Point) -> f64 {
        let way = between(point, self.goal);
        let (clearance, _) = self.floor.nearest(point);
        let push = self.push(clearance);
        0.5 * self.field.attraction * way * way + 0.5 * self.field.repulsion * push * push
    }

    /// `1 / delta - 1 / delta_0`, zero beyond the influence.
    fn push(&self, clearance: f64) -> f64 {
        // On the obstacle the potential is infinite; a robot may start there.
        let clearance = clearance.max(1e-3);
        (1.0 / clearance - 1.0 / self.field.influence).max(0.0)
    }

    /// The direction of the steepest descent; none where the field is flat.
    fn downhill(&self, [x, y]: Point) -> Option<Point> {
        let (clearance, [nx, ny]) = self.floor.nearest([x, y]);
        let pull = self.field.attraction;
        let (mut dx, mut dy) = (pull * (self.goal[0] - x), pull * (self.goal[1] - y));
        let away = between([x, y], [nx, ny]);
        if away > 0.0 {
            let clearance = clearance.max(1e-3);
            let force =
                self.field.repulsion * self.push(clearance) / (clearance * clearance * away);
            dx += force * (x - nx);
            dy += force * (y - ny);
        }
        let length = dx.hypot(dy);
        (length > 0.0).then_some([dx / length, dy / length])
    }

    fn descend(&mut self, path: &mut Vec<Point>) {
        let mut here = self.end(path);
        let mut value = self.value(here);
        while self.goes_on() && !self.arrived(path) {
            self.left -= 1;
            let Some([dx, dy]) = self.downhill(here) else {
                return;
            };
            let steps = (0..=HALVINGS).map(|halving| {
                let step = self.field.step * 0.5_f64.powi(i32::try_from(halving).unwrap_or(0));
                [here[0] + step * dx, here[1] + step * dy]
            });
            let down = steps
                .map(|point| (self.value(point), point))
                .find(|(lower, point)| *lower < value && self.floor.is_free(here, *point));
            let Some((lower, point)) = down else {
                return;
            };
            // Creeping towards a minimum is being there.
            let crept = value - lower < 1e-9 * value;
            (here, value) = (point, lower);
            path.push(here);
            if crept {
                return;
            }
        }
    }

    fn walk(&mut self, path: &mut Vec<Point>) {
        let mut here = self.end(path);
        let length = self.uniform() * f64::from(self.field.walk);
        let mut walked = 0.0;
        // Straight for a few steps: a pure Brownian motion needs the square of the way.
        while walked < length && self.goes_on() {
            let angle = TAU * self.uniform();
            let stretch = 1.0 + 9.0 * self.uniform();
            let mut along = 0.0;
            while along < stretch && self.goes_on() {
                self.left -= 1;
                along += 1.0;
                let step = self.field.step;
                let next = [here[0] + step * angle.cos(), here[1] + step * angle.sin()];
                if !self.floor.is_free(here, next) {
                    break;
                }
                here = next;
                path.push(here);
            }
            walked += along;
        }
    }
}

fn count(length: usize) -> f64 {
    u32::try_from(length).map_or(f64::MAX, f64::from)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of points; `as` saturates"
)]
fn floor_of(value: f64) -> usize {
    value as usize
}
