//! Bags in memory, without a cell. What other implementations read and write is compared in `tests/peers/ros2`.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use byteorder::{BigEndian, LittleEndian};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use mrroc_core::observe::layout::{HardwareLayout, SensorLayout};
use mrroc_core::payload::{Shape, Wire as _};
use mrroc_core::pose::Wrench;
use mrroc_core::sensor::VspMode;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::simulated;
use proptest::prelude::*;
use serde::Serialize;
use serde_json::json;

use super::file::{Bag, LITTLE_ENDIAN};
use super::read::{Source, Wanted};
use crate::messages::{Header, JointState, Stamp, Vector, WrenchStamped};
use crate::readings::ReadingTopics;
use crate::topics::{self, Recorded, Told};
use crate::trajectories::{Duration, MultiTrajectory, Point, Request, Trajectory};

const TRAJECTORY: &str = "trajectory_msgs/msg/JointTrajectory";
const STATE: &str = "sensor_msgs/msg/JointState";

/// A message of a topic: its type, its date \[ns\], and its bytes.
type Message = (&'static str, &'static str, u64, Vec<u8>);

/// An MCAP file of these messages.
fn bag(messages: &[Message]) -> Vec<u8> {
    let options = WriteOptions::new().profile("ros2").compression(Some(Compression::Lz4));
    let mut writer = options.create(Cursor::new(Vec::new())).expect("a file");
    for (topic, kind, log_time, data) in messages {
        let schema = writer.add_schema(kind, "ros2msg", b"").expect("a schema");
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel");
        let header = MessageHeader { channel_id, sequence: 0, log_time: *log_time, publish_time: 0 };
        writer.write_to_known_channel(&header, data).expect("written");
    }
    writer.finish().expect("an end");
    writer.into_inner().into_inner()
}

fn cdr(message: &impl Serialize) -> Vec<u8> {
    [&LITTLE_ENDIAN[..], &cdr_encoding::to_vec::<_, LittleEndian>(message).expect("CDR")].concat()
}

fn trajectory(times: &[i64]) -> Trajectory {
    let point = |&ms: &i64| Point {
        positions: vec![ms as f64, -0.5],
        time_from_start: Duration::of(ms * 1_000_000).expect("a time"),
        ..Point::default()
    };
    Trajectory {
        header: Header { stamp: Stamp { sec: 7, nanosec: 8 }, frame_id: "base".to_owned() },
        joint_names: vec!["a".to_owned(), "b".to_owned()],
        points: times.iter().map(point).collect(),
    }
}

fn read(bytes: &[u8], topic: Option<&str>) -> Result<Vec<Request>, String> {
    goals_in(bytes, &Wanted { topic: topic.map(str::to_owned), approach: 0.0, every: 0.0 })
}

/// What is read of a file with these bytes.
fn goals_in(bytes: &[u8], wanted: &Wanted) -> Result<Vec<Request>, String> {
    in_file(bytes, |file| Source::at(file).and_then(|source| source.goals(wanted)))
}

/// What is made of a file with these bytes.
fn in_file<T>(bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    let name = format!("mrroc-ros2-bag-{}-{:?}.mcap", std::process::id(), std::thread::current().id());
    let file = std::env::temp_dir().join(name);
    std::fs::write(&file, bytes).expect("written");
    let made = read(&file);
    std::fs::remove_file(&file).expect("removed");
    made
}

#[test]
fn trajectories_are_goals_in_the_order_of_their_dates_and_begin_when_they_are_sent() {
    let (early, late) = (trajectory(&[500, 1000]), trajectory(&[250]));
    let bytes = bag(&[("/plan", TRAJECTORY, 9, cdr(&late)), ("/plan", TRAJECTORY, 5, cdr(&early))]);
    let goals = read(&bytes, None).expect("one topic");
    let expected = |of: &Trajectory| Trajectory {
        header: Header { stamp: Stamp::default(), frame_id: "base".to_owned() },
        ..of.clone()
    };
    let found: Vec<_> = goals.into_iter().map(|goal| goal.trajectory).collect();
    assert_eq!(found, [expected(&early), expected(&late)]);
    let wanted = Wanted { approach: 1.5, ..Wanted::default() };
    let later = goals_in(&bytes, &wanted).expect("the same, later");
    let times: Vec<_> =
        later[0].trajectory.points.iter().map(|point| point.time_from_start.nanos()).collect();
    assert_eq!(times, [2_000_000_000, 2_500_000_000]);
}

