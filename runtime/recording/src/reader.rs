//! Reads a recording, as far as a replay needs it.
//!
//! In: a file, and the layout of the cell. Out: a [`RecordedRun`], or what is wrong with the file. The file may have
//! any contents: it is read piece by piece, and no piece is larger than [`LARGEST`].

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use lz4::Decoder;
use mcap::McapError;
use mcap::records::{Metadata, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::file::{END, PROFILE, START, VERSION};
use super::messages::Messages;
use mrroc_core::console::quoted;
use mrroc_core::observe::layout::Layout;
use mrroc_core::replay::RecordedRun;
use mrroc_launch::files;

/// The largest record or chunk that is read \[bytes\]; the chunks of a recording have a quarter of a megabyte.
const LARGEST: usize = 1 << 20;

/// What to do with a recording that was cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutOff {
    /// Refuse it.
    Refused,
    /// Replay it up to the last step that is complete.
    Taken,
}

/// Why a file cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {what}\n help: {help}", file.display())]
pub struct NotReplayable {
    file: PathBuf,
    what: String,
    help: String,
}

/// What is wrong with a recording; the name of the file is added later.
pub(super) struct Wrong {
    what: String,
    help: &'static str,
}

impl Wrong {
    pub fn new(what: impl Into<String>, help: &'static str) -> Wrong {
        Wrong { what: what.into(), help }
    }

    /// An error for contents that only another kind of recorder can have written.
    pub fn foreign(what: impl Into<String>) -> Wrong {
        Wrong::new(what, "give a file that --record has written")
    }

    fn of(self, file: &Path) -> NotReplayable {
        NotReplayable { file: file.to_owned(), what: self.what, help: self.help.to_owned() }
    }
}

const DAMAGED: &str =
    "record the run again; what is there up to the damage can be looked at with an MCAP viewer";

/// Reads a recording of a cell.
///
/// # Errors
/// [`NotReplayable`]: the file is no recording, is of another cell, or is not complete.
pub(crate) fn read(file: &Path, layout: &Layout, cut_off: CutOff) -> Result<RecordedRun, NotReplayable> {
    let recorded = files::open(file).map_err(unreadable).and_then(|from| read_from(from, layout, cut_off));
    recorded.map_err(|wrong| wrong.of(file))
}

/// Reads a recording from bytes in memory.
pub(crate) fn read_bytes(
    bytes: &[u8],
    layout: &Layout,
    cut_off: CutOff,
) -> Result<RecordedRun, NotReplayable> {
    read_from(bytes, layout, cut_off).map_err(|wrong| wrong.of(Path::new("bytes")))
}

fn unreadable(error: std::io::Error) -> Wrong {
    Wrong::new(format!("cannot be read: {error}"), "see whether it is a file, and who may read it")
}

fn read_from(mut from: impl Read, layout: &Layout, cut_off: CutOff) -> Result<RecordedRun, Wrong> {
    if !layout.cells.is_empty() {
        let help =
            "look at it with an MCAP viewer, or record one of its cells in a run of its own and replay that";
        return Err(Wrong::new("a cell of cells cannot be replayed", help));
    }
    let options = LinearReaderOptions::default()
        .with_record_length_limit(LARGEST)
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut taker = Taker { layout, messages: None, channels: BTreeMap::new(), start: 0, end: None };
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(size)) => {
                let read = from.read(reader.insert(size.min(LARGEST))).map_err(unreadable)?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => taker.take_bytes(opcode, data)?,
            Err(McapError::UnexpectedEof) => {
                return taker.cut_off(cut_off);
            }
            Err(error) => return Err(damaged(error)),
        }
    }
    if taker.end.is_none() {
        return taker.cut_off(cut_off);
    }
    taker.finish(cut_off)
}

/// An error for a part that states a length beyond the end of what contains it.
fn torn(what: &str) -> Wrong {
    Wrong::new(format!("is damaged: {what} is longer than what it is in"), DAMAGED)
}

