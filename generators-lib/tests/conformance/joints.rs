//! Generators that move one robot by its joints.

use super::kit::{alone, arm, bytes, joint_limits, odd_limits, path_limits, reaching};
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{
    JointMove, JointSpline, JointVelocity, JointVia, ReachState, SmoothJointMove, TimeOptimalJoints,
};
use mrroc_robots::{Irp6, Six};

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
    reach_state: ReachState<Irp6>,
    class: "ECP f*4(c0, c), first step f*6(c0, c, e)",
    make: ReachState::within(joint_limits(0.5, 1.0, 10.0)),
    given: |step| reaching(if step < 100 { 0.2 } else { -0.1 }),
    odd: |x| odd_limits(x).map(|[v, a, j]| ReachState::within(joint_limits(v, a, j))).into(),
    allocated: bytes,
}

generator_conformance! {
    joint_velocity: JointVelocity<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: JointVelocity::of(Six::repeat(0.1), Six::repeat(1.0)),
    given: alone,
    odd: |x| vec![
        JointVelocity::of(Six::zeros(), Six::repeat(1.0)),
        JointVelocity::of(Six::repeat(x), Six::repeat(1.0)),
        JointVelocity::of(Six::repeat(0.1), Six::repeat(x)),
        JointVelocity::of(Six::repeat(x), Six::repeat(x)),
    ],
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
