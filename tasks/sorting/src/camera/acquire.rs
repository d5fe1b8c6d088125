//! Takes a part from the running belt: goes with it by the belt's encoder, down, waits for the hand, and up.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc::prelude::*;
use mrroc_robots::Irp6;
use mrroc_sensors::virtual_sensors::{Between, Encoder};
use nalgebra::Vector3;

use super::count::Count;
use super::layout::{FIRST, LAST};
use super::orders::Place;
use crate::generators::{Close, Part, Pursuit};
use crate::places::{BELT, HIGH, LOW, tool};

/// The phases of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// Over the part.
    Above,
    /// Beside it, for so long \[s\].
    Down(f64),
    /// On its way up, from where it left the part, along and across the belt \[m\].
    Up(f64, f64),
}

/// Follows a place on the belt, down to it, stays there while the hand closes, and goes up. The place is known in the belt's frame, so
/// that the encoder says where it is now; no camera is asked.
pub struct Acquire {
    place: Place,
    /// Where the arm stands along the belt \[m\]; all places below count from there.
    station: f64,
    tool: Pursuit,
    yaw: f64,
    turning: f64,
    phase: Phase,
    count: Count,
    /// How long the part has been between the fingers, and for how long the tool has been about it \[s\].
    held: f64,
    age: f64,
}

impl Acquire {
    /// Hand and arm wait so long for a part \[s\].
    pub const TIMEOUT: f64 = 9.0;
    /// A part comes between the fingers within this time, or it is not there \[s\].
    const COMING: f64 = 1.2;
    /// How old the belt's state is that the encoder's reading has, at the step of that reading \[s\].
    pub const LATCH: f64 = 2.2e-3;
    /// The tool goes down where it is within this of its place \[m\], with this difference of velocity [m/s] and of angle \[rad\].
    const NEAR: (f64, f64, f64) = (0.002, 0.01, 0.01);
    /// Across the belt, towards the arm, the trays begin here \[m\].
    const BESIDE: f64 = -0.12;
    /// How fast the wrist may turn [rad/s], of 0.865.
    const WRIST: f64 = 0.72;
    /// Angles of the tool that the wrist attains all along the belt and over the trays \[rad\].
    pub const ANGLES: [f64; 2] = [-0.4, 3.5];
    /// Angular acceleration of the tool about z [rad/s²].
    const TURNING: f64 = 2.5;

    /// A part at a place in the belt's frame, by an arm that stands so far along the belt \[m\].
    #[must_use]
    pub fn new(place: Place, station: f64) -> Self {
        Self {
            place: Place { along: place.along - station, ..place },
            station,
            tool: Pursuit::default(),
            yaw: 0.0,
            turning: 0.0,
            phase: Phase::Above,
            count: Count::default(),
            held: 0.0,
            age: 0.0,
        }
    }

    /// The angle of the tool about z of the world \[rad\].
    #[must_use]
    pub const fn yaw(&self) -> f64 {
        self.yaw
    }

    /// Turns towards the angle of the part, as fast as the wrist can beside the arm's own motion.
    fn turn(&mut self, dt: f64) {
        let remaining = self.place.yaw - self.yaw;
        // q6 turns with the column's q1, and against the tool's angle.
        let (x, y) = (BELT[0] + self.tool.at.y, BELT[1] + self.tool.at.x);
        let column = (x * self.tool.velocity.x - y * self.tool.velocity.y) / x.hypot(y).powi(2);
        let speed =
            (1.2 * Self::TURNING * remaining.abs()).sqrt().min(8.0 * remaining.abs()).copysign(remaining);
        let speed = speed.clamp(column - Self::WRIST, column + Self::WRIST);
        let change = Self::TURNING * dt;
        self.turning += (speed - self.turning).clamp(-change, change);
        self.yaw += self.turning * dt;
    }
}

/// The tool along the belt, across it and over it \[m\], turned about z of the world \[rad\].
#[must_use]
pub fn at(s: f64, across: f64, over: f64, yaw: f64) -> Pose {
    let pose = tool(s, across, over);
    Pose::from_parts(pose.translation, Pose::rotation(Vector3::z() * yaw).rotation * pose.rotation)
}

