//! The cell whose recordings are read: one robot, one sensor, a motion of a few steps.

use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, Q};

struct Depth;

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
struct Below {
    metres: f64,
    is_sure: bool,
}

impl Sensor for Depth {
    const KIND: &'static str = "depth";
    type Reading = Below;
    type Configuration = ();
}

struct Sounding;

impl VirtualSensor for Sounding {
    type Kind = Depth;
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Below, Fault> {
        Ok(Below { metres: 0.1 * order.step as f64, is_sure: order.step > 3 })
    }
}

struct Hop {
    left: u32,
}

#[generator(ecp)]
fn hop(c: &mut Hop, v: &Reading<(Depth,)>, t: Tick) -> Step<Gantry> {
    c.left = match c.left.checked_sub(1) {
        Some(left) => left,
        None => return Step::Done,
    };
    let depth = v.0.reading().map_or(0.0, |below| below.metres);
    Step::Next(Demand::joints(Q::<3>::new(1e-6 * f64::from(8 - c.left), 1e-9 * depth, 1e-3 * t.dt)))
}

/// The cell.
pub fn cell() -> Cell {
    let gantry = RobotSetup::new("g", Gantry::default(), ExactDrive::new(Q::<3>::zeros(), MS));
    let gantry = gantry.program(|ecp| {
        let mut depth = ecp.sensor::<Depth>("depth")?;
        ecp.move_robot((&mut depth,), Hop { left: 8 }).map(drop)
    });
    Cell::new(MS).robot(gantry).sensor(SensorSetup::new("depth", Sounding).of("g"))
}

/// Recordings in a folder: a complete one of this cell, and one that was cut off.
fn are_whole_and_cut(folder: &std::path::Path) {
    let read = |name: &str| {
        let bytes = std::fs::read(folder.join(name)).expect("in the corpus");
        mrroc::recording::read_bytes(&cell(), &bytes)
    };
    assert_eq!(read("whole.mcap"), Ok(()));
    assert!(read("cut.mcap").is_err());
}

/// The folder of the corpus.
fn corpus() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("parsers/corpus/recording")
}

#[test]
fn the_corpus_of_recordings_has_one_of_this_cell() {
    are_whole_and_cut(&corpus());
}

#[test]
#[ignore = "overwrites files of the corpus: `just corpus`"]
fn recordings_of_this_cell_are_made_anew() {
    let folder = corpus();
    std::fs::create_dir_all(&folder).expect("a folder");
    cell().record(mrroc::recording::to(folder.join("whole.mcap"))).run().expect("runs");
    let whole = std::fs::read(folder.join("whole.mcap")).expect("recorded");
    std::fs::write(folder.join("cut.mcap"), &whole[..whole.len() * 2 / 3]).expect("written");
    are_whole_and_cut(&folder);
}
