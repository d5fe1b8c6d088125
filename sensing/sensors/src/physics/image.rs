//! A digital camera: the light that comes to each pixel while it is exposed, and what the sensor makes of it.
//!
//! ```text
//! irradiance of a surface   E(n) = g(x, y) (A (1 + n_z)/2 + (1 - A) max(0, n . l))     diffuse light and a lamp, unevenly bright
//! radiance                  L = albedo E, seen through cos^4 of the ray's angle        vignetting
//! electrons                 e = P(full L) + N(0, read),   grey = round(255 e/well)     EMVA 1288: shot, read, quantisation noise
//! ```
//!
//! A pixel takes several rays, spread over its area and over the exposure: edges are smooth, and what moves is blurred. The true state of
//! the world is seen, at the times of the exposure. Surfaces are matt, and cast no shadows.

use mrroc::pose::Pose;
use mrroc::random::Noise;
use nalgebra::{Point3, Vector3};

use crate::camera::{Camera, Plane};
use crate::form::Form;
use crate::view::View;

/// A camera with its light.
#[derive(Clone, Debug)]
pub struct Imager {
    plane: Plane,
    /// Of each pixel: where it sees the belt \[m\], and how bright something white is there.
    ground: Vec<[f32; 3]>,
    belt: Texture,
    exposure: f64,
    interlaced: bool,
    normals: Vec<f32>,
    random: Noise,
    dark: Option<(f64, Dark)>,
    /// Rays of each pixel that met something, and the light of those.
    met: Vec<(u8, f32)>,
}

/// Why a camera sees nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dark {
    /// Its lens is covered.
    Covered,
    /// The lamp is off: a fiftieth of the light is left.
    LampOff,
}

/// Times within an exposure.
const MOMENTS: usize = 4;
/// Rays of a pixel: where in it, and at which of the times.
const RAYS: [(f64, f64, usize); 8] = [
    (-0.4375, -0.1875, 0),
    (0.0625, 0.3125, 0),
    (-0.1875, 0.4375, 1),
    (0.3125, -0.0625, 1),
    (-0.0625, -0.3125, 2),
    (0.4375, 0.1875, 2),
    (-0.3125, 0.0625, 3),
    (0.1875, -0.4375, 3),
];
/// Share of the light that comes from everywhere, and where the lamp is.
const DIFFUSE: f64 = 0.65;
const LAMP: [f64; 3] = [0.25, -0.35, 0.9];
/// Electrons of something white, of the largest grey value, and of the reader's noise.
const FULL: f32 = 9000.0;
const WELL: f32 = 10_000.0;
const READ: f32 = 12.0;
/// Time between the two fields of an interlaced image \[s\].
const FIELD: f64 = 0.02;

/// Something in view, from the camera's side.
struct Thing<'f> {
    form: &'f Form,
    reflectance: f64,
    /// Of each field and moment: its frame, and eye and axes of the camera in it.
    eyes: [[(Vector3<f64>, Pose); MOMENTS]; 2],
    window: [[usize; 2]; 2],
}

