//! The IRp-6 by its physical parameters: lengths of links, zeros of gears, and the triangles of its two ball screws.
//!
//! A screw of length l turns a crank c about the joint, and stands on the arm at a distance b from it:
//!
//! ```text
//! l^2 = b^2 + c^2 + 2 b c cos(theta + phi),    l = l0 + (5 mm / 2 pi) (m - s)
//! ```
//!
//! so `L = b^2 + c^2`, `mu = 2 b c cos phi`, `nu = 2 b c sin phi` of [`mrroc_robots::Screw`]. What encoders read are the motors' angles from
//! their marks; joint positions are what programs make of them with the dimensions that they believe.

use mrroc::pose::Pose;
use mrroc::robot::Robot;
use mrroc_robots::{Irp6, Screw, Six};

use crate::arm::Arm;
use crate::parameter::{Parameter, Unit};

/// How far lengths may be off \[m\]: the arm's own were found 4.6 to 9.7 mm longer than designed.
const LENGTH: f64 = 5e-3;

/// How far directions and zeros may be off \[rad\]: the arm's own, up to 0.09.
const ANGLE: f64 = 0.05;

/// The triangle of a ball screw.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Triangle {
    /// From the joint to where the screw stands, and to where it pulls \[m\].
    base: f64,
    crank: f64,
    /// Where they lie in one line \[rad\].
    direction: f64,
    /// The screw's length at the mark \[m\].
    length: f64,
}

impl Triangle {
    fn of(screw: &Screw) -> Self {
        let twice = screw.mu.hypot(screw.nu);
        let (sum, difference) = ((screw.square + twice).sqrt(), (screw.square - twice).sqrt());
        Self {
            base: 0.5e-3 * (sum + difference),
            crank: 0.5e-3 * (sum - difference),
            direction: screw.nu.atan2(screw.mu),
            length: 1e-3 * screw.reference,
        }
    }

    fn screw(&self, synchro: f64) -> Screw {
        let twice = 2e6 * self.base * self.crank;
        Screw {
            synchro,
            square: 1e6 * (self.base * self.base + self.crank * self.crank),
            mu: twice * self.direction.cos(),
            nu: twice * self.direction.sin(),
            reference: 1e3 * self.length,
        }
    }

    fn moved(&self, by: &[f64]) -> Self {
        Self {
            base: self.base + by[0],
            crank: self.crank + by[1],
            direction: self.direction + by[2],
            length: self.length + by[3],
        }
    }
}

/// An IRp-6 with its 15 parameters, at what programs believe its joint positions to be.
#[derive(Clone, Debug)]
pub struct Irp6Arm {
    believed: Irp6,
    parameters: Vec<Parameter>,
}

impl Irp6Arm {
    /// The arm that programs believe in; its base counts for nothing here.
    #[must_use]
    pub fn new(believed: Irp6) -> Self {
        let length = |name: &str| Parameter::new(name, Unit::Metre).within(LENGTH);
        let angle = |name: &str| Parameter::new(name, Unit::Radian).within(ANGLE);
        let mut parameters: Vec<Parameter> = ["lower link", "upper link", "wrist link"].map(length).into();
        parameters.extend(["column zero", "T zero", "V zero", "N zero"].map(|name| angle(name).important(8)));
        for screw in ["lower screw", "upper screw"] {
            parameters.extend([
                length(&format!("{screw} base")),
                length(&format!("{screw} crank")),
                angle(&format!("{screw} direction")),
                length(&format!("{screw} length")),
            ]);
        }
        Self { believed: believed.with_base(Pose::identity()), parameters }
    }

    /// The arm with these values of its parameters, its base at the world's origin. Its encoders have the marks of the believed one.
    #[must_use]
    pub fn with(&self, values: &[f64]) -> Irp6 {
        let [a2, a3, d5] = self.believed.lengths();
        let mut drives = *self.believed.transmission();
        let by = |i: usize| values.get(i).copied().unwrap_or(0.0);
        drives.column.offset += by(3);
        drives.t.offset += by(4);
        drives.v.offset += by(5);
        drives.n.offset += by(6);
        for (screw, first) in [(&mut drives.lower, 7), (&mut drives.upper, 11)] {
            let moved = [by(first), by(first + 1), by(first + 2), by(first + 3)];
            *screw = Triangle::of(screw).moved(&moved).screw(screw.synchro);
        }
        self.believed.clone().with_dimensions([a2 + by(0), a3 + by(1), d5 + by(2)], drives)
    }

    /// The joint positions of the arm with these values \[rad\], where programs believe it to be at `q` \[rad\].
    #[must_use]
    pub fn joints_of(&self, arm: &Irp6, q: &Six) -> Six {
        arm.transmission().joints(&self.believed.transmission().motors(q))
    }
}

impl Arm for Irp6Arm {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn joints(&self) -> usize {
        6
    }

    fn flange(&self, q: &[f64], values: &[f64]) -> Pose {
        let arm = self.with(values);
        arm.forward(&self.joints_of(&arm, &Six::from_column_slice(q)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_screw_is_its_triangle() {
        for screw in [Irp6::nominal().transmission().lower, Irp6::calibrated().transmission().upper] {
            let back = Triangle::of(&screw).screw(screw.synchro);
            for (a, b) in [(back.square, screw.square), (back.mu, screw.mu), (back.nu, screw.nu)] {
                assert!((a - b).abs() < 1e-9 * b.abs(), "{a} {b}");
            }
            assert!((back.reference - screw.reference).abs() < 1e-12);
        }
    }
}
