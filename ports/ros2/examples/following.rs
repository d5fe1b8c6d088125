//! An arm whose tool follows the twists of a topic, shown to others at the port `servo`.

use mrroc::launch::own_number;
use mrroc::prelude::*;
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

// ANCHOR: cell
/// Makes the cell of `servo.toml`.
///
/// # Errors
/// What is wrong in the file.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let stick = External::<Stick>::in_cell(file, "stick")?.stand_in(UpAndDown);
    Ok(file.cell(&simulated())?.sensor(stick).program(servo).shown_to(Subscribers::at("servo")))
}

fn servo(mp: &mut Mp) -> Result<(), Fault> {
    let seconds = own_number("seconds", 60.0)?;
    let (mut arm, mut stick) = (mp.robot::<Irp6>("arm")?, mp.sensor::<Stick>("stick")?);
    // Its publisher may still be starting.
    mp.wait_until((), (&mut stick,), Heard)?;
    let twist = FollowTwist { pose: arm.demanded().pose, twist: Twist::default(), left: seconds };
    mp.move_robots((&mut arm,), (&mut stick,), twist)?;
    Ok(())
}
// ANCHOR_END: cell

/// A twist has come.
struct Heard;

#[condition(mp)]
fn heard(_: &mut Heard, stick: &Reading<(Stick,)>) -> bool {
    stick.0.reading().is_some()
}

// ANCHOR: follow
/// The age of a twist that is followed no longer \[s\].
const DEADLINE: f64 = 0.1;
/// How fast velocities change [m/s², rad/s²].
const ACCELERATIONS: [f64; 2] = [0.5, 2.0];

/// Moves the tool as the newest twist says. When no new one comes, it comes to rest and waits; it ends at rest.
struct FollowTwist {
    pose: Pose,
    twist: Twist,
    /// Time that is left \[s\].
    left: f64,
}

#[generator(mp)]
fn follow_twist(c: &mut FollowTwist, stick: &Reading<(Stick,)>, t: Tick) -> Result<Step<(Irp6,)>, Fault> {
    c.left -= t.dt;
    let is_new = f64::from(stick.0.age()) * t.duration <= DEADLINE && c.left > 0.0;
    let wanted = stick.0.reading().filter(|_| is_new).unwrap_or_default();
    let [linear, angular] = ACCELERATIONS.map(|acceleration| acceleration * t.dt);
    c.twist.linear = towards(c.twist.linear, wanted.linear, linear);
    c.twist.angular = towards(c.twist.angular, wanted.angular, angular);
    let turn = UnitQuaternion::from_scaled_axis(c.twist.angular * t.dt);
    c.pose *= Pose::from_parts(Translation3::from(c.twist.linear * t.dt), turn);
    c.pose.rotation.renormalize_fast();
    let at_rest = c.twist.linear == Vector3::zeros() && c.twist.angular == Vector3::zeros();
    Ok(if c.left <= 0.0 && at_rest { Step::Done } else { Step::Next((Demand::pose(c.pose),)) })
}

/// `v`, changed towards `goal` by at most `most`.
fn towards(v: Vector3<f64>, goal: Vector3<f64>, most: f64) -> Vector3<f64> {
    let left = goal - v;
    if left.norm() <= most { goal } else { v + left * (most / left.norm()) }
}
// ANCHOR_END: follow
