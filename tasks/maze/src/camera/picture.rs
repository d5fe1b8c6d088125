//! The image as the camera saw it, with the walls that were found in it and the path between them.

use std::io;

use mrroc_map::Place;
use mrroc_sensors::camera::Plane;
use nalgebra::{Point3, Vector2};

use super::run::Outcome;
use crate::places::{HEIGHT, LOW};

/// Walls that were found ..
const WALL: [u8; 3] = [255, 140, 0];
/// .. and the path.
const PATH: [u8; 3] = [0, 200, 255];

/// A picture in colour.
struct Picture {
    size: [usize; 2],
    rgb: Vec<u8>,
}

impl Picture {
    fn dot(&mut self, at: Vector2<f64>, colour: [u8; 3]) {
        let (x, y) = (at.x.round(), at.y.round());
        if x >= 0.0 && y >= 0.0 && x < self.size[0] as f64 && y < self.size[1] as f64 {
            let index = 3 * (y as usize * self.size[0] + x as usize);
            self.rgb[index..index + 3].copy_from_slice(&colour);
        }
    }

    fn line(&mut self, from: Vector2<f64>, to: Vector2<f64>, colour: [u8; 3]) {
        let steps = (2.0 * (to - from).norm()).ceil().max(1.0);
        for i in 0..=steps as u32 {
            self.dot(from + (to - from) * (f64::from(i) / steps), colour);
        }
    }
}

/// A PNG of what was seen, as far as the maze is in it: `camera` is the camera as it is believed to be.
///
/// # Errors
/// What the encoder says; there is no image.
#[allow(non_snake_case)]
pub fn png(outcome: &Outcome, camera: &Plane) -> io::Result<Vec<u8>> {
    let [width, height] = camera.camera.size;
    let image = &outcome.taken.image;
    if image.len() != width * height {
        return Err(io::Error::other("no image was taken"));
    }
    let rgb = image.iter().flat_map(|grey| [*grey; 3]).collect();
    let mut picture = Picture { size: [width, height], rgb };
    let mut window = [[0, width], [0, height]];
    if let Some(bars) = &outcome.taken.bars {
        let X_FM = bars.X_FM;
        let pixel = |at: Place, z: f64| {
            camera.project(&X_FM.transform_point(&Point3::new(at.x, at.y, z)).coords).unwrap_or_default()
        };
        for [lower, upper] in &bars.boxes {
            let corners = [*lower, Place::new(upper.x, lower.y), *upper, Place::new(lower.x, upper.y)];
            let corners = corners.map(|corner| pixel(corner, HEIGHT));
            for i in 0..4 {
                picture.line(corners[i], corners[(i + 1) % 4], WALL);
            }
        }
        if let Some(path) = &outcome.planned.path {
            for leg in path.points(1e-3, 5e-3).windows(2) {
                for off in [Vector2::zeros(), Vector2::x(), Vector2::y()] {
                    picture.line(pixel(leg[0], LOW) + off, pixel(leg[1], LOW) + off, PATH);
                }
            }
        }
        // With a margin around the outermost walls.
        for (axis, [from, to]) in window.iter_mut().enumerate() {
            let ends = bars.boxes.iter().flatten().map(|corner| pixel(*corner, HEIGHT)[axis]);
            let (low, high) = ends.fold((f64::INFINITY, 0.0_f64), |sum, at| (sum.0.min(at), sum.1.max(at)));
            *from = (low - 14.0).max(0.0) as usize;
            *to = ((high + 14.0).max(0.0) as usize).clamp(*from + 1, *to);
        }
    }
    let [[left, right], [top, bottom]] = window;
    let rows =
        (top..bottom).flat_map(|row| &picture.rgb[3 * (row * width + left)..3 * (row * width + right)]);
    let cut: Vec<u8> = rows.copied().collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, (right - left) as u32, (bottom - top) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&cut)?;
    Ok(file)
}
