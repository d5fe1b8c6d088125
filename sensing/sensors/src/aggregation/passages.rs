//! Parts that pass two light barriers: number, speed, length.
//!
//! ```text
//!        beam 0 <-- D --> beam 1            belt ->
//! t0+ t0-: leading and trailing edge at beam 0      t1+ t1-: at beam 1
//!
//! v = D / (t1- - t0-)          the newer one; that of the leading edges must agree
//! L = mean of v (t0- - t0+) and v (t1- - t1+)
//! ```
//!
//! Edges that do not make one part that goes from beam 0 to beam 1 (a barrier that is dead, a belt that stopped or was reversed, two
//! parts between the beams) are dropped and counted.

use super::debounce::Edge;

/// A part that has passed both barriers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// When its leading edge came to beam 0 \[s\].
    pub came: f64,
    /// When its trailing edge left beam 1 \[s\].
    pub left: f64,
    /// [m/s], > 0.
    pub speed: f64,
    /// Along the belt \[m\], > 0.
    pub length: f64,
}

/// Makes passages of edges.
#[derive(Clone, Copy, Debug)]
pub struct Passages {
    spacing: f64,
    /// Times of the edges so far of the part that is at a beam: covered and open.
    at: [Option<f64>; 2],
    /// The part that has left beam 0 and not yet come to beam 1.
    between: Option<(f64, f64)>,
    last: Option<Passage>,
    count: u32,
    dropped: u32,
}

impl Passages {
    /// By how much the speeds of the two edges of a part may differ, as a share.
    pub const AGREEMENT: f64 = 0.1;

    /// Two beams this far apart along the belt \[m\], > 0.
    #[must_use]
    pub const fn new(spacing: f64) -> Self {
        Self { spacing, at: [None; 2], between: None, last: None, count: 0, dropped: 0 }
    }

    /// The newest part.
    #[must_use]
    pub const fn last(&self) -> Option<Passage> {
        self.last
    }

    /// How many parts have passed.
    #[must_use]
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// How often edges made no part.
    #[must_use]
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Takes an edge of beam 0 or 1. Those of one beam come in their order.
    pub fn take(&mut self, beam: usize, edge: Edge) {
        let Some(at) = self.at.get_mut(beam) else { return };
        if edge.covered {
            *at = Some(edge.time);
            return;
        }
        let Some(covered) = at.take() else { return };
        if beam == 0 {
            // Two between the beams: only the newer one can be told.
            self.dropped += u32::from(self.between.is_some());
            self.between = Some((covered, edge.time));
            return;
        }
        match self.between.take().and_then(|first| self.passage(first, (covered, edge.time))) {
            Some(passage) => {
                self.last = Some(passage);
                self.count += 1;
            }
            None => self.dropped += 1,
        }
    }

    /// The part whose edges covered and left beam 0, and beam 1, at these times.
    fn passage(&self, first: (f64, f64), second: (f64, f64)) -> Option<Passage> {
        let [leading, trailing] = [second.0 - first.0, second.1 - first.1].map(|time| self.spacing / time);
        let agree = (leading / trailing - 1.0).abs() <= Self::AGREEMENT;
        let length = 0.5 * trailing * ((first.1 - first.0) + (second.1 - second.0));
        let is_one = trailing > 0.0 && agree && length > 0.0 && length < self.spacing;
        is_one.then_some(Passage { came: first.0, left: second.1, speed: trailing, length })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const D: f64 = 0.15;

    /// The edges of a part of this length whose leading edge is at `x(t)` from beam 0, found by halving.
    fn edges(x: impl Fn(f64) -> f64, length: f64) -> [(usize, Edge); 4] {
        let when = |place: f64| {
            let (mut early, mut late) = (0.0, 100.0);
            for _ in 0..60 {
                let middle = 0.5 * (early + late);
                if x(middle) < place { early = middle } else { late = middle }
            }
            early
        };
        let edge = |beam: usize, covered: bool| {
            let place = D * beam as f64 + if covered { 0.0 } else { length };
            (beam, Edge { time: when(place), covered })
        };
        [edge(0, true), edge(0, false), edge(1, true), edge(1, false)]
    }

    fn take(passages: &mut Passages, edges: &[(usize, Edge)]) {
        edges.iter().for_each(|&(beam, edge)| passages.take(beam, edge));
    }

    #[test]
    fn a_part_that_speeds_up_slightly_is_told_by_its_newer_speed() {
        let mut passages = Passages::new(D);
        take(&mut passages, &edges(|t| 0.1 * t * (1.0 + 0.0025 * t), 0.08));
        let passage = passages.last().expect("passed");
        // Where its trailing edge goes, 0.08 to 0.23 m, x' = 0.1 (1 + 0.005 t) with t about 1.55.
        assert!((passage.speed / 0.1 - 1.0 - 0.005 * 1.54).abs() < 3e-4, "{passage:?}");
        assert!((passage.length - 0.08).abs() < 4e-4, "{passage:?}");
        assert_eq!((passages.count(), passages.dropped()), (1, 0));
    }

    #[test]
    fn edges_that_make_no_part_are_dropped() {
        // A belt that stands for 2 s with the part between the beams.
        let mut passages = Passages::new(D);
        take(&mut passages, &edges(|t| 0.1 * (t.min(1.0) + (t - 3.0).max(0.0)), 0.08));
        let slow = passages.last();
        assert!(slow.is_none_or(|slow| slow.speed < 0.06), "both edges saw the pause: {slow:?}");
        // One that stands while only its leading edge is beyond beam 1.
        let mut passages = Passages::new(D);
        take(&mut passages, &edges(|t| 0.1 * (t.min(1.9) + (t - 3.9).max(0.0)), 0.08));
        assert_eq!((passages.count(), passages.dropped()), (0, 1));
        // Beam 0 dead; beam 1 dead; reversed: it comes to beam 1 first.
        let all = edges(|t| 0.1 * t, 0.08);
        let mut passages = Passages::new(D);
        take(&mut passages, &all[2..]);
        assert_eq!((passages.count(), passages.dropped()), (0, 1));
        let mut passages = Passages::new(D);
        take(&mut passages, &all[..2]);
        assert_eq!((passages.count(), passages.dropped()), (0, 0));
        take(&mut passages, &all[..2]);
        assert_eq!((passages.count(), passages.dropped()), (0, 1));
        let mut passages = Passages::new(D);
        let backwards = all.map(|(beam, edge)| (1 - beam, edge));
        take(&mut passages, &backwards[2..]);
        take(&mut passages, &backwards[..2]);
        assert_eq!(passages.count(), 0);
    }
}
