//! Two simulated arms that hold one body, in a cell under the runtime: forces against statics.

use std::cell::{Cell as Slot, RefCell};
use std::f64::consts::TAU;
use std::rc::Rc;
use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::generator::RobotHandle;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::Driver;
use mrroc_robots::grasp::{Body, Fingers, Grasp, Grasping, Hand, SimulatedWrist, Table, World};
use mrroc_robots::sensors::WristForce;
use mrroc_robots::{
    Conveyor, Driven, Five, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, One, Polycrank, Rnt, Seven,
    Simulated, Six,
};
use nalgebra::{Matrix6, SVector, Translation3, UnitQuaternion, Vector3, Vector6};

const MASS: f64 = 2.0;
const STIFFNESS: (f64, f64) = (5e4, 500.0);
const GRAVITY: f64 = 9.80665;
const DURATION: f64 = 2.0;

fn start() -> Seven {
    Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2])
}

/// The arms that programs compute with, 0.6 m apart.
fn arms() -> [Polycrank; 2] {
    [Polycrank::new(), Polycrank::new().with_base(Pose::translation(0.6, 0.0, 0.0))]
}

/// A world with two arms at a bar; the second arm's base truly stands `error` off.
struct TwoArms {
    world: World,
    hands: [Hand; 2],
    /// `X_BG`.
    grasps: [Pose; 2],
    drives: [Grasping<Polycrank, 7>; 2],
}

impl TwoArms {
    #[allow(non_snake_case)]
    fn new(error: Pose) -> Self {
        let flanges = arms().map(|arm| arm.forward(&start()));
        let middle = 0.5 * (flanges[0].translation.vector + flanges[1].translation.vector);
        let X_WB = Pose::from_parts(middle.into(), UnitQuaternion::identity());
        let grasps = flanges.map(|X_WE| X_WB.inverse() * X_WE);
        let body = Body::block(MASS, [0.6, 0.1, 0.1]).at(X_WB);
        let table = Table::at(middle.z - 1.0);
        let world = World::new(&body).and_then(|world| world.with_table(table)).expect("a world");
        let bases = [Pose::identity(), Pose::translation(0.6, 0.0, 0.0) * error];
        let drives = [0, 1].map(|i| {
            let truly = Simulated::new(Polycrank::new().with_base(bases[i]), &start());
            world.arm(truly, Grasp::new(STIFFNESS.0, STIFFNESS.1).at(grasps[i])).expect("a good grasp")
        });
        Self { world, hands: [drives[0].hand(), drives[1].hand()], grasps, drives }
    }

    /// Runs a cell of the two arms, the second with a wrist sensor.
    fn run(
        self,
        mut program: impl FnMut(&mut Mp, Both) -> Result<(), Fault> + 'static,
    ) -> Result<(), CellError> {
        let [one, two] = self.drives;
        let wrist = SimulatedWrist::new(two.hand());
        Cell::new(Duration::from_millis(2))
            .robot(RobotSetup::new("one", arms()[0].clone(), one))
            .robot(RobotSetup::new("two", arms()[1].clone(), two))
            .sensor(SensorSetup::new("wrist", wrist).of("two"))
            .program(move |mp| {
                let both = (mp.robot::<Polycrank>("one")?, mp.robot::<Polycrank>("two")?);
                program(mp, both)
            })
            .run()
            .map(drop)
    }
}

type Both = (RobotHandle<Polycrank>, RobotHandle<Polycrank>);

/// Waits for so many steps.
struct Pause(u32);

#[condition(mp)]
fn pause(c: &mut Pause) -> bool {
    c.0 -= 1;
    c.0 == 0
}

/// Carries both flanges along one path, 8 cm there and half of it back.
struct Carry {
    from: [Pose; 2],
    t: f64,
}

#[generator(mp)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Polycrank, Polycrank)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let part = 0.5 * (1.0 - (0.5 * TAU * c.t / DURATION).cos());
    let displacement = Translation3::from(Vector3::new(0.03, -0.05, 0.02) * part);
    Step::Next((Demand::pose(displacement * c.from[0]), Demand::pose(displacement * c.from[1])))
}

