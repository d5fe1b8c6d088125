//! From exact strokes to the points through which the motion's spline goes.
//!
//! A stroke is split into runs at corners (the tangent turns by more than [`Sampling::corner_angle`]). Within a run
//! points are added until the natural C2 cubic spline over chord length through them, the curve that the motion
//! follows, stays within [`Sampling::tolerance`] of the exact curve at five places of every span, and neighbouring
//! spans differ by a factor of at most 2. So joins of lines and arcs, where curvature jumps, get a fine, graded
//! spacing, and long lines few points.

use crate::drawing::{Drawing, NaturalSpline, Piece, Stroke, Vec3};
use std::collections::VecDeque;

/// What a sample is to its stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// The first point of a stroke: the tool comes down here.
    Start,
    /// A point that the spline passes smoothly.
    Smooth,
    /// A corner: one run of the spline ends here, the next begins.
    Corner,
    /// The last point of a stroke: the tool lifts here.
    End,
}

/// A point of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The tool's tip: the place over the plate and the height \[mm\].
    pub position: Vec3,
    /// Index of its stroke in the drawing.
    pub stroke: usize,
    /// What it is to its stroke.
    pub mark: Mark,
}

/// How finely strokes are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// The spline's distance from the exact curve \[mm\], > 0.
    pub tolerance: f64,
    /// A join that turns by more is a corner \[rad\], 0..π.
    pub corner_angle: f64,
    /// Points are not set closer than this \[mm\], > 0.
    pub closest: f64,
}

impl Default for Sampling {
    /// 2 µm, 5 degrees, 4 µm.
    fn default() -> Self {
        Self { tolerance: 0.002, corner_angle: 5.0f64.to_radians(), closest: 0.004 }
    }
}

/// How often spans are halved at most, which divides the longest by 2^20.
const MOST_PASSES: usize = 20;

/// Neighbouring spans differ by this factor at most.
const GRADING: f64 = 2.0;

impl Sampling {
    /// The samples of the whole drawing, stroke by stroke, computed as they are asked for.
    pub fn samples<'a>(&'a self, drawing: &'a Drawing) -> impl Iterator<Item = Sample> + 'a {
        Samples { sampling: self, drawing, stroke: 0, ready: VecDeque::new() }
    }

    /// The samples of one stroke.
    #[must_use]
    pub fn stroke(&self, stroke: &Stroke, index: usize) -> Vec<Sample> {
        let ends = self.run_ends(stroke);
        let mut samples = vec![Sample { position: stroke.tip(0.0), stroke: index, mark: Mark::Start }];
        for run in ends.windows(2) {
            let parameters = self.run(stroke, run[0], run[1]);
            samples.extend(parameters.iter().skip(1).map(|s| Sample {
                position: position(stroke, *s),
                stroke: index,
                mark: Mark::Smooth,
            }));
            if let Some(last) = samples.last_mut() {
                last.mark = Mark::Corner;
            }
        }
        if let Some(last) = samples.last_mut() {
            last.mark = Mark::End;
        }
        samples
    }

    /// Positions of the stroke's corners, without its ends \[mm\].
    #[must_use]
    pub fn corners(&self, stroke: &Stroke) -> Vec<Vec3> {
        let ends = self.run_ends(stroke);
        ends[1..ends.len() - 1].iter().map(|k| stroke.tip(*k as f64)).collect()
    }

    /// The piece indices where runs begin and end, the stroke's ends among them.
    fn run_ends(&self, stroke: &Stroke) -> Vec<usize> {
        let count = stroke.pieces().len();
        let mut ends = vec![0];
        for k in 1..count {
            let turn = stroke.tip_tangent(k - 1, 1.0).angle(&stroke.tip_tangent(k, 0.0));
            if turn > self.corner_angle {
                ends.push(k);
            }
        }
        ends.push(count);
        ends
    }

    /// The stroke parameters of a run's points.
    fn run(&self, stroke: &Stroke, from: usize, to: usize) -> Vec<f64> {
        if to == from + 1 && matches!(stroke.pieces()[from], Piece::Line { .. }) {
            return vec![from as f64, to as f64];
        }
        let mut at = self.first_guess(stroke, from, to);
        for _ in 0..MOST_PASSES {
            let points: Vec<Vec3> = at.iter().map(|s| position(stroke, *s)).collect();
            let Some(spline) = NaturalSpline::new(points.clone()) else { break };
            let poor = |i: usize| {
                (points[i + 1] - points[i]).norm() > 2.0 * self.closest
                    && deviation(stroke, &spline, i, at[i], at[i + 1]) > self.tolerance
            };
            let halved: Vec<bool> = (0..spline.spans()).map(poor).collect();
            let before = at.len();
            at = halve(stroke, &at, &halved);
            at = self.grade(stroke, at);
            if at.len() == before {
                break;
            }
        }
        at
    }

