//! Known layout: one image, the path that it shows, and faults on it.
//!
//! A few mazes; `just maze-whole` takes thirty more by chance.

use maze::camera::eye::{floor, truly};
use maze::camera::mp::CLEARANCE;
use maze::camera::run::Ready;
use maze::camera::scene::Overlooked;
use maze::camera::summary::Summary;
use maze::mazes::Seeded;
use maze::places::{HEIGHT, HIGH, MIDDLE, Sizes, said, tool};
use maze::plant::Plant;
use maze::run::told;
use mrroc::pose::Pose;
use mrroc::robot::Robot as _;
use mrroc_map::Inflated;
use mrroc_robots::{Irp6, Six};
use mrroc_sensors::aggregation::{Bars, BarsKnown, NoBars};
use mrroc_sensors::physics::{Dark, Imager};
use nalgebra::{Vector2, Vector3};

use crate::usage::{islands, with_shipped};

/// `start` of `cell.toml`.
pub const START: [f64; 6] = [-0.394791, -2.046687, 0.407842, 0.068049, 4.712389, 1.176005];

/// The shipped mazes and so many by chance.
fn shortest_paths_are_gone(count: u64) {
    for Seeded { name, layout, seed } in with_shipped(count) {
        let outcome = Ready::new(&layout, seed).expect("a cell").run();
        assert!(outcome.report.is_ok(), "{name}: {:?}", outcome.report);
        // No contact in the physics, at places and between them.
        assert!(outcome.travel == 0.0 && outcome.clearance > 0.0, "{name}: {} m", outcome.clearance);
        // Each true wall was seen once, its corners to 0.15 mm in the maze's frame, and to 0.05 mm rms.
        let bars = outcome.taken.bars.as_ref().expect("seen");
        assert_eq!(bars.boxes.len(), outcome.walls.boxes().len(), "{name}");
        let mut squares = 0.0;
        for wall in outcome.walls.boxes() {
            // Of both corners, along both axes.
            let off = |[lower, upper]: &[Vector2<f64>; 2]| {
                let (lower, upper) = (lower - wall.lower, upper - wall.upper);
                [lower.x, lower.y, upper.x, upper.y]
            };
            let worst = |off: &[f64; 4]| off.iter().fold(0.0, |worst: f64, by| worst.max(by.abs()));
            let offs = bars.boxes.iter().map(off);
            let nearest = offs.min_by(|a, b| worst(a).total_cmp(&worst(b))).expect("a wall");
            assert!(worst(&nearest) < 1.5e-4, "{name}: {wall:?} is off by {nearest:?} m");
            squares += nearest.iter().map(|by| by * by).sum::<f64>() / 4.0;
        }
        let rms = (squares / bars.boxes.len() as f64).sqrt();
        assert!(rms < 5e-5, "{name}: walls are off by {rms} m rms");
        // The path that was planned is no shorter than for the ball alone, and no longer than for one that is larger by the clearance, what
        // walls are off by, and what arcs are less than polygons around them.
        let planned = outcome.planned.path.as_ref().expect("planned").length();
        let sizes = Sizes::within_reach(&layout);
        let told = told(&layout, &sizes);
        let larger = (sizes.radius + CLEARANCE + 1.5e-4) * 1.0824;
        let (most, _) =
            Inflated::by(&outcome.walls, larger).shortest(&told.start, &told.goal).expect("a path");
        assert!(outcome.shortest < planned && planned < most, "{} {planned} {most}", outcome.shortest);
        // The ball goes along that path, and at its ends less than a millimetre more.
        assert!((outcome.distance - planned).abs() < 1e-3, "{name}: {} {planned}", outcome.distance);
    }
}

#[test]
fn the_shortest_path_of_an_image_is_gone_without_a_contact() {
    shortest_paths_are_gone(1);
}

