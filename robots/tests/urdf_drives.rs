//! Simulated drives of arms read from URDF: they keep what drivers must keep, and what the file says of masses, efforts and
//! friction is in them.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Driver;
use mrroc_robots::{Driven, Serial, Simulated, UrdfError, driver_conformance};
use nalgebra::{SVector, Vector2, Vector3};

const GRAVITY: f64 = 9.80665;

fn arm<const N: usize>(arm: &str, base: &str, tip: &str) -> Serial<N> {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    Serial::<N>::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::<f64, N>::repeat(10.0)))
        .expect("the URDF is sound")
}

fn six() -> SVector<f64, 6> {
    SVector::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
}

fn weighted() -> Serial<6> {
    arm("weighted_arm", "base_link", "tool0")
}

driver_conformance!(weighted_arm, weighted(), Simulated::new(weighted(), &six()), six());
driver_conformance!(
    ortho_parallel,
    arm::<6>("ortho_parallel", "base_link", "tool0"),
    Simulated::new(arm::<6>("ortho_parallel", "base_link", "tool0"), &six()),
    six()
);
driver_conformance!(
    offset_arm,
    arm::<6>("offset_arm", "foot", "tool"),
    Simulated::new(arm::<6>("offset_arm", "foot", "tool"), &six()),
    six()
);
driver_conformance!(
    three_parallel,
    arm::<6>("three_parallel", "base", "wrist_3"),
    Simulated::new(arm::<6>("three_parallel", "base", "wrist_3"), &six()),
    six()
);
driver_conformance!(
    seven_axes,
    arm::<7>("seven_axes", "world_foot", "flange"),
    Simulated::new(arm::<7>("seven_axes", "world_foot", "flange"), &SVector::from([0.1; 7])),
    SVector::<f64, 7>::from([0.1; 7])
);
// A slide, an endless joint, and one that mimics.
driver_conformance!(
    palletiser,
    arm::<4>("palletiser", "base", "tool"),
    Simulated::new(arm::<4>("palletiser", "base", "tool"), &SVector::from([0.1, 0.2, 0.3, 0.4])),
    SVector::<f64, 4>::from([0.1, 0.2, 0.3, 0.4])
);
driver_conformance!(
    gantry,
    arm::<4>("gantry", "bed", "tool"),
    Simulated::new(arm::<4>("gantry", "bed", "tool"), &SVector::from([0.5, 0.1, 0.1, 0.4])),
    SVector::<f64, 4>::from([0.5, 0.1, 0.1, 0.4])
);

/// Two links in a vertical plane, rods along x: lengths, masses, centres along x, moments about y.
const L1: f64 = 0.4;
const MASSES: [f64; 2] = [3.0, 2.0];
const CENTRES: [f64; 2] = [0.15, 0.25];
const MOMENTS: [f64; 2] = [0.05, 0.03];

fn planar_text(inertial: bool) -> String {
    let link = |i: usize| {
        let body = format!(
            "<inertial><origin xyz=\"{} 0 0\"/><mass value=\"{}\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"{moment}\" iyz=\"0\" izz=\"{moment}\"/></inertial>",
            CENTRES[i],
            MASSES[i],
            moment = MOMENTS[i]
        );
        if inertial { body } else { String::new() }
    };
    format!(
        r#"<robot name="planar"><link name="base"/><link name="upper">{}</link><link name="fore">{}</link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="60" velocity="2"/><dynamics damping="0.7" friction="1.1"/></joint>
<joint name="elbow" type="revolute"><origin xyz="{L1} 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="0" velocity="4"/></joint></robot>"#,
        link(0),
        link(1)
    )
}

fn planar(inertial: bool) -> Serial<2> {
    Serial::from_urdf(&planar_text(inertial), "base", "fore")
        .and_then(|robot| robot.with_acceleration(Vector2::new(3.0, 5.0)))
        .expect("sound")
}

/// What the motors turn by per joint angle: the lesser of 250 rad/s by the velocity and 500 rad/s² by the acceleration.
const GEARS: [f64; 2] = [125.0, 62.5];

#[test]
fn gears_use_the_motors_speed_or_its_acceleration() {
    let q = Vector2::new(0.3, -0.2);
    assert_eq!(planar(true).motors(&q), Vector2::new(0.3 * GEARS[0], -0.2 * GEARS[1]));
    let quick = Serial::<2>::from_urdf(&planar_text(true), "base", "fore")
        .and_then(|robot| robot.with_acceleration(Vector2::new(20.0, 5.0)))
        .expect("sound");
    assert_eq!(quick.motors(&q)[0], 0.3 * 25.0);
}

/// Craig, Introduction to Robotics, 6.7: the gravity terms of the planar arm with two links; a turn about y lowers x.
#[test]
fn the_weight_of_a_planar_arm_is_that_of_the_textbook() {
    let [m1, m2] = MASSES;
    let [c1, c2] = CENTRES;
    let robot = planar(true);
    let mut random = Random::seeded(5);
    for _ in 0..1000 {
        let q = Vector2::new(random.between(-3.0, 3.0), random.between(-3.0, 3.0));
        let fore = -GRAVITY * m2 * c2 * (q[0] + q[1]).cos();
        let upper = -GRAVITY * (m1 * c1 + m2 * L1) * q[0].cos() + fore;
        let loads = robot.shafts(&robot.motors(&q), &Vector2::zeros()).loads;
        assert!((loads[0] * GEARS[0] - upper).abs() < 1e-12, "{loads}");
        assert!((loads[1] * GEARS[1] - fore).abs() < 1e-12, "{loads}");
    }
    // Lying on its side, nothing pulls; upside down, it pulls in the other direction.
    let q = Vector2::new(0.3, -0.2);
    let upright = robot.shafts(&robot.motors(&q), &Vector2::zeros()).loads;
    let turned = |angle: f64| {
        let robot = planar(true).with_base(Pose::rotation(Vector3::x() * angle));
        robot.shafts(&robot.motors(&q), &Vector2::zeros()).loads
    };
    assert!(turned(std::f64::consts::FRAC_PI_2).amax() < 1e-12);
    assert!((turned(std::f64::consts::PI) + upright).amax() < 1e-12);
}

