//! The force sensor at the wrist: a virtual sensor that tells how walls push the ball, and along which it has slid.
//!
//! ```text
//! raw     = force of the stylus's spring + bias + noise, to the resolution        r; the tool hangs straight down, its weight is in the bias
//! force   = raw - bias, which is the mean of the first `ZEROING` readings         no wall is near then
//! ball    = seat as the encoders see it + force / stiffness                       the spring between them is known
//! a wall  lies along that axis of the world from which the force comes; where the ball slid, the force stays there
//! ```

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::random::Noise;
use mrroc::robot::RobotImage;
use mrroc_robots::Irp6;
use nalgebra::Vector2;

use crate::feeling::{Feeling, Seen, Stretch, Touch};
use crate::plant::World;
use crate::plant::stylus::STIFFNESS;

/// The kind of sensor: the force of walls on a ball.
#[derive(Clone, Copy, Debug)]
pub struct WallForce;

impl Sensor for WallForce {
    const KIND: &'static str = "force of walls";
    type Reading = Felt;
    type Configuration = Going;
}

/// What a program goes, so that the sensor knows which stretches are new: `c_j`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Going {
    /// Which leg this is, counted by the program from 1; 0: still the same.
    pub leg: u32,
}

/// What is felt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Felt {
    /// Whether the bias is known; nothing is felt before.
    pub is_zeroed: bool,
    /// Of walls on the ball [N, W].
    pub force: [f64; 2],
    /// The ball's middle [m, W].
    pub ball: [f64; 2],
    /// Touches: each time that a wall is felt which was not felt just before.
    pub touch: Touch,
    /// Along which walls the ball slid in this leg, in their order: so many.
    pub count: u32,
    /// See `count`.
    pub slid: [Slid; MOST],
}

/// So many stretches are told of a leg.
pub const MOST: usize = 4;

/// A slide of the ball along a wall; of no length where it only touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Slid {
    /// Of the ball's middle [m, W].
    pub from: [f64; 2],
    /// See `from`.
    pub to: [f64; 2],
    /// Into the wall, along an axis of the world.
    pub into: [f64; 2],
}

impl Felt {
    /// Of walls on the ball [N, W].
    #[must_use]
    pub fn force(&self) -> Vector2<f64> {
        self.force.into()
    }

    /// The ball's middle [m, W].
    #[must_use]
    pub fn ball(&self) -> Vector2<f64> {
        self.ball.into()
    }
}

impl Feeling<Irp6> for WallForce {
    const TELLS_FACES: bool = true;

    fn touch(felt: &Felt) -> Touch {
        felt.touch
    }

    fn place(_: &Felt, robot: &RobotImage<Irp6>) -> Vector2<f64> {
        robot.demanded().pose.translation.vector.xy()
    }

    fn seen(felt: &Felt) -> Seen {
        core::array::from_fn(|i| {
            let slid = felt.slid.get(i).filter(|_| i < felt.count as usize)?;
            Some(Stretch { ends: [slid.from.into(), slid.to.into()], into: slid.into.into() })
        })
    }
}

/// A force that is felt \[N\]: many times the noise.
pub const THRESHOLD: f64 = 0.4;
/// A wall is pressed if the force along its normal is this share of that along it: friction is less.
const SHARE: f64 = 0.45;
/// The bias is the mean of so many readings.
const ZEROING: u32 = 50;
/// Noise of a reading, one standard deviation, and resolution \[N\].
const NOISE: f64 = 0.05;
/// See [`NOISE`].
const RESOLUTION: f64 = 0.0125;
/// The bias is at most so much along each axis, and the sensor measures up to so much \[N\].
const BIAS: f64 = 3.0;
/// See [`BIAS`].
const RANGE: f64 = 65.0;
/// It has failed where it gives the same for more readings than these: once is seldom, by its noise and resolution.
const STANDING: u32 = 6;
/// Felt along both axes, less than this is of one corner; of two walls it is more \[N\].
const TURNING: f64 = 1.5;
/// A wall that was not felt for so many readings is felt anew.
const FORGOTTEN: u32 = 4;

/// How a force sensor fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failing {
    /// It gives what it gave last, whatever pushes.
    Stuck,
    /// It gives more than it can measure.
    Saturated,
}

/// Makes readings of the force.
#[derive(Debug)]
pub struct Wrist {
    world: Rc<RefCell<World>>,
    noise: Noise,
    bias: Vector2<f64>,
    failing: Option<Failing>,
    raw: Vector2<f64>,
    /// For how many readings that has been the same.
    standing: u32,
    zero: (Vector2<f64>, u32),
    felt: Felt,
    /// For each axis the sense in which a wall was pressed last, which stretch that is, and how many readings ago it was.
    pressed: [Option<(f64, usize, u32)>; 2],
    leg: u32,
    touches: Rc<Cell<u32>>,
}