    /// Joins of pieces that are not too close, and inner points so that no span turns by much more than 60 degrees.
    fn first_guess(&self, stroke: &Stroke, from: usize, to: usize) -> Vec<f64> {
        let mut at = vec![from as f64];
        let mut last = position(stroke, from as f64);
        let end = position(stroke, to as f64);
        for k in from..to {
            let parts = match &stroke.pieces()[k] {
                Piece::Line { .. } => 1,
                Piece::Arc(arc) => (arc.sweep.abs() / 1.0).ceil().max(1.0) as usize,
                Piece::Cubic(_) | Piece::Rational(_) => 3,
            };
            for part in 1..=parts {
                let s = k as f64 + part as f64 / parts as f64;
                let p = position(stroke, s);
                let final_point = k + 1 == to && part == parts;
                if !final_point && (p - last).norm() >= self.closest && (end - p).norm() >= self.closest {
                    at.push(s);
                    last = p;
                }
            }
        }
        at.push(to as f64);
        at
    }

    /// Halves spans that are more than twice as long as a neighbour.
    fn grade(&self, stroke: &Stroke, mut at: Vec<f64>) -> Vec<f64> {
        for _ in 0..MOST_PASSES {
            let points: Vec<Vec3> = at.iter().map(|s| position(stroke, *s)).collect();
            let spans: Vec<f64> = points.windows(2).map(|w| (w[1] - w[0]).norm()).collect();
            let too_long = |i: usize| {
                let beside = [i.checked_sub(1), Some(i + 1)];
                let shortest = beside
                    .into_iter()
                    .flatten()
                    .filter_map(|k| spans.get(k))
                    .fold(f64::INFINITY, |a, b| a.min(*b));
                spans[i] > GRADING * shortest && spans[i] > 2.0 * self.closest
            };
            let halved: Vec<bool> = (0..spans.len()).map(too_long).collect();
            if !halved.contains(&true) {
                break;
            }
            at = halve(stroke, &at, &halved);
        }
        at
    }
}

/// The point at a stroke parameter; exact at joins.
fn position(stroke: &Stroke, s: f64) -> Vec3 {
    stroke.tip(s)
}

/// Puts a point into the middle of the marked spans.
fn halve(stroke: &Stroke, at: &[f64], marked: &[bool]) -> Vec<f64> {
    let mut more = Vec::with_capacity(at.len() * 2);
    for (i, s) in at.iter().enumerate() {
        more.push(*s);
        if marked.get(i) == Some(&true) {
            more.push(middle(stroke, *s, at[i + 1]));
        }
    }
    more
}

/// The parameter whose point is about as far from both ends.
fn middle(stroke: &Stroke, a: f64, b: f64) -> f64 {
    let (from, to) = (stroke.tip(a), stroke.tip(b));
    let (mut low, mut high) = (a, b);
    for _ in 0..8 {
        let m = 0.5 * (low + high);
        let p = stroke.tip(m);
        let (left, right) = ((p - from).norm(), (to - p).norm());
        if (left - right).abs() < 0.05 * (left + right) {
            return m;
        }
        if left < right {
            low = m;
        } else {
            high = m;
        }
    }
    0.5 * (low + high)
}

/// The largest distance of a spline's span from the exact curve between two stroke parameters \[mm\].
fn deviation(stroke: &Stroke, spline: &NaturalSpline<3>, span: usize, from: f64, to: f64) -> f64 {
    let mut worst = 0.0f64;
    for k in 1..=5 {
        let f = f64::from(k) / 6.0;
        worst = worst.max(distance(stroke, spline.point(span, f), from, to, f));
    }
    worst
}

/// The distance of a point from the curve between two stroke parameters, searched from the fraction `f` by Newton's
/// method on `(P - q) . P' = 0`.
fn distance(stroke: &Stroke, q: Vec3, from: f64, to: f64, f: f64) -> f64 {
    let mut s = from + (to - from) * f;
    for _ in 0..4 {
        // Just inside, so that a parameter at a join belongs to the piece of this span.
        let inside = s.clamp(from + 1e-12, to - 1e-12);
        let (d, dd) = stroke.tip_derivatives(inside);
        let gap = stroke.tip(inside) - q;
        let slope = d.norm_squared() + gap.dot(&dd);
        if slope <= 0.0 {
            break;
        }
        s = (s - gap.dot(&d) / slope).clamp(from, to);
    }
    (stroke.tip(s) - q).norm()
}

