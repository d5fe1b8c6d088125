//! Parts in an image: which class, where, and at which angle.
//!
//! ```text
//! image -> bright things (Blobs) -> features -> classes by a classifier
//!       -> place: that at which the class's form, seen by this camera, has the centre and the axis that are observed
//! ```
//!
//! A part that stands up shows its sides, the more the farther it is from the axis of the camera. So its outline is compared with that
//! which its class would have, by rays through the same camera: that takes the parallax away, whatever the form. A thing whose outline
//! differs from that of its class is none of the known parts.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector2, Vector3};
use thiserror::Error;

use super::blobs::{Blob, Blobs};
use super::features::{FEATURES, Moments, features};
use crate::camera::Plane;
use crate::form::Form;

/// A class of parts.
#[derive(Clone, Debug, PartialEq)]
pub struct PartClass {
    /// Its name.
    pub name: &'static str,
    /// Its form, in the frame P of the part: on the belt, z up.
    pub form: Form,
    /// In how many attitudes about z it looks the same; 0: in all.
    pub turns: u32,
}

/// Tells classes by features.
pub trait Classifier {
    /// How likely each class is, 0 to 1, in the order of the classes; `None` where it could not tell.
    fn classify(&mut self, features: &[f32]) -> Option<Vec<f32>>;
}

/// A thing in an image.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectedObject {
    /// Its class; `None` of something unknown.
    pub class: Option<usize>,
    /// How likely the likeliest class is, 0 to 1.
    pub score: f64,
    /// How well its outline is that of the class: common area by joint area, 0 to 1.
    pub fit: f64,
    /// Where its frame P is on the belt \[m, F\].
    pub place: Vector2<f64>,
    /// Angle of x of P from x of F \[rad\].
    pub angle: f64,
    /// Its pixels.
    pub blob: Blob,
    /// What it was told by.
    pub features: [f32; FEATURES],
}

/// Why nothing can be seen.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Blind {
    /// The image is dark.
    #[error("the image is dark, mean grey {mean:.1}, usually {usual:.1}: lens covered or lamp off?")]
    Dark {
        /// Mean grey value.
        mean: f64,
        /// That of the image of the empty belt.
        usual: f64,
    },
    /// The image of the empty belt, with which all others are compared, has no light.
    #[error("the empty belt is dark, mean grey {mean:.1}, at least {least:.1}: lens covered or lamp off?")]
    NoLight {
        /// Mean grey value.
        mean: f64,
        /// What it has to be at least.
        least: f64,
    },
}

/// What makes parts of images.
pub struct Vision {
    plane: Plane,
    /// Where each pixel sees the belt, and how much of it \[m, m²\].
    ground: Vec<[f32; 3]>,
    classes: Vec<PartClass>,
    classifier: Box<dyn Classifier>,
    empty: Option<(f64, Blobs)>,
}

impl core::fmt::Debug for Vision {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Vision").field("classes", &self.classes).finish_non_exhaustive()
    }
}

impl Vision {
    /// The classifier is believed from this score on ..
    pub const SCORE: f64 = 0.7;
    /// .. and its class from this fit of outlines on.
    pub const FIT: f64 = 0.93;
    /// The least mean grey value of an image of the empty belt.
    const LIGHT: f64 = 3.0;
    /// Outlines are compared again and again, in each of so many columns and rows.
    const STRIDES: [usize; 4] = [2, 2, 1, 1];

    /// By a camera that looks at a belt like this, for these classes.
    #[must_use]
    pub fn new(plane: Plane, classes: Vec<PartClass>, classifier: Box<dyn Classifier>) -> Self {
        let (width, pixels) = (plane.width(), plane.width() * plane.height());
        let ground = |index: usize| {
            let at = plane.place(index);
            // To the neighbours; at the edges to those on the other side.
            let right = if (index + 1).is_multiple_of(width) {
                at - plane.place(index - 1)
            } else {
                plane.place(index + 1) - at
            };
            let down = if index + width >= pixels {
                at - plane.place(index - width)
            } else {
                plane.place(index + width) - at
            };
            [at.x as f32, at.y as f32, right.perp(&down).abs() as f32]
        };
        Self { ground: (0..pixels).map(ground).collect(), plane, classes, classifier, empty: None }
    }

    /// The camera as it is believed to be.
    #[must_use]
    pub const fn plane(&self) -> &Plane {
        &self.plane
    }

    /// The classes.
    #[must_use]
    pub fn classes(&self) -> &[PartClass] {
        &self.classes
    }

    /// Whether it has seen the empty belt.
    #[must_use]
    pub const fn is_taught(&self) -> bool {
        self.empty.is_some()
    }

    /// Shows it the empty belt.
    ///
    /// # Errors
    /// [`Blind::NoLight`].
    ///
    /// # Panics
    /// If the image has not the camera's size.
    pub fn teach(&mut self, image: &[u8]) -> Result<(), Blind> {
        let mean = mean(image);
        if mean < Self::LIGHT {
            return Err(Blind::NoLight { mean, least: Self::LIGHT });
        }
        self.empty = Some((mean, Blobs::of(self.plane.camera.size, image)));
        Ok(())
    }

