//! Where the drawing goes on the plate: scaled as asked, centred, y up, never larger than the room inside the margin.

use crate::drawing::{Affine, Bounds, Drawing, Vec2};
use crate::error::DrawingError;

/// The plate; its lower left corner is the origin of plate coordinates, x right, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Width \[mm\], > 0.
    pub width: f64,
    /// Height \[mm\], > 0.
    pub height: f64,
    /// Kept free on every side \[mm\], >= 0.
    pub margin: f64,
}

impl Default for Plate {
    fn default() -> Self {
        Self { width: 200.0, height: 120.0, margin: 10.0 }
    }
}

impl Plate {
    /// Width and height inside the margins \[mm\].
    #[must_use]
    pub fn room(&self) -> Vec2 {
        Vec2::new(self.width - 2.0 * self.margin, self.height - 2.0 * self.margin)
    }
}

/// How large the drawing becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Sizing {
    /// As its file says.
    #[default]
    Natural,
    /// So many times as large, > 0.
    Scale(f64),
    /// As large as fits into so many millimetres, its proportions kept.
    Within {
        /// Width \[mm\], > 0.
        width: f64,
        /// Height \[mm\], > 0.
        height: f64,
    },
    /// As large as the plate has room for.
    Fill,
}

/// A drawing in plate coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// The drawing \[mm\].
    pub drawing: Drawing,
    /// Its box \[mm\].
    pub bounds: Bounds,
    /// How many times larger than in the file.
    pub scale: f64,
}

/// Places the drawing in the middle of the plate.
///
/// # Errors
/// [`DrawingError::LargerThanPlate`] with both sizes and the flags that help; [`DrawingError::Empty`].
pub fn place(drawing: &Drawing, plate: &Plate, sizing: Sizing) -> Result<Placement, DrawingError> {
    let bounds = drawing.bounds().ok_or_else(|| DrawingError::Empty {
        file: "drawing".to_owned(),
        found: "no stroke".to_owned(),
        help: "give a drawing with visible curves".to_owned(),
    })?;
    let size = bounds.size();
    let scale = match sizing {
        Sizing::Natural => 1.0,
        Sizing::Scale(scale) => scale,
        Sizing::Within { width, height } => fit(size, Vec2::new(width, height)),
        Sizing::Fill => fit(size, plate.room()),
    };
    let room = plate.room();
    let scaled = size * scale;
    let rounding = 1e-6;
    if !scale.is_finite() || scaled.x > room.x + rounding || scaled.y > room.y + rounding {
        return Err(DrawingError::LargerThanPlate {
            width: scaled.x,
            height: scaled.y,
            room_width: room.x,
            room_height: room.y,
            margin: plate.margin,
            help: advice(scaled, plate, fit(size, room)),
        });
    }
    let centre = Vec2::new(plate.width / 2.0, plate.height / 2.0);
    let map = Affine::translation(centre)
        .after(&Affine::scaling(scale, scale))
        .after(&Affine::translation(-bounds.centre()));
    let drawing = drawing.transformed(&map);
    let half = scaled * 0.5;
    Ok(Placement { drawing, bounds: Bounds { min: centre - half, max: centre + half }, scale })
}

/// The largest scale at which `size` fits into `room`.
fn fit(size: Vec2, room: Vec2) -> f64 {
    let one = |size: f64, room: f64| if size > 1e-9 { room / size } else { f64::INFINITY };
    one(size.x, room.x).min(one(size.y, room.y))
}

fn advice(scaled: Vec2, plate: &Plate, fitting: f64) -> String {
    let down = (fitting * 1000.0).floor() / 1000.0;
    let needed = scaled + Vec2::new(2.0, 2.0) * plate.margin;
    let mut help = format!(
        "use --fit, --scale {down}, or a larger --plate {:.0}x{:.0}",
        needed.x.ceil(),
        needed.y.ceil()
    );
    let room = plate.room();
    let as_inches = scaled / 25.4;
    let far = scaled.x > 3.0 * room.x || scaled.y > 3.0 * room.y;
    if far && as_inches.x <= room.x && as_inches.y <= room.y {
        help.push_str(&format!(
            "; it would be {:.1} x {:.1} mm if its numbers were meant in millimetres and read as inches (check G20/G21 or $INSUNITS)",
            as_inches.x, as_inches.y
        ));
    }
    help
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Piece, Stroke};

    fn diagonal(width: f64, height: f64) -> Drawing {
        let piece = Piece::Line { from: Vec2::new(3.0, 4.0), to: Vec2::new(3.0 + width, 4.0 + height) };
        Drawing { strokes: vec![Stroke::new(vec![piece]).unwrap()] }
    }

    #[test]
    fn a_drawing_keeps_its_size_in_the_middle() {
        let placed = place(&diagonal(40.0, 20.0), &Plate::default(), Sizing::Natural).unwrap();
        assert_eq!(placed.bounds.min, Vec2::new(80.0, 50.0));
        assert!((placed.drawing.bounds().unwrap().max - Vec2::new(120.0, 70.0)).norm() < 1e-9);
    }

    #[test]
    fn filling_keeps_proportions() {
        let placed = place(&diagonal(10.0, 10.0), &Plate::default(), Sizing::Fill).unwrap();
        assert!((placed.bounds.size() - Vec2::new(100.0, 100.0)).norm() < 1e-9);
        let within = Sizing::Within { width: 50.0, height: 90.0 };
        assert!((place(&diagonal(10.0, 0.0), &Plate::default(), within).unwrap().scale - 5.0).abs() < 1e-9);
    }

    #[test]
    fn too_large_a_drawing_is_refused_with_numbers_and_flags() {
        let error =
            place(&diagonal(300.0, 20.0), &Plate::default(), Sizing::Natural).unwrap_err().to_string();
        for part in ["300.0 x 20.0 mm", "180.0 x 100.0 mm", "--fit", "--scale 0.6", "--plate 320x40"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(!error.contains("inches"));
        let error =
            place(&diagonal(2540.0, 1270.0), &Plate::default(), Sizing::Natural).unwrap_err().to_string();
        assert!(
            error.contains("100.0 x 50.0 mm if its numbers were meant in millimetres and read as inches"),
            "{error}"
        );
    }
}
