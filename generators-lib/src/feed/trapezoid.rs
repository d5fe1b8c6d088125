//! The fastest speed over one cell between two given speeds.

/// Speed up, hold, slow down over a given length; the ends' speeds need not be zero.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellTrapezoid {
    acceleration: f64,
    entry: f64,
    peak: f64,
    exit: f64,
    length: f64,
    up: f64,
    hold: f64,
    duration: f64,
}

impl CellTrapezoid {
    /// From the squares of the entry, exit and largest speed [m^2/s^2]. The entry and exit must be within the
    /// limit and reachable from each other; `length` \[m\] > 0.
    pub(super) fn new(entry2: f64, exit2: f64, limit2: f64, length: f64, acceleration: f64) -> Self {
        let reachable = 0.5 * (entry2 + exit2) + acceleration * length;
        let peak2 = limit2.min(reachable).max(entry2).max(exit2);
        let (entry, peak, exit) = (entry2.sqrt(), peak2.sqrt(), exit2.sqrt());
        let up = (peak - entry) / acceleration;
        let down = (peak - exit) / acceleration;
        let ramps = (2.0 * peak2 - entry2 - exit2) / (2.0 * acceleration);
        let hold = if peak > 0.0 { ((length - ramps) / peak).max(0.0) } else { 0.0 };
        Self { acceleration, entry, peak, exit, length, up, hold, duration: up + hold + down }
    }

    /// Time over the cell \[s\].
    pub(super) fn duration(&self) -> f64 {
        self.duration
    }

    /// Length \[m\] and speed [m/s] at `t` \[s\] in 0..=duration.
    #[inline]
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        let a = self.acceleration;
        if t < self.up {
            return (t * (self.entry + 0.5 * a * t), self.entry + a * t);
        }
        let left = self.duration - t;
        if t < self.up + self.hold {
            let t = t - self.up;
            return (self.up * 0.5 * (self.entry + self.peak) + self.peak * t, self.peak);
        }
        let left = left.max(0.0);
        (self.length - left * (self.exit + 0.5 * a * left), self.exit + a * left)
    }
}
