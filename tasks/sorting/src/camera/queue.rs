//! The coordinator's queue of parts: those that the camera has seen, in the order in which they come.

use core::cell::Cell;
use core::f64::consts::PI;
use std::collections::VecDeque;
use std::rc::Rc;

use mrroc::generator::{Class, Condition, Generator, Level, Uses};
use mrroc::prelude::*;
use mrroc::robot::RobotImage;
use mrroc::sensor::SensorImage;
use mrroc_robots::{Irp6, TwoFingers};
use mrroc_sensors::virtual_sensors::{OnBelt, PartSensor, Spotted};

use super::carry::{along, is_over_belt};
use super::count::Count;
use super::gap::Things;
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
    /// What is on the belt, besides parts that a hand has.
    pub(super) things: Things,
    /// The part that was to be taken last.
    number: u32,
    /// The arm and the hand that the MP tells what to do.
    arm: Held,
    /// For how long a part has waited in the hand for a gap \[s\].
    waited: f64,
}

/// What an arm has, as far as its coordinator sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    /// Openings of the hand, demanded and measured \[m\].
    pub openings: [f64; 2],
    /// Where the tool is along the belt, if it is over the belt \[m\].
    pub over_belt: Option<f64>,
}

impl Held {
    /// Nothing is known yet.
    pub const NOTHING: Self = Self { openings: [OPEN; 2], over_belt: None };

    pub fn of(arm: &RobotImage<Irp6>, hand: &RobotImage<TwoFingers>) -> Self {
        let pose = &arm.demanded().pose;
        Self {
            openings: [hand.demanded(), hand.measured()].map(|state| state.joints[0]),
            over_belt: is_over_belt(pose).then(|| along(pose)),
        }
    }

    /// Where the tool is along the belt with a part that the arm cannot bring to its bin \[m\]; `None` where it has none, or is over a bin.
    pub fn stranded(&self) -> Option<f64> {
        let [demanded, measured] = self.openings;
        self.over_belt.filter(|_| is_closed(demanded) && !is_empty(demanded, measured))
    }
}

impl Queue {
    /// The arm sets out for a part so long before that comes into its reach \[s\] ..
    pub(super) const AHEAD: f64 = 2.5;
    /// .. and gets to it at most so long after it has set out, with the hand closed \[s\].
    pub const REACHING: f64 = 4.5;
    /// A gap to put a part back into comes within this time, or the cell stops \[s\].
    pub const WAITING: f64 = 120.0;

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
            things: Things::default(),
            number: 0,
            arm: Held::NOTHING,
            waited: 0.0,
        }
    }

    /// The same on a belt that may run so fast [m/s].
    #[must_use]
    pub fn on_belt(self, fastest: f64) -> Self {
        Self { things: Things::on_belt(fastest), ..self }
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
        self.things.take(seen, self.newest, self.last + 2.0 * Things::APART);
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
    pub fn count_pick(&mut self, failed: &Cell<Failed>) -> Result<(), Fault> {
        let [demanded, measured] = self.arm.openings;
        if !is_closed(demanded) {
            return Ok(());
        }
        self.count_grip(self.number, is_empty(demanded, measured), failed)
    }

    /// Counts a hand that has closed for a part.
    ///
    /// # Errors
    /// It closed on nothing, as often in a row as the cell stops for.
    pub(super) fn count_grip(
        &mut self,
        part: u32,
        has_failed: bool,
        failed: &Cell<Failed>,
    ) -> Result<(), Fault> {
        // A part that the hand did not get may still lie there.
        if !has_failed {
            self.things.lift(part);
        }
        Failed::count(failed, has_failed)
    }

    /// Whether the hand has a part that the arm cannot bring to its bin.
    #[must_use]
    pub fn is_stranded(&self) -> bool {
        self.arm.stranded().is_some()
    }

    /// Whether the belt has a gap now where an arm has waited for it so long \[s\], at a place along s \[m\].
    ///
    /// # Errors
    /// None came for too long.
    pub(super) fn has_gap(&self, s: f64, waited: f64) -> Result<bool, Fault> {
        if waited > Self::WAITING {
            return Err(Fault::thrown(
                "an arm holds a part that it cannot bring to its bin, and no gap of the belt came to put it back: take it out of the hand",
            ));
        }
        Ok(self.things.is_clear(s, &self.seen))
    }

    /// The task to take the next part; `None` when no more come.
    pub fn pick(&mut self) -> Option<Task> {
        if self.quiet > self.timeout {
            return None;
        }
        let part = self.waiting.pop_front()?;
        self.number = part.number;
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

/// What a Wait that goes on taking in parts uses: by hand, as `Tell`, since the queue goes on in every step, whatever the coordinator is about.
const WAIT: Class = Class::new(Level::Mp, Uses { state: true, sensors: true, tick: true, ..Uses::NOTHING });

/// A Wait for a part that is to be taken now, or for the end.
pub struct Ready(pub Queue);

impl Condition for Ready {
    type Robots = Arm;
    type Sensors = (PartSensor,);
    type Order = ();
    const CLASS: Class = WAIT;

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

/// A Wait for a gap of the belt below the part that the arm holds.
pub struct Gap(pub Queue);

impl Condition for Gap {
    type Robots = Arm;
    type Sensors = (PartSensor,);
    type Order = ();
    const CLASS: Class = WAIT;

    fn is_met(
        &mut self,
        _: &Order<()>,
        _: &State<Arm>,
        v: &Reading<(PartSensor,)>,
        t: Tick,
    ) -> Result<bool, Fault> {
        let queue = &mut self.0;
        queue.take(&v.0, t.duration)?;
        let Some(s) = queue.arm.stranded() else { return Ok(true) };
        queue.waited += t.duration;
        let has_gap = queue.has_gap(s, queue.waited)?;
        if has_gap {
            queue.waited = 0.0;
            queue.things.put_back(queue.number, s, &queue.seen);
        }
        Ok(has_gap)
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
        self.1.arm = Held::of(&e.0, &e.1);
        Ok(Step::Next((self.0, self.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_341_a_part_for_which_no_gap_of_the_belt_comes_is_a_named_fault() {
        let mut queue = Queue::of(2, 10.0);
        assert_eq!(queue.has_gap(0.5, 0.0), Ok(true));
        // One lies below on a belt that stands.
        queue.things.put_back(1, 0.5, &Spotted::default());
        assert_eq!(queue.has_gap(0.5, Queue::WAITING), Ok(false));
        let fault = queue.has_gap(0.5, Queue::WAITING + 4e-3).expect_err("too long").to_string();
        assert!(
            fault.contains("no gap of the belt came") && fault.contains("take it out of the hand"),
            "{fault}"
        );
    }

    #[test]
    fn a_hand_that_presses_on_a_part_over_the_belt_holds_one_that_cannot_go_to_its_bin() {
        let held = |openings: [f64; 2], over_belt| Held { openings, over_belt }.stranded();
        // Fingers that are to close to 40 mm, and a part of 50 mm between them.
        assert_eq!(held([0.04, 0.05], Some(0.3)), Some(0.3));
        assert_eq!(held([0.04, 0.05], None), None, "over its bin");
        assert_eq!(held([0.04, 0.04], Some(0.3)), None, "nothing between the fingers");
        assert_eq!(held([0.08, 0.08], Some(0.3)), None, "the hand is open");
    }
}
