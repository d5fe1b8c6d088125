//! The programs of the book's pages about URDF arms, grippers and belts, blending, conditions, signals and teaching: shown there
//! word for word.

use std::cell::RefCell;
use std::error::Error;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::{InputSetup, OutputSetup, RunReport};
use mrroc::observe::ServoRecord;
// ANCHOR: imports
use mrroc::prelude::*; // Mp, Ecp, Fault, Pose, Demand, Step, Each ..
use mrroc_generators::conditions::{ConditionExt, all, any, elapsed, elapsed_since, not};
use mrroc_generators::cooperation::Functional; // frames that move
use mrroc_generators::generators::{Jog, JointMove, JointVelocity, MovingFrame, Replay, StraightLine};
use mrroc_generators::line::ToolLimits; // of a tool: translation and rotation
use mrroc_generators::profile::{ProfileLimits, Trapezoid}; // velocity and acceleration
use mrroc_generators::teach::{Jogging, Taught, TaughtFile}; // taught poses and their files
use mrroc_robots::{Conveyor, Gripper, Irp6, One, Serial, Simulated, SimulatedIrp6, Six}; // robots; joints: One, Five to Seven
// ANCHOR_END: imports
use mrroc::robot::{Channel, Input};
use mrroc_generators::generators::Tell;
use nalgebra::Vector3;

fn start() -> Six {
    Irp6::READY
}

fn limits(velocity: f64, acceleration: f64) -> ToolLimits {
    let limits = ProfileLimits { velocity, acceleration };
    ToolLimits { translation: limits, rotation: limits }
}

const URDF: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/tests/reference/urdf/ortho_parallel.urdf");

// ANCHOR: urdf
fn urdf_arm(path: &str) -> Result<RunReport, Box<dyn Error>> {
    let arm = Serial::<6>::from_urdf_file(path, "base_link", "tool0")? // links of the file: the base, and the flange
        .with_acceleration(Six::repeat(15.0))? // [rad/s²]: a URDF does not say it
        .with_base(Pose::translation(0.0, 0.0, 0.5)); // where the base stands in the world
    let start = Six::new(0.1, -0.3, 0.4, 0.2, 0.7, -0.1);
    let drives = Simulated::new(arm.clone(), &start);
    let robot = RobotSetup::new("arm", arm, drives).program(|ecp| {
        let down = Pose::translation(0.0, 0.0, 0.1); // along the z axis of the tool
        ecp.move_robot((), StraightLine::by(down, limits(0.2, 0.5))).map(drop)
    });
    Ok(Cell::new(Duration::from_millis(2)).robot(robot).run()?)
}
// ANCHOR_END: urdf

#[test]
fn an_arm_of_a_urdf_goes_along_a_line() {
    let report = urdf_arm(URDF).expect("nothing is wrong");
    // D / V + V / A.
    let time = report.time.as_secs_f64();
    assert!((0.9..0.93).contains(&time), "{time} s");
}

// ANCHOR: gripper
fn grip(gripper: &mut Ecp<Gripper>) -> Result<(), Fault> {
    let to = |opening| JointMove::to(One::new(opening), One::new(0.008), One::new(0.018));
    gripper.move_robot((), to(0.06))?; // [m] between the fingers
    gripper.wait_until((), closed {}.held_for(0.05))?;
    gripper.move_robot((), to(0.09)).map(drop)
}

/// The fingers have come to within 1 mm of what they are told, or stand still at what they hold.
#[condition(ecp)]
fn closed(e: &State<Gripper>) -> bool {
    let off = e.measured().joints[0] - e.demanded().joints[0];
    off.abs() < 1e-3 || e.measured().velocity[0].abs() < 1e-4
}
// ANCHOR_END: gripper

// ANCHOR: gripper_setup
fn gripper(start: f64) -> RobotSetup<Gripper> {
    let fingers = Gripper::new();
    let limits = *fingers.limits();
    let drives = Simulated::new(fingers.clone(), &One::new(start));
    // The fingers may stay behind their demand by as much as they open: what they hold stops them.
    RobotSetup::new("gripper", fingers, drives).following_error(limits.upper - limits.lower)
}
// ANCHOR_END: gripper_setup

