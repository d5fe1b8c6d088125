//! The world of one cell: bodies, a table, belts, sinks, and the arms whose grippers may hold a body.
//!
//! In: the poses of the arms' tools and of the belts, servo period by servo period. Out: the forces of the bodies on them. Simulated
//! arms of one cell share it on the memory link, whose processes run on one thread. Bodies do not touch each other.
//!
//! **Time.** The servo periods of arms and belts drive it. When a period of one begins, the world goes on to its beginning, or as
//! far as the motions of all are known then. That time follows from the periods alone, so the result depends neither
//! on the order in which those of one period are ticked nor on one that has stopped. Within a period tools and belts move evenly.
//!
//! **The arms' side.** Reactions load the arms' motors one period later. That is stable for arms whose inertia at the
//! tool is far above `k T^2`, 0.2 kg for 5e4 N/m and 2 ms; geared arms have hundreds of kilograms.

use std::cell::{Ref, RefCell, RefMut};
use std::rc::Rc;

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::belt::{Belt, BeltState};
use super::body::{Body, BodyState};
use super::contact::Table;
use super::entry::{Entry, Sink, Whereabouts};
use super::error::{WorldError, not_negative};
use super::motion::{Nanos, nanos, seconds};
use super::plate::Plate;
use super::stepping::{Mover, State};
use crate::models::GRAVITY;

/// Bodies, a table, belts, sinks and grippers. All copies are the same world.
#[derive(Clone, Debug)]
pub struct World(Rc<RefCell<State>>);

impl World {
    /// A world with this body in it, and weight along -z.
    ///
    /// # Errors
    /// [`WorldError`] when no rigid body has these figures.
    pub fn new(body: &Body) -> Result<Self, WorldError> {
        let world = Self::empty();
        world.put(body)?;
        Ok(world)
    }

    /// A world without bodies, with weight along -z.
    #[must_use]
    pub fn empty() -> Self {
        Self(Rc::new(RefCell::new(State {
            time: 0,
            entries: Vec::new(),
            active: Vec::new(),
            next: 0,
            gravity: Vector3::new(0.0, 0.0, -GRAVITY),
            table: None,
            plate: None,
            belts: Vec::new(),
            sinks: Vec::new(),
            rests: false,
            hands: Vec::new(),
        })))
    }

    /// Puts a body into the world now, at rest; returns its number, counted from 0.
    ///
    /// # Errors
    /// [`WorldError`] when no rigid body has these figures.
    pub fn put(&self, body: &Body) -> Result<usize, WorldError> {
        let now = self.time();
        self.put_at(body, now)
    }

    /// Puts a body into the world, at rest, when its clock shows `time` \[s\], >= 0: at the beginning of the next interval in which
    /// nothing changes its motion. Returns its number, counted from 0.
    ///
    /// # Errors
    /// [`WorldError`] when no rigid body has these figures, or the time is none.
    pub fn put_at(&self, body: &Body, time: f64) -> Result<usize, WorldError> {
        let time = not_negative("the time at which a body comes", time, "s")?;
        let state = &mut *self.state_mut();
        state.entries.push(Entry::new(body, (time * 1e9).round() as Nanos, state.plate.as_ref())?);
        let room = state.entries.len() - state.active.len();
        state.active.reserve(room);
        state.next = 0;
        state.admit();
        Ok(state.entries.len() - 1)
    }

    /// The same world with this sink.
    ///
    /// # Errors
    /// [`WorldError`] when it has no inside.
    pub fn with_sink(self, sink: Sink) -> Result<Self, WorldError> {
        sink.check()?;
        self.state_mut().sinks.push(sink);
        Ok(self)
    }

    /// The same world, in which bodies that have moved with a belt for 50 ms rest on it: they go with it exactly, without being
    /// integrated, until a finger comes near, the belt accelerates by more than half of what friction gives, or they leave it.
    #[must_use]
    pub fn with_rest(self) -> Self {
        self.state_mut().rests = true;
        self
    }

    /// How many bodies rest on belts.
    #[cfg(test)]
    pub(super) fn rests(&self) -> usize {
        self.state().entries.iter().filter(|entry| entry.resting.is_some()).count()
    }

    /// The same world with this table.
    ///
    /// # Errors
    /// [`WorldError`] when one of its figures is out of range.
    pub fn with_table(self, table: Table) -> Result<Self, WorldError> {
        table.check()?;
        self.state_mut().table = Some(table);
        Ok(self)
    }

    /// The same world with this plate. A body that rests on a belt does not touch it.
    ///
    /// # Errors
    /// [`WorldError`] when one of its figures is out of range, or two holes meet.
    pub fn with_plate(self, plate: Plate) -> Result<Self, WorldError> {
        plate.check()?;
        self.state_mut().entries.iter_mut().for_each(|entry| entry.face(&plate));
        self.state_mut().plate = Some(plate);
        Ok(self)
    }

    /// The same world with this gravity [m/s²].
    #[must_use]
    pub fn with_gravity(self, gravity: Vector3<f64>) -> Self {
        self.state_mut().gravity = gravity;
        self
    }

    /// Puts a belt into the world, its mark at `X_WF`, which moves every `period`; returns its number.
    #[allow(non_snake_case)]
    pub(super) fn add_belt(
        &self,
        belt: Belt,
        period: core::time::Duration,
        X_WB: Pose,
        X_WF: Pose,
    ) -> Result<usize, WorldError> {
        let period = nanos(period)?;
        let state = &mut *self.state_mut();
        state.belts.push(BeltState::new(belt, X_WB, period, state.time, X_WF)?);
        state.reserve();
        Ok(state.belts.len() - 1)
    }

