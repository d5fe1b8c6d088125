//! A path of all joints: straight legs, whose corners are rounded as far as what is near allows.
//!
//! In: points of a clear path. Out: a [`Path`], twice continuously differentiable by its parameter `u`, which on legs is the length: the
//! root of the sum of squares over all joints.
//!
//! A corner `C` between the directions `e` and `f` is replaced, from `d` before it to `d` behind it, by the Bézier curve of degree 5
//! with the points `C - d e, C - 0.6 d e, C - 0.2 d e, C + 0.2 d f, C + 0.6 d f, C + d f` over `2 d` of the parameter: it joins the legs with
//! their first and second derivative, and lies in the triangle that it cuts off.

use crate::check::Checker;
use crate::edge::Edges;

/// The largest distance from a corner at which it is rounded [rad or m].
const LARGEST: f64 = 0.6;
/// The least distance; nearer than that a corner is passed at hardly any speed.
const LEAST: f64 = 1e-4;
/// The narrowest part of a curve whose derivatives are bounded: a share of it.
const NARROWEST: f64 = 1e-5;
/// Stretches that are shorter than this are none [rad or m].
pub(crate) const ROUNDING: f64 = 1e-12;
/// Into how many chords a curve is cut for its check.
const CHORDS: usize = 8;

/// Position, first and second derivative by the parameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct At {
    pub(crate) q: Vec<f64>,
    pub(crate) first: Vec<f64>,
    pub(crate) second: Vec<f64>,
}

/// A piece of a path, from its parameter to that of the next.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Piece {
    /// From a point along a direction of length 1.
    Leg { from: Vec<f64>, along: Vec<f64> },
    /// Joint by joint the six numbers of a curve of degree 5.
    Curve(Vec<[f64; 6]>),
}

/// A path of all joints.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    /// Where each piece begins, and the end.
    pub(crate) knots: Vec<f64>,
    pub(crate) pieces: Vec<Piece>,
}

/// A point of a path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    /// Where all joints are [rad or m].
    pub(crate) at: Vec<f64>,
    /// How its corner is rounded.
    pub(crate) rounding: Rounding,
}

/// How a corner is rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rounding {
    /// As far as is clear.
    Free,
    /// From this distance on [rad or m], at most half of both legs, which is known to be clear.
    By(f64),
    /// No more than is needed to pass it at all.
    Least,
}

/// The root of the sum of squares over all joints [rad or m].
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt()
}

/// The direction from one point to another, of length 1, and their distance, which is not 0.
pub(crate) fn direction(a: &[f64], b: &[f64]) -> (Vec<f64>, f64) {
    let length = distance(a, b);
    (b.iter().zip(a).map(|(b, a)| (b - a) / length).collect(), length)
}

/// `a + b x`.
pub(crate) fn along(a: &[f64], b: &[f64], x: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b * x).collect()
}

impl Path {
    /// Through points, each apart from the next, whose straight legs are clear; corners are rounded as far as is clear as well.
    pub(crate) fn rounded(checker: &mut Checker, edges: &mut Edges, points: &[Point]) -> Self {
        let places: Vec<&[f64]> = points.iter().map(|point| &*point.at).collect();
        let largest = |i: usize| match points[i].rounding {
            Rounding::Free => LARGEST,
            Rounding::By(d) => d,
            Rounding::Least => LEAST,
        };
        Path::through(&places, largest, LEAST, |i, curve, _| {
            matches!(points[i].rounding, Rounding::By(_)) || is_clear(checker, edges, curve)
        })
    }

    /// Through points, each apart from the next. The corner at point `i` is rounded from `largest(i)` on, at most from half of both legs, halved until the
    /// curve `is_clear`, which is told the point, the curve and that distance, or the distance is not above `least`.
    pub(crate) fn through(
        points: &[&[f64]],
        largest: impl Fn(usize) -> f64,
        least: f64,
        mut is_clear: impl FnMut(usize, &[[f64; 6]], f64) -> bool,
    ) -> Self {
        let legs: Vec<(Vec<f64>, f64)> = points.windows(2).map(|pair| direction(pair[0], pair[1])).collect();
        let mut path = Path { knots: vec![0.0], pieces: Vec::new() };
        let mut begin = points[0].to_vec();
        for (i, pair) in legs.windows(2).enumerate() {
            let [(e, before), (f, behind)] = pair else { continue };
            let corner = points[i + 1];
            let mut d = largest(i + 1).min(0.5 * before).min(0.5 * behind);
            let curve = loop {
                let curve = curve(corner, e, f, d);
                if d <= least || is_clear(i + 1, &curve, d) {
                    break curve;
                }
                d *= 0.5;
            };
            path.leg(&begin, &along(corner, e, -d), e);
            path.push(2.0 * d, Piece::Curve(curve));
            begin = along(corner, f, d);
        }
        if let (Some((e, _)), Some(end)) = (legs.last(), points.last()) {
            path.leg(&begin, end, e);
        }
        path
    }

