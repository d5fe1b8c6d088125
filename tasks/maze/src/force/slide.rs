//! Along a wall, pressed to it by a force.

use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
use mrroc_robots::Irp6;
use nalgebra::{Vector2, Vector3};

use super::sensor::{Felt, WallForce};
use crate::places::Sizes;

/// The ball is pressed to the wall so much \[N\]: half a millimetre of the stylus.
const LOAD: f64 = 1.0;
/// The wall has ended where less is felt in so many readings \[N\] ..
const LEAST: f64 = 0.25;
/// .. in a row.
const READINGS: u32 = 3;
/// Another wall is in the way where more is felt along the wall than this share of the force against it, and so much \[N\]: friction is less.
const HELD: (f64, f64) = (0.45, 0.4);
/// It goes on along the wall by so many lengths of walls beyond where the leg would have ended.
const ON: f64 = 3.0;
/// A slide that is less than this share of a wall's length is none.
const SHORTEST: f64 = 0.08;
/// How an axis yields: against the stylus's 2 N/mm the force comes to what it is to be with 1 / (k b) = 0.1 s.
const GIVE: Give = Give { reciprocal_damping: 0.005, inertia: 5.0 };
/// How fast the ball goes towards the wall, and how far from where it began to press \[m\].
const WITHIN: Bound = Bound { speed: 0.02, travel: 0.01 };

/// Slides along a wall until it ends, another one is in the way, or it is far enough.
///
/// In the axes of the tool, which are those of the world up to signs, one keeps a load, and one moves and yields.
pub struct Slide {
    law: ForceControl,
    into: Vector2<f64>,
    along: Vector2<f64>,
    most: f64,
    from: Vector2<f64>,
    pose: Pose,
    /// Whether the load has been felt; in how many readings in a row it was not any more, and something was in the way.
    bears: bool,
    lost: u32,
    held: u32,
}

impl Slide {
    /// Along the wall that is felt, as far as the line to `goal` [m, W] goes along it, and on; `None` where that is across the wall, or
    /// where a corner is touched, or nothing.
    ///
    /// # Errors
    /// None: the law's numbers are in range.
    pub fn towards(goal: Vector2<f64>, felt: &Felt, sizes: &Sizes) -> Result<Option<Self>, Fault> {
        let force = felt.force();
        let axis = usize::from(force.y.abs() > force.x.abs());
        let mut into = Vector2::zeros();
        into[axis] = -force[axis].signum();
        let mut beside = goal - felt.ball();
        beside[axis] = 0.0;
        let is_corner = force.abs().min() > 0.6 * force.abs().max();
        if is_corner || force.norm() < LEAST || beside.norm() < SHORTEST * sizes.pitch {
            return Ok(None);
        }
        let along = beside.normalize();
        let tool = |direction: Vector2<f64>| [direction.x, -direction.y];
        let (press, go) = (tool(into), tool(along));
        let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
        for i in 0..2 {
            axes[i] = if i == axis {
                Behaviour::Contact { load: LOAD * press[i], give: GIVE, within: WITHIN }
            } else {
                Behaviour::Guarded { velocity: sizes.velocity * go[i], give: GIVE }
            };
        }
        let law = ForceControl::new(axes).map_err(|bad| Fault::thrown(&bad.to_string()))?;
        let most = beside.norm() + ON * sizes.pitch;
        let from = felt.ball();
        Ok(Some(Self {
            law,
            into,
            along,
            most,
            from,
            pose: Pose::identity(),
            bears: false,
            lost: 0,
            held: 0,
        }))
    }
}

#[generator(ecp)]
impl Slide {
    fn first_step(
        &mut self,
        e: &State<Irp6>,
        v: &Reading<(WallForce,)>,
        t: Tick,
    ) -> Result<Step<Irp6>, Fault> {
        self.pose = e.demanded().pose;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(WallForce,)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let felt = v.0.reading().ok_or_else(|| Fault::thrown("the force sensor has no reading"))?;
        let (against, before) = (-felt.force().dot(&self.into), -felt.force().dot(&self.along));
        self.bears |= against > 0.6 * LOAD;
        self.lost = if self.bears && against < LEAST { self.lost + 1 } else { 0 };
        self.held = if before > HELD.0 * against.max(0.0) + HELD.1 { self.held + 1 } else { 0 };
        let is_far = (felt.ball() - self.from).dot(&self.along) > self.most;
        if is_far || self.lost >= READINGS || self.held >= READINGS {
            return Ok(Step::Done);
        }
        let force = self.pose.rotation.inverse_transform_vector(&felt.force().push(0.0));
        self.pose *= self.law.advance(&Wrench { force, torque: Vector3::zeros() }, t.dt)?;
        self.pose.rotation.renormalize_fast();
        Ok(Step::Next(Demand::pose(self.pose)))
    }
}