#[test]
fn a_gripper_closes_and_opens() {
    let cell = Cell::new(Duration::from_millis(2)).robot(gripper(0.08).program(grip));
    let time = cell.run().expect("nothing is wrong").time.as_secs_f64();
    // 0.02 and 0.03 m at 0.008 m/s and 0.018 m/s²: D / V + V / A each, and 25 steps of the condition at least.
    let moves = (0.02 + 0.03) / 0.008 + 2.0 * 0.008 / 0.018;
    assert!((moves + 0.05..moves + 0.2).contains(&time), "{time} s, not {moves} s");
}

// ANCHOR: belt
fn follow_the_belt(mp: &mut Mp) -> Result<(), Fault> {
    let (mut arm, mut belt) = (mp.robot::<Irp6>("irp6")?, mp.robot::<Conveyor>("belt")?);
    // The belt runs by 0.1 m: it speeds up for a second, runs at 0.04 m/s, and slows down for a second.
    let (distance, limits) = (0.1, ProfileLimits { velocity: 0.04, acceleration: 0.04 }); // of 0.2 m/s and 0.05 m/s²
    let run = JointMove::to(One::new(distance), One::new(limits.velocity), One::new(limits.acceleration));
    // The part lies below the tool at the start, and moves with the belt along y.
    let belts = Trapezoid::new(distance, limits).map_err(|bad| Fault::thrown(&bad.to_string()))?;
    let above = arm.demanded().pose;
    let part = Functional::new(move |age| Pose::translation(0.0, belts.at(age).s, 0.0) * above);
    // The tool is above the part after 2 s, and goes on with it until the belt stands.
    let follow = MovingFrame::to(part, Pose::identity(), 2.0, belts.duration());
    mp.move_robots((&mut arm, &mut belt), (), Each::of((follow, run))).map(drop)
}
// ANCHOR_END: belt

#[test]
fn a_tool_goes_on_with_a_belt() {
    let irp6 = Irp6::nominal();
    let seen = Rc::new(RefCell::new(Vec::new()));
    let (of_belt, of_arm) = (Rc::clone(&seen), Rc::new(RefCell::new(Vec::new())));
    let arm_seen = Rc::clone(&of_arm);
    let model = irp6.clone();
    let arm = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6.clone(), &start())).observe(
        move |record: &ServoRecord<Irp6>| {
            arm_seen.borrow_mut().push(model.forward(&record.demanded).translation.y);
        },
    );
    let belt = Conveyor::new();
    let belt = RobotSetup::new("belt", belt.clone(), Simulated::new(belt, &One::new(0.0)))
        .observe(move |record: &ServoRecord<Conveyor>| of_belt.borrow_mut().push(record.demanded[0]));
    let cell = Cell::new(Duration::from_millis(2)).stop_time(Duration::from_secs(5)); // 0.2 m/s at 0.05 m/s²
    let cell = cell.robot(arm).robot(belt).program(follow_the_belt);
    cell.run().expect("within the limits");
    let (belt, arm) = (seen.borrow(), of_arm.borrow());
    // Between 2.1 s and 2.4 s the tool moves as the belt does.
    let moved = |of: &[f64]| of[1200] - of[1050];
    assert!((moved(&belt) - 0.04 * 0.3).abs() < 1e-5, "{}", moved(&belt));
    assert!((moved(&arm) - moved(&belt)).abs() < 1e-5, "{} {}", moved(&arm), moved(&belt));
}

// ANCHOR: background
fn beside_a_running_belt(mp: &mut Mp) -> Result<(), Fault> {
    let (mut arm, mut belt) = (mp.robot::<Irp6>("irp6")?, mp.robot::<Conveyor>("belt")?);
    let run = |speed: f64| JointVelocity::of(One::new(speed), One::new(0.04)); // [m/s], [m/s²]
    let here = arm.demanded().joints;
    let to = |q: Six| JointMove::to(q, Six::repeat(0.4), Six::repeat(0.8));
    mp.start_robot(&mut belt, run(0.04))?; // returns at once
    mp.move_robot(&mut arm, (), to(here + Six::x() * 0.4))?;
    mp.start_robot(&mut belt, run(0.02))?; // slower, without a stop
    mp.move_robot(&mut arm, (), to(here))?;
    mp.end_robot(&mut belt) // brakes it
}
// ANCHOR_END: background