    /// The path of robots that stay at a point.
    pub(crate) fn point(at: &[f64]) -> Self {
        Path {
            knots: vec![0.0; 2],
            pieces: vec![Piece::Leg { from: at.to_vec(), along: vec![0.0; at.len()] }],
        }
    }

    fn leg(&mut self, from: &[f64], to: &[f64], direction: &[f64]) {
        let length = distance(from, to);
        if length > ROUNDING {
            self.push(length, Piece::Leg { from: from.to_vec(), along: direction.to_vec() });
        }
    }

    pub(crate) fn push(&mut self, length: f64, piece: Piece) {
        self.knots.push(self.knots[self.knots.len() - 1] + length);
        self.pieces.push(piece);
    }

    /// The last parameter; the first is 0.
    pub(crate) fn length(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    /// Where pieces begin and end, rising.
    pub(crate) fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The number of the piece at a parameter: the first before the path's start, the last behind its end.
    pub(crate) fn piece_at(&self, u: f64) -> usize {
        self.knots.partition_point(|knot| *knot <= u).clamp(1, self.pieces.len()) - 1
    }

    /// The path at a parameter; before its start and behind its end it stays there.
    pub(crate) fn at(&self, u: f64) -> At {
        let piece = self.piece_at(u);
        let (from, to) = (self.knots[piece], self.knots[piece + 1]);
        let s = u.clamp(from, to) - from;
        match &self.pieces[piece] {
            Piece::Leg { from, along: direction } => At {
                q: along(from, direction, s),
                first: direction.clone(),
                second: vec![0.0; direction.len()],
            },
            Piece::Curve(points) => {
                let width = to - from;
                let at = points.iter().map(|points| bezier(points, s / width));
                let mut out = At { q: Vec::new(), first: Vec::new(), second: Vec::new() };
                for [value, first, second] in at {
                    out.q.push(value);
                    out.first.push(first / width);
                    out.second.push(second / (width * width));
                }
                out
            }
        }
    }

    /// The position of one joint.
    pub(crate) fn joint_at(&self, u: f64, joint: usize) -> f64 {
        let piece = self.piece_at(u);
        let (from, to) = (self.knots[piece], self.knots[piece + 1]);
        let s = u.clamp(from, to) - from;
        match &self.pieces[piece] {
            Piece::Leg { from, along } => from[joint] + along[joint] * s,
            Piece::Curve(points) => bezier(&points[joint], s / (to - from))[0],
        }
    }

    /// Where the joints are from the parameter `from` on, in one piece of the path, to `to` at most: gives where the stretch ends, and visits each joint
    /// with its position in the middle and by how much it is off that at most, either way.
    pub(crate) fn stretch(&self, from: f64, to: f64, mut visit: impl FnMut(usize, f64, f64)) -> f64 {
        let piece = self.piece_at(from);
        let (begin, end) = (self.knots[piece], self.knots[piece + 1]);
        let is_last = piece + 1 == self.pieces.len();
        let reached = if is_last { to } else { to.min(end) };
        let [a, b] = [from, reached].map(|u| u.clamp(begin, end) - begin);
        match &self.pieces[piece] {
            Piece::Leg { from, along } => {
                for (joint, (from, along)) in from.iter().zip(along).enumerate() {
                    visit(joint, from + along * (0.5 * (a + b)), (0.5 * along * (b - a)).abs());
                }
            }
            Piece::Curve(points) => {
                let width = end - begin;
                for (joint, points) in points.iter().enumerate() {
                    let middle = bezier(points, 0.5 * (a + b) / width)[0];
                    // A curve lies between the least and the largest of its control points.
                    let off = part(points, [a / width, b / width]).map(|point| (point - middle).abs());
                    visit(joint, middle, off.into_iter().fold(0.0, f64::max));
                }
            }
        }
        reached
    }

    /// The least and the largest derivative of each joint by the parameter between two parameters, or a wider range.
    pub(crate) fn rates(&self, from: f64, to: f64, mut visit: impl FnMut(usize, [f64; 2])) {
        let joints = match &self.pieces[0] {
            Piece::Leg { from, .. } => from.len(),
            Piece::Curve(points) => points.len(),
        };
        let (first, last) = (self.piece_at(from), self.piece_at(to));
        for joint in 0..joints {
            let mut rates = [f64::INFINITY, f64::NEG_INFINITY];
            for piece in first..=last {
                let (begin, end) = (self.knots[piece], self.knots[piece + 1]);
                let mut take = |rate: f64| rates = [rates[0].min(rate), rates[1].max(rate)];
                match &self.pieces[piece] {
                    Piece::Leg { along, .. } => take(along[joint]),
                    Piece::Curve(points) => {
                        let width = end - begin;
                        let [a, b] = [from, to].map(|u| (u.clamp(begin, end) - begin) / width);
                        // Differences of what is nearly one point are rounding.
                        let b = b.max(a + NARROWEST).min(1.0);
                        let a = a.min(b - NARROWEST);
                        // The derivatives of a part lie between those of its control points.
                        let part = part(&points[joint], [a, b]);
                        let part_width = (b - a) * width;
                        part.windows(2).for_each(|p| take(5.0 * (p[1] - p[0]) / part_width));
                    }
                }
            }
            visit(joint, rates);
        }
    }

    /// The derivative of one joint by the parameter.
    pub(crate) fn first_at(&self, u: f64, joint: usize) -> f64 {
        let piece = self.piece_at(u);
        let (from, to) = (self.knots[piece], self.knots[piece + 1]);
        match &self.pieces[piece] {
            Piece::Leg { along, .. } => along[joint],
            Piece::Curve(points) => {
                bezier(&points[joint], (u.clamp(from, to) - from) / (to - from))[1] / (to - from)
            }
        }
    }
}

/// The control points of a part of a curve of degree 5, from `a` to `b`, each 0 to 1, by de Casteljau's scheme at both.
pub(crate) fn part(points: &[f64; 6], [a, b]: [f64; 2]) -> [f64; 6] {
    // What lies before `b`, of that what lies behind `a`.
    let mut before = *points;
    for level in 1..6 {
        for i in (level..6).rev() {
            before[i] = before[i - 1] + (before[i] - before[i - 1]) * b;
        }
    }
    let share = if b > 0.0 { a / b } else { 0.0 };
    for level in (1..6).rev() {
        for i in 0..level {
            before[i] += (before[i + 1] - before[i]) * share;
        }
    }
    before
}

/// The curve around a corner.
pub(crate) fn curve(corner: &[f64], e: &[f64], f: &[f64], d: f64) -> Vec<[f64; 6]> {
    let joint = |((c, e), f): ((&f64, &f64), &f64)| {
        [c - d * e, c - 0.6 * d * e, c - 0.2 * d * e, c + 0.2 * d * f, c + 0.6 * d * f, c + d * f]
    };
    corner.iter().zip(e).zip(f).map(joint).collect()
}

/// Value, first and second derivative of a curve of degree 5 at `t`, 0 to 1, by de Casteljau's scheme.
pub(crate) fn bezier(points: &[f64; 6], t: f64) -> [f64; 3] {
    let mut p = *points;
    let (mut first, mut second) = (0.0, 0.0);
    for degree in (1..=5).rev() {
        if degree == 2 {
            second = 20.0 * (p[2] - 2.0 * p[1] + p[0]);
        }
        if degree == 1 {
            first = 5.0 * (p[1] - p[0]);
        }
        for i in 0..degree {
            p[i] += (p[i + 1] - p[i]) * t;
        }
    }
    [p[0], first, second]
}

/// Whether a curve is clear: its chords are, with all that lies as far off them as the curve may.
pub(crate) fn is_clear(checker: &mut Checker, edges: &mut Edges, curve: &[[f64; 6]]) -> bool {
    // A curve is off its chord by at most an eighth of the square of the width times its second derivative, which is at most the
    // largest of its control points.
    let bend = |points: &[f64; 6]| {
        let second = points.windows(3).map(|p| (20.0 * (p[2] - 2.0 * p[1] + p[0])).abs()).fold(0.0, f64::max);
        (second / (8.0 * (CHORDS * CHORDS) as f64)) as f32
    };
    let off: Vec<f32> = curve.iter().map(bend).collect();
    let at = |k: usize| -> Vec<f32> {
        let t = k as f64 / CHORDS as f64;
        curve.iter().map(|points| bezier(points, t)[0] as f32).collect()
    };
    (0..CHORDS).all(|k| edges.is_clear_around(checker, &at(k), &at(k + 1), &off))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_of_degree_five_has_the_derivatives_of_its_bernstein_form() {
        // t^5: all control points 0 but the last.
        let [value, first, second] = bezier(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 0.7);
        assert!((value - 0.7_f64.powi(5)).abs() < 1e-15);
        assert!((first - 5.0 * 0.7_f64.powi(4)).abs() < 1e-14);
        assert!((second - 20.0 * 0.7_f64.powi(3)).abs() < 1e-14);
    }

    #[test]
    fn a_part_of_a_curve_is_the_curve_between_its_ends() {
        let points = [0.3, -1.0, 2.0, 0.7, -0.4, 1.1];
        for (a, b) in [(0.0, 1.0), (0.2, 0.7), (0.0, 0.0), (1.0, 1.0), (0.5, 0.5001)] {
            let part = part(&points, [a, b]);
            for k in 0..=10 {
                let t = f64::from(k) / 10.0;
                let expected = bezier(&points, a + (b - a) * t)[0];
                assert!((bezier(&part, t)[0] - expected).abs() < 1e-14, "{a} to {b} at {t}");
            }
        }
    }

    #[test]
    fn a_stretch_holds_all_of_the_path_between_its_ends_and_passes_its_middle() {
        let (e, f) = ([0.6, 0.8], [-0.8, 0.6]);
        let path = Path {
            knots: vec![0.0, 1.0, 1.5, 2.0],
            pieces: vec![
                Piece::Leg { from: vec![0.4 - 0.15, 1.2 - 0.2], along: e.to_vec() },
                Piece::Curve(curve(&[1.0, 2.0], &e, &f, 0.25)),
                Piece::Leg { from: vec![0.8, 2.15], along: f.to_vec() },
            ],
        };
        let mut from = 0.0;
        for width in [0.3, 0.9, 0.1, 0.2, 0.05, 0.4, 0.3].into_iter().cycle() {
            let mut held = [[0.0; 2]; 2];
            let end = path
                .stretch(from, (from + width).min(2.0), |joint, middle, half| held[joint] = [middle, half]);
            assert!(end > from && end <= from + width);
            for (joint, [middle, half]) in held.into_iter().enumerate() {
                assert!((path.joint_at(0.5 * (from + end), joint) - middle).abs() < 1e-14);
                for k in 0..=20 {
                    let q = path.joint_at(from + (end - from) * f64::from(k) / 20.0, joint);
                    assert!((q - middle).abs() <= half + 1e-14, "{from} to {end}, joint {joint}");
                }
            }
            let to = (from + width).min(2.0);
            let mut derivatives = [[0.0; 2]; 2];
            path.rates(from, to, |joint, rates| derivatives[joint] = rates);
            for (joint, [least, most]) in derivatives.into_iter().enumerate() {
                for k in 0..=20 {
                    let u = from + (to - from) * f64::from(k) / 20.0;
                    let at = path.at(u);
                    assert!((path.first_at(u, joint) - at.first[joint]).abs() < 1e-12);
                    assert!(at.first[joint] >= least - 1e-9 && at.first[joint] <= most + 1e-9, "at {u}");
                }
            }
            if end >= 2.0 {
                break;
            }
            from = end;
        }
        // Of a part that is all but a point at the end of a curve.
        let mut derivatives = [[0.0; 2]; 2];
        path.rates(1.5 - 4e-16, 1.5 - 2e-16, |joint, rates| derivatives[joint] = rates);
        for (joint, [least, most]) in derivatives.into_iter().enumerate() {
            let first = path.first_at(1.5, joint);
            assert!((least - first).abs() < 1e-4 && (most - first).abs() < 1e-4, "{least} {most} {first}");
        }
    }

    #[test]
    fn a_rounded_corner_joins_its_legs_with_two_derivatives() {
        let (e, f) = ([0.6, 0.8], [-0.8, 0.6]);
        let points = curve(&[1.0, 2.0], &e, &f, 0.25);
        for (joint, points) in points.iter().enumerate() {
            let [from, first, second] = bezier(points, 0.0);
            assert!((from - ([1.0, 2.0][joint] - 0.25 * e[joint])).abs() < 1e-15);
            assert!((first / 0.5 - e[joint]).abs() < 1e-14 && second.abs() < 1e-12);
            let [_, first, second] = bezier(points, 1.0);
            assert!((first / 0.5 - f[joint]).abs() < 1e-14 && second.abs() < 1e-12);
        }
    }
}
