//! The force and torque sensor at a wrist: its raw measurement, and the virtual sensor that makes a reading of it.
//!
//! ```text
//! raw     = body's reaction + weight of the tool + bias + noise,  to the resolution     in S, the sensor's frame
//! reading = low-pass(raw - measured bias - weight of the tool, as e_j says it hangs)    in E, the tool's frame
//! ```
//!
//! The sensor sits between flange and tool, so the tool's weight is on it. It feels no inertia of the tool. E is the tool
//! frame of the robot's set-up and of its grasp, which must be the same.

use core::f64::consts::TAU;

use mrroc::fault::FaultKind;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::random::Noise;
use nalgebra::{UnitQuaternion, Vector3};

use crate::sensors::{Bias, WristForce, WristOrder};

use super::grip::Hand;

/// A simulated wrist sensor, on the hand of an arm in a [`World`](super::World).
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct SimulatedWrist {
    hand: Hand,
    X_ES: Pose,
    tool: Load,
    believed: Load,
    bias: Wrench,
    noise: (f64, f64),
    resolution: (f64, f64),
    range: Wrench,
    corner: Option<f64>,
    random: Noise,
    measured_bias: Bias,
    filtered: Option<(f64, Wrench)>,
}

/// A mass at the wrist.
#[derive(Clone, Copy, Debug)]
struct Load {
    /// \[kg\].
    mass: f64,
    /// Its centre \[m, in E\].
    centre: Vector3<f64>,
}

impl Load {
    /// Its weight at E, with E turned by `R_WE`.
    #[allow(non_snake_case)]
    fn weight(&self, gravity: &Vector3<f64>, R_WE: &UnitQuaternion<f64>) -> Wrench {
        let force = R_WE.inverse_transform_vector(&(gravity * self.mass));
        Wrench::new(force, self.centre.cross(&force))
    }
}

impl SimulatedWrist {
    /// Range along x, y, z \[N\] and about them [N m] (MRROC++).
    pub const RANGE: Wrench = Wrench::new(Vector3::new(65.0, 65.0, 130.0), Vector3::new(5.0, 5.0, 5.0));

    /// A sensor without bias, noise or filter, of the range [`RANGE`](Self::RANGE) and a resolution of 0.0125 N and 0.75 mN m
    /// (assumed), at a wrist whose tool weighs nothing.
    #[must_use]
    pub fn new(hand: Hand) -> Self {
        let nothing = Load { mass: 0.0, centre: Vector3::zeros() };
        Self {
            hand,
            X_ES: Pose::identity(),
            tool: nothing,
            believed: nothing,
            bias: Wrench::default(),
            noise: (0.0, 0.0),
            resolution: (0.0125, 7.5e-4),
            range: Self::RANGE,
            corner: None,
            random: Noise::seeded(0),
            measured_bias: Bias::default(),
            filtered: None,
        }
    }

