//! Two arms share the belt: the coordinator's program, and what it knows of arms beside the queue of parts.

use core::cell::Cell;

use mrroc::generator::{Class, Condition, Level, Uses};
use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_robots::{Conveyor, Irp6, TwoFingers};
use mrroc_sensors::virtual_sensors::{OnBelt, PartSensor};

use super::assignment::{Free, Times, Waiting, assign, over};
use super::gap::Things;
use super::layout::{FIRST, LAST, STATIONS};
use super::orders::Task;
use super::queue::{Held, Queue};
use super::settings::Settings;
use crate::generators::Uneven;
use crate::mp::{Arm, Failed, is_closed, is_empty};

/// How many arms.
pub const ARMS: usize = STATIONS.len();

/// Sorts what the belt brings by two arms, as long as more comes; `eye` is the sensor that tells of parts. Each arm works in the background by
/// loose orders, while the coordinator goes on taking in parts. Counts in `failed` the picks in which the hand of an arm closed on nothing.
///
/// # Errors
/// The first fault of the cell; three picks of an arm in a row that failed; no gap came for a part that is to be put back.
pub fn coordinate(
    mp: &mut Mp,
    eye: &str,
    drive: Uneven,
    mut shared: Shared,
    failed: &[Cell<Failed>; ARMS],
) -> Result<Shared, Fault> {
    let names = STATIONS.map(|station| station.robots);
    let mut arms = [mp.robot::<Irp6>(names[0][0])?, mp.robot::<Irp6>(names[1][0])?];
    let mut hands = [mp.robot::<TwoFingers>(names[0][1])?, mp.robot::<TwoFingers>(names[1][1])?];
    let (mut belt, mut parts) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<PartSensor>(eye)?);
    mp.start_robot(&mut belt, drive)?;
    loop {
        let ([arm, arm_2], [hand, hand_2]) = (&mut arms, &mut hands);
        shared = mp.wait_until((arm, arm_2, hand, hand_2), (&mut parts,), Turn::of(shared))?.shared;
        for (number, (arm, hand)) in arms.iter_mut().zip(&mut hands).enumerate() {
            if !mp.is_in_background(arm)
                && let Some(task) = shared.next(number, &failed[number])?
            {
                mp.start_robots((arm, hand), ConstantOrder::<Arm, Task>::to_all(task))?;
            }
        }
        if shared.is_over() {
            return mp.end_robot(&mut belt).map(|()| shared);
        }
    }
}

/// What an arm and its hand are about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum About {
    /// The program has just begun: where the arm is nobody knows.
    Nowhere,
    /// Nothing.
    Idle,
    /// Taking this part.
    Taking(OnBelt),
    /// Holding a part that it cannot bring to its bin, by its number, since a time \[s of path time\]: it waits for a gap of the belt.
    Holding(u32, f64),
    /// Putting it back there.
    PuttingBack,
    /// Letting it go.
    Releasing,
}

/// What the coordinator of two arms knows.
#[derive(Clone, Debug)]
pub struct Shared {
    queue: Queue,
    about: [About; ARMS],
    /// Until when the arms are busy, about, and what time it is \[s of path time\].
    busy: [f64; ARMS],
    now: f64,
    held: [Held; ARMS],
    /// Parts that an arm did not find between its fingers: their numbers, and which arm.
    pub vain: Vec<(u32, usize)>,
}

impl Shared {
    /// Letting go takes so long \[s\].
    const RELEASING: f64 = 0.7;
    const TIMES: Times = Times {
        cycle: Settings::CYCLE,
        reaching: Queue::REACHING,
        carrying: Settings::CYCLE - Queue::REACHING,
    };

    /// Of so many parts to come; it ends where none has come for `timeout` \[s\].
    #[must_use]
    pub fn of(parts: u32, timeout: f64) -> Self {
        Self {
            queue: Queue::of(parts, timeout).up_to(LAST + STATIONS[ARMS - 1].along),
            about: [About::Nowhere; ARMS],
            busy: [0.0; ARMS],
            now: 0.0,
            held: [Held::NOTHING; ARMS],
            vain: Vec::new(),
        }
    }

    /// The same on a belt that may run so fast [m/s].
    #[must_use]
    pub fn on_belt(self, fastest: f64) -> Self {
        Self { queue: self.queue.on_belt(fastest), ..self }
    }

    /// Parts that went by because both arms were busy: their numbers.
    #[must_use]
    pub fn late(&self) -> Vec<u32> {
        let late = self.queue.late.iter().filter(|part| !self.vain.iter().any(|(vain, _)| vain == *part));
        late.copied().collect()
    }

    /// Whether no more come, and the arms have nothing to do.
    fn is_over(&self) -> bool {
        self.queue.is_over() && self.about.iter().all(|about| *about == About::Idle)
    }

