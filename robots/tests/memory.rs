//! Nothing that a step calls allocates.

use mrroc::fault::Name;
use mrroc::prelude::*;
use mrroc::robot::{Driver, MAX_JOINTS, RobotView};
use mrroc::sensor::EffectorState;
use mrroc_counting_allocator::count;
use mrroc_robots::clearance::{Bodies, Capsule, Clearance, Cloud, HeightField, Obstacle, Stopping};
use mrroc_robots::grasp::{Body, Grasp, SimulatedWrist, Table, World};
use mrroc_robots::sensors::WristOrder;
use mrroc_robots::{
    Conveyor, Driven, Five, Gripper, Irp6, Irp6FiveDof, Irp6Track, Kinematics, One, Polycrank, Rnt, Seven,
    Simulated, Six,
};
use nalgebra::{SVector, Vector3};

fn counted<const N: usize, R: Driven<N> + Kinematics<N>>(robot: R, start: SVector<f64, N>) {
    let mut driver = Simulated::new(robot.clone(), &start);
    let mut sum = 0.0;
    let ((), allocations) = count(|| {
        for k in 0..50 {
            let q = start + SVector::repeat(1e-5 * f64::from(k));
            let pose = robot.forward(&q);
            sum += robot.inverse(&pose, &start).map_or(0.0, |q| q[0]);
            sum += robot.jacobian(&q)[0] + robot.manipulability(&q) + robot.singularity_distance(&q);
            let _ = robot.solutions(&pose, &start, &mut |q| sum += q[0]);
            sum += robot.nearest_attainable(&pose, &start).ok().flatten().map_or(0.0, |q| q[0]);
            sum += driver.tick(&start).map_or(0.0, |measured| measured.position[0]);
            let mut far = pose;
            far.translation.vector.x += 10.0;
            sum += f64::from(u8::from(robot.inverse(&far, &start).is_ok()));
        }
    });
    assert_eq!(allocations, 0, "{}: {sum}", R::KIND);
}

#[test]
fn kinematics_and_servo_periods_of_every_robot_allocate_nothing() {
    let arm = Six::new(0.1, -1.55, 0.1, -0.1, 4.6, 0.2);
    counted(Irp6::nominal(), arm);
    counted(Irp6FiveDof::nominal(), Five::new(0.3, -1.6, 0.1, 0.2, 1.0));
    counted(Irp6Track::nominal(), Seven::from([0.5, arm[0], arm[1], arm[2], arm[3], arm[4], arm[5]]));
    counted(Rnt::new(), Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3));
    counted(Polycrank::new(), Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]));
    counted(Gripper::new(), One::new(0.07));
    counted(Conveyor::new(), One::new(0.5));
}

#[test]
fn servo_periods_of_arms_that_hold_a_body_and_readings_of_a_wrist_allocate_nothing() {
    let start = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
    let flange = Polycrank::new().forward(&start);
    let body = Body::block(2.0, [0.6, 0.1, 0.1]).at(Pose::translation(
        flange.translation.x + 0.3,
        flange.translation.y,
        flange.translation.z,
    ));
    // The body's corners touch the table, too.
    let table = Table::at(flange.translation.z - 0.05);
    let world = World::new(&body).and_then(|world| world.with_table(table)).expect("a world");
    let arm = |x: f64| {
        let robot = Polycrank::new().with_base(Pose::translation(x, 0.0, 0.0));
        world.arm(Simulated::new(robot, &start), Grasp::new(5e4, 500.0)).expect("a grasp")
    };
    let (mut one, mut two) = (arm(0.0), arm(0.6));
    let hands = [one.hand(), two.hand()];
    let wrist = SimulatedWrist::new(one.hand()).with_tool(1.0, Vector3::zeros()).with_noise(0.1, 0.01, 1);
    let mut wrist = wrist.with_low_pass(20.0);
    let mut sum = 0.0;
    let ((), allocations) = count(|| {
        for k in 0..200 {
            if k == 10 {
                hands.iter().for_each(|hand| hand.close().expect("there"));
            }
            sum += one.tick(&start).map_or(0.0, |measured| measured.position[0]);
            sum += two.tick(&start).map_or(0.0, |measured| measured.position[0]);
            let robot = EffectorState {
                joints: [0.0; MAX_JOINTS],
                velocity: [0.0; MAX_JOINTS],
                pose: flange,
                wrench: None,
            };
            let order = ReadingOrder { configuration: WristOrder::Read, robot: Some(robot), step: k };
            sum += wrist.aggregate(&order).map_or(0.0, |wrench| wrench.force.x);
            sum += world.energy() + world.internal_force() + hands[0].internal().torque.x;
        }
    });
    assert!(world.table_force().norm() > 0.0, "it touches");
    assert_eq!(allocations, 0, "{sum}");
}

