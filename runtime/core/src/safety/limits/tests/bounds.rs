//! The very bounds: the last value that is taken and the first one that is refused.

use nalgebra::{Translation3, UnitQuaternion};

use super::*;
use crate::model::robot::POSITION_ROUND_OFF;
use crate::safety::braking::stopping_distance;

/// The check of a state whose velocity and acceleration are as they are given.
fn check(acceptor: &Acceptor<Turntable>, q: Two, v: Two, a: Two) -> Result<(), FaultKind> {
    acceptor.check(&q, &v, &v, &a, T).map(|_| ()).map_err(|fault| fault.kind())
}

const ZERO: Two = Two::new(0.0, 0.0);

#[test]
fn fault_21_a_velocity_is_taken_up_to_the_limit_and_round_off() {
    let fast = |limit: f64| {
        acceptor(Turntable::with(|l| {
            l.velocity = Two::repeat(limit);
            l.acceleration = Two::repeat(1e9);
            (l.lower, l.upper) = (Two::repeat(-100.0), Two::repeat(100.0));
        }))
    };
    let velocity = |limit: f64, q: f64, v: f64| check(&fast(limit), Two::new(0.0, q), Two::new(0.0, v), ZERO);
    // 1e-9 of the limit, at 100 rad/s; the round-off of the difference, 1e-12 in 1 ms, is a hundredth of that.
    for sign in [1.0, -1.0] {
        assert_eq!(velocity(100.0, 0.0, sign * (100.0 + 0.9e-7)), Ok(()));
        assert_eq!(velocity(100.0, 0.0, sign * (100.0 + 1.1e-7)), Err(FaultKind::DemandedVelocity));
    }
    // At 1 rad/s both are 1e-9; the round-off grows with a position beyond 1.
    assert_eq!(velocity(1.0, 0.5, 1.0 + 1.9e-9), Ok(()));
    assert_eq!(velocity(1.0, 0.5, 1.0 + 2.1e-9), Err(FaultKind::DemandedVelocity));
    assert_eq!(velocity(1.0, 50.0, 1.0 + 5.0e-8), Ok(()));
    assert_eq!(velocity(1.0, 50.0, 1.0 + 5.2e-8), Err(FaultKind::DemandedVelocity));
    // At the bound is within it.
    assert_eq!(velocity(1.0, 0.5, 1.0 * (1.0 + RELATIVE) + POSITION_ROUND_OFF * T.recip()), Ok(()));
}

#[test]
fn fault_22_only_the_first_demand_of_a_robot_at_rest_is_a_wrong_start() {
    let mut acceptor = acceptor(Turntable::new());
    let kind = |acceptor: &mut Acceptor<Turntable>, demand| {
        acceptor.accept(&demand, T, T).map(|_| ()).map_err(|fault| fault.kind())
    };
    assert_eq!(kind(&mut acceptor, joints(0.5, 0.0)), Err(FaultKind::DemandedVelocity));
    acceptor.begin();
    let fault = acceptor.accept(&joints(0.0, 0.5), T, T).expect_err("a jump");
    assert_eq!((fault.kind(), fault.joint()), (FaultKind::StartPoseMismatch, Some(1)));
    // 0.5 rad where 1 rad/s allows 1e-3 rad in 1 ms.
    let excess = fault.excess().expect("a jump and its limit");
    near(excess.actual, 0.5);
    near(excess.limit, 1e-3);
    assert_eq!(excess.unit, "rad");
    acceptor.accept(&joints(5e-6, 0.0), T, T).expect("slow");
    acceptor.begin();
    assert_eq!(kind(&mut acceptor, joints(0.5, 0.0)), Err(FaultKind::DemandedVelocity));
}

#[test]
fn fault_21_an_acceleration_is_taken_up_to_the_limit_and_round_off() {
    let acceleration = |a: f64| check(&acceptor(Turntable::new()), ZERO, ZERO, Two::new(a, 0.0));
    // Of 10 m/s² 1e-8; of four positions in 1 ms, twice differenced, 4e-6.
    for sign in [1.0, -1.0] {
        assert_eq!(acceleration(sign * (10.0 + 3.9e-6)), Ok(()));
        assert_eq!(acceleration(sign * (10.0 + 4.1e-6)), Err(FaultKind::DemandedAcceleration));
    }
    let per_second = T.recip();
    let bound = 10.0 * (1.0 + RELATIVE) + 4.0 * POSITION_ROUND_OFF * per_second * per_second;
    assert_eq!(acceleration(bound), Ok(()));
}

