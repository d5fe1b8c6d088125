//! The coordinator's program: it runs the belt, has parts acquired one after another, and chooses their trays.

use mrroc::generator::{Class, Generator, Level, Uses};
use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_robots::{Conveyor, Irp6, TwoFingers};
use mrroc_sensors::virtual_sensors::Gate;

use core::cell::Cell;

use crate::generators::Uneven;
use crate::orders::Task;
use crate::places::{CLOSED, END, OPEN, PART};

/// The arm and its hand.
pub type Arm = (Irp6, TwoFingers);

/// Picks in which a hand closed on nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Failed {
    /// How many.
    pub all: u32,
    in_a_row: u32,
}

impl Failed {
    /// After so many in a row the cell stops: something is wrong with it.
    pub const IN_A_ROW: u32 = 3;

    /// Counts a pick in which a hand has closed, on nothing or not.
    ///
    /// # Errors
    /// It is one too many in a row.
    pub fn count(so_far: &Cell<Self>, is_empty: bool) -> Result<(), Fault> {
        let Self { all, in_a_row } = so_far.get();
        let in_a_row = if is_empty { in_a_row + 1 } else { 0 };
        so_far.set(Self { all: all + u32::from(is_empty), in_a_row });
        if in_a_row == Self::IN_A_ROW {
            return Err(Fault::thrown(
                "the hand has closed on nothing three times in a row: look at the barrier between its fingers, and how parts lie",
            ));
        }
        Ok(())
    }
}

/// Whether fingers that are to press on a part are where none can be between them: by their demanded and measured opening \[m\].
#[must_use]
pub fn is_empty(demanded: f64, measured: f64) -> bool {
    is_closed(demanded) && measured < 0.5 * (CLOSED + PART[0])
}

/// Whether fingers are to press on a part: by their demanded opening \[m\].
#[must_use]
pub fn is_closed(demanded: f64) -> bool {
    demanded < 0.1 * OPEN + 0.9 * CLOSED
}

/// Sorts what the belt brings, until so many parts have come and gone, or nothing has passed the gate for `timeout` \[s\].
/// Counts in `failed` the picks in which the hand closed on nothing: it is opened then, and the next part is taken.
///
/// # Errors
/// The first fault of the cell; three picks in a row that failed.
pub fn coordinate(
    mp: &mut Mp,
    drive: Uneven,
    (parts, timeout): (u32, f64),
    failed: &Cell<Failed>,
) -> Result<(), Fault> {
    let mut arm = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let (mut belt, mut gate) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<Gate>("gate")?);
    let order = |task| ConstantOrder::<Arm, Task>::to_all(task);
    mp.move_robots((&mut arm.0, &mut arm.1), (), order(Task::Return))?;
    mp.start_robot(&mut belt, drive)?;
    loop {
        let pick = Pick { parts, timeout, quiet: 0.0, passed: 0, gone: false, empty: 0.0 };
        let pick = mp.move_robots((&mut arm.0, &mut arm.1), (&mut gate,), pick)?;
        if pick.is_over() {
            return mp.end_robot(&mut belt);
        }
        let is_empty = pick.empty > 0.0;
        Failed::count(failed, is_empty)?;
        if !is_empty {
            mp.move_robots((&mut arm.0, &mut arm.1), (), order(Task::Carry { short: 0, long: 1 }))?;
        }
        for task in [Task::Release, Task::Return] {
            mp.move_robots((&mut arm.0, &mut arm.1), (), order(task))?;
        }
    }
}

/// Orders the next part to be acquired, until that is done, or the hand has closed on nothing, or none comes any more.
struct Pick {
    parts: u32,
    timeout: f64,
    /// For how long nothing has passed \[s\].
    quiet: f64,
    passed: u32,
    /// Whether the last one is out of the arm's reach.
    gone: bool,
    /// For how long the hand has been closed with nothing in it \[s\].
    empty: f64,
}

impl Pick {
    /// So long the fingers have to come to rest before their opening tells whether they hold something \[s\].
    const RESTING: f64 = 0.1;

    fn is_over(&self) -> bool {
        self.quiet >= self.timeout || self.passed >= self.parts && self.gone
    }
}

// By hand: it ends when arm and hand have finished, and also by itself.
impl Generator for Pick {
    type Robots = Arm;
    type Language = Task;
    type Sensors = (Gate,);
    type Order = ();
    const CLASS: Class =
        Class::new(Level::Mp, Uses { state: true, robots: true, sensors: true, tick: true, ..Uses::NOTHING });
    const ENDS: bool = false;

    fn first_step(
        &mut self,
        c0: &Order<()>,
        e: &State<Arm>,
        v: &Reading<(Gate,)>,
        t: Tick,
    ) -> Result<Step<Arm, Task>, Fault> {
        self.next_step(c0, e, v, t)
    }

    fn next_step(
        &mut self,
        _: &Order<()>,
        e: &State<Arm>,
        v: &Reading<(Gate,)>,
        t: Tick,
    ) -> Result<Step<Arm, Task>, Fault> {
        let gate = v.0.reading().unwrap_or_default();
        let passed = gate.parts + gate.dropped;
        self.gone = gate.place(0.0) > END;
        self.quiet = if passed > self.passed { 0.0 } else { self.quiet + t.dt };
        self.passed = passed;
        let is_empty = is_empty(e.1.demanded().joints[0], e.1.measured().joints[0]);
        self.empty = if is_empty { self.empty + t.dt } else { 0.0 };
        Ok(if self.is_over() || self.empty > Self::RESTING {
            Step::Done
        } else {
            Step::Next((Task::Pick, Task::Pick))
        })
    }
}
