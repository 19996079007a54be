//! A drawing as a reader's eye takes it apart.

#![expect(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a drawing that is not as expected is a test that fails"
)]

use plots::Drawing;
use roxmltree::Document;

/// A line: its color, how thick it is, and its points in pixels.
pub(crate) type SeenLine = (String, f64, Vec<(f64, f64)>);

/// The SVG's parts.
pub(crate) struct Seen {
    /// Every text, in the order of drawing.
    pub(crate) texts: Vec<String>,
    /// Every line.
    pub(crate) lines: Vec<SeenLine>,
    /// Every filled rectangle: its color and its area in square pixels.
    pub(crate) rectangles: Vec<(String, f64)>,
    /// Every filled polygon's color.
    pub(crate) polygons: Vec<String>,
    /// Every circle: its fill or stroke, its middle and radius in pixels.
    pub(crate) circles: Vec<(String, (f64, f64), f64)>,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

pub(crate) fn seen(drawing: &Drawing) -> Seen {
    let document = Document::parse(drawing.svg()).unwrap();
    let root = document.root_element();
    let width: f64 = root.attribute("width").unwrap().parse().unwrap();
    let height: f64 = root.attribute("height").unwrap().parse().unwrap();
    let view: Vec<f64> = numbers(root.attribute("viewBox").unwrap());
    let fine = view[2] / width;
    let mut seen = Seen {
        texts: Vec::new(),
        lines: Vec::new(),
        rectangles: Vec::new(),
        polygons: Vec::new(),
        circles: Vec::new(),
        width,
        height,
    };
    for node in root.children().filter(roxmltree::Node::is_element) {
        let text = |name: &str| node.attribute(name).unwrap_or_default().to_owned();
        let number = |name: &str| -> f64 { text(name).parse().unwrap_or(0.0) };
        match node.tag_name().name() {
            "text" => seen
                .texts
                .push(node.text().unwrap_or_default().trim().to_owned()),
            "polyline" => {
                let all = numbers(&text("points"));
                let points = all
                    .chunks(2)
                    .map(|pair| (pair[0] / fine, pair[1] / fine))
                    .collect();
                seen.lines
                    .push((text("stroke"), number("stroke-width") / fine, points));
            }
            "line" => {
                let end = |n: u8| {
                    let at = |axis: &str| number(&format!("{axis}{n}")) / fine;
                    (at("x"), at("y"))
                };
                seen.lines.push((
                    text("stroke"),
                    number("stroke-width") / fine,
                    vec![end(1), end(2)],
                ));
            }
            "rect" => seen.rectangles.push((
                text("fill"),
                number("width") * number("height") / fine / fine,
            )),
            "polygon" => seen.polygons.push(text("fill")),
            "circle" => {
                let color = if text("fill") == "none" {
                    text("stroke")
                } else {
                    text("fill")
                };
                let center = (number("cx") / fine, number("cy") / fine);
                seen.circles.push((color, center, number("r") / fine));
            }
            _ => {}
        }
    }
    seen
}

impl Seen {
    pub(crate) fn says(&self, text: &str) -> bool {
        self.texts.iter().any(|line| line == text)
    }

    pub(crate) fn count(&self, text: &str) -> usize {
        self.texts.iter().filter(|line| *line == text).count()
    }

    /// Lines of this color and thickness.
    pub(crate) fn drawn(&self, color: &str, pixels: f64) -> Vec<&[(f64, f64)]> {
        let lines = self.lines.iter();
        lines
            .filter(|line| line.0 == color && (line.1 - pixels).abs() < 0.13)
            .map(|line| line.2.as_slice())
            .collect()
    }
}

fn numbers(text: &str) -> Vec<f64> {
    text.split([' ', ','])
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().unwrap())
        .collect()
}