#[test]
fn fault_21_a_jerk_is_taken_up_to_the_limit_and_round_off() {
    let jerk = |jerk: f64| {
        let mut acceptor = acceptor(Turntable::with_jerk(1000.0, 1000.0));
        acceptor.state.acceleration = Two::new(0.0, 3.0);
        check(&acceptor, ZERO, ZERO, Two::new(0.0, 3.0 + jerk * T))
    };
    // Of 1000 rad/s³ 1e-6; of eight positions in 1 ms, three times differenced, 8e-3.
    for sign in [1.0, -1.0] {
        assert_eq!(jerk(sign * (1000.0 + 7.9e-3)), Ok(()));
        assert_eq!(jerk(sign * (1000.0 + 8.1e-3)), Err(FaultKind::DemandedJerk));
    }
    // The bound itself, in a step of which there are a power of two in a second: no division rounds it.
    let bound = 1000.0 * (1.0 + RELATIVE) + 8.0 * POSITION_ROUND_OFF * 1024.0 * 1024.0 * 1024.0;
    let a = Two::new(bound / 1024.0, 0.0);
    let acceptor = acceptor(Turntable::with_jerk(1000.0, 1000.0));
    acceptor.check(&ZERO, &ZERO, &ZERO, &a, 1024.0_f64.recip()).expect("at the bound is within it");
}

#[test]
fn fault_20_a_position_is_taken_up_to_the_limit_and_round_off() {
    let robot = || Turntable::with(|l| (l.lower, l.upper) = (Two::repeat(-0.5), Two::repeat(0.5)));
    let at = |q: f64, v: f64| {
        let mut acceptor = acceptor(robot());
        acceptor.checks.reaction = 0.0;
        check(&acceptor, Two::new(q, 0.0), Two::new(v, 0.0), ZERO)
    };
    for sign in [1.0, -1.0] {
        assert_eq!(at(sign * (0.5 + 0.9e-12), 0.0), Ok(()));
        assert_eq!(at(sign * (0.5 + 1.1e-12), 0.0), Err(FaultKind::DemandOutOfRange));
        // The bound itself, of the position and of where it stops: v²/2a = 1/80 m at 0.5 m/s.
        let bound = 0.5 + POSITION_ROUND_OFF;
        assert_eq!(at(sign * bound, 0.0), Ok(()));
        assert_eq!(at(sign * (bound - 0.0125), sign * 0.5), Ok(()));
        assert_eq!(at(sign * (bound - 0.0124), sign * 0.5), Err(FaultKind::DemandOutOfRange));
        // On the return it stops anywhere.
        assert_eq!(at(sign * bound, -sign * 0.5), Ok(()));
        // Also where its path has come to rest.
        let (q, v) = (Two::new(sign * bound, 0.0), Two::new(-sign * 0.5, 0.0));
        acceptor(robot()).check(&q, &v, &ZERO, &ZERO, T).expect("away from the limit");
        // Out of range is out of range, on the return as well.
        assert_eq!(at(sign * 0.51, -sign * 0.5), Err(FaultKind::DemandOutOfRange));
    }
}

#[test]
fn fault_85_a_joint_that_stands_outside_of_its_range_may_come_back_and_nothing_else() {
    for sign in [1.0, -1.0] {
        let outside = Two::new(sign * (1.0 + 67e-6), 0.0);
        let mut acceptor = Acceptor::new(Turntable::new(), Pose::identity(), outside, REACTION);
        acceptor.begin();
        let at = |q: f64| joints(sign * q, 0.0);
        let refused = acceptor.accept(&at(1.0 + 68e-6), T, T).map(|_| ()).map_err(|fault| fault.kind());
        assert_eq!(refused, Err(FaultKind::DemandOutOfRange));
        acceptor.accept(&at(1.0 + 67e-6), T, T).expect("where it is");
        // At 9 m/s² inwards: inside after the fourth step.
        let mut q = 1.0 + 67e-6;
        for step in 1..=10 {
            q -= 9e-6 * f64::from(step);
            acceptor.accept(&at(q), T, T).unwrap_or_else(|fault| panic!("step {step}: {fault}"));
        }
        assert!(q < 1.0);
        // From there its range is what it is for any other.
        let mut acceptor = Acceptor::new(Turntable::new(), Pose::identity(), Two::new(sign, 0.0), REACTION);
        acceptor.begin();
        let refused = acceptor.accept(&at(1.0 + 1e-6), T, T).map(|_| ()).map_err(|fault| fault.kind());
        assert_eq!(refused, Err(FaultKind::DemandOutOfRange));
    }
}

