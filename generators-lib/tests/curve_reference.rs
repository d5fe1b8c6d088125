//! Curves against scipy, Pinocchio and KDL.

use crate::usage::reference::rows;
use mrroc::pose::Pose;
use mrroc_generators::curve::*;
use mrroc_generators::line::{LinePath, ToolPoint};
use mrroc_generators::profile::ProfilePoint;
use nalgebra::{Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3};
use std::collections::BTreeMap;

/// The rows of a case, by what they say.
type Case = BTreeMap<String, Vec<Vec<f64>>>;

fn cases(kind: &str) -> Vec<Case> {
    cases_of("curves.csv", kind)
}

fn cases_of(file: &str, kind: &str) -> Vec<Case> {
    let mut cases: BTreeMap<String, Case> = BTreeMap::new();
    for (label, numbers) in rows(file, 3).into_iter().filter(|(label, _)| label[0] == kind) {
        cases.entry(label[1].clone()).or_default().entry(label[2].clone()).or_default().push(numbers);
    }
    assert!(cases.len() >= 10, "{kind}");
    cases.into_values().collect()
}

fn v(x: &[f64]) -> Vector3<f64> {
    Vector3::new(x[0], x[1], x[2])
}

fn q(x: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(x[3], x[0], x[1], x[2]))
}

/// The same orientation, to `tolerance` in every number of the quaternion, whose sign does not count.
fn same(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, tolerance: f64) -> bool {
    (a.coords - b.coords).amax().min((a.coords + b.coords).amax()) < tolerance
}

#[test]
fn smoothing_splines_equal_scipys() {
    for case in cases("smoothing") {
        let points: Vec<_> = case["point"].iter().map(|x| v(x)).collect();
        let spline = CubicSpline::smoothing(
            case["knots"][0].clone(),
            &points,
            &case["weights"][0],
            case["lambda"][0][0],
        )
        .unwrap();
        for row in &case["at"] {
            let at = spline.at(row[0]);
            let off = [at.value - v(&row[1..]), at.first - v(&row[4..])];
            assert!(off.iter().all(|off| off.amax() < 1e-9), "{off:?} at {} of {case:?}", row[0]);
        }
    }
}

#[test]
fn rotation_splines_equal_scipys() {
    for case in cases("rotation") {
        let orientations = case["point"].iter().map(|x| q(x)).collect();
        let spline = RotationSpline::new(case["knots"][0].clone(), orientations).unwrap();
        let (most_w, most_a) = spline.bounds();
        for row in &case["at"] {
            let (orientation, w, a) = spline.at(row[0]);
            assert!(same(&orientation, &q(&row[1..]), 1e-10), "{} of {case:?}", row[0]);
            assert!((w - v(&row[5..])).amax() < 1e-10 * (1.0 + w.norm()), "{w} at {} of {case:?}", row[0]);
            assert!((a - v(&row[8..])).amax() < 1e-8 * (1.0 + a.norm()), "{a} at {} of {case:?}", row[0]);
            assert!(w.norm() <= most_w * (1.0 + 1e-12) && a.norm() <= most_a * (1.0 + 1e-12));
        }
    }
}

#[test]
fn nurbs_equal_scipys() {
    for case in cases("nurbs") {
        let points: Vec<_> = case["point"].iter().map(|x| v(x)).collect();
        let degree = case["degree"][0][0] as usize;
        let curve = Nurbs::new(degree, &points, &case["weights"][0], case["knots"][0].clone()).unwrap();
        for row in &case["at"] {
            let at = curve.at(row[0]);
            let off = [
                (at.value - v(&row[1..])).norm(),
                (at.first - v(&row[4..])).norm() / (1.0 + at.first.norm()),
                (at.second - v(&row[7..])).norm() / (1.0 + at.second.norm()),
            ];
            assert!(off[0] < 1e-12 && off[1] < 1e-11 && off[2] < 1e-10, "{off:?} at {} of {case:?}", row[0]);
        }
        let (length, by_length) = (case["length"][0][0], ByLength::new(curve).unwrap());
        assert!((by_length.length() / length - 1.0).abs() < 1e-10, "{} {length}", by_length.length());
    }
}

#[test]
fn lines_turn_as_scipys_slerp() {
    for case in cases("slerp") {
        let ends = [0, 1].map(|i| Pose::from_parts(Translation3::identity(), q(&case["point"][i])));
        let line = LinePath::new(ends[0], ends[1]);
        for row in &case["at"] {
            assert!(same(&line.pose(row[0]).rotation, &q(&row[1..]), 1e-12), "{} of {case:?}", row[0]);
        }
    }
}

#[test]
fn screws_equal_pinocchios_interpolation() {
    for case in cases("screw") {
        let screw = Screw::new(pose(&case["point"][0]), pose(&case["point"][1]));
        for row in &case["at"] {
            let (ours, theirs) = (screw.pose(row[0]), pose(&row[1..]));
            let off = (ours.translation.vector - theirs.translation.vector).amax();
            assert!(off < 1e-10 && same(&ours.rotation, &theirs.rotation, 1e-10), "{off} at {}", row[0]);
        }
    }
}

fn pose(x: &[f64]) -> Pose {
    Pose::from_parts(Translation3::from(v(x)), q(&x[3..]))
}

/// Pose, velocity and acceleration at every row of a case of KDL, to 1e-10 of what they are made of. `per` turns a length
/// into the path's parameter.
fn equals_kdl(case: &Case, per: f64, at: impl Fn(&ProfilePoint) -> ToolPoint) {
    for row in &case["at"] {
        let point = ProfilePoint { s: row[0] * per, v: row[1] * per, a: row[2] * per };
        let ours = at(&point);
        let theirs = pose(&row[3..]);
        let off = (ours.pose.translation.vector - theirs.translation.vector).amax();
        assert!(off < 1e-10 && same(&ours.pose.rotation, &theirs.rotation, 1e-10), "{off} at {row:?}");
        let derivatives = [ours.velocity, ours.turning, ours.acceleration, ours.turning_acceleration];
        for (k, ours) in derivatives.into_iter().enumerate() {
            let theirs = v(&row[10 + 3 * k..]);
            assert!(
                (ours - theirs).amax() < 1e-10 * (1.0 + theirs.norm()),
                "{k}: {ours} {theirs} at {row:?}"
            );
        }
    }
}

#[test]
fn circles_equal_kdls() {
    for case in cases_of("kdl_paths.csv", "circle") {
        let (start, end, about) = (pose(&case["start"][0]), pose(&case["end"][0]), &case["about"][0]);
        let (on, centre) = (start.translation.vector, v(about));
        let axis = UnitVector3::new_normalize((on - centre).cross(&(v(&about[3..]) - centre)));
        let arc = Arc::about(on, centre, axis, about[6]).unwrap();
        assert!((arc.length() / case["length"][0][0] - 1.0).abs() < 1e-12);
        let circle = TurnedCurve::new(arc, start, end).unwrap();
        equals_kdl(&case, 1.0, |point| circle.at(point));
    }
}

#[test]
fn lines_equal_kdls() {
    for case in cases_of("kdl_paths.csv", "line") {
        let line = LinePath::new(pose(&case["start"][0]), pose(&case["end"][0]));
        assert!((line.length() / case["length"][0][0] - 1.0).abs() < 1e-12);
        equals_kdl(&case, 1.0 / line.length(), |point| line.at(point));
    }
}