impl Imager {
    /// A camera at `X_FC` over a belt: exposures of 4 ms, whole images. The seed is that of its noise and of its light.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(camera: Camera, X_FC: Pose, seed: u64) -> Self {
        Self::over(Plane::new(camera, X_FC), seed)
    }

    /// The same of a camera whose pixels are looked up already.
    #[must_use]
    pub fn over(plane: Plane, seed: u64) -> Self {
        let mut random = Noise::seeded(seed);
        let brightness = random.between(0.85, 1.0);
        // The light falls off from a place near the middle of the image.
        let [x, y] = [random.between(-0.05, 0.05), random.between(-0.05, 0.05)];
        let centre = plane.X_FC.translation.vector.xy() + nalgebra::Vector2::new(x, y);
        let pixel = |index: usize| {
            let (place, ray) = (plane.place(index), plane.ray(index));
            let vignetting = ray.norm_squared().powi(-2);
            let light = brightness * (1.0 - 4.0 * (place - centre).norm_squared()) * vignetting;
            [place.x as f32, place.y as f32, light as f32]
        };
        let pixels = plane.width() * plane.height();
        let ground = (0..pixels).map(pixel).collect();
        let normals = (0..8192).map(|_| random.normal() as f32).collect();
        let belt = Texture::new(&mut random);
        let met = vec![(0, 0.0); pixels];
        Self { plane, ground, belt, exposure: 4e-3, interlaced: false, normals, random, dark: None, met }
    }

    /// The same camera with exposures so long \[s\], > 0.
    #[must_use]
    pub fn with_exposure(self, exposure: f64) -> Self {
        Self { exposure, ..self }
    }

    /// The same camera whose odd rows are exposed 20 ms after the even ones.
    #[must_use]
    pub fn interlaced(self) -> Self {
        Self { interlaced: true, ..self }
    }

    /// How long it is exposed \[s\].
    #[must_use]
    pub const fn exposure(&self) -> f64 {
        self.exposure
    }

    /// Darkens it from a time on, on the scene's clock \[s\].
    pub const fn darken(&mut self, from: f64, dark: Dark) {
        self.dark = Some((from, dark));
    }

    /// The grey values of an image whose exposure has its middle at `time` \[s\] on the scene's clock, shortly before now; of an
    /// interlaced one, that of its odd rows.
    pub fn expose(&mut self, view: &dyn View, time: f64, image: &mut Vec<u8>) {
        let before = view.now() - time;
        self.met.fill((0, 0.0));
        self.meet(view, before);
        let light = match self.dark.filter(|(from, _)| time >= *from) {
            None => 1.0,
            Some((_, Dark::Covered)) => 0.0,
            Some((_, Dark::LampOff)) => 0.02,
        };
        // The surface at both ends of the exposure.
        let half = 0.35 * self.exposure;
        let run = |field: f64| {
            [-half, half].map(|off| (view.surface(before + field + off) % Texture::PERIOD) as f32)
        };
        let runs = [run(if self.interlaced { FIELD } else { 0.0 }), run(0.0)];
        let mut bits = self.random;
        let mut spread = 0_u64;
        image.clear();
        image.reserve(self.ground.len());
        let width = self.plane.width();
        for (index, (&[x, y, bright], &(met, lit))) in self.ground.iter().zip(&self.met).enumerate() {
            let run = runs[(index / width) % 2];
            let rays = RAYS.len() as f32;
            let mut radiance = lit / rays;
            if usize::from(met) < RAYS.len() {
                let belt = 0.5 * (self.belt.at(x - run[0], y) + self.belt.at(x - run[1], y));
                radiance += belt * (1.0 - f32::from(met) / rays);
            }
            let electrons = FULL * radiance * bright * light;
            if index.is_multiple_of(4) {
                spread = (bits.uniform() * (1_u64 << 53) as f64) as u64;
            }
            let normal = self.normals[(spread as usize) & 8191];
            spread >>= 13;
            let noise = (electrons + READ * READ).sqrt() * normal;
            image.push(grey_of((electrons + noise) * (255.0 / WELL)));
        }
        self.random = bits;
    }

    /// Follows the rays of all pixels at which something may be.
    #[allow(non_snake_case)]
    fn meet(&mut self, view: &dyn View, before: f64) {
        // The forms are visited once for each of them, which keeps the borrow of the view short.
        let X_FC = self.plane.X_FC;
        let (exposure, plane) = (self.exposure, &self.plane);
        let fields = if self.interlaced { [FIELD, 0.0] } else { [0.0, 0.0] };
        let mut forms: Vec<(Form, f64, [[Pose; MOMENTS]; 2])> = Vec::new();
        view.each_form(&mut |seen| {
            let moment = |field: f64, i: usize| {
                let off = exposure * (0.5 - (i as f64 + 0.5) / MOMENTS as f64);
                seen.pose_before(before + field + off)
            };
            let poses = fields.map(|field| core::array::from_fn(|i| moment(field, i)));
            forms.push((seen.form.clone(), seen.reflectance, poses));
        });
        let things: Vec<Thing<'_>> = forms
            .iter()
            .filter_map(|(form, reflectance, poses)| {
                let corners = poses.iter().flatten().flat_map(|X_FP| {
                    form.corners().map(move |corner| X_FP.transform_point(&Point3::from(corner)).coords)
                });
                let window = plane.window(corners, 1.0)?;
                let eye = |X_FP: &Pose| {
                    let X_PC = X_FP.inv_mul(&X_FC);
                    (X_PC.translation.vector, X_PC)
                };
                Some(Thing {
                    form,
                    reflectance: *reflectance,
                    eyes: poses.map(|of| of.map(|pose| eye(&pose))),
                    window,
                })
            })
            .collect();
        let lamp = Vector3::from(LAMP).normalize();
        let [fx, fy] = plane.camera.focal;
        for (number, thing) in things.iter().enumerate() {
            let [[left, right], [top, bottom]] = thing.window;
            let meets = |other: &Thing<'_>| {
                (0..2).all(|i| {
                    other.window[i][0] < thing.window[i][1] && thing.window[i][0] < other.window[i][1]
                })
            };
            let others: Vec<_> = things
                .iter()
                .enumerate()
                .filter(|(i, other)| *i != number && meets(other))
                .map(|(_, o)| o)
                .collect();
            for row in top..bottom {
                for column in left..right {
                    let index = row * plane.width() + column;
                    let ray = plane.ray(index);
                    for (du, dv, moment) in RAYS {
                        let ray = Vector3::new(ray.x + du / fx, ray.y + dv / fy, 1.0);
                        let hit = |of: &Thing<'_>| {
                            let (eye, X_PC) = &of.eyes[row % 2][moment];
                            of.form.hit(eye, &(X_PC.rotation * ray))
                        };
                        let Some(met) = hit(thing) else { continue };
                        if others
                            .iter()
                            .any(|other| hit(other).is_some_and(|other| other.distance < met.distance))
                        {
                            continue;
                        }
                        let (_, X_PC) = &thing.eyes[row % 2][moment];
                        let normal = X_FC.rotation * X_PC.rotation.inverse_transform_vector(&met.normal);
                        let lit =
                            DIFFUSE * 0.5 * (1.0 + normal.z) + (1.0 - DIFFUSE) * normal.dot(&lamp).max(0.0);
                        let pixel = &mut self.met[index];
                        pixel.0 += 1;
                        pixel.1 += (thing.reflectance * lit) as f32;
                    }
                }
            }
        }
    }
}

