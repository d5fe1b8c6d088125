//! Bags that others have written.
//!
//! In: a folder of rosbag2 with MCAP files, or such a file, which may have any contents; and which topic is meant. Out: its messages, and goals, one for each
//! trajectory, as clients of the action send them; or what is wrong. Nothing that a bag says of its lengths is believed before the bytes are there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use byteorder::{BigEndian, LittleEndian};
use mrroc_recording::{McapMessage, each_mcap_message};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::series::Series;
use crate::messages::{Header, JointState, Stamp};
use crate::topics::ByteOrder;
use crate::trajectories::{Duration, MultiTrajectory, Request, Trajectory};

/// The largest message of a trajectory \[bytes\]: a goal has 16,384 numbers at most, and a plan of MoveIt has a scene behind it. And all that are read of a
/// topic: of joint states, those of some minutes.
const LARGEST: usize = 4 << 20;
const LARGEST_TOPIC: usize = 16 << 20;
const LARGEST_SERIES: usize = 64 << 20;

/// The most trajectories of a topic.
const MOST_GOALS: usize = 1000;

/// Topics that a bag may have.
const MOST_TOPICS: usize = 10_000;

/// The types whose messages are trajectories, and the one whose messages are the points of one.
const JOINT_TRAJECTORY: &str = "trajectory_msgs/msg/JointTrajectory";
const GOAL: &str = "control_msgs/action/FollowJointTrajectory_Goal";
const DISPLAY: &str = "moveit_msgs/msg/DisplayTrajectory";
const JOINT_STATE: &str = "sensor_msgs/msg/JointState";

/// What is wanted of a bag.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// The topic, which is needed where several have trajectories.
    pub topic: Option<String>,
    /// How long the robots take to get to the first point, beyond what it says itself \[s\].
    pub approach: f64,
    /// How far points of joint states are apart at least \[s\].
    pub every: f64,
}

/// A bag.
pub struct Source {
    bag: PathBuf,
    /// Its MCAP files.
    files: Vec<PathBuf>,
}

/// `moveit_msgs/DisplayTrajectory`, as far as it is read.
#[derive(Deserialize)]
struct Display {
    _model_id: String,
    trajectory: Vec<(Trajectory, MultiTrajectory)>,
}

impl Source {
    /// The files of a bag.
    ///
    /// # Errors
    /// It is none that is read, and what to do.
    pub fn at(bag: &Path) -> Result<Source, String> {
        let failed = |why: &str| format!("{}: {why}", bag.display());
        if !bag.is_dir() {
            fs::metadata(bag).map_err(|error| failed(&error.to_string()))?;
            return match why_unreadable(bag) {
                Some(why) => Err(failed(why)),
                None => Ok(Source { bag: bag.to_owned(), files: vec![bag.to_owned()] }),
            };
        }
        let entries = fs::read_dir(bag).map_err(|error| failed(&error.to_string()))?;
        let inside: Result<Vec<_>, _> = entries.map(|entry| Ok(entry?.path())).collect();
        let mut inside = inside.map_err(|error: std::io::Error| failed(&error.to_string()))?;
        inside.sort();
        // A bag may be in several files, of which none is left out.
        if let Some(why) = inside.iter().find_map(|path| why_unreadable(path)) {
            return Err(failed(why));
        }
        inside.retain(|path| has_ending(path, "mcap"));
        match inside.is_empty() {
            false => Ok(Source { bag: bag.to_owned(), files: inside }),
            true => {
                Err(failed("is no bag: it has no .mcap file\n help: name the folder that has metadata.yaml"))
            }
        }
    }

