//! A part of a plane as a camera sees it, looked at straight on: by squares of equal size in a frame of that plane.

use nalgebra::{Point3, Vector2, Vector3};

use crate::camera::Plane;
use mrroc::pose::Pose;

/// Grey values of squares.
#[derive(Clone, Debug)]
pub struct Rectified {
    /// Columns, along x, and rows, along y.
    pub size: [usize; 2],
    /// Side length of a square \[m\].
    pub cell: f64,
    /// Where the middle of the first square is \[m\].
    pub origin: Vector2<f64>,
    grey: Vec<f32>,
}

/// The camera's model is evaluated at every so many-th square, and interpolated between.
const COARSE: usize = 16;

impl Rectified {
    /// What `image` shows of the plane z = `height` \[m\] of a frame M at `X_FM`, from `-pad` to `sides + pad` \[m\].
    ///
    /// # Panics
    /// If the image has not the camera's size.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn of(
        plane: &Plane,
        image: &[u8],
        X_FM: &Pose,
        height: f64,
        sides: [f64; 2],
        pad: f64,
        cell: f64,
    ) -> Self {
        let size = sides.map(|side| ((side + 2.0 * pad) / cell).ceil() as usize);
        let origin = Vector2::new(-pad, -pad) + Vector2::repeat(0.5 * cell);
        let [columns, rows] = size;
        let (width, tall) = (plane.width(), plane.height());
        let pixel = |i: usize, j: usize| {
            let at = Vector3::new(origin.x + i as f64 * cell, origin.y + j as f64 * cell, height);
            let seen = plane.project(&X_FM.transform_point(&Point3::from(at)).coords);
            seen.map_or([f32::NAN; 2], |at| [at.x as f32, at.y as f32])
        };
        let across = columns.div_ceil(COARSE) + 1;
        let coarse: Vec<[f32; 2]> = (0..rows.div_ceil(COARSE) + 1)
            .flat_map(|j| (0..across).map(move |i| (i, j)))
            .map(|(i, j)| pixel(i * COARSE, j * COARSE))
            .collect();
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let mut grey = Vec::with_capacity(columns * rows);
        for j in 0..rows {
            let (cj, t) = (j / COARSE, (j % COARSE) as f32 / COARSE as f32);
            for ci in 0..columns.div_ceil(COARSE) {
                let at = cj * across + ci;
                let corner = |k: usize| [at, at + 1].map(|at| mix(coarse[at][k], coarse[at + across][k], t));
                let [[u0, u1], [v0, v1]] = [corner(0), corner(1)];
                for i in 0..COARSE.min(columns - ci * COARSE) {
                    let s = i as f32 / COARSE as f32;
                    let (u, v) = (mix(u0, u1, s), mix(v0, v1, s));
                    // Outside of the image it is dark; so is what is not ahead of the camera.
                    let inside = u >= 0.0 && v >= 0.0 && u < (width - 1) as f32 && v < (tall - 1) as f32;
                    grey.push(if inside {
                        let index = v as usize * width + u as usize;
                        let (s, t) = (u.fract(), v.fract());
                        let at = |off: usize| f32::from(image[index + off]);
                        mix(mix(at(0), at(1), s), mix(at(width), at(width + 1), s), t)
                    } else {
                        0.0
                    });
                }
            }
        }
        Self { size, cell, origin, grey }
    }

    /// The grey value of a square; 0 outside.
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> f32 {
        if column < self.size[0] {
            self.grey.get(row * self.size[0] + column).copied().unwrap_or(0.0)
        } else {
            0.0
        }
    }

    /// All of them, row by row from the lowest y.
    #[must_use]
    pub fn grey(&self) -> &[f32] {
        &self.grey
    }

    /// The coordinate \[m\] of a place that is counted in squares, along an axis.
    #[must_use]
    pub fn metres(&self, axis: usize, squares: f64) -> f64 {
        self.origin[axis] + squares * self.cell
    }
}
