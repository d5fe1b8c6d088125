//! What a sensor over a belt says of the parts that come, whatever it is.

use std::collections::VecDeque;

use mrroc::prelude::*;

/// The kind of sensor: one that tells which parts come on a belt. Programs that ask for it do not mind by what it sees or hears them.
#[derive(Clone, Copy, Debug)]
pub struct PartSensor;

impl Sensor for PartSensor {
    const KIND: &'static str = "parts on a belt";
    type Reading = Spotted;
    type Configuration = ();
}

/// A part on a belt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct OnBelt {
    /// Its number, from 1 on; parts are counted as they are found.
    pub number: u32,
    /// Its class, by its place in the list of classes.
    pub class: u32,
    /// How likely that is, 0 to 1.
    pub score: f64,
    /// Where its frame is on the belt, which it goes with: along the belt where that had run 0 ..
    pub along: f64,
    /// .. and across it \[m\].
    pub across: f64,
    /// Its angle about z \[rad\].
    pub angle: f64,
}

/// What is said of the newest parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Spotted {
    /// Images that have been evaluated, without that of the empty belt.
    pub images: u32,
    /// Things that were no known parts.
    pub unknown: u32,
    /// Parts that have been found.
    pub parts: u32,
    /// How far the belt has run at the step of the reading \[m\].
    pub travel: f64,
    /// How fast it is [m/s].
    pub speed: f64,
    /// The newest parts, the latest first; number 0 where there are fewer.
    pub newest: [OnBelt; 6],
}

/// Parts that have been found, and are not in readings yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Pending(VecDeque<(f64, OnBelt)>);

impl Pending {
    /// A part that is in readings from a time on \[s\].
    pub fn push(&mut self, from: f64, part: OnBelt) {
        self.0.push_back((from, part));
    }

    /// Puts those into a reading that are in it by now.
    pub fn tell(&mut self, now: f64, reading: &mut Spotted) {
        while let Some((_, part)) = self.0.pop_front_if(|(from, _)| now >= *from) {
            reading.newest.rotate_right(1);
            reading.newest[0] = part;
            reading.parts = part.number;
        }
    }
}
