//! Why there is no drawing.

/// Why there is no drawing.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// There is nothing to see.
    #[error("{what} has no points to draw")]
    Empty {
        /// The drawing, or the part of it.
        what: String,
    },
    /// No place on paper.
    #[error("{what} has a value that is not a finite number: {value}")]
    NotFinite {
        /// The drawing, or the part of it.
        what: String,
        /// The value.
        value: f64,
    },
    /// The parts of the data do not fit each other.
    #[error("{what} has {given} values where {wanted} are needed")]
    Shape {
        /// The part of the drawing.
        what: String,
        /// How many there are.
        given: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// The drawing library gave up.
    #[error("drawing: {0}")]
    Draw(String),
    /// The picture could not be made from the drawing.
    #[error("making a PNG of the drawing: {0}")]
    Png(String),
}

/// Checks that every number can be drawn.
pub(crate) fn all_finite(
    what: &str,
    numbers: impl IntoIterator<Item = f64>,
) -> Result<(), PlotError> {
    match numbers.into_iter().find(|number| !number.is_finite()) {
        None => Ok(()),
        Some(value) => Err(PlotError::NotFinite {
            what: what.to_owned(),
            value,
        }),
    }
}
