//! Poses of `cell.toml`: the forms of an orientation, and what is wrong with a pose.

use mrroc::cell_file::RobotEntry;
use mrroc::pose::Pose;
use mrroc::prelude::*;

use super::{GOOD, complaints};

/// The base of the arm on the right, with this pose.
fn base(pose: &str) -> Pose {
    let text = GOOD.replace("{ xyz = [0.0, 1.5, 0.0], zyz = [2.5, 0.0, 0.0] }", pose);
    let file = CellFile::parse("cell.toml", &text).expect(pose);
    file.robots().iter().find(|robot| robot.name() == "right").map(RobotEntry::base).expect("it is there")
}

/// scipy 1.17: `Rotation.from_euler("xyz", [0.3, -0.7, 1.9])`, turns about the fixed axes: `as_matrix`, `as_quat`, `as_euler("ZYZ")`.
const MATRIX: [[f64; 3]; 3] = [
    [-0.247_265_499_446_136_54, -0.842_487_347_747_248_8, 0.478_617_636_187_237_2],
    [0.723_770_228_894_345_3, -0.489_006_309_763_144_1, -0.486_856_739_480_988],
    [0.644_217_687_237_691, 0.226_026_321_249_623_02, 0.730_681_649_935_512_2],
];

#[test]
fn an_orientation_is_the_same_as_rpy_as_a_quaternion_and_as_zyz() {
    for orientation in [
        "rpy = [0.3, -0.7, 1.9]",
        "quat_xyzw = [0.3574420094160363, -0.08303243304197462, 0.785326915867652, 0.4986005015857463]",
        // The same rotation.
        "quat_xyzw = [-0.3574420094160363, 0.08303243304197462, -0.785326915867652, -0.4986005015857463]",
        "zyz = [-0.7939316921029851, 0.7514764738032209, 2.8041572782074233]",
    ] {
        let base = base(&format!("{{ xyz = [1, 2.5, -0.5], {orientation} }}"));
        assert_eq!(base.translation.vector.as_slice(), [1.0, 2.5, -0.5]);
        let matrix = base.rotation.to_rotation_matrix();
        for (i, row) in MATRIX.iter().enumerate() {
            for (j, expected) in row.iter().enumerate() {
                let got = matrix[(i, j)];
                assert!((got - expected).abs() < 1e-15, "{orientation}, row {i}, column {j}: {got}");
            }
        }
    }
}

#[test]
fn a_pose_without_an_orientation_is_not_rotated_and_one_without_xyz_is_at_the_origin() {
    assert_eq!(base("{ xyz = [1.0, 2.0, 3.0] }"), Pose::translation(1.0, 2.0, 3.0));
    assert_eq!(base("{}"), Pose::identity());
    assert_eq!(base("{ rpy = [0, 0, 0] }"), Pose::identity());
    assert_eq!(base("{ quat_xyzw = [0, 0, 0, 1] }"), Pose::identity());
    assert_eq!(base("{ zyz = [0, 0, 0] }"), Pose::identity());
}

#[test]
fn a_quaternion_is_normalised_if_its_length_is_1_within_1e_6() {
    for length in [1.0 - 0.99e-6, 1.0, 1.0 + 0.99e-6] {
        let [z, w] = [0.6 * length, 0.8 * length];
        let rotation = base(&format!("{{ quat_xyzw = [0, 0, {z}, {w}] }}")).rotation;
        assert!((rotation.quaternion().norm() - 1.0).abs() < 1e-15, "{length}");
        // w is the cosine of half the angle.
        assert!((rotation.angle() - 2.0 * 0.8_f64.acos()).abs() < 1e-15, "{length}");
    }
    for (length, told) in [
        (1.0 - 1.01e-6, "a quaternion of length 0.99999"),
        (1.0 + 1.01e-6, "a quaternion of length 1.00000"),
        (0.0, "a quaternion of length 0,"),
    ] {
        let [z, w] = [0.6 * length, 0.8 * length];
        let text = format!("{GOOD}\n[frames.table]\nquat_xyzw = [0, 0, {z}, {w}]\n");
        let told_of = complaints(&text);
        assert!(told_of.contains(told), "{told_of}");
    }
}

#[test]
fn what_is_wrong_with_a_pose_is_told_with_its_place_and_what_to_write() {
    let wrong = format!(
        "{GOOD}{}",
        r#"
[frames.former]
position = [0.4, 0.0, 0.1]

[frames.two]
zyz = [0.0, 0.0, 0.0]
rpy = [0.0, 0.0, 1.57]

[frames.three]
quat_xyzw = [0.0, 0.0, 0.0, 1.0]
zyz = [0.0, 0.0, 0.0]
rpy = [0.0, 0.0, 1.57]

[frames.long]
quat_xyzw = [1.0, 0.0, 0.0, 1.0]

[frames.short]
quat_xyzw = [0.0, 0.0, 1.0]

[frames.other]
rotation_vector = [0.0, 0.0, 1.57]

[tools.pen]
position = [0.0, 0.0, 0.1]
rpy = [0.0, 1.57]
"#
    );
    insta::assert_snapshot!(complaints(&wrong));
}