    /// Begins a servo period of a belt's drive; returns the force of the bodies along it \[N\] in the last one.
    pub(super) fn begin_belt(&self, index: usize) -> f64 {
        let state = &mut *self.state_mut();
        state.begin(Mover::Belt(index));
        state.belts[index].take_force()
    }

    /// Ends the servo period with the belt's mark at `X_WF`.
    #[allow(non_snake_case)]
    pub(super) fn end_belt(&self, index: usize, X_WF: Pose) {
        self.state_mut().belts[index].motion.end(X_WF);
    }

    /// Where the first body is and how it moves.
    ///
    /// # Panics
    /// In a world without bodies.
    #[must_use]
    pub fn body(&self) -> BodyState {
        self.state().entries[0].body.state()
    }

    /// How many bodies there are, awaited and gone ones counted with the others.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.state().entries.len()
    }

    /// Where a body is and how it moves; `None` of one that is not in the world.
    #[must_use]
    pub fn body_of(&self, number: usize) -> Option<BodyState> {
        let state = self.state();
        let entry = state.entries.get(number)?;
        (entry.whereabouts == Whereabouts::Here).then(|| entry.body.state())
    }

    /// Whether a body is in the world, awaited, or gone; `None` of a number that no body has.
    #[must_use]
    pub fn whereabouts(&self, number: usize) -> Option<Whereabouts> {
        self.state().entries.get(number).map(|entry| entry.whereabouts)
    }

    /// How many bodies a sink has taken, counted from 0.
    #[must_use]
    pub fn taken(&self, sink: usize) -> usize {
        let is_in =
            |entry: &&Entry| matches!(entry.whereabouts, Whereabouts::Gone { sink: in_, .. } if in_ == sink);
        self.state().entries.iter().filter(is_in).count()
    }

    /// Visits the bodies that are in the world: number, and where it is and how it moves.
    pub fn each_body(&self, mut visit: impl FnMut(usize, &BodyState)) {
        let state = self.state();
        state.active.iter().for_each(|&number| visit(number, &state.entries[number].body.state()));
    }

    /// The mark of a belt, counted from 0 in the order in which belts came into the world: its pose and how it moves.
    #[must_use]
    pub fn belt_mark(&self, belt: usize) -> Option<BodyState> {
        let state = self.state();
        let motion = &state.belts.get(belt)?.motion;
        Some(BodyState { pose: motion.pose(), velocity: motion.velocity, angular_velocity: motion.turning })
    }

    /// Gives the first body a velocity of its centre of mass [m/s] and an angular velocity [rad/s], along the world's axes.
    ///
    /// # Panics
    /// In a world without bodies.
    pub fn push(&self, velocity: Vector3<f64>, angular_velocity: Vector3<f64>) {
        let entry = &mut self.state_mut().entries[0];
        entry.wake();
        entry.body.set_velocity(velocity, angular_velocity);
    }

    /// Takes a body away, also out of a hand, as a person does who reaches in: it is gone, and counted with those that this sink has
    /// taken. Returns whether it was in the world.
    pub fn take_away(&self, number: usize, sink: usize) -> bool {
        let state = &mut *self.state_mut();
        let here = |entry: &&mut Entry| entry.whereabouts == Whereabouts::Here;
        let Some(entry) = state.entries.get_mut(number).filter(here) else { return false };
        entry.sink(sink, state.time);
        state.hands.iter_mut().filter(|hand| hand.held() == Some(number)).for_each(|hand| hand.open());
        state.active.retain(|of| *of != number);
        true
    }

    /// Gravity [m/s²].
    #[must_use]
    pub fn gravity(&self) -> Vector3<f64> {
        self.state().gravity
    }

    /// Time on the world's clock \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        seconds(self.state().time)
    }

    /// Kinetic energy, energy of position over z = 0, and energy of all springs \[J\].
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.state().energy()
    }

    /// The force of the table and of belts on the bodies \[N\], along the world's axes.
    #[must_use]
    pub fn table_force(&self) -> Vector3<f64> {
        let state = self.state();
        let points = state.active.iter().flat_map(|&number| &state.entries[number].points);
        points.map(|point| point.force).sum()
    }

    /// The force of the plate on the bodies \[N\], along the world's axes.
    #[must_use]
    pub fn plate_force(&self) -> Vector3<f64> {
        let state = self.state();
        let scrapes = state.active.iter().flat_map(|&number| &state.entries[number].scrapes);
        scrapes.map(|scrape| scrape.force).sum()
    }

    /// The greatest internal force that a closed gripper exerts on the body \[N\], mean over its last servo period: the
    /// part of its force that neither carries nor moves the body.
    #[must_use]
    pub fn internal_force(&self) -> f64 {
        let state = self.state();
        let closed = state.hands.iter().filter_map(|hand| Some((hand, hand.held()?)));
        closed
            .map(|(hand, body)| state.sharing(body).internal(&hand.applied()).force.norm())
            .fold(0.0, f64::max)
    }

    pub(super) fn state(&self) -> Ref<'_, State> {
        self.0.borrow()
    }

    pub(super) fn state_mut(&self) -> RefMut<'_, State> {
        self.0.borrow_mut()
    }
}
