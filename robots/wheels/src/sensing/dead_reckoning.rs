//! Where the base stands, from its wheels and its gyro: gyrodometry.
//!
//! ```text
//! standing (no wheel turned for 0.1 s)   heading stays;  bias := mean of what the gyro says
//! moving                                 heading += gyro - bias dt;   distance += r (dq_L + dq_R) / 2 along it
//! told apart                             d := d exp(-dt / 0.5 s) + (gyro - bias dt) - r (dq_R - dq_L) / b
//! ```
//!
//! Wheels slip when the base turns, a gyro drifts: so the heading is the gyro's, its bias what it says in standstills, and the distance that
//! of the wheels (Borenstein and Feng, *Gyrodometry*, 1996). What both say of a turn is compared: they disagree by the tyres' slip, a few
//! hundredths of the turn. Disagreeing by more than [`DeadReckoning::MOST`] within about half a second, one of both cannot be
//! believed, and with it the heading. A wheel that slips straight ahead is not seen by this.

use super::gyro::Turned;
use super::planar::Planar;
use crate::model::{DiffDrive, Two};

/// Where the base should be by what it measured of its own motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadReckoning {
    pose: Planar,
    wheels: Option<Two>,
    /// What the gyro says at rest [rad/s], once that is known.
    bias: Option<f64>,
    /// Where the wheels came to rest.
    rest: Option<Two>,
    /// How long no wheel has turned \[s\], and what the gyro said in that time \[rad\].
    still: f64,
    drifted: f64,
    apart: f64,
    /// How far the base goes for a metre that its wheels turn, as a share: less than 1 where they slip.
    scale: f64,
}

/// What came of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reckoned {
    /// Where it stands.
    pub pose: Planar,
    /// How far it went \[m\].
    pub distance: f64,
    /// How far it turned \[rad\].
    pub turn: f64,
    /// How far gyro and wheels are apart about a turn \[rad\].
    pub apart: f64,
    /// Whether it stands, and has for so long that the gyro's bias is known.
    pub stands: bool,
}

impl DeadReckoning {
    /// How long no wheel turns where it stands \[s\].
    pub const STILL: f64 = 0.1;
    /// How far a wheel turns that rests \[rad\]: two pulses of its encoder.
    const TREMBLING: f64 = 6.2e-4;
    /// Gyro and wheels may be so far apart \[rad\].
    pub const MOST: f64 = 0.35;
    /// For how long they are compared \[s\].
    const COMPARED: f64 = 0.5;

    /// From a pose on.
    #[must_use]
    pub const fn from(pose: Planar) -> Self {
        Self { pose, wheels: None, bias: None, rest: None, still: 0.0, drifted: 0.0, apart: 0.0, scale: 1.0 }
    }

    /// The same with a calibrated distance, as a share of what the wheels turn, > 0.
    #[must_use]
    pub const fn with_scale(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// The bias that it has found [rad/s].
    #[must_use]
    pub const fn bias(&self) -> Option<f64> {
        self.bias
    }

    /// Where it stands.
    #[must_use]
    pub const fn pose(&self) -> Planar {
        self.pose
    }

    /// It is known better where it stands.
    pub fn correct(&mut self, pose: Planar) {
        self.pose = pose;
    }

    /// One step: the wheels are at these angles \[rad\], and the gyro said so much.
    pub fn step(&mut self, wheels: &Two, gyro: &Turned) -> Reckoned {
        let moved = *wheels - self.wheels.replace(*wheels).unwrap_or(*wheels);
        let (distance, turn_of_wheels) = DiffDrive::rolled(&moved);
        let distance = self.scale * distance;
        // Encoders tremble by a pulse; a base that creeps leaves that behind.
        let is_still = (*wheels - *self.rest.get_or_insert(*wheels)).amax() < Self::TREMBLING;
        if is_still {
            self.still += gyro.time;
            self.drifted += gyro.angle;
        } else {
            (self.still, self.drifted, self.rest) = (0.0, 0.0, Some(*wheels));
        }
        let stands = is_still && self.still >= Self::STILL;
        if stands {
            self.bias = Some(self.drifted / self.still);
        }
        // Before the bias is known, what the gyro says of a base that stands is bias.
        let turn = match self.bias {
            Some(bias) if !stands => gyro.angle - bias * gyro.time,
            None if !is_still => gyro.angle,
            Some(_) | None => 0.0,
        };
        self.apart = self.apart * (-gyro.time / Self::COMPARED).exp() + turn - turn_of_wheels;
        self.pose = self.pose.moved(distance, turn);
        Reckoned { pose: self.pose, distance, turn, apart: self.apart, stands: stands && self.bias.is_some() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bias_is_found_in_a_standstill_and_turns_no_heading_after_it() {
        let mut reckoning = DeadReckoning::from(Planar::default());
        let gyro = |turn: f64| Turned { angle: turn + 0.03 * 0.004, time: 0.004 };
        for _ in 0..100 {
            reckoning.step(&Two::zeros(), &gyro(0.0));
        }
        assert!((reckoning.bias().expect("it stood") - 0.03).abs() < 1e-12);
        // A quarter of a circle of 0.2 m, as wheels and gyro see it.
        let turn = core::f64::consts::FRAC_PI_2;
        for k in 1..=1000 {
            let share = f64::from(k) / 1000.0;
            reckoning.step(&DiffDrive::wheels(0.2 * turn * share, turn * share), &gyro(turn / 1000.0));
        }
        let pose = reckoning.pose();
        assert!((pose.at() - nalgebra::Vector2::new(0.2, 0.2)).norm() < 1e-9, "{pose:?}");
        assert!((pose.heading - turn).abs() < 1e-9);
    }
}