#[test]
fn a_belt_runs_beside_an_arm() {
    let irp6 = Irp6::nominal();
    let seen = Rc::new(RefCell::new(Vec::new()));
    let of_belt = Rc::clone(&seen);
    let arm = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6, &start()));
    let belt = Conveyor::new();
    let belt = RobotSetup::new("belt", belt.clone(), Simulated::new(belt, &One::new(0.0)))
        .stop_time(Duration::from_secs(5))
        .observe(move |record: &ServoRecord<Conveyor>| of_belt.borrow_mut().push(record.demanded[0]));
    let cell = Cell::new(Duration::from_millis(2)).robot(arm).robot(belt);
    cell.program(beside_a_running_belt).run().expect("within the limits");
    // Two Moves of 0.4 / 0.4 + 0.4 / 0.8 = 1.5 s: 1 s to 0.04 m/s, 0.5 s at it, 0.5 s to 0.02 m/s, 1 s at it, and braking.
    let distance = 0.02 + 0.02 + 0.015 + 0.02;
    let end = seen.borrow().last().copied().unwrap_or_default() - distance;
    assert!((0.0..0.02 * 0.02 / (2.0 * 0.05) + 1e-3).contains(&end), "{end}");
}

// ANCHOR: blend
/// Joint 1 speeds up to 0.2 rad/s in 0.2 s, and is not stopped: its last step is as fast as the one before.
struct SpeedUp {
    q: Six,
    speed: f64,
}

#[generator(ecp, first = from_here)]
fn speed_up(c: &mut SpeedUp, t: Tick) -> Step<Irp6> {
    if c.speed >= 0.2 - 1e-9 {
        return Step::Done;
    }
    c.speed += 1.0 * t.dt;
    c.q[0] += c.speed * t.dt;
    Step::Next(Demand::joints(c.q))
}

fn from_here(c: &mut SpeedUp, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
    c.q = e.demanded().joints;
    speed_up(c, t)
}

/// It goes on at the speed that it finds, for a time.
struct GoOn {
    q: Six,
    speed: f64,
    left: f64,
}

#[generator(ecp, first = take_over)]
fn go_on(c: &mut GoOn, t: Tick) -> Step<Irp6> {
    c.left -= t.dt;
    if c.left < 0.0 {
        return Step::Done; // the runtime brakes it
    }
    c.q[0] += c.speed * t.dt;
    Step::Next(Demand::joints(c.q))
}

fn take_over(c: &mut GoOn, e: &State<Irp6>, t: Tick) -> Step<Irp6> {
    let now = e.demanded(); // the end of the motion before, with its velocity
    (c.q, c.speed) = (now.joints, now.velocity[0]);
    go_on(c, t)
}

fn two_motions(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    ecp.blend_robot((), SpeedUp { q: Six::zeros(), speed: 0.0 })?;
    ecp.move_robot((), GoOn { q: Six::zeros(), speed: 0.0, left: 0.5 }).map(drop)
}
// ANCHOR_END: blend

#[test]
fn a_motion_takes_a_moving_robot_over() {
    let irp6 = Irp6::nominal();
    let recorded = Rc::new(RefCell::new(Vec::new()));
    let recorder = Rc::clone(&recorded);
    let robot = RobotSetup::new("irp6", irp6.clone(), SimulatedIrp6::new(irp6, &start()))
        .observe(move |record: &ServoRecord<Irp6>| recorder.borrow_mut().push(record.demanded[0]))
        .program(two_motions);
    Cell::new(Duration::from_millis(2)).robot(robot).run().expect("within the limits");
    let q = recorded.borrow();
    let speed: Vec<f64> = q.windows(2).map(|q| (q[1] - q[0]) / 2e-3).collect();
    // From the first step at 0.2 rad/s to the last: the end of the first motion, and the whole second one.
    let at_speed = speed.iter().filter(|v| (**v - 0.2).abs() < 1e-6).count();
    assert!((250..=252).contains(&at_speed), "{at_speed} steps");
    let first = speed.iter().position(|v| *v > 0.2 - 1e-6).expect("it speeds up");
    assert!(speed[first..first + at_speed].iter().all(|v| (v - 0.2).abs() < 1e-6), "no dip between them");
}

// ANCHOR: teach
fn jog_and_replay(mp: &mut Mp, panel: impl FnMut() -> Jogging, file: &Path) -> Result<(), Fault> {
    let mut arm = mp.robot::<Irp6>("irp6")?;
    let refused = |why: std::io::Error| Fault::thrown(&why.to_string());
    let kept = TaughtFile::begin(file, 0.5, 0.5, 100).map_err(refused)?; // shares for the replay, most poses
    let jog = Jog::by(panel, 0.5, 1.0, 100).kept_in(&kept); // [m/s²], [rad/s²], most poses
    mp.move_robot(&mut arm, (), jog)?; // whatever stops it: what was recorded is in the file
    kept.finish().map_err(refused)?;

    // The file may be edited before it is read.
    let text = std::fs::read_to_string(file).map_err(refused)?;
    let taught: Taught = text.parse().map_err(|why| Fault::thrown(&format!("{}: {why}", file.display())))?;
    // Largest velocities and accelerations: of each joint, and of the tool.
    let replay = Replay::of(taught, Six::repeat(0.4), Six::repeat(0.8), limits(0.1, 0.5));
    mp.move_robot(&mut arm, (), replay).map(drop)
}
// ANCHOR_END: teach

