//! Calibrated arms: their own dimensions forward, and back to 1e-9.
//!
//! Expected values: the product of the Denavit-Hartenberg matrices, and one calibration that an owner has published.

use core::f64::consts::PI;

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_counting_allocator::count;
use mrroc_robots::{Kinematics, Serial, Six};
use mrroc_ur::{Calibration, UrModel};
use nalgebra::{Matrix3, Matrix4, Vector3};

const POSES: usize = 10_000;

fn drawn(random: &mut Random, distance: f64) -> Six {
    Six::from_fn(|_, _| random.between(-distance, distance))
}

/// The calibration of a UR10 that its owner has published in UR's forum (thread 18921): what it adds to the nominal one.
fn published(model: UrModel) -> Calibration {
    let nominal = Calibration::nominal(model);
    let add = |to: [f64; 6], delta: [f64; 6]| core::array::from_fn(|i| to[i] + delta[i]);
    Calibration {
        theta: add(
            nominal.theta,
            [
                -8.206_424_066_101_864e-5,
                -0.103_609_197_138_685_98,
                0.673_631_891_251_821_1,
                -0.570_169_747_249_608_4,
                -4.596_363_516_758_562e-5,
                9.749_995_611_345_406e-7,
            ],
        ),
        a: add(
            nominal.a,
            [
                -0.000_161_187_342_296_687_12,
                0.003_040_038_437_921_777,
                0.091_646_855_572_178_83,
                -9.629_649_759_531_436e-5,
                -2.975_953_407_621_962e-5,
                0.0,
            ],
        ),
        d: add(
            nominal.d,
            [
                0.000_505_390_894_843_999,
                11.198_451_475_782_104,
                -92.527_032_690_866_82,
                81.328_268_352_070_36,
                -0.000_212_852_818_740_727_48,
                -0.000_126_145_560_998_547_35,
            ],
        ),
        alpha: add(
            nominal.alpha,
            [
                -0.000_321_423_998_958_625_4,
                -0.005_650_245_185_401_471,
                -0.003_789_226_218_336_892,
                -0.001_065_332_740_116_442_5,
                0.000_999_586_303_470_856_3,
                0.0,
            ],
        ),
        checksum: [0x06e0_f7bf, 0xa32a_713f, 0x0f63_6a50, 0x9ec2_338a, 0xa1af_ded8, 0xb29b_2979],
    }
}

/// One that is off by up to 1 mrad and 1 mm in every parameter.
fn off(model: UrModel, random: &mut Random) -> Calibration {
    let nominal = Calibration::nominal(model);
    let mut by = |six: [f64; 6]| six.map(|number| number + random.between(-1e-3, 1e-3));
    Calibration {
        theta: by(nominal.theta),
        a: by(nominal.a),
        d: by(nominal.d),
        alpha: by(nominal.alpha),
        ..nominal
    }
}

/// The product of the matrices.
fn product(of: &Calibration, q: &Six) -> Matrix4<f64> {
    (0..6).fold(Matrix4::identity(), |product, i| {
        let (s, c) = (q[i] + of.theta[i]).sin_cos();
        let (sa, ca) = of.alpha[i].sin_cos();
        let (a, d) = (of.a[i], of.d[i]);
        product
            * Matrix4::new(
                c,
                -s * ca,
                s * sa,
                a * c, //
                s,
                c * ca,
                -c * sa,
                a * s, //
                0.0,
                sa,
                ca,
                d, //
                0.0,
                0.0,
                0.0,
                1.0,
            )
    })
}

fn error(pose: &Pose, expected: &Matrix4<f64>) -> f64 {
    let rotation: Matrix3<f64> = expected.fixed_view::<3, 3>(0, 0).into();
    let position: Vector3<f64> = expected.fixed_view::<3, 1>(0, 3).into();
    let turned = (pose.rotation.to_rotation_matrix().into_inner() - rotation).amax();
    turned.max((pose.translation.vector - position).amax())
}

fn apart(one: &Pose, other: &Pose) -> f64 {
    error(one, &other.to_homogeneous())
}

fn arm(model: UrModel, calibration: &Calibration) -> Serial<6> {
    model.calibrated(Pose::identity(), calibration).unwrap_or_else(|why| panic!("{model:?}: {why}"))
}

fn arms(random: &mut Random) -> Vec<(UrModel, Calibration)> {
    let mut arms: Vec<_> = UrModel::ALL.into_iter().map(|model| (model, off(model, random))).collect();
    arms.push((UrModel::Ur10e, published(UrModel::Ur10e)));
    arms
}

