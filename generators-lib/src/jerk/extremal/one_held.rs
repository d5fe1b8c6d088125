//! One acceleration is held: the variable is the other's peak `x`, `v = b + x^2 / J`.

use super::value::Value;

/// `t = (v - o) / A + A / J`; `T = 2 x / J + t`; `D = (b + v) x / J + (v + o) t / 2`.
#[inline]
pub(super) fn value(x: f64, base: f64, other: f64, held: f64, per_j: f64) -> Value {
    let i = per_j;
    let per_held = 1.0 / held;
    let v = base + x * x * i;
    let t = (v - other) * per_held + held * i;
    let slope = 2.0 * x * i;
    Value {
        time: slope + t,
        displacement: (base + v) * x * i + 0.5 * (v + other) * t,
        slope: (slope * x + base + v) * i + 0.5 * slope * (t + (v + other) * per_held),
    }
}

/// `(x + A)^2 = J A T - J (b - o)`.
#[inline]
pub(super) fn at_time(time: f64, base: f64, other: f64, held: f64, j: f64) -> f64 {
    (j * (held * time - (base - other))).max(0.0).sqrt() - held
}

/// `dD/dx = 0`: `(x + A) (2 x^2 + A x + 2 b J) = 0`, of which `x = -A` is where the piece may begin.
#[inline]
pub(super) fn turns(base: f64, held: f64, j: f64) -> [f64; 2] {
    let root = (held * held - 16.0 * base * j).sqrt();
    [0.25 * (-held - root), 0.25 * (root - held)]
}
