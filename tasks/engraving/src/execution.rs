//! What came of it: looks at every servo period of the arm and measures, carves and records.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::observe::{ServoRecord, Shown};
use mrroc::prelude::*;
use mrroc::robot::Limits;
use mrroc_robots::{Irp6, Shaft, Six};

use crate::deviation::Deviation;
use crate::ecp::Activity;
use crate::plate::{HeightMap, Tip};
use crate::trace::Trace;

/// What measures, carves and records, unused yet.
pub struct Instruments {
    /// Measures distances from the drawing.
    pub deviation: Deviation,
    /// The plate that is carved.
    pub surface: HeightMap,
    /// Records the path.
    pub trace: Trace,
}

/// The measurements of a run.
pub struct Execution {
    /// Of the demanded path.
    pub demanded: Deviation,
    /// Of the path of the arm's true tip, from the plant's dynamics.
    pub executed: Deviation,
    /// The plate.
    pub surface: HeightMap,
    /// The executed path.
    pub trace: Trace,
    /// Largest joint speed demanded [rad/s].
    pub velocity: Six,
    /// Largest joint acceleration demanded [rad/s²].
    pub acceleration: Six,
    /// Length of the tip's path in the material \[mm\].
    pub cut_length: f64,
    /// Length of the tip's path above it \[mm\].
    pub travel_length: f64,
    arm: Irp6,
    shaft: Shaft,
    activity: Shown<Activity>,
    /// `X_PW`: the world in the frame of the plate's true surface.
    world: Pose,
    stroke: Option<usize>,
    tip: Option<Tip>,
    joints: Option<(Six, Six)>,
    time: f64,
}

impl Execution {
    /// For an arm whose true state is `shaft`'s, and a plate whose true surface lies at `X_WP`.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn new(
        arm: Irp6,
        shaft: Shaft,
        activity: Shown<Activity>,
        X_WP: &Pose,
        instruments: Instruments,
    ) -> Self {
        Execution {
            demanded: instruments.deviation.clone(),
            executed: instruments.deviation,
            surface: instruments.surface,
            trace: instruments.trace,
            velocity: Six::zeros(),
            acceleration: Six::zeros(),
            cut_length: 0.0,
            travel_length: 0.0,
            arm,
            shaft,
            activity,
            world: X_WP.inverse(),
            stroke: None,
            tip: None,
            joints: None,
            time: 0.0,
        }
    }

    /// An observer of the arm's servo periods.
    pub fn observer(execution: &Rc<RefCell<Execution>>) -> impl FnMut(&ServoRecord<Irp6>) + 'static {
        let execution = Rc::clone(execution);
        move |record| execution.borrow_mut().observe(record)
    }

    fn observe(&mut self, record: &ServoRecord<Irp6>) {
        self.observe_joints(record);
        // In the plate's frame, in millimetres.
        let tip = |q: &Six| (self.world * self.arm.forward(q) * record.tool).translation.vector * 1e3;
        let executed = tip(&self.shaft.state().position);
        let activity = self.activity.get();
        let stroke = activity.stroke();
        if let Some(index) = stroke {
            if self.stroke != stroke {
                let found = activity.plate_height().unwrap_or(0.0);
                // Depth counts from where the probe found the plate: that is where the drawing lies for the arm.
                let surface = (found + self.world.translation.z) * 1e3;
                self.demanded.begin_stroke(index, surface);
                self.executed.begin_stroke(index, surface);
            }
            self.demanded.observe(tip(&record.demanded));
            self.executed.observe(executed);
        }
        self.stroke = stroke;
        if let Some(last) = self.tip {
            let distance = (executed - last).norm();
            if executed.z < 0.0 { self.cut_length += distance } else { self.travel_length += distance }
        }
        self.tip = Some(executed);
        self.surface.move_to(executed);
        self.trace.move_to(executed);
    }

    /// Velocities and accelerations by differences of the demanded positions.
    fn observe_joints(&mut self, record: &ServoRecord<Irp6>) {
        let q = record.demanded;
        if let Some((last, speed)) = self.joints {
            let per_second = (record.time - self.time).recip();
            let velocity = (q - last) * per_second;
            let acceleration = (velocity - speed) * per_second;
            self.velocity = self.velocity.sup(&velocity.abs());
            self.acceleration = self.acceleration.sup(&acceleration.abs());
            self.joints = Some((q, velocity));
        } else {
            self.joints = Some((q, Six::zeros()));
        }
        self.time = record.time;
    }

    /// The largest velocities and accelerations as shares of the limits.
    #[must_use]
    pub fn shares(&self, limits: &Limits<Six>) -> [(f64, f64); 6] {
        core::array::from_fn(|i| {
            (self.velocity[i] / limits.velocity[i], self.acceleration[i] / limits.acceleration[i])
        })
    }
}
