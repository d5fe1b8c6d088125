//! The planner: a ring of cells, a backward pass, and a walk in path time.

use super::cell::{CELLS_PER_SPAN, Cell, cut};
use super::trapezoid::CellTrapezoid;
use super::{FeedError, FeedLimits};
use crate::bspline::{PathSpan, Span, SpanEnd, SpanGeometry, parameter_at, parameter_at_plain};
use nalgebra::Vector3;

/// Spans may differ in position by this much where they meet \[m\]: rounding.
const GAP: f64 = 1e-9;

/// A point on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Position \[m\].
    pub position: Vector3<f64>,
    /// Unit tangent.
    pub tangent: Vector3<f64>,
    /// Curvature [1/m].
    pub curvature: f64,
    /// Length of the path so far \[m\].
    pub length: f64,
    /// Speed at full feed [m/s]; an operator's feed rate scales it.
    pub speed: f64,
}

/// The cell being travelled.
#[derive(Clone, Copy, Debug)]
struct Travel {
    cell: Cell,
    speeds: CellTrapezoid,
    /// Square of the speed at its end.
    exit2: f64,
    /// Time since its start.
    time: f64,
    /// Length and parameter of the point emitted last.
    s: f64,
    u: f64,
}

/// A feed planner over the next `HORIZON` (>= 32) cells; about `HORIZON` times 400 bytes, fixed.
#[derive(Clone, Debug)]
pub struct FeedPlanner<const HORIZON: usize = 64> {
    limits: FeedLimits,
    cells: [Cell; HORIZON],
    first: usize,
    count: usize,
    /// End and end tangent of the last span pushed, and whether motion rests there.
    tail: Option<(Vector3<f64>, Vector3<f64>, SpanEnd)>,
    travel: Option<Travel>,
    /// Length of the cells already left.
    length: f64,
    finished: bool,
    ended: bool,
}

impl<const HORIZON: usize> FeedPlanner<HORIZON> {
    const ROOMY: () = assert!(HORIZON >= 2 * CELLS_PER_SPAN, "a feed horizon must be 32 cells or more");

    /// A planner without a path.
    ///
    /// # Errors
    /// A limit out of range.
    pub fn new(limits: FeedLimits) -> Result<Self, FeedError> {
        const { Self::ROOMY };
        limits.validate()?;
        Ok(Self {
            limits,
            cells: [Cell::empty(); HORIZON],
            first: 0,
            count: 0,
            tail: None,
            travel: None,
            length: 0.0,
            finished: false,
            ended: false,
        })
    }

    /// Whether another span can be pushed.
    #[must_use]
    pub fn has_room(&self) -> bool {
        !self.finished && HORIZON - self.count >= CELLS_PER_SPAN
    }

    /// Takes the next span and plans with it.
    ///
    /// # Errors
    /// No room, or a gap to the span before.
    pub fn push(&mut self, path: PathSpan) -> Result<(), FeedError> {
        if !self.has_room() {
            return Err(FeedError::NotAsked);
        }
        let PathSpan { span, end } = path;
        let mut join2 = f64::INFINITY;
        if let Some((position, tangent, end)) = self.tail {
            let gap = (span.start() - position).norm();
            if gap.is_nan() || gap > GAP {
                return Err(FeedError::Gap(gap));
            }
            let kink = self.limits.speed_at_kink((span.at(0.0).tangent() - tangent).norm());
            join2 = if end == SpanEnd::Rest { 0.0 } else { kink * kink };
        }
        self.tail = Some((span.end(), span.at(span.knot_span()).tangent(), end));
        let before = self.count;
        let Self { cells, first, count, limits, .. } = self;
        cut(&span, limits, |cell| {
            cells[(*first + *count) % HORIZON] = cell;
            *count += 1;
        });
        let at = (self.first + before) % HORIZON;
        self.cells[at].join2 = join2.min(self.cells[at].limit2);
        for k in before.max(1)..self.count {
            let [earlier, later] = [k - 1, k].map(|k| (self.first + k) % HORIZON);
            let mut previous = self.cells[earlier];
            let mut cell = self.cells[later];
            cell.join2 = cell.join2.min(previous.limit2);
            previous.join(&mut cell, self.limits.feed);
            self.cells[earlier].top2 = previous.top2;
            self.cells[later] = cell;
        }
        if before == 0
            && let Some(travel) = &self.travel
        {
            let previous = travel.cell.limit2;
            self.cells[at].join2 = self.cells[at].join2.min(previous);
        }
        self.plan_backward(before);
        Ok(())
    }

