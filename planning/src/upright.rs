//! An axis of a flange that a plan keeps upright.
//!
//! In: joint positions, and by how much each may be off. Out: whether the axis is within its tolerance from the vertical at all of them
//! ([`Uprights::check`]), and positions near them at which it is almost vertical ([`Uprights::project`]). A joint that turns by `w` turns
//! the axis by `w` at most, and about a vertical line not at all as seen from the vertical: so in an interval the axis is tilted by no more than in
//! the middle, and the sum over the other joints. Posture by posture, in double precision.
//!
//! The projection is Gauss and Newton's with a little damping, as Berenson and others have it in *CBiRRT* (ICRA 2009).

use mrroc::fault::Name;
use mrroc::robot::MAX_JOINTS;
use mrroc_robots::clearance::{Joints, Motion};
use nalgebra::{Matrix3, Matrix3xX, Vector3};

use crate::arm::Arm;
use crate::lanes::{Lanes, Mask};

/// The share of the tolerance within which a projection ends: the rest is for straight motions between two positions.
const SHARE: f64 = 0.3;
/// Steps of a projection, and the longest [rad or m].
const STEPS: usize = 20;
const LONGEST: f64 = 0.5;
/// What is added to the squares of sines in a projection, so that a singular arm takes short steps.
const DAMPING: f64 = 1e-4;
/// How far a joint moves to see what it does to the axis [rad or m].
const DIFFERENCE: f64 = 1e-6;
/// An axis is vertical if its horizontal part is no longer.
const VERTICAL: f64 = 1e-9;

/// An axis of a robot's flange that is kept upright.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(crate) struct Upright {
    pub(crate) robot: Name,
    /// In the flange's frame, of length 1.
    pub(crate) axis_F: Vector3<f64>,
    /// How far it may be tilted [rad], > 0.
    pub(crate) tolerance: f64,
}

impl Upright {
    fn axis(&self, arm: &Arm, q: &Joints) -> Vector3<f64> {
        arm.part.shape.flange(q).rotation * self.axis_F
    }

    /// How far it is tilted [rad], of this arm at the positions `q` of all robots [rad or m].
    pub(crate) fn tilt(&self, arm: &Arm, q: &[f64]) -> f64 {
        angle(&self.axis(arm, &arm.own(q)))
    }

    /// By how much joints turn it at most when each moves by `half` [rad].
    fn turned(arm: &Arm, q: &Joints, half: &Joints) -> f64 {
        let flange = arm.part.shape.flange_motions();
        let mut sum = 0.0;
        let (mut i, mut is_base) = (0, true);
        arm.part.shape.motions(q, half, &mut |motion| {
            let moves = flange >> i & 1 == 1;
            i += 1;
            match motion {
                Motion::Slide { .. } => {}
                Motion::Turn { axis, bound, .. } if moves => {
                    // From the base on, as long as all axes are vertical.
                    is_base &= axis.is_some_and(|axis| axis.x.hypot(axis.y) <= VERTICAL);
                    if !is_base {
                        sum += bound;
                    }
                }
                Motion::Turn { .. } => {}
            }
        });
        sum
    }
}

/// The angle between a direction of length 1 and the vertical [rad], 0 to pi.
fn angle(axis: &Vector3<f64>) -> f64 {
    axis.x.hypot(axis.y).atan2(axis.z)
}

/// All axes that are kept upright.
#[derive(Clone, Debug, Default)]
pub(crate) struct Uprights(pub(crate) Vec<Upright>);

impl Uprights {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Each of them, with its arm.
    pub(crate) fn with_arms<'a>(&'a self, arms: &'a [Arm]) -> impl Iterator<Item = (&'a Upright, &'a Arm)> {
        let of = |upright: &'a Upright| Some((upright, arms.iter().find(|arm| arm.name() == upright.robot)?));
        self.0.iter().filter_map(of)
    }

    /// In which of the first `count` lanes they are upright all `around` the positions `q`; `None` if in one of them they are not upright
    /// in the middle.
    pub(crate) fn check(&self, arms: &[Arm], q: &[Lanes], half: &[Lanes], count: usize) -> Option<Mask> {
        let mut proven = Mask::MAX;
        for (upright, arm) in self.with_arms(arms) {
            for lane in 0..count {
                let of = |values: &[Lanes]| -> Joints {
                    core::array::from_fn(|i| {
                        if i < arm.joints { f64::from(values[arm.first + i].lane(lane)) } else { 0.0 }
                    })
                };
                let (at, half) = (of(q), of(half).map(f64::abs));
                let tilt = angle(&upright.axis(arm, &at));
                // What is no number is not upright.
                if tilt.is_nan() || tilt > upright.tolerance {
                    return None;
                }
                if tilt + Upright::turned(arm, &at, &half) > upright.tolerance {
                    proven &= !(1 << lane);
                }
            }
        }
        Some(proven)
    }

    /// Moves joints [rad or m], as they are computed with, until all axes are upright, with room for a motion; whether they are, within the
    /// limits of the joints.
    pub(crate) fn project(&self, arms: &[Arm], q: &mut [f32]) -> bool {
        self.with_arms(arms).all(|(upright, arm)| {
            let own = &mut q[arm.first..arm.first + arm.joints];
            let mut at: Joints = core::array::from_fn(|j| own.get(j).map_or(0.0, |q| f64::from(*q)));
            for _ in 0..STEPS {
                let axis = upright.axis(arm, &at);
                let tilt = angle(&axis);
                if tilt <= SHARE * upright.tolerance {
                    own.iter_mut().zip(at).for_each(|(q, at)| *q = at as f32);
                    return true;
                }
                step(upright, arm, &mut at, &axis, tilt);
            }
            false
        })
    }
}

