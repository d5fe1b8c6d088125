//! Physics and aggregation together, as virtual sensors without a cell.

use mrroc::prelude::*;
use mrroc_sensors::aggregation::Laterals;
use mrroc_sensors::physics::{LightBarrier, Stuck, Triangulation};
use mrroc_sensors::virtual_sensors::{AcrossReading, GateReading, GateSensor, RangeFinder};

use super::scene::{Block, across, cuboid};

const STEP: f64 = 4e-3;
const SPACING: f64 = 0.15;

fn order(step: u64) -> ReadingOrder<()> {
    ReadingOrder { configuration: (), robot: None, step }
}

fn gate(block: &Block, seed: u64) -> GateSensor<Block> {
    let barriers = [LightBarrier::new(0.005, seed), LightBarrier::new(0.005, seed + 1)];
    GateSensor::new(block.clone(), [across(0.0, -0.3), across(SPACING, -0.3)], barriers, STEP)
}

/// What the gate says in the step at `end` \[s\], asked in every step.
fn read(block: &Block, gate: &mut GateSensor<Block>, end: f64) -> GateReading {
    let steps = (end / STEP) as u64;
    let mut reading = GateReading::default();
    for step in 0..=steps {
        block.time.set(step as f64 * STEP);
        reading = gate.aggregate(&order(step)).expect("a reading");
    }
    reading
}

#[test]
fn speed_length_and_place_are_those_of_the_block_for_all_seeds_and_speeds() {
    for seed in 0..20 {
        let speed = 0.016 + 0.0082 * seed as f64;
        let length = 0.06 + 0.002 * seed as f64;
        let block = Block::new(cuboid([length, 0.05, 0.04]), move |t| speed * t - 0.1);
        let mut gate = gate(&block, seed);
        let end = 0.5 / speed;
        let seen = read(&block, &mut gate, end);
        assert_eq!((seen.parts, seen.dropped), (1, 0), "{speed} m/s");
        // Thresholds 5 % off and noise of 1 %, of a beam of 5 mm: 0.2 mm at an edge; 2 ms of sampling.
        assert!((seen.speed / speed - 1.0).abs() < 0.006, "{} of {speed}", seen.speed);
        assert!((seen.length - length).abs() < 1e-3, "{} of {length}", seen.length);
        let truth = speed * block.time.get() - 0.1 - SPACING;
        assert!((seen.place(0.0) - truth).abs() < 2e-3, "{} of {truth}", seen.place(0.0));
    }
}

#[test]
fn a_block_that_lies_askew_is_longer_by_what_its_width_adds() {
    let turn = 3.0_f64.to_radians();
    let block = Block::new(cuboid([0.08, 0.05, 0.04]), |t| 0.1 * t - 0.1).turned(turn);
    let seen = read(&block, &mut gate(&block, 7), 5.0);
    let expected = 0.08 * turn.cos() + 0.05 * turn.sin();
    assert!((seen.length - expected).abs() < 8e-4, "{} of {expected}", seen.length);
}

#[test]
fn a_dead_barrier_lets_no_part_pass() {
    for number in [0, 1] {
        for stuck in [Stuck::Open, Stuck::Covered] {
            let block = Block::new(cuboid([0.08, 0.05, 0.04]), |t| 0.1 * t - 0.1);
            let mut gate = gate(&block, 3);
            gate.barrier(number).fail(0.0, stuck);
            assert_eq!(read(&block, &mut gate, 5.0).parts, 0, "{number} {stuck:?}");
        }
    }
}

#[test]
fn a_range_finder_tells_where_blocks_lie_across() {
    for (seed, y) in [(1, -0.02), (2, 0.0), (3, 0.02)] {
        let block = Block::new(cuboid([0.08, 0.05, 0.04]), |t| 0.1 * t - 0.2).at_y(y);
        let sensor = Triangulation::new(0.5, seed);
        let laterals = Laterals::new(0.1, 0.32, 70.0);
        let mut finder = RangeFinder::new(block.clone(), across(0.0, -0.25), sensor, laterals, STEP);
        let mut seen = AcrossReading::default();
        for step in 0..1000 {
            block.time.set(step as f64 * STEP);
            seen = finder.aggregate(&order(step)).expect("a reading");
        }
        // About 20 values of 2 codes at 0.0077 codes per mm and less: 3 mm / sqrt(20) and what the median costs, four of them.
        let off = seen.distance - (0.25 + y - 0.025);
        assert!(
            seen.parts == 1 && seen.values > 15 && off.abs() < 4.0 * 1.25 * 3.4e-3 / 20.0_f64.sqrt(),
            "{off} m"
        );
        // It left after 2.4 s, 0.8 s the sensor saw it.
        assert!((seen.since - (999.0 * STEP - 2.4)).abs() < 2.0 * Triangulation::UPDATE, "{}", seen.since);
    }
}