    /// No more spans will come.
    pub fn finish(&mut self) {
        self.finished = true;
    }

    /// Whether the exact end of the path has been emitted, or there is no path.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.ended || (self.finished && self.travel.is_none() && self.count == 0)
    }

    /// Advances by `dt` \[s\] of path time, >= 0. The exact end is emitted once, at rest, then `None`. While spans are
    /// missing and [`Self::finish`] was not called, the last known point is emitted, at rest; before the first span,
    /// `None`.
    pub fn advance(&mut self, dt: f64) -> Option<PathPoint> {
        if self.ended {
            return None;
        }
        let mut left = dt;
        loop {
            let Some(travel) = &mut self.travel else {
                self.begin(0.0)?;
                continue;
            };
            let rest = travel.speeds.duration() - travel.time;
            if left < rest {
                travel.time += left;
                return Some(self.point());
            }
            let at_rest = travel.exit2 == 0.0;
            if self.count == 0 {
                travel.time = travel.speeds.duration();
                self.ended = self.finished;
                return Some(self.end_point());
            }
            let exit2 = travel.exit2;
            let length = travel.cell.length;
            // The sum of n increments may miss n * dt by rounding: nothing is lost while at rest.
            left = if at_rest && rest.abs() <= 1e-9 * dt { 0.0 } else { left - rest };
            self.length += length;
            self.begin(exit2)?;
        }
    }

    /// Plans from the newest cell backwards, until a cell whose plan does not change.
    fn plan_backward(&mut self, added: usize) {
        let mut exit2 = 0.0;
        for k in (0..self.count).rev() {
            let cell = &mut self.cells[(self.first + k) % HORIZON];
            let entry2 = cell.join2.min(exit2 + 2.0 * self.limits.tangential * cell.length);
            if k < added && entry2 == cell.entry2 {
                return;
            }
            cell.entry2 = entry2;
            exit2 = entry2;
        }
    }

    /// Starts the next cell at the given square of the speed; its exit is final from here on.
    fn begin(&mut self, entry2: f64) -> Option<()> {
        if self.count == 0 {
            return None;
        }
        let cell = self.cells[self.first];
        self.first = (self.first + 1) % HORIZON;
        self.count -= 1;
        let next = if self.count > 0 { self.cells[self.first].entry2 } else { 0.0 };
        let a = self.limits.tangential;
        let exit2 = next.min(entry2 + 2.0 * a * cell.length);
        let speeds = CellTrapezoid::new(entry2, exit2, cell.top2, cell.length, a);
        self.travel = Some(Travel { cell, speeds, exit2, time: 0.0, s: 0.0, u: cell.u[0] });
        Some(())
    }

    fn point(&mut self) -> PathPoint {
        let Some(travel) = &mut self.travel else { return self.end_point() };
        let (s, speed) = travel.speeds.at(travel.time);
        let s = s.clamp(travel.s, travel.cell.length);
        let span = &travel.cell.span;
        let end = travel.cell.u[1];
        let further = s - travel.s;
        travel.u = match &travel.cell.by_parameter {
            Some((table, start)) => table.parameter_at(start + s, travel.u),
            None if travel.cell.plain => parameter_at_plain(span, travel.u, end, further),
            None => parameter_at(span, travel.u, end, further),
        };
        travel.s = s;
        on_span(span, travel.u, self.length + s, speed)
    }

    fn end_point(&self) -> PathPoint {
        self.travel.as_ref().map_or_else(
            || on_span(&self.cells[self.first].span, 0.0, self.length, 0.0),
            |travel| on_span(&travel.cell.span, travel.cell.u[1], self.length + travel.cell.length, 0.0),
        )
    }
}

#[inline]
fn on_span(span: &Span, u: f64, length: f64, speed: f64) -> PathPoint {
    let position = span.position(u);
    let first = span.first(u);
    let at = SpanGeometry { position, first, second: span.second(u), third: Vector3::zeros() };
    PathPoint { position, tangent: at.tangent(), curvature: at.curvature(), length, speed }
}
