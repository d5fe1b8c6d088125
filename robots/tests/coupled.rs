//! Simulated drives whose links couple them: they keep what drivers must keep, and are those of one inertia where the links'
//! inertia is the same everywhere.

use mrroc::robot::Driver;
use mrroc_counting_allocator::allocations;
use mrroc_robots::{
    Conveyor, Driven, Gripper, Irp6, Irp6FiveDof, Irp6Track, One, Polycrank, Rnt, Serial, Simulated,
    TwoFingers, driver_conformance,
};
use nalgebra::SVector;

fn weighted() -> Serial<6> {
    let path = format!("{}/tests/reference/urdf/weighted_arm.urdf", env!("CARGO_MANIFEST_DIR"));
    Serial::<6>::from_urdf_file(path, "base_link", "tool0")
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound")
}

const ARM: [f64; 6] = Irp6::READY.data.0[0];
const CRANKS: [f64; 7] = [0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2];
const RODS: [f64; 6] = [0.0, 0.5, 0.55, 0.0, 1.3, 0.0];
const SIX: [f64; 6] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];

fn coupled<const N: usize, R: Driven<N>>(robot: R, q: [f64; N]) -> Simulated<R, N> {
    Simulated::coupled(robot, &q.into()).expect("it has links")
}

driver_conformance!(irp6, Irp6::nominal(), coupled(Irp6::nominal(), ARM), SVector::from(ARM));
driver_conformance!(rnt, Rnt::new(), coupled(Rnt::new(), RODS), SVector::from(RODS));
driver_conformance!(polycrank, Polycrank::new(), coupled(Polycrank::new(), CRANKS), SVector::from(CRANKS));
driver_conformance!(weighted_arm, weighted(), coupled(weighted(), SIX), SVector::from(SIX));

/// Goes to and fro at an eighth of what the limits allow, every joint in its own time, and comes back.
fn goes_to_and_fro<const N: usize, R: Driven<N>>(robot: R, q: [f64; N]) {
    let q = SVector::<f64, N>::from(q);
    let limits = *robot.limits();
    let mut arm = Simulated::coupled(robot, &q).expect("it has links");
    let mut worst = 0.0_f64;
    for k in 0..3000 {
        let t = 0.002 * f64::from(k);
        // amplitude a (1 - cos(w t)) / 2: speed a w / 2, acceleration a w² / 2.
        let wave = |i: usize| {
            let w = 2.0 + 0.3 * i as f64;
            let most = (limits.velocity[i] / w).min(limits.acceleration[i] / (w * w));
            0.12 * most * (1.0 - (w * t).cos())
        };
        let demanded = q + SVector::<f64, N>::from_fn(|i, _| wave(i));
        let before = allocations();
        let measured = arm.tick(&demanded).unwrap_or_else(|fault| panic!("{}: {fault}", R::KIND));
        assert_eq!(allocations(), before, "{}: a period allocates", R::KIND);
        for i in 0..N {
            worst = worst.max((measured.position[i] - demanded[i]).abs() / limits.velocity[i]);
        }
    }
    println!("{}: behind by at most {:.2} ms of the largest speed", R::KIND, worst * 1e3);
    assert!(worst < 0.02, "{}: {worst} s", R::KIND);
}

#[test]
fn coupled_robots_follow_within_their_limits_and_allocate_nothing() {
    goes_to_and_fro(Irp6::nominal(), ARM);
    goes_to_and_fro(Irp6FiveDof::nominal(), [0.0, -1.57, 0.16, 0.6, 1.0]);
    goes_to_and_fro(Irp6Track::nominal(), [0.5, 0.0, -1.57, 0.16, -0.16, 4.71, 0.0]);
    goes_to_and_fro(Rnt::new(), RODS);
    goes_to_and_fro(Polycrank::new(), CRANKS);
    goes_to_and_fro(Gripper::new(), [0.065]);
    goes_to_and_fro(TwoFingers::new(), [0.04]);
    goes_to_and_fro(Conveyor::new(), [0.0]);
    goes_to_and_fro(weighted(), SIX);
}

#[test]
fn a_belt_has_the_same_inertia_everywhere_so_coupling_changes_nothing() {
    let mut coupled = coupled(Conveyor::new(), [0.0]);
    let mut alone = Simulated::new(Conveyor::new(), &One::new(0.0));
    for k in 0..2000 {
        let demanded = One::new(0.05 * (1.0 - (1.0 * 0.002 * f64::from(k)).cos()));
        coupled.tick(&demanded).expect("no fault");
        alone.tick(&demanded).expect("no fault");
        let off = coupled.shaft().state().position - alone.shaft().state().position;
        assert!(off.amax() < 1e-12, "{off} m after {k} periods");
    }
}

#[test]
fn a_joint_that_is_jerked_shakes_the_others_only_where_they_are_coupled() {
    // The shoulder starts at half its acceleration; the column, whose axis it crosses at a right angle, is not loaded, the elbow is.
    let shaken = |mut arm: Simulated<Serial<6>, 6>| {
        let q = SVector::from([0.0, 0.2, 0.3, 0.0, 0.5, 0.0]);
        let mut most = SVector::<f64, 6>::zeros();
        for k in 0..100 {
            let t = 0.002 * f64::from(k);
            let mut demanded = q;
            demanded[1] += 2.5 * t * t;
            arm.tick(&demanded).expect("no fault");
            most = most.sup(&(arm.shaft().state().position - demanded).abs());
        }
        most
    };
    let q = [0.0, 0.2, 0.3, 0.0, 0.5, 0.0];
    let (with, without) = (shaken(coupled(weighted(), q)), shaken(Simulated::new(weighted(), &q.into())));
    println!("coupled {with} rad, alone {without} rad");
    assert!(with[2] > 5.0 * without[2], "{} and {}", with[2], without[2]);
}
