//! The weight of the links is a conservative load: no closed path of the motors gains energy from it.

use mrroc_robots::{
    Conveyor, Driven, Gripper, Irp6, Irp6FiveDof, Irp6Track, One, Polycrank, Rnt, Seven, Six,
};
use nalgebra::SVector;

use crate::support::engraving;

/// The work of the loads along a triangle of motor angles around the joints `q`, by Simpson's rule on many pieces.
fn work_around<const N: usize>(
    robot: &impl Driven<N>,
    q: &SVector<f64, N>,
    corners: [SVector<f64, N>; 3],
) -> f64 {
    const PIECES: usize = 200;
    let place = |corner: &SVector<f64, N>| robot.motors(&(q + corner));
    let load = |angles: &SVector<f64, N>| robot.shafts(angles, &SVector::zeros()).loads;
    let mut work = 0.0;
    for side in 0..3 {
        let (from, to) = (place(&corners[side]), place(&corners[(side + 1) % 3]));
        let step = (to - from) / PIECES as f64;
        for piece in 0..PIECES {
            let at = from + step * piece as f64;
            let mean = (load(&at) + load(&(at + step * 0.5)) * 4.0 + load(&(at + step))) / 6.0;
            work += mean.dot(&step);
        }
    }
    work
}

fn conserves<const N: usize>(robot: &impl Driven<N>, q: SVector<f64, N>, size: f64) {
    let corner = |phase: f64| SVector::from_fn(|i, _| size * (1.7 * i as f64 + phase).sin());
    let work = work_around(robot, &q, [corner(0.0), corner(2.0), corner(4.5)]);
    let there = robot.motors(&(q + corner(0.0)));
    let scale = robot.shafts(&there, &SVector::zeros()).loads.amax() * (there - robot.motors(&q)).norm();
    println!("{}: {work:.1e} J around, {scale:.1e} J in between", std::any::type_name_of_val(robot));
    assert!(work.abs() <= 1e-9 * (1.0 + scale), "{work} J");
}

#[test]
fn no_closed_path_gains_energy_from_the_weight() {
    let arm = engraving();
    let tracked = Seven::from_fn(|i, _| if i == 0 { 0.5 } else { arm[i - 1] });
    conserves(&Irp6::nominal(), arm, 0.1);
    conserves(&Irp6::calibrated(), arm, 0.1);
    conserves(&Irp6FiveDof::nominal(), arm.fixed_rows::<5>(0).into_owned(), 0.1);
    conserves(&Irp6Track::nominal(), tracked, 0.1);
    conserves(&Rnt::new(), Six::new(0.1, 0.5, 0.55, 0.2, 1.3, 0.3), 0.05);
    conserves(&Polycrank::new(), Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]), 0.5);
    conserves(&Gripper::new(), One::new(0.07), 0.01);
    conserves(&Conveyor::new(), One::new(0.5), 0.1);
}