#[test]
fn fault_20_a_joint_stops_before_its_limit_when_its_demands_are_lost() {
    // 0.6 m/s of 10 m/s² is longest: all brake in 60 ms, after 21 ms. From the velocity that is held then.
    let acceptor = acceptor(Turntable::new());
    let stop = acceptor
        .check(&Two::new(0.1, 0.2), &Two::new(0.5, -0.3), &Two::new(0.6, -0.2), &ZERO, T)
        .expect("in range");
    both(&stop.position, [0.1 + 0.6 * (0.021 + 0.03), 0.2 - 0.3 * (0.021 + 0.03)]);
    near(stop.time, 0.021 + 0.03);
    let stop = acceptor.check(&Two::new(0.1, 0.2), &ZERO, &ZERO, &ZERO, T).expect("at rest");
    assert_eq!((stop.position, stop.time), (Two::new(0.1, 0.2), 0.0));
}

#[test]
fn fault_20_a_joint_with_a_jerk_limit_stops_before_its_limit_when_its_demands_are_lost() {
    // 0.1 m/s at 4 m/s² is 0.106 m/s when the acceleration has faded by 1000 m/s³: by 3, 2, 1 and 0 mm/s in the next steps.
    let mut acceptor = acceptor(Turntable::with_jerk(1000.0, 1000.0));
    let mut stop = |v: f64, a: f64| {
        acceptor.state.acceleration = Two::new(a, 0.0);
        acceptor.check(&ZERO, &Two::new(v, 0.0), &ZERO, &Two::new(a, 0.0), T).expect("in range")
    };
    for (v, a, lost) in [(0.1, 4.0, 0.106), (-0.1, -4.0, 0.106), (0.1, -4.0, 0.1), (0.1, 0.0, 0.1)] {
        let distance = stopping_distance(v, a, 10.0, 1000.0, T) + lost * REACTION;
        near(stop(v, a).position[0], distance.copysign(v));
        near(stop(v, a).time, distance / lost);
    }
    // It reaches 10 m/s² only if v > a²/j = 0.1 m/s: at 0.05 m/s it takes 2 sqrt(v/j), v sqrt(v/j) far.
    near(stop(0.05, 0.0).position[0], 0.05 * (0.05_f64 / 1000.0).sqrt() + 0.05 * REACTION);
    // -2 mm/s at 4 m/s² turn into 4 mm/s in the other direction.
    near(stop(-0.002, 4.0).position[0], 0.004 * (0.004_f64 / 1000.0).sqrt() + 0.004 * REACTION);
}

#[test]
fn fault_20_a_joint_that_turns_round_goes_on_until_its_acceleration_has_gone() {
    // At rest with -50 m/s², which is let go of by 1000 m/s³ in 50 steps: it comes to 49 + 48 + .. + 1 m/s² T.
    let robot = Turntable::with(|limits| {
        limits.jerk = Some(Two::repeat(1000.0));
        (limits.acceleration, limits.velocity) = (Two::repeat(50.0), Two::repeat(2.0));
    });
    let mut acceptor = acceptor(robot);
    let a = Two::new(-50.0, 0.0);
    acceptor.state.acceleration = a;
    let kept = 49.0 * 50.0 / 2.0 * T;
    let distance = stopping_distance(kept, 0.0, 50.0, 1000.0, T) + kept * 50.0 * T;
    let stop = acceptor.check(&Two::new(0.9, 0.0), &ZERO, &ZERO, &a, T).expect("in range");
    near(stop.position[0], 0.9 - distance);
    // And so it does, when it brakes.
    let room = distance - 1.0;
    acceptor.check(&Two::new(room, 0.0), &ZERO, &ZERO, &a, T).expect("as far as the limit");
    acceptor.state.position = Two::new(room, 0.0);
    let mut braking = acceptor.braking();
    let mut lowest = room;
    while !braking.is_over() {
        acceptor.brake(&mut braking, T);
        lowest = lowest.min(acceptor.state.position[0]);
    }
    assert!((-1.0..room - 0.05).contains(&lowest), "{lowest} from {room}");
    let refused = acceptor.check(&Two::new(room - 1e-6, 0.0), &ZERO, &ZERO, &a, T);
    assert_eq!(refused.map(|_| ()).map_err(|fault| fault.kind()), Err(FaultKind::DemandOutOfRange));
}

