//! Devices: what an instrument reads of a target, as a function of where that is in the instrument's frame.
//!
//! One function is a device: [`Device::predict`]. Everything else has a default.

use core::f64::consts::{PI, TAU};

use mrroc::pose::Pose;
use nalgebra::{DMatrix, UnitQuaternion, Vector3, Vector6};

use crate::arm::displaced;
use crate::parameter::{Parameter, Unit};

/// A kind of instrument.
pub trait Device {
    /// How many numbers it reads of a target.
    fn readings(&self) -> usize;

    /// Its constants: what it may be wrong in. None by default.
    fn constants(&self) -> &[Parameter] {
        &[]
    }

    /// What it would read of a target at `X_IT` in its own frame I.
    #[allow(non_snake_case)]
    fn predict(&self, X_IT: &Pose, constants: &[f64], readings: &mut [f64]);

    /// The unit of each residual, from 0.
    fn unit(&self, i: usize) -> Unit;

    /// What it reads more than foretold, in the units of the residuals. By default the difference.
    fn difference(&self, read: &[f64], foretold: &[f64], difference: &mut [f64]) {
        for (difference, (read, foretold)) in difference.iter_mut().zip(read.iter().zip(foretold)) {
            *difference = read - foretold;
        }
    }

    /// How many residuals a measurement has: by default as many as readings.
    fn residuals(&self) -> usize {
        self.readings()
    }

    /// How the difference changes when the target is displaced in the instrument's axes (six columns: x, y, z \[m\], and a turn about the target's
    /// own origin \[rad\]), and when each constant grows (further columns). By default by central differences.
    #[allow(non_snake_case)]
    fn slopes(&self, X_IT: &Pose, constants: &[f64], read: &[f64], slopes: &mut DMatrix<f64>) {
        const H: f64 = 1e-6;
        let mut foretold = vec![0.0; self.readings()];
        let mut both = [vec![0.0; self.residuals()], vec![0.0; self.residuals()]];
        let mut constants = constants.to_vec();
        for column in 0..6 + constants.len() {
            for (side, sign) in both.iter_mut().zip([1.0, -1.0]) {
                let mut X = *X_IT;
                if column < 6 {
                    let mut by = Vector6::zeros();
                    by[column] = sign * H;
                    // Along the instrument's axes, about the target's origin.
                    let here = Pose::from_parts(X.translation, UnitQuaternion::identity());
                    X = Pose::from_parts(
                        displaced(&here, &by).translation,
                        displaced(&here, &by).rotation * X.rotation,
                    );
                    self.predict(&X, &constants, &mut foretold);
                } else {
                    let at = constants[column - 6];
                    constants[column - 6] = at + sign * H;
                    self.predict(&X, &constants, &mut foretold);
                    constants[column - 6] = at;
                }
                self.difference(read, &foretold, side);
            }
            for (row, (ahead, back)) in both[0].iter().zip(&both[1]).enumerate() {
                slopes[(row, column)] = (ahead - back) / (2.0 * H);
            }
        }
    }
}

/// A tracker: where a target is. Its one constant is its scale: it reads `(1 + s) p`.
#[derive(Clone, Debug)]
pub struct Points {
    constants: Vec<Parameter>,
}

impl Points {
    /// A tracker whose lengths are right.
    #[must_use]
    pub fn new() -> Self {
        Self { constants: Vec::new() }
    }

    /// One whose scale is to be found, 0 to within `tolerance` (a ratio) if that is given.
    #[must_use]
    pub fn with_scale(tolerance: Option<f64>) -> Self {
        Self { constants: vec![scale(tolerance)] }
    }
}

impl Default for Points {
    fn default() -> Self {
        Self::new()
    }
}

fn scale(tolerance: Option<f64>) -> Parameter {
    Parameter { tolerance, ..Parameter::new("scale", Unit::One).important(3) }
}

#[allow(non_snake_case)]
impl Device for Points {
    fn readings(&self) -> usize {
        3
    }

    fn constants(&self) -> &[Parameter] {
        &self.constants
    }

