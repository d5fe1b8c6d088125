//! Drives of arms that are not as they were designed: programs demand joint positions by what they believe, and the motors know no better.

use core::cell::RefCell;
use core::time::Duration;
use std::rc::Rc;

use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

use crate::scene::{ARMS, Scene};

/// The scene, which drives move and instruments look at, with where the arms truly are \[rad\].
#[derive(Clone)]
pub struct Shared {
    /// The scene.
    pub scene: Rc<RefCell<Scene>>,
    /// The true joint positions.
    pub joints: Rc<RefCell<[Six; ARMS]>>,
}

impl Shared {
    /// The scene with the arms at `start`, as programs believe.
    #[must_use]
    pub fn new(scene: Scene, start: &[Six; ARMS]) -> Self {
        let joints = core::array::from_fn(|arm| scene.joints(arm, &start[arm]));
        Self { scene: Rc::new(RefCell::new(scene)), joints: Rc::new(RefCell::new(joints)) }
    }
}

/// Simulated drives with motors, regulators and friction, behind a transmission that is not quite what programs believe.
pub struct Believed {
    drives: SimulatedIrp6,
    arm: usize,
    shared: Shared,
    /// Where the joints were without friction, and how far they stay behind \[rad\].
    before: Six,
    behind: Six,
}

impl Believed {
    /// The drives of an arm of the scene, at `start`.
    #[must_use]
    pub fn new(arm: usize, start: &Six, shared: Shared) -> Self {
        let before = shared.scene.borrow().joints(arm, start);
        Self { drives: SimulatedIrp6::new(Irp6::nominal(), start), arm, shared, before, behind: Six::zeros() }
    }
}

impl Driver<Irp6> for Believed {
    fn period(&self) -> Duration {
        self.drives.period()
    }

    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        self.drives.measured()
    }

    /// The motors turn as they are told, which is where programs believe the joints to be; the joints are elsewhere.
    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        let measured = self.drives.tick(demanded)?;
        let turned = self.drives.shaft().state().position;
        let scene = self.shared.scene.borrow();
        let pulled = scene.joints(self.arm, &turned);
        // A joint stays where it is until the gear is wound up by what its friction takes, and then goes with it (Prandtl's element): at rest it is
        // behind its motion.
        let most = scene.windup();
        self.behind = (self.behind + pulled - self.before).map(|behind| behind.clamp(-most, most));
        self.before = pulled;
        self.shared.joints.borrow_mut()[self.arm] = pulled - self.behind;
        Ok(measured)
    }
}
