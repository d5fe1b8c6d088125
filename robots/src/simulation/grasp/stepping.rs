//! The state of a world, and how it goes on in time.
//!
//! **Steps.** An interval in which all tools and belts move evenly is divided into leapfrog steps `h`, for each body its own. With
//! velocities damped explicitly one mode `x'' + c x' + w^2 x = 0` of it is stable where `w^2 h^2 + 2 c h < 4` (both roots of its
//! transition, of determinant `1 - c h` and trace `2 - c h - w^2 h^2`, lie within the unit circle). Here `w h <= 0.1`,
//! which puts frequencies wrong by `(w h)^2 / 24`, 4e-4, and by `c h / 4` where they are damped, with `c h <= 0.5`. With the tensor `C = 1/m - [r] I^-1 [r]` of a
//! grasp at `r`, squared frequencies are at most the sum over grasps and touching points of `k max(C) + kappa / min(I)`.

use mrroc::pose::Wrench;
use nalgebra::Vector3;

use super::belt::BeltState;
use super::compliance::Deflection;
use super::contact::{Point, Table, at_lever};
use super::entry::{Entry, Sink, Whereabouts};
use super::hand::HandState;
use super::internal::Sharing;
use super::motion::{Motion, Nanos, seconds};
use super::pads::Touch;
use super::plate::Plate;

/// The longest step \[s\], where nothing holds the body.
const LONGEST: f64 = 1e-3;
/// The greatest frequency times the step \[rad\].
const TURN: f64 = 0.1;
/// The greatest rate of decay times the step.
const DECAY: f64 = 0.5;

/// What a drive moves in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mover {
    Hand(usize),
    Belt(usize),
}

/// The state of a world.
#[derive(Debug)]
pub(super) struct State {
    pub time: Nanos,
    pub entries: Vec<Entry>,
    /// Those that are in the world.
    pub active: Vec<usize>,
    /// When the next one comes.
    pub next: Nanos,
    pub gravity: Vector3<f64>,
    pub table: Option<Table>,
    pub plate: Option<Plate>,
    pub belts: Vec<BeltState>,
    pub sinks: Vec<Sink>,
    /// Whether bodies may rest on belts without being integrated.
    pub rests: bool,
    pub hands: Vec<HandState>,
}

impl State {
    /// Reserves memory for what the world may be behind.
    pub fn reserve(&mut self) {
        let longest = self.motions().map(|(_, motion)| motion.period).max().unwrap_or(1);
        self.hands.iter_mut().for_each(|hand| hand.motion.reserve(longest));
        self.belts.iter_mut().for_each(|belt| belt.motion.reserve(longest));
    }

    fn motions(&self) -> impl Iterator<Item = (Mover, &Motion)> {
        let hands = self.hands.iter().enumerate().map(|(i, hand)| (Mover::Hand(i), &hand.motion));
        let belts = self.belts.iter().enumerate().map(|(i, belt)| (Mover::Belt(i), &belt.motion));
        hands.chain(belts)
    }

    /// Begins a servo period, and goes on as far as all motions are known.
    pub fn begin(&mut self, mover: Mover) {
        let now = self.time;
        let motion = match mover {
            Mover::Hand(i) => &mut self.hands[i].motion,
            Mover::Belt(i) => &mut self.belts[i].motion,
        };
        let period = motion.period;
        let begun = motion.begin(now);
        let others = self.motions().filter(|(other, _)| *other != mover);
        let known = others.map(|(_, other)| other.known(begun, period)).fold(begun, Nanos::min);
        self.go_on_to(known);
        // What has stopped begins no period any more, but bodies still act on it.
        self.hands.iter_mut().filter(|hand| hand.is_overdue()).for_each(HandState::take_reaction);
        for belt in self.belts.iter_mut().filter(|belt| belt.is_overdue()) {
            belt.take_force();
        }
    }

    /// Goes on to the time `until` \[ns\].
    fn go_on_to(&mut self, until: Nanos) {
        while self.time < until {
            let now = self.time;
            self.admit();
            let changes = self.motions().filter_map(|(_, motion)| motion.next_change(now));
            let end = changes.fold(until, Nanos::min);
            self.enter(now);
            let duration = seconds(end - now);
            self.interval(now, duration);
            self.time = end;
            // Before belts enter the next interval: beyond what is known of them they stand.
            self.look_after_bodies(duration);
            self.enter(end);
            self.belts.iter_mut().for_each(|belt| belt.pass(duration));
        }
    }

    /// Lets the bodies come whose time it is.
    pub fn admit(&mut self) {
        let now = self.time;
        if now < self.next {
            return;
        }
        for (number, entry) in self.entries.iter_mut().enumerate() {
            if entry.is_due(now) {
                entry.whereabouts = Whereabouts::Here;
                self.active.push(number);
            }
        }
        let awaited = self.entries.iter().filter(|entry| entry.whereabouts == Whereabouts::Awaited);
        self.next = awaited.map(|entry| entry.since).min().unwrap_or(Nanos::MAX);
    }