#[test]
fn fault_21_a_velocity_that_no_jerk_within_the_limit_can_keep_below_its_limit_is_refused() {
    // Letting 8 m/s² go by 1000 m/s³ adds 7 + 6 + .. + 1 = 28 mm/s in steps of 1 ms: 0.972 m/s may have them, no more.
    let mut acceptor = acceptor(Turntable::with_jerk(1000.0, 1000.0));
    for sign in [1.0, -1.0] {
        let mut at = |v: f64, a: f64| {
            let (v, a) = (Two::new(sign * v, 0.0), Two::new(sign * a, 0.0));
            acceptor.state.acceleration = a;
            acceptor.check(&ZERO, &v, &ZERO, &a, T).map(|_| ()).map_err(|fault| fault.to_string())
        };
        assert_eq!(at(0.972, 8.0), Ok(()));
        let refused = at(0.973, 8.0).expect_err("1.001 m/s");
        assert!(refused.contains("by the time that its acceleration is taken away"), "{refused}");
        assert_eq!(at(0.973, -8.0), Ok(()));
        assert_eq!(at(1.0, 0.9), Ok(()));
    }
}

#[test]
fn fault_20_no_joint_leaves_its_range_whatever_it_does_when_its_demands_are_lost() {
    let speeds = [-0.3_f64, -0.02, -0.01, -1e-3, 0.0, 1e-3, 0.01, 0.02, 0.3];
    let (mut kept, mut refused) = (0, 0);
    for jerk in [None, Some(1000.0), Some(5000.0)] {
        let robot = Turntable::with(|limits| limits.jerk = jerk.map(Two::repeat));
        for (v, w) in speeds.into_iter().flat_map(|v| speeds.map(|w| (v, w))) {
            // With a jerk limit the acceleration matters, without one the path's own velocity.
            let (held, a) =
                if jerk.is_some() { (v, w.signum() * 10.0 * (w / 0.3).abs().sqrt()) } else { (w, 0.0) };
            for inwards in [0.0, 1e-5, 1e-4, 2e-4, 3e-4, 1e-3, 0.006, 0.012, 0.02] {
                for q in [1.0 - inwards, inwards - 1.0] {
                    let mut acceptor = Acceptor::new(robot.clone(), Pose::identity(), ZERO, REACTION);
                    let [q, v, held, a] = [q, v, held, a].map(|x| Two::new(x, 0.0));
                    acceptor.state.acceleration = a;
                    if acceptor.check(&q, &v, &held, &a, T).is_err() {
                        refused += 1;
                        continue;
                    }
                    kept += 1;
                    (acceptor.state.position, acceptor.track.path.position, acceptor.pace.period) = (q, q, T);
                    (acceptor.state.velocity, acceptor.track.path.velocity) = (v, held);
                    for _ in 0..20 {
                        let _ = acceptor.extrapolate(T);
                    }
                    let mut braking = acceptor.braking();
                    while !braking.is_over() {
                        acceptor.brake(&mut braking, T);
                    }
                    let end = acceptor.state.position[0];
                    assert!(end.abs() <= 1.0 + 1e-9, "{end} from {q} by {v}, {held}, {a} of {jerk:?}");
                }
            }
        }
    }
    assert!(kept > 500 && refused > 500, "{kept} {refused}");
}

#[test]
fn limits_that_joints_share_are_checked_at_the_demand_and_where_the_robot_would_stand() {
    let mut acceptor = acceptor(Turntable { sum: 0.5, ..Turntable::new() });
    (acceptor.state.position, acceptor.state.velocity) = (Two::new(0.2, 0.28), Two::new(0.5, 0.0));
    acceptor.track.path.position = acceptor.state.position;
    let fault = acceptor.accept(&joints(0.2005, 0.28), T, T).expect_err("0.5 m/s takes 23 mm");
    // v²/2a = 12.5 mm, and 21 ms.
    let excess = fault.excess().expect("a sum");
    near(excess.actual, 0.2005 + 0.0125 + 0.5 * REACTION + 0.28);
    assert_eq!((fault.kind(), fault.message(), excess.limit), (FaultKind::DemandOutOfRange, "sum", 0.5));
    // One that stands needs no distance to stop, and is checked all the same.
    let mut acceptor = self::acceptor(Turntable { sum: 0.5, ..Turntable::new() });
    (acceptor.state.position, acceptor.track.path.position) = (Two::new(0.25, 0.25), Two::new(0.25, 0.25));
    acceptor.accept(&joints(0.25, 0.25), T, T).expect("at the limit");
    acceptor.checks.robot.sum = 0.4;
    acceptor.accept(&joints(0.25, 0.25), T, T).expect_err("beyond it");
}

