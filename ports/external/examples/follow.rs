//! An arm turns its column to where a camera sees a part, which a program in Python says: `cargo run -p mrroc-examples
//! --example follow -- --cell ports/external/examples/cell.toml` with a simulated camera, and with `--processes` where the
//! program runs. `external camera` prints the module for that program, `external follow` that for a program that subscribes.
//!
//! `--seconds` behind a `--` says for how long, three by default.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_external::{External, Subscribers};
use mrroc_robots::{Irp6, Six, simulated};

// ANCHOR: kind
/// Where the part is.
#[derive(Clone, Copy, Debug, Payload)]
struct Part {
    /// Direction from the arm's column \[rad\].
    direction: f64,
    /// Whether it is in the image.
    seen: bool,
}

/// A camera that looks for one of several parts.
struct Camera;

#[derive(Clone, Copy, Debug, Default, Payload)]
struct Which {
    number: u32,
}

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Part;
    type Configuration = Which;
}
// ANCHOR_END: kind

// ANCHOR: stand-in
/// In the camera's place where nothing real is looked at: a part that goes to and fro, once in four seconds.
struct Belt;

impl VirtualSensor for Belt {
    type Kind = Camera;

    fn aggregate(&mut self, order: &ReadingOrder<Which>) -> Result<Part, Fault> {
        let t = order.step as f64 * 0.002;
        Ok(Part { direction: 0.3 * (core::f64::consts::FRAC_PI_2 * t).sin(), seen: true })
    }
}
// ANCHOR_END: stand-in

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

// ANCHOR: cell
fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let camera = External::<Camera>::in_cell(file, "camera")?.stand_in(Belt);
    Ok(file.cell(&simulated())?.sensor(camera).program(watch).shown_to(Subscribers::at("follow")))
}
// ANCHOR_END: cell

fn watch(mp: &mut Mp) -> Result<(), Fault> {
    let seconds = own_number("seconds", 3.0)?;
    let (mut arm, mut camera) = (mp.robot::<Irp6>("arm")?, mp.sensor::<Camera>("camera")?);
    // Its program may still be starting.
    mp.wait_until((), (&mut camera,), Seen)?;
    let from = arm.demanded().joints;
    mp.move_robots((&mut arm,), (&mut camera,), Follow { q: from, velocity: 0.0, left: seconds })?;
    Ok(())
}

// ANCHOR: read
/// The part is in the image.
struct Seen;

#[condition(mp)]
fn seen(_: &mut Seen, camera: &Reading<(Camera,)>) -> bool {
    camera.0.reading().is_some_and(|part| part.seen)
}
// ANCHOR_END: read

/// Turns the column to the part, at most 0.5 rad/s and 1 rad/s².
struct Follow {
    q: Six,
    velocity: f64,
    /// Time that is left \[s\].
    left: f64,
}

#[generator(mp)]
fn follow(c: &mut Follow, camera: &Reading<(Camera,)>, t: Tick) -> Result<Step<(Irp6,)>, Fault> {
    if c.left <= 0.0 {
        return Ok(Step::Done);
    }
    c.left -= t.dt;
    let part = camera.0.reading().ok_or_else(|| Fault::thrown("no part was ever seen"))?;
    let away = part.direction - c.q[0];
    // Critically damped, with a natural frequency of 4 rad/s.
    let acceleration = (16.0 * away - 8.0 * c.velocity).clamp(-1.0, 1.0);
    c.velocity = (c.velocity + acceleration * t.dt).clamp(-0.5, 0.5);
    c.q[0] += c.velocity * t.dt;
    Ok(Step::Next((Demand::joints(c.q),)))
}
