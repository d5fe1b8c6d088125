//! Calibrated arms: their poses are those of their file, their inverse kinematics finds back, and the file of another arm is refused.

use std::path::{Path, PathBuf};

use mrroc::prelude::*;
use mrroc::robot::JointKind;
use mrroc_counting_allocator::count;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{
    ArmCalibration, ChainCalibration, Irp6, Irp6Calibration, Kinematics, LocalCorrection, Serial, simulated,
};
use nalgebra::{SVector, UnitQuaternion, Vector6};

type Arm = Serial<6>;

fn arm(text: &str, base: &str, tip: &str) -> Arm {
    Serial::<6>::from_urdf(text, base, tip)
        .and_then(|arm| arm.with_acceleration(SVector::repeat(10.0)))
        .expect("sound")
}

fn three_parallel() -> Arm {
    arm(include_str!("reference/urdf/three_parallel.urdf"), "base", "wrist_3")
}

/// The design of an arm by its frames, and displacements of up to 2 mm and 4 mrad that are always the same.
fn calibration(of: &Arm) -> ChainCalibration {
    let mut frames = Vec::new();
    of.frames(&SVector::zeros(), &mut |frame| frames.push(*frame));
    let step = |i: usize| frames[i].inv_mul(&frames[i + 1]);
    let small =
        |i: usize, axis: usize| ((i * 6 + axis) as f64 * 1.7).sin() * if axis < 3 { 2e-3 } else { 4e-3 };
    ChainCalibration {
        design: (0..6).map(step).collect(),
        tip: step(6),
        displacements: (0..6).map(|i| Vector6::from_fn(|axis, _| small(i, axis))).collect(),
        encoders: Vec::new(),
        local: None,
    }
}

/// By the definition: each joint's frame, turned, then the displacement.
fn flange(calibration: &ChainCalibration, q: &[f64]) -> Pose {
    let mut pose = Pose::identity();
    for ((design, displacement), q) in calibration.design.iter().zip(&calibration.displacements).zip(q) {
        let shift = displacement.fixed_rows::<3>(0).into_owned();
        let turn = UnitQuaternion::from_scaled_axis(displacement.fixed_rows::<3>(3).into_owned());
        pose = pose
            * design
            * Pose::rotation(nalgebra::Vector3::z() * *q)
            * Pose::from_parts(shift.into(), turn);
    }
    pose * calibration.tip
}

fn postures() -> impl Iterator<Item = SVector<f64, 6>> {
    (0..200).map(|i| SVector::from_fn(|j, _| 2.0 * (f64::from(i) * 0.73 + j as f64 * 2.1).sin() + 0.3))
}

#[test]
fn a_calibrated_arm_has_the_poses_of_its_file_and_finds_its_joints_back_without_allocation() {
    let place = Pose::translation(0.3, 0.1, 0.5);
    for nominal in
        [three_parallel(), arm(include_str!("reference/urdf/ortho_parallel.urdf"), "base_link", "tool0")]
    {
        let nominal = nominal.with_base(place);
        let calibration = calibration(&nominal);
        let arm = nominal.clone().calibrated_by(&calibration).expect("its own");
        let (mut missed, mut all) = (0, 0);
        for q in postures() {
            let expected = place * flange(&calibration, q.as_slice());
            let pose = arm.forward(&q);
            assert!((pose.to_homogeneous() - expected.to_homogeneous()).amax() < 1e-12);
            // At the edge of the range the nominal arm has no solution to begin with.
            if arm.near_singularity(&q).is_some() || nominal.inverse(&pose, &q).is_err() {
                continue;
            }
            all += 1;
            let (found, allocated) = count(|| arm.inverse(&pose, &q.add_scalar(0.05)));
            assert_eq!(allocated, 0);
            let found = found.ok().filter(|found| {
                (arm.forward(found).to_homogeneous() - expected.to_homogeneous()).amax() < 1e-9
            });
            missed += usize::from(found.is_none_or(|found| (found - q).amax() > 0.5));
        }
        assert!(all > 100 && missed * 50 <= all, "{missed} of {all} are not found back");
    }
}

/// Coefficients of some 20 urad, measured within 1.5 rad of 0.3 in all joints.
fn local() -> LocalCorrection {
    let wave = |k: usize, j: usize| 2e-5 * ((k * 6 + j) as f64 * 1.3).sin();
    LocalCorrection {
        range: vec![[-1.2, 1.8, 0.4]; 6],
        kinds: vec![JointKind::Revolute; 6],
        coefficients: (0..LocalCorrection::count(6)).map(|k| (0..6).map(|j| wave(k, j)).collect()).collect(),
    }
}

