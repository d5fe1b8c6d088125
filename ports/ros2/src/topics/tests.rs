//! Messages of other nodes as readings: against rosbags' serialisation, and against what cannot be believed.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use mrroc_core::observe::layout::{HardwareLayout, SensorLayout};
use mrroc_core::payload::Shape;
use mrroc_core::sensor::VspMode;
use mrroc_launch::cell_file::CellFile;
use proptest::prelude::*;
use serde::Deserialize;

use super::cdr::{ByteOrder, Refusal};
use super::mapping::{Mapping, Told};
use super::{AHEAD, Last, Owner, measured};

/// Messages as rosbags serialises them, by `reference/messages.py`.
const REFERENCE: &str = include_str!("../../reference/messages.json");

#[derive(Deserialize)]
struct Reference {
    /// Definitions that no package has.
    own: BTreeMap<String, String>,
    messages: Vec<Serialised>,
}

#[derive(Deserialize)]
struct Serialised {
    r#type: String,
    little: String,
    big: String,
    /// Numbers by their paths.
    values: BTreeMap<String, serde_json::Value>,
}

impl Serialised {
    /// Its body in each order of bytes, without the four bytes of the encapsulation.
    fn bodies(&self) -> [(ByteOrder, Vec<u8>); 2] {
        let bytes = |hex: &str| {
            let byte = |i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).expect("hexadecimal");
            (4..hex.len() / 2).map(byte).collect()
        };
        [(ByteOrder::Little, bytes(&self.little)), (ByteOrder::Big, bytes(&self.big))]
    }
}

fn reference() -> Reference {
    serde_json::from_str(REFERENCE).expect("as it was written")
}

/// A folder with the definitions that no package has.
struct Own(PathBuf);

impl Own {
    fn new(name: &str) -> Own {
        let folder = std::env::temp_dir().join(format!("mrroc-own-{}-{name}", std::process::id()));
        for (message, text) in reference().own {
            let file = folder.join(format!("{message}.msg"));
            std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
            std::fs::write(file, text).expect("written");
        }
        Own(folder)
    }

    /// What is read of a type's messages, by the rest of a table.
    fn mapping(&self, message: &str, rest: &str, shape: &'static Shape) -> Result<Mapping, String> {
        let text = format!(
            "step_ms = 2\n[robots.arm]\nkind = \"irp6\"\n[sensors.s]\nmode = \"free running\"\nperiod_ms = 4\nstale_after_ms = 100\n\
             [sensors.s.external]\nrate_hz = 30.0\n[sensors.s.external.topic]\nname = \"/s\"\ntype = \"{message}\"\n\
             definitions = \"{}\"\n{rest}\n",
            self.0.display()
        );
        let file = CellFile::parse("cell.toml", &text).map_err(|error| error.to_string())?;
        let (_, topic) = file.topics().next().expect("one");
        let sensor = SensorLayout {
            name: "s".to_owned(),
            kind: "s",
            of: None,
            readers: Vec::new(),
            every: 1,
            stale_after: Duration::from_millis(100),
            mode: VspMode::Interactive,
            latency: Duration::ZERO,
            reading: shape,
            reading_layout: 0,
            hardware: HardwareLayout::Nothing,
        };
        Mapping::of(topic, &sensor).map_err(|error| error.to_string())
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        drop(std::fs::remove_dir_all(&self.0));
    }
}

/// The word of a number of the reference, and what it is of.
fn expected(value: &serde_json::Value) -> (&'static Shape, u64) {
    match value {
        serde_json::Value::Bool(is) => (&Shape::Truth, u64::from(*is)),
        number if number.is_f64() => (&Shape::Float, number.as_f64().expect("a number").to_bits()),
        number if number.is_u64() => (&Shape::Unsigned, number.as_u64().expect("above 0")),
        number => (&Shape::Signed, number.as_i64().expect("a whole number").cast_unsigned()),
    }
}

