//! The world of one cell: a body, a table, and the arms whose grippers may hold the body.
//!
//! In: the poses of the arms' tools, servo period by servo period. Out: the forces of the body on them. Simulated arms of one
//! cell share it on the memory link, whose processes run on one thread.
//!
//! **Time.** The arms' servo periods drive it. When a period of an arm begins, the world goes on to its beginning, or as
//! far as the motions of all arms are known then. That time follows from the periods alone, so the result depends neither
//! on the order in which arms of one period are ticked nor on an arm that has stopped. Within a period tools move evenly.
//!
//! **Steps.** An interval in which all tools move evenly is divided into leapfrog steps `h`. With velocities damped
//! explicitly one mode `x'' + c x' + w^2 x = 0` of it is stable where `w^2 h^2 + 2 c h < 4` (both roots of its
//! transition, of determinant `1 - c h` and trace `2 - c h - w^2 h^2`, lie within the unit circle). Here `w h <= 0.1`,
//! which puts frequencies wrong by `(w h)^2 / 24`, 4e-4, and by `c h / 4` where they are damped, with `c h <= 0.5`. With the tensor `C = 1/m - [r] I^-1 [r]` of a
//! grasp at `r`, squared frequencies are at most the sum over grasps and touching points of `k max(C) + kappa / min(I)`.
//!
//! **The arms' side.** Reactions load the arms' motors one period later. That is stable for arms whose inertia at the
//! tool is far above `k T^2`, 0.2 kg for 5e4 N/m and 2 ms; geared arms have hundreds of kilograms.

use std::cell::{Ref, RefCell, RefMut};
use std::rc::Rc;

use mrroc::pose::{Pose, Wrench};
use nalgebra::{Vector2, Vector3};

use super::arm::Grasping;
use super::body::{Body, BodyState, Moving};
use super::compliance::{Deflection, Grasp};
use super::contact::{Point, Table, at_lever};
use super::error::{OutOfReach, WorldError, positive};
use super::hand::{HandState, Nanos, seconds};
use super::internal::Sharing;
use crate::models::{Driven, GRAVITY, Kinematics};
use crate::simulation::simulated::Simulated;

/// The longest step \[s\], where nothing holds the body.
const LONGEST: f64 = 1e-3;
/// The greatest frequency times the step \[rad\].
const TURN: f64 = 0.1;
/// The greatest rate of decay times the step.
const DECAY: f64 = 0.5;

/// A body, a table and grippers. All copies are the same world.
#[derive(Clone, Debug)]
pub struct World(Rc<RefCell<State>>);

/// The state of a world.
#[derive(Debug)]
struct State {
    time: Nanos,
    body: Moving,
    gravity: Vector3<f64>,
    table: Option<Table>,
    points: Vec<Point>,
    hands: Vec<HandState>,
}

