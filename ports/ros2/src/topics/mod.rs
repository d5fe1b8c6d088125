//! Topics as virtual sensors: messages of other nodes become readings of the cell.
//!
//! In: what `cell.toml` says of topics, and the messages of other nodes, or of a bag. Out: readings at the ports of the cell's sensors. What may be believed of a reading (its bounds,
//! its age) the sensor decides, as of any program's. Here it is decided whether a message is one of its type, and whose it is: as long as one node publishes, another
//! one's messages are refused, since a robot that follows two of them in turn follows none.

mod cdr;
mod mapped;
mod mapping;
mod receive;
mod recorded;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use mrroc_core::console::complain;
use mrroc_external::{StepShown, WordSender, monotonic, port_of_cell};
use mrroc_launch::cell_file::TopicEntry;
use ros2_client::dds::rustdds::GUID;
use ros2_client::qos::{Durability, History};
use ros2_client::{MessageTypeName, QosProfile};

use crate::clock::now;
use crate::node::{RosNode, reliability};
pub use cdr::ByteOrder;
pub use mapped::{Mapped, mapped};
use mapping::Mapping;
pub use mapping::Told;
use receive::{Body, BodyReader};
pub use recorded::{Recorded, described};

/// Messages of a topic that are taken at a time, however many come: the rest has its turn.
const EACH: usize = 100;

/// Reasons of refusals that are told of a topic, at most.
const MOST_REASONS: usize = 20;

/// How often it is told how many messages were refused, and publishers are looked at.
const TOLD: Duration = Duration::from_secs(10);
const LOOKED: Duration = Duration::from_secs(1);
/// The least time between two looks at publishers, whoever sends.
const LOOKED_AGAIN: Duration = Duration::from_millis(50);

/// By how much a stamp may be ahead of this machine's clock, for clocks that are kept alike over a network \[ns\].
const AHEAD: i128 = 10_000_000;

/// The topics that are sensors of a cell.
pub struct SensorTopics {
    topics: Vec<SensorTopic>,
    /// What is read of a bag in their place.
    recorded: Option<Recorded>,
    looked: Option<Instant>,
    /// The types of what publishers publish.
    types: BTreeMap<GUID, String>,
    /// Publishers of whom it was told that a topic does not hear them.
    unheard: Vec<(GUID, usize)>,
}

/// A topic, and the sensor.
struct SensorTopic {
    name: String,
    message: MessageTypeName,
    qos: QosProfile,
    mapping: Mapping,
    /// `None`: its messages are those of a bag.
    reader: Option<BodyReader>,
    sender: WordSender,
    owner: Owner<GUID>,
    refused: Refusals,
}

impl SensorTopics {
    /// Begins to hear these topics, or to take what is read of a bag.
    ///
    /// # Errors
    /// Why a topic or the port of a sensor cannot be opened.
    pub fn open(
        node: &mut RosNode,
        mapped: Vec<Mapped<'_>>,
        recorded: Option<Recorded>,
    ) -> Result<SensorTopics, String> {
        described(&mapped, recorded.as_ref()).iter().for_each(|line| complain(line));
        let mut topics = Vec::new();
        for Mapped { of, topic, sensor, mapping } in mapped {
            let sender = WordSender::at(&port_of_cell(of), sensor)?;
            let name = topic.name().text.clone();
            let message = message_type(topic);
            let qos = qos(topic);
            let reader = match &recorded {
                Some(_) => None,
                None => Some(
                    BodyReader::open(node.participant(), &name, &message, &qos)
                        .map_err(|error| format!("topic {name}: {error}"))?,
                ),
            };
            let owner = Owner { stale: of.stale_after().as_nanos() as u64, last: None };
            let refused = Refusals::of(&name);
            topics.push(SensorTopic { name, message, qos, mapping, reader, sender, owner, refused });
        }
        Ok(SensorTopics { topics, recorded, looked: None, types: BTreeMap::new(), unheard: Vec::new() })
    }

    /// The coordinator has shown a step, or that its program is over.
    pub fn step(&mut self, step: &StepShown) {
        if let Some(recorded) = &mut self.recorded {
            recorded.step(step.time, step.sent, step.over);
        }
    }