    fn enter(&mut self, now: Nanos) {
        self.hands.iter_mut().for_each(|hand| hand.enter(now));
        self.belts.iter_mut().for_each(|belt| belt.motion.enter(now));
    }

    /// Steps through `duration` \[s\] in which all tools and belts move evenly.
    fn interval(&mut self, now: Nanos, duration: f64) {
        self.look_for_touches();
        let mut counted = false;
        for place in 0..self.active.len() {
            let number = self.active[place];
            if !self.entries[number].rest(&mut self.belts, self.gravity.norm(), duration) {
                self.integrate(number, duration, !counted);
                counted = true;
            }
        }
        if !counted {
            self.hands.iter_mut().for_each(|hand| hand.idle(duration));
        }
        self.grip(now);
    }

    /// Finds, for each open gripper with fingers, the body that they may touch, and wakes it.
    fn look_for_touches(&mut self) {
        for hand in &mut self.hands {
            let closed = hand.is_closed();
            let Some(jaw) = &mut hand.jaw else { continue };
            let may_touch = |number: &&usize| {
                let entry = &self.entries[**number];
                !closed && jaw.may_touch(&hand.motion, &entry.body, &entry.hull, entry.radius)
            };
            let near = self.active.iter().find(may_touch).copied();
            jaw.set_near(near);
            if let Some(number) = near {
                self.entries[number].wake();
            }
        }
    }

    /// Closes the grippers whose fingers have come to hold a body.
    fn grip(&mut self, now: Nanos) {
        for hand in &mut self.hands {
            let Some(jaw) = &mut hand.jaw else { continue };
            let Some(number) = jaw.near() else { continue };
            let body = &self.entries[number].body;
            let inverse = hand.motion.rotation.inverse();
            let seen = Touch {
                body: number,
                time: seconds(now),
                X_EB: hand.motion.pose().inv_mul(&self.entries[number].pose()),
                velocity: inverse * (body.velocity() - hand.motion.velocity),
            };
            if jaw.touches() && jaw.touch.is_none() {
                jaw.touch = Some(seen);
            }
            if jaw.has_it() {
                jaw.grip = Some(seen);
                hand.close(now, number, body, &seen.X_EB.inverse());
            }
        }
    }

    /// Lets bodies rest, and takes those that are in a sink.
    fn look_after_bodies(&mut self, duration: f64) {
        let Self { time, entries, active, belts, sinks, rests, hands, .. } = self;
        active.retain(|&number| {
            let entry = &mut entries[number];
            let engaged = hands.iter().any(|hand| hand.engaged() == Some(number));
            if *rests && !engaged && entry.resting.is_none() {
                entry.calm_down(belts, duration);
            }
            let held = hands.iter().any(|hand| hand.held() == Some(number));
            let sink = sinks.iter().position(|sink| !held && sink.has(&entry.body.position));
            sink.map(|sink| entry.sink(sink, *time)).is_none()
        });
    }

    /// Steps one body through `duration` \[s\]. `idle`: whether hands that are not at it are counted with its steps.
    fn integrate(&mut self, number: usize, duration: f64, idle: bool) {
        let gravity = self.gravity.norm();
        self.entries[number].find_belts(&self.belts, gravity, duration);
        let touching = self.is_near_table(number, duration);
        let scraping = self.is_near_plate(number, duration);
        let steps = (duration / self.longest_step(number, touching, scraping)).ceil().max(1.0);
        let h = duration / steps;
        self.drift(number, 0.5 * h);
        for left in (0..steps as usize).rev() {
            let wrench = self.wrench(number, h, touching, idle);
            self.entries[number].body.kick(&wrench, h);
            self.drift(number, if left == 0 { 0.5 * h } else { h });
        }
    }

    /// The longest step that is stable and accurate enough \[s\].
    fn longest_step(&self, number: usize, touching: bool, scraping: usize) -> f64 {
        let entry = &self.entries[number];
        let mut stiffness = 0.0;
        let mut damping = 0.0;
        for hand in self.hands.iter().filter(|hand| hand.engaged() == Some(number)) {
            let (k, c) = hand.bounds(&entry.body, entry.radius);
            stiffness += k;
            damping += c;
        }
        if let Some((k, c)) = self.table.filter(|_| touching).map(|table| table.compliance()) {
            let yielding: f64 = entry.points.iter().map(|point| point.yielding).sum();
            stiffness += k * yielding;
            damping += c * yielding;
        }
        if let Some(plate) = self.plate.as_ref().filter(|_| scraping > 0) {
            let (k, c) = plate.compliance();
            // No contact lies farther from the centre than the hull does.
            let yielding = entry.points.iter().map(|point| point.yielding).fold(0.0, f64::max);
            stiffness += k * yielding * scraping as f64;
            damping += c * yielding * scraping as f64;
        }
        for point in &entry.points {
            if let Some(belt) = point.on.and_then(|on| self.belts.get(on)) {
                let (k, c) = belt.table.compliance();
                stiffness += k * point.yielding;
                damping += c * point.yielding;
            }
        }
        LONGEST.min(TURN / stiffness.sqrt()).min(DECAY / damping)
    }

