//! Drawings of arms, trajectories and paths: plain numbers in, an SVG or a PNG out.
//!
//! [`answers`] draws the answers of the API: an arm, a trajectory, a route. What is drawn is described by plain data ([`Panel`], [`Map`], [`HeatMap`], [`Skeleton`]), in the units its labels
//! name, so that a drawing says nothing that its data did not. The curves are drawn with `plotters` into an SVG; a PNG
//! is that same SVG rendered by `resvg`, with a font that is part of the program. So neither needs a library or a font
//! of the system, and both show the same.
//!
//! Colors are those of Okabe and Ito, which people tell apart whatever their eyesight; counts are drawn in the
//! `viridis` scale, whose lightness grows with the value.
//!
//! ```
//! let panel = plots::Panel {
//!     title: "Position".to_owned(),
//!     x_label: "time in s".to_owned(),
//!     y_label: "J1 in °".to_owned(),
//!     lines: vec![plots::Line::new("J1", plots::Color::of(0), vec![(0.0, 0.0), (1.0, 30.0)])],
//!     ..plots::Panel::default()
//! };
//! let drawing = plots::panels("A move", "", &[panel], 1)?;
//! assert!(drawing.svg().starts_with("<svg "));
//! assert!(drawing.png()?.starts_with(b"\x89PNG"));
//! # Ok::<(), plots::PlotError>(())
//! ```

pub mod answers;
mod canvas;
mod drawing;
mod error;
mod figure;
mod frame;
mod heat;
mod legend;
mod map;
mod palette;
mod panels;
mod simplify;
mod skeleton;
mod ticks;

pub use drawing::Drawing;
pub use error::PlotError;
pub use heat::{HeatMap, heat_map};
pub use map::{Item, Look, Map, map};
pub use palette::Color;
pub use panels::{Level, Line, Moment, Panel, panels};
pub use skeleton::{Body, Capsule, Skeleton, Stick, skeleton};
