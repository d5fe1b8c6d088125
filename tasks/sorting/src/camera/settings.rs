//! What is run.

use super::clear::MARGIN;
use crate::generators::Uneven;

/// What is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Nominal speed of the belt [m/s]; the true one is up to 20 % off and wanders.
    pub speed: f64,
    /// Of parts, sensors and belt.
    pub seed: u64,
    /// How many parts come.
    pub parts: usize,
    /// Mean time between two parts \[s\].
    pub every: f64,
    /// How regularly they come: none less than this share of that time after another, the rest as Poisson's law says. 0: quite at random.
    pub regular: f64,
    /// Which of the strangers comes first, if any.
    pub stranger: Option<usize>,
    /// Every so many parts comes a stranger, and one that touches the part before it; 0: none.
    pub strangers: usize,
    /// See [`strangers`](Self::strangers).
    pub touching: usize,
    /// From when on \[s\] the belt goes at which share of its speed.
    pub profile: &'static [(f64, f64)],
    /// What is over the belt.
    pub overhead: Overhead,
    /// How many arms are at it, 1 or 2.
    pub arms: usize,
    /// Two arms that are nearer than this are stopped \[m\].
    pub margin: f64,
    /// An arm keeps so far from its limits that it may go on for this time before it brakes \[s\]; by default for as long as its EDP does.
    pub noticing: Option<f64>,
}

/// What is over the belt and tells of parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overhead {
    /// A camera.
    Camera,
    /// An ultrasonic matrix.
    Matrix,
}

impl Settings {
    /// Parts that come every so many seconds in the mean.
    #[must_use]
    pub const fn of(speed: f64, parts: usize, every: f64, seed: u64) -> Self {
        Self {
            speed,
            seed,
            parts,
            every,
            regular: Self::REGULAR,
            stranger: None,
            strangers: 0,
            touching: 0,
            profile: &[],
            overhead: Overhead::Camera,
            arms: 1,
            margin: MARGIN,
            noticing: None,
        }
    }

    /// The same with so many arms, 1 or 2.
    #[must_use]
    pub const fn by(self, arms: usize) -> Self {
        Self { arms, ..self }
    }

    /// The same with something else over the belt.
    #[must_use]
    pub const fn below(self, overhead: Overhead) -> Self {
        Self { overhead, ..self }
    }

    /// The time that the arm needs for a part in the mean: measured where parts never wait for it nor it for them \[s\].
    pub const CYCLE: f64 = 8.0;
    /// A feeder lets no two parts come within this share of the mean time between them.
    pub const REGULAR: f64 = 0.7;
    /// Parts are at least so far apart \[m\]; what edges send back must not run together.
    pub(super) const fn spacing(&self) -> f64 {
        match self.overhead {
            Overhead::Camera => 0.16,
            Overhead::Matrix => 0.2,
        }
    }

    /// When the first part comes \[s\]: the belt has its speed, and the camera has seen it empty.
    #[must_use]
    pub fn first(&self) -> f64 {
        2.0 + (1.0 + Uneven::OFF) * self.speed / Uneven::ACCELERATION
    }
}
