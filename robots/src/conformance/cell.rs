//! What the driver of a robot must keep in a whole cell: on the memory link, under the virtual clock.

use core::cell::RefCell;
use core::f64::consts::TAU;
use core::time::Duration;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, JointVector, Measured, Pace, Pulse, Regulators, SimulatedDrives};

use super::driver::read;
use super::{Violation, ensure};

/// Longest stop that the cell allows any joint: that of slow belts.
const STOP: Duration = Duration::from_secs(60);
/// How long the motion takes \[s\].
const DURATION: f64 = 1.0;
/// Steps that a sensor takes to answer, so that its ECP is late and demands get lost.
const LATE: f64 = 2.4;

/// A driver that outlives its cell, with the count of its ticks and the last demand.
struct Kept<R: Robot, D> {
    driver: D,
    ticks: u64,
    demanded: Option<R::Joints>,
}

/// What the cell gets of it.
struct Lent<R: Robot, D>(Rc<RefCell<Kept<R, D>>>);

impl<R: Robot, D> Lent<R, D> {
    fn of(driver: D) -> (Self, Rc<RefCell<Kept<R, D>>>) {
        let kept = Rc::new(RefCell::new(Kept { driver, ticks: 0, demanded: None }));
        (Lent(Rc::clone(&kept)), kept)
    }
}

impl<R: Robot, D: Driver<R>> Driver<R> for Lent<R, D> {
    fn period(&self) -> Duration {
        self.0.borrow().driver.period()
    }

    fn pace(&self) -> Pace {
        self.0.borrow().driver.pace()
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        self.0.borrow_mut().driver.pulse(now)
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        self.0.borrow().driver.measured()
    }

    fn motor_currents(&self) -> Option<R::Joints> {
        self.0.borrow().driver.motor_currents()
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        self.0.borrow_mut().driver.open()
    }

    fn close(&mut self) {
        self.0.borrow_mut().driver.close();
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        let mut kept = self.0.borrow_mut();
        kept.ticks += 1;
        kept.demanded = Some(*demanded);
        kept.driver.tick(demanded)
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.0.borrow().driver.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.0.borrow_mut().driver.choose_regulators(sets);
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        let is_simulated = self.0.borrow_mut().driver.simulation().is_some();
        if is_simulated { Some(self) } else { None }
    }
}

impl<R: Robot, D: Driver<R>> SimulatedDrives<R::Joints> for Lent<R, D> {
    fn brake(&mut self) -> Measured<R::Joints> {
        let driver = &mut self.0.borrow_mut().driver;
        match driver.simulation() {
            Some(simulated) => simulated.brake(),
            None => driver.measured().expect("simulated drives can be read"),
        }
    }
}

/// Met after so many steps.
struct After(u32);

#[condition(mp)]
fn after(c: &mut After) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}

/// In every stretch of virtual time a driver is called once a period, no more and no less, for steps of a period and of ten.
///
/// # Errors
/// The first [`Violation`].
pub fn ticks_once_a_period<R: Robot, D: Driver<R> + 'static>(
    robot: &R,
    make: impl Fn() -> D,
) -> Result<(), Violation> {
    for periods in [1, 10] {
        let driver = make();
        let step = driver.period() * periods;
        let (lent, kept) = Lent::of(driver);
        let setup = RobotSetup::new("robot", robot.clone(), lent);
        let counts = Rc::<RefCell<Vec<u64>>>::default();
        let seen = Rc::clone(&counts);
        let steps = 500;
        let outcome = Cell::new(step).stop_time(STOP).robot(setup).program(move |mp| {
            let mut robot = mp.robot::<R>("robot")?;
            for _ in 0..3 {
                mp.wait_until((&mut robot,), (), After(steps))?;
                seen.borrow_mut().push(kept.borrow().ticks);
            }
            Ok(())
        });
        outcome.run().map_err(|why| Violation(format!("steps of {step:?}: {why}")))?;
        let counts = counts.borrow();
        for pair in counts.windows(2) {
            let ticks = pair[1] - pair[0];
            let due = u64::from(steps * periods);
            ensure(ticks == due, || format!("{ticks} ticks in {steps} steps of {step:?}, {due} are due"))?;
        }
    }
    Ok(())
}

/// A sensor with an empty reading, which it gives late.
struct Slow;

#[derive(Clone, Copy, Debug, Payload)]
struct Nothing {
    nothing: u64,
}

impl Sensor for Slow {
    const KIND: &'static str = "slow";
    type Reading = Nothing;
    type Configuration = ();
}

impl VirtualSensor for Slow {
    type Kind = Slow;

    fn aggregate(&mut self, _order: &ReadingOrder<()>) -> Result<Nothing, Fault> {
        Ok(Nothing { nothing: 0 })
    }
}

/// Moves all joints at once, from rest to rest; gives up in between when told to.
#[derive(Clone)]
struct Sway<R: Robot> {
    start: R::Joints,
    displacement: R::Joints,
    t: f64,
    until: f64,
}