    fn predict(&self, X_IT: &Pose, constants: &[f64], readings: &mut [f64]) {
        let factor = 1.0 + constants.first().copied().unwrap_or(0.0);
        readings.copy_from_slice((X_IT.translation.vector * factor).as_slice());
    }

    fn unit(&self, _: usize) -> Unit {
        Unit::Metre
    }

    fn slopes(&self, X_IT: &Pose, constants: &[f64], _: &[f64], slopes: &mut DMatrix<f64>) {
        let factor = 1.0 + constants.first().copied().unwrap_or(0.0);
        slopes.fill(0.0);
        for i in 0..3 {
            slopes[(i, i)] = -factor;
            if !constants.is_empty() {
                slopes[(i, 6)] = -X_IT.translation.vector[i];
            }
        }
    }
}

/// A theodolite: horizontal angle (about z, from x) and elevation of a target \[rad\].
///
/// With errors it reads, in its first face, `Hz + c / cos V + i tan V` and `V + v0`: collimation c, trunnion axis i and index v0. The mean
/// of both faces is free of them.
#[derive(Clone, Debug)]
pub struct Angles {
    constants: Vec<Parameter>,
}

impl Angles {
    /// The mean of both faces.
    #[must_use]
    pub fn both_faces() -> Self {
        Self { constants: Vec::new() }
    }

    /// One face, with errors of the axes of about `tolerance` \[rad\].
    #[must_use]
    pub fn one_face(tolerance: f64) -> Self {
        let one = |name| Parameter::new(name, Unit::Radian).within(tolerance).important(3);
        Self { constants: ["collimation", "trunnion axis", "index"].map(one).into() }
    }
}

#[allow(non_snake_case)]
impl Device for Angles {
    fn readings(&self) -> usize {
        2
    }

    fn constants(&self) -> &[Parameter] {
        &self.constants
    }

    fn predict(&self, X_IT: &Pose, constants: &[f64], readings: &mut [f64]) {
        let p = X_IT.translation.vector;
        let elevation = p.z.atan2(p.x.hypot(p.y));
        let [c, i, v0] = [0, 1, 2].map(|k| constants.get(k).copied().unwrap_or(0.0));
        readings[0] = p.y.atan2(p.x) + c / elevation.cos() + i * elevation.tan();
        readings[1] = elevation + v0;
    }

    /// The difference of the horizontal angle is that of the line of sight: times the cosine of the elevation.
    fn difference(&self, read: &[f64], foretold: &[f64], difference: &mut [f64]) {
        let wrapped = read[0] - foretold[0];
        difference[0] = (wrapped - TAU * ((wrapped + PI) / TAU).floor()) * read[1].cos();
        difference[1] = read[1] - foretold[1];
    }

    fn unit(&self, _: usize) -> Unit {
        Unit::Radian
    }

    fn slopes(&self, X_IT: &Pose, constants: &[f64], read: &[f64], slopes: &mut DMatrix<f64>) {
        let p = X_IT.translation.vector;
        let (level, square) = (p.x.hypot(p.y), p.norm_squared());
        let elevation = p.z.atan2(level);
        let [c, i] = [0, 1].map(|k| constants.get(k).copied().unwrap_or(0.0));
        let cosine = read[1].cos();
        let d_elevation = [-p.x * p.z / level / square, -p.y * p.z / level / square, level / square];
        let d_level = [-p.y / (level * level), p.x / (level * level), 0.0];
        // c / cos V + i tan V, by V.
        let bend = (c * elevation.sin() + i) / elevation.cos().powi(2);
        slopes.fill(0.0);
        for k in 0..3 {
            slopes[(0, k)] = -cosine * (d_level[k] + bend * d_elevation[k]);
            slopes[(1, k)] = -d_elevation[k];
        }
        if !constants.is_empty() {
            slopes[(0, 6)] = -cosine / elevation.cos();
            slopes[(0, 7)] = -cosine * elevation.tan();
            slopes[(1, 8)] = -1.0;
        }
    }
}

/// A ball-bar, or a wire from a drum: the distance of a target from the instrument's origin \[m\]. Its one constant is how much longer
/// it is than it reads.
#[derive(Clone, Debug)]
pub struct Distance {
    constants: Vec<Parameter>,
}

