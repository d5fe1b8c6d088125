//! Polycrank: seven joints that turn without end; three upright axes, three level ones, and the tool's own.
//!
//! ```text
//!   side view                       z7 = tool            plan view
//!      k |        o--L--o                                   y ^    P12
//!        |   L  /  (q5)  \ (q6) 0.043                         |   o------> e (phi = q1 + q2 + q3)
//!        | (q4)o          +---> F                             |  / a2 (q2)
//!        +-----|--> e     wrist centre                        | /
//!              |                                              |o
//!     a1  a2   | 1.632 m above the floor                      o--- a1 = -0.299 (q1): backwards
//!   (q1)(q2)(q3)                                              B --> x
//! ```
//!
//! **Frames.** B: on the floor in the axis of joint 1, z_B up. F: Denavit-Hartenberg frame 7. Rows (d, a \[m\], alpha):
//! (0.220, -0.299, 0), (0.152, 0.180, 0), (0.335, 0, 90 deg), (0.120, 0.151, 0), (0.116, 0.151, 0), (0.060, 0, 90 deg),
//! (0.043, 0, 0), on a column of 0.925 m; `A_i = R_z(q_i) T_z(d) T_x(a) R_x(alpha)`. With `phi = q1 + q2 + q3`,
//! `psi = q4 + q5 + q6`, `e = (cos phi, sin phi, 0)`, `m = (sin phi, -cos phi, 0)`, `k` up:
//!
//! ```text
//! p = P12 + 1.632 k + u e + v k + 0.296 m + 0.043 z_F,       P12 = a1 e(q1) + a2 e(q1 + q2)
//! u = L (cos q4 + cos(q4 + q5)),   v = L (sin q4 + sin(q4 + q5)),   z_F = sin(psi) e - cos(psi) k
//! ```
//!
//! **Redundancy.** The pose gives phi and psi (twice: the other turns both, and q7, half round), q7 and v; `u`, how far
//! the level-axis arm stretches, is free. [`Robot::inverse`] takes the `u` whose joints lie nearest to `near` (least sum of
//! squares), by damped Gauss-Newton steps on the closed-form solution, and keeps `near`'s elbows (signs of sin q2 and sin
//! q5); an elbow that is nearly stretched may change its sign. Any `u` gives the pose exactly, so what the iteration leaves
//! is only a joint motion that is not quite the least. Where the heading nearest to `near` does not reach, the pose is refused
//! rather than the arm turned over; [`Kinematics::nearest_attainable`] tries all families. Along a path the joints follow continuously, as a least-squares
//! velocity solution would, except where a singularity leaves no choice: the tool vertical (`sin psi = 0`; phi then stays
//! as in `near`), both ways of changing `u` blocked (`sin q2 = sin q5 = 0`). Where the range of `u` ends so, a pose within
//! 2 mm and 2 mrad of `near`'s that needs a joint to move by more than 0.5 rad is refused as singular, not jumped to.
//!
//! **Limits.** None on positions but the ±3600 deg of the published model: angles unwrap, and inverse takes the turn
//! nearest to `near`. 1 rad/s (its default velocity); 2 rad/s² is assumed.
//!
//! Sources: GraspIt!'s model of Polycrank (geometry, joint range), MRROC++ public facts (2250 motor turns per turn of each
//! joint, no limits). Its motors are assumed.

use core::f64::consts::{PI, TAU};

use mrroc::{CoupledLimit, Limits, Measured, NoInverse, Pose, Robot};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::drives::{Driven, MotorData, MotorLimits, Shafts, check_motors};
use crate::irp6_track::Seven;
use crate::kinematics::{Jacobian, Kinematics, closest, column, doubled};
use crate::plant::Encoder;
use crate::sines::sin_cos;
use crate::transmission::GRAVITY;

const A1: f64 = -0.299;
const A2: f64 = 0.180;
/// Both links of the arm with level axes \[m\].
const L: f64 = 0.151;
/// Height of the level axes at v = 0 \[m\].
const HEIGHT: f64 = 0.925 + 0.220 + 0.152 + 0.335;
/// Offset along the level axes \[m\].
const ASIDE: f64 = 0.120 + 0.116 + 0.060;
/// From the wrist centre to the flange \[m\].
const TIP: f64 = 0.043;

