//! The velocity is held at its limit, behind the ramps that lead there.

use super::Value;

#[inline]
pub(super) fn value(t: f64, velocity: f64, before: &Value) -> Value {
    // An endless cruise gets anywhere.
    let way = if t == f64::INFINITY { t } else { before.way + velocity * t };
    Value { time: before.time + t, way, way_slope: velocity }
}
