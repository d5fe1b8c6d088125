//! Two arms of five joints and a body, as in the paper's demonstration: what a free direction of the grasps resolves, and
//! what is refused before anything moves.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::{JointVector, NoInverse, RobotState};
use mrroc_generators::cooperation::{
    Arm, ArmModel, BodyFrame, Cause, Displacement, DryRunError, FreeDirection, StraightBody, dry_run,
};
use mrroc_generators::generators::{RigidCarry, YieldingTransmit};
use mrroc_robots::{Five, Irp6, Irp6FiveDof, Kinematics};
use nalgebra::{UnitQuaternion, Vector3};

use super::kit::{STEP, Trace, arm, irp6_start, limits};

/// Tools level, along the arms: the tool's x axis is upright.
fn start() -> Five {
    let theta3 = -1.5 + 0.1 + std::f64::consts::FRAC_PI_2;
    Five::new(0.0, -1.5, 0.1, -theta3, 0.0)
}

/// Two arms that face one another across a body of 0.3 m.
fn robots() -> [Irp6FiveDof; 2] {
    let reach = Irp6FiveDof::nominal().forward(&start()).translation.x;
    [0.0, std::f64::consts::PI].map(|angle| {
        let base = Pose::rotation(Vector3::z() * angle) * Pose::translation(-reach - 0.15, 0.0, 0.0);
        Irp6FiveDof::nominal().with_base(base)
    })
}

fn state<R: Robot>(robot: &R, joints: R::Joints) -> RobotState<R> {
    RobotState { joints, velocity: R::Joints::zeros(), pose: robot.forward(&joints) }
}

/// Sideways: the arms' planes turn, and the level tools with them.
fn sideways() -> StraightBody {
    StraightBody::by(Pose::translation(0.0, 0.06, 0.0), limits())
}

const UPRIGHT: FreeDirection =
    FreeDirection::Turn(nalgebra::Unit::new_unchecked(Vector3::new(1.0, 0.0, 0.0)));

#[test]
fn a_motion_that_five_joints_cannot_make_is_refused_with_the_direction() {
    let mut arms = robots().map(|robot| Arm::new(robot.clone(), &state(&robot, start())));
    let [left, right] = &mut arms;
    let refused =
        dry_run(sideways(), 2e-3, BodyFrame::Centroid, &mut [left, right]).expect_err("five joints");
    let DryRunError::Unattainable(refused) = refused else { panic!("{refused}") };
    let Cause::NoInverse(NoInverse::NotAttainable { actual, .. }) = refused.cause else {
        panic!("{refused}")
    };
    assert!(actual > Irp6FiveDof::LEAN);
    // The column turns the tool by 1 / rho where it moves it aside: an upright turn of the tool, its x, is not its own.
    assert!(refused.direction.turning.x.abs() > 0.95, "{refused}");
    assert!(refused.to_string().contains("turning about (1.00, 0.00, 0.00)"), "{refused}");
    assert!(refused.time < 0.1, "{refused}");
    // Upwards nothing is in the way: D / V + V / A = 0.03 / 0.1 + 0.5, or 2 sqrt(D / A) without full speed.
    let mut arms = robots().map(|robot| Arm::new(robot.clone(), &state(&robot, start())));
    let [left, right] = &mut arms;
    let up = StraightBody::by(Pose::translation(0.0, 0.0, 0.03), limits());
    let duration = dry_run(up, 2e-3, BodyFrame::Centroid, &mut [left, right]).expect("in the arms' planes");
    assert!((duration - 2.0 * (0.03_f64 / 0.2).sqrt()).abs() <= 2e-3, "{duration}");
}

#[test]
fn the_direction_that_fails_is_one_that_no_joint_gives() {
    let (robot, q) = (Irp6FiveDof::nominal(), Five::new(0.3, -1.5, 0.1, 0.2, 0.7));
    let mut arm = Arm::new(robot.clone(), &state(&robot, q));
    let leaning = robot.forward(&q) * Pose::rotation(Vector3::new(0.3, 0.2, 0.0));
    let refused = arm.follow(&leaning).expect_err("leans");
    let direction = refused.direction;
    // Of the analytic Jacobian in the world's axes; turned into the tool's, and weighted as the direction is.
    let back = robot.forward(&q).rotation.inverse();
    for column in robot.jacobian(&q).column_iter() {
        let moving = back * Vector3::new(column[0], column[1], column[2]);
        let turning = back * Vector3::new(column[3], column[4], column[5]);
        let given = moving.dot(&direction.moving) / 0.01 + turning.dot(&direction.turning);
        assert!(given.abs() < 1e-8, "{given}");
    }
}

#[test]
fn a_free_direction_resolves_it_and_six_joints_need_none() {
    let mut arms = robots().map(|robot| Arm::new(robot.clone(), &state(&robot, start())).free_in(UPRIGHT));
    let [left, right] = &mut arms;
    dry_run(sideways(), 2e-3, BodyFrame::Centroid, &mut [left, right]).expect("free to turn");
    // The tools have turned with the arms' planes, by the angle of the column.
    for (arm, robot) in arms.iter().zip(&robots()) {
        let p = robot.forward(&start()).translation.vector.x.abs() - 0.15;
        let reach = Irp6FiveDof::nominal().forward(&start()).translation.x;
        assert!(p.abs() < 1e-12);
        assert!((arm.freely().abs() - (0.06 / reach).atan()).abs() < 1e-9, "{}", arm.freely());
        assert!((arm.joints()[0].abs() - (0.06 / reach).atan()).abs() < 1e-9);
    }
    // The wrong direction does not help.
    let along = FreeDirection::Turn(Vector3::z_axis());
    let mut arms = robots().map(|robot| Arm::new(robot.clone(), &state(&robot, start())).free_in(along));
    let [left, right] = &mut arms;
    let refused =
        dry_run(sideways(), 2e-3, BodyFrame::Centroid, &mut [left, right]).expect_err("not that one");
    assert!(
        matches!(refused, DryRunError::Unattainable(refused) if matches!(refused.cause, Cause::NotSolved(_)))
    );
    let six = Irp6::nominal();
    let mut arm = Arm::new(six.clone(), &state(&six, irp6_start()));
    dry_run(sideways(), 2e-3, BodyFrame::Centroid, &mut [&mut arm]).expect("six joints");
}

