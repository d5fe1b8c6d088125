//! The task program of these tests: two arms that are coordinated loosely and tightly, sensors in three modes, and a
//! record of what each arm was demanded, written by the process that demands it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell_file::Kinds;
use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured, SimulatedDrives};
use mrroc_robots::{Irp6, Shaft, SimulatedIrp6, Six};
use mrroc_tests::fixture::{COMPUTES, FARTHER, HARDWARE, OTHER, PLANS, RECORDS, TIMEOUT, TIMES};
use mrroc_tests::{Follow, Turned};

use crate::Nothing;
use crate::calls::Calls;

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    mrroc::launch(cell, Nothing)
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let left = Rc::new(RefCell::new(None));
    let truth = Rc::clone(&left);
    let cell = file
        .cell(&Kinds::new().with("irp6", move |entry| {
            let arm = Irp6::nominal().with_base(entry.base());
            let drives = Recorded::new(entry.name(), SimulatedIrp6::new(arm.clone(), &entry.start(&arm)?));
            if entry.name() == "left" {
                *truth.borrow_mut() = Some(drives.drives.shaft());
            }
            Ok(RobotSetup::new(entry.name(), arm, drives))
        }))?
        .sensor(file.sensor("count", Counting::new("vsp count"))?)
        .sensor(file.sensor("slow", Counting::new("vsp slow"))?)
        .sensor(file.sensor("free", Counting::new("vsp free"))?)
        .sensor(file.sensor("shaft", Looking(left.take()))?)
        .ecp("left", arm)
        .ecp("right", arm)
        .program(coordinate);
    let cell = match own_option(OTHER) {
        Some(_) if std::env::args().any(|word| word == "edp") => {
            let arm = Irp6::nominal();
            let drives = SimulatedIrp6::new(arm.clone(), &Six::zeros());
            cell.robot(RobotSetup::new("third", arm, drives))
        }
        _ => cell,
    };
    let timeout = own_option(TIMEOUT).and_then(|seconds| seconds.parse().ok());
    let cell = match timeout {
        Some(seconds) => cell.end_when_stuck(Duration::from_secs(seconds)),
        None => cell,
    };
    if Calls::are_counted() {
        let mut steps = Calls::of("mp");
        let periods = RefCell::new(BTreeMap::new());
        return Ok(cell.on_step(move |_, _| steps.note()).watch(move |seen| {
            let mut periods = periods.borrow_mut();
            if !periods.contains_key(seen.robot) {
                periods.insert(seen.robot.to_owned(), Calls::of(&format!("edp {}", seen.robot)));
            }
            periods.get_mut(seen.robot).expect("it is there").note();
        }));
    }
    let cell = crate::suspended(cell);
    Ok(match own_option(RECORDS) {
        Some(folder) => cell.watch(crate::records::record(PathBuf::from(folder))),
        None => cell,
    })
}

/// Simulated drives that write what they do, in whichever process they are: a line for each servo period, `tick` or
/// `brake`, one when their power is taken away, `off`, and what the encoders read at its end.
struct Recorded {
    path: Option<PathBuf>,
    drives: SimulatedIrp6,
    file: Option<File>,
    calls: Calls,
}

impl Recorded {
    fn new(name: &str, drives: SimulatedIrp6) -> Recorded {
        let path = own_option(RECORDS).map(|folder| Path::new(&folder).join(format!("{name}.plant")));
        Recorded { path, drives, file: None, calls: Calls::of(&format!("plant {name}")) }
    }

    fn write(&mut self, what: &str, measured: &Measured<Six>) {
        self.calls.note();
        let Some(path) = &self.path else { return };
        let file = self.file.get_or_insert_with(|| File::create(path).expect("the file can be written"));
        let line = |q: &Six| q.iter().map(|q| format!(" {q:e}")).collect::<String>();
        let text = format!("{what}{}{}\n", line(&measured.position), line(&measured.velocity));
        file.write_all(text.as_bytes()).expect("written");
    }
}

impl Driver<Irp6> for Recorded {
    fn period(&self) -> Duration {
        Driver::period(&self.drives)
    }

    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        self.drives.measured()
    }

    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        let outcome = self.drives.tick(demanded);
        self.write("tick", &self.drives.measured()?);
        outcome
    }

    fn hardware(&self) -> Option<String> {
        own_option(HARDWARE)
    }

    fn has_brakes(&self) -> bool {
        self.drives.has_brakes()
    }

    fn switch_off(&mut self) {
        self.drives.switch_off();
        if let Ok(measured) = self.drives.measured() {
            self.write("off", &measured);
        }
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.drives.switch_on()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<Six>> {
        Some(self)
    }
}

