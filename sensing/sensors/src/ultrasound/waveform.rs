//! What a transducer hears after a ping, and the echo that a threshold detector finds in it.

use super::Air;

/// A pressure over the range from which it comes, about the carrier: in bins, first as points, then as pulses.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Waveform {
    /// Real and imaginary parts of what each bin sends back.
    pub(super) points: Vec<[f64; 2]>,
    /// What is heard, bin by bin: real and imaginary parts ..
    waves: Vec<[f64; 2]>,
    /// .. and magnitude.
    heard: Vec<f64>,
}

/// The first echo.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// From the ping until the pressure passes the threshold \[s\].
    pub time: f64,
    /// The pressure where it is greatest, of 1 a metre before the source.
    pub amplitude: f64,
}

impl Waveform {
    /// Width of a bin \[m\].
    pub const BIN: f64 = 1e-3;

    /// What is listened to, from one range to another \[m\]; what comes from so many bins beyond is heard, too, if only with its beginning.
    pub(super) fn empty(from: f64, to: f64, beyond: usize) -> Self {
        let bins = ((to - from) / Self::BIN).ceil() as usize + 1;
        Self { points: vec![[0.0; 2]; bins + beyond], waves: vec![[0.0; 2]; bins], heard: vec![0.0; bins] }
    }

    /// The pressure heard from each bin, of 1 a metre before the source.
    #[must_use]
    pub fn heard(&self) -> &[f64] {
        &self.heard
    }

    /// Takes over the points of another one.
    pub fn start_from(&mut self, other: &Self) {
        self.points.clone_from(&other.points);
    }

    /// Adds something to every second bin: what `noise` gives.
    pub fn disturb(&mut self, mut noise: impl FnMut() -> [f64; 2]) {
        for point in self.points.iter_mut().step_by(2) {
            let [re, im] = noise();
            *point = [point[0] + re, point[1] + im];
        }
    }

    /// A point becomes a pulse of this shape, with its middle in the middle; what is farther is weaker, from `from` \[m\] on.
    pub(super) fn pulse(&mut self, shape: &[f64], from: f64) {
        let half = shape.len() / 2;
        self.waves.fill([0.0; 2]);
        for (bin, [re, im]) in self.points.iter().copied().enumerate() {
            let first = bin.saturating_sub(half);
            let last = (bin + half + 1).min(self.waves.len());
            if first < last {
                let weights = &shape[first + half - bin..];
                for (wave, weight) in self.waves[first..last].iter_mut().zip(weights) {
                    *wave = [wave[0] + weight * re, wave[1] + weight * im];
                }
            }
        }
        let (mut left, each) = (Air::left(from), Air::left(Self::BIN));
        for (wave, heard) in self.waves.iter_mut().zip(&mut self.heard) {
            *wave = wave.map(|part| part * left);
            left *= each;
            *heard = (wave[0] * wave[0] + wave[1] * wave[1]).sqrt();
        }
    }

    /// Becomes what two others are together, as they were heard.
    pub fn join(&mut self, one: &Self, two: &Self) {
        for (heard, (a, b)) in self.heard.iter_mut().zip(one.waves.iter().zip(&two.waves)) {
            *heard = ((a[0] + b[0]).powi(2) + (a[1] + b[1]).powi(2)).sqrt();
        }
    }

    /// Where the pressure passes a threshold first, in bins, and how great it becomes before it falls again.
    pub(super) fn first(&self, threshold: f64) -> Option<(f64, f64)> {
        let over = self.heard.iter().position(|heard| *heard >= threshold)?;
        let mut peak = 0.0_f64;
        for heard in &self.heard[over..] {
            if *heard < 0.7 * peak {
                break;
            }
            peak = peak.max(*heard);
        }
        let [before, at] = [self.heard[over.saturating_sub(1)], self.heard[over]];
        let share = if over > 0 { (threshold - before) / (at - before) } else { 1.0 };
        Some((over as f64 - 1.0 + share, peak))
    }
}
