//! Goals that a motion names: what certainly cannot be reached is refused with the demand that names it, and nothing else is.

use super::*;
use crate::model::beside::GOAL_ROUND_OFF;
use crate::model::demand::Demand;
use crate::model::fault::FaultKind;
use crate::model::pose::Pose;

/// What becomes of a demand to stay that names this goal; nothing has changed where it is refused.
fn named(robot: &Turntable, goal: Demand<Turntable>) -> Result<(), Fault> {
    let mut acceptor = Acceptor::new(robot.clone(), Pose::identity(), Two::zeros(), REACTION);
    acceptor.begin();
    let accepted = acceptor.accept(&Demand::hold().with_goal(goal), T, T).map(drop);
    assert_eq!(acceptor.demanded().0, Two::zeros());
    accepted
}

#[test]
fn fault_130_a_goal_beyond_a_joint_s_limit_is_refused_by_joint_value_and_limit() {
    let robot = Turntable::new();
    let to = |x: f64, y: f64| named(&robot, Demand::joints(Two::new(x, y)));
    assert_eq!(to(1.0, -1.0), Ok(()));
    // What the seven digits of a goal do not tell is no excess.
    assert_eq!(to(1.0 + 0.4 * GOAL_ROUND_OFF, 0.0), Ok(()));
    for (x, y, joint, actual, limit, unit) in
        [(1.5, 0.0, 0, 1.5, 1.0, "m"), (0.0, -2.0, 1, -2.0, -1.0, "rad"), (f64::NAN, 0.0, 0, 0.0, 0.0, "")]
    {
        let fault = to(x, y).expect_err("out of reach");
        assert_eq!((fault.joint(), fault.message()), (Some(joint), GOAL));
        match x.is_nan() {
            true => assert_eq!(fault.kind(), FaultKind::DemandNotFinite),
            false => {
                assert_eq!(fault.kind(), FaultKind::DemandOutOfRange);
                assert_eq!(fault.excess(), Some(Excess::new(actual, limit, unit)));
            }
        }
    }
    // A limit that joints share.
    let robot = Turntable { sum: 1.5, ..robot };
    let fault = named(&robot, Demand::joints(Two::new(0.9, 0.9))).expect_err("too much together");
    assert!(fault.kind() == FaultKind::DemandOutOfRange && fault.message().starts_with(GOAL), "{fault}");
    assert_eq!(named(&robot, Demand::joints(Two::new(0.7, 0.7))), Ok(()));
}

#[test]
fn fault_130_a_pose_is_refused_as_a_goal_only_where_it_certainly_has_no_joints() {
    let far = NoInverse::OutOfReach { distance: 2.5, min: 0.1, max: 1.2 };
    let near = NoInverse::OutOfReach { distance: 0.05, min: 0.1, max: 1.2 };
    let rounded = NoInverse::OutOfReach { distance: 1.2 + 1e-7, min: 0.1, max: 1.2 };
    let lean = |actual| NoInverse::NotAttainable { what: "lean", actual, tolerance: 1e-6, unit: "rad" };
    for (no_inverse, limit) in [
        (far, Some(1.2)),
        (near, Some(0.1)),
        (rounded, None),
        (lean(0.2), Some(1e-6)),
        (lean(1.5e-6), None),
        (NoInverse::Singular { name: "wrist" }, None),
        (NoInverse::NotRedundant, None),
        // From nearer a search may find it.
        (NoInverse::NotConverged { error: 0.1, tolerance: 1e-9 }, None),
    ] {
        let robot = Turntable { no_inverse: Some(no_inverse), ..Turntable::new() };
        for goal in [Demand::pose(Pose::translation(0.5, 0.0, 0.0)), Demand::displacement(Pose::identity())] {
            let refused = named(&robot, goal);
            match limit {
                None => assert_eq!(refused, Ok(()), "{no_inverse:?}"),
                Some(limit) => {
                    let fault = refused.expect_err("out of reach");
                    assert_eq!(fault.kind(), FaultKind::NoInverseKinematics);
                    assert!(fault.message().starts_with("its goal: "), "{fault}");
                    assert!(fault.excess().is_some_and(|excess| excess.limit == limit), "{fault}");
                    assert!(fault.help().is_some_and(|help| help.contains("goal")), "{fault}");
                }
            }
        }
    }
    // A displacement counts from the tool's pose at the start; this robot has joints for any.
    assert_eq!(named(&Turntable::new(), Demand::displacement(Pose::translation(0.3, 0.0, 0.0))), Ok(()));
}
