//! The readers of external input: each target reads bytes and must refuse or accept them, whatever they are. The fuzz
//! targets in `tests/fuzz/` are the same functions.

use engraving::drawing::{Limits, read_bytes};
use mrroc::fault::Name;
use mrroc::payload::{BadWords, WORDS, Wire};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::sensor::EffectorState;
pub use mrroc::testing::readers;
use mrroc_generators::teach::Taught;
use mrroc_robots::{Irp6, Serial, simulated};

#[path = "recorded.rs"]
mod recorded;

/// A reader of bytes.
pub type Target = fn(&[u8]);

/// All readers, by the names of their corpora.
pub const TARGETS: &[(&str, Target)] = &[
    ("cell", cell),
    ("svg", svg),
    ("dxf", dxf),
    ("gcode", gcode),
    ("urdf", urdf),
    ("trj", trj),
    ("wire", wire),
    ("envelope", envelope),
    #[cfg(target_os = "linux")]
    ("operator", mrroc::processes::readers::operator),
    ("recording", recording),
    ("rsi", rsi),
    ("fci", fci),
    ("rtde", rtde),
    ("modbus", modbus),
];

/// Checks that the answer to bad input is not empty.
fn told<T, E: std::fmt::Display>(outcome: Result<T, E>) -> Option<T> {
    outcome.map_err(|error| assert!(!error.to_string().is_empty(), "an error without words")).ok()
}

/// `cell.toml`, and the cell that is made of it.
pub fn cell(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Some(file) = told(CellFile::parse("cell.toml", &text)) {
        told(file.cell(&simulated()));
    }
}

fn drawing(name: &str, bytes: &[u8]) {
    if let Some(import) = told(read_bytes(name, bytes.to_vec(), Limits::default())) {
        let points = import.drawing.strokes.iter().flat_map(|stroke| stroke.pieces());
        assert!(points.into_iter().all(|piece| piece.is_sane()), "an accepted drawing is finite");
    }
}

/// What the controller of a KUKA arm says.
pub fn rsi(bytes: &[u8]) {
    if let Some(said) = mrroc_kuka::FromController::read(bytes) {
        assert!(said.axes.iter().all(|axis| axis.is_finite()), "axes that are read are numbers");
    }
}

/// What a Franka says: its states, and its answers to requests.
pub fn fci(bytes: &[u8]) {
    if let Some(state) = mrroc_franka::State::read(bytes) {
        let numbers = [state.q, state.dq, state.q_d, state.dq_d, state.ddq_d];
        assert!(
            numbers.iter().flatten().all(|number| number.is_finite()),
            "a state that is read has numbers"
        );
    }
    if let Ok(Some((_, size))) = mrroc_franka::Answer::read(bytes) {
        assert!((13..=bytes.len()).contains(&size), "an answer that is read is there");
    }
}

/// What a controller of Universal Robots and its clients say to each other, and its script.
pub fn rtde(bytes: &[u8]) {
    use mrroc_ur::rtde::{Answer, Package, Request};
    let mut rest = bytes;
    while let Ok(Some((package, after))) = Package::first(rest) {
        assert!(after.len() < rest.len(), "a package has bytes");
        let _ = Request::read(&package);
        if let Some(Answer::Data { values, .. }) = Answer::read(&package)
            && let Some(state) = mrroc_ur::State::read(values)
        {
            assert!(state.actual_q.iter().all(|q| q.is_finite()), "joints that are read are numbers");
        }
        rest = after;
    }
    if let Some(message) = bytes.first_chunk().and_then(mrroc_ur::SetPoint::read) {
        assert_eq!(mrroc_ur::SetPoint::read(&message.bytes()), Some(message));
    }
    if let Some(calibration) = mrroc_ur::primary::calibration(bytes) {
        let text = calibration.text(mrroc_ur::UrModel::Ur5e);
        let read = told(mrroc_ur::Calibration::parse(&text)).expect("what is written is read");
        assert!(read.1.is_of_the_same_arm(&calibration), "{text}");
    }
    let _ = mrroc_ur::primary::message_length(bytes);
    told(mrroc_ur::Calibration::parse(&String::from_utf8_lossy(bytes)));
    if let Some(script) = mrroc_ur::Script::read(&String::from_utf8_lossy(bytes)) {
        assert!(script.deceleration > 0.0 && script.gain > 0.0);
    }
}

