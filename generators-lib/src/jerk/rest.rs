//! From rest to rest with the same acceleration up and down, in closed form.
//!
//! ```text
//! each ramp   x = min(A, sqrt(J v)),  t = x / J, h = v / x - t, t
//! v = V                                    if D >= V (V / A + A / J), or 2 V sqrt(V / J) if V < A^2 / J
//!     (sqrt(A^4 / J^2 + 4 A D) - A^2 / J) / 2   else if D >= 2 A^3 / J^2
//!     cbrt(J D^2 / 4)                      else
//! ```

use super::AxisLimits;
use super::profile::Phases;

/// The fastest motion from rest by `way` \[m\] > 0 in the `direction` 1 or -1, if both accelerations are the same.
pub(super) fn rest_to_rest(way: f64, direction: f64, limits: &AxisLimits) -> Option<Phases> {
    let (a, j) = (limits.max_acceleration, limits.jerk);
    if a != -limits.min_acceleration {
        return None;
    }
    let v_max = if direction > 0.0 { limits.max_velocity } else { -limits.min_velocity };
    let bend = a * a / j;
    let ramp = if v_max >= bend { v_max / a + a / j } else { 2.0 * (v_max / j).sqrt() };
    let cruise = way - v_max * ramp;
    let v = if cruise >= 0.0 {
        v_max
    } else if way * j >= 2.0 * a * bend {
        // The root without cancellation.
        2.0 * a * way / ((bend * bend + 4.0 * a * way).sqrt() + bend)
    } else {
        (0.25 * j * way * way).cbrt()
    };
    let x = if v >= bend { a } else { (j * v).sqrt() };
    let (t, held) = (x / j, (v / x - x / j).max(0.0));
    let cruise = if cruise > 0.0 { cruise / v_max } else { 0.0 };
    let jerk = j * direction;
    Some([(t, jerk), (held, 0.0), (t, -jerk), (cruise, 0.0), (t, -jerk), (held, 0.0), (t, jerk)])
}
