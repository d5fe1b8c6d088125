//! One simulated drive: a voltage-fed DC motor with its load, its friction, its brake and its encoder.
//!
//! ```text
//! i      = (U - ke omega) / R,  U = 96 V pwm / 255,      limited by `Overload`
//! J alpha = kt i - b omega - tau_load - tau_c sign(omega),      alpha = 0 in stiction
//! ```
//!
//! Integrated with [`Plant::SUBSTEPS`] implicit steps of length h per servo period: current, viscous and Coulomb
//! friction are those at the step's *end*, and the shaft turns by `h omega` of that moment. With `kt = ke` each step then
//! keeps, exactly,
//!
//! ```text
//! J omega'^2 / 2 - J omega^2 / 2 = h (U_m i - R i^2 - b omega'^2 - tau_load omega' - tau_f omega') - J (omega' - omega)^2 / 2
//! ```
//!
//! where `U_m = R i + ke omega'` is the voltage at the motor (`U`, unless the current is limited) and `tau_f omega' >= 0`
//! the power that Coulomb friction takes. The last term is energy that the integration loses: it never creates any. A motor
//! in stiction stands exactly still. The armature's inductance is left out: the current follows the voltage at once.
//! Coupling inertias between the links are left out; their weight comes in as `tau_load`. [`Coupling`] takes them in.

mod coupled;
#[cfg(test)]
mod tests;

pub(super) use coupled::Coupling;

use super::regulator::Regulator;
use crate::models::{MotorData, Overload};

/// Servo period \[s\] (MRROC++).
pub(crate) const PERIOD: f64 = 0.002;

/// Supply voltage at full pulse width \[V\] (assumed).
const SUPPLY: f64 = 96.0;

/// Largest current of the amplifier, as a multiple of the lasting current (assumed).
const PEAK: f64 = 2.0;

/// Length of one integration step \[s\].
const H: f64 = PERIOD / Plant::SUBSTEPS as f64;

/// State of one simulated drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    angle: f64,
    speed: f64,
    current: f64,
    jammed: bool,
    model: Model,
}

/// Coefficients of one integration step, with torques given as the changes of speed that they cause in it [rad/s].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Model {
    current_per_pwm: f64,
    current_per_speed: f64,
    peak: f64,
    speed_per_current: f64,
    viscous: f64,
    speed_per_load: f64,
    friction: f64,
    brake: f64,
}

impl Plant {
    /// Integration steps per servo period.
    pub const SUBSTEPS: usize = 4;

    /// A drive at rest at a shaft angle \[rad\].
    #[must_use]
    pub fn at_rest(data: &MotorData, angle: f64) -> Self {
        Self {
            angle,
            speed: 0.0,
            current: 0.0,
            jammed: false,
            model: Model {
                current_per_pwm: SUPPLY / (Regulator::PWM * data.resistance),
                current_per_speed: data.torque_constant / data.resistance,
                peak: match data.overload {
                    Overload::Trip => PEAK * data.current_limit,
                    Overload::Limit => data.current_limit,
                },
                speed_per_current: data.torque_constant * H / data.inertia,
                viscous: data.viscous * H / data.inertia,
                speed_per_load: H / data.inertia,
                friction: data.coulomb * H / data.inertia,
                brake: data.brake * H,
            },
        }
    }

    /// The pulse width \[pwm\] that balances a load torque [N m] at rest.
    #[must_use]
    pub fn holding(&self, load: f64) -> f64 {
        load * self.model.speed_per_load / (self.model.speed_per_current * self.model.current_per_pwm)
    }

    /// One servo period with the pulse width `pwm` against the load torque `load` [N m] (positive: against
    /// positive motion).
    pub fn run(&mut self, pwm: f64, load: f64) {
        if self.jammed {
            self.speed = 0.0;
            self.current = self.current_at(pwm);
            return;
        }
        for _ in 0..Self::SUBSTEPS {
            self.step(pwm, load);
        }
    }

    /// One integration step. The torque falls with the speed at the step's end, so exactly one speed solves the equation;
    /// its sign is that of the torque at standstill.
    fn step(&mut self, pwm: f64, load: f64) {
        let model = &self.model;
        let free = self.speed - model.speed_per_load * load;
        let pushed = free + model.speed_per_current * self.limited(model.current_per_pwm * pwm);
        self.speed = if pushed.abs() <= model.friction {
            0.0
        } else {
            let free = free - model.friction.copysign(pushed);
            let back = 1.0 + model.viscous + model.speed_per_current * model.current_per_speed;
            let speed = (free + model.speed_per_current * model.current_per_pwm * pwm) / back;
            let current = model.current_per_pwm * pwm - model.current_per_speed * speed;
            let limited = self.limited(current);
            if limited == current {
                speed
            } else {
                (free + model.speed_per_current * limited) / (1.0 + model.viscous)
            }
        };
        self.current = self.current_at(pwm);
        self.angle += H * self.speed;
    }

    /// One servo period without power and with the brake applied.
    pub fn brake(&mut self) {
        self.current = 0.0;
        for _ in 0..Self::SUBSTEPS {
            self.speed = if self.jammed { 0.0 } else { towards_zero(self.speed, self.model.brake) };
            self.angle += H * self.speed;
        }
    }

    /// Jams the shaft where it is, or frees it.
    pub fn set_jammed(&mut self, jammed: bool) {
        self.jammed = jammed;
    }

    /// True shaft angle \[rad\].
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// True shaft speed [rad/s].
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Armature current \[A\].
    #[must_use]
    pub fn current(&self) -> f64 {
        self.current
    }

    fn current_at(&self, pwm: f64) -> f64 {
        self.limited(self.model.current_per_pwm * pwm - self.model.current_per_speed * self.speed)
    }

    /// A current, limited to what the amplifier gives \[A\].
    fn limited(&self, current: f64) -> f64 {
        current.clamp(-self.model.peak, self.model.peak)
    }
}

/// `value` moved towards zero by `by`, and not beyond it.
fn towards_zero(value: f64, by: f64) -> f64 {
    (value.abs() - by).max(0.0).copysign(value)
}
