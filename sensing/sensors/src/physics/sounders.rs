//! Ultrasonic transducers over a belt: the echo of each ping, of the true world's surfaces.
//!
//! What is heard is the coherent sum over rays that [`ultrasound`](crate::ultrasound) describes, of the parts as they truly lie at the time of the
//! ping, and noise 30 dB below the belt's echo. Transducers are a little elsewhere than they are believed to be, and not alike loud.

use mrroc::random::Noise;
use nalgebra::{Point3, Vector3};

use crate::ultrasound::{Air, Array, Echo, Transducer, Waveform};
use crate::view::View;

/// Why a transducer gives nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Silent {
    /// One of them is dead.
    One(usize),
    /// All are.
    All,
}

/// Transducers that ping one after another.
#[derive(Clone, Debug)]
pub struct Sounders {
    /// As they truly are.
    array: Array,
    /// How loud each is, of 1.
    gains: Vec<f64>,
    transducer: Transducer,
    /// What each hears of the empty belt.
    belts: Vec<Waveform>,
    wave: Waveform,
    noise: f64,
    random: Noise,
    /// Of all echoes, so many are lost, 0 to 1.
    lost: f64,
    silent: Option<(f64, Silent)>,
    /// When air changes \[s\], and to which.
    change: Option<(f64, Air)>,
}

impl Sounders {
    /// What a form is farther off the axis adds nothing: the beam is a tenth there \[m\].
    const FAR: f64 = 0.17;
    /// Standard deviations of places \[m\] and of gains.
    const OFF: [f64; 2] = [2e-4, 0.06];

    /// Where this array is believed to be, in this air.
    #[must_use]
    pub fn over(believed: &Array, air: Air, seed: u64) -> Self {
        let mut random = Noise::seeded(seed);
        let mut array = believed.clone();
        for place in &mut array.places {
            *place += Vector3::from_fn(|_, _| Self::OFF[0] * random.normal());
        }
        let gains = array.places.iter().map(|_| 1.0 + Self::OFF[1] * random.normal()).collect();
        let transducer = array.transducer(air);
        let belts = array.places.iter().map(|place| array.belt(&transducer, place)).collect();
        let noise = believed.noise(&transducer);
        let wave = transducer.silence();
        Self { array, gains, transducer, belts, wave, noise, random, lost: 0.0, silent: None, change: None }
    }

    /// The same, of whose echoes a share is lost, 0 to 1.
    #[must_use]
    pub fn losing(self, lost: f64) -> Self {
        Self { lost, ..self }
    }

    /// From a time on \[s\] one or all are dead.
    pub const fn silence(&mut self, from: f64, silent: Silent) {
        self.silent = Some((from, silent));
    }

    /// From a time on \[s\] the air is another.
    pub const fn warm(&mut self, from: f64, air: Air) {
        self.change = Some((from, air));
    }

    fn breathe(&mut self, air: Air) {
        self.transducer = self.transducer.in_air(air);
        self.wave = self.transducer.silence();
        self.belts = self.array.places.iter().map(|place| self.array.belt(&self.transducer, place)).collect();
    }

    /// The ping of a transducer at `time` \[s\], shortly before the view's.
    #[allow(non_snake_case)]
    pub fn ping(&mut self, view: &dyn View, number: usize, time: f64) -> Option<Echo> {
        if let Some((_, air)) = self.change.take_if(|(from, _)| time >= *from) {
            self.breathe(air);
        }
        let before = view.now() - time;
        let Self { array, transducer, wave, .. } = self;
        wave.start_from(&self.belts[number]);
        let place = &array.places[number];
        let mut near = Vec::new();
        view.each_form(&mut |seen| {
            let X_FP = seen.pose_before(before);
            let reaches = seen.form.corners().any(|corner| {
                let off = (X_FP * Point3::from(corner)).coords - place;
                off.xy().norm() < Self::FAR && off.z < -1e-3
            });
            if reaches {
                let X_PF = X_FP.inverse();
                near.push((seen.form.clone(), X_FP, X_PF, (X_PF * Point3::from(*place)).coords));
            }
        });
        for (this, (form, X_FP, ..)) in near.iter().enumerate() {
            let hides = |ray: &Vector3<f64>, distance: f64| {
                near.iter().enumerate().any(|(other, (form, _, X_PF, eye))| {
                    other != this
                        && form.hit(eye, &(X_PF.rotation * ray)).is_some_and(|hit| hit.distance < distance)
                })
            };
            array.add(transducer, wave, place, (form, X_FP), Array::FINE, hides);
        }
        let (noise, random) = (self.noise, &mut self.random);
        wave.disturb(|| random.normals().map(|x| x * noise));
        let echo = transducer.hear(wave, self.gains[number]);
        let lost = self.lost > 0.0 && self.random.uniform() <= self.lost;
        let dead = self.silent.is_some_and(|(from, silent)| {
            time >= from && (silent == Silent::All || silent == Silent::One(number))
        });
        echo.filter(|_| !lost && !dead)
    }

    /// What was heard after the last ping, bin by bin from the nearest range that is listened to.
    #[must_use]
    pub const fn wave(&self) -> &Waveform {
        &self.wave
    }
}
