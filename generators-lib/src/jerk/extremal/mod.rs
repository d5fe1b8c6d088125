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
//! ([`free`]), one acceleration ([`one_held`]), both ([`both_held`]), the velocity. On each, `T` is
//! inverted in closed form and `D` by Newton's iteration. Along the curve `D` may rise, fall and rise again: a piece is cut at
//! these turns, so that it passes a value once between them. From where `x >= 0` and `v >= 0` on it rises to the end. The
//! least `D` in a given time is that of the mirrored axis.
//!
//! Where the accelerations at both ends have one sign, a change of velocity in between may be possible without the acceleration
//! passing zero, or with much time for going past zero and back, but not in the times between: the curve then has two parts.

mod both_held;
mod free;
mod one_held;
mod piece;
mod value;

use super::profile::{Phase, Phases};
use super::{AxisLimits, AxisState, AxisTarget};
use piece::{Held, Piece, Ramps};
use value::Value;

/// Most intervals of durations in which a displacement is not reached.
const GAPS: usize = 4;

/// Places for pieces: with one acceleration, none, none again, one, the other, both, the cruise; the first two may be
/// a part of their own.
const STAGES: usize = 8;

/// The first place of the curve's last part.
const LAST_PART: usize = 2;

/// The curve of the farthest motions: what its pieces, which are made when they are needed, are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremal {
    /// Accelerations at the start and at the target.
    ends: [f64; 2],
    /// Those that are held on the first and on the second ramp, > 0.
    accelerations: [f64; 2],
    /// Where the ramps begin, `b0`, and end, `b1`.
    bases: [f64; 2],
    first_is_higher: bool,
    /// `(a0 - a1) / J`, and `c` of the module.
    ahead: [f64; 2],
    ramps: Ramps,
    /// Peak accelerations `x` [m/s^2] of the ramp at the higher base. Where the first of two parts begins and ends.
    early: Option<[f64; 2]>,
    /// Where the last part begins.
    from: f64,
    /// Where on it that acceleration or the velocity is held.
    to: f64,
    /// Where the velocity is.
    cruises: f64,
    /// Where the acceleration of the other ramp is; below 0 if it is throughout.
    bend: f64,
    /// From where on the displacement rises.
    rises: f64,
    /// The first piece, and its beginning.
    first: (usize, Piece, Value),
}