/// One observation: the tools' true poses and the wrench of the body on each gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    tools: [Pose; 2],
    reactions: [Wrench; 2],
    internal: f64,
}

fn look(world: &World, hands: &[Hand; 2]) -> Moment {
    Moment {
        tools: [hands[0].pose(), hands[1].pose()],
        reactions: [hands[0].reaction(), hands[1].reaction()],
        internal: world.internal_force(),
    }
}

/// Closes both hands, carries the body, and looks after each of the two.
fn carried(error: Pose) -> ([Moment; 2], [Pose; 2]) {
    let setup = TwoArms::new(error);
    let seen = Rc::new(RefCell::new(Vec::new()));
    let (world, hands, grasps, record) =
        (setup.world.clone(), setup.hands.clone(), setup.grasps, Rc::clone(&seen));
    setup
        .run(move |mp, (mut one, mut two)| {
            hands[0].close()?;
            hands[1].close()?;
            mp.wait_until((&mut one, &mut two), (), Pause(1000))?;
            record.borrow_mut().push(look(&world, &hands));
            let from = [one.demanded().pose, two.demanded().pose];
            mp.move_robots((&mut one, &mut two), (), Carry { from, t: 0.0 })?;
            mp.wait_until((&mut one, &mut two), (), Pause(1000))?;
            record.borrow_mut().push(look(&world, &hands));
            Ok(())
        })
        .expect("carried");
    let seen = seen.borrow();
    ([seen[0], seen[1]], grasps)
}

/// The wrenches of the springs on the grippers where the body is in equilibrium, by Newton's method on its pose: each wrench at
/// the tool's origin in the tool's axes.
#[allow(non_snake_case)]
fn statics(tools: &[Pose; 2], grasps: &[Pose; 2]) -> [Wrench; 2] {
    let on_body = |X_WB: &Pose, i: usize| {
        let X_WG = X_WB * grasps[i];
        let d = X_WG.translation.vector - tools[i].translation.vector;
        let turn = (X_WG.rotation * tools[i].rotation.inverse()).scaled_axis();
        let (force, torque) = (-STIFFNESS.0 * d, -STIFFNESS.1 * turn);
        (X_WG.translation.vector, Wrench::new(force, torque))
    };
    let sum = |u: &Vector6<f64>| {
        let turn = UnitQuaternion::from_scaled_axis(u.fixed_rows::<3>(3).into_owned());
        let middle = 0.5 * (tools[0].translation.vector + tools[1].translation.vector);
        let X_WB = Pose::from_parts((middle + u.fixed_rows::<3>(0)).into(), turn);
        let mut total = Vector6::new(0.0, 0.0, -MASS * GRAVITY, 0.0, 0.0, 0.0);
        for i in 0..2 {
            let (at, w) = on_body(&X_WB, i);
            let torque = w.torque + (at - X_WB.translation.vector).cross(&w.force);
            total += Vector6::from_iterator(w.force.iter().chain(torque.iter()).copied());
        }
        (total, X_WB)
    };
    let mut u = Vector6::zeros();
    for _ in 0..10 {
        let mut slope = Matrix6::zeros();
        for j in 0..6 {
            let step = Vector6::from_fn(|i, _| if i == j { 1e-6 } else { 0.0 });
            slope.set_column(j, &((sum(&(u + step)).0 - sum(&(u - step)).0) / 2e-6));
        }
        u -= slope.lu().solve(&sum(&u).0).expect("held");
    }
    let (left, X_WB) = sum(&u);
    assert!(left.amax() < 1e-8, "no equilibrium: {left}");
    [0, 1].map(|i| {
        let (at, w) = on_body(&X_WB, i);
        let torque = -w.torque - (at - tools[i].translation.vector).cross(&w.force);
        let turn = tools[i].rotation.inverse();
        Wrench::new(turn * -w.force, turn * torque)
    })
}

