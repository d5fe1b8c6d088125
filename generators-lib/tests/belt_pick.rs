//! The whole program of the book's page about grippers and belts: a pick from a belt that goes on. Shown there word for word.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::observe::ServoRecord;
// ANCHOR: pick
use std::time::Duration;

use mrroc::prelude::*;
use mrroc_generators::combinators::Sequence;
use mrroc_generators::cooperation::Functional;
use mrroc_generators::generators::{JointMove, JointVelocity, MovingFrame, Sleep, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Conveyor, Gripper, Irp6, One, Simulated, SimulatedIrp6};

/// How fast the belt runs [m/s].
const BELT: f64 = 0.03;
/// The part is so far below the tool at its start [m].
const DEPTH: f64 = 0.1;

/// A camera over the belt, which runs along y.
struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Seen;
    type Configuration = ();
}

/// Where it sees the part.
#[derive(Clone, Copy, Payload)]
struct Seen {
    y: f64, // in the world [m]
}

/// The simulated camera: a part was laid on the belt 0.3 m before the arm. A real one asks its hardware here.
struct Laid;

impl VirtualSensor for Laid {
    type Kind = Camera;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Seen, Fault> {
        let belt = order.robot.ok_or_else(|| Fault::thrown("the camera is of no belt"))?;
        Ok(Seen { y: belt.joints[0] - 0.3 })
    }
}

/// Holds when the part has come to where the arm can take it, and remembers where that is.
struct Comes {
    y: f64,
}

#[condition(mp)]
fn comes(c: &mut Comes, v: &Reading<(Camera,)>) -> bool {
    c.y = v.0.reading().map_or(f64::NEG_INFINITY, |seen| seen.y);
    c.y > -0.15
}

/// From 0 to 1 within a second from `start` [s], without a step in velocity or acceleration.
fn ramp(age: f64, start: f64) -> f64 {
    let s = (age - start).clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

fn pick(mp: &mut Mp) -> Result<(), Fault> {
    let (mut arm, mut hand) = (mp.robot::<Irp6>("arm")?, mp.robot::<Gripper>("hand")?);
    let (mut belt, mut camera) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<Camera>("camera")?);
    let fingers = |opening| JointMove::to(One::new(opening), One::new(0.008), One::new(0.018));
    let start = arm.demanded().pose; // the tool points down

    // The belt runs from now on, beside all that follows.
    mp.start_robot(&mut belt, JointVelocity::of(One::new(BELT), One::new(0.04)))?;
    let part = mp.wait_until((&mut arm,), (&mut camera,), Comes { y: 0.0 })?;

    // Where the tool is to be: 80 mm above the part, down to it from 2 s on, up again from 5.5 s on.
    let place = Functional::new(move |age| {
        let height = 0.08 * (1.0 - ramp(age, 2.0) + ramp(age, 5.5));
        Pose::translation(0.0, part.y + BELT * age - start.translation.y, height - DEPTH) * start
    });
    // The tool is there after 2 s and goes on with it. Meanwhile the hand waits until the tool is down, and closes.
    let follow = MovingFrame::to(place, Pose::identity(), 2.0, 6.5);
    let close = Sequence::of(Sleep::lasting(3.0), fingers(0.06));
    mp.move_robots((&mut arm, &mut hand), (), Each::of((follow, close)))?; // and the arm brakes

    // Into the bin, 0.15 m behind the start.
    let limits = ProfileLimits { velocity: 0.1, acceleration: 0.4 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    let bin = Pose::translation(0.0, -0.15, -0.05) * start;
    mp.move_robot(&mut arm, (), StraightLine::to(bin, limits))?;
    mp.move_robot(&mut hand, (), fingers(0.075))?;
    mp.end_robot(&mut belt)
}

/// The cell: in a task project `cell.toml` says this.
fn cell(arm: RobotSetup<Irp6>, hand: RobotSetup<Gripper>, belt: RobotSetup<Conveyor>) -> Cell {
    Cell::new(Duration::from_millis(2))
        .robot(arm)
        .robot(hand.following_error(One::new(0.04))) // fingers stay behind their demand at what they hold
        .robot(belt.stop_time(Duration::from_secs(5))) // a belt is slow to stop
        .sensor(SensorSetup::new("camera", Laid).of("belt")) // its orders bring where the belt is
        .program(pick)
}

fn robots() -> (RobotSetup<Irp6>, RobotSetup<Gripper>, RobotSetup<Conveyor>) {
    let start = Irp6::READY;
    let (irp6, fingers, belt) = (Irp6::nominal(), Gripper::new(), Conveyor::new());
    (
        RobotSetup::new("arm", irp6.clone(), SimulatedIrp6::new(irp6, &start)),
        RobotSetup::new("hand", fingers.clone(), Simulated::new(fingers, &One::new(0.075))),
        RobotSetup::new("belt", belt.clone(), Simulated::new(belt, &One::new(0.0))),
    )
}
// ANCHOR_END: pick

type Trace<T> = Rc<RefCell<Vec<T>>>;

#[test]
fn a_part_is_taken_from_a_belt_that_goes_on_and_put_into_the_bin() {
    let (tool, opening, positions): (Trace<_>, Trace<_>, Trace<_>) = Default::default();
    let (of_tool, of_hand, of_belt) = (Rc::clone(&tool), Rc::clone(&opening), Rc::clone(&positions));
    let (arm, hand, belt) = robots();
    let model = Irp6::nominal();
    let arm = arm.observe(move |record: &ServoRecord<Irp6>| {
        of_tool.borrow_mut().push(model.forward(&record.measured.position).translation.vector);
    });
    let hand = hand.observe(move |record: &ServoRecord<Gripper>| {
        of_hand.borrow_mut().push((record.demanded[0], record.measured.position[0]));
    });
    let belt = belt.observe(move |record: &ServoRecord<Conveyor>| {
        of_belt.borrow_mut().push(record.measured.position[0])
    });
    cell(arm, hand, belt).run().expect("within the limits");
    let (tool, opening, positions) = (tool.borrow(), opening.borrow(), positions.borrow());
    let start = tool[0];
    // From the first step in which the fingers close to the last one, the tool is at the part, which moves.
    let closes = |i: &usize| opening[*i].0 < 0.075 - 1e-6 && opening[*i].0 > 0.06 + 1e-6;
    let closing: Vec<_> = (0..opening.len()).filter(closes).collect();
    let first = *closing.first().expect("they close");
    let closed = (first..opening.len()).find(|&i| opening[i].0 <= 0.06 + 1e-6).expect("they have closed");
    for i in first..closed {
        let part = nalgebra::Vector3::new(start.x, positions[i] - 0.3, start.z - DEPTH);
        assert!((tool[i] - part).norm() < 1.5e-3, "{i}: {} {part}", tool[i]);
    }
    assert!(
        (positions[closed] - positions[first] - BELT * 2e-3 * (closed - first) as f64).abs() < 1e-3,
        "the belt went on"
    );
    // Closed, the tool goes up by 80 mm while it still goes on with the belt.
    let up = closed + 650;
    assert!((tool[up].z - start.z + DEPTH - 0.08).abs() < 2e-3, "{}", tool[up]);
    // The fingers open where the bin is.
    let opens = (up..opening.len()).find(|&i| opening[i].0 > 0.06 + 1e-6).expect("they open");
    let bin = start + nalgebra::Vector3::new(0.0, -0.15, -0.05);
    assert!((tool[opens] - bin).norm() < 1e-3, "{}", tool[opens]);
    assert!((opening[opening.len() - 1].1 - 0.075).abs() < 1e-3);
}
