//! A virtual sensor that fails; the kinds of failure have the names of PX4's failure injection.

use std::collections::VecDeque;

use super::random::Random;
use mrroc_core::fault::{Fault, FaultKind};
use mrroc_core::payload::{WORDS, Wire};
use mrroc_core::sensor::Sensor;
use mrroc_core::sensor::{ReadingOrder, VirtualSensor};

type ReadingOf<V> = <<V as VirtualSensor>::Kind as Sensor>::Reading;
type ConfigurationOf<V> = <<V as VirtualSensor>::Kind as Sensor>::Configuration;

/// How a sensor that reads a `T` fails.
#[derive(Clone, Copy, Debug)]
pub enum SensorFault<T> {
    /// The sensor works.
    Ok,
    /// The sensor gives no reading: [`FaultKind::SensorFailed`].
    Off,
    /// The sensor repeats its last reading.
    Stuck,
    /// The reading consists of random bits; if they are no valid reading, it is [`FaultKind::SensorFailed`].
    Garbage,
    /// The reading is altered by this function.
    Wrong(fn(T) -> T),
    /// The sensor reads anew once in so many steps, at least 1, and repeats the reading between them.
    Slow(u32),
    /// The sensor gives the reading of so many readings before.
    Delayed(u32),
    /// The sensor is off at random, half of the time.
    Intermittent,
}

/// A sensor that fails from some step on, for some steps.
///
/// ```
/// use mrroc::testing::{FaultySensor, SensorFault};
/// # use mrroc::prelude::*;
/// # #[derive(Clone, Copy, Payload)] struct Metres { x: f64 }
/// # struct Distance;
/// # impl Sensor for Distance { const KIND: &'static str = "distance"; type Reading = Metres; type Configuration = (); }
/// # struct Laser;
/// # impl VirtualSensor for Laser {
/// #     type Kind = Distance;
/// #     fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Metres, Fault> { Ok(Metres { x: order.step as f64 }) }
/// # }
/// let laser = FaultySensor::new(Laser, SensorFault::Wrong(|at| Metres { x: at.x + 0.1 }), 500, 20);
/// let setup = SensorSetup::new("laser", laser);
/// ```
pub struct FaultySensor<V: VirtualSensor> {
    sensor: V,
    fault: SensorFault<ReadingOf<V>>,
    from: u64,
    steps: u64,
    random: Random,
    last: Option<ReadingOf<V>>,
    past: VecDeque<ReadingOf<V>>,
}

impl<V: VirtualSensor> FaultySensor<V> {
    /// Lets `sensor` fail in step `from` and in the `steps - 1` steps after it.
    pub fn new(sensor: V, fault: SensorFault<ReadingOf<V>>, from: u64, steps: u64) -> Self {
        let (random, last, past) = (Random::new(from), None, VecDeque::new());
        FaultySensor { sensor, fault, from, steps, random, last, past }
    }

    /// Sets the seed of what is random; without it the step is the seed.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.random = Random::new(seed);
        self
    }

    fn garbage(&mut self) -> Result<ReadingOf<V>, Fault> {
        let mut words = [0; WORDS];
        words.fill_with(|| self.random.next());
        ReadingOf::<V>::get(&words).map_err(|_| failed("garbage"))
    }

    fn fail(&mut self, step: u64, reading: ReadingOf<V>) -> Result<ReadingOf<V>, Fault> {
        match self.fault {
            SensorFault::Ok => Ok(reading),
            SensorFault::Off => Err(failed("off")),
            SensorFault::Stuck => Ok(self.last.unwrap_or(reading)),
            SensorFault::Garbage => self.garbage(),
            SensorFault::Wrong(wrong) => Ok(wrong(reading)),
            SensorFault::Slow(every) if (step - self.from).is_multiple_of(u64::from(every.max(1))) => {
                Ok(reading)
            }
            SensorFault::Slow(_) => Ok(self.last.unwrap_or(reading)),
            SensorFault::Delayed(_) => Ok(self.past.front().copied().unwrap_or(reading)),
            SensorFault::Intermittent if self.random.below(2) == 0 => Err(failed("off")),
            SensorFault::Intermittent => Ok(reading),
        }
    }
}

fn failed(text: &str) -> Fault {
    Fault::new(FaultKind::SensorFailed).text(text)
}

impl<V: VirtualSensor> VirtualSensor for FaultySensor<V> {
    type Kind = V::Kind;

    fn aggregate(&mut self, order: &ReadingOrder<ConfigurationOf<V>>) -> Result<ReadingOf<V>, Fault> {
        let reading = self.sensor.aggregate(order)?;
        if let SensorFault::Delayed(readings) = self.fault {
            self.past.push_back(reading);
            while self.past.len() > readings as usize + 1 {
                self.past.pop_front();
            }
        }
        let fails = (self.from..self.from.saturating_add(self.steps)).contains(&order.step);
        let reading = if fails { self.fail(order.step, reading)? } else { reading };
        self.last = Some(reading);
        Ok(reading)
    }
}
