//! Edges of a switched output that chatters.

/// A change of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// When \[s\].
    pub time: f64,
    /// To what.
    pub covered: bool,
}

/// Makes one edge of each burst of changes: in the middle between the first and the last of them.
///
/// ```
/// use mrroc_sensors::aggregation::Debounce;
///
/// let mut output = Debounce::new(5e-3);
/// let mut edges = Vec::new();
/// // Sampled every millisecond: open, then it chatters for 4 ms.
/// for (ms, covered) in [0, 0, 1, 0, 1, 0, 1, 1, 1, 1, 1, 1, 1].into_iter().enumerate() {
///     edges.extend(output.take(ms as f64 * 1e-3, covered == 1));
/// }
/// // Between the samples at 1 and 2 ms it changed first, between 5 and 6 ms last.
/// assert!(edges.len() == 1 && edges[0].covered && (edges[0].time - 3.5e-3).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Debounce {
    quiet: f64,
    settled: bool,
    last: Option<(f64, bool)>,
    /// When the output changed first and last in a burst.
    burst: Option<(f64, f64)>,
}

impl Debounce {
    /// A burst is over when the output has not changed for `quiet` \[s\], > 0. The output is open to begin with.
    #[must_use]
    pub const fn new(quiet: f64) -> Self {
        Self { quiet, settled: false, last: None, burst: None }
    }

    /// Whether the output is covered, chatter aside.
    #[must_use]
    pub const fn is_covered(&self) -> bool {
        self.settled
    }

    /// Takes a sample at `time` \[s\]; samples come in their order. The edge whose burst is over then.
    pub fn take(&mut self, time: f64, covered: bool) -> Option<Edge> {
        // An output that is covered from the first sample on was so before.
        let (before, was) = self.last.replace((time, covered)).unwrap_or_else(|| {
            self.settled = covered;
            (time, covered)
        });
        if covered != was {
            let changed = 0.5 * (before + time);
            self.burst = Some((self.burst.map_or(changed, |(first, _)| first), changed));
            return None;
        }
        let (first, last) = self.burst.filter(|(_, last)| time - last >= self.quiet)?;
        self.burst = None;
        let is_edge = covered != self.settled;
        self.settled = covered;
        is_edge.then_some(Edge { time: 0.5 * (first + last), covered })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(samples: &[u8]) -> Vec<Edge> {
        let mut output = Debounce::new(3e-3);
        samples.iter().enumerate().filter_map(|(ms, &s)| output.take(ms as f64 * 1e-3, s == 1)).collect()
    }

    #[test]
    fn a_spike_is_no_edge_and_both_edges_of_a_pulse_are() {
        assert_eq!(edges(&[0, 0, 1, 0, 0, 0, 0, 0]), []);
        let both = edges(&[0, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0]);
        let expected = [(1.5e-3, true), (7.5e-3, false)];
        assert_eq!(both.len(), 2);
        for (edge, (time, covered)) in both.iter().zip(expected) {
            assert!((edge.time - time).abs() < 1e-12 && edge.covered == covered, "{edge:?}");
        }
    }

    #[test]
    fn an_output_that_is_covered_from_the_beginning_has_no_edge() {
        assert_eq!(edges(&[1; 20]), []);
    }
}
