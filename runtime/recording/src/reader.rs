//! Reads a recording, as far as a replay needs it.
//!
//! In: the [`records`] of a file, and the layout of the cell. Out: a [`RecordedRun`], or what is wrong with the file, which may
//! have any contents; or its messages, for programs that look at them or convert them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use mcap::records::{Metadata, Record};

use super::file::{END, PROFILE, START, VERSION};
use super::messages::Messages;
use super::records::{self, Ended};
use super::samples::RecordedMessage;
use super::wrong::{CutOff, NotReplayable, Wrong, unreadable};
use mrroc_core::console::quoted;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::replay::RecordedRun;
use mrroc_launch::files;

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

fn read_from(from: impl Read, layout: &Layout, cut_off: CutOff) -> Result<RecordedRun, Wrong> {
    if !layout.cells.is_empty() {
        let help =
            "look at it with an MCAP viewer, or record one of its cells in a run of its own and replay that";
        return Err(Wrong::new("a cell of cells cannot be replayed", help));
    }
    let mut taker = Taker { head: Head::of(layout), messages: None };
    match records::each(from, &records::RECORDING, &mut |record| taker.take(record))? {
        Ended::Whole if taker.head.dropped.is_some() => taker.finish(cut_off),
        Ended::Whole | Ended::CutOff => taker.cut_off(cut_off),
    }
}

/// Hands over the messages of a recording of a cell of this layout, in the order in which they are in the file; of one that was cut off, those that
/// there are. Tells what it lacks.
///
/// # Errors
/// [`NotReplayable`]: the file is no recording, is damaged, or is of another cell.
pub fn each_message_of(
    file: &Path,
    layout: &Layout,
    mut take: impl FnMut(RecordedMessage<'_>),
) -> Result<Completeness, NotReplayable> {
    let (mut head, mut messages) = (Head::of(layout), None);
    let unknown = || Wrong::foreign("does not say what its cell is made of, or when it started");
    let mut take = |record: Record<'_>| {
        if let Some(Found { topic, start, date, data }) = head.take(record, &mut messages)? {
            let start = start.filter(|_| messages.is_some()).ok_or_else(unknown)?;
            take(RecordedMessage { topic, start, time: date.saturating_sub(start), json: &data });
        }
        Ok(())
    };
    let read = files::open(file)
        .map_err(unreadable)
        .and_then(|from| records::each(from, &records::RECORDING, &mut take));
    let ended = read.map_err(|wrong| wrong.of(file))?;
    if messages.is_none() {
        return Err(unknown().of(file));
    }
    Ok(Completeness {
        cut_off: ended != Ended::Whole || head.dropped.is_none(),
        dropped: head.dropped.unwrap_or_default(),
    })
}

/// What a recording lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Completeness {
    /// It has no end.
    pub cut_off: bool,
    /// So many records were dropped while it was written.
    pub dropped: u64,
}

/// How many records were dropped, as the end of a recording tells.
fn dropped_by(end: &Metadata) -> u64 {
    end.metadata.get("dropped").and_then(|dropped| dropped.parse().ok()).unwrap_or(0)
}

/// A message of an MCAP file that others have written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct McapMessage<'a> {
    /// Its topic.
    pub topic: &'a str,
    /// The name of its schema, which is its type.
    pub schema: &'a str,
    /// How it is encoded.
    pub encoding: &'a str,
    /// When it was logged \[ns since 1970\].
    pub date: Nanos,
    /// What it says.
    pub data: &'a [u8],
}

