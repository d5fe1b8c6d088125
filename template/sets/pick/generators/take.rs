//! Takes a part from a running belt: over it, down, with it while the hand closes, up.

use std::f64::consts::{FRAC_PI_2, PI};

use mrroc::prelude::*;
use mrroc_generators::cooperation::{TrackedFrame, Tracking};
use mrroc_generators::line::LinePath;
use mrroc_robots::Irp6;
use mrroc_sensors::virtual_sensors::Encoder;
use nalgebra::Vector3;

/// The attitude in which the tool points down, as an axis times an angle [rad].
pub const DOWN: Vector3<f64> = Vector3::new(PI, 0.0, 0.0);
/// FILL IN: when it is over the part, when the hand closes, when it goes up again [s]. Down and up take a second each.
const OVER: f64 = 3.0;
pub const CLOSE: f64 = 4.2;
const UP: f64 = 5.2;
/// Heights of the fingertips: over a part, and beside it [m].
const HIGH: f64 = 0.14;
const LOW: f64 = 0.02;
/// How old what the encoder tells is, beside its age in steps, when the arm attains the demand of its step [s].
const LATE: f64 = 0.012;

pub struct Take {
    frame: Pose,
    place: Pose,
    belt: TrackedFrame,
    from: Pose,
    age: f64,
}

impl Take {
    /// A part on the belt with the frame F, there at a place [m] and an angle [rad].
    pub fn at(frame: Pose, along: f64, across: f64, angle: f64) -> Self {
        let part = Pose::translation(along, across, LOW) * Pose::rotation(Vector3::z() * angle);
        // The fingers close along x of the tool, which is y of the part.
        let place = part * Pose::rotation(-Vector3::z() * FRAC_PI_2) * Pose::rotation(DOWN);
        let belt = TrackedFrame::new(Tracking { rate: 15.0, acceleration: 1.0, turning: 5.0 });
        Take { frame, place, belt, from: Pose::identity(), age: 0.0 }
    }
}

/// One step: what is returned is demanded.
#[generator(ecp, first = begin)]
fn take(c: &mut Take, v: &Reading<(Encoder,)>, t: Tick) -> Step<Irp6> {
    if c.age >= UP + 1.0 {
        return Step::Done;
    }
    // Where the belt's frame has gone, filtered, so that its velocity has no steps.
    let seen = v.0.reading().map(|belt| c.frame * Pose::translation(belt.travel, 0.0, 0.0));
    let late = f64::from(v.0.age()) * t.duration + LATE;
    c.age += t.dt; // with the hand's own time, whatever the encoder says
    let Some(belt) = c.belt.follow(seen.map(|seen| (seen, late)), t.duration, t.dt) else {
        return Step::Next(Demand::hold());
    };
    let height = (HIGH - LOW) * (1.0 - smooth(c.age - OVER) + smooth(c.age - UP));
    let goal = belt * c.place * Pose::translation(0.0, 0.0, -height);
    Step::Next(Demand::pose(LinePath::new(c.from, goal).pose(smooth(c.age / OVER))))
}

/// The first step: the one place that needs to know where the arm is.
fn begin(c: &mut Take, e: &State<Irp6>, v: &Reading<(Encoder,)>, t: Tick) -> Step<Irp6> {
    c.from = e.demanded().pose;
    take(c, v, t)
}

/// From 0 at 0 to 1 at 1, without a step in velocity or acceleration.
fn smooth(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}
