//! One's own arm: from a URDF and a tracker to a file for `cell.toml`. The tracker is made up here, and so is what the arm is off by.
//!
//! ```text
//! cargo run --release -p mrroc-examples --example own_arm -- FILE.toml
//! ```

use std::path::Path;

use mrroc::pose::Pose;
use mrroc_calibration::data::Described;
use mrroc_calibration::{
    Aim, Arm, ChainArm, Detail, Freedom, Noise, Points, Problem, Settings, Tolerances, choose,
};
use nalgebra::{Point3, Vector3};

/// The arm's description, and its flange.
const URDF: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/tests/reference/urdf/three_parallel.urdf");
const TIP: &str = "wrist_3";
/// Balls on the flange, about \[m\].
const BALLS: [[f64; 3]; 3] = [[0.05, 0.0, 0.06], [-0.03, 0.045, 0.03], [-0.02, -0.05, 0.09]];

type Any = Box<dyn std::error::Error>;

// ANCHOR: own
/// `postures` are what the arm may be sent to [rad]; `measured(q, ball)` sends it there and asks the tracker \[m\].
pub fn calibrated(
    postures: &[Vec<f64>],
    count: usize,
    mut measured: impl FnMut(&[f64], usize) -> [f64; 3],
) -> Result<String, Any> {
    let arm = Described::urdf(Path::new(URDF), None, TIP)?;
    let model = arm.chain.with(Detail::Geometry, &Tolerances::default());
    let mut problem = Problem::new();
    let id = problem.arm("arm", model.clone(), Pose::translation(1.5, 0.0, 0.0), Freedom::FRAME);
    let noise = Noise::Known(vec![2e-5; 3]);
    let tracker = problem.instrument("tracker", Points::new(), None, Pose::identity(), Freedom::FIXED, noise);
    let balls =
        BALLS.map(|[x, y, z]| problem.target("ball", Some(id), Pose::translation(x, y, z), Freedom::POINT));
    // Which postures tell most of where the first ball is, in all of them?
    let mut expected = problem.clone();
    for q in postures {
        let posture = expected.posture(id, q);
        balls.iter().for_each(|ball| expected.measure(tracker, *ball, &[posture], &[0.0; 3]));
    }
    let candidates: Vec<_> = (0..postures.len()).map(|i| vec![3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let aims: Vec<_> = postures.iter().map(|q| Aim::Place(id, q.clone(), balls[0])).collect();
    for i in choose(&expected, &candidates, &aims, count).candidates {
        let posture = problem.posture(id, &postures[i]);
        for (ball, target) in balls.iter().enumerate() {
            problem.measure(tracker, *target, &[posture], &measured(&postures[i], ball));
        }
    }
    let fit = problem.fit(&Settings::default())?;
    Ok(mrroc_calibration::file::of_chain(&model, fit.arm(id), None).text())
}
// ANCHOR_END: own

/// An arm that is not quite as it was designed: some tenths of a millimetre, and milliradians.
pub struct Truth {
    model: ChainArm,
    values: Vec<f64>,
}

impl Truth {
    /// # Errors
    /// If its description cannot be read.
    pub fn new() -> Result<Self, Any> {
        let arm = Described::urdf(Path::new(URDF), None, TIP)?;
        let model = arm.chain.with(Detail::Geometry, &Tolerances::default());
        let count = Arm::parameters(&model).len();
        // What is off along and about the last axis is found as places of the balls.
        let size = |i: usize| if i + 12 < count { 5e-4 } else { 0.0 };
        let values = (0..count).map(|i| size(i) * (i as f64 * 1.7).sin()).collect();
        Ok(Self { model, values })
    }

    /// The flange in the base \[m\].
    #[must_use]
    pub fn flange(&self, q: &[f64]) -> Pose {
        Arm::flange(&self.model, q, &self.values)
    }

    /// Where the tracker sees a ball, to 0.02 mm.
    #[must_use]
    pub fn ball(&self, q: &[f64], ball: usize) -> [f64; 3] {
        let place = Pose::new(Vector3::new(1.502, 0.003, -0.001), Vector3::new(0.0, 0.002, 0.01));
        let seen = place * self.flange(q) * Point3::from(BALLS[ball]);
        let noise =
            |axis: usize| 3e-5 * (1e3 * q.iter().sum::<f64>() + 7.0 * ball as f64 + axis as f64).sin();
        [seen.x + noise(0), seen.y + noise(1), seen.z + noise(2)]
    }
}

/// Postures that the arm may be sent to \[rad\], always the same.
#[must_use]
pub fn postures(count: usize) -> Vec<Vec<f64>> {
    let half = [1.4, 0.7, 0.9, 1.5, 1.5, 2.0];
    let middle = [0.0, -1.3, 1.4, -1.5, 0.0, 0.0];
    // Kronecker's sequence, of the roots of primes.
    let step = [2.0_f64, 3.0, 5.0, 7.0, 11.0, 13.0].map(f64::sqrt);
    let joint = |i: usize, j: usize| middle[j] + half[j] * (2.0 * (i as f64 * step[j]).fract() - 1.0);
    (0..count).map(|i| (0..6).map(|j| joint(i, j)).collect()).collect()
}

#[allow(dead_code)] // the tests read the rest of this file
fn main() -> Result<(), Any> {
    let out = std::env::args().nth(1).unwrap_or_else(|| "own_arm.toml".to_owned());
    let truth = Truth::new()?;
    let text = calibrated(&postures(200), 20, |q, ball| truth.ball(q, ball))?;
    std::fs::write(&out, text)?;
    mrroc::console::complain(&format!("see {out}"));
    Ok(())
}
