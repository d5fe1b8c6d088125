//! Gauss-Legendre quadrature of `|S'|`: nodes and weights on -1..1 (Abramowitz and Stegun, table 25.4).

use super::Span;

const NODES_5: [(f64, f64); 2] =
    [(0.538_469_310_105_683_1, 0.478_628_670_499_366_47), (0.906_179_845_938_664, 0.236_926_885_056_189_08)];
const CENTRE_5: f64 = 0.568_888_888_888_888_9;
const NODES_7: [(f64, f64); 3] = [
    (0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (0.741_531_185_599_394_4, 0.279_705_391_489_276_67),
    (0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
];
const CENTRE_7: f64 = 0.417_959_183_673_469_4;

/// Length from `a` to `b` by 5 nodes.
#[inline]
pub(super) fn length_5(span: &Span, a: f64, b: f64) -> f64 {
    rule(span, a, b, CENTRE_5, &NODES_5)
}

/// Length from `a` to `b` by 7 nodes.
#[inline]
pub(super) fn length_7(span: &Span, a: f64, b: f64) -> f64 {
    rule(span, a, b, CENTRE_7, &NODES_7)
}

#[inline]
fn rule<const N: usize>(span: &Span, a: f64, b: f64, centre: f64, nodes: &[(f64, f64); N]) -> f64 {
    let middle = 0.5 * (a + b);
    let half = 0.5 * (b - a);
    let pairs = nodes.iter().fold(centre * span.first(middle).norm(), |sum, (x, weight)| {
        let offset = x * half;
        sum + weight * (span.first(middle - offset).norm() + span.first(middle + offset).norm())
    });
    half * pairs
}
