//! Arms, sensors and paths that the generators are tried on.

use std::f64::consts::PI;

use mrroc::generator::Generator;
use mrroc::operator::jog::{JogNow, JogOrder, JogPanel};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::JointVector as _;
use mrroc::robot::{Channel, Output, RobotImage, RobotState};
use mrroc::sensor::SensorImage;
use mrroc_generators::bspline::SplineSettings;
use mrroc_generators::combinators::{
    Arbitrate, Compliant, Corrected, CorrectionLimits, Handover, Override, Superpose,
};
use mrroc_generators::conformance::Given;
use mrroc_generators::cooperation::*;
use mrroc_generators::curve::{CurveError, Helix};
use mrroc_generators::feed::{FeedError, FeedLimits};
use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
use mrroc_generators::generators::*;
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::jogging::JogLimits;
use mrroc_generators::line::{SmoothToolLimits, ToolLimits};
use mrroc_generators::profile::{JerkLimits, ProfileLimits};
use mrroc_generators::teach::{Reference, Space, Taught, TaughtPose};
use mrroc_generators::timing::PathLimits;
use mrroc_generators::trajectory::{JointBounds, JointTrajectory, TrajectoryPoint};
use mrroc_generators::via::PoseDeviation;
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Six};
use nalgebra::{UnitQuaternion, Vector3};

pub use mrroc_counting_allocator::bytes;

pub type Two = [Irp6; 2];

/// A force and torque sensor.
pub struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

pub fn load(z: f64) -> SensorImage<Wrist> {
    SensorImage::new(Wrench::new(Vector3::new(0.1 * z, 0.0, z), Vector3::new(0.0, 0.01 * z, 0.0)), 0)
}

pub fn arm() -> Six {
    Irp6::READY
}

pub fn start() -> Pose {
    Irp6::nominal().forward(&arm())
}

fn at_rest<R: Robot>(robot: &R, q: R::Joints) -> RobotImage<R> {
    let state = RobotState { joints: q, velocity: R::Joints::zeros(), pose: robot.forward(&q) };
    RobotImage::new(state, state)
}

pub fn image() -> RobotImage<Irp6> {
    at_rest(&Irp6::nominal(), arm())
}

/// A pose near [`start`].
pub fn away() -> Pose {
    start() * Pose::new(Vector3::new(0.0, 0.01, 0.05), Vector3::new(0.1, 0.0, 0.0))
}

/// An arm at rest whose tool is at `pose`.
pub fn image_at(pose: Pose) -> RobotImage<Irp6> {
    let state = RobotState { pose, ..*image().demanded() };
    RobotImage::new(state, state)
}

pub fn five() -> RobotImage<Irp6FiveDof> {
    at_rest(&Irp6FiveDof::nominal(), Five::new(0.0, -1.5, 0.1, -0.170_796_326_794_896_6, 0.0))
}

pub fn pair_state() -> State<Two> {
    State::new([image(), at_rest(&Irp6::nominal().with_base(Pose::translation(0.0, 0.5, 0.0)), arm())])
}

/// One arm at rest, no sensors, no orders.
pub fn alone<G: Generator<Robots = Irp6, Sensors = (), Order = ()>>(_: u64) -> Given<G> {
    Given { order: Order::new(()), e: State::new(image()), v: Reading::new(()) }
}

/// Two arms at rest.
pub fn pair<G: Generator<Robots = Two, Sensors = (), Order = ()>>(_: u64) -> Given<G> {
    Given { order: Order::new(()), e: pair_state(), v: Reading::new(()) }
}

/// One arm at rest that feels a force along its tool's z axis \[N\].
pub fn pressed<G: Generator<Robots = Irp6, Sensors = (Wrist,), Order = ()>>(force: f64) -> Given<G> {
    Given { order: Order::new(()), e: State::new(image()), v: Reading::new((load(force),)) }
}

/// One arm at rest that is ordered a displacement along its tool's z axis \[m\].
pub fn ordered<G: Generator<Robots = Irp6, Sensors = (), Order = Displacement>>(z: f64) -> Given<G> {
    let pose = Pose::translation(0.0, 0.0, z);
    Given { order: Order::new(Displacement { pose }), e: State::new(image()), v: Reading::new(()) }
}

/// A pose that is moved in the plane of the tool \[m\].
pub fn beside(x: f64, y: f64) -> Pose {
    start() * Pose::translation(x, y, 0.0)
}

/// The arm with its first joint turned [rad].
pub fn turned(by: f64) -> Six {
    arm() + Six::x() * by
}

