//! The pin-hole camera with the distortion of Brown (1971) and Conrady (1919).
//!
//! ```text
//! (a, b) = (x/z, y/z)                        of a point in the camera's frame C: z ahead, x to the right of the image, y down
//! r^2 = a^2 + b^2,  s = 1 + k1 r^2 + k2 r^4 + k3 r^6
//! a' = a s + 2 p1 a b + p2 (r^2 + 2 a^2),    b' = b s + p1 (r^2 + 2 b^2) + 2 p2 a b
//! u = fx a' + cx,  v = fy b' + cy            [pixel]; the middle of the first pixel is (0, 0)
//! ```

use nalgebra::{Matrix2, Vector2, Vector3};

/// The lens: how it distorts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lens {
    /// Radial: k1, k2, k3.
    pub radial: [f64; 3],
    /// Tangential: p1, p2.
    pub tangential: [f64; 2],
}

/// A camera: its image, and its lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Pixels in a row, and rows.
    pub size: [usize; 2],
    /// fx, fy \[pixel\], > 0.
    pub focal: [f64; 2],
    /// cx, cy \[pixel\].
    pub centre: [f64; 2],
    /// How it distorts.
    pub lens: Lens,
}

impl Camera {
    /// The camera of MRROC++'s vision experiments: 768 x 576 pixels, with the intrinsics of its calibration files.
    pub const MRROCPP: Self = Self {
        size: [768, 576],
        focal: [1871.2, 1877.6],
        centre: [383.5, 287.5],
        lens: Lens { radial: [-0.0688, 8.201, -136.3], tangential: [0.00774, 0.00296] },
    };

    /// The pixel at which a point of the camera's frame appears \[m\]; `None` of one that is not ahead.
    #[must_use]
    pub fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        (point.z > 0.0).then(|| {
            let bent = self.lens.distort(&(point.xy() / point.z)).0;
            Vector2::new(self.focal[0] * bent.x + self.centre[0], self.focal[1] * bent.y + self.centre[1])
        })
    }

    /// (a, b) of the ray that a pixel sees, by Newton's method from a first guess.
    #[must_use]
    pub fn ray(&self, pixel: &Vector2<f64>, guess: Option<Vector2<f64>>) -> Vector2<f64> {
        let bent = Vector2::new(
            (pixel.x - self.centre[0]) / self.focal[0],
            (pixel.y - self.centre[1]) / self.focal[1],
        );
        let mut ray = guess.unwrap_or(bent);
        for _ in 0..10 {
            let (got, slope) = self.lens.distort(&ray);
            let Some(inverse) = slope.try_inverse() else { break };
            let change = inverse * (bent - got);
            ray += change;
            if change.norm_squared() < 1e-20 {
                break;
            }
        }
        ray
    }
}

impl Lens {
    /// The distorted (a', b'), and its derivatives by (a, b).
    #[must_use]
    pub fn distort(&self, at: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let (a, b) = (at.x, at.y);
        let q = a * a + b * b;
        let s = 1.0 + q * (k1 + q * (k2 + q * k3));
        let ds = k1 + q * (2.0 * k2 + q * 3.0 * k3);
        let bent = Vector2::new(
            a * s + 2.0 * p1 * a * b + p2 * (q + 2.0 * a * a),
            b * s + p1 * (q + 2.0 * b * b) + 2.0 * p2 * a * b,
        );
        let slope = Matrix2::new(
            s + 2.0 * a * a * ds + 2.0 * p1 * b + 6.0 * p2 * a,
            2.0 * a * b * ds + 2.0 * p1 * a + 2.0 * p2 * b,
            2.0 * a * b * ds + 2.0 * p1 * a + 2.0 * p2 * b,
            s + 2.0 * b * b * ds + 6.0 * p1 * b + 2.0 * p2 * a,
        );
        (bent, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixels_ray_is_projected_onto_that_pixel() {
        let camera = Camera::MRROCPP;
        for i in 0..=10 {
            for j in 0..=10 {
                let pixel = Vector2::new(76.7 * f64::from(i), 57.5 * f64::from(j));
                let ray = camera.ray(&pixel, None);
                let back = camera.project(&Vector3::new(ray.x, ray.y, 1.0)).expect("ahead");
                assert!((back - pixel).norm() < 1e-8, "{pixel} {back}");
            }
        }
        assert_eq!(camera.project(&-Vector3::z()), None);
    }

    #[test]
    fn pixels_are_those_of_opencv() {
        // cv2.projectPoints of OpenCV 5.0 with these intrinsics, without rotation and translation.
        let camera = Camera::MRROCPP;
        for (point, pixel) in OPENCV {
            let got = camera.project(&Vector3::from(point)).expect("ahead");
            assert!((got - Vector2::from(pixel)).norm() < 1e-6, "{got} {pixel:?}");
        }
    }

    const OPENCV: [([f64; 3], [f64; 2]); 4] = [
        ([0.1, 0.05, 0.85], [604.213_755_636_276_9, 398.437_680_118_585_55]),
        ([-0.15, 0.1, 0.8], [32.709_954_823_878_72, 523.086_029_388_987_6]),
        ([0.12, -0.11, 0.82], [657.681_900_644_042_8, 36.080_492_207_796_28]),
        ([-0.05, -0.09, 0.9], [279.791_389_273_319_5, 100.245_286_403_054_68]),
    ];
}
