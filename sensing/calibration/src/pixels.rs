//! Pixels of a board: where a camera sees points of a target, such as the corners of a chessboard.

use core::fmt;

use mrroc::pose::Pose;
use mrroc_sensors::camera::{Camera, Lens};
use nalgebra::{DMatrix, Matrix2, Matrix2x3, Point3, Vector2, Vector3};

use crate::device::Device;
use crate::parameter::{Parameter, Unit};

/// What of a camera is not known, in the order of its constants. Those of the lens are 0 of one that does not distort.
const NAMES: [&str; 9] = ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"];

/// A camera that sees points of a target: u, v \[pixel\] of each. Its constants are what is to be added to fx, fy, cx, cy \[pixel\] and k1, k2, p1, p2, k3
/// of the camera that is believed in, if they are to be found.
#[derive(Clone, Debug)]
pub struct Pixels {
    camera: Camera,
    points: Vec<Vector3<f64>>,
    constants: Vec<Parameter>,
}

impl Pixels {
    /// A camera that is known, and the points of its target \[m\].
    #[must_use]
    pub fn of(camera: Camera, points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        Self { camera, points: points.into_iter().collect(), constants: Vec::new() }
    }

    /// One of which nothing is known but that it is about like this.
    #[must_use]
    pub fn unknown(about: Camera, points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        let constant = |(i, name): (usize, &str)| {
            Parameter::new(name, if i < 4 { Unit::Pixel } else { Unit::One }).important(3)
        };
        Self { constants: NAMES.into_iter().enumerate().map(constant).collect(), ..Self::of(about, points) }
    }

    /// The camera with such constants; without any, the one that is known.
    #[must_use]
    pub fn camera(&self, constants: &[f64]) -> Camera {
        let [fx, fy, cx, cy, k1, k2, p1, p2, k3] =
            core::array::from_fn(|i| constants.get(i).copied().unwrap_or(0.0));
        let Camera { size, focal, centre, lens } = self.camera;
        Camera {
            size,
            focal: [focal[0] + fx, focal[1] + fy],
            centre: [centre[0] + cx, centre[1] + cy],
            lens: Lens {
                radial: [lens.radial[0] + k1, lens.radial[1] + k2, lens.radial[2] + k3],
                tangential: [lens.tangential[0] + p1, lens.tangential[1] + p2],
            },
        }
    }
}

#[allow(non_snake_case)]
impl Device for Pixels {
    fn readings(&self) -> usize {
        2 * self.points.len()
    }

    fn constants(&self) -> &[Parameter] {
        &self.constants
    }

    /// Points behind the camera are mirrored, so that no image fits them.
    fn predict(&self, X_IT: &Pose, constants: &[f64], readings: &mut [f64]) {
        let camera = self.camera(constants);
        for (point, pixel) in self.points.iter().zip(readings.chunks_exact_mut(2)) {
            let p = (X_IT * Point3::from(*point)).coords;
            let bent = camera.lens.distort(&(p.xy() / p.z)).0;
            for axis in 0..2 {
                pixel[axis] = camera.focal[axis] * bent[axis] + camera.centre[axis];
            }
        }
    }

    fn unit(&self, _: usize) -> Unit {
        Unit::Pixel
    }

    fn slopes(&self, X_IT: &Pose, constants: &[f64], _: &[f64], slopes: &mut DMatrix<f64>) {
        let Camera { focal, lens, .. } = self.camera(constants);
        let scale = Matrix2::from_diagonal(&Vector2::from(focal));
        slopes.fill(0.0);
        for (i, point) in self.points.iter().enumerate() {
            let own = X_IT.rotation * point;
            let p = own + X_IT.translation.vector;
            let (a, b) = (p.x / p.z, p.y / p.z);
            let (bent, slope) = lens.distort(&Vector2::new(a, b));
            let ray = Matrix2x3::new(1.0, 0.0, -a, 0.0, 1.0, -b) / p.z;
            let by_place = scale * slope * ray;
            let by_turn = -by_place * own.cross_matrix();
            let mut rows = slopes.rows_mut(2 * i, 2);
            rows.fixed_view_mut::<2, 3>(0, 0).copy_from(&-by_place);
            rows.fixed_view_mut::<2, 3>(0, 3).copy_from(&-by_turn);
            if self.constants.is_empty() {
                continue;
            }
            let q = a * a + b * b;
            let [fx, fy] = focal;
            // By fx, fy, cx, cy, k1, k2, p1, p2, k3.
            let u = [
                bent.x,
                0.0,
                1.0,
                0.0,
                fx * a * q,
                fx * a * q * q,
                fx * 2.0 * a * b,
                fx * (q + 2.0 * a * a),
                fx * a * q * q * q,
            ];
            let v = [
                0.0,
                bent.y,
                0.0,
                1.0,
                fy * b * q,
                fy * b * q * q,
                fy * (q + 2.0 * b * b),
                fy * 2.0 * a * b,
                fy * b * q * q * q,
            ];
            for (column, (u, v)) in u.iter().zip(&v).enumerate() {
                rows[(0, 6 + column)] = -u;
                rows[(1, 6 + column)] = -v;
            }
        }
    }
}

/// Names and units of what is found of a camera, for people and files: `fx`, `px`, and so on.
pub(crate) fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
    NAMES.into_iter().enumerate().map(|(i, name)| (name, if i < 4 { "px" } else { "" }))
}

/// fx, fy, cx, cy, k1, k2, p1, p2, k3 of a camera.
pub(crate) fn numbers(camera: &Camera) -> [f64; 9] {
    let Camera {
        focal: [fx, fy],
        centre: [cx, cy],
        lens: Lens { radial: [k1, k2, k3], tangential: [p1, p2] },
        ..
    } = *camera;
    [fx, fy, cx, cy, k1, k2, p1, p2, k3]
}

/// Writes numbers as a list of TOML.
pub(crate) struct List<'n>(pub(crate) &'n [f64]);

impl fmt::Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.0)
    }
}
