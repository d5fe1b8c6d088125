//! What a pose determines of Polycrank's joints, and how the rest follows from the stretch u.
//!
//! In: the flange's pose in B and the joints to stay near. Out: the heading (phi, psi, q7), the ranges of `u` in which
//! both arms close, and the joints at one `u`. The sketch and the formulas stand at [`Polycrank`](super::Polycrank).

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{Vector2, Vector3};

use super::{A1, A2, ASIDE, HEIGHT, L, Seven, TIP};
use crate::models::kinematics::closest;
use crate::models::sines::{atan2, sin_cos};

/// Sine of psi below which the tool counts as vertical; the pose then errs by no more than this \[rad\].
const VERTICAL: f64 = 1e-10;
/// Sine of an elbow from which on the stretch is kept, and the one below which the joints move the least.
const BENT: f64 = 0.3;
const STRETCHED: f64 = 0.15;
/// Share of a range of u by which the iteration begins inside it, when `near` lies outside.
const INSIDE: f64 = 0.02;
/// Gauss-Newton steps at most; far from `near` the last of them may still move the joints.
const STEPS: usize = 12;
/// Motion of the joints at which the iteration ends \[rad\].
const SETTLED: f64 = 1e-10;
/// Smallest and largest distance that joints 1 and 2 reach \[m\].
const NEAREST: f64 = -A1 - A2;
const FARTHEST: f64 = -A1 + A2;

/// Signs of sin q2 and sin q5; a stretched elbow counts as positive.
pub(super) type Elbows = [f64; 2];

/// The stretch u \[m\] and the sides of the elbows at `q`.
#[inline]
pub(super) fn stretch_and_elbows(q: &Seven) -> (f64, Elbows) {
    let [(s2, _), (s5, _), (_, c4), (_, c45)] = sin_cos([q[1], q[4], q[3], q[3] + q[4]]);
    (L * (c4 + c45), [1.0_f64.copysign(s2), 1.0_f64.copysign(s5)])
}

/// What the pose determines, on one of its two branches.
#[derive(Clone, Copy)]
pub(super) struct Heading {
    phi: f64,
    e: Vector2<f64>,
    psi: f64,
    q7: f64,
    /// The wrist centre less the offset along m: P12 + u e \[m\].
    plan: Vector2<f64>,
    /// Height of the wrist centre above the level axes \[m\].
    v: f64,
}

/// The joints at one stretch.
pub(super) struct Member {
    pub(super) q: Seven,
    /// Sines of q2 and q5; 0 where an arm does not close.
    sines: [f64; 2],
}

impl Member {
    /// How much of the least motion's change of u is followed: 0 with both elbows bent, 1 with one all but stretched or
    /// folded, where a kept u would turn the joints fast.
    #[inline]
    pub(super) fn share(&self) -> f64 {
        let sine = self.sines[0].abs().min(self.sines[1].abs());
        let part = ((BENT - sine) / (BENT - STRETCHED)).clamp(0.0, 1.0);
        // Smoothly, so that the joints' speeds stay continuous.
        part * part * (3.0 - 2.0 * part)
    }

    /// Derivative of the joints by u [rad/m]: P12 moves by -e, (u, v) by (1, 0), per metre of u.
    fn slope(&self) -> Seven {
        let q = &self.q;
        let [(_, c3), (_, c23), (_, c4), (_, c45)] = sin_cos([q[2], q[1] + q[2], q[3], q[3] + q[4]]);
        let d1 = -c3 / (A1 * self.sines[0]);
        let d12 = c23 / (A2 * self.sines[0]);
        let d4 = c45 / (L * self.sines[1]);
        let d45 = -c4 / (L * self.sines[1]);
        Seven::from([d1, d12 - d1, -d12, d4, d45 - d4, -d45, 0.0])
    }
}

/// The member of a family that is nearest to some joints.
#[derive(Clone, Copy)]
pub(super) struct Least {
    pub(super) q: Seven,
    u: f64,
    /// The square of its distance \[rad²\].
    pub(super) distance: f64,
}

