//! Camera images as PNG files: rims in the colour of their class, axes, and names.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use mrroc_sensors::aggregation::DetectedObject;
use mrroc_sensors::camera::Plane;
use nalgebra::{Vector2, Vector3};

use super::kinds::{KINDS, kinds};

/// A colour for each class, and for what is none.
const COLOURS: [[u8; 3]; KINDS + 1] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 200, 140],
    [240, 228, 66],
    [120, 140, 255],
    [255, 110, 60],
    [230, 130, 200],
    [150, 230, 90],
    [255, 40, 60],
];
/// Letters of 3 x 5 pixels, a row in each three bits from the top.
const LETTERS: [(char, u16); 20] = [
    ('a', 0b010_101_111_101_101),
    ('b', 0b110_101_110_101_110),
    ('c', 0b011_100_100_100_011),
    ('d', 0b110_101_101_101_110),
    ('e', 0b111_100_110_100_111),
    ('f', 0b111_100_110_100_100),
    ('g', 0b011_100_101_101_011),
    ('h', 0b101_101_111_101_101),
    ('i', 0b111_010_010_010_111),
    ('k', 0b101_101_110_101_101),
    ('l', 0b100_100_100_100_111),
    ('m', 0b101_111_111_101_101),
    ('n', 0b110_101_101_101_101),
    ('o', 0b010_101_101_101_010),
    ('p', 0b110_101_110_100_100),
    ('r', 0b110_101_110_101_101),
    ('s', 0b011_100_010_001_110),
    ('t', 0b111_010_010_010_010),
    ('y', 0b101_101_010_010_010),
    ('-', 0b000_000_111_000_000),
];
/// Pixels of a letter's pixel.
const LARGE: usize = 3;

/// A picture in colour.
struct Canvas {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    fn set(&mut self, x: f64, y: f64, colour: [u8; 3]) {
        let (x, y) = (x.round(), y.round());
        if x >= 0.0 && y >= 0.0 && (x as usize) < self.width {
            let index = y as usize * self.width + x as usize;
            if let Some(pixel) = self.pixels.get_mut(index) {
                *pixel = colour;
            }
        }
    }

    fn line(&mut self, from: Vector2<f64>, to: Vector2<f64>, colour: [u8; 3]) {
        let steps = (to - from).norm().ceil().max(1.0) as usize;
        for step in 0..=steps {
            let at = from + (to - from) * (step as f64 / steps as f64);
            self.set(at.x, at.y, colour);
            self.set(at.x + 1.0, at.y, colour);
        }
    }

    fn text(&mut self, x: usize, y: usize, text: &str, colour: [u8; 3]) {
        for (place, letter) in text.chars().enumerate() {
            let Some((_, rows)) = LETTERS.iter().find(|(of, _)| *of == letter) else { continue };
            for bit in (0..15).filter(|bit| rows >> (14 - bit) & 1 == 1) {
                for (i, j) in (0..LARGE).flat_map(|i| (0..LARGE).map(move |j| (i, j))) {
                    let column = x + (place * 4 + bit % 3) * LARGE + i;
                    self.set(column as f64, (y + bit / 3 * LARGE + j) as f64, colour);
                }
            }
        }
    }
}

/// Writes an image with what was found in it, as the camera `plane` sees it. Grey values are brightened a little.
///
/// # Errors
/// The file cannot be written.
pub fn draw(file: &Path, image: &[u8], found: &[DetectedObject], plane: &Plane) -> io::Result<()> {
    let kinds = kinds();
    let width = plane.width();
    let pixels = image.iter().map(|grey| [grey.saturating_add(grey / 4); 3]).collect();
    let mut canvas = Canvas { width, pixels };
    for thing in found {
        let colour = COLOURS[thing.class.unwrap_or(KINDS)];
        for index in thing.blob.rim(width) {
            canvas.set((index % width) as f64, (index / width) as f64, colour);
        }
        let name = thing.class.map_or("strange", |class| kinds[class].class.name);
        let [[left, _], [top, _]] = thing.blob.window;
        canvas.text(left, top.saturating_sub(8 * LARGE), name, colour);
        if thing.class.is_some() {
            // The axes of P on the belt: x longer than y.
            let end = |angle: f64, length: f64| {
                let at = thing.place + Vector2::new(angle.cos(), angle.sin()) * length;
                plane.project(&Vector3::new(at.x, at.y, 0.0))
            };
            for (angle, length) in [(thing.angle, 0.03), (thing.angle + core::f64::consts::FRAC_PI_2, 0.018)]
            {
                if let (Some(from), Some(to)) = (end(angle, 0.0), end(angle, length)) {
                    canvas.line(from, to, colour);
                }
            }
        }
    }
    let mut encoder =
        png::Encoder::new(BufWriter::new(File::create(file)?), width as u32, plane.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(&canvas.pixels.concat()).map_err(io::Error::other)
}

/// The grey values of a PNG file of this many columns and rows.
///
/// # Errors
/// The file cannot be read, or is no such image.
pub fn read(file: &Path, size: [usize; 2]) -> io::Result<Vec<u8>> {
    let decoder = png::Decoder::new(std::io::BufReader::new(File::open(file)?));
    let mut reader = decoder.read_info().map_err(io::Error::other)?;
    let bytes = reader.output_buffer_size().ok_or_else(|| io::Error::other("the image is too large"))?;
    let mut pixels = vec![0; bytes];
    let info = reader.next_frame(&mut pixels).map_err(io::Error::other)?;
    let fits = [info.width as usize, info.height as usize] == size
        && (info.color_type, info.bit_depth) == (png::ColorType::Grayscale, png::BitDepth::Eight);
    if !fits {
        let text = format!("{} x {} pixels {:?}", info.width, info.height, info.color_type);
        return Err(io::Error::other(format!(
            "{text}: it must have {} x {}, grey, of 8 bits",
            size[0], size[1]
        )));
    }
    pixels.truncate(size[0] * size[1]);
    Ok(pixels)
}

/// Writes the grey values of an image of this many columns and rows as a PNG file.
///
/// # Errors
/// The file cannot be written.
pub fn write(file: &Path, image: &[u8], size: [usize; 2]) -> io::Result<()> {
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(file)?), size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(image).map_err(io::Error::other)
}