mod whole {
    #[test]
    #[ignore = "takes minutes: `just maze-whole`"]
    fn the_shortest_path_of_an_image_is_gone_without_a_contact() {
        super::shortest_paths_are_gone(30);
    }
}

#[test]
fn a_sweep_says_how_long_paths_are_and_what_failed() {
    let closed = "o---o---o\n|   | G |\no   o---o\n| S     |\no---o---o";
    let closed = Seeded::read("closed", closed, 1).expect("a maze");
    let [islands, _] = Seeded::shipped(0).expect("mazes");
    let summary = Summary::sweep(&[islands, closed]);
    let text = summary.to_string();
    assert_eq!(summary.faults(), 1, "{text}");
    assert!(text.contains("closed: ") && text.contains("no path to the exit"), "{text}");
    assert!(text.contains("1 of 2 mazes") && text.contains("contacts in 0"), "{text}");
}

#[test]
fn fault_188_a_camera_that_sees_no_maze_is_a_named_fault_before_the_arm_moves() {
    for dark in [Dark::Covered, Dark::LampOff] {
        let ready = Ready::seen_by(&islands(), 0, |camera| camera.darkened(dark)).expect("a cell");
        let outcome = ready.run();
        let fault = outcome.report.expect_err("blind").to_string();
        assert!(fault.contains("the camera over the maze") && fault.contains("dark"), "{fault}");
        assert!(outcome.trace.is_empty() && outcome.planned.path.is_none());
    }
}

/// What is seen of the islands with an arm that has these joint positions.
fn seen_with(joints: [f64; 6]) -> (Vec<u8>, Result<Bars, NoBars>) {
    let maze = islands();
    let sizes = Sizes::within_reach(&maze);
    let sides = sizes.sides(&maze);
    let plant = Plant::new(&maze, &sizes, 0);
    let world = plant.world();
    let world = world.borrow();
    let scene = Overlooked::new(&world.walls, &world.X_WM, &Six::from(joints));
    let mut image = Vec::new();
    Imager::over(truly().clone(), 0).expose(&scene, 0.0, &mut image);
    let known = BarsKnown { sides, thickness: sizes.thickness, height: HEIGHT, loose: 6.5e-3, cell: 4e-4 };
    let said: Pose = floor().inv_mul(&said(sides));
    let bars = Bars::find(truly(), &image, &said, &known);
    (image, bars)
}

#[test]
fn fault_188_an_arm_in_front_of_the_camera_hides_the_frame_and_at_its_start_it_is_out_of_view() {
    let (free, bars) = seen_with(START);
    assert!(bars.is_ok());
    // Turned away by a right angle nothing changes: it was not in view.
    let mut away = START;
    away[0] -= 1.5;
    assert!(free == seen_with(away).0);
    // Over the maze it hides a side.
    let flange = tool(MIDDLE[0], MIDDLE[1], HIGH) * Pose::translation(0.0, 0.0, -0.25);
    let over = Irp6::nominal().inverse(&flange, &Six::from(START)).expect("within reach");
    let (hidden, bars) = seen_with(over.into());
    assert!(free != hidden);
    assert!(matches!(bars, Err(NoBars::NoFrame { .. })), "{bars:?}");
}

#[test]
fn fault_189_a_contact_on_the_path_that_an_image_shows_stops_the_arm_and_is_named() {
    // By more than the clearance: the camera was moved after its calibration.
    for by in [Vector3::new(2e-3, 1e-3, 0.0), Vector3::new(-1e-3, 2.5e-3, 0.0)] {
        let ready = Ready::seen_by(&islands(), 0, |camera| camera.moved(by)).expect("a cell");
        let outcome = ready.run();
        let fault = outcome.report.expect_err("a contact").to_string();
        assert!(fault.contains("touches a wall") && fault.contains("arm"), "{fault}");
        assert!(outcome.travel > 0.0 && outcome.travel < 4e-3, "{} m", outcome.travel);
    }
}
