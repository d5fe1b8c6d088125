//! Jerk-limited plans against closed forms, and on inputs at the edge.

use mrroc_generators::jerk::*;
use nalgebra::{Vector1, Vector2, Vector3};
use std::f64::consts::PI;

fn rest(distance: f64, limits: &AxisLimits) -> Result<AxisPlan, JerkError> {
    AxisPlan::new(&AxisState::default(), &AxisTarget { position: distance, ..AxisTarget::default() }, limits)
}

/// `Ta = V/A + A/J`, or `2 sqrt(V/J)`; `T = D/V + Ta`, or `A/J + sqrt((A/J)^2 + 4D/A)`, or `4 cbrt(D/2J)`.
fn closed_form(d: f64, v: f64, a: f64, j: f64) -> f64 {
    let ramp = if v >= a * a / j { v / a + a / j } else { 2.0 * (v / j).sqrt() };
    if d >= v * ramp {
        d / v + ramp
    } else if d >= 2.0 * a.powi(3) / j.powi(2) {
        a / j + ((a / j).powi(2) + 4.0 * d / a).sqrt()
    } else {
        4.0 * (d / (2.0 * j)).cbrt()
    }
}

#[test]
fn rest_to_rest_takes_the_closed_form_time() {
    let table = [
        (1.0, 1.0, 1.0, 1.0, 3.174_802_103_936),
        (1.0, 1.0, 1.0, 2.0, 2.561_552_812_809),
        (1.0, 0.6, 1.0, 2.0, 2.766_666_666_667),
        (1.0, 0.4, 1.0, 2.0, 3.394_427_191),
        (0.5, 1.0, 1.0, 10.0, 1.517_744_687_876),
        (2.0, 1.0, 4.0, 40.0, 2.35),
        (PI / 2.0, 2.5, 7.5, 50.0, 1.111_651_864_051),
    ];
    for (d, v, a, j, expected) in table {
        for sign in [1.0, -1.0] {
            let duration = rest(sign * d, &AxisLimits::symmetric(v, a, j)).unwrap().least();
            assert!((duration - expected).abs() < 1e-11, "{duration} {expected}");
            assert!((duration - closed_form(d, v, a, j)).abs() < 1e-13, "{duration} {expected}");
        }
    }
}

#[test]
fn all_phases_of_a_long_motion_are_those_of_the_book() {
    // 2 m at 1 m/s, 4 m/s^2, 40 m/s^3: ramps 0.1, 0.15, 0.1 s, cruise from 0.35 to 2.0 s.
    let profile = rest(2.0, &AxisLimits::symmetric(1.0, 4.0, 40.0)).unwrap().fastest();
    let at = |t: f64| profile.at(t);
    assert!((at(0.1).velocity - 0.2).abs() < 1e-14 && (at(0.1).position - 40.0 * 1e-3 / 6.0).abs() < 1e-14);
    assert!((at(0.2).acceleration - 4.0).abs() < 1e-13 && at(0.2).jerk == 0.0);
    assert!((at(1.175).velocity - 1.0).abs() < 1e-13 && (at(1.175).position - 1.0).abs() < 1e-13);
    assert!((at(2.3).acceleration + 40.0 * 0.05).abs() < 1e-12 && (at(2.3).jerk - 40.0).abs() < 1e-12);
    let peaks = profile.peaks();
    let expected =
        [(peaks.velocity, (1.0, 0.0)), (peaks.acceleration, (4.0, -4.0)), (peaks.jerk, (40.0, -40.0))];
    for ((high, low), (most, least)) in expected {
        assert!((high - most).abs() < 1e-12 && (low - least).abs() < 1e-12);
    }
    assert_eq!(at(9.0), AxisPoint { position: 2.0, ..AxisPoint::default() });
}