pub fn tool_limits(velocity: f64, acceleration: f64) -> ToolLimits {
    let limits = ProfileLimits { velocity, acceleration };
    ToolLimits { translation: limits, rotation: limits }
}

pub fn smooth_limits(velocity: f64, acceleration: f64, jerk: f64) -> SmoothToolLimits {
    let limits = JerkLimits { velocity, acceleration, jerk };
    SmoothToolLimits { translation: limits, rotation: limits }
}

/// A deviation from via poses [m], [rad].
pub fn within(distance: f64, angle: f64) -> PoseDeviation {
    PoseDeviation { distance, angle }
}

pub fn joint_limits(velocity: f64, acceleration: f64, jerk: f64) -> JointLimits<Six> {
    JointLimits {
        velocity: Six::repeat(velocity),
        acceleration: Six::repeat(acceleration),
        jerk: Six::repeat(jerk),
    }
}

pub fn path_limits(velocity: f64, acceleration: f64, speed: f64) -> PathLimits<Six> {
    PathLimits { velocity: Six::repeat(velocity), acceleration: Six::repeat(acceleration), speed }
}

/// Sizes that are none, one at a time and both.
pub fn odd_sizes(x: f64) -> [[f64; 2]; 4] {
    [[0.02, 8e-3], [x, 8e-3], [0.02, x], [x, x]]
}

/// Limits that are none, one at a time and all.
pub fn odd_limits(x: f64) -> [[f64; 3]; 5] {
    [[0.5, 1.0, 10.0], [x, 1.0, 10.0], [0.5, x, 10.0], [0.5, 1.0, x], [x, x, x]]
}

/// A helix beside the tool: radius and pitch \[m\], angle \[rad\].
pub fn helix(radius: f64, pitch: f64, angle: f64) -> Result<Helix, CurveError> {
    Helix::about(Vector3::zeros(), Vector3::new(radius, 0.0, 0.0), Vector3::z_axis(), angle, pitch)
}

/// Of an arm, past points at these times \[s\], each a turn of all joints farther \[rad\]; `None` where that is no trajectory.
pub fn trajectory(from: Six, times: &[f64], by: f64) -> Option<JointTrajectory> {
    let points = times.iter().zip(1..).map(|(&time, k)| {
        let positions = (from + Six::repeat(by * f64::from(k))).as_slice().to_vec();
        TrajectoryPoint { time, positions, ..TrajectoryPoint::default() }
    });
    JointTrajectory::new(JointBounds::of(Irp6::nominal().limits()), points.collect()).ok()
}

/// Jogged down, by a panel on which a button is held all the time.
pub fn jogged(limits: JogLimits) -> PanelJog<Irp6> {
    let (panel, seat) = JogPanel::alone(Irp6::nominal());
    let order = JogOrder::read(&mut "world z -40%".split_whitespace()).expect("an order");
    seat.say(JogNow::Order { press: 1, order });
    PanelJog::within(panel, limits)
}

/// An analog output.
pub fn flow() -> Output<f64> {
    Output::of(Channel::Analog(0)).expect("an analog one")
}

/// More than any motion here needs.
pub const WIDE: Bound = Bound { speed: 1.0, travel: 10.0 };

/// An arm that is to reach joint positions beside its own.
pub fn reaching(by: f64) -> Given<ReachState<Irp6>> {
    let mut joints = [0.0; mrroc::robot::MAX_JOINTS];
    joints.iter_mut().zip(arm().iter()).for_each(|(joint, q)| *joint = q + by);
    Given { order: Order::new(JointOrder { joints }), e: State::new(image()), v: Reading::new(()) }
}

/// Poses at which something may go wrong: at an odd number, half a turn away, where the tool is.
pub fn odd_poses(x: f64) -> impl Iterator<Item = Pose> {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), PI);
    let about = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle);
    [
        Pose::identity(),
        start(),
        start() * Pose::from_parts(Vector3::zeros().into(), turned),
        start() * Pose::from_parts(Vector3::new(x, 0.0, 0.0).into(), turned),
        Pose::translation(x, 0.1, 0.2),
        Pose::translation(x, x, x),
        Pose::from_parts(Vector3::new(0.8, 0.0, 0.3).into(), about(x)),
    ]
    .into_iter()
}

pub fn wave(points: usize, spacing: f64) -> Vec<Vector3<f64>> {
    (0..points)
        .map(|i| {
            let x = i as f64 * spacing;
            Vector3::new(x, 0.2 * x * (30.0 * x).sin(), 0.0)
        })
        .collect()
}