/// Within what was measured, on its edge, where it fades, and beyond, where only the dimensions count.
#[test]
fn a_local_correction_moves_the_joints_and_is_undone_without_allocation() {
    let nominal = three_parallel();
    let calibration = ChainCalibration { local: Some(local()), ..calibration(&nominal) };
    let file = ArmCalibration::Chain(calibration.clone()).text();
    let Ok(ArmCalibration::Chain(read)) = ArmCalibration::parse(&file) else { panic!("{file}") };
    let arm =
        nominal.clone().calibrated_by(&read).expect("its own").with_base(Pose::translation(0.1, 0.0, 0.0));
    let (mut inside, mut beside, mut beyond) = (0, 0, 0);
    for (i, q) in postures().enumerate() {
        let q = q * [0.6, 0.75, 1.1][i % 3];
        let own = local();
        match own.weight(q.as_slice()) {
            1.0 => inside += 1,
            0.0 => beyond += 1,
            _ => beside += 1,
        }
        let stands: Vec<f64> = q.iter().zip(own.at(q.as_slice())).map(|(q, off)| q + off).collect();
        let expected = Pose::translation(0.1, 0.0, 0.0) * flange(&calibration, &stands);
        let (pose, allocated) = count(|| arm.forward(&q));
        assert_eq!(allocated, 0);
        assert!((pose.to_homogeneous() - expected.to_homogeneous()).amax() < 1e-12);
        let mut last = Pose::identity();
        arm.frames(&q, &mut |frame| last = *frame);
        assert!((last.to_homogeneous() - expected.to_homogeneous()).amax() < 1e-12);
        let jacobian = arm.jacobian(&q);
        for j in 0..6 {
            let h = SVector::<f64, 6>::ith(j, 1e-6);
            let step = arm.forward(&(q + h)).translation.vector - arm.forward(&(q - h)).translation.vector;
            assert!((jacobian.fixed_view::<3, 1>(0, j) - step / 2e-6).amax() < 1e-7);
        }
        if arm.near_singularity(&q).is_some() || nominal.inverse(&pose, &q).is_err() {
            continue;
        }
        let (found, allocated) = count(|| arm.inverse(&pose, &q.add_scalar(1e-3)));
        assert_eq!(allocated, 0);
        if let Ok(found) = found {
            assert!((arm.forward(&found).to_homogeneous() - expected.to_homogeneous()).amax() < 1e-9);
        }
    }
    assert!(inside > 3 && beside > 3 && beyond > 3, "{inside} {beside} {beyond}");
}

#[test]
fn an_irp6_takes_the_dimensions_of_its_calibration() {
    let calibration = Irp6Calibration::of(&Irp6::calibrated());
    let arm = Irp6::nominal().calibrated_by(&calibration);
    let q = [0.2, -1.5, 0.1, -0.2, 4.5, 0.3].into();
    assert_eq!(arm.forward(&q), Irp6::calibrated().forward(&q));
    // Its marks stay those of its own encoders.
    assert_eq!(Irp6Calibration::of(&arm), calibration);
    assert_eq!(arm.transmission().lower.synchro, Irp6::nominal().transmission().lower.synchro);
}