#[test]
#[allow(non_snake_case)]
fn arms_whose_bases_are_off_squeeze_the_body_as_statics_says() {
    let degree = TAU / 360.0;
    let along = Pose::translation(1e-3, 0.0, 0.0);
    let both = Pose::from_parts(
        Translation3::new(6e-4, -5e-4, 6e-4),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.03, -0.04, 0.08) * degree),
    );
    for (error, squeezes) in [(Pose::identity(), false), (along, true), (both, true)] {
        let (moments, grasps) = carried(error);
        for (i, moment) in moments.iter().enumerate() {
            // With the tools where they truly are, the body hangs in them as springs hold it; drives that hunt for a
            // pulse of their encoders, 1e-5 m at the tool, keep it from quite coming to rest.
            let expected = statics(&moment.tools, &grasps);
            for (reaction, expected) in moment.reactions.iter().zip(&expected) {
                let off = *reaction - *expected;
                assert!(off.force.amax() < 0.1 && off.torque.amax() < 0.01, "{i}: {reaction:?} {expected:?}");
            }
            // Where the true base puts them, but for the drives: encoders of 2e-5 rad and friction leave 0.1 mm.
            let truly = arms()[1].forward(&start());
            let base = Pose::translation(0.6, 0.0, 0.0);
            let displacement =
                Translation3::from(Vector3::new(0.03, -0.05, 0.02) * if i == 0 { 0.0 } else { 1.0 });
            let there = base * error * base.inverse() * displacement * truly;
            assert!((there.translation.vector - moment.tools[1].translation.vector).norm() < 1.5e-4);
        }
        println!("internal force {:.2} N, then {:.2} N", moments[0].internal, moments[1].internal);
        for moment in &moments {
            // Perfect bases leave what the drives are off by: a pulse, k 1e-5 m / 2.
            assert!(
                if squeezes { moment.internal > 15.0 } else { moment.internal < 0.5 },
                "{}",
                moment.internal
            );
        }
        if error == along {
            // k delta / 2 = 25 N.
            assert!((moments[0].internal - 25.0).abs() < 0.5, "{}", moments[0].internal);
        }
    }
}

