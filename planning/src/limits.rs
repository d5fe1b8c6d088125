//! The limits of the joints of all robots, one behind the other.

use core::ops::Range;

use mrroc::robot::JointKind;

use crate::arm::Arm;

/// Limits of all joints, in the order of the robots.
#[derive(Clone, Debug)]
pub(crate) struct Limits {
    /// Which joints belong to each robot.
    pub(crate) robots: Vec<Range<usize>>,
    pub(crate) kinds: Vec<JointKind>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) velocity: Vec<f64>,
    pub(crate) acceleration: Vec<f64>,
    pub(crate) jerk: Vec<Option<f64>>,
}

impl Limits {
    /// Those of `arms`.
    pub(crate) fn of(arms: &[Arm]) -> Self {
        let mut all = Limits {
            robots: Vec::new(),
            kinds: Vec::new(),
            lower: Vec::new(),
            upper: Vec::new(),
            velocity: Vec::new(),
            acceleration: Vec::new(),
            jerk: Vec::new(),
        };
        for arm in arms {
            let limits = arm.part.shape.limits();
            all.robots.push(arm.first..arm.first + arm.joints);
            all.kinds.extend(arm.part.shape.kinds());
            for j in 0..arm.joints {
                all.lower.push(limits.lower[j]);
                all.upper.push(limits.upper[j]);
                all.velocity.push(limits.velocity[j]);
                all.acceleration.push(limits.acceleration[j]);
                all.jerk.push(limits.jerk.map(|jerk| jerk[j]));
            }
        }
        all
    }

    /// Positions of all joints, robot by robot.
    pub(crate) fn split<'a>(&self, q: &'a [f64]) -> Vec<&'a [f64]> {
        self.robots.iter().map(|joints| &q[joints.clone()]).collect()
    }

    /// How many joints there are.
    pub(crate) fn joints(&self) -> usize {
        self.lower.len()
    }
}