/// Sine of psi below which the tool counts as vertical; the pose then errs by no more than this \[rad\].
const VERTICAL: f64 = 1e-10;
/// Sine of an elbow below which its other side is tried too.
const ELBOW: f64 = 0.05;
/// Share of a range of u by which the iteration begins inside it, when `near` lies outside.
const INSIDE: f64 = 0.02;
/// Motion of the joints that counts as a jump when the flange hardly moves \[rad\] ..
const JUMP: f64 = 0.5;
/// .. namely by less than this [m and rad].
const BESIDE: f64 = 2e-3;
/// Gauss-Newton steps at most; far from `near` the last of them may still move the joints.
const STEPS: usize = 12;
/// Motion of the joints at which the iteration ends \[rad\].
const SETTLED: f64 = 1e-10;

/// A Polycrank arm.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Polycrank {
    X_WB: Pose,
    X_BW: Pose,
    limits: Limits<Seven>,
}

/// What the pose determines, on one of its two branches.
#[derive(Clone, Copy)]
struct Heading {
    phi: f64,
    e: (f64, f64),
    psi: f64,
    q7: f64,
    /// The wrist centre less the offset along m: P12 + u e \[m\].
    plan: (f64, f64),
    /// Height of the wrist centre above the level axes \[m\].
    v: f64,
}

/// Signs of sin q2 and sin q5.
type Elbows = [f64; 2];

/// One member of a family of solutions.
struct Member {
    q: Seven,
    /// Derivative of `q` by u [rad/m].
    slope: Seven,
}

impl Polycrank {
    /// Motor turns per joint turn (MRROC++).
    pub const GEAR: f64 = 2250.0;

    /// First moments of mass that load joints 4, 5 and 6, after balancing [kg m] (assumed).
    pub const GRAVITY_MOMENT: [f64; 3] = [0.6, 0.3, 0.1];
    /// The drive of every joint: a small, fast motor. All assumed, but that gear and encoder must fit 1 rad/s: 2250 rad/s at
    /// the motor, with the 128 pulses per turn of MRROC++'s grippers. The loop's gain is that of the IRp-6's column.
    pub const MOTOR: MotorData = MotorData {
        encoder: Encoder { pulses: 128.0 },
        current_limit: 6.0,
        resistance: 1.46,
        torque_constant: 0.02,
        inertia: 2e-5,
        viscous: 1e-6,
        coulomb: 2e-3,
        following: 20.0,
        brake: 2e4,
        ..MotorData::DISC
    };
    const MOTOR_LIMITS: MotorLimits<7> =
        MotorLimits { lower: [-142_000.0; 7], upper: [142_000.0; 7], speed: 2500.0 };

    /// The arm with its base at the world's origin.
    #[must_use]
    pub fn new() -> Self {
        Self {
            X_WB: Pose::identity(),
            X_BW: Pose::identity(),
            limits: Limits {
                lower: Seven::repeat(-10.0 * TAU),
                upper: Seven::repeat(10.0 * TAU),
                velocity: Seven::repeat(1.0),
                acceleration: Seven::repeat(2.0),
                jerk: None,
            },
        }
    }

    /// The same arm with its base at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Self {
        Self { X_WB, X_BW: X_WB.inverse(), ..self }
    }

    /// How far `q` stretches the arm with the level axes: the redundancy's parameter u \[m\], -0.302 to 0.302.
    #[must_use]
    pub fn stretch(q: &Seven) -> f64 {
        L * (q[3].cos() + (q[3] + q[4]).cos())
    }

    /// The joints that put the flange at `X_WF` with the redundancy's parameter `u` \[m\]; heading and elbows as in `near`.
    ///
    /// # Errors
    /// [`NoInverse::OutOfReach`] when one of the two arms cannot stretch or fold that far.
    #[allow(non_snake_case)]
    pub fn inverse_at(&self, X_WF: &Pose, u: f64, near: &Seven) -> Result<Seven, NoInverse> {
        let heading = Heading::of(&(self.X_BW * X_WF), near)?.nearest(near);
        let ranges = heading.ranges()?;
        if !ranges.into_iter().flatten().any(|(lower, upper)| (lower..=upper).contains(&u)) {
            let (distance, _) = heading.plan_distance(u);
            return Err(NoInverse::OutOfReach { distance, min: A1.abs() - A2, max: A1.abs() + A2 });
        }
        Ok(heading.member(u, elbows_of(near), near).q)
    }

    /// Whether the flange is all but there at `near`.
    #[cold]
    #[allow(non_snake_case)]
    fn is_beside(&self, X_WF: &Pose, near: &Seven) -> bool {
        let here = self.forward(near);
        (here.translation.vector - X_WF.translation.vector).norm() < BESIDE
            && here.rotation.angle_to(&X_WF.rotation) < BESIDE
    }
}

