//! Every generator of the library keeps what a generator must keep.

mod kit;
mod violators;

use kit::*;
use mrroc::{Order, Pose, Reading, State, Wrench};
use mrroc_generators::combinators::{Corrected, Handover, InParallel, Override, Sequence};
use mrroc_generators::conformance::Given;
use mrroc_generators::cooperation::*;
use mrroc_generators::curve::Helix;
use mrroc_generators::force::Give;
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::*;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_generators::teach::{Jogging, Space, Taught};
use mrroc_robots::{Irp6, Irp6FiveDof, Six};
use nalgebra::Vector3;

generator_conformance! {
    joint_move: JointMove<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: JointMove::to(arm() + Six::repeat(0.2), Six::repeat(0.5), Six::repeat(1.0)),
    given: alone,
    odd: |x| vec![
        JointMove::to(arm(), Six::repeat(1.0), Six::repeat(1.0)),
        JointMove::to(Six::repeat(x), Six::repeat(1.0), Six::repeat(1.0)),
        JointMove::to(Six::zeros(), Six::repeat(x), Six::repeat(1.0)),
        JointMove::to(Six::zeros(), Six::repeat(1.0), Six::repeat(x)),
        JointMove::to(Six::zeros(), Six::repeat(x), Six::repeat(x)),
        JointMove::to(arm() + Six::new(x, 0.0, 0.0, 0.0, 0.0, 0.1), Six::repeat(1.0), Six::repeat(1.0)),
    ],
    allocated: bytes,
}

