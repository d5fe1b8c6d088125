//! The servo regulator of MRROC++, one per motor, run every 2 ms on increments.
//!
//! With `r_k`, `y_k` the demanded and measured motor increments of a period \[pulses\]:
//!
//! ```text
//! eps_k = eps_{k-1} + 1.010 (r_k - y_k) - 0.990 (r_{k-1} - y_{k-1})
//! u_k   = (1 + a) u_{k-1} - a u_{k-2} + b0 eps_k - b1 eps_{k-1}
//! pwm   = u_k + k_ff r_{k+1}
//! ```
//!
//! `eps` is the proportional and derivative part of the following error; `u` integrates it through a lag. `k_ff` acts on
//! `r_{k+1}`, the next increment: that is an assumption, the gains are public facts of MRROC++. `u` and the pulse
//! width are limited to [`Regulator::PWM`].
//!
//! Each regulator has three parameter sets ([`RegulatorSet`]). The one without integration, algorithm 1 of MRROC++, has
//! `eps_k = r_k - y_k`, so that `u` answers the following error `e` alone,
//!
//! ```text
//! u = (b0 - b1 z^-1) / (1 - a z^-1) e,      at rest (b0 - b1) / (1 - a) e
//! ```
//!
//! counted from where the set was chosen: a change of sets keeps the pulse width that holds the load. The sets that
//! integrate bring the whole following error to 0.

use crate::models::Gains;

/// The parameter sets of a regulator, by their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RegulatorSet {
    /// 0: the gains of the robot.
    #[default]
    Usual,
    /// 1: half the gains `b0`, `b1`: half the stiffness against a push that is faster than the integration; against a
    /// lasting push it is as stiff as the usual set.
    Soft,
    /// 2: proportional and derivative action without integration: a lasting push displaces the joint, as it does a spring.
    Springy,
}

impl RegulatorSet {
    /// The set with that number.
    #[must_use]
    pub fn numbered(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Usual),
            1 => Some(Self::Soft),
            2 => Some(Self::Springy),
            _ => None,
        }
    }
}

/// One motor's regulator with its memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulator {
    gains: Gains,
    set: RegulatorSet,
    /// `e`, the following error: the sum of all deviations.
    following: f64,
    deviation: f64,
    error: f64,
    outputs: [f64; 2],
}

impl Regulator {
    /// Largest pulse width in either direction \[pwm\], which is the full supply voltage (assumed: 8 bits and a sign).
    pub const PWM: f64 = 255.0;

    /// Weight of the newest deviation in `eps` where it integrates.
    const NEWEST: f64 = 1.010;

    /// Weight of the deviation before that one.
    const BEFORE: f64 = 0.990;

    /// A regulator at rest that holds its load with the pulse width `holding` \[pwm\].
    #[must_use]
    pub fn holding(gains: Gains, holding: f64) -> Self {
        Self {
            gains,
            set: RegulatorSet::Usual,
            following: 0.0,
            deviation: 0.0,
            error: 0.0,
            outputs: [holding; 2],
        }
    }

    /// Goes on with another parameter set.
    pub fn choose(&mut self, set: RegulatorSet) {
        self.set = set;
        // The value that `eps` would have if this set had been in force from the beginning.
        self.error = match set {
            RegulatorSet::Usual | RegulatorSet::Soft => {
                Self::BEFORE * self.deviation + (Self::NEWEST - Self::BEFORE) * self.following
            }
            RegulatorSet::Springy => self.deviation,
        };
    }

    /// The parameter set in force.
    #[must_use]
    pub fn set(&self) -> RegulatorSet {
        self.set
    }

    /// One period: `deviation` is `r_k - y_k` and `next` is `r_{k+1}` \[pulses\]; returns the pulse width.
    #[must_use = "the pulse width drives the motor"]
    pub fn step(&mut self, deviation: f64, next: f64) -> f64 {
        let Gains { a, b0, b1, feedforward } = self.gains;
        let integrated = self.error + Self::NEWEST * deviation - Self::BEFORE * self.deviation;
        let (share, error) = match self.set {
            RegulatorSet::Usual => (1.0, integrated),
            RegulatorSet::Soft => (0.5, integrated),
            RegulatorSet::Springy => (1.0, deviation),
        };
        let [newer, older] = self.outputs;
        let output = (1.0 + a) * newer - a * older + share * (b0 * error - b1 * self.error);
        let output = output.clamp(-Self::PWM, Self::PWM);
        self.following += deviation;
        self.deviation = deviation;
        self.error = error;
        self.outputs = [output, newer];
        (output + feedforward * next).clamp(-Self::PWM, Self::PWM)
    }
}
