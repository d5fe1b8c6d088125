//! Pixels on the plane of a belt: for each pixel, once and for all, the ray that it sees and where that meets the plane.

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector2, Vector3};

use super::model::Camera;

/// A camera over the plane z = 0 of a frame F, in which it is at `X_FC`.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Plane {
    /// The camera.
    pub camera: Camera,
    /// Where it is.
    pub X_FC: Pose,
    /// (a, b) of each pixel's ray.
    rays: Vec<[f32; 2]>,
}

impl Plane {
    /// Looks up all pixels.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(camera: Camera, X_FC: Pose) -> Self {
        let [width, height] = camera.size;
        let mut rays = Vec::with_capacity(width * height);
        for v in 0..height {
            let mut last = None;
            for u in 0..width {
                let ray = camera.ray(&Vector2::new(u as f64, v as f64), last);
                last = Some(ray);
                rays.push([ray.x as f32, ray.y as f32]);
            }
        }
        Self { camera, X_FC, rays }
    }

    /// The same pixels of a camera that is elsewhere.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(&self, X_FC: Pose) -> Self {
        Self { X_FC, ..self.clone() }
    }

    /// Pixels in a row.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.camera.size[0]
    }

    /// Rows.
    #[must_use]
    pub const fn height(&self) -> usize {
        self.camera.size[1]
    }

    /// Direction of the ray of a pixel, in C; 1 along z.
    #[must_use]
    pub fn ray(&self, index: usize) -> Vector3<f64> {
        let [a, b] = self.rays[index];
        Vector3::new(a.into(), b.into(), 1.0)
    }

    /// Where the ray of a pixel meets the plane \[m, in F\].
    #[must_use]
    pub fn place(&self, index: usize) -> Vector2<f64> {
        let (eye, ray) = (self.X_FC.translation.vector, self.X_FC.rotation * self.ray(index));
        (eye - ray * (eye.z / ray.z)).xy()
    }

    /// The pixel at which a point of F appears \[m\].
    #[must_use]
    pub fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        self.camera.project(&self.X_FC.inverse_transform_point(&Point3::from(*point)).coords)
    }

    /// Columns and rows that hold these points of F \[m\], by `margin` more on each side; `None` of those outside the image.
    #[must_use]
    pub fn window(&self, points: impl Iterator<Item = Vector3<f64>>, margin: f64) -> Option<[[usize; 2]; 2]> {
        let (mut least, mut most) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
        for point in points {
            let at = self.project(&point)?;
            least = least.inf(&at);
            most = most.sup(&at);
        }
        let side = |axis: usize| {
            let end = self.camera.size[axis] as f64;
            let (from, to) = ((least[axis] - margin).floor().max(0.0), (most[axis] + margin).ceil().min(end));
            (from < to).then_some([from as usize, to as usize])
        };
        Some([side(0)?, side(1)?])
    }
}