impl SimulatedDrives<Six> for Recorded {
    fn brake(&mut self) -> Measured<Six> {
        let measured = self.drives.brake();
        self.write("brake", &measured);
        measured
    }
}

#[derive(Clone, Copy, Payload)]
enum Phase {
    Out,
    Back,
}

/// Counts its aggregations, and tells where its robot's column was measured.
struct Count;

impl Sensor for Count {
    const KIND: &'static str = "count";
    type Reading = Counted;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Counted {
    count: u64,
    column: f64,
}

struct Counting {
    count: u64,
    calls: Calls,
}

impl Counting {
    fn new(name: &str) -> Counting {
        Counting { count: 0, calls: Calls::of(name) }
    }
}

impl VirtualSensor for Counting {
    type Kind = Count;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Counted, Fault> {
        self.calls.note();
        self.count += 1;
        Ok(Counted { count: self.count, column: order.robot.map_or(0.0, |robot| robot.joints[0]) })
    }
}

/// Tells where the left column truly is: it looks at the simulated drives, and counts nothing.
struct Looking(Option<Shaft>);

impl VirtualSensor for Looking {
    type Kind = Count;

    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Counted, Fault> {
        let column = self.0.as_ref().map_or(0.0, |shaft| shaft.state().position[0]);
        Ok(Counted { count: 0, column })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// How often the arms go out and back.
fn times() -> u32 {
    own_option(TIMES).and_then(|times| times.parse().ok()).unwrap_or(1)
}

fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    while own_option(COMPUTES).is_some() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let (mut count, mut shaft) = (mp.sensor::<Count>("count")?, mp.sensor::<Count>("shaft")?);
    mp.wait_until((&mut left, &mut right), (&mut count,), Counted3 {})?;
    for _ in 0..times() {
        for phase in [Phase::Out, Phase::Back] {
            mp.move_robots((&mut left, &mut right), (), Ask(phase))?;
        }
    }
    let swing = Swing::new();
    mp.move_robots((&mut left, &mut right), (&mut count, &mut shaft), swing)?;
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

/// Both columns out and back, against each other; what the sensors saw makes a difference of its own.
struct Swing {
    t: f64,
    /// How long it takes \[s\].
    duration: f64,
    /// How far it goes \[rad\].
    angle: f64,
}

impl Swing {
    fn new() -> Self {
        let farther = own_option(FARTHER).and_then(|times| times.parse().ok()).unwrap_or(1.0);
        // Where calls are counted there are enough of them even if a late machine leaves out half of its steps.
        let duration = if Calls::are_counted() { 2.0 } else { 1.0 };
        Swing { t: 0.0, duration, angle: 0.002 * farther }
    }
}

#[generator(mp)]
fn swing(c: &mut Swing, v: &Reading<(Count, Count)>, t: Tick) -> Step<(Irp6, Irp6), Turned> {
    if c.t >= c.duration {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(c.duration);
    let column = |seen: Option<Counted>| seen.map_or(0.0, |reading| 1e-9 * reading.column);
    let seen = column(v.0.reading()) + column(v.1.reading());
    let by = (c.angle + seen) * smooth((2.0 * c.t / c.duration).min(2.0 - 2.0 * c.t / c.duration));
    Step::Next((Turned { by }, Turned { by: -by }))
}

fn smooth(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

fn arm(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    let from = ecp.image().demanded().joints;
    let plans = own_option(PLANS).is_some();
    let go = |angle, duration| GoTo { angle, duration, from, t: 0.0, plans, calls: Calls::of("ecp") };
    for _ in 0..2 * times() {
        ecp.serve(|ecp, phase: Phase| match phase {
            Phase::Out => ecp.move_robot((), go(0.01, 1.0)).map(drop),
            Phase::Back => ecp.move_robot((), go(0.0, 1.5)).map(drop),
        })?;
    }
    ecp.serve(|ecp, _: Turned| ecp.move_robot((), Follow::from_here()).map(drop))
}

/// The column to an angle \[rad\] in a time \[s\].
struct GoTo {
    angle: f64,
    duration: f64,
    from: Six,
    t: f64,
    /// Whether its first step takes half a second.
    plans: bool,
    calls: Calls,
}

#[generator(ecp)]
impl GoTo {
    fn first_step(&mut self, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
        self.from = e.demanded().joints;
        if self.plans {
            std::thread::sleep(Duration::from_millis(500));
        }
        self.next_step(t)
    }

    fn next_step(&mut self, t: Tick) -> Step<Irp6> {
        self.calls.note();
        if self.t >= self.duration {
            return Step::Done;
        }
        self.t = (self.t + t.dt).min(self.duration);
        let mut q = self.from;
        q[0] += (self.angle - self.from[0]) * smooth(self.t / self.duration);
        Step::Next(Demand::joints(q))
    }
}
