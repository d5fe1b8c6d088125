//! Memory does not grow with the path, and nothing allocates while it is followed.

use mrroc::generator::Generator;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};
use mrroc::sensor::SensorImage;
use mrroc_counting_allocator::bytes;
use mrroc_generators::bspline::{SpanStream, SplineSettings};
use mrroc_generators::cooperation::{
    BodyFrame, Displacement, FreeDirection, GraspStiffness, KinematicLoop, SqueezeBounds, SqueezeGains,
    SqueezeLaw, TimedBody,
};
use mrroc_generators::curve::Helix;
use mrroc_generators::feed::{FedPath, FeedLimits};
use mrroc_generators::generators::{
    CircularMove, CurveMove, FollowMaster, JointOrder, JointSpline, ReachState, RigidCarry, SharedDrive,
    SmoothJointMove, SqueezedCarry, StraightLine, YieldingTransmit,
};
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::{SmoothToolLimits, ToolLimits};
use mrroc_generators::profile::{JerkLimits, ProfileLimits};
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Six};
use nalgebra::Vector3;

/// Bytes that the work allocates.
fn allocated(work: impl FnOnce()) -> usize {
    let before = bytes();
    work();
    bytes() - before
}

fn wave(points: u32) -> impl Iterator<Item = Vector3<f64>> {
    (0..points).map(|i| {
        let x = f64::from(i) * 1e-3;
        Vector3::new(x, 0.01 * (x * 30.0).sin(), 0.0)
    })
}

/// The count covers points, windows and spans.
#[test]
fn a_spline_of_any_length_allocates_nothing() {
    for points in [10_000, if cfg!(debug_assertions) { 1_000_000 } else { 10_000_000 }] {
        let mut spans = 0;
        let bytes = allocated(|| {
            spans = SpanStream::new(SplineSettings::default(), wave(points)).unwrap().flatten().count();
        });
        assert_eq!((bytes, spans), (0, points as usize - 1));
    }
}

#[test]
fn following_a_path_allocates_nothing() {
    let limits = FeedLimits {
        feed: 0.2,
        tangential: 1.0,
        normal: 1.0,
        step: 1e-3,
        chord_error: 1e-5,
        jerk: f64::INFINITY,
    };
    let mut steps = 0;
    let bytes = allocated(|| {
        let spans = SpanStream::new(SplineSettings::default(), wave(2000)).unwrap();
        let mut path: FedPath<_> = FedPath::new(limits, spans).unwrap();
        while path.advance(1e-3).is_some() {
            steps += 1;
        }
    });
    assert_eq!(bytes, 0);
    assert!(steps > 10_000, "{steps}");
}

struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

/// The bytes that a generator's steps allocate, to its end or for 500 of them.
fn stepped<G>(
    mut generator: G,
    e: &State<G::Robots>,
    v: &Reading<G::Sensors>,
    order: &Order<G::Order>,
) -> usize
where
    G: Generator,
{
    let t = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
    allocated(|| {
        let mut step = generator.first_step(order, e, v, t).unwrap();
        for _ in 0..500 {
            if matches!(step, Step::Done) {
                break;
            }
            step = generator.next_step(order, e, v, t).unwrap();
        }
    })
}

