//! Back into the limits, of an axis that has left them or must leave them: before anything else, as Ruckig does it.
//!
//! An acceleration beyond its limit is brought back by the jerk; a velocity beyond its limit, or one that the acceleration leads
//! there, by jerk and then by the acceleration's limit, until it is back or would leave its limit on the other side.

use super::{AxisLimits, AxisState};

/// Two phases of a duration and a jerk each.
pub(super) type Brake = [(f64, f64); 2];

/// The fastest way back, and the state it leads to; nothing for a start that the limits allow.
pub(super) fn brake(start: &AxisState, limits: &AxisLimits) -> (Brake, AxisState) {
    if limits.allow(start) {
        return ([(0.0, 0.0); 2], *start);
    }
    let (v, a, j) = (start.velocity, start.acceleration, limits.jerk);
    let upwards = if a > limits.max_acceleration {
        true
    } else if a < limits.min_acceleration {
        false
    } else {
        // Where the velocity gets when the acceleration is ended upwards, or downwards.
        let (rising, falling) = (v + a * a / (2.0 * j), v - a * a / (2.0 * j));
        (v > limits.max_velocity && falling > limits.min_velocity)
            || (a > 0.0 && rising > limits.max_velocity)
    };
    let direction = if upwards { 1.0 } else { -1.0 };
    let seen = if upwards { *limits } else { limits.mirrored() };
    let phases = downwards(direction * v, direction * a, &seen).map(|(t, j)| (t, direction * j));
    let mut state = *start;
    for (t, j) in phases {
        let AxisState { position: p, velocity: v, acceleration: a } = state;
        state = AxisState {
            position: p + t * (v + t * (0.5 * a + t * j / 6.0)),
            velocity: v + t * (a + t * 0.5 * j),
            acceleration: a + t * j,
        };
    }
    (phases, state)
}

/// Back from an acceleration that is too high, or from a velocity that is or will be.
fn downwards(v: f64, a: f64, limits: &AxisLimits) -> Brake {
    let AxisLimits { max_velocity, min_velocity, max_acceleration: most, jerk: j, .. } = *limits;
    if a <= most || v + a * a / (2.0 * j) > max_velocity {
        return slower(v, a, limits);
    }
    let back = (a - most) / j;
    let v = v + back * (a - 0.5 * j * back);
    // Held while the velocity is too low, but not so long that it must become too high.
    let held = ((min_velocity - v) / most).min((max_velocity - v) / most - most / (2.0 * j));
    [(back, -j), (held.max(0.0), 0.0)]
}

/// Back from a velocity that is or will be too high, until it is at its limit or would come to fall below the lower one.
fn slower(v: f64, a: f64, limits: &AxisLimits) -> Brake {
    let AxisLimits { max_velocity, min_velocity, min_acceleration: least, jerk: j, .. } = *limits;
    let to_limit = (a + (a * a + 2.0 * j * (v - max_velocity)).max(0.0).sqrt()) / j;
    let to_lower = (a + (0.5 * a * a + j * (v - min_velocity)).max(0.0).sqrt()) / j;
    let (to_least, until) = ((a - least) / j, to_limit.min(to_lower));
    if to_least >= until {
        return [(until.max(0.0), -j), (0.0, 0.0)];
    }
    let v = v + to_least * (a - 0.5 * j * to_least);
    let held = ((max_velocity - v) / least).min((min_velocity - v) / least + least / (2.0 * j));
    [(to_least.max(0.0), -j), (held.max(0.0), 0.0)]
}
