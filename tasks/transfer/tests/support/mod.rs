//! Watches the demands of both arms, servo period by servo period, as their drives get them.

// Each test uses some of it.
#![allow(dead_code)]

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::observe::Observation;
use mrroc::prelude::*;
use mrroc_robots::{Kinematics, Polycrank, Rnt, Seven, Six};
use transfer::places::{CLOSED, End, bar, grasp, legs};
use transfer::{cell, file, mp, plant};

/// What was demanded in the servo periods of a run.
#[derive(Default)]
pub struct Demands {
    /// Both tools, `X_WE`, while the hands were told to be closed.
    pub carrying: Vec<[Pose; 2]>,
    /// Both tools in the last period of all.
    pub last: [Pose; 2],
    /// How far the faster of them went in that period \[m\].
    pub moved: f64,
    /// How far both arms are from a singularity at least.
    pub singularity: [f64; 2],
    /// Every number that any drive got, as bits, one after the other.
    pub bits: Vec<u64>,
    /// What the drives of each robot got first, and whether any got something else.
    first: Vec<(String, Vec<f64>)>,
    pub is_moved: bool,
    tools: [Pose; 2],
}

/// Shared with the cell that is watched.
pub type Shared = Rc<RefCell<Demands>>;

/// The kinematics of both arms, from the file.
struct Arms {
    rnt: Rnt,
    polycrank: Polycrank,
    tool: Pose,
}

impl Arms {
    fn of(file: &CellFile) -> Arms {
        let [rnt, polycrank, ..] = file.robots() else { panic!("two arms and their hands") };
        Arms {
            rnt: Rnt::new().with_base(rnt.base()),
            polycrank: Polycrank::new().with_base(polycrank.base()),
            tool: rnt.tool(),
        }
    }
}

impl Demands {
    fn see(&mut self, arms: &Arms, robot: &Observation<'_>) {
        self.bits.extend(robot.demanded.iter().map(|x| x.to_bits()));
        match self.first.iter().find(|(name, _)| name == robot.robot) {
            Some((_, first)) => self.is_moved |= first != robot.demanded,
            None => self.first.push((robot.robot.to_owned(), robot.demanded.to_vec())),
        }
        match robot.robot {
            "rnt" => {
                let q = Six::from_column_slice(robot.demanded);
                self.tools[0] = arms.rnt.forward(&q) * arms.tool;
                self.note_singularity(0, || arms.rnt.singularity_distance(&q));
            }
            "polycrank" => {
                let q = Seven::from_column_slice(robot.demanded);
                self.tools[1] = arms.polycrank.forward(&q) * arms.tool;
                self.note_singularity(1, || arms.polycrank.singularity_distance(&q));
                let moved =
                    |i: usize| (self.tools[i].translation.vector - self.last[i].translation.vector).norm();
                self.moved = moved(0).max(moved(1));
                self.last = self.tools;
            }
            "rnt-hand" if (robot.demanded[0] - CLOSED).abs() < 1e-12 => self.carrying.push(self.tools),
            _ => {}
        }
    }
}

impl Demands {
    /// Every 64th number is enough: it takes longer than all else.
    fn note_singularity(&mut self, arm: usize, distance: impl FnOnce() -> f64) {
        if self.bits.len().is_multiple_of(64) {
            let least = &mut self.singularity[arm];
            let distance = distance();
            *least = if *least == 0.0 { distance } else { least.min(distance) };
        }
    }
}

/// The cell with its demands watched.
pub fn watched(cell: Cell, file: &CellFile) -> (Cell, Shared) {
    let (demands, arms) = (Shared::default(), Arms::of(file));
    let seen = Rc::clone(&demands);
    (cell.watch(move |robot| seen.borrow_mut().see(&arms, robot)), demands)
}

/// The task with nothing between the hands, its demands watched.
pub fn task() -> (Cell, Shared) {
    let file = file().expect("in order");
    // The guard has its own test, tests/clear.rs: without it, many runs take half the time.
    let cell = cell(&file, &plant::drives()).expect("in order").guard(u32::MAX, |_| Ok(()));
    watched(cell.program(mp::coordinate), &file)
}

/// Distance \[m\] and angle \[rad\] between two poses.
pub fn apart(a: &Pose, b: &Pose) -> (f64, f64) {
    let error = a.inv_mul(b);
    (error.translation.vector.norm(), error.rotation.scaled_axis().norm())
}

/// How far both tools are from each other's side of the body, and the body from its path, at worst [m and rad].
#[allow(non_snake_case)]
pub fn off_path(demands: &Demands) -> f64 {
    let [near, far] = [End::Near, End::Far].map(grasp);
    let mut worst = 0.0_f64;
    for [rnt, polycrank] in &demands.carrying {
        let (distance, angle) = apart(&near.inv_mul(&far), &rnt.inv_mul(polycrank));
        worst = worst.max(distance).max(angle).max(off_legs(&(rnt * near.inverse())));
    }
    worst
}

/// How far `X_WB` is from the nearest leg of the body's path [m and rad].
#[allow(non_snake_case)]
fn off_legs(X_WB: &Pose) -> f64 {
    let mut start = bar();
    let mut least = f64::INFINITY;
    for X_BsB in legs() {
        let end = start * X_BsB;
        let leg = end.translation.vector - start.translation.vector;
        // The share of the leg, by the nearest point of the line; the turn must be the same share of the leg's.
        let along = leg.dot(&(X_WB.translation.vector - start.translation.vector)) / leg.norm_squared();
        let share = along.clamp(0.0, 1.0);
        let there = start.translation.vector + leg * share;
        let turned = start.rotation * X_BsB.rotation.powf(share);
        let angle = (turned.inverse() * X_WB.rotation).scaled_axis().norm();
        least = least.min((X_WB.translation.vector - there).norm().max(angle));
        start = end;
    }
    least
}
