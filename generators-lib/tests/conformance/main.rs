//! Every generator of the library keeps what a generator must keep.

mod kit;

use kit::*;
use mrroc::{Order, Pose, Reading, State, Wrench};
use mrroc_generators::conformance::Given;
use mrroc_generators::cooperation::*;
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::*;
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

/// Every file of the generators' folder is named above as a module, or here with the reason why not.
#[test]
fn every_generator_of_the_library_is_held_to_this() {
    let (folder, text) = (concat!(env!("CARGO_MANIFEST_DIR"), "/src/generators"), include_str!("main.rs"));
    for entry in std::fs::read_dir(folder).expect("the folder of the generators") {
        let file = entry.expect("an entry").file_name().into_string().expect("a plain name");
        let name = file.trim_end_matches(".rs");
        assert!(name == "mod" || text.contains(&format!("\n    {name}: ")), "{name} is held to nothing");
    }
}