impl Default for Polycrank {
    fn default() -> Self {
        Self::new()
    }
}

/// Sides of the elbows; a stretched one counts as positive.
fn elbows_of(q: &Seven) -> Elbows {
    [1.0_f64.copysign(q[1].sin()), 1.0_f64.copysign(q[4].sin())]
}

impl Heading {
    /// The branch with `sin psi >= 0`; with the tool vertical, phi stays as in `near`.
    #[inline]
    #[allow(non_snake_case)]
    fn of(X_BF: &Pose, near: &Seven) -> Result<Self, NoInverse> {
        let rotation = X_BF.rotation.to_rotation_matrix();
        let r = rotation.matrix();
        let (zx, zy, zz) = (r[(0, 2)], r[(1, 2)], r[(2, 2)]);
        let sine = zx.hypot(zy);
        let p = X_BF.translation.vector;
        if !(p.x + p.y + p.z + sine).is_finite() {
            return Err(NoInverse::Singular { name: "undefined pose" });
        }
        let (phi, e, psi) = if sine < VERTICAL {
            let phi = near[0] + near[1] + near[2];
            let (s, c) = phi.sin_cos();
            (phi, (c, s), if zz < 0.0 { 0.0 } else { PI })
        } else {
            (zy.atan2(zx), (zx / sine, zy / sine), sine.atan2(-zz))
        };
        // The axis of joint 6, m, in the flange's frame: A7 turns by q7, A6 tilts by 90 deg, so m = sin(q7) x_F + cos(q7) y_F.
        let along_m = |c: usize| e.1 * r[(0, c)] - e.0 * r[(1, c)];
        let q7 = along_m(0).atan2(along_m(1));
        let centre = p - TIP * Vector3::new(zx, zy, zz);
        let plan = (centre.x - ASIDE * e.1, centre.y + ASIDE * e.0);
        Ok(Self { phi, e, psi, q7, plan, v: centre.z - HEIGHT })
    }

    /// The other branch; none with the tool vertical, where it is the same family.
    fn other(&self) -> Option<Self> {
        if self.psi == 0.0 || self.psi == PI {
            return None;
        }
        let (c, s) = self.e;
        // m changes its sign with e: the wrist centre lies on the other side.
        let plan = (self.plan.0 + 2.0 * ASIDE * s, self.plan.1 - 2.0 * ASIDE * c);
        Some(Self { phi: self.phi + PI, e: (-c, -s), psi: -self.psi, q7: self.q7 + PI, plan, v: self.v })
    }

    /// Sum of the squares by which the angles that the pose gives differ from `near` \[rad²\].
    fn distance(&self, near: &Seven) -> f64 {
        let square = |angle: f64, near: f64| (closest(angle, near) - near).powi(2);
        square(self.phi, near[0] + near[1] + near[2])
            + square(self.psi, near[3] + near[4] + near[5])
            + square(self.q7, near[6])
    }

    /// The branch nearest to `near`.
    #[inline]
    fn nearest(&self, near: &Seven) -> Self {
        self.other().filter(|other| other.distance(near) < self.distance(near)).unwrap_or(*self)
    }

    /// Distance and components of P12 at `u` \[m\].
    fn plan_distance(&self, u: f64) -> (f64, (f64, f64)) {
        let p = (self.plan.0 - u * self.e.0, self.plan.1 - u * self.e.1);
        (p.0.hypot(p.1), p)
    }

