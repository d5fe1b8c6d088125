//! The robot: its behaviours, and which of them runs.

use mrroc::prelude::*;
use mrroc_generators::combinators::Arbitrate;
use nalgebra::Vector2;

use crate::arm::Arm;
use crate::generators::{SPEED, Steer};
use crate::orders::Task;
use crate::touch::{Near, Touch, clear, near};

/// What hands over is braked within this time [s].
const BRAKING: f64 = 0.1;

/// Gives the robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("arm", arm) // named as in cell.toml
}

/// FILL IN: behaviours by priority. More than two: the last argument makes another `Arbitrate`.
fn arm(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    let mut touch = ecp.sensor::<Touch>("touch")?;
    ecp.serve_all(|ecp, Task::Reach { x, y }| {
        let goal = Vector2::new(x, y);
        let go_around = move || Steer::by(move |at, near: &Near| around(&goal, &at, near));
        let go_on = move || Steer::by(move |at, _: &Near| head(&goal, &at));
        ecp.move_robot((&mut touch,), Arbitrate::of(go_around, near, clear, BRAKING, go_on)).map(drop)
    })
}

/// FILL IN: the usual behaviour: straight to the goal, more slowly near it. `None`: it is there.
fn head(goal: &Vector2<f64>, at: &Vector2<f64>) -> Option<Vector2<f64>> {
    let towards = goal - at;
    let far = towards.norm();
    (far > 5e-4).then(|| towards / far * SPEED.min(2.0 * far))
}

/// FILL IN: the preferred one: along what is near, on the side of the goal, and a little away from it.
fn around(goal: &Vector2<f64>, at: &Vector2<f64>, near: &Near) -> Option<Vector2<f64>> {
    let away = Vector2::from(near.away);
    let beside = Vector2::new(-away.y, away.x);
    let beside = if beside.dot(&(goal - at)) < 0.0 { -beside } else { beside };
    Some((beside + away * 0.5).normalize() * SPEED)
}
