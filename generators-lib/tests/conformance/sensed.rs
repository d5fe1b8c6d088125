//! Generators that follow sensors or a coordinator's orders.

use super::kit::{
    Camera, Wrist, bytes, felt, five, followed, law, odd_poses, ordered, pressed, seen, servoing, squeeze_law,
};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc_generators::conformance::Given;
use mrroc_generators::cooperation::{Displacement, FreeDirection};
use mrroc_generators::force::{Bound, Give};
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{
    CompliantTransmit, EyeInHand, FollowedFrame, ForceLaw, GuardedApproach, OrderedForce, Pressing,
    TransmitDisplacement, WatchedTransmit, YieldingTransmit,
};
use mrroc_robots::{Irp6, Irp6FiveDof};
use nalgebra::Vector3;

/// More than the motions below need.
const WIDE: Bound = Bound { speed: 1.0, travel: 10.0 };

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
    make: OrderedForce::with_tool(13.18, Give::FORCE, WIDE),
    given: |step| felt(step, Pressing { force: 0.01 * step as f64, across: [0.01, 0.0] }),
    odd: |x| {
        let gives = [(x, 1.0), (0.01, x), (x, x)].map(|(reciprocal_damping, inertia)| Give { reciprocal_damping, inertia });
        let mut odd: Vec<_> = gives.map(|give| OrderedForce::with_tool(10.0, give, WIDE)).into();
        odd.push(OrderedForce::with_tool(x, Give::FORCE, WIDE));
        odd.push(OrderedForce::with_tool(10.0, Give::FORCE, Bound { speed: x, travel: x }));
        odd
    },
    allocated: bytes,
}
