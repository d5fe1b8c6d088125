//! Generators made of generators.

use super::kit::{
    Arbitrated, Belt, Camera, Wrist, arbitrated, arm, away, bytes, compliant, corrected, handed, image,
    image_at, odd_poses, overridden, pressed, seen, start, superposed, tool_limits,
};
use mrroc::prelude::*;
use mrroc_generators::combinators::{Blind, Compliant, Corrected, Handover, Override, Sequence, Superpose};
use mrroc_generators::conformance::Given;
use mrroc_generators::generator_conformance;
use mrroc_generators::generators::{ForceLaw, GuardedApproach, JointMove, MovingFrame, StraightLine};
use mrroc_robots::{Irp6, Six};

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
    each: Each<(JointMove<Irp6>, StraightLine<Irp6>)>,
    class: "MP f*0(c0), first step f*2(c0, e)",
    make: Each::of((
        JointMove::to(arm() + Six::repeat(0.2), Six::repeat(0.5), Six::repeat(1.0)),
        StraightLine::by(Pose::translation(0.0, 0.0, 0.05), tool_limits(0.3, 1.0)),
    )),
    given: |_| Given { order: Order::new(()), e: State::new((image(), image())), v: Reading::new(()) },
    odd: |x| odd_poses(x)
        .map(|pose| Each::of((
            JointMove::to(Six::repeat(x), Six::repeat(0.5), Six::repeat(1.0)),
            StraightLine::by(pose, tool_limits(0.3, 1.0)),
        )))
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
    compliant: Compliant<StraightLine<Irp6>, Wrist>,
    class: "ECP f*1(c, v), first step f*3(c, e, v)",
    make: compliant(10.0, 0.01, 0.2),
    given: |step| pressed(-0.02 * step as f64),
    odd: |x| vec![
        compliant(x, 0.01, 0.2),
        compliant(10.0, x, 0.2),
        compliant(10.0, 0.01, x),
        compliant(x, x, x),
    ],
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
    arbitrate: Arbitrated,
    class: "ECP f*3(c, e, v)",
    make: arbitrated(0.2),
    // Touched and free in turn.
    given: |step| pressed(-10.0 * (0.01 * step as f64).sin().max(0.0)),
    odd: |x| vec![arbitrated(x)],
    allocated: bytes,
}

generator_conformance! {
    superpose: Superpose<GuardedApproach<Irp6, Wrist>, ForceLaw<Irp6, Wrist>>,
    class: "ECP f*1(c, v), first step f*3(c, e, v)",
    make: superposed(0.2),
    given: |step| pressed(-10.0 * (0.01 * step as f64).sin().max(0.0)),
    odd: |x| vec![superposed(x)],
    allocated: bytes,
}

generator_conformance! {
    blind: Blind<StraightLine<Irp6>, (Wrist,)>,
    class: "ECP f*0(c), first step f*2(c, e)",
    make: Blind::new(StraightLine::to(away(), tool_limits(0.3, 1.0))),
    given: |_| pressed(-10.0),
    odd: |x| odd_poses(x).map(|pose| Blind::new(StraightLine::to(pose, tool_limits(0.3, 1.0)))).collect(),
    allocated: bytes,
}