#[test]
fn cooperation_allocates_nothing() {
    type Two = [Irp6FiveDof; 2];
    let (robot, q) = (Irp6FiveDof::nominal(), Five::new(0.0, -1.5, 0.1, -0.17, 0.0));
    let state = RobotState { joints: q, velocity: Five::zeros(), pose: robot.forward(&q) };
    let images = [RobotImage::new(state, state); 2];
    let (e, none, no_order) = (State::<Two>::new(images), Reading::new(()), Order::new(()));
    let path = || TimedBody::new(0.4, |t| Pose::translation(0.1 * t, 0.0, 0.0));
    let carry = RigidCarry::along(BodyFrame::Centroid, path()).by_displacements();
    assert_eq!(stepped(carry, &e, &none, &no_order), 0);
    assert_eq!(stepped(FollowMaster::<Two, _>::along(path(), 0.01), &e, &none, &no_order), 0);
    let limits = ProfileLimits { velocity: 0.1, acceleration: 1.0 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    let loops = [KinematicLoop::held(&Pose::identity(), &Pose::translation(0.8, 0.0, 1.0)); 2];
    let drive = SharedDrive::<Two, _>::from(Pose::identity(), path(), loops, limits);
    assert_eq!(stepped(drive, &e, &none, &no_order), 0);
    let stiffness = GraspStiffness { force: 5e4, torque: 500.0 };
    let gains = SqueezeGains { stiffness, rate: 5.0, inertia: 0.02 };
    let bounds = SqueezeBounds { speed: 1.0, turning: 1.0, travel: 1.0, angle: 1.0 };
    let law = SqueezeLaw::new(gains, bounds, 0.01).unwrap();
    let (body, squeeze) = (BodyFrame::InFirstTool(Pose::translation(0.1, 0.0, 0.0)), 5.0);
    let squeezed = SqueezedCarry::<Two, [Wrist; 2], _>::along(body, path(), law, squeeze, 0);
    let load = Wrench::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, 0.2, 0.3));
    let v = Reading::new([SensorImage::new(load, 0); 2]);
    assert_eq!(stepped(squeezed, &e, &v, &no_order), 0);
    let free = FreeDirection::Turn(Vector3::x_axis());
    let (one, order) =
        (State::new(images[0]), Order::new(Displacement { pose: Pose::translation(0.0, 0.02, 0.0) }));
    assert_eq!(stepped(YieldingTransmit::by(robot, free), &one, &none, &order), 0);
}

#[test]
fn smooth_motions_allocate_nothing() {
    let (robot, q) = (Irp6::nominal(), Irp6::READY);
    let state = RobotState { joints: q, velocity: Six::zeros(), pose: robot.forward(&q) };
    let (e, none, no_order) =
        (State::<Irp6>::new(RobotImage::new(state, state)), Reading::new(()), Order::new(()));
    let limits =
        JointLimits { velocity: Six::repeat(0.5), acceleration: Six::repeat(2.0), jerk: Six::repeat(20.0) };
    let goal = q + Six::repeat(0.2);
    assert_eq!(stepped(SmoothJointMove::<Irp6>::to(goal, limits), &e, &none, &no_order), 0);
    let along = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
    let tool = SmoothToolLimits { translation: along, rotation: along };
    let goal = state.pose * Pose::translation(0.0, 0.03, 0.0);
    assert_eq!(stepped(StraightLine::<Irp6, _>::to(goal, tool), &e, &none, &no_order), 0);
    let via = (state.pose * Pose::translation(0.01, 0.015, 0.0)).translation.vector;
    assert_eq!(stepped(CircularMove::<Irp6>::through(via, goal, tool), &e, &none, &no_order), 0);
    let helix = Helix::about(Vector3::x(), Vector3::zeros(), Vector3::z_axis(), 0.1, 0.0).unwrap();
    assert_eq!(stepped(CurveMove::<Irp6, _>::along(helix, along), &e, &none, &no_order), 0);
    // The target of the orders changes in every step.
    let t = Tick { step: 0, dt: 1e-3, duration: 1e-3 };
    let mut reach = ReachState::<Irp6>::within(limits);
    let bytes = allocated(|| {
        for i in 0..500 {
            let order = Order::new(JointOrder { joints: [1e-3 * f64::from(i); 8] });
            let step = if i == 0 {
                reach.first_step(&order, &e, &none, t)
            } else {
                reach.next_step(&order, &e, &none, t)
            };
            assert!(step.is_ok());
        }
    });
    assert_eq!(bytes, 0);
    // A spline through a list of points is solved in the first step; the next ones only follow it.
    let mut spline =
        JointSpline::<Irp6>::through(vec![q + Six::repeat(0.1)], limits.velocity, limits.acceleration, 0.05);
    assert!(spline.first_step(&no_order, &e, &none, t).is_ok());
    assert_eq!(
        allocated(|| while !matches!(spline.next_step(&no_order, &e, &none, t), Ok(Step::Done)) {}),
        0
    );
}

/// The counter does count.
#[test]
fn an_allocation_is_seen() {
    assert!(allocated(|| drop(std::hint::black_box(vec![0_u8; 100]))) >= 100);
}