    /// With its frame S at `X_ES` in the tool's.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(self, X_ES: Pose) -> Self {
        Self { X_ES, ..self }
    }

    /// With a tool of this mass \[kg\] centred at `centre` \[m, in E\], whose weight is compensated.
    #[must_use]
    pub fn with_tool(self, mass: f64, centre: Vector3<f64>) -> Self {
        let tool = Load { mass, centre };
        Self { tool, believed: tool, ..self }
    }

    /// Compensates the weight of another tool than the one that is there: an error of its identification.
    #[must_use]
    pub fn compensating(self, mass: f64, centre: Vector3<f64>) -> Self {
        Self { believed: Load { mass, centre }, ..self }
    }

    /// With this bias, in S: it is there until it is measured ([`WristOrder::MeasureBias`]) or known.
    #[must_use]
    pub fn with_bias(self, bias: Wrench) -> Self {
        Self { bias, ..self }
    }

    /// Subtracts this bias, in S, without measuring it.
    #[must_use]
    pub fn knowing_bias(self, bias: Wrench) -> Self {
        Self { measured_bias: Bias::known(bias), ..self }
    }

    /// With Gaussian noise of these standard deviations \[N\] and [N m], from `seed`.
    #[must_use]
    pub fn with_noise(self, force: f64, torque: f64, seed: u64) -> Self {
        Self { noise: (force, torque), random: Noise::seeded(seed), ..self }
    }

    /// With this resolution \[N\] and [N m], each > 0.
    #[must_use]
    pub fn with_resolution(self, force: f64, torque: f64) -> Self {
        Self { resolution: (force, torque), ..self }
    }

    /// With this range, in S: beyond it the sensor gives a fault instead of a reading.
    #[must_use]
    pub fn with_range(self, range: Wrench) -> Self {
        Self { range, ..self }
    }

    /// With a low-pass filter of first order and this corner frequency \[Hz\], > 0.
    #[must_use]
    pub fn with_low_pass(self, corner: f64) -> Self {
        Self { corner: Some(corner), ..self }
    }

    /// Whether all figures are in their ranges.
    fn check_settings(&self) -> Result<(), Fault> {
        let is_positive = |value: f64| value > 0.0 && value.is_finite();
        let resolves = is_positive(self.resolution.0) && is_positive(self.resolution.1);
        let spreads = self.noise.0 >= 0.0 && self.noise.1 >= 0.0;
        if resolves && spreads && self.corner.is_none_or(is_positive) {
            return Ok(());
        }
        let text = "a wrist sensor needs resolutions and a corner frequency above 0, and noise of 0 or more";
        Err(Fault::new(FaultKind::Config).text(text))
    }

    /// The raw measurement of the strain gauges, in S.
    #[allow(non_snake_case)]
    fn raw(&mut self) -> Wrench {
        let weight = self.tool.weight(&self.hand.world().gravity(), &self.hand.pose().rotation);
        let load = self.hand.reaction() + weight;
        let mut raw = load.moved(&self.X_ES.inverse()) + self.bias;
        let measured = |values: &mut Vector3<f64>, deviation: f64, resolution: f64, random: &mut Noise| {
            for value in values.iter_mut() {
                if deviation > 0.0 {
                    *value += deviation * random.normal();
                }
                *value = (*value / resolution).round() * resolution;
            }
        };
        measured(&mut raw.force, self.noise.0, self.resolution.0, &mut self.random);
        measured(&mut raw.torque, self.noise.1, self.resolution.1, &mut self.random);
        raw
    }

    /// Whether each component lies within the range.
    fn check(&self, raw: &Wrench) -> Result<(), Fault> {
        const NAMES: [&str; 3] = ["along x", "along y", "along z"];
        const ABOUT: [&str; 3] = ["about x", "about y", "about z"];
        let forces = (&raw.force, &self.range.force, NAMES, "N");
        let torques = (&raw.torque, &self.range.torque, ABOUT, "N m");
        for (values, limits, names, unit) in [forces, torques] {
            for ((&value, &limit), name) in values.iter().zip(limits.iter()).zip(names) {
                // Also true for NaN.
                let is_within = value.abs() <= limit;
                if !is_within {
                    let fault = Fault::new(FaultKind::SensorFailed).exceeds(value.abs(), limit, unit);
                    return Err(fault.text(&format!("the wrist sensor saturates {name} of its frame")));
                }
            }
        }
        Ok(())
    }

    /// The low-pass filter, `y + (1 - exp(-2 pi f t)) (x - y)` after the time t.
    fn filter(&mut self, value: Wrench) -> Wrench {
        let now = self.hand.world().time();
        let filtered = match (self.corner, self.filtered) {
            (Some(corner), Some((before, last))) => {
                last + (value - last) * -(-TAU * corner * (now - before)).exp_m1()
            }
            _ => value,
        };
        self.filtered = Some((now, filtered));
        filtered
    }
}

impl VirtualSensor for SimulatedWrist {
    type Kind = WristForce;

    #[allow(non_snake_case)]
    fn aggregate(&mut self, order: &ReadingOrder<WristOrder>) -> Result<Wrench, Fault> {
        let arm = order.robot.ok_or_else(|| {
            Fault::thrown("a wrist sensor must know how its tool hangs: give it its arm, `SensorSetup::of`")
        })?;
        self.check_settings()?;
        let raw = self.raw();
        self.check(&raw)?;
        let weight = self.believed.weight(&self.hand.world().gravity(), &arm.pose.rotation);
        match order.configuration {
            WristOrder::Read => self.measured_bias.read(),
            WristOrder::MeasureBias => {
                self.measured_bias.measure(raw - weight.moved(&self.X_ES.inverse()));
                // Readings with the old bias must not be smoothed into those with the new one.
                self.filtered = None;
            }
        }
        let reading = (raw - self.measured_bias.value).moved(&self.X_ES) - weight;
        Ok(self.filter(reading))
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
