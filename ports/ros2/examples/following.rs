//! An arm whose tool follows the twists, or the poses, of a topic, shown to others at the port `servo`.

use core::marker::PhantomData;

use mrroc::generator::{Generator, Motion};
use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use mrroc_external::{External, Subscribers};
use mrroc_robots::{Irp6, simulated};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

// ANCHOR: kind
/// A velocity of the tool, in the axes of the tool. The frame that a `TwistStamped` names is not looked at.
#[derive(Clone, Copy, Debug, Default, Payload)]
struct Twist {
    /// [m/s].
    linear: Vector3<f64>,
    /// [rad/s].
    angular: Vector3<f64>,
}

/// Where somebody wants the tool to go.
struct Stick;

impl Sensor for Stick {
    const KIND: &'static str = "stick";
    type Reading = Twist;
    type Configuration = ();
}

/// Where somebody wants the tool to be, in the world.
#[derive(Clone, Copy, Debug, Payload)]
struct Target {
    pose: Pose,
}

/// What it is read from.
struct Goal;

impl Sensor for Goal {
    const KIND: &'static str = "goal";
    type Reading = Target;
    type Configuration = ();
}
// ANCHOR_END: kind

/// In its place under the virtual clock: up and down, once in four seconds.
struct UpAndDown;

impl VirtualSensor for UpAndDown {
    type Kind = Stick;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Twist, Fault> {
        let t = order.step as f64 * 0.002;
        let z = 0.05 * (core::f64::consts::FRAC_PI_2 * t).sin();
        Ok(Twist { linear: Vector3::z() * z, angular: Vector3::zeros() })
    }
}

/// In its place under the virtual clock: where the arm begins, and 5 cm above it, for two seconds each.
struct BetweenTwo;

impl VirtualSensor for BetweenTwo {
    type Kind = Goal;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Target, Fault> {
        let start = Irp6::nominal().forward(&Irp6::READY) * Pose::translation(0.0, 0.0, 0.12);
        let z = if order.step % 2000 < 1000 { 0.0 } else { 0.05 };
        Ok(Target { pose: Pose::translation(0.0, 0.0, z) * start })
    }
}

// ANCHOR: cell
/// Makes the cell of `servo.toml`, or of `poses.toml`, which has the sensor `goal`.
///
/// # Errors
/// What is wrong in the file.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file.cell(&simulated())?;
    let cell = if file.external("goal").is_ok() {
        let goal = External::<Goal>::in_cell(file, "goal")?.stand_in(BetweenTwo);
        cell.sensor(goal).program(|mp| servo::<Goal, _>(mp, "goal", FollowPose))
    } else {
        let stick = External::<Stick>::in_cell(file, "stick")?.stand_in(UpAndDown);
        cell.sensor(stick).program(|mp| servo::<Stick, _>(mp, "stick", FollowTwist))
    };
    Ok(cell.shown_to(Subscribers::at("servo")))
}

fn servo<S, G>(mp: &mut Mp, name: &str, follow: fn(Tool) -> G) -> Result<(), Fault>
where
    S: Sensor<Configuration = ()>,
    G: Generator<Robots = (Irp6,), Language = Motion, Sensors = (S,), Order = ()>,
{
    let (mut arm, mut sensor) = (mp.robot::<Irp6>("arm")?, mp.sensor::<S>(name)?);
    // Its publisher may still be starting.
    mp.wait_until((), (&mut sensor,), Heard::default())?;
    let tool =
        Tool { pose: arm.demanded().pose, twist: Twist::default(), left: own_number("seconds", 60.0)? };
    mp.move_robots((&mut arm,), (&mut sensor,), follow(tool))?;
    Ok(())
}
// ANCHOR_END: cell

/// A reading has come.
struct Heard<S>(PhantomData<S>);

impl<S> Default for Heard<S> {
    fn default() -> Self {
        Heard(PhantomData)
    }
}

#[condition(mp)]
impl<S: Sensor> Heard<S> {
    fn is_met(&mut self, of: &Reading<(S,)>) -> bool {
        of.0.reading().is_some()
    }
}

// ANCHOR: follow
/// The age of a reading that is followed no longer \[s\].
const DEADLINE: f64 = 0.1;
/// How fast velocities change [m/s², rad/s²].
const ACCELERATIONS: [f64; 2] = [0.5, 2.0];
/// The largest velocities towards a pose [m/s, rad/s].
const SPEEDS: [f64; 2] = [0.1, 0.4];

/// A tool that moves as it is told, within [`ACCELERATIONS`].
struct Tool {
    pose: Pose,
    twist: Twist,
    /// Time that is left \[s\].
    left: f64,
}

impl Tool {
    /// Changes its velocity towards `wanted`, or towards rest without one; it ends at rest.
    fn go(&mut self, wanted: Option<Twist>, t: Tick) -> Step<(Irp6,)> {
        self.left -= t.dt;
        let wanted = wanted.filter(|_| self.left > 0.0).unwrap_or_default();
        let [linear, angular] = ACCELERATIONS.map(|acceleration| acceleration * t.dt);
        self.twist.linear = towards(self.twist.linear, wanted.linear, linear);
        self.twist.angular = towards(self.twist.angular, wanted.angular, angular);
        let turn = UnitQuaternion::from_scaled_axis(self.twist.angular * t.dt);
        self.pose *= Pose::from_parts(Translation3::from(self.twist.linear * t.dt), turn);
        self.pose.rotation.renormalize_fast();
        let at_rest = self.twist.linear == Vector3::zeros() && self.twist.angular == Vector3::zeros();
        if self.left <= 0.0 && at_rest { Step::Done } else { Step::Next((Demand::pose(self.pose),)) }
    }

    /// The twist that leads to a pose: at the largest velocity, then slower in proportion to what is left.
    fn twist_to(&self, goal: &Pose) -> Twist {
        let left = self.pose.inv_mul(goal);
        let [linear, angular] = [0, 1].map(|i| (SPEEDS[i], ACCELERATIONS[i] / SPEEDS[i]));
        let slower = |left: Vector3<f64>, (most, rate): (f64, f64)| (left * rate).cap_magnitude(most);
        Twist {
            linear: slower(left.translation.vector, linear),
            angular: slower(left.rotation.scaled_axis(), angular),
        }
    }
}

/// Moves the tool as the newest twist says. When no new one comes, it comes to rest and waits.
struct FollowTwist(Tool);

#[generator(mp)]
fn follow_twist(c: &mut FollowTwist, stick: &Reading<(Stick,)>, t: Tick) -> Result<Step<(Irp6,)>, Fault> {
    Ok(c.0.go(new(&stick.0, t), t))
}

/// Moves the tool to the newest pose. When no new one comes, it comes to rest and waits.
struct FollowPose(Tool);

#[generator(mp)]
fn follow_pose(c: &mut FollowPose, goal: &Reading<(Goal,)>, t: Tick) -> Result<Step<(Irp6,)>, Fault> {
    let wanted = new(&goal.0, t).map(|goal| c.0.twist_to(&goal.pose));
    Ok(c.0.go(wanted, t))
}

/// The last reading, if it is no older than the deadline.
fn new<S: Sensor>(of: &SensorImage<S>, t: Tick) -> Option<S::Reading> {
    of.reading().filter(|_| f64::from(of.age()) * t.duration <= DEADLINE)
}

/// `v`, changed towards `goal` by at most `most`.
fn towards(v: Vector3<f64>, goal: Vector3<f64>, most: f64) -> Vector3<f64> {
    v + (goal - v).cap_magnitude(most)
}
// ANCHOR_END: follow
