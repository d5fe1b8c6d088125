//! Problems whose solution SciPy found (`tests/reference/fits.py`).

use mrroc_calibration::*;

use crate::usage::case::{Case, Stated};

fn cases() -> Vec<(String, Case)> {
    let text = include_str!("reference/fits.json");
    let value: serde_json::Value = serde_json::from_str(text).expect("JSON");
    let serde_json::Value::Object(map) = value else { panic!("an object") };
    map.into_iter().map(|(name, case)| (name, Case::new(case))).collect()
}

fn cost_of(fit: &Fit, sigma: f64, loss: Loss) -> f64 {
    fit.residuals().map(|(_, _, raw)| raw.iter().map(|r| 0.5 * loss.of(r / sigma)).sum::<f64>()).sum()
}

#[test]
fn fits_are_those_that_scipy_finds() {
    for (name, case) in cases() {
        let Stated { problem, arm, balls } = case.stated();
        let loss = case.loss();
        let fit = problem.fit(&Settings { loss, ..Settings::default() }).expect("a fit");
        let sigma = case.number("sigma").expect("a sigma");
        let information = fit.information();
        assert_eq!(
            Some(information.rank as f64),
            case.number("rank"),
            "{name}: {:?}",
            information.singular_values
        );
        if case.number("tolerance").is_none() {
            let (cost, scipy) = (cost_of(&fit, sigma, loss), case.number("cost").expect("a cost"));
            assert!((cost / scipy - 1.0).abs() < 1e-6, "{name}: cost {cost}, SciPy's {scipy}");
        }
        for (q, expected) in case.rows("unseen").iter().zip(case.points("foretold")) {
            for (ball, expected) in balls.iter().zip(expected) {
                let (there, _) = fit.place(arm, q, problem.frame_of(*ball));
                for (own, scipy) in there.translation.vector.iter().zip(&expected) {
                    assert!((own - scipy).abs() < 2e-8, "{name}: {own} m, SciPy's {scipy} m");
                }
            }
        }
    }
}

/// To a thousandth of the standard deviation: residuals here are a hundred times the noise, and both iterations end some steps early.
#[test]
fn what_is_found_and_how_sure_it_is_agrees_with_scipy_where_all_is_seen() {
    let (_, case) = cases().into_iter().find(|(name, _)| name == "zeros").expect("it is there");
    let Stated { problem, .. } = case.stated();
    let fit = problem.fit(&Settings::default()).expect("a fit");
    assert!(fit.unseen().is_empty());
    let displacements = case.rows("displacements");
    let sigmas: Vec<f64> = case.rows("sigmas_of").into_iter().flatten().collect();
    let zeros: Vec<FoundParameter> =
        fit.found().filter(|found| found.parameter.name.contains("zero")).collect();
    assert_eq!(zeros.len(), sigmas.len());
    for (i, (found, sigma)) in zeros.iter().zip(sigmas).enumerate() {
        let scipy = displacements[i + 1][5];
        assert!(
            (found.value - scipy).abs() < 1e-3 * sigma,
            "{}: {} rad, SciPy's {scipy} rad",
            found.parameter.name,
            found.value
        );
        assert!(
            (found.sigma / sigma - 1.0).abs() < 1e-4,
            "{}: {} {sigma}",
            found.parameter.name,
            found.sigma
        );
    }
}

/// 51 unknowns of an arm with 6 joints, its base and three balls. Of each two neighbouring joints' displacements, z and the turn about
/// z are those of either (2 x 6, the base being before the first), and where the last frame is on the flange is free (6).
#[test]
fn what_cannot_be_told_apart_is_named() {
    let (_, case) = cases().into_iter().find(|(name, _)| name == "geometry").expect("it is there");
    let Stated { problem, .. } = case.stated();
    let fit = problem.fit(&Settings::default()).expect("a fit");
    let told: Vec<String> = fit.unseen().iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 18, "{told:#?}");
    // Frames are never what is fixed: an arm's own parameters stay as they were designed.
    assert!(fit.unseen().iter().all(|unseen| unseen.fixed.name.starts_with("joint")), "{told:#?}");
}

#[test]
fn of_a_base_that_is_free_and_the_zero_of_the_first_joint_only_the_sum_is_told() {
    let row = DhRow {
        name: "q1".into(),
        kind: mrroc::robot::JointKind::Revolute,
        theta: 0.0,
        d: 0.0,
        a: 0.0,
        alpha: 0.0,
    };
    let turntable = Chain::distal(&[row]).with(Detail::Zeros, &Tolerances::default());
    let mut problem = Problem::new();
    let yaw = Freedom { free: [false, false, false, false, false, true], tolerance: [None; 6] };
    let table = problem.arm("table", turntable, mrroc::pose::Pose::identity(), yaw);
    let place = mrroc::pose::Pose::translation(0.25, 0.0, 0.1);
    let ball = problem.target("ball", Some(table), place, Freedom::FIXED);
    let at = mrroc::pose::Pose::identity();
    let tracker =
        problem.instrument("tracker", Points::new(), None, at, Freedom::FIXED, Noise::Known(vec![1e-5; 3]));
    for q in [0.1_f64, 0.7, 1.5] {
        let posture = problem.posture(table, &[q]);
        let angle = q + 0.01;
        problem.measure(tracker, ball, &[posture], &[0.25 * angle.cos(), 0.25 * angle.sin(), 0.1]);
    }
    let fit = problem.fit(&Settings::default()).expect("a fit");
    let told: Vec<String> = fit.unseen().iter().map(ToString::to_string).collect();
    assert_eq!(told, ["q1 zero and table base turn z: only their sum"]);
    let found: Vec<FoundParameter> = fit.found().collect();
    assert!((found[0].value - 0.01).abs() < 1e-9, "{found:?}");
}
