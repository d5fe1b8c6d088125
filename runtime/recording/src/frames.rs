//! The frames of a sensor, images and echoes, in files: an MCAP file beside the recording, and PNG files.
//!
//! In: frames, on a thread of the sensor's own process ([`Frames`](mrroc_core::sensor::Frames)). Out: messages of the schemas
//! that follow, at the date of the step in which the frame was taken, as in the recording itself; a viewer opens both files
//! together. Each file learns the start of the run by itself, so they may differ by milliseconds. A file is made with the
//! first frame.
//!
//! | channel | what | schema |
//! |---|---|---|
//! | `/sensors/NAME/image` | an image, as PNG | `foxglove.CompressedImage`, in its form as JSON |
//! | `/sensors/NAME/echo` | the samples of an echo | `mrroc.Echo` |

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};
use mrroc_core::observe::recording::FramesTo;
use mrroc_core::sensor::{Content, Frame, FrameSink};
use serde_json::{Value, json};

use crate::file::{END, PROFILE, can_be_written, wall_clock};

/// Writes the frames of one sensor.
pub(super) struct FrameFiles {
    sensor: String,
    step_ns: u64,
    /// The date of the cell's time 0 \[ns\], learnt from the first frame, as the recording learns it from its first message.
    start: Option<u64>,
    recording: Option<PathBuf>,
    folder: Option<PathBuf>,
    mcap: Option<McapFrames>,
    /// Whether the folder of its images is there.
    has_folder: bool,
    png: Vec<u8>,
    text: String,
    written: u64,
}

impl FrameFiles {
    pub fn of(to: &FramesTo, sensor: &str) -> FrameFiles {
        // `run.mcap` has the frames of `camera` in `run.camera.mcap`.
        let recording = to.recording.as_ref().filter(|recording| recording.has_sensor(sensor));
        let recording = recording.map(|recording| recording.file().with_extension(format!("{sensor}.mcap")));
        FrameFiles {
            sensor: sensor.to_owned(),
            step_ns: u64::try_from(to.step.as_nanos()).unwrap_or(u64::MAX),
            start: None,
            recording,
            folder: to.folder.as_ref().map(|folder| folder.join(sensor)),
            mcap: None,
            has_folder: false,
            png: Vec::new(),
            text: String::new(),
            written: 0,
        }
    }

    /// Keeps an image as `NNNNNNNN.png`, named by its step.
    fn keep_image(&mut self, step: u64) -> io::Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        if !self.has_folder {
            fs::create_dir_all(folder).map_err(|error| of_file(folder, &error))?;
            let is_empty = fs::read_dir(folder)?.next().is_none();
            if !is_empty {
                let error = io::Error::other("it has files already; give an empty folder by --frames");
                return Err(of_file(folder, &error));
            }
            self.has_folder = true;
        }
        let file = folder.join(format!("{step:08}.png"));
        fs::write(&file, &self.png).map_err(|error| of_file(&file, &error))
    }

    /// Writes the message of a frame.
    fn record(&mut self, frame: &Frame) -> io::Result<()> {
        let Some(file) = &self.recording else { return Ok(()) };
        let mcap = match &mut self.mcap {
            Some(mcap) => mcap,
            none => {
                none.insert(McapFrames::create(file, &self.sensor).map_err(|error| of_file(file, &error))?)
            }
        };
        let time = frame.step().saturating_mul(self.step_ns);
        let start = *self.start.get_or_insert_with(|| wall_clock().saturating_sub(time));
        let time = start.saturating_add(time);
        self.text.clear();
        let channel = match frame.content() {
            Content::Image { .. } => {
                let (sec, nsec) = (time / 1_000_000_000, time % 1_000_000_000);
                // Writing to a text cannot fail.
                let _ = write!(
                    self.text,
                    "{{\"timestamp\":{{\"sec\":{sec},\"nsec\":{nsec}}},\"frame_id\":{},\"data\":\"",
                    json!(self.sensor)
                );
                base64(&self.png, &mut self.text);
                self.text.push_str("\",\"format\":\"png\"}");
                mcap.image
            }
            Content::Echo { interval } => {
                let _ =
                    write!(self.text, "{{\"step\":{},\"interval\":{interval:?},\"samples\":[", frame.step());
                for (i, sample) in frame.samples().enumerate() {
                    let comma = if i > 0 { "," } else { "" };
                    // JSON has no numbers that are not finite: as in the recording they are texts.
                    let _ = match (sample.is_finite(), sample.is_nan()) {
                        (true, _) => write!(self.text, "{comma}{sample:?}"),
                        (false, true) => write!(self.text, "{comma}\"NaN\""),
                        (false, false) if sample > 0.0 => write!(self.text, "{comma}\"Infinity\""),
                        (false, false) => write!(self.text, "{comma}\"-Infinity\""),
                    };
                }
                self.text.push_str("]}");
                mcap.echo
            }
        };
        mcap.write(channel, time, self.text.as_bytes()).map_err(|error| of_file(file, &error))
    }
}

