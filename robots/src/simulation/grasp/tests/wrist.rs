//! The wrist sensor: what it takes off, how it smooths, when it refuses.

use core::f64::consts::TAU;

use mrroc::fault::FaultKind;
use mrroc::pose::{AngleAxis, Wrench};
use mrroc::prelude::*;
use mrroc::random::Noise;
use mrroc::robot::MAX_JOINTS;
use mrroc::sensor::EffectorState;
use nalgebra::{Translation3, Vector3};

use super::Bench;
use super::bench::at;
use crate::sensors::WristOrder;
use crate::simulation::grasp::{Body, Grasp, SimulatedWrist, World};

#[allow(non_snake_case)]
fn order(configuration: WristOrder, X_WE: Pose) -> ReadingOrder<WristOrder> {
    let robot =
        EffectorState { joints: [0.0; MAX_JOINTS], velocity: [0.0; MAX_JOINTS], pose: X_WE, wrench: None };
    ReadingOrder { configuration, robot: Some(robot), step: 0 }
}

/// A hand at `X_WE` that may hold a bar which weighs 29.4 N.
#[allow(non_snake_case)]
fn bench(X_WE: Pose) -> Bench {
    let body = Body::block(3.0, [0.2, 0.1, 0.1]).at(X_WE);
    Bench::new(World::new(&body).expect("a body")).with_hand(Grasp::new(5e4, 500.0), X_WE)
}

fn random(noise: &mut Noise) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise.normal())
}

#[test]
#[allow(non_snake_case)]
fn an_unloaded_wrist_reads_nothing_to_its_resolution_however_it_hangs() {
    let mut noise = Noise::seeded(11);
    let bias = Wrench::new(Vector3::new(3.0, -2.0, 5.0), Vector3::new(0.1, -0.2, 0.05));
    let X_ES =
        Pose::from_parts(Translation3::new(0.0, 0.01, -0.09), AngleAxis(Vector3::z() * -1.57).rotation());
    for _ in 0..200 {
        let turn =
            |noise: &mut Noise| Pose::from_parts(Default::default(), AngleAxis(random(noise)).rotation());
        // The bias is measured hanging in one orientation, the reading taken in another.
        let (first, second) = (turn(&mut noise), turn(&mut noise));
        let bench = bench(first);
        let mut sensor = SimulatedWrist::new(bench.hands[0].0.clone())
            .at(X_ES)
            .with_tool(1.1, Vector3::new(0.004, 0.0, 0.13))
            .with_bias(bias);
        sensor.aggregate(&order(WristOrder::MeasureBias, first)).expect("in range");
        bench.hands[0].0.begin();
        bench.hands[0].0.end(second);
        bench.hands[0].0.begin();
        let read = sensor.aggregate(&order(WristOrder::Read, second)).expect("in range");
        // Two roundings by half a resolution each along three axes; at E the force has a lever of |X_ES|.
        let force = 3.0_f64.sqrt() * 0.0125;
        assert!(read.force.norm() <= force, "{read:?}");
        assert!(read.torque.norm() <= 3.0_f64.sqrt() * 7.5e-4 + 0.0906 * force, "{read:?}");
    }
}

#[test]
fn a_held_body_is_read_as_its_weight_in_the_axes_of_the_tool() {
    let pose = Pose::from_parts(
        Translation3::new(0.4, 0.1, 0.7),
        AngleAxis(Vector3::new(0.5, -0.3, 0.8)).rotation(),
    );
    let bench = bench(pose);
    bench.close();
    bench.run(3.0);
    let mut sensor =
        SimulatedWrist::new(bench.hands[0].0.clone()).with_tool(1.1, Vector3::new(0.0, 0.0, 0.1));
    let read = sensor.aggregate(&order(WristOrder::Read, pose)).expect("in range");
    let weight = pose.rotation.inverse() * Vector3::new(0.0, 0.0, -3.0 * 9.80665);
    assert!((read.force - weight).amax() <= 0.5 * 0.0125 + 1e-6, "{read:?}");
    // The body hangs by 0.6 mm below the grasp; that lever is within what is read.
    assert!(read.torque.amax() <= 0.5 * 7.5e-4 + 1e-3, "{read:?}");
    // A tool that is believed to be 0.1 kg lighter leaves 0.98 N.
    let mut sensor = sensor.compensating(1.0, Vector3::new(0.0, 0.0, 0.1));
    let off = sensor.aggregate(&order(WristOrder::Read, pose)).expect("in range");
    assert!(((off.force - read.force).norm() - 0.980_665).abs() < 1e-9);
}

