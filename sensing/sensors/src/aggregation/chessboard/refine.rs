//! Where a corner is to a fraction of a pixel.
//!
//! At each place p around the corner q the gradient g is either none or perpendicular to an edge that leads to q, so that `g . (p - q) = 0`. Least
//! squares over a window tell q (Foerstner and Guelch 1987); OpenCV's `cornerSubPix` is the same, with these weights and this rule for its end.

use nalgebra::{Matrix2, Vector2};

use super::grey::Grey;

/// How often a corner is moved at most, and the step after which it is not moved any more \[pixel\].
const ROUNDS: usize = 30;
const STILL: f64 = 1e-3;

/// Moves a corner \[pixel\] to where the gradients in a window of `2 window + 1` pixels point; back to where it was if that is outside the window.
#[must_use]
pub fn refine(image: &Grey<'_>, at: &Vector2<f64>, window: usize) -> Vector2<f64> {
    let reach = window as isize;
    let weight = |off: isize| (-(off as f64 / window as f64).powi(2)).exp();
    let side = 2 * window + 3;
    let mut patch = vec![0.0; side * side];
    let mut corner = *at;
    for _ in 0..ROUNDS {
        for (index, grey) in patch.iter_mut().enumerate() {
            let off = Vector2::new((index % side) as f64, (index / side) as f64)
                - Vector2::repeat(window as f64 + 1.0);
            *grey = image.at(&(corner + off));
        }
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for y in -reach..=reach {
            for x in -reach..=reach {
                let index = (y + reach + 1) as usize * side + (x + reach + 1) as usize;
                let slope = Vector2::new(
                    patch[index + 1] - patch[index - 1],
                    patch[index + side] - patch[index - side],
                );
                let part = slope * slope.transpose() * (weight(x) * weight(y));
                normal += part;
                right += part * Vector2::new(x as f64, y as f64);
            }
        }
        let Some(inverse) = normal.try_inverse() else { break };
        let step = inverse * right;
        corner += step;
        let inside = corner.x >= 0.0
            && corner.y >= 0.0
            && corner.x <= (image.width - 1) as f64
            && corner.y <= (image.height - 1) as f64;
        if !inside {
            return *at;
        }
        if step.norm_squared() < STILL * STILL {
            break;
        }
    }
    if (corner - at).amax() > window as f64 { *at } else { corner }
}
