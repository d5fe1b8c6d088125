//! How far executed points lie from the drawing: a cursor that moves along the exact stroke.
//!
//! Distances are those of the tool's tip in space, its depth included. Each stroke is flattened to 0.2 µm, so that a distance is exact to less than 0.5 µm. The cursor advances along the
//! stroke about as far as the tool moved: at a cusp it goes on to the stroke back, instead of turning back itself, and
//! where two parts of a stroke come close it stays on its own. If it ends far away, it searches wider, and then the
//! whole stroke. It also searches the whole stroke before a new maximum counts: no point is called far from the drawing
//! because the cursor went on along another part.

use crate::drawing::{Drawing, Stroke, Vec3};
use crate::sampling::Sampling;

/// Flattening of the strokes \[mm\].
const FLATTENING: f64 = 2e-4;

/// Beyond this distance the search goes [`WIDE`] in both directions \[mm\].
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
    from: Vec3,
    along: Vec3,
    /// 1 / |along|².
    inverse: f64,
    /// Length of the stroke before it \[mm\].
    before: f64,
}

impl Segment {
    /// From the start to a tip, where the stroke's height 0 is at `surface` \[mm\].
    fn gap(&self, p: Vec3, surface: f64) -> Vec3 {
        Vec3::new(p.x - self.from.x, p.y - self.from.y, p.z - (surface + self.from.z))
    }

