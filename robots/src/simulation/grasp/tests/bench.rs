//! A world whose tool frames are led from outside, without arms.

use core::time::Duration;

use mrroc::pose::Pose;
use nalgebra::Vector3;

use crate::simulation::grasp::{Grasp, Hand, World};

/// A world and its hands, each at its own period.
pub(super) struct Bench {
    pub world: World,
    pub hands: Vec<(Hand, Duration, Pose)>,
}

impl Bench {
    pub fn new(world: World) -> Self {
        Self { world, hands: Vec::new() }
    }

    /// With a hand every 2 ms.
    #[allow(non_snake_case)]
    pub fn with_hand(self, grasp: Grasp, X_WE: Pose) -> Self {
        self.with_hand_every(2, grasp, X_WE)
    }

    #[allow(non_snake_case)]
    pub fn with_hand_every(mut self, millis: u64, grasp: Grasp, X_WE: Pose) -> Self {
        let period = Duration::from_millis(millis);
        let hand = self.world.add_hand(grasp, period, X_WE).expect("a good grasp");
        self.hands.push((hand, period, X_WE));
        self
    }

    pub fn close(&self) {
        self.hands.iter().for_each(|(hand, ..)| hand.close().expect("within reach"));
    }

    /// One servo period of each hand, all of one period.
    pub fn tick(&self) {
        self.hands.iter().for_each(|(hand, _, pose)| {
            hand.begin();
            hand.end(*pose);
        });
    }

    pub fn run(&self, duration: f64) {
        for _ in 0..(duration / self.hands[0].1.as_secs_f64()).round() as u64 {
            self.tick();
        }
    }
}

/// No weight.
pub(super) fn weightless(world: World) -> World {
    world.with_gravity(Vector3::zeros())
}

/// A pose without turn.
pub(super) fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}
