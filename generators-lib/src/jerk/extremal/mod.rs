//! The farthest that an axis gets in a given time.
//!
//! Of all motions from `(v0, a0)` to `(v1, a1)` that take `T`, the one that ends farthest in the positive direction
//! speeds up to a peak velocity `v`, where the acceleration is 0, cruises if that is the limit `V`, and slows down:
//! jerk + 0 - 0 - 0 +. The state `(v0, a0)` lies on a ramp of jerk `J` that begins with no acceleration at
//! `b0 = v0 - a0^2 / 2J`, and `(v1, a1)` on one that ends with none at `b1 = v1 - a1^2 / 2J`, so that the two ramps are of one
//! kind, symmetric about their middles:
//!
//! ```text
//! T = t0 + t_c + t1 - a0 / J + a1 / J                   b + x^2 / J = v                  without a phase of
//! D = (b0 + v) t0 / 2 + V t_c + (v + b1) t1 / 2 - c     t = 2 x / J                      constant acceleration,
//! c = c(b0, a0) - c(b1, a1)                             t = (v - b) / A + A / J          with it
//! c(b, a) = b a / J + a^3 / 6 J^2
//! ```
//!
//! These motions form one curve, along which `T` grows; it is cut into pieces by what is held: nothing
//! ([`free`]), one acceleration ([`one_held`]), both ([`both_held`]), the velocity ([`cruising`]). On each, `T` is
//! inverted in closed form and `D` by Newton's iteration. Along the curve `D` may rise, fall and rise again: it is cut at
//! these turns as well, so that it passes a value once on a piece. The least `D` in a given time is that of the mirrored axis.
//!
//! Where the accelerations at both ends have one sign, a change of velocity in between may be possible without the acceleration
//! passing zero, or with much time for going past zero and back, but not in the times between: the curve then has two parts.

mod both_held;
mod cruising;
mod free;
mod one_held;
mod piece;

use super::profile::Phases;
use super::{AxisLimits, AxisState, AxisTarget};
use piece::{Kind, Piece, Value};

/// Most pieces of a curve: one acceleration held, none, none again, one, the other, both, the cruise; and three turns.
const PIECES: usize = 10;

/// Most intervals of durations in which a way is not reached.
const GAPS: usize = 4;

/// The curve of the farthest motions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremal {
    /// Accelerations at the start and at the target.
    ends: [f64; 2],
    limits: AxisLimits,
    /// Where the ramps begin, `b0`, and end, `b1`.
    bases: [f64; 2],
    first_is_higher: bool,
    /// `(a0 - a1) / J`, and `c` of the module.
    ahead: [f64; 2],
    pieces: [Piece; PIECES],
    count: usize,
    /// The first piece of the curve's second part, if it has two.
    second: usize,
    cut: bool,
}

/// A motion on the curve: which piece, and where on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    piece: usize,
    z: f64,
    /// Its duration \[s\].
    pub duration: f64,
}

/// Open intervals of durations, in order: where each begins, and the motion that ends it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gaps {
    pub items: [Option<(f64, Place)>; GAPS],
    count: usize,
}

impl Gaps {
    fn push(&mut self, from: f64, end: Place) {
        if self.count < GAPS {
            self.items[self.count] = Some((from, end));
            self.count += 1;
        }
    }
}

