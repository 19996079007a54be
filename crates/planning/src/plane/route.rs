//! A path on the floor.

use super::polygon::between;
use super::{Floor, Point};
use crate::wanted::{BrokenOff, Wanted};

/// Points to be driven through on straight lines, start and goal included.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    points: Vec<Point>,
}

impl Route {
    pub(crate) fn new(points: Vec<Point>) -> Route {
        Route { points }
    }

    /// The points, start first.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// In millimeters.
    #[must_use]
    pub fn length(&self) -> f64 {
        let pairs = self.points.iter().zip(self.points.iter().skip(1));
        pairs.map(|(a, b)| between(*a, *b)).sum()
    }

    /// Without detours: the shortest way over points that see each other, then the same with points
    /// between, which cuts the corners, until that gains nothing.
    ///
    /// # Errors
    /// It was no longer `wanted`.
    pub fn shortened(&self, floor: &Floor, wanted: Wanted<'_>) -> Result<Route, BrokenOff> {
        let mut best = self.skipped(floor, wanted)?;
        for _ in 0..ROUNDS {
            let shorter = best.divided().shortest(floor, wanted)?;
            if shorter.length() > 0.998 * best.length() {
                break;
            }
            best = shorter;
        }
        Ok(best)
    }

    fn skipped(&self, floor: &Floor, wanted: Wanted<'_>) -> Result<Route, BrokenOff> {
        let mut points = Vec::new();
        let mut rest = self.points.as_slice();
        while let Some((&here, ahead)) = rest.split_first() {
            points.push(here);
            wanted.check()?;
            // A long way is halved until its end is seen: not the farthest point, but near it.
            let mut farthest = ahead.len().saturating_sub(1);
            while farthest > 0
                && !ahead
                    .get(farthest)
                    .is_some_and(|&to| floor.is_free(here, to))
            {
                farthest /= 2;
            }
            rest = ahead.get(farthest..).unwrap_or_default();
        }
        Ok(Route { points })
    }

    /// The shortest way over some of the points, in their order.
    fn shortest(&self, floor: &Floor, wanted: Wanted<'_>) -> Result<Route, BrokenOff> {
        // For each point: the length from the start, and the point before.
        let mut best: Vec<(f64, usize)> = vec![(0.0, 0)];
        for (index, &to) in self.points.iter().enumerate().skip(1) {
            wanted.check()?;
            let mut ways: Vec<(f64, usize)> = self
                .points
                .iter()
                .zip(&best)
                .enumerate()
                .map(|(from, (point, (length, _)))| (length + between(*point, to), from))
                .collect();
            ways.sort_by(|a, b| a.0.total_cmp(&b.0));
            let seen = ways.iter().find(|(_, from)| {
                // The neighbor is always seen.
                let point = self.points.get(*from);
                from + 1 == index || point.is_some_and(|&point| floor.is_free(point, to))
            });
            best.push(seen.copied().unwrap_or((f64::INFINITY, index - 1)));
        }
        let mut points = Vec::new();
        let mut at = best.len() - 1;
        loop {
            points.extend(self.points.get(at));
            if at == 0 {
                break;
            }
            at = best.get(at).map_or(0, |(_, from)| *from);
        }
        points.reverse();
        Ok(Route { points })
    }

    fn divided(&self) -> Route {
        let pairs = self.points.iter().zip(self.points.iter().skip(1));
        let inner = pairs.flat_map(|([ax, ay], [bx, by])| {
            (0..PARTS).map(move |part| {
                let share = f64::from(part) / f64::from(PARTS);
                [ax + share * (bx - ax), ay + share * (by - ay)]
            })
        });
        Route {
            points: inner.chain(self.points.last().copied()).collect(),
        }
    }
}

const ROUNDS: u32 = 8;
/// Of each straight piece.
const PARTS: u32 = 8;
