//! Topics as virtual sensors: messages of other nodes become readings of the cell.
//!
//! In: what `cell.toml` says of topics, and the messages of other nodes. Out: readings at the ports of the cell's sensors. What may be believed of a reading (its bounds,
//! its age) the sensor decides, as of any program's. Here it is decided whether a message is one of its type, and whose it is: as long as one node publishes, another
//! one's messages are refused, since a robot that follows two of them in turn follows none.

mod cdr;
mod definition;
mod mapping;
mod receive;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use mrroc_core::cell::CellError;
use mrroc_core::console::complain;
use mrroc_core::observe::layout::Layout;
use mrroc_external::{WordSender, monotonic};
use mrroc_launch::cell_file::{CellFile, ExternalEntry, TopicEntry};
use ros2_client::dds::rustdds::GUID;
use ros2_client::qos::{Durability, History, Reliability, WhenFull};
use ros2_client::{MessageTypeName, QosProfile};

use crate::clock::now;
use crate::node::RosNode;
use mapping::Mapping;
use receive::{Body, BodyReader};

/// Messages of a topic that are taken at a time, however many come: the rest has its turn.
const EACH: usize = 100;

/// Reasons of refusals that are told of a topic, at most: some have numbers in them that differ.
const MOST_REASONS: usize = 20;

/// How often it is told how many messages were refused, and publishers are looked at.
const TOLD: Duration = Duration::from_secs(10);
const LOOKED: Duration = Duration::from_secs(1);

/// By how much a stamp may be ahead of this machine's clock, for clocks that are kept alike over a network \[ns\].
const AHEAD: i128 = 10_000_000;

/// The topics that are sensors of a cell.
pub struct SensorTopics {
    topics: Vec<SensorTopic>,
    looked: Option<Instant>,
    /// The types of what publishers publish.
    types: BTreeMap<GUID, String>,
    /// Publishers of whom it was told that nothing is heard.
    unheard: Vec<GUID>,
}

/// A topic, and the sensor.
struct SensorTopic {
    name: String,
    message: MessageTypeName,
    qos: QosProfile,
    mapping: Mapping,
    reader: BodyReader,
    sender: WordSender,
    owner: Owner<GUID>,
    refused: Refusals,
}

impl SensorTopics {
    /// Reads the topics of a cell file, for the sensors of a cell of this layout.
    ///
    /// # Errors
    /// What is wrong with the file, or why a topic or the port of a sensor cannot be opened.
    pub fn open(node: &mut RosNode, layout: &Layout, file: &CellFile) -> Result<SensorTopics, String> {
        let mapped: Vec<_> = file.topics().map(|(of, topic)| map(layout, of, topic)).collect();
        let errors = mapped.iter().filter_map(|mapped| mapped.as_ref().err().cloned()).collect();
        CellError::all(errors).map_err(|error| error.to_string())?;
        let mut topics = Vec::new();
        for ((of, topic), mapping) in file.topics().zip(mapped.into_iter().flatten()) {
            let sensor = layout.sensors.iter().find(|sensor| sensor.name == of.name());
            let sender =
                sensor.map_or_else(|| Err(missing(of)), |sensor| WordSender::at(of.port(), sensor))?;
            let name = topic.name().text.clone();
            let message = message_type(topic);
            let qos = qos(topic);
            let reader = BodyReader::open(node.participant(), &name, &message, &qos)
                .map_err(|error| format!("topic {name}: {error}"))?;
            complain(&format!("sensor `{}` reads {name}, {}", of.name(), topic.message().text));
            let owner = Owner { quiet: of.stale_after().as_nanos() as u64, now: None };
            let refused = Refusals::of(&name);
            topics.push(SensorTopic { name, message, qos, mapping, reader, sender, owner, refused });
        }
        Ok(SensorTopics { topics, looked: None, types: BTreeMap::new(), unheard: Vec::new() })
    }

    /// Sends what has come; waits for nobody.
    pub fn serve(&mut self, node: &RosNode) {
        if self.topics.is_empty() {
            return;
        }
        if self.looked.is_none_or(|looked| looked.elapsed() >= LOOKED) {
            self.look(node);
        }
        for place in 0..self.topics.len() {
            for _ in 0..EACH {
                match self.topics[place].reader.next() {
                    Ok(None) => break,
                    Ok(Some(body)) => self.message(node, place, &body),
                    Err(why) => self.topics[place].refused.add(&why),
                }
            }
            self.topics[place].refused.tell();
        }
    }

    fn message(&mut self, node: &RosNode, place: usize, body: &Body) {
        if !self.types.contains_key(&body.writer) {
            self.look(node);
        }
        let topic = &mut self.topics[place];
        let written = self.types.get(&body.writer);
        if let Err(why) = topic.message(body, written, [monotonic(), now()]) {
            topic.refused.add(&why);
        }
    }

