//! Where a maze stands: from three touches of its frame from outside.

use mrroc::pose::Pose;
use nalgebra::{Translation3, UnitQuaternion, Vector2, Vector3};

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