/// The inertia about the shoulder of the same textbook is greatest with the elbow stretched.
#[test]
fn the_inertia_is_that_of_the_posture_that_has_most() {
    let [m1, m2] = MASSES;
    let [c1, c2] = CENTRES;
    let most = m1 * c1 * c1 + MOMENTS[0] + m2 * (L1 + c2).powi(2) + MOMENTS[1];
    let robot = planar(true);
    let motors = robot.motor_data();
    let rotor = 1e-4;
    assert!((motors[0].inertia - rotor - most / GEARS[0].powi(2)).abs() < 1e-15);
    let fore = m2 * c2 * c2 + MOMENTS[1];
    assert!((motors[1].inertia - rotor - fore / GEARS[1].powi(2)).abs() < 1e-15);
    assert_eq!(planar(false).motor_data()[0].inertia, rotor, "without <inertial>, no mass");
}

#[test]
fn effort_and_dynamics_are_in_the_motors() {
    let robot = planar(true);
    let [shoulder, elbow] = robot.motor_data();
    // 60 N m at the joint.
    assert!((shoulder.current_limit * shoulder.torque_constant * GEARS[0] - 60.0).abs() < 1e-12);
    let without = |data: &mrroc_robots::MotorData| (0.4 * data.inertia, 32.0 * data.inertia);
    let (viscous, coulomb) = without(shoulder);
    assert!((shoulder.viscous - viscous - 0.7 / GEARS[0].powi(2)).abs() < 1e-15);
    assert!((shoulder.coulomb - coulomb - 1.1 / GEARS[0]).abs() < 1e-15);
    assert_eq!((elbow.viscous, elbow.coulomb), without(elbow));
    // No effort: twice what it needs, which is at least its weight stretched out and its acceleration.
    let torque = elbow.current_limit * elbow.torque_constant * GEARS[1];
    let needed = MASSES[1] * CENTRES[1] * GRAVITY + (MASSES[1] * CENTRES[1].powi(2) + MOMENTS[1]) * 5.0;
    assert!(torque > 2.0 * needed && torque < 4.0 * needed, "{torque} N m, {needed} N m");
}

#[test]
fn no_closed_path_gains_energy_from_the_weight_of_six_links() {
    let robot = weighted().with_base(Pose::new(Vector3::zeros(), Vector3::new(0.4, -0.2, 1.0)));
    let corner = |phase: f64| SVector::<f64, 6>::from_fn(|i, _| 0.5 * (1.7 * i as f64 + phase).sin());
    let corners = [0.0, 2.0, 4.5].map(|phase| robot.motors(&(six() + corner(phase))));
    let load = |m: &SVector<f64, 6>| robot.shafts(m, &SVector::zeros()).loads;
    let (mut work, mut passed) = (0.0, 0.0);
    for side in 0..3 {
        let step = (corners[(side + 1) % 3] - corners[side]) / 200.0;
        for piece in 0..200 {
            let at = corners[side] + step * f64::from(piece);
            let mean = (load(&at) + load(&(at + step * 0.5)) * 4.0 + load(&(at + step))) / 6.0;
            work += mean.dot(&step);
            passed += mean.dot(&step).abs();
        }
    }
    assert!(passed > 100.0 && f64::abs(work) < 1e-7 * passed, "{work} J of {passed} J");
}

#[test]
fn an_effort_that_cannot_carry_the_arm_trips_by_name() {
    let weak = planar_text(true).replace("effort=\"60\"", "effort=\"5\"");
    let robot = Serial::<2>::from_urdf(&weak, "base", "fore")
        .and_then(|robot| robot.with_acceleration(Vector2::new(3.0, 5.0)))
        .expect("sound");
    let stretched = Vector2::zeros();
    let mut drives = Simulated::new(robot, &stretched);
    let fault = (0..500).find_map(|_| drives.tick(&stretched).err()).expect("17 N m is above 5 N m");
    assert_eq!((fault.joint(), fault.what()), (Some(0), "motor current"));
}

#[test]
fn bad_masses_and_dynamics_are_refused_by_name() {
    let refusal = |from: &str, to: &str| {
        let text = planar_text(true);
        assert!(text.contains(from), "{from}");
        match Serial::<2>::from_urdf(&text.replacen(from, to, 1), "base", "fore") {
            Ok(_) => panic!("it was read: {to}"),
            Err(why @ UrdfError::File { .. }) => panic!("{why}"),
            Err(why) => why.to_string(),
        }
    };
    for (from, to, told) in [
        ("<mass value=\"3\"/>", "", "link \"upper\" <inertial> has no <mass>"),
        ("value=\"3\"", "value=\"-3\"", "link \"upper\" <inertial> <mass>: value=\"-3\""),
        ("ixy=\"0\" ", "", "<inertia> has no attribute ixy"),
        ("iyy=\"0.05\"", "iyy=\"much\"", "<inertia>: iyy=\"much\""),
        ("damping=\"0.7\"", "damping=\"-0.7\"", "joint \"shoulder\" <dynamics>: damping=\"-0.7\""),
        ("effort=\"60\"", "effort=\"-1\"", "joint \"shoulder\" <limit>: effort=\"-1\""),
    ] {
        let why = refusal(from, to);
        assert!(why.contains(told), "{to}: {why}");
    }
}