impl World {
    /// A world with this body in it, and weight along -z.
    ///
    /// # Errors
    /// [`WorldError`] when no rigid body has these figures.
    pub fn new(body: &Body) -> Result<Self, WorldError> {
        let moving = Moving::at_rest(body)?;
        let point = |at: &Vector3<f64>| Point {
            at: *at,
            yielding: moving.yielding(at),
            stretch: Vector2::zeros(),
            force: Vector3::zeros(),
        };
        Ok(Self(Rc::new(RefCell::new(State {
            time: 0,
            points: body.points.iter().map(point).collect(),
            body: moving,
            gravity: Vector3::new(0.0, 0.0, -GRAVITY),
            table: None,
            hands: Vec::new(),
        }))))
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

    /// The same world with this gravity [m/s²].
    #[must_use]
    pub fn with_gravity(self, gravity: Vector3<f64>) -> Self {
        self.state_mut().gravity = gravity;
        self
    }

    /// The drives of an arm whose gripper, open, holds the body as `grasp` says when it is closed.
    ///
    /// The robot of the drives is the true one. The cell's robot is the one that programs compute with: its base may stand
    /// elsewhere, as after a wrong calibration.
    ///
    /// # Errors
    /// [`WorldError`] when a figure of the grasp is out of range.
    pub fn arm<const N: usize, R: Driven<N> + Kinematics<N>>(
        &self,
        drives: Simulated<R, N>,
        grasp: Grasp,
    ) -> Result<Grasping<R, N>, WorldError> {
        Grasping::new(self, drives, grasp)
    }

    /// Puts a tool frame into the world, at `X_WE`, which moves every `period`.
    #[allow(non_snake_case)]
    pub(super) fn add_hand(
        &self,
        grasp: Grasp,
        period: core::time::Duration,
        X_WE: Pose,
    ) -> Result<Hand, WorldError> {
        grasp.check()?;
        positive("the servo period", period.as_secs_f64(), "s")?;
        let mut state = self.state_mut();
        let now = state.time;
        let period = Nanos::try_from(period.as_nanos()).unwrap_or(Nanos::MAX);
        state.hands.push(HandState::new(grasp, period, now, X_WE));
        let longest = state.hands.iter().map(|hand| hand.period).max().unwrap_or(period);
        state.hands.iter_mut().for_each(|hand| hand.reserve(longest));
        Ok(Hand { world: self.clone(), index: state.hands.len() - 1 })
    }

    /// The gripper of an arm, counted from 0 in the order in which arms came into the world.
    #[must_use]
    pub fn hand(&self, arm: usize) -> Option<Hand> {
        (arm < self.state().hands.len()).then(|| Hand { world: self.clone(), index: arm })
    }

    /// Where the body is and how it moves.
    #[must_use]
    pub fn body(&self) -> BodyState {
        self.state().body.state()
    }

    /// Gives the body a velocity of its centre of mass [m/s] and an angular velocity [rad/s], along the world's axes.
    pub fn push(&self, velocity: Vector3<f64>, angular_velocity: Vector3<f64>) {
        self.state_mut().body.set_velocity(velocity, angular_velocity);
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
        let state = self.state();
        let body = &state.body;
        let springs: f64 = state.hands.iter().map(|hand| hand.energy(body)).sum();
        let contacts = state.table.map_or(0.0, |table| {
            let height = |point: &Point| (body.position + body.rotation * point.at).z;
            state.points.iter().map(|point| table.energy(height(point), &point.stretch)).sum()
        });
        body.kinetic_energy() - body.mass * state.gravity.dot(&body.position) + springs + contacts
    }

    /// The force of the table on the body \[N\], along the world's axes.
    #[must_use]
    pub fn table_force(&self) -> Vector3<f64> {
        self.state().points.iter().map(|point| point.force).sum()
    }

    /// The greatest internal force that a closed gripper exerts on the body \[N\], mean over its last servo period: the
    /// part of its force that neither carries nor moves the body.
    #[must_use]
    pub fn internal_force(&self) -> f64 {
        let state = self.state();
        let sharing = state.sharing();
        let closed = state.hands.iter().filter(|hand| hand.is_closed());
        closed.map(|hand| sharing.internal(&hand.applied()).force.norm()).fold(0.0, f64::max)
    }

    fn state(&self) -> Ref<'_, State> {
        self.0.borrow()
    }

    fn state_mut(&self) -> RefMut<'_, State> {
        self.0.borrow_mut()
    }
}

/// A gripper in a world: it closes and opens, and has the wrench of the body on it. All copies are the same gripper.
#[derive(Clone, Debug)]
pub struct Hand {
    world: World,
    index: usize,
}

impl Hand {
    /// Closes on the body: where the two are, or at the stated grasp frame. A closed gripper stays as it is.
    ///
    /// # Errors
    /// [`OutOfReach`] when the stated grasp frame is too far from the tool frame.
    #[allow(non_snake_case)]
    pub fn close(&self) -> Result<(), OutOfReach> {
        let state = &mut *self.world.state_mut();
        let now = state.time;
        let body = &state.body;
        let hand = &mut state.hands[self.index];
        if hand.is_closed() {
            return Ok(());
        }
        let X_BE = body.state().pose.inverse() * hand.pose();
        let X_BG = hand.grasp.X_BG.unwrap_or(X_BE);
        let X_EG = X_BE.inverse() * X_BG;
        let distance = X_EG.translation.vector.norm();
        let angle = X_EG.rotation.angle();
        let reach = Grasp::REACH;
        let turn = Grasp::TURN;
        let is_there = distance <= reach && angle <= turn;
        if !is_there {
            return Err(OutOfReach { distance, angle, reach, turn });
        }
        hand.close(now, body, &X_BG);
        Ok(())
    }

    /// Lets the body go.
    pub fn open(&self) {
        self.world.state_mut().hands[self.index].open();
    }

    /// Whether it holds the body.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.world.state().hands[self.index].is_closed()
    }

    /// `F_E`, the wrench of the body on the gripper: at the tool frame's origin and in its axes, mean over the last servo
    /// period that the world went through.
    #[must_use]
    pub fn reaction(&self) -> Wrench {
        let state = self.world.state();
        let hand = &state.hands[self.index];
        let turn = Pose::from_parts(Default::default(), hand.pose().rotation.inverse());
        hand.reaction().moved(&turn)
    }

    /// The part of the gripper's wrench on the body that neither carries nor moves it: at the tool frame's origin, in the
    /// world's axes. The internal wrenches of all closed grippers together are zero.
    #[must_use]
    pub fn internal(&self) -> Wrench {
        let state = self.world.state();
        let hand = &state.hands[self.index];
        if hand.is_closed() { state.sharing().internal(&hand.applied()) } else { Wrench::default() }
    }

    /// `X_WE`, where the tool frame truly is at the world's time.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.world.state().hands[self.index].pose()
    }

    /// The world that it is in.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Begins a servo period of the hand's arm; returns the wrench of the body on the gripper in the last period: at E,
    /// along the world's axes.
    pub(super) fn begin(&self) -> Wrench {
        let state = &mut *self.world.state_mut();
        let now = state.time;
        let period = state.hands[self.index].period;
        let begun = state.hands[self.index].begin(now);
        let others = state.hands.iter().enumerate().filter(|(i, _)| *i != self.index);
        let known = others.map(|(_, other)| other.known(begun, period)).fold(begun, Nanos::min);
        state.go_on_to(known);
        // An arm whose drives stopped begins no period any more, but the body still acts on its gripper.
        state.hands.iter_mut().filter(|hand| hand.is_overdue()).for_each(HandState::take_reaction);
        let hand = &mut state.hands[self.index];
        hand.take_reaction();
        hand.reaction()
    }

    /// Ends the servo period with the tool frame at `X_WE`.
    #[allow(non_snake_case)]
    pub(super) fn end(&self, X_WE: Pose) {
        self.world.state_mut().hands[self.index].end(X_WE);
    }
}