    fn squared_distance(&self, p: Vec3, surface: f64) -> f64 {
        let gap = self.gap(p, surface);
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
    pub position: Vec3,
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
    /// The height of strokes that are level \[mm\].
    levels: Vec<Option<f64>>,
    corners: Vec<Vec<Vec3>>,
    except_squared: f64,
    stroke: usize,
    /// Height of the plate's surface in the frame of the points \[mm\].
    surface: f64,
    cursor: usize,
    latest: Option<Vec3>,
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
            levels: drawing.strokes.iter().map(level).collect(),
            corners: excepted_corners,
            except_squared,
            stroke: 0,
            surface: 0.0,
            cursor: 0,
            latest: None,
            sum_of_squares: 0.0,
            max_squared: 0.0,
            points: 0,
            excepted: 0,
            worst: None,
        }
    }

    /// The tool comes down at the start of a stroke: the cursor goes there. The plate's surface, the strokes' height 0,
    /// is at the height `surface` \[mm\] in the frame of the points.
    pub fn begin_stroke(&mut self, stroke: usize, surface: f64) {
        self.stroke = stroke;
        self.surface = surface;
        self.cursor = 0;
        self.latest = None;
    }

    /// Measures one executed tip of the present stroke \[mm\]; its distance from the stroke \[mm\], 0 if there is no such
    /// stroke.
    pub fn observe(&mut self, p: Vec3) -> f64 {
        let Some(segments) = self.strokes.get(self.stroke).filter(|s| !s.is_empty()) else { return 0.0 };
        let surface = self.surface;
        // Which part of a level stroke is nearest, the tip's height does not say: it is looked for in the plane.
        let (p, off_level) = match self.levels[self.stroke] {
            Some(level) => (Vec3::new(p.x, p.y, surface + level), p.z - (surface + level)),
            None => (p, 0.0),
        };
        let moved = self.latest.map_or(0.0, |latest| (p - latest).norm());
        self.latest = Some(p);
        let mut best = nearest_around(segments, self.cursor, SLACK, 1.5 * moved + SLACK, (p, surface));
        if best.1 > FAR * FAR {
            best = nearest_around(segments, best.0, WIDE, WIDE, (p, surface));
        }
        let record = best.1 > self.max_squared && best.1 > TRUSTED * TRUSTED;
        if record || best.1 > LOST * LOST {
            let anywhere = nearest_around(segments, 0, 0.0, f64::INFINITY, (p, surface));
            if anywhere.1 < best.1 {
                best = anywhere;
            }
        }
        self.cursor = best.0;
        let squared = best.1 + off_level * off_level;
        if self.corners[self.stroke].iter().any(|c| (c.xy() - p.xy()).norm_squared() < self.except_squared) {
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

/// The height of a stroke that has one.
fn level(stroke: &Stroke) -> Option<f64> {
    let (low, high) = stroke.height_range();
    (low == high).then_some(low)
}

fn segments(stroke: &Stroke) -> Vec<Segment> {
    let points = stroke.flattened_tips(FLATTENING);
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

/// The nearest segment to a tip over a surface, within the lengths `back` and `ahead` \[mm\] of the cursor, and the squared
/// distance \[mm²\].
fn nearest_around(
    segments: &[Segment],
    cursor: usize,
    back: f64,
    ahead: f64,
    at: (Vec3, f64),
) -> (usize, f64) {
    let (p, surface) = at;
    let here = &segments[cursor];
    let mut best = (cursor, here.squared_distance(p, surface));
    // How far along the present segment the point is: the window begins there.
    let along = here.gap(p, surface).dot(&here.along) * here.inverse;
    let at = here.before + here.along.norm() * along.clamp(0.0, 1.0);
    for (i, segment) in segments.iter().enumerate().skip(cursor + 1) {
        if segment.before > at + ahead {
            break;
        }
        let d = segment.squared_distance(p, surface);
        if d < best.1 {
            best = (i, d);
        }
    }
    for i in (0..cursor).rev() {
        if segments[i + 1].before < at - back {
            break;
        }
        let d = segments[i].squared_distance(p, surface);
        if d < best.1 {
            best = (i, d);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{EllipticalArc, Height, Manner, Piece, Vec2};

    fn circle() -> Drawing {
        let arc = EllipticalArc::circular(Vec2::zeros(), 10.0, 0.0, std::f64::consts::TAU);
        Drawing { strokes: vec![Stroke::new(vec![Piece::Arc(arc)]).unwrap()] }
    }

    #[test]
    fn distances_from_a_circle_are_exact_to_half_a_micrometre() {
        let mut deviation = Deviation::new(&circle(), &Sampling::default(), Corners::Counted);
        deviation.begin_stroke(0, 0.0);
        let mut squares = 0.0;
        for k in 0..5000 {
            let a = f64::from(k) / 5000.0 * 6.25;
            let off = 0.01 * (a * 9.0).sin();
            let found = deviation.observe(Vec3::new(a.cos(), a.sin(), 0.0) * (10.0 + off));
            assert!((found - off.abs()).abs() < 5e-4, "{found} for {off}");
            squares += off * off;
        }
        let report = deviation.report();
        assert!((report.max - 0.01).abs() < 5e-4);
        assert!((report.rms - (squares / 5000.0f64).sqrt()).abs() < 3e-4);
    }

    #[test]
    fn a_lost_cursor_finds_its_place() {
        let mut deviation = Deviation::new(&circle(), &Sampling::default(), Corners::Counted);
        assert!(deviation.observe(Vec3::new(-10.0, 0.0, 0.0)) < 5e-4);
        assert!((deviation.observe(Vec3::new(0.0, 10.3, 0.0)) - 0.3).abs() < 5e-4);
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
            assert!(deviation.observe(stroke.tip(f64::from(k) / 200.0)) < 1e-9);
        }
        assert_eq!(deviation.cursor, 1);
    }

    #[test]
    fn a_stroke_that_goes_back_over_itself_and_off_sideways_is_not_far_away() {
        let line = |a: [f64; 2], b: [f64; 2]| Piece::Line { from: a.into(), to: b.into() };
        let corners = [[0.0, 0.0], [9.0, 0.0], [2.0, 0.0], [2.0, 5.0]];
        let stroke = Stroke::new(corners.windows(2).map(|w| line(w[0], w[1])).collect()).unwrap();
        let mut deviation =
            Deviation::new(&Drawing { strokes: vec![stroke] }, &Sampling::default(), Corners::Counted);
        // The tool turns back 0.1 mm before the tip, as a tool that lags behind does.
        let executed = [[0.0, 0.0], [8.9, 0.0], [2.0, 0.0], [2.0, 5.0]];
        for w in executed.windows(2) {
            for k in 0..=500 {
                let t = f64::from(k) / 500.0;
                let p = Vec2::from(w[0]) * (1.0 - t) + Vec2::from(w[1]) * t;
                deviation.observe(Vec3::new(p.x, p.y, 0.0));
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
        assert!((deviation.observe(Vec3::new(4.9, 0.1, 0.0)) - 0.1).abs() < 1e-9);
        assert_eq!((deviation.report().points, deviation.report().excepted), (0, 1));
        deviation.observe(Vec3::new(5.0, 3.0, 0.0));
        assert_eq!(deviation.report().points, 1);
    }

    #[test]
    fn a_helix_is_measured_in_space() {
        let pieces = vec![(
            Piece::Arc(EllipticalArc::circular(Vec2::zeros(), 10.0, 0.0, 3.0 * std::f64::consts::TAU)),
            Height::Linear { from: 0.0, to: -3.0 },
        )];
        let helix = Stroke::with_heights(pieces, Manner::default()).unwrap();
        // The length of a helix: turns times the hypotenuse of circumference and pitch.
        let length = 3.0 * (20.0 * std::f64::consts::PI).hypot(1.0);
        assert!((helix.length() - length).abs() < 1e-6);
        let mut deviation =
            Deviation::new(&Drawing { strokes: vec![helix] }, &Sampling::default(), Corners::Counted);
        deviation.begin_stroke(0, -1.7);
        for k in 0..=20_000 {
            let turn = f64::from(k) / 20_000.0;
            let a = turn * 3.0 * std::f64::consts::TAU;
            let tip = Vec3::new(10.0 * a.cos(), 10.0 * a.sin(), -1.7 - 3.0 * turn);
            assert!(deviation.observe(tip) < 1e-3);
            // Above or below the next turn is 1 mm away, and so it is where the tip is too high by 0.02 mm.
            assert!((deviation.observe(tip + Vec3::new(0.0, 0.0, 0.02)) - 0.02).abs() < 1e-3);
        }
    }
}
