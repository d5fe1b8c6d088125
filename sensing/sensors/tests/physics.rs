//! What barriers and triangulation sensors give.

use mrroc_sensors::physics::{LightBarrier, Stuck, Triangulation, code_of, distance_of};

use super::scene::{Block, across, cuboid};

const SPEED: f64 = 0.1;

/// The times at which the output changes while a block of 80 mm passes, sampled every 0.1 ms.
fn changes(barrier: &mut LightBarrier, speed: f64) -> Vec<f64> {
    let block = Block::new(cuboid([0.08, 0.05, 0.04]), move |t| speed * t - 0.06);
    let mut was = false;
    let mut changes = Vec::new();
    for i in 0..(0.12 / speed * 1e4) as u32 {
        let t = f64::from(i) * 1e-4;
        block.time.set(t);
        if barrier.sample(&block, &across(0.0, -0.3), t) != was {
            was = !was;
            changes.push(t);
        }
    }
    changes
}

#[test]
fn a_barrier_switches_where_its_threshold_is_covered_and_late_by_its_delay() {
    let mut barrier = LightBarrier::new(0.005, 1).switching_at(0.5, 0.0);
    let seen = changes(&mut barrier, SPEED);
    // Half of the beam is covered when an edge is in its middle; hysteresis is 0.5 % of its area, 0.02 mm.
    for (time, expected) in seen.iter().zip([0.02 / SPEED, 0.1 / SPEED]) {
        assert!(
            (time - expected - LightBarrier::DELAY).abs() < LightBarrier::JITTER + 3e-4,
            "{time} for {expected}"
        );
    }
    assert_eq!(seen.len(), 2);
}

#[test]
fn a_threshold_off_the_half_moves_both_edges_by_what_the_beam_says() {
    let mut barrier = LightBarrier::new(0.005, 1).switching_at(0.55, 0.0);
    let seen = changes(&mut barrier, SPEED);
    // 55 % of a disc are covered when the edge is 0.0787 radii beyond its middle: later at the front, earlier at the back.
    let off = 0.0787 * 0.0025 / SPEED;
    let length = (seen[1] - seen[0]) * SPEED;
    assert!((length - (0.08 - 2.0 * off * SPEED)).abs() < 8e-5, "{length}");
}

#[test]
fn noise_makes_a_slow_edge_chatter() {
    let mut barrier = LightBarrier::new(0.005, 2);
    let seen = changes(&mut barrier, 0.016);
    assert!(seen.len() > 4, "{} changes", seen.len());
}

#[test]
fn a_barrier_that_is_stuck_says_the_same_whatever_passes() {
    let mut barrier = LightBarrier::new(0.005, 3);
    barrier.fail(0.0, Stuck::Open);
    assert_eq!(changes(&mut barrier, SPEED), []);
    barrier.fail(0.0, Stuck::Covered);
    assert_eq!(changes(&mut barrier, SPEED).len(), 1);
}

#[test]
fn the_curve_is_that_of_the_measured_sensor_and_its_own_inverse() {
    // 4835 / 20 + 28.76 at 20 cm.
    assert!((code_of(0.2) - 270.51).abs() < 1e-9);
    for mm in [90, 150, 300, 800] {
        let distance = f64::from(mm) * 1e-3;
        assert!((distance_of(code_of(distance)) - distance).abs() < 1e-12);
    }
    assert!(distance_of(0.0).is_infinite());
    // Too near, it seems to be far.
    assert!(distance_of(code_of(0.04)) > 0.15);
}

#[test]
fn a_triangulation_sensor_gives_a_new_value_every_38_ms_and_sees_the_near_side() {
    let block = Block::new(cuboid([0.08, 0.05, 0.04]), |t| 0.02 * t - 0.2).at_y(0.01);
    let mut sensor = Triangulation::new(0.5, 4).with_noise(2.0, 0.0);
    let mut values = Vec::new();
    for i in 0..=10_000_u32 {
        block.time.set(f64::from(i) * 2e-3);
        let value = sensor.sample(&block, &across(0.0, -0.25));
        if values.last() != Some(&value) {
            values.push(value);
        }
    }
    assert!(values.windows(2).skip(1).all(|w| (w[1].0 - w[0].0 - Triangulation::UPDATE).abs() < 1e-9));
    // Its side is at -0.015, 0.235 m away, from 8 s to 12 s. Nothing: 0.5 m.
    let mean = |from: f64, to: f64| {
        let of: Vec<f64> = values.iter().filter(|v| v.0 > from && v.0 < to).map(|v| f64::from(v.1)).collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    // 100 values of 2 codes: 0.2; four of them.
    assert!((mean(8.1, 12.0) - code_of(0.235)).abs() < 0.8, "{}", mean(8.1, 12.0));
    assert!((mean(1.0, 7.9) - code_of(0.5)).abs() < 0.8, "{}", mean(1.0, 7.9));
}
