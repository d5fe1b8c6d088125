//! Generators that move one tool along a path, or as it was taught.

use super::kit::{
    Belt, alone, away, belt, bytes, feed, helix, odd_limits, odd_poses, path_limits, shown, smooth_limits,
    start, tool_limits, track, wave, within,
};
use mrroc::operator::jog::{JogNow, JogOrder, JogPanel};
use mrroc::pose::Pose;
use mrroc_generators::curve::Helix;
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{
    CircularMove, CurveMove, Jog, LineVia, MovingFrame, PanelJog, PoseSplineMove, Replay, SpiralSearch,
    SplineTrack, StraightLine, TiltSearch, TimeOptimalCurve, ToolOffset,
};
use mrroc_generators::jogging::JogLimits;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_generators::teach::{Jogging, Space, Taught};
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

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

/// Sizes that are none, one at a time and both.
fn odd_sizes(x: f64) -> [[f64; 2]; 4] {
    [[0.02, 8e-3], [x, 8e-3], [0.02, x], [x, x]]
}

generator_conformance! {
    spiral_search: SpiralSearch<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: SpiralSearch::over(0.02, 8e-3, JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 }),
    given: alone,
    odd: |x| {
        let limits = odd_limits(x).map(|[velocity, acceleration, jerk]| JerkLimits { velocity, acceleration, jerk });
        let of = |limits| odd_sizes(x).map(|[radius, pitch]| SpiralSearch::over(radius, pitch, limits));
        limits.into_iter().flat_map(of).collect()
    },
    allocated: bytes,
}

generator_conformance! {
    tilt_search: TiltSearch<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: TiltSearch::within(0.1, 0.04, JerkLimits { velocity: 0.5, acceleration: 2.0, jerk: 20.0 }),
    given: alone,
    odd: |x| {
        let limits = odd_limits(x).map(|[velocity, acceleration, jerk]| JerkLimits { velocity, acceleration, jerk });
        let of = |limits| odd_sizes(x).map(|[largest, pitch]| TiltSearch::within(largest, pitch, limits));
        limits.into_iter().flat_map(of).collect()
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

/// Jogged down, by a panel on which a button is held all the time.
fn jogged(limits: JogLimits) -> PanelJog<Irp6> {
    let (panel, seat) = JogPanel::alone(Irp6::nominal());
    let order = JogOrder::read(&mut "world z -40%".split_whitespace()).expect("an order");
    seat.say(JogNow::Order { press: 1, order });
    PanelJog::within(panel, limits)
}

generator_conformance! {
    panel_jog: PanelJog<Irp6>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: jogged(JogLimits::default()),
    given: alone,
    odd: |x| vec![
        jogged(JogLimits { speed: x, ..JogLimits::default() }),
        jogged(JogLimits { turn: x, ..JogLimits::default() }),
        jogged(JogLimits { acceleration: x, ..JogLimits::default() }),
        jogged(JogLimits { turning_acceleration: x, ..JogLimits::default() }),
        jogged(JogLimits { joints: x, ..JogLimits::default() }),
        jogged(JogLimits { margin: x, ..JogLimits::default() }),
    ],
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