#[test]
fn the_low_pass_filter_rises_as_its_corner_frequency_says() {
    let pose = at(0.0, 0.0, 0.0);
    let bench = bench(pose);
    let corner = 10.0;
    let mut sensor =
        SimulatedWrist::new(bench.hands[0].0.clone()).with_low_pass(corner).with_resolution(1e-9, 1e-9);
    bench.run(0.1);
    sensor.aggregate(&order(WristOrder::Read, pose)).expect("in range");
    // A step of 29.4 N, made sudden by a bias that is no longer known.
    let mut sensor = sensor.knowing_bias(Wrench::new(Vector3::new(0.0, 0.0, -29.4), Vector3::zeros()));
    for k in 1..=50 {
        bench.tick();
        let read = sensor.aggregate(&order(WristOrder::Read, pose)).expect("in range").force.z;
        let expected = 29.4 * (1.0 - (-TAU * corner * 2e-3 * f64::from(k)).exp());
        assert!((read - expected).abs() < 1e-6, "{k}: {read} for {expected}");
    }
}

#[test]
fn beyond_its_range_the_sensor_gives_a_fault_and_no_reading() {
    let pose = at(0.0, 0.0, 0.0);
    let bench = bench(pose);
    let range = SimulatedWrist::RANGE;
    for i in 0..6 {
        for sign in [-1.0, 1.0] {
            let at_limit = |share: f64| {
                let mut bias = Wrench::default();
                if i < 3 {
                    bias.force[i] = sign * range.force[i] * share;
                } else {
                    bias.torque[i - 3] = sign * range.torque[i - 3] * share;
                }
                SimulatedWrist::new(bench.hands[0].0.clone()).with_bias(bias).knowing_bias(bias)
            };
            let read = at_limit(0.999).aggregate(&order(WristOrder::Read, pose)).expect("in range");
            assert!(read.force.amax() < 0.0125 && read.torque.amax() < 7.5e-4);
            let fault = at_limit(1.001).aggregate(&order(WristOrder::Read, pose)).expect_err("saturated");
            assert_eq!(fault.kind(), FaultKind::SensorFailed);
            assert!(fault.to_string().contains("saturates"), "{fault}");
        }
    }
    let nan = Wrench::new(Vector3::repeat(f64::NAN), Vector3::zeros());
    let mut broken = SimulatedWrist::new(bench.hands[0].0.clone()).with_bias(nan);
    assert!(broken.aggregate(&order(WristOrder::Read, pose)).is_err());
}

#[test]
fn noise_is_the_same_for_the_same_seed_and_averaged_out_of_a_measured_bias() {
    let pose = at(0.0, 0.0, 0.0);
    let bench = bench(pose);
    let sensor = |seed| SimulatedWrist::new(bench.hands[0].0.clone()).with_noise(0.5, 0.01, seed);
    let read =
        |mut sensor: SimulatedWrist| sensor.aggregate(&order(WristOrder::Read, pose)).expect("in range");
    assert_eq!(read(sensor(3)), read(sensor(3)));
    assert_ne!(read(sensor(3)), read(sensor(4)));
    let bias = Wrench::new(Vector3::new(7.0, 0.0, 0.0), Vector3::zeros());
    let mut measuring = sensor(5).with_bias(bias);
    for _ in 0..400 {
        measuring.aggregate(&order(WristOrder::MeasureBias, pose)).expect("in range");
    }
    // Without noise what is left is the error of the bias: five standard errors of 0.5 / 20.
    let left = read(measuring.with_noise(0.0, 0.0, 0));
    assert!(left.force.amax() < 5.0 * 0.025, "{left:?}");
}

#[test]
fn a_sensor_without_resolution_or_of_a_negative_corner_is_refused() {
    let pose = at(0.0, 0.0, 0.0);
    let bench = bench(pose);
    let sensor = || SimulatedWrist::new(bench.hands[0].0.clone());
    let wrong = [
        sensor().with_resolution(0.0, 1.0),
        sensor().with_resolution(1.0, f64::NAN),
        sensor().with_low_pass(-1.0),
        sensor().with_noise(-1.0, 0.0, 0),
    ];
    for mut sensor in wrong {
        let fault = sensor.aggregate(&order(WristOrder::Read, pose)).expect_err("refused");
        assert_eq!(fault.kind(), FaultKind::Config);
    }
    let mut of_no_robot = order(WristOrder::Read, pose);
    of_no_robot.robot = None;
    assert!(sensor().aggregate(&of_no_robot).is_err());
}