/// The nearest of 256 grey values, the farther one from 0 half-way: what `round` and `clamp` give, without a call for each pixel.
fn grey_of(value: f32) -> u8 {
    if value >= 255.0 {
        return u8::MAX;
    }
    let below = value as u8;
    below + u8::from(value - f32::from(below) >= 0.5)
}

/// What a belt looks like: dark rubber, with grain and stains. It repeats after half a metre.
#[derive(Clone, Debug)]
struct Texture(Vec<f32>);

impl Texture {
    const SIDE: usize = 512;
    /// Cells per metre.
    const FINE: f32 = 1024.0;
    /// Albedo.
    const MEAN: f64 = 0.05;
    /// After so far it repeats \[m\].
    const PERIOD: f64 = 0.5;

    fn new(random: &mut Noise) -> Self {
        // Stains of 16 mm, smoothly between; grain of 1 mm.
        let coarse: Vec<f64> = (0..32 * 32).map(|_| random.normal()).collect();
        let stain = |x: usize, y: usize| {
            let (i, j) = (x / 16, y / 16);
            let (s, t) = ((x % 16) as f64 / 16.0, (y % 16) as f64 / 16.0);
            let at = |i: usize, j: usize| coarse[(i % 32) * 32 + j % 32];
            at(i, j) * (1.0 - s) * (1.0 - t)
                + at(i + 1, j) * s * (1.0 - t)
                + at(i, j + 1) * (1.0 - s) * t
                + at(i + 1, j + 1) * s * t
        };
        let cell = |index: usize| {
            let (x, y) = (index / Self::SIDE, index % Self::SIDE);
            let albedo = Self::MEAN * (1.0 + 0.1 * stain(x, y) + 0.12 * random.normal());
            albedo.clamp(0.02, 0.2) as f32
        };
        Self((0..Self::SIDE * Self::SIDE).map(cell).collect())
    }

    fn at(&self, x: f32, y: f32) -> f32 {
        // So many periods to the right that nothing is left of 0.
        let [x, y] = [x, y].map(|at| (at + 4.0) * Self::FINE);
        // All are below 2^31.
        let (i, j) = (x as i32, y as i32);
        let s = x - i as f32;
        let cell = |i: i32, j: i32| self.0[(i as usize % Self::SIDE) * Self::SIDE + j as usize % Self::SIDE];
        cell(i, j) * (1.0 - s) + cell(i + 1, j) * s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_values_are_those_of_round_and_clamp() {
        let halves = (-2..260).flat_map(|grey: i16| {
            let half = f32::from(grey) + 0.5;
            [half.next_down(), half, half.next_up(), f32::from(grey)]
        });
        let others = (0..300_000_u32).map(|i| i as f32 * 1e-3 - 20.0);
        for value in halves.chain(others).chain([f32::INFINITY, f32::NEG_INFINITY, 1e9, -0.0]) {
            assert_eq!(grey_of(value), value.round().clamp(0.0, 255.0) as u8, "{value}");
        }
    }
}
