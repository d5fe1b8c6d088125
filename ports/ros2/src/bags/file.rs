//! A bag that is written: a folder with `metadata.yaml` and an MCAP file, as rosbag2 of Jazzy writes it.
//!
//! In: messages of topics, at dates. Out: messages in CDR, with the definitions of their types.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::BufWriter;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use byteorder::LittleEndian;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};

use crate::definitions;
use crate::messages::RosType;
use crate::outlet::{Durability, Outlet, Put, twice};

/// The first bytes of a message: plain CDR, the lowest byte of a number first.
pub const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// A bag that is being written.
pub struct Bag {
    folder: PathBuf,
    file: String,
    node: String,
    written: Rc<RefCell<Written>>,
}

/// What was written so far.
struct Written {
    writer: Writer<BufWriter<File>>,
    topics: Vec<Topic>,
    /// The date of what comes next \[ns since 1970\].
    now: u64,
    /// The dates of the first and the last message.
    span: Option<[u64; 2]>,
    /// Why nothing is written any more.
    failed: Option<String>,
}

struct Topic {
    name: String,
    kind: String,
    durability: Durability,
    channel: u16,
    count: u32,
}

/// A topic of a bag.
pub struct BagTopic<M> {
    written: Rc<RefCell<Written>>,
    place: usize,
    of: PhantomData<M>,
}

impl Bag {
    /// Begins a bag in a folder that is not there yet, of a node of this name.
    ///
    /// # Errors
    /// The folder is there, or cannot be made.
    pub fn create(folder: &Path, node: &str) -> Result<Bag, String> {
        let failed = |error: &dyn core::fmt::Display| format!("{}: {error}", folder.display());
        let made = fs::create_dir(folder);
        if made.as_ref().is_err_and(|error| error.kind() == std::io::ErrorKind::AlreadyExists) {
            return Err(failed(&"is there already\n help: name a folder that is to be made"));
        }
        made.map_err(|error| failed(&error))?;
        let name = folder.file_name().map_or_else(|| "bag".into(), |name| name.to_string_lossy());
        let file = format!("{name}_0.mcap");
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("mrroc ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4));
        let stream = File::create(folder.join(&file)).map_err(|error| failed(&error))?;
        let writer = options.create(BufWriter::new(stream)).map_err(|error| failed(&error))?;
        let written = Written { writer, topics: Vec::new(), now: 0, span: None, failed: None };
        let written = Rc::new(RefCell::new(written));
        Ok(Bag { folder: folder.to_owned(), file, node: node.to_owned(), written })
    }

    /// What comes next is of this date \[ns since 1970\].
    pub fn set_now(&self, date: u64) {
        self.written.borrow_mut().now = date;
    }

    /// Ends the bag; tells how many messages of how many topics it has.
    ///
    /// # Errors
    /// Why it could not be written.
    pub fn finish(&self) -> Result<[usize; 2], String> {
        let written = &mut *self.written.borrow_mut();
        if let Some(why) = written.failed.take() {
            return Err(format!("{}: {why}", self.folder.display()));
        }
        let failed = |error: &dyn core::fmt::Display| format!("{}: {error}", self.folder.display());
        let metadata = written.metadata(&self.file);
        let about = [("serialized_metadata".to_owned(), metadata.clone())];
        let record = Metadata { name: "rosbag2".to_owned(), metadata: BTreeMap::from(about) };
        written.writer.write_metadata(&record).map_err(|error| failed(&error))?;
        written.writer.finish().map_err(|error| failed(&error))?;
        let mut text = "rosbag2_bagfile_information:\n".to_owned();
        for line in metadata.lines() {
            // Writing to a string does not fail.
            let _ = writeln!(text, "  {line}");
        }
        fs::write(self.folder.join("metadata.yaml"), text).map_err(|error| failed(&error))?;
        Ok([written.count() as usize, written.topics.len()])
    }

    /// Takes away what was written of a bag that cannot be ended.
    pub fn discard(&self) {
        // It is this program's own: the folder was not there before.
        drop(fs::remove_file(self.folder.join(&self.file)));
        drop(fs::remove_file(self.folder.join("metadata.yaml")));
        drop(fs::remove_dir(&self.folder));
    }
}

impl Outlet for Bag {
    type Topic<M: RosType> = BagTopic<M>;

    fn node(&self) -> &str {
        &self.node
    }

