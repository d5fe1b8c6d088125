//! Light on the carved surface: Lambert and Blinn-Phong terms on normals of the height map, a bevelled rim, brushed
//! metal, darker grooves, and the plate's shadow on the bench.

use std::num::NonZero;
use std::thread;

use super::{Material, Picture};
use crate::placement::Plate;
use crate::plate::HeightMap;

/// What is drawn, and how large.
pub struct Frame<'a> {
    pub plate: &'a Plate,
    /// The bench around it \[mm\].
    pub bench: f64,
    /// Pixels of a millimetre.
    pub per_mm: f64,
    pub material: Material,
}

/// Radius of the plate's corners and width of its bevelled rim \[mm\].
const CORNER: f32 = 4.0;
const BEVEL: f32 = 1.1;

/// Towards the light: left, up, and out of the picture; of unit length.
const LIGHT: [f32; 3] = [-0.485, 0.566, 0.667];

type Rgb = [f32; 3];

/// Draws bench, shadow and plate, on all processors: this takes most of the time of a short run.
pub fn draw(picture: &mut Picture, map: &HeightMap, frame: &Frame<'_>) {
    let &mut Picture { width, height, ref mut rgb } = picture;
    let relief = &Relief {
        map,
        frame,
        colours: Colours::of(frame.material),
        deepest: (-map.deepest()).max(0.05),
        fine: (1.0 / (frame.per_mm * map.cell())).round().clamp(1.0, 4.0) as usize,
    };
    let rows = height.div_ceil(thread::available_parallelism().map_or(1, NonZero::get));
    thread::scope(|scope| {
        for (band, rgb) in rgb.chunks_mut(rows * width * 3).enumerate() {
            scope.spawn(move || {
                for (row, rgb) in rgb.chunks_mut(width * 3).enumerate() {
                    relief.draw_row(rgb, band * rows + row);
                }
            });
        }
    });
}

struct Relief<'a> {
    map: &'a HeightMap,
    frame: &'a Frame<'a>,
    colours: Colours,
    /// Depth of the deepest cell \[mm\].
    deepest: f32,
    /// Samples a pixel in each direction, so that no cell is missed.
    fine: usize,
}

impl Relief<'_> {
    /// Draws the row `py` of pixels.
    fn draw_row(&self, rgb: &mut [u8], py: usize) {
        let &Self { frame, fine, .. } = self;
        let share = 1.0 / (fine * fine) as f32;
        let fraction = |k: usize| (k as f64 + 0.5) / fine as f64;
        for (px, pixel) in rgb.as_chunks_mut().0.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            for sub in 0..fine * fine {
                let x = (px as f64 + fraction(sub % fine)) / frame.per_mm - frame.bench;
                let y = frame.plate.height + frame.bench - (py as f64 + fraction(sub / fine)) / frame.per_mm;
                for (total, c) in sum.iter_mut().zip(self.sample(x, y)) {
                    *total += c * share;
                }
            }
            *pixel = sum.map(|c| (c.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8);
        }
    }

    /// The linear colour at a place in plate coordinates \[mm\].
    fn sample(&self, x: f64, y: f64) -> Rgb {
        let &Self { map, frame, ref colours, deepest, .. } = self;
        let (half_w, half_h) = (frame.plate.width as f32 / 2.0, frame.plate.height as f32 / 2.0);
        let (cx, cy) = (x as f32 - half_w, y as f32 - half_h);
        let (outside, rim) = rounded(cx, cy, half_w, half_h);
        if outside > 0.0 {
            return bench(cx, cy, half_w, half_h);
        }
        let cell = map.cell();
        let (column, row) = ((x / cell).floor() as isize, (y / cell).floor() as isize);
        let at = |dx: isize, dy: isize| map.height(column + dx, row + dy);
        let run = 2.0 * cell as f32;
        let mut normal = [-(at(1, 0) - at(-1, 0)) / run, -(at(0, 1) - at(0, -1)) / run, 1.0];
        let depth = -at(0, 0);
        if -outside < BEVEL {
            normal[0] += rim[0] * 0.75;
            normal[1] += rim[1] * 0.75;
        }
        let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt();
        let normal = normal.map(|n| n / length);
        let groove = smooth(depth / (0.30 * deepest)).min(1.0);
        let grain = 1.0 + (brushed(x as f32, y as f32) - 0.5) * 0.10 * (1.0 - groove);
        // A broad sheen across the metal, as a window leaves it.
        let sheen = 1.0 + 0.20 * (-((cx * 0.7 - cy) / half_w + 0.25).powi(2) * 2.2).exp();
        let lambert = dot(normal, LIGHT).max(0.0);
        let half = unit([LIGHT[0], LIGHT[1], LIGHT[2] + 1.0]);
        let gloss = dot(normal, half).max(0.0).powi(48);
        let mut colour = [0.0; 3];
        for (k, c) in colour.iter_mut().enumerate() {
            let base = colours.metal[k] * (1.0 - groove) + colours.groove[k] * groove;
            let shine = colours.shine[k] * gloss * (0.55 - 0.40 * groove);
            *c = base * (0.20 + 1.08 * lambert) * grain * sheen + shine;
        }
        colour
    }
}

