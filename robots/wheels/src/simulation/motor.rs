//! A geared motor of the base: the equations of [`mrroc_robots::Plant`], in shorter steps, because tyres answer faster than a servo period.
//!
//! ```text
//! i = (U - ke omega) / R,   U = 7.4 V pwm / 255,   |i| <= the amplifier's peak
//! J alpha = kt i - b omega - tau_load - tau_c sign(omega),   alpha = 0 in stiction
//! ```
//!
//! Implicit, as there: one step has exactly one solution, and creates no energy.

use mrroc_robots::{MotorData, Regulator};

/// Supply voltage at full pulse width: two lithium cells \[V\].
const SUPPLY: f64 = 7.4;

/// Largest current of the amplifier, as a multiple of the lasting current.
const PEAK: f64 = 2.0;

/// A motor with its friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Angle of its shaft \[rad\].
    pub angle: f64,
    /// Its speed [rad/s].
    pub speed: f64,
    /// Current through it \[A\].
    pub current: f64,
}

impl Motor {
    /// At rest at an angle \[rad\].
    #[must_use]
    pub const fn at_rest(angle: f64) -> Self {
        Self { angle, speed: 0.0, current: 0.0 }
    }

    /// One step of `h` \[s\] with a pulse width \[pwm\] against a torque at its shaft [N m], of a motor whose rotor and wheel have
    /// `inertia` at the shaft [kg m²].
    pub fn step(&mut self, data: &MotorData, inertia: f64, pwm: f64, load: f64, h: f64) {
        let per_torque = h / inertia;
        let per_current = data.torque_constant * per_torque;
        let viscous = data.viscous * per_torque;
        let peak = PEAK * data.current_limit;
        let limited = |current: f64| current.clamp(-peak, peak);
        let standing = SUPPLY * pwm / (Regulator::PWM * data.resistance);
        let back = data.torque_constant / data.resistance;
        let free = self.speed - per_torque * load;
        let pushed = free + per_current * limited(standing);
        let friction = data.coulomb * per_torque;
        self.speed = if pushed.abs() <= friction {
            0.0
        } else {
            let free = free - friction.copysign(pushed);
            let speed = (free + per_current * standing) / (1.0 + viscous + per_current * back);
            let current = standing - back * speed;
            if limited(current) == current {
                speed
            } else {
                (free + per_current * limited(current)) / (1.0 + viscous)
            }
        };
        self.current = limited(standing - back * self.speed);
        self.angle += h * self.speed;
    }

    /// One step of `h` \[s\] without power and with its brake.
    pub fn brake(&mut self, data: &MotorData, h: f64) {
        self.current = 0.0;
        self.speed = (self.speed.abs() - data.brake * h).max(0.0).copysign(self.speed);
        self.angle += h * self.speed;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::Rolling;
    use mrroc_robots::Plant;

    #[test]
    fn with_its_wheel_in_the_air_it_runs_as_the_plant_of_the_arms_does() {
        // The plant is fed with 96 V: the same volts by fewer pulses. Its steps are 0.5 ms, and it is of the first order in them.
        let data = MotorData { inertia: 1.26e-7, ..Rolling::MOTOR };
        let (mut motor, mut plant) = (Motor::at_rest(0.0), Plant::at_rest(&data, 0.0));
        for k in 0..200 {
            let volts = 5.0 * (0.02 * f64::from(k)).sin();
            let load = 1e-4;
            plant.run(volts * Regulator::PWM / 96.0, load);
            for _ in 0..4 {
                motor.step(&data, data.inertia, volts * Regulator::PWM / SUPPLY, load, 5e-4);
            }
            assert!((motor.speed - plant.speed()).abs() < 1e-9 && (motor.angle - plant.angle()).abs() < 1e-9);
            assert!((motor.current - plant.current()).abs() < 1e-9);
        }
        assert!(motor.angle > 10.0, "it has moved: {}", motor.angle);
    }
}