/// The samples of a drawing, one stroke ahead.
struct Samples<'a> {
    sampling: &'a Sampling,
    drawing: &'a Drawing,
    stroke: usize,
    ready: VecDeque<Sample>,
}

impl Iterator for Samples<'_> {
    type Item = Sample;

    fn next(&mut self) -> Option<Sample> {
        while self.ready.is_empty() {
            let stroke = self.drawing.strokes.get(self.stroke)?;
            self.ready.extend(self.sampling.stroke(stroke, self.stroke));
            self.stroke += 1;
        }
        self.ready.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deviation::{Corners, Deviation};
    use crate::drawing::{EllipticalArc, Limits, Vec2, read_file};
    use std::path::Path;

    fn stroke(pieces: Vec<Piece>) -> Stroke {
        Stroke::new(pieces).unwrap()
    }

    fn line(a: [f64; 2], b: [f64; 2]) -> Piece {
        Piece::Line { from: a.into(), to: b.into() }
    }

    /// The largest distance of the spline through a stroke's samples from the stroke.
    fn worst(stroke: &Stroke) -> f64 {
        let sampling = Sampling::default();
        let drawing = Drawing { strokes: vec![stroke.clone()] };
        let mut deviation = Deviation::new(&drawing, &sampling, Corners::Counted);
        let samples = sampling.stroke(stroke, 0);
        let mut run = vec![samples[0].position];
        for sample in &samples[1..] {
            run.push(sample.position);
            if sample.mark != Mark::Smooth {
                let spline = NaturalSpline::new(std::mem::take(&mut run)).unwrap();
                for span in 0..spline.spans() {
                    for k in 0..16 {
                        deviation.observe(spline.point(span, f64::from(k) / 16.0));
                    }
                }
                run.push(sample.position);
            }
        }
        deviation.report().max
    }

    #[test]
    fn a_line_has_two_points_and_a_rectangle_three_corners() {
        let sampling = Sampling::default();
        assert_eq!(sampling.stroke(&stroke(vec![line([0.0, 0.0], [90.0, 0.0])]), 0).len(), 2);
        let pieces = vec![
            line([0.0, 0.0], [9.0, 0.0]),
            line([9.0, 0.0], [9.0, 5.0]),
            line([9.0, 5.0], [0.0, 5.0]),
            line([0.0, 5.0], [0.0, 0.0]),
        ];
        let marks: Vec<Mark> = sampling.stroke(&stroke(pieces), 0).iter().map(|s| s.mark).collect();
        assert_eq!(marks, [Mark::Start, Mark::Corner, Mark::Corner, Mark::Corner, Mark::End]);
    }

    #[test]
    fn a_line_that_runs_into_an_arc_does_not_make_the_spline_overshoot() {
        let arc = EllipticalArc::circular(Vec2::new(100.0, 5.0), 5.0, -std::f64::consts::FRAC_PI_2, 3.0);
        let smooth = stroke(vec![line([0.0, 0.0], [100.0, 0.0]), Piece::Arc(arc)]);
        assert!(worst(&smooth) < 0.003, "{}", worst(&smooth));
        let samples = Sampling::default().stroke(&smooth, 0);
        assert!(samples.len() < 60, "{}", samples.len());
        let spans: Vec<f64> = samples.windows(2).map(|w| (w[1].position - w[0].position).norm()).collect();
        assert!(spans.windows(2).all(|w| w[0] < 2.2 * w[1] && w[1] < 2.2 * w[0]), "{spans:?}");
    }

    #[test]
    fn splines_through_the_shipped_drawings_stay_within_a_hundredth_of_a_millimetre() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/drawings");
        let mut files: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(!files.is_empty());
        for file in files {
            let import = read_file(&file, Limits::default()).unwrap();
            for stroke in import.drawing.strokes.iter() {
                let worst = worst(stroke);
                assert!(worst < 0.005, "{}: {worst}", file.display());
            }
        }
    }

    #[test]
    fn corners_are_found_where_the_tangent_turns() {
        let pieces =
            vec![line([0.0, 0.0], [5.0, 0.0]), line([5.0, 0.0], [10.0, 0.1]), line([10.0, 0.1], [10.0, 9.0])];
        assert_eq!(Sampling::default().corners(&stroke(pieces)), vec![Vec3::new(10.0, 0.1, 0.0)]);
    }
}
