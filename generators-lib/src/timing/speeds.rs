//! How fast the velocity limits let the path be passed at each point of the grid, so that they hold between as well.
//!
//! With `g` the least of `(V_j / q_j')^2` over the joints, `x <= g` keeps the limits at a point. On a cell `x` is linear and
//! `q_j'` a parabola; with `g` linear between its ends, `g q_j'^2 / V_j^2` is a polynomial of degree 5, at most its largest
//! Bernstein coefficient. Both ends are divided by that where it exceeds 1.

use mrroc::robot::JointVector;

use super::PathLimits;
use crate::curve::SplinePoint;

/// How much higher than the middle of its cells a speed may be where all joints reverse: any number does that is finite.
const REVERSING: f64 = 16.0;

/// Bernstein coefficients of a parabola with these values at the start, in the middle and at the end.
fn bernstein(start: f64, middle: f64, end: f64) -> [f64; 3] {
    [start, 2.0 * middle - 0.5 * (start + end), end]
}

/// The square of the speed allowed at each point of the grid, from the path at start, middle and end of each cell.
pub(super) fn most<J: JointVector>(cells: &[[SplinePoint<J>; 3]], limits: &PathLimits<J>) -> Vec<f64> {
    let path = limits.speed * limits.speed;
    let mut most = vec![path; cells.len() + 1];
    // The parabolas, in units of the limits.
    let controls = |cell: &[SplinePoint<J>; 3], j: usize| {
        let [p, q, r] = [0, 1, 2].map(|k| cell[k].first[j] / limits.velocity[j]);
        bernstein(p, q, r)
    };
    for (i, cell) in cells.iter().enumerate() {
        let mut hull = 0.0_f64;
        for j in 0..J::LEN {
            let [p, q, r] = controls(cell, j);
            most[i] = most[i].min(1.0 / (p * p));
            most[i + 1] = most[i + 1].min(1.0 / (r * r));
            hull = hull.max(p.abs()).max(q.abs()).max(r.abs());
        }
        let reversing = REVERSING / (hull * hull);
        most[i] = most[i].min(reversing);
        most[i + 1] = most[i + 1].min(reversing);
    }
    let mut share = vec![1.0_f64; most.len()];
    for (i, cell) in cells.iter().enumerate() {
        let g = most[i];
        let h = most[i + 1];
        let mut excess = 1.0_f64;
        for j in 0..J::LEN {
            let [p, q, r] = controls(cell, j);
            let squares = [p * p, p * q, (p * r + 2.0 * q * q) / 3.0, q * r, r * r];
            for k in 1..5 {
                let k_of_5 = 0.2 * k as f64;
                let rest = 1.0 - 0.2 * k as f64;
                excess = excess.max(rest * squares[k] * g + k_of_5 * squares[k - 1] * h);
            }
        }
        share[i] = share[i].min(1.0 / excess);
        share[i + 1] = share[i + 1].min(1.0 / excess);
    }
    most.iter().zip(share).map(|(most, share)| most * share).collect()
}
