//! The shortest way through a graph.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

struct Open {
    estimate: f64,
    cost: f64,
    node: usize,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    /// The heap gives the greatest first: the least estimate, then the least node, so that equal
    /// ways are always chosen alike.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_estimate = other.estimate.total_cmp(&self.estimate);
        by_estimate.then_with(|| other.node.cmp(&self.node))
    }
}

/// A* from node `start` to node `goal` of `count` nodes; `neighbors` pushes `(node, cost)`,
/// `ahead` is at most the cost that is left.
pub(crate) fn shortest(
    count: usize,
    start: usize,
    goal: usize,
    mut neighbors: impl FnMut(usize, &mut Vec<(usize, f64)>),
    ahead: impl Fn(usize) -> f64,
) -> Option<Vec<usize>> {
    let mut best = vec![(f64::INFINITY, usize::MAX); count];
    let mut open = BinaryHeap::new();
    let mut around = Vec::new();
    if let Some(first) = best.get_mut(start) {
        first.0 = 0.0;
    }
    open.push(Open {
        estimate: ahead(start),
        cost: 0.0,
        node: start,
    });
    while let Some(Open { cost, node, .. }) = open.pop() {
        if node == goal {
            let mut way = vec![goal];
            let mut at = goal;
            while at != start {
                at = best.get(at)?.1;
                way.push(at);
            }
            way.reverse();
            return Some(way);
        }
        if best.get(node).is_some_and(|(least, _)| cost > *least) {
            continue;
        }
        around.clear();
        neighbors(node, &mut around);
        for &(next, step) in &around {
            let Some(slot) = best.get_mut(next) else {
                continue;
            };
            let through = cost + step;
            if through < slot.0 {
                *slot = (through, node);
                open.push(Open {
                    estimate: through + ahead(next),
                    cost: through,
                    node: next,
                });
            }
        }
    }
    None
}