    /// The things that are wholly in an image.
    ///
    /// # Errors
    /// [`Blind`] of an image that shows nothing, or before it has been taught.
    ///
    /// # Panics
    /// If the image has not the camera's size.
    pub fn look(&mut self, image: &[u8]) -> Result<Vec<DetectedObject>, Blind> {
        let seen = mean(image);
        let Some((usual, blobs)) = &mut self.empty else {
            return Err(Blind::NoLight { mean: 0.0, least: Self::LIGHT });
        };
        if seen < 0.5 * *usual {
            return Err(Blind::Dark { mean: seen, usual: *usual });
        }
        let blobs = blobs.find(image);
        Ok(blobs.into_iter().map(|blob| self.evaluate(blob, image)).collect())
    }

    /// Place and area of a pixel.
    fn ground(&self, index: usize) -> ([f64; 2], f64) {
        let [x, y, area] = self.ground[index];
        ([x.into(), y.into()], area.into())
    }

    fn evaluate(&mut self, blob: Blob, image: &[u8]) -> DetectedObject {
        let moments = Moments::of(blob.pixels.iter().map(|&index| self.ground(index)));
        let features = features(&blob, &moments, image, self.plane.width(), |index| self.ground(index));
        let scores = self.classifier.classify(&features).unwrap_or_default();
        let best = scores.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let best = best
            .filter(|(class, _)| *class < self.classes.len())
            .map(|(class, score)| (class, f64::from(*score)));
        let mut found = DetectedObject {
            class: None,
            score: best.map_or(0.0, |(_, score)| score),
            fit: 0.0,
            place: moments.centre,
            angle: moments.axis(),
            blob,
            features,
        };
        if let Some((class, score)) = best {
            (found.fit, found.place, found.angle) = self.fit(class, &moments, &found.blob);
            found.class = (score >= Self::SCORE && found.fit >= Self::FIT).then_some(class);
        }
        found
    }

    /// Fit, place and angle of a class whose outline has the centre and the axis of what is observed.
    fn fit(&self, class: usize, observed: &Moments, blob: &Blob) -> (f64, Vector2<f64>, f64) {
        let PartClass { form, turns, .. } = &self.classes[class];
        let starts: &[f64] = match turns {
            0 => &[0.0],
            1 => &[0.0, PI],
            _ => &[0.0],
        };
        // How its own long axis lies.
        let alone = self.outline(form, observed.centre, 0.0, blob, 2).0.axis();
        let mut best = (0.0, observed.centre, 0.0);
        for start in starts {
            let (mut place, mut angle) =
                (observed.centre, if *turns == 0 { 0.0 } else { start + observed.axis() - alone });
            let mut fit = 0.0;
            for step in Self::STRIDES {
                let (expected, common) = self.outline(form, place, angle, blob, step);
                fit = common;
                let off = observed.centre - expected.centre;
                place += off;
                let turn = if *turns == 0 { 0.0 } else { within(observed.axis() - expected.axis(), PI) };
                angle += turn;
            }
            if fit > best.0 {
                best = (fit, place, angle);
            }
        }
        let period = if *turns == 0 { PI } else { 2.0 * PI / f64::from(*turns) };
        (best.0, best.1, within(best.2, period))
    }

    /// The outline of a form, by rays through the camera: its moments on the belt, and how much of it and the thing is common.
    #[allow(non_snake_case)]
    fn outline(
        &self,
        form: &Form,
        place: Vector2<f64>,
        angle: f64,
        blob: &Blob,
        step: usize,
    ) -> (Moments, f64) {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let X_FP = Pose::from_parts(Translation3::new(place.x, place.y, 0.0), turn);
        let corners = form.corners().map(|corner| X_FP.transform_point(&Point3::from(corner)).coords);
        let Some([[left, right], [top, bottom]]) = self.plane.window(corners, 2.0) else {
            return (Moments::default(), 0.0);
        };
        let width = self.plane.width();
        let X_PC = X_FP.inv_mul(&self.plane.X_FC);
        let eye = X_PC.translation.vector;
        let mut pixels = Vec::new();
        let aligned = |from: usize| from.next_multiple_of(step);
        for row in (aligned(top)..bottom).step_by(step) {
            for column in (aligned(left)..right).step_by(step) {
                let index = row * width + column;
                if form.hit(&eye, &(X_PC.rotation * self.plane.ray(index))).is_some() {
                    pixels.push(index);
                }
            }
        }
        let own =
            |index: &&usize| [**index / width, **index % width].iter().all(|at| at.is_multiple_of(step));
        let all = blob.pixels.iter().filter(own).count();
        let common = pixels.iter().filter(|index| blob.pixels.binary_search(index).is_ok()).count();
        let joint = (all + pixels.len() - common).max(1);
        let moments = Moments::of(pixels.iter().map(|&index| self.ground(index)));
        (moments, common as f64 / joint as f64)
    }
}

/// Brought within half a period of 0.
fn within(angle: f64, period: f64) -> f64 {
    angle - period * (angle / period).round()
}

fn mean(image: &[u8]) -> f64 {
    image.iter().map(|grey| u64::from(*grey)).sum::<u64>() as f64 / image.len().max(1) as f64
}