/// The records in a chunk, after its checksum is verified. The parser's own function for chunks is not used: its
/// counter underflows if a record is longer than its chunk.
fn chunk(data: &[u8]) -> Result<Cow<'_, [u8]>, Wrong> {
    let (size, sum, compression, records) = chunk_parts(data).ok_or_else(|| torn("a chunk"))?;
    let records = match compression {
        b"" => Cow::Borrowed(records),
        b"lz4" => Cow::Owned(decompressed(records, size)?),
        other => {
            let other = quoted(&String::from_utf8_lossy(other), 20);
            return Err(Wrong::foreign(format!("is compressed by {other}, recordings are by lz4")));
        }
    };
    let is_whole = size == records.len() as u64 && (sum == 0 || crc32fast::hash(&records) == sum);
    if is_whole {
        Ok(records)
    } else {
        Err(Wrong::new("is damaged: a chunk is not as its checksum says", DAMAGED))
    }
}

/// Undoes the compression of a chunk that states this size \[bytes\]. What is longer than it states is cut off, and found out
/// by the checksum.
fn decompressed(data: &[u8], size: u64) -> Result<Vec<u8>, Wrong> {
    if size > LARGEST as u64 {
        return Err(Wrong::foreign(format!("has a chunk of {size} bytes, more than a recording's")));
    }
    let mut records = Vec::new();
    let read = Decoder::new(data).and_then(|decoder| decoder.take(size + 1).read_to_end(&mut records));
    read.map_err(|_| Wrong::new("is damaged: a chunk cannot be decompressed", DAMAGED))?;
    Ok(records)
}

/// The parts of a chunk: its uncompressed size \[bytes\], its checksum, the name of its compression, and its records.
fn chunk_parts(mut rest: &[u8]) -> Option<(u64, u32, &[u8], &[u8])> {
    // The times of the chunk's first and last message, which are not needed.
    rest.split_off(..16)?;
    let (size, sum) = (u64_of(&mut rest)?, u32_of(&mut rest)?);
    let compression = text(&mut rest)?;
    let len = usize::try_from(u64_of(&mut rest)?).ok()?;
    Some((size, sum, compression, rest.split_off(..len)?))
}

/// Splits the next record off a chunk: its opcode and its data.
fn record<'a>(rest: &mut &'a [u8]) -> Option<(u8, &'a [u8])> {
    let opcode = *rest.split_off_first()?;
    let len = usize::try_from(u64_of(rest)?).ok()?;
    Some((opcode, rest.split_off(..len)?))
}

fn u64_of(rest: &mut &[u8]) -> Option<u64> {
    rest.split_off(..8)?.try_into().ok().map(u64::from_le_bytes)
}

/// Whether the texts of a record fit into it: the parser allocates as much memory as their lengths state. `None` for
/// records that are not used.
fn has_its_texts(opcode: u8, data: &[u8]) -> Option<bool> {
    // The number of bytes before the texts, the number of texts, and whether a map of texts follows.
    let (skipped, count, map) = match opcode {
        op::HEADER => (0, 2, false),
        op::CHANNEL => (4, 2, true),
        op::MESSAGE => (0, 0, false),
        op::METADATA => (0, 1, true),
        _ => return None,
    };
    let fits = |mut rest: &[u8]| {
        rest.split_off(..skipped)?;
        (0..count).try_for_each(|_| text(&mut rest).map(drop))?;
        // A map has a length in bytes before it, as a text has.
        let mut map = if map { text(&mut rest)? } else { &[] };
        while !map.is_empty() {
            let _key = text(&mut map)?;
            let _value = text(&mut map)?;
        }
        Some(())
    };
    Some(fits(data).is_some())
}

/// Splits a text off, which stands after its length.
fn text<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let len = usize::try_from(u32_of(rest)?).ok()?;
    rest.split_off(..len)
}

fn u32_of(rest: &mut &[u8]) -> Option<u32> {
    rest.split_off(..4)?.try_into().ok().map(u32::from_le_bytes)
}

