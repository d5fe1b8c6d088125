//! What comes on the belt, and when: drawn from a seed.

use core::f64::consts::PI;

use mrroc::prelude::*;
use mrroc_robots::grasp::Body;
use mrroc_sensors::form::Form;
use mrroc_sensors::physics::Noise;
use mrroc_sensors::simulated::Workpiece;
use nalgebra::Vector3;

use super::kinds::{KINDS, Kind, kinds, lying, strangers};
use super::layout::{ACROSS, FEED, X_WF};
use super::studio::{REFLECTANCE, TOLERANCE};

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

/// So many parts from `first` \[s\] on: one every `every` \[s\] in the mean as Poisson's law says, but none less than `gap` \[s\] after another; the
/// first one may be one of the [`strangers`].
#[must_use]
pub fn coming(
    count: usize,
    first: f64,
    every: f64,
    gap: f64,
    seed: u64,
    stranger: Option<usize>,
) -> Vec<Coming> {
    let mut random = Noise::seeded(seed);
    let mut made: Vec<_> = kinds();
    made.extend(stranger.and_then(|which| strangers().into_iter().nth(which)));
    let mut time = first;
    let mut next = |number| {
        let is_strange = number == 0 && stranger.is_some();
        let drawn = ((random.uniform() * KINDS as f64) as usize).min(KINDS - 1);
        let coming = part(&made, if is_strange { KINDS } else { drawn }, time, &mut random);
        time += gap - (every - gap).max(0.0) * random.uniform().ln();
        coming
    };
    (0..count).map(&mut next).collect()
}

#[allow(non_snake_case)]
fn part(made: &[Kind], kind: usize, time: f64, random: &mut Noise) -> Coming {
    let (form, body, in_body) = made[kind].made(1.0 + random.between(-TOLERANCE, TOLERANCE));
    let angle = random.between(-PI, PI);
    let X_BP = Pose::translation(in_body.x, in_body.y, in_body.z);
    // Its middle comes to the place, whatever its frame is.
    let corners: Vec<_> = form.corners().collect();
    let (least, most) = corners.iter().fold((corners[0], corners[0]), |(a, b), c| (a.inf(c), b.sup(c)));
    let middle = nalgebra::Rotation2::new(angle) * (0.5 * (least + most)).xy();
    let X_FP = lying(FEED - middle.x, random.between(-ACROSS, ACROSS) - middle.y, angle);
    let X_WB = X_WF() * X_FP * X_BP.inverse();
    let reflectance = random.between(REFLECTANCE[0], REFLECTANCE[1]);
    Coming { time, kind, form, body: body.at(X_WB), X_BP, reflectance }
}

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
