//! Four arms on one body, two of each kind: the library's generators as they are.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::generator::RobotHandle;
use mrroc::prelude::*;
use mrroc_generators::cooperation::BodyFrame;
use mrroc_generators::generators::{RigidCarry, SqueezedCarry};
use mrroc_robots::grasp::{Body, Grasp, Hand, SimulatedWrist, World};
use mrroc_robots::sensors::WristForce;
use mrroc_robots::{Driven, Kinematics, Polycrank, Rnt, Simulated};
use nalgebra::{SVector, UnitQuaternion, Vector3};
use transfer::file;
use transfer::paths::soft;
use transfer::places::{End, bar, grasp, limits};
use transfer::plant::calibration_error;
use transfer::sensed::{STIFFNESS, law};

type Four = (Rnt, Rnt, Polycrank, Polycrank);
type Wrists = (WristForce, WristForce, WristForce, WristForce);

/// Half the distance between the two pairs \[m\].
const ASIDE: f64 = 0.4;

/// A place of a pair: those of the task, shifted.
fn shifted(side: f64) -> Pose {
    Pose::translation(0.0, side * ASIDE, 0.0)
}

/// An arm of the task's file, shifted, that holds its end of what was a bar, and its true drives.
#[allow(non_snake_case)]
fn arm<const N: usize, R: Driven<N> + Kinematics<N>>(
    world: &World,
    name: &str,
    (place, end, near): (Pose, End, SVector<f64, N>),
    based: impl Fn(Pose) -> R,
    error: Pose,
) -> (RobotSetup<R>, Hand) {
    let file = file().expect("in order");
    let entry = &file.robots()[if end == End::Near { 0 } else { 1 }];
    let (base, X_FE) = (place * entry.base(), entry.tool());
    let believed = based(base);
    let X_WE = place * bar() * grasp(end);
    let q = believed.inverse(&(X_WE * X_FE.inverse()), &near).expect("in reach");
    let held = Grasp::new(STIFFNESS.force, STIFFNESS.torque).with_tool(X_FE);
    let drives = world.arm(Simulated::new(based(base * error), &q), held).expect("a good grasp");
    let hand = drives.hand();
    (RobotSetup::new(name, believed, drives).tool(X_FE), hand)
}

/// What was seen: the largest error of a relative pose of the demands [m or rad], and of the internal force \[N\].
#[derive(Clone, Copy, Debug, Default)]
struct RunMeasurements {
    apart: f64,
    internal: f64,
}

type Handles<'a> = (
    &'a mut RobotHandle<Rnt>,
    &'a mut RobotHandle<Rnt>,
    &'a mut RobotHandle<Polycrank>,
    &'a mut RobotHandle<Polycrank>,
);

/// Runs four arms at a plate; the last one's base is off.
fn run(mut program: impl FnMut(&mut Mp, Handles<'_>) -> Result<(), Fault> + 'static) -> RunMeasurements {
    let plate = Body::block(4.0, [0.4, 2.0 * ASIDE + 0.06, 0.04]).at(bar());
    let world = World::new(&plate).expect("a plate");
    let file = file().expect("in order");
    let (rnt, polycrank) = (Rnt::new(), Polycrank::new());
    let near =
        (file.robots()[0].start(&rnt).expect("six"), file.robots()[1].start(&polycrank).expect("seven"));
    let straight = Pose::identity();
    let at_rnt = |base| Rnt::new().with_base(base);
    let at_polycrank = |base| Polycrank::new().with_base(base);
    let (a, ha) = arm(&world, "a", (shifted(-1.0), End::Near, near.0), at_rnt, straight);
    let (b, hb) = arm(&world, "b", (shifted(1.0), End::Near, near.0), at_rnt, straight);
    let (c, hc) = arm(&world, "c", (shifted(-1.0), End::Far, near.1), at_polycrank, straight);
    let (d, hd) = arm(&world, "d", (shifted(1.0), End::Far, near.1), at_polycrank, calibration_error());
    let hands = [ha, hb, hc, hd];
    let mut cell = Cell::new(Duration::from_millis(2)).robot(a).robot(b).robot(c).robot(d);
    for (name, hand) in ["a", "b", "c", "d"].into_iter().zip(&hands) {
        let wrist = SimulatedWrist::new(hand.clone()).with_low_pass(50.0);
        cell = cell.sensor(SensorSetup::new(&format!("{name}-wrist"), wrist).of(name));
    }
    let seen = Rc::new(RefCell::new((RunMeasurements::default(), None::<Vec<Pose>>)));
    let (record, looked) = (Rc::clone(&seen), world.clone());
    cell.guard(1, move |robots| {
        let (seen, first) = &mut *record.borrow_mut();
        let tools: Vec<Pose> = robots.iter().map(|robot| robot.demanded.pose).collect();
        let relative: Vec<Pose> = tools.iter().map(|tool| tools[0].inv_mul(tool)).collect();
        let first = first.get_or_insert_with(|| relative.clone());
        for (first, now) in first.iter().zip(&relative) {
            let error = first.inv_mul(now);
            let error = error.translation.vector.norm().max(error.rotation.scaled_axis().norm());
            seen.apart = seen.apart.max(error);
        }
        seen.internal = seen.internal.max(looked.internal_force());
        Ok(())
    })
    .program(move |mp| {
        hands.iter().try_for_each(Hand::close)?;
        let mut rnts = (mp.robot::<Rnt>("a")?, mp.robot::<Rnt>("b")?);
        let mut polycranks = (mp.robot::<Polycrank>("c")?, mp.robot::<Polycrank>("d")?);
        program(mp, (&mut rnts.0, &mut rnts.1, &mut polycranks.0, &mut polycranks.1))
    })
    .run()
    .expect("within all limits");
    let seen = seen.borrow();
    seen.0
}

/// The plate's displacement: up and aside, turned by 6 degrees.
fn displacement() -> Pose {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 6_f64.to_radians());
    Pose::from_parts(Vector3::new(0.0, 0.05, 0.1).into(), turn)
}

#[test]
fn four_arms_of_two_kinds_carry_one_body() {
    let rigid = run(|mp, robots| {
        let carry = RigidCarry::along(BodyFrame::InWorld(bar()), soft(displacement(), limits())?);
        mp.move_robots(robots, (), carry).map(drop)
    });
    assert!(rigid.apart <= 1e-9, "{rigid:?}");
    let squeezed = run(|mp, robots| {
        let mut wrist = |name: &str| mp.sensor::<WristForce>(name);
        let (mut a, mut b, mut c, mut d) =
            (wrist("a-wrist")?, wrist("b-wrist")?, wrist("c-wrist")?, wrist("d-wrist")?);
        let body = BodyFrame::InWorld(bar());
        let carry =
            SqueezedCarry::<Four, Wrists, _>::along(body, soft(displacement(), limits())?, law()?, 0.0, 1);
        mp.move_robots(robots, (&mut a, &mut b, &mut c, &mut d), carry).map(drop)
    });
    println!("internal force: {:.2} N, with sensors {:.2} N", rigid.internal, squeezed.internal);
    assert!(rigid.internal > 5.0 && squeezed.internal <= rigid.internal / 5.0, "{rigid:?} {squeezed:?}");
}
