//! Lengths and view boxes: 96 px to the inch, as CSS has it.

use crate::drawing::Affine;
use svgtypes::{Length, LengthUnit};

/// Millimetres of one px: 96 to the inch.
pub const MM_PER_PX: f64 = 25.4 / 96.0;

/// A length in px; a percentage of `whole` px, an em of `font_size` px.
#[must_use]
pub fn to_px(length: Length, whole: f64, font_size: f64) -> f64 {
    let n = length.number;
    match length.unit {
        LengthUnit::None | LengthUnit::Px => n,
        LengthUnit::Mm => n / MM_PER_PX,
        LengthUnit::Cm => n * 10.0 / MM_PER_PX,
        LengthUnit::In => n * 96.0,
        LengthUnit::Pt => n * 96.0 / 72.0,
        LengthUnit::Pc => n * 16.0,
        LengthUnit::Em => n * font_size,
        LengthUnit::Ex => n * font_size / 2.0,
        LengthUnit::Percent => n * whole / 100.0,
    }
}

/// Whether a length is one of its surroundings: of the viewport or of the font's size.
#[must_use]
pub fn is_relative(length: Length) -> bool {
    matches!(length.unit, LengthUnit::Percent | LengthUnit::Em | LengthUnit::Ex)
}

/// A length in px; `None` for one that is relative.
#[must_use]
pub fn absolute(length: Length) -> Option<f64> {
    (!is_relative(length)).then(|| to_px(length, 0.0, 0.0))
}

/// The map of a view box into a viewport of `width` x `height`, by `preserveAspectRatio`'s value.
#[must_use]
pub fn view_box_map(view: svgtypes::ViewBox, width: f64, height: f64, aspect: Option<&str>) -> Affine {
    let ratio: svgtypes::AspectRatio = aspect.and_then(|a| a.parse().ok()).unwrap_or_default();
    let (sx, sy) = (width / view.w, height / view.h);
    let (sx, sy, across, up) = if ratio.align == svgtypes::Align::None {
        (sx, sy, 0.0, 0.0)
    } else {
        let s = if ratio.slice { sx.max(sy) } else { sx.min(sy) };
        let (fx, fy) = shares(ratio.align);
        (s, s, (width - view.w * s) * fx, (height - view.h * s) * fy)
    };
    Affine::new(sx, 0.0, 0.0, sy, across - view.x * sx, up - view.y * sy)
}

fn shares(align: svgtypes::Align) -> (f64, f64) {
    use svgtypes::Align;
    match align {
        Align::None | Align::XMinYMin => (0.0, 0.0),
        Align::XMidYMin => (0.5, 0.0),
        Align::XMaxYMin => (1.0, 0.0),
        Align::XMinYMid => (0.0, 0.5),
        Align::XMidYMid => (0.5, 0.5),
        Align::XMaxYMid => (1.0, 0.5),
        Align::XMinYMax => (0.0, 1.0),
        Align::XMidYMax => (0.5, 1.0),
        Align::XMaxYMax => (1.0, 1.0),
    }
}
