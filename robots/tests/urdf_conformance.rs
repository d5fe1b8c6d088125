//! Arms read from URDF keep what a robot must keep.

use mrroc::robot::Robot;
use mrroc_robots::{Serial, kinematics_conformance};
use nalgebra::SVector;

fn arm<const N: usize>(arm: &str, base: &str, tip: &str) -> Serial<N> {
    let path = format!("{}/tests/reference/urdf/{arm}.urdf", env!("CARGO_MANIFEST_DIR"));
    Serial::<N>::from_urdf_file(path, base, tip)
        .and_then(|robot| robot.with_acceleration(SVector::<f64, N>::repeat(10.0)))
        .and_then(|robot: Serial<N>| {
            // Endless joints have a thousand turns: their round-off would hide what is tested.
            let limits = *robot.limits();
            robot.with_positions(
                limits.lower.map(|q: f64| q.max(-20.0)),
                limits.upper.map(|q: f64| q.min(20.0)),
            )
        })
        .expect("the URDF is sound")
}

kinematics_conformance!(
    ortho_parallel,
    arm::<6>("ortho_parallel", "base_link", "tool0"),
    SVector::<f64, 6>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
);
kinematics_conformance!(
    offset_arm,
    arm::<6>("offset_arm", "foot", "tool"),
    SVector::<f64, 6>::from([0.1, -0.2, 0.3, 0.4, 0.5, 0.6])
);
kinematics_conformance!(
    three_parallel,
    arm::<6>("three_parallel", "base", "wrist_3"),
    SVector::<f64, 6>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
);
kinematics_conformance!(
    seven_axes,
    arm::<7>("seven_axes", "world_foot", "flange"),
    SVector::<f64, 7>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
);
kinematics_conformance!(
    three_parallel_beside,
    arm::<6>("three_parallel_beside", "foot", "tool"),
    SVector::<f64, 6>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
);
kinematics_conformance!(
    offset_elbow,
    arm::<7>("offset_elbow", "foot", "tool"),
    SVector::<f64, 7>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
);
kinematics_conformance!(
    offset_wrist,
    arm::<7>("offset_wrist", "link0", "flange"),
    SVector::<f64, 7>::from([0.1, 0.2, 0.3, -1.4, 0.5, 1.6, 0.7])
);
kinematics_conformance!(
    scara,
    arm::<4>("scara", "base", "tool"),
    SVector::<f64, 4>::from([0.1, 0.2, 0.3, 0.1])
);
kinematics_conformance!(
    gantry,
    arm::<4>("gantry", "bed", "tool"),
    SVector::<f64, 4>::from([0.1, 0.2, 0.3, 0.4])
);
kinematics_conformance!(
    palletiser,
    arm::<4>("palletiser", "base", "tool"),
    SVector::<f64, 4>::from([0.1, 0.2, 0.3, 0.4])
);