    /// Hands over its messages, file by file.
    ///
    /// # Errors
    /// What is wrong with the bag, or what `take` says.
    pub fn each(&self, mut take: impl FnMut(McapMessage<'_>) -> Result<(), String>) -> Result<(), String> {
        self.files.iter().try_for_each(|file| each_mcap_message(file, &mut take))
    }

    /// What is wrong with the bag as a whole.
    pub fn wrong(&self, why: &str) -> String {
        format!("{}: {why}", self.bag.display())
    }

    /// The goals of a bag, in the order of their dates.
    ///
    /// # Errors
    /// What is wrong with the bag, or which topics it has.
    pub fn goals(&self, wanted: &Wanted) -> Result<Vec<Request>, String> {
        let (topic, kind) = self.topic(wanted.topic.as_deref())?;
        let (mut goals, mut series) = (Vec::new(), Series::default());
        let (mut count, mut bytes) = (0, 0);
        let most = if kind == JOINT_STATE { LARGEST_SERIES } else { LARGEST_TOPIC };
        self.each(|message| {
            if message.topic != topic {
                return Ok(());
            }
            count += 1;
            bytes += message.data.len();
            let wrong = |why: String| format!("topic {topic}, message {count}: {why}");
            if message.data.len() > LARGEST || bytes > most {
                return Err(wrong(format!(
                    "{} bytes, and {bytes} of all: at most {LARGEST} and {most} are read",
                    message.data.len()
                )));
            }
            if message.schema != kind {
                return Err(wrong(format!("it is of type {}, those before are of {kind}", message.schema)));
            }
            if message.encoding != "cdr" {
                return Err(wrong(format!("it is encoded by `{}`, and not in CDR", message.encoding)));
            }
            let date = message.date;
            match &*kind {
                JOINT_TRAJECTORY => {
                    let trajectory = whole(message.data).map_err(wrong)?;
                    goals.push((date, Request { trajectory, ..Request::default() }));
                }
                GOAL => goals.push((date, whole(message.data).map_err(wrong)?)),
                DISPLAY => {
                    // What comes behind the trajectories is the state of the scene.
                    let (display, _): (Display, usize) = decoded(message.data).map_err(wrong)?;
                    for (trajectory, multi_dof_trajectory) in display.trajectory {
                        let goal = Request { trajectory, multi_dof_trajectory, ..Request::default() };
                        goals.push((date, goal));
                    }
                }
                _ => series.take(date, &whole::<JointState>(message.data).map_err(wrong)?).map_err(wrong)?,
            }
            match goals.len() > MOST_GOALS {
                true => Err(format!("topic {topic}: it has more than {MOST_GOALS} trajectories")),
                false => Ok(()),
            }
        })?;
        if kind == JOINT_STATE {
            let trajectory = series
                .trajectory(wanted.every)
                .map_err(|why| self.wrong(&format!("topic {topic}: {why}")))?;
            goals.push((0, Request { trajectory, ..Request::default() }));
        }
        goals.sort_by_key(|(date, _)| *date);
        let begin = |(_, mut goal): (u64, Request)| {
            // Its own date is past: it begins when it is sent.
            goal.trajectory.header = Header { stamp: Stamp::default(), ..goal.trajectory.header };
            for point in &mut goal.trajectory.points {
                let later = point.time_from_start.later_by(wanted.approach);
                point.time_from_start = later.ok_or_else(|| {
                    self.wrong(&format!("topic {topic}: a point is at no time that can be told"))
                })?;
            }
            Ok(goal)
        };
        match goals.is_empty() {
            true => Err(self.wrong("its topic has no trajectory")),
            false => goals.into_iter().map(begin).collect(),
        }
    }

    /// The topics of its messages, and their types.
    ///
    /// # Errors
    /// What is wrong with the bag.
    pub fn topics(&self) -> Result<BTreeMap<String, String>, String> {
        let mut topics = BTreeMap::<String, String>::new();
        self.each(|message| {
            if !topics.contains_key(message.topic) {
                topics.insert(message.topic.to_owned(), message.schema.to_owned());
            }
            if topics.len() > MOST_TOPICS {
                return Err(format!("the bag has more than {MOST_TOPICS} topics"));
            }
            Ok(())
        })?;
        Ok(topics)
    }

    /// The topic that is meant, and its type.
    fn topic(&self, wanted: Option<&str>) -> Result<(String, String), String> {
        let topics = self.topics()?;
        let is_one_each = |kind: &str| [JOINT_TRAJECTORY, GOAL, DISPLAY].contains(&kind);
        let is_read = |kind: &str| is_one_each(kind) || kind == JOINT_STATE;
        let list = |is: &dyn Fn(&str) -> bool| {
            let named = topics.iter().filter(|(_, kind)| is(kind)).map(|(topic, _)| topic.as_str());
            let named: Vec<_> = named.take(20).collect();
            if named.is_empty() { "none".to_owned() } else { named.join(", ") }
        };
        match wanted {
            Some(topic) => match topics.get(topic) {
                Some(kind) if is_read(kind) => Ok((topic.to_owned(), kind.clone())),
                Some(kind) => Err(self.wrong(&format!(
                    "topic {topic} is of type {kind}, which is no trajectory\n help: --topic takes one of type {JOINT_TRAJECTORY}, {GOAL}, {DISPLAY} or \
                     {JOINT_STATE}; in this bag: {}",
                    list(&is_read)
                ))),
                None => Err(self.wrong(&format!(
                    "the bag has no message of topic {topic}\n help: it has trajectories in: {}",
                    list(&is_read)
                ))),
            },
            None => {
                let mut found = topics.iter().filter(|(_, kind)| is_one_each(kind));
                match (found.next(), found.next()) {
                    (Some((topic, kind)), None) => Ok((topic.clone(), kind.clone())),
                    (Some(_), _) => Err(self.wrong(&format!(
                        "the bag has several topics of trajectories\n help: name one by --topic: {}",
                        list(&is_read)
                    ))),
                    (None, _) => Err(self.wrong(&format!(
                        "the bag has no topic of trajectories\n help: name one of joint states by --topic, of which it has: {}; its topics: {}",
                        list(&is_read),
                        list(&|_| true)
                    ))),
                }
            }
        }
    }
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|of| of == ending)
}

