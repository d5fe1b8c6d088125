//! What arms that move together have in common: the twist of a step, and the law by which they brake on it.
//!
//! In: two poses of an arm's flange, one step apart; the law that the MP sent to all arms with the order of that step.
//! Out: where the flange is to be in steps for which no order comes. Where arms carry one rigid body, the displacement of
//! a step in the world,
//!
//! ```text
//! D = X_WF(k) X_WF(k-1)^-1 = X_WB(k) X_BF X_BF^-1 X_WB(k-1)^-1 = X_WB(k) X_WB(k-1)^-1
//! ```
//!
//! does not depend on where an arm holds it: each of them knows the body's motion by its own. So arms that go on by `D^s`
//! with one sequence of `s` keep their relative pose, whoever else of the cell is gone.

use core::ops::{Add, Mul, Sub};

use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::model::pose::Pose;
use crate::safety::braking::BrakingLaw;
use crate::safety::rate::{Feed, RateMargin};

/// The displacement of a step in the world, as a rotation vector \[rad\] and the twist's linear part \[m\]: `D = exp(turn, linear)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Twist {
    turn: Vector3<f64>,
    linear: Vector3<f64>,
}

impl Twist {
    /// No displacement.
    pub const NONE: Twist = Twist { turn: Vector3::new(0.0, 0.0, 0.0), linear: Vector3::new(0.0, 0.0, 0.0) };

    /// The twist that leads from one pose to another one.
    pub fn between(from: &Pose, to: &Pose) -> Twist {
        #[allow(non_snake_case)]
        let D = to * from.inverse();
        let turn = D.rotation.scaled_axis();
        let t = D.translation.vector;
        // V(turn)^-1 t (Murray, Li, Sastry, appendix A).
        let angle = turn.norm();
        let third = if angle < 1e-3 {
            1.0 / 12.0
        } else {
            (1.0 - 0.5 * angle / (0.5 * angle).tan()) / (angle * angle)
        };
        let cross = turn.cross(&t);
        Twist { turn, linear: t - cross * 0.5 + turn.cross(&cross) * third }
    }

    /// How large the displacement is, in all: its turn \[rad\] about the origin of the world, and its linear part \[m\].
    pub fn size(&self) -> f64 {
        self.turn.norm() + self.linear.norm()
    }

    /// `D^s`.
    pub fn part(&self, s: f64) -> Pose {
        let turn = self.turn * s;
        let linear = self.linear * s;
        let angle = turn.norm();
        let (second, third) = if angle < 1e-3 {
            (0.5 - angle * angle / 24.0, 1.0 / 6.0)
        } else {
            let half = (0.5 * angle).sin() / angle;
            (2.0 * half * half, (angle - angle.sin()) / (angle * angle * angle))
        };
        let cross = turn.cross(&linear);
        let t = linear + cross * second + turn.cross(&cross) * third;
        Pose::from_parts(Translation3::from(t), UnitQuaternion::from_scaled_axis(turn))
    }
}

/// Of twists whose turns are small: the displacements of steps, which differ little.
impl Add for Twist {
    type Output = Twist;

    fn add(self, other: Twist) -> Twist {
        Twist { turn: self.turn + other.turn, linear: self.linear + other.linear }
    }
}

impl Sub for Twist {
    type Output = Twist;

    fn sub(self, other: Twist) -> Twist {
        Twist { turn: self.turn - other.turn, linear: self.linear - other.linear }
    }
}

impl Mul<f64> for Twist {
    type Output = Twist;

    fn mul(self, factor: f64) -> Twist {
        Twist { turn: self.turn * factor, linear: self.linear * factor }
    }
}

/// How robots that move together go on through steps without demands: along the path's last twist, as it changed last. All of
/// them know both by their own flanges. None goes back where a path that slows down would come to a standstill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bridging {
    /// The twist of the last step.
    pub twist: Twist,
    /// By how much it changes in a step.
    bend: Twist,
    /// How large it was when the path was known last.
    known: f64,
}

impl Bridging {
    /// After a step with the displacement `twist`, which `bend` has led to from that of the step before.
    pub fn after(twist: Twist, bend: Twist) -> Bridging {
        Bridging { twist, bend, known: twist.size() }
    }

    /// The same, which goes on at its present velocity.
    pub const fn steady(self) -> Bridging {
        Bridging { bend: Twist::NONE, ..self }
    }

    /// A step later.
    pub fn advanced(self) -> Bridging {
        let twist = self.twist + self.bend;
        let goes_on = self.twist.turn.dot(&twist.turn) + self.twist.linear.dot(&twist.linear) > 0.0;
        if goes_on { Bridging { twist, ..self } } else { Bridging { twist: Twist::NONE, ..self.steady() } }
    }

    /// The law by which robots brake from here that may brake by `law` at the speed which the path had: a robot that has become
    /// faster meanwhile slows down by as much in a second, which is a smaller share of its speed.
    pub fn eased(&self, law: BrakingLaw) -> BrakingLaw {
        let size = self.twist.size();
        let share = if size > self.known { self.known / size } else { 1.0 };
        BrakingLaw { fall: law.fall * share, bend: law.bend * share }
    }
}

/// Braking to a standstill on a twist.
#[derive(Clone, Debug)]
pub(crate) struct TwistBraking {
    twist: Twist,
    law: BrakingLaw,
    feed: Feed,
}

