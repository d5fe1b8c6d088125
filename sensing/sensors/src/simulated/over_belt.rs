//! A simulated world as sensors over a belt see it.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc_robots::grasp::{BodyState, World, WorldError};
use nalgebra::{Point3, Vector3};

use super::workpiece::Workpiece;
use crate::scene::{Scene, Solid};
use crate::view::{Seen, View};

/// What is on the first belt of a world, for cameras, matrices and light barriers. Arms are not in it: keep them out of what a camera sees, or
/// implement [`View`] for a scene of your own.
///
/// A clone is the same scene. Frame F: the base of the belt's conveyor, on its surface, x along it, z up.
///
/// ```
/// use mrroc::pose::Pose;
/// use mrroc_robots::grasp::World;
/// use mrroc_sensors::simulated::{OverBelt, Workpiece};
/// use mrroc_sensors::view::View as _;
///
/// // The belt begins at x = 0.8 m. A block is put on it at once, 0.1 m along it and 0.02 m aside.
/// let belt = Pose::translation(0.8, 0.0, 0.0);
/// let scene = OverBelt::of(World::empty(), belt);
/// let block = Workpiece::block([0.07, 0.05, 0.04], 0.2);
/// scene.put(block, Pose::translation(0.1, 0.02, 0.0), 0.0)?;
/// let mut seen = Vec::new();
/// scene.each_form(&mut |thing| seen.push(thing.pose.translation.vector));
/// assert!((seen[0] - nalgebra::Vector3::new(0.1, 0.02, 0.0)).norm() < 1e-12);
/// # Ok::<(), mrroc_robots::grasp::WorldError>(())
/// ```
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct OverBelt {
    world: World,
    /// By the numbers of their bodies.
    pieces: Rc<RefCell<Vec<Option<Workpiece>>>>,
    X_WF: Pose,
}

impl OverBelt {
    /// Of a world, over a belt at `X_WF`. Bodies that are in the world already are not seen.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn of(world: World, X_WF: Pose) -> Self {
        Self::with(world, X_WF, [])
    }

    /// The same of a world into which the bodies of these parts have been put, in their order and before all others.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with(world: World, X_WF: Pose, pieces: impl IntoIterator<Item = Workpiece>) -> Self {
        let pieces = Rc::new(RefCell::new(pieces.into_iter().map(Some).collect()));
        Self { world, pieces, X_WF }
    }

    /// Puts a part onto the belt at `X_FP`, when the world's clock shows `time` \[s\], >= 0; returns its number, counted from 0.
    ///
    /// # Errors
    /// As [`World::put_at`].
    #[allow(non_snake_case)]
    pub fn put(&self, piece: Workpiece, X_FP: Pose, time: f64) -> Result<usize, WorldError> {
        let X_WB = self.X_WF * X_FP * piece.X_BP.inverse();
        let number = self.world.put_at(&piece.body.clone().at(X_WB), time)?;
        let mut pieces = self.pieces.borrow_mut();
        let count = pieces.len().max(number + 1);
        pieces.resize(count, None);
        pieces[number] = Some(piece);
        Ok(number)
    }

    /// The world.
    #[must_use]
    pub const fn world(&self) -> &World {
        &self.world
    }
}

/// A body in this state, as barriers see it: the points of its hull in its frame, and how much light it scatters, 0 to 1.
#[must_use]
pub fn solid<'h>(hull: &'h [Vector3<f64>], reflectance: f64, state: &BodyState) -> Solid<'h> {
    let BodyState { pose, velocity, angular_velocity, .. } = *state;
    Solid { hull, pose, velocity, angular_velocity, reflectance }
}

impl Scene for OverBelt {
    fn now(&self) -> f64 {
        self.world.time()
    }

    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>)) {
        let pieces = self.pieces.borrow();
        self.world.each_body(|number, state| {
            let Some(piece) = pieces.get(number).and_then(Option::as_ref) else { return };
            visit(&solid(piece.body.points(), piece.reflectance, state));
        });
    }
}

impl View for OverBelt {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        let pieces = self.pieces.borrow();
        let to_belt = self.X_WF.rotation.inverse();
        self.world.each_body(|number, state| {
            let Some(piece) = pieces.get(number).and_then(Option::as_ref) else { return };
            let lever = state.pose.rotation * piece.X_BP.translation.vector;
            let velocity = state.velocity + state.angular_velocity.cross(&lever);
            visit(&Seen {
                form: &piece.form,
                pose: self.X_WF.inv_mul(&(state.pose * piece.X_BP)),
                velocity: to_belt * velocity,
                angular_velocity: to_belt * state.angular_velocity,
                reflectance: piece.reflectance,
            });
        });
    }

    #[allow(non_snake_case)]
    fn surface(&self, before: f64) -> f64 {
        let Some(mark) = self.world.belt_mark(0) else { return 0.0 };
        let X_FW = self.X_WF.inverse();
        let at = X_FW * Point3::from(mark.pose.translation.vector);
        at.x - (X_FW.rotation * mark.velocity).x * before
    }
}
