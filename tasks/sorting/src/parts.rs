//! What comes on the belt, and when: drawn from a seed.

use mrroc::prelude::*;
use mrroc::random::Noise;
use mrroc_robots::grasp::Body;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::places::{BELT, LIMIT, PART};

/// Where parts are put on the belt, along s \[m\].
pub const FEED: f64 = -0.3;
/// What parts weigh for their size [kg/m³].
const DENSITY: f64 = 1500.0;
/// How far a part may lie off the middle of the belt \[m\] ..
const ACROSS: f64 = 0.015;
/// .. and askew \[rad\].
const ASKEW: f64 = 0.05;

/// The shape of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A block of this length \[m\].
    Block(f64),
    /// An upright disc, as wide as the blocks.
    Disc,
}

/// The shapes that come.
pub const SHAPES: [Shape; 5] =
    [Shape::Disc, Shape::Block(0.06), Shape::Block(0.07), Shape::Block(0.09), Shape::Block(0.1)];

/// A part that comes.
#[derive(Clone, Debug)]
pub struct Arrival {
    /// When \[s\].
    pub time: f64,
    /// What.
    pub shape: Shape,
    /// Its body, where it is put.
    pub body: Body,
    /// How much light it scatters, 0 to 1.
    pub reflectance: f64,
}

impl Shape {
    /// Along the belt \[m\].
    #[must_use]
    pub const fn length(self) -> f64 {
        match self {
            Self::Block(length) => length,
            Self::Disc => PART[0],
        }
    }

    /// The tray to which it belongs: 0 for short parts, 1 for long ones.
    #[must_use]
    pub fn tray(self) -> usize {
        usize::from(self.length() >= LIMIT)
    }

    /// Its body, with points along its lower edges by which it lies on the belt until it tips over the end.
    fn body(self) -> Body {
        let [width, height] = PART;
        match self {
            Self::Disc => {
                let area = core::f64::consts::PI * 0.25 * width * width;
                Body::disc(DENSITY * area * height, width, height)
            }
            Self::Block(length) => {
                let body = Body::block(DENSITY * length * width * height, [length, width, height]);
                let [x, y, z] = [0.5 * length, 0.5 * width, -0.5 * height];
                let between = [-x / 2.0, 0.0, x / 2.0].into_iter().flat_map(|x| [(x, -y), (x, y)]);
                let points: Vec<_> = between.map(|(x, y)| Vector3::new(x, y, z)).collect();
                let corners = body.points().to_vec();
                body.with_points(corners.into_iter().chain(points))
            }
        }
    }
}

/// So many parts, from `first` \[s\] on, each at least `gap` \[s\] after the one before and by `mean` \[s\] later in the mean: as Poisson's law
/// says, beyond the gap.
#[must_use]
#[allow(non_snake_case)]
pub fn arrivals(count: usize, first: f64, gap: f64, mean: f64, seed: u64) -> Vec<Arrival> {
    let mut random = Noise::seeded(seed);
    let mut time = first;
    let mut next = |_| {
        let shape = SHAPES[((random.uniform() * SHAPES.len() as f64) as usize).min(SHAPES.len() - 1)];
        let across = random.between(-ACROSS, ACROSS);
        // A block lies along the belt, which is y of the world.
        let turn = core::f64::consts::FRAC_PI_2 + random.between(-ASKEW, ASKEW);
        let place = Translation3::new(BELT[0] + across, BELT[1] + FEED, 0.5 * PART[1]);
        let X_WB = Pose::from_parts(place, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn));
        let reflectance = random.between(0.2, 1.0);
        let arrival = Arrival { time, shape, body: shape.body().at(X_WB), reflectance };
        time += gap - mean * random.uniform().ln();
        arrival
    };
    (0..count).map(&mut next).collect()
}
