//! How an axis that has left its limits, or cannot help leaving them, comes back within them: before anything else, as
//! Ruckig does it.
//!
//! An acceleration beyond its limit is brought back by the jerk. A velocity beyond its limit, or one that the present
//! acceleration will bring there, is brought back by the jerk and then by the limit of acceleration, until it is within
//! its limits again or would pass the limit on the other side.

use super::profile::Phase;
use super::{AxisLimits, AxisState};

/// The phases of a recovery.
pub(super) type Recovery = [Phase; 2];

/// The fastest recovery, and the state that it leads to; of no duration for a start that the limits allow.
pub(super) fn recovery(start: &AxisState, limits: &AxisLimits) -> (Recovery, AxisState) {
    if limits.allow(start) {
        return ([Phase::NONE; 2], *start);
    }
    let v = start.velocity;
    let a = start.acceleration;
    let j = limits.jerk;
    let upwards = if a > limits.max_acceleration {
        true
    } else if a < limits.min_acceleration {
        false
    } else {
        // The velocity when the acceleration has been ended, if that is positive, or negative.
        let rising = v + a * a / (2.0 * j);
        let falling = v - a * a / (2.0 * j);
        (v > limits.max_velocity && falling > limits.min_velocity)
            || (a > 0.0 && rising > limits.max_velocity)
    };
    let direction = if upwards { 1.0 } else { -1.0 };
    let seen = if upwards { *limits } else { limits.mirrored() };
    let phases = downwards(direction * v, direction * a, &seen)
        .map(|phase| Phase { jerk: direction * phase.jerk, ..phase });
    let mut state = *start;
    for Phase { duration: t, jerk: j } in phases {
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
fn downwards(v: f64, a: f64, limits: &AxisLimits) -> Recovery {
    let AxisLimits { max_velocity, min_velocity, max_acceleration: most, jerk: j, .. } = *limits;
    if a <= most || v + a * a / (2.0 * j) > max_velocity {
        return slower(v, a, limits);
    }
    let back = (a - most) / j;
    let v = v + back * (a - 0.5 * j * back);
    // Held while the velocity is too low, but not so long that it cannot help becoming too high.
    let held = ((min_velocity - v) / most).min((max_velocity - v) / most - most / (2.0 * j));
    [Phase::new(back, -j), Phase::new(held.max(0.0), 0.0)]
}

/// Back from a velocity that is or will be too high, until it is at its limit or would later fall below the lower limit.
fn slower(v: f64, a: f64, limits: &AxisLimits) -> Recovery {
    let AxisLimits { max_velocity, min_velocity, min_acceleration: least, jerk: j, .. } = *limits;
    let to_limit = (a + (a * a + 2.0 * j * (v - max_velocity)).max(0.0).sqrt()) / j;
    let to_lower = (a + (0.5 * a * a + j * (v - min_velocity)).max(0.0).sqrt()) / j;
    let to_least = (a - least) / j;
    let until = to_limit.min(to_lower);
    if to_least >= until {
        return [Phase::new(until.max(0.0), -j), Phase::NONE];
    }
    let v = v + to_least * (a - 0.5 * j * to_least);
    let held = ((max_velocity - v) / least).min((min_velocity - v) / least + least / (2.0 * j));
    [Phase::new(to_least.max(0.0), -j), Phase::new(held.max(0.0), 0.0)]
}