#[test]
fn every_number_that_rosbags_serialises_is_read_to_the_bit_in_both_orders_of_bytes() {
    let own = Own::new("numbers");
    let mut compared = 0;
    for message in reference().messages {
        for (path, value) in &message.values {
            let (shape, word) = expected(value);
            let mapping = own.mapping(&message.r#type, &format!("reading = \"{path}\""), shape);
            let mapping = mapping.unwrap_or_else(|error| panic!("{} {path}: {error}", message.r#type));
            for (order, body) in message.bodies() {
                let told = mapping.read(&body, order);
                let told = told.unwrap_or_else(|why| panic!("{} {path} {order:?}: {why}", message.r#type));
                assert_eq!(
                    told,
                    Told { words: vec![word], stamp: None },
                    "{} {path} {order:?}",
                    message.r#type
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 1400, "{compared}");
}

#[test]
fn fault_256_a_message_that_was_cut_or_goes_on_is_refused_wherever_its_wanted_number_is() {
    let own = Own::new("cut");
    let mut types = 0;
    for message in reference().messages {
        // The first one: what is behind it is looked at all the same.
        // Some have texts alone.
        let Some((path, value)) = message.values.iter().next() else { continue };
        types += 1;
        let mapping = own.mapping(&message.r#type, &format!("reading = \"{path}\""), expected(value).0);
        let mapping = mapping.expect("nothing is wrong");
        for (order, body) in message.bodies() {
            for len in 0..body.len() {
                assert!(mapping.read(&body[..len], order).is_err(), "{} of {len} bytes", message.r#type);
            }
            let longer = |by| mapping.read(&[&body[..], &vec![0; by]].concat(), order);
            assert!(longer(3).is_ok(), "up to a multiple of four bytes");
            assert_eq!(longer(4), Err(Refusal::Long(4)), "{}", message.r#type);
        }
    }
    assert!(types > 60, "{types}");
}

#[test]
fn parts_of_messages_become_parts_of_readings_by_tables_lists_and_names() {
    const READING: Shape = Shape::Fields(&[
        ("pose", Shape::POSE),
        ("at", &Shape::Array(&Shape::Float, 3)),
        ("two", &Shape::Array(&Shape::Float, 2)),
        ("seconds", &Shape::Signed),
    ]);
    let own = Own::new("parts");
    let reference = reference();
    let message =
        reference.messages.iter().find(|m| m.r#type == "geometry_msgs/msg/PoseStamped").expect("there");
    let rest = "reading = { pose = \"pose\", at = \"pose.position\", two = [\"pose.orientation.w\", \"pose.position.z\"], seconds = \"header.stamp.sec\" }\n\
                stamp = \"header.stamp\"";
    let mapping = own.mapping(&message.r#type, rest, &READING).expect("nothing is wrong");
    let number = |path: &str| message.values[path].as_f64().expect("a number");
    let words = |paths: &[&str]| paths.iter().map(|path| number(path).to_bits()).collect::<Vec<_>>();
    let [sec, nanosec] =
        ["header.stamp.sec", "header.stamp.nanosec"].map(|path| message.values[path].as_i64());
    let (sec, nanosec) = (sec.expect("whole"), nanosec.expect("whole"));
    let [x, y, z] = ["pose.position.x", "pose.position.y", "pose.position.z"];
    let [i, j, k, w] =
        ["pose.orientation.x", "pose.orientation.y", "pose.orientation.z", "pose.orientation.w"];
    let mut all = words(&[x, y, z, i, j, k, w, x, y, z, w, z]);
    all.push(sec.cast_unsigned());
    for (order, body) in message.bodies() {
        let told = mapping.read(&body, order).expect("a message");
        assert_eq!(told.words, all);
        assert_eq!(told.stamp, Some(i128::from(sec) * 1_000_000_000 + i128::from(nanosec)));
    }
    // An array of fixed length, and the first values of one of any length.
    let fixed = own.mapping("own_msgs/msg/Everything", "reading = \"odd\"", &Shape::Array(&Shape::Float, 5));
    assert!(fixed.is_ok(), "{fixed:?}");
    let first =
        own.mapping("own_msgs/msg/Everything", "reading = \"numbers\"", &Shape::Array(&Shape::Float, 2));
    assert!(first.is_ok(), "{first:?}");
}

#[test]
fn fault_256_what_is_wrong_with_a_mapping_is_named_with_what_to_write() {
    const TWO: Shape = Shape::Fields(&[("v", &Shape::Float), ("on", &Shape::Truth)]);
    const TWIST: &str = "geometry_msgs/msg/TwistStamped";
    const ALL: &str = "own_msgs/msg/Everything";
    let own = Own::new("mapping");
    for (message, rest, shape, told, help) in [
        (
            "geometry_msgs/msg/TwistStampd",
            "reading = \"x\"",
            &Shape::Float,
            "no definition of",
            "did you mean `geometry_msgs/msg/TwistStamped`?",
        ),
        (
            ALL,
            "reading = { v = \"f64\" }",
            &TWO,
            "a reading has a field `on`, of which nothing is said",
            "write on = \"..\"",
        ),
        (
            ALL,
            "reading = { v = \"f64\", on = \"on\", w = \"f32\" }",
            &TWO,
            "a reading has no field `w`",
            "it has: v, on",
        ),
        (ALL, "reading = { v = \"f46\", on = \"on\" }", &TWO, "has no field `f46`", "did you mean `f64`?"),
        (
            ALL,
            "reading = { v = \"text\", on = \"on\" }",
            &TWO,
            "`text` is a text, and v is a number",
            "write the path",
        ),
        (
            ALL,
            "reading = { v = \"on\", on = \"on\" }",
            &TWO,
            "`on` is a value of type bool, and v is a number",
            "write the path",
        ),
        (
            ALL,
            "reading = { v = \"f64\", on = \"f64\" }",
            &TWO,
            "`f64` is a value of type float64, and on is true or false",
            "write the path",
        ),
        (ALL, "reading = \"f64\"", &TWO, "and a reading is made of fields: v, on", "write the path"),
        (
            ALL,
            "reading = \"inner\"",
            &TWO,
            "own_msgs/msg/Inner has none",
            "write a table, with the path of `v`",
        ),
        (ALL, "reading = { v = { x = \"f64\" }, on = \"on\" }", &TWO, "v is a number", "write the path"),
        (
            ALL,
            "reading = \"f32\"",
            &Shape::Signed,
            "`f32` is a value of type float32, and a reading is a whole number",
            "write the path",
        ),
        (ALL, "reading = \"odd[5]\"", &Shape::Float, "`odd[5]` has no such value", "from [0] to [4]"),
        (ALL, "reading = \"odd[-1]\"", &Shape::Float, "has no such value", "from [0] to [4]"),
        (ALL, "reading = \"few[4].b\"", &Shape::Float, "has no such value", "from [0] to [3]"),
        (ALL, "reading = \"f64[0]\"", &Shape::Float, "is no array", "leave [..] out"),
        (
            ALL,
            "reading = \"many.b\"",
            &Shape::Float,
            "`b` of an array of any length",
            "choose a value by [0]",
        ),
        (ALL, "reading = \"f64.b\"", &Shape::Float, "`b` of a value of type float64", "end the path there"),
        (ALL, "reading = \"\"", &Shape::Float, "has no field ``", "it has:"),
        (ALL, "reading = \"numbers\"", &Shape::Float, "an array of any length", "write the path"),
        (ALL, "reading = \"odd\"", &Shape::Array(&Shape::Float, 4), "an array of 5 values", "write the path"),
        (
            ALL,
            "reading = [\"f64\"]",
            &Shape::Array(&Shape::Float, 2),
            "1 values of a reading, which has 2",
            "write 2 paths",
        ),
        (ALL, "reading = \"f64\"", &Shape::Words(1), "of words that say nothing to others", "write the path"),
        (
            TWIST,
            "reading = \"twist.linear.x\"\nstamp = \"header\"",
            &Shape::Float,
            "a stamp is a message builtin_interfaces/msg/Time",
            "leave `stamp` out",
        ),
    ] {
        let error = own.mapping(message, rest, shape).expect_err(told);
        assert!(error.contains(told) && error.contains(help), "{told}, {help}: {error}");
        assert!(error.contains("cell.toml:"), "{error}");
    }
    let nowhere = Own(PathBuf::from("/nonexistent/of/mrroc"));
    let error = nowhere.mapping(TWIST, "reading = \"twist.linear.x\"", &Shape::Float).expect_err("no folder");
    assert!(error.contains("is no folder"), "{error}");
}

/// `own_msgs/msg/Everything` of the reference.
fn everything() -> Serialised {
    reference()
        .messages
        .into_iter()
        .find(|message| message.r#type == "own_msgs/msg/Everything")
        .expect("there")
}

#[test]
fn fault_256_values_that_a_reading_does_not_have_are_refused_by_name() {
    let own = Own::new("values");
    let mapping = |message: &str, path: &str, shape| {
        own.mapping(message, &format!("reading = \"{path}\""), shape).expect("nothing is wrong")
    };
    let joy = |axes: u32, buttons: [i32; 2]| {
        let mut body = vec![0; 8];
        body.extend(1_u32.to_le_bytes());
        body.extend([0, 0, 0, 0]);
        body.extend(axes.to_le_bytes());
        body.extend((0..axes).flat_map(|_| 0.5_f32.to_le_bytes()));
        body.extend(2_u32.to_le_bytes());
        body.extend(buttons.iter().flat_map(|button| button.to_le_bytes()));
        body
    };
    let read = |path: &str, shape, body: &[u8]| {
        let told = mapping("sensor_msgs/msg/Joy", path, shape).read(body, ByteOrder::Little);
        told.map(|told| told.words[0]).map_err(|why| why.to_string())
    };
    const CHOICE: &Shape = &Shape::Choice(&["Off", "On"]);
    assert_eq!(read("axes[1]", &Shape::Float, &joy(2, [0, 0])), Ok(0.5_f64.to_bits()));
    assert_eq!(read("axes[1]", &Shape::Single, &joy(2, [0, 0])), Ok(u64::from(0.5_f32.to_bits())));
    assert_eq!(
        read("axes[1]", &Shape::Float, &joy(1, [0, 0])),
        Err("`axes` has 1 values, and value [1] is wanted".to_owned())
    );
    assert_eq!(read("buttons[1]", &Shape::Truth, &joy(0, [0, 1])), Ok(1));
    let refused = |path, shape, body: &[u8]| read(path, shape, body).expect_err("refused");
    assert!(refused("buttons[1]", &Shape::Truth, &joy(0, [0, 2])).contains("is 2, and neither 0 nor 1"));
    assert!(
        refused("buttons[0]", &Shape::Unsigned, &joy(0, [-3, 0]))
            .contains("is -3, and the reading has no numbers below 0")
    );
    assert_eq!(read("buttons[0]", &Shape::Signed, &joy(0, [-3, 0])), Ok((-3_i64).cast_unsigned()));
    assert_eq!(read("buttons[0]", CHOICE, &joy(0, [1, 0])), Ok(1));
    assert!(refused("buttons[0]", CHOICE, &joy(0, [2, 0])).contains("no choice of this number"));
    let far = u64::MAX.to_le_bytes();
    let told = mapping("std_msgs/msg/UInt64", "data", &Shape::Signed).read(&far, ByteOrder::Little);
    assert!(told.expect_err("too large").to_string().contains("no numbers above 2^63 - 1"));
}

#[test]
fn fault_256_lengths_that_a_message_does_not_have_are_refused_before_they_are_believed() {
    let own = Own::new("lengths");
    let joints = own.mapping("sensor_msgs/msg/JointState", "reading = \"position[0]\"", &Shape::Float);
    let joints = joints.expect("nothing is wrong");
    let body = |frame: u32, names: u32| {
        let mut body = vec![0; 8];
        body.extend(frame.to_le_bytes());
        body.extend([b'x', 0, 0, 0]);
        body.extend(names.to_le_bytes());
        body
    };
    let refused = |body: &[u8]| joints.read(body, ByteOrder::Little).expect_err("refused").to_string();
    assert_eq!(refused(&body(u32::MAX, 0)), "it is too short: it ends in `frame_id`");
    assert_eq!(refused(&body(1, 0)), "the text `frame_id` has no end");
    assert_eq!(
        refused(&body(2, u32::MAX)),
        "`name` says that it has 4294967295 values, more than there are bytes"
    );
    assert_eq!(refused(&body(2, 0)), "it is too short: it ends in `position`");
    // Sequences and texts that are longer than their types allow.
    let all =
        own.mapping("own_msgs/msg/Everything", "reading = \"f64\"", &Shape::Float).expect("nothing is wrong");
    let [(order, good), _] = everything().bodies();
    let text = good.windows(6).position(|bytes| *bytes == [5, 0, 0, 0, b'z', b'c']).expect("`short`");
    let mut long = good;
    long[text] = 11;
    let why = all.read(&long, order).expect_err("of up to 9 bytes");
    assert_eq!(why, Refusal::Bound("short".to_owned(), 11));
}

#[test]
fn a_stamp_is_a_time_of_the_monotonic_clock_and_never_later_than_now() {
    // It was 5 s past some time, 100 s after the machine was started.
    let (now, wall) = (100_000_000_000, 1_700_000_005_000_000_000);
    let stamp = |seconds: f64| 1_700_000_005_000_000_000 + (seconds * 1e9) as i128;
    assert_eq!(measured(stamp(-0.25), now, wall), Ok(99_750_000_000));
    assert_eq!(measured(stamp(0.0), now, wall), Ok(now));
    assert_eq!(
        measured(stamp(0.0) + AHEAD, now, wall),
        Ok(now),
        "clocks that are kept alike are not the same"
    );
    let told = measured(stamp(0.5), now, wall).expect_err("of the future");
    assert!(told.contains("0.500 s ahead of this machine's clock"), "{told}");
    for none in [0, 12_000_000_000, i128::from(i64::MIN) * 1_000_000_000] {
        let told = measured(none, now, wall).expect_err("no stamp");
        assert!(told.contains("leave `stamp` out"), "{told}");
    }
}

#[test]
fn fault_256_a_second_publisher_is_refused_until_the_first_one_is_silent() {
    let mut owner = Owner { stale: 200, last: None };
    assert_eq!(owner.check("first", 1000), Ok(()));
    owner.last = Some(Last { writer: Some("first"), heard: 1000, measured: 990 });
    let told = owner.check("second", 1099).expect_err("the first one is there");
    assert!(told.contains("another publisher"), "{told}");
    assert_eq!(owner.check("first", 1099), Ok(()));
    assert_eq!(
        owner.check("second", 1100),
        Ok(()),
        "silent for half the time after which the sensor is stale"
    );
    owner.check("second", 1050).expect_err("it is there");
    owner.keep_if(|writer| *writer != "first");
    assert_eq!(owner.check("second", 1050), Ok(()), "the first one has gone");
}

#[test]
fn fault_256_a_stamp_that_stands_still_or_is_stale_is_refused() {
    const MS: u64 = 1_000_000;
    let mut owner = Owner { stale: 100 * MS, last: None };
    assert_eq!(owner.check_stamp(901 * MS, 1000 * MS), Ok(()));
    let told = owner.check_stamp(900 * MS, 1000 * MS).expect_err("stale");
    assert_eq!(told, "its stamp is 0.100 s old, and a reading is stale after 0.100 s");
    owner.last = Some(Last { writer: Some("first"), heard: 1000 * MS, measured: 990 * MS });
    assert_eq!(owner.check_stamp(991 * MS, 1010 * MS), Ok(()));
    let told = owner.check_stamp(990 * MS, 1010 * MS).expect_err("the same one");
    assert!(told.contains("not later than that of the message before"), "{told}");
}

/// A publisher at 50 Hz whose messages need 3 ms, and two wall clocks: its own, and that of the bridge's machine, which is set in the middle \[ns\]. Tells of each message whether
/// its reading counted, after having tested that this is not younger than the message's arrival nor older than it is by both clocks.
fn taken_while_clocks_are_set(by: i128, both: bool) -> Vec<bool> {
    const MS: u64 = 1_000_000;
    const TODAY: i128 = 1_700_000_000_000_000_000;
    let mut owner = Owner { stale: 200 * MS, last: None };
    let set =
        |of: u64, is_set: bool| TODAY + i128::from(of) + if is_set && of >= 10_050 * MS { by } else { 0 };
    let message = |k: u64| {
        let sent = 10_000 * MS + 20 * MS * k;
        let came = sent + 3 * MS;
        let (stamp, wall) = (set(sent, both), set(came, true));
        let taken =
            owner.take(Some(stamp), came, Some("it"), [came, u64::try_from(wall).expect("after 1970")]);
        if let Ok(measured) = taken {
            assert!(measured <= came, "message {k} counts as younger than its arrival");
            assert!(came - measured < 200 * MS, "message {k} counts as stale");
        }
        taken.is_ok()
    };
    (0..10).map(message).collect()
}

#[test]
fn fault_261_a_wall_clock_that_is_set_makes_no_reading_younger_than_its_arrival() {
    const HOUR: i128 = 3_600_000_000_000;
    // On one machine at most the message that was under way is refused: none here, where the clock was set between two.
    for by in [HOUR, -HOUR, 20_000_000, -20_000_000] {
        assert_eq!(taken_while_clocks_are_set(by, true), [true; 10], "set by {by} ns");
    }
    // Where the publisher is on another machine its stamps are of another clock from then on: they are refused, and the sensor gets stale.
    for by in [HOUR, -HOUR] {
        let expected: Vec<bool> = (0..10).map(|k| k < 3).collect();
        assert_eq!(taken_while_clocks_are_set(by, false), expected, "set by {by} ns");
    }
}

proptest! {
    #[test]
    fn fault_256_any_bytes_are_a_message_or_are_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        big in any::<bool>(),
    ) {
        let own = Own::new("bytes");
        let order = if big { ByteOrder::Big } else { ByteOrder::Little };
        for (message, path) in [("own_msgs/msg/Everything", "many[1].b"), ("sensor_msgs/msg/JointState", "position[2]")] {
            let mapping = own.mapping(message, &format!("reading = \"{path}\""), &Shape::Float).expect("nothing is wrong");
            if let Ok(told) = mapping.read(&bytes, order) {
                prop_assert_eq!(told.words.len(), 1);
            }
        }
    }

    #[test]
    fn fault_256_a_message_with_other_bytes_is_one_or_is_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let own = Own::new("changed");
        let mapping = own.mapping("own_msgs/msg/Everything", "reading = \"last\"", &Shape::Float).expect("nothing is wrong");
        for (order, mut body) in everything().bodies() {
            for (at, byte) in &changes {
                let at = at.index(body.len());
                body[at] = *byte;
            }
            if let Ok(told) = mapping.read(&body, order) {
                // It ends where the message does.
                let last: [u8; 8] = *body.last_chunk().expect("long enough");
                let last = if order == ByteOrder::Big { u64::from_be_bytes(last) } else { u64::from_le_bytes(last) };
                prop_assert_eq!(told.words[0], last);
            }
        }
    }
}
