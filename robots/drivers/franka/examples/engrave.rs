//! Engraves the nameplate of the engraving task with an FR3: `cargo run --release -p mrroc-examples --example engrave -- --cell
//! robots/drivers/franka/examples/cell.toml --simulated`, and with `--processes` in its place where a robot is at the address
//! of that file. The arm goes to a posture with a bent shoulder first; the plate lies 50 mm below where the tool is then.
//!
//! `--strokes` behind a `--` says how many strokes of it, all by default: its last ones, since the first is the frame, which takes a minute.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::time::Duration;

use engraving::drawing::{Limits, read_str};
use engraving::placement::{Plate, Sizing, place};
use engraving::sampling::{Mark, Sampling};
use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_franka::{FciSettings, Fr3, with_franka_as};
use mrroc_generators::bspline::{Junction, Method, SplinePoint, SplineSettings};
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::generators::{JointMove, SplineTrack, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Seven, simulated};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// A posture with the tool straight down, away from the shoulder's singularity at 0 of joint 2 \[rad\].
const READY: [f64; 7] = [0.0, -FRAC_PI_4, 0.0, -3.0 * FRAC_PI_4, 0.0, FRAC_PI_2, FRAC_PI_4];

/// Height above the plate at which the tool travels \[m\], and depth of the strokes \[mm\].
const TRAVEL: f64 = 0.002;
const DEPTH: f64 = 0.3;

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let step = file.step().as_secs_f64();
    // A simulator may be late for longer than a robot, whose settings are those of `with_franka`.
    let settings = |robot| FciSettings { silence: Duration::from_millis(100), ..FciSettings::new(robot) };
    Ok(file.cell(&with_franka_as(simulated(), settings))?.program(move |mp| engrave(mp, step)))
}

fn straight(velocity: f64) -> ToolLimits {
    ToolLimits {
        translation: ProfileLimits { velocity, acceleration: 0.2 },
        rotation: ProfileLimits { velocity: 0.5, acceleration: 1.0 },
    }
}

fn engrave(mp: &mut Mp, step: f64) -> Result<(), Fault> {
    let strokes = own_number("strokes", usize::MAX)?;
    let thrown = |why: &dyn std::fmt::Display| Fault::thrown(&why.to_string());
    let plate = Plate::default();
    let read =
        read_str("nameplate.svg", engraving::NAMEPLATE, Limits::default()).map_err(|why| thrown(&why))?;
    let placed = place(&read.drawing, &plate, Sizing::Fill).map_err(|why| thrown(&why))?;
    let drawing = placed.drawing.sunk(DEPTH);

    let mut arm = mp.robot::<Fr3>("arm")?;
    mp.move_robot(&mut arm, (), JointMove::to(Seven::from(READY), Seven::repeat(0.15), Seven::repeat(0.3)))?;
    let here = arm.demanded().pose;
    // Seen from the arm, the plate's x runs to the right and its y away.
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -FRAC_PI_2);
    let middle = here.translation.vector - Vector3::z() * 0.05;
    let corner = middle - turn * Vector3::new(plate.width * 0.5e-3, plate.height * 0.5e-3, 0.0);
    let surface = Pose::from_parts(Translation3::from(corner), turn);
    let orientation = turn.inverse() * here.rotation;
    let over = |x: f64, y: f64, height: f64| {
        surface * Pose::from_parts(Translation3::new(x * 1e-3, y * 1e-3, height), orientation)
    };

    let spline = SplineSettings { method: Method::C2, corner: PI, ..SplineSettings::default() };
    let feed =
        FeedLimits { feed: 0.01, tangential: 0.2, normal: 0.2, step, chord_error: 1e-6, jerk: f64::INFINITY };
    let sampling = Sampling::default();
    let left_out = drawing.strokes.len().saturating_sub(strokes);
    for (index, stroke) in drawing.strokes.iter().enumerate().skip(left_out) {
        let (start, end) = (stroke.start(), stroke.end());
        let down = over(start.x, start.y, stroke.tip(0.0).z * 1e-3);
        mp.move_robot(&mut arm, (), StraightLine::to(over(start.x, start.y, TRAVEL), straight(0.05)))?;
        mp.move_robot(&mut arm, (), StraightLine::to(down, straight(0.005)))?;
        let points = sampling.stroke(stroke, index);
        let points: Vec<_> = points
            .iter()
            .map(|sample| SplinePoint {
                position: sample.position * 1e-3,
                junction: if sample.mark == Mark::Corner { Junction::Corner } else { Junction::Smooth },
                ..SplinePoint::default()
            })
            .collect();
        let track = SplineTrack::through(points, spline, feed, surface, orientation);
        mp.move_robot(&mut arm, (), track.map_err(|why| thrown(&why))?)?;
        mp.move_robot(&mut arm, (), StraightLine::to(over(end.x, end.y, TRAVEL), straight(0.02)))?;
    }
    mp.move_robot(&mut arm, (), StraightLine::to(here, straight(0.05)))?;
    Ok(())
}