/// A motion on the curve: what is held, and where on that piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    held: Held,
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
    /// From `start`, which the limits allow, to the velocity and acceleration of `target`.
    #[inline]
    pub fn new(start: &AxisState, target: &AxisTarget, limits: &AxisLimits) -> Self {
        let j = limits.jerk;
        let v_max = limits.max_velocity;
        let per_j = 1.0 / j;
        let a0 = start.acceleration;
        let a1 = target.acceleration;
        let base = |v: f64, a: f64| v - 0.5 * a * a * per_j;
        let b0 = base(start.velocity, a0);
        let b1 = base(target.velocity, a1);
        let from_base = |b: f64, a: f64| (b + a * a * per_j * (1.0 / 6.0)) * a * per_j;
        let ahead = [(a0 - a1) * per_j, from_base(b0, a0) - from_base(b1, a1)];
        // A difference of squares as small as the rounding of the squares counts as 0: its root would not be small.
        // A start on the ramp to `b1` may bring the rounding of higher velocities along.
        let brought = (v_max - limits.min_velocity).min(1e3 * b1.abs());
        let rounding = 8.0 * f64::EPSILON * (a0 * a0 + a1 * a1 + j * (b0.abs() + b1.abs() + brought));
        let above = |square: f64| if square > rounding { square } else { 0.0 };
        let k = above(j * (b0 - b1).abs());
        let bases = if k == 0.0 { [b1, b1] } else { [b0, b1] };
        // The ramp of the higher base is the smaller one, x, the other y = sqrt(x^2 + k).
        let accelerations = [limits.max_acceleration, -limits.min_acceleration];
        // Where both are equally high, as it suits a start and a target on one ramp.
        let first_is_higher = if k == 0.0 { a0 <= 0.0 } else { b0 > b1 };
        let (higher, lower) = if first_is_higher { (0, 1) } else { (1, 0) };
        let g = bases[higher];
        let l = bases[lower];
        let a_g = accelerations[higher];
        let a_l = accelerations[lower];
        // The first ramp is at least `a0`, the second at least `-a1`: where `y` must be higher than from its base, `x` is at
        // least so high, or so low.
        let (edge_x, edge_y) = if first_is_higher { (a0, -a1) } else { (-a1, a0) };
        let raised = above(edge_y.max(0.0) * edge_y - k).sqrt();
        let early = (raised > 0.0 && edge_x < 0.0 && edge_x * edge_x + rounding >= raised * raised)
            .then_some([edge_x, -raised]);
        let from = if k == 0.0 { edge_x.max(0.0) } else { edge_x };
        let from = if raised > 0.0 { from.max(raised) } else { from };
        let cruises = (j * (v_max - g)).max(0.0).sqrt().max(from);
        let ramps =
            Ramps { higher: g, lower: l, k, held_higher: a_g, held_lower: a_l, fastest: v_max, j, per_j };
        let nothing = Piece { held: Held::Nothing, from: 0.0, to: 0.0 };
        let mut curve = Extremal {
            ends: [a0, a1],
            accelerations,
            bases,
            first_is_higher,
            ahead,
            ramps,
            early,
            from,
            to: cruises.min(a_g).max(from),
            cruises,
            // Where y reaches its limit.
            bend: if a_l * a_l > k { (a_l * a_l - k).sqrt() } else { -1.0 },
            rises: (-j * g).max(0.0).sqrt(),
            first: (0, nothing, Value::default()),
        };
        for stage in 0..STAGES {
            if let Some(piece) = curve.piece(stage) {
                curve.first = (stage, piece, curve.ramps.value(piece.held, piece.from));
                break;
            }
        }
        curve
    }

    /// The piece at a place, if there is one.
    #[inline]
    fn piece(&self, stage: usize) -> Option<Piece> {
        let Extremal { from, to, cruises, bend, .. } = *self;
        let Ramps { higher: g, lower: l, k, held_higher: a_g, held_lower: a_l, fastest, j, per_j } =
            self.ramps;
        let bends = bend >= 0.0;
        // The ramp of the lower base leads so high that the other one is held throughout.
        let held = from > a_g;
        let sum = |x: f64| free::sum(x, k);
        let (kind, exists, from, to) = match stage {
            0 | 1 => {
                let [edge, end] = self.early?;
                if stage == 0 {
                    (Held::Lower, edge < -bend, edge, end.min(-bend))
                } else {
                    (Held::Nothing, bends, sum(edge.max(-bend)), sum(end))
                }
            }
            2 if bends => (Held::Lower, !held && from < -bend, from, to.min(-bend)),
            2 => (Held::Lower, !held, from, to),
            3 => {
                if held || !bends || from > bend {
                    return None;
                }
                (Held::Nothing, true, sum(from.max(-bend)), sum(to.min(bend)))
            }
            4 => (Held::Lower, !held && bends && to > bend, from.max(bend), to),
            5 | 6 => {
                if cruises <= a_g {
                    return None;
                }
                let x = from.max(a_g);
                let v_g = g + x * x * per_j;
                let v_l = l + a_l * a_l * per_j;
                if stage == 5 {
                    if v_g >= v_l {
                        return None;
                    }
                    let y = |v: f64| (j * (v - l)).max(0.0).sqrt();
                    (Held::Higher, true, y(v_g), y(v_l.min(fastest)))
                } else {
                    // Something leads to the cruise.
                    (Held::Both, v_l < fastest || (held && v_g >= v_l), v_g.max(v_l), fastest)
                }
            }
            _ => (Held::Velocity, true, 0.0, f64::INFINITY),
        };
        exists.then_some(Piece { held: kind, from, to: to.max(from) })
    }

    /// Whether the displacement rises from the beginning of this piece, which exists, to the end of the curve.
    #[inline]
    fn rises(&self, stage: usize) -> bool {
        let x = match stage {
            0 | 1 => return false,
            2 => self.from,
            3 => self.from.max(-self.bend),
            4 => self.from.max(self.bend),
            5 | 6 => self.from.max(self.ramps.held_higher),
            _ => return true,
        };
        x >= self.rises
    }

    /// The displacement \[m\] in the shortest duration to the velocity alone.
    #[inline]
    pub fn least_displacement(&self) -> f64 {
        self.first.2.displacement - self.ahead[1]
    }

    /// How long a motion whose ramps take `time` lasts.
    #[inline]
    fn duration(&self, time: f64) -> f64 {
        (time - self.ahead[0]).max(0.0)
    }

    #[inline]
    fn place(&self, held: Held, z: f64, time: f64) -> Place {
        Place { held, z, duration: self.duration(time) }
    }

    /// The beginning of the curve: the fastest change of velocity.
    #[inline]
    pub fn beginning(&self) -> Place {
        let (_, piece, value) = &self.first;
        self.place(piece.held, piece.from, value.time)
    }

    /// The durations in which the farthest motion gets less far than `displacement` \[m\]; where the beginning is known to get
    /// `there`, not the shortest one.
    #[inline]
    pub fn gaps(&self, displacement: f64, there: bool) -> Gaps {
        let (first, beginning, mut here) = self.first;
        let target = displacement + self.ahead[1];
        let target = if there { target.min(here.displacement) } else { target };
        let mut gaps = Gaps::default();
        let mut below = (here.displacement < target).then_some(f64::NEG_INFINITY);
        let mut known = Some(beginning);
        let mut in_last_part = first >= LAST_PART;
        for stage in first..STAGES {
            let Some(piece) = known.take().or_else(|| self.piece(stage)) else { continue };
            let rises = self.rises(stage);
            if rises && in_last_part && below.is_none() {
                break;
            }
            if !in_last_part && stage >= LAST_PART {
                in_last_part = true;
                let from = below.unwrap_or_else(|| self.duration(here.time));
                here = self.ramps.value(piece.held, piece.from);
                below = Some(from);
                if here.displacement >= target {
                    gaps.push(from, self.place(piece.held, piece.from, here.time));
                    below = None;
                }
            }
            if piece.held == Held::Velocity {
                if let Some(from) = below {
                    let z = ((target - here.displacement) / self.ramps.fastest).max(0.0);
                    gaps.push(from, self.place(Held::Velocity, z, here.time + z));
                }
                break;
            }
            let turns = if rises { [f64::NAN; 2] } else { self.ramps.turns(piece.held) };
            let mut from = piece.from;
            for cut in turns.into_iter().chain([piece.to]) {
                if cut != piece.to && !(cut > from && cut < piece.to) {
                    continue;
                }
                let part = Piece { held: piece.held, from, to: cut };
                let end = self.ramps.value(piece.held, cut);
                if (end.displacement < target) != below.is_some() {
                    let z = self.ramps.crossing(&part, [&here, &end], target);
                    let crossing = self.place(piece.held, z, self.ramps.time(piece.held, z));
                    below = match below {
                        None => Some(crossing.duration),
                        Some(from) => {
                            gaps.push(from, crossing);
                            None
                        }
                    };
                }
                here = end;
                from = cut;
            }
        }
        gaps
    }

    /// The farthest motion that lasts `duration` \[s\], at least that of [`Self::beginning`].
    #[inline]
    pub fn lasting(&self, duration: f64) -> Place {
        let time = duration + self.ahead[0];
        let (first, beginning, _) = self.first;
        let mut known = Some(beginning);
        let mut before = 0.0;
        for stage in first..STAGES - 1 {
            let Some(piece) = known.take().or_else(|| self.piece(stage)) else { continue };
            before = self.ramps.time(piece.held, piece.to);
            if before >= time {
                return Place { held: piece.held, z: self.ramps.at_time(&piece, time), duration };
            }
        }
        Place { held: Held::Velocity, z: (time - before).max(0.0), duration }
    }

    /// The motion itself, as phases; `direction` 1, or -1 for the mirrored axis.
    pub fn phases(&self, place: &Place, direction: f64) -> Phases {
        let Ramps { j, per_j, .. } = self.ramps;
        let (peak, cruise) = self.ramps.peak(place.held, place.z);
        let heights = self.ramps.heights(place.held, place.z);
        let edges = [self.ends[0], -self.ends[1]];
        let ramp = |side: usize| {
            let a = self.accelerations[side];
            let rise = (peak - self.bases[side]).max(0.0);
            match heights[if self.first_is_higher { side } else { 1 - side }] {
                Some(height) => (height, 0.0),
                // The velocity before a target may be above the limit by rounding: the height is that of the target then.
                None if j * rise < a * a => ((j * rise).sqrt().max(edges[side]), 0.0),
                None => (a, (rise / a - a * per_j).max(0.0)),
            }
        };
        let (up, up_held) = ramp(0);
        let (down, down_held) = ramp(1);
        // Where the acceleration never is 0, the two middle phases of one jerk are one.
        let (up_end, down_begin) = if up < 0.0 || down < 0.0 { (up + down, 0.0) } else { (up, down) };
        let signed = j * direction;
        let mut first = (up - self.ends[0]) * per_j;
        let mut last = (down + self.ends[1]) * per_j;
        // Both ends are on one ramp.
        if up == 0.0 && down == 0.0 && cruise == 0.0 {
            first += last;
            last = 0.0;
        }
        [
            Phase::new(first, signed),
            Phase::new(up_held, 0.0),
            Phase::new(up_end * per_j, -signed),
            Phase::new(cruise, 0.0),
            Phase::new(down_begin * per_j, -signed),
            Phase::new(down_held, 0.0),
            Phase::new(last, signed),
        ]
    }
}
