//! The virtual sensor of a base among walls: where it stands, what is in its way, and which walls it has seen.

use mrroc::fault::FaultKind;
use mrroc::payload::Payload;
use mrroc::prelude::*;
use nalgebra::Vector2;

use super::infrared::{FRONT, Infrared, SENSORS, distance, mounted};
use super::planar::Planar;
use super::wall_memory::{Face, TOLD, WallMemory};
use super::whereabouts::{Located, wheels};
use crate::model::DiffDrive;
use crate::simulation::Floor;

/// The kind of sensor.
#[derive(Clone, Copy, Debug)]
pub struct Lookout;

impl Sensor for Lookout {
    const KIND: &'static str = "lookout";
    type Reading = Sight;
    type Configuration = Watch;
}

/// What a program goes for, so that the sensor knows what is in its way: `c_j`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Watch {
    /// Which path this is, counted by the program from 1; 0: it goes nowhere.
    pub path: u32,
    /// Where it leads to, straight on [m, floor].
    pub x: f64,
    /// See `x`.
    pub y: f64,
}

/// What a base among walls knows of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Sight {
    /// Where it stands.
    pub pose: Planar,
    /// Whether it stands still, and its gyro's bias is known.
    pub stands: bool,
    /// How far it can go straight on before it touches something \[m\]; [`Sight::FAR`] where nothing is seen.
    pub ahead: f64,
    /// Whether the path that it follows now is blocked.
    pub is_blocked: bool,
    /// How many paths were found blocked, and what the last one was blocked by: a place on a wall [m, floor].
    pub blocked: u32,
    /// See `blocked`.
    pub x: f64,
    /// See `blocked`.
    pub y: f64,
    /// How many faces have been told, and those that changed last, the newest first.
    pub count: u8,
    /// See `count`.
    pub faces: [Face; TOLD],
}

impl Sight {
    /// Nothing is seen ahead \[m\].
    pub const FAR: f64 = 0.2;
    /// A path is blocked by what would be touched after so much more of it \[m\]: a base of 0.3 m/s stops before.
    pub const NEAR: f64 = 0.045;
}

/// Aggregates wheels, gyro and infrared sensors.
#[derive(Debug)]
pub struct LookingOut {
    floor: Floor,
    located: Located,
    infrared: Infrared,
    memory: WallMemory,
    /// What each sensor said last: where that was, and whether it is as new as the last sample ahead.
    met: [Option<Vector2<f64>>; SENSORS],
    /// The last path that was blocked, how many were, and by what.
    blocked: (u32, u32, Vector2<f64>),
    gone: f64,
    time: f64,
}

impl LookingOut {
    /// Turning faster, it only looks at what is ahead [rad/s].
    const DIZZY: f64 = 0.6;
    /// The path is as wide as if the body had this radius \[m\]: where it stands is known to a few millimetres.
    const KEPT: f64 = DiffDrive::BODY + 0.005;
    /// It looks at walls again when it has gone so far \[m\]: what is wrong with a sensor does not add up where it stands.
    const AGAIN: f64 = 5e-3;
    /// What is farther from a sensor is not used for the map \[m\].
    const SURE: f64 = 0.22;

    /// Of the base of this floor.
    #[must_use]
    pub fn new(floor: Floor, located: Located, infrared: Infrared, memory: WallMemory) -> Self {
        let time = floor.time();
        Self {
            floor,
            located,
            infrared,
            memory,
            met: [None; SENSORS],
            blocked: (0, 0, Vector2::zeros()),
            gone: 0.0,
            time,
        }
    }

    /// The gyro and what it is compared with, to break it.
    pub const fn located_mut(&mut self) -> &mut Located {
        &mut self.located
    }

    /// The infrared sensors, to break one.
    pub const fn infrared_mut(&mut self) -> &mut Infrared {
        &mut self.infrared
    }

    /// How far the body can go straight on before it touches, and the place that it touches then.
    fn ahead(&self, pose: &Planar) -> (f64, Vector2<f64>) {
        let mut nearest = (Sight::FAR, Vector2::zeros());
        for at in self.met[..FRONT].iter().flatten() {
            let seen = pose.seen(at);
            let rim = Self::KEPT * Self::KEPT - seen.y * seen.y;
            let ahead = (seen.x - rim.max(0.0).sqrt()).max(0.0);
            if rim > 0.0 && ahead < nearest.0 {
                nearest = (ahead, *at);
            }
        }
        nearest
    }
}

impl VirtualSensor for LookingOut {
    type Kind = Lookout;

    fn aggregate(&mut self, order: &ReadingOrder<Watch>) -> Result<Sight, Fault> {
        if self.floor.touched().now {
            let fault = Fault::new(FaultKind::ProtectiveStop);
            return Err(fault.text("the bumper touches a wall that no sensor saw: put the base back, and look at its infrared sensors"));
        }
        let reckoned = self.located.step(&wheels(order.robot.as_ref())?)?;
        let now = self.floor.time();
        let passed = now - core::mem::replace(&mut self.time, now);
        let steady = reckoned.turn.abs() < Self::DIZZY * passed.max(1e-3);
        let codes = self.infrared.ask();
        let mut pose = reckoned.pose;
        let mut is_new = false;
        for (i, code) in codes.iter().enumerate() {
            let Some(code) = code else { continue };
            let far = distance(*code);
            let sensor = mounted(i);
            let (sine, cosine) = sensor.looks.sin_cos();
            let on_base = |far: f64| sensor.at + Vector2::new(cosine, sine) * far;
            self.met[i] = far.map(|far| pose.place(&on_base(far)));
            is_new |= i < FRONT;
            if steady {
                let sure = far.filter(|far| *far < Self::SURE);
                pose = self.memory.trace(i, sure.map(|far| pose.place(&on_base(far))), pose);
            }
        }
        self.gone += reckoned.distance.abs();
        if is_new && steady && self.gone > Self::AGAIN {
            self.gone = 0.0;
            // Those that look ahead, from right to left, as they met last.
            let near: [_; FRONT] = core::array::from_fn(|i| {
                self.met[i].filter(|at| pose.seen(at).x - mounted(i).at.x < Self::SURE)
            });
            pose = self.memory.side_by_side(&near, pose);
        }
        self.located.correct(pose);
        let (ahead, what) = self.ahead(&pose);
        let Watch { path, x, y } = order.configuration;
        let left = pose.seen(&Vector2::new(x, y)).x;
        if path != 0 && path != self.blocked.0 && ahead < Sight::NEAR && ahead < left {
            self.blocked = (path, self.blocked.1 + 1, what);
        }
        let mut sight = Sight {
            pose,
            stands: reckoned.stands,
            ahead,
            is_blocked: path != 0 && path == self.blocked.0,
            blocked: self.blocked.1,
            x: self.blocked.2.x,
            y: self.blocked.2.y,
            count: 0,
            faces: [Face::default(); TOLD],
        };
        for (told, face) in sight.faces.iter_mut().zip(self.memory.changed()) {
            *told = face;
            sight.count += 1;
        }
        Ok(sight)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
