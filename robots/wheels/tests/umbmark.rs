//! How far a base is wrong about its place after squares in both directions: UMBmark (Borenstein and Feng, *Measurement and Correction of Systematic
//! Odometry Errors in Mobile Robots*, 1996), with sides of 1 m instead of 4 m.
//!
//! Five runs in each direction; the centres of gravity of the errors at the end; `E` is how far the worse one is off.

use core::f64::consts::FRAC_PI_2;
use std::rc::Rc;

use mrroc::sensor::VirtualSensor;
use mrroc_wheels::sensing::{DeadReckoning, Gyro, Located};
use mrroc_wheels::simulation::{Floor, Ground};
use mrroc_wheels::{DiffDrive, Path, Planar, Two, Whereabouts};
use nalgebra::Vector2;

use crate::usage::bench::{ByWheels, Trace, Traced, run};

/// Side of the square \[m\].
const SIDE: f64 = 1.0;
/// The right wheel is larger than the left one by this share.
const UNEQUAL: f64 = 0.005;

/// Straight pieces and turns on the spot, counterclockwise (1) or clockwise (-1): its `direction`.
fn square(direction: f64) -> Vec<Path> {
    let mut at = Planar::default();
    let mut paths = Vec::new();
    for _ in 0..4 {
        let end = at.place(&Vector2::new(SIDE, 0.0));
        paths.push(Path::through(&[at.at(), end], 0.01).expect("a path"));
        at = Planar { x: end.x, y: end.y, ..at };
        paths.push(Path::turn(at, direction * FRAC_PI_2));
        at.heading += direction * FRAC_PI_2;
    }
    paths
}

/// The error at the end of a run: where it is, less where it thinks that it is.
fn error<V: VirtualSensor<Kind = Whereabouts>>(
    direction: f64,
    sensor: impl FnOnce(&Floor) -> V,
) -> Vector2<f64> {
    let ground = Ground { rims: [1.0 - 0.5 * UNEQUAL, 1.0 + 0.5 * UNEQUAL], ..Ground::default() };
    let floor = Floor::new(ground, Planar::default());
    let trace = Trace::default();
    let inner = sensor(&floor);
    run(&floor, Traced { inner, floor: floor.clone(), trace: Rc::clone(&trace) }, square(direction))
        .expect("no fault");
    let (thought, truly) = *trace.borrow().last().expect("it was asked");
    truly.at() - thought.at()
}

/// The same of wheels that never slip: each side bends by what the larger wheel rolls farther, and so does each turn.
fn expected(direction: f64) -> Vector2<f64> {
    let (mut thought, mut truly) = (Planar::default(), Planar::default());
    let mut roll = |q: Two, by_wheels: &mut Planar| {
        let pieces = 1000;
        for _ in 0..pieces {
            let each = q / f64::from(pieces);
            let (forward, turn) = DiffDrive::rolled(&each);
            *by_wheels = by_wheels.moved(forward, turn);
            let (forward, turn) = DiffDrive::rolled(&Two::new(
                each[0] * (1.0 - 0.5 * UNEQUAL),
                each[1] * (1.0 + 0.5 * UNEQUAL),
            ));
            truly = truly.moved(forward, turn);
        }
    };
    for _ in 0..4 {
        roll(DiffDrive::wheels(SIDE, 0.0), &mut thought);
        roll(DiffDrive::wheels(0.0, direction * FRAC_PI_2), &mut thought);
    }
    truly.at() - thought.at()
}

/// `E`: the larger distance of both centres of gravity.
fn worse(errors: impl Fn(f64, u64) -> Vector2<f64>) -> f64 {
    [1.0, -1.0]
        .map(|direction| (0..5).map(|seed| errors(direction, seed)).sum::<Vector2<f64>>().norm() / 5.0)
        .into_iter()
        .fold(0.0, f64::max)
}

#[test]
fn after_squares_in_both_directions_a_base_is_off_by_what_its_unequal_wheels_say_and_less_with_a_gyro() {
    let wheels = worse(|direction, _| {
        error(direction, |_| ByWheels {
            reckoning: DeadReckoning::from(Planar::default()),
            before: Two::zeros(),
        })
    });
    let kinematics = worse(|direction, _| expected(direction));
    let gyro = worse(|direction, seed| {
        error(direction, |floor| {
            Located::by(Gyro::new(floor.clone(), seed), DeadReckoning::from(Planar::default()))
        })
    });
    println!(
        "E of UMBmark, squares of 1 m: {:.1} mm by wheels alone (without slip {:.1} mm), {:.1} mm with a gyro",
        1e3 * wheels,
        1e3 * kinematics,
        1e3 * gyro
    );
    assert!((wheels - kinematics).abs() < 0.15 * kinematics, "{wheels} {kinematics}");
    assert!(gyro < 0.25 * wheels, "{gyro}");
}
