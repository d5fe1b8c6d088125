//! Frames of sensors: what is in their files is what was handed over, on both links, and no step waits or allocates for them.

use std::cell::Cell as Counts;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc_counting_allocator::allocations;
use mrroc_robots::{Irp6, SimulatedIrp6};
use serde_json::Value;

use crate::recording::camera::{Camera, SIZE, colour, depth, look, sample};
use crate::recording::cell::{START, STEP};
use crate::recording::command::{folder, run, said};

const CAMERA: &str = "[sensors.camera]\n";

/// The pixels of a PNG file, with their depth in bits and the number of channels.
fn decoded(png: impl std::io::BufRead + std::io::Seek) -> (Vec<u8>, u8, usize) {
    let mut reader = png::Decoder::new(png).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("it fits")];
    let info = reader.next_frame(&mut pixels).expect("a frame");
    assert_eq!((info.width, info.height), SIZE);
    (pixels, info.bit_depth as u8, info.color_type.samples())
}

fn is_that_of(step: u64, (pixels, bits, channels): &(Vec<u8>, u8, usize)) {
    if step.is_multiple_of(2) {
        let expected: Vec<u8> = (0..pixels.len()).map(|i| colour(step, i)).collect();
        assert_eq!((*bits, *channels), (8, 3));
        assert!(*pixels == expected, "step {step}");
    } else {
        let expected: Vec<u8> = (0..pixels.len() / 2).flat_map(|i| depth(step, i).to_be_bytes()).collect();
        assert_eq!((*bits, *channels), (16, 1));
        assert!(*pixels == expected, "step {step}");
    }
}

/// Every PNG file of a folder; how many there are.
fn check_images(folder: &Path) -> usize {
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let step = path.file_stem().and_then(|name| name.to_str()?.parse().ok()).expect("a step");
        is_that_of(step, &decoded(BufReader::new(File::open(&path).expect("a file"))));
        count += 1;
    }
    count
}

/// Base64, as the standard has it: another reader than the writer.
fn from_base64(text: &str) -> Vec<u8> {
    let digit = |c: char| match c {
        'A'..='Z' => c as u32 - 'A' as u32,
        'a'..='z' => c as u32 - 'a' as u32 + 26,
        '0'..='9' => c as u32 - '0' as u32 + 52,
        '+' => 62,
        '/' => 63,
        _ => panic!("{c}"),
    };
    let (mut bytes, mut word, mut bits) = (Vec::new(), 0, 0);
    for c in text.trim_end_matches('=').chars() {
        (word, bits) = (word << 6 | digit(c), bits + 6);
        if bits >= 8 {
            bits -= 8;
            bytes.push((word >> bits) as u8);
            word &= (1 << bits) - 1;
        }
    }
    bytes
}

/// Every message of a file of frames, at the time of its step; how many images and echoes there are.
fn check_messages(file: &Path) -> (usize, usize) {
    let bytes = fs::read(file).expect("a file");
    let (mut images, mut echoes) = (0, 0);
    let messages =
        || mcap::MessageStream::new(&bytes).expect("an MCAP file").map(|message| message.expect("whole"));
    // The date of the cell's time 0, by the first echo, which names its step.
    let start = messages().find_map(|message| {
        let json: Value = serde_json::from_slice(&message.data).expect("JSON");
        Some(message.log_time - json["step"].as_u64()? * STEP.as_nanos() as u64)
    });
    let start = start.expect("an echo");
    assert!(start > 1_700_000_000_000_000_000, "a date after 2023: {start} ns");
    for message in messages() {
        let schema = message.channel.schema.as_ref().map(|schema| schema.name.clone()).unwrap_or_default();
        let json: Value = serde_json::from_slice(&message.data).expect("JSON");
        let step = (message.log_time - start) / STEP.as_nanos() as u64;
        if message.channel.topic == "/sensors/camera/image" {
            assert_eq!((schema.as_str(), &json["format"]), ("foxglove.CompressedImage", &Value::from("png")));
            let time = json["timestamp"]["sec"].as_u64().expect("s") * 1_000_000_000;
            assert_eq!(time + json["timestamp"]["nsec"].as_u64().expect("ns"), message.log_time);
            let png = from_base64(json["data"].as_str().expect("a text"));
            is_that_of(step, &decoded(std::io::Cursor::new(png)));
            images += 1;
        } else {
            assert_eq!(
                (schema.as_str(), message.channel.topic.as_str()),
                ("mrroc.Echo", "/sensors/camera/echo")
            );
            assert_eq!((json["step"].as_u64(), json["interval"].as_f64()), (Some(step), Some(1e-6)));
            let samples = json["samples"].as_array().expect("samples");
            let expected: Vec<Value> = (0..5).map(|i| Value::from(f64::from(sample(step, i)))).collect();
            assert_eq!(*samples, expected);
            echoes += 1;
        }
    }
    let summary = mcap::Summary::read(&bytes).expect("a summary").expect("a summary");
    assert!(summary.metadata_indexes.iter().any(|metadata| metadata.name == "mrroc.end"));
    (images, echoes)
}

