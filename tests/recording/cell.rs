//! The cell of these tests: two arms that are coordinated loosely and tightly, sensors in three modes that the MP and an
//! ECP read, and an operator who slows down, suspends and resumes in known steps.

use std::time::Duration;

use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use mrroc_tests::{Follow, Turned};

pub const STEP: Duration = Duration::from_millis(2);

pub const START: Six = Irp6::READY;

/// What is changed in the programs.
#[derive(Clone, Copy, PartialEq)]
pub enum Change {
    Nothing,
    /// From this path time of the swing on the right column turns by 1e-9 of the angle more.
    Swing(f64),
    /// The program ends before the swing.
    NoSwing,
}

pub fn arms(change: Change) -> Cell {
    let arm =
        |name: &str| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &START));
    let cell = Cell::new(STEP)
        .robot(arm("left"))
        .robot(arm("right"))
        .sensor(SensorSetup::new("count", Counting(0)).of("left"))
        .sensor(
            SensorSetup::new("slow", Counting(0)).of("left").mode(VspMode::WithDelay).latency(5 * STEP / 2),
        )
        .sensor(SensorSetup::new("free", Counting(0)).of("right").mode(VspMode::NonInteractive(2 * STEP)));
    programmed(cell, change)
}

/// Gives such a cell its programs.
pub fn programmed(cell: Cell, change: Change) -> Cell {
    cell.ecp("left", serve).ecp("right", serve).on_step(operate).program(move |mp| coordinate(mp, change))
}

fn operate(step: u64, operator: &Operator) {
    // In real time a step may be left out.
    match step {
        0..100 => {}
        100..250 => operator.set_speed(0.4).expect("a share"),
        250..400 => operator.suspend(),
        400..600 => operator.resume(),
        600.. => operator.set_speed(1.0).expect("a share"),
    }
}

#[derive(Clone, Copy, Payload)]
pub enum Phase {
    Out,
    Back,
}

/// Counts its aggregations, and tells where its robot's column was measured.
pub struct Count;

impl Sensor for Count {
    const KIND: &'static str = "count";
    type Reading = Counted;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
pub struct Counted {
    pub count: u64,
    pub column: f64,
}

#[derive(Default)]
pub struct Counting(u64);

impl VirtualSensor for Counting {
    type Kind = Count;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Counted, Fault> {
        self.0 += 1;
        Ok(Counted { count: self.0, column: order.robot.map_or(0.0, |robot| robot.joints[0]) })
    }
}

fn coordinate(mp: &mut Mp, change: Change) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let (mut count, mut free) = (mp.sensor::<Count>("count")?, mp.sensor::<Count>("free")?);
    mp.wait_until((&mut left, &mut right), (&mut count,), Counted3 {})?;
    for phase in [Phase::Out, Phase::Back] {
        mp.move_robots((&mut left, &mut right), (), Ask(phase))?;
    }
    if change == Change::NoSwing {
        return Ok(());
    }
    let more = if let Change::Swing(from) = change { from } else { f64::INFINITY };
    let swing = Swing { t: 0.0, more };
    mp.move_robots((&mut left, &mut right), (&mut count, &mut free), swing)?;
    Ok(())
}

struct Counted3 {}

#[condition(mp)]
fn counted3(_c: &mut Counted3, v: &Reading<(Count,)>) -> bool {
    v.0.reading().is_some_and(|reading| reading.count >= 3)
}

struct Ask(Phase);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Irp6, Irp6), Phase> {
    Always((c.0, c.0))
}

/// Both columns out and back, against each other, in a second; what the sensors counted makes a difference of its own.
struct Swing {
    t: f64,
    more: f64,
}

#[generator(mp)]
fn swing(c: &mut Swing, v: &Reading<(Count, Count)>, t: Tick) -> Step<(Irp6, Irp6), Turned> {
    if c.t >= 1.0 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(1.0);
    let seen = |reading: Option<Counted>| reading.map_or(0.0, |reading| 1e-3 * reading.column);
    let share = smooth((2.0 * c.t).min(2.0 - 2.0 * c.t));
    let by = (0.002 + seen(v.0.reading()) + seen(v.1.reading())) * share;
    let more = if c.t >= c.more { 1.0 + 1e-9 } else { 1.0 };
    Step::Next((Turned { by }, Turned { by: -by * more }))
}

fn smooth(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

fn serve(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    let from = ecp.image().demanded().joints;
    for _ in 0..2 {
        ecp.serve(|ecp, phase: Phase| match phase {
            Phase::Out => match ecp.sensor::<Count>("slow") {
                Ok(mut slow) => ecp.move_robot((&mut slow,), Feel { goal: 0.01, from, t: 0.0 }).map(drop),
                Err(_) => ecp.move_robot((), GoTo { angle: 0.01, from, t: 0.0 }).map(drop),
            },
            Phase::Back => ecp.move_robot((), GoTo { angle: 0.0, from, t: 0.0 }).map(drop),
        })?;
    }
    ecp.serve(|ecp, _: Turned| ecp.move_robot((), Follow::from_here()).map(drop))
}

/// The column to an angle \[rad\] in a second.
struct GoTo {
    angle: f64,
    from: Six,
    t: f64,
}

#[generator(ecp)]
impl GoTo {
    fn first_step(&mut self, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
        self.from = e.demanded().joints;
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Step<Irp6> {
        if self.t >= 1.0 {
            return Step::Done;
        }
        self.t = (self.t + t.dt).min(1.0);
        let mut q = self.from;
        q[0] += (self.angle - self.from[0]) * smooth(self.t);
        Step::Next(Demand::joints(q))
    }
}

/// The column to an angle \[rad\] in a second, and by what was measured of it, a trace of it farther.
struct Feel {
    goal: f64,
    from: Six,
    t: f64,
}

#[generator(ecp)]
impl Feel {
    fn first_step(&mut self, e: &State<Irp6>, v: &Reading<(Count,)>, t: Tick) -> Step<Irp6> {
        self.from = e.demanded().joints;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Count,)>, t: Tick) -> Step<Irp6> {
        if self.t >= 1.0 {
            return Step::Done;
        }
        self.t = (self.t + t.dt).min(1.0);
        let felt = v.0.reading().map_or(0.0, |reading| 1e-3 * reading.column);
        let mut q = self.from;
        q[0] += (self.goal + felt - self.from[0]) * smooth(self.t);
        Step::Next(Demand::joints(q))
    }
}
