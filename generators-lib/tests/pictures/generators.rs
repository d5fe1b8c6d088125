//! What every generator demands, one sheet each: displacement, velocity, acceleration, jerk over time, and the path in space.

use std::error::Error;
use std::f64::consts::TAU;

use mrroc::operator::jog::{JogNow, JogOrder, JogPanel, JogSeat};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use mrroc_generators::bspline::SplineSettings;
use mrroc_generators::combinators::*;
use mrroc_generators::cooperation::*;
use mrroc_generators::curve::Helix;
use mrroc_generators::feed::FeedLimits;
use mrroc_generators::force::{Behaviour, Bound, ForceControl, Give};
use mrroc_generators::generators::*;
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::{SmoothToolLimits, ToolLimits};
use mrroc_generators::profile::{JerkLimits, ProfileLimits};
use mrroc_generators::teach::{Jogging, Reference, Space, Taught, TaughtPose};
use mrroc_generators::timing::PathLimits;
use mrroc_generators::trajectory::{JointBounds, JointTrajectory, TrajectoryPoint};
use mrroc_generators::via::PoseDeviation;
use mrroc_robots::{Irp6, Six};
use nalgebra::{UnitQuaternion, Vector3};

use super::sheet::{Sheet, Trace};
use super::stage::*;

type Track = SplineTrack<Irp6, std::vec::IntoIter<Vector3<f64>>>;
type Sheets = Result<Vec<(&'static str, Vec<Trace>)>, Box<dyn Error>>;

fn limits() -> ToolLimits {
    let limits = ProfileLimits { velocity: 0.2, acceleration: 0.8 };
    ToolLimits { translation: limits, rotation: limits }
}

/// A path so slow that the tool comes to the surface on it.
fn slow() -> ToolLimits {
    let limits = ProfileLimits { velocity: 0.05, acceleration: 0.2 };
    ToolLimits { translation: limits, rotation: limits }
}

fn smooth() -> SmoothToolLimits {
    SmoothToolLimits { translation: along(), rotation: along() }
}

fn along() -> JerkLimits {
    JerkLimits { velocity: 0.2, acceleration: 0.8, jerk: 8.0 }
}

fn joint_limits() -> JointLimits<Six> {
    JointLimits { velocity: Six::repeat(0.4), acceleration: Six::repeat(1.6), jerk: Six::repeat(16.0) }
}

fn fastest() -> PathLimits<Six> {
    PathLimits { velocity: Six::repeat(0.4), acceleration: Six::repeat(1.6), speed: f64::INFINITY }
}

fn goal() -> Six {
    joints() + Six::new(0.3, 0.2, -0.1, 0.0, 0.1, 0.0)
}

fn offset() -> Pose {
    Pose::new(Vector3::new(0.1, 0.05, 0.02), Vector3::z() * 0.3)
}

fn body() -> StraightBody {
    StraightBody::by(Pose::new(Vector3::new(0.1, 0.0, 0.05), Vector3::z() * 0.4), limits())
}

/// A part on a belt of 0.1 m/s, `age` \[s\] after the start.
fn belt(age: f64) -> Pose {
    Pose::translation(0.1 * age, 0.0, 0.0) * start()
}

/// Motions of one arm that need nothing but its state.
fn plain() -> Sheets {
    let at = |x: f64, y: f64, z: f64| start() * Pose::translation(x, y, z);
    let helix = Helix::about(Vector3::zeros(), Vector3::x() * 0.04, Vector3::z_axis(), 3.0 * TAU, 0.03)?;
    let poses = [[0.08, 0.0, 0.0], [0.0, 0.08, 0.0], [-0.08, -0.08, 0.04]];
    let poses = poses.map(|[x, y, z]| TaughtPose::new(1.0, 1.0, &[x, y, z, 0.0, 0.0, 0.0]));
    let poses = poses.into_iter().collect::<Option<_>>().ok_or("out of range")?;
    let taught = Taught { space: Space::AngleAxis, reference: Reference::Relative, poses };
    let through = vec![joints() + Six::new(0.2, 0.1, 0.0, 0.0, 0.0, 0.1), goal(), joints()];
    let corners = [at(0.08, 0.0, 0.0), at(0.08, 0.08, 0.04), at(0.0, 0.08, 0.0)];
    let mut step = 0;
    let panel = move || {
        step += 1;
        let turned = if step < 200 { Vector3::x() } else { Vector3::y() };
        Jogging { along: turned * 0.1, done: step > 400, ..Jogging::default() }
    };
    let sixth = Six::repeat(1.0);
    let planned = through.iter().zip([0.8, 1.6, 2.6]).map(|(joints, time)| TrajectoryPoint {
        time,
        positions: joints.as_slice().to_vec(),
        ..TrajectoryPoint::default()
    });
    let planned = JointTrajectory::new(JointBounds::of(Irp6::nominal().limits()), planned.collect())?;
    Ok(vec![
        ("follow_trajectory", alone(FollowTrajectory::<Irp6>::along(&planned))),
        ("joint_move", alone(JointMove::<Irp6>::to(goal(), sixth * 0.4, sixth * 1.6))),
        ("smooth_joint_move", alone(SmoothJointMove::<Irp6>::to(goal(), joint_limits()))),
        ("joint_spline", alone(JointSpline::<Irp6>::through(through.clone(), sixth * 0.4, sixth * 1.6, 0.1))),
        (
            "joint_velocity",
            follow(
                JointVelocity::<Irp6>::of(Six::new(0.1, 0.05, 0.0, 0.0, 0.0, 0.0), sixth * 0.2),
                500,
                |_, _| ((), Reading::new(())),
            ),
        ),
        ("straight_line", alone(StraightLine::<Irp6>::by(offset(), limits()))),
        ("straight_line_with_limited_jerk", alone(StraightLine::<Irp6, _>::by(offset(), smooth()))),
        ("tool_offset", alone(ToolOffset::<Irp6>::by(offset(), limits()))),
        (
            "circular_move",
            alone(CircularMove::<Irp6>::through(
                at(0.05, 0.05, 0.0).translation.vector,
                at(0.1, 0.0, 0.0),
                smooth(),
            )),
        ),
        ("curve_move", alone(CurveMove::<Irp6, _>::along(helix, along()))),
        ("spiral_search", alone(SpiralSearch::<Irp6>::over(0.02, 8e-3, along()))),
        ("tilt_search", alone(TiltSearch::<Irp6>::within(0.1, 0.04, along()))),
        ("joint_via", alone(JointVia::<Irp6>::through(through.clone(), sixth * 0.01, joint_limits()))),
        (
            "line_via",
            alone(LineVia::<Irp6>::through(
                corners.to_vec(),
                PoseDeviation { distance: 0.005, angle: 0.05 },
                smooth(),
            )),
        ),
        ("pose_spline_move", alone(PoseSplineMove::<Irp6>::through(corners.to_vec(), smooth()))),
        ("time_optimal_joints", alone(TimeOptimalJoints::<Irp6>::through(through, fastest()))),
        ("time_optimal_curve", alone(TimeOptimalCurve::along(Irp6::nominal(), helix, fastest()))),
        ("spline_track", alone(spline()?)),
        ("moving_frame", alone(onto_the_belt(1.5))),
        ("replay", alone(Replay::<Irp6>::of(taught, sixth, sixth, limits()))),
        ("jog", alone(Jog::<Irp6, _>::by(panel, 0.5, 1.0, 0))),
        ("panel_jog", alone(Pressed::new())),
    ])
}

/// A person presses two buttons of a panel, each for half a second, and is done.
struct Pressed {
    jog: PanelJog<Irp6>,
    seat: JogSeat,
    steps: u64,
}

impl Pressed {
    fn new() -> Self {
        let (panel, seat) = JogPanel::alone(Irp6::nominal());
        Pressed { jog: PanelJog::by(panel), seat, steps: 0 }
    }

    fn step(&mut self, e: &State<Irp6>, t: Tick) -> Result<Step<Irp6>, Fault> {
        let order = |text: &str| JogOrder::read(&mut text.split_whitespace()).expect("an order");
        self.seat.say(match self.steps {
            0..250 => JogNow::Order { press: 1, order: order("world x 60%") },
            500..750 => JogNow::Order { press: 2, order: order("tool rz -100%") },
            250..1000 => JogNow::Nothing,
            _ => JogNow::Done { press: 3 },
        });
        self.steps += 1;
        let (order, v) = (Order::new(()), Reading::new(()));
        match self.steps {
            1 => mrroc::generator::Generator::first_step(&mut self.jog, &order, e, &v, t),
            _ => mrroc::generator::Generator::next_step(&mut self.jog, &order, e, &v, t),
        }
    }
}

#[generator(ecp)]
impl Pressed {
    fn first_step(&mut self, e: &State<Irp6>, t: Tick) -> Result<Step<Irp6>, Fault> {
        self.step(e, t)
    }

    fn next_step(&mut self, e: &State<Irp6>, t: Tick) -> Result<Step<Irp6>, Fault> {
        self.step(e, t)
    }
}

fn onto_the_belt(duration: f64) -> MovingFrame<Irp6, impl Transform> {
    MovingFrame::to(Functional::new(belt), Pose::translation(0.0, 0.1, 0.05), 1.0, duration)
}

fn spline() -> Result<Track, Box<dyn Error>> {
    let points: Vec<_> = (0..=48).map(|i| f64::from(i) * TAU / 48.0).collect();
    let points: Vec<_> =
        points.into_iter().map(|a| Vector3::new(1.0 - a.cos(), (2.0 * a).sin() / 2.0, 0.0) * 0.05).collect();
    let infinite = f64::INFINITY;
    let (feed, tangential, normal) = (0.1, 0.4, 0.4);
    let feed = FeedLimits { feed, tangential, normal, step: DT, chord_error: infinite, jerk: infinite };
    Ok(SplineTrack::through(points, SplineSettings::default(), feed, start(), UnitQuaternion::identity())?)
}

/// A law that presses with 10 N along z, and goes along x at a velocity [m/s].
fn pressing(velocity: f64) -> Result<ForceControl, Box<dyn Error>> {
    let mut axes = [Behaviour::Unguarded { velocity: 0.0 }; 6];
    axes[0] = Behaviour::Unguarded { velocity };
    axes[2] =
        Behaviour::Contact { load: 10.0, give: Give::FORCE, within: Bound { speed: 0.1, travel: 0.05 } };
    Ok(ForceControl::new(axes)?)
}

fn approach() -> GuardedApproach<Irp6, Wrist> {
    GuardedApproach::along(start().rotation * Vector3::z_axis(), 0.05, 0.25, 0.2, |felt: &Wrench| {
        felt.force.z < -1.0
    })
}

/// Motions of one arm that go by sensors or by the coordinator's orders.
fn told() -> Sheets {
    let pressed = |_: u64, at: &[Image; 2]| ((), Reading::new((table(&at[0], 0.02),)));
    let object = Pose::new(Vector3::new(0.1, 0.05, 0.15), Vector3::z() * 0.4);
    let camera = Pose::translation(0.0, 0.05, 0.0);
    let how = Servoing {
        speed: 0.1,
        turning: 0.5,
        ramp: 0.2,
        gain: 4.0,
        tolerance: 1e-4,
        angle_tolerance: 1e-3,
        oldest: 2,
    };
    let eye =
        EyeInHand::<Irp6, Camera>::to(Pose::translation(0.0, 0.0, -0.1), camera, |seen| Some(seen.pose), how);
    // The belt is seen every fifth step, two to six steps late.
    let late = |step: u64, _: &[Image; 2]| {
        let of = (step.saturating_sub(2) / 5) * 5;
        let pose = belt(of as f64 * DT);
        ((), Reading::new((SensorImage::<Camera>::new(Displacement { pose }, (step - of) as u32),)))
    };
    let tracking = Tracking { rate: 15.0, acceleration: 1.0, turning: 5.0 };
    let place = Pose::translation(0.0, 0.1, 0.05);
    let followed = FollowedFrame::<Irp6, Camera>::to(|seen| Some(seen.pose), place, tracking, 1.0, 1.5, 8);
    let aside = |step: u64, _: &[Image; 2]| {
        let pose = Pose::translation(0.0, if step < 100 { 0.0 } else { 0.01 }, 0.0);
        ((), Reading::new((SensorImage::<Camera>::new(Displacement { pose }, 0),)))
    };
    let bounds =
        CorrectionLimits { speed: 0.02, turning: 0.1, ramp: 0.1, travel: 0.02, angle: 0.1, oldest: 1 };
    let corrected =
        Corrected::<_, Camera>::by(ToolOffset::<Irp6>::by(offset(), limits()), |seen| seen.pose, bounds);
    let compliant = Compliant::<_, Wrist>::by(ToolOffset::<Irp6>::by(offset(), slow()), pressing(0.0)?, 1);
    let touched = |v: &Reading<(Wrist,)>| v.0.reading().is_some_and(|felt| felt.force.z < -1.0);
    let blind: GuardedApproach<Irp6, Wrist> =
        GuardedApproach::along(start().rotation * Vector3::z_axis(), 0.05, 0.25, 0.2, |_: &Wrench| false);
    let over = Override::of(blind, touched, 0.1, ForceLaw::lasting(pressing(0.0)?, 1.5, 1));
    // Somebody leans against the tool for 100 steps, and it stands meanwhile.
    let leaned = |step: u64, _: &[Image; 2]| {
        let push = if (60..160).contains(&step) { -5.0 } else { 0.0 };
        let felt = Wrench::new(Vector3::z() * push, Vector3::zeros());
        ((), Reading::new((SensorImage::<Wrist>::new(felt, 0),)))
    };
    let free = |v: &Reading<(Wrist,)>| v.0.reading().is_some_and(|felt| felt.force.z > -0.5);
    let stand = || Blind::new(Sleep::<Irp6>::lasting(f64::INFINITY));
    let go = || Blind::new(StraightLine::<Irp6>::to(start() * offset(), limits()));
    let arbitrated = Arbitrate::of(stand, touched, free, 0.1, go);
    let helped = |v: &Reading<(Wrist,)>| {
        [1.0, v.0.reading().map_or(0.0, |felt| f64::from(u8::from(felt.force.z < -1.0)))]
    };
    let beside = Blind::new(ToolOffset::<Irp6>::by(Pose::translation(0.0, 0.06, 0.0), limits()));
    let along = Blind::new(ToolOffset::<Irp6>::by(offset(), limits()));
    let superposed = Superpose::of(
        along,
        beside,
        helped,
        ToolLimits { translation: ProfileLimits { velocity: 0.2, acceleration: 0.4 }, ..limits() },
    );
    let felt = |step: u64, at: &[Image; 2]| (ordered(step), Reading::new((table(&at[0], 0.08),)));
    let stiffness = GraspStiffness { force: 2e3, torque: 20.0 };
    let gains = SqueezeGains { stiffness, rate: 5.0, inertia: 0.01 };
    let bounds = SqueezeBounds { speed: 0.2, turning: 0.2, travel: 0.1, angle: 0.1 };
    let law = SqueezeLaw::new(gains, bounds, DT)?;
    let by_order = |step: u64, _: &[Image; 2]| (ordered(step), Reading::new(()));
    let reached = |step: u64, _: &[Image; 2]| {
        let to = if (100..180).contains(&step) { joints() } else { goal() };
        let mut all = [0.0; mrroc::robot::MAX_JOINTS];
        all[..6].copy_from_slice(to.as_slice());
        (JointOrder { joints: all }, Reading::new(()))
    };
    let press = |step: u64, at: &[Image; 2]| {
        let across = [0.02 * (0.02 * (step as f64 - 50.0)).clamp(0.0, 1.0), 0.0];
        let down = at[0].measured().pose.rotation.inverse_transform_vector(&-Vector3::z()) * 13.18;
        let felt = table(&at[0], 0.01).reading().map_or(0.0, |felt| felt.force.z) * Vector3::z() + down;
        let felt = SensorImage::<Wrist>::new(Wrench::new(felt, Vector3::zeros()), 0);
        (Pressing { force: 10.0, across }, Reading::new((felt,)))
    };
    Ok(vec![
        ("guarded_approach", follow(approach(), 1000, pressed)),
        ("force_law", follow(ForceLaw::<Irp6, Wrist>::lasting(pressing(0.01)?, 2.5, 1), 1000, pressed)),
        (
            "ordered_force",
            follow(
                OrderedForce::<Irp6, Wrist>::with_tool(
                    13.18,
                    Give::FORCE,
                    Bound { speed: 0.1, travel: 0.05 },
                ),
                500,
                press,
            ),
        ),
        (
            "eye_in_hand",
            follow(eye, 2000, move |_, at| {
                let pose = (at[0].demanded().pose * camera).inverse() * (start() * object);
                ((), Reading::new((SensorImage::new(Displacement { pose }, 0),)))
            }),
        ),
        ("followed_frame", follow(followed, 1000, late)),
        ("corrected", follow(corrected, 1000, aside)),
        ("override_", follow(over, 1000, pressed)),
        ("compliant", follow(compliant, 1000, pressed)),
        ("arbitrate", follow(arbitrated, 1000, leaned)),
        ("superpose", follow(superposed, 1000, leaned)),
        ("blind", follow(go(), 1000, leaned)),
        ("compliant_transmit", follow(CompliantTransmit::<Irp6, Wrist>::by(law, 1), 300, felt)),
        ("transmit_displacement", follow(TransmitDisplacement::<Irp6>::new(), 300, by_order)),
        ("reach_state", follow(ReachState::<Irp6>::within(joint_limits()), 500, reached)),
        (
            "sequence",
            alone(Sequence::of(
                StraightLine::<Irp6>::by(offset(), limits()),
                StraightLine::to(start(), limits()),
            )),
        ),
        ("handover", alone(Handover::of(onto_the_belt(1.2), StraightLine::to(start(), limits()), 0.4))),
    ])
}

/// Motions of two arms.
fn pairs() -> Sheets {
    let loops = [0.0, 0.5]
        .map(|y| KinematicLoop::held(&Pose::identity(), &(Pose::translation(0.0, y, 0.02) * start())));
    let drive = SharedDrive::<Two, _>::from(Pose::identity(), body(), loops, limits());
    let gains =
        SqueezeGains { stiffness: GraspStiffness { force: 2e3, torque: 20.0 }, rate: 5.0, inertia: 0.01 };
    let bounds = SqueezeBounds { speed: 0.2, turning: 0.2, travel: 0.1, angle: 0.1 };
    let law = SqueezeLaw::new(gains, bounds, DT)?;
    let squeezed = SqueezedCarry::<Two, [Wrist; 2], _>::along(BodyFrame::Centroid, body(), law, 5.0, 0);
    // A body of 2 N/mm between the tools' origins, as long as at the start.
    let between = |_: u64, at: &[Image; 2]| {
        let poses = [0, 1].map(|i| at[i].demanded().pose);
        let displacement = poses[1].translation.vector - poses[0].translation.vector;
        let push = displacement.normalize() * (2000.0 * (0.5 - displacement.norm()));
        let felt = |i: usize, force: Vector3<f64>| {
            let force = poses[i].rotation.inverse_transform_vector(&force);
            SensorImage::<Wrist>::new(Wrench::new(force, Vector3::zeros()), 0)
        };
        ((), Reading::new([felt(0, -push), felt(1, push)]))
    };
    // A person pushes along x for half a second, half of it felt by each arm.
    let pushed = |step: u64, at: &[Image; 2]| {
        let push = if (50..175).contains(&step) { 10.0 } else { 0.0 };
        let felt = |i: usize| {
            let force = at[i].measured().pose.rotation.inverse_transform_vector(&(Vector3::x() * push));
            SensorImage::<Wrist>::new(Wrench::new(force, Vector3::zeros()), 0)
        };
        ((), Reading::new([felt(0), felt(1)]))
    };
    let guided = GuidedBody::<Two, [Wrist; 2]>::yielding(Give::FORCE, 1.0, 1.0, 2.0);
    let each = Each::of((
        StraightLine::<Irp6>::by(offset(), limits()),
        StraightLine::<Irp6, _>::by(Pose::translation(0.0, -0.03, 0.05), smooth()),
    ));
    Ok(vec![
        ("rigid_carry", alone(RigidCarry::<Two, _>::along(BodyFrame::Centroid, body()))),
        ("follow_master", alone(FollowMaster::<Two, _>::along(body(), 0.02))),
        ("shared_drive", alone(drive)),
        ("squeezed_carry", follow(squeezed, 2000, between)),
        ("guided_body", follow(guided, 1000, pushed)),
        ("each", alone(each)),
    ])
}

/// A name and a sheet for every generator and every combinator.
pub fn pictures() -> Result<Vec<(&'static str, Sheet)>, Box<dyn Error>> {
    let all = plain()?.into_iter().chain(told()?).chain(pairs()?);
    Ok(all.map(|(name, tools)| (name, Sheet::of_tools(name, &tools, DT))).collect())
}