impl Wrist {
    /// The sensor of this world.
    #[must_use]
    pub fn new(world: Rc<RefCell<World>>, seed: u64) -> Self {
        let mut noise = Noise::seeded(seed ^ 0x0066_6f72_6365);
        let bias = Vector2::new(noise.between(-BIAS, BIAS), noise.between(-BIAS, BIAS));
        Self {
            world,
            noise,
            bias,
            failing: None,
            raw: Vector2::zeros(),
            standing: 0,
            zero: (Vector2::zeros(), 0),
            felt: Felt::default(),
            pressed: [None; 2],
            leg: 0,
            touches: Rc::default(),
        }
    }

    /// How many touches there were, as a view of this sensor.
    #[must_use]
    pub fn touches(&self) -> Rc<Cell<u32>> {
        Rc::clone(&self.touches)
    }

    /// From now on it fails, or does not.
    pub const fn fail(&mut self, failing: Option<Failing>) {
        self.failing = failing;
    }

    /// What the strain gauges give [N, W].
    fn measured(&mut self) -> Vector2<f64> {
        let world = self.world.borrow();
        let bent = world.stylus.deflection();
        let force = world.X_WM.rotation * (-STIFFNESS * bent).push(0.0);
        drop(world);
        let noise: Vector2<f64> = self.noise.normals().into();
        let raw = force.xy() + self.bias + noise * NOISE;
        match self.failing {
            None => raw.map(|value| (value / RESOLUTION).round() * RESOLUTION),
            Some(Failing::Stuck) => self.raw,
            Some(Failing::Saturated) => Vector2::new(RANGE + RESOLUTION, raw.y),
        }
    }

    /// Which walls the force comes from, and how far the ball has slid along them.
    fn follow(&mut self) {
        let (force, ball) = (self.felt.force(), self.felt.ball);
        for axis in 0..2 {
            let (own, other) = (force[axis], force[1 - axis]);
            let is_pressed = own.abs() > THRESHOLD && own.abs() > SHARE * other.abs();
            let before = self.pressed[axis];
            if !is_pressed {
                self.pressed[axis] = before
                    .map(|(sense, number, ago)| (sense, number, ago + 1))
                    .filter(|(_, _, ago)| *ago <= FORGOTTEN);
                continue;
            }
            let sense = -own.signum();
            let mut into = [0.0; 2];
            into[axis] = sense;
            let known = before.filter(|(pressed, _, _)| *pressed == sense);
            // Around the end of a wall the force turns from one axis to the other: the same touch.
            let turns = self.pressed[1 - axis].is_some() && force.norm() < TURNING;
            if known.is_none() && !turns {
                self.touches.set(self.touches.get() + 1);
                let touches = self.touches.get();
                self.felt.touch = Touch { touching: true, touches, x: ball[0], y: ball[1], since: 0.0 };
            }
            // A stretch of an earlier leg goes on as a new one.
            let number = match known {
                Some((_, number, _)) if number < self.felt.count as usize => number,
                _ => {
                    let number = (self.felt.count as usize).min(MOST - 1);
                    self.felt.count = number as u32 + 1;
                    self.felt.slid[number] = Slid { from: ball, to: ball, into };
                    number
                }
            };
            self.felt.slid[number].to = ball;
            self.pressed[axis] = Some((sense, number, 0));
        }
    }
}

impl VirtualSensor for Wrist {
    type Kind = WallForce;

    fn aggregate(&mut self, order: &ReadingOrder<Going>) -> Result<Felt, Fault> {
        let arm = order
            .robot
            .ok_or_else(|| Fault::thrown("the force sensor got no state of its arm: write `of`"))?;
        self.world.borrow().stylus.check_travel(
            "the stylus is bent beyond its over-travel: its force is not felt, or the arm was too fast",
        )?;
        let raw = self.measured();
        // Noise alone changes it.
        self.standing = if raw == self.raw { self.standing + 1 } else { 0 };
        self.raw = raw;
        if self.standing > STANDING {
            let fault = Fault::new(FaultKind::SensorFailed);
            return Err(
                fault.text("the force sensor at the wrist stands at one value, not even noise changes it")
            );
        }
        if self.raw.amax() > RANGE {
            let fault = Fault::new(FaultKind::SensorFailed).exceeds(self.raw.amax(), RANGE, "N");
            return Err(fault
                .text("the force sensor at the wrist saturates: look what pushes the tool, and its cable"));
        }
        if self.zero.1 < ZEROING {
            self.zero.1 += 1;
            self.zero.0 += (self.raw - self.zero.0) / f64::from(self.zero.1);
            return Ok(self.felt);
        }
        if order.configuration.leg > self.leg {
            self.leg = order.configuration.leg;
            (self.felt.count, self.pressed) = (0, [None; 2]);
        }
        let force = self.raw - self.zero.0;
        self.felt.is_zeroed = true;
        self.felt.force = force.into();
        self.felt.ball = (arm.pose.translation.vector.xy() + force / STIFFNESS).into();
        self.follow();
        self.felt.touch.touching = force.norm() > THRESHOLD;
        Ok(self.felt)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