#[test]
fn both_orders_of_bytes_and_goals_and_plans_of_moveit_are_read() {
    let of = trajectory(&[100]);
    let big = [&[0, 0, 0, 0][..], &cdr_encoding::to_vec::<_, BigEndian>(&of).expect("CDR")].concat();
    assert_eq!(read(&bag(&[("/a", TRAJECTORY, 1, big)]), None).expect("big").len(), 1);
    let goal = Request {
        trajectory: of.clone(),
        goal_time_tolerance: Duration { sec: 3, nanosec: 0 },
        ..Request::default()
    };
    let kind = "control_msgs/action/FollowJointTrajectory_Goal";
    let found = read(&bag(&[("/a", kind, 1, cdr(&goal))]), None).expect("a goal");
    assert_eq!(found[0].goal_time_tolerance.sec, 3);
    // What comes behind the trajectories is not looked at.
    let plan = vec![(of.clone(), MultiTrajectory::default()), (of, MultiTrajectory::default())];
    let display = cdr(&("arm".to_owned(), plan, vec![1.0, 2.0, 3.0]));
    let kind = "moveit_msgs/msg/DisplayTrajectory";
    assert_eq!(read(&bag(&[("/a", kind, 1, display)]), None).expect("a plan").len(), 2);
}

/// Joint states of two robots.
fn states() -> Vec<Message> {
    let state = |ms: u32, name: &str, position: f64| JointState {
        header: Header { stamp: Stamp { sec: 1, nanosec: ms * 1_000_000 }, frame_id: String::new() },
        name: vec![name.to_owned()],
        position: vec![position],
        ..JointState::default()
    };
    let mut messages = vec![("/joint_states", STATE, 0, cdr(&state(0, "right", 9.0)))];
    for k in 1..=10 {
        for (name, offset) in [("left", 0.0), ("right", 100.0)] {
            let state = state(20 * k, name, offset + f64::from(k));
            messages.push(("/joint_states", STATE, u64::from(k), cdr(&state)));
        }
    }
    messages
}

#[test]
fn joint_states_of_one_stamp_are_a_point_and_stamps_without_all_joints_are_left_out() {
    let bytes = bag(&states());
    let goals = read(&bytes, Some("/joint_states")).expect("a series");
    let [goal] = &goals[..] else { panic!("{} goals", goals.len()) };
    assert_eq!(goal.trajectory.joint_names, ["right", "left"]);
    let points = &goal.trajectory.points;
    let told: Vec<_> =
        points.iter().map(|point| (point.time_from_start.nanos(), &*point.positions)).collect();
    assert_eq!(told.len(), 10);
    assert_eq!((told[0].0, told[0].1), (0, &[101.0, 1.0][..]));
    assert_eq!((told[9].0, told[9].1), (180_000_000, &[110.0, 10.0][..]));
    let wanted = Wanted { topic: Some("/joint_states".to_owned()), approach: 0.0, every: 0.05 };
    let goals = goals_in(&bytes, &wanted).expect("a series");
    let times: Vec<_> =
        goals[0].trajectory.points.iter().map(|point| point.time_from_start.nanos() / 1_000_000).collect();
    // The last one is there in any case, and no two are nearer than asked for.
    assert_eq!(times, [0, 60, 120, 180]);
    // Joint states are taken where they are named alone: every bag of a robot has them.
    let why = read(&bytes, None).expect_err("no trajectory");
    assert!(why.contains("no topic of trajectories") && why.contains("/joint_states"), "{why}");
}