    /// The ranges of `u` \[m\] in which both arms close: at most two.
    #[inline]
    fn ranges(&self) -> Result<[Option<(f64, f64)>; 2], NoInverse> {
        let (min, max) = (A1.abs() - A2, A1.abs() + A2);
        let upright = 4.0 * L * L - self.v * self.v;
        if under_zero(upright) {
            return Err(NoInverse::OutOfReach { distance: self.v.abs(), min: 0.0, max: 2.0 * L });
        }
        // |plan - u e|^2 = across^2 + (u - along)^2.
        let (along, across) = (
            self.plan.0 * self.e.0 + self.plan.1 * self.e.1,
            self.plan.1 * self.e.0 - self.plan.0 * self.e.1,
        );
        let bound = upright.sqrt();
        let outer = max * max - across * across;
        let refused = NoInverse::OutOfReach { distance: self.plan.0.hypot(self.plan.1), min, max };
        if under_zero(outer) {
            return Err(refused);
        }
        let outer = outer.sqrt();
        let inner = min * min - across * across;
        let range = |lower: f64, upper: f64| {
            let (lower, upper) = (lower.max(-bound), upper.min(bound));
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

    /// The solution at `u`, which must lie in a range, on the given sides of the elbows.
    #[inline]
    fn member(&self, u: f64, elbows: Elbows, near: &Seven) -> Member {
        // Joints 1 and 2 reach P12, joints 4 and 5 reach (u, v).
        let (_, p) = self.plan_distance(u);
        let (q1, q2, s2) = two_cranks(A1, A2, p, elbows[0]);
        let (q4, q5, s5) = two_cranks(L, L, (u, self.v), elbows[1]);
        let q1 = closest(q1, near[0]);
        let q2 = closest(q2, near[1]);
        let q3 = closest(self.phi - q1 - q2, near[2]);
        let q4 = closest(q4, near[3]);
        let q5 = closest(q5, near[4]);
        let q6 = closest(self.psi - q4 - q5, near[5]);
        let q = Seven::from([q1, q2, q3, q4, q5, q6, closest(self.q7, near[6])]);
        // P12 moves by -e, (u, v) by (1, 0), per metre of u.
        let [(_, c3), (_, c23), (_, c4), (_, c45)] = sin_cos([q3, q2 + q3, q4, q4 + q5]);
        let (d1, d12) = (-c3 / (A1 * s2), c23 / (A2 * s2));
        let (d4, d45) = (c45 / (L * s5), -c4 / (L * s5));
        Member { q, slope: Seven::from([d1, d12 - d1, -d12, d4, d45 - d4, -d45, 0.0]) }
    }

    /// The member of the family nearest to `near`, and the square of its distance \[rad²\].
    #[inline]
    fn settle(&self, ranges: &[Option<(f64, f64)>; 2], elbows: Elbows, near: &Seven) -> Option<(Seven, f64)> {
        let wanted = Polycrank::stretch(near);
        let mut best: Option<(Seven, f64)> = None;
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
                let curvature = member.slope.norm_squared();
                let step = -(member.q - near).dot(&member.slope) / curvature;
                // At an end of the range an arm is stretched or folded and the slope infinite.
                if !step.is_finite() || step * step * curvature < SETTLED * SETTLED {
                    break;
                }
                // Half way to an end at most, and shorter until the distance falls.
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
                (member, distance) = (next, shorter);
            }
            if best.is_none_or(|(_, least)| distance < least) {
                best = Some((member.q, distance));
            }
        }
        best
    }
}

/// Whether a square is negative or not a number.
fn under_zero(square: f64) -> bool {
    square.is_nan() || square < 0.0
}

