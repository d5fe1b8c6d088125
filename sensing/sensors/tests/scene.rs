//! A block that moves along x as a function of time.

use std::cell::Cell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc_sensors::scene::{Scene, Solid};
use nalgebra::Vector3;

/// The block: its edges \[m\], its turn about z, and where its middle is along x at a time.
#[derive(Clone)]
pub struct Block {
    pub time: Rc<Cell<f64>>,
    hull: Rc<[Vector3<f64>]>,
    turn: f64,
    y: f64,
    x: Rc<dyn Fn(f64) -> f64>,
}

impl Block {
    pub fn new(hull: impl IntoIterator<Item = Vector3<f64>>, x: impl Fn(f64) -> f64 + 'static) -> Self {
        let hull = hull.into_iter().collect();
        Self { time: Rc::default(), hull, turn: 0.0, y: 0.0, x: Rc::new(x) }
    }

    pub fn turned(self, turn: f64) -> Self {
        Self { turn, ..self }
    }

    pub fn at_y(self, y: f64) -> Self {
        Self { y, ..self }
    }
}

pub fn cuboid(edges: [f64; 3]) -> Vec<Vector3<f64>> {
    let corner = |i: usize| {
        let side = |bit: usize| if i & bit == 0 { -0.5 } else { 0.5 };
        Vector3::new(side(1) * edges[0], side(2) * edges[1], side(4) * edges[2])
    };
    (0..8).map(corner).collect()
}

impl Scene for Block {
    fn now(&self) -> f64 {
        self.time.get()
    }

    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>)) {
        let (t, h) = (self.time.get(), 1e-4);
        let speed = ((self.x)(t + h) - (self.x)(t - h)) / (2.0 * h);
        visit(&Solid {
            hull: &self.hull,
            pose: Pose::translation((self.x)(t), self.y, 0.0) * Pose::rotation(Vector3::z() * self.turn),
            velocity: Vector3::x() * speed,
            angular_velocity: Vector3::zeros(),
            reflectance: 1.0,
        });
    }
}

/// A frame at `x`, `y` whose z axis looks along y of the world.
pub fn across(x: f64, y: f64) -> Pose {
    Pose::translation(x, y, 0.0) * Pose::rotation(Vector3::x() * -core::f64::consts::FRAC_PI_2)
}
