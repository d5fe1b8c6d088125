//! Reads a recording, as far as a replay needs it.
//!
//! In: the [`records`] of a file, and the layout of the cell. Out: a [`RecordedRun`], or what is wrong with the file, which may
//! have any contents; or its messages as they are, for programs that only look at them.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use mcap::records::{Metadata, Record};

use super::file::{END, PROFILE, START, VERSION};
use super::messages::Messages;
use super::records::{self, Ended};
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
    let mut taker = Taker { layout, messages: None, channels: BTreeMap::new(), start: 0, end: None };
    match records::each(from, &mut |record| taker.take(record))? {
        Ended::Whole if taker.end.is_some() => taker.finish(cut_off),
        Ended::Whole | Ended::CutOff => taker.cut_off(cut_off),
    }
}

/// Hands over the messages of a recording as they are in the file: the topic, when it was written by the clock of the machine
/// that recorded it \[ns\], and the JSON. Of one that was cut off, those that there are.
///
/// # Errors
/// [`NotReplayable`]: the file is no MCAP file, or is damaged.
pub fn each_message(file: &Path, mut take: impl FnMut(&str, Nanos, &[u8])) -> Result<(), NotReplayable> {
    let mut channels = BTreeMap::new();
    let mut take = |record: Record<'_>| {
        match record {
            Record::Channel(channel) => drop(channels.insert(channel.id, channel.topic)),
            Record::Message { header, data } => {
                let topic = channels.get(&header.channel_id).map_or("", String::as_str);
                take(topic, header.log_time, &data);
            }
            _ => {}
        }
        Ok(())
    };
    let read = files::open(file).map_err(unreadable).and_then(|from| records::each(from, &mut take));
    read.map(drop).map_err(|wrong| wrong.of(file))
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