pub fn feed(feed: f64, acceleration: f64) -> FeedLimits {
    let (chord_error, jerk) = (f64::INFINITY, f64::INFINITY);
    FeedLimits { feed, tangential: acceleration, normal: acceleration, step: 4e-3, chord_error, jerk }
}

pub type Points = std::vec::IntoIter<Vector3<f64>>;

pub fn track(points: &[Vector3<f64>], limits: FeedLimits) -> Result<SplineTrack<Irp6, Points>, FeedError> {
    let at = start();
    SplineTrack::through(points.to_vec(), SplineSettings::default(), limits, at, UnitQuaternion::identity())
}

pub fn body() -> StraightBody {
    StraightBody::by(
        Pose::new(Vector3::new(0.02, 0.0, 0.05), Vector3::new(0.0, 0.0, 0.1)),
        tool_limits(0.3, 1.0),
    )
}

pub fn odd_bodies(x: f64) -> impl Iterator<Item = StraightBody> {
    let limits = [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x)];
    limits.into_iter().flat_map(move |limits| odd_poses(x).map(move |pose| StraightBody::by(pose, limits)))
}

pub fn drive(path: StraightBody, limits: ToolLimits) -> SharedDrive<Two, StraightBody> {
    let loops = [0.0, 0.5]
        .map(|y| KinematicLoop::held(&Pose::identity(), &(Pose::translation(0.0, y, 0.02) * start())));
    SharedDrive::from(Pose::identity(), path, loops, limits)
}

pub fn squeeze_law(inertia: f64) -> Option<SqueezeLaw> {
    let stiffness = GraspStiffness { force: 5e4, torque: 500.0 };
    let bounds = SqueezeBounds { speed: 1.0, turning: 1.0, travel: 1.0, angle: 1.0 };
    SqueezeLaw::new(SqueezeGains { stiffness, rate: 5.0, inertia }, bounds, 0.01).ok()
}

pub fn squeezed(
    path: StraightBody,
    squeeze: f64,
    inertia: f64,
) -> Option<SqueezedCarry<Two, [Wrist; 2], StraightBody>> {
    Some(SqueezedCarry::along(BodyFrame::Centroid, path, squeeze_law(inertia)?, squeeze, 0))
}

/// An arm whose joints are `off` [rad] from their demands.
pub fn behind(off: f64) -> RobotImage<Irp6> {
    let (image, q) = (image(), arm() + Six::repeat(off));
    RobotImage::new(RobotState { joints: q, ..*image.measured() }, *image.demanded())
}

pub type Belt = Functional<fn(f64) -> Pose>;

/// A frame that moves at 0.1 m/s along x.
pub fn belt() -> Belt {
    Functional::new(|age| Pose::translation(0.1 * age, 0.0, 0.0))
}

/// Presses along z, guarded along x.
pub fn law(load: f64, velocity: f64, give: Give) -> Option<ForceControl> {
    let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
    (axes[0], axes[2], axes[3]) = (
        Behaviour::Guarded { velocity, give },
        Behaviour::Contact { load, give, within: Bound { speed: 1.0, travel: 10.0 } },
        Behaviour::Unguarded { velocity },
    );
    ForceControl::new(axes).ok()
}

/// A camera that sees where an object is.
pub struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Displacement;
    type Configuration = ();
}

/// One arm at rest that sees an object which is `x` [m] aside.
pub fn seen<G: Generator<Robots = Irp6, Sensors = (Camera,), Order = ()>>(x: f64) -> Given<G> {
    let pose = Pose::new(Vector3::new(x, 0.0, 0.2), Vector3::new(0.0, 0.0, 0.3));
    let v = Reading::new((SensorImage::new(Displacement { pose }, 0),));
    Given { order: Order::new(()), e: State::new(image()), v }
}

pub fn servoing(speed: f64, ramp: f64, gain: f64) -> Servoing {
    Servoing { speed, turning: 5.0 * speed, ramp, gain, tolerance: 1e-4, angle_tolerance: 1e-3, oldest: 2 }
}

/// One arm at rest with an order, which is pushed more and more.
pub fn felt<G: Generator<Robots = Irp6, Sensors = (Wrist,)>>(step: u64, order: G::Order) -> Given<G> {
    let v = Reading::new((load(-0.01 * step as f64),));
    Given { order: Order::new(order), e: State::new(image()), v }
}