    /// What an arm that has done what it was told is to do next; `None` while that is nothing. Counts in `failed` whether its hand has
    /// closed on nothing.
    ///
    /// # Errors
    /// It has, as often in a row as the cell stops for.
    fn next(&mut self, arm: usize, failed: &Cell<Failed>) -> Result<Option<Task>, Fault> {
        let [demanded, measured] = self.held[arm].openings;
        match self.about[arm] {
            About::Nowhere => {
                self.about[arm] = About::Releasing;
                return Ok(Some(Task::Return));
            }
            About::Taking(part) if is_closed(demanded) => {
                self.queue.count_grip(part.number, is_empty(demanded, measured), failed)?;
                if self.held[arm].stranded().is_some() {
                    self.about[arm] = About::Holding(part.number, self.now);
                    return self.put_back(arm, part.number, 0.0);
                }
                return Ok(Some(self.release(arm)));
            }
            About::Holding(number, since) => return self.put_back(arm, number, self.now - since),
            About::PuttingBack => return Ok(Some(self.release(arm))),
            About::Taking(part) => {
                // Not between the fingers: the other arm may find it.
                self.vain.push((part.number, arm));
                let ahead = |other: &OnBelt| other.along > part.along;
                let place = self.queue.waiting.iter().filter(|other| ahead(other)).count();
                self.queue.waiting.insert(place, part);
                self.about[arm] = About::Idle;
            }
            About::Idle | About::Releasing => self.about[arm] = About::Idle,
        }
        Ok(self.pick(arm))
    }

    fn release(&mut self, arm: usize) -> Task {
        self.about[arm] = About::Releasing;
        self.busy[arm] = self.now + Self::RELEASING;
        Task::Release
    }

    /// Has an arm put back a part that it has held so long \[s\], once the belt has a gap there.
    fn put_back(&mut self, arm: usize, number: u32, waited: f64) -> Result<Option<Task>, Fault> {
        self.busy[arm] = self.now + Things::CLEAR;
        let Some(s) = self.held[arm].stranded() else { return Ok(Some(self.release(arm))) };
        if !self.queue.has_gap(s, waited)? {
            return Ok(None);
        }
        let seen = self.queue.seen;
        self.queue.things.put_back(number, s, &seen);
        self.about[arm] = About::PuttingBack;
        Ok(Some(Task::PutBack))
    }

    /// The part that an idle arm is to set out for now.
    fn pick(&mut self, arm: usize) -> Option<Task> {
        let (seen, vain) = (self.queue.seen, &self.vain);
        let speed = seen.speed.max(0.0);
        let waiting = |part: &OnBelt| Waiting {
            at: part.along + seen.travel,
            tried: core::array::from_fn(|arm| vain.contains(&(part.number, arm))),
        };
        let parts: Vec<_> = self.queue.waiting.iter().map(waiting).collect();
        let free: [_; ARMS] = core::array::from_fn(|arm| Free {
            after: if self.about[arm] == About::Idle { 0.0 } else { (self.busy[arm] - self.now).max(0.0) },
            first: FIRST + STATIONS[arm].along,
            last: LAST + STATIONS[arm].along,
        });
        let assigned = assign(&parts, &free, speed, &Self::TIMES);
        let place = assigned.iter().position(|of| *of == Some((arm, 0)))?;
        // Not before it must: until then a better assignment may be found.
        if parts[place].at < free[arm].first - Queue::AHEAD * speed {
            return None;
        }
        let part = self.queue.waiting.remove(place)?;
        self.about[arm] = About::Taking(part);
        self.busy[arm] = self.now + over(parts[place].at, &free[arm], 0, speed, &Self::TIMES)?;
        Some(self.queue.order(&part))
    }
}

/// A Wait for the coordinator's next turn: it takes in parts, and what the arms have.
struct Turn {
    shared: Shared,
    steps: u32,
}

impl Turn {
    /// A turn every so many steps.
    const STEPS: u32 = 5;

    fn of(shared: Shared) -> Self {
        Self { shared, steps: 0 }
    }
}

// By hand, as the queue's.
impl Condition for Turn {
    type Robots = (Irp6, Irp6, TwoFingers, TwoFingers);
    type Sensors = (PartSensor,);
    type Order = ();
    const CLASS: Class =
        Class::new(Level::Mp, Uses { state: true, robots: true, sensors: true, tick: true, ..Uses::NOTHING });

    fn is_met(
        &mut self,
        _: &Order<()>,
        e: &State<(Irp6, Irp6, TwoFingers, TwoFingers)>,
        v: &Reading<(PartSensor,)>,
        t: Tick,
    ) -> Result<bool, Fault> {
        let shared = &mut self.shared;
        shared.queue.take(&v.0, t.duration)?;
        shared.now += t.duration;
        shared.held = [Held::of(&e.0, &e.2), Held::of(&e.1, &e.3)];
        self.steps += 1;
        Ok(self.steps >= Self::STEPS)
    }
}