// ANCHOR: panel
/// What a person presses: along x for a second, and once more the other way; each place is recorded.
fn presses() -> impl FnMut() -> Jogging {
    let mut steps = 0;
    move || {
        steps += 1;
        let speed = match steps {
            ..=500 => 0.1,
            1001..=1500 => -0.05,
            _ => 0.0, // the tool comes to rest
        };
        let record = steps == 1000 || steps == 2000;
        Jogging { along: Vector3::x() * speed, record, done: steps > 2000, ..Jogging::default() }
    }
}
// ANCHOR_END: panel

#[test]
fn what_was_jogged_is_replayed_from_its_file() {
    let file = std::env::temp_dir().join("taught.txt");
    let drives = SimulatedIrp6::new(Irp6::nominal(), &start());
    let arm = RobotSetup::new("irp6", Irp6::nominal(), drives);
    let (to, end) = (file.clone(), Rc::new(RefCell::new(Pose::identity())));
    let reached = Rc::clone(&end);
    let cell = Cell::new(Duration::from_millis(2)).robot(arm);
    let cell = cell.program(move |mp| jog_and_replay(mp, presses(), &to));
    // The tool's frame comes last.
    let cell = cell.watch(move |robot| robot.frames(&mut |frame| *reached.borrow_mut() = *frame));
    cell.run().expect("nothing is wrong");
    let taught: Taught = std::fs::read_to_string(&file).expect("written").parse().expect("in order");
    assert_eq!(taught.poses.len(), 2);
    // 0.1 m/s for a second, and half of that back, along the x axis of the tool; the simulated arm sags by some µm at first.
    let irp6 = Irp6::nominal();
    let from = irp6.forward(&start());
    for (pose, distance) in taught.poses.iter().zip([0.1, 0.05]) {
        let at = from.inv_mul(&pose.pose(taught.space).expect("a pose")).translation.vector;
        assert!((at - Vector3::x() * distance).norm() < 1e-5, "{at}");
    }
    // The simulated arm follows within 0.2 mm.
    let at = from.inv_mul(&end.borrow()).translation.vector;
    assert!((at - Vector3::x() * 0.05).norm() < 2e-4, "replayed to {at}");
}

/// The arm is jogged along x until a joint would leave its limits, which ends the Move, the program and the cell.
#[test]
fn poses_that_were_taught_before_a_fault_are_in_their_file_and_more_can_be_added() {
    let file = std::env::temp_dir().join("taught_before_a_fault.txt");
    drop(std::fs::remove_file(&file));
    let run = |begins: bool| {
        let drives = SimulatedIrp6::new(Irp6::nominal(), &start());
        let arm = RobotSetup::new("irp6", Irp6::nominal(), drives);
        let to = file.clone();
        let cell = Cell::new(Duration::from_millis(2)).robot(arm).program(move |mp| {
            let mut arm = mp.robot::<Irp6>("irp6")?;
            let mut steps = 0;
            let panel = move || {
                steps += 1;
                let record = steps == 500 || steps == 1000;
                Jogging { along: Vector3::x() * 0.1, record, ..Jogging::default() }
            };
            let kept = match begins {
                true => TaughtFile::begin(&to, 0.5, 0.5, 9),
                false => TaughtFile::go_on(&to, 0.25, 0.5, 9),
            };
            let kept = kept.map_err(|why| Fault::thrown(&why.to_string()))?;
            mp.move_robot(&mut arm, (), Jog::by(panel, 0.5, 1.0, 9).kept_in(&kept)).map(drop)
        });
        let stopped = cell.run().expect_err("it is jogged out of reach").to_string();
        assert!(stopped.contains("Move 1 (Jog)"), "{stopped}");
        let text = std::fs::read_to_string(&file).expect("written");
        text.parse::<Taught>().expect("in order")
    };
    let from = Irp6::nominal().forward(&start());
    for (begins, poses) in [(true, 2), (false, 4), (true, 2)] {
        let taught = run(begins);
        assert_eq!(taught.poses.len(), poses);
        // 0.1 m/s, less what it lacks of the first 0.2 s; from the same start in each run.
        for (i, pose) in taught.poses.iter().enumerate() {
            let at = from.inv_mul(&pose.pose(taught.space).expect("a pose")).translation.vector;
            let distance = 0.1 * (1.0 + (i % 2) as f64) - 0.1 * 0.1 / (2.0 * 0.5);
            // In steps of 2 ms the ramp is longer by up to half of one.
            assert!((at - Vector3::x() * distance).norm() < 2e-4, "{at} {distance}");
            assert_eq!(pose.velocity, if i < 2 { 0.5 } else { 0.25 });
        }
    }
    let refused = TaughtFile::begin(&file, 0.0, 0.5, 9).expect_err("no share").to_string();
    assert!(refused.contains("above 0"), "{refused}");
    assert!(TaughtFile::begin("no/such/folder/taught.txt", 0.5, 0.5, 9).is_err());
}

struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Seen;
    type Configuration = ();
}

#[derive(Clone, Copy, Payload)]
struct Seen {
    part: bool,
    jam: bool,
}

// ANCHOR: conditions
#[condition(mp)]
fn part_seen(v: &Reading<(Camera,)>) -> bool {
    v.0.reading().is_some_and(|seen| seen.part)
}

#[condition(mp)]
fn jammed(v: &Reading<(Camera,)>) -> bool {
    v.0.reading().is_some_and(|seen| seen.jam)
}

#[condition(mp)]
fn fingers_closed(e: &State<(Gripper,)>) -> bool {
    e.0.measured().joints[0] < 0.07
}

fn wait_for_a_part(mp: &mut Mp) -> Result<(), Fault> {
    let (mut gripper, mut camera) = (mp.robot::<Gripper>("gripper")?, mp.sensor::<Camera>("camera")?);
    let held = all((part_seen {}, fingers_closed {}.held_for(0.2), not(jammed {})));
    let dry = elapsed_since(part_seen {}, 1.5); // glue: 1.5 s after a part was seen first
    mp.wait_until((&mut gripper,), (&mut camera,), any((all((held, dry)), elapsed(10.0)))).map(drop)
}
// ANCHOR_END: conditions

/// A part from the 501st reading on, after a second.
struct Looks(u32);

impl VirtualSensor for Looks {
    type Kind = Camera;
    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Seen, Fault> {
        self.0 += 1;
        Ok(Seen { part: self.0 > 500, jam: false })
    }
}

#[test]
fn a_wait_takes_as_long_as_its_conditions_say() {
    for (opening, seconds) in [(0.06, 1.0 + 1.5), (0.08, 10.0)] {
        let cell = Cell::new(Duration::from_millis(2)).robot(gripper(opening));
        let cell = cell.sensor(SensorSetup::new("camera", Looks(0))).program(wait_for_a_part);
        let time = cell.run().expect("nothing is wrong").time.as_secs_f64();
        assert!((seconds..seconds + 0.02).contains(&time), "{time} s");
    }
}

// ANCHOR: signals
/// Holds when an input reads on.
struct On(Input<bool>);

#[condition(mp)]
fn on(c: &mut On, e: &State<(Irp6,)>) -> bool {
    e.0.value(c.0)
}

fn grasp(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Irp6>("arm")?;
    let (vacuum, sucked) = (arm.output::<bool>("vacuum")?, arm.input::<bool>("sucked")?);
    mp.move_robot(&mut arm, (), Tell::output(vacuum, true))?;
    mp.wait_at_most((&mut arm,), (), On(sucked), 500)?;
    Ok(())
}
// ANCHOR_END: signals

#[test]
fn an_arm_grasps_by_a_vacuum() {
    let drives = SimulatedIrp6::new(Irp6::nominal(), &start());
    let arm = RobotSetup::new("arm", Irp6::nominal(), drives)
        .output(OutputSetup::new("vacuum", Channel::Digital(0)).holds_body())
        .input(InputSetup::new("sucked", Channel::Digital(4)).follows("vacuum", Duration::from_millis(150)));
    let cell = Cell::new(Duration::from_millis(2)).robot(arm).program(grasp);
    let time = cell.run().expect("its names are there").time.as_secs_f64();
    // The switch is 150 ms behind the vacuum.
    assert!((0.15..0.18).contains(&time), "{time} s");
}