#[test]
fn what_is_wrong_with_a_bag_is_told_by_name() {
    let good = cdr(&trajectory(&[100]));
    let of = |data: &[u8]| bag(&[("/a", TRAJECTORY, 1, data.to_vec())]);
    let changed = |place: usize, bytes: &[u8]| {
        let mut data = good.clone();
        data[place..place + bytes.len()].copy_from_slice(bytes);
        of(&data)
    };
    let longer = |more: usize| of(&[&good[..], &vec![0; more]].concat());
    let two = bag(&[("/a", TRAJECTORY, 1, good.clone()), ("/b", TRAJECTORY, 1, good.clone())]);
    let unequal = JointState { name: vec!["a".to_owned()], ..JointState::default() };
    for (bytes, topic, text) in [
        (b"SQLite format 3\0".to_vec(), None, "no MCAP file"),
        (of(&good)[..100].to_vec(), None, "is cut off: it has no end\n help: copy it again"),
        (of(&good[..3]), None, "shorter than 4 bytes"),
        (of(&good[..good.len() - 8]), None, "cannot be read"),
        (longer(64), None, "64 bytes are left"),
        // The length of the list of names is at 24: seconds, nanoseconds, and 5 letters with their length before it.
        (changed(24, &[0xff; 4]), None, "cannot be read"),
        (changed(0, &[0, 7]), None, "not as plain CDR"),
        (changed(0, &[0x28, 0xb5, 0x2f, 0xfd]), None, "compressed by zstd"),
        (longer(5 << 20), None, "at most"),
        (two.clone(), None, "several topics of trajectories\n help: name one by --topic: /a, /b"),
        (two, Some("/c"), "no message of topic /c"),
        (bag(&[("/t", "std_msgs/msg/String", 1, vec![])]), Some("/t"), "type std_msgs/msg/String"),
        (bag(&[("/t", "std_msgs/msg/String", 1, vec![])]), None, "no topic of trajectories"),
        (bag(&[("/s", STATE, 1, cdr(&unequal))]), Some("/s"), "0 positions for 1 joints"),
    ] {
        let why = read(&bytes, topic).expect_err(text);
        assert!(why.contains(text), "{text}: {why}");
    }
    let many: Vec<_> = (0..1001).map(|date| ("/a", TRAJECTORY, date, good.clone())).collect();
    assert!(read(&bag(&many), None).is_err_and(|why| why.contains("more than 1000 trajectories")));
    assert_eq!(read(&bag(&many[1..]), None).map(|goals| goals.len()), Ok(1000));
    // Padding to whole words is not foreign.
    assert!(read(&longer(3), None).is_ok());
}

proptest! {
    /// Whatever the bytes are, the answer is goals or what is wrong: bytes of a message, and bytes of the file about it. No more numbers come out than went in.
    #[test]
    fn a_damaged_bag_is_read_or_refused(
        changes in proptest::collection::vec((any::<u16>(), any::<u8>()), 1..8),
        cut in proptest::option::of(any::<u16>()),
        is_in_message in any::<bool>(),
        has_states in any::<bool>(),
    ) {
        let damage = |mut bytes: Vec<u8>| {
            for &(place, byte) in &changes {
                let place = usize::from(place) % bytes.len();
                bytes[place] = byte;
            }
            if let Some(cut) = cut {
                bytes.truncate(usize::from(cut) % bytes.len());
            }
            bytes
        };
        let mut messages = states();
        if !has_states {
            messages = vec![("/joint_states", TRAJECTORY, 1, cdr(&trajectory(&[1, 2, 3])))];
        }
        let bytes = if is_in_message {
            for message in &mut messages {
                message.3 = damage(core::mem::take(&mut message.3));
            }
            bag(&messages)
        } else {
            damage(bag(&messages))
        };
        let most: usize = messages.iter().map(|(.., data)| data.len() / 8).sum();
        for topic in [None, Some("/joint_states")] {
            match read(&bytes, topic) {
                Ok(goals) => {
                    let points = goals.iter().flat_map(|goal| &goal.trajectory.points);
                    let numbers: usize = points.map(|point| point.numbers() - 1).sum();
                    prop_assert!(numbers <= most, "{numbers} of {most}");
                }
                Err(why) => prop_assert!(!why.is_empty()),
            }
        }
    }
}

/// What is read of a bag for the sensors `gauge`, a number of `/gauge`, and `arrival`, a number of `/stamped` whose message has a stamp.
fn recorded(bytes: &[u8]) -> Result<Recorded, Vec<String>> {
    let sensor = |name: &str, topic: &str| {
        format!(
            "[sensors.{name}]\nmode = \"free running\"\nperiod_ms = 2\nstale_after_ms = 100\n\
             [sensors.{name}.external]\nrate_hz = 50.0\n[sensors.{name}.external.topic]\n{topic}\n"
        )
    };
    let text = format!(
        "step_ms = 2\nrobots.arm = {{ kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }}\n{}{}",
        sensor("gauge", "name = \"/gauge\"\ntype = \"std_msgs/msg/Float64\"\nreading = \"data\""),
        sensor(
            "arrival",
            "name = \"/stamped\"\ntype = \"geometry_msgs/msg/PointStamped\"\nreading = \"point.x\"\nstamp = \"header.stamp\""
        ),
    );
    let file = CellFile::parse("cell.toml", &text).expect("nothing is wrong with it");
    let layout = CellFile::parse("cell.toml", text.split_once("[sensors").expect("two").0);
    let mut layout = layout.expect("the robot alone").cell(&simulated()).expect("a cell").layout();
    layout.sensors.extend(["gauge", "arrival"].map(|name| SensorLayout {
        name: name.to_owned(),
        kind: "number",
        of: None,
        readers: Vec::new(),
        every: 1,
        stale_after: std::time::Duration::from_millis(100),
        mode: VspMode::Interactive,
        latency: std::time::Duration::ZERO,
        reading: &Shape::Float,
        reading_layout: 0,
        hardware: HardwareLayout::Nothing,
    }));
    let mapped = topics::mapped(&layout, &file).expect("its topics have these types");
    in_file(bytes, |bag| Recorded::read(bag, &mapped))
}

