//! Probabilistic roadmaps in any space.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;

use crate::plane::graph::shortest;
use crate::wanted::{BrokenOff, Wanted};

/// How a roadmap is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// The same seed gives the same path.
    pub seed: u64,
    /// Samples between two attempts to join start and goal.
    pub batch: u32,
    /// Samples after which the search is given up.
    pub most: u32,
    /// Neighbors that a sample is joined with.
    pub neighbors: usize,
}

impl Default for Sampling {
    fn default() -> Self {
        Sampling {
            seed: 0,
            batch: 100,
            most: 5000,
            neighbors: 12,
        }
    }
}

/// Where a roadmap is made.
pub(crate) trait Space {
    /// A place in it.
    type At: Clone;

    /// Are connections only checked when a path wants to use them?
    const LAZY: bool;

    fn sample(&self, random: &mut Pcg64Mcg) -> Self::At;
    fn distance(&self, a: &Self::At, b: &Self::At) -> f64;
    fn is_valid(&self, at: &Self::At) -> bool;
    fn is_free(&self, a: &Self::At, b: &Self::At) -> bool;
}

struct Edge {
    to: usize,
    length: f64,
    /// `None`: not known yet.
    free: Option<bool>,
}

/// A way through a roadmap.
pub(crate) struct Found<At> {
    /// Start, the samples between, goal.
    pub(crate) way: Vec<At>,
    /// The edges of the map that are known to be free.
    pub(crate) edges: Vec<[At; 2]>,
}

/// Start, the samples between, goal; `None` if all samples were in vain. Start and goal must be
/// valid.
pub(crate) fn search<S: Space>(
    space: &S,
    start: S::At,
    goal: S::At,
    sampling: &Sampling,
    wanted: Wanted<'_>,
) -> Result<Option<Found<S::At>>, BrokenOff> {
    if space.is_free(&start, &goal) {
        return Ok(Some(Found {
            way: vec![start, goal],
            edges: Vec::new(),
        }));
    }
    let mut random = Pcg64Mcg::seed_from_u64(sampling.seed);
    let mut map = Map {
        space,
        nodes: vec![start, goal],
        edges: vec![Vec::new(), Vec::new()],
        neighbors: sampling.neighbors,
        wanted,
    };
    let mut sampled = 0;
    while sampled < sampling.most {
        for _ in 0..sampling.batch.max(1) {
            sampled += 1;
            wanted.check()?;
            let sample = space.sample(&mut random);
            if space.is_valid(&sample) {
                map.add(sample);
            }
        }
        if let Some(way) = map.way()? {
            let nodes = way.into_iter();
            let way = nodes.filter_map(|node| map.nodes.get(node).cloned());
            return Ok(Some(Found {
                way: way.collect(),
                edges: map.free_edges(),
            }));
        }
    }
    Ok(None)
}

struct Map<'a, S: Space> {
    space: &'a S,
    nodes: Vec<S::At>,
    edges: Vec<Vec<Edge>>,
    neighbors: usize,
    wanted: Wanted<'a>,
}

impl<S: Space> Map<'_, S> {
    fn add(&mut self, sample: S::At) {
        let mut near: Vec<(f64, usize)> = self
            .nodes
            .iter()
            .enumerate()
            .map(|(index, node)| (self.space.distance(node, &sample), index))
            .collect();
        let by_distance = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0);
        if near.len() > self.neighbors {
            let _ = near.select_nth_unstable_by(self.neighbors, by_distance);
            near.truncate(self.neighbors);
        }
        near.sort_by(by_distance);
        let index = self.nodes.len();
        let mut own = Vec::with_capacity(near.len());
        for (length, to) in near {
            let Some(node) = self.nodes.get(to) else {
                continue;
            };
            let free = if S::LAZY {
                None
            } else if self.space.is_free(node, &sample) {
                Some(true)
            } else {
                continue;
            };
            own.push(Edge { to, length, free });
            if let Some(theirs) = self.edges.get_mut(to) {
                theirs.push(Edge {
                    to: index,
                    length,
                    free,
                });
            }
        }
        self.nodes.push(sample);
        self.edges.push(own);
    }

    fn free_edges(&self) -> Vec<[S::At; 2]> {
        let nodes = self.nodes.iter().zip(&self.edges).enumerate();
        let edges = nodes.flat_map(|(index, (node, edges))| {
            // Each edge is kept at both its ends.
            let once = edges.iter().filter(move |edge| edge.to < index);
            let free = once.filter(|edge| edge.free == Some(true));
            free.filter_map(|edge| Some([self.nodes.get(edge.to)?.clone(), node.clone()]))
        });
        edges.collect()
    }

    /// The shortest way from node 0 to node 1 whose edges are all free.
    fn way(&mut self) -> Result<Option<Vec<usize>>, BrokenOff> {
        loop {
            let Some(way) = shortest(
                self.nodes.len(),
                0,
                1,
                |node, around| {
                    let edges = self.edges.get(node).into_iter().flatten();
                    let open = edges.filter(|edge| edge.free != Some(false));
                    around.extend(open.map(|edge| (edge.to, edge.length)));
                },
                |node| match (self.nodes.get(node), self.nodes.get(1)) {
                    (Some(node), Some(goal)) => self.space.distance(node, goal),
                    _ => 0.0,
                },
            ) else {
                return Ok(None);
            };
            let mut free = true;
            for (&a, &b) in way.iter().zip(way.iter().skip(1)) {
                self.wanted.check()?;
                free &= self.check(a, b);
            }
            if free {
                return Ok(Some(way));
            }
        }
    }

    /// Is the edge free? Looked at once.
    fn check(&mut self, a: usize, b: usize) -> bool {
        let known = self.edges.get(a).into_iter().flatten();
        let known = known.filter(|edge| edge.to == b).find_map(|edge| edge.free);
        if let Some(free) = known {
            return free;
        }
        let free = match (self.nodes.get(a), self.nodes.get(b)) {
            (Some(from), Some(to)) => self.space.is_free(from, to),
            _ => false,
        };
        for (from, to) in [(a, b), (b, a)] {
            for edge in self.edges.get_mut(from).into_iter().flatten() {
                if edge.to == to {
                    edge.free = Some(free);
                }
            }
        }
        free
    }
}
