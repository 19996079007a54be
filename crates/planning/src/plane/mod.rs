//! Paths of a disc-shaped robot on a floor among polygons.
//!
//! Chapter 2.2 of the textbook: exact cell decomposition ([`trapezoids()`]), approximate cell
//! decomposition ([`quadtree()`]), potential field with random walks ([`potential()`]) and the
//! probabilistic roadmap ([`roadmap()`]). Lengths are millimeters.
//!
//! ```
//! use planning::plane::{self, Floor, Polygon};
//!
//! let wall = Polygon::try_new(vec![[400.0, 0.0], [500.0, 0.0], [500.0, 700.0], [400.0, 700.0]])?;
//! let floor = Floor::try_new([0.0, 0.0], [1000.0, 1000.0], vec![wall], 50.0)?;
//! let path = plane::trapezoids(&floor, [100.0, 100.0], [900.0, 100.0])?;
//! // Up, over the wall's end at a distance of 50, and down.
//! assert!(path.length() > 1400.0 && path.length() < 1900.0);
//! # Ok::<(), planning::plane::PlaneError>(())
//! ```

mod floor;
pub(crate) mod graph;
mod polygon;
mod potential;
mod quadtree;
mod route;
mod sampled;
mod sketch;
mod trapezoids;

pub use floor::{Floor, PlaneError};
pub use polygon::{Polygon, PolygonError};
pub use potential::{Field, potential, potential_sketched};
pub use quadtree::{quadtree, quadtree_sketched};
pub use route::Route;
pub use sampled::{Sampling, roadmap, roadmap_sketched};
pub use sketch::{Sketch, SketchedCell};
pub use trapezoids::{trapezoids, trapezoids_sketched};

/// x and y in millimeters.
pub type Point = [f64; 2];
