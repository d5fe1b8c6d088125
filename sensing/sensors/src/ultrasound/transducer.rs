//! A transducer that sends a ping and hears what comes back.

use core::f64::consts::TAU;

use super::{Air, Echo, Piston, Waveform};

/// A part of the directions of a transducer: those of the rays (u, v, 1) of its frame T, whose z is its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// From, to.
    pub u: [f64; 2],
    /// From, to.
    pub v: [f64; 2],
}

impl Window {
    /// All directions that matter: to 48° to each side.
    pub const ALL: Self = Self { u: [-1.1, 1.1], v: [-1.1, 1.1] };
}

/// Where a ray (u, v, 1) of a transducer meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// In lengths of the ray: along the axis \[m\].
    pub depth: f64,
    /// How that changes with u and with v there \[m\].
    pub slope: [f64; 2],
}

impl Surface {
    /// One that faces the transducer at a depth \[m\].
    #[must_use]
    pub const fn facing(depth: f64) -> Self {
        Self { depth, slope: [0.0; 2] }
    }
}

/// A transducer with its pulse and its detector, in air of a temperature.
#[derive(Clone, Debug)]
pub struct Transducer {
    piston: Piston,
    air: Air,
    /// What is listened to \[m\].
    gate: [f64; 2],
    threshold: f64,
    /// Squares of the directivity over the square of the sine.
    beam: Vec<f64>,
    /// cos and -sin over a turn.
    turn: Vec<[f64; 2]>,
    /// sin(x) / x, so many to the unit.
    sinc: Vec<f64>,
    /// The pulse, in bins, its middle in the middle.
    shape: Vec<f64>,
}

impl Transducer {
    /// Standard deviation of the pulse, a Gaussian burst \[s\].
    pub const PULSE: f64 = 50e-6;
    const BEAM: usize = 1024;
    const TURN: usize = 4096;
    /// Entries for each unit of x, and up to which x. Between them, linearly, sin(x) / x is off by at most 1e-6.
    const SINC: (f64, usize) = (256.0, 16);

    /// In air of this temperature; it listens to what comes from these ranges \[m\], and reports what passes a pressure, of 1 a metre before the source.
    #[must_use]
    pub fn new(piston: Piston, air: Air, gate: [f64; 2], threshold: f64) -> Self {
        let k = TAU * piston.frequency / air.speed();
        let square = |i: usize| piston.directivity(i as f64 / Self::BEAM as f64, k).powi(2);
        let turn = |i: usize| (i as f64 / Self::TURN as f64 * TAU).sin_cos();
        let sigma = 0.5 * air.speed() * Self::PULSE / Waveform::BIN;
        let half = (3.5 * sigma) as usize;
        let shape = |i: usize| (-0.5 * ((i as f64 - half as f64) / sigma).powi(2)).exp();
        let (each, most) = Self::SINC;
        let sinc = |i: usize| if i == 0 { 1.0 } else { (i as f64 / each).sin() / (i as f64 / each) };
        Self {
            piston,
            air,
            gate,
            threshold,
            beam: (0..=Self::BEAM + 1).map(square).collect(),
            turn: (0..Self::TURN).map(turn).map(|(sin, cos)| [cos, -sin]).collect(),
            sinc: (0..=each as usize * most).map(sinc).collect(),
            shape: (0..=2 * half).map(shape).collect(),
        }
    }

    /// The air it is in.
    #[must_use]
    pub const fn air(&self) -> Air {
        self.air
    }

    /// The same in other air.
    #[must_use]
    pub fn in_air(&self, air: Air) -> Self {
        Self::new(self.piston, air, self.gate, self.threshold)
    }

    /// What its detector reports \[pressure, of 1 a metre before the source\].
    #[must_use]
    pub const fn threshold(&self) -> f64 {
        self.threshold
    }

    /// What is listened to \[m\].
    #[must_use]
    pub const fn gate(&self) -> [f64; 2] {
        self.gate
    }

    /// Wave number [1/m].
    #[must_use]
    pub fn wave_number(&self) -> f64 {
        TAU * self.piston.frequency / self.air.speed()
    }