/// Why a file of a bag cannot be read, by its name.
fn why_unreadable(path: &Path) -> Option<&'static str> {
    if has_ending(path, "db3") {
        return Some(
            "is a bag with sqlite3 storage, which is not read\n help: convert it: rosbags-convert --src BAG --dst NEW --dst-storage mcap, or ros2 bag convert",
        );
    }
    (has_ending(path, "zstd") || has_ending(path, "zst"))
        .then_some("is compressed as a whole file\n help: unpack it: zstd -d")
}

/// A message of which nothing is left when it was read.
fn whole<M: DeserializeOwned>(data: &[u8]) -> Result<M, String> {
    let (message, left) = decoded(data)?;
    // Some pad messages to whole words.
    if left > 3 {
        return Err(format!("{left} bytes are left when it was read: its type is another one of this name"));
    }
    Ok(message)
}

/// The body of a message, and the order of its bytes.
///
/// # Errors
/// It is not in plain CDR.
pub fn body(data: &[u8]) -> Result<(ByteOrder, &[u8]), String> {
    let (head, body) = data.split_at_checked(4).ok_or("it is shorter than 4 bytes")?;
    match head {
        [0, 1, ..] => Ok((ByteOrder::Little, body)),
        [0, 0, ..] => Ok((ByteOrder::Big, body)),
        [0x28, 0xb5, 0x2f, 0xfd] => Err(
            "it is compressed by zstd\n help: convert the bag: rosbags-convert --src BAG --dst NEW --dst-storage mcap"
                .to_owned(),
        ),
        other => Err(format!("it begins with {other:02x?}, and not as plain CDR")),
    }
}

/// A message, and how many bytes are left behind it.
fn decoded<M: DeserializeOwned>(data: &[u8]) -> Result<(M, usize), String> {
    let (order, body) = body(data)?;
    let read = match order {
        ByteOrder::Little => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        ByteOrder::Big => cdr_encoding::from_bytes::<M, BigEndian>(body),
    };
    let (message, used) = read.map_err(|error| format!("it cannot be read: {error}"))?;
    Ok((message, body.len().saturating_sub(used)))
}

impl Duration {
    /// Later by so much \[s\]; `None`: that cannot be told.
    fn later_by(self, seconds: f64) -> Option<Duration> {
        Duration::of(self.nanos() + (seconds * 1e9).round() as i64)
    }
}
