//! How far executed points lie from the drawing: a cursor that moves along the exact stroke.
//!
//! Each stroke is flattened to 0.2 µm, so that a distance is exact to less than 0.5 µm. The cursor advances along the
//! stroke about as far as the tool moved: at a cusp it goes on to the way back, instead of turning back itself, and
//! where two parts of a stroke come close it stays on its own. If it ends far away, it searches wider, and then the
//! whole stroke. It also searches the whole stroke before a new maximum counts: no point is called far from the drawing
//! because the cursor went on along another part.

use crate::drawing::{Drawing, Stroke, Vec2};
use crate::sampling::Sampling;

/// Flattening of the strokes \[mm\].
const FLATTENING: f64 = 2e-4;

/// Beyond this distance the search goes [`WIDE`] both ways \[mm\].
const FAR: f64 = 0.05;

/// Half the width of the wider search along the stroke \[mm\].
const WIDE: f64 = 3.0;

/// Beyond this distance the whole stroke is searched \[mm\].
const LOST: f64 = 0.5;

/// Up to this distance a new maximum counts as it is \[mm\].
const TRUSTED: f64 = 0.004;

/// What the cursor may go ahead and back beyond the tool's own movement \[mm\].
const SLACK: f64 = 0.02;

/// Where points near marked corners are measured, too.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Corners {
    /// They count as all others.
    #[default]
    Counted,
    /// Points within this radius \[mm\] of a corner of the drawing are measured, but not counted.
    Excepted {
        /// Radius \[mm\], > 0.
        radius: f64,
    },
}

/// A segment of a flattened stroke.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: Vec2,
    along: Vec2,
    /// 1 / |along|².
    inverse: f64,
    /// Length of the stroke before it \[mm\].
    before: f64,
}

impl Segment {
    fn squared_distance(&self, p: Vec2) -> f64 {
        let gap = p - self.from;
        let t = (gap.dot(&self.along) * self.inverse).clamp(0.0, 1.0);
        (gap - self.along * t).norm_squared()
    }
}

/// The worst point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Its stroke.
    pub stroke: usize,
    /// Where it was executed \[mm\].
    pub position: Vec2,
    /// Its distance from the drawing \[mm\].
    pub distance: f64,
}

/// What was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviationReport {
    /// The largest distance \[mm\].
    pub max: f64,
    /// The root of the mean square \[mm\].
    pub rms: f64,
    /// The points that count.
    pub points: u64,
    /// The points near corners that do not count.
    pub excepted: u64,
    /// The worst point that counts.
    pub worst: Option<Worst>,
}

/// Measures executed points against a drawing.
#[derive(Clone, Debug)]
pub struct Deviation {
    strokes: Vec<Vec<Segment>>,
    corners: Vec<Vec<Vec2>>,
    except_squared: f64,
    stroke: usize,
    cursor: usize,
    latest: Option<Vec2>,
    sum_of_squares: f64,
    max_squared: f64,
    points: u64,
    excepted: u64,
    worst: Option<Worst>,
}

impl Deviation {
    /// Measures against the drawing, whose corners are those of the sampling.
    #[must_use]
    pub fn new(drawing: &Drawing, sampling: &Sampling, corners: Corners) -> Self {
        let (except_squared, excepted_corners) = match corners {
            Corners::Counted => (0.0, vec![Vec::new(); drawing.strokes.len()]),
            Corners::Excepted { radius } => {
                (radius * radius, drawing.strokes.iter().map(|s| sampling.corners(s)).collect())
            }
        };
        Self {
            strokes: drawing.strokes.iter().map(segments).collect(),
            corners: excepted_corners,
            except_squared,
            stroke: 0,
            cursor: 0,
            latest: None,
            sum_of_squares: 0.0,
            max_squared: 0.0,
            points: 0,
            excepted: 0,
            worst: None,
        }
    }

