//! No acceleration is held: the variable is `w = x + y`, with `y^2 - x^2 = k`, in which the duration is linear.

use super::value::Value;

/// `x = (w - k / w) / 2`; negative where the acceleration stays below 0 throughout.
#[inline]
pub(super) fn smaller(w: f64, k: f64) -> f64 {
    if w > 0.0 { 0.5 * (w - k / w) } else { 0.0 }
}

/// The sum of `x` and the `y` that belongs to it.
#[inline]
pub(super) fn sum(x: f64, k: f64) -> f64 {
    let y = (x * x + k).sqrt();
    if x < 0.0 { k / (y - x) } else { x + y }
}

/// `T = 2 w / J`; `D = ((b + v) x + (v + o) y) / J = ((b + v) w - k y / J) / J`; `dD/dw = (b + v + x w / J) / J`.
#[inline]
pub(super) fn value(w: f64, base: f64, k: f64, per_j: f64) -> Value {
    let i = per_j;
    let x = smaller(w, k);
    let sum = 2.0 * base + x * x * i;
    Value { time: 2.0 * w * i, displacement: (sum * w - k * i * (w - x)) * i, slope: (sum + x * w * i) * i }
}

#[inline]
pub(super) fn at_time(time: f64, j: f64) -> f64 {
    0.5 * j * time
}

/// `dD/dw = 0`: `3 u^2 - 4 c u + k^2 = 0` for `u = w^2`, `c = k - 2 b J`.
#[inline]
pub(super) fn turns(base: f64, k: f64, j: f64) -> [f64; 2] {
    let c = k - 2.0 * base * j;
    let root = (4.0 * c * c - 3.0 * k * k).sqrt();
    // The smaller one by the product, which does not cancel. Without solution, not a number.
    let high = (2.0 * c + root) / 3.0;
    [(k * k / (3.0 * high)).sqrt(), high.sqrt()]
}
