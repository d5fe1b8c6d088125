//! What the kinematics of a robot must keep.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::{JointKind, JointVector};
use nalgebra::{DMatrix, SVector, Translation3, Vector3};

use super::{SEED, Violation, ensure};
use crate::models::{Kinematics, closest};

/// Largest error of a pose that inverse kinematics gives back [m and rad].
const POSE: f64 = 1e-9;

/// Distance from singularities below which joints are not compared: there they follow the pose too sharply.
const REGULAR: f64 = 1e-3;

/// Draws before giving up on finding an attainable position.
const DRAWS: usize = 100_000;

/// The larger of the differences of position \[m\] and rotation [rad, for small ones].
fn difference(x: &Pose, y: &Pose) -> f64 {
    let turn = x.rotation.to_rotation_matrix().into_inner() - y.rotation.to_rotation_matrix().into_inner();
    turn.amax().max((x.translation.vector - y.translation.vector).amax())
}

/// An attainable position, uniform in the limits.
fn attainable<const N: usize, R: Kinematics<N>>(
    robot: &R,
    random: &mut Random,
) -> Result<SVector<f64, N>, Violation> {
    let limits = robot.limits();
    for _ in 0..DRAWS {
        let q = SVector::<f64, N>::from_joints(|i| random.between(limits.lower[i], limits.upper[i]));
        if robot.is_attainable(&q) {
            return Ok(q);
        }
    }
    Err(Violation(format!("none of {DRAWS} positions within the limits is attainable")))
}

/// Largest difference of joints, full turns of revolute ones left out of account.
fn joint_difference<const N: usize>(
    robot: &impl Kinematics<N>,
    a: &SVector<f64, N>,
    b: &SVector<f64, N>,
) -> f64 {
    (0..N).fold(0.0, |worst: f64, i| {
        let turned = if robot.joint(i) == JointKind::Revolute { closest(a[i], b[i]) } else { a[i] };
        worst.max((turned - b[i]).abs())
    })
}

/// Limits are finite, in order, positive where they must be; `start` is attainable.
///
/// # Errors
/// The first [`Violation`].
pub fn limits_are_sound<const N: usize, R: Kinematics<N>>(
    robot: &R,
    start: &SVector<f64, N>,
) -> Result<(), Violation> {
    let limits = robot.limits();
    for i in 0..N {
        let (lower, upper) = (limits.lower[i], limits.upper[i]);
        ensure(lower.is_finite() && upper.is_finite() && lower < upper, || {
            format!("joint {i}: position limits {lower}, {upper}")
        })?;
        let jerk = limits.jerk.map_or(1.0, |jerk| jerk[i]);
        for limit in [limits.velocity[i], limits.acceleration[i], jerk, robot.reach()] {
            ensure(limit.is_finite() && limit > 0.0, || format!("joint {i}: limit {limit}"))?;
        }
    }
    ensure(robot.is_attainable(start), || format!("the start is not attainable: {start}"))
}

/// `inverse` gives the pose of every attainable position back, from there and from nearby; from there also the joints.
///
/// # Errors
/// The first [`Violation`].
pub fn inverse_returns_poses<const N: usize, R: Kinematics<N>>(
    robot: &R,
    count: usize,
) -> Result<(), Violation> {
    let mut random = Random::seeded(SEED);
    let mut worst = 0.0_f64;
    let mut refused = 0_usize;
    for _ in 0..count {
        let q = attainable(robot, &mut random)?;
        let pose = robot.forward(&q);
        let found =
            robot.inverse(&pose, &q).map_err(|why| Violation(format!("{why} at its own joints {q}")))?;
        let error = difference(&robot.forward(&found), &pose);
        worst = worst.max(error);
        ensure(error <= POSE, || format!("pose off by {error:e} from {q}"))?;
        if robot.singularity_distance(&q) > REGULAR {
            let error = (found - q).amax();
            ensure(error <= POSE, || format!("joints off by {error:e} from {q}, found {found}"))?;
        }
        let near = SVector::<f64, N>::from_joints(|i| q[i] + random.between(-0.01, 0.01));
        match robot.inverse(&pose, &near) {
            Ok(found) => {
                let error = difference(&robot.forward(&found), &pose);
                worst = worst.max(error);
                ensure(error <= POSE, || format!("pose off by {error:e} from {q} near {near}"))?;
            }
            Err(_) => refused += 1,
        }
    }
    println!(
        "{}: {count} poses, seed {SEED}: pose error {worst:.1e}, {refused} refused from nearby",
        R::KIND
    );
    ensure(refused * 100 <= count, || format!("{refused} of {count} poses refused from nearby"))
}