    /// The sum of the squares of the pulse, over its bins: by how much it raises the power of noise.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.shape.iter().map(|w| w * w).sum()
    }

    /// Silence.
    #[must_use]
    pub fn silence(&self) -> Waveform {
        Waveform::empty(self.gate[0], self.gate[1], self.shape.len() / 2)
    }

    /// Adds what comes back from a part of its directions, in steps of `step`. `meet` says of a ray (u, v, 1) where it meets something, and
    /// where it would meet what is behind, of which that is taken off.
    ///
    /// A ray stands for a cell of directions, over which the surface is plane. The phase `2 k r` changes evenly over it, so that the mean of the
    /// wave is that of the ray times
    ///
    /// ```text
    /// sinc(k dr/du step) sinc(k dr/dv step)        sinc(x) = sin(x) / x
    /// ```
    ///
    /// Without it rays that are more than a quarter of a wave apart along the sound make up echoes of surfaces that are steep and silent.
    pub fn add(
        &self,
        wave: &mut Waveform,
        window: Window,
        step: f64,
        meet: impl Fn(f64, f64) -> (Option<Surface>, Option<Surface>),
    ) {
        let k = self.wave_number();
        let pressure = k / TAU * step * step;
        let turns = 2.0 * k / TAU * Self::TURN as f64;
        let aligned = |[from, to]: [f64; 2]| ((from / step).floor() as i64, (to / step).ceil() as i64);
        let ((u0, u1), (v0, v1)) = (aligned(window.u), aligned(window.v));
        let place = |i: i64| (i as f64 + 0.5) * step;
        for u in (u0..u1).map(place) {
            for v in (v0..v1).map(place) {
                let (hit, behind) = meet(u, v);
                if hit.is_none() && behind.is_none() || hit == behind {
                    continue;
                }
                let square = 1.0 + u * u + v * v;
                let length = square.sqrt();
                let at = (1.0 - 1.0 / square) * Self::BEAM as f64;
                let low = at as usize;
                let share = at - low as f64;
                let beam = self.beam[low] + share * (self.beam[low + 1] - self.beam[low]);
                let amplitude = pressure * beam / (square * length);
                let mut put = |Surface { depth, slope }: Surface, amplitude: f64| {
                    let range = depth * length;
                    let at = (range - self.gate[0]) / Waveform::BIN;
                    if at < 0.0 || at as usize + 1 >= wave.points.len() {
                        return;
                    }
                    let across =
                        |at: f64, slope: f64| self.sinc(k * step * (slope * length + depth * at / length));
                    let amplitude = amplitude * across(u, slope[0]) * across(v, slope[1]);
                    let [cos, sin] = self.turn[(range * turns) as usize % Self::TURN];
                    let low = at as usize;
                    let share = at - low as f64;
                    for (bin, share) in [(low, 1.0 - share), (low + 1, share)] {
                        let [re, im] = &mut wave.points[bin];
                        *re += amplitude * share * cos;
                        *im += amplitude * share * sin;
                    }
                };
                if let Some(surface) = hit {
                    put(surface, amplitude);
                }
                if let Some(surface) = behind {
                    put(surface, -amplitude);
                }
            }
        }
    }

    /// sin(x) / x; 0 of a surface that lies along the ray, whose depth changes by any amount.
    fn sinc(&self, x: f64) -> f64 {
        let (each, most) = Self::SINC;
        let at = x.abs() * each;
        if at < each * most as f64 {
            let low = at as usize;
            self.sinc[low] + (at - low as f64) * (self.sinc[low + 1] - self.sinc[low])
        } else if x.is_finite() {
            x.sin() / x
        } else {
            0.0
        }
    }

    /// What is heard, and its first echo.
    pub fn hear(&self, wave: &mut Waveform, gain: f64) -> Option<Echo> {
        wave.pulse(&self.shape, self.gate[0]);
        self.detect(wave, gain)
    }

    /// The first echo in what was heard, so many times as loud.
    #[must_use]
    pub fn detect(&self, wave: &Waveform, gain: f64) -> Option<Echo> {
        let (bins, amplitude) = wave.first(self.threshold / gain)?;
        let range = self.gate[0] + bins * Waveform::BIN;
        Some(Echo { time: 2.0 * range / self.air.speed(), amplitude: amplitude * gain })
    }

    /// When the middle of an echo came \[s\]: a weak one passes the threshold later than a strong one. That is its walk, which is known of
    /// a Gaussian burst.
    #[must_use]
    pub fn middle(&self, echo: &Echo) -> f64 {
        let over = (echo.amplitude / self.threshold).max(1.0);
        echo.time + Self::PULSE * (2.0 * over.ln()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_sin_x_by_x_and_a_surface_along_the_ray_sends_nothing() {
        let transducer = Transducer::new(Piston::SMALL, Air { celsius: 20.0 }, [0.2, 0.3], 0.1);
        let most = (1..40_000)
            .map(|i| f64::from(i) * 1e-3 - 20.0005)
            .map(|x| (transducer.sinc(x) - x.sin() / x).abs())
            .fold(0.0, f64::max);
        assert!(most < 1e-6, "{most}");
        assert_eq!(transducer.sinc(0.0), 1.0);
        assert!([f64::INFINITY, f64::NAN].iter().all(|x| transducer.sinc(*x) == 0.0));
    }
}
