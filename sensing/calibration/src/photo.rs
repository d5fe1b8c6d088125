//! Photos in files: JPEG and PNG, as grey values.

use std::io::{Cursor, Read};
use std::path::Path;

use mrroc_launch::files;
use mrroc_sensors::aggregation::Grey;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The largest file of a photo \[bytes\], and its longest side \[pixel\].
const MOST: u64 = 1 << 26;
const SIDE: usize = 1 << 14;

/// A photo.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Photo {
    /// Pixels in a row, and rows.
    pub size: [usize; 2],
    /// Grey values, row by row.
    pub grey: Vec<u8>,
}

impl Photo {
    /// Reads a JPEG or a PNG file.
    ///
    /// # Errors
    /// What is wrong with it, and what to do.
    pub fn read(file: impl AsRef<Path>) -> Result<Self, String> {
        let file = file.as_ref();
        let told = |why: &dyn core::fmt::Display| format!("{}: {why}", file.display());
        let mut bytes = Vec::new();
        let opened = files::open(file).and_then(|opened| opened.take(MOST + 1).read_to_end(&mut bytes));
        opened.map_err(|why| told(&format!("the photo cannot be read: {why}")))?;
        if bytes.len() as u64 > MOST {
            return Err(told(&format!("more than {MOST} bytes\n help: save it smaller")));
        }
        Self::parse(&bytes).map_err(|why| told(&why))
    }

    /// Reads the bytes of such a file.
    ///
    /// # Errors
    /// What is wrong with them, and what to do.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let photo = match bytes {
            [0xff, 0xd8, ..] => jpeg(bytes)?,
            [0x89, b'P', b'N', b'G', ..] => png(bytes)?,
            _ => return Err("neither a JPEG nor a PNG\n help: save the photo as one of them".to_owned()),
        };
        match photo.grey() {
            Some(_) => Ok(photo),
            None => Err("the photo has no pixels, or fewer than it says\n help: save it again".to_owned()),
        }
    }

    /// Its pixels; `None` if they are not as many as its size says.
    #[must_use]
    pub fn grey(&self) -> Option<Grey<'_>> {
        Grey::new(self.size[0], self.size[1], &self.grey)
    }
}

const AGAIN: &str = "help: save it again, as an ordinary JPEG or PNG";

fn jpeg(bytes: &[u8]) -> Result<Photo, String> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::Luma)
        .set_max_width(SIDE)
        .set_max_height(SIDE)
        .set_strict_mode(false);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    let grey = decoder.decode().map_err(|why| format!("the JPEG cannot be read: {why:?}\n {AGAIN}"))?;
    let size = decoder.dimensions().ok_or_else(|| format!("the JPEG has no size\n {AGAIN}"))?;
    Ok(Photo { size: size.into(), grey })
}

fn png(bytes: &[u8]) -> Result<Photo, String> {
    let wrong = |why: &dyn core::fmt::Display| format!("the PNG cannot be read: {why}\n {AGAIN}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|why| wrong(&why))?;
    let size = [reader.info().width as usize, reader.info().height as usize];
    if size.iter().any(|side| *side > SIDE) {
        return Err(format!("more than {SIDE} pixels along a side\n help: save it smaller"));
    }
    let mut buffer = vec![0; reader.output_buffer_size().ok_or_else(|| wrong(&"it is too large"))?];
    let info = reader.next_frame(&mut buffer).map_err(|why| wrong(&why))?;
    buffer.truncate(info.buffer_size());
    // Luma of Rec. 601, as JPEG has it.
    let luma = |rgb: &[u8]| {
        let [r, g, b] = [rgb[0], rgb[1], rgb[2]].map(u32::from);
        u8::try_from((299 * r + 587 * g + 114 * b + 500) / 1000).unwrap_or(u8::MAX)
    };
    let grey = match info.color_type.samples() {
        1 => buffer,
        2 => buffer.chunks_exact(2).map(|one| one[0]).collect(),
        samples => buffer.chunks_exact(samples).map(luma).collect(),
    };
    Ok(Photo { size, grey })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_is_read_and_what_is_none_is_refused() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(&[255, 0, 0, 10, 10, 10]).expect("pixels");
        drop(writer);
        // 0.299 of 255.
        assert_eq!(Photo::parse(&bytes), Ok(Photo { size: [2, 1], grey: vec![76, 10] }));
        for wrong in [&bytes[..bytes.len() / 2], b"no photo", &[0xff, 0xd8, 1, 2], b""] {
            assert!(Photo::parse(wrong).is_err());
        }
    }
}