fn damaged(error: McapError) -> Wrong {
    match error {
        McapError::BadMagic => Wrong::foreign("is no MCAP file"),
        error => Wrong::new(format!("is damaged: {}", quoted(&error.to_string(), 200)), DAMAGED),
    }
}

/// Takes the records of a file one after another.
struct Taker<'a> {
    layout: &'a Layout,
    /// `None` until the metadata has been read.
    messages: Option<Messages>,
    /// The topics of the channels, by their numbers.
    channels: BTreeMap<u16, String>,
    /// The date of the cell's time 0 \[ns\].
    start: u64,
    end: Option<Metadata>,
}

impl Taker<'_> {
    fn take_bytes(&mut self, opcode: u8, data: &[u8]) -> Result<(), Wrong> {
        if opcode == op::CHUNK {
            let records = chunk(data)?;
            let mut records = &*records;
            while !records.is_empty() {
                let (opcode, data) = record(&mut records).ok_or_else(|| torn("a chunk"))?;
                self.take_record(opcode, data)?;
            }
            return Ok(());
        }
        self.take_record(opcode, data)
    }

    fn take_record(&mut self, opcode: u8, data: &[u8]) -> Result<(), Wrong> {
        match has_its_texts(opcode, data) {
            None => Ok(()),
            Some(false) => Err(torn("a record")),
            Some(true) => self.take(mcap::parse_record(opcode, data).map_err(damaged)?),
        }
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), Wrong> {
        match record {
            Record::Header(header) if header.profile != PROFILE => Err(Wrong::foreign(format!(
                "is no recording of a cell: its profile is `{}`",
                quoted(&header.profile, 60)
            ))),
            Record::Metadata(metadata) if metadata.name == PROFILE => {
                let version = metadata.metadata.get("version").map(String::as_str);
                if version != Some(VERSION) {
                    let what =
                        format!("is a recording of version {}", quoted(version.unwrap_or("unknown"), 60));
                    return Err(Wrong::new(what, "replay it with the version of mrroc that recorded it"));
                }
                self.messages = Some(Messages::of(&metadata, self.layout)?);
                Ok(())
            }
            Record::Metadata(metadata) if metadata.name == START => {
                let start = metadata.metadata.get("start_ns").and_then(|start| start.parse().ok());
                self.start = start.ok_or_else(|| Wrong::foreign("does not say when it started"))?;
                Ok(())
            }
            Record::Metadata(metadata) if metadata.name == END => {
                self.end = Some(metadata);
                Ok(())
            }
            Record::Channel(channel) => {
                self.channels.insert(channel.id, channel.topic);
                Ok(())
            }
            Record::Message { header, data } => {
                let topic = self.channels.get(&header.channel_id).map_or("", String::as_str);
                let messages = self.messages.as_mut();
                let messages =
                    messages.ok_or_else(|| Wrong::foreign("does not say what its cell is made of"))?;
                messages.take(topic, header.log_time.saturating_sub(self.start), &data)
            }
            _ => Ok(()),
        }
    }

    fn cut_off(self, cut_off: CutOff) -> Result<RecordedRun, Wrong> {
        let Some(messages) = &self.messages else {
            return Err(Wrong::foreign("ends before it says what it is a recording of"));
        };
        match cut_off {
            CutOff::Taken => self.finish(cut_off),
            CutOff::Refused => {
                let what =
                    format!("is cut off: it has no end, and its last step is {}", messages.last_step());
                Err(Wrong::new(what, "replay what is there by --partial"))
            }
        }
    }

    fn finish(self, cut_off: CutOff) -> Result<RecordedRun, Wrong> {
        let dropped = self.end.and_then(|end| end.metadata.get("dropped")?.parse::<u64>().ok()).unwrap_or(0);
        if dropped > 0 {
            let what = format!("lacks {dropped} records, which were dropped while it was written");
            return Err(Wrong::new(what, "record the run again, to a faster disk or in virtual time"));
        }
        let messages =
            self.messages.ok_or_else(|| Wrong::foreign("does not say what its cell is made of"))?;
        messages.finish(cut_off)
    }
}
