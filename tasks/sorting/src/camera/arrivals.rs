//! What comes on the belt, and when: drawn from a seed.

use core::f64::consts::PI;

use mrroc::prelude::*;
use mrroc::random::Noise;
use mrroc_robots::grasp::Body;
use mrroc_sensors::form::Form;
use mrroc_sensors::simulated::Workpiece;
use nalgebra::Vector3;

use super::kinds::{KINDS, Kind, kinds, lying, strangers};
use super::layout::{ACROSS, FEED, X_WF};
use super::settings::Settings;
use super::studio::{REFLECTANCE, TOLERANCE};
use crate::generators::Uneven;

/// A part that comes.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Coming {
    /// When \[s\].
    pub time: f64,
    /// Its kind; of a stranger [`KINDS`].
    pub kind: usize,
    /// What it looks like, in its frame P.
    pub form: Form,
    /// What it is, where it is put.
    pub body: Body,
    /// `X_BP`.
    pub X_BP: Pose,
    /// How much light it scatters, 0 to 1.
    pub reflectance: f64,
}

/// The parts of a run: one every so often in the mean as Poisson's law says, but none less than `gap` \[s\] after another; the first one, and
/// every so many, may be one of the [`strangers`], and every so many comes so close behind another one that they touch.
#[must_use]
pub fn coming(settings: &Settings, gap: f64) -> Vec<Coming> {
    let Settings { parts: count, every, seed, stranger, strangers: each_strange, touching, .. } = *settings;
    let mut random = Noise::seeded(seed);
    let mut made: Vec<_> = kinds();
    made.extend(strangers());
    let speed = Uneven::about(settings.speed, seed.wrapping_add(77)).speed();
    let is_due = |number: usize, each: usize| each > 0 && number > 0 && number.is_multiple_of(each);
    let mut time = settings.first();
    let mut before: Option<(f64, f64)> = None;
    let mut next = |number: usize| {
        let drawn = ((random.uniform() * KINDS as f64) as usize).min(KINDS - 1);
        let kind = match stranger.filter(|_| number == 0) {
            Some(which) => KINDS + which,
            None if is_due(number, each_strange) => KINDS + (number / each_strange) % (made.len() - KINDS),
            None => drawn,
        };
        let (mut coming, half) = part(&made, kind, time, &mut random);
        if let Some((came, length)) = before.filter(|_| is_due(number, touching)) {
            coming.time = came + (length + half + CLOSE) / speed;
        }
        before = Some((coming.time, half));
        time += gap - (every - gap).max(0.0) * random.uniform().ln();
        coming
    };
    (0..count).map(&mut next).collect()
}

/// A part of a kind, and half of its length along the belt \[m\].
#[allow(non_snake_case)]
fn part(made: &[Kind], kind: usize, time: f64, random: &mut Noise) -> (Coming, f64) {
    let (form, body, in_body) = made[kind].made(1.0 + random.between(-TOLERANCE, TOLERANCE));
    let kind = kind.min(KINDS);
    let angle = random.between(-PI, PI);
    let X_BP = Pose::translation(in_body.x, in_body.y, in_body.z);
    // Its middle comes to the place, whatever its frame is.
    let corners: Vec<_> = form.corners().collect();
    let (least, most) = corners.iter().fold((corners[0], corners[0]), |(a, b), c| (a.inf(c), b.sup(c)));
    let turned = nalgebra::Rotation2::new(angle);
    let middle = turned * (0.5 * (least + most)).xy();
    let along = corners.iter().map(|corner| ((turned * corner.xy()).x - middle.x).abs());
    let half = along.fold(0.0, f64::max);
    let X_FP = lying(FEED - middle.x, random.between(-ACROSS, ACROSS) - middle.y, angle);
    let X_WB = X_WF() * X_FP * X_BP.inverse();
    let reflectance = random.between(REFLECTANCE[0], REFLECTANCE[1]);
    (Coming { time, kind, form, body: body.at(X_WB), X_BP, reflectance }, half)
}

/// Parts that touch are so far apart, for what the belt's speed has wandered by then \[m\].
const CLOSE: f64 = 1e-3;

impl Coming {
    /// What sensors see of it.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn piece(&self) -> Workpiece {
        let Self { form, body, X_BP, reflectance, .. } = self;
        Workpiece::of(form.clone(), body.clone(), *X_BP).painted(*reflectance)
    }

    /// Where its frame P is, of a body at `X_WB`: in the belt's frame.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn place(&self, X_WB: &Pose) -> Pose {
        X_WF().inv_mul(&(X_WB * self.X_BP))
    }
}

/// The angle of a pose about z \[rad\].
#[must_use]
pub fn angle(pose: &Pose) -> f64 {
    let x = pose.rotation * Vector3::x();
    x.y.atan2(x.x)
}
