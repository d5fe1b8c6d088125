//! The moving segment itself: a window of points, pushed one at a time, and the spans that it completes.

use super::frozen::Frozen;
use super::window::slopes_of_chords;
use super::{EndCondition, Junction, Parametrisation, Part, PathSpan, Span, SpanEnd, SplinePoint};
use nalgebra::Vector3;
use thiserror::Error;

/// Smallest window \[points\].
pub const WINDOW_MIN: usize = 4;
/// Largest window \[points\].
pub const WINDOW_MAX: usize = 16;
/// Points nearer to each other than this \[m\] are one.
pub(super) const COINCIDENT: f64 = 1e-9;
/// Points must be nearer to the origin than this \[m\], along each axis: farther out, neighbours are rounded to [`COINCIDENT`]
/// and worse, and the powers that curvatures are made of overflow in the end.
const FARTHEST: f64 = 1e7;
/// Places of the arrays: the window moves down once in `PLACES - WINDOW_MAX` points.
const PLACES: usize = 4 * WINDOW_MAX;

/// How successive windows are tied together; see the table in [`super`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// Nothing is carried: every window has this condition at both ends. For comparison only: its joins have kinks.
    Literal(EndCondition),
    /// The slope reached is carried: C1.
    Interpolating,
    /// Slopes and second derivatives of `Interpolating`, joined by quintics: C2 and exact.
    #[default]
    C2,
    /// Control points are carried: a C2 cubic near the points.
    FrozenControlPoints,
}

/// Settings of a moving segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplineSettings {
    /// How windows are tied together.
    pub method: Method,
    /// How far apart the knots are.
    pub parametrisation: Parametrisation,
    /// Window \[points\], [`WINDOW_MIN`]..=[`WINDOW_MAX`].
    pub window: usize,
    /// Turn angle at a point above which it is a corner \[rad\], > 0, <= pi; at pi nothing is.
    pub corner: f64,
}

impl Default for SplineSettings {
    /// C2 over chord lengths, a window of 8 and corners above 30 degrees.
    fn default() -> Self {
        Self {
            method: Method::default(),
            parametrisation: Parametrisation::default(),
            window: 8,
            corner: std::f64::consts::FRAC_PI_6,
        }
    }
}

/// Why a spline cannot be set up or a point not be taken.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SplineError {
    /// The window is too small or too large.
    #[error("spline window of {0} points must lie in {WINDOW_MIN}..={WINDOW_MAX}")]
    Window(usize),
    /// The corner angle is not in 0..pi.
    #[error("corner angle {0} rad must be greater than 0 and at most pi")]
    Corner(f64),
    /// A coordinate is not a number, or farther out than 1e7 m.
    #[error("path point ({x}, {y}, {z}) m must be finite and within {FARTHEST} m")]
    Point {
        /// Coordinate \[m\].
        x: f64,
        /// Coordinate \[m\].
        y: f64,
        /// Coordinate \[m\].
        z: f64,
    },
    /// A point was pushed while spans were waiting, or after the end.
    #[error("a point was pushed although the spline did not ask for one")]
    NotAsked,
}

/// What a moving segment has to say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Poll {
    /// The next span.
    Span(PathSpan),
    /// Push a point or finish.
    NeedPoint,
    /// The path is over.
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Taking points into the window.
    Filling,
    /// The run is over; the point, if any, that follows its corner opens the next run.
    Draining(Option<SplinePoint>),
    Done,
}

/// A span of the C2 method that waits for the second derivative at its end.
#[derive(Clone, Copy, Debug)]
struct Held {
    start: [Vector3<f64>; 3],
    end: [Vector3<f64>; 2],
    h: f64,
    part: Part,
}

/// A window over a stream of points. About 4 kB, fixed.
#[derive(Clone, Debug)]
pub struct MovingSegment {
    settings: SplineSettings,
    corner_cosine: f64,
    /// The window is the `count` places from `first` on; it moves down when it reaches the end of the arrays.
    points: [Vector3<f64>; PLACES],
    chords: [Vector3<f64>; PLACES],
    h: [f64; PLACES],
    parts: [Part; PLACES],
    first: usize,
    count: usize,
    newest: Junction,
    phase: Phase,
    slope: Option<Vector3<f64>>,
    held: Option<Held>,
    frozen: Frozen,
}