/// Solutions give the pose back, differ from each other, hold the joints that the pose came from, and are each what
/// `inverse` gives near them if they are attainable; `nearest_attainable` is the nearest of them.
///
/// # Errors
/// The first [`Violation`].
pub fn solutions_are_complete<const N: usize, R: Kinematics<N>>(
    robot: &R,
    count: usize,
) -> Result<(), Violation> {
    let mut random = Random::seeded(SEED);
    let mut total = 0;
    for _ in 0..count {
        let q = attainable(robot, &mut random)?;
        if robot.singularity_distance(&q) < REGULAR {
            continue;
        }
        let pose = robot.forward(&q);
        let mut solutions = Vec::new();
        robot
            .solutions(&pose, &q, &mut |solution| solutions.push(*solution))
            .map_err(|why| Violation(format!("{why} at its own joints {q}")))?;
        total += solutions.len();
        let holds = solutions.iter().any(|solution| joint_difference(robot, solution, &q) < POSE);
        ensure(holds, || format!("{q} is not among its {} solutions", solutions.len()))?;
        for (i, solution) in solutions.iter().enumerate() {
            let error = difference(&robot.forward(solution), &pose);
            ensure(error <= POSE, || format!("solution {i} of {q} is off by {error:e}"))?;
            for other in &solutions[..i] {
                let apart = joint_difference(robot, solution, other);
                ensure(apart > POSE, || format!("{q} has solution {solution} twice"))?;
            }
            if robot.is_attainable(solution) && robot.singularity_distance(solution) > REGULAR {
                let again = robot.inverse(&pose, solution).map_err(|why| Violation(why.to_string()))?;
                let error = (again - solution).amax();
                ensure(error <= POSE, || format!("near its solution {solution} inverse gives {again}"))?;
            }
        }
        let nearest = robot
            .nearest_attainable(&pose, &q)
            .map_err(|why| Violation(why.to_string()))?
            .unwrap_or(q * f64::NAN);
        ensure((nearest - q).amax() < POSE, || format!("nearest attainable to {q} is {nearest}"))?;
    }
    println!("{}: {total} solutions of {count} poses, seed {SEED}", R::KIND);
    Ok(())
}

/// The Jacobian agrees with central differences of `forward`; manipulability and distance are those of the Jacobian.
///
/// # Errors
/// The first [`Violation`].
pub fn jacobian_is_the_derivative<const N: usize, R: Kinematics<N>>(
    robot: &R,
    count: usize,
) -> Result<(), Violation> {
    const H: f64 = 2e-5;
    let mut random = Random::seeded(SEED);
    let mut worst = 0.0_f64;
    for _ in 0..count {
        let q = attainable(robot, &mut random)?;
        let jacobian = robot.jacobian(&q);
        for i in 0..N {
            let central = |h: f64| {
                let mut step = SVector::<f64, N>::zeros();
                step[i] = h;
                let after = robot.forward(&(q + step));
                let before = robot.forward(&(q - step));
                let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
                (linear, (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * h))
            };
            // Two steps cancel the error of the third derivative.
            let (linear, angular) = central(H);
            let (wide_linear, wide_angular) = central(2.0 * H);
            let linear = (linear * 4.0 - wide_linear) / 3.0;
            let angular = (angular * 4.0 - wide_angular) / 3.0;
            let size = 1.0 + jacobian.column(i).amax();
            for row in 0..6 {
                let expected = if row < 3 { linear[row] } else { angular[row - 3] };
                let error = (jacobian[(row, i)] - expected).abs() / size;
                worst = worst.max(error);
                ensure(error < 1e-8, || {
                    format!("row {row}, joint {i}: {} instead of {expected} at {q}", jacobian[(row, i)])
                })?;
            }
        }
        let gram = if N < 6 {
            DMatrix::from_column_slice(N, N, (jacobian.transpose() * jacobian).as_slice())
        } else {
            DMatrix::from_column_slice(6, 6, (jacobian * jacobian.transpose()).as_slice())
        };
        let determinant = gram.determinant();
        let error = robot.manipulability(&q).powi(2) - determinant;
        ensure(error.abs() < 1e-10 * (1.0 + determinant), || {
            format!("manipulability {} but sqrt(det) {} at {q}", robot.manipulability(&q), determinant.sqrt())
        })?;
    }
    println!("{}: Jacobian against central differences: {worst:.1e}, seed {SEED}", R::KIND);
    Ok(())
}

