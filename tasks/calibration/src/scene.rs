//! The cell as it truly is, and as it is believed to be: two arms, three balls on the flange of each, two theodolites, a scale bar.
//!
//! The arms are IRp-6 whose dimensions are those that MRROC++ found by calibration; programs believe in the design. Each base stands up to
//! some millimetres from where it is believed to be. The arms are 2.1 m apart, as in that laboratory.

use mrroc::pose::Pose;
use mrroc::robot::Robot;
use mrroc_calibration::Irp6Arm;
use mrroc_robots::models::{Capsule, Outline};
use mrroc_robots::{Irp6, Irp6Calibration, Kinematics, Six};
use nalgebra::{Point3, Vector3};

use crate::random::Random;
use crate::theodolite::{Face, Theodolite, mean};

/// An arm, by its place among them.
pub const ARMS: usize = 2;
/// The names of the arms.
pub const NAMES: [&str; ARMS] = ["left", "right"];
/// Balls on the flange of an arm, where they are believed to be \[m\].
pub const BALLS: [[f64; 3]; 3] = [[0.09, 0.0, 0.06], [-0.045, 0.08, 0.02], [-0.045, -0.08, 0.11]];
/// Length of the scale bar \[m\], and its standard deviation.
pub const BAR: (f64, f64) = (1.0, 5e-6);
/// How often each end of it is sighted.
pub const BAR_SIGHTS: usize = 16;
/// How far from the plane between the arms each keeps its flange \[m\].
const APART: f64 = 0.25;
/// How near to a link a line of sight may pass \[m\].
const MARGIN: f64 = 0.01;

/// Where the bases are believed to be, `X_WB`.
#[must_use]
pub fn believed_bases() -> [Pose; ARMS] {
    let turned = Pose::rotation(Vector3::z() * core::f64::consts::PI);
    [Pose::identity(), Pose::translation(2.106, 0.0, 0.0) * turned]
}

/// Where the theodolites are believed to stand; the first one is the world.
#[must_use]
pub fn believed_theodolites() -> [Pose; 2] {
    [Pose::translation(-0.2, 2.3, 0.45), Pose::translation(2.3, 2.3, 0.4)]
}

/// The ends of the scale bar, about \[m\].
#[must_use]
pub fn bar_ends() -> [Vector3<f64>; 2] {
    [Vector3::new(0.55, 1.0, 0.2), Vector3::new(1.55, 1.0, 0.2)]
}

/// The truth.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The arms as they are, at their bases.
    pub arms: [Irp6; ARMS],
    /// The balls of each arm on its flange \[m\].
    pub balls: [[Vector3<f64>; 3]; ARMS],
    /// The theodolites.
    pub theodolites: [Theodolite; 2],
    /// The ends of the scale bar \[m\].
    pub ends: [Vector3<f64>; 2],
    model: Irp6Arm,
    random: Random,
    windup: f64,
}

