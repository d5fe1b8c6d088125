//! The records of an MCAP file, one after another.
//!
//! In: bytes of any contents. Out: each record, also those in chunks. No piece that is larger than what the [`Kind`] of file allows is held in
//! memory, and chunks do not unpack to more than so many times what was read: a small file cannot keep its reader at work.

use std::borrow::Cow;
use std::io::Read;

use lz4::Decoder;
use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mrroc_core::console::quoted;

use super::wrong::{Wrong, unreadable};

/// What a file may be like.
pub(super) struct Kind {
    /// The largest record or chunk that is read \[bytes\].
    largest: usize,
    /// How many bytes a byte of a file may unpack to.
    unpacked: u64,
}

/// A recording: its chunks have a quarter of a megabyte. Robots that stand still are the same lines again and again: they unpack to about twenty.
pub(super) const RECORDING: Kind = Kind { largest: 1 << 20, unpacked: 50 };

/// A file of others, which may have images.
pub(super) const OF_OTHERS: Kind = Kind { largest: 1 << 26, unpacked: 1000 };

/// How a file ends.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended {
    /// As its format says.
    Whole,
    /// In the middle.
    CutOff,
}

/// Hands over each record.
///
/// # Errors
/// What is wrong with the file, or with a record.
pub(super) fn each(
    mut from: impl Read,
    kind: &Kind,
    take: &mut dyn FnMut(Record<'_>) -> Result<(), Wrong>,
) -> Result<Ended, Wrong> {
    let options = LinearReaderOptions::default()
        .with_record_length_limit(kind.largest)
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true);
    let mut reader = LinearReader::new_with_options(options);
    let (mut read, mut unpacked) = (0, 0);
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(size)) => {
                let count = from.read(reader.insert(size.min(kind.largest))).map_err(unreadable)?;
                reader.notify_read(count);
                read += count as u64;
            }
            Ok(LinearReadEvent::Record { data, opcode: op::CHUNK }) => {
                let records = chunk(data, kind)?;
                unpacked += records.len() as u64;
                if unpacked > kind.unpacked * read + kind.largest as u64 {
                    return Err(Wrong::foreign("unpacks to far more than it should"));
                }
                let mut records = &*records;
                while !records.is_empty() {
                    let (opcode, data) = record(&mut records).ok_or_else(|| torn("a chunk"))?;
                    take_bytes(opcode, data, kind, take)?;
                }
            }
            Ok(LinearReadEvent::Record { data, opcode }) => take_bytes(opcode, data, kind, take)?,
            Err(McapError::UnexpectedEof) => return Ok(Ended::CutOff),
            Err(error) => return Err(damaged(error, kind)),
        }
    }
    Ok(Ended::Whole)
}

fn take_bytes(
    opcode: u8,
    data: &[u8],
    kind: &Kind,
    take: &mut dyn FnMut(Record<'_>) -> Result<(), Wrong>,
) -> Result<(), Wrong> {
    match has_its_texts(opcode, data) {
        None => Ok(()),
        Some(false) => Err(torn("a record")),
        Some(true) => take(mcap::parse_record(opcode, data).map_err(|error| damaged(error, kind))?),
    }
}

/// An error for a part that states a length beyond the end of what contains it.
fn torn(what: &str) -> Wrong {
    Wrong::damaged(format!("is damaged: {what} is longer than what it is in"))
}

/// The records in a chunk, after its checksum is verified. The parser's own function for chunks is not used: its
/// counter underflows if a record is longer than its chunk.
fn chunk<'a>(data: &'a [u8], kind: &Kind) -> Result<Cow<'a, [u8]>, Wrong> {
    let (size, sum, compression, records) = chunk_parts(data).ok_or_else(|| torn("a chunk"))?;
    let records = match compression {
        b"" => Cow::Borrowed(records),
        b"lz4" => Cow::Owned(decompressed(Decoder::new(records), size, kind)?),
        #[cfg(feature = "zstd")]
        b"zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(records);
            Cow::Owned(decompressed(decoder.map_err(std::io::Error::other), size, kind)?)
        }
        other => {
            let other = quoted(&String::from_utf8_lossy(other), 20);
            return Err(Wrong::foreign(format!("is compressed by {other}, which is not read here")));
        }
    };
    let is_whole = size == records.len() as u64 && (sum == 0 || crc32fast::hash(&records) == sum);
    if is_whole {
        Ok(records)
    } else {
        Err(Wrong::damaged("is damaged: a chunk is not as its checksum says"))
    }
}

/// Undoes the compression of a chunk that states this size \[bytes\]. What is longer than it states is cut off, and found out
/// by the checksum.
fn decompressed(decoder: std::io::Result<impl Read>, size: u64, kind: &Kind) -> Result<Vec<u8>, Wrong> {
    if size > kind.largest as u64 {
        return Err(Wrong::foreign(format!("has a chunk of {size} bytes, of at most {}", kind.largest)));
    }
    let mut records = Vec::new();
    let read = decoder.and_then(|decoder| decoder.take(size + 1).read_to_end(&mut records));
    read.map_err(|_| Wrong::damaged("is damaged: a chunk cannot be decompressed"))?;
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
        // The third one is the schema itself.
        op::SCHEMA => (2, 3, false),
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

fn damaged(error: McapError, kind: &Kind) -> Wrong {
    match error {
        McapError::BadMagic => Wrong::foreign("is no MCAP file"),
        McapError::RecordTooLarge { len, .. } => Wrong::foreign(format!(
            "has a record of {len} bytes, of at most {}: leave out what was added to it",
            kind.largest
        )),
        error => Wrong::damaged(format!("is damaged: {}", quoted(&error.to_string(), 200))),
    }
}