    /// Looks at the publishers that there are, and tells of those that are not heard: of other types, and of lower quality of service.
    fn look(&mut self, node: &RosNode) {
        self.looked = Some(Instant::now());
        let writers = receive::writers(node.participant());
        self.types.clear();
        self.unheard.retain(|known| writers.iter().any(|writer| writer.guid == *known));
        for writer in &writers {
            let is_it = |topic: &&SensorTopic| receive::dds_name(&topic.name) == writer.topic;
            if let Some(topic) = self.topics.iter().find(is_it)
                && !self.unheard.contains(&writer.guid)
                && let Some(why) = writer.is_unheard_by(&topic.message, &topic.qos)
            {
                complain(&format!("warning: topic {}: a publisher is not heard: {why}", topic.name));
                self.unheard.push(writer.guid);
            }
            self.types.insert(writer.guid, writer.message.clone());
        }
    }
}

/// What is read of the messages of a topic.
fn map(layout: &Layout, of: &ExternalEntry, topic: &TopicEntry) -> Result<Mapping, CellError> {
    let sensor = layout.sensors.iter().find(|sensor| sensor.name == of.name());
    Mapping::of(
        topic,
        sensor.ok_or_else(|| topic.refuse(topic.name().place(), missing(of), ADDED.to_owned()))?,
    )
}

const ADDED: &str =
    "add it in the function that makes the cell, by `External::in_cell`, or leave its table out";

fn missing(of: &ExternalEntry) -> String {
    format!("the cell has no sensor `{}`", of.name())
}

fn message_type(topic: &TopicEntry) -> MessageTypeName {
    // The cell file has no other form.
    let (package, name) = topic.message().text.split_once("/msg/").unwrap_or_default();
    MessageTypeName::new(package, name)
}

fn qos(topic: &TopicEntry) -> QosProfile {
    let reliability = if topic.is_reliable() {
        Reliability::Reliable { when_full: WhenFull::Fail }
    } else {
        Reliability::BestEffort
    };
    let durability =
        if topic.is_transient_local() { Durability::TransientLocal } else { Durability::Volatile };
    QosProfile::publisher_default()
        .reliability(reliability)
        .durability(durability)
        .history(History::KeepLast { depth: topic.depth() })
}

impl SensorTopic {
    /// Sends what a message says as a reading. `written` is the type of what its publisher publishes, as far as that is known; the times are now, by the
    /// monotonic clock \[ns\] and by the wall clock \[ns since 1970\].
    fn message(
        &mut self,
        body: &Body,
        written: Option<&String>,
        [monotonic, wall]: [u64; 2],
    ) -> Result<(), String> {
        let expected = self.message.dds_msg_type();
        if let Some(other) = written.filter(|written| **written != expected) {
            return Err(format!("its publisher publishes {other}, not {expected}"));
        }
        self.owner.check(body.writer, monotonic)?;
        let order = body.order()?;
        let told = self.mapping.read(body.bytes(), order).map_err(|why| why.to_string())?;
        let came = monotonic.saturating_sub(body.waited);
        let measured = match told.stamp {
            None => came,
            Some(stamp) => measured(stamp, monotonic, wall)?.min(came),
        };
        self.sender.send(&told.words, measured);
        self.owner.now = Some((body.writer, monotonic));
        Ok(())
    }
}

/// When it was by the monotonic clock \[ns\] what a stamp tells by the wall clock \[ns since 1970\].
fn measured(stamp: i128, monotonic: u64, wall: u64) -> Result<u64, String> {
    let age = i128::from(wall) - stamp;
    if age < -AHEAD {
        let ahead = -age as f64 / 1e9;
        return Err(format!("its stamp is {ahead:.3} s ahead of this machine's clock"));
    }
    u64::try_from(i128::from(monotonic) - age.max(0)).map_err(|_| {
        "its stamp is of before this machine was started: its publisher sets none, or has a clock of its own; leave `stamp` out".to_owned()
    })
}

/// Whose messages count.
#[derive(Clone, Debug)]
struct Owner<W> {
    /// A publisher that has sent nothing good for so long is replaced by another one \[ns\].
    quiet: u64,
    /// Who has sent the last good message, and when \[ns\].
    now: Option<(W, u64)>,
}

impl<W: PartialEq + Copy> Owner<W> {
    fn check(&self, writer: W, monotonic: u64) -> Result<(), String> {
        match self.now {
            Some((owner, heard)) if owner != writer && monotonic.saturating_sub(heard) < self.quiet => {
                Err("another publisher sends to the same topic; the first one stays".to_owned())
            }
            Some(_) | None => Ok(()),
        }
    }
}

/// Messages of a topic that were refused: why is told once for each reason, and now and again how many there were.
#[derive(Debug)]
struct Refusals {
    name: String,
    /// Reasons that were told.
    known: Vec<String>,
    told: Instant,
    /// Since then.
    count: u64,
}

impl Refusals {
    fn of(name: &str) -> Refusals {
        Refusals { name: name.to_owned(), known: Vec::new(), told: Instant::now(), count: 0 }
    }

    fn add(&mut self, why: &str) {
        if self.known.len() < MOST_REASONS && !self.known.iter().any(|known| known == why) {
            self.known.push(why.to_owned());
            complain(&format!("warning: topic {}: a message is refused: {why}", self.name));
        } else {
            self.count += 1;
        }
    }

    fn tell(&mut self) {
        if self.count > 0 && self.told.elapsed() >= TOLD {
            complain(&format!("warning: topic {}: {} more messages refused", self.name, self.count));
            (self.told, self.count) = (Instant::now(), 0);
        }
    }
}