impl Extremal {
    /// From `start`, which the limits allow, to the velocity and acceleration of `target`; cut at the turns of the way, which
    /// only [`Self::gaps`] needs.
    pub fn new(start: &AxisState, target: &AxisTarget, limits: &AxisLimits, cut: bool) -> Self {
        let (j, v_max) = (limits.jerk, limits.max_velocity);
        let (a0, a1) = (start.acceleration, target.acceleration);
        let base = |v: f64, a: f64| v - 0.5 * a * a / j;
        let (b0, b1) = (base(start.velocity, a0), base(target.velocity, a1));
        let from_base = |b: f64, a: f64| (b + a * a / (6.0 * j)) * a / j;
        let ahead = [(a0 - a1) / j, from_base(b0, a0) - from_base(b1, a1)];
        let mut curve = Extremal {
            ends: [a0, a1],
            limits: *limits,
            bases: [b0, b1],
            first_is_higher: true,
            ahead,
            pieces: [Piece::default(); PIECES],
            count: 0,
            second: 0,
            cut,
        };
        // Differences of squares as small as the rounding of what they come from are none: their roots would not be small.
        // A start on the way to `b1` may bring the rounding of higher velocities along.
        let brought = (v_max - limits.min_velocity).min(1e3 * b1.abs());
        let rounding = 8.0 * f64::EPSILON * (a0 * a0 + a1 * a1 + j * (b0.abs() + b1.abs() + brought));
        let above = |square: f64| if square > rounding { square } else { 0.0 };
        let k = above(j * (b0 - b1).abs());
        if k == 0.0 {
            curve.bases[0] = b1;
        }
        // The ramp of the higher base is the smaller one, x, the other y = sqrt(x^2 + k).
        let accelerations = [limits.max_acceleration, -limits.min_acceleration];
        // Where both are equally high, as it suits a start and a target on one ramp.
        let first_is_higher = if k == 0.0 { a0 <= 0.0 } else { b0 > b1 };
        curve.first_is_higher = first_is_higher;
        let (higher, lower) = if first_is_higher { (0, 1) } else { (1, 0) };
        let (g, l) = (curve.bases[higher], curve.bases[lower]);
        let (a_g, a_l) = (accelerations[higher], accelerations[lower]);
        // The first ramp is at least `a0`, the second at least `-a1`: where `y` must be higher than from its base, `x` is at
        // least so high, or so low.
        let (edge_x, edge_y) = if first_is_higher { (a0, -a1) } else { (-a1, a0) };
        let raised = above(edge_y.max(0.0) * edge_y - k).sqrt();
        let low = (raised > 0.0 && edge_x < 0.0 && edge_x * edge_x + rounding >= raised * raised)
            .then_some(-raised);
        let from = if k == 0.0 { edge_x.max(0.0) } else { edge_x };
        let from = if raised > 0.0 { from.max(raised) } else { from };
        let x_cruise = (j * (v_max - g)).max(0.0).sqrt().max(from);
        let to = x_cruise.min(a_g).max(from);
        // Where y reaches its limit.
        let bend = if a_l * a_l > k { (a_l * a_l - k).sqrt() } else { -1.0 };
        let y_held = Kind::OneHeld { base: g, other: l, held: a_l, base_is_higher: true };
        let w = |x: f64| {
            let y = (x * x + k).sqrt();
            if x < 0.0 { k / (y - x) } else { x + y }
        };
        let free = Kind::Free { base: g, k };
        if let Some(low) = low {
            curve.push(y_held, edge_x, low.min(-bend), edge_x < -bend);
            curve.push(free, w(edge_x.max(-bend)), w(low), bend >= 0.0);
            curve.second = curve.count;
        }
        if from > a_g {
            // The ramp of the lower base leads so high that the other one is held throughout.
        } else if bend < 0.0 {
            curve.push(y_held, from, to, true);
        } else {
            curve.push(y_held, from, to.min(-bend), from < -bend);
            let (low, high) = (from.max(-bend), to.min(bend));
            curve.push(free, w(low), w(high), from <= bend);
            curve.push(y_held, from.max(bend), to, to > bend);
        }
        if x_cruise > a_g {
            let x = from.max(a_g);
            let (v_g, v_l) = (g + x * x / j, l + a_l * a_l / j);
            let y = |v: f64| (j * (v - l)).max(0.0).sqrt();
            let x_held = Kind::OneHeld { base: l, other: g, held: a_g, base_is_higher: false };
            curve.push(x_held, y(v_g), y(v_l.min(v_max)), v_g < v_l);
            let both = Kind::BothHeld { bases: [g, l], held: [a_g, a_l] };
            curve.push(both, v_g.max(v_l), v_max, v_l < v_max || curve.count == curve.second);
        }
        let last = curve.pieces[curve.count - 1].to_value;
        curve.push(Kind::Cruising { velocity: v_max, before: last }, 0.0, f64::INFINITY, true);
        curve
    }

    /// Adds a piece, cut where the way turns.
    fn push(&mut self, kind: Kind, from: f64, to: f64, exists: bool) {
        if !exists {
            return;
        }
        let mut from = from;
        let to = to.max(from);
        let turns = if self.cut { Piece::turns(&kind, self.limits.jerk) } else { [f64::NAN; 2] };
        for cut in turns.into_iter().chain([to]) {
            // All room is needed only where rounding makes more turns than there are.
            let last = cut == to || self.count + 2 >= PIECES;
            if last || (cut > from && cut < to) {
                let end = if last { to } else { cut };
                let before = self.pieces[self.second..self.count].last().map(|piece| piece.to_value);
                self.pieces[self.count] = Piece::new(kind, from, end, self.limits.jerk, before.as_ref());
                self.count += 1;
                from = end;
            }
            if last {
                return;
            }
        }
    }

