//! The caption and the scale bar, drawn in the same single-stroke font that engraves texts.

use super::Picture;
use super::relief::Frame;
use crate::drawing::{Vec2, hershey::Font};

const INK: [f32; 3] = [0.80, 0.80, 0.77];

/// Writes the caption at the left and the scale bar at the right of the strip below the plate, which is so high \[mm\].
pub fn draw(picture: &mut Picture, frame: &Frame<'_>, strip: f64, caption: &str) {
    let &Frame { plate, bench, per_mm, .. } = frame;
    let pen = Pen { per_mm, half_width: 0.16, capital: CAPITAL };
    let baseline = bench + plate.height + bench * 0.55 + strip * 0.55;
    let length = bar_length(plate.width);
    let right = bench + plate.width;
    let left = right - length;
    let tick = 1.1;
    pen.line(picture, Vec2::new(left, baseline), Vec2::new(right, baseline));
    for k in 0..=5 {
        let x = left + length * f64::from(k) / 5.0;
        let height = if k % 5 == 0 { 1.6 * tick } else { tick };
        pen.line(picture, Vec2::new(x, baseline), Vec2::new(x, baseline - height));
    }
    let label = format!("{length:.0} mm");
    let used = pen.width(&label);
    pen.write(picture, &label, Vec2::new(left - used - 2.0, baseline));
    let room = left - used - 6.0 - bench;
    // A caption that is too long is written smaller, as long as it can be read.
    let width = pen.width(caption);
    let pen = if width > room { Pen { capital: CAPITAL * room / width, ..pen } } else { pen };
    if pen.capital > SMALLEST_CAPITAL {
        pen.write(picture, caption, Vec2::new(bench, baseline));
    }
}

/// A round length that is about a quarter of the plate.
fn bar_length(width: f64) -> f64 {
    let mut length = 1.0;
    for step in [2.5, 2.0, 2.0].into_iter().cycle().take(12) {
        if length * step > width / 3.0 {
            break;
        }
        length *= step;
    }
    length
}

/// Draws lines given in millimetres from the upper left corner.
struct Pen {
    per_mm: f64,
    half_width: f64,
    /// Height of capitals \[mm\].
    capital: f64,
}

/// Height of capitals \[mm\], and the smallest.
const CAPITAL: f64 = 2.9;
const SMALLEST_CAPITAL: f64 = 1.4;

impl Pen {
    fn lines(&self, text: &str) -> Vec<Vec<Vec2>> {
        // Characters that the font lacks are left out of a caption.
        let written =
            Font::open("futural").and_then(|font| font.write(&font.engravable(text).0, self.capital));
        written
            .map(|import| import.drawing.strokes.iter().map(|s| s.flattened(0.02)).collect())
            .unwrap_or_default()
    }

    fn width(&self, text: &str) -> f64 {
        let lines = self.lines(text);
        let xs = || lines.iter().flatten().map(|p| p.x);
        let (low, high) = (xs().fold(f64::MAX, f64::min), xs().fold(f64::MIN, f64::max));
        (high - low).max(0.0)
    }

    fn write(&self, picture: &mut Picture, text: &str, at: Vec2) {
        let lines = self.lines(text);
        let left = lines.iter().flatten().map(|p| p.x).fold(f64::MAX, f64::min);
        for w in lines.iter().flat_map(|line| line.windows(2)) {
            let to_page = |p: Vec2| Vec2::new(at.x + p.x - left, at.y - p.y);
            self.line(picture, to_page(w[0]), to_page(w[1]));
        }
    }

    /// A line with smooth edges.
    fn line(&self, picture: &mut Picture, from: Vec2, to: Vec2) {
        let (a, b) = (from * self.per_mm, to * self.per_mm);
        let reach = self.half_width * self.per_mm + 1.0;
        let clip = |low: f64, high: f64, size: usize| {
            ((low - reach).max(0.0) as usize).min(size)..((high + reach).max(0.0) as usize).min(size)
        };
        let along = b - a;
        let squared = along.norm_squared().max(1e-12);
        for y in clip(a.y.min(b.y), a.y.max(b.y), picture.height) {
            for x in clip(a.x.min(b.x), a.x.max(b.x), picture.width) {
                let p = Vec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let t = ((p - a).dot(&along) / squared).clamp(0.0, 1.0);
                let distance = (p - a - along * t).norm();
                let cover = (reach - 0.5 - distance).clamp(0.0, 1.0);
                if cover > 0.0 {
                    picture.blend(x, y, INK, cover as f32);
                }
            }
        }
    }
}