impl Heading {
    /// The branch with `sin psi >= 0`; with the tool vertical, phi stays as in `near`.
    #[inline]
    #[allow(non_snake_case)]
    pub(super) fn of(X_BF: &Pose, near: &Seven) -> Result<Self, NoInverse> {
        let rotation = X_BF.rotation.to_rotation_matrix();
        let r = rotation.matrix();
        let (zx, zy, zz) = (r[(0, 2)], r[(1, 2)], r[(2, 2)]);
        let sine = (zx * zx + zy * zy).sqrt();
        let p = X_BF.translation.vector;
        if !(p.x + p.y + p.z + sine).is_finite() {
            return Err(NoInverse::Singular { name: "undefined pose" });
        }
        let vertical = sine < VERTICAL;
        let kept = near[0] + near[1] + near[2];
        let e = if vertical {
            let (s, c) = kept.sin_cos();
            Vector2::new(c, s)
        } else {
            let inverse = 1.0 / sine;
            Vector2::new(zx * inverse, zy * inverse)
        };
        // The axis of joint 6, m, in the flange's frame: A7 turns by q7, A6 tilts by 90 deg, so m = sin(q7) x_F + cos(q7) y_F.
        let along_m = |c: usize| e.y * r[(0, c)] - e.x * r[(1, c)];
        let [phi, psi, q7, _] = atan2([zy, sine, along_m(0), 0.0], [zx, -zz, along_m(1), 1.0]);
        let (phi, psi) = if vertical { (kept, if zz < 0.0 { 0.0 } else { PI }) } else { (phi, psi) };
        let centre = p - TIP * Vector3::new(zx, zy, zz);
        let plan = Vector2::new(centre.x - ASIDE * e.y, centre.y + ASIDE * e.x);
        Ok(Self { phi, e, psi, q7, plan, v: centre.z - HEIGHT })
    }

    /// The other branch; none with the tool vertical, where it is the same family.
    pub(super) fn other(&self) -> Option<Self> {
        if self.psi == 0.0 || self.psi == PI {
            return None;
        }
        // m changes its sign with e: the wrist centre lies on the other side.
        let plan = Vector2::new(self.plan.x + 2.0 * ASIDE * self.e.y, self.plan.y - 2.0 * ASIDE * self.e.x);
        Some(Self { phi: self.phi + PI, e: -self.e, psi: -self.psi, q7: self.q7 + PI, plan, v: self.v })
    }

    /// Sum of the squares by which the angles that the pose gives differ from `near` \[rad²\].
    #[inline]
    fn distance(&self, near: &Seven) -> f64 {
        let square = |angle: f64, near: f64| {
            let off = closest(angle, near) - near;
            off * off
        };
        square(self.phi, near[0] + near[1] + near[2])
            + square(self.psi, near[3] + near[4] + near[5])
            + square(self.q7, near[6])
    }

    /// The branch nearest to `near`.
    #[inline]
    pub(super) fn nearest(&self, near: &Seven) -> Self {
        self.other().filter(|other| other.distance(near) < self.distance(near)).unwrap_or(*self)
    }

    /// P12 at `u` \[m\].
    #[inline]
    fn plan_at(&self, u: f64) -> Vector2<f64> {
        Vector2::new(self.plan.x - u * self.e.x, self.plan.y - u * self.e.y)
    }

    /// Whether both arms close at `u` \[m\].
    ///
    /// # Errors
    /// [`NoInverse::OutOfReach`] for the one that does not.
    pub(super) fn check(&self, u: f64) -> Result<(), NoInverse> {
        let p = self.plan_at(u);
        let arms = [(u.hypot(self.v), 0.0, 2.0 * L), (p.x.hypot(p.y), NEAREST, FARTHEST)];
        match arms.into_iter().find(|(distance, min, max)| !(*min..=*max).contains(distance)) {
            Some((distance, min, max)) => Err(NoInverse::OutOfReach { distance, min, max }),
            None => Ok(()),
        }
    }

    /// The ranges of `u` \[m\] in which both arms close: at most two.
    #[inline]
    pub(super) fn ranges(&self) -> Result<[Option<(f64, f64)>; 2], NoInverse> {
        let upright = 4.0 * L * L - self.v * self.v;
        if under_zero(upright) {
            return Err(NoInverse::OutOfReach { distance: self.v.abs(), min: 0.0, max: 2.0 * L });
        }
        // |plan - u e|^2 = across^2 + (u - along)^2.
        let along = self.plan.x * self.e.x + self.plan.y * self.e.y;
        let across = self.plan.y * self.e.x - self.plan.x * self.e.y;
        let bound = upright.sqrt();
        let outer = FARTHEST * FARTHEST - across * across;
        let refused =
            NoInverse::OutOfReach { distance: self.plan.x.hypot(self.plan.y), min: NEAREST, max: FARTHEST };
        if under_zero(outer) {
            return Err(refused);
        }
        let outer = outer.sqrt();
        let inner = NEAREST * NEAREST - across * across;
        let range = |lower: f64, upper: f64| {
            let lower = lower.max(-bound);
            let upper = upper.min(bound);
            (lower <= upper).then_some((lower, upper))
        };
        let ranges = if inner > 0.0 {
            let inner = inner.sqrt();
            [range(along - outer, along - inner), range(along + inner, along + outer)]
        } else {
            [range(along - outer, along + outer), None]
        };
        if ranges == [None, None] { Err(refused) } else { Ok(ranges) }
    }