    /// Sends what has come; waits for nobody.
    pub fn serve(&mut self, node: &RosNode) {
        if self.topics.is_empty() {
            return;
        }
        if let Some(recorded) = &mut self.recorded {
            while let Some((message, due)) = recorded.next(monotonic()) {
                let topic = &mut self.topics[message.place];
                // As if it came at its time in the bag, however late the bridge is: the bag's clock stands for this machine's.
                let told = message.told.clone();
                let sent = told.and_then(|told| topic.send(&told, due, None, [due, message.date]));
                if let Err(why) = sent {
                    topic.refused.add(&why);
                }
            }
            if recorded.offers_first(monotonic()) {
                for (place, topic) in self.topics.iter().enumerate() {
                    // Measured when the machine was started: the cell begins, and does not count it as a reading.
                    recorded.first(place).into_iter().for_each(|told| topic.sender.send(&told.words, 0));
                }
            }
            self.topics.iter_mut().for_each(|topic| topic.refused.tell());
            return;
        }
        self.look(node, LOOKED);
        for place in 0..self.topics.len() {
            for _ in 0..EACH {
                match self.topics[place].reader.as_ref().map_or(Ok(None), BodyReader::next) {
                    Ok(None) => break,
                    Ok(Some(body)) => self.message(node, place, &body),
                    Err(why) => self.topics[place].refused.add(&why),
                }
            }
            self.topics[place].refused.tell();
        }
    }

    fn message(&mut self, node: &RosNode, place: usize, body: &Body) {
        let last = self.topics[place].owner.last.as_ref();
        let is_another = last.is_none_or(|last| last.writer != Some(body.writer));
        if is_another || !self.types.contains_key(&body.writer) {
            self.look(node, LOOKED_AGAIN);
        }
        let topic = &mut self.topics[place];
        let written = self.types.get(&body.writer);
        if let Err(why) = topic.message(body, written, [monotonic(), now()]) {
            topic.refused.add(&why);
        }
    }

    /// Looks at the publishers that there are, if that was so long ago, and tells of those that are not heard: of other types, and of lower quality of
    /// service.
    fn look(&mut self, node: &RosNode, after: Duration) {
        if self.looked.is_some_and(|looked| looked.elapsed() < after) {
            return;
        }
        self.looked = Some(Instant::now());
        let writers = receive::writers(node.participant());
        self.types.clear();
        self.unheard.retain(|(known, _)| writers.iter().any(|writer| writer.guid == *known));
        for writer in &writers {
            for (place, topic) in self.topics.iter().enumerate() {
                if receive::dds_name(&topic.name) == writer.topic
                    && !self.unheard.contains(&(writer.guid, place))
                    && let Some(why) = writer.is_unheard_by(&topic.message, &topic.qos)
                {
                    complain(&format!("warning: topic {}: a publisher is not heard: {why}", topic.name));
                    self.unheard.push((writer.guid, place));
                }
            }
            self.types.insert(writer.guid, writer.message.clone());
        }
        for topic in &mut self.topics {
            topic.owner.keep_if(|writer| self.types.contains_key(writer));
        }
    }
}

fn message_type(topic: &TopicEntry) -> MessageTypeName {
    // The cell file has no other form.
    let (package, name) = topic.message().text.split_once("/msg/").unwrap_or_default();
    MessageTypeName::new(package, name)
}

fn qos(topic: &TopicEntry) -> QosProfile {
    let durability =
        if topic.is_transient_local() { Durability::TransientLocal } else { Durability::Volatile };
    QosProfile::publisher_default()
        .reliability(reliability(topic.is_reliable()))
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
        let written = written.ok_or("its publisher is not known")?;
        if *written != expected {
            let [written, expected] = [written, &expected].map(|name| receive::ros_name(name));
            return Err(format!("its publisher publishes {written}, not {expected}"));
        }
        self.owner.check(body.writer, monotonic)?;
        let order = body.order()?;
        let told = self.mapping.read(body.bytes(), order).map_err(|why| why.to_string())?;
        let came = monotonic.saturating_sub(body.waited);
        self.send(&told, came, Some(body.writer), [monotonic, wall])
    }

    /// Sends what a message says that came at a time of the monotonic clock \[ns\].
    fn send(
        &mut self,
        told: &Told,
        came: u64,
        writer: Option<GUID>,
        [monotonic, wall]: [u64; 2],
    ) -> Result<(), String> {
        let measured = self.owner.take(told.stamp, came, writer, [monotonic, wall])?;
        self.sender.send(&told.words, measured);
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
    /// The age of a reading that is stale \[ns\]. A publisher that has sent nothing good for half of this time is replaced by another one, before the
    /// sensor is stale.
    stale: u64,
    last: Option<Last<W>>,
}

