//! A body of a world: awaited, in it, or gone into a sink; and at rest on a belt, where it needs no integration.

use mrroc::pose::Pose;
use nalgebra::{Vector2, Vector3};

use super::belt::BeltState;
use super::body::{Barrel, Body, Face, Moving};
use super::contact::Point;
use super::error::WorldError;
use super::motion::{Nanos, seconds};
use super::plate::{Plate, Scrape};

/// Where a body of a world is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Whereabouts {
    /// Not there yet.
    Awaited,
    /// In the world.
    Here,
    /// In a sink.
    Gone {
        /// Which, in the order in which they were given.
        sink: usize,
        /// When, on the world's clock \[s\].
        time: f64,
    },
}

/// A box in the world that takes every body whose centre comes into it, and counts it: the bin at the end of a belt, or a tray. A
/// body in a gripper is not taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sink {
    /// Its lower corner \[m, world\].
    pub lower: [f64; 3],
    /// Its upper corner \[m, world\].
    pub upper: [f64; 3],
}

impl Sink {
    pub(super) fn check(&self) -> Result<(), WorldError> {
        let is_box = (0..3).all(|i| self.lower[i] < self.upper[i]);
        if is_box { Ok(()) } else { Err(WorldError::Sink { lower: self.lower, upper: self.upper }) }
    }

    pub(super) fn has(&self, place: &Vector3<f64>) -> bool {
        (0..3).all(|i| self.lower[i] <= place[i] && place[i] <= self.upper[i])
    }
}

/// A body, as the world keeps it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub body: Moving,
    pub points: Vec<Point>,
    pub hull: Vec<Vector3<f64>>,
    pub faces: Vec<Face>,
    pub barrel: Option<Barrel>,
    /// Its contacts with a plate.
    pub scrapes: Vec<Scrape>,
    /// Distance of the farthest point of the hull from the centre \[m\].
    pub radius: f64,
    pub whereabouts: Whereabouts,
    /// When it comes.
    pub since: Nanos,
    /// The belt on which it rests.
    pub resting: Option<usize>,
    /// How long it has moved with the belt \[s\].
    calm: f64,
}

impl Entry {
    /// A point moves with the belt where its speed differs by less \[m/s\] ..
    const CALM: f64 = 5e-4;
    /// .. and the body rests after so long \[s\].
    const SETTLING: f64 = 0.05;
    /// The share of friction that the belt may need for its own acceleration without waking the body.
    const SHARE: f64 = 0.5;

    pub fn new(body: &Body, since: Nanos, plate: Option<&Plate>) -> Result<Self, WorldError> {
        let moving = Moving::at_rest(body)?;
        let point = |at: &Vector3<f64>| Point {
            at: *at,
            yielding: moving.yielding(at),
            stretch: Vector2::zeros(),
            force: Vector3::zeros(),
            on: None,
        };
        Ok(Self {
            points: body.points.iter().map(point).collect(),
            hull: body.points.clone(),
            faces: body.faces.clone(),
            barrel: body.barrel,
            scrapes: plate.map_or_else(Vec::new, |plate| plate.contacts(&body.points, body.barrel)),
            radius: body.points.iter().map(Vector3::norm).fold(0.0, f64::max),
            body: moving,
            whereabouts: Whereabouts::Awaited,
            since,
            resting: None,
            calm: 0.0,
        })
    }

    /// It is to touch this plate.
    pub fn face(&mut self, plate: &Plate) {
        self.scrapes = plate.contacts(&self.hull, self.barrel);
    }

    /// Finds the points that may touch a belt within `duration` \[s\].
    pub fn find_belts(&mut self, belts: &[BeltState], gravity: f64, duration: f64) {
        if belts.is_empty() {
            return;
        }
        let (body, velocity, omega) = (&self.body, self.body.velocity(), self.body.angular_velocity());
        let fall = 0.5 * gravity * duration * duration;
        for point in &mut self.points {
            let lever = body.rotation * point.at;
            let reach = 2.0 * ((velocity + omega.cross(&lever)).norm() * duration + fall);
            let is_near = |(number, belt): (usize, &BeltState)| {
                belt.is_near(&(body.position + lever), reach, point.on == Some(number))
            };
            let on = belts.iter().enumerate().position(is_near);
            if on != point.on {
                (point.stretch, point.force) = Default::default();
            }
            point.on = on;
        }
    }

    /// After `duration` \[s\]: whether it has moved with a belt for long enough to rest on it.
    pub fn calm_down(&mut self, belts: &[BeltState], duration: f64) {
        let on = self.points.iter().find(|point| point.force.z > 0.0).and_then(|point| point.on);
        let Some(belt) = on.and_then(|on| belts.get(on)) else {
            self.calm = 0.0;
            return;
        };
        let slip = (self.body.velocity() - belt.motion.velocity).norm();
        let turn = self.body.angular_velocity().norm() * self.radius;
        self.calm = if slip < Self::CALM && turn < Self::CALM { self.calm + duration } else { 0.0 };
        if self.calm >= Self::SETTLING {
            self.resting = on;
        }
    }

    /// Goes on with the belt for `duration` \[s\] as a body at rest on it; it wakes, and `false` is returned, where friction may not
    /// suffice or a point of it leaves the belt.
    pub fn rest(&mut self, belts: &mut [BeltState], gravity: f64, duration: f64) -> bool {
        let Some(belt) = self.resting.and_then(|on| belts.get_mut(on)) else { return false };
        let velocity = belt.motion.velocity;
        let before = self.body.velocity();
        let change = velocity - before;
        let enough = Self::SHARE * belt.table.friction() * gravity * duration;
        let (body, hull) = (&self.body, &self.hull);
        let leaves = || hull.iter().any(|at| belt.inside(&(body.position + body.rotation * at)) <= 0.0);
        // The momentum that it still had when it fell asleep is no acceleration of the belt.
        let slips = change.norm() > enough + Self::CALM;
        if slips || (belt.inside(&body.position) < self.radius && leaves()) {
            self.wake();
            return false;
        }
        belt.push(&(-change * body.mass / duration), duration);
        self.body.set_velocity(velocity, Vector3::zeros());
        self.body.drift(duration);
        true
    }

    pub fn wake(&mut self) {
        self.resting = None;
        self.calm = 0.0;
    }

    /// Whether it is to come by the time `now`.
    pub fn is_due(&self, now: Nanos) -> bool {
        self.whereabouts == Whereabouts::Awaited && self.since <= now
    }

    /// `X_WB`.
    pub fn pose(&self) -> Pose {
        self.body.state().pose
    }

    /// Puts it into a sink at the time `now`.
    pub fn sink(&mut self, sink: usize, now: Nanos) {
        self.whereabouts = Whereabouts::Gone { sink, time: seconds(now) };
    }
}
