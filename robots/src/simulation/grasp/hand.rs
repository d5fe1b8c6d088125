//! A gripper in the world: the motion of its tool frame E, servo period by servo period, and its grasp of the body.

use std::collections::VecDeque;

use mrroc::pose::{Pose, Wrench};
use nalgebra::{UnitQuaternion, Vector3};

use super::body::Moving;
use super::compliance::{Deflection, Grasp};
use super::contact::at_lever;
use super::turn;

/// Time on the world's clock \[ns\].
pub(super) type Nanos = u64;

/// \[s\] of a time on the world's clock.
pub(super) fn seconds(time: Nanos) -> f64 {
    time as f64 * 1e-9
}

/// Where E is at a time.
#[derive(Clone, Copy, Debug)]
#[allow(non_snake_case)]
struct Knot {
    time: Nanos,
    X_WE: Pose,
}

/// A closed gripper.
#[derive(Clone, Copy, Debug)]
#[allow(non_snake_case)]
struct Held {
    /// `X_BG`.
    at: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    /// The square of the greatest frequency that the grasp alone gives the body is at most this [1/s²].
    stiffness: f64,
    /// The same of its damping [1/s].
    damping: f64,
    /// When it began to close.
    since: Nanos,
    /// How tight it is, 0 to 1.
    tightness: f64,
}

/// An arm's gripper, as the world keeps it.
#[derive(Clone, Debug)]
pub(super) struct HandState {
    pub grasp: Grasp,
    pub period: Nanos,
    /// Servo periods that have begun.
    ticks: u64,
    /// Where E has come to, from the world's time on.
    knots: VecDeque<Knot>,
    held: Option<Held>,
    /// E at the world's time, and its motion [m/s, rad/s].
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    velocity: Vector3<f64>,
    turning: Vector3<f64>,
    /// Impulse on the gripper since its last servo period, at E in the world's axes, and its length \[s\].
    impulse: Wrench,
    elapsed: f64,
    reaction: Wrench,
}

impl HandState {
    #[allow(non_snake_case)]
    pub fn new(grasp: Grasp, period: Nanos, now: Nanos, X_WE: Pose) -> Self {
        Self {
            grasp,
            period,
            ticks: now.div_ceil(period.max(1)),
            knots: VecDeque::from([Knot { time: now, X_WE }]),
            held: None,
            position: X_WE.translation.vector,
            rotation: X_WE.rotation,
            velocity: Vector3::zeros(),
            turning: Vector3::zeros(),
            impulse: Wrench::default(),
            elapsed: 0.0,
            reaction: Wrench::default(),
        }
    }

    /// Reserves memory for the knots of all periods by which the world may be behind, the longest period being `longest`.
    pub fn reserve(&mut self, longest: Nanos) {
        let periods = usize::try_from(longest.div_ceil(self.period)).unwrap_or(usize::MAX);
        self.knots.reserve(periods.saturating_add(3));
    }

    /// Begins a servo period, at the world's time `now` or later; returns the time at its beginning.
    pub fn begin(&mut self, now: Nanos) -> Nanos {
        // An arm that has stood still for a while goes on from now.
        self.ticks = self.ticks.max(now.div_ceil(self.period));
        self.ticks * self.period
    }

    /// The time to which this hand's motion is known when a servo period of another, `period` long, begins at `time`. Ticks
    /// come half a period after its beginning. One at the same moment does not count, so that their order does not matter.
    pub fn known(&self, time: Nanos, period: Nanos) -> Nanos {
        let odd_multiples = ((2 * time + period - 1) / self.period).div_ceil(2);
        odd_multiples * self.period
    }

    /// Ends the servo period with E at `X_WE`.
    #[allow(non_snake_case)]
    pub fn end(&mut self, X_WE: Pose) {
        let begun = self.ticks * self.period;
        if let Some(last) = self.knots.back().copied().filter(|last| last.time < begun) {
            self.knots.push_back(Knot { time: begun, ..last });
        }
        self.ticks += 1;
        self.knots.push_back(Knot { time: begun + self.period, X_WE });
    }

    /// The next time at which E's motion changes.
    pub fn next_change(&self, now: Nanos) -> Option<Nanos> {
        self.knots.iter().map(|knot| knot.time).find(|&time| time > now)
    }

