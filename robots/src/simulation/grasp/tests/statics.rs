//! Equilibrium: forces of springs against weights, solved by hand or by a general linear solution.

use mrroc::pose::{AngleAxis, Pose};
use nalgebra::{Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

use super::Bench;
use super::bench::{at, weightless};
use crate::models::GRAVITY;
use crate::simulation::grasp::{Body, Grasp, World};

const MASS: f64 = 3.0;

fn bar() -> Body {
    Body::block(MASS, [0.6, 0.1, 0.1])
}

#[test]
fn two_equal_grasps_at_equal_distances_carry_half_the_weight_each() {
    let grasp = Grasp::new(5e4, 500.0);
    let bench = Bench::new(World::new(&bar()).expect("a body"))
        .with_hand(grasp, at(-0.3, 0.0, 0.0))
        .with_hand(grasp, at(0.3, 0.0, 0.0));
    bench.close();
    bench.run(4.0);
    let weight = MASS * GRAVITY;
    for (hand, ..) in &bench.hands {
        let force = hand.reaction().force;
        assert!((force - Vector3::new(0.0, 0.0, -0.5 * weight)).amax() < 1e-6, "{force}");
    }
    let sag = -bench.world.body().pose.translation.z;
    assert!((sag - weight / 1e5).abs() < 1e-10, "{sag}");
    // Carrying is not squeezing.
    assert!(bench.world.internal_force() < 1e-6);
}

#[test]
fn unequal_grasps_carry_what_their_stiffness_and_their_levers_give_them() {
    // z and a turn b about y: sum k_i (z - x_i b) = -m g, sum x_i k_i (z - x_i b) - sum kappa_i b = 0.
    let (k, kappa, x) = ([2e4, 6e4], [300.0, 700.0], [-0.3, 0.2]);
    let mut bench = Bench::new(World::new(&bar()).expect("a body"));
    for i in 0..2 {
        bench = bench.with_hand(Grasp::new(k[i], kappa[i]), at(x[i], 0.0, 0.0));
    }
    bench.close();
    bench.run(6.0);
    let (s0, s1) = (k[0] + k[1], k[0] * x[0] + k[1] * x[1]);
    let s2 = k[0] * x[0] * x[0] + k[1] * x[1] * x[1] + kappa[0] + kappa[1];
    let weight = MASS * GRAVITY;
    // s0 z - s1 b = -weight, s1 z - s2 b = 0.
    let z = -weight / (s0 - s1 * s1 / s2);
    let b = s1 * z / s2;
    for i in 0..2 {
        let expected = k[i] * (z - x[i] * b);
        let force = bench.hands[i].0.reaction().force.z;
        assert!((force - expected).abs() < 1e-3, "{i}: {force} for {expected}");
        let (torque, expected) = (bench.hands[i].0.reaction().torque.y, kappa[i] * b);
        assert!((torque - expected).abs() < 1e-4, "{i}: {torque} for {expected}");
    }
}

/// The forces of springs on a free body, linear in small displacements: `sum K_i (u - u_i) = 0` about the origin.
fn series(springs: &[(f64, f64, Vector3<f64>, Vector6<f64>)]) -> Vec<Vector6<f64>> {
    let at_spring = |r: &Vector3<f64>| {
        let mut a = Matrix6::identity();
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&-r.cross_matrix());
        a
    };
    let stiffness = |k: f64, kappa: f64| Matrix6::from_diagonal(&Vector6::new(k, k, k, kappa, kappa, kappa));
    let (mut sum, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for (k, kappa, r, moved) in springs {
        let a = at_spring(r);
        sum += a.transpose() * stiffness(*k, *kappa) * a;
        right += a.transpose() * stiffness(*k, *kappa) * moved;
    }
    let u = sum.lu().solve(&right).expect("held");
    let force = |(k, kappa, r, moved): &(f64, f64, Vector3<f64>, Vector6<f64>)| {
        stiffness(*k, *kappa) * (at_spring(r) * u - moved)
    };
    springs.iter().map(force).collect()
}

#[test]
#[allow(non_snake_case)]
fn grippers_off_their_grasps_squeeze_as_springs_in_series_do() {
    // The second gripper stands 1 mm and 0.1 deg off, as after an error of calibration.
    let degree = core::f64::consts::PI / 180.0;
    let cases = [
        (Vector3::new(1e-3, 0.0, 0.0), Vector3::zeros()),
        (Vector3::new(0.0, 1e-3, 0.0), Vector3::zeros()),
        (Vector3::zeros(), Vector3::new(0.1, 0.0, 0.0) * degree),
        (Vector3::new(4e-4, -6e-4, 7e-4), Vector3::new(0.03, -0.08, 0.05) * degree),
    ];
    for (shift, turn) in cases {
        let off = Pose::from_parts(Translation3::from(shift), AngleAxis(turn).rotation());
        let (left, right) = (at(-0.3, 0.0, 0.0), at(0.3, 0.0, 0.0));
        let grasp = Grasp::new(5e4, 500.0);
        let bench = Bench::new(World::new(&bar()).expect("a body").with_gravity(Vector3::zeros()))
            .with_hand(grasp.at(left), left)
            .with_hand(grasp.at(right), right * off);
        bench.close();
        bench.run(4.0);
        let moved = Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
        let springs = [
            (5e4, 500.0, left.translation.vector, Vector6::zeros()),
            (5e4, 500.0, right.translation.vector, moved),
        ];
        let expected = series(&springs);
        for ((hand, ..), expected) in bench.hands.iter().zip(&expected) {
            // E's axes are all but the world's.
            let reaction = hand.reaction();
            let (f, t) = (expected.fixed_rows::<3>(0), expected.fixed_rows::<3>(3));
            // Second order: 2e-3 rad of 25 N.
            assert!((reaction.force - f).amax() < 0.06, "{shift} {turn}: {} for {f}", reaction.force);
            assert!((reaction.torque - t).amax() < 0.02, "{shift} {turn}: {} for {t}", reaction.torque);
            // Nothing else acts on the body: all of it is internal.
            assert!((hand.internal().force.norm() - reaction.force.norm()).abs() < 1e-6);
        }
        if shift.x == 1e-3 {
            let squeeze = bench.world.internal_force();
            assert!((squeeze - 5e4 * 1e-3 / 2.0).abs() < 1e-3, "k delta / 2 is 25 N: {squeeze} N");
        }
    }
}

#[test]
fn a_grasp_that_turns_far_stores_the_energy_of_its_angle() {
    let grasp = Grasp::new(5e4, 500.0);
    let bench = Bench::new(World::new(&bar()).expect("a body").with_gravity(Vector3::zeros()));
    let bench = bench.with_hand(grasp, at(0.0, 0.0, 0.0));
    bench.close();
    let turned =
        Pose::from_parts(Default::default(), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.5));
    bench.hands[0].0.begin();
    bench.hands[0].0.end(turned);
    // The gripper does the work within 2 ms; the body of 0.09 kg m² hardly moves in them.
    bench.hands[0].0.begin();
    let energy = bench.world.energy();
    assert!((energy / (0.5 * 500.0 * 1.5 * 1.5) - 1.0).abs() < 0.02, "{energy}");
}

