//! How arms that hold one body stop together: on the twist that the body has.
//!
//! In: what the joints do on the twist from a place of the body's path. Out: by how much they accelerate by its parameter, `c = d²q / ds²`, and how long they brake.
//!
//! The twist is a straight line of no joint. At the distance `s` on it a joint is off the line along its velocity by at most `c s² / 2`. All arms
//! brake by the same law (decision 7): so that no joint needs more than the smaller of `0.8 a` and `a - 1.25 c v²`, and never for longer than `T_b / 0.8`,
//! with the longest time `T_b` that a joint brakes from its limit of velocity.
//!
//! **`c` is taken at samples**, and is a quarter larger than the largest.

use crate::limits::Limits;

/// Up to which shares of the farthest distance `c` is known, each from the samples up to it.
const LEVELS: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// Where it is sampled, as shares of it.
const SAMPLES: [f64; 9] = [0.0, 0.0625, 0.125, 0.1875, 0.25, 0.375, 0.5, 0.75, 1.0];
/// What is kept for between samples, and the share of the limit of acceleration by which arms brake at most.
const MORE: f64 = 1.25;
const SHARE: f64 = 0.8;

/// The twists of a body from all cells of a grid.
pub(crate) struct Twist {
    /// The longest time that arms brake together \[s\].
    pub(crate) longest: f64,
    /// Of each cell the farthest distance, and `c` of all joints for each level; as far as the arms have postures.
    cells: Vec<(f64, Vec<Vec<f64>>)>,
}

impl Twist {
    /// Without any cell, for these limits.
    pub(crate) fn new(limits: &Limits) -> Self {
        let alone = limits.velocity.iter().zip(&limits.acceleration).map(|(v, a)| v / a);
        Twist { longest: alone.fold(0.0, f64::max) / SHARE, cells: Vec::new() }
    }

    /// Adds a cell whose twists are at most `farthest` long [by the path's parameter]; `c` of all joints at a distance on those from some places in the
    /// cell is told by `at`.
    pub(crate) fn add(&mut self, farthest: f64, mut at: impl FnMut(f64) -> Option<Vec<Vec<f64>>>) {
        let mut levels = Vec::new();
        let mut most: Vec<f64> = Vec::new();
        let mut samples = SAMPLES.iter().peekable();
        'levels: for level in LEVELS {
            while let Some(share) = samples.next_if(|share| **share <= level) {
                let Some(found) = at(share * farthest) else { break 'levels };
                for bends in found {
                    most.resize(bends.len(), 0.0);
                    most.iter_mut().zip(bends).for_each(|(most, c)| *most = most.max(MORE * c.abs()));
                }
            }
            levels.push(most.clone());
        }
        self.cells.push((farthest, levels));
    }

    /// How long arms brake at most \[s\] that leave a cell at a `speed` of the path \[1/s\], with velocities in these ranges [rad/s or m/s], and after a
    /// reaction time \[s\]; how far that is by the parameter, and `c` of all joints until there. `None` where they have no postures there.
    pub(crate) fn stop(
        &self,
        cell: usize,
        limits: &Limits,
        rates: &[[f64; 2]],
        speed: f64,
        reaction: f64,
    ) -> Option<(f64, f64, &[f64])> {
        let (farthest, levels) = self.cells.get(cell)?;
        LEVELS.iter().zip(levels).find_map(|(share, bends)| {
            let time = self.time(limits, rates, bends, speed);
            let far = speed * (reaction + 0.5 * time);
            (far <= share * farthest).then_some((time, far, bends.as_slice()))
        })
    }

    fn time(&self, limits: &Limits, rates: &[[f64; 2]], bends: &[f64], speed: f64) -> f64 {
        let times = rates.iter().zip(bends).zip(&limits.acceleration).map(|(([lower, upper], c), a)| {
            let left = (SHARE * a).min(a - c * speed * speed);
            let fastest = lower.abs().max(upper.abs());
            if left > 0.0 { fastest / left } else { f64::INFINITY }
        });
        times.fold(0.0, f64::max).min(self.longest)
    }
}
