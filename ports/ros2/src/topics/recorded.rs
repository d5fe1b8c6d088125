//! Messages of a bag in the place of those of other nodes.
//!
//! In: a bag, the topics that are sensors, and the steps of the cell. Out: what each message says, as long after the first step of a run as it is after the
//! first message of the bag. The whole bag is read before a cell runs, so that what is wrong with it is told at the start.

use std::path::Path;

use mrroc_core::console::complain;
use mrroc_core::suggestion::suggestion;
use mrroc_recording::McapMessage;

use super::Owner;
use super::mapped::Mapped;
use super::mapping::{Mapping, Told};
use super::receive::{LONGEST, too_long};
use crate::bags::{Source, body};
use crate::clock::is_another_run;

/// What is kept of all messages, at most \[bytes\].
const MOST: usize = 256 << 20;

/// A cell whose steps were not seen for so long may have ended \[ns\].
const ENDED: u64 = 1_000_000_000;
/// So often the first messages are sent where a cell may begin \[ns\].
const AGAIN: u64 = 100_000_000;

/// The longest time from the first message of a bag to its last one \[ns\]: beyond it a date is wrong, and all others would wait for it.
const LONGEST_BAG: u64 = 86_400 * 1_000_000_000;

/// When a bag begins that nobody hears, by the monotonic clock \[ns\]: long after the machine was started, so that stamps may be older.
const LATE: u64 = 1 << 62;

/// Topics that are named in a message, at most.
const NAMED: usize = 20;

/// The messages of all topics that are sensors.
#[derive(Debug)]
pub struct Recorded {
    /// In the order of their dates.
    messages: Vec<Message>,
    /// The date of the first message of the bag, of whatever topic \[ns since 1970\].
    first: u64,
    /// How many were sent in the run.
    sent: usize,
    run: Option<Run>,
    /// When the first messages were offered last \[ns\].
    offered: u64,
}

/// A message.
#[derive(Debug)]
pub struct Message {
    /// When it was logged \[ns since 1970\].
    pub date: u64,
    /// The place of its topic among those that are sensors.
    pub place: usize,
    /// What it says, or why it is refused.
    pub told: Result<Told, String>,
}

/// The run of the cell that is seen.
#[derive(Debug)]
struct Run {
    /// When the cell's time was zero, by the monotonic clock \[ns\].
    zero: u64,
    /// When the first step that is known was sent, and the newest one.
    began: u64,
    seen: u64,
    /// Whether the cell's program has ended.
    is_over: bool,
}

