//! Any serial arm: a chain of joints, a small displacement behind each of them, and errors of the encoders.
//!
//! ```text
//! X_BF = X_1 M_1(q_1 + e_1) D_1  X_2 M_2(q_2 + e_2) D_2  ..  X_N M_N(q_N + e_N) D_N  X_tip
//! D_k: x, y, z of joint k's own frame, then a turn (rotation vector);   e_k = s q_k + a cos q_k + b sin q_k
//! ```
//!
//! `z` is the joint's axis. The turn of `D_k` about z of a revolute joint (the shift of a sliding one) is the error of its zero. Of the
//! six numbers of each `D_k` two cannot be told from those of its neighbour; what else cannot be depends on the arm. The rank says so.

use mrroc::pose::Pose;
use mrroc::robot::{JointKind, JointVector, Robot};
use nalgebra::{Matrix3, Vector3, Vector6};

use crate::arm::{Arm, at, turned, twist};
use crate::parameter::{Parameter, Unit};

/// A joint of a chain, with all that is fixed before it.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Its frame, z along its axis, in the frame of the joint before (of the base), with both at 0.
    pub X_before: Pose,
    /// How it moves.
    pub kind: JointKind,
}

/// A chain as it was designed.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Chain {
    /// Its joints, from the base on.
    pub joints: Vec<Joint>,
    /// The flange in the frame of the last joint.
    pub X_tip: Pose,
}

/// How much of a chain is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// Nothing: frames alone.
    Frames,
    /// The zeros of the joints.
    Zeros,
    /// All displacements.
    Geometry,
    /// And the gear's ratio, and once a turn the eccentricity of the encoder.
    Encoders,
}

/// How far an arm is from its design, as standard deviations before anything is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Lengths \[m\].
    pub length: f64,
    /// Directions of axes \[rad\].
    pub angle: f64,
    /// Zeros of turning joints \[rad\].
    pub zero: f64,
    /// Eccentricity of encoders \[rad\], and the error of gears (a ratio).
    pub encoder: f64,
}

impl Default for Tolerances {
    /// 1 mm, 2 mrad, 10 mrad, 0.3 mrad: an arm as it comes from its maker, or with a motor that was changed.
    fn default() -> Self {
        Self { length: 1e-3, angle: 2e-3, zero: 1e-2, encoder: 3e-4 }
    }
}

impl Chain {
    /// The chain of a robot whose frames are those of its joints with z along each axis, as those of an arm read from a URDF;
    /// `None` of another one, or with joints that follow others.
    ///
    /// It is checked against the robot itself.
    #[allow(non_snake_case)]
    pub fn of<R: Robot>(robot: &R) -> Option<Chain> {
        let zero = R::Joints::from_joints(|_| 0.0);
        let mut frames = Vec::new();
        robot.frames(&zero, &mut |X_WL| frames.push(*X_WL));
        let n = R::Joints::LEN;
        if frames.len() != n + 2 {
            return None;
        }
        let joints = (0..n).map(|i| Joint {
            name: format!("joint {}", i + 1),
            X_before: frames[i].inv_mul(&frames[i + 1]),
            kind: robot.joint(i),
        });
        let chain = Chain { joints: joints.collect(), X_tip: frames[n].inv_mul(&frames[n + 1]) };
        let same = (0..4).all(|trial| {
            let q: Vec<f64> = (0..n).map(|i| 0.2 + 0.17 * f64::from(trial) * (i as f64 - 1.5)).collect();
            let own = frames[0] * chain.clone().with(Detail::Frames, &Tolerances::default()).flange(&q, &[]);
            let robots = robot.forward(&R::Joints::from_joints(|i| q[i]));
            (own.to_homogeneous() - robots.to_homogeneous()).amax() < 1e-9
        });
        same.then_some(chain)
    }