#[test]
fn fault_18_numbers_of_frames_are_finite() {
    let mut pose = Pose::identity();
    pose.translation.x = f64::INFINITY;
    assert_eq!(valid_frame(&pose).map_err(|fault| fault.kind()), Err(FaultKind::DemandNotFinite));
    let fault = acceptor(Turntable::new()).accept(&joints(0.0, f64::NAN), T, T).expect_err("no number");
    assert_eq!((fault.kind(), fault.joint()), (FaultKind::DemandNotFinite, Some(1)));
}

#[test]
fn fault_19_a_frame_is_taken_normalised_up_to_the_tolerance() {
    let turned = UnitQuaternion::from_scaled_axis(nalgebra::Vector3::new(0.1, 0.2, 0.3));
    let scaled = |by: f64| {
        let rotation = UnitQuaternion::new_unchecked(turned.into_inner() * by);
        valid_frame(&Pose::from_parts(Translation3::new(1.0, 2.0, 3.0), rotation))
    };
    for sign in [1.0, -1.0] {
        let pose = scaled(1.0 + sign * 0.9e-6).expect("round-off");
        assert!((pose.rotation.coords - turned.coords).norm() < 1e-15 && pose.translation.z == 3.0);
        let fault = scaled(1.0 + sign * 1.1e-6).expect_err("no rotation");
        assert_eq!(fault.kind(), FaultKind::DemandInvalidFrame);
        assert!((fault.excess().expect("a norm").actual - 1.1e-6).abs() < 1e-12, "{fault}");
    }
}

#[test]
fn a_displacement_between_two_demands_is_as_fast_as_a_joint_may_be() {
    let acceptor = acceptor(Turntable::with(|l| l.velocity = Two::new(1.0, 100.0)));
    let check = |first: f64, second: f64| acceptor.check_displacement(&Two::new(first * T, second * T), T);
    // 1e-9 of 100 rad/s; at 1 m/s as much again for the round-off of 1e-12 m in 1 ms.
    for sign in [1.0, -1.0] {
        check(sign * (1.0 + 1.9e-9), sign * (100.0 + 0.9e-7)).expect("as fast as it may be");
        assert_eq!(check(sign * (1.0 + 2.1e-9), 0.0).expect_err("too fast").joint(), Some(0));
        let fault = check(0.0, sign * (100.0 + 1.1e-7)).expect_err("too fast");
        assert_eq!((fault.kind(), fault.joint()), (FaultKind::DemandedVelocity, Some(1)));
        assert!(fault.excess().is_some_and(|excess| excess.limit == 100.0 && excess.unit == "rad/s"));
    }
    check(f64::NAN, 0.0).expect_err("no number");
}

#[test]
fn a_state_that_is_well_within_all_limits_is_found_sound_by_a_closer_look_and_stands_at_the_same_place() {
    let robot = Turntable::new();
    let Limits { velocity, acceleration, .. } = robot.limits;
    let checks = Checks { robot, reaction: REACTION };
    let mut x = 0.5_f64;
    // A sequence in -size..size that does not repeat soon.
    let mut draw = |size: Two| {
        Two::from_fn(|i, _| {
            x = (x + 0.618_033_988_749_894_9).fract();
            size[i] * ((x * 97.0).fract() * 2.0 - 1.0)
        })
    };
    let mut counts = (0, 0);
    for _ in 0..20_000 {
        let (q, v) = (draw(Two::repeat(1.02)), draw(velocity * 1.02));
        let (held, a) = (draw(velocity * 1.02), draw(acceleration * 1.02));
        let from = JointState { position: q - v * T, velocity: v - a * T, acceleration: Two::zeros() };
        let next = Proposed { position: &q, velocity: &v, held: &held, acceleration: &a };
        let closer = checks.look_closer(&next, &CheckedStep { from: &from, duration: T, starting: false });
        let Some(stop) = checks.well_within(&next) else {
            counts.1 += usize::from(closer.is_ok());
            continue;
        };
        counts.0 += 1;
        let closer = closer.expect("it is well within");
        assert_eq!(stop.position, closer.position);
        assert!((stop.time - closer.time).abs() <= 1e-15 * stop.time, "{} and {}", stop.time, closer.time);
    }
    assert!(counts.0 > 4_000, "{counts:?}");
    // Where only one of the two velocities is bounded, or the longer distance is the other one's, it takes a closer look.
    assert!(counts.1 > 100, "{counts:?}");
}
