//! The fastest speed over one cell between two given speeds.
//!
//! The square of the speed is a line of the length wherever the acceleration is constant. So it is the least of three lines:
//! speeding up from the entry, slowing down to the exit, and the limit, which may itself rise or fall over the cell.

/// Speed up, keep to the limit, slow down over a given length; the ends' speeds need not be zero.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellTrapezoid {
    /// Acceleration of each phase [m/s^2].
    accelerations: [f64; 3],
    /// Speed at the start of each phase [m/s].
    speeds: [f64; 3],
    /// Length at the start of each phase \[m\].
    lengths: [f64; 3],
    /// Time at the end of each phase \[s\].
    times: [f64; 3],
    length: f64,
    exit: f64,
}

impl CellTrapezoid {
    /// From the squares of the entry and exit speed [m^2/s^2], and of the limit at either end. Entry and exit must be within
    /// the limit and reachable from each other; `length` \[m\] > 0.
    pub(super) fn new(entry2: f64, exit2: f64, top2: [f64; 2], length: f64, acceleration: f64) -> Self {
        let steepest = 2.0 * acceleration;
        let slope = (top2[1] - top2[0]) / length;
        // Where speeding up would exceed the limit, and from where slowing down will do; a limit that is steeper than either
        // is not met by it.
        let meets = if slope < steepest { (top2[0] - entry2) / (steepest - slope) } else { length };
        let leaves = if slope > -steepest { length - (top2[1] - exit2) / (steepest + slope) } else { 0.0 };
        let (first, second, squares) = if meets < leaves {
            let first = meets.max(0.0);
            let second = leaves.min(length);
            (first, second, [top2[0] + slope * first, top2[0] + slope * second])
        } else {
            let turn = (0.5 * (length + (exit2 - entry2) / steepest)).clamp(0.0, length);
            (turn, turn, [(entry2 + steepest * turn).max(exit2); 2])
        };
        let entry = entry2.sqrt();
        let exit = exit2.sqrt();
        let [meeting, leaving] = squares.map(|square| square.max(0.0).sqrt());
        let time = |distance: f64, from: f64, to: f64| {
            if distance > 0.0 { 2.0 * distance / (from + to) } else { 0.0 }
        };
        let up = time(first, entry, meeting);
        let kept = time(second - first, meeting, leaving);
        let down = time(length - second, leaving, exit);
        Self {
            accelerations: [acceleration, 0.5 * slope, -acceleration],
            speeds: [entry, meeting, leaving],
            lengths: [0.0, first, second],
            times: [up, up + kept, up + kept + down],
            length,
            exit,
        }
    }

    /// Time over the cell \[s\].
    pub(super) fn duration(&self) -> f64 {
        self.times[2]
    }

    /// Length \[m\] and speed [m/s] at `t` \[s\] in 0..=duration.
    #[inline]
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        // Backwards from the exit, which is met exactly.
        if t >= self.times[1] {
            let left = (self.times[2] - t).max(0.0);
            let a = -self.accelerations[2];
            return (self.length - left * (self.exit + 0.5 * a * left), self.exit + a * left);
        }
        let (phase, start) = if t < self.times[0] { (0, 0.0) } else { (1, self.times[0]) };
        let t = t - start;
        let a = self.accelerations[phase];
        let v = self.speeds[phase];
        (self.lengths[phase] + t * (v + 0.5 * a * t), v + a * t)
    }
}