impl Scene {
    /// A scene with instruments of this accuracy \[rad\]; the places of all things are off as `seed` says. `windup` is the standard
    /// deviation of what friction leaves between a motor and its joint \[rad\].
    #[must_use]
    pub fn new(sigma: f64, windup: f64, seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x5eed);
        let mut off = |length: f64, angle: f64| {
            let mut three =
                |scale: f64| Vector3::new(random.normal(), random.normal(), random.normal()) * scale;
            Pose::new(three(length), three(angle))
        };
        let truth = Irp6::nominal().calibrated_by(&Irp6Calibration::of(&Irp6::calibrated()));
        let arms = believed_bases().map(|base| truth.clone().with_base(base * off(3e-3, 2e-3)));
        let balls =
            [0; ARMS].map(|_| BALLS.map(|ball| Vector3::from(ball) + off(1e-3, 0.0).translation.vector));
        let ends = bar_ends();
        // It is exactly as long as it is certified, to its standard deviation.
        let middle = 0.5 * (ends[0] + ends[1]);
        let along = (ends[1] - ends[0]).normalize() * (0.5 * (BAR.0 + BAR.1 * off(1.0, 0.0).translation.x));
        let [north, south] = believed_theodolites();
        let south =
            south * Pose::new(off(5e-3, 0.0).translation.vector, Vector3::z() * off(5e-3, 0.0).translation.x);
        let theodolites =
            [Theodolite::new(north, sigma, seed * 2 + 1), Theodolite::new(south, sigma, seed * 2 + 2)];
        Self {
            arms,
            balls,
            theodolites,
            ends: [middle - along, middle + along],
            model: Irp6Arm::new(Irp6::nominal()),
            random: Random(seed ^ 0xf1c7),
            windup,
        }
    }

    /// The true joint positions of an arm \[rad\], where its encoders, by what programs believe, read `q`.
    #[must_use]
    pub fn joints(&self, arm: usize, q: &Six) -> Six {
        self.model.joints_of(&self.arms[arm], q)
    }

    /// The same with what friction leaves, anew in every posture.
    pub fn come_to_rest(&mut self, arm: usize, q: &Six) -> Six {
        let off = Six::from_fn(|_, _| self.random.normal() * self.windup);
        self.joints(arm, q) + off
    }

    /// Where a ball of an arm is at true joint positions \[m\].
    #[must_use]
    pub fn ball(&self, arm: usize, ball: usize, joints: &Six) -> Vector3<f64> {
        (self.arms[arm].forward(joints) * Point3::from(self.balls[arm][ball])).coords
    }

    /// Whether a theodolite sees a ball: no link of an arm is in its line of sight. The balls stand clear of the flange.
    #[must_use]
    pub fn sees(&self, theodolite: usize, point: &Vector3<f64>, joints: &[Six; ARMS]) -> bool {
        let eye = self.theodolites[theodolite].place.translation.vector;
        // The last 3 cm are the ball's own stem.
        let end = point + (eye - point).normalize() * 0.03;
        let mut clear = true;
        for (arm, joints) in self.arms.iter().zip(joints) {
            Outline::capsules(arm, joints, &mut |capsule: Capsule| {
                clear &= distance([eye, end], capsule.ends) > capsule.radius + MARGIN;
            });
        }
        clear
    }

    /// Sights a point in both faces \[rad\].
    pub fn sight(&mut self, theodolite: usize, point: &Vector3<f64>) -> [f64; 2] {
        let own = &mut self.theodolites[theodolite];
        mean(own.sight(point, Face::One), own.sight(point, Face::Two))
    }
}

/// Postures of an arm that programs may demand, drawn by a random source: within its limits, on its own side, its tool in front.
#[must_use]
pub fn posture(of: usize, random: &mut Random) -> Six {
    let arm = Irp6::nominal();
    // The right arm faces the left one, so that the instruments are on its other side.
    let side = if of == 0 { 1.0 } else { -1.0 };
    loop {
        let q = Six::new(
            side * random.between(-0.3, 1.9),
            random.between(-2.2, -1.0),
            random.between(-0.35, 0.6),
            random.between(-1.0, 0.9),
            random.between(3.3, 5.9),
            random.between(-2.2, 2.2),
        );
        let x = arm.forward(&q).translation.x;
        if arm.is_attainable(&q) && x < 0.5 * 2.106 - APART - 0.12 {
            return q;
        }
    }
}

/// Smallest distance of two segments \[m\].
fn distance(a: [Vector3<f64>; 2], b: [Vector3<f64>; 2]) -> f64 {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let parallel = uu * vv - uv * uv;
    let mut s = if parallel > 1e-12 { ((uv * vw - vv * uw) / parallel).clamp(0.0, 1.0) } else { 0.0 };
    let t = if vv > 0.0 { ((uv * s + vw) / vv).clamp(0.0, 1.0) } else { 0.0 };
    s = if uu > 0.0 { ((uv * t - uw) / uu).clamp(0.0, 1.0) } else { s };
    (w + u * s - v * t).norm()
}
