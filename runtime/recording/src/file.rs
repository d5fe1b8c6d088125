//! The MCAP file of a recording.
//!
//! In: channels and messages, at times of the cell. Out: whole chunks, in the order in which they become full, compressed by
//! LZ4: if the process is killed, the file is valid up to its last chunk. The file is written without seeking, so that it
//! may be a pipe. What the messages say of places is written once more for 3D viewers ([`scene`](super::scene)).
//!
//! Viewers show the time of a message as a date, so its log time is that of the wall clock: the date at which the file
//! received the first message, and from then on the cell's time. The date of the cell's time 0 is in the metadata.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, SystemTime};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, MAGIC, McapError, WriteOptions, Writer};
use serde_json::{Value, json};

use super::channels::Outlet;
use super::foxglove::{FRAME_TRANSFORMS, SCENE_UPDATE, frame_transforms, scene_update};
use super::json::schema;
use super::scene::Scene;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;

/// The profile of the files, and the name of the metadata that describes the cell.
pub(super) const PROFILE: &str = "mrroc";
/// The name of the metadata at the end.
pub(super) const END: &str = "mrroc.end";
/// The name of the metadata with the date of the cell's time 0, which come before the first message.
pub(super) const START: &str = "mrroc.start";
/// The version of the contents of channels and metadata.
pub(super) const VERSION: &str = "2";
/// The name of the link of a cell that runs as processes in real time.
pub(super) const REAL_TIME: &str = "processes in real time";
/// The size at which a chunk is full \[bytes\].
const CHUNK: u64 = 256 * 1024;

/// A file that is being written.
pub(super) struct McapFile {
    writer: Writer<NoSeek<File>>,
    /// Number of messages of each channel.
    sequences: Vec<(u16, u32)>,
    /// The date of the cell's time 0 \[ns since 1970, UTC\]; `None` before the first message.
    start: Option<Nanos>,
    scene: Scene,
    /// The channels of the scene, once there is one: frames, and bodies.
    scene_channels: Option<[u16; 2]>,
    /// Whether the obstacles were written, if there are any.
    has_obstacles: bool,
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}

/// How long to wait for what makes no progress in writing this file. A disk that many programs write to stands still for
/// seconds, and goes on; a pipe that nobody reads does not.
pub(super) fn write_timeout(path: &Path) -> Duration {
    let is_special = path.metadata().is_ok_and(|metadata| !metadata.is_file());
    Duration::from_secs(if is_special { 3 } else { 60 })
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
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK))
            .disable_seeking(true);
        let writer = options.create(NoSeek::new(File::create(path)?)).map_err(io_error)?;
        let (sequences, scene) = (Vec::new(), Scene::of(layout));
        let mut file =
            McapFile { writer, sequences, start: None, scene, scene_channels: None, has_obstacles: false };
        let about = [
            ("version", VERSION.to_owned()),
            ("step_ns", layout.step.as_nanos().to_string()),
            ("link", link.to_owned()),
            ("robots", robots(layout).to_string()),
            ("sensors", sensors(layout).to_string()),
            ("bodies", bodies(layout).to_string()),
            ("cells", cells(layout).to_string()),
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

    /// The date of the cell's time 0, learnt from the first message, which is at `time`.
    fn start(&mut self, time: Nanos) -> io::Result<Nanos> {
        if let Some(start) = self.start {
            return Ok(start);
        }
        let start = wall_clock().saturating_sub(time);
        self.start = Some(start);
        self.metadata(START, [("start_ns", start.to_string())])?;
        Ok(start)
    }

    /// Writes a message at a time of the wall clock.
    fn write_at(&mut self, channel: u16, date: Nanos, json: &[u8]) -> io::Result<()> {
        let sequence =
            self.sequences.iter_mut().find(|(known, _)| *known == channel).map_or(0, |(_, count)| {
                *count = count.wrapping_add(1);
                *count
            });
        let header = MessageHeader { channel_id: channel, sequence, log_time: date, publish_time: date };
        self.writer.write_to_known_channel(&header, json).map_err(io_error)
    }

    /// Writes what stands in the cell, once.
    fn write_obstacles(&mut self, date: Nanos) -> io::Result<()> {
        if core::mem::replace(&mut self.has_obstacles, true) {
            return Ok(());
        }
        let Some(update) = self.scene.obstacles(date) else { return Ok(()) };
        let channel = self.open("/obstacles", SCENE_UPDATE, &scene_update().to_string())?;
        self.write_at(channel, date, update.to_string().as_bytes())
    }

    /// Writes what a message says of places, if it says any and the last ones are old enough.
    fn write_scene(&mut self, channel: u16, time: Nanos, date: Nanos, json: &str) -> io::Result<()> {
        if !self.scene.wants(channel, time) {
            return Ok(());
        }
        self.write_obstacles(date)?;
        let Some(update) = self.scene.update(channel, date, json) else { return Ok(()) };
        let [frames, bodies] = match self.scene_channels {
            Some(channels) => channels,
            None => {
                let frames = self.open("/tf", FRAME_TRANSFORMS, &frame_transforms().to_string())?;
                let bodies = self.open("/scene", SCENE_UPDATE, &scene_update().to_string())?;
                *self.scene_channels.insert([frames, bodies])
            }
        };
        self.write_at(frames, date, update.frames.to_string().as_bytes())?;
        self.write_at(bodies, date, update.bodies.to_string().as_bytes())
    }
}

/// The date \[ns since 1970, UTC\].
#[expect(clippy::disallowed_methods, reason = "the date of a recording, which nothing acts on")]
pub(crate) fn wall_clock() -> Nanos {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |since| since.as_nanos() as Nanos)
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

/// The bodies, as the metadata describes them.
fn bodies(layout: &Layout) -> Value {
    layout.bodies.iter().map(|body| json!({"name": body.name, "edges": body.edges})).collect()
}

/// The lower cells, as the metadata describes them.
fn cells(layout: &Layout) -> Value {
    layout.cells.iter().map(|(name, step)| json!({"name": name, "step_ns": step.as_nanos() as u64})).collect()
}

impl Outlet for McapFile {
    fn open(&mut self, topic: &str, schema: &str, text: &str) -> io::Result<u16> {
        let schema = self.writer.add_schema(schema, "jsonschema", text.as_bytes()).map_err(io_error)?;
        let channel = self.writer.add_channel(schema, topic, "json", &BTreeMap::new()).map_err(io_error)?;
        if self.sequences.iter().all(|(known, _)| *known != channel) {
            self.sequences.push((channel, 0));
            self.scene.knows(topic, channel);
        }
        Ok(channel)
    }

    fn write(&mut self, channel: u16, time: Nanos, json: &str) -> io::Result<()> {
        let date = self.start(time)?.saturating_add(time);
        self.write_at(channel, date, json.as_bytes())?;
        self.write_scene(channel, time, date, json)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(io_error)
    }

    fn finish(&mut self, dropped: u64) -> io::Result<()> {
        let messages: u64 = self.sequences.iter().map(|(_, count)| u64::from(*count)).sum();
        self.metadata(END, [("messages", messages.to_string()), ("dropped", dropped.to_string())])?;
        self.writer.finish().map(drop).map_err(io_error)
    }
}