#[generator(ecp)]
impl Acquire {
    fn first_step(
        &mut self,
        e: &State<Irp6>,
        v: &Reading<(Encoder, Between)>,
        t: Tick,
    ) -> Result<Step<Irp6>, Fault> {
        let pose = e.demanded().pose;
        self.tool = Pursuit::at_rest(&pose);
        self.tool.at.x -= self.station;
        let x = pose.rotation * Vector3::x();
        self.yaw = x.y.atan2(x.x);
        // From -0.4 on, not from -pi on.
        if self.yaw < -1.0 {
            self.yaw += 2.0 * PI;
        }
        // Fingers do not mind half a turn: the nearest of those attitudes that the wrist attains.
        let attained = |yaw: &f64| (Self::ANGLES[0]..=Self::ANGLES[1]).contains(yaw);
        let all = [-PI, 0.0, PI].map(|half| self.place.yaw + half);
        let nearest = all
            .into_iter()
            .filter(attained)
            .min_by(|a, b| (a - self.yaw).abs().total_cmp(&(b - self.yaw).abs()));
        self.place.yaw = nearest.unwrap_or(self.place.yaw);
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Encoder, Between)>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let (Some(belt), Some(fingers)) = (v.0.reading(), v.1.reading()) else {
            return Err(Fault::thrown("a part is taken only once encoder and finger barrier have been read"));
        };
        self.count.take(belt.travel, belt.speed, t.duration)?;
        // Where the part is when the demand of this step is attained.
        let later = f64::from(v.0.age()) * t.duration + Self::LATCH + Part::DELAY;
        let s = self.place.along + belt.travel + belt.speed * later;
        if fingers.covered && self.phase == Phase::Above && self.tool.at.z > 0.5 * HIGH {
            return Err(Fault::thrown(
                "the barrier between the fingers is covered where nothing can be: clean it, or mend it",
            ));
        }
        self.age += t.dt;
        self.turn(t.dt);
        let (mut place, mut moving) = (Vector3::new(s, self.place.across, HIGH), belt.speed);
        if s < FIRST {
            (place.x, moving) = (FIRST, 0.0);
        }
        if self.phase == Phase::Above && self.tool.at.y < Self::BESIDE {
            // From a tray rather towards the belt than along it: the straight line leads too near to the arm's column.
            place.x = self.tool.at.x + 0.3 * (place.x - self.tool.at.x);
        }
        let off = (self.tool.at - place).xy().norm();
        match &mut self.phase {
            Phase::Above => {
                let drifting = (self.tool.velocity.x - moving).abs();
                let askew = (self.place.yaw - self.yaw).abs();
                let (near, slow, straight) = Self::NEAR;
                if s > LAST || self.age > Self::TIMEOUT {
                    self.phase = Phase::Up(self.tool.at.x, self.tool.at.y);
                } else if s >= FIRST && off < near && drifting < slow && askew < straight {
                    self.phase = Phase::Down(0.0);
                }
            }
            Phase::Down(time) => {
                place.z = LOW;
                *time += t.dt;
                self.held = if fingers.covered { self.held + t.dt } else { 0.0 };
                let gone = *time > Self::COMING && !fingers.covered;
                if gone || s > LAST + 0.1 || self.held >= Close::WAITING + Close::CLOSING {
                    let stopping = 0.2 * self.tool.velocity.x;
                    self.phase = Phase::Up(self.tool.at.x + stopping, self.tool.at.y);
                }
            }
            Phase::Up(along, across) => {
                (place, moving) = (Vector3::new(*along, *across, HIGH), 0.0);
                let there = (self.tool.at - place).norm() < 1e-3 && self.tool.velocity.norm() < 5e-3;
                if there && self.turning.abs() < 1e-3 {
                    return Ok(Step::Done);
                }
            }
        }
        if matches!(self.phase, Phase::Up(..)) {
            self.place.yaw = self.yaw;
        }
        self.tool = self.tool.after(&place, &Vector3::new(moving, 0.0, 0.0), t.dt);
        let s = self.tool.at.x + self.station;
        Ok(Step::Next(Demand::pose(at(s, self.tool.at.y, self.tool.at.z, self.yaw))))
    }
}