const NUMBER: &str = "std_msgs/msg/Float64";
const POINT: &str = "geometry_msgs/msg/PointStamped";

fn stamped(sec: i32, x: f64) -> Vec<u8> {
    cdr(&((sec, 5_u32), "world".to_owned(), x, 0.0, 0.0))
}

#[test]
fn fault_256_messages_of_a_bag_are_due_as_long_after_the_first_step_as_they_are_after_the_bags_first_message()
{
    const MS: u64 = 1_000_000;
    const DATE: u64 = 1_700_000_000_000 * MS;
    let bytes = bag(&[
        ("/other", STATE, DATE, cdr(&JointState::default())),
        // Files are in no order of dates.
        ("/gauge", NUMBER, DATE + 40 * MS, cdr(&0.75)),
        ("/gauge", NUMBER, DATE + 20 * MS, cdr(&0.1)),
        ("/gauge", NUMBER, DATE + 30 * MS, vec![0, 1, 0, 0, 1, 2]),
        ("/stamped", POINT, DATE + 20 * MS, stamped(1_699_999_999, -2.5)),
    ]);
    let mut recorded = recorded(&bytes).expect("both topics are there");
    assert_eq!(recorded.extent(0), (3, 0.04));
    assert!(recorded.next(u64::MAX).is_none(), "no cell runs");
    // Of `/stamped` the message is older than 100 ms, after which its reading is stale; without a bound on its age it is not refused.
    let short = "it is too short: it ends in `data`".to_owned();
    assert_eq!(recorded.refused(0, 100 * MS), Some((1, short)));
    let stale = "its stamp is 1.020 s old, and a reading is stale after 0.100 s".to_owned();
    assert_eq!(recorded.refused(1, 100 * MS), Some((1, stale)));
    assert_eq!(recorded.refused(1, 2000 * MS), None);
    // Where no cell runs the first messages are offered ten times a second.
    assert_eq!([400, 499, 500].map(|ms| recorded.offers_first(ms * MS)), [true, false, true]);
    assert_eq!(recorded.first(0).map(|told| told.words.clone()), Some(vec![0.1_f64.to_bits()]));
    let mut run = |first: u64, began: u64| {
        recorded.step(2 * MS * first, began, false);
        assert!(recorded.next(began + 20 * MS - 1).is_none());
        // The bridge is late: what is due comes in its order, each since its own time.
        let late = began + 35 * MS;
        let mut due = Vec::new();
        let mut take = |recorded: &mut Recorded, now: u64| {
            while let Some((message, since)) = recorded.next(now) {
                due.push((message.place, (since - began) / MS, message.date, message.told.clone()));
            }
        };
        take(&mut recorded, late);
        recorded.step(2 * MS * (first + 17), late, false);
        take(&mut recorded, late);
        recorded.step(2 * MS * (first + 18), late, false);
        take(&mut recorded, began + 40 * MS);
        take(&mut recorded, u64::MAX);
        due
    };
    let told = |x: f64, stamp| Ok(Told { words: vec![x.to_bits()], stamp });
    let stamp = Some(1_699_999_999_000_000_005);
    let expected = [
        (0, 20, DATE + 20 * MS, told(0.1, None)),
        (1, 20, DATE + 20 * MS, told(-2.5, stamp)),
        (0, 30, DATE + 30 * MS, Err("it is too short: it ends in `data`".to_owned())),
        (0, 40, DATE + 40 * MS, told(0.75, None)),
    ];
    assert_eq!(run(1, 600 * MS), expected);
    // Another run of the cell hears it from the beginning.
    assert_eq!(run(0, 9000 * MS), expected);
    // Its newest step was seen at 9035 ms.
    assert_eq!([10_034, 10_035].map(|ms| recorded.offers_first(ms * MS)), [false, true]);
    assert!(recorded.first(0).is_some(), "all of its messages are sent");
}