    /// The tool comes down at the start of a stroke: the cursor goes there.
    pub fn begin_stroke(&mut self, stroke: usize) {
        self.stroke = stroke;
        self.cursor = 0;
        self.latest = None;
    }

    /// Measures one executed point of the present stroke: its place over the plate and its error in depth \[mm\]; its
    /// distance from the stroke \[mm\], 0 if there is no such stroke.
    pub fn observe(&mut self, p: Vec2, depth_error: f64) -> f64 {
        let Some(segments) = self.strokes.get(self.stroke).filter(|s| !s.is_empty()) else { return 0.0 };
        let moved = self.latest.map_or(0.0, |latest| (p - latest).norm());
        self.latest = Some(p);
        let mut best = nearest_around(segments, self.cursor, SLACK, 1.5 * moved + SLACK, p);
        if best.1 > FAR * FAR {
            best = nearest_around(segments, best.0, WIDE, WIDE, p);
        }
        let record = best.1 > self.max_squared && best.1 > TRUSTED * TRUSTED;
        if record || best.1 > LOST * LOST {
            let anywhere = nearest_around(segments, 0, 0.0, f64::INFINITY, p);
            if anywhere.1 < best.1 {
                best = anywhere;
            }
        }
        self.cursor = best.0;
        let squared = best.1 + depth_error * depth_error;
        if self.corners[self.stroke].iter().any(|c| (c - p).norm_squared() < self.except_squared) {
            self.excepted += 1;
            return squared.sqrt();
        }
        self.points += 1;
        self.sum_of_squares += squared;
        if squared > self.max_squared || self.worst.is_none() {
            self.max_squared = squared;
            self.worst = Some(Worst { stroke: self.stroke, position: p, distance: squared.sqrt() });
        }
        squared.sqrt()
    }

    /// What was measured so far.
    #[must_use]
    pub fn report(&self) -> DeviationReport {
        DeviationReport {
            max: self.max_squared.sqrt(),
            rms: if self.points == 0 { 0.0 } else { (self.sum_of_squares / self.points as f64).sqrt() },
            points: self.points,
            excepted: self.excepted,
            worst: self.worst,
        }
    }
}

fn segments(stroke: &Stroke) -> Vec<Segment> {
    let points = stroke.flattened(FLATTENING);
    let mut before = 0.0;
    let mut segments = Vec::with_capacity(points.len());
    for w in points.windows(2) {
        let along = w[1] - w[0];
        let squared = along.norm_squared();
        if squared > 0.0 {
            segments.push(Segment { from: w[0], along, inverse: 1.0 / squared, before });
            before += squared.sqrt();
        }
    }
    segments
}

