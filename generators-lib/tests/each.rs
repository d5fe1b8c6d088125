//! Motions that are written for single robots, as motions of an MP.

use std::time::Duration;

use mrroc::generator::RobotHandle;
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};
use mrroc::sensor::SensorImage;
use mrroc_generators::generators::{GuardedApproach, JointMove, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Irp6, Polycrank, Seven, Simulated, SimulatedIrp6, Six};
use nalgebra::Vector3;

fn six() -> Six {
    Irp6::READY
}

/// By 2 sqrt(D / A) of a joint whose velocity limit is not reached.
fn joint_move(by: f64) -> JointMove<Irp6> {
    JointMove::to(six() + Six::repeat(by), Six::repeat(0.4), Six::repeat(0.8))
}

/// So many simulated arms `irp6-0`, `irp6-1`, .. and the end of a run of this program, with its time \[s\].
fn run_arms(count: usize, program: impl FnOnce(&mut Mp) -> Result<(), Fault> + 'static) -> f64 {
    let arm = |i| {
        RobotSetup::new(&format!("irp6-{i}"), Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &six()))
    };
    let cell = (0..count).fold(Cell::new(Duration::from_millis(2)), |cell, i| cell.robot(arm(i)));
    let mut program = Some(program);
    let report =
        cell.program(move |mp| program.take().expect("one run")(mp)).run().expect("within the limits");
    report.time.as_secs_f64()
}

#[test]
fn an_mp_moves_one_robot_by_a_line_that_ecps_use() {
    let time = run_arms(1, |mp| {
        let mut arm = mp.robot::<Irp6>("irp6-0")?;
        let before = arm.demanded().pose;
        let limits = ProfileLimits { velocity: 0.1, acceleration: 0.1 };
        let limits = ToolLimits { translation: limits, rotation: limits };
        let line = StraightLine::by(Pose::translation(0.0, 0.0, 0.1), limits);
        mp.move_robot(&mut arm, (), line)?;
        let displacement = before.inv_mul(&arm.demanded().pose).translation.vector;
        assert!((displacement - Vector3::z() * 0.1).norm() < 1e-9, "{displacement}");
        Ok(())
    });
    // D / v + v / a.
    assert!((2.0..2.02).contains(&time), "{time} s");
}

#[test]
fn two_robots_of_two_kinds_move_at_once_and_the_longer_motion_ends_both() {
    let q7 = Seven::repeat(0.3);
    let arms = (SimulatedIrp6::new(Irp6::nominal(), &six()), Simulated::new(Polycrank::new(), &q7));
    let shafts = (arms.0.shaft(), arms.1.shaft());
    let cell = Cell::new(Duration::from_millis(2))
        .robot(RobotSetup::new("irp6", Irp6::nominal(), arms.0))
        .robot(RobotSetup::new("polycrank", Polycrank::new(), arms.1));
    let cell = cell.program(move |mp| {
        let mut one = mp.robot::<Irp6>("irp6")?;
        let mut two = mp.robot::<Polycrank>("polycrank")?;
        let long = JointMove::to(q7 + Seven::repeat(0.2), Seven::repeat(0.4), Seven::repeat(0.8));
        mp.move_robots((&mut one, &mut two), (), Each::of((joint_move(0.05), long))).map(drop)
    });
    let report = cell.run().expect("within the limits");
    // 2 sqrt(D / A) of the longer one.
    let duration = report.time.as_secs_f64();
    assert!((1.0..1.02).contains(&duration), "{duration} s");
    assert!((shafts.0.state().position - six() - Six::repeat(0.05)).amax() < 1e-3);
    assert!((shafts.1.state().position - q7 - Seven::repeat(0.2)).amax() < 1e-3);
}