/// One step of a projection from the positions of an arm, at which the axis is tilted.
fn step(upright: &Upright, arm: &Arm, q: &mut Joints, axis: &Vector3<f64>, tilt: f64) {
    // Along the great circle to the vertical; upside down any will do.
    let across = Vector3::z() - axis * axis.z;
    let wanted = across.try_normalize(VERTICAL).unwrap_or(Vector3::x()) * tilt;
    let mut jacobian = Matrix3xX::zeros(arm.joints);
    for j in 0..arm.joints {
        let mut moved = *q;
        moved[j] += DIFFERENCE;
        jacobian.set_column(j, &((upright.axis(arm, &moved) - axis) / DIFFERENCE));
    }
    let square = &jacobian * jacobian.transpose() + Matrix3::identity() * DAMPING;
    let Some(inverse) = square.try_inverse() else { return };
    let change = jacobian.transpose() * (inverse * wanted);
    let longest = change.amax();
    let share = if longest > LONGEST { LONGEST / longest } else { 1.0 };
    let limits = arm.part.shape.limits();
    for j in 0..arm.joints.min(MAX_JOINTS) {
        q[j] = (q[j] + share * change[j]).clamp(limits.lower[j], limits.upper[j]);
    }
}

#[cfg(test)]
mod tests {
    use mrroc_robots::clearance::Clearance;
    use mrroc_robots::{Irp6, Rnt};
    use proptest::prelude::*;

    use super::*;
    use crate::check::Checker;
    use crate::usage::cells::{around_a_box, seven_axes, stopping};

    fn clearances() -> [Clearance; 4] {
        let of = |builder: mrroc_robots::clearance::ClearanceBuilder| {
            builder.build(stopping()).expect("a clearance")
        };
        let alone = || Clearance::with_margin(0.0);
        [
            of(around_a_box()),
            of(alone().robot("arm", seven_axes(mrroc::pose::Pose::identity())).expect("an arm")),
            of(alone().robot("arm", Irp6::nominal()).expect("an arm")),
            of(alone().robot("arm", Rnt::new()).expect("an arm")),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn no_position_within_an_interval_is_tilted_more_than_its_bound(
            part in proptest::array::uniform8(0.1..0.9_f64),
            half in proptest::array::uniform8(0.0..0.3_f64),
            to in proptest::array::uniform8(-1.0..1.0_f64),
            axis in proptest::array::uniform3(-1.0..1.0_f64),
        ) {
            let axis = Vector3::from(axis);
            prop_assume!(axis.norm() > 0.1);
            for clearance in clearances() {
                let arm = &Checker::new(&clearance).arms[0];
                let upright = Upright { robot: arm.name(), axis_F: axis.normalize(), tolerance: 0.1 };
                let q = arm.part.shape.between_limits(&|j| part[j]);
                // Lengths of RNT's actuators change by a tenth of what angles do.
                let half: Joints = core::array::from_fn(|j| 0.1 * half[j]);
                let there: Joints = core::array::from_fn(|j| q[j] + half[j] * to[j]);
                let tilts = [q, there].map(|q| angle(&upright.axis(arm, &q)));
                prop_assume!(tilts.iter().all(|tilt| tilt.is_finite()));
                let bound = Upright::turned(arm, &q, &half);
                prop_assert!((tilts[1] - tilts[0]).abs() <= bound + 1e-9, "{tilts:?} {bound}");
            }
        }
    }

    #[test]
    fn positions_all_over_the_ranges_are_projected_to_upright_ones_within_the_limits() {
        for (clearance, least) in clearances().into_iter().zip([95, 85, 40, 5]) {
            let arms = Checker::new(&clearance).arms;
            let upright = Upright { robot: arms[0].name(), axis_F: Vector3::z(), tolerance: 0.1 };
            let uprights = Uprights(vec![upright]);
            let mut found = 0;
            for sample in 1..=100 {
                let q = arms[0].part.shape.between_limits(&|j| mrroc::random::halton(sample, j));
                let mut q: Vec<f32> = q[..arms[0].joints].iter().map(|q| *q as f32).collect();
                if !uprights.project(&arms, &mut q) {
                    continue;
                }
                found += 1;
                let q: Vec<f64> = q.into_iter().map(f64::from).collect();
                let tilt = uprights.0[0].tilt(&arms[0], &q);
                assert!(tilt <= 0.1 * SHARE + 1e-5, "{tilt}");
                let limits = arms[0].part.shape.limits();
                for (j, q) in q.iter().enumerate() {
                    assert!(limits.lower[j] - 1e-6 <= *q && *q <= limits.upper[j] + 1e-6);
                }
            }
            assert!(found >= least, "{found} of 100 for {}", arms[0].name());
        }
    }
}