impl Recorded {
    /// Reads the messages of these topics in a bag.
    ///
    /// # Errors
    /// All that is wrong: the bag cannot be read, lacks a topic, or has it with another type.
    pub fn read(bag: &Path, mapped: &[Mapped<'_>]) -> Result<Recorded, Vec<String>> {
        let one = |why: String| vec![why];
        if mapped.is_empty() {
            return Err(one("the cell file makes no topic a sensor\n help: write a table [sensors.NAME.external.topic], or leave --sensors-from-bag out".to_owned()));
        }
        let source = Source::at(bag).map_err(one)?;
        let topics = source.topics().map_err(one)?;
        let names: Vec<_> = topics.keys().take(NAMED).collect();
        let unlike = |of: &Mapped<'_>| {
            let (topic, kind, sensor) = (&of.topic.name().text, &of.topic.message().text, of.of.name());
            match topics.get(topic) {
                Some(found) if found == kind => None,
                Some(found) => Some(format!(
                    "topic {topic} is of type {found}, and sensor `{sensor}` reads {kind}\n help: write the type of the bag in the cell file, or name another bag"
                )),
                None => Some(format!(
                    "the bag has no message of topic {topic}, which sensor `{sensor}` reads\n help: {}",
                    suggestion(topic, &names, "it has messages of")
                )),
            }
        };
        let wrong: Vec<_> = mapped.iter().filter_map(unlike).map(|why| source.wrong(&why)).collect();
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let (mut messages, mut bytes) = (Vec::new(), 0);
        // The earliest and the latest date, and the topics of these messages.
        let mut span: Option<[(u64, String); 2]> = None;
        let mut take = |message: McapMessage<'_>| {
            let this = || (message.date, message.topic.to_owned());
            let [earliest, latest] = span.get_or_insert_with(|| [this(), this()]);
            if message.date < earliest.0 {
                *earliest = this();
            } else if message.date > latest.0 {
                *latest = this();
            }
            for (place, of) in
                mapped.iter().enumerate().filter(|(_, of)| of.topic.name().text == message.topic)
            {
                let told = told(&message, &of.topic.message().text, &of.mapping);
                bytes += size_of::<Message>()
                    + told.as_ref().map_or_else(String::len, |told| 8 * told.words.len());
                messages.push(Message { date: message.date, place, told });
            }
            match bytes > MOST {
                true => {
                    Err("its readings take more than 256 MiB\n help: make a bag of a shorter time".to_owned())
                }
                false => Ok(()),
            }
        };
        source.each(&mut take).map_err(one)?;
        let Some([earliest, latest]) = span else { return Err(one(source.wrong("it has no message"))) };
        if latest.0 - earliest.0 > LONGEST_BAG {
            let [first, last] = [&earliest, &latest].map(|(date, topic)| {
                format!("a message of topic {topic} at {:.3} s since 1970", *date as f64 / 1e9)
            });
            let why = format!(
                "it is longer than a day: the first is {first}, the last {last}\n help: leave out messages whose date is wrong, or make a bag of a shorter time"
            );
            return Err(one(source.wrong(&why)));
        }
        let first = earliest.0;
        messages.sort_by_key(|message| message.date);
        let refused = mapped.iter().enumerate().filter_map(|(place, of)| {
            let mut all = messages.iter().filter(|message| message.place == place);
            let why = all.clone().next()?.told.as_ref().err()?;
            let topic = &of.topic.name().text;
            let told = format!("no message of topic {topic} can be read, the first one: {why}");
            all.all(|message| message.told.is_err()).then(|| source.wrong(&told))
        });
        let refused: Vec<_> = refused.collect();
        match refused.is_empty() {
            true => Ok(Recorded { messages, first, sent: 0, run: None, offered: 0 }),
            false => Err(refused),
        }
    }

    /// How many messages a topic has, and how long after the first message of the bag the last one is \[s\].
    pub fn extent(&self, place: usize) -> (usize, f64) {
        let of = || self.messages.iter().filter(|message| message.place == place);
        let last = of().next_back().map_or(self.first, |message| message.date);
        (of().count(), (last - self.first) as f64 / 1e9)
    }

    /// How many messages of a topic a cell would refuse whose readings are stale at this age \[ns\], and why the first of them.
    pub fn refused(&self, place: usize, stale: u64) -> Option<(usize, String)> {
        let mut owner = Owner::<()> { stale, last: None };
        let of = self.messages.iter().filter(|message| message.place == place);
        let mut refused = of.filter_map(|Message { date, told, .. }| {
            let due = LATE + (date - self.first);
            let stamp = told.as_ref().map_err(String::clone).map(|told| told.stamp);
            stamp.and_then(|stamp| owner.take(stamp, due, None, [due, *date])).err()
        });
        let first = refused.next()?;
        Some((1 + refused.count(), first))
    }

    /// The coordinator has shown a step of this time of the cell \[ns\], or that its program is over; that was sent at a time of the monotonic clock \[ns\]. With
    /// the first step of a run that is seen the bag begins.
    pub fn step(&mut self, time: u64, sent: u64, is_over: bool) {
        let zero = sent.saturating_sub(time);
        match &mut self.run {
            Some(run) if is_over || !(run.is_over || is_another_run(zero, run.zero)) => {
                (run.seen, run.is_over) = (sent, is_over);
            }
            Some(_) | None => {
                self.run = Some(Run { zero, began: sent, seen: sent, is_over });
                self.sent = 0;
            }
        }
    }

    /// Whether the first messages are to be offered to a cell that waits for the first readings of its sensors, which it does before its first step: now and
    /// again where no cell is known to run.
    pub fn offers_first(&mut self, now: u64) -> bool {
        let may_begin = |run: &Run| run.is_over || now.saturating_sub(run.seen) >= ENDED;
        let offers = self.run.as_ref().is_none_or(may_begin) && now.saturating_sub(self.offered) >= AGAIN;
        if offers {
            self.offered = now;
        }
        offers
    }

    /// What the first message of a topic says that is not refused; `None` where another one of the topic is to be sent in this run, which it would replace.
    pub fn first(&self, place: usize) -> Option<&Told> {
        let of = |message: &&Message| message.place == place;
        let is_at_work = self.run.as_ref().is_some_and(|run| !run.is_over);
        if is_at_work && self.messages[self.sent..].iter().any(|message| of(&message)) {
            return None;
        }
        self.messages.iter().filter(of).find_map(|message| message.told.as_ref().ok())
    }

    /// The next message that is due at a time of the monotonic clock, and since when \[ns\].
    pub fn next(&mut self, now: u64) -> Option<(&Message, u64)> {
        let run = self.run.as_ref().filter(|run| !run.is_over)?;
        let message = self.messages.get(self.sent)?;
        let due = run.began.checked_add(message.date - self.first)?;
        if due > now {
            return None;
        }
        self.sent += 1;
        if self.sent == self.messages.len() {
            complain("bag: all messages of sensors are sent");
        }
        Some((message, due))
    }
}

/// Which sensor reads which topic, and how much of a bag.
pub fn described(mapped: &[Mapped<'_>], recorded: Option<&Recorded>) -> Vec<String> {
    let line = |(place, Mapped { of, topic, .. }): (usize, &Mapped<'_>)| {
        let of_bag = recorded.map_or_else(String::new, |recorded| {
            let (count, seconds) = recorded.extent(place);
            let refused = recorded.refused(place, of.stale_after().as_nanos() as u64);
            let refused = refused.map_or_else(String::new, |(refused, why)| {
                format!("; {refused} of {count} messages are refused, the first: {why}")
            });
            format!(": {count} messages of the bag, until {seconds:.3} s{refused}")
        });
        format!("sensor `{}` reads {}, {}{of_bag}", of.name(), topic.name().text, topic.message().text)
    };
    mapped.iter().enumerate().map(line).collect()
}

/// What a message says, by the same rules as one that another node sends.
fn told(message: &McapMessage<'_>, kind: &str, mapping: &Mapping) -> Result<Told, String> {
    if message.schema != kind {
        return Err(format!("it is of type {}, not {kind}", message.schema));
    }
    if message.encoding != "cdr" {
        return Err(format!("it is encoded by `{}`, and not in CDR", message.encoding));
    }
    let (order, body) = body(message.data)?;
    if body.len() > LONGEST {
        return Err(too_long(body.len()));
    }
    mapping.read(body, order).map_err(|why| why.to_string())
}
