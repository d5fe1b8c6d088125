//! Cells that benchmarks measure: N robots of one kind, moved by the MP for so many steps.

use std::time::Duration;

use mrroc::cell::LowerCell;
use mrroc::generator::{Generator, Motion};
use mrroc::prelude::*;
use mrroc_doubles::{ExactDrive, Gantry, Q};
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Length of a step and of a servo period.
pub const PERIOD: Duration = Duration::from_millis(2);

/// Holds for so many steps: nothing to compute.
struct Hold<const N: usize, R> {
    left: u64,
    of: core::marker::PhantomData<R>,
}

#[generator(mp)]
fn hold<R: Robot, const N: usize>(c: &mut Hold<N, R>) -> Step<[R; N]> {
    if c.left == 0 {
        return Step::Done;
    }
    c.left -= 1;
    Step::Next([Demand::hold(); N])
}

/// Every arm along a circle by poses: inverse kinematics in every step.
struct Circle<const N: usize> {
    left: u64,
    t: f64,
}

#[generator(mp)]
fn circle<const N: usize>(c: &mut Circle<N>, t: Tick) -> Step<[Irp6; N]> {
    if c.left == 0 {
        return Step::Done;
    }
    c.left -= 1;
    c.t += t.dt;
    let phase = (c.t - (2.0 * c.t).sin() / 2.0) / 2.0;
    let (sin, cos) = phase.sin_cos();
    let flange = Pose::from_parts(Translation3::new(0.84 + 0.01 * cos, 0.01 * sin, 0.35), down());
    Step::Next([Demand::pose(flange); N])
}

/// The tool points down.
pub fn down() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
}

/// Where the IRp-6 begins.
pub fn start() -> Six {
    let flange = Pose::from_parts(Translation3::new(0.85, 0.0, 0.35), down());
    let near = Irp6::READY;
    Irp6::nominal().inverse(&flange, &near).expect("within reach")
}

/// Runs a cell of N robots and one Move.
fn run<R: Robot, const N: usize, G>(setup: &dyn Fn(&str) -> RobotSetup<R>, generator: G)
where
    G: Generator<Robots = [R; N], Language = Motion, Sensors = ()> + 'static,
{
    let names: [String; N] = core::array::from_fn(|i| format!("r{i}"));
    let cell = names.iter().fold(Cell::new(PERIOD), |cell, name| cell.robot(setup(name)));
    let mut generator = Some(generator);
    cell.program(move |mp| {
        let mut robots = Vec::new();
        for name in &names {
            robots.push(mp.robot::<R>(name)?);
        }
        let mut handles = robots.iter_mut();
        let list = core::array::from_fn(|_| handles.next().expect("one handle per name"));
        mp.move_robots(list, (), generator.take().expect("one run")).map(drop)
    })
    .run()
    .expect("the motion keeps the limits");
}

/// N gantries that hold where they are: what a step costs without kinematics.
pub fn held<const N: usize>(steps: u64) {
    let setup = |name: &str| RobotSetup::new(name, Gantry::default(), ExactDrive::new(Q::zeros(), PERIOD));
    run::<Gantry, N, _>(&setup, Hold::<N, Gantry> { left: steps, of: core::marker::PhantomData });
}

/// N IRp-6 along circles by poses, with drives that follow exactly.
pub fn by_poses<const N: usize>(steps: u64) {
    let setup = |name: &str| RobotSetup::new(name, Irp6::nominal(), ExactDrive::new(start(), PERIOD));
    run::<Irp6, N, _>(&setup, Circle::<N> { left: steps, t: 0.0 });
}

/// The same with the simulated arms' dynamics.
pub fn with_dynamics<const N: usize>(steps: u64) {
    let setup =
        |name: &str| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start()));
    run::<Irp6, N, _>(&setup, Circle::<N> { left: steps, t: 0.0 });
}

/// N gantries with jerk limits that go there and back along a polynomial without a jump in its jerk.
pub fn jerk_limited<const N: usize>(steps: u64) {
    let setup =
        |name: &str| RobotSetup::new(name, Gantry::with_jerk(100.0), ExactDrive::new(Q::zeros(), PERIOD));
    run::<Gantry, N, _>(&setup, Swing::<N> { left: steps, t: 0.0 });
}