/// Signed distance from the plate's rounded outline (negative inside) \[mm\], and the outward direction there.
fn rounded(x: f32, y: f32, half_w: f32, half_h: f32) -> (f32, [f32; 2]) {
    let corner = CORNER.min(half_w).min(half_h);
    let (qx, qy) = (x.abs() - half_w + corner, y.abs() - half_h + corner);
    let (sx, sy) = (x.signum(), y.signum());
    if qx > 0.0 && qy > 0.0 {
        let d = qx.hypot(qy);
        return (d - corner, [sx * qx / d, sy * qy / d]);
    }
    if qx > qy { (qx - corner, [sx, 0.0]) } else { (qy - corner, [0.0, sy]) }
}

/// The bench: dark slate, lighter towards the light, with the plate's soft shadow to the lower right.
fn bench(x: f32, y: f32, half_w: f32, half_h: f32) -> Rgb {
    let (from_edge, _) = rounded(x - 1.4, y + 1.8, half_w, half_h);
    let shadow = 1.0 - 0.75 * (1.0 - smooth(from_edge / 5.0 + 0.15));
    let glow = 0.9 + 0.35 * (y / half_h - x / half_w).clamp(-2.0, 2.0) / 2.0;
    [0.030, 0.034, 0.040].map(|c| c * glow * shadow)
}

/// Fine horizontal streaks, 0..=1: noise that changes quickly across and slowly along the brush.
fn brushed(x: f32, y: f32) -> f32 {
    let layer = |along: f32, across: f32, salt: u32| {
        let row = below(y * across);
        let u = x * along + noise(row, 7, salt) * 50.0;
        let cell = below(u);
        let f = u - cell as f32;
        let (a, b) = (noise(cell, row, salt), noise(cell + 1, row, salt));
        a + (b - a) * f * f * (3.0 - 2.0 * f)
    };
    0.6 * layer(0.10, 9.0, 1) + 0.4 * layer(0.035, 4.0, 2)
}

/// The largest integer up to `x`: `floor` is a call of a function where the processor's own is not taken for granted.
fn below(x: f32) -> i32 {
    let whole = x as i32;
    whole - i32::from(x < whole as f32)
}

/// A number in 0..1 from two integers (Wang's hash).
fn noise(x: i32, y: i32, salt: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1)
        ^ (y as u32).wrapping_mul(0x85EB_CA77)
        ^ salt.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    ((h ^ (h >> 15)) & 0xFFFF) as f32 / 65536.0
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f32; 3]) -> [f32; 3] {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}

/// Linear colours of a material.
struct Colours {
    metal: Rgb,
    groove: Rgb,
    shine: Rgb,
}

impl Colours {
    fn of(material: Material) -> Self {
        match material {
            Material::Brass => {
                Self { metal: [0.62, 0.40, 0.12], groove: [0.085, 0.042, 0.012], shine: [1.0, 0.86, 0.55] }
            }
            Material::Steel => {
                Self { metal: [0.46, 0.48, 0.51], groove: [0.030, 0.032, 0.036], shine: [0.95, 0.97, 1.0] }
            }
        }
    }
}
