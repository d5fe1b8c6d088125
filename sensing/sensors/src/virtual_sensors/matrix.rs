//! An ultrasonic matrix over a belt: which parts pass below it, and where they are in the belt's own frame.
//!
//! ```text
//! ping every 5 ms -> echo, and the travel of the belt by its encoder -> relief -- strip of bare belt behind it, 60 ms --> in the readings
//! ```
//!
//! Each ping has a place on the belt of its own, so that a belt that runs unevenly, or stops below the matrix, makes the relief neither longer nor
//! shorter. Pings go on whether somebody asks or not; what is due is made up for when somebody does.

use mrroc::prelude::*;

use super::parts::{OnBelt, PartSensor, Pending, Spotted};
use crate::aggregation::{HeardObject, Hearing, Relief, Reliefs};
use crate::physics::Sounders;
use crate::ultrasound::Echo;
use crate::view::View;

/// A listener to what the sensor sees.
pub trait Listener {
    /// A transducer of this number has pinged at a time \[s\].
    fn pinged(&mut self, number: usize, time: f64, echo: Option<Echo>, sounders: &Sounders);

    /// A thing was evaluated.
    fn evaluated(&mut self, relief: &Relief, heard: &HeardObject);
}

/// A matrix over a scene.
pub struct MatrixSensor<S> {
    scene: S,
    sounders: Sounders,
    reliefs: Reliefs,
    hearing: Hearing,
    /// How old the state of the belt is that goes with an order \[s\].
    latch: f64,
    /// Pings that were made.
    pings: u64,
    processed: Pending,
    found: u32,
    reading: Spotted,
    listener: Option<Box<dyn Listener>>,
}

impl<S> core::fmt::Debug for MatrixSensor<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("MatrixSensor").field("reading", &self.reading).finish_non_exhaustive()
    }
}

impl<S: View + 'static> MatrixSensor<S> {
    /// From when a thing has passed until it is in readings \[s\].
    pub const PROCESSING: f64 = 0.06;
    /// Of pings that are due, so many at most are made up for after a pause.
    const KEPT: u64 = 20;

    /// What `sounders` hear of a scene is evaluated by `hearing`; `latch` \[s\] is how old the state of the belt is that goes with an order.
    #[must_use]
    pub fn new(scene: S, sounders: Sounders, reliefs: Reliefs, hearing: Hearing, latch: f64) -> Self {
        let (processed, reading) = (Pending::default(), Spotted::default());
        Self {
            scene,
            sounders,
            reliefs,
            hearing,
            latch,
            pings: 0,
            processed,
            found: 0,
            reading,
            listener: None,
        }
    }

    /// The same, with a listener.
    #[must_use]
    pub fn watched(self, listener: Box<dyn Listener>) -> Self {
        Self { listener: Some(listener), ..self }
    }

    /// The transducers, to break them.
    pub const fn sounders(&mut self) -> &mut Sounders {
        &mut self.sounders
    }

    fn evaluate(&mut self, relief: &Relief, now: f64) {
        let heard = self.hearing.evaluate(relief);
        self.reading.images += 1;
        match heard.class {
            Some(class) => {
                self.found += 1;
                let part = OnBelt {
                    number: self.found,
                    class: class as u32,
                    score: heard.score,
                    along: heard.place.x,
                    across: heard.place.y,
                    angle: heard.angle,
                };
                self.processed.push(now + Self::PROCESSING, part);
            }
            None => self.reading.unknown += 1,
        }
        if let Some(listener) = &mut self.listener {
            listener.evaluated(relief, &heard);
        }
    }
}

impl<S: View + 'static> VirtualSensor for MatrixSensor<S> {
    type Kind = PartSensor;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Spotted, Fault> {
        let belt = order.robot.ok_or_else(|| {
            Fault::thrown("a matrix hears parts on a belt: write of = \"BELT\" in its table of cell.toml")
        })?;
        let now = self.scene.now();
        let speed = belt.velocity[0];
        let run = belt.joints[0] + speed * self.latch;
        let period = self.reliefs.array().period;
        let due = (now / period + 1e-6) as u64;
        self.pings = self.pings.max(due.saturating_sub(Self::KEPT));
        while self.pings < due {
            self.pings += 1;
            let time = self.pings as f64 * period;
            let number = self.reliefs.array().turn(self.pings);
            let echo = self.sounders.ping(&self.scene, number, time);
            let deaf = self.reliefs.take(number, echo, run + speed * (time - now));
            deaf.map_err(|deaf| Fault::thrown(&deaf.to_string()))?;
            if let Some(listener) = &mut self.listener {
                listener.pinged(number, time, echo, &self.sounders);
            }
        }
        while let Some(relief) = self.reliefs.passed(run) {
            self.evaluate(&relief, now);
        }
        (self.reading.travel, self.reading.speed) = (run, speed);
        self.processed.tell(now, &mut self.reading);
        Ok(self.reading)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
