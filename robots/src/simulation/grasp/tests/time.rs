//! The world's clock: driven by servo periods, whatever their order and their lengths.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use super::Bench;
use super::bench::at;
use crate::simulation::grasp::{Body, BodyState, Grasp, World};

const SWAY: f64 = 0.05;

/// Where a hand is at a time \[s\]: sways along y and z.
fn hand(x: f64, time: f64) -> Pose {
    at(x, SWAY * (1.0 - (2.0 * time).cos()), SWAY * (3.0 * time).sin().powi(2))
}

/// Carries a bar for a second with hands of these periods \[ms\], ticked as the EDPs of a cell are, those of one moment in
/// the order of the list or against it. Returns the body at each millisecond at which the world had come to it.
fn carried(periods: &[u64], reversed: bool) -> Vec<(f64, BodyState)> {
    let mut bench = Bench::new(World::new(&Body::block(2.0, [0.6, 0.1, 0.1])).expect("a body"));
    for (i, period) in periods.iter().enumerate() {
        let x = if i == 0 { -0.3 } else { 0.3 };
        bench = bench.with_hand_every(*period, Grasp::new(5e4, 500.0), hand(x, 0.0));
    }
    bench.close();
    let mut seen = Vec::new();
    let mut order: Vec<_> = (0..periods.len()).collect();
    if reversed {
        order.reverse();
    }
    for half in 1..2000_u64 {
        for &i in &order {
            // A hand of period p ticks at p / 2, 3 p / 2 ..
            if half % periods[i] == 0 && (half / periods[i]) % 2 == 1 {
                let end = (half + periods[i]) as f64 * 0.5e-3;
                bench.hands[i].0.begin();
                bench.hands[i].0.end(hand(if i == 0 { -0.3 } else { 0.3 }, end));
            }
        }
        seen.push((bench.world.time(), bench.world.body()));
    }
    seen
}

#[test]
fn the_order_of_ticks_of_one_moment_changes_nothing() {
    for periods in [[2, 2], [1, 2], [1, 3], [4, 1], [5, 1]] {
        let (one, other) = (carried(&periods, false), carried(&periods, true));
        // Within a moment the world may have gone on or not; a moment later it is the same to the bit.
        assert_eq!(one.last(), other.last(), "{periods:?}");
        let differing = one.iter().zip(&other).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "{periods:?}");
    }
}

#[test]
fn hands_of_several_periods_carry_the_body_along_one_path() {
    let reference = carried(&[1, 1], false);
    for periods in [[1, 2], [4, 1], [2, 4], [8, 1]] {
        let seen = carried(&periods, false);
        let (time, body) = seen.last().expect("a second");
        // The slowest hand's path is known up to the period that it is in.
        let slowest = *periods.iter().max().expect("two") as f64 * 1e-3;
        assert!(*time >= 1.0 - 2.0 * slowest, "{periods:?}: {time}");
        let (_, same) = reference.iter().find(|(t, _)| (t - time).abs() < 1e-9).expect("a millisecond");
        let off = (body.pose.translation.vector - same.pose.translation.vector).norm();
        // A path of acceleration a that is followed evenly for T is cut by a T^2 / 8 at most.
        let cut = SWAY * 18.0 * slowest * slowest;
        assert!(off < cut, "{periods:?}: {off} m, {cut} m");
    }
}

#[test]
fn an_arm_that_has_stopped_stands_and_the_world_goes_on() {
    let bench = Bench::new(World::new(&Body::block(2.0, [0.6, 0.1, 0.1])).expect("a body"))
        .with_hand(Grasp::new(5e4, 500.0), at(-0.3, 0.0, 0.0))
        .with_hand(Grasp::new(5e4, 500.0), at(0.3, 0.0, 0.0));
    bench.close();
    bench.run(0.1);
    let (first, second) = (&bench.hands[0].0, &bench.hands[1].0);
    for _ in 0..500 {
        first.begin();
        first.end(at(-0.3, 0.0, 0.0));
    }
    assert!((bench.world.time() - 1.098).abs() < 1e-9, "{}", bench.world.time());
    // It comes back where it stood, and now.
    second.begin();
    second.end(at(0.3, 0.0, 0.0));
    bench.run(2.0);
    assert!((bench.world.time() - 3.098).abs() < 2e-3 + 1e-9, "{}", bench.world.time());
    assert!((second.reaction().force.z + 9.80665).abs() < 1e-6, "{}", second.reaction().force);
}

#[test]
fn a_hand_that_is_led_at_constant_speed_leads_the_body_so() {
    let world = World::new(&Body::block(2.0, [0.2, 0.1, 0.1])).expect("a body");
    let bench = Bench::new(world).with_hand(Grasp::new(5e4, 500.0), at(0.0, 0.0, 0.0));
    bench.close();
    let (hand, speed) = (&bench.hands[0].0, Vector3::new(0.1, -0.2, 0.05));
    for k in 1..=2000 {
        hand.begin();
        hand.end(Pose::from_parts((speed * (2e-3 * f64::from(k))).into(), Default::default()));
    }
    assert!((bench.world.body().velocity - speed).amax() < 1e-9);
    assert!((hand.reaction().force + Vector3::z() * (2.0 * 9.80665)).amax() < 1e-6);
}
