//! The cell as it truly is, and as it is believed to be: two arms, three balls on the flange of each, two theodolites, a scale bar.
//!
//! The arms are IRp-6 whose dimensions are those that MRROC++ found by calibration; programs believe in the design. Each base stands up to
//! some millimetres from where it is believed to be. The arms are 2.1 m apart, as in that laboratory.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::{Load, Robot};
use mrroc_calibration::Irp6Arm;
use mrroc_robots::models::{Capsule, Outline};
use mrroc_robots::{Driven, Irp6, Irp6Calibration, Kinematics, Six};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::random::normal;
use crate::theodolite::{Face, Theodolite, mean};

/// An arm, by its place among them.
pub const ARMS: usize = 2;
/// The names of the arms.
pub const NAMES: [&str; ARMS] = ["left", "right"];
/// Balls on the flange of an arm, where they are believed to be \[m\].
pub const BALLS: [[f64; 3]; 3] = [[0.09, 0.0, 0.06], [-0.045, 0.08, 0.02], [-0.045, -0.08, 0.11]];
/// Length of the scale bar \[m\], and its standard deviation.
pub const BAR: (f64, f64) = (1.0, 5e-6);
/// In how many places the bar is laid down, one after another.
pub const BARS: usize = 3;
/// How often each end of it is sighted in each.
pub const BAR_SIGHTS: usize = 12;
/// How often each theodolite sights the other.
pub const MUTUAL_SIGHTS: usize = 8;
/// A sight is the mean of so many sets, each in both faces.
pub const SETS: usize = 2;
/// The mass that hangs on the flanges in half of all postures \[kg\].
pub const PAYLOAD: f64 = 5.0;
/// Compliances of the joints [rad/(N m)] (assumed): screws and gears of an arm of this size.
pub const COMPLIANCE: [f64; 6] = [0.0, 4e-6, 5e-6, 1e-5, 1e-5, 0.0];
/// The arms' weight turns their joints by so much more than programs believe (assumed): nobody has weighed the links.
const HEAVIER: [f64; 6] = [0.0, 0.1, -0.07, 0.15, -0.1, 0.0];
/// Where a payload hangs, in the flange's frame \[m\].
pub const PAYLOAD_AT: [f64; 3] = [0.0, 0.0, 0.1];
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

/// The ends of the scale bar in each of its places, about \[m\]: level before the arms, and upright in front of each instrument.
#[must_use]
pub fn bar_ends() -> [[Vector3<f64>; 2]; BARS] {
    let upright = |x: f64| [Vector3::new(x, 1.0, -0.05), Vector3::new(x, 1.0, 0.95)];
    [[Vector3::new(0.55, 1.0, 0.2), Vector3::new(1.55, 1.0, 0.2)], upright(0.3), upright(1.8)]
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
    /// The ends of the scale bar in each of its places \[m\].
    pub ends: [[Vector3<f64>; 2]; BARS],
    /// What hangs on the flange of each \[kg\], at [`PAYLOAD_AT`].
    pub payload: [f64; ARMS],
    model: Irp6Arm,
    random: Random,
    windup: f64,
    /// Compliances of the joints [rad/(N m)], and by how much their own weight turns them more than programs believe, as a ratio.
    give: [Six; ARMS],
    heavier: Six,
}

impl Scene {
    /// The cell as it is believed to be.
    #[must_use]
    pub fn believed() -> Self {
        let theodolites = believed_theodolites().map(|place| Theodolite::new(place, 0.0, 0));
        Self {
            arms: believed_bases().map(|base| Irp6::nominal().with_base(base)),
            balls: [BALLS.map(Vector3::from); ARMS],
            theodolites,
            ends: bar_ends(),
            payload: [0.0; ARMS],
            model: Irp6Arm::new(Irp6::nominal()),
            random: Random::seeded(0),
            windup: 0.0,
            give: [Six::zeros(); ARMS],
            heavier: Six::zeros(),
        }
    }

