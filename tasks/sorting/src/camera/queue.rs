//! The coordinator's queue of parts: those that the camera has seen, in the order in which they come.

use core::cell::Cell;
use core::f64::consts::PI;
use std::collections::VecDeque;
use std::rc::Rc;

use mrroc::generator::{Class, Condition, Generator, Level, Uses};
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use mrroc_sensors::virtual_sensors::{OnBelt, PartSensor, Spotted};

use super::count::Count;
use super::kinds::{KINDS, kinds};
use super::layout::{FIRST, LAST};
use super::orders::{Place, Task};
use crate::mp::{Arm, Failed, is_closed, is_empty};
use crate::places::OPEN;

/// What the coordinator knows of parts.
#[derive(Clone, Debug)]
pub struct Queue {
    pub(super) waiting: VecDeque<OnBelt>,
    /// Number of the newest part that has been taken in.
    newest: u32,
    pub(super) seen: Spotted,
    count: Count,
    /// So many are to come; and for how long none may \[s\].
    parts: u32,
    timeout: f64,
    quiet: f64,
    /// The last arm goes down onto parts up to here, along s \[m\].
    last: f64,
    grips: Rc<[f64]>,
    /// Parts that went by, because the arm was busy: their numbers.
    pub late: Vec<u32>,
    /// Openings of the hand that the MP tells what to do, demanded and measured \[m\].
    openings: [f64; 2],
}

impl Queue {
    /// The arm sets out for a part so long before that comes into its reach \[s\] ..
    pub(super) const AHEAD: f64 = 2.5;
    /// .. and gets to it at most so long after it has set out, with the hand closed \[s\].
    pub const REACHING: f64 = 4.5;

    /// Of so many parts to come; it ends where none has come for `timeout` \[s\].
    #[must_use]
    pub fn of(parts: u32, timeout: f64) -> Self {
        let grips = kinds().iter().map(|kind| kind.grip).collect();
        let (waiting, seen, count) = (VecDeque::new(), Spotted::default(), Count::default());
        Self {
            waiting,
            newest: 0,
            seen,
            count,
            parts,
            timeout,
            quiet: 0.0,
            last: LAST,
            grips,
            late: Vec::new(),
            openings: [OPEN; 2],
        }
    }

    /// The same where the last arm goes down up to another place, along s \[m\].
    #[must_use]
    pub fn up_to(self, last: f64) -> Self {
        Self { last, ..self }
    }

    /// Takes in what the camera says.
    ///
    /// # Errors
    /// The belt's count cannot be true.
    pub(super) fn take(&mut self, image: &SensorImage<PartSensor>, dt: f64) -> Result<(), Fault> {
        let seen = &image.reading().unwrap_or_default();
        if image.reading().is_some() {
            self.count.take(seen.travel, seen.speed, dt)?;
        }
        self.quiet += dt;
        for part in seen.newest.iter().rev().filter(|part| part.number > self.newest) {
            self.waiting.push_back(*part);
            self.quiet = 0.0;
        }
        self.newest = self.newest.max(seen.parts);
        self.seen = *seen;
        // Belts may carry parts past each other only as fast as they run: none.
        let last = self.last - Self::REACHING * seen.speed.max(0.0);
        while let Some(part) = self.waiting.front().filter(|part| part.along + seen.travel > last) {
            self.late.push(part.number);
            self.waiting.pop_front();
        }
        Ok(())
    }

    /// Whether a part is to be taken now, or no more come.
    fn is_ready(&self) -> bool {
        let ahead = FIRST - Self::AHEAD * self.seen.speed.max(0.0);
        let near = self.waiting.front().is_some_and(|part| part.along + self.seen.travel > ahead);
        near || self.is_over()
    }

    /// Whether no more come, and none waits that could be taken.
    pub(super) fn is_over(&self) -> bool {
        let all = self.seen.parts + self.seen.unknown >= self.parts && self.waiting.is_empty();
        // A belt that stands brings nothing, even if a part waits on it.
        all || self.quiet > self.timeout
    }

    /// Counts the pick that is over, if the hand has closed in it.
    ///
    /// # Errors
    /// It closed on nothing, as often in a row as the cell stops for.
    pub fn count_pick(&self, failed: &Cell<Failed>) -> Result<(), Fault> {
        let [demanded, measured] = self.openings;
        if is_closed(demanded) { Failed::count(failed, is_empty(demanded, measured)) } else { Ok(()) }
    }

    /// The task to take the next part; `None` when no more come.
    pub fn pick(&mut self) -> Option<Task> {
        if self.quiet > self.timeout {
            return None;
        }
        let part = self.waiting.pop_front()?;
        Some(self.order(&part))
    }

    /// The task to take a part.
    pub(super) fn order(&self, part: &OnBelt) -> Task {
        let OnBelt { number, class, along, across, angle, .. } = *part;
        let turned = angle + self.grips.get(class as usize).copied().unwrap_or_default();
        // Fingers do not mind half a turn, and between 0 and a half the wrist can follow all along the belt; y of the belt's frame is against x of the world.
        let place = Place { along, across: -across, yaw: turned.rem_euclid(PI) };
        Task::Pick { part: number, place, bin: class % KINDS as u32 }
    }
}

/// A Wait for a part that is to be taken now, or for the end.
pub struct Ready(pub Queue);

// By hand, as `Tell`: the queue goes on in every step, whatever the coordinator is about.
impl Condition for Ready {
    type Robots = Arm;
    type Sensors = (PartSensor,);
    type Order = ();
    const CLASS: Class =
        Class::new(Level::Mp, Uses { state: true, sensors: true, tick: true, ..Uses::NOTHING });

    fn is_met(
        &mut self,
        _: &Order<()>,
        _: &State<Arm>,
        v: &Reading<(PartSensor,)>,
        t: Tick,
    ) -> Result<bool, Fault> {
        self.0.take(&v.0, t.duration)?;
        Ok(self.0.is_ready())
    }
}

/// Tells arm and hand a task, and goes on taking in parts.
pub struct Tell(pub Task, pub Queue);

impl Generator for Tell {
    type Robots = Arm;
    type Language = Task;
    type Sensors = (PartSensor,);
    type Order = ();
    const CLASS: Class =
        Class::new(Level::Mp, Uses { state: true, robots: true, sensors: true, tick: true, ..Uses::NOTHING });
    const ENDS: bool = false;

    fn first_step(
        &mut self,
        c0: &Order<()>,
        e: &State<Arm>,
        v: &Reading<(PartSensor,)>,
        t: Tick,
    ) -> Result<Step<Arm, Task>, Fault> {
        self.next_step(c0, e, v, t)
    }

    fn next_step(
        &mut self,
        _: &Order<()>,
        e: &State<Arm>,
        v: &Reading<(PartSensor,)>,
        t: Tick,
    ) -> Result<Step<Arm, Task>, Fault> {
        self.1.take(&v.0, t.duration)?;
        self.1.openings = [e.1.demanded().joints[0], e.1.measured().joints[0]];
        Ok(Step::Next((self.0, self.0)))
    }
}