/// To and fro in joints, from rest.
struct Swing<const N: usize> {
    left: u64,
    t: f64,
}

#[generator(mp)]
fn swing<const N: usize>(c: &mut Swing<N>, t: Tick) -> Step<[Gantry; N]> {
    if c.left == 0 {
        return Step::Done;
    }
    c.left -= 1;
    c.t += t.dt;
    // x⁴ at the start: position, velocity, acceleration and jerk begin at 0.
    let sin = c.t.sin();
    Step::Next([Demand::joints(Q::repeat(0.1 * sin.powi(4))); N])
}

/// A robot whose own program moves it by its state and the reading of a virtual sensor of its own.
pub fn sensed(steps: u64) {
    let robot = RobotSetup::new("r0", Gantry::default(), ExactDrive::new(Q::zeros(), PERIOD));
    Cell::new(PERIOD)
        .robot(robot.program(move |ecp| {
            let mut height = ecp.sensor::<Height>("height")?;
            ecp.move_robot((&mut height,), Pressing { left: steps }).map(drop)
        }))
        .sensor(SensorSetup::new("height", Above).of("r0"))
        .run()
        .expect("the motion keeps the limits");
}

/// The height of a tool \[m\].
struct Height;

#[derive(Clone, Copy, Payload)]
struct Metres {
    metres: f64,
}

impl Sensor for Height {
    const KIND: &'static str = "height";
    type Reading = Metres;
    type Configuration = ();
}

struct Above;

impl VirtualSensor for Above {
    type Kind = Height;
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Metres, Fault> {
        Ok(Metres { metres: order.robot.map_or(0.0, |robot| robot.joints[2]) })
    }
}

struct Pressing {
    left: u64,
}

#[generator(ecp)]
fn pressing(c: &mut Pressing, e: &State<Gantry>, v: &Reading<(Height,)>) -> Step<Gantry> {
    if c.left == 0 {
        return Step::Done;
    }
    c.left -= 1;
    let mut q = e.demanded().joints;
    q[2] += 1e-6 * (0.1 - v.0.reading().map_or(0.0, |reading| reading.metres));
    Step::Next(Demand::joints(q))
}

/// What a cell of a plant is told: to hold for so many steps.
#[derive(Clone, Copy, Payload)]
enum Job {
    Hold { steps: u64 },
}

struct Holding<const CELLS: usize>(u64);

#[generator(mp)]
fn holding<const CELLS: usize>(c: &mut Holding<CELLS>) -> Always<[LowerCell; CELLS], Job> {
    Always([Job::Hold { steps: c.0 }; CELLS])
}

/// A plant of cells of four gantries each that hold where they are: what a step of all of them costs.
pub fn cells_of_four<const CELLS: usize>(steps: u64) {
    let lower = || {
        let names: [String; 4] = core::array::from_fn(|i| format!("r{i}"));
        let setup =
            |name: &String| RobotSetup::new(name, Gantry::default(), ExactDrive::new(Q::zeros(), PERIOD));
        let cell = names.iter().map(setup).fold(Cell::new(PERIOD), Cell::robot);
        cell.program(move |mp| {
            let mut robots = Vec::new();
            for name in &names {
                robots.push(mp.robot::<Gantry>(name)?);
            }
            mp.serve_all(|mp, Job::Hold { steps }| {
                let mut handles = robots.iter_mut();
                let list = core::array::from_fn(|_| handles.next().expect("one handle per name"));
                mp.move_robots(list, (), Hold::<4, Gantry> { left: steps, of: core::marker::PhantomData })
                    .map(drop)
            })
        })
    };
    let plant = (0..CELLS).fold(Cell::new(PERIOD), |plant, i| plant.cell(&format!("c{i}"), lower()));
    plant
        .program(move |mp| {
            let mut cells = Vec::new();
            for i in 0..CELLS {
                cells.push(mp.robot::<LowerCell>(&format!("c{i}"))?);
            }
            let mut handles = cells.iter_mut();
            let list = core::array::from_fn(|_| handles.next().expect("one handle per cell"));
            mp.move_robots(list, (), Holding::<CELLS>(steps)).map(drop)
        })
        .run()
        .expect("nothing moves");
}
