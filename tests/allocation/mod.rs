//! No allocation in a step once warm: counted over whole cells, whose processes are all of one thread.

mod counting;

use mrroc::prelude::*;
use mrroc::sensor::VspMode;
use mrroc_counting_allocator::allocations;
use mrroc_robots::{Irp6, SimulatedIrp6, Six};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// Where the arm works: above the plate, tool down.
fn start() -> Six {
    let flange = mrroc::pose::Pose::from_parts(
        Translation3::new(0.85, 0.0, 0.35),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI),
    );
    let near = Irp6::READY;
    mrroc::robot::Robot::inverse(&Irp6::nominal(), &flange, &near).expect("within reach")
}

struct Tilt;

impl Sensor for Tilt {
    const KIND: &'static str = "tilt";
    type Reading = Angle;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Angle {
    angle: f64,
}

struct Level;

impl VirtualSensor for Level {
    type Kind = Tilt;
    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Angle, Fault> {
        Ok(Angle { angle: order.robot.map_or(0.0, |robot| robot.joints[1]) })
    }
}

/// Both arms along a circle of 10 mm by their poses, with every kind of feedback.
struct Circles {
    t: f64,
    start: [Vector3<f64>; 2],
    seen: f64,
}

#[generator(mp, first = begin)]
fn circles(
    c: &mut Circles,
    e: &State<(Irp6, Irp6)>,
    v: &Reading<(Tilt, Tilt)>,
    t: Tick,
) -> Step<(Irp6, Irp6)> {
    if c.t >= 20.0 {
        return Step::Done;
    }
    c.t += t.dt;
    c.seen += v.0.reading().map_or(0.0, |reading| reading.angle) + e.1.measured().joints[2];
    // The angle grows smoothly from 0, so that the circle begins at rest.
    let phase = (c.t - (2.0 * c.t).sin() / 2.0) / 2.0;
    let offset = Vector3::new(phase.cos() - 1.0, phase.sin(), 0.0) * 0.01;
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let pose =
        |i: usize| Demand::pose(mrroc::pose::Pose::from_parts(Translation3::from(c.start[i] + offset), down));
    Step::Next((pose(0), pose(1)))
}

fn begin(c: &mut Circles, e: &State<(Irp6, Irp6)>, v: &Reading<(Tilt, Tilt)>, t: Tick) -> Step<(Irp6, Irp6)> {
    c.start = [e.0.demanded().pose.translation.vector, e.1.demanded().pose.translation.vector];
    circles(c, e, v, t)
}

#[test]
fn a_step_of_two_arms_with_sensors_in_three_modes_allocates_nothing() {
    let robot = |name| RobotSetup::new(name, Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start()));
    let step = std::time::Duration::from_millis(2);
    let counts = std::rc::Rc::new(std::cell::Cell::new((0, 0)));
    let seen = std::rc::Rc::clone(&counts);
    Cell::new(step)
        .robot(robot("left"))
        .robot(robot("right"))
        .sensor(SensorSetup::new("a", Level).of("left"))
        .sensor(SensorSetup::new("b", Level).of("right").mode(VspMode::WithDelay))
        .sensor(SensorSetup::new("c", Level).mode(VspMode::NonInteractive(step)))
        .on_step(move |step, _| match step {
            100 => seen.set((allocations(), 0)),
            9_000 => seen.set((seen.get().0, allocations())),
            _ => {}
        })
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
            let (mut a, mut b) = (mp.sensor::<Tilt>("a")?, mp.sensor::<Tilt>("b")?);
            let circles = Circles { t: 0.0, start: [Vector3::zeros(); 2], seen: 0.0 };
            mp.move_robots((&mut left, &mut right), (&mut a, &mut b), circles).map(drop)
        })
        .run()
        .expect("the circles keep the limits");
    let (warm, end) = counts.get();
    assert!(warm > 0, "nothing was counted");
    assert_eq!(end - warm, 0, "allocations in 8900 steps");
}
