//! Time-optimal motion along paths, against TOPPRA's durations and within its limits.

use crate::usage::reference::rows;
use mrroc_generators::curve::{CubicSpline, SplineEnds};
use mrroc_generators::profile::Profile;
use mrroc_generators::timing::*;
use nalgebra::{SVector, Vector2};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// The rows of a case, by their kind.
type Case = BTreeMap<String, Vec<Vec<f64>>>;

fn cases() -> Vec<Case> {
    let mut cases: BTreeMap<String, Case> = BTreeMap::new();
    for (label, numbers) in rows("toppra.csv", 2) {
        cases.entry(label[1].clone()).or_default().entry(label[0].clone()).or_default().push(numbers);
    }
    cases.into_values().collect()
}

type Vector<const N: usize> = SVector<f64, N>;

fn spline<const N: usize>(case: &Case) -> CubicSpline<Vector<N>> {
    let points = case["point"].iter().map(|p| Vector::<N>::from_column_slice(p)).collect();
    CubicSpline::new(case["knots"][0].clone(), points, SplineEnds::Natural).unwrap()
}

fn limits<const N: usize>(case: &Case) -> PathLimits<Vector<N>> {
    PathLimits {
        velocity: Vector::from_column_slice(&case["velocity"][0]),
        acceleration: Vector::from_column_slice(&case["acceleration"][0]),
        speed: f64::INFINITY,
    }
}

/// So many equal cells on each knot span.
fn cells(knots: &[f64], count: usize) -> Vec<f64> {
    let spans = knots.windows(2);
    let starts = spans.flat_map(|w| (0..count).map(|i| w[0] + (w[1] - w[0]) * i as f64 / count as f64));
    starts.chain(knots.last().copied()).collect()
}

/// The arm of `tests/benches/peers/toppra_reference.py`.
fn dynamics<const N: usize>(q: &Vector<N>, v: &Vector<N>, a: &Vector<N>) -> Vector<N> {
    let (c, s, k) = (q[1].cos(), q[1].sin(), 0.25);
    let first = k * ((3.0 + 2.0 * c) * a[0] + (1.0 + c) * a[1] - s * (2.0 * v[0] * v[1] + v[1] * v[1]));
    let second = k * ((1.0 + c) * a[0] + a[1] + s * v[0] * v[0]);
    let (g1, g2) = (9.81 * 0.5 * q[0].cos(), 9.81 * 0.5 * (q[0] + q[1]).cos());
    let both = Vector2::new(first + 2.0 * g1 + g2, second + g2);
    Vector::from_fn(|i, _| both[i])
}

fn plan<const N: usize>(case: &Case, count: usize) -> TimeOptimal {
    let (path, limits) = (spline::<N>(case), limits::<N>(case));
    let (grid, speeds) = (cells(path.knots(), count), [case["speeds"][0][0], case["speeds"][0][1]]);
    let torque = case.get("torque").map(|rows| Vector::<N>::from_column_slice(&rows[0]));
    TimeOptimal::with_linear_limits(&path, &grid, &limits, speeds, |at, more| {
        if let Some(torque) = &torque {
            more.extend(torque_limits(at, dynamics, &-torque, torque));
        }
    })
    .unwrap()
}

/// The largest share of a limit of velocity, acceleration and torque at many instants, on grid points and between.
fn shares<const N: usize>(case: &Case, plan: &TimeOptimal) -> [f64; 3] {
    let (path, limits) = (spline::<N>(case), limits::<N>(case));
    let mut most = [0.0_f64; 3];
    for i in 0..=20_000 {
        let point = plan.at(plan.duration() * f64::from(i) / 20_000.0);
        let at = path.at(point.s);
        let (v, a) = (at.first * point.v, at.first * point.a + at.second * point.v * point.v);
        most[0] = most[0].max(v.component_div(&limits.velocity).amax());
        most[1] = most[1].max(a.component_div(&limits.acceleration).amax());
        if let Some(torque) = case.get("torque") {
            let tau = dynamics(&at.value, &v, &a);
            most[2] = most[2].max(tau.component_div(&Vector::from_column_slice(&torque[0])).amax());
        }
    }
    most
}

fn by_joints<T>(case: &Case, two: impl Fn(&Case) -> T, six: impl Fn(&Case) -> T) -> T {
    if case["velocity"][0].len() == 2 { two(case) } else { six(case) }
}

#[test]
fn durations_equal_toppras_to_within_the_error_of_its_grid() {
    let mut worst: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    for case in cases() {
        let exact = case["duration"].last().unwrap()[1];
        for row in &case["duration"] {
            let (count, theirs) = (row[0] as usize, row[1]);
            let ours = by_joints(&case, |c| plan::<2>(c, count), |c| plan::<6>(c, count)).duration();
            // What it costs that limits hold between grid points too is of the second order of the cell.
            let off = (ours / theirs - 1.0).abs();
            assert!(off < 3.0 / (count * count) as f64, "{count}: {ours} instead of {theirs}: {case:?}");
            let [most, error] = worst.entry(count).or_default();
            (*most, *error) = (most.max(off), error.max(theirs / exact - 1.0));
        }
    }
    for (count, [off, error]) in worst {
        assert!(count == 400 || off < 0.5 * error, "{count} cells: off by {off}, TOPPRA's own error {error}");
    }
}

#[test]
fn limits_hold_on_grid_points_and_between() {
    for case in cases() {
        // Torques are no cubics: they may exceed their limits between grid points by the fourth order of the cell.
        for (count, torque) in [(5, 1e-6), (10, 1e-7), (50, 1e-10)] {
            let [v, a, tau] = by_joints(
                &case,
                |c| shares::<2>(c, &plan::<2>(c, count)),
                |c| shares::<6>(c, &plan::<6>(c, count)),
            );
            assert!(v < 1.0 + 1e-12 && a < 1.0 + 1e-12 && tau < 1.0 + torque, "{count}: {v} {a} {tau}");
        }
    }
}

/// The largest angle by which a link of the arm would turn in one unit of the path, at the speed of any of its places [rad].
fn most_turned(path: &CubicSpline<Vector<2>>) -> f64 {
    let length = *path.knots().last().unwrap();
    let turned = |i: i32| path.at(length * f64::from(i) / 1000.0).first.lp_norm(1);
    (0..=1000).map(turned).fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn torques_exceed_their_limits_by_the_fourth_order_of_a_cell_at_most(
        points in prop::collection::vec([-1.5..1.5f64, -1.5..1.5f64], 2..7),
        torque in 16.0..60.0f64,
        acceleration in 1.0..100.0f64,
    ) {
        let mut case = Case::new();
        case.insert("knots".into(), vec![(0..points.len()).map(|i| i as f64).collect()]);
        case.insert("point".into(), points.iter().map(|p| p.to_vec()).collect());
        case.insert("velocity".into(), vec![vec![10.0; 2]]);
        case.insert("acceleration".into(), vec![vec![acceleration; 2]]);
        // More than gravity takes at any place.
        case.insert("torque".into(), vec![vec![torque; 2]]);
        case.insert("speeds".into(), vec![vec![0.0; 2]]);
        for count in [5_u8, 10, 20] {
            let [_, _, tau] = shares::<2>(&case, &plan::<2>(&case, count.into()));
            // A cubic that meets value and slope of a cosine at both ends of an interval is off by a 384th of the fourth
            // power of its width: of the largest angle by which a link turns in a cell.
            let width = most_turned(&spline::<2>(&case)) / f64::from(count);
            let bound = width.powi(4) / 384.0;
            prop_assert!(tau < 1.0 + bound, "{count}: {tau}, {bound}");
        }
    }
}
