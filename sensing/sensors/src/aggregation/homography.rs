//! The homography from a plane to an image.

use nalgebra::{Matrix3, SMatrix, Vector2};

/// The homography that maps points of a plane to pixels, by least squares with its last number 1, in units of the pixels' spread.
pub(super) fn homography(points: &[Vector2<f64>], pixels: &[Vector2<f64>]) -> Option<Matrix3<f64>> {
    let n = points.len() as f64;
    let mean = pixels.iter().sum::<Vector2<f64>>() / n;
    let spread = (pixels.iter().map(|one| (one - mean).norm_squared()).sum::<f64>() / n).sqrt();
    let mut square = SMatrix::<f64, 8, 8>::zeros();
    let mut right = SMatrix::<f64, 8, 1>::zeros();
    for (p, pixel) in points.iter().zip(pixels) {
        let [u, v] = <[f64; 2]>::from((pixel - mean) / spread);
        for (row, value) in [
            ([p.x, p.y, 1.0, 0.0, 0.0, 0.0, -u * p.x, -u * p.y], u),
            ([0.0, 0.0, 0.0, p.x, p.y, 1.0, -v * p.x, -v * p.y], v),
        ] {
            let row = SMatrix::<f64, 8, 1>::from(row);
            square += row * row.transpose();
            right += row * value;
        }
    }
    let h = square.lu().solve(&right)?;
    let own = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1.0);
    let back = Matrix3::new(spread, 0.0, mean.x, 0.0, spread, mean.y, 0.0, 0.0, 1.0);
    let plane = back * own;
    plane.iter().all(|number| number.is_finite()).then_some(plane)
}