pub fn corrected(speed: f64, ramp: f64, travel: f64) -> Corrected<StraightLine<Irp6>, Camera> {
    let line = StraightLine::by(Pose::translation(0.0, 0.0, 0.1), tool_limits(0.3, 1.0));
    let limits = CorrectionLimits { speed, turning: speed, ramp, travel, angle: 1.0, oldest: 1 };
    Corrected::by(line, |seen: &Displacement| seen.pose, limits)
}

/// Goes on while it presses, until it is pressed by 5 N. A law of numbers that are none is one that stands.
pub fn compliant(load: f64, velocity: f64, braking: f64) -> Compliant<StraightLine<Irp6>, Wrist> {
    let line = StraightLine::by(Pose::translation(0.0, 0.0, 0.1), tool_limits(0.3, 1.0));
    let still = || law(0.0, 0.0, Give::FORCE).expect("in range");
    let law = law(load, velocity, Give::FORCE).unwrap_or_else(still);
    Compliant::by(line, law, 1).until(|felt| felt.load.force.z < -5.0, braking)
}

/// Goes on until it is pressed by 5 N, and then presses.
pub fn overridden(braking: f64) -> Override<GuardedApproach<Irp6, Wrist>, ForceLaw<Irp6, Wrist>> {
    let approach = GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, 1.0, |_: &Wrench| false);
    let press = ForceLaw::lasting(law(10.0, 0.0, Give::FORCE).expect("in range"), 1.0, 1);
    let touched = |v: &Reading<(Wrist,)>| v.0.reading().is_some_and(|felt| felt.force.z < -5.0);
    Override::of(approach, touched, braking, press)
}

/// An approach that yields to pressing.
pub type Arbitrated = Arbitrate<
    ForceLaw<Irp6, Wrist>,
    GuardedApproach<Irp6, Wrist>,
    fn() -> ForceLaw<Irp6, Wrist>,
    fn() -> GuardedApproach<Irp6, Wrist>,
>;

/// Goes on while it is pressed by less than 5 N, and presses from there on until it is by less than 1 N.
pub fn arbitrated(braking: f64) -> Arbitrated {
    let approach = || GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, 1.0, |_: &Wrench| false);
    let press = || ForceLaw::lasting(law(10.0, 0.0, Give::FORCE).expect("in range"), 1.0, 1);
    let touched = |v: &Reading<(Wrist,)>| v.0.reading().is_some_and(|felt| felt.force.z < -5.0);
    let free = |v: &Reading<(Wrist,)>| v.0.reading().is_some_and(|felt| felt.force.z > -1.0);
    Arbitrate::of(press, touched, free, braking, approach)
}

/// An approach and the force law together, each by half, within a velocity of `most`.
pub fn superposed(most: f64) -> Superpose<GuardedApproach<Irp6, Wrist>, ForceLaw<Irp6, Wrist>> {
    let approach = GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, 1.0, |_: &Wrench| false);
    let press = ForceLaw::lasting(law(10.0, 0.0, Give::FORCE).expect("in range"), 1.0, 1);
    let limits = ProfileLimits { velocity: most, acceleration: 1.0 };
    Superpose::of(approach, press, |_| [0.5; 2], ToolLimits { translation: limits, rotation: limits })
}

/// Two poses that were taught, of coordinates around `x`, with a share of velocity.
pub fn shown(x: f64, share: f64, space: Space) -> Option<Taught> {
    let poses = [1.0, 0.5].map(|k| TaughtPose::new(share, 0.5, &[k * x; 6]));
    let poses = poses.into_iter().collect::<Option<_>>()?;
    Some(Taught { space, reference: Reference::Relative, poses })
}

/// Two motions of the first joint that were taught [rad].
pub fn swung(first: f64, second: f64) -> Taught {
    let legs = [first, second].map(|q| TaughtPose::new(1.0, 1.0, &[q, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let poses = legs.into_iter().flatten().collect();
    Taught { space: Space::Joint, reference: Reference::Relative, poses }
}

/// To a place beside the object that the camera sees.
pub fn followed(
    place: Pose,
    rate: f64,
    most: f64,
    approach: f64,
    duration: f64,
) -> FollowedFrame<Irp6, Camera> {
    let how = Tracking { rate, acceleration: most, turning: most };
    FollowedFrame::to(|seen: &Displacement| Some(seen.pose), place, how, approach, duration, 2)
}

/// Onto a belt, and off it to `goal`.
pub fn handed(goal: Pose, fading: f64) -> Handover<MovingFrame<Irp6, Belt>, StraightLine<Irp6>, Irp6> {
    let limits = tool_limits(0.3, 1.0);
    Handover::of(MovingFrame::to(belt(), start(), 0.5, 0.6), StraightLine::to(goal, limits), fading)
}