fn view(name: &str, joints: [f64; 8]) -> RobotView {
    let demanded = EffectorState { joints, velocity: [0.02; 8], pose: Pose::identity(), wrench: None };
    RobotView { name: Name::new(name).unwrap(), measured: demanded, demanded }
}

#[test]
fn clearance_checks_that_pass_and_that_fail_allocate_nothing() {
    let rod = [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.2), 0.02)];
    let build = |margin| {
        Clearance::with_margin(margin)
            .robot("rnt", Rnt::new())
            .unwrap()
            .robot("polycrank", Polycrank::new().with_base(Pose::translation(1.8, 0.0, 0.0)))
            .unwrap()
            .robot("irp6", Irp6Track::nominal().with_base(Pose::translation(-3.0, 0.0, 0.8)))
            .unwrap()
            .tool("rnt", &rod)
            .unwrap()
            .obstacle("floor", Obstacle::table(-0.3))
            .unwrap()
            .build(Stopping::of_guard(std::time::Duration::from_millis(2), 5))
            .unwrap()
    };
    let states = [
        view("rnt", [0.0, 0.5, 0.55, 0.0, 1.3, 0.0, 0.0, 0.0]),
        view("polycrank", [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2, 0.0]),
        view("irp6", [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0, 0.0]),
    ];
    for (margin, passes) in [(0.0, true), (5.0, false)] {
        let mut clearance = build(margin);
        let ((), allocations) = count(|| {
            for _ in 0..100 {
                let checked = clearance.check(&states);
                assert!(checked.is_ok() == passes, "{checked:?}");
                assert!(clearance.nearest(&states).is_ok());
            }
        });
        assert_eq!(allocations, 0);
    }
}

#[test]
fn queries_of_obstacles_with_many_parts_allocate_nothing() {
    let at = |k: f64| Vector3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin());
    let places: Vec<_> = (0..2000).map(|k| at(f64::from(k))).collect();
    let capsules: Vec<_> = places.iter().map(|p| Capsule::new(*p, p * 1.1, 0.01)).collect();
    let heights = places.iter().map(|p| p.z).collect();
    let obstacles = [
        Obstacle::Cloud(Cloud::new(&places, 0.01).unwrap().into()),
        Obstacle::Bodies(Bodies::new(&capsules).unwrap().into()),
        Obstacle::HeightField(HeightField::new(Pose::identity(), 0.05, 50, heights).unwrap().into()),
        Obstacle::Cylinder { X_WO: Pose::identity(), radius: 0.1, half_length: 0.2 },
    ];
    let (sum, allocations) = count(|| {
        let mut sum = 0.0;
        for obstacle in &obstacles {
            for k in 0..100 {
                let link = Capsule::new(at(0.3 + f64::from(k)), at(0.6 + f64::from(k)), 0.05);
                sum += obstacle.gap(&link).distance + obstacle.distance(&link.ends[0], 0.1);
                sum += f64::from(u8::from(obstacle.ball_clear(&link.ends[0], 0.05)));
                sum += f64::from(u8::from(obstacle.capsule_clear(&link, 0.02)));
            }
        }
        sum
    });
    assert_eq!(allocations, 0, "{sum}");
}