    /// The chain of a table of Denavit-Hartenberg parameters in the distal convention (Paul): `R_z(q + theta) T_z(d) T_x(a) R_x(alpha)`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn distal(rows: &[DhRow]) -> Chain {
        let mut X = Pose::identity();
        let joints = rows.iter().map(|row| {
            let joint = row.joint(X);
            X = row.about_z() * row.about_x();
            joint
        });
        let joints = joints.collect();
        Chain { joints, X_tip: X }
    }

    /// The chain of a table in the proximal convention (Craig): `R_x(alpha) T_x(a) R_z(q + theta) T_z(d)`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn proximal(rows: &[DhRow]) -> Chain {
        let mut X = Pose::identity();
        let joints = rows.iter().map(|row| {
            let joint = row.joint(X * row.about_x());
            X = row.about_z();
            joint
        });
        let joints = joints.collect();
        Chain { joints, X_tip: X }
    }

    /// Which numbers behind a joint are left at 0 where several cannot be told apart: those along and about the next joint's axis, which that
    /// joint has itself; beside a parallel axis those across the link; all behind the last joint, which targets have themselves; and
    /// those of the first joint that the base has itself.
    fn importance(&self, joint: usize, axis: usize) -> u8 {
        let own = if self.joints[joint].kind == JointKind::Revolute { 5 } else { 2 };
        let Some(next) = self.joints.get(joint + 1) else { return 1 };
        if joint == 0 && (axis == 2 || axis == 5) {
            return if axis == own { 2 } else { 1 };
        }
        if axis == own {
            return 8;
        }
        let along = next.X_before.rotation * Vector3::z();
        let across = if along.z.abs() > 0.9 {
            // Parallel: across both the axis and the link.
            along.cross(&next.X_before.translation.vector)
        } else {
            Vector3::new(along.x, along.y, 0.0)
        };
        let redundant = usize::from(across.y.abs() > across.x.abs());
        let parallel = along.z.abs() > 0.9;
        let is_redundant =
            axis == redundant || (axis == redundant + 3 && !parallel) || (axis == 2 && parallel);
        if is_redundant { 1 } else { 5 }
    }

    /// The arm whose `detail` is to be calibrated.
    #[must_use]
    pub fn with(self, detail: Detail, tolerances: &Tolerances) -> ChainArm {
        let mut parameters = Vec::new();
        let mut effects = Vec::new();
        for (i, joint) in self.joints.iter().enumerate() {
            let revolute = joint.kind == JointKind::Revolute;
            let own = if revolute { 5 } else { 2 };
            for axis in 0..6 {
                let is_zero = axis == own;
                let wanted = if is_zero { detail >= Detail::Zeros } else { detail >= Detail::Geometry };
                if !wanted {
                    continue;
                }
                let (unit, tolerance) = match axis {
                    5 if is_zero => (Unit::Radian, tolerances.zero),
                    0..3 => (Unit::Metre, tolerances.length),
                    _ => (Unit::Radian, tolerances.angle),
                };
                let name = if is_zero {
                    format!("{} zero", joint.name)
                } else {
                    format!("{} {}", joint.name, ["x", "y", "z", "turn x", "turn y", "turn z"][axis])
                };
                let importance = self.importance(i, axis);
                parameters.push(Parameter::new(name, unit).within(tolerance).important(importance));
                effects.push(Effect::Displacement { joint: i, axis });
            }
            if detail >= Detail::Encoders {
                let names: &[(&str, Encoder)] = match joint.kind {
                    JointKind::Revolute => {
                        &[("gear", Encoder::Gear), ("cosine", Encoder::Cosine), ("sine", Encoder::Sine)]
                    }
                    JointKind::Prismatic => &[("gear", Encoder::Gear)],
                };
                for (name, error) in names {
                    let unit = if *error == Encoder::Gear { Unit::One } else { Unit::Radian };
                    let parameter = Parameter::new(format!("{} {name}", joint.name), unit);
                    parameters.push(parameter.within(tolerances.encoder).important(2));
                    effects.push(Effect::Encoder { joint: i, error: *error });
                }
            }
        }
        ChainArm { chain: self, parameters, effects }
    }
}

/// A row of a table of Denavit-Hartenberg parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct DhRow {
    /// The joint's name.
    pub name: String,
    /// How it moves: `q` is added to `theta` or to `d`.
    pub kind: JointKind,
    /// Turn about z \[rad\].
    pub theta: f64,
    /// Shift along z \[m\].
    pub d: f64,
    /// Shift along x \[m\].
    pub a: f64,
    /// Turn about x \[rad\].
    pub alpha: f64,
}

impl DhRow {
    #[allow(non_snake_case)]
    fn joint(&self, X_before: Pose) -> Joint {
        Joint { name: self.name.clone(), X_before, kind: self.kind }
    }

    fn about_z(&self) -> Pose {
        Pose::rotation(Vector3::z() * self.theta) * Pose::translation(0.0, 0.0, self.d)
    }

    fn about_x(&self) -> Pose {
        Pose::rotation(Vector3::x() * self.alpha) * Pose::translation(self.a, 0.0, 0.0)
    }
}

/// What an encoder reads wrongly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoder {
    Gear,
    Cosine,
    Sine,
}

