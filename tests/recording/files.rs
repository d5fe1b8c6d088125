//! What is refused: files that are cut off, damaged, foreign, or of another cell. None of them ends in a panic.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use mrroc::prelude::*;
use mrroc::recording::{CutOff, Replay, ReplayError};
use mrroc_robots::{Irp6, SimulatedIrp6};
use mrroc_tests::{ExactDrive, Gantry, Q};
use proptest::prelude::*;

use crate::recording::cell::{Change, START, STEP, arms};
use crate::recording::recorded;

/// A recording, whole.
fn whole() -> &'static [u8] {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    WHOLE.get_or_init(|| fs::read(recorded("whole.mcap")).expect("was written"))
}

fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&file, bytes).expect("a file");
    file
}

/// Why a file of these bytes is refused.
fn refusal(name: &str, bytes: &[u8]) -> String {
    match arms(Change::Nothing).replay(written(name, bytes), CutOff::Refused) {
        Err(ReplayError::File(error)) => {
            let told = error.to_string();
            assert!(told.contains(name) && told.contains("\n help: "), "{told}");
            told
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_no_recording_is_refused_with_what_it_is() {
    for (bytes, told) in [
        (&b""[..], "ends before it says what it is"),
        (b"PK\x03\x04 and so on, for some more bytes", "is no MCAP file"),
        (&whole()[..7], "ends before it says what it is"),
    ] {
        let refused = refusal("foreign.mcap", bytes);
        assert!(refused.contains(told), "{refused}");
    }
    for unreadable in ["no/such/file.mcap", env!("CARGO_TARGET_TMPDIR")] {
        let refused = arms(Change::Nothing).replay(unreadable, CutOff::Refused);
        assert!(refused.is_err_and(|error| error.to_string().contains("cannot be read")));
    }
}

#[test]
fn a_recording_of_another_profile_is_refused() {
    // The header's profile is the first text of the file: magic, opcode, length, then the text behind its length.
    let mut bytes = whole().to_vec();
    let at = 8 + 1 + 8 + 4;
    assert_eq!(&bytes[at..at + 5], b"mrroc");
    bytes[at..at + 5].copy_from_slice(b"other");
    let refused = refusal("profile.mcap", &bytes);
    assert!(refused.contains("is no recording of a cell: its profile is `other`"), "{refused}");
}

#[test]
fn a_recording_that_was_cut_off_is_refused_or_taken_as_far_as_it_goes() {
    let half = &whole()[..whole().len() / 2];
    let refused = refusal("half.mcap", half);
    assert!(refused.contains("is cut off: it has no end") && refused.contains("--partial"), "{refused}");
    let file = written("half-taken.mcap", half);
    let compared = arms(Change::Nothing).replay(file, CutOff::Taken).expect("as far as it goes");
    assert!(compared.is_identical() && compared.end.is_none(), "{compared:?}");
    let all = arms(Change::Nothing).replay(written("all.mcap", whole()), CutOff::Taken).expect("whole");
    assert!(
        compared.steps > all.steps / 4 && compared.steps < all.steps,
        "{} of {}",
        compared.steps,
        all.steps
    );
}

#[test]
fn a_recording_of_another_cell_is_refused() {
    let file = written("other-cell.mcap", whole());
    let told = |cell: Cell| match cell.program(|_| Ok(())).replay(&file, CutOff::Refused) {
        Err(error) => error.to_string(),
        Ok(compared) => panic!("{compared:?}"),
    };
    let arm = || SimulatedIrp6::new(Irp6::nominal(), &START);
    let third = told(Cell::new(STEP).robot(RobotSetup::new("third", Irp6::nominal(), arm())));
    assert!(third.contains("has no robot `third`"), "{third}");
    let drive = ExactDrive::new(Q::zeros(), STEP);
    let gantry = told(Cell::new(STEP).robot(RobotSetup::new("left", Gantry::default(), drive)));
    assert!(gantry.contains("has robot `left` of the kind irp6 with 6 joints"), "{gantry}");
    let slower = told(Cell::new(2 * STEP).robot(RobotSetup::new("left", Irp6::nominal(), arm())));
    assert!(slower.contains("was recorded with a step of 2000000 ns, the cell's is 4000000"), "{slower}");
}

#[test]
fn a_recording_of_one_robot_says_that_the_other_one_is_missing() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("one.mcap");
    arms(Change::Nothing)
        .record(mrroc::recording::to(&file).robots(["left"]))
        .run()
        .expect("keeps the limits");
    let told = arms(Change::Nothing).replay(&file, CutOff::Refused).map_err(|error| error.to_string());
    assert!(told.as_ref().is_err_and(|told| told.contains("has no robot `right`")), "{told:?}");
}

#[test]
fn a_recording_asks_for_what_there_is() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("asks.mcap");
    let asked = mrroc::recording::to(&file).robots(["lefd"]).sensors(["counts"]);
    let told = arms(Change::Nothing).record(asked).run().expect_err("neither is there").to_string();
    assert!(told.contains("robot `lefd`") && told.contains("sensor `counts`"), "{told}");
    let nowhere = arms(Change::Nothing).record(mrroc::recording::to("no/such/folder/a.mcap")).run();
    let told = nowhere.expect_err("there is no such folder").to_string();
    assert!(told.contains("cannot be written") && told.contains("--record"), "{told}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// A byte that is another one is found out by a checksum, or is in a place that says nothing.
    #[test]
    fn a_damaged_file_is_refused_or_replays_the_same(at in 0.0..1.0_f64, flip in 1..=255_u8) {
        let mut bytes = whole().to_vec();
        let at = (at * bytes.len() as f64) as usize;
        bytes[at] ^= flip;
        let file = written("damaged.mcap", &bytes);
        if let Ok(compared) = arms(Change::Nothing).replay(file, CutOff::Refused) {
            prop_assert!(compared.is_identical(), "byte {} ^ {}: {:?}", at, flip, compared);
        }
    }

    /// Whatever follows a good beginning ends in a refusal.
    #[test]
    fn garbage_is_refused(
        from in 0..100_000_usize,
        garbage in proptest::collection::vec(any::<u8>(), 1..4096),
    ) {
        let mut bytes = whole()[..from].to_vec();
        bytes.extend(garbage);
        let refused = arms(Change::Nothing).replay(written("garbage.mcap", &bytes), CutOff::Refused);
        prop_assert!(refused.is_err());
    }
}

/// The recording with the messages of a topic changed.
fn with(topic: &str, change: impl Fn(&mut serde_json::Value)) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().profile("mrroc").chunk_size(Some(1 << 18));
    let mut writer = options.create(&mut bytes).expect("in memory");
    let mut channels = std::collections::BTreeMap::new();
    for record in mcap::read::ChunkFlattener::new(whole()).expect("a file") {
        match record.expect("whole") {
            mcap::records::Record::Metadata(metadata) => writer.write_metadata(&metadata).expect("in memory"),
            mcap::records::Record::Channel(channel) => {
                let id = writer.add_channel(0, &channel.topic, "json", &Default::default()).expect("few");
                channels.insert(channel.id, (id, channel.topic));
            }
            mcap::records::Record::Message { mut header, data } => {
                let (id, of) = &channels[&header.channel_id];
                let mut json = serde_json::from_slice(&data).expect("JSON");
                if of == topic {
                    change(&mut json);
                }
                header.channel_id = *id;
                writer.write_to_known_channel(&header, json.to_string().as_bytes()).expect("in memory");
            }
            _ => {}
        }
    }
    writer.finish().expect("in memory");
    drop(writer);
    bytes.into_inner()
}

#[test]
fn fault_249_a_recording_whose_steps_jump_is_refused_before_it_is_replayed() {
    let unchanged = written("unchanged.mcap", &with("", |_| {}));
    assert!(arms(Change::Nothing).replay(unchanged, CutOff::Refused).expect("replayed").is_identical());
    let later = |json: &mut serde_json::Value| {
        let step = json["step"].as_u64().expect("a step");
        if step >= 5 {
            json["step"] = (step + (1 << 40)).into();
        }
    };
    let found = |json: &mut serde_json::Value| {
        (json["what"], json["process"]) = ("late request".into(), "edp left".into());
        json["text"] = format!("request 0 in step {}", 1_u64 << 40).into();
    };
    let [steps, late] = [with("/steps", later), with("/events", found)];
    for bytes in [steps, late] {
        let refused = refusal("jumps.mcap", &bytes);
        assert!(refused.contains("that does not fit"), "{refused}");
        let taken = arms(Change::Nothing).replay(written("jumps.mcap", &bytes), CutOff::Taken);
        assert!(taken.is_err_and(|error| error.to_string().contains("that does not fit")));
    }
}

#[test]
fn fault_249_a_small_file_that_unpacks_to_much_is_refused() {
    // Chunks of nothing but the same byte: 250 times smaller.
    let mut bytes = Vec::new();
    let mut writer = mcap::WriteOptions::new()
        .profile("mrroc")
        .compression(Some(mcap::Compression::Lz4))
        .chunk_size(Some(1 << 19))
        .create(std::io::Cursor::new(&mut bytes))
        .expect("in memory");
    for record in mcap::read::ChunkFlattener::new(whole()).expect("a file") {
        if let mcap::records::Record::Metadata(metadata) = record.expect("whole") {
            writer.write_metadata(&metadata).expect("in memory");
        }
    }
    let channel = writer.add_channel(0, "/steps", "json", &Default::default()).expect("few");
    for sequence in 0..1000 {
        let header =
            mcap::records::MessageHeader { channel_id: channel, sequence, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, &vec![b' '; 1 << 18]).expect("in memory");
    }
    writer.finish().expect("in memory");
    drop(writer);
    assert!(bytes.len() < 3_000_000, "{}", bytes.len());
    let file = written("unpacks.mcap", &bytes);
    let mut taken = 0;
    let layout = arms(Change::Nothing).layout();
    let read = mrroc::recording::each_message_of(&file, &layout, |message| taken += message.json.len());
    assert!(read.is_err_and(|error| error.to_string().contains("unpacks to far more than it should")));
    // What was read until then is bounded by the file.
    assert!(taken <= 50 * bytes.len() + (1 << 20), "{taken}");
}
