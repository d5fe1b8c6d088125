//! Kinematics of an arm read from URDF allocate nothing, whatever they are asked.

use std::hint::black_box;

use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_counting_allocator::{allocations, count};
use mrroc_robots::{Kinematics, Serial};
use nalgebra::SVector;

fn allocates_nothing<const N: usize>(arm: &str, base: &str, tip: &str) {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    let robot: Serial<N> = Serial::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::repeat(10.0)))
        .expect("the URDF is sound");
    let mut random = Random::seeded(1);
    assert!(allocations() > 0, "reading a file allocates, and that is counted");
    let ((), within) = count(|| {
        for _ in 0..100 {
            let limits = robot.limits();
            let q = SVector::<f64, N>::from_fn(|i, _| {
                random.between(limits.lower[i].max(-7.0), limits.upper[i].min(7.0))
            });
            let mut pose = robot.forward(&q);
            black_box(robot.jacobian(&q));
            black_box(robot.near_singularity(&q));
            robot.frames(&q, &mut |frame| _ = black_box(frame));
            for away in [0.0, 100.0, f64::NAN] {
                pose.translation.vector.x += away;
                black_box(robot.inverse(&pose, &q).is_ok());
                black_box(robot.solutions(&pose, &q, &mut |q| _ = black_box(q)).is_ok());
            }
        }
    });
    assert_eq!(within, 0, "{arm}");
}

#[test]
fn arms_of_every_kind_are_moved_without_allocation() {
    allocates_nothing::<6>("ortho_parallel", "base_link", "tool0");
    allocates_nothing::<6>("three_parallel", "base", "wrist_3");
    allocates_nothing::<7>("seven_axes", "world_foot", "flange");
    allocates_nothing::<4>("palletiser", "base", "tool");
}