#[test]
fn limits_of_joints_are_named() {
    let six = Irp6::nominal();
    let mut arm = Arm::new(six.clone(), &state(&six, irp6_start()));
    let turn = StraightBody::by(Pose::rotation(Vector3::z() * 3.0), limits());
    let refused = dry_run(turn, 2e-3, BodyFrame::InFirstTool(Pose::identity()), &mut [&mut arm]);
    let Err(DryRunError::Unattainable(refused)) = refused else { panic!("{refused:?}") };
    let Cause::Limit { joint: 6, actual, limit, unit: "rad" } = refused.cause else { panic!("{refused}") };
    assert!(actual.abs() > limit.abs() && [six.limits().lower[5], six.limits().upper[5]].contains(&limit));
    // What fails is what the sixth joint alone would give, up to the last increment's turn.
    let mut q = *arm.joints();
    q[5] = limit;
    let back = six.forward(&q).rotation.inverse();
    let jacobian = six.jacobian(&q);
    let given = jacobian.column_iter().map(|column| {
        let moving = back * Vector3::new(column[0], column[1], column[2]);
        let turning = back * Vector3::new(column[3], column[4], column[5]);
        moving.dot(&refused.direction.moving) / 0.01 + turning.dot(&refused.direction.turning)
    });
    let given: Vec<_> = given.collect();
    assert!(given[..5].iter().all(|g| g.abs() < 0.02) && given[5].abs() > 0.1, "{given:?}");
}

/// Both arms' cell; each yields in `free`, or is transparent.
fn cell(free: Option<FreeDirection>) -> (Cell, Trace, Trace) {
    let robots = robots();
    let (left, one, _) = arm("left", &robots[0], &start());
    let (right, two, _) = arm("right", &robots[1], &start());
    let cell = Cell::new(STEP).robot(left).robot(right);
    let Some(free) = free else { return (cell, one, two) };
    let program = |robot: Irp6FiveDof| {
        move |ecp: &mut Ecp<Irp6FiveDof>| {
            ecp.serve_all(|ecp, _: Displacement| {
                ecp.move_robot((), YieldingTransmit::by(robot.clone(), free)).map(drop)
            })
        }
    };
    let [first, second] = robots;
    (cell.ecp("left", program(first)).ecp("right", program(second)), one, two)
}

/// Met at once: a Wait that only asks where the robots are.
struct Asked;

#[condition(mp)]
fn asked(_c: &mut Asked) -> bool {
    true
}

fn refused_or_carried(mp: &mut Mp, free: Option<FreeDirection>) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6FiveDof>("left")?, mp.robot::<Irp6FiveDof>("right")?);
    mp.wait_until((&mut left, &mut right), (), Asked)?;
    let [one, two] = robots();
    let mut one = Arm::new(one, left.demanded()).named(left.name());
    let mut two = Arm::new(two, right.demanded()).named(right.name());
    if let Some(free) = free {
        (one, two) = (one.free_in(free), two.free_in(free));
    }
    dry_run(sideways(), 2e-3, BodyFrame::Centroid, &mut [&mut one, &mut two])?;
    let carry = RigidCarry::along(BodyFrame::Centroid, sideways()).by_displacements();
    mp.move_robots([&mut left, &mut right], (), carry).map(drop)
}

#[test]
fn a_program_refuses_before_anything_moves() {
    let (cell, left, right) = cell(None);
    let Err(mrroc::cell::CellError::Fault(fault)) = cell.program(|mp| refused_or_carried(mp, None)).run()
    else {
        panic!("five joints")
    };
    assert_eq!(fault.kind(), FaultKind::Program);
    assert!(fault.message().starts_with("left cannot follow in turning about (1.00, 0.00, 0.00)"), "{fault}");
    for trace in [left, right] {
        let trace = trace.demanded.borrow();
        assert!(trace.iter().all(|pose| *pose == trace[0]));
    }
}

#[test]
fn arms_that_yield_keep_the_body_but_for_the_free_turn() {
    for at in [50, 200, 300] {
        let (cell, left, right) = cell(Some(UPRIGHT));
        let cell = cell.program(|mp| refused_or_carried(mp, Some(UPRIGHT))).on_step(move |step, operator| {
            if step == at {
                operator.suspend();
            }
            if step == at + 200 {
                operator.resume();
            }
        });
        cell.run().expect("within the limits");
        let (left, right) = (left.demanded.borrow(), right.demanded.borrow());
        let apart = left[0].translation.vector - right[0].translation.vector;
        for (left_tool, right_tool) in left.iter().zip(right.iter()) {
            let error = left_tool.translation.vector - right_tool.translation.vector - apart;
            assert!(error.norm() <= 1e-9, "{error}");
        }
        for trace in [&left, &right] {
            for tool in trace.iter() {
                let turn: UnitQuaternion<f64> = trace[0].rotation.inverse() * tool.rotation;
                assert!(turn.j.abs().max(turn.k.abs()) <= 1e-9, "{turn}");
            }
            let displacement = trace[trace.len() - 1].translation.vector - trace[0].translation.vector;
            assert!((displacement - Vector3::new(0.0, 0.06, 0.0)).norm() <= 1e-9, "{displacement}");
        }
    }
}