/// What answers the drivers of a gripper, and of a device with inputs and outputs.
pub fn modbus(bytes: &[u8]) {
    use mrroc_modbus::message::{Question, Table, UnitRequest};
    use mrroc_robotiq::registers::Status;

    for what in [
        UnitRequest::Read(Table::InputRegisters, 0x07d0, 3),
        UnitRequest::Write(0x03e8, [0x0900, 0x00ff, 0xffff]),
        UnitRequest::Read(Table::DiscreteInputs, 0, 13),
        UnitRequest::Switch(16, true),
    ] {
        let question = Question { transaction: 0xd605, unit: 9, what };
        let Some(answer) = told(question.answer(bytes)).flatten() else { continue };
        if let &[a, b, c] = answer.registers() {
            let status = Status::new([a, b, c]);
            assert!(status.is_active() || status.stop().is_some(), "one that is not active is stopped");
        }
        assert!(answer.registers().len() == 3 || answer.bits() < 1 << 13, "{answer:?}");
    }
}

/// A drawing in SVG.
pub fn svg(bytes: &[u8]) {
    drawing("a.svg", bytes);
}

/// A drawing in DXF.
pub fn dxf(bytes: &[u8]) {
    drawing("a.dxf", bytes);
}

/// A G-code program.
pub fn gcode(bytes: &[u8]) {
    drawing("a.ngc", bytes);
}

/// A robot in URDF: of three joints, or of four.
pub fn urdf(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    told(Serial::<3>::from_urdf(&text, "bed", "tool"));
    told(Serial::<4>::from_urdf(&text, "base", "tool"));
}

/// Taught poses in MRROC++'s format, and in this library's.
pub fn trj(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    for taught in [told(Taught::from_trj(&text)), told(text.parse::<Taught>())].into_iter().flatten() {
        // What is written is read again.
        assert!(taught.to_string().parse::<Taught>().is_ok_and(|again| again == taught));
    }
}

/// A recording of a cell of one robot.
pub fn recording(bytes: &[u8]) {
    told(mrroc::recording::read_bytes(&recorded::cell(), bytes));
}

/// Words of a message, head and body.
pub fn envelope(bytes: &[u8]) {
    readers::envelope(&words::<{ readers::ENVELOPE_WORDS }>(bytes));
}

fn words<const N: usize>(bytes: &[u8]) -> [u64; N] {
    let mut words = [0_u64; N];
    for (word, chunk) in words.iter_mut().zip(bytes.chunks(8)) {
        let mut whole = [0; 8];
        whole[..chunk.len()].copy_from_slice(chunk);
        *word = u64::from_le_bytes(whole);
    }
    words
}

/// Words of a message: a value that is read is written as the same words again, to the bit.
pub fn wire(bytes: &[u8]) {
    let words = words::<WORDS>(bytes);
    spells::<Demand<Irp6>>(&words);
    spells::<EffectorState>(&words);
    spells::<Pose>(&words);
    spells::<Wrench>(&words);
    spells::<Name>(&words);
    spells::<[bool; 4]>(&words);
    spells::<[u16; 3]>(&words);
    // Too few words give no value and cause no panic.
    for len in 0..WORDS {
        let _: Result<Demand<Irp6>, BadWords> = Wire::get(&words[..len]);
        let _: Result<EffectorState, BadWords> = Wire::get(&words[..len]);
        let _: Result<[f32; 3], BadWords> = Wire::get(&words[..len]);
    }
}

fn spells<T: Wire>(words: &[u64; WORDS]) {
    let Ok(value) = T::get(words) else { return };
    let (mut once, mut twice) = ([0; WORDS], [0; WORDS]);
    value.put(&mut once);
    let Ok(again) = T::get(&once) else { panic!("what was written is not read") };
    again.put(&mut twice);
    assert_eq!(once, twice);
}