#[test]
fn fault_256_after_the_end_of_a_run_nothing_of_a_bag_is_sent_and_the_next_run_begins_the_bag_again() {
    const MS: u64 = 1_000_000;
    let at = |ms: u64, x: f64| ("/gauge", NUMBER, ms * MS, cdr(&x));
    let bytes = bag(&[at(10, 0.1), at(20, 0.2), at(30, 0.3), ("/stamped", POINT, 10 * MS, stamped(0, 0.0))]);
    let mut recorded = recorded(&bytes).expect("both topics are there");
    // It ends at its first step.
    recorded.step(0, 500 * MS, false);
    assert_eq!(recorded.next(500 * MS).map(|(_, due)| due), Some(500 * MS));
    recorded.step(0, 502 * MS, true);
    assert!(recorded.next(u64::MAX).is_none(), "it is over");
    assert!(recorded.offers_first(503 * MS) && recorded.first(0).is_some(), "another one may begin");
    recorded.step(0, 600 * MS, false);
    let mut due = Vec::new();
    while let Some((message, since)) = recorded.next(610 * MS) {
        due.push((message.place, since / MS));
    }
    assert_eq!(due, [(0, 600), (1, 600), (0, 610)]);
    assert!(!recorded.offers_first(610 * MS));
    // That one is killed, and of another one a later step is seen first.
    recorded.step(10 * MS, 610 * MS, false);
    recorded.step(400 * MS, 5000 * MS, false);
    assert_eq!(recorded.next(5000 * MS).map(|(_, due)| due), Some(5000 * MS));
    // Steps that are not seen may be those of a cell that runs: what is due would be replaced, but for topics that have no more of it.
    assert!(recorded.next(5000 * MS).is_some());
    assert!(recorded.offers_first(6000 * MS));
    assert!(recorded.first(0).is_none() && recorded.first(1).is_some());
}

#[test]
fn fault_256_a_bag_that_cannot_be_what_sensors_read_is_refused_by_name() {
    let point = |topic| (topic, POINT, 5, stamped(0, 0.0));
    let number = |data: Vec<u8>| ("/gauge", NUMBER, 5, data);
    let wrong = |messages: &[Message]| recorded(&bag(messages)).expect_err("refused");
    // All that is wrong is told.
    let both = wrong(&[point("/gauge"), point("/stampd")]);
    assert!(both.len() == 2, "{both:?}");
    assert!(both[0].contains("topic /gauge is of type geometry_msgs/msg/PointStamped, and sensor `gauge` reads std_msgs/msg/Float64"), "{both:?}");
    assert!(both[1].contains("no message of topic /stamped, which sensor `arrival` reads"), "{both:?}");
    assert!(both[1].contains("did you mean `/stampd`? it has messages of: /gauge, /stampd"), "{both:?}");
    let compressed = wrong(&[point("/stamped"), number(vec![0x28, 0xb5, 0x2f, 0xfd, 0])]);
    assert!(
        compressed[0]
            .contains("no message of topic /gauge can be read, the first one: it is compressed by zstd"),
        "{compressed:?}"
    );
    let long = wrong(&[point("/stamped"), number([&LITTLE_ENDIAN[..], &vec![0; (1 << 20) + 1]].concat())]);
    assert!(long[0].contains("more than 1 MiB"), "{long:?}");
    // A date of 0 would make all others due after many years.
    const DAY: u64 = 86_400_000_000_000;
    let dated = |first: u64, last: u64| {
        let messages = [("/said", STATE, first), ("/stamped", POINT, last), ("/gauge", NUMBER, last)];
        recorded(&bag(&messages.map(|(topic, kind, date)| match kind {
            NUMBER => (topic, kind, date, cdr(&0.5)),
            POINT => (topic, kind, date, stamped(0, 0.0)),
            _ => (topic, kind, date, cdr(&JointState::default())),
        })))
    };
    assert!(dated(5, 5 + DAY).is_ok());
    let far = dated(0, 1_700_000_000_500_000_000).expect_err("too long");
    assert!(far.len() == 1 && far[0].contains("longer than a day: the first is a message of topic /said at 0.000 s since 1970, the last a message of topic /stamped at 1700000000.500 s"), "{far:?}");
    let cut = recorded(&bag(&[point("/stamped")])[..200]).expect_err("cut off");
    assert!(cut[0].contains("mcap recover"), "{cut:?}");
}