/// The frames of the links are finite and the last of them is the flange.
///
/// # Errors
/// The first [`Violation`].
pub fn frames_end_at_the_flange<const N: usize, R: Kinematics<N>>(
    robot: &R,
    count: usize,
) -> Result<(), Violation> {
    let mut random = Random::seeded(SEED);
    for _ in 0..count {
        let q = attainable(robot, &mut random)?;
        let mut last = None;
        let mut finite = true;
        robot.frames(&q, &mut |frame| {
            finite &= is_finite(frame);
            last = Some(*frame);
        });
        ensure(finite, || format!("a frame is not finite at {q}"))?;
        let error = last.map_or(f64::INFINITY, |last| difference(&last, &robot.forward(&q)));
        ensure(error <= 1e-12, || format!("the last frame is off the flange by {error:e} at {q}"))?;
    }
    Ok(())
}

fn is_finite(pose: &Pose) -> bool {
    pose.to_homogeneous().iter().all(|entry| entry.is_finite())
}

/// Poses that no robot can take are refused, not answered by NaN; forward kinematics is finite on the limits.
///
/// # Errors
/// The first [`Violation`].
pub fn nothing_is_nan<const N: usize, R: Kinematics<N>>(
    robot: &R,
    start: &SVector<f64, N>,
) -> Result<(), Violation> {
    let limits = robot.limits();
    for corner in 0..1_usize << N {
        let q = SVector::<f64, N>::from_joints(|i| {
            if corner >> i & 1 == 0 { limits.lower[i] } else { limits.upper[i] }
        });
        if robot.is_attainable(&q) {
            ensure(is_finite(&robot.forward(&q)), || format!("forward is not finite at {q}"))?;
        }
    }
    let at =
        |x: f64, y: f64, z: f64| Pose::from_parts(Translation3::new(x, y, z), robot.forward(start).rotation);
    let far = 100.0 * robot.reach();
    let nan = f64::NAN;
    for pose in [at(nan, 0.0, 0.0), at(0.0, nan, 0.0), at(0.0, 0.0, nan)] {
        ensure(robot.inverse(&pose, start).is_err(), || "a pose that is NaN has an inverse".into())?;
    }
    let mut random = Random::seeded(SEED);
    for size in [1e-12, 0.5 * robot.reach(), robot.reach(), far] {
        for _ in 0..1_000 {
            let mut draw = || random.between(-size, size);
            let centre = robot.forward(start).translation.vector;
            let p =
                Vector3::new(draw(), draw(), draw()) + if size < 1e-6 { Vector3::zeros() } else { centre };
            let pose = at(p.x, p.y, p.z);
            if let Ok(q) = robot.inverse(&pose, start) {
                ensure(q.is_finite(), || format!("inverse gives {q} at {p}"))?;
                let error = difference(&robot.forward(&q), &pose);
                ensure(error <= POSE, || format!("inverse is off by {error:e} at {p}"))?;
            }
        }
    }
    Ok(())
}