#[test]
fn from_rest_a_longer_duration_is_the_same_motion_slowed() {
    let plan =
        rest(1.0, &AxisLimits { min_acceleration: -0.5, ..AxisLimits::symmetric(1.0, 2.0, 9.0) }).unwrap();
    let (fast, slow) = (plan.fastest(), plan.lasting(3.0 * plan.least()).unwrap());
    for i in 0..=100 {
        let t = f64::from(i) * 0.01 * plan.least();
        assert!((slow.at(3.0 * t).position - fast.at(t).position).abs() < 1e-12);
        assert!((slow.at(3.0 * t).jerk * 27.0 - fast.at(t).jerk).abs() < 1e-10);
    }
    // Even with limits that differ by direction, an axis that has nowhere to go stays.
    let still =
        rest(0.0, &AxisLimits { min_velocity: -0.2, ..AxisLimits::symmetric(1.0, 1.0, 1.0) }).unwrap();
    assert_eq!((still.least(), still.lasting(2.0).unwrap().at(1.3).position), (0.0, 0.0));
}

#[test]
fn a_duration_between_going_straight_and_turning_round_is_refused() {
    // At 1 m/s with 1 m/s to arrive with: 1 s straight on; longer takes a detour with turns.
    let moving = AxisState { velocity: 1.0, ..AxisState::default() };
    let limits = AxisLimits::symmetric(1.5, 2.0, 10.0);
    let plan =
        AxisPlan::new(&moving, &AxisTarget { position: 0.01, velocity: 1.0, acceleration: 0.0 }, &limits)
            .unwrap();
    assert!(plan.least() < 0.01);
    let (from, until) = plan.blocked()[0];
    assert!(plan.least() <= from && until > 1.0, "{from} {until}");
    let refused = plan.lasting(0.5 * (from + until)).unwrap_err();
    assert_eq!(
        refused,
        JerkError::Duration { asked: 0.5 * (from + until), least: plan.least(), next: until }
    );
    assert!(plan.lasting(until).is_ok() && plan.lasting(from).is_ok());
}

#[test]
fn joints_from_rest_to_rest_move_along_a_straight_line() {
    let goal = Vector3::new(1.0, -0.4, 0.0);
    let limits = JointLimits {
        velocity: Vector3::repeat(0.8),
        acceleration: Vector3::new(3.0, 2.0, 1.0),
        jerk: Vector3::new(30.0, 20.0, 9.0),
    };
    let motion =
        SynchronisedMove::new(&JointState::rest(Vector3::zeros()), &JointTarget::rest(goal), &limits)
            .unwrap();
    assert!((motion.duration() - closed_form(1.0, 0.8, 3.0, 30.0)).abs() < 1e-12);
    for i in 0..=50 {
        let q = motion.at(f64::from(i) * 0.02 * motion.duration()).position;
        assert!((q - goal * q.x).norm() < 1e-15, "{q}");
    }
    assert_eq!(motion.at(motion.duration()).position, goal);
}

/// A profile from rest to rest in `k` times the time: velocities shrink by `k`, accelerations by `k^2`, jerks by `k^3`.
#[test]
fn joints_take_at_least_the_minimum_duration_and_go_along_the_same_path() {
    let start = JointState::rest(Vector3::new(0.1, 0.0, -0.3));
    let goal = Vector3::new(1.1, -0.4, -0.3);
    let limits = JointLimits {
        velocity: Vector3::repeat(0.8),
        acceleration: Vector3::new(3.0, 2.0, 1.0),
        jerk: Vector3::new(30.0, 20.0, 9.0),
    };
    let lasting =
        |minimum| SynchronisedMove::with_minimum_duration(&start, &JointTarget::rest(goal), &limits, minimum);
    let fastest = closed_form(1.0, 0.8, 3.0, 30.0);
    assert_eq!(lasting(0.5 * fastest).unwrap(), lasting(0.0).unwrap());
    let k = 2.5;
    let slow = lasting(k * fastest).unwrap();
    assert_eq!(slow.duration(), k * fastest);
    for (joint, displacement) in [(0, 1.0), (1, -0.4)] {
        let peaks = slow.peaks(joint).unwrap();
        let extreme = |(high, low): (f64, f64)| if displacement > 0.0 { high } else { low };
        assert!((extreme(peaks.velocity) - 0.8 * displacement / k).abs() < 1e-12, "{peaks:?}");
        assert!((extreme(peaks.acceleration) - 3.0 * displacement / (k * k)).abs() < 1e-12, "{peaks:?}");
        assert!((extreme(peaks.jerk) - 30.0 * displacement / (k * k * k)).abs() < 1e-12, "{peaks:?}");
    }
    assert_eq!(slow.at(0.5 * slow.duration()).position.z, -0.3);
    assert_eq!(slow.at(slow.duration()).position, goal);
    // What has nowhere to go stays for that time.
    let still =
        SynchronisedMove::with_minimum_duration(&start, &JointTarget::rest(start.position), &limits, 2.0);
    assert_eq!(still.unwrap().duration(), 2.0);
    for bad in [-1e-9, f64::NAN, f64::INFINITY] {
        assert!(matches!(lasting(bad), Err(JerkError::MinimumDuration(_))), "{bad}");
    }
}