/// Angles \[rad\] of two cranks of lengths `a`, `b` that reach `p`, the second relative to the first and on the side
/// `elbow`, and the sine of the second.
#[inline]
fn two_cranks(a: f64, b: f64, p: (f64, f64), elbow: f64) -> (f64, f64, f64) {
    let square = p.0 * p.0 + p.1 * p.1;
    // cos = (r^2 - a^2 - b^2) / (2 a b); 1 - cos and 1 + cos as products keep the digits next to the ends.
    let r = square.sqrt();
    let (sum, difference) = ((a + b).abs(), (a - b).abs());
    let (longer, shorter) = if sum > difference { (sum, difference) } else { (difference, sum) };
    let sixteen_areas = ((longer - r) * (longer + r) * (r - shorter) * (r + shorter)).max(0.0);
    let cosine = (square - a * a - b * b) / (2.0 * a * b);
    let sine = elbow * sixteen_areas.sqrt() / (2.0 * a * b).abs();
    let (along, across) = (a + b * cosine, b * sine);
    // The first crank's direction is p turned back by the direction of (along, across).
    let first = (p.1 * along - p.0 * across).atan2(p.0 * along + p.1 * across);
    (first, sine.atan2(cosine), sine)
}

impl Robot for Polycrank {
    const KIND: &'static str = "polycrank";

    type Joints = Seven;

    fn limits(&self) -> &Limits<Seven> {
        &self.limits
    }

    fn check_coupled(&self, from: &Seven, to: &Seven, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)
    }

    fn near_singularity(&self, q: &Seven) -> Option<&'static str> {
        let [tool, elbow2, elbow5] = [q[3] + q[4] + q[5], q[1], q[4]].map(|angle| angle.sin().abs() < 0.1);
        match (tool, elbow2 || elbow5) {
            (true, _) => Some("near the vertical-tool singularity"),
            (false, true) => Some("with an elbow stretched or folded"),
            (false, false) => None,
        }
    }

    fn forward(&self, q: &Seven) -> Pose {
        let (q12, q45) = (q[0] + q[1], q[3] + q[4]);
        let (phi, psi) = (q12 + q[2], q45 + q[5]);
        let (sum, difference) = (0.5 * (phi + q[6]), 0.5 * (phi - q[6]));
        let [(s1, c1), (s12, c12), (s4, c4), (s45, c45), (sp, cp), h, plus, minus] =
            sin_cos([q[0], q12, q[3], q45, phi, 0.5 * psi, sum, difference]);
        let (ss, cs) = doubled(h);
        let (u, v) = (L * (c4 + c45) + TIP * ss, L * (s4 + s45) - TIP * cs);
        let position = Translation3::new(
            A1 * c1 + A2 * c12 + u * cp + ASIDE * sp,
            A1 * s1 + A2 * s12 + u * sp - ASIDE * cp,
            HEIGHT + v,
        );
        // R_z(phi) R_x(90 deg) R_z(psi) R_x(90 deg) R_z(q7), multiplied out.
        let rotation = Quaternion::new(-h.0 * plus.0, h.1 * minus.1, h.1 * minus.0, h.0 * plus.1);
        self.X_WB * Pose::from_parts(position, UnitQuaternion::new_unchecked(rotation))
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: B, then Denavit-Hartenberg frames 1 to 7; the
    /// elbow of a joint's offset `d` and length `a` lies between them.
    fn frames(&self, q: &Seven, visit: &mut dyn FnMut(&Pose)) {
        let rows = [
            (0.925 + 0.220, A1, 0.0),
            (0.152, A2, 0.0),
            (0.335, 0.0, 0.5 * PI),
            (0.120, L, 0.0),
            (0.116, L, 0.0),
            (0.060, 0.0, 0.5 * PI),
            (TIP, 0.0, 0.0),
        ];
        let mut frame = self.X_WB;
        visit(&frame);
        for (i, (d, a, alpha)) in rows.into_iter().enumerate() {
            frame *= Pose::new(Vector3::z() * d, Vector3::z() * q[i]);
            frame *= Pose::new(Vector3::x() * a, Vector3::x() * alpha);
            visit(&frame);
        }
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Seven) -> Result<Seven, NoInverse> {
        let heading = Heading::of(&(self.X_BW * X_WF), near)?.nearest(near);
        let ranges = heading.ranges()?;
        let elbows = elbows_of(near);
        let mut best: Option<(Seven, f64)> = None;
        for (flip2, flip5) in [(false, false), (true, false), (false, true), (true, true)] {
            if (flip2 && near[1].sin().abs() > ELBOW) || (flip5 && near[4].sin().abs() > ELBOW) {
                continue;
            }
            let sign = |flip: bool| if flip { -1.0 } else { 1.0 };
            let found = heading.settle(&ranges, [elbows[0] * sign(flip2), elbows[1] * sign(flip5)], near);
            best = match (best, found) {
                (Some(best), Some(found)) if best.1 <= found.1 => Some(best),
                (best, found) => found.or(best),
            };
        }
        let stretched = NoInverse::Singular { name: "stretched arms" };
        let (q, distance) = best.ok_or(stretched)?;
        // The range of u that near lies in has vanished: going on would be a jump into another.
        if distance > JUMP * JUMP && self.is_beside(X_WF, near) { Err(stretched) } else { Ok(q) }
    }
}

