//! `plate.png`: the carved plate in brass under light from the upper left, on a dark bench with a scale bar.

mod lettering;
mod relief;

use crate::placement::Plate;
use crate::plate::HeightMap;
use std::io::{BufWriter, Write};
use std::path::Path;

/// An image of 8-bit RGB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width \[pixels\].
    pub width: usize,
    /// Height \[pixels\].
    pub height: usize,
    /// Rows from the top, three bytes a pixel.
    pub rgb: Vec<u8>,
}

/// What the plate is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Material {
    /// Brushed brass.
    #[default]
    Brass,
    /// Brushed steel.
    Steel,
}

/// The most pixels across.
const WIDEST: f64 = 2240.0;

/// The bench around the plate \[mm\], and the strip below it for the caption.
const BENCH: f64 = 9.0;
const CAPTION: f64 = 11.0;

/// Draws the plate with a caption below it at the left.
#[must_use]
pub fn render(map: &HeightMap, plate: &Plate, material: Material, caption: &str) -> Picture {
    let across = plate.width + 2.0 * BENCH;
    let down = plate.height + 2.0 * BENCH + CAPTION;
    // At most as fine as the cells: two cells a pixel in each direction smooth the edges.
    let per_mm = (WIDEST / across).min(1.0 / map.cell()).min(3000.0 / down);
    let width = (across * per_mm).round().max(1.0) as usize;
    let height = (down * per_mm).round().max(1.0) as usize;
    let mut picture = Picture { width, height, rgb: vec![0; width * height * 3] };
    let frame = relief::Frame { plate, bench: BENCH, per_mm, material };
    relief::draw(&mut picture, map, &frame);
    lettering::draw(&mut picture, &frame, CAPTION, caption);
    picture
}

impl Picture {
    /// Writes the image as PNG.
    ///
    /// # Errors
    /// What the file system or the encoder reports.
    pub fn write_png(&self, path: &Path) -> std::io::Result<()> {
        let file = BufWriter::new(std::fs::File::create(path)?);
        self.encode(file).map_err(std::io::Error::other)
    }

    fn encode(&self, to: impl Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(to, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        encoder.write_header()?.write_image_data(&self.rgb)
    }

    /// Lays a colour over a pixel with the given opacity, 0..=1.
    fn blend(&mut self, x: usize, y: usize, colour: [f32; 3], opacity: f32) {
        let at = (y * self.width + x) * 3;
        for (byte, c) in self.rgb[at..at + 3].iter_mut().zip(colour) {
            let mixed = f32::from(*byte) * (1.0 - opacity) + c * 255.0 * opacity;
            *byte = mixed.clamp(0.0, 255.0) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plate::{Cutter, Tip};

    #[test]
    fn a_groove_is_darker_than_the_plate_and_the_png_can_be_read() {
        let plate = Plate { width: 30.0, height: 20.0, margin: 2.0 };
        let mut map = HeightMap::new(&plate, 0.1, Cutter::default());
        map.move_to(Tip::new(5.0, 10.0, -0.8));
        map.move_to(Tip::new(25.0, 10.0, -0.8));
        map.finish();
        let picture = render(&map, &plate, Material::Brass, "test");
        let per_mm = picture.width as f64 / 48.0;
        let brightness = |x: f64, y: f64| {
            let (px, py) = (((x + BENCH) * per_mm) as usize, ((20.0 - y + BENCH) * per_mm) as usize);
            let at = (py * picture.width + px) * 3;
            picture.rgb[at..at + 3].iter().map(|b| u32::from(*b)).sum::<u32>()
        };
        assert!(brightness(15.0, 10.0) * 2 < brightness(15.0, 15.0));
        let mut bytes = Vec::new();
        picture.encode(&mut bytes).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        assert_eq!(reader.info().width as usize, picture.width);
    }
}