fn folder(of: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("mrroc-calibrated-{of}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let chain = calibration(&three_parallel());
    let other = calibration(&arm(include_str!("reference/urdf/ortho_parallel.urdf"), "base_link", "tool0"));
    let encoders = ChainCalibration { encoders: vec![[1e-4, 0.0, 0.0]; 6], ..chain.clone() };
    let short = ChainCalibration {
        design: chain.design[..5].to_vec(),
        displacements: chain.displacements[..5].to_vec(),
        ..chain.clone()
    };
    let steep = LocalCorrection { coefficients: vec![vec![1e-3; 6]; LocalCorrection::count(6)], ..local() };
    let steep = ChainCalibration { local: Some(steep), ..chain.clone() };
    let irp6 = ArmCalibration::Irp6(Irp6Calibration::of(&Irp6::calibrated())).text();
    for (name, text) in [
        ("own.toml", ArmCalibration::Chain(chain).text()),
        ("other.toml", ArmCalibration::Chain(other).text()),
        ("encoders.toml", ArmCalibration::Chain(encoders).text()),
        ("short.toml", ArmCalibration::Chain(short).text()),
        ("steep.toml", ArmCalibration::Chain(steep).text()),
        ("irp6.toml", irp6),
        ("ur.toml", "model = \"ur5e\"\n".to_owned()),
        ("cell.toml", "step_ms = 2\n".to_owned()),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    folder
}

fn refusal(robot: &str, folder: &Path, calibration: &str) -> Option<String> {
    let name = format!("{}/tests/reference/urdf/cell.toml", env!("CARGO_MANIFEST_DIR"));
    let calibration = folder.join(calibration).display().to_string();
    let text = format!("step_ms = 2\nstop_ms = 3000\n[robots.arm]\ncalibration = {calibration:?}\n{robot}");
    let file = CellFile::parse(&name, &text).expect("well-formed");
    file.cell(&simulated()).err().map(|why| why.to_string())
}

const THREE_PARALLEL: &str = "kind = \"urdf\"\nfile = \"three_parallel.urdf\"\ntip = \"wrist_3\"\n\
    acceleration = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0]\nstart = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]\n";
const IRP6: &str = "kind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\n";

#[test]
fn fault_186_a_local_correction_that_is_too_steep_is_refused_before_anything_moves() {
    let folder = folder("steep");
    let why = refusal(THREE_PARALLEL, &folder, "steep.toml").expect("too steep");
    assert!(why.contains("its `local` may change by") && why.contains("cell.toml:4:15"), "{why}");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn fault_180_the_calibration_of_another_arm_is_refused_before_anything_moves() {
    let folder = folder("other");
    assert_eq!(refusal(THREE_PARALLEL, &folder, "own.toml"), None);
    assert_eq!(refusal(IRP6, &folder, "irp6.toml"), None);
    for (robot, file, told) in [
        (
            THREE_PARALLEL,
            "other.toml",
            "it is the calibration of another arm: by its design the flange is up to",
        ),
        (THREE_PARALLEL, "short.toml", "an arm with 5 joints, this one has 6"),
        (THREE_PARALLEL, "encoders.toml", "calibrate with --detail geometry"),
        (THREE_PARALLEL, "irp6.toml", "the calibration of an irp6, not of an arm of a URDF"),
        (THREE_PARALLEL, "ur.toml", "the calibration of a `ur5e`, not one that `calibrate` has made"),
        (THREE_PARALLEL, "cell.toml", "it is no calibration"),
        (THREE_PARALLEL, "nothing.toml", "nothing.toml cannot be read"),
        (IRP6, "own.toml", "the calibration of a chain of joints, not of an irp6"),
    ] {
        let why = refusal(robot, &folder, file).expect(file);
        assert!(why.contains(told) && why.contains("cell.toml:4:15"), "{why}");
    }
    std::fs::remove_dir_all(folder).expect("removed");
}

/// `base = ".."` names a file that `calibrate` has written.
#[test]
fn fault_181_a_base_that_is_in_no_file_is_refused_before_anything_moves() {
    let folder = std::env::temp_dir().join(format!("mrroc-base-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let frame = |xyz: &str| format!("[frames.base]\nxyz = {xyz}\nquat_xyzw = [0.0, 0.0, 0.6, 0.8]\n");
    for (name, text) in [
        ("right.toml", frame("[1.0, 2, 3.0]")),
        ("none.toml", "model = \"base\"\n".to_owned()),
        ("text.toml", "a base\n".to_owned()),
        ("two.toml", frame("[1.0, 2.0]")),
        ("nan.toml", frame("[1.0, nan, 2.0]")),
        ("far.toml", frame("[1e9, 0.0, 0.0]")),
        ("longer.toml", "[frames.base]\nquat_xyzw = [0.0, 0.0, 0.6, 0.9]\n".to_owned()),
        (
            "former.toml",
            "[frames.base]\nposition = [1.0, 2.0, 3.0]\nrotation_vector = [0.0, 0.0, 1.5]\n".to_owned(),
        ),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    let cell = folder.join("cell.toml").display().to_string();
    let read = |file: &str| {
        let text = format!("step_ms = 2\nstop_ms = 3000\n[robots.arm]\nbase = {file:?}\n{IRP6}");
        CellFile::parse(&cell, &text)
    };
    let right = read("right.toml").expect("in order");
    assert!(right.cell(&simulated()).is_ok());
    for (file, told) in [
        ("none.toml", "it has no table [frames.base]"),
        ("text.toml", "it is no TOML"),
        ("two.toml", "two.toml:2:7: `xyz` has 2 numbers"),
        ("nan.toml", "nan.toml:2:13: not a finite number"),
        ("far.toml", "far.toml:2:7: a place 1000000000 m away"),
        ("longer.toml", "longer.toml:2:13: a quaternion of length 1.08"),
        ("former.toml", "former.toml:2:1: unknown key `position`"),
        ("nothing.toml", "it cannot be read"),
    ] {
        let why = read(file).expect_err(file).to_string();
        assert!(why.contains(told) && why.contains("cell.toml:4:8"), "{why}");
    }
    std::fs::remove_dir_all(folder).expect("removed");
}
