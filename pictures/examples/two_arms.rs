//! Two simulated IRp-6 arms face each other and wave; the picture shows what moved.
//!
//! `cargo run -p mrroc-examples --example two_arms` writes `picture.svg`.

use std::time::Duration;

use mrroc::cell::RunPicture;
use mrroc::prelude::*;
use mrroc_pictures::Film;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::{Translation3, Vector3};

/// Both turn their columns, in opposite directions, and nod.
struct Greet {
    from: [Six; 2],
    t: f64,
}

const DURATION: f64 = 4.0;

#[generator(mp, first = look)]
fn greet(c: &mut Greet, t: Tick) -> Step<(Irp6, Irp6)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let u = c.t / DURATION;
    // From rest to rest: 10 u³ - 15 u⁴ + 6 u⁵.
    let turn = u * u * u * (10.0 + u * (6.0 * u - 15.0));
    let nod = 0.5 * (1.0 - (std::f64::consts::TAU * u).cos());
    let [mut left, mut right] = c.from;
    left += Six::new(0.9 * turn, 0.15 * nod, -0.3 * nod, 0.1 * nod, 0.0, 0.0);
    right += Six::new(-0.6 * turn, 0.25 * nod, -0.1 * nod, -0.2 * nod, 0.0, 0.5 * turn);
    Step::Next((Demand::joints(left), Demand::joints(right)))
}

fn look(c: &mut Greet, e: &State<(Irp6, Irp6)>, t: Tick) -> Step<(Irp6, Irp6)> {
    c.from = [e.0.demanded().joints, e.1.demanded().joints];
    greet(c, t)
}

/// Runs the example.
///
/// # Errors
/// When the cell stops with a fault, or the picture cannot be written.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
    let half_turn = Pose::rotation(Vector3::z() * std::f64::consts::PI);
    let arms = [Irp6::nominal(), Irp6::nominal().with_base(Translation3::new(2.2, 0.3, 0.0) * half_turn)];
    let mut cell = Cell::new(Duration::from_millis(2));
    for (name, arm) in ["left", "right"].into_iter().zip(arms) {
        cell = cell.robot(RobotSetup::new(name, arm.clone(), SimulatedIrp6::new(arm, &start)));
    }
    let cell = cell.program(|mp| {
        let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
        mp.move_robots((&mut left, &mut right), (), Greet { from: [Six::zeros(); 2], t: 0.0 })?;
        Ok(())
    });
    let mut film = Film::new();
    let report = film.watch(cell).run()?;
    film.save("picture.svg".as_ref())?;
    println!("moved for {:.3} s: see picture.svg", report.time.as_secs_f64());
    Ok(())
}
