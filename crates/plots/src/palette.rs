//! Colors that people tell apart, and what they are used for.

use plotters::style::RGBColor;

/// A color of the palette of Okabe and Ito ("Color Universal Design", 2008), told apart with any common color blindness.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct Color(pub(crate) RGBColor);

impl Color {
    /// Blue: what the drawing is about.
    pub const MAIN: Self = Self(RGBColor(0x00, 0x72, 0xb2));
    /// Vermilion: limits and what went wrong.
    pub const LIMIT: Self = Self(RGBColor(0xd5, 0x5e, 0x00));
    /// Bluish green: where something begins.
    pub const START: Self = Self(RGBColor(0x00, 0x9e, 0x73));
    /// Reddish purple: where something ends.
    pub const GOAL: Self = Self(RGBColor(0xb0, 0x4a, 0x8a));
    /// Near black: text and outlines.
    pub const INK: Self = Self(RGBColor(0x1c, 0x20, 0x26));
    /// Gray: text beside the point.
    pub const SOFT: Self = Self(RGBColor(0x5a, 0x60, 0x69));
    /// Light gray: what is behind.
    pub const FAINT: Self = Self(RGBColor(0xb4, 0xba, 0xc2));
    /// The gray of bodies behind lines.
    pub const BODY: Self = Self(RGBColor(0xdd, 0xe2, 0xe8));
    /// The light green of a body at the start.
    pub const START_BODY: Self = Self(RGBColor(0xbf, 0xe3, 0xd6));
    /// The light purple of a body at the goal.
    pub const GOAL_BODY: Self = Self(RGBColor(0xe8, 0xcd, 0xdf));
    /// The light vermilion around what is closed.
    pub(crate) const CLOSED: Self = Self(RGBColor(0xe3, 0xb0, 0x90));
    /// White: nothing.
    pub(crate) const PAPER: Self = Self(RGBColor(0xff, 0xff, 0xff));
    /// Very light gray: the lines of a grid.
    pub(crate) const GRID: Self = Self(RGBColor(0xe6, 0xe9, 0xed));

    const SERIES: [Self; 8] = [
        Self::MAIN,
        Self::LIMIT,
        Self::START,
        Self(RGBColor(0xe6, 0x9f, 0x00)),
        Self(RGBColor(0xcc, 0x79, 0xa7)),
        Self(RGBColor(0x56, 0xb4, 0xe9)),
        Self::INK,
        Self(RGBColor(0x8a, 0x7a, 0x1f)),
    ];

    /// The color of the `index`-th of several series; after eight they come again.
    #[must_use]
    pub fn of(index: usize) -> Self {
        let color = Self::SERIES.get(index % Self::SERIES.len());
        color.copied().unwrap_or(Self::INK)
    }
}

/// Support points of the color scale `viridis` (van der Walt and Smith, 2015), from low to high.
const VIRIDIS: [RGBColor; 9] = [
    RGBColor(0x44, 0x01, 0x54),
    RGBColor(0x47, 0x2d, 0x7b),
    RGBColor(0x3b, 0x52, 0x8b),
    RGBColor(0x2c, 0x72, 0x8e),
    RGBColor(0x21, 0x91, 0x8c),
    RGBColor(0x28, 0xae, 0x80),
    RGBColor(0x5e, 0xc9, 0x62),
    RGBColor(0xad, 0xdc, 0x30),
    RGBColor(0xfd, 0xe7, 0x25),
];

/// The color of `share`, 0 to 1, of the highest value.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "both factors are in 0 to 8, and a channel stays between two channels"
)]
pub(crate) fn scale(share: f64) -> Color {
    let at = share.clamp(0.0, 1.0) * 8.0;
    let low = at.floor().min(7.0);
    let part = at - low;
    let index = low as usize;
    let (Some(a), Some(b)) = (VIRIDIS.get(index), VIRIDIS.get(index + 1)) else {
        return Color::INK;
    };
    let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * part).round() as u8;
    Color(RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rec. 709 luminance, without the gamma: order is all that matters.
    fn lightness(Color(RGBColor(r, g, b)): Color) -> f64 {
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    }

    #[test]
    fn a_higher_value_is_lighter() {
        let steps: Vec<f64> = (0..=40)
            .map(|n| lightness(scale(f64::from(n) / 40.0)))
            .collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]), "{steps:?}");
        assert_eq!(scale(-1.0), scale(0.0));
        assert_eq!(scale(2.0), scale(1.0));
    }

    #[test]
    fn eight_series_have_eight_colors() {
        for a in 0..8 {
            for b in 0..a {
                assert_ne!(Color::of(a), Color::of(b));
            }
        }
        assert_eq!(Color::of(8), Color::of(0));
    }
}