    /// The joints at `u`, on the given sides of the elbows. Where `u` lies in no range they do not give the pose, and
    /// [`Member::share`] is 1.
    #[inline]
    pub(super) fn member(&self, u: f64, elbows: Elbows, near: &Seven) -> Member {
        // Joints 1 and 2 reach P12, joints 4 and 5 reach (u, v).
        let [first, second] = two_cranks(A1, A2, self.plan_at(u), elbows[0]);
        let [fourth, fifth] = two_cranks(L, L, Vector2::new(u, self.v), elbows[1]);
        let [q1, q2, q4, q5] =
            atan2([first.y, second.y, fourth.y, fifth.y], [first.x, second.x, fourth.x, fifth.x]);
        let q1 = closest(q1, near[0]);
        let q2 = closest(q2, near[1]);
        let q3 = closest(self.phi - q1 - q2, near[2]);
        let q4 = closest(q4, near[3]);
        let q5 = closest(q5, near[4]);
        let q6 = closest(self.psi - q4 - q5, near[5]);
        let q = Seven::from([q1, q2, q3, q4, q5, q6, closest(self.q7, near[6])]);
        Member { q, sines: [second.y, fifth.y] }
    }

    /// Between `kept`, the member at the stretch `u`, and the one that moves the joints the least.
    pub(super) fn between(
        &self,
        u: f64,
        kept: &Member,
        least: &Least,
        elbows: Elbows,
        near: &Seven,
    ) -> Seven {
        let share = kept.share();
        let member = self.member(u + share * (least.u - u), elbows, near);
        // Between two ranges no arm closes.
        if share < 1.0 && member.sines.iter().all(|sine| *sine != 0.0) { member.q } else { least.q }
    }

    /// The member of the family nearest to `near`, whose stretch is `wanted`.
    pub(super) fn settle(
        &self,
        ranges: &[Option<(f64, f64)>; 2],
        wanted: f64,
        elbows: Elbows,
        near: &Seven,
    ) -> Option<Least> {
        let mut best: Option<Least> = None;
        for (lower, upper) in ranges.iter().flatten() {
            // A range's ends are stretched or folded elbows, where the slope is infinite: begin inside.
            let margin = INSIDE * (upper - lower);
            let mut u = if (*lower..=*upper).contains(&wanted) {
                wanted
            } else {
                wanted.clamp(lower + margin, upper - margin)
            };
            let mut member = self.member(u, elbows, near);
            let mut distance = (member.q - near).norm_squared();
            for _ in 0..STEPS {
                let slope = member.slope();
                let curvature = slope.norm_squared();
                let step = -(member.q - near).dot(&slope) / curvature;
                // At an end of the range an arm is stretched or folded and the slope infinite.
                if !step.is_finite() || step * step * curvature < SETTLED * SETTLED {
                    break;
                }
                // Half the distance to an end at most, and shorter until the distance falls.
                let room = if step > 0.0 { *upper - u } else { *lower - u };
                let mut step = if step.abs() > 0.5 * room.abs() { 0.5 * room } else { step };
                let mut moved = None;
                for _ in 0..4 {
                    let next = self.member(u + step, elbows, near);
                    let shorter = (next.q - near).norm_squared();
                    if shorter < distance {
                        moved = Some((next, shorter));
                        break;
                    }
                    step *= 0.25;
                }
                let Some((next, shorter)) = moved else { break };
                u += step;
                member = next;
                distance = shorter;
            }
            if best.is_none_or(|best| distance < best.distance) {
                best = Some(Least { q: member.q, u, distance });
            }
        }
        best
    }
}

/// Whether a square is negative or not a number.
fn under_zero(square: f64) -> bool {
    square.is_nan() || square < 0.0
}

/// Directions of two cranks of lengths `a`, `b` that reach `p`: of the first (of any length), and of the second relative to
/// the first (of length 1), on the side `elbow`. Where they do not reach, the second's sine is 0.
#[inline]
fn two_cranks(a: f64, b: f64, p: Vector2<f64>, elbow: f64) -> [Vector2<f64>; 2] {
    let square = p.x * p.x + p.y * p.y;
    // cos = (r^2 - a^2 - b^2) / (2 a b); 1 - cos and 1 + cos as products keep the digits next to the ends.
    let r = square.sqrt();
    let (sum, difference) = ((a + b).abs(), (a - b).abs());
    let (longer, shorter) = if sum > difference { (sum, difference) } else { (difference, sum) };
    let sixteen_areas = ((longer - r) * (longer + r) * (r - shorter) * (r + shorter)).max(0.0);
    let cosine = (square - a * a - b * b) * (1.0 / (2.0 * a * b));
    let sine = elbow * sixteen_areas.sqrt() * (1.0 / (2.0 * a * b).abs());
    let (along, across) = (a + b * cosine, b * sine);
    // The first crank's direction is p turned back by the direction of (along, across).
    let first = Vector2::new(p.x * along + p.y * across, p.y * along - p.x * across);
    [first, Vector2::new(cosine, sine)]
}