impl Distance {
    /// One whose readings are right to within `tolerance` \[m\], if that is given; exactly right if it is 0.
    #[must_use]
    pub fn new(tolerance: Option<f64>) -> Self {
        let zero = Parameter { tolerance, ..Parameter::new("zero", Unit::Metre).important(3) };
        Self { constants: if tolerance == Some(0.0) { Vec::new() } else { vec![zero] } }
    }
}

#[allow(non_snake_case)]
impl Device for Distance {
    fn readings(&self) -> usize {
        1
    }

    fn constants(&self) -> &[Parameter] {
        &self.constants
    }

    fn predict(&self, X_IT: &Pose, constants: &[f64], readings: &mut [f64]) {
        readings[0] = X_IT.translation.vector.norm() - constants.first().copied().unwrap_or(0.0);
    }

    fn unit(&self, _: usize) -> Unit {
        Unit::Metre
    }
}

/// A touched plane, z = 0 of its frame: the target's tip is on it, within what is read (0, or a feeler's deflection \[m\]).
#[derive(Clone, Copy, Debug, Default)]
pub struct Plane;

#[allow(non_snake_case)]
impl Device for Plane {
    fn readings(&self) -> usize {
        1
    }

    fn predict(&self, X_IT: &Pose, _: &[f64], readings: &mut [f64]) {
        readings[0] = X_IT.translation.vector.z;
    }

    fn unit(&self, _: usize) -> Unit {
        Unit::Metre
    }
}

/// A touched point, such as a tip or a bore: the target is at the frame's origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct Touch;

#[allow(non_snake_case)]
impl Device for Touch {
    fn readings(&self) -> usize {
        3
    }

    fn predict(&self, X_IT: &Pose, _: &[f64], readings: &mut [f64]) {
        readings.copy_from_slice(X_IT.translation.vector.as_slice());
    }

    fn unit(&self, _: usize) -> Unit {
        Unit::Metre
    }
}

/// A device that reads full poses: position \[m\], then the orientation as a quaternion w, x, y, z. Its one constant is the scale of its positions, as of
/// a camera that looks at a board of which it believes a wrong size.
///
/// The residuals are the position, and the rotation vector in the instrument's axes.
#[derive(Clone, Debug)]
pub struct FullPose {
    constants: Vec<Parameter>,
}

impl FullPose {
    /// A device whose lengths are right.
    #[must_use]
    pub fn new() -> Self {
        Self { constants: Vec::new() }
    }

    /// One whose scale is to be found, 0 to within `tolerance` (a ratio) if that is given.
    #[must_use]
    pub fn with_scale(tolerance: Option<f64>) -> Self {
        Self { constants: vec![scale(tolerance)] }
    }
}

impl Default for FullPose {
    fn default() -> Self {
        Self::new()
    }
}

#[allow(non_snake_case)]
impl Device for FullPose {
    fn readings(&self) -> usize {
        7
    }

    fn residuals(&self) -> usize {
        6
    }

    fn constants(&self) -> &[Parameter] {
        &self.constants
    }

    fn predict(&self, X_IT: &Pose, constants: &[f64], readings: &mut [f64]) {
        let factor = 1.0 + constants.first().copied().unwrap_or(0.0);
        let q = X_IT.rotation.quaternion();
        readings[..3].copy_from_slice((X_IT.translation.vector * factor).as_slice());
        readings[3..].copy_from_slice(&[q.w, q.i, q.j, q.k]);
    }

    fn difference(&self, read: &[f64], foretold: &[f64], difference: &mut [f64]) {
        for i in 0..3 {
            difference[i] = read[i] - foretold[i];
        }
        let rotation =
            |q: &[f64]| UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[3], q[4], q[5], q[6]));
        let turn: Vector3<f64> = (rotation(read) * rotation(foretold).inverse()).scaled_axis();
        difference[3..].copy_from_slice(turn.as_slice());
    }

    fn unit(&self, i: usize) -> Unit {
        if i < 3 { Unit::Metre } else { Unit::Radian }
    }
}