/// On the memory link and in lock-step the sensor waits for its writer: nothing is missing.
#[test]
fn both_links_have_every_frame_in_the_recording_and_in_png_files() {
    for (name, arguments) in [("frames-memory", &[][..]), ("frames-lock-step", &["--processes", "--virtual"])]
    {
        let folder = folder(name, CAMERA);
        let both = ["--record", "run.mcap", "--frames", "images"];
        let told = said(&run(&folder, &[arguments, &both].concat()), 0);
        assert!(!told.contains("warning"), "{told}");
        assert_eq!(check_images(&folder.join("images/camera")), 30, "{name}");
        assert_eq!(check_messages(&folder.join("run.camera.mcap")), (30, 30), "{name}");
        // The recording itself is what it was, and a replay draws nothing.
        let replayed = said(&run(&folder, &["replay", "run.mcap"]), 0);
        assert!(replayed.ends_with(" steps: identical\n"), "{replayed}");
        // The images are not overwritten.
        let again = said(&run(&folder, &[arguments, &both].concat()), 2);
        assert!(
            again.contains("images: has files already\n help: give an empty folder by --frames"),
            "{again}"
        );
    }
}

/// In real time frames are dropped, and told, before a step waits; what is there is whole.
#[test]
fn in_real_time_frames_are_whole_or_counted() {
    let folder = folder("frames-real", CAMERA);
    let words = ["--processes", "--record", "run.mcap", "--frames", "images", "--outcome", "outcome.json"];
    let output = run(&folder, &words);
    let told = said(&output, output.status.code().unwrap_or(-1));
    let outcome = fs::read(folder.join("outcome.json")).expect("the launcher has written it");
    let outcome: Value = serde_json::from_slice(&outcome).expect("JSON");
    // A machine that is late stops the cell before it has taken all frames.
    let is_whole = output.status.success();
    assert!(is_whole || matches!(outcome["fault"]["kind"].as_str(), Some("PeerLost" | "Overrun")), "{told}");
    if !is_whole && !folder.join("images/camera").is_dir() {
        return println!("stopped before the first frame: {told}");
    }
    let (images, echoes) = check_messages(&folder.join("run.camera.mcap"));
    assert_eq!(check_images(&folder.join("images/camera")), images);
    let dropped =
        told.split("warning: ").find_map(|told| told.split_once(" frames of sensor `camera` were dropped"));
    let dropped: usize = dropped.map_or(0, |(count, _)| count.parse().expect("a number"));
    println!("{images} images, {echoes} echoes, {dropped} dropped");
    assert!(!is_whole || images + echoes + dropped >= 60, "{images} {echoes} {dropped}: {told}");
}

#[test]
fn a_folder_that_cannot_be_written_is_told_and_the_run_goes_on() {
    let folder = folder("frames-refused", CAMERA);
    fs::write(folder.join("file"), "").expect("a file");
    let told = said(&run(&folder, &["--frames", "file"]), 2);
    assert!(told.contains("file: cannot be written") && told.contains("--frames"), "{told}");
    // The file of the frames is there, and is no recording.
    fs::write(folder.join("run.camera.mcap"), "a letter").expect("a file");
    let told = said(&run(&folder, &["--record", "run.mcap"]), 0);
    assert!(told.contains("frames of sensor `camera` were not written: run.camera.mcap"), "{told}");
    assert!(told.contains("frames of sensor `camera` were dropped"), "{told}");
    assert_eq!(fs::read_to_string(folder.join("run.camera.mcap")).expect("a file"), "a letter");
}

/// The copy into a slot allocates nothing, and the rest is another thread's.
#[test]
fn a_step_that_hands_over_frames_allocates_nothing() {
    let counts = Rc::new(Counts::new((0, 0)));
    let seen = Rc::clone(&counts);
    let robot = RobotSetup::new("arm", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &START));
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("frames-allocation.mcap");
    let cell = Cell::new(STEP)
        .robot(robot)
        .sensor(SensorSetup::new("camera", Camera::new(80)))
        .on_step(move |step, _| match step {
            10 => seen.set((allocations(), 0)),
            25 => seen.set((seen.get().0, allocations())),
            _ => {}
        })
        .program(look);
    cell.record(mrroc::recording::to(&file)).run().expect("it looks");
    let (warm, end) = counts.get();
    assert!(warm > 0, "nothing was counted");
    assert_eq!(end - warm, 0, "allocations in 15 steps");
    assert_eq!(check_messages(&file.with_extension("camera.mcap")), (30, 30));
}
