//! Straight on until a sensor says so: a guarded motion.

use core::marker::PhantomData;

use mrroc::{Demand, Fault, Pose, Reading, Robot, Sensor, State, Step, Tick, generator};
use nalgebra::{Translation3, Unit, Vector3};

/// Moves the tool along a direction at a steady speed until a reading tells of contact.
///
/// Ends in the step after the contact; the runtime brings the tool to a standstill. Throws a fault when there is
/// no contact within the way that it was given.
pub struct GuardedApproach<R, S: Sensor> {
    direction: Unit<Vector3<f64>>,
    speed: f64,
    acceleration: f64,
    way: f64,
    contact: fn(&S::Reading) -> bool,
    start: Pose,
    travelled: f64,
    rate: f64,
    of: PhantomData<(R, S)>,
}

impl<R: Robot, S: Sensor> GuardedApproach<R, S> {
    /// Along `direction` in the world at `speed` [m/s], reached by `acceleration` [m/s²], for at most `way`
    /// \[m\], until `contact` holds for a reading. All > 0.
    #[must_use]
    pub fn along(
        direction: Unit<Vector3<f64>>,
        speed: f64,
        acceleration: f64,
        way: f64,
        contact: fn(&S::Reading) -> bool,
    ) -> Self {
        let (start, travelled, rate) = (Pose::identity(), 0.0, 0.0);
        GuardedApproach {
            direction,
            speed,
            acceleration,
            way,
            contact,
            start,
            travelled,
            rate,
            of: PhantomData,
        }
    }

    fn advance(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        if v.0.reading().as_ref().is_some_and(self.contact) {
            return Ok(Step::Done);
        }
        self.rate = (self.rate + self.acceleration * t.dt).min(self.speed);
        self.travelled += self.rate * t.dt;
        if self.travelled > self.way {
            return Err(Fault::thrown("no contact on the whole way of a guarded approach"));
        }
        let moved = Translation3::from(self.direction.into_inner() * self.travelled);
        Ok(Step::Next(Demand::pose(moved * self.start)))
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor> GuardedApproach<R, S> {
    fn first_step(&mut self, e: &State<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        self.start = e.demanded().pose;
        self.advance(v, t)
    }

    fn next_step(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        self.advance(v, t)
    }
}