/// At 1 m/s with 1 m/s to arrive with, as above: what is too long to go straight on is made long enough to turn round.
#[test]
fn a_minimum_duration_that_is_impossible_becomes_the_next_possible_one() {
    let one = Vector1::repeat(1.0);
    let start = JointState { velocity: one, ..JointState::rest(Vector1::zeros()) };
    let target = JointTarget { velocity: one, ..JointTarget::rest(one * 0.01) };
    let limits = JointLimits { velocity: one * 1.5, acceleration: one * 2.0, jerk: one * 10.0 };
    let axis = AxisPlan::new(
        &AxisState { velocity: 1.0, ..AxisState::default() },
        &AxisTarget { position: 0.01, velocity: 1.0, acceleration: 0.0 },
        &limits.axis(0),
    )
    .unwrap();
    let (from, until) = axis.blocked()[0];
    let motion =
        SynchronisedMove::with_minimum_duration(&start, &target, &limits, 0.5 * (from + until)).unwrap();
    assert_eq!(motion.duration(), until);
    // And where the end is to fall on a step as well, on the first one after that.
    let duration = MoveDuration { minimum: 0.5 * (from + until), step: Some(0.25) };
    let motion = SynchronisedMove::with_limits(&start, &target, |i| limits.axis(i), duration).unwrap();
    assert_eq!(motion.duration(), (until / 0.25).ceil() * 0.25);
}