impl TwistBraking {
    /// From the full displacement of a step.
    pub fn new(twist: Twist, law: BrakingLaw) -> TwistBraking {
        TwistBraking { twist, law, feed: Feed::new(f64::INFINITY) }
    }

    /// The displacement of the next step of `duration` \[s\]; `None` at the standstill.
    pub fn advance(&mut self, duration: f64) -> Option<Pose> {
        let BrakingLaw { fall, bend } = self.law;
        self.feed.limit(RateMargin { rise: 0.0, fall, bend, ..RateMargin::UNLIMITED });
        let part = self.feed.advance(0.0, duration);
        (part > 0.0).then(|| self.twist.part(part))
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;

    fn poses() -> [Pose; 2] {
        [
            Pose::new(Vector3::new(0.8, -0.3, 0.5), Vector3::new(3.0, 0.1, -0.2)),
            Pose::new(Vector3::new(-0.4, 0.9, 0.1), Vector3::new(0.3, -0.7, 1.2)),
        ]
    }

    fn apart(a: &Pose, b: &Pose) -> f64 {
        let by = a.inv_mul(b);
        assert!(by.to_homogeneous().iter().all(|x| x.is_finite()), "{by}");
        by.translation.vector.norm().max(2.0 * by.rotation.imag().norm())
    }

    #[test]
    fn parts_of_a_twist_compose_to_the_whole_for_turns_of_all_sizes() {
        let [from, _] = poses();
        for angle in [0.0, 1e-9, 1e-4, 0.999e-3, 1.001e-3, 0.1, 2.0] {
            let by =
                Pose::new(Vector3::new(0.1, -0.2, 0.05), Vector3::new(1.0, 2.0, -0.5).normalize() * angle);
            let to = by * from;
            let twist = Twist::between(&from, &to);
            assert!(apart(&(twist.part(1.0) * from), &to) < 1e-14, "{angle}");
            let thirds = twist.part(1.0 / 3.0);
            assert!(apart(&(thirds * thirds * thirds * from), &to) < 1e-14, "{angle}");
        }
    }

    #[test]
    fn arms_that_carry_a_body_know_one_twist_and_stay_together_on_it() {
        let [left, right] = poses();
        let by = Pose::new(Vector3::new(1e-3, 2e-3, -5e-4), Vector3::new(1e-3, -2e-3, 1.5e-3));
        let law = BrakingLaw { fall: 4.0, bend: f64::INFINITY };
        let mut arms = [left, right].map(|tool| {
            let moved = by * tool;
            (moved, TwistBraking::new(Twist::between(&tool, &moved), law))
        });
        let relative = left.inv_mul(&right);
        let mut steps = 0;
        while let [Some(one), Some(two)] = arms.each_mut().map(|(_, braking)| braking.advance(2e-3)) {
            steps += 1;
            (arms[0].0, arms[1].0) = (one * arms[0].0, two * arms[1].0);
            assert!(apart(&arms[0].0.inv_mul(&arms[1].0), &relative) < 1e-12, "step {steps}");
        }
        // 1 / (4 / s) in steps of 2 ms, of which the last has no speed.
        assert_eq!(steps, 124);
    }

    #[test]
    fn what_two_robots_bear_is_the_less_of_both() {
        let (one, two) = (BrakingLaw { fall: 4.0, bend: 90.0 }, BrakingLaw { fall: 5.0, bend: 70.0 });
        for law in [one.and(two), two.and(one)] {
            assert_eq!(law, BrakingLaw { fall: 4.0, bend: 70.0 });
        }
    }

    #[test]
    fn a_robot_whose_speed_a_step_takes_away_stops_at_once() {
        // `fall` is 0.8 a / v: in a step of 2 ms a takes v away where v <= a T, so where `fall` T >= 0.8.
        let law = |fall: f64| BrakingLaw { fall, bend: f64::INFINITY };
        assert!(law(401.0).stops_at_once(2e-3) && law(400.0).stops_at_once(2e-3));
        assert!(!law(399.0).stops_at_once(2e-3) && !law(401.0).stops_at_once(1e-3));
        // A share of 1e-6 is round-off.
        assert!(law(400.0 * (1.0 - 0.9e-6)).stops_at_once(2e-3));
        assert!(!law(400.0 * (1.0 - 1.1e-6)).stops_at_once(2e-3));
    }

    #[test]
    fn a_twist_without_any_turn_is_a_line() {
        let twist = Twist::between(&Pose::translation(1.0, 2.0, 3.0), &Pose::translation(1.5, 1.0, 3.0));
        assert!(apart(&twist.part(0.5), &Pose::translation(0.25, -0.5, 0.0)) < 1e-15);
    }

    #[test]
    fn a_part_of_a_twist_turns_and_goes_on_by_that_part_of_it() {
        // About an axis along z, by a large angle and by one below which its functions are series; 5e-11 is round-off of 2e4 m.
        for (turn, axis) in [(FRAC_PI_2, [1.0, 2.0]), (0.9e-3, [1e4, -2e4])] {
            let about = |turn: f64| {
                let to = Translation3::new(axis[0], axis[1], 0.3 * turn);
                let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, turn));
                Pose::from_parts(to, rotation) * Pose::translation(-axis[0], -axis[1], 0.0)
            };
            let from = poses()[0];
            let twist = Twist::between(&from, &(about(turn) * from));
            for s in [0.25, 0.5, 0.75] {
                assert!(apart(&twist.part(s), &about(s * turn)) < 5e-11, "{turn} {s}");
            }
        }
    }
}