/// The last good message: who has sent it, when it was heard and of when it is by the monotonic clock \[ns\].
#[derive(Clone, Debug)]
struct Last<W> {
    /// `None`: it has gone.
    writer: Option<W>,
    heard: u64,
    measured: u64,
}

impl<W: PartialEq + Copy> Owner<W> {
    fn check(&self, writer: W, monotonic: u64) -> Result<(), String> {
        match &self.last {
            Some(last)
                if last.writer.is_some_and(|owner| owner != writer)
                    && monotonic.saturating_sub(last.heard) < self.stale / 2 =>
            {
                Err("another publisher sends to the same topic; the first one stays".to_owned())
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Takes a message with this stamp, if it has one, as the last good one: of when it is by the monotonic clock \[ns\].
    fn take(
        &mut self,
        stamp: Option<i128>,
        came: u64,
        writer: Option<W>,
        [monotonic, wall]: [u64; 2],
    ) -> Result<u64, String> {
        let measured = match stamp {
            None => came,
            Some(stamp) => {
                let measured = measured(stamp, monotonic, wall)?.min(came);
                self.check_stamp(measured, monotonic)?;
                measured
            }
        };
        self.last = Some(Last { writer, heard: monotonic, measured });
        Ok(measured)
    }

    /// Another publisher may follow at once where this one is there no more.
    fn keep_if(&mut self, is_there: impl Fn(&W) -> bool) {
        if let Some(last) = &mut self.last {
            last.writer = last.writer.filter(is_there);
        }
    }

    /// The cell takes no reading that is stale or not newer than the last one, and whoever sends such ones sends nothing good.
    fn check_stamp(&self, measured: u64, monotonic: u64) -> Result<(), String> {
        let age = monotonic.saturating_sub(measured);
        if age >= self.stale {
            let [age, stale] = [age, self.stale].map(|time| time as f64 / 1e9);
            return Err(format!("its stamp is {age:.3} s old, and a reading is stale after {stale:.3} s"));
        }
        match &self.last {
            Some(last) if measured <= last.measured => {
                Err("its stamp is not later than that of the message before".to_owned())
            }
            Some(_) | None => Ok(()),
        }
    }
}

/// Messages of a topic that were refused: why is told once for each reason, and now and again how many there were.
#[derive(Debug)]
struct Refusals {
    name: String,
    /// Reasons that were told, without their digits: numbers in them differ from message to message.
    known: Vec<String>,
    told: Instant,
    /// How many there were since then, and the reason of the last one.
    count: u64,
    last: String,
}

impl Refusals {
    fn of(name: &str) -> Refusals {
        Refusals {
            name: name.to_owned(),
            known: Vec::new(),
            told: Instant::now(),
            count: 0,
            last: String::new(),
        }
    }

    fn add(&mut self, why: &str) {
        let kind: String = why.chars().filter(|c| !c.is_ascii_digit()).collect();
        if self.known.len() < MOST_REASONS && !self.known.contains(&kind) {
            self.known.push(kind);
            complain(&format!("warning: topic {}: a message is refused: {why}", self.name));
        } else {
            self.count += 1;
            why.clone_into(&mut self.last);
        }
    }

    fn tell(&mut self) {
        if self.count > 0 && self.told.elapsed() >= TOLD {
            let Refusals { name, count, last, .. } = self;
            complain(&format!("warning: topic {name}: {count} more messages refused, the last one: {last}"));
            (self.told, self.count) = (Instant::now(), 0);
        }
    }
}