    /// Whether a point of the body may touch the table within `duration` \[s\].
    fn is_near_table(&mut self, number: usize, duration: f64) -> bool {
        let Some(table) = self.table else { return false };
        let Entry { body, points, .. } = &mut self.entries[number];
        let velocity = body.velocity();
        let omega = body.angular_velocity();
        let fall = 0.5 * self.gravity.norm() * duration * duration;
        let is_near = |point: &Point| {
            let lever = body.rotation * point.at;
            let speed = (velocity + omega.cross(&lever)).norm();
            table.is_near((body.position + lever).z, 2.0 * (speed * duration + fall))
        };
        let near = points.iter().any(is_near);
        if !near {
            let lift = |point: &mut Point| (point.stretch, point.force) = Default::default();
            points.iter_mut().filter(|point| point.on.is_none()).for_each(lift);
        }
        near
    }

    /// How many contacts of the body may touch the plate within `duration` \[s\].
    fn is_near_plate(&mut self, number: usize, duration: f64) -> usize {
        let gravity = self.gravity.norm();
        let Some(plate) = &self.plate else { return 0 };
        let Entry { body, barrel, scrapes, .. } = &mut self.entries[number];
        plate.find(body, barrel.as_ref(), scrapes, gravity, duration)
    }

    fn drift(&mut self, number: usize, h: f64) {
        self.entries[number].body.drift(h);
        self.hands.iter_mut().filter(|hand| hand.engaged() == Some(number)).for_each(|hand| hand.drift(h));
    }

    /// The total wrench on the body, about its centre of mass along the world's axes.
    fn wrench(&mut self, number: usize, h: f64, touching: bool, idle: bool) -> Wrench {
        let Entry { body, points, faces, barrel, scrapes, .. } = &mut self.entries[number];
        let mut sum = Wrench::new(body.mass * self.gravity, Vector3::zeros());
        let velocity = body.velocity();
        let omega = body.angular_velocity();
        let rate = Deflection { displacement: velocity, turn: omega };
        for hand in &mut self.hands {
            if hand.held() == Some(number) {
                sum = sum + hand.pull(body, &rate, h);
            } else if hand.engaged() == Some(number) {
                sum = sum + hand.press(body, faces, &rate, h);
            } else if idle && hand.engaged().is_none() {
                hand.idle(h);
            }
        }
        if let Some(plate) = &self.plate {
            sum = sum + plate.press(body, barrel.as_ref(), scrapes, h);
        }
        for point in points.iter_mut().filter(|point| touching || point.on.is_some()) {
            let lever = body.rotation * point.at;
            let speed = velocity + omega.cross(&lever);
            let height = (body.position + lever).z;
            let belt = point.on.and_then(|on| self.belts.get_mut(on));
            let (table, moving) = match (&belt, self.table) {
                (Some(belt), _) => (belt.table, speed - belt.motion.velocity),
                (None, Some(table)) => (table, speed),
                (None, None) => continue,
            };
            point.force = table.force(height, &moving, h, &mut point.stretch);
            if let Some(belt) = belt {
                belt.push(&-point.force, h);
            }
            sum = sum + at_lever(point.force, &lever);
        }
        sum
    }

    /// Kinetic energy, energy of position over z = 0, and energy of all springs \[J\].
    pub fn energy(&self) -> f64 {
        let of_body = |&number: &usize| {
            let Entry { body, points, barrel, scrapes, .. } = &self.entries[number];
            let holding = self.hands.iter().filter(|hand| hand.held() == Some(number));
            let springs: f64 = holding.map(|hand| hand.energy(body)).sum();
            let contact = |point: &Point| {
                let table = point.on.and_then(|on| self.belts.get(on)).map(|belt| belt.table).or(self.table);
                let height = (body.position + body.rotation * point.at).z;
                table.map_or(0.0, |table| table.energy(height, &point.stretch))
            };
            let contacts: f64 = points.iter().map(contact).sum();
            let plate = self.plate.as_ref().map_or(0.0, |plate| plate.energy(body, barrel.as_ref(), scrapes));
            body.kinetic_energy() - body.mass * self.gravity.dot(&body.position) + springs + contacts + plate
        };
        self.active.iter().map(of_body).sum()
    }

    /// How the grippers that hold a body share their total wrench on it.
    pub fn sharing(&self, body: usize) -> Sharing {
        let holding = self.hands.iter().filter(|hand| hand.held() == Some(body));
        Sharing::of(holding.map(HandState::applied))
    }
}

impl HandState {
    /// The gripper's wrench on the body: the place where it acts, and the wrench there.
    pub fn applied(&self) -> (Vector3<f64>, Wrench) {
        (self.pose().translation.vector, -self.reaction())
    }
}
