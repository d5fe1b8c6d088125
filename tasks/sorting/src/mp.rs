//! The coordinator's program: it runs the belt, has parts acquired one after another, and chooses their trays.

use mrroc::generator::{Class, Generator, Level, Uses};
use mrroc::prelude::*;
use mrroc_generators::generators::ConstantOrder;
use mrroc_robots::{Conveyor, Irp6, TwoFingers};
use mrroc_sensors::virtual_sensors::Gate;

use crate::generators::Uneven;
use crate::orders::Task;
use crate::places::END;

/// The arm and its hand.
pub type Arm = (Irp6, TwoFingers);

/// Sorts what the belt brings, until so many parts have come and gone, or nothing has passed the gate for `patience` \[s\].
///
/// # Errors
/// The first fault of the cell.
pub fn coordinate(mp: &mut Mp, drive: Uneven, parts: u32, patience: f64) -> Result<(), Fault> {
    let mut arm = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let (mut belt, mut gate) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<Gate>("gate")?);
    let order = |task| ConstantOrder::<Arm, Task>::to_all(task);
    mp.move_robots((&mut arm.0, &mut arm.1), (), order(Task::Return))?;
    mp.start_robot(&mut belt, drive)?;
    loop {
        let pick = Pick { parts, patience, quiet: 0.0, passed: 0, gone: false };
        if mp.move_robots((&mut arm.0, &mut arm.1), (&mut gate,), pick)?.is_over() {
            return mp.end_robot(&mut belt);
        }
        for task in [Task::Carry { short: 0, long: 1 }, Task::Release, Task::Return] {
            mp.move_robots((&mut arm.0, &mut arm.1), (), order(task))?;
        }
    }
}

/// Orders the next part to be acquired, until that is done or none comes any more.
struct Pick {
    parts: u32,
    patience: f64,
    /// For how long nothing has passed \[s\].
    quiet: f64,
    passed: u32,
    /// Whether the last one is out of the arm's reach.
    gone: bool,
}

impl Pick {
    fn is_over(&self) -> bool {
        self.quiet >= self.patience || self.passed >= self.parts && self.gone
    }
}

// By hand: it ends when arm and hand have finished, and also by itself.
impl Generator for Pick {
    type Robots = Arm;
    type Language = Task;
    type Sensors = (Gate,);
    type Order = ();
    const CLASS: Class =
        Class::new(Level::Mp, Uses { state: true, sensors: true, tick: true, ..Uses::NOTHING });
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
        _: &State<Arm>,
        v: &Reading<(Gate,)>,
        t: Tick,
    ) -> Result<Step<Arm, Task>, Fault> {
        let gate = v.0.reading().unwrap_or_default();
        let passed = gate.parts + gate.dropped;
        self.gone = gate.place(0.0) > END;
        self.quiet = if passed > self.passed { 0.0 } else { self.quiet + t.dt };
        self.passed = passed;
        Ok(if self.is_over() { Step::Done } else { Step::Next((Task::Pick, Task::Pick)) })
    }
}
