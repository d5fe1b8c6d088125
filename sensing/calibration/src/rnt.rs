//! RNT by its physical parameters: what its closed linkages truly are.
//!
//! No displacement behind joints expresses them: the joints are actuators, and the links' directions are what three loops in the arm's plane make of their lengths
//! (see [`Rnt`](mrroc_robots::Rnt)). Here each loop has dimensions of its own.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use nalgebra::{Vector2, Vector3};

use crate::arm::{Arm, displaced};
use crate::parameter::{Parameter, Unit};

/// How far dimensions may be from the design, as standard deviations: lengths \[m\], zeros and directions of axes \[rad\].
const LENGTH: f64 = 1e-3;
const ZERO: f64 = 9e-3;
const AXIS: f64 = 1e-3;

/// The dimensions, their design [m, rad], and what each may be off by. Points are those of the arm's plane, from the shoulder's axis forwards and upwards: feet 0.40 m
/// away at -20 degrees, and 0.55 m at 250 degrees.
const DESIGN: [(&str, f64, f64); 22] = [
    ("shoulder actuator's foot x", 0.375_877_048_314_363_4, LENGTH),
    ("shoulder actuator's foot z", -0.136_808_057_330_267_5, LENGTH),
    ("elbow actuator's foot x", -0.188_111_078_829_117_7, LENGTH),
    ("elbow actuator's foot z", -0.516_830_941_432_249_7, LENGTH),
    ("crank", 0.25, LENGTH),
    ("rocker", 0.20, LENGTH),
    ("rod", 0.52, LENGTH),
    ("tail", 0.20, LENGTH),
    ("upper arm", 0.50, LENGTH),
    ("forearm", 0.60, LENGTH),
    ("shoulder forwards", 0.12, LENGTH),
    ("wrist aside", 0.0, LENGTH),
    ("shoulder actuator zero", 0.0, LENGTH),
    ("elbow actuator zero", 0.0, LENGTH),
    ("joint 4 zero", 0.0, ZERO),
    ("joint 5 zero", 0.0, ZERO),
    ("shoulder axis turn x", 0.0, AXIS),
    ("shoulder axis turn z", 0.0, AXIS),
    ("forearm turn z", 0.0, AXIS),
    ("wrist axis 5 turn x", 0.0, AXIS),
    ("wrist axis 6 turn y", 0.0, AXIS),
    ("wrist axes apart", 0.0, LENGTH),
];

/// An RNT with dimensions of its own: how far each is from the design's.
#[derive(Clone, Debug)]
pub struct RntArm {
    parameters: Vec<Parameter>,
}

impl Default for RntArm {
    fn default() -> Self {
        Self::new()
    }
}

impl RntArm {
    /// One as designed.
    #[must_use]
    pub fn new() -> Self {
        let parameter = |(name, design, tolerance): (&str, f64, f64)| {
            let unit = if tolerance == LENGTH { Unit::Metre } else { Unit::Radian };
            // The larger ones are best known.
            let importance = if design.abs() > 0.4 { 3 } else { 5 };
            Parameter::new(name, unit).within(tolerance).important(importance)
        };
        Self { parameters: DESIGN.into_iter().map(parameter).collect() }
    }
}

/// The direction of a crank about the origin whose end is `reach` from `foot`, on the side `sign` of the foot's direction.
fn crank(foot: Vector2<f64>, crank: f64, reach: f64, sign: f64) -> f64 {
    let far = foot.norm();
    let cosine = (far * far + crank * crank - reach * reach) / (2.0 * far * crank);
    foot.y.atan2(foot.x) + sign * cosine.clamp(-1.0, 1.0).acos()
}

fn along(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

impl Arm for RntArm {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn joints(&self) -> usize {
        6
    }

    fn flange(&self, q: &[f64], values: &[f64]) -> Pose {
        let [
            foot2x,
            foot2z,
            foot3x,
            foot3z,
            lever,
            rocker,
            rod,
            tail,
            upper,
            fore,
            forwards,
            aside,
            zero2,
            zero3,
            zero4,
            zero5,
            shoulder_x,
            shoulder_z,
            fore_z,
            axis5_x,
            axis6_y,
            apart,
        ] = core::array::from_fn(|i| DESIGN[i].1 + values[i]);
        let theta2 = crank(Vector2::new(foot2x, foot2z), lever, q[1] + zero2, 1.0);
        let rho = crank(Vector2::new(foot3x, foot3z), rocker, q[2] + zero3, -1.0);
        let (elbow, tip) = (along(theta2) * upper, along(rho) * rocker);
        // T on the circles about R and E, on the side away from the shoulder.
        let between = elbow - tip;
        let square = between.norm_squared();
        let ahead = 0.5 * (square + rod * rod - tail * tail);
        let across = (rod * rod * square - ahead * ahead).max(0.0).sqrt();
        let end = tip + (between * ahead + Vector2::new(-between.y, between.x) * across) / square;
        let direction = elbow - end;
        let theta3 = direction.y.atan2(direction.x);
        let wrist = elbow + along(theta3) * fore;
        let about = |axis: Vector3<f64>, angle: f64| Pose::rotation(axis * angle);
        let shoulder = about(Vector3::z(), q[0]) * Pose::translation(forwards, 0.0, HEIGHT);
        let tilt =
            displaced(&Pose::identity(), &nalgebra::Vector6::new(0.0, 0.0, 0.0, shoulder_x, 0.0, shoulder_z));
        shoulder
            * tilt
            * Pose::translation(wrist.x, aside, wrist.y)
            * about(Vector3::y(), 0.5 * PI - theta3)
            * about(Vector3::x(), fore_z)
            * about(Vector3::z(), q[3] + zero4)
            * about(Vector3::x(), axis5_x)
            * about(Vector3::y(), q[4] + zero5)
            * Pose::translation(apart, 0.0, 0.0)
            * about(Vector3::y(), axis6_y)
            * about(Vector3::z(), q[5])
            * Pose::translation(0.0, 0.0, TOOL)
    }
}

/// Shoulder above the floor, and wrist centre to flange \[m\]: the base and what is on the flange have them themselves.
const HEIGHT: f64 = 0.75;
const TOOL: f64 = 0.12;

#[cfg(test)]
mod tests {
    use mrroc::robot::Robot;
    use mrroc_robots::{Rnt, Six};

    use super::*;

    #[test]
    fn as_designed_it_is_the_arm_that_programs_believe_in() {
        let (arm, robot) = (RntArm::new(), Rnt::new());
        for i in 0..50 {
            let share = |k: f64| 0.5 + 0.45 * (f64::from(i) * k + k).sin();
            let theta = Six::new(
                -2.0 + 4.0 * share(1.1),
                0.6 + 0.7 * share(2.3),
                -0.5 + 0.6 * share(3.7),
                -2.0 + 4.0 * share(4.1),
                -1.5 + 3.0 * share(5.3),
                -3.0 + 6.0 * share(6.7),
            );
            let Some(q) = Rnt::from_elevations(&theta) else { continue };
            let own = arm.flange(q.as_slice(), &[0.0; 22]);
            let off = own.to_homogeneous() - robot.forward(&q).to_homogeneous();
            assert!(off.amax() < 1e-12, "{off}");
        }
    }
}
