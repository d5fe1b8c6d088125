//! Speeds from positions: differences over the last servo periods.
//!
//! In: a sample per servo period. Out: `(x(t) - x(t - w)) / w`, which is the speed at `t - w / 2`, with a window w of
//! [`WINDOW`], two servo periods at least, so that an encoder's pulses do not drown the motion.

use std::collections::VecDeque;

use nalgebra::Vector3;

use crate::sample::{Rates, Sample};

/// Over what time positions are compared \[s\].
const WINDOW: f64 = 0.016;

/// The servo periods of one window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Speeds {
    recent: VecDeque<Moment>,
}

#[derive(Clone, Debug)]
struct Moment {
    time: f64,
    demanded: Vec<f64>,
    measured: Vec<f64>,
    tool: Vector3<f64>,
}

impl Speeds {
    /// Takes the next sample; the speeds of the window that it ends, none at the first.
    pub fn next(&mut self, sample: &Sample) -> Option<Rates> {
        let now = Moment {
            time: sample.time,
            demanded: sample.demanded.clone(),
            measured: sample.measured.clone(),
            tool: sample.tool.translation.vector,
        };
        while self.recent.len() > 2 && self.recent.get(1).is_some_and(|m| m.time < now.time - WINDOW + 1e-9) {
            self.recent.pop_front();
        }
        let rates = self.recent.front().filter(|first| first.time < now.time).map(|first| {
            let window = now.time - first.time;
            let rate =
                |now: &[f64], first: &[f64]| now.iter().zip(first).map(|(b, a)| (b - a) / window).collect();
            Rates {
                time: now.time - 0.5 * window,
                demanded: rate(&now.demanded, &first.demanded),
                measured: rate(&now.measured, &first.measured),
                tool: (now.tool - first.tool).norm() / window,
            }
        });
        self.recent.push_back(now);
        rates
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::tests::slide;

    #[test]
    fn the_rate_of_a_sine_is_its_cosine() {
        for period in [2e-3, 1e-2] {
            let mut speeds = Speeds::default();
            for i in 0..2000 {
                let time = f64::from(i) * period;
                let rates = speeds.next(&slide(time, time.sin(), time.sin()));
                let Some(rates) = rates else {
                    assert_eq!(i, 0);
                    continue;
                };
                // A central difference over w errs by w² / 24.
                let window = WINDOW.max(2.0 * period) + period;
                let bound = window * window / 24.0 + 1e-12;
                assert!((rates.measured[0] - rates.time.cos()).abs() < bound);
                assert!((rates.tool - rates.time.cos().abs()).abs() < bound);
                assert!(time - rates.time <= 0.5 * window);
            }
        }
    }
}