    fn pieces(&self) -> &[Piece] {
        &self.pieces[..self.count]
    }

    fn first(&self) -> &Value {
        &self.pieces[0].from_value
    }

    /// The way \[m\] in the shortest duration to the velocity alone.
    pub fn least_way(&self) -> f64 {
        self.first().way - self.ahead[1]
    }

    fn place(&self, piece: usize, z: f64) -> Place {
        let time = self.pieces[piece].value(z, self.limits.jerk).time;
        Place { piece, z, duration: (time - self.ahead[0]).max(0.0) }
    }

    /// The beginning of the curve: the fastest change of velocity.
    pub fn beginning(&self) -> Place {
        self.place(0, self.pieces[0].from)
    }

    /// The durations in which the farthest motion gets less far than `way` \[m\]; where the beginning is known to get
    /// `there`, not the shortest one.
    pub fn gaps(&self, way: f64, there: bool) -> Gaps {
        let target = way + self.ahead[1];
        let target = if there { target.min(self.first().way) } else { target };
        let mut gaps = Gaps::default();
        let mut below = (self.first().way < target).then_some(f64::NEG_INFINITY);
        for (i, piece) in self.pieces().iter().enumerate() {
            if i > 0 && i == self.second {
                let before = self.pieces[i - 1].to;
                let from = below.unwrap_or_else(|| self.place(i - 1, before).duration);
                below = Some(from);
                if piece.from_value.way >= target {
                    gaps.push(from, self.place(i, piece.from));
                    below = None;
                }
            }
            let ends_below = piece.to_value.way < target;
            if ends_below == below.is_some() {
                continue;
            }
            let crossing = self.place(i, piece.crossing(target, self.limits.jerk));
            match below {
                None => below = Some(crossing.duration),
                Some(from) => {
                    gaps.push(from, crossing);
                    below = None;
                }
            }
        }
        gaps
    }

    /// The farthest motion that lasts `duration` \[s\], at least that of [`Self::beginning`].
    pub fn lasting(&self, duration: f64) -> Place {
        let time = duration + self.ahead[0];
        let piece =
            self.pieces().iter().position(|piece| piece.to_value.time >= time).unwrap_or(self.count - 1);
        Place { piece, z: self.pieces[piece].at_time(time, self.limits.jerk), duration }
    }

    /// The motion itself, as phases of a duration and a jerk each; `direction` 1, or -1 for the mirrored axis.
    pub fn phases(&self, place: &Place, direction: f64) -> Phases {
        let j = self.limits.jerk;
        let (peak, cruise) = self.pieces[place.piece].peak(place.z, j);
        let accelerations = [self.limits.max_acceleration, -self.limits.min_acceleration];
        let heights = self.pieces[place.piece].heights(place.z);
        let ramp = |side: usize| {
            let (a, rise) = (accelerations[side], (peak - self.bases[side]).max(0.0));
            match heights[if self.first_is_higher { side } else { 1 - side }] {
                Some(height) => (height, 0.0),
                None if j * rise < a * a => ((j * rise).sqrt(), 0.0),
                None => (a, (rise / a - a / j).max(0.0)),
            }
        };
        let ((up, up_held), (down, down_held)) = (ramp(0), ramp(1));
        // Where the acceleration never is 0, the two middle phases of one jerk are one.
        let (up_end, down_begin) = if up < 0.0 || down < 0.0 { (up + down, 0.0) } else { (up, down) };
        let signed = j * direction;
        let (mut first, mut last) = ((up - self.ends[0]) / j, (down + self.ends[1]) / j);
        // Both ends are on one ramp.
        if up == 0.0 && down == 0.0 && cruise == 0.0 {
            (first, last) = (first + last, 0.0);
        }
        [
            (first, signed),
            (up_held, 0.0),
            (up_end / j, -signed),
            (cruise, 0.0),
            (down_begin / j, -signed),
            (down_held, 0.0),
            (last, signed),
        ]
    }
}
