//! The README's program, and those of the book's page about programs, compile, run and are what is shown.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Duration;

use crate::tutorial::support::{ONE, TWO, extent, file, watched};
use mrroc::cell::RunReport;
use mrroc::prelude::*;
use mrroc_robots::{Irp6, SimulatedIrp6};
use nalgebra::Translation3;

// ANCHOR: program
/// Both tools rise by 0.1 m and come down again, in four seconds.
struct Lift {
    t: f64, // path time since the start [s]
}

#[generator(mp)] // a motion is a step function: what it returns is demanded of the robots
fn lift(c: &mut Lift, t: Tick) -> Step<(Irp6, Irp6)> {
    c.t += t.dt;
    let height = 0.05 - 0.05 * (TAU * c.t / 4.0).cos();
    let up = Pose::translation(0.0, 0.0, -height); // the z axes of the tools point down
    let demands = (Demand::displacement(up), Demand::displacement(up)); // one per robot: none can be forgotten
    if c.t < 4.0 { Step::Next(demands) } else { Step::Done }
}

#[condition(mp)] // a condition says what a Wait waits for
fn held(v: &Reading<(WristForce,)>) -> bool {
    v.0.reading().is_some_and(|force| force.newtons > 10.0)
}

fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let mut force = mp.sensor::<WristForce>("force")?;
    mp.wait_until((&mut left, &mut right), (&mut force,), held {})?; // Wait
    mp.move_robots((&mut left, &mut right), (), Lift { t: 0.0 })?; // Move
    Ok(())
}
// ANCHOR_END: program

// ANCHOR: block
/// The tool of one robot rises by 0.1 m and comes down again, wherever its z axis points.
struct Rise {
    from: Pose,
    t: f64,
}

#[generator(ecp)]
impl Rise {
    fn first_step(&mut self, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
        self.from = e.demanded().pose;
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Step<Irp6> {
        self.t += t.dt;
        let up = Translation3::new(0.0, 0.0, 0.05 - 0.05 * (TAU * self.t / 4.0).cos());
        if self.t < 4.0 { Step::Next(Demand::pose(up * self.from)) } else { Step::Done }
    }
}
// ANCHOR_END: block

// ANCHOR: file
fn run_file(path: &Path) -> Result<RunReport, Box<dyn Error>> {
    let file = CellFile::read(path)?; // names, kinds, places, the step
    let cell = file.cell(&mrroc_robots::simulated())?; // its robots, here simulated
    let cell = cell.sensor(file.sensor("force", Pull(0.0))?); // `Pull`, a virtual sensor, computes its readings
    Ok(cell.program(coordinate).run()?) // the program of the MP
}
// ANCHOR_END: file

// ANCHOR: by_hand
fn run_by_hand() -> Result<RunReport, CellError> {
    let start = Irp6::READY;
    let arm = |name| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start));
    Cell::new(Duration::from_millis(2))
        .robot(arm("left"))
        .robot(arm("right"))
        .sensor(SensorSetup::new("force", Pull(0.0)))
        .program(coordinate)
        .run()
}
// ANCHOR_END: by_hand

struct WristForce;

impl Sensor for WristForce {
    const KIND: &'static str = "wrist force";
    type Reading = Force;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Force {
    newtons: f64,
}

/// Pulls ever harder, by 0.1 N a step.
struct Pull(f64);

impl VirtualSensor for Pull {
    type Kind = WristForce;
    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Force, Fault> {
        self.0 += 0.1;
        Ok(Force { newtons: self.0 })
    }
}

/// The two robots of the README and their sensor.
fn cell_file() -> String {
    format!("{TWO}[sensors.force]\n")
}

/// 100 steps to 10 N, and 4 s of motion in steps of 2 ms.
fn assert_takes_its_time(report: RunReport) {
    assert!((2100..=2110).contains(&report.steps), "{}", report.steps);
}

#[test]
fn the_program_of_the_readme_runs() {
    let file = file(&cell_file());
    let cell = file.cell(&mrroc_robots::simulated()).expect("known kinds");
    let cell = cell.sensor(file.sensor("force", Pull(0.0)).expect("it is in the file"));
    let (cell, paths) = watched(cell.program(coordinate));
    assert_takes_its_time(cell.run().expect("nothing is wrong"));
    for robot in ["left", "right"] {
        let (low, high) = extent(&paths, robot, 2);
        assert!(low > -1e-3 && (high - 0.1).abs() < 1e-3, "{robot}: {low} {high}");
        let height = |(name, at): &(String, [f64; 3])| (name == robot).then_some(at[2]);
        let heights: Vec<_> = paths.borrow().iter().filter_map(height).collect();
        let (first, last) = (heights.first().expect("seen"), heights.last().expect("seen"));
        assert!((last - first).abs() < 1e-3, "{robot}: from {first} to {last}");
    }
}

#[test]
fn an_impl_block_moves_a_robot_of_its_own() {
    let cell = file(ONE).cell(&mrroc_robots::simulated()).expect("a known kind");
    let (cell, paths) = watched(cell.ecp("arm", |ecp: &mut mrroc::program::Ecp<Irp6>| {
        ecp.move_robot((), Rise { from: Pose::identity(), t: 0.0 }).map(drop)
    }));
    cell.run().expect("nothing is wrong");
    let (low, high) = extent(&paths, "arm", 2);
    assert!(low > -1e-3 && (high - 0.1).abs() < 1e-3, "{low} {high}");
}

#[test]
fn a_cell_from_its_file_and_one_by_hand_run_alike() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme-cell.toml");
    std::fs::write(&path, cell_file()).expect("written");
    let from_file = run_file(&path).expect("nothing is wrong");
    assert_takes_its_time(from_file);
    assert_eq!(from_file, run_by_hand().expect("nothing is wrong"));
}

#[test]
fn the_readme_shows_this_program() {
    let readme = include_str!("../../README.md");
    let shown: Vec<_> =
        readme.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    let here = include_str!("mod.rs");
    let begin = here.find("// ANCHOR: program\n").expect("marked") + "// ANCHOR: program\n".len();
    let end = here.find("// ANCHOR_END: program").expect("marked");
    assert_eq!(shown, [&here[begin..end]], "it shows this program and no other Rust");
}
