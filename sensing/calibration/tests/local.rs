//! The local corrector: it helps where the arm has a smooth error that its dimensions cannot say, and stays off where there is only noise.

use mrroc::pose::Pose;
use mrroc::random::Noise as Random;
use mrroc::robot::JointKind;
use mrroc_calibration::*;
use nalgebra::{Point3, Vector3};

/// theta, d, a, alpha [rad, m] of a small six-axis arm, as in `reference/fits.py`.
const DH: [[f64; 4]; 6] = [
    [0.0, 0.29, 0.0, -90.0],
    [-90.0, 0.0, 0.27, 0.0],
    [0.0, 0.0, 0.07, -90.0],
    [0.0, 0.302, 0.0, 90.0],
    [0.0, 0.0, 0.0, -90.0],
    [180.0, 0.072, 0.0, 0.0],
];
const BALLS: [[f64; 3]; 3] = [[0.05, 0.0, 0.06], [-0.03, 0.045, 0.03], [-0.02, -0.05, 0.09]];
const KINDS: [JointKind; 6] = [JointKind::Revolute; 6];
const TRACKER: f64 = 2e-5;

fn model() -> ChainArm {
    let row = |i: usize| {
        let [theta, d, a, alpha] = DH[i];
        let (theta, alpha) = (theta.to_radians(), alpha.to_radians());
        DhRow { name: format!("joint {}", i + 1), kind: JointKind::Revolute, theta, d, a, alpha }
    };
    let rows: Vec<DhRow> = (0..6).map(row).collect();
    Chain::distal(&rows).with(Detail::Geometry, &Tolerances::default())
}

/// What no dimension says: each joint's gear is out of centre, and the level links bend joints 2 and 3 by their reach.
struct Truth {
    values: Vec<f64>,
    eccentric: Vec<[f64; 2]>,
    sag: f64,
}

impl Truth {
    fn flange(&self, model: &ChainArm, q: &[f64]) -> Pose {
        let mut stands: Vec<f64> = q.to_vec();
        for (stands, [a, b]) in stands.iter_mut().zip(&self.eccentric) {
            *stands += a * stands.cos() + b * stands.sin();
        }
        // How far the elbow and the wrist are out, as parts of the links.
        let (upper, lower) = (q[1].sin(), (q[1] + q[2]).cos());
        stands[1] += self.sag * (0.5 * upper + 0.5 * lower);
        stands[2] += 0.5 * self.sag * lower;
        model.flange(&stands, &self.values)
    }
}

struct Outcome {
    local: LocalTrial,
    /// Mean error of the balls at postures that nobody measured, without and with what was taken \[m\].
    unseen: [f64; 2],
}

fn outcome(seed: u64, eccentricity: f64, sag: f64) -> Outcome {
    let mut random = Random::seeded(seed);
    let model = model();
    let sizes: Vec<f64> =
        model.parameters().iter().map(|one| 0.5 * one.tolerance.expect("a tolerance")).collect();
    let truth = Truth {
        values: sizes.iter().map(|size| size * random.normal()).collect(),
        eccentric: (0..6).map(|_| [random.normal(), random.normal()].map(|x| x * eccentricity)).collect(),
        sag,
    };
    let draw = |random: &mut Random| -> Vec<f64> {
        let half = [1.4, 0.8, 0.8, 1.5, 1.3, 1.5];
        half.iter().map(|half| half * (random.normal() * 0.8).sin()).collect()
    };
    let mut problem = Problem::new();
    let arm = problem.arm("arm", model.clone(), Pose::identity(), Freedom::FRAME);
    let noise = Noise::Known(vec![TRACKER; 3]);
    let tracker = problem.instrument("tracker", Points::new(), None, Pose::identity(), Freedom::FIXED, noise);
    let balls =
        BALLS.map(|[x, y, z]| problem.target("ball", Some(arm), Pose::translation(x, y, z), Freedom::POINT));
    let mut measure = |problem: &mut Problem, count: usize, noise: f64| {
        for _ in 0..count {
            let q = draw(&mut random);
            let flange = truth.flange(&model, &q);
            let posture = problem.posture(arm, &q);
            for (target, ball) in balls.iter().zip(BALLS) {
                let off = Vector3::new(random.normal(), random.normal(), random.normal()) * noise;
                let read = (flange * Point3::from(ball)).coords + off;
                problem.measure(tracker, *target, &[posture], read.as_slice());
            }
        }
    };
    let mut unseen = problem.clone();
    measure(&mut problem, 40, TRACKER);
    measure(&mut unseen, 100, 0.0);
    let fit = problem.fit(&Settings::default()).expect("a fit");
    let local = fit.local(arm, &KINDS, 8).expect("fits");
    let mean = |problem: &Problem, fit: &Fit| {
        let lengths = trials::lengths(problem, &fit.foretold(problem));
        trials::Errors::of(lengths.into_iter().map(|(_, error)| error)).mean
    };
    let without = mean(&unseen, &fit);
    let with = local.taken.as_ref().map_or(without, |(by, fit)| mean(&bent(&unseen, arm, by), fit));
    Outcome { local, unseen: [without, with] }
}

#[test]
fn a_local_corrector_helps_where_gears_are_out_of_centre_and_links_sag() {
    for (seed, eccentricity, sag) in [(1, 3e-4, 0.0), (2, 0.0, 5e-4), (3, 2e-4, 4e-4)] {
        let Outcome { local, unseen: [without, with] } = outcome(seed, eccentricity, sag);
        assert!(local.taken.is_some(), "seed {seed}: {:?} {:?}", local.without, local.with);
        assert!(with < 0.5 * without, "seed {seed}: {without} -> {with}");
        // What was foretold by leaving postures out is what comes: beside the tracker's own noise.
        assert!(local.with.mean < 2.0 * (with + 1.6 * TRACKER), "seed {seed}: {:?} {with}", local.with);
    }
}

#[test]
fn a_local_corrector_stays_off_where_there_is_only_noise() {
    for seed in 10..15 {
        let Outcome { local, unseen } = outcome(seed, 0.0, 0.0);
        assert!(
            local.taken.is_none(),
            "seed {seed}: {} {} {}",
            local.without.mean,
            local.with.mean,
            local.sure
        );
        assert_eq!(unseen[0], unseen[1]);
    }
}
