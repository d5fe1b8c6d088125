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

/// After so many failed picks in a row the cell stops: something is wrong with it.
const FAILED: u32 = 3;

/// Sorts what the belt brings, until so many parts have come and gone, or nothing has passed the gate for `timeout` \[s\].
/// Counts in `failed` the picks in which the hand closed on nothing: it is opened then, and the next part is taken.
///
/// # Errors
/// The first fault of the cell; three picks in a row that failed.
pub fn coordinate(
    mp: &mut Mp,
    drive: Uneven,
    (parts, timeout): (u32, f64),
    failed: &Cell<u32>,
) -> Result<(), Fault> {
    let mut arm = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let (mut belt, mut gate) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<Gate>("gate")?);
    let order = |task| ConstantOrder::<Arm, Task>::to_all(task);
    mp.move_robots((&mut arm.0, &mut arm.1), (), order(Task::Return))?;
    mp.start_robot(&mut belt, drive)?;
    let mut in_a_row = 0;
    loop {
        let pick = Pick { parts, timeout, quiet: 0.0, passed: 0, gone: false, empty: 0.0 };
        let pick = mp.move_robots((&mut arm.0, &mut arm.1), (&mut gate,), pick)?;
        if pick.is_over() {
            return mp.end_robot(&mut belt);
        }
        in_a_row = if pick.empty > 0.0 { in_a_row + 1 } else { 0 };
        if in_a_row == FAILED {
            return Err(Fault::thrown(
                "the hand has closed on nothing three times in a row: look at the barrier between its fingers, and how parts lie",
            ));
        }
        if in_a_row == 0 {
            mp.move_robots((&mut arm.0, &mut arm.1), (), order(Task::Carry { short: 0, long: 1 }))?;
        } else {
            failed.set(failed.get() + 1);
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

    /// Whether fingers that are to press on a part are where none can be between them.
    fn is_empty(e: &State<Arm>) -> bool {
        let [demanded, measured] = [e.1.demanded().joints[0], e.1.measured().joints[0]];
        demanded < 0.1 * OPEN + 0.9 * CLOSED && measured < 0.5 * (CLOSED + PART[0])
    }

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
        self.empty = if Self::is_empty(e) { self.empty + t.dt } else { 0.0 };
        Ok(if self.is_over() || self.empty > Self::RESTING {
            Step::Done
        } else {
            Step::Next((Task::Pick, Task::Pick))
        })
    }
}
