//! The MCAP file of a recording.
//!
//! In: channels and messages. Out: whole chunks, in the order in which they become full: if the process is killed, the
//! file is valid up to its last chunk. The file is written without seeking, so that it may be a pipe.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{MAGIC, McapError, WriteOptions, Writer};
use serde_json::{Value, json};

use super::channels::Outlet;
use super::json::schema;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;

/// The profile of the files, and the name of the metadata that describes the cell.
pub(super) const PROFILE: &str = "mrroc";
/// The name of the metadata at the end.
pub(super) const END: &str = "mrroc.end";
/// The version of the contents of channels and metadata.
pub(super) const VERSION: &str = "1";
/// The name of the link of a cell that runs as processes in real time.
pub(super) const REAL_TIME: &str = "processes in real time";
/// The size at which a chunk is full \[bytes\].
const CHUNK: u64 = 256 * 1024;

/// A file that is being written.
pub(super) struct McapFile {
    writer: Writer<NoSeek<File>>,
    /// Number of messages of each channel.
    sequences: Vec<(u16, u32)>,
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}

/// Checks that a file can be written, as far as this can be known without waiting for the reader of a pipe. Of the files
/// that are there already, only recordings are written anew, and those that are empty.
pub(super) fn can_be_written(path: &Path) -> io::Result<()> {
    let is_special = path.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
    if is_special {
        return Ok(());
    }
    let file = OpenOptions::new().read(true).append(true).create(true).open(path)?;
    let mut begins = Vec::new();
    file.take(MAGIC.len() as u64).read_to_end(&mut begins)?;
    // A recording that was cut off has the beginning of the mark at least.
    if MAGIC.starts_with(&begins) {
        return Ok(());
    }
    Err(io::Error::new(
        io::ErrorKind::AlreadyExists,
        "it is there already and no recording: only those are written anew",
    ))
}

impl McapFile {
    /// Creates the file, with metadata that describes the cell.
    pub fn create(path: &Path, layout: &Layout, link: &str) -> io::Result<McapFile> {
        let options = WriteOptions::new()
            .profile(PROFILE)
            .library(concat!("mrroc ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .chunk_size(Some(CHUNK))
            .disable_seeking(true);
        let writer = options.create(NoSeek::new(File::create(path)?)).map_err(io_error)?;
        let mut file = McapFile { writer, sequences: Vec::new() };
        let about = [
            ("version", VERSION.to_owned()),
            ("step_ns", layout.step.as_nanos().to_string()),
            ("link", link.to_owned()),
            ("robots", robots(layout).to_string()),
            ("sensors", sensors(layout).to_string()),
        ];
        file.metadata(PROFILE, about)?;
        file.flush()?;
        Ok(file)
    }

    fn metadata<const N: usize>(&mut self, name: &str, about: [(&str, String); N]) -> io::Result<()> {
        let metadata: BTreeMap<_, _> =
            about.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        self.writer.write_metadata(&Metadata { name: name.to_owned(), metadata }).map_err(io_error)
    }
}

/// The robots, as the metadata describes them.
fn robots(layout: &Layout) -> Value {
    let robot = |robot: &mrroc_core::observe::layout::RobotLayout| {
        let units: Vec<_> = robot.joints.iter().map(|joint| joint.kind.unit(0)).collect();
        json!({"name": robot.name, "kind": robot.kind, "joints": units, "servo_ns": robot.servo.as_nanos() as u64})
    };
    layout.robots.iter().map(robot).collect()
}

/// The sensors, as the metadata describes them.
fn sensors(layout: &Layout) -> Value {
    let sensor = |sensor: &mrroc_core::observe::layout::SensorLayout| json!({"name": sensor.name, "kind": sensor.kind, "of": sensor.of, "reading": schema(sensor.reading)});
    layout.sensors.iter().map(sensor).collect()
}

impl Outlet for McapFile {
    fn open(&mut self, topic: &str, schema: &str, text: &str) -> io::Result<u16> {
        let schema = self.writer.add_schema(schema, "jsonschema", text.as_bytes()).map_err(io_error)?;
        let channel = self.writer.add_channel(schema, topic, "json", &BTreeMap::new()).map_err(io_error)?;
        if self.sequences.iter().all(|(known, _)| *known != channel) {
            self.sequences.push((channel, 0));
        }
        Ok(channel)
    }

    fn write(&mut self, channel: u16, time: Nanos, json: &str) -> io::Result<()> {
        let sequence =
            self.sequences.iter_mut().find(|(known, _)| *known == channel).map_or(0, |(_, count)| {
                *count = count.wrapping_add(1);
                *count
            });
        let header = MessageHeader { channel_id: channel, sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, json.as_bytes()).map_err(io_error)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(io_error)
    }

    fn finish(&mut self, messages: u64, dropped: u64) -> io::Result<()> {
        self.metadata(END, [("messages", messages.to_string()), ("dropped", dropped.to_string())])?;
        self.writer.finish().map(drop).map_err(io_error)
    }
}
