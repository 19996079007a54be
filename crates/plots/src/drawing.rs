//! A finished drawing, as text or as a picture.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, fontdb};

use crate::PlotError;

/// What a PNG's pixels are to the drawing's: sharp on today's screens, and in print.
const ZOOM: f32 = 2.0;

/// The font of a PNG. In an SVG the viewer takes it if it has it, and else one of its own.
pub(crate) const FONT: &str = "DejaVu Sans";

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.set_sans_serif_family(FONT);
    Arc::new(fonts)
});

/// A finished drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    svg: String,
}

impl Drawing {
    pub(crate) fn new(svg: String) -> Self {
        Self { svg }
    }

    /// As SVG text, with a newline at its end.
    #[must_use]
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// As a PNG with two pixels for each of the drawing's.
    ///
    /// # Errors
    /// [`PlotError::Png`], if the renderer does not take the drawing: a bug of this crate.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a drawing is some thousand pixels wide"
    )]
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        let wrong = |why: String| PlotError::Png(why);
        let options = usvg::Options {
            fontdb: Arc::clone(&FONTS),
            font_family: FONT.to_owned(),
            ..usvg::Options::default()
        };
        let tree =
            usvg::Tree::from_str(&self.svg, &options).map_err(|error| wrong(error.to_string()))?;
        let size = tree.size();
        let (width, height) = (size.width() * ZOOM, size.height() * ZOOM);
        let mut picture = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
            .ok_or_else(|| wrong(format!("{width} x {height} pixels are no picture")))?;
        resvg::render(
            &tree,
            Transform::from_scale(ZOOM, ZOOM),
            &mut picture.as_mut(),
        );
        picture
            .encode_png()
            .map_err(|error| wrong(error.to_string()))
    }
}