#[test]
fn an_arm_has_the_poses_of_its_own_parameters() {
    let mut random = Random::seeded(18_921);
    for (model, calibration) in arms(&mut random) {
        let arm = arm(model, &calibration);
        let base = Pose::translation(0.3, -0.2, 0.5) * Pose::rotation(Vector3::new(0.1, 0.2, 2.0));
        let moved = model.calibrated(base, &calibration).expect("the same");
        for _ in 0..1000 {
            let q = drawn(&mut random, 6.2);
            let expected = product(&calibration, &q);
            let off = error(&arm.forward(&q), &expected);
            assert!(off < 1e-12, "{model:?} {off}");
            assert!(apart(&moved.forward(&q), &(base * arm.forward(&q))) < 1e-12);
        }
        // Lengths of 92 m cancel out: the frames are where those of the nominal arm are.
        let nominal = model.arm(Pose::identity()).expect("an arm");
        let frames = |arm: &Serial<6>| {
            let mut frames = Vec::new();
            arm.frames(&Six::zeros(), &mut |frame| frames.push(*frame));
            frames
        };
        for (own, other) in frames(&arm).iter().zip(frames(&nominal)) {
            assert!(
                (own.translation.vector - other.translation.vector).norm() < 0.02,
                "{model:?} {own} {other}"
            );
        }
        assert!((arm.reach() - nominal.reach()).abs() < 0.05);
    }
}

#[test]
fn ten_thousand_poses_of_every_arm_come_back_to_a_nanometre_without_allocation() {
    let mut random = Random::seeded(20_261_123);
    for (model, calibration) in arms(&mut random) {
        let arm = arm(model, &calibration);
        assert!(arm.is_closed_form());
        let (mut worst, mut joints, mut singular) = (0.0_f64, 0.0_f64, 0);
        for k in 0..POSES {
            let q = drawn(&mut random, PI);
            let pose = arm.forward(&q);
            let seed = q + drawn(&mut random, 0.05);
            let (found, allocated) = count(|| arm.inverse(&pose, &seed));
            assert_eq!(allocated, 0, "allocations");
            let found = found.unwrap_or_else(|why| panic!("{model:?} pose {k} at {q}: {why}"));
            worst = worst.max(apart(&arm.forward(&found), &pose));
            if arm.near_singularity(&q).is_some() {
                singular += 1;
            } else {
                joints = joints.max((found - q).amax());
            }
        }
        println!("{model:?}: poses to {worst:.1e}, joints to {joints:.1e}, {singular} near a singularity");
        assert!(worst < 1e-9, "{model:?}: {worst}");
        // Away from singularities on the branch of the seed.
        assert!(joints < 1e-6, "{model:?}: {joints}");
    }
}

#[test]
fn all_solutions_of_a_calibrated_arm_have_its_pose() {
    let mut random = Random::seeded(5);
    for (model, calibration) in arms(&mut random) {
        let arm = arm(model, &calibration);
        let mut counts = [0; 9];
        for _ in 0..500 {
            let q = drawn(&mut random, 2.5);
            let pose = arm.forward(&q);
            let (mut count, mut own) = (0, false);
            let visited = arm.solutions(&pose, &q, &mut |found| {
                count += 1;
                own |= (found - q).amax() < 1e-6;
                let off = apart(&arm.forward(found), &pose);
                assert!(off < 1e-9, "{model:?} {off}");
            });
            if arm.near_singularity(&q).is_none() {
                visited.unwrap_or_else(|why| panic!("{model:?} {q}: {why}"));
                assert!(own, "{model:?} {q}");
                counts[count] += 1;
            }
        }
        // Most poses have four or eight.
        assert!(counts[4] + counts[8] > 300, "{model:?} {counts:?}");
    }
}

#[test]
fn the_calibration_of_another_model_is_refused() {
    for model in [UrModel::Ur3e, UrModel::Ur5e, UrModel::Ur16e, UrModel::Ur20, UrModel::Ur30] {
        let other = Calibration::nominal(UrModel::Ur10e);
        let Err(why) = model.calibrated(Pose::identity(), &other) else { panic!("{model:?} takes it") };
        assert!(why.to_string().contains("it is another model"), "{why}");
    }
}

#[test]
fn a_file_gives_the_same_calibration_back_and_what_is_none_is_refused() {
    let calibration = published(UrModel::Ur10e);
    let text = calibration.text(UrModel::Ur10e);
    assert_eq!(Calibration::parse(&text), Ok((UrModel::Ur10e, calibration)));
    for (from, to, told) in [
        ("ur10e", "ur10", "its `model` is none of"),
        ("theta = [", "theta = [1.0, ", "its `theta` is not six numbers"),
        ("alpha = [", "alpha = [nan, ", "its `alpha` is not six numbers"),
        ("\nd = [", "\nd = 4 # [", "its `d` is not six numbers"),
        ("checksum = [", "checksum = [-1, 2, 3, 4, 5, 6] # ", "its `checksum` is not six whole numbers"),
        ("\na = [", "\nb = [", "a calibration has no `b`"),
        ("model =", "model", "it is no TOML"),
        ("\nd = [", "\nd = [1e5, 0, 0, 0, 0, 0] # ", "no arm has such lengths"),
    ] {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        let why = Calibration::parse(&changed).expect_err(to).to_string();
        assert!(why.contains(told), "{why}");
    }
}