impl<R: Robot> Sway<R> {
    /// By up to an eighth of the limits of speed, a sixteenth of those of acceleration, and a tenth of the range.
    fn from(robot: &R, start: &R::Joints, until: f64) -> Self {
        let limits = robot.limits();
        let displacement = R::Joints::from_joints(|i| {
            let up = limits.upper[i] - start[i];
            let down = start[i] - limits.lower[i];
            let most = (limits.velocity[i] * DURATION / 16.0)
                .min(limits.acceleration[i] * DURATION * DURATION / (16.0 * TAU));
            if up > down { most.min(0.1 * up) } else { -most.min(0.1 * down) }
        });
        Sway { start: *start, displacement, t: 0.0, until }
    }
}

#[generator(ecp, first = sway_first)]
fn sway<R: Robot>(c: &mut Sway<R>, _v: &Reading<(Slow,)>, t: Tick) -> Result<Step<R>, Fault> {
    if c.t >= DURATION {
        return Ok(Step::Done);
    }
    if c.t >= c.until {
        return Err(Fault::thrown("the program gives up in the middle"));
    }
    c.t = (c.t + t.dt).min(DURATION);
    let u = c.t / DURATION;
    Ok(Step::Next(Demand::joints(c.start + c.displacement * (u - (TAU * u).sin() / TAU))))
}

fn sway_first<R: Robot>(
    c: &mut Sway<R>,
    e: &State<R>,
    v: &Reading<(Slow,)>,
    t: Tick,
) -> Result<Step<R>, Fault> {
    c.start = e.demanded().joints;
    sway(c, v, t)
}

/// A cell of one robot whose ECP is made late by a sensor, and gives up at a time [s].
fn late_cell<R: Robot, D: Driver<R> + 'static>(
    robot: &R,
    driver: D,
    start: &R::Joints,
    until: f64,
) -> (Cell, Rc<RefCell<Kept<R, D>>>) {
    let step = driver.period();
    let sway = Sway::from(robot, start, until);
    let (lent, kept) = Lent::of(driver);
    let setup = RobotSetup::new("robot", robot.clone(), lent).program(move |ecp| {
        let mut slow = ecp.sensor::<Slow>("slow")?;
        ecp.move_robot((&mut slow,), sway.clone()).map(drop)
    });
    let slow = SensorSetup::new("slow", Slow).of("robot").latency(step.mul_f64(LATE));
    (Cell::new(step).stop_time(STOP).robot(setup).sensor(slow), kept)
}

/// Where the robot stands half a second after its cell has ended.
fn at_rest<R: Robot, D: Driver<R>>(robot: &R, kept: &RefCell<Kept<R, D>>) -> Result<R::Joints, Violation> {
    let Kept { driver, demanded, .. } = &mut *kept.borrow_mut();
    let Some(demanded) = demanded else { return Err(Violation("it was never called".into())) };
    let ticks = (0.5 / driver.period().as_secs_f64()).ceil() as usize;
    for _ in 0..ticks {
        driver.tick(demanded).map_err(|fault| Violation(format!("after the cell: {fault}")))?;
    }
    let measured = read(driver)?;
    for i in 0..R::Joints::LEN {
        let off = (measured.position[i] - demanded[i]).abs() / robot.limits().velocity[i];
        ensure(off < 2e-3, || format!("joint {i} stands {off} s of its top speed off its demand"))?;
    }
    Ok(*demanded)
}

/// A motion of which two demands of three are lost is followed to its end all the same; one whose program gives up in
/// between ends at rest.
///
/// # Errors
/// The first [`Violation`].
pub fn bears_lost_demands<R: Robot, D: Driver<R> + 'static>(
    robot: &R,
    make: impl Fn() -> D,
    start: &R::Joints,
) -> Result<(), Violation> {
    let limits = robot.limits();
    let (cell, kept) = late_cell(robot, make(), start, f64::INFINITY);
    cell.run().map_err(|why| Violation(format!("with lost demands: {why}")))?;
    let end = at_rest(robot, &kept)?;
    let sway = Sway::from(robot, start, f64::INFINITY);
    for i in 0..R::Joints::LEN {
        // It began where the encoders were.
        let off = (end[i] - start[i] - sway.displacement[i]).abs() / limits.velocity[i];
        ensure(off < 2e-3, || format!("joint {i} ends {off} s of its top speed from its goal"))?;
    }
    let (cell, kept) = late_cell(robot, make(), start, 0.5 * DURATION);
    let outcome = cell.run();
    ensure(outcome.is_err(), || "a program that gives up ends well".into())?;
    let end = at_rest(robot, &kept)?;
    let moved = (0..R::Joints::LEN).any(|i| (end[i] - start[i]).abs() > 0.3 * sway.displacement[i].abs());
    ensure(moved, || "it gave up before it moved".into())
}