    /// Sets E and its motion for an interval that begins at `now`.
    pub fn enter(&mut self, now: Nanos) {
        if let Some(held) = &mut self.held {
            let closing = seconds(now - held.since);
            held.tightness = if closing < self.grasp.closing { closing / self.grasp.closing } else { 1.0 };
        }
        while self.knots.get(1).is_some_and(|next| next.time <= now) {
            self.knots.pop_front();
        }
        let Some(from) = self.knots.front() else { return };
        self.position = from.X_WE.translation.vector;
        self.rotation = from.X_WE.rotation;
        self.velocity = Vector3::zeros();
        self.turning = Vector3::zeros();
        if let Some(to) = self.knots.get(1) {
            let rate = seconds(to.time - from.time).recip();
            let way = Deflection::between(
                &self.position,
                &self.rotation,
                &to.X_WE.translation.vector,
                &to.X_WE.rotation,
            );
            self.velocity = way.displacement * rate;
            self.turning = way.turn * rate;
            if now > from.time {
                self.drift(seconds(now - from.time));
            }
        }
    }

    /// Moves E on for `h` \[s\].
    pub fn drift(&mut self, h: f64) {
        self.position += self.velocity * h;
        self.rotation = turn::by(&(self.turning * h)) * self.rotation;
    }

    /// Closes at the time `now` at the frame G of the body, given as a pose in B.
    #[allow(non_snake_case)]
    pub fn close(&mut self, now: Nanos, body: &Moving, X_BG: &Pose) {
        let at = X_BG.translation.vector;
        let grasp = &self.grasp;
        let bound = |linear: f64, angular: f64| linear * body.yielding(&at) + angular * body.turning();
        self.held = Some(Held {
            at,
            rotation: X_BG.rotation,
            stiffness: bound(grasp.stiffness, grasp.rotational_stiffness),
            damping: bound(grasp.damping, grasp.rotational_damping),
            since: now,
            tightness: 0.0,
        });
    }

    pub fn open(&mut self) {
        self.held = None;
    }

    pub fn is_closed(&self) -> bool {
        self.held.is_some()
    }

    /// Bounds of the squared frequency [1/s²] and of the rate of decay [1/s] that the grasp adds to the body's motion.
    pub fn bounds(&self) -> (f64, f64) {
        self.held.map_or((0.0, 0.0), |held| (held.stiffness, held.damping))
    }

    /// `X_WE` at the world's time.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.position.into(), self.rotation)
    }

    /// The wrench of the grasp on the body now, about its centre of mass; the hand takes the opposite for `h` \[s\]. `rate`:
    /// velocity and angular velocity of the body.
    pub fn pull(&mut self, body: &Moving, rate: &Deflection, h: f64) -> Wrench {
        self.elapsed += h;
        let Some(held) = self.held else { return Wrench::default() };
        let lever = body.rotation * held.at;
        let deflection = Deflection::between(
            &self.position,
            &self.rotation,
            &(body.position + lever),
            &(body.rotation * held.rotation),
        );
        let arm = deflection.displacement;
        let omega = rate.turn;
        let rate = Deflection {
            displacement: rate.displacement + omega.cross(&lever)
                - (self.velocity + self.turning.cross(&arm)),
            turn: omega - self.turning,
        };
        let wrench = self.grasp.wrench(&deflection, &rate) * held.tightness;
        let back = at_lever(-wrench.force, &arm);
        self.impulse = self.impulse + Wrench::new(back.force, back.torque - wrench.torque) * h;
        let moved = at_lever(wrench.force, &lever);
        Wrench::new(moved.force, moved.torque + wrench.torque)
    }

    /// Energy stored in the grasp \[J\].
    pub fn energy(&self, body: &Moving) -> f64 {
        self.held.map_or(0.0, |held| {
            let deflection = Deflection::between(
                &self.position,
                &self.rotation,
                &(body.position + body.rotation * held.at),
                &(body.rotation * held.rotation),
            );
            self.grasp.energy(&deflection) * held.tightness
        })
    }

    /// Whether a period ended long ago whose reaction its arm has not taken.
    pub fn is_overdue(&self) -> bool {
        self.elapsed > 1.5 * seconds(self.period)
    }

    /// Sets the reaction to the mean since the last call.
    pub fn take_reaction(&mut self) {
        if self.elapsed > 0.0 {
            self.reaction = self.impulse * self.elapsed.recip();
            self.impulse = Wrench::default();
            self.elapsed = 0.0;
        }
    }

    /// The wrench of the body on the gripper: at E, along the world's axes.
    pub fn reaction(&self) -> Wrench {
        self.reaction
    }
}
