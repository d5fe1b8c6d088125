//! One rule for the points of all paths: those that coincide are one, and what is wrong is told with its place.

use mrroc::generator::{Generator, Motion};
use mrroc::prelude::*;
use mrroc_generators::generators::{JointSpline, JointVia, LineVia, PoseSplineMove, TimeOptimalJoints};
use mrroc_generators::jerk::JointLimits;
use mrroc_generators::line::SmoothToolLimits;
use mrroc_generators::profile::JerkLimits;
use mrroc_generators::rehearsal::rehearse;
use mrroc_generators::timing::PathLimits;
use mrroc_generators::via::PoseDeviation;
use mrroc_robots::{Irp6, Six};

const V: f64 = 0.4;
const A: f64 = 0.8;

/// The joints that a motion demands from [`Irp6::READY`] on; the message of its fault.
fn demanded<G>(motion: G) -> Result<Vec<Six>, String>
where
    G: Generator<Robots = Irp6, Language = Motion, Sensors = (), Order = ()>,
{
    let irp6 = Irp6::nominal();
    let mut near = Irp6::READY;
    let demands = rehearse(motion, &irp6, Irp6::READY, 0.002).map_err(|fault| fault.message().to_owned())?;
    let joints = |demand: &Demand<Irp6>| {
        near = match demand.as_pose() {
            Some(pose) => irp6.inverse(&pose, &near).expect("within reach"),
            None => demand.as_joints().expect("joints"),
        };
        near
    };
    Ok(demands.iter().map(joints).collect())
}

type Path = fn(&[Six]) -> Result<Vec<Six>, String>;

fn poses(points: &[Six]) -> Vec<Pose> {
    points.iter().map(|q| Irp6::nominal().forward(q)).collect()
}

/// All paths through points, by their names.
const PATHS: [(&str, Path); 5] = [
    ("JointVia", |points| {
        let limits =
            JointLimits { velocity: Six::repeat(V), acceleration: Six::repeat(A), jerk: Six::repeat(8.0) };
        demanded(JointVia::through(points.to_vec(), Six::repeat(0.01), limits))
    }),
    ("JointSpline", |points| {
        demanded(JointSpline::through(points.to_vec(), Six::repeat(V), Six::repeat(A), 0.1))
    }),
    ("TimeOptimalJoints", |points| {
        let limits =
            PathLimits { velocity: Six::repeat(V), acceleration: Six::repeat(A), speed: f64::INFINITY };
        demanded(TimeOptimalJoints::through(points.to_vec(), limits))
    }),
    ("LineVia", |points| {
        let limits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
        let limits = SmoothToolLimits { translation: limits, rotation: limits };
        let deviation = PoseDeviation { distance: 0.005, angle: 0.05 };
        demanded(LineVia::through(poses(points), deviation, limits))
    }),
    ("PoseSplineMove", |points| {
        let limits = JerkLimits { velocity: 0.1, acceleration: 0.5, jerk: 5.0 };
        demanded(PoseSplineMove::through(
            poses(points),
            SmoothToolLimits { translation: limits, rotation: limits },
        ))
    }),
];

#[test]
fn points_that_coincide_are_one_for_every_path() {
    let at = |x: f64, y: f64| Irp6::READY + Six::new(x, y, -0.5 * x, 0.0, y * x, 0.3 * x);
    let (a, b, c) = (at(0.1, 0.05), at(0.2, -0.05), at(0.15, 0.1));
    let nearly = |q: Six| q + Six::repeat(1e-10);
    for (name, path) in PATHS {
        let plain = path(&[a, b, c]).expect("a path");
        for points in [
            // From where it is, named as the first point, and to places named twice.
            vec![Irp6::READY, a, b, c],
            vec![nearly(Irp6::READY), Irp6::READY, a, b, c],
            vec![a, a, b, nearly(b), b, c],
            vec![a, b, c, nearly(c), c],
        ] {
            let again = path(&points).unwrap_or_else(|wrong| panic!("{name}: {wrong}"));
            assert_eq!(again.len(), plain.len(), "{name}: it takes as long");
            let off = again.iter().zip(&plain).map(|(q, p)| (q - p).amax()).fold(0.0, f64::max);
            assert!(off < 1e-7, "{name}: {off}");
        }
    }
}

#[test]
fn a_path_to_where_the_robot_is_is_over_at_once() {
    for (name, path) in PATHS {
        assert_eq!(path(&[Irp6::READY, Irp6::READY]), Ok(Vec::new()), "{name}");
    }
}

#[test]
fn the_point_is_named_that_is_no_number() {
    let (a, b) = (Irp6::READY + Six::x() * 0.1, Irp6::READY + Six::y() * 0.1);
    for bad in [f64::NAN, f64::INFINITY] {
        for (name, path) in &PATHS[..3] {
            let wrong = path(&[a, b, Six::repeat(bad)]).expect_err("no number");
            assert!(
                wrong.contains("point 3 of the path has a coordinate that is infinite or not a number"),
                "{name}: {wrong}"
            );
        }
    }
}