#[test]
fn a_grasp_that_closes_slowly_pulls_without_a_jerk() {
    // 1 mm off at one end: with k(t) alike at both, 25 N at the end in either case; suddenly, nearly twice as much first.
    let peak = |closing: f64| {
        let (left, right) = (at(-0.3, 0.0, 0.0), at(0.3, 0.0, 0.0));
        let grasp = Grasp::new(5e4, 500.0).closing_over(closing);
        let bench = Bench::new(World::new(&bar()).expect("a body").with_gravity(Vector3::zeros()))
            .with_hand(grasp.at(left), left)
            .with_hand(grasp.at(right), right * at(1e-3, 0.0, 0.0));
        bench.close();
        let mut peak = 0.0_f64;
        for _ in 0..1000 {
            bench.tick();
            peak = peak.max(bench.hands[0].0.reaction().force.norm());
        }
        let last = bench.hands[0].0.reaction().force.norm();
        assert!((last - 25.0).abs() < 1e-6, "{last}");
        peak
    };
    let (sudden, slow) = (peak(0.0), peak(0.2));
    assert!(sudden > 35.0 && slow < 26.0, "{sudden} N and {slow} N");
}

#[test]
fn four_grasps_carry_a_quarter_of_a_plate_each() {
    let grasp = Grasp::new(5e4, 500.0);
    let body = Body::block(8.0, [0.8, 0.6, 0.05]);
    let mut bench = Bench::new(World::new(&body).expect("a body"));
    for (x, y) in [(-0.4, -0.3), (0.4, -0.3), (0.4, 0.3), (-0.4, 0.3)] {
        bench = bench.with_hand(grasp, at(x, y, 0.0));
    }
    bench.close();
    bench.run(3.0);
    for (hand, ..) in &bench.hands {
        let force = hand.reaction().force;
        assert!((force + Vector3::z() * (2.0 * GRAVITY)).amax() < 1e-6, "{force}");
    }
    assert!(bench.world.internal_force() < 1e-6);
}

#[test]
fn what_the_body_does_to_the_gripper_of_an_arm_that_stopped_goes_on_being_read() {
    // The first arm's drives stop; then the second lowers its end of a weightless bar by d: two springs in series, k d / 2.
    let (k, d) = (5e4, 1e-3);
    let world = weightless(World::new(&Body::block(2.0, [0.4, 0.1, 0.1])).expect("a body"));
    let bench = Bench::new(world)
        .with_hand(Grasp::new(k, 500.0), at(-0.2, 0.0, 0.0))
        .with_hand(Grasp::new(k, 500.0), at(0.2, 0.0, 0.0));
    bench.close();
    bench.run(0.1);
    let [(first, ..), (second, ..)] = &bench.hands[..] else { panic!("two") };
    for _ in 0..2000 {
        second.begin();
        second.end(at(0.2 + d, 0.0, 0.0));
    }
    let (one, two) = (first.reaction().force.x, second.reaction().force.x);
    assert!((one - 0.5 * k * d).abs() < 1e-3 && (two + 0.5 * k * d).abs() < 1e-3, "{one} N, {two} N");
}
