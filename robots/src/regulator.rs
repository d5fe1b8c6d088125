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
//! `eps` is the following error's proportional and derivative part, the first line of `u` integrates it
//! through a lag. `r_{k+1}`, the increment to be made next, is what `k_ff` acts on: that pairing is an
//! assumption, the gains are public facts of MRROC++. `u` and the pulse width are limited to [`Regulator::PWM`].

/// Gains of one regulator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Pole of the lag, 0 to 1.
    pub a: f64,
    /// Gain of the newest error [pwm/pulse].
    pub b0: f64,
    /// Gain of the error before [pwm/pulse].
    pub b1: f64,
    /// Feed-forward of the demanded increment `k_ff` [pwm per pulse and period].
    pub feedforward: f64,
}

/// One motor's regulator with its memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulator {
    gains: Gains,
    deviation: f64,
    error: f64,
    outputs: [f64; 2],
}

impl Regulator {
    /// Largest pulse width either way \[pwm\], which is the full supply voltage (assumed: 8 bits and a sign).
    pub const PWM: f64 = 255.0;

    /// A regulator at rest that holds its load with the pulse width `holding` \[pwm\].
    #[must_use]
    pub fn holding(gains: Gains, holding: f64) -> Self {
        Self { gains, deviation: 0.0, error: 0.0, outputs: [holding; 2] }
    }

    /// One period: `deviation` is `r_k - y_k` and `next` is `r_{k+1}` \[pulses\]; returns the pulse width.
    #[must_use = "the pulse width drives the motor"]
    pub fn step(&mut self, deviation: f64, next: f64) -> f64 {
        let Gains { a, b0, b1, feedforward } = self.gains;
        let error = self.error + 1.010 * deviation - 0.990 * self.deviation;
        let [newer, older] = self.outputs;
        let output = (1.0 + a) * newer - a * older + b0 * error - b1 * self.error;
        let output = output.clamp(-Self::PWM, Self::PWM);
        self.deviation = deviation;
        self.error = error;
        self.outputs = [output, newer];
        (output + feedforward * next).clamp(-Self::PWM, Self::PWM)
    }
}
