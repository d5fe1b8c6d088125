//! Masters and slaves, and loops that share a drive frame.

use mrroc::prelude::*;
use mrroc_generators::cooperation::{KinematicLoop, StraightBody};
use mrroc_generators::generators::{FollowMaster, SharedDrive};
use mrroc_robots::Irp6;
use nalgebra::Vector3;

use super::kit::{STEP, apart, arm, irp6_facing, irp6_start, limits, relative_error};

#[test]
fn a_slave_follows_the_measured_master_at_the_stated_distance_and_arrives() {
    const LAG: f64 = 0.03;
    let (left, right) = (irp6_facing(1.1, 0.0), irp6_facing(1.1, 3.0));
    let (master, led, _) = arm("master", &left, &irp6_start());
    let (slave, following, _) = arm("slave", &right, &irp6_start());
    let cell = Cell::new(STEP).robot(master).robot(slave).program(|mp| {
        let (mut master, mut slave) = (mp.robot::<Irp6>("master")?, mp.robot::<Irp6>("slave")?);
        let path = StraightBody::by(Pose::translation(0.0, 0.0, 0.1), limits());
        mp.move_robots((&mut master, &mut slave), (), FollowMaster::<(Irp6, Irp6), _>::along(path, LAG))
            .map(drop)
    });
    cell.run().expect("within the limits");
    let (led, following) = (led.demanded.borrow(), following.demanded.borrow());
    let relation = led[0].inv_mul(&following[0]);
    // V lag and a step or two; D / V + V / A = 1.5 s, so full speed is kept until 1 s: at 0.9 s the lag has settled.
    let behind = apart(&led[450].inv_mul(&following[450]), &relation).0;
    let (least, most) = (0.1 * LAG, 0.1 * (LAG + 4.0 * STEP.as_secs_f64()));
    assert!((least..most).contains(&behind), "{behind} m, not {least} to {most} m");
    let last = led.len() - 1;
    let end = apart(&led[last].inv_mul(&following[last]), &relation);
    // What is left is e^-10 of the distance behind, and what the master's drives are off at rest.
    assert!(end.0 < 1e-4 && end.1 < 2e-4, "{end:?}");
}

#[test]
fn arms_engage_each_in_its_own_time_and_then_share_the_drive_frame() {
    let (left, right) = (irp6_facing(1.1, 0.0), irp6_facing(1.1, 2.0));
    let (one, near, _) = arm("one", &left, &irp6_start());
    let (two, far, _) = arm("two", &right, &irp6_start());
    let X_WD = Pose::translation(0.0, 0.0, 0.4);
    // The loops close 20 mm above where one arm begins, and 60 mm above where the other does.
    let above = |robot: &Irp6, height| {
        let tool = mrroc::robot::Robot::forward(robot, &irp6_start());
        KinematicLoop::held(&X_WD, &(Pose::translation(0.0, 0.0, height) * tool))
    };
    let loops = [above(&left, 0.02), above(&right, 0.06)];
    let cell = Cell::new(STEP).robot(one).robot(two).program(move |mp| {
        let (mut one, mut two) = (mp.robot::<Irp6>("one")?, mp.robot::<Irp6>("two")?);
        let turn = Pose::new(Vector3::new(0.0, 0.0, 0.02), Vector3::z() * 0.05);
        let path = StraightBody::by(turn, limits());
        let drive = SharedDrive::<[Irp6; 2], _>::from(X_WD, path, loops, limits());
        mp.move_robots([&mut one, &mut two], (), drive).map(drop)
    });
    cell.run().expect("within the limits");
    let (near, far) = (near.demanded.borrow(), far.demanded.borrow());
    let there = |trace: &[Pose], i: usize| {
        let [mut first, mut second] = loops;
        let goal = [first.tool(&X_WD, 0.0), second.tool(&X_WD, 0.0)][i];
        trace.iter().position(|pose| apart(pose, &goal).0 < 1e-9).expect("arrives")
    };
    // Triangular profiles: 2 sqrt(D / A) = 0.632 s, and D / V + V / A = 1.1 s.
    let (first, last) = (there(&near, 0), there(&far, 1));
    assert!((316..=324).contains(&first) && (549..=556).contains(&last), "{first} {last}");
    assert!(near[first..last].iter().all(|pose| apart(pose, &near[first]).0 < 1e-9));
    let relation = near[last].inv_mul(&far[last]);
    let error = relative_error(&near[last..], &far[last..], &relation);
    assert!(error.0 <= 1e-9 && error.1 <= 1e-9, "{error:?}");
    let turned = near[near.len() - 1].rotation.angle_to(&near[last].rotation);
    assert!((turned - 0.05).abs() < 1e-9, "{turned}");
}