#[test]
fn runs_are_the_same_to_the_bit() {
    let error = Pose::translation(5e-4, 5e-4, 0.0);
    let ((one, _), (other, _)) = (carried(error), carried(error));
    let bits = |moment: &Moment| {
        let wrenches = moment.reactions.iter().flat_map(|w| [w.force, w.torque]);
        wrenches.flat_map(|v| [v.x, v.y, v.z]).map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(one.each_ref().map(bits), other.each_ref().map(bits));
}

/// Waits until the wrist measures more than any body could cause.
struct Feel(Rc<Slot<f64>>);

#[condition(mp)]
fn feel(c: &mut Feel, v: &mrroc::sensor::Reading<(WristForce,)>) -> bool {
    let force = v.0.reading().map_or(0.0, |wrench| wrench.force.norm());
    c.0.set(c.0.get().max(force));
    false
}

#[test]
fn a_wrist_that_saturates_ends_the_cell_with_the_name_of_its_sensor() {
    // 4 mm off: 100 N, where the sensor bears 65 N.
    let setup = TwoArms::new(Pose::translation(4e-3, 0.0, 0.0));
    let hands = setup.hands.clone();
    let highest = Rc::new(Slot::new(0.0));
    let seen = Rc::clone(&highest);
    let outcome = setup.run(move |mp, (mut one, mut two)| {
        let mut wrist = mp.sensor::<WristForce>("wrist")?;
        hands[0].close()?;
        hands[1].close()?;
        mp.wait_at_most((&mut one, &mut two), (&mut wrist,), Feel(Rc::clone(&seen)), 1000).map(drop)
    });
    let Err(CellError::Fault(fault)) = outcome else { panic!("{outcome:?}") };
    assert_eq!(fault.kind(), FaultKind::SensorFailed);
    let text = fault.to_string();
    assert!(text.contains("wrist") && text.contains("saturates"), "{text}");
    let excess = fault.excess().expect("says by how much");
    assert!(excess.actual > excess.limit && excess.limit <= 130.0 && excess.unit == "N", "{text}");
    // No reading beyond what the sensor can measure came through.
    assert!(highest.get() <= (2.0 * 65.0_f64.powi(2) + 130.0_f64.powi(2)).sqrt());
}

#[test]
fn fingers_stop_at_the_body_hold_it_and_let_it_go() {
    let arm = Simulated::new(Polycrank::new(), &start());
    let flange = Polycrank::new().forward(&start());
    let body = Body::block(0.2, [0.1, 0.06, 0.06]).at(flange);
    let world = World::new(&body).expect("a body");
    let mut arm = world.arm(arm, Grasp::new(5e4, 500.0).at(Pose::identity())).expect("a grasp");
    let hand = arm.hand();
    let drive = Simulated::new(Gripper::new(), &One::new(0.08));
    let mut fingers = Fingers::new(drive, hand.clone(), 0.06).expect("a width");
    let mut go = |mut from: f64, to: f64| {
        for _ in 0..6000 {
            from += (to - from).clamp(-1e-5, 1e-5);
            fingers.tick(&One::new(from)).expect("a gripper does not trip");
            if hand.is_closed() {
                arm.tick(&start()).expect("it holds");
            }
        }
        fingers.measured().expect("simulated").position[0]
    };
    let held = go(0.08, 0.055);
    // Closed at 5 mm/s: a servo period of it, and the encoder's pulse.
    assert!(held <= 0.060001 && held > 0.0599 && hand.is_closed(), "{held}");
    let weight = hand.reaction().force.norm();
    assert!((weight - 0.2 * GRAVITY).abs() < 1e-3, "{weight} N");
    let open = go(0.055, 0.07);
    assert!((open - 0.07).abs() < 1e-4 && !hand.is_closed(), "{open}");
    // Elsewhere than the body they close on nothing.
    world.push(Vector3::new(0.0, 0.0, -5.0), Vector3::zeros());
    for _ in 0..100 {
        arm.tick(&start()).expect("it holds nothing");
    }
    let drive = Simulated::new(Gripper::new(), &One::new(0.061));
    let mut fingers = Fingers::new(drive, arm.hand(), 0.06).expect("a width");
    let mut x = 0.061;
    for _ in 0..2000 {
        x = f64::max(x - 1e-5, 0.055);
        fingers.tick(&One::new(x)).expect("a gripper does not trip");
    }
    assert!(
        (fingers.measured().expect("simulated").position[0] - 0.055).abs() < 1e-4 && !arm.hand().is_closed()
    );
}

/// Torques at motors and at joints do the same work: `tau_m dm = tau_q dq`, with dm from the inverse transmission.
fn same_work<const N: usize>(robot: &impl Driven<N>, q: SVector<f64, N>) {
    let motors = robot.motors(&q);
    let torques = SVector::from_fn(|i, _| 3.0 - i as f64);
    let at_motors = robot.motor_torques(&motors, &torques);
    for i in 0..N {
        let step = SVector::from_fn(|j, _| if i == j { 1e-5 } else { 0.0 });
        let turned = (robot.motors(&(q + step)) - robot.motors(&(q - step))) / 2e-5;
        assert!((at_motors.dot(&turned) - torques[i]).abs() < 1e-5, "joint {i}: {at_motors}");
    }
}

#[test]
fn outside_torques_do_the_same_work_at_motors_as_at_joints() {
    let arm = Six::new(0.1, -1.55, 0.1, -0.1, 4.6, 0.2);
    same_work(&Irp6::nominal(), arm);
    same_work(&Irp6FiveDof::nominal(), Five::new(0.3, -1.6, 0.1, 0.2, 1.0));
    same_work(&Irp6Track::nominal(), Seven::from([0.5, arm[0], arm[1], arm[2], arm[3], arm[4], arm[5]]));
    same_work(&Rnt::new(), Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3));
    same_work(&Polycrank::new(), start());
    same_work(&Gripper::new(), One::new(0.07));
    same_work(&Conveyor::new(), One::new(0.5));
}

