//! What a refusal says of poses.

use super::*;

const ZERO: Two = Two::new(0.0, 0.0);

#[test]
fn fault_23_a_pose_that_breaks_a_limit_beside_a_singularity_names_it() {
    let far = Demand::pose(Pose::translation(0.5, 0.0, 0.0)).with_tool(Pose::identity());
    let mut acceptor = acceptor(Turntable { singular: Some("beside a pole"), ..Turntable::new() });
    let message = |acceptor: &mut Acceptor<Turntable>, demand: &Demand<Turntable>| {
        acceptor.accept(demand, T, T).expect_err("too far").message().to_owned()
    };
    assert_eq!(message(&mut acceptor, &far), "beside a pole");
    assert_eq!(message(&mut acceptor, &joints(0.5, 0.0)), "");
    // What the fault says itself comes first.
    acceptor.checks.robot.sum = -1.0;
    let here = Demand::pose(Pose::identity()).with_tool(Pose::identity());
    assert_eq!(message(&mut acceptor, &here), "sum, beside a pole");
    acceptor.checks.robot.singular = None;
    assert_eq!(message(&mut acceptor, &far), "");
}

#[test]
fn a_pose_that_breaks_a_limit_by_an_inverse_that_is_none_says_so() {
    let mut acceptor = acceptor(Turntable::new());
    let by = |acceptor: &mut Acceptor<Turntable>, off: f64| {
        acceptor.checks.robot.off = off;
        let here = Demand::pose(acceptor.tool_pose(&ZERO));
        acceptor.accept(&here, T, T).expect_err("too far")
    };
    let fault = by(&mut acceptor, 1.1e-3);
    assert_eq!((fault.kind(), fault.message()), (FaultKind::NoInverseKinematics, DISAGREEMENT));
    near(fault.excess().expect("a distance").actual, 1.1e-3);
    // 0.9 m/s at once is too much, but a robot as accurate as that is one.
    assert_eq!(by(&mut acceptor, 0.9e-3).kind(), FaultKind::DemandedAcceleration);
}

#[test]
fn fault_23_a_wrist_that_is_out_of_reach_is_so_by_the_nearer_end() {
    for (distance, limit) in [(1.3, 1.2), (0.1, 0.2)] {
        let no_inverse = Some(NoInverse::OutOfReach { distance, min: 0.2, max: 1.2 });
        let mut acceptor = acceptor(Turntable { no_inverse, ..Turntable::new() });
        let fault = acceptor.accept(&Demand::pose(Pose::identity()), T, T).expect_err("out of reach");
        assert_eq!(fault.kind(), FaultKind::NoInverseKinematics);
        let excess = fault.excess().expect("a distance");
        assert_eq!((excess.actual, excess.limit), (distance, limit));
    }
}
