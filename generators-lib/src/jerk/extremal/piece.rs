//! A piece of the curve, whichever of its kinds it is.

use super::{both_held, cruising, free, one_held};

/// Duration and way of the ramps, as the module's `T + a0 / J` and `D + c`, and their slopes by the piece's variable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Value {
    pub time: f64,
    pub way: f64,
    pub way_slope: f64,
}

/// What is held on a piece, and its variable `z`.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// Nothing; `z` is the sum of both peak accelerations [m/s^2]; `k` >= 0 is `J` times how
    /// much higher `base` is than the other.
    Free { base: f64, k: f64 },
    /// The acceleration of the ramp at `other`; `z` is the peak acceleration of that at `base` [m/s^2].
    OneHeld { base: f64, other: f64, held: f64, base_is_higher: bool },
    /// Both; `z` is the peak velocity [m/s].
    BothHeld { bases: [f64; 2], held: [f64; 2] },
    /// The velocity; `z` is how long \[s\].
    Cruising { velocity: f64, before: Value },
}

/// A piece from one value of its variable to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    kind: Kind,
    pub from: f64,
    pub to: f64,
    pub from_value: Value,
    pub to_value: Value,
}

impl Default for Piece {
    fn default() -> Self {
        let kind = Kind::Cruising { velocity: 0.0, before: Value::default() };
        Piece { kind, from: 0.0, to: 0.0, from_value: Value::default(), to_value: Value::default() }
    }
}

impl Piece {
    /// Behind `before`, where there is a piece before this one.
    pub fn new(kind: Kind, from: f64, to: f64, j: f64, before: Option<&Value>) -> Self {
        let mut piece = Piece { kind, from, to, ..Piece::default() };
        piece.from_value = before.copied().unwrap_or_else(|| piece.value(from, j));
        piece.to_value = piece.value(to, j);
        piece
    }

    #[inline]
    pub fn value(&self, z: f64, j: f64) -> Value {
        match self.kind {
            Kind::Free { base, k } => free::value(z, base, k, j),
            Kind::OneHeld { base, other, held, .. } => one_held::value(z, base, other, held, j),
            Kind::BothHeld { bases, held } => both_held::value(z, bases, held, j),
            Kind::Cruising { velocity, ref before } => cruising::value(z, velocity, before),
        }
    }

    /// Where the duration is `time`.
    pub fn at_time(&self, time: f64, j: f64) -> f64 {
        let z = match self.kind {
            Kind::Free { .. } => free::at_time(time, j),
            Kind::OneHeld { base, other, held, .. } => one_held::at_time(time, base, other, held, j),
            Kind::BothHeld { bases, held } => both_held::at_time(time, bases, held, j),
            Kind::Cruising { ref before, .. } => time - before.time,
        };
        z.max(self.from).min(self.to)
    }

    /// Peak velocity [m/s], and how long it is held \[s\].
    pub fn peak(&self, z: f64, j: f64) -> (f64, f64) {
        match self.kind {
            Kind::Free { base, k } => (base + free::smaller(z, k).powi(2) / j, 0.0),
            Kind::OneHeld { base, .. } => (base + z * z / j, 0.0),
            Kind::BothHeld { .. } => (z, 0.0),
            Kind::Cruising { velocity, .. } => (velocity, z),
        }
    }

    /// Peak accelerations of the ramps at the higher and at the lower base, where the variable says them.
    pub fn heights(&self, z: f64) -> [Option<f64>; 2] {
        match self.kind {
            Kind::Free { k, .. } => {
                let x = free::smaller(z, k);
                [Some(x), Some(z - x)]
            }
            Kind::OneHeld { base_is_higher: true, .. } => [Some(z), None],
            Kind::OneHeld { base_is_higher: false, .. } => [None, Some(z)],
            Kind::BothHeld { .. } | Kind::Cruising { .. } => [None, None],
        }
    }

    /// Where the way may turn, in order; places outside the piece do not count.
    pub fn turns(kind: &Kind, j: f64) -> [f64; 2] {
        match *kind {
            Kind::Free { base, k } => free::turns(base, k, j),
            Kind::OneHeld { base, held, .. } => one_held::turns(base, held, j),
            Kind::BothHeld { held, .. } => both_held::turns(held, j),
            Kind::Cruising { .. } => [f64::NAN; 2],
        }
    }

    /// Where the way, which rises or falls throughout, passes `target`: Newton's iteration, kept in a bracket.
    pub fn crossing(&self, target: f64, j: f64) -> f64 {
        if let Kind::Cruising { velocity, ref before } = self.kind {
            return ((target - before.way) / velocity).max(0.0);
        }
        let rising = self.to_value.way >= self.from_value.way;
        let (mut low, mut high) = (self.from, self.to);
        let range = self.to_value.way - self.from_value.way;
        let share = ((target - self.from_value.way) / range).clamp(0.0, 1.0);
        // The way grows with a power between 1 and 3 of the variable.
        let mut z = if range == 0.0 { low } else { low + (high - low) * share.sqrt() };
        for _ in 0..100 {
            let value = self.value(z, j);
            let residual = value.way - target;
            if residual == 0.0 {
                return z;
            }
            if (residual > 0.0) == rising {
                high = z;
            } else {
                low = z;
            }
            let newton = z - residual / value.way_slope;
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