impl Encoder {
    fn of(self, q: f64) -> f64 {
        match self {
            Encoder::Gear => q,
            Encoder::Cosine => q.cos(),
            Encoder::Sine => q.sin(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    Displacement { joint: usize, axis: usize },
    Encoder { joint: usize, error: Encoder },
}

/// A chain and what is calibrated of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainArm {
    chain: Chain,
    parameters: Vec<Parameter>,
    /// What each parameter does.
    effects: Vec<Effect>,
}

impl ChainArm {
    /// The chain as it was designed.
    #[must_use]
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// The displacements behind the joints [m, rad] that values of the parameters mean: x, y, z, and a rotation vector.
    #[must_use]
    pub fn displacements(&self, values: &[f64]) -> Vec<Vector6<f64>> {
        (0..self.chain.joints.len()).map(|joint| self.displacement(joint, values)).collect()
    }

    /// By joint what its encoder reads wrongly: gear, cosine and sine [1, rad, rad].
    #[must_use]
    pub fn encoders(&self, values: &[f64]) -> Vec<[f64; 3]> {
        let of = |wanted| {
            move |joint: usize| {
                let same = |effect: &Effect| *effect == Effect::Encoder { joint, error: wanted };
                self.effects.iter().position(same).and_then(|i| values.get(i)).copied().unwrap_or(0.0)
            }
        };
        let one = |joint| [of(Encoder::Gear)(joint), of(Encoder::Cosine)(joint), of(Encoder::Sine)(joint)];
        (0..self.chain.joints.len()).map(one).collect()
    }

    fn displacement(&self, wanted: usize, values: &[f64]) -> Vector6<f64> {
        let mut sum = Vector6::zeros();
        for (effect, value) in self.effects.iter().zip(values) {
            match effect {
                Effect::Displacement { joint, axis } if *joint == wanted => sum[*axis] = *value,
                Effect::Displacement { .. } | Effect::Encoder { .. } => {}
            }
        }
        sum
    }

    /// What the joint's encoder leaves out at `q`.
    fn encoder(&self, wanted: usize, q: f64, values: &[f64]) -> f64 {
        let left_out = self.effects.iter().zip(values).map(|(effect, value)| match effect {
            Effect::Encoder { joint, error } if *joint == wanted => value * error.of(q),
            Effect::Encoder { .. } | Effect::Displacement { .. } => 0.0,
        });
        left_out.sum()
    }

    /// Walks along the chain: `visit` gets each joint's number, its frame after it has moved, and the displacement behind.
    #[allow(non_snake_case)]
    fn walk(&self, q: &[f64], values: &[f64], visit: &mut dyn FnMut(usize, &Pose, &Vector6<f64>)) -> Pose {
        let mut X = Pose::identity();
        for (i, joint) in self.chain.joints.iter().enumerate() {
            X *= joint.X_before;
            let position = q[i] + self.encoder(i, q[i], values);
            let moved = X * match joint.kind {
                JointKind::Revolute => Pose::rotation(Vector3::z() * position),
                JointKind::Prismatic => Pose::translation(0.0, 0.0, position),
            };
            let displacement = self.displacement(i, values);
            visit(i, &moved, &displacement);
            X = crate::arm::displaced(&moved, &displacement);
        }
        X * self.chain.X_tip
    }
}

/// How a rotation vector's change turns what it turns, along the axes before the turn (left Jacobian of SO(3)).
fn left_jacobian(of: &Vector3<f64>) -> Matrix3<f64> {
    let angle = of.norm();
    let cross = of.cross_matrix();
    if angle < 1e-6 {
        return Matrix3::identity() + cross * 0.5;
    }
    let square = angle * angle;
    Matrix3::identity()
        + cross * ((1.0 - angle.cos()) / square)
        + cross * cross * ((angle - angle.sin()) / (square * angle))
}

impl Arm for ChainArm {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn joints(&self) -> usize {
        self.chain.joints.len()
    }

    fn flange(&self, q: &[f64], values: &[f64]) -> Pose {
        self.walk(q, values, &mut |_, _, _| {})
    }

    fn linearise(&self, q: &[f64], values: &[f64], twists: &mut [Vector6<f64>]) -> Pose {
        // First each at the origin of its own joint's frame, along the base's axes; then all at the flange.
        let mut origins = vec![Vector3::zeros(); twists.len()];
        let flange = self.walk(q, values, &mut |joint, moved, displacement| {
            let turn = Vector3::new(displacement[3], displacement[4], displacement[5]);
            let shift = Vector3::new(displacement[0], displacement[1], displacement[2]);
            let left = left_jacobian(&turn);
            for (i, effect) in self.effects.iter().enumerate() {
                let (own, origin) = match effect {
                    Effect::Displacement { joint: of, axis } if *of == joint && *axis < 3 => {
                        (twist(&Vector3::ith(*axis, 1.0), &Vector3::zeros()), shift)
                    }
                    Effect::Displacement { joint: of, axis } if *of == joint => {
                        (twist(&Vector3::zeros(), &left.column(*axis - 3).into_owned()), shift)
                    }
                    Effect::Encoder { joint: of, error } if *of == joint => {
                        let z = Vector3::z() * error.of(q[joint]);
                        let own = match self.chain.joints[joint].kind {
                            JointKind::Revolute => twist(&Vector3::zeros(), &z),
                            JointKind::Prismatic => twist(&z, &Vector3::zeros()),
                        };
                        (own, Vector3::zeros())
                    }
                    Effect::Displacement { .. } | Effect::Encoder { .. } => continue,
                };
                twists[i] = turned(&own, &moved.rotation);
                origins[i] = moved.translation.vector + moved.rotation * origin;
            }
        });
        for (twist, origin) in twists.iter_mut().zip(&origins) {
            *twist = at(twist, &(flange.translation.vector - origin));
        }
        flange
    }
}
