//! The task program of these tests: two arms that are coordinated loosely and tightly, sensors in three modes, and a
//! record of what each arm was demanded, written by the process that demands it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use mrroc::{
    Always, Cell, CellError, CellFile, Demand, DriveFault, Driver, Ecp, Fault, Kinds, Measured, Mp,
    Observation, Payload, Reading, ReadingOrder, Recorder, RobotSetup, Sensor, State, Step, Tick,
    VirtualSensor, condition, generator,
};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};

/// The variable that names the folder of the records.
pub const RECORDS: &str = "MRROC_TEST_RECORDS";

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    mrroc::launch(cell, Nothing)
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file
        .cell(&Kinds::new().with("irp6", |entry| {
            let arm = Irp6::nominal().with_base(entry.base());
            let drives = Recorded::new(entry.name(), SimulatedIrp6::new(arm.clone(), &entry.start(&arm)?));
            Ok(RobotSetup::new(entry.name(), arm, drives))
        }))?
        .sensor(file.sensor("count", Counting::default())?)
        .sensor(file.sensor("slow", Counting::default())?)
        .sensor(file.sensor("free", Counting::default())?)
        .ecp("left", arm)
        .ecp("right", arm)
        .program(coordinate);
    Ok(match std::env::var_os(RECORDS) {
        Some(folder) => cell.watch(record(PathBuf::from(folder))),
        None => cell,
    })
}

/// Writes every servo period of every robot to a file of its own: the time, then the bits of each demanded joint.
fn record(folder: PathBuf) -> impl FnMut(&Observation<'_>) {
    let files = RefCell::new(BTreeMap::new());
    move |seen| {
        let mut files = files.borrow_mut();
        let file = files.entry(seen.robot.to_owned()).or_insert_with(|| {
            File::create(folder.join(seen.robot)).expect("the folder of the records can be written")
        });
        let bits: String = seen.demanded.iter().map(|q| format!(" {:016x}", q.to_bits())).collect();
        // One write a line: what is there when the process is killed is whole.
        file.write_all(format!("{:.6}{bits}\n", seen.time).as_bytes()).expect("written");
    }
}

/// Simulated drives that write what they do, in whichever process they are: a line for each servo period, `tick` or
/// `brake`, and what the encoders read at its end.
struct Recorded {
    name: String,
    drives: SimulatedIrp6,
    file: Option<File>,
}

impl Recorded {
    fn new(name: &str, drives: SimulatedIrp6) -> Recorded {
        Recorded { name: format!("{name}.plant"), drives, file: None }
    }

    fn write(&mut self, what: &str, measured: &Measured<Six>) {
        let Some(folder) = std::env::var_os(RECORDS) else { return };
        let file = self.file.get_or_insert_with(|| {
            File::create(Path::new(&folder).join(&self.name))
                .expect("the folder of the records can be written")
        });
        let line = |q: &Six| q.iter().map(|q| format!(" {q:e}")).collect::<String>();
        let text = format!("{what}{}{}\n", line(&measured.position), line(&measured.velocity));
        file.write_all(text.as_bytes()).expect("written");
    }
}

impl Driver<Irp6> for Recorded {
    fn period(&self) -> Duration {
        Driver::period(&self.drives)
    }

    fn measured(&self) -> Measured<Six> {
        self.drives.measured()
    }

    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        let outcome = self.drives.tick(demanded);
        self.write("tick", &self.drives.measured());
        outcome
    }

    fn is_simulated(&self) -> bool {
        self.drives.is_simulated()
    }

    fn brake(&mut self) -> Measured<Six> {
        let measured = Driver::brake(&mut self.drives);
        self.write("brake", &measured);
        measured
    }
}

/// Draws nothing.
struct Nothing;

impl Recorder for Nothing {
    fn watch(&mut self, cell: Cell) -> Cell {
        cell
    }

    fn save(&mut self, _: &Path) -> io::Result<()> {
        Ok(())
    }
}

#[derive(Clone, Copy, Payload)]
enum Phase {
    Out,
    Back,
}

/// An offset of the column \[rad\].
#[derive(Clone, Copy, Payload)]
struct Turned {
    by: f64,
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

#[derive(Default)]
struct Counting(u64);

impl VirtualSensor for Counting {
    type Kind = Count;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Counted, Fault> {
        self.0 += 1;
        Ok(Counted { count: self.0, column: order.robot.map_or(0.0, |robot| robot.joints[0]) })
    }
}

fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let mut count = mp.sensor::<Count>("count")?;
    mp.wait_until((&mut left, &mut right), (&mut count,), Counted3 {})?;
    for phase in [Phase::Out, Phase::Back] {
        mp.move_robots((&mut left, &mut right), (), Ask(phase))?;
    }
    let swing = Swing { t: 0.0 };
    mp.move_robots((&mut left, &mut right), (&mut count,), swing)?;
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

/// Both columns out and back, against each other, in a second; what the sensor counted makes a difference of its own.
struct Swing {
    t: f64,
}

#[generator(mp)]
fn swing(c: &mut Swing, v: &Reading<(Count,)>, t: Tick) -> Step<(Irp6, Irp6), Turned> {
    if c.t >= 1.0 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(1.0);
    let counted = v.0.reading().map_or(0.0, |reading| 1e-9 * reading.column);
    let by =
        0.002 * smooth((2.0 * c.t).min(2.0 - 2.0 * c.t)) + counted * smooth((2.0 * c.t).min(2.0 - 2.0 * c.t));
    Step::Next((Turned { by }, Turned { by: -by }))
}

fn smooth(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

fn arm(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    let from = ecp.image().demanded().joints;
    let go = |angle, duration| GoTo { angle, duration, from, t: 0.0 };
    for _ in 0..2 {
        ecp.obey(|ecp, phase: Phase| match phase {
            Phase::Out => ecp.move_robot((), go(0.01, 1.0)).map(drop),
            Phase::Back => ecp.move_robot((), go(0.0, 1.5)).map(drop),
        })?;
    }
    ecp.obey(|ecp, _: Turned| ecp.move_robot((), Follow { from: Six::zeros() }).map(drop))
}

/// The column to an angle \[rad\] in a time \[s\].
struct GoTo {
    angle: f64,
    duration: f64,
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
        if self.t >= self.duration {
            return Step::Done;
        }
        self.t = (self.t + t.dt).min(self.duration);
        let mut q = self.from;
        q[0] += (self.angle - self.from[0]) * smooth(self.t / self.duration);
        Step::Next(Demand::joints(q))
    }
}

/// Where the MP's order turns the column to.
struct Follow {
    from: Six,
}

#[generator(ecp)]
impl Follow {
    fn first_step(&mut self, order: &mrroc::Order<Turned>, e: &State<Irp6>) -> Step<Irp6> {
        self.from = e.demanded().joints;
        self.next_step(order)
    }

    fn next_step(&mut self, order: &mrroc::Order<Turned>) -> Step<Irp6> {
        let mut q = self.from;
        q[0] += order.value().by;
        Step::Next(Demand::joints(q))
    }
}
