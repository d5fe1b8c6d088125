//! Images of grey values, and smoothed ones.

use nalgebra::Vector2;

/// A grey image.
#[derive(Clone, Copy, Debug)]
pub struct Grey<'i> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Grey values, row by row.
    pub pixels: &'i [u8],
}

impl<'i> Grey<'i> {
    /// An image of these pixels; `None` if it is empty or they are not as many.
    #[must_use]
    pub fn new(width: usize, height: usize, pixels: &'i [u8]) -> Option<Self> {
        let fits = width > 0 && height > 0 && width.checked_mul(height) == Some(pixels.len());
        fits.then_some(Self { width, height, pixels })
    }

    /// The grey value at a place \[pixel\], linear between pixels; those at the rim go on beyond it.
    #[must_use]
    pub fn at(&self, at: &Vector2<f64>) -> f64 {
        between(self.width, self.height, at, |index| f64::from(self.pixels[index]))
    }
}

/// Linear between four pixels.
fn between(width: usize, height: usize, at: &Vector2<f64>, pixel: impl Fn(usize) -> f64) -> f64 {
    let x = at.x.clamp(0.0, (width - 1) as f64);
    let y = at.y.clamp(0.0, (height - 1) as f64);
    let (i, j) = ((x as usize).min(width.saturating_sub(2)), (y as usize).min(height.saturating_sub(2)));
    let (s, t) = (x - i as f64, y - j as f64);
    let (right, below) = ((i + 1).min(width - 1), (j + 1).min(height - 1));
    (pixel(j * width + i) * (1.0 - s) + pixel(j * width + right) * s) * (1.0 - t)
        + (pixel(below * width + i) * (1.0 - s) + pixel(below * width + right) * s) * t
}

/// Grey values that need not be whole numbers.
#[derive(Clone, Debug)]
pub(super) struct Smooth {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) values: Vec<f32>,
}

impl Smooth {
    pub(super) fn of(image: &Grey<'_>) -> Self {
        let values = image.pixels.iter().map(|grey| f32::from(*grey)).collect();
        Self { width: image.width, height: image.height, values }
    }

    /// Means of two by two pixels.
    pub(super) fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let pixel =
            |x: usize, y: usize| self.values[y.min(self.height - 1) * self.width + x.min(self.width - 1)];
        let mean = |index: usize| {
            let (x, y) = (2 * (index % width), 2 * (index / width));
            0.25 * (pixel(x, y) + pixel(x + 1, y) + pixel(x, y + 1) + pixel(x + 1, y + 1))
        };
        Self { width, height, values: (0..width * height).map(mean).collect() }
    }

    /// Smoothed by a Gaussian of this standard deviation \[pixel\].
    pub(super) fn blurred(&self, sigma: f32) -> Self {
        let reach = (3.0 * sigma).ceil() as isize;
        let kernel: Vec<f32> = (-reach..=reach).map(|k| (-0.5 * (k as f32 / sigma).powi(2)).exp()).collect();
        let sum: f32 = kernel.iter().sum();
        let along = |from: &[f32], length: usize, stride: usize, begin: usize, into: &mut [f32]| {
            for k in 0..length {
                let taps = kernel.iter().zip(-reach..).map(|(weight, off)| {
                    let k = (k as isize + off).clamp(0, length as isize - 1) as usize;
                    weight * from[begin + k * stride]
                });
                into[begin + k * stride] = taps.sum::<f32>() / sum;
            }
        };
        let (mut rows, mut both) = (vec![0.0; self.values.len()], vec![0.0; self.values.len()]);
        (0..self.height).for_each(|y| along(&self.values, self.width, 1, y * self.width, &mut rows));
        (0..self.width).for_each(|x| along(&rows, self.height, self.width, x, &mut both));
        Self { values: both, ..*self }
    }

    pub(super) fn at(&self, at: &Vector2<f64>) -> f64 {
        between(self.width, self.height, at, |index| f64::from(self.values[index]))
    }
}