/// The nearest segment within the lengths `back` and `ahead` \[mm\] of the cursor, and the squared distance \[mm²\].
fn nearest_around(segments: &[Segment], cursor: usize, back: f64, ahead: f64, p: Vec2) -> (usize, f64) {
    let here = &segments[cursor];
    let mut best = (cursor, here.squared_distance(p));
    // How far along the present segment the point is: the window begins there.
    let along = (p - here.from).dot(&here.along) * here.inverse;
    let at = here.before + here.along.norm() * along.clamp(0.0, 1.0);
    for (i, segment) in segments.iter().enumerate().skip(cursor + 1) {
        if segment.before > at + ahead {
            break;
        }
        let d = segment.squared_distance(p);
        if d < best.1 {
            best = (i, d);
        }
    }
    for i in (0..cursor).rev() {
        if segments[i + 1].before < at - back {
            break;
        }
        let d = segments[i].squared_distance(p);
        if d < best.1 {
            best = (i, d);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{EllipticalArc, Piece};

    fn circle() -> Drawing {
        let arc = EllipticalArc::circular(Vec2::zeros(), 10.0, 0.0, std::f64::consts::TAU);
        Drawing { strokes: vec![Stroke::new(vec![Piece::Arc(arc)]).unwrap()] }
    }

    #[test]
    fn distances_from_a_circle_are_exact_to_half_a_micrometre() {
        let mut deviation = Deviation::new(&circle(), &Sampling::default(), Corners::Counted);
        deviation.begin_stroke(0);
        let mut squares = 0.0;
        for k in 0..5000 {
            let a = f64::from(k) / 5000.0 * 6.25;
            let off = 0.01 * (a * 9.0).sin();
            let found = deviation.observe(Vec2::new(a.cos(), a.sin()) * (10.0 + off), 0.0);
            assert!((found - off.abs()).abs() < 5e-4, "{found} for {off}");
            squares += off * off;
        }
        let report = deviation.report();
        assert!((report.max - 0.01).abs() < 5e-4);
        assert!((report.rms - (squares / 5000.0f64).sqrt()).abs() < 3e-4);
    }

    #[test]
    fn a_lost_cursor_finds_its_way() {
        let mut deviation = Deviation::new(&circle(), &Sampling::default(), Corners::Counted);
        assert!(deviation.observe(Vec2::new(-10.0, 0.0), 0.0) < 5e-4);
        assert!((deviation.observe(Vec2::new(0.0, 10.3), 0.0) - 0.3).abs() < 5e-4);
    }

    #[test]
    fn the_cursor_follows_a_narrow_spike_forth_and_back() {
        let line = |a: [f64; 2], b: [f64; 2]| Piece::Line { from: a.into(), to: b.into() };
        let stroke = Stroke::new(vec![line([0.0, 0.0], [9.0, 0.0]), line([9.0, 0.0], [0.0, 1.0])]).unwrap();
        let mut deviation = Deviation::new(
            &Drawing { strokes: vec![stroke.clone()] },
            &Sampling::default(),
            Corners::Counted,
        );
        for k in 0..=400 {
            assert!(deviation.observe(stroke.point(f64::from(k) / 200.0), 0.0) < 1e-9);
        }
        assert_eq!(deviation.cursor, 1);
    }

    #[test]
    fn a_stroke_that_goes_back_over_itself_and_off_sideways_is_not_far_away() {
        let line = |a: [f64; 2], b: [f64; 2]| Piece::Line { from: a.into(), to: b.into() };
        let way = [[0.0, 0.0], [9.0, 0.0], [2.0, 0.0], [2.0, 5.0]];
        let stroke = Stroke::new(way.windows(2).map(|w| line(w[0], w[1])).collect()).unwrap();
        let mut deviation =
            Deviation::new(&Drawing { strokes: vec![stroke] }, &Sampling::default(), Corners::Counted);
        // The tool turns back 0.1 mm before the tip, as a tool that lags behind does.
        let executed = [[0.0, 0.0], [8.9, 0.0], [2.0, 0.0], [2.0, 5.0]];
        for w in executed.windows(2) {
            for k in 0..=500 {
                let t = f64::from(k) / 500.0;
                deviation.observe(Vec2::from(w[0]) * (1.0 - t) + Vec2::from(w[1]) * t, 0.0);
            }
        }
        assert!(deviation.report().max < 1e-2, "{}", deviation.report().max);
    }

    #[test]
    fn corners_can_be_excepted() {
        let line = |a: [f64; 2], b: [f64; 2]| Piece::Line { from: a.into(), to: b.into() };
        let stroke = Stroke::new(vec![line([0.0, 0.0], [5.0, 0.0]), line([5.0, 0.0], [5.0, 5.0])]).unwrap();
        let drawing = Drawing { strokes: vec![stroke] };
        let mut deviation = Deviation::new(&drawing, &Sampling::default(), Corners::Excepted { radius: 0.5 });
        assert!((deviation.observe(Vec2::new(4.9, 0.1), 0.0) - 0.1).abs() < 1e-9);
        assert_eq!((deviation.report().points, deviation.report().excepted), (0, 1));
        deviation.observe(Vec2::new(5.0, 3.0), 0.0);
        assert_eq!(deviation.report().points, 1);
    }
}