    /// A scene with instruments of this accuracy \[rad\]; the places of all things are off as `seed` says. `windup` is the standard
    /// deviation of what friction leaves between a motor and its joint \[rad\], anew in each posture.
    #[must_use]
    pub fn new(sigma: f64, windup: f64, seed: u64) -> Self {
        let mut random = Random::seeded(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x5eed);
        let mut off = |length: f64, angle: f64| {
            let mut three = |scale: f64| {
                Vector3::new(normal(&mut random), normal(&mut random), normal(&mut random)) * scale
            };
            Pose::new(three(length), three(angle))
        };
        let truth = Irp6::nominal().calibrated_by(&Irp6Calibration::of(&Irp6::calibrated()));
        let arms = believed_bases().map(|base| truth.clone().with_base(base * off(3e-3, 2e-3)));
        let balls =
            [0; ARMS].map(|_| BALLS.map(|ball| Vector3::from(ball) + off(1e-3, 0.0).translation.vector));
        // It is as long as it is certified, to its standard deviation, and the same in all places.
        let length = BAR.0 + BAR.1 * off(1.0, 0.0).translation.x;
        let ends = bar_ends().map(|ends| {
            let middle = 0.5 * (ends[0] + ends[1]);
            let along = (ends[1] - ends[0]).normalize() * (0.5 * length);
            [middle - along, middle + along]
        });
        let [north, south] = believed_theodolites();
        let south =
            south * Pose::new(off(5e-3, 0.0).translation.vector, Vector3::z() * off(5e-3, 0.0).translation.x);
        let theodolites =
            [Theodolite::new(north, sigma, seed * 2 + 1), Theodolite::new(south, sigma, seed * 2 + 2)];
        Self {
            arms,
            balls,
            theodolites,
            ends,
            payload: [0.0; ARMS],
            model: Irp6Arm::new(Irp6::nominal()),
            random: Random::seeded(seed ^ 0xf1c7),
            windup,
            give: [Six::from(COMPLIANCE); ARMS],
            heavier: Six::from(HEAVIER),
        }
    }

    /// The true joint positions of an arm \[rad\], where its encoders, by what programs believe, read `q`.
    #[must_use]
    pub fn joints(&self, arm: usize, q: &Six) -> Six {
        let stiff = self.model.joints_of(&self.arms[arm], q);
        let own = torques(&stiff, 0.0);
        let weight =
            own.component_mul(&self.heavier.add_scalar(1.0)) + torques(&stiff, self.payload[arm]) - own;
        stiff + self.give[arm].component_mul(&weight)
    }

    /// What friction may leave between a motor and its joint \[rad\].
    #[must_use]
    pub fn windup(&self) -> f64 {
        self.windup
    }

    /// The same with what friction leaves, anew in every posture.
    pub fn come_to_rest(&mut self, arm: usize, q: &Six) -> Six {
        let off = Six::from_fn(|_, _| normal(&mut self.random) * self.windup);
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

    /// Sights a point, the mean of all sets in both faces \[rad\].
    pub fn sight(&mut self, theodolite: usize, point: &Vector3<f64>) -> [f64; 2] {
        let own = &mut self.theodolites[theodolite];
        mean((0..SETS).flat_map(|_| [Face::One, Face::Two]).map(|face| own.sight(point, face)))
    }
}

/// What the weight of an arm and of a payload \[kg\] turns its joints by, as programs believe \[N m\].
#[must_use]
pub fn torques(q: &Six, payload: f64) -> Six {
    let Some(tree) = Irp6::nominal().tree() else { return Six::zeros() };
    let load = Load { mass: payload, centre: PAYLOAD_AT.into(), inertia: Matrix3::zeros() };
    -tree.with_load(&load).gravity_torques(q)
}

/// Postures of an arm that programs may demand, drawn by a random source: within its limits, on its own side, its tool in front.
#[must_use]
pub fn posture(of: usize, random: &mut Random) -> Six {
    drawn(of, random, |random, [low, high]| random.between(low, high))
}

/// The same, with joints near the ends of their ranges in half of all cases: dimensions show best there.
#[must_use]
pub fn wide_posture(of: usize, random: &mut Random) -> Six {
    drawn(of, random, |random, [low, high]| {
        let near = random.between(0.0, 0.1) * (high - low);
        match random.between(0.0, 4.0) as u32 {
            0 => low + near,
            1 => high - near,
            _ => random.between(low, high),
        }
    })
}

fn drawn(of: usize, random: &mut Random, draw: impl Fn(&mut Random, [f64; 2]) -> f64) -> Six {
    let arm = Irp6::nominal();
    let limits = Robot::limits(&arm);
    // The right arm faces the left one, so that the instruments are on its other side.
    let side = if of == 0 { 1.0 } else { -1.0 };
    let ranges = [
        [-0.3, 1.9],
        [limits.lower[1], limits.upper[1]],
        [limits.lower[2], limits.upper[2]],
        [-1.0, 0.9],
        [3.3, 5.9],
        [-2.2, 2.2],
    ];
    loop {
        let mut q = Six::from_iterator(ranges.into_iter().map(|range| draw(random, range)));
        q[0] *= side;
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