#[test]
fn a_held_body_loads_the_motors_by_its_weight() {
    let flange = Polycrank::new().forward(&start());
    let loaded = |mass: f64| {
        let body = Body::block(mass, [0.1, 0.1, 0.1]).at(flange);
        let world = World::new(&body).expect("a body");
        let drives = Simulated::new(Polycrank::new(), &start());
        let mut arm = world.arm(drives, Grasp::new(5e4, 500.0)).expect("a grasp");
        arm.hand().close().expect("there");
        for _ in 0..3000 {
            arm.tick(&start()).expect("it holds");
        }
        let q = arm.drives().shaft().state().position;
        (q, arm.drives().currents())
    };
    // Joint 4 lifts with d z / d q4 = u + 0.043 sin psi: kt di = m g (dz/dq4) / 2250, but for friction of 2e-3 N m.
    let ((q, heavy), (_, light)) = (loaded(8.0), loaded(0.5));
    let slope = Polycrank::stretch(&q) + 0.043 * (q[3] + q[4] + q[5]).sin();
    let expected = 7.5 * GRAVITY * slope / 2250.0 / 0.02;
    let difference = heavy[3] - light[3];
    assert!((difference - expected).abs() < 2.0 * 2e-3 / 0.02, "{difference} A for {expected} A");
    assert!(expected > 0.1 && difference > 0.0);
}

/// Holds 2 kg beside the tool for three seconds; returns how far the tool yielded \[m\].
fn holds<const N: usize, R: Driven<N> + Kinematics<N>>(robot: R, q: SVector<f64, N>) -> f64 {
    let flange = robot.forward(&q);
    let body = Body::block(MASS, [0.2, 0.1, 0.1]).at(Translation3::new(0.1, 0.0, 0.0) * flange);
    let world = World::new(&body).expect("a body");
    let mut arm = world.arm(Simulated::new(robot, &q), Grasp::new(5e4, 500.0)).expect("a grasp");
    let hand = arm.hand();
    hand.close().expect("there");
    let periods = (3.0 / arm.period().as_secs_f64()) as usize;
    for _ in 0..periods {
        arm.tick(&q).expect("no drive trips");
    }
    let force = hand.pose().rotation * hand.reaction().force;
    assert!((force + Vector3::z() * (MASS * GRAVITY)).amax() < 0.2, "{}: {force}", R::KIND);
    let torque = hand.pose().rotation * hand.reaction().torque;
    // m g of lever, and what the grasp sags.
    assert!((torque.y - 0.1 * MASS * GRAVITY).abs() < 0.05, "{}: {torque}", R::KIND);
    (hand.pose().translation.vector - flange.translation.vector).norm()
}

#[test]
fn every_arm_carries_a_body_without_swinging_up() {
    let arm = Six::new(0.1, -1.55, 0.1, -0.1, 4.6, 0.2);
    let yielded = [
        holds(Irp6::nominal(), arm),
        holds(Irp6FiveDof::nominal(), Five::new(0.3, -1.6, 0.1, 0.2, 1.0)),
        holds(Irp6Track::nominal(), Seven::from([0.5, arm[0], arm[1], arm[2], arm[3], arm[4], arm[5]])),
        holds(Rnt::new(), Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3)),
        holds(Polycrank::new(), start()),
    ];
    // The regulators hold each motor to some pulses of its encoder.
    assert!(yielded.iter().all(|distance| *distance < 2e-4), "{yielded:?} m");
}

#[path = "../examples/01_two_arms_one_body.rs"]
mod example_01;

#[test]
fn example_01_holds_a_body_with_two_arms() {
    example_01::main().expect("runs without a fault");
}

/// An arm whose closed gripper holds 2 kg.
fn holding() -> Grasping<Polycrank, 7> {
    let body = Body::block(MASS, [0.2, 0.1, 0.1]).at(Polycrank::new().forward(&start()));
    let world = World::new(&body).expect("a body");
    let drives = Simulated::new(Polycrank::new(), &start());
    let arm = world.arm(drives, Grasp::new(STIFFNESS.0, STIFFNESS.1)).expect("a good grasp");
    arm.hand().close().expect("there");
    arm
}

/// A gripper whose fingers have the body of a still arm between them.
fn fingers() -> Fingers {
    Fingers::new(Simulated::new(Gripper::new(), &One::new(0.07)), holding().hand(), 0.05).expect("a width")
}

mrroc_robots::driver_conformance!(an_arm_with_a_body, Polycrank::new(), holding(), start());
mrroc_robots::driver_conformance!(open_fingers, Gripper::new(), fingers(), One::new(0.07));