#[test]
fn readings_have_a_topic_for_each_number_each_list_of_numbers_and_each_wrench() {
    const SHAPE: &Shape = &Shape::Fields(&[
        ("x", &Shape::Float),
        ("touches", &Shape::Truth),
        ("side", &Shape::Choice(&["Left", "Right"])),
        ("force", &Shape::Array(&Shape::Float, 3)),
        ("grid", &Shape::Array(&Shape::Array(&Shape::Unsigned, 2), 3)),
        ("tip", &Shape::Fields(&[("z", &Shape::Signed)])),
        ("hash", &Shape::Words(1)),
        ("touch", Wrench::SHAPE),
    ]);
    let stamp = Stamp { sec: 7, nanosec: 8 };
    let place = std::env::temp_dir().join(format!("mrroc-ros2-readings-{}", std::process::id()));
    let mut bag = Bag::create(&place, "cell").expect("a folder");
    bag.set_now(1000);
    let topics = ReadingTopics::open(&mut bag, "/sensors/wrist", SHAPE, "arm/tool").expect("topics");
    topics.put(
        stamp,
        &json!({
            "x": "Infinity", "touches": true, "side": "Right", "force": [1.5, -2.0, 0.1],
            "grid": [[1, 2], [3, 4], [5, 6]], "tip": {"z": -3}, "hash": ["00"],
            "touch": {"force": [0.1, -2.0, "NaN"], "torque": [1e-3, 0.5, -0.25]},
        }),
    );
    let again = ReadingTopics::<Bag>::open(&mut bag, "/sensors/wrist/x", &Shape::Float, "");
    assert!(again.is_err_and(|why| why.contains("twice")));
    assert_eq!(bag.finish().expect("written"), [7, 7]);
    let name = format!("{}_0.mcap", place.file_name().expect("a name").to_string_lossy());
    let mut found = BTreeMap::new();
    let take = |message: mrroc_recording::McapMessage<'_>| {
        assert_eq!((message.date, message.encoding), (1000, "cdr"));
        found.insert(message.topic.to_owned(), (message.schema.to_owned(), message.data[4..].to_vec()));
        Ok(())
    };
    mrroc_recording::each_mcap_message(&place.join(name), take).expect("an MCAP file");
    let is_there = Bag::create(&place, "cell").err().expect("it is there already");
    bag.discard();
    assert!(is_there.contains("is there already") && !place.exists(), "{is_there}");
    let kinds: Vec<_> = found.iter().map(|(topic, (kind, _))| (topic.as_str(), kind.as_str())).collect();
    let expected = [
        ("/sensors/wrist/force", "std_msgs/msg/Float64MultiArray"),
        ("/sensors/wrist/grid", "std_msgs/msg/Float64MultiArray"),
        ("/sensors/wrist/side", "std_msgs/msg/String"),
        ("/sensors/wrist/tip/z", "std_msgs/msg/Float64"),
        ("/sensors/wrist/touch", "geometry_msgs/msg/WrenchStamped"),
        ("/sensors/wrist/touches", "std_msgs/msg/Bool"),
        ("/sensors/wrist/x", "std_msgs/msg/Float64"),
    ];
    assert_eq!(kinds, expected);
    assert_eq!(found["/sensors/wrist/x"].1, f64::INFINITY.to_le_bytes());
    type Numbers = (Vec<(String, u32, u32)>, u32, Vec<f64>);
    let numbers = |of: &str| {
        let read =
            cdr_encoding::from_bytes::<Numbers, LittleEndian>(&found[&format!("/sensors/wrist/{of}")].1);
        read.expect("a list of numbers").0
    };
    assert_eq!(numbers("force"), (vec![("force".to_owned(), 3, 3)], 0, vec![1.5, -2.0, 0.1]));
    let dimensions = vec![("grid".to_owned(), 3, 6), ("grid[]".to_owned(), 2, 2)];
    assert_eq!(numbers("grid"), (dimensions, 0, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    let touch = cdr_encoding::from_bytes::<WrenchStamped, LittleEndian>(&found["/sensors/wrist/touch"].1);
    let touch = touch.expect("a wrench").0;
    assert_eq!(touch.header, Header { stamp, frame_id: "arm/tool".to_owned() });
    assert!([touch.force.x, touch.force.y] == [0.1, -2.0] && touch.force.z.is_nan(), "{touch:?}");
    assert_eq!(touch.torque, Vector { x: 1e-3, y: 0.5, z: -0.25 });
}
