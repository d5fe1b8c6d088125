//! The path of a tool as one of the joints.

use mrroc::prelude::*;
use mrroc::robot::JointVector;

use super::TimingError;
use crate::curve::{CubicSpline, SplineEnds};

/// Fewest and most cells of the spline.
const CELLS: (usize, usize) = (16, 1024);

/// The cubic spline of the joints on which the flange of `robot` follows `pose`, `X_WF` by a parameter in
/// `0..=length`, from the joint positions `near`: through the joint positions at equal distances, so many that midway between
/// them it misses those of the path by less than `tolerance` [rad or m].
///
/// The path should be twice continuously differentiable: at a jump of its curvature the spline's second derivative oscillates
/// a little, which takes time, but breaks no limit.
///
/// # Errors
/// A pose that the robot does not reach; joints that jump, or that 1024 cells do not follow.
pub fn joint_spline<R: Robot>(
    robot: &R,
    pose: impl Fn(f64) -> Pose,
    length: f64,
    near: &R::Joints,
    tolerance: f64,
) -> Result<CubicSpline<R::Joints>, TimingError> {
    if !(length > 0.0 && length.is_finite() && tolerance > 0.0) {
        return Err(TimingError::Grid(0.0, length));
    }
    let mut cells = CELLS.0;
    loop {
        // At the ends of the cells and midway between them.
        let at = |k: usize| length * k as f64 / (2 * cells) as f64;
        let mut joints = Vec::with_capacity(2 * cells + 1);
        let mut before = *near;
        for k in 0..=2 * cells {
            let found = robot.inverse(&pose(at(k)), &before);
            before = found.map_err(|cause| TimingError::NoInverse { at: at(k), cause })?;
            joints.push(before);
        }
        let ends = SplineEnds::Clamped(slope(&joints, at(1)), slope_at_end(&joints, at(1)));
        let knots = (0..=cells).map(|i| at(2 * i)).collect();
        let spline = CubicSpline::new(knots, joints.iter().step_by(2).copied().collect(), ends)?;
        let misses = (0..cells).map(|i| {
            let off = spline.at(at(2 * i + 1)).value - joints[2 * i + 1];
            (at(2 * i + 1), off.as_slice().iter().fold(0.0, |most: f64, x| most.max(x.abs())))
        });
        let worst = misses.fold((0.0, 0.0), |worst, miss| if miss.1 > worst.1 { miss } else { worst });
        if worst.1 <= tolerance {
            return Ok(spline);
        }
        if cells >= CELLS.1 {
            return Err(TimingError::NotSmooth { at: worst.0, miss: worst.1 });
        }
        cells *= 2;
    }
}

/// The slope at the start, from five points `h` apart: exact to the fourth order.
fn slope<J: JointVector>(q: &[J], h: f64) -> J {
    (q[0] * -25.0 + q[1] * 48.0 - q[2] * 36.0 + q[3] * 16.0 - q[4] * 3.0) * (1.0 / (12.0 * h))
}

fn slope_at_end<J: JointVector>(q: &[J], h: f64) -> J {
    let n = q.len() - 1;
    slope(&[q[n], q[n - 1], q[n - 2], q[n - 3], q[n - 4]], -h)
}
