//! Generators as they are made otherwise than in their rows of the registry.

use super::kit::{Two, alone, body, bytes, odd_bodies, odd_limits, odd_poses, pair, smooth_limits, start};
use mrroc::pose::Pose;
use mrroc_generators::cooperation::{BodyFrame, Displacement, StraightBody};
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{RigidCarry, StraightLine};
use mrroc_generators::line::SmoothToolLimits;
use mrroc_robots::Irp6;
use nalgebra::Vector3;

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
    rigid_carry_by_displacements: RigidCarry<Two, StraightBody, Displacement>,
    class: "MP f*0(c0), first step f*2(c0, e)",
    make: RigidCarry::along(BodyFrame::Centroid, body()).by_displacements(),
    given: pair,
    odd: |x| odd_bodies(x).map(|path| RigidCarry::along(BodyFrame::Centroid, path).by_displacements()).collect(),
    allocated: bytes,
}