generator_conformance! {
    straight_line: StraightLine<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: StraightLine::by(Pose::new(Vector3::new(0.05, 0.02, 0.1), Vector3::new(0.1, 0.2, 0.3)), tool_limits(0.3, 1.0)),
    given: alone,
    odd: |x| {
        let mut odd = vec![StraightLine::to(start(), tool_limits(0.1, 1.0))];
        for limits in [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x), tool_limits(x, x)] {
            odd.extend(odd_poses(x).map(|pose| StraightLine::to(pose, limits)));
            odd.extend(odd_poses(x).map(|pose| StraightLine::by(pose, limits)));
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    smooth_joint_move: SmoothJointMove<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: SmoothJointMove::to(arm() + Six::repeat(0.2), joint_limits(0.5, 1.0, 10.0)),
    given: alone,
    odd: |x| {
        let mut odd = vec![SmoothJointMove::to(arm(), joint_limits(0.5, 1.0, 10.0))];
        for [v, a, j] in odd_limits(x) {
            odd.push(SmoothJointMove::to(Six::repeat(x), joint_limits(v, a, j)));
            odd.push(SmoothJointMove::to(Six::zeros(), joint_limits(v, a, j)));
            odd.push(SmoothJointMove::to(arm() + Six::new(x, 0.0, 0.0, 0.0, 0.0, 0.1), joint_limits(v, a, j)));
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    straight_line_with_limited_jerk: StraightLine<Irp6, SmoothToolLimits>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: StraightLine::by(Pose::new(Vector3::new(0.05, 0.02, 0.1), Vector3::new(0.1, 0.2, 0.3)), smooth_limits(0.3, 1.0, 10.0)),
    given: alone,
    odd: |x| {
        let mut odd = vec![StraightLine::to(start(), smooth_limits(0.1, 1.0, 10.0))];
        for [v, a, j] in odd_limits(x) {
            odd.extend(odd_poses(x).map(|pose| StraightLine::to(pose, smooth_limits(v, a, j))));
            odd.extend(odd_poses(x).map(|pose| StraightLine::by(pose, smooth_limits(v, a, j))));
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    reach_state: ReachState<Irp6>,
    class: "ECP f*4(c0, c), first step f*6(c0, c, e)",
    make: ReachState::within(joint_limits(0.5, 1.0, 10.0)),
    given: |step| reaching(if step < 100 { 0.2 } else { -0.1 }),
    odd: |x| odd_limits(x).map(|[v, a, j]| ReachState::within(joint_limits(v, a, j))).into(),
    allocated: bytes,
}

generator_conformance! {
    joint_spline: JointSpline<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: JointSpline::through(
        vec![arm() + Six::repeat(0.1), arm() + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)],
        Six::repeat(0.5),
        Six::repeat(1.0),
        0.2,
    ),
    given: alone,
    odd: |x| {
        let mut odd = vec![JointSpline::through(vec![], Six::repeat(1.0), Six::repeat(1.0), 0.2)];
        for points in [vec![arm()], vec![arm(), arm()], vec![Six::repeat(x)], vec![Six::repeat(x), arm()]] {
            for [v, a, ramp] in [[0.5, 1.0, 0.2], [x, 1.0, 0.2], [0.5, x, 0.2], [0.5, 1.0, x], [x, x, x]] {
                odd.push(JointSpline::through(points.clone(), Six::repeat(v), Six::repeat(a), ramp));
            }
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    time_optimal_joints: TimeOptimalJoints<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: TimeOptimalJoints::through(
        vec![arm() + Six::repeat(0.1), arm() + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)],
        path_limits(0.5, 1.0, f64::INFINITY),
    ),
    given: alone,
    odd: |x| {
        let mut odd = vec![TimeOptimalJoints::through(vec![], path_limits(1.0, 1.0, 1.0))];
        for points in [vec![arm()], vec![arm(), arm()], vec![Six::repeat(x)], vec![Six::repeat(x), arm()]] {
            for [v, a, speed] in odd_limits(x) {
                odd.push(TimeOptimalJoints::through(points.clone(), path_limits(v, a, speed)));
            }
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    time_optimal_curve: TimeOptimalCurve<Irp6, Helix>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: TimeOptimalCurve::along(
        Irp6::nominal(),
        helix(0.05, 0.02, 6.0).expect("a helix"),
        path_limits(0.5, 1.0, f64::INFINITY),
    ),
    given: alone,
    odd: |x| {
        let helices = [helix(0.05, 0.02, 6.0), helix(x, 0.02, 6.0), helix(0.05, x, 6.0), helix(0.05, 0.02, x)];
        let limits = odd_limits(x).map(|[v, a, speed]| path_limits(v, a, speed));
        let all = helices.into_iter().flatten().flat_map(|helix| limits.map(|limits| (helix, limits)));
        all.map(|(helix, limits)| TimeOptimalCurve::along(Irp6::nominal(), helix, limits)).collect()
    },
    allocated: bytes,
}

generator_conformance! {
    joint_via: JointVia<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: JointVia::through(
        vec![arm() + Six::repeat(0.1), arm() + Six::new(0.2, 0.1, 0.1, 0.0, -0.1, 0.3)],
        Six::repeat(0.01),
        joint_limits(0.5, 1.0, 10.0),
    ),
    given: alone,
    odd: |x| {
        let mut odd = vec![JointVia::through(vec![], Six::repeat(0.01), joint_limits(0.5, 1.0, 10.0))];
        for points in [vec![arm()], vec![arm(), arm()], vec![Six::repeat(x)], vec![Six::repeat(x), arm()]] {
            for [v, a, j] in odd_limits(x) {
                odd.push(JointVia::through(points.clone(), Six::repeat(0.01), joint_limits(v, a, j)));
                odd.push(JointVia::through(points.clone(), Six::repeat(x), joint_limits(v, a, j)));
            }
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    line_via: LineVia<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: LineVia::through(
        vec![away(), start() * Pose::translation(0.05, 0.05, 0.05), start()],
        within(0.005, 0.05),
        smooth_limits(0.3, 1.0, 10.0),
    ),
    given: alone,
    odd: |x| {
        let mut odd = vec![LineVia::through(vec![start()], within(0.01, 0.01), smooth_limits(0.1, 1.0, 10.0))];
        for [v, a, j] in odd_limits(x) {
            for pose in odd_poses(x) {
                for poses in [vec![pose], vec![pose, start()], vec![away(), pose, away()]] {
                    odd.push(LineVia::through(poses.clone(), within(0.01, 0.1), smooth_limits(v, a, j)));
                    odd.push(LineVia::through(poses, within(0.01, x), smooth_limits(v, a, j)));
                }
            }
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    pose_spline_move: PoseSplineMove<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: PoseSplineMove::through(
        vec![away(), start() * Pose::translation(0.05, 0.05, 0.05), start()],
        smooth_limits(0.3, 1.0, 10.0),
    ),
    given: alone,
    odd: |x| {
        let mut odd = vec![PoseSplineMove::through(vec![], smooth_limits(0.1, 1.0, 10.0))];
        for [v, a, j] in odd_limits(x) {
            for pose in odd_poses(x) {
                for poses in [vec![pose], vec![pose, start()], vec![away(), pose, away()]] {
                    odd.push(PoseSplineMove::through(poses, smooth_limits(v, a, j)));
                }
            }
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    circular_move: CircularMove<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: CircularMove::through(
        start().translation.vector + Vector3::new(0.05, 0.03, 0.0),
        start() * Pose::new(Vector3::new(0.0, 0.1, 0.02), Vector3::new(0.1, 0.2, 0.3)),
        smooth_limits(0.3, 1.0, 10.0),
    ),
    given: alone,
    odd: |x| {
        let at = start().translation.vector;
        let mut odd = Vec::new();
        for [v, a, j] in odd_limits(x) {
            for via in [at, at + Vector3::repeat(x), Vector3::repeat(x), Vector3::new(0.1, x, 0.3)] {
                odd.extend(odd_poses(x).map(|pose| CircularMove::through(via, pose, smooth_limits(v, a, j))));
            }
        }
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    curve_move: CurveMove<Irp6, Helix>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: CurveMove::along(helix(0.05, 0.02, 6.0).expect("in range"), JerkLimits { velocity: 0.2, acceleration: 1.0, jerk: 10.0 }),
    given: alone,
    odd: |x| {
        let curves = [helix(0.05, 0.02, 6.0), helix(x, 0.02, 6.0), helix(0.05, x, 6.0), helix(0.05, 0.02, x), helix(x, x, x)];
        let limits = odd_limits(x).map(|[velocity, acceleration, jerk]| JerkLimits { velocity, acceleration, jerk });
        curves
            .into_iter()
            .flatten()
            .flat_map(|curve| limits.map(|limits| CurveMove::along(curve, limits)))
            .collect()
    },
    allocated: bytes,
}

generator_conformance! {
    spline_track: SplineTrack<Irp6, std::vec::IntoIter<Vector3<f64>>>,
    class: "ECP f*0(c)",
    make: track(&wave(40, 2e-3), feed(0.1, 1.0)).expect("in range"),
    given: alone,
    odd: |x| {
        let odd_points = [x * Vector3::x(), Vector3::new(x, -x, 1.0), Vector3::repeat(x)];
        let mut odd: Vec<_> = odd_points
            .into_iter()
            .flat_map(|p| [track(&[p, p], feed(0.1, 1.0)), track(&[Vector3::zeros(), p, Vector3::y()], feed(0.1, 1.0))])
            .collect();
        odd.extend([track(&wave(20, x), feed(0.1, 1.0)), track(&[], feed(0.1, 1.0)), track(&wave(1, x), feed(0.1, 1.0))]);
        odd.extend([feed(x, 1.0), feed(0.1, x), feed(x, x)].map(|limits| track(&wave(20, 1e-3), limits)));
        odd.into_iter().flatten().collect()
    },
    allocated: bytes,
}

generator_conformance! {
    guarded_approach: GuardedApproach<Irp6, Wrist>,
    class: "ECP f*1(c, v), first step f*3(c, e, v)",
    make: GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, 0.5, |w: &Wrench| w.force.z < -5.0),
    given: |step| pressed(-0.02 * step as f64),
    odd: |x| vec![
        GuardedApproach::along(Vector3::z_axis(), x, 0.5, 0.5, |_| false),
        GuardedApproach::along(Vector3::z_axis(), 0.05, x, 0.5, |_| false),
        GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, x, |_| false),
        GuardedApproach::along(Vector3::z_axis(), x, x, x, |_| false),
    ],
    allocated: bytes,
}

generator_conformance! {
    transmit_displacement: TransmitDisplacement<Irp6>,
    class: "ECP f*4(c0, c)",
    make: TransmitDisplacement::new(),
    given: |step| ordered(1e-4 * step as f64),
    odd: |_| vec![TransmitDisplacement::new()],
    allocated: bytes,
}

generator_conformance! {
    yielding_transmit: YieldingTransmit<Irp6FiveDof>,
    class: "ECP f*4(c0, c), first step f*6(c0, c, e)",
    make: YieldingTransmit::by(Irp6FiveDof::nominal(), FreeDirection::Turn(Vector3::x_axis())),
    given: |step| {
        let pose = Pose::translation(0.0, 1e-5 * step as f64, 0.0);
        Given { order: Order::new(Displacement { pose }), e: State::new(five()), v: Reading::new(()) }
    },
    odd: |_| vec![YieldingTransmit::by(Irp6FiveDof::nominal(), FreeDirection::Turn(Vector3::x_axis()))],
    allocated: bytes,
}

generator_conformance! {
    rigid_carry: RigidCarry<Two, StraightBody>,
    class: "MP f*0(c0), first step f*2(c0, e)",
    make: RigidCarry::along(BodyFrame::Centroid, body()),
    given: pair,
    odd: |x| odd_bodies(x).map(|path| RigidCarry::along(BodyFrame::Centroid, path)).collect(),
    allocated: bytes,
}

generator_conformance! {
    follow_master: FollowMaster<Two, StraightBody>,
    class: "MP f*2(c0, e)",
    make: FollowMaster::along(body(), 0.02),
    given: pair,
    odd: |x| {
        let lags = [x, 0.02].into_iter().flat_map(|lag| odd_bodies(x).map(move |path| FollowMaster::along(path, lag)));
        lags.collect()
    },
    allocated: bytes,
}

generator_conformance! {
    shared_drive: SharedDrive<Two, StraightBody>,
    class: "MP f*0(c0), first step f*2(c0, e)",
    make: drive(body(), tool_limits(0.3, 1.0)),
    given: pair,
    odd: |x| {
        let limits = [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x)];
        limits.into_iter().flat_map(|limits| odd_bodies(x).map(move |path| drive(path, limits))).collect()
    },
    allocated: bytes,
}

generator_conformance! {
    squeezed_carry: SqueezedCarry<Two, [Wrist; 2], StraightBody>,
    class: "MP f*1(c0, v), first step f*3(c0, e, v)",
    make: squeezed(body(), 5.0, 0.01).expect("has reserve"),
    given: |step| Given { order: Order::new(()), e: pair_state(), v: Reading::new([load(0.01 * step as f64), load(-0.5)]) },
    odd: |x| {
        let squeezes = [(x, 0.01), (5.0, x)].into_iter();
        squeezes.flat_map(|(squeeze, inertia)| odd_bodies(x).filter_map(move |path| squeezed(path, squeeze, inertia))).collect()
    },
    allocated: bytes,
}

generator_conformance! {
    constant_order: ConstantOrder<Two, Displacement>,
    class: "MP f**() = const",
    make: ConstantOrder::to_all(Displacement { pose: Pose::identity() }),
    given: pair,
    odd: |_| vec![ConstantOrder::to_all(Displacement { pose: Pose::identity() })],
    allocated: bytes,
}

generator_conformance! {
    sleep: Sleep<Irp6>,
    class: "ECP f*0(c)",
    make: Sleep::lasting(0.5),
    given: alone,
    odd: |x| vec![Sleep::lasting(x)],
    allocated: bytes,
}

generator_conformance! {
    settle: Settle<Irp6>,
    class: "ECP f*2(c, e)",
    make: Settle::within(Six::repeat(1e-3), 0.5, 1.0),
    given: |step| Given { order: Order::new(()), e: State::new(behind(0.9_f64.powi(step as i32))), v: Reading::new(()) },
    odd: |x| vec![
        Settle::within(Six::repeat(x), 0.5, 1.0), Settle::within(Six::repeat(1e-3), x, 1.0),
        Settle::within(Six::repeat(1e-3), 0.5, x), Settle::within(Six::repeat(x), x, x),
    ],
    allocated: bytes,
}

generator_conformance! {
    tool_offset: ToolOffset<Irp6>,
    class: "ECP f*0(c)",
    make: ToolOffset::by(Pose::new(Vector3::new(0.05, 0.02, 0.1), Vector3::new(0.1, 0.2, 0.3)), tool_limits(0.3, 1.0)),
    given: alone,
    odd: |x| {
        let limits = [tool_limits(0.3, 1.0), tool_limits(x, 1.0), tool_limits(1.0, x), tool_limits(x, x)];
        limits.into_iter().flat_map(|limits| odd_poses(x).map(move |pose| ToolOffset::by(pose, limits))).collect()
    },
    allocated: bytes,
}

generator_conformance! {
    moving_frame: MovingFrame<Irp6, Belt>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: MovingFrame::to(belt(), start(), 0.5, 1.0),
    given: alone,
    odd: |x| {
        let mut odd = vec![MovingFrame::to(belt(), start(), x, 1.0), MovingFrame::to(belt(), start(), 0.5, x), MovingFrame::to(belt(), start(), x, x)];
        odd.extend(odd_poses(x).map(|pose| MovingFrame::to(belt(), pose, 0.5, 1.0)));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    followed_frame: FollowedFrame<Irp6, Camera>,
    class: "ECP f*1(c, v), first step f*3(c, e, v)",
    make: followed(Pose::identity(), 10.0, 1.0, 0.5, 1.0),
    given: |step| seen(step as f64 * 4e-4),
    odd: |x| {
        let mut odd: Vec<_> = odd_poses(x).map(|pose| followed(pose, 10.0, 1.0, 0.5, 1.0)).collect();
        odd.extend([(x, 1.0), (10.0, x), (x, x)].map(|(rate, most)| followed(Pose::identity(), rate, most, 0.5, 1.0)));
        odd.extend([(x, 1.0), (0.5, x), (x, x)].map(|(approach, duration)| followed(Pose::identity(), 10.0, 1.0, approach, duration)));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    force_law: ForceLaw<Irp6, Wrist>,
    class: "ECP f*1(c, v), first step f*3(c, e, v)",
    make: ForceLaw::lasting(law(10.0, 0.01, Give::FORCE).expect("in range"), 2.0, 1),
    given: |step| pressed(-0.02 * step as f64),
    odd: |x| {
        let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
        let mut laws = vec![law(x, 0.01, Give::FORCE), law(10.0, x, Give::FORCE), law(x, x, Give::FORCE)];
        laws.extend(gives.map(|give| law(10.0, 0.01, give)));
        let mut odd: Vec<_> = laws.into_iter().flatten().map(|law| ForceLaw::lasting(law, 2.0, 1)).collect();
        odd.push(ForceLaw::lasting(law(10.0, 0.01, Give::FORCE).expect("in range"), x, 1));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    eye_in_hand: EyeInHand<Irp6, Camera>,
    class: "ECP f*3(c, e, v)",
    make: EyeInHand::to(Pose::identity(), Pose::translation(0.0, 0.05, 0.0), |seen: &Displacement| Some(seen.pose), servoing(0.2, 0.2, 4.0)),
    given: |step| seen(step as f64 * 1e-4),
    odd: |x| {
        let mut odd: Vec<_> = odd_poses(x)
            .map(|pose| EyeInHand::to(pose, Pose::identity(), |seen: &Displacement| Some(seen.pose), servoing(0.2, 0.2, 4.0)))
            .collect();
        let how = [servoing(x, 0.2, 4.0), servoing(0.2, x, 4.0), servoing(0.2, 0.2, x), servoing(x, x, x)];
        odd.extend(how.map(|how| EyeInHand::to(Pose::identity(), Pose::identity(), |seen: &Displacement| Some(seen.pose), how)));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    watched_transmit: WatchedTransmit<Irp6>,
    class: "ECP f*6(c0, c, e)",
    make: WatchedTransmit::within(5e-3, 0.05),
    given: |step| ordered(1e-4 * step as f64),
    odd: |x| vec![WatchedTransmit::within(x, 0.05), WatchedTransmit::within(5e-3, x)],
    allocated: bytes,
}

generator_conformance! {
    compliant_transmit: CompliantTransmit<Irp6, Wrist>,
    class: "ECP f*5(c0, c, v)",
    make: CompliantTransmit::by(squeeze_law(0.01).expect("has reserve"), 1),
    given: |step| felt(step, Displacement { pose: Pose::translation(0.0, 0.0, 1e-4 * step as f64) }),
    odd: |x| squeeze_law(x).map(|law| CompliantTransmit::by(law, 1)).into_iter().collect(),
    allocated: bytes,
}

generator_conformance! {
    ordered_force: OrderedForce<Irp6, Wrist>,
    class: "ECP f*7(c0, c, e, v)",
    make: OrderedForce::with_tool(13.18, Give::FORCE),
    given: |step| felt(step, Pressing { force: 0.01 * step as f64, across: [0.01, 0.0] }),
    odd: |x| {
        let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
        let mut odd: Vec<_> = gives.map(|give| OrderedForce::with_tool(10.0, give)).into();
        odd.push(OrderedForce::with_tool(x, Give::FORCE));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    guided_body: GuidedBody<Two, [Wrist; 2]>,
    class: "MP f*3(c0, e, v)",
    make: GuidedBody::yielding(Give::FORCE, 1.0, 1.0, 2.0),
    given: |step| Given { order: Order::new(()), e: pair_state(), v: Reading::new([load(0.01 * step as f64), load(-0.5)]) },
    odd: |x| {
        let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
        let mut odd: Vec<_> = gives.map(|give| GuidedBody::yielding(give, 1.0, 1.0, 2.0)).into();
        odd.extend([(x, 1.0, 2.0), (1.0, x, 2.0), (1.0, 1.0, x)].map(|(a, b, c)| GuidedBody::yielding(Give::FORCE, a, b, c)));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    sequence: Sequence<StraightLine<Irp6>, StraightLine<Irp6>>,
    class: "ECP f*2(c, e)",
    make: Sequence::of(StraightLine::to(away(), tool_limits(0.3, 1.0)), StraightLine::to(start(), tool_limits(0.3, 1.0))),
    // The second begins where the first has led the arm.
    given: |step| Given {
        order: Order::new(()),
        e: State::new(if step == 0 { image() } else { image_at(away()) }),
        v: Reading::new(()),
    },
    odd: |x| odd_poses(x)
        .map(|pose| Sequence::of(StraightLine::to(away(), tool_limits(0.3, 1.0)), StraightLine::to(pose, tool_limits(0.3, 1.0))))
        .collect(),
    allocated: bytes,
}

generator_conformance! {
    handover: Handover<MovingFrame<Irp6, Belt>, StraightLine<Irp6>, Irp6>,
    class: "ECP f*2(c, e)",
    make: handed(start(), 0.2),
    // The second begins where the first has led the arm.
    given: |step| Given {
        order: Order::new(()),
        e: State::new(if step == 0 { image() } else { image_at(Pose::translation(0.06, 0.0, 0.0) * start()) }),
        v: Reading::new(()),
    },
    odd: |x| {
        let mut odd: Vec<_> = odd_poses(x).map(|pose| handed(pose, 0.2)).collect();
        odd.push(handed(away(), x));
        odd
    },
    allocated: bytes,
}

generator_conformance! {
    in_parallel: InParallel<JointMove<Irp6>, StraightLine<Irp6>>,
    class: "MP f*0(c0), first step f*2(c0, e)",
    make: InParallel::of(
        JointMove::to(arm() + Six::repeat(0.2), Six::repeat(0.5), Six::repeat(1.0)),
        StraightLine::by(Pose::translation(0.0, 0.0, 0.05), tool_limits(0.3, 1.0)),
    ),
    given: |_| Given { order: Order::new(()), e: State::new((image(), image())), v: Reading::new(()) },
    odd: |x| odd_poses(x)
        .map(|pose| InParallel::of(
            JointMove::to(Six::repeat(x), Six::repeat(0.5), Six::repeat(1.0)),
            StraightLine::by(pose, tool_limits(0.3, 1.0)),
        ))
        .collect(),
    allocated: bytes,
}

generator_conformance! {
    corrected: Corrected<StraightLine<Irp6>, Camera>,
    class: "ECP f*1(c, v), first step f*3(c, e, v)",
    make: corrected(0.02, 0.2, 1.0),
    given: |step| seen(1e-5 * step as f64),
    odd: |x| vec![corrected(x, 0.2, 1.0), corrected(0.02, x, 1.0), corrected(0.02, 0.2, x), corrected(x, x, x)],
    allocated: bytes,
}

generator_conformance! {
    override_: Override<GuardedApproach<Irp6, Wrist>, ForceLaw<Irp6, Wrist>>,
    class: "ECP f*3(c, e, v)",
    make: overridden(0.2),
    given: |step| pressed(-0.02 * step as f64),
    odd: |x| vec![overridden(x)],
    allocated: bytes,
}

generator_conformance! {
    replay: Replay<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: Replay::of(shown(0.1, 0.5, Space::Zyz).expect("in range"), Six::repeat(1.0), Six::repeat(2.0), tool_limits(0.3, 1.0)),
    given: alone,
    odd: |x| {
        let all = [Space::Motor, Space::Joint, Space::Zyz, Space::AngleAxis].into_iter();
        let taught = all.flat_map(|space| [shown(x, 0.5, space), shown(0.1, x, space), shown(x, x, space)]).flatten();
        let one = |taught: Taught| [
            Replay::of(taught.clone(), Six::repeat(1.0), Six::repeat(2.0), tool_limits(0.3, 1.0)),
            Replay::of(taught.clone(), Six::repeat(x), Six::repeat(2.0), tool_limits(x, 1.0)),
            Replay::of(taught, Six::repeat(1.0), Six::repeat(x), tool_limits(0.3, x)),
        ];
        taught.flat_map(one).collect()
    },
    allocated: bytes,
}

generator_conformance! {
    jog: Jog<Irp6, fn() -> Jogging>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: Jog::by(|| Jogging { along: Vector3::x() * 0.1, record: true, ..Jogging::default() }, 1.0, 1.0, 1),
    given: alone,
    odd: |x| vec![
        Jog::by(|| Jogging { along: Vector3::x() * 0.1, ..Jogging::default() }, x, 1.0, 1),
        Jog::by(|| Jogging { about: Vector3::x() * f64::NAN, ..Jogging::default() }, 1.0, 1.0, 1),
        Jog::by(|| Jogging { about: Vector3::x() * 1e300, ..Jogging::default() }, 1.0, x, 1),
        Jog::by(|| Jogging { along: Vector3::x() * 1e100, ..Jogging::default() }, 1e300, 1e300, 0),
    ],
    allocated: bytes,
}

generator_conformance! {
    delay: Delay<Irp6>,
    class: "ECP f*0(c)",
    make: Delay::lasting(0.5),
    given: alone,
    odd: |x| vec![Delay::lasting(x)],
    allocated: bytes,
}

generator_conformance! {
    await_operator: AwaitOperator<Irp6, fn() -> bool>,
    class: "ECP f*0(c)",
    make: AwaitOperator::until(|| false),
    given: alone,
    odd: |_| vec![AwaitOperator::until(|| true)],
    allocated: bytes,
}

/// Every file of the two folders is named above as a module, and its allocations are counted.
#[test]
fn every_generator_of_the_library_is_held_to_this() {
    let (folder, text) = (concat!(env!("CARGO_MANIFEST_DIR"), "/src"), include_str!("main.rs"));
    let folders = ["generators", "combinators"].map(|name| std::fs::read_dir(format!("{folder}/{name}")));
    for entry in folders.into_iter().flat_map(|entries| entries.expect("a folder")) {
        let file = entry.expect("an entry").file_name().into_string().expect("a plain name");
        let Some(name) = file.strip_suffix(".rs") else { continue };
        assert!(
            ["mod", "joined"].contains(&name) || text.contains(&format!("\n    {name}: ")),
            "{name} is held to nothing"
        );
    }
    // In two pieces, or these lines would count themselves.
    let blocks = text.matches(concat!("generator_", "conformance! {")).count();
    assert_eq!(text.matches(concat!("    allocated: ", "bytes,\n")).count(), blocks);
}