impl MovingSegment {
    /// An empty window.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(settings: SplineSettings) -> Result<Self, SplineError> {
        if !(WINDOW_MIN..=WINDOW_MAX).contains(&settings.window) {
            return Err(SplineError::Window(settings.window));
        }
        if !(settings.corner > 0.0 && settings.corner <= std::f64::consts::PI) {
            return Err(SplineError::Corner(settings.corner));
        }
        Ok(Self {
            settings,
            corner_cosine: settings.corner.cos(),
            points: [Vector3::zeros(); PLACES],
            chords: [Vector3::zeros(); PLACES],
            h: [0.0; PLACES],
            parts: [Part::Drawn; PLACES],
            first: 0,
            count: 0,
            newest: Junction::Auto,
            phase: Phase::Filling,
            slope: None,
            held: None,
            frozen: Frozen::default(),
        })
    }

    /// Takes the next point. A point nearer than 1e-9 m to the one before is dropped; its corner mark is kept.
    ///
    /// # Errors
    /// A point that is not finite, or one that was not asked for.
    pub fn push(&mut self, point: SplinePoint) -> Result<(), SplineError> {
        let p = point.position;
        if !p.iter().all(|x| x.abs() <= FARTHEST) {
            return Err(SplineError::Point { x: p.x, y: p.y, z: p.z });
        }
        if self.phase != Phase::Filling || self.count == self.settings.window {
            return Err(SplineError::NotAsked);
        }
        if self.count > 0
            && (p - self.points[self.first + self.count - 1]).norm_squared() < COINCIDENT * COINCIDENT
        {
            if point.junction != Junction::Auto {
                self.newest = point.junction;
            }
        } else if self.turns_a_corner_towards(&p) {
            self.phase = Phase::Draining(Some(point));
        } else {
            self.append(point);
        }
        Ok(())
    }

    /// No more points will come.
    pub fn finish(&mut self) {
        if self.phase == Phase::Filling {
            self.phase = Phase::Draining(None);
        }
    }

    /// The next span, or what is missing for it.
    pub fn poll(&mut self) -> Poll {
        loop {
            let draining = match self.phase {
                Phase::Done => return Poll::Done,
                Phase::Filling if self.count < self.settings.window => return Poll::NeedPoint,
                Phase::Filling => false,
                Phase::Draining(_) => true,
            };
            let least = if self.settings.method == Method::FrozenControlPoints { 1 } else { 2 };
            let run_over = self.count < least;
            let complete = if run_over { self.flush() } else { self.step(draining) };
            if run_over {
                self.open_next_run();
            }
            if let Some((span, Part::Drawn, end)) = complete {
                return Poll::Span(PathSpan { span, end });
            }
        }
    }

    #[inline]
    fn turns_a_corner_towards(&self, next: &Vector3<f64>) -> bool {
        if self.count < 2 {
            return false;
        }
        let newest = self.first + self.count - 1;
        let here = self.points[newest];
        let before = here - self.points[newest - 1];
        let after = next - here;
        match self.newest {
            Junction::Smooth => false,
            Junction::Corner => true,
            Junction::Auto => {
                let cosine = before.dot(&after);
                // Exactly pi means that nothing is a corner, not even a reversal.
                self.corner_cosine > -1.0
                    && cosine < self.corner_cosine * (before.norm_squared() * after.norm_squared()).sqrt()
            }
        }
    }

    #[inline]
    fn append(&mut self, point: SplinePoint) {
        if self.first + self.count == PLACES {
            let window = self.first..;
            self.points.copy_within(window.clone(), 0);
            self.chords.copy_within(window.clone(), 0);
            self.h.copy_within(window.clone(), 0);
            self.parts.copy_within(window, 0);
            self.first = 0;
        }
        let place = self.first + self.count;
        if self.count > 0 {
            let newest = self.points[place - 1];
            let h = self.settings.parametrisation.knot_span(&newest, &point.position);
            self.h[place - 1] = h;
            self.chords[place - 1] = (point.position - newest) * (1.0 / h);
        }
        self.points[place] = point.position;
        self.parts[place] = point.part;
        self.newest = point.junction;
        self.count += 1;
    }

    /// Solves the window, shifts it by one point, and gives the span that this completes.
    fn step(&mut self, draining: bool) -> Option<(Span, Part, SpanEnd)> {
        let n = self.count;
        let at = self.first;
        let end = if draining && n == 2 { SpanEnd::Rest } else { SpanEnd::Continued };
        let complete = match self.settings.method {
            Method::FrozenControlPoints => self
                .frozen
                .step(&self.points[at..at + n], &self.h[at..at + n - 1], self.parts[at])
                .map(|(span, part)| (span, part, SpanEnd::Continued)),
            Method::Literal(ends) => {
                self.slopes(ends, ends).map(|(m0, m1)| (self.cubic(m0, m1), self.parts[at], end))
            }
            Method::Interpolating => {
                self.carried_slopes().map(|(m0, m1)| (self.cubic(m0, m1), self.parts[at], end))
            }
            Method::C2 => self.carried_slopes().and_then(|(m0, m1)| self.hold(m0, m1)),
        };
        // The last point of a run stays: it may be the corner that opens the next.
        if n > 1 {
            self.first += 1;
        }
        self.count -= 1;
        complete
    }

    #[inline]
    fn slopes(&self, start: EndCondition, end: EndCondition) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let spans = self.first..self.first + self.count - 1;
        let chords = &self.chords[spans.clone()];
        slopes_of_chords(&self.h[spans], |k| chords[k], start, end)
    }

    #[inline]
    fn carried_slopes(&mut self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let start = self.slope.map_or(EndCondition::Natural, EndCondition::Slope);
        let slopes = self.slopes(start, EndCondition::Natural)?;
        self.slope = Some(slopes.1);
        Some(slopes)
    }

    #[inline]
    fn cubic(&self, m0: Vector3<f64>, m1: Vector3<f64>) -> Span {
        let at = self.first;
        Span::cubic(self.points[at], self.points[at + 1], m0, m1, self.h[at])
    }

    /// Keeps the span with these slopes and completes the one before by the second derivative at its end.
    #[inline]
    fn hold(&mut self, m0: Vector3<f64>, m1: Vector3<f64>) -> Option<(Span, Part, SpanEnd)> {
        let at = self.first;
        let p0 = self.points[at];
        let p1 = self.points[at + 1];
        let h = self.h[at];
        let part = self.parts[at];
        let second = (self.chords[at] * 3.0 - m0 * 2.0 - m1) * (2.0 / h);
        let now = Held { start: [p0, m0, second], end: [p1, m1], h, part };
        let held = self.held.replace(now)?;
        Some((held.complete(second), held.part, SpanEnd::Continued))
    }

    /// What a method has held back when its run is over.
    fn flush(&mut self) -> Option<(Span, Part, SpanEnd)> {
        if let Some(held) = self.held.take() {
            return Some((held.complete(Vector3::zeros()), held.part, SpanEnd::Rest));
        }
        // The first place of the window still holds the last point of the run.
        let last = self.points[self.first];
        self.frozen.flush(last).map(|(span, part)| (span, part, SpanEnd::Rest))
    }

    /// The corner is the first point of the next run.
    fn open_next_run(&mut self) {
        let next = match std::mem::replace(&mut self.phase, Phase::Filling) {
            Phase::Draining(Some(next)) => next,
            Phase::Filling | Phase::Draining(None) | Phase::Done => {
                self.phase = Phase::Done;
                return;
            }
        };
        self.slope = None;
        self.frozen = Frozen::default();
        self.count = self.count.max(1);
        self.append(next);
    }
}

impl Held {
    #[inline]
    fn complete(&self, second: Vector3<f64>) -> Span {
        Span::quintic(self.start, [self.end[0], self.end[1], second], self.h)
    }
}
