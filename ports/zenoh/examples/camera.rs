//! A cell whose camera is a program in Python on another machine: `cargo run -p mrroc-zenoh --example camera -- --cell
//! FOLDER/cell.toml --processes`, where `[sensors.camera.external]` has an `address`; `.. certificates FOLDER/keys` makes the certificates and
//! `.. external camera` prints the module for the program. An arm turns its column to where the camera sees a part.
//!
//! With `--trace FOLDER` behind a `--` the MP writes there, in every step of its Move, when it was by the wall clock [ns], how old the reading was
//! [steps], and the bits of its direction, and the plant what was demanded of the arm: the time [s] and the first joint, as two
//! numbers of 8 bytes.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{SystemTime, UNIX_EPOCH};

use mrroc::launch::{own_number, own_option};
use mrroc::prelude::*;
use mrroc_external::External;
use mrroc_robots::{Irp6, Six, simulated};

/// Where the part is.
#[derive(Clone, Copy, Debug, Payload)]
struct Part {
    /// Direction from the arm's column \[rad\].
    direction: f64,
    /// Whether it is in the image.
    seen: bool,
}

/// A camera that looks for a part.
struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Part;
    type Configuration = ();
}

fn main() -> ExitCode {
    mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh);
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let camera = External::<Camera>::in_cell(file, "camera")?;
    let cell = file.cell(&simulated())?.sensor(camera).program(watch);
    let mut demands = trace("demands");
    Ok(cell.watch(move |seen| {
        let numbers = [seen.time, seen.demanded.first().copied().unwrap_or_default()];
        write(&mut demands, &numbers.map(f64::to_le_bytes).concat());
    }))
}

/// A file of the trace, if there is one: it is made when something is written.
fn trace(name: &str) -> (Option<PathBuf>, Option<File>) {
    (own_option("trace").map(|folder| PathBuf::from(folder).join(name)), None)
}

/// A disk that is full ends the trace and nothing else.
fn write((path, file): &mut (Option<PathBuf>, Option<File>), bytes: &[u8]) {
    let Some(path) = path else { return };
    if file.is_none() {
        *file = File::create(path).ok();
    }
    if let Some(file) = file {
        let _ = file.write_all(bytes);
    }
}

fn watch(mp: &mut Mp) -> Result<(), Fault> {
    let seconds = own_number("seconds", 3.0)?;
    let (mut arm, mut camera) = (mp.robot::<Irp6>("arm")?, mp.sensor::<Camera>("camera")?);
    mp.wait_until((), (&mut camera,), Seen)?;
    let from = arm.demanded().joints;
    let follow = Follow { q: from, velocity: 0.0, left: seconds, trace: trace("readings") };
    mp.move_robots((&mut arm,), (&mut camera,), follow)?;
    Ok(())
}

/// The part is in the image.
struct Seen;

#[condition(mp)]
fn seen(_: &mut Seen, camera: &Reading<(Camera,)>) -> bool {
    camera.0.reading().is_some_and(|part| part.seen)
}

/// Turns the column to the part, at most 0.5 rad/s and 1 rad/s².
struct Follow {
    q: Six,
    velocity: f64,
    /// Time that is left \[s\].
    left: f64,
    trace: (Option<PathBuf>, Option<File>),
}

#[generator(mp)]
fn follow(c: &mut Follow, camera: &Reading<(Camera,)>, t: Tick) -> Result<Step<(Irp6,)>, Fault> {
    if c.left <= 0.0 {
        return Ok(Step::Done);
    }
    c.left -= t.dt;
    let part = camera.0.reading().ok_or_else(|| Fault::thrown("no part was ever seen"))?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64);
    let row = [now, camera.0.age().into(), part.direction.to_bits()];
    write(&mut c.trace, &row.map(u64::to_le_bytes).concat());
    // Critically damped, with a natural frequency of 4 rad/s.
    let acceleration = (16.0 * (part.direction - c.q[0]) - 8.0 * c.velocity).clamp(-1.0, 1.0);
    c.velocity = (c.velocity + acceleration * t.dt).clamp(-0.5, 0.5);
    c.q[0] += c.velocity * t.dt;
    Ok(Step::Next((Demand::joints(c.q),)))
}
