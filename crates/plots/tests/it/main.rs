//! What is in a drawing: curves, labels, limits, legends; and that the same is in the PNG.

mod answers;
mod drawings;
mod refused;
mod seen;
