//! A gripper in the world: the motion of its tool frame E, its fingers, and its grasp of a body.

use mrroc::pose::{Pose, Wrench};
use nalgebra::{UnitQuaternion, Vector3};

use super::body::{Face, Moving};
use super::compliance::{Deflection, Grasp};
use super::contact::at_lever;
use super::motion::{Motion, Nanos, seconds};
use super::pads::Jaw;

/// A closed gripper.
#[derive(Clone, Copy, Debug)]
#[allow(non_snake_case)]
struct Held {
    /// Which body.
    body: usize,
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
    pub motion: Motion,
    /// Its fingers, if they touch bodies.
    pub jaw: Option<Jaw>,
    held: Option<Held>,
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
            motion: Motion::new(period, now, X_WE),
            jaw: None,
            held: None,
            impulse: Wrench::default(),
            elapsed: 0.0,
            reaction: Wrench::default(),
        }
    }

    /// Sets E and its motion for an interval that begins at `now`.
    pub fn enter(&mut self, now: Nanos) {
        if let Some(held) = &mut self.held {
            let closing = seconds(now - held.since);
            held.tightness = if closing < self.grasp.closing { closing / self.grasp.closing } else { 1.0 };
        }
        self.motion.enter(now);
    }

    /// Closes at the time `now` at the frame G of the body with this index, given as a pose in B.
    #[allow(non_snake_case)]
    pub fn close(&mut self, now: Nanos, index: usize, body: &Moving, X_BG: &Pose) {
        let at = X_BG.translation.vector;
        let grasp = &self.grasp;
        let bound = |linear: f64, angular: f64| linear * body.yielding(&at) + angular * body.turning();
        self.held = Some(Held {
            body: index,
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

    /// The body that it holds.
    pub fn held(&self) -> Option<usize> {
        self.held.map(|held| held.body)
    }

    /// The body that it holds, or that its fingers may touch in this interval.
    pub fn engaged(&self) -> Option<usize> {
        self.held().or(self.jaw.as_ref().and_then(Jaw::near))
    }

    /// Counts `h` \[s\] in which nothing acts on it.
    pub fn idle(&mut self, h: f64) {
        self.elapsed += h;
    }

    /// The wrench of its open fingers on the body that they are near, about its centre of mass; the hand takes the opposite for
    /// `h` \[s\].
    pub fn press(&mut self, body: &Moving, faces: &[Face], rate: &Deflection, h: f64) -> Wrench {
        self.elapsed += h;
        let Some(jaw) = &mut self.jaw else { return Wrench::default() };
        let wrench = jaw.press(&self.motion, body, faces, rate);
        let arm = body.position - self.motion.position;
        let back = at_lever(-wrench.force, &arm);
        self.impulse = self.impulse + Wrench::new(back.force, back.torque - wrench.torque) * h;
        wrench
    }

    /// Bounds of the squared frequency [1/s²] and of the rate of decay [1/s] that the grasp or the fingers add to the motion of the body
    /// that they are at, whose hull reaches this far from its centre \[m\].
    pub fn bounds(&self, body: &Moving, radius: f64) -> (f64, f64) {
        match (&self.held, &self.jaw) {
            (Some(held), _) => (held.stiffness, held.damping),
            (None, Some(jaw)) => jaw.bounds(body.yielding(&(Vector3::repeat(radius / 3.0_f64.sqrt())))),
            (None, None) => (0.0, 0.0),
        }
    }

    /// Moves E and the fingers on for `h` \[s\].
    #[inline]
    pub fn drift(&mut self, h: f64) {
        self.motion.drift(h);
        if let Some(jaw) = &mut self.jaw {
            jaw.drift(h);
        }
    }

    /// `X_WE` at the world's time.
    pub fn pose(&self) -> Pose {
        self.motion.pose()
    }

    /// The wrench of the grasp on the body now, about its centre of mass; the hand takes the opposite for `h` \[s\]. `rate`:
    /// velocity and angular velocity of the body.
    #[inline]
    pub fn pull(&mut self, body: &Moving, rate: &Deflection, h: f64) -> Wrench {
        self.elapsed += h;
        let Some(held) = self.held else { return Wrench::default() };
        let lever = body.rotation * held.at;
        let deflection = Deflection::between(
            &self.motion.position,
            &self.motion.rotation,
            &(body.position + lever),
            &(body.rotation * held.rotation),
        );
        let arm = deflection.displacement;
        let omega = rate.turn;
        let rate = Deflection {
            displacement: rate.displacement + omega.cross(&lever)
                - (self.motion.velocity + self.motion.turning.cross(&arm)),
            turn: omega - self.motion.turning,
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
                &self.motion.position,
                &self.motion.rotation,
                &(body.position + body.rotation * held.at),
                &(body.rotation * held.rotation),
            );
            self.grasp.energy(&deflection) * held.tightness
        })
    }

    /// Whether a period ended long ago whose reaction its arm has not taken.
    pub fn is_overdue(&self) -> bool {
        self.elapsed > 1.5 * seconds(self.motion.period)
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
