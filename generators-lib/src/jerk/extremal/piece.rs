//! A piece of the curve, whichever of its kinds it is.

use super::value::Value;
use super::{both_held, free, one_held};

/// What is held on a piece, and by that its variable `z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Held {
    /// Nothing; `z` is the sum of both peak accelerations [m/s^2].
    Nothing,
    /// The acceleration of the ramp at the lower base; `z` is the peak acceleration of the other [m/s^2].
    Lower,
    /// The acceleration of the ramp at the higher base; `z` is the peak acceleration of the other [m/s^2].
    Higher,
    /// Both; `z` is the peak velocity [m/s].
    Both,
    /// The velocity; `z` is how long \[s\].
    Velocity,
}

/// A piece from one value of its variable to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub held: Held,
    pub from: f64,
    pub to: f64,
}

/// The two ramps, that at the higher base and that at the lower.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramps {
    /// Where they begin and end [m/s].
    pub higher: f64,
    pub lower: f64,
    /// `J` times how much higher the one is than the other [m^2/s^4].
    pub k: f64,
    /// Their accelerations where these are held [m/s^2], > 0.
    pub held_higher: f64,
    pub held_lower: f64,
    /// The velocity that is held [m/s], > 0.
    pub fastest: f64,
    /// Jerk [m/s^3], and what it is divided by.
    pub j: f64,
    pub per_j: f64,
}

impl Ramps {
    /// Not of the cruise, which goes on from what is before it.
    #[inline]
    pub fn value(&self, held: Held, z: f64) -> Value {
        let Ramps { higher, lower, k, held_higher, held_lower, fastest, per_j, .. } = *self;
        match held {
            Held::Nothing => free::value(z, higher, k, per_j),
            Held::Lower => one_held::value(z, higher, lower, held_lower, per_j),
            Held::Higher => one_held::value(z, lower, higher, held_higher, per_j),
            Held::Both => both_held::value(z, [higher, lower], [held_higher, held_lower], per_j),
            Held::Velocity => Value { time: z, displacement: fastest * z, slope: fastest },
        }
    }

    /// The duration alone; not of the cruise.
    #[inline]
    pub fn time(&self, held: Held, z: f64) -> f64 {
        self.value(held, z).time
    }

    /// Where the duration is `time`; not of the cruise.
    #[inline]
    pub fn at_time(&self, piece: &Piece, time: f64) -> f64 {
        let Ramps { higher, lower, held_higher, held_lower, j, .. } = *self;
        let z = match piece.held {
            Held::Nothing => free::at_time(time, j),
            Held::Lower => one_held::at_time(time, higher, lower, held_lower, j),
            Held::Higher => one_held::at_time(time, lower, higher, held_higher, j),
            Held::Both => both_held::at_time(time, [higher, lower], [held_higher, held_lower], j),
            Held::Velocity => time,
        };
        z.max(piece.from).min(piece.to)
    }

    /// Peak velocity [m/s], and how long it is held \[s\].
    #[inline]
    pub fn peak(&self, held: Held, z: f64) -> (f64, f64) {
        match held {
            Held::Nothing => (self.higher + free::smaller(z, self.k).powi(2) * self.per_j, 0.0),
            Held::Lower => (self.higher + z * z * self.per_j, 0.0),
            Held::Higher => (self.lower + z * z * self.per_j, 0.0),
            Held::Both => (z, 0.0),
            Held::Velocity => (self.fastest, z),
        }
    }

    /// Peak accelerations of the ramps at the higher and at the lower base, where the variable says them.
    #[inline]
    pub fn heights(&self, held: Held, z: f64) -> [Option<f64>; 2] {
        match held {
            Held::Nothing => {
                let x = free::smaller(z, self.k);
                [Some(x), Some(z - x)]
            }
            Held::Lower => [Some(z), None],
            Held::Higher => [None, Some(z)],
            Held::Both | Held::Velocity => [None, None],
        }
    }

    /// Where the displacement may turn, in order; places outside the piece do not count.
    pub fn turns(&self, held: Held) -> [f64; 2] {
        let Ramps { higher, lower, k, held_higher, held_lower, j, .. } = *self;
        match held {
            Held::Nothing => free::turns(higher, k, j),
            Held::Lower => one_held::turns(higher, held_lower, j),
            Held::Higher => one_held::turns(lower, held_higher, j),
            Held::Both => both_held::turns([held_higher, held_lower], j),
            Held::Velocity => [f64::NAN; 2],
        }
    }

    /// Where the displacement, which rises or falls throughout from one value to the other, passes `target`: Newton's iteration, kept
    /// in a bracket.
    #[inline]
    pub fn crossing(&self, piece: &Piece, ends: [&Value; 2], target: f64) -> f64 {
        let [first, last] = ends.map(|value| value.displacement);
        let rising = last >= first;
        let mut low = piece.from;
        let mut high = piece.to;
        let range = last - first;
        let share = ((target - first) / range).clamp(0.0, 1.0);
        // The displacement grows with a power between 1 and 3 of the variable.
        let mut z = if range == 0.0 { low } else { low + (high - low) * share.sqrt() };
        for _ in 0..100 {
            let value = self.value(piece.held, z);
            let residual = value.displacement - target;
            if residual == 0.0 {
                return z;
            }
            if (residual > 0.0) == rising {
                high = z;
            } else {
                low = z;
            }
            let newton = z - residual / value.slope;
            if !(newton >= low && newton <= high) {
                z = 0.5 * (low + high);
                if z <= low || z >= high {
                    return z;
                }
                continue;
            }
            // The next step would be its square.
            if (newton - z).abs() <= 1e-9 * z.abs() {
                return newton;
            }
            z = newton;
        }
        z
    }
}
