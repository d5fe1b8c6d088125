//! Both accelerations are held: the variable is the peak velocity.

use super::value::Value;

/// `t = (v - b) / A + A / J` for each ramp; `D` is the sum of `(b + v) t / 2`.
#[inline]
pub(super) fn value(v: f64, bases: [f64; 2], held: [f64; 2], per_j: f64) -> Value {
    let mut sum = Value::default();
    for (base, a) in bases.into_iter().zip(held) {
        let per_a = 1.0 / a;
        let t = (v - base) * per_a + a * per_j;
        sum.time += t;
        sum.displacement += 0.5 * (v + base) * t;
        sum.slope += 0.5 * (t + (v + base) * per_a);
    }
    sum
}

#[inline]
pub(super) fn at_time(time: f64, bases: [f64; 2], held: [f64; 2], j: f64) -> f64 {
    let [b, c] = bases;
    let [a, d] = held;
    (time - (a + d) / j + b / a + c / d) / (1.0 / a + 1.0 / d)
}

/// `dD/dv = 0`.
#[inline]
pub(super) fn turns(held: [f64; 2], j: f64) -> [f64; 2] {
    [-0.5 * held[0] * held[1] / j, f64::NAN]
}
