//! Where a maze stands: from three touches of its frame from outside.

use mrroc::pose::Pose;
use mrroc::prelude::*;
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::mp::MazeSettings;
use crate::orders::{Task, TaskOutcome, TaskRunner};
use crate::places::{MIDDLE, said};

/// How an arm finds the maze: it touches the left side twice and the lower one once, each from 12 mm beside the frame and for 20 mm at
/// most. Then the ball is put down at the start. `X_WM`, and where the ball is.
///
/// # Errors
/// No side where one is looked for; the first fault of the cell.
pub fn by_three_touches(run: &mut TaskRunner<'_>, told: &MazeSettings) -> Result<(Pose, TaskOutcome), Fault> {
    let [width, height] = told.known.size;
    let corner = said([width, height]).translation;
    let mut sides = [Vector2::zeros(); 3];
    let places = [(-0.012, 0.15 * height), (-0.012, 0.85 * height), (0.5 * width, -0.012)];
    for (side, (x, y)) in sides.iter_mut().zip(places) {
        let from = [corner.x + x, corner.y + y];
        let to = if x < 0.0 { [0.02, 0.0] } else { [0.0, 0.02] };
        run(Task::Hop { x: from[0], y: from[1] })?;
        let went = run(Task::Go { x: from[0] + to[0], y: from[1] + to[1] })?;
        *side = went.touched.ok_or_else(|| {
            Fault::thrown("the maze is not where it is said to stand: look for it, and correct its place")
        })?;
    }
    let off = told.known.radius + 0.5 * told.known.thickness;
    let maze = found([sides[0], sides[1]], sides[2], off, MIDDLE[2]);
    let start = maze * Point3::new(told.start.x, told.start.y, 0.0);
    Ok((maze, run(Task::Hop { x: start.x, y: start.y })?))
}

/// `X_WM` from where the ball's centre touched the left side twice, below and above, and the lower side once [m, W]; `off` is how far
/// the centre is then from the line of the posts \[m\].
#[must_use]
#[allow(non_snake_case)]
pub fn found(left: [Vector2<f64>; 2], below: Vector2<f64>, off: f64, height: f64) -> Pose {
    let up = (left[1] - left[0]).normalize();
    let right = Vector2::new(up.y, -up.x);
    // The left side is x = -off, the lower one y = -off.
    let origin = right * (left[0].dot(&right) + off) + up * (below.dot(&up) + off);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), right.y.atan2(right.x));
    Pose::from_parts(Translation3::new(origin.x, origin.y, height), turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_maze_is_found_where_it_stands() {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.015);
        let pose = Pose::from_parts(Translation3::new(0.66, -0.21, 0.1), turn);
        let at = |x: f64, y: f64| (pose * nalgebra::Point3::new(x, y, 0.0)).coords.xy();
        let off = 0.003;
        let again = found([at(-off, 0.03), at(-off, 0.36)], at(0.2, -off), off, 0.1);
        assert!((again.inverse() * pose).translation.vector.norm() < 1e-15);
        assert!(again.rotation.angle_to(&turn) < 1e-12);
    }
}
