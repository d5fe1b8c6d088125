//! A theodolite as a virtual sensor, `north` and `south`: it turns to what it is told to sight, takes its time, and reads one face.

use mrroc::prelude::*;

use crate::drives::Shared;
use crate::scene::{ARMS, BARS};
use crate::theodolite::Face;

/// The kind of sensor.
pub struct Sighting;

impl Sensor for Sighting {
    const KIND: &'static str = "theodolite";
    type Reading = Angles;
    type Configuration = Sight;
}

/// What a theodolite is told to sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Payload)]
pub enum Sight {
    /// Nothing.
    #[default]
    Nothing,
    /// A ball on the flange of an arm.
    Ball {
        /// Which arm.
        arm: u32,
        /// Which ball.
        ball: u32,
        /// Even: the first face, odd: the second; by two more of them in each set.
        face: u32,
    },
    /// The other theodolite.
    Other {
        /// Even: the first face, odd: the second; by two more of them in each set.
        face: u32,
    },
    /// An end of the scale bar in one of its places.
    End {
        /// Which place.
        bar: u32,
        /// Which end.
        end: u32,
        /// Even: the first face, odd: the second; by two more of them in each set.
        face: u32,
    },
}

/// What it reads.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Angles {
    /// Horizontal angle \[rad\].
    pub hz: f64,
    /// Elevation \[rad\].
    pub v: f64,
    /// The target is sighted, and the reading is one of it.
    pub settled: bool,
    /// A link is in the line of sight.
    pub blocked: bool,
}

/// A simulated theodolite.
pub struct Simulated {
    which: usize,
    shared: Shared,
    /// Steps from an order to its reading.
    pointing: u64,
    sighted: Option<(Sight, u64, Option<[f64; 2]>)>,
}

impl Simulated {
    /// Theodolite `which` of the scene, which takes so many steps to turn to a target and to sight it.
    #[must_use]
    pub fn new(which: usize, shared: Shared, pointing: u64) -> Self {
        Self { which, shared, pointing, sighted: None }
    }
}

impl VirtualSensor for Simulated {
    type Kind = Sighting;

    fn aggregate(&mut self, order: &ReadingOrder<Sight>) -> Result<Angles, Fault> {
        let nothing = Angles { hz: 0.0, v: 0.0, settled: false, blocked: false };
        let wanted = order.configuration;
        if self.sighted.is_none_or(|(sight, ..)| sight != wanted) {
            self.sighted = Some((wanted, order.step, None));
        }
        let mut scene = self.shared.scene.borrow_mut();
        let joints = *self.shared.joints.borrow();
        let (point, face) = match wanted {
            Sight::Nothing => return Ok(nothing),
            Sight::Ball { arm, ball, face } => {
                let arm = arm as usize % ARMS;
                (scene.ball(arm, ball as usize % 3, &joints[arm]), face)
            }
            Sight::End { bar, end, face } => (scene.ends[bar as usize % BARS][end as usize % 2], face),
            Sight::Other { face } => (scene.theodolites[1 - self.which].place.translation.vector, face),
        };
        let Some((_, since, read)) = &mut self.sighted else { return Ok(nothing) };
        if order.step < *since + self.pointing {
            return Ok(nothing);
        }
        if read.is_none() {
            if matches!(wanted, Sight::Ball { .. }) && !scene.sees(self.which, &point, &joints) {
                return Ok(Angles { settled: true, blocked: true, ..nothing });
            }
            let face = if face % 2 == 0 { Face::One } else { Face::Two };
            *read = Some(scene.theodolites[self.which].sight(&point, face));
        }
        let [hz, v] = read.unwrap_or_default();
        Ok(Angles { hz, v, settled: true, blocked: false })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
