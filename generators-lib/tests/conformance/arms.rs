//! Generators of several arms.

use super::kit::{Two, Wrist, body, bytes, drive, load, odd_bodies, pair, pair_state, squeezed, tool_limits};
use mrroc::prelude::*;
use mrroc_generators::conformance::Given;
use mrroc_generators::cooperation::{BodyFrame, Displacement, StraightBody};
use mrroc_generators::force::Give;
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{
    ConstantOrder, FollowMaster, GuidedBody, RigidCarry, SharedDrive, SqueezedCarry,
};

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
