//! The gripper's opening and its grasp.

use mrroc::robot::{Driver, NoInverse, Robot};
use mrroc_robots::{Driven, Gripper, One, Simulated};

const PERIOD: f64 = 0.002;

/// Both formulas as MRROC++ has them: x(m), and m(x) with rounded constants.
#[test]
fn the_opening_is_that_of_mrroc() {
    let gripper = Gripper::new();
    for k in 0..=38 {
        let x = 0.053 + 0.001 * f64::from(k);
        let m = gripper.motors(&One::new(x))[0];
        let published = 3.531_946_456e-6 * (2.622_172_716e18 - 2.8313e19 * x).sqrt() - 2_564.034_32;
        assert!((m - published).abs() < 1e-3, "{x}: {m} {published}");
        let opening = -2.8313e-9 * m * m - 1.451_910_074e-5 * m + 0.074;
        assert!((opening - x).abs() < 1e-15, "{x}: {opening}");
    }
}

#[test]
fn an_object_stops_the_fingers_without_a_fault_and_is_held_with_the_current_limit() {
    let start = One::new(0.08);
    let mut drive = Simulated::new(Gripper::new(), &start);
    let mut demanded = start;
    let mut close = |drive: &mut Simulated<Gripper, 1>, to: f64| {
        while demanded[0] > to {
            demanded[0] = (demanded[0] - 0.005 * PERIOD).max(to);
            drive.tick(&demanded).expect("closing trips nothing");
        }
    };
    close(&mut drive, 0.07);
    drive.block(0);
    let object = drive.measured().expect("simulated").position[0];
    close(&mut drive, 0.06);
    for _ in 0..5000 {
        drive.tick(&One::new(0.06)).expect("holding an object trips nothing");
    }
    let (held, current) = (drive.measured().expect("simulated").position[0], drive.currents()[0].abs());
    println!("held at {held:.4} m of {object:.4} m with {current} A");
    assert!((held - object).abs() < 1e-9 && (current - Gripper::MOTOR.current_limit).abs() < 1e-12);
    drive.unblock(0);
    for _ in 0..2000 {
        drive.tick(&One::new(0.06)).expect("the fingers close on");
    }
    assert!(
        (drive.measured().expect("simulated").position[0] - 0.06).abs() < 1e-5,
        "{}",
        drive.measured().expect("simulated").position[0]
    );
}

#[test]
fn a_pose_beside_the_finger_s_line_is_refused() {
    let gripper = Gripper::new();
    let mut pose = gripper.forward(&One::new(0.07));
    pose.translation.vector.y += 1e-3;
    let why = gripper.inverse(&pose, &One::new(0.07)).expect_err("beside the line");
    let NoInverse::NotAttainable { actual, unit: "m", .. } = why else { panic!("{why}") };
    assert!((actual - 1e-3).abs() < 1e-15, "{why}");
}
