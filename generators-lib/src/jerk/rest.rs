//! From rest to rest with the same acceleration up and down, in closed form.
//!
//! ```text
//! each ramp   x = min(A, sqrt(J v)),  t = x / J, h = v / x - t, t
//! v = V                                    if D >= V (V / A + A / J), or 2 V sqrt(V / J) if V < A^2 / J
//!     (sqrt(A^4 / J^2 + 4 A D) - A^2 / J) / 2   else if D >= 2 A^3 / J^2
//!     cbrt(J D^2 / 4)                      else
//! ```

use super::AxisLimits;
use super::profile::{Phase, Phases};

/// The fastest motion from rest over the `distance` \[m\] > 0 in the `direction` 1 or -1, if both accelerations are the same.
pub(super) fn rest_to_rest(distance: f64, direction: f64, limits: &AxisLimits) -> Option<Phases> {
    let a = limits.max_acceleration;
    let j = limits.jerk;
    if a != -limits.min_acceleration {
        return None;
    }
    let v_max = if direction > 0.0 { limits.max_velocity } else { -limits.min_velocity };
    let bend = a * a / j;
    let ramp = if v_max >= bend { v_max / a + a / j } else { 2.0 * (v_max / j).sqrt() };
    let cruise = distance - v_max * ramp;
    let v = if cruise >= 0.0 {
        v_max
    } else if distance * j >= 2.0 * a * bend {
        // The root without cancellation.
        2.0 * a * distance / ((bend * bend + 4.0 * a * distance).sqrt() + bend)
    } else {
        (0.25 * j * distance * distance).cbrt()
    };
    let x = if v >= bend { a } else { (j * v).sqrt() };
    let t = x / j;
    let held = (v / x - x / j).max(0.0);
    let cruise = if cruise > 0.0 { cruise / v_max } else { 0.0 };
    let jerk = j * direction;
    let up = Phase::new(t, jerk);
    let down = Phase::new(t, -jerk);
    let held = Phase::new(held, 0.0);
    Some([up, held, down, Phase::new(cruise, 0.0), down, held, up])
}
