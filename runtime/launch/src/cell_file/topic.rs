//! What `[sensors.NAME.external.topic]` says: whose messages a bridge to ROS 2 sends as the sensor's readings. And `[topics."/NAME"]`: how the bridge publishes
//! a topic.

use core::ops::Range;
use core::time::Duration;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use mrroc_core::cell::CellError;

use super::error::Source;

/// A topic of ROS 2 whose messages are the readings of a sensor. Types of messages are known to the bridge alone, which checks what is said of them and
/// refuses it by [`refuse`](TopicEntry::refuse).
#[derive(Clone, Debug)]
pub struct TopicEntry {
    pub(super) source: Rc<Source>,
    pub(super) name: TopicText,
    pub(super) message: TopicText,
    pub(super) reading: TopicReading,
    pub(super) stamp: Option<TopicText>,
    pub(super) reliable: bool,
    pub(super) kept: bool,
    pub(super) depth: usize,
    pub(super) definitions: Option<TopicText>,
}

/// How the bridge to ROS 2 publishes a topic. Which topics there are is known to the bridge alone, which refuses others by [`refuse`](PublishedEntry::refuse).
#[derive(Clone, Debug)]
pub struct PublishedEntry {
    pub(super) source: Rc<Source>,
    pub(super) name: TopicText,
    pub(super) reliable: bool,
    pub(super) depth: usize,
    pub(super) every: Option<Duration>,
}

/// A text in the table.
#[derive(Clone, Debug)]
pub struct TopicText {
    /// It.
    pub text: String,
    pub(super) at: Place,
}

/// A place in the cell file.
#[derive(Clone, Debug)]
pub struct Place(pub(super) Range<usize>);

/// What of a message a reading, or a part of it, is.
#[derive(Clone, Debug)]
pub enum TopicReading {
    /// The path of a field in the message, such as `twist.linear.x` or `axes[2]`.
    Path(TopicText),
    /// Of each field by its name.
    Fields(Vec<(TopicText, TopicReading)>, Place),
    /// Of each value of an array.
    Items(Vec<TopicReading>, Place),
}

impl TopicText {
    /// Where it stands.
    #[must_use]
    pub const fn place(&self) -> &Place {
        &self.at
    }
}

impl TopicReading {
    /// Where it stands.
    #[must_use]
    pub const fn place(&self) -> &Place {
        match self {
            TopicReading::Path(path) => path.place(),
            TopicReading::Fields(_, place) | TopicReading::Items(_, place) => place,
        }
    }
}

impl TopicEntry {
    /// `name` of the topic.
    #[must_use]
    pub const fn name(&self) -> &TopicText {
        &self.name
    }

    /// `type` of its messages, such as `geometry_msgs/msg/TwistStamped`.
    #[must_use]
    pub const fn message(&self) -> &TopicText {
        &self.message
    }

    /// `reading`: where its parts are in a message.
    #[must_use]
    pub const fn reading(&self) -> &TopicReading {
        &self.reading
    }

    /// `stamp`: where the time of the measurement is in a message; `None`: a reading is as old as its arrival.
    #[must_use]
    pub const fn stamp(&self) -> Option<&TopicText> {
        self.stamp.as_ref()
    }

    /// `reliability`: whether lost messages are sent again.
    #[must_use]
    pub const fn is_reliable(&self) -> bool {
        self.reliable
    }

    /// `durability`: whether the last messages of before are wanted, too.
    #[must_use]
    pub const fn is_transient_local(&self) -> bool {
        self.kept
    }

    /// `depth`: how many messages wait to be read.
    #[must_use]
    pub const fn depth(&self) -> usize {
        self.depth
    }

    /// `definitions`: the folder of the packages that define messages of the user's own, with where the file names it.
    #[must_use]
    pub fn definitions(&self) -> Option<(PathBuf, &Place)> {
        let folder = self.definitions.as_ref()?;
        let beside = Path::new(&self.source.file).parent().unwrap_or(Path::new(""));
        Some((beside.join(&folder.text), folder.place()))
    }

    /// Refuses what stands at a place, and says what to write.
    #[must_use]
    pub fn refuse(&self, place: &Place, what: String, help: String) -> CellError {
        self.source.complain(&place.0, what, help).into()
    }
}

impl PublishedEntry {
    /// The name of the topic.
    #[must_use]
    pub const fn name(&self) -> &TopicText {
        &self.name
    }

    /// `reliability`: whether lost messages are sent again.
    #[must_use]
    pub const fn is_reliable(&self) -> bool {
        self.reliable
    }

    /// `depth`: how many messages wait for a subscriber that is slow.
    #[must_use]
    pub const fn depth(&self) -> usize {
        self.depth
    }

    /// `every_ms`: on average, one message in this time at most.
    #[must_use]
    pub const fn every(&self) -> Option<Duration> {
        self.every
    }

    /// Refuses it, and says what to write.
    #[must_use]
    pub fn refuse(&self, what: String, help: String) -> CellError {
        self.source.complain(&self.name.at.0, what, help).into()
    }
}