/// Hands over the messages of an MCAP file of any profile. Records and chunks of more than 64 MiB are refused before they are in memory.
///
/// # Errors
/// What is wrong with the file, or what `take` says.
pub fn each_mcap_message(
    file: &Path,
    take: impl FnMut(McapMessage<'_>) -> Result<(), String>,
) -> Result<(), String> {
    let read = files::open(file).map_err(unreadable).and_then(|from| each_mcap_message_in(from, take));
    read.map_err(|wrong| {
        let help = if wrong.is_damage() { RECOVERED } else { "" };
        format!("{}: {}{help}", file.display(), wrong.what())
    })
}

/// What to do about a file of others that is damaged, or has no end.
const RECOVERED: &str = "\n help: copy it again if its copy was cut off; else have `mcap recover FILE -o NEW.mcap` of the MCAP tools keep what there is, and \
                         name NEW.mcap";

fn each_mcap_message_in(
    from: impl Read,
    mut take: impl FnMut(McapMessage<'_>) -> Result<(), String>,
) -> Result<(), Wrong> {
    let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
    let mut take = |record: Record<'_>| {
        match record {
            Record::Schema { header, .. } => drop(schemas.insert(header.id, kept(header.name)?)),
            Record::Channel(channel) => {
                let names = [kept(channel.topic)?, kept(channel.message_encoding)?];
                channels.insert(channel.id, (names, channel.schema_id));
            }
            Record::Message { header, data } => {
                let channel = channels.get(&header.channel_id);
                let ([topic, encoding], schema) =
                    channel.ok_or_else(|| Wrong::foreign("has a message of no channel"))?;
                let schema = schemas.get(schema).map_or("", String::as_str);
                let message = McapMessage { topic, schema, encoding, date: header.log_time, data: &data };
                take(message).map_err(|what| Wrong::new(what, ""))?;
            }
            _ => {}
        }
        if schemas.len().max(channels.len()) > MOST_CHANNELS {
            return Err(Wrong::foreign(format!("has more than {MOST_CHANNELS} channels or schemas")));
        }
        Ok(())
    };
    match records::each(from, &records::OF_OTHERS, &mut take)? {
        Ended::Whole => Ok(()),
        Ended::CutOff => Err(Wrong::damaged("is cut off: it has no end")),
    }
}

/// Channels, and schemas, of a file of others, at most; and the bytes of a name of one.
const MOST_CHANNELS: usize = 10_000;
const LONGEST_NAME: usize = 1000;

/// A name that is kept in memory.
fn kept(name: String) -> Result<String, Wrong> {
    if name.len() <= LONGEST_NAME {
        return Ok(name);
    }
    Err(Wrong::foreign(format!("has a name of {} bytes, of at most {LONGEST_NAME}", name.len())))
}

fn of_profile(profile: &str) -> Result<(), Wrong> {
    if profile == PROFILE {
        return Ok(());
    }
    Err(Wrong::foreign(format!("is no recording of a cell: its profile is `{}`", quoted(profile, 60))))
}

fn of_version(metadata: &Metadata) -> Result<&Metadata, Wrong> {
    let version = metadata.metadata.get("version").map(String::as_str);
    if version == Some(VERSION) {
        return Ok(metadata);
    }
    let what = format!("is a recording of version {}", quoted(version.unwrap_or("unknown"), 60));
    Err(Wrong::new(what, "read it with the version of mrroc that recorded it"))
}

/// The date of the cell's time 0 \[ns\].
fn started(metadata: &Metadata) -> Result<Nanos, Wrong> {
    let start = metadata.metadata.get("start_ns").and_then(|start| start.parse().ok());
    start.ok_or_else(|| Wrong::foreign("does not say when it started"))
}

/// What the records before the messages say of a recording, and its end.
struct Head<'a> {
    layout: &'a Layout,
    /// The topics of the channels, by their numbers.
    channels: BTreeMap<u16, String>,
    /// The date of the cell's time 0 \[ns\].
    start: Option<Nanos>,
    /// How many records were dropped, which the end says.
    dropped: Option<u64>,
}

/// A message, as it is in the file.
struct Found<'a> {
    topic: &'a str,
    start: Option<Nanos>,
    /// When it was logged \[ns\].
    date: Nanos,
    data: Cow<'a, [u8]>,
}

impl<'a> Head<'a> {
    fn of(layout: &'a Layout) -> Self {
        Head { layout, channels: BTreeMap::new(), start: None, dropped: None }
    }

    /// Takes a record, and hands it back if it is a message. The metadata of the cell begin `messages`.
    fn take<'r>(
        &'r mut self,
        record: Record<'r>,
        messages: &mut Option<Messages>,
    ) -> Result<Option<Found<'r>>, Wrong> {
        match record {
            Record::Header(header) => of_profile(&header.profile)?,
            Record::Metadata(metadata) if metadata.name == PROFILE => {
                *messages = Some(Messages::of(of_version(&metadata)?, self.layout)?);
            }
            Record::Metadata(metadata) if metadata.name == START => self.start = Some(started(&metadata)?),
            Record::Metadata(metadata) if metadata.name == END => {
                self.dropped = Some(dropped_by(&metadata));
            }
            Record::Channel(channel) => drop(self.channels.insert(channel.id, channel.topic)),
            Record::Message { header, data } => {
                let topic = self.channels.get(&header.channel_id).map_or("", String::as_str);
                return Ok(Some(Found { topic, start: self.start, date: header.log_time, data }));
            }
            _ => {}
        }
        Ok(None)
    }
}

/// Takes the records of a file one after another.
struct Taker<'a> {
    head: Head<'a>,
    /// `None` until the metadata has been read.
    messages: Option<Messages>,
}

impl Taker<'_> {
    fn take(&mut self, record: Record<'_>) -> Result<(), Wrong> {
        let layout = self.head.layout;
        let Some(Found { topic, start, date, data }) = self.head.take(record, &mut self.messages)? else {
            return Ok(());
        };
        let messages = self.messages.as_mut();
        let messages = messages.ok_or_else(|| Wrong::foreign("does not say what its cell is made of"))?;
        let start = start.unwrap_or_default();
        messages
            .take(&RecordedMessage { topic, start, time: date.saturating_sub(start), json: &data }, layout)
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
        let dropped = self.head.dropped.unwrap_or_default();
        if dropped > 0 {
            let what = format!("lacks {dropped} records, which were dropped while it was written");
            return Err(Wrong::new(what, "record the run again, to a faster disk or in virtual time"));
        }
        let messages =
            self.messages.ok_or_else(|| Wrong::foreign("does not say what its cell is made of"))?;
        messages.finish(cut_off)
    }
}