impl State {
    /// Goes on to the time `until` \[ns\].
    fn go_on_to(&mut self, until: Nanos) {
        while self.time < until {
            let now = self.time;
            let changes = self.hands.iter().filter_map(|hand| hand.next_change(now));
            let end = changes.fold(until, Nanos::min);
            self.hands.iter_mut().for_each(|hand| hand.enter(now));
            self.interval(seconds(end - now));
            self.time = end;
            self.hands.iter_mut().for_each(|hand| hand.enter(end));
        }
    }

    /// Steps through `duration` \[s\] in which all tools move evenly.
    fn interval(&mut self, duration: f64) {
        let touching = self.is_near_table(duration);
        let steps = (duration / self.longest_step(touching)).ceil().max(1.0);
        let h = duration / steps;
        self.drift(0.5 * h);
        for left in (0..steps as usize).rev() {
            let wrench = self.wrench(h, touching);
            self.body.kick(&wrench, h);
            self.drift(if left == 0 { 0.5 * h } else { h });
        }
    }

    /// The longest step that is stable and accurate enough \[s\].
    fn longest_step(&self, touching: bool) -> f64 {
        let mut stiffness = 0.0;
        let mut damping = 0.0;
        for (k, c) in self.hands.iter().map(HandState::bounds) {
            stiffness += k;
            damping += c;
        }
        if let Some((k, c)) = self.table.filter(|_| touching).map(|table| table.compliance()) {
            let yielding: f64 = self.points.iter().map(|point| point.yielding).sum();
            stiffness += k * yielding;
            damping += c * yielding;
        }
        LONGEST.min(TURN / stiffness.sqrt()).min(DECAY / damping)
    }

    /// Whether a point of the body may touch the table within `duration` \[s\].
    fn is_near_table(&mut self, duration: f64) -> bool {
        let Some(table) = self.table else { return false };
        let body = &self.body;
        let velocity = body.velocity();
        let omega = body.angular_velocity();
        let fall = 0.5 * self.gravity.norm() * duration * duration;
        let is_near = |point: &Point| {
            let lever = body.rotation * point.at;
            let speed = (velocity + omega.cross(&lever)).norm();
            table.is_near((body.position + lever).z, 2.0 * (speed * duration + fall))
        };
        let near = self.points.iter().any(is_near);
        if !near {
            let lift = |point: &mut Point| (point.stretch, point.force) = Default::default();
            self.points.iter_mut().for_each(lift);
        }
        near
    }

    fn drift(&mut self, h: f64) {
        self.body.drift(h);
        self.hands.iter_mut().filter(|hand| hand.is_closed()).for_each(|hand| hand.drift(h));
    }

    /// The total wrench on the body, about its centre of mass along the world's axes.
    fn wrench(&mut self, h: f64, touching: bool) -> Wrench {
        let body = &self.body;
        let mut sum = Wrench::new(body.mass * self.gravity, Vector3::zeros());
        let velocity = body.velocity();
        let omega = body.angular_velocity();
        let rate = Deflection { displacement: velocity, turn: omega };
        for hand in &mut self.hands {
            sum = sum + hand.pull(body, &rate, h);
        }
        if let Some(table) = self.table.filter(|_| touching) {
            for point in &mut self.points {
                let lever = body.rotation * point.at;
                let speed = velocity + omega.cross(&lever);
                point.force = table.force((body.position + lever).z, &speed, h, &mut point.stretch);
                sum = sum + at_lever(point.force, &lever);
            }
        }
        sum
    }

    /// How the closed grippers share their total wrench on the body.
    fn sharing(&self) -> Sharing {
        Sharing::of(self.hands.iter().filter(|hand| hand.is_closed()).map(HandState::applied))
    }
}

impl HandState {
    /// The gripper's wrench on the body: the place where it acts, and the wrench there.
    fn applied(&self) -> (Vector3<f64>, Wrench) {
        (self.pose().translation.vector, -self.reaction())
    }
}