/// One solution of each of the eight families (two headings, two elbows): the one nearest to `near`, as for inverse.
impl Kinematics<7> for Polycrank {
    fn reach(&self) -> f64 {
        A1.abs() + A2 + 2.0 * L + ASIDE
    }

    fn jacobian(&self, q: &Seven) -> Jacobian<7> {
        let (phi, psi) = (q[0] + q[1] + q[2], q[3] + q[4] + q[5]);
        let ((sp, cp), (ss, cs)) = (phi.sin_cos(), psi.sin_cos());
        let ((s1, c1), (s12, c12)) = (q[0].sin_cos(), (q[0] + q[1]).sin_cos());
        let ((s4, c4), (s45, c45)) = (q[3].sin_cos(), (q[3] + q[4]).sin_cos());
        let (e, k, m) = (Vector3::new(cp, sp, 0.0), Vector3::z(), Vector3::new(sp, -cp, 0.0));
        // From each axis to the flange.
        let from6 = TIP * (ss * e - cs * k);
        let from5 = from6 + L * (c45 * e + s45 * k);
        let from4 = from5 + L * (c4 * e + s4 * k);
        let from3 = from4 + ASIDE * m;
        let from2 = from3 + A2 * Vector3::new(c12, s12, 0.0);
        let from1 = from2 + A1 * Vector3::new(c1, s1, 0.0);
        let none = Vector3::zeros();
        let z_f = ss * e - cs * k;
        let axes = [(k, from1), (k, from2), (k, from3), (m, from4), (m, from5), (m, from6), (z_f, none)];
        let turned = self.X_WB.rotation;
        Jacobian::from_columns(
            &axes.map(|(axis, arm)| column(&(turned * axis.cross(&arm)), &(turned * axis))),
        )
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Seven, visit: &mut dyn FnMut(&Seven)) -> Result<(), NoInverse> {
        let first = Heading::of(&(self.X_BW * X_WF), near)?;
        let (mut refused, mut any) = (None, false);
        for heading in [Some(first), first.other()].into_iter().flatten() {
            match heading.ranges() {
                Ok(ranges) => {
                    for elbows in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
                        if let Some((q, _)) = heading.settle(&ranges, elbows, near) {
                            any = true;
                            visit(&q);
                        }
                    }
                }
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        refused.filter(|_| !any).map_or(Ok(()), Err)
    }
}

impl Driven<7> for Polycrank {
    fn motor_data(&self) -> &[MotorData; 7] {
        &[Self::MOTOR; 7]
    }

    fn motor_limits(&self) -> &MotorLimits<7> {
        &Self::MOTOR_LIMITS
    }

    fn motors(&self, q: &Seven) -> Seven {
        q * Self::GEAR
    }

    fn shafts(&self, angles: &Seven, speeds: &Seven) -> Shafts<7> {
        let (q, qdot) = (angles / Self::GEAR, speeds / Self::GEAR);
        // Each moment turns with all joints before it, so each joint carries those behind it.
        let [m4, m5, m6] = Self::GRAVITY_MOMENT;
        let (g4, g5, g6) = (m4 * q[3].cos(), m5 * (q[3] + q[4]).cos(), m6 * (q[3] + q[4] + q[5]).cos());
        let share = GRAVITY / Self::GEAR;
        let loads = Seven::from([0.0, 0.0, 0.0, share * (g4 + g5 + g6), share * (g5 + g6), share * g6, 0.0]);
        Shafts { joints: Measured { position: q, velocity: qdot }, loads }
    }
}
