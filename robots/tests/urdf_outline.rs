//! The shapes of arms read from URDF.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_robots::clearance::{Clearance, Obstacle, Outline, Stop, Stopping};
use mrroc_robots::{Serial, SerialOutline, UrdfError};
use nalgebra::{SVector, Vector3};

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

/// An arm of `tests/reference/urdf` with a base of its own.
#[allow(non_snake_case)]
fn arm<const N: usize>(text: &str, base: &str, tip: &str) -> Serial<N> {
    let built = Serial::<N>::from_urdf(text, base, tip).unwrap();
    let X_WB = Pose::new(Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.2, 0.4, -1.0));
    built.with_acceleration(SVector::repeat(0.5)).unwrap().with_base(X_WB)
}

/// Compares the capsules of a chain, and its flange, with those of the outline and the robot.
fn the_chain_is_the_outline<const N: usize>(outline: &SerialOutline<N>) {
    let chain = outline.chain().expect("a chain");
    assert_eq!(chain.bodies.len(), outline.links().len());
    let mut random = Random::seeded(7);
    for _ in 0..200 {
        let q = SVector::<f64, N>::from_fn(|_, _| 6.0 * random.unit() - 3.0);
        let mut expected = Vec::new();
        outline.capsules(&q, &mut |capsule| expected.push(capsule));
        let capsules = chain.capsules(q.as_slice());
        assert_eq!(capsules.len(), expected.len());
        for (capsule, expected) in capsules.iter().zip(&expected) {
            for (end, there) in capsule.ends.iter().zip(&expected.ends) {
                assert!((end - there).amax() < 1e-12, "{end} is not {there}");
            }
            assert_eq!(capsule.radius, expected.radius);
        }
        let flange = chain.frames(q.as_slice()).last().copied().unwrap();
        let apart = flange.translation.vector - outline.robot().forward(&q).translation.vector;
        assert!(apart.amax() < 1e-12, "{apart}");
    }
}

/// The text of an arm, with a cylinder beside the origin of each of these links.
fn with_cylinders(text: &str, links: &[&str]) -> String {
    let shape = r#"<origin xyz="0.1 0.2 0.3" rpy="0 0 1"/><geometry><cylinder radius="0.1" length="0.2"/></geometry>"#;
    links.iter().fold(text.to_owned(), |text, link| {
        let begin = format!("<link name=\"{link}\"");
        text.replace(&format!("{begin}/>"), &format!("{begin}><collision>{shape}</collision></link>"))
    })
}

#[test]
fn the_chain_of_an_outline_has_its_capsules_in_every_posture() {
    let seven = include_str!("reference/urdf/seven_axes.urdf");
    the_chain_is_the_outline(&SerialOutline::new(arm::<7>(seven, "world_foot", "flange"), 0.05));
    // Two joints of this one mimic others, and so does the slide that its last link is on.
    let palletiser = include_str!("reference/urdf/palletiser.urdf");
    the_chain_is_the_outline(&SerialOutline::new(arm::<4>(palletiser, "base", "hand"), 0.05));
    let text = with_cylinders(palletiser, &["base", "lower", "level_2", "slide", "tool"]);
    let of_text = |robot| SerialOutline::from_urdf(robot, &text, "base", "tool").unwrap();
    the_chain_is_the_outline(&of_text(arm::<4>(&text, "base", "tool")));
}

#[test]
fn a_chain_has_slides_but_no_bars_that_change_their_length() {
    let gantry = include_str!("reference/urdf/gantry.urdf");
    assert_eq!(SerialOutline::new(arm::<4>(gantry, "bed", "tool"), 0.05).chain(), None);
    let text = with_cylinders(gantry, &["bed", "carriage", "head"]);
    let outline = SerialOutline::from_urdf(arm::<4>(&text, "bed", "tool"), &text, "bed", "tool").unwrap();
    assert_eq!(outline.links().len(), 3);
    the_chain_is_the_outline(&outline);
}
