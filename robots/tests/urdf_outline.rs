//! The shapes of arms read from URDF.

use mrroc_robots::clearance::{Clearance, Obstacle, Outline, Stop, Stopping};
use mrroc_robots::{Serial, SerialOutline, UrdfError};
use nalgebra::Vector3;

/// An upper link that turns about y, 1 m above the base, with a tool fixed to its end; the axes lie along x of tilted frames.
fn urdf(shape: &str) -> String {
    format!(
        r#"<robot name="r"><link name="base"/>
        <link name="arm"><collision><origin xyz="0.25 0 0" rpy="0 1.5707963267948966 0"/>
            <geometry>{shape}</geometry></collision></link>
        <link name="tool"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
        <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 1"/>
            <axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2"/></joint>
        <joint name="mount" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.8 0 0"/></joint></robot>"#
    )
}

fn robot(text: &str) -> Serial<1> {
    Serial::<1>::from_urdf(text, "base", "tool").unwrap().with_acceleration([5.0].into()).unwrap()
}

fn height_above_floor(outline: impl Outline, q: f64) -> (f64, String) {
    let build = Clearance::with_margin(0.0).robot("arm", outline).unwrap();
    let stopping = Stopping { reaction: 0.0, stop: Stop::Braking };
    let mut clearance = build.obstacle("floor", Obstacle::table(0.0)).unwrap().build(stopping).unwrap();
    let nearest = clearance.nearest_at(&[&[q]]).unwrap();
    (nearest.distance, nearest.sides[0].to_string())
}

#[test]
fn collision_shapes_stand_where_the_file_puts_them() {
    let text = urdf(r#"<cylinder radius="0.05" length="0.5"/>"#);
    let outline = SerialOutline::from_urdf(robot(&text), &text, "base", "tool").unwrap();
    let mut capsules = Vec::new();
    outline.capsules(&[0.5].into(), &mut |capsule| capsules.push(capsule));
    // Along x of the arm from its joint, 0.5 m, turned downwards by 0.5 rad; the tool 0.8 m out.
    let along = Vector3::new(0.5_f64.cos(), 0.0, -0.5_f64.sin());
    assert_eq!(capsules.len(), 2);
    assert!((capsules[0].ends[0] - Vector3::z()).amax() < 1e-15);
    assert!((capsules[0].ends[1] - Vector3::z() - along * 0.5).amax() < 1e-15);
    assert!((capsules[1].ends[0] - Vector3::z() - along * 0.8).amax() < 1e-15);
    // The ball of the tool hangs 0.8 sin(0.5) below the joint.
    let (height, nearest) = height_above_floor(outline, 0.5);
    assert!((height - (1.0 - 0.8 * 0.5_f64.sin() - 0.1)).abs() < 1e-12);
    assert_eq!(nearest, "arm tool");
}

#[test]
fn a_box_is_covered() {
    let text = urdf(r#"<box size="0.2 0.1 0.5"/>"#);
    let outline = SerialOutline::from_urdf(robot(&text), &text, "base", "tool").unwrap();
    let mut capsules = Vec::new();
    outline.capsules(&[0.0].into(), &mut |capsule| capsules.push(capsule));
    // Four rods of 0.1 x 0.05 m and the ball.
    assert_eq!(capsules.len(), 5);
    assert!(capsules[..4].iter().all(|capsule| (capsule.radius - 0.5 * 0.1_f64.hypot(0.05)).abs() < 1e-15));
}

#[test]
fn a_mesh_and_a_file_without_shapes_are_refused() {
    let text = urdf(r#"<mesh filename="arm.stl"/>"#);
    let refused = SerialOutline::from_urdf(robot(&text), &text, "base", "tool").unwrap_err();
    assert!(matches!(refused, UrdfError::UnsupportedCollision { line: 3, .. }), "{refused}");
    let text = urdf(r#"<sphere radius="0"/>"#);
    let refused = SerialOutline::from_urdf(robot(&text), &text, "base", "tool").unwrap_err();
    assert!(matches!(refused, UrdfError::BadValue { .. }), "{refused}");
    let text = r#"<robot name="r"><link name="base"/><link name="tool"/><joint name="turn" type="revolute">
        <parent link="base"/><child link="tool"/><limit lower="-2" upper="2" velocity="2"/></joint></robot>"#;
    let refused = SerialOutline::from_urdf(robot(text), text, "base", "tool").unwrap_err();
    assert!(matches!(refused, UrdfError::NoCollision { .. }), "{refused}");
}

#[test]
fn bars_with_a_radius_run_from_joint_to_joint() {
    let text = urdf(r#"<mesh filename="arm.stl"/>"#);
    let (height, nearest) = height_above_floor(SerialOutline::new(robot(&text), 0.07), 0.5);
    assert!((height - (1.0 - 0.8 * 0.5_f64.sin() - 0.07)).abs() < 1e-12);
    assert_eq!(nearest, "arm link 1");
}