#[test]
fn four_motions_in_a_tuple_and_three_in_an_array_each_move_their_own_robot() {
    let distances = [0.02, -0.04, 0.06, 0.03];
    let moved = |handle: &RobotHandle<Irp6>, distance: f64| {
        assert!((handle.demanded().joints - six() - Six::repeat(distance)).amax() < 1e-12, "{distance}");
    };
    run_arms(4, move |mp| {
        let [mut a, mut b, mut c, mut d] =
            [mp.robot::<Irp6>("irp6-0")?, mp.robot("irp6-1")?, mp.robot("irp6-2")?, mp.robot("irp6-3")?];
        let [to_a, to_b, to_c, to_d] = distances.map(joint_move);
        mp.move_robots((&mut a, &mut b, &mut c, &mut d), (), Each::of((to_a, to_b, to_c, to_d)))?;
        for (handle, distance) in [&a, &b, &c, &d].into_iter().zip(distances) {
            moved(handle, distance);
        }
        // Back, and the first one farther; the fourth stays.
        let back = [joint_move(-0.01), joint_move(0.0), joint_move(0.0)];
        mp.move_robots([&mut a, &mut b, &mut c], (), Each::of(back))?;
        for (handle, distance) in [&a, &b, &c, &d].into_iter().zip([-0.01, 0.0, 0.0, 0.03]) {
            moved(handle, distance);
        }
        Ok(())
    });
}

struct Touch;

impl Sensor for Touch {
    const KIND: &'static str = "touch";
    type Reading = Wrench;
    type Configuration = ();
}

/// What is felt, along the tool.
fn felt(pressed: bool) -> SensorImage<Touch> {
    let force = -Vector3::z() * if pressed { 2.0 } else { 0.0 };
    SensorImage::new(Wrench::new(force, Vector3::zeros()), 0)
}

fn approach() -> GuardedApproach<Irp6, Touch> {
    GuardedApproach::along(Vector3::z_axis(), 0.05, 0.5, 1.0, |felt: &Wrench| felt.force.z < -1.0)
}

/// Whether each robot still moves in each step, where robot `i` feels something from step `contacts[i]` on; the last line is
/// of the step in which the motion is done.
fn moving<const N: usize, G>(
    mut all: G,
    contacts: [u64; N],
    list: impl Fn([SensorImage<Touch>; N]) -> Reading<G::Sensors>,
    told: impl Fn(Step<G::Robots>) -> Option<[bool; N]>,
    e: &State<G::Robots>,
) -> Vec<[bool; N]>
where
    G: mrroc::generator::Generator<Language = mrroc::generator::Motion, Order = ()>,
{
    let mut lines = Vec::new();
    for step in 0.. {
        let v = list(contacts.map(|contact| felt(step >= contact)));
        let t = Tick { step, dt: 2e-3, duration: 2e-3 };
        let c0 = Order::new(());
        let next = if step == 0 { all.first_step(&c0, e, &v, t) } else { all.next_step(&c0, e, &v, t) };
        match told(next.expect("no fault")) {
            Some(line) => lines.push(line),
            None => break,
        }
    }
    lines
}

#[test]
fn each_arm_stops_at_its_own_contact_and_reads_its_own_sensor() {
    let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: Pose::identity() };
    let image = RobotImage::<Irp6>::new(state, state);
    let goes = |demand: Demand<Irp6>| demand.as_pose().is_some();
    let contacts = [20, 50, 35];
    let expected: Vec<_> = (0..50).map(|step| contacts.map(|contact| step < contact)).collect();
    let tuple = moving(
        Each::of((approach(), approach(), approach())),
        contacts,
        |[a, b, c]| Reading::new((a, b, c)),
        |step| match step {
            Step::Next((a, b, c)) => Some([goes(a), goes(b), goes(c)]),
            Step::Done => None,
        },
        &State::new((image, image, image)),
    );
    assert_eq!(tuple, expected);
    let array = moving(
        Each::of([approach(), approach(), approach()]),
        contacts,
        Reading::new,
        |step| match step {
            Step::Next(demands) => Some(demands.map(goes)),
            Step::Done => None,
        },
        &State::new([image; 3]),
    );
    assert_eq!(array, expected);
}
