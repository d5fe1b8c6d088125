//! A virtual sensor whose readings must be plausible: what it may read, how fast that may change, and for how long it may
//! stay the same to the bit.
//!
//! In: a sensor's readings, as numbers. Out: the readings, or [`FaultKind::SensorFailed`] with what was met and what is
//! allowed: the Move or Wait that reads it ends with that. A sensor that lies within its bounds is nobody's to find out.

use crate::model::fault::{Fault, FaultKind};
use crate::model::frames::Frames;
use crate::model::image::Sensor;
use crate::model::sensor::{ReadingOrder, Taken, VirtualSensor};

type ReadingOf<V> = <<V as VirtualSensor>::Kind as Sensor>::Reading;
type ConfigurationOf<V> = <<V as VirtualSensor>::Kind as Sensor>::Configuration;

/// A sensor with bounds on what it may read, in the units of its readings.
///
/// ```
/// use mrroc::sensor::Plausible;
/// # use mrroc::prelude::*;
/// # #[derive(Clone, Copy, Payload)] struct Metres { x: f64 }
/// # struct Distance;
/// # impl Sensor for Distance { const KIND: &'static str = "distance"; type Reading = Metres; type Configuration = (); }
/// # struct Laser;
/// # impl VirtualSensor for Laser {
/// #     type Kind = Distance;
/// #     fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Metres, Fault> { Ok(Metres { x: order.step as f64 }) }
/// # }
/// // 0.05 m to 2 m, at most 0.01 m from one step to the next, and never the same for longer than 50 steps.
/// let laser = Plausible::new(Laser, |at| [at.x]).range([0.05], [2.0]).rate([0.01]).stuck_after(50);
/// let setup = SensorSetup::new("laser", laser);
/// ```
pub struct Plausible<V: VirtualSensor, const N: usize> {
    sensor: V,
    numbers: fn(&ReadingOf<V>) -> [f64; N],
    range: Option<([f64; N], [f64; N])>,
    rate: Option<[f64; N]>,
    stuck_after: Option<u64>,
    /// The last reading's step and numbers, and since which step they have been the same.
    last: Option<(u64, [f64; N])>,
    since: u64,
}

impl<V: VirtualSensor, const N: usize> Plausible<V, N> {
    /// Readings of `sensor` as the numbers that are looked at: they must be finite.
    pub fn new(sensor: V, numbers: fn(&ReadingOf<V>) -> [f64; N]) -> Self {
        Plausible { sensor, numbers, range: None, rate: None, stuck_after: None, last: None, since: 0 }
    }

    /// The least and the largest of each number.
    #[must_use]
    pub fn range(mut self, least: [f64; N], largest: [f64; N]) -> Self {
        self.range = Some((least, largest));
        self
    }

    /// By how much each number may change from one step to the next, > 0.
    #[must_use]
    pub fn rate(mut self, per_step: [f64; N]) -> Self {
        self.rate = Some(per_step);
        self
    }

    /// For how many steps all numbers may be the same to the bit: a real sensor has noise.
    #[must_use]
    pub fn stuck_after(mut self, steps: u64) -> Self {
        self.stuck_after = Some(steps);
        self
    }

    fn check(&mut self, step: u64, numbers: &[f64; N]) -> Result<(), Fault> {
        for (i, &x) in numbers.iter().enumerate() {
            let fault = |what: &str, limit: f64| {
                let text = format!("number {} of the reading {what}", i + 1);
                Err(Fault::new(FaultKind::SensorFailed).text(&text).exceeds(x, limit, ""))
            };
            if !x.is_finite() {
                return fault("is not finite", f64::MAX);
            }
            match self.range {
                Some((least, _)) if x < least[i] => return fault("is below its range", least[i]),
                Some((_, largest)) if x > largest[i] => return fault("is above its range", largest[i]),
                Some(_) | None => {}
            }
            if let (Some(rate), Some((before, last))) = (self.rate, self.last) {
                let may = rate[i] * step.saturating_sub(before).max(1) as f64;
                if (x - last[i]).abs() > may {
                    return fault("jumps", last[i] + may.copysign(x - last[i]));
                }
            }
        }
        if self.last.is_none_or(|(_, last)| last.map(f64::to_bits) != numbers.map(f64::to_bits)) {
            self.since = step;
        }
        self.last = Some((step, *numbers));
        let same = step.saturating_sub(self.since);
        match self.stuck_after {
            Some(most) if same > most => {
                let fault = Fault::new(FaultKind::SensorFailed).text("the reading is stuck");
                Err(fault.exceeds(same as f64, most as f64, "step"))
            }
            Some(_) | None => Ok(()),
        }
    }
}

impl<V: VirtualSensor, const N: usize> VirtualSensor for Plausible<V, N> {
    type Kind = V::Kind;

    fn aggregate(&mut self, order: &ReadingOrder<ConfigurationOf<V>>) -> Result<ReadingOf<V>, Fault> {
        let reading = self.sensor.aggregate(order)?;
        self.check(order.step, &(self.numbers)(&reading))?;
        Ok(reading)
    }

    fn is_simulated(&self) -> bool {
        self.sensor.is_simulated()
    }

    fn hardware(&self) -> Option<String> {
        self.sensor.hardware()
    }

    fn open(&mut self) -> Result<(), Fault> {
        self.sensor.open()
    }

    fn taken(&mut self, order: &ReadingOrder<ConfigurationOf<V>>) -> Taken {
        self.sensor.taken(order)
    }

    fn python(&self) -> Option<String> {
        self.sensor.python()
    }

    fn frames(&mut self) -> Option<&mut Frames> {
        self.sensor.frames()
    }
}
