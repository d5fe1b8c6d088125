//! Transducers over a belt, side by side in staggered rows.

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector3};

use super::{Air, Piston, Surface, Transducer, Waveform, Window};
use crate::form::Form;

/// Where transducers are that look straight down on a belt, and in which order they ping.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// In the frame F of the belt's surface \[m\].
    pub places: Vec<Vector3<f64>>,
    /// Half of the belt's width \[m\].
    pub half_width: f64,
    /// Time from one ping to the next \[s\]: what is heard later than that is gone.
    pub period: f64,
}

impl Array {
    /// Distance of transducers in a row, across the belt, and of rows, along it \[m\].
    const PITCH: [f64; 2] = [0.025, 0.03];
    /// Rows, and transducers in each.
    const SIZE: [usize; 2] = [4, 8];
    /// A ray for every two and a half millimetres of the belt.
    pub const FINE: f64 = 0.01;
    /// What is heard of something nearer than this is the end of the ping itself \[m\].
    const NEAREST: f64 = 0.18;
    /// The belt is heard in the middle of what is listened to at this height \[m\].
    const BEYOND: f64 = 0.08;
    /// The detector reports what has this share of the belt's echo.
    const SHARE: f64 = 0.12;
    /// Noise, as a share of the pressure of the belt's echo: 30 dB below it.
    const NOISE: f64 = 0.031_6;

    /// Four rows of eight about a place along the belt, at a height over it \[m\]. Each row is a quarter of the pitch beside the one before: what runs
    /// below is sampled every 6.25 mm across. One ping each 5 ms.
    #[must_use]
    pub fn over(along: f64, height: f64, half_width: f64) -> Self {
        let [rows, columns] = Self::SIZE;
        let [across, rows_apart] = Self::PITCH;
        let middle = |count: usize| 0.5 * (count as f64 - 1.0);
        let place = |number: usize| {
            let (row, column) = ((number / columns) as f64, (number % columns) as f64);
            let x = along + (row - middle(rows)) * rows_apart;
            let y = (column - middle(columns)) * across + (row - middle(rows)) * across / rows as f64;
            Vector3::new(x, y, height)
        };
        Self { places: (0..rows * columns).map(place).collect(), half_width, period: 5e-3 }
    }

    /// Which transducer makes a ping: none beside the one before, whose reverberation it would hear.
    #[must_use]
    pub fn turn(&self, ping: u64) -> usize {
        (ping * 13 % self.places.len() as u64) as usize
    }

    /// The transducers, in air of a temperature: they listen to what lies between the arm's length and a little below the belt.
    #[must_use]
    pub fn transducer(&self, air: Air) -> Transducer {
        let height = self.places.first().map_or(0.0, |place| place.z);
        let belt = Air::left(height) / (2.0 * height);
        Transducer::new(Piston::SMALL, air, [Self::NEAREST, height + Self::BEYOND], Self::SHARE * belt)
    }

    /// Receivers' noise: the standard deviation of what each second point is disturbed by, so that what is heard is 30 dB below the belt's echo.
    #[must_use]
    pub fn noise(&self, transducer: &Transducer) -> f64 {
        let height = self.places.first().map_or(1.0, |place| place.z);
        // Half of the power is in the real part, all of it in every second bin.
        Self::NOISE / (2.0 * height) / transducer.gain().sqrt()
    }

    /// What comes back from the empty belt to a transducer at a place.
    #[must_use]
    pub fn belt(&self, transducer: &Transducer, place: &Vector3<f64>) -> Waveform {
        let mut wave = transducer.silence();
        transducer.add(&mut wave, Window::ALL, Self::FINE, |_, v| (self.behind(place, v), None));
        wave
    }

    /// Where a ray (u, v, 1) of a transducer at a place meets the belt.
    fn behind(&self, place: &Vector3<f64>, v: f64) -> Option<Surface> {
        ((place.y + place.z * v).abs() < self.half_width).then_some(Surface::facing(place.z))
    }

    /// Adds what comes back from a form at `X_FP`, and takes off what comes from the belt that it hides. `others` says whether something else is
    /// before it, from the place in a direction, within a distance.
    #[allow(non_snake_case)]
    pub fn add(
        &self,
        transducer: &Transducer,
        wave: &mut Waveform,
        place: &Vector3<f64>,
        (form, X_FP): (&Form, &Pose),
        step: f64,
        others: impl Fn(&Vector3<f64>, f64) -> bool,
    ) {
        // Frame T looks down: its x is that of F, its y too, so that it is left-handed; nothing here minds.
        let mut window =
            Window { u: [f64::INFINITY, f64::NEG_INFINITY], v: [f64::INFINITY, f64::NEG_INFINITY] };
        for corner in form.corners() {
            let at = (X_FP * Point3::from(corner)).coords - place;
            let depth = (-at.z).max(1e-3);
            for (range, at) in [(&mut window.u, at.x / depth), (&mut window.v, at.y / depth)] {
                *range = [range[0].min(at), range[1].max(at)];
            }
        }
        for (range, all) in [(&mut window.u, Window::ALL.u), (&mut window.v, Window::ALL.v)] {
            *range = [range[0].max(all[0]), range[1].min(all[1])];
        }
        if window.u[0] >= window.u[1] || window.v[0] >= window.v[1] {
            return;
        }
        let X_PF = X_FP.inverse();
        let eye = (X_PF * Point3::from(*place)).coords;
        transducer.add(wave, window, step, |u, v| {
            let ray = Vector3::new(u, v, -1.0);
            let ray_P = X_PF.rotation * ray;
            let Some(hit) = form.hit(&eye, &ray_P) else { return (None, None) };
            if others(&ray, hit.distance) {
                return (None, None);
            }
            // On the plane n . p = const, n . (depth ray) does not change.
            let normal = X_FP.rotation * hit.normal;
            let per_normal = -hit.distance / hit.normal.dot(&ray_P);
            let slope = [normal.x * per_normal, normal.y * per_normal];
            (Some(Surface { depth: hit.distance, slope }), self.behind(place, v))
        });
    }
}