#[test]
fn what_makes_no_plan_is_refused_with_its_numbers() {
    let good = AxisLimits::symmetric(1.0, 2.0, 10.0);
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for bad in [
            AxisLimits { max_velocity: value, ..good },
            AxisLimits { min_velocity: -value, ..good },
            AxisLimits { max_acceleration: value, ..good },
            AxisLimits { min_acceleration: -value, ..good },
            AxisLimits { jerk: value, ..good },
        ] {
            assert!(matches!(rest(1.0, &bad), Err(JerkError::Limit { .. })), "{bad:?}");
        }
        if value != 0.0 && value != -1.0 {
            assert!(matches!(rest(value, &good), Err(JerkError::NotFinite { name: "target position", .. })));
        }
    }
    let to = |velocity, acceleration| AxisTarget { position: 0.0, velocity, acceleration };
    let name = |target| match AxisPlan::new(&AxisState::default(), &target, &good) {
        Err(JerkError::Outside { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(name(to(1.1, 0.0)), "target velocity");
    assert_eq!(name(to(0.0, -2.1)), "target acceleration");
    // 0.95 + 1.5^2 / 20 = 1.0625 m/s when the acceleration was 0 last.
    assert_eq!(name(to(0.95, -1.5)), "velocity inevitable before the target");
    let steps = SynchronisedMove::in_whole_steps(
        &JointState::rest(Vector2::zeros()),
        &JointTarget::rest(Vector2::x()),
        &JointLimits {
            velocity: Vector2::repeat(1.0),
            acceleration: Vector2::repeat(1.0),
            jerk: Vector2::repeat(1.0),
        },
        0.0,
    );
    assert!(matches!(steps, Err(JerkError::Limit { name: "step", .. })));
}

#[test]
fn a_start_outside_the_limits_is_first_brought_back() {
    let limits = AxisLimits::symmetric(1.0, 2.0, 10.0);
    let from = |velocity, acceleration| {
        let start = AxisState { position: 0.0, velocity, acceleration };
        AxisPlan::new(&start, &AxisTarget::default(), &limits).unwrap()
    };
    // 1.1 m/s at -10 m/s^3: the limit is passed when 5 t^2 = 0.1.
    assert!((from(1.1, 0.0).recovery_time() - 0.02_f64.sqrt()).abs() < 1e-15);
    // 2.5 m/s^2 is 2 after 0.05 s; -3 is -2 after 0.1 s.
    assert!((from(0.0, 2.5).recovery_time() - 0.05).abs() < 1e-15);
    assert!((from(0.0, -3.0).recovery_time() - 0.1).abs() < 1e-15);
    // 3 m/s: -2 m/s^2 after 0.2 s at 2.8 m/s, then 0.9 s.
    assert!((from(3.0, 0.0).recovery_time() - 1.1).abs() < 1e-12);
    assert_eq!(from(1.0, -2.0).recovery_time(), 0.0);
}

#[test]
fn numbers_of_any_size_make_a_finite_plan_or_an_error() {
    let sizes = [0.0, 1e-300, 1e-100, 1e-15, 1e-3, 1.0, 1e6, 1e100, 1e300];
    let positive = &sizes[1..];
    for &distance in &sizes {
        for &v in positive {
            for &a in positive {
                for &j in positive {
                    let limits = AxisLimits::symmetric(v, a, j);
                    for velocity in [0.0, 0.5 * v, -v, 3.0 * v] {
                        let start = AxisState { position: -distance, velocity, acceleration: 0.0 };
                        let target = AxisTarget { position: distance, ..AxisTarget::default() };
                        let Ok(plan) = AxisPlan::new(&start, &target, &limits) else { continue };
                        let profile = plan.fastest();
                        let point = profile.at(0.5 * profile.duration());
                        let all =
                            [plan.least(), point.position, point.velocity, point.acceleration, point.jerk];
                        assert!(all.iter().all(|x| x.is_finite()), "{start:?} {target:?} {limits:?} {all:?}");
                    }
                }
            }
        }
    }
}

/// Ruckig's issue 160: a target 1e-15 away from the current state.
#[test]
fn a_target_a_rounding_away_is_reached() {
    let limits = AxisLimits::symmetric(2.0, 5.0, 50.0);
    for off in [0.0, 1e-17, 1e-15, -1e-15, 1e-12, -1e-9] {
        for position in [0.0, 0.5, -1234.5] {
            let start = AxisState { position, velocity: 0.0, acceleration: 0.0 };
            let plan = AxisPlan::new(
                &start,
                &AxisTarget { position: position + off, ..AxisTarget::default() },
                &limits,
            )
            .unwrap();
            assert!(plan.least() < 4.0 * (off.abs() / 100.0).cbrt() + 1e-3, "{}", plan.least());
        }
    }
}

/// At the limit of velocity an acceleration back from it means a velocity above it before, here by rounding.
#[test]
fn a_target_at_its_limit_of_velocity_is_reached_without_a_jump_in_any_duration() {
    let limits = AxisLimits {
        max_velocity: 1.5695956007051513,
        min_velocity: -1.198120458137013,
        max_acceleration: 0.15576363974363747,
        min_acceleration: -0.6311464394730779,
        jerk: 24.983536625768874,
    };
    let start = AxisState { position: 0.01, velocity: 0.64, acceleration: -0.25 };
    let target = AxisTarget { position: 0.968, velocity: limits.min_velocity, acceleration: 1.84e-5 };
    let plan = AxisPlan::new(&start, &target, &limits).unwrap();
    for share in 0..40 {
        let duration = plan.possible_from(plan.least() * (1.0 + 0.1 * f64::from(share)));
        let end = plan.lasting(duration).unwrap().at(duration * (1.0 - 1e-12));
        assert!((end.position - target.position).abs() < 1e-9, "{duration}: {end:?}");
    }
}
