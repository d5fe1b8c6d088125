//! Demands that come after or before their steps: the robot goes on along its path, within the limits, and ends where it ends.

use super::late::{Quintic, Trajectory};
use super::*;
use crate::safety::limits::catching_up::FARTHEST;

/// Follows the path, where the demand of step `k` comes `late(k)` steps late, in the order of their steps; returns how far from
/// the path the robot was at most \[m\], and where it ended.
fn go(path: &impl Trajectory, late: impl Fn(i64) -> i64) -> Result<(f64, Two), Fault> {
    let mut acceptor = acceptor(Turntable::new());
    let last = (path.duration() / T).ceil() as i64;
    let (mut next, mut off, mut before) = (1, 0.0_f64, (Two::zeros(), Two::zeros()));
    for step in 1..last + 400 {
        let mut accepted = false;
        while next <= last && next + late(next) <= step {
            let demand = Demand::joints(path.at(next as f64 * T));
            let behind = step - i64::from(!accepted) - next;
            if behind == -1 && !accepted {
                acceptor.accept(&demand, T, T)?;
                accepted = true;
            } else {
                acceptor.hear(&demand, T, T, behind as f64)?;
            }
            next += 1;
        }
        if next > last && !accepted {
            acceptor.hold(T)?;
        } else if !accepted && acceptor.go_on_along_path(T).is_none() {
            acceptor.extrapolate(T);
        }
        let (q, velocity) = acceptor.accepted();
        let acceleration = (velocity - before.1) / T;
        assert!((q - before.0 - velocity * T).amax() < 1e-12, "step {step}");
        for (i, limit) in [10.0, 20.0].into_iter().enumerate() {
            assert!(velocity[i].abs() <= 1.0 + 1e-9, "{velocity} in step {step}");
            assert!(acceleration[i].abs() <= limit + 1e-4, "{acceleration} in step {step}");
        }
        before = (q, velocity);
        off = off.max((q - path.at(step as f64 * T)).amax());
    }
    Ok((off, before.0))
}

/// Its acceleration is 10/√3 length/duration² at most: half of the limit.
fn path() -> Quintic {
    Quintic { length: 5.0 * 0.09 * 3.0_f64.sqrt() / 10.0, duration: 0.3 }
}

#[test]
fn fault_152_a_path_whose_demands_are_all_late_is_gone_along_and_ends_where_it_ends() {
    let path = path();
    for n in 0..=15 {
        let (off, end) = go(&path, |_| n).unwrap_or_else(|fault| panic!("{n} steps late: {fault}"));
        let t = (n + 2) as f64 * T;
        assert!(end == path.at(1.0) && off <= FARTHEST * 10.0 * t * t, "{n} steps late: {off} m off, {end}");
    }
}

#[test]
fn fault_152_a_delay_that_jumps_up_or_down_in_any_step_changes_nothing_of_where_a_path_ends() {
    let path = path();
    for (n, jumps) in [2, 7, 15].into_iter().flat_map(|n| (3..300).step_by(11).map(move |jumps| (n, jumps))) {
        // Later from then on; or earlier, of a node that has gone by late ones before.
        for [before, after] in [[0, n], [0, -n], [n, 0]] {
            let went = go(&path, |k| if k < jumps { before } else { after });
            let (off, end) = went.unwrap_or_else(|fault| panic!("{before} to {after} in {jumps}: {fault}"));
            let t = (n + 2) as f64 * T;
            assert!(end == path.at(1.0), "{before} to {after} in {jumps}: {end}");
            assert!(off <= FARTHEST * 10.0 * t * t, "{before} to {after} in {jumps}: {off} m off");
        }
    }
}

#[test]
fn fault_152_demands_that_come_by_chance_up_to_fifteen_steps_late_lead_to_the_same_end() {
    let path = path();
    for seed in 1..=40_u64 {
        let chance = |k: i64| {
            let mut x = (k as u64 + 1).wrapping_mul(seed).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            x ^= x >> 29;
            (x.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32) as i64 % 16
        };
        let (_, end) = go(&path, chance).unwrap_or_else(|fault| panic!("seed {seed}: {fault}"));
        assert_eq!(end, path.at(1.0), "seed {seed}");
    }
}

#[test]
fn a_demand_that_is_not_newer_than_what_is_known_says_nothing() {
    let mut acceptor = acceptor(Turntable::new());
    acceptor.accept(&joints(1e-6, 0.0), T, T).expect("slow");
    let before = acceptor.demanded();
    assert!(!acceptor.hear(&joints(9e-6, 0.0), T, T, 0.0).expect("old"));
    assert_eq!(acceptor.demanded(), before);
    // What breaks a limit is refused, whenever it comes.
    let jump = acceptor.hear(&joints(0.1, 0.0), T, T, -1.0).expect_err("a jump");
    assert_eq!(jump.kind(), FaultKind::DemandedVelocity);
}