impl FrameSink for FrameFiles {
    fn write(&mut self, frame: &Frame) -> io::Result<()> {
        if let Content::Image { width, height, channels, depth } = frame.content() {
            encode(&mut self.png, (width, height), channels, depth, frame.bytes())?;
            self.keep_image(frame.step())?;
        }
        self.record(frame)?;
        self.written += 1;
        Ok(())
    }

    fn finish(&mut self, dropped: u64) -> io::Result<()> {
        let Some(mcap) = &mut self.mcap else { return Ok(()) };
        mcap.finish(self.written, dropped)
    }
}

/// An MCAP file of frames.
struct McapFrames {
    writer: Writer<io::BufWriter<File>>,
    image: u16,
    echo: u16,
    sequence: u32,
}

impl McapFrames {
    fn create(path: &Path, sensor: &str) -> io::Result<McapFrames> {
        can_be_written(path)?;
        let options = WriteOptions::new()
            .profile(PROFILE)
            .library(concat!("mrroc ", env!("CARGO_PKG_VERSION")))
            // PNG is compressed already.
            .compression(None);
        let mut writer = options.create(io::BufWriter::new(File::create(path)?)).map_err(io::Error::other)?;
        let mut open = |name: &str, topic: &str, schema: &Value| {
            let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
            writer.add_channel(schema, &format!("/sensors/{sensor}/{topic}"), "json", &BTreeMap::new())
        };
        let image =
            open("foxglove.CompressedImage", "image", &compressed_image()).map_err(io::Error::other)?;
        let echo = open("mrroc.Echo", "echo", &echo()).map_err(io::Error::other)?;
        Ok(McapFrames { writer, image, echo, sequence: 0 })
    }

    fn write(&mut self, channel_id: u16, time: u64, json: &[u8]) -> io::Result<()> {
        self.sequence = self.sequence.wrapping_add(1);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, json).map_err(io::Error::other)
    }

    fn finish(&mut self, written: u64, dropped: u64) -> io::Result<()> {
        let about = [("messages", written), ("dropped", dropped)];
        let metadata = about.map(|(key, count)| (key.to_owned(), count.to_string())).into();
        let metadata = Metadata { name: END.to_owned(), metadata };
        self.writer.write_metadata(&metadata).map_err(io::Error::other)?;
        self.writer.finish().map(drop).map_err(io::Error::other)
    }
}

/// The public schema of a compressed image, of which a viewer knows the name.
fn compressed_image() -> Value {
    json!({
        "title": "foxglove.CompressedImage", "type": "object",
        "properties": {
            "timestamp": {
                "type": "object", "title": "time",
                "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999}}
            },
            "frame_id": {"type": "string"},
            "data": {"type": "string", "contentEncoding": "base64"},
            "format": {"type": "string"}
        }
    })
}

fn echo() -> Value {
    json!({
        "type": "object", "required": ["step", "interval", "samples"],
        "properties": {
            "step": {"type": "integer"},
            "interval": {"type": "number", "description": "from one sample to the next [s]"},
            "samples": {"type": "array", "items": {"type": ["number", "string"]}}
        }
    })
}

/// An image as PNG, instead of what `png` had.
fn encode(
    png: &mut Vec<u8>,
    (width, height): (u32, u32),
    channels: u8,
    depth: u8,
    bytes: &[u8],
) -> io::Result<()> {
    png.clear();
    let mut encoder = png::Encoder::new(png, width, height);
    encoder.set_color(match channels {
        1 => png::ColorType::Grayscale,
        2 => png::ColorType::GrayscaleAlpha,
        3 => png::ColorType::Rgb,
        _ => png::ColorType::Rgba,
    });
    encoder.set_depth(if depth == 2 { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(bytes).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)
}

/// Base64 (RFC 4648, section 4), appended to a text.
fn base64(bytes: &[u8], text: &mut String) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    text.reserve(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let word = [0, 1, 2].map(|i| u32::from(group.get(i).copied().unwrap_or(0)));
        let word = word[0] << 16 | word[1] << 8 | word[2];
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= group.len() { char::from(digit) } else { '=' });
        }
    }
}

fn of_file(file: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_is_that_of_the_standard() {
        let texts = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (bytes, expected) in texts {
            let mut text = String::new();
            base64(bytes.as_bytes(), &mut text);
            assert_eq!(text, expected);
        }
    }
}