    fn now(&self) -> u64 {
        self.written.borrow().now
    }

    fn topic<M: RosType>(&mut self, name: &str, durability: Durability) -> Result<BagTopic<M>, String> {
        let written = &mut *self.written.borrow_mut();
        let failed = |error: &dyn core::fmt::Display| format!("topic {name}: {error}");
        if written.topics.iter().any(|topic| topic.name == name) {
            return Err(twice(name));
        }
        let definition = definitions::with_named(&format!("{}/{}", M::PACKAGE, M::NAME));
        let definition = definition.ok_or_else(|| failed(&"its type has no definition"))?;
        let kind = format!("{}/msg/{}", M::PACKAGE, M::NAME);
        let schema = written.writer.add_schema(&kind, "ros2msg", definition.as_bytes());
        let schema = schema.map_err(|error| failed(&error))?;
        let about = [("offered_qos_profiles".to_owned(), qos_profile(durability))];
        let channel = written.writer.add_channel(schema, name, "cdr", &BTreeMap::from(about));
        let channel = channel.map_err(|error| failed(&error))?;
        written.topics.push(Topic { name: name.to_owned(), kind, durability, channel, count: 0 });
        let place = written.topics.len() - 1;
        Ok(BagTopic { written: Rc::clone(&self.written), place, of: PhantomData })
    }
}

impl<M: RosType> Put<M> for BagTopic<M> {
    fn put(&self, message: M) {
        let written = &mut *self.written.borrow_mut();
        if written.failed.is_none() {
            written.failed = written.put(self.place, &message).err();
        }
    }
}

impl Written {
    fn put<M: RosType>(&mut self, place: usize, message: &M) -> Result<(), String> {
        let body = cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(|error| error.to_string())?;
        let data = [&LITTLE_ENDIAN[..], &body].concat();
        let topic = &mut self.topics[place];
        let header = MessageHeader {
            channel_id: topic.channel,
            sequence: topic.count,
            log_time: self.now,
            publish_time: self.now,
        };
        topic.count += 1;
        let [first, last] = self.span.unwrap_or([self.now; 2]);
        self.span = Some([first.min(self.now), last.max(self.now)]);
        self.writer.write_to_known_channel(&header, &data).map_err(|error| error.to_string())
    }

    fn count(&self) -> u64 {
        self.topics.iter().map(|topic| u64::from(topic.count)).sum()
    }

    /// What `metadata.yaml` says below its title, in version 9.
    fn metadata(&self, file: &str) -> String {
        let [first, last] = self.span.unwrap_or_default();
        let span = format!(
            "duration:\n  nanoseconds: {}\nstarting_time:\n  nanoseconds_since_epoch: {first}\nmessage_count: {}\n",
            last - first,
            self.count()
        );
        let indented = |text: &str, by: &str| {
            let lines = text.lines().map(|line| format!("{by}{line}\n"));
            lines.collect::<String>()
        };
        let file = serde_json::Value::from(file);
        let mut text = format!("version: 9\nstorage_identifier: mcap\n{span}topics_with_message_count:\n");
        for topic in &self.topics {
            // Writing to a string does not fail.
            let _ = write!(
                text,
                "  - topic_metadata:
      name: {}
      type: {}
      serialization_format: cdr
      offered_qos_profiles:
{}      type_description_hash: \"\"
    message_count: {}
",
                topic.name,
                topic.kind,
                indented(&qos_profile(topic.durability), "        "),
                topic.count
            );
        }
        let _ = write!(
            text,
            "compression_format: \"\"
compression_mode: \"\"
relative_file_paths:
  - {file}
files:
  - path: {file}
{}custom_data: ~
ros_distro: jazzy
",
            indented(&span, "    ")
        );
        text
    }
}

/// The quality of service that the bridge offers, as version 9 of the metadata says it.
fn qos_profile(durability: Durability) -> String {
    let (depth, durability) = match durability {
        Durability::Volatile => (100, "volatile"),
        Durability::TransientLocal => (1, "transient_local"),
    };
    let forever = "\n    sec: 9223372036\n    nsec: 854775807";
    format!(
        "- history: keep_last
  depth: {depth}
  reliability: reliable
  durability: {durability}
  deadline:{forever}
  lifespan:{forever}
  liveliness: automatic
  liveliness_lease_duration:{forever}
  avoid_ros_namespace_conventions: false
"
    )
}
