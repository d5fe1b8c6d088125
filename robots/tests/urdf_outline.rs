//! The shapes of arms read from URDF.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_robots::clearance::{Capsule, Clearance, ClearanceError, Obstacle, Outline, Stop, Stopping};
use mrroc_robots::{DisabledPair, Meshes, Serial, SerialOutline, UrdfError};
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
    let outline = SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &Meshes::refused()).unwrap();
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
    let outline = SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &Meshes::refused()).unwrap();
    let mut capsules = Vec::new();
    outline.capsules(&[0.0].into(), &mut |capsule| capsules.push(capsule));
    // Four rods of 0.1 x 0.05 m and the ball.
    assert_eq!(capsules.len(), 5);
    assert!(capsules[..4].iter().all(|capsule| (capsule.radius - 0.5 * 0.1_f64.hypot(0.05)).abs() < 1e-15));
}

#[test]
fn a_mesh_without_its_folder_and_a_file_without_shapes_are_refused() {
    let text = urdf(r#"<mesh filename="arm.stl"/>"#);
    let refused =
        SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &Meshes::refused()).unwrap_err();
    assert!(matches!(refused, UrdfError::NoMesh { line: 3, .. }), "{refused}");
    let text = urdf(r#"<sphere radius="0"/>"#);
    let refused =
        SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &Meshes::refused()).unwrap_err();
    assert!(matches!(refused, UrdfError::BadValue { .. }), "{refused}");
    let text = r#"<robot name="r"><link name="base"/><link name="tool"/><joint name="turn" type="revolute">
        <parent link="base"/><child link="tool"/><limit lower="-2" upper="2" velocity="2"/></joint></robot>"#;
    let refused =
        SerialOutline::from_urdf(robot(text), text, "base", "tool", &Meshes::refused()).unwrap_err();
    assert!(matches!(refused, UrdfError::NoCollision { .. }), "{refused}");
}

#[test]
fn bars_with_a_radius_run_from_joint_to_joint() {
    let text = urdf(r#"<mesh filename="arm.stl"/>"#);
    let (height, nearest) = height_above_floor(SerialOutline::new(robot(&text), 0.07), 0.5);
    assert!((height - (1.0 - 0.8 * 0.5_f64.sin() - 0.07)).abs() < 1e-12);
    assert_eq!(nearest, "arm link 1");
    let thin = Clearance::with_margin(0.0).robot("arm", SerialOutline::new(robot(&text), 0.0));
    assert!(matches!(thin.err(), Some(ClearanceError::BadBody { body }) if &*body == "arm link 0"));
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
    let of_text = |robot| SerialOutline::from_urdf(robot, &text, "base", "tool", &Meshes::refused()).unwrap();
    the_chain_is_the_outline(&of_text(arm::<4>(&text, "base", "tool")));
}

#[test]
fn a_chain_has_slides_but_no_bars_that_change_their_length() {
    let gantry = include_str!("reference/urdf/gantry.urdf");
    assert_eq!(SerialOutline::new(arm::<4>(gantry, "bed", "tool"), 0.05).chain(), None);
    let text = with_cylinders(gantry, &["bed", "carriage", "head"]);
    let robot = arm::<4>(&text, "bed", "tool");
    let outline = SerialOutline::from_urdf(robot, &text, "bed", "tool", &Meshes::refused()).unwrap();
    assert_eq!(outline.links().len(), 3);
    the_chain_is_the_outline(&outline);
}

/// A folder with a cube of 0.2 m in millimetres, `meshes/cube.obj`.
fn folder_with_a_cube(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("mrroc-outline-{name}-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("meshes")).unwrap();
    let corner =
        |k: i32| format!("v {} {} {}\n", 200 * (k & 1) - 100, 100 * (k & 2) - 100, 50 * (k & 4) - 100);
    let corners: String = (0..8).map(corner).collect();
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.join("meshes/cube.obj"), corners + faces).unwrap();
    std::fs::write(folder.join("meshes/cut.stl"), [0; 100]).unwrap();
    folder
}

#[test]
fn a_mesh_is_covered_where_the_file_puts_it() {
    let folder = folder_with_a_cube("covered");
    let text = urdf(r#"<mesh filename="package://r/meshes/cube.obj" scale="0.001 0.001 0.001"/>"#);
    let outline =
        SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &Meshes::below(&folder)).unwrap();
    assert!(outline.links().len() > 2);
    the_chain_is_the_outline(&outline);
    // Straight out, the cube reaches from 0.15 to 0.35 m along x, and 0.1 m to each side.
    let mut capsules = Vec::new();
    outline.capsules(&[0.0].into(), &mut |capsule| capsules.push(capsule));
    let (tool, cube) = capsules.split_last().unwrap();
    assert_eq!(tool.radius, 0.1);
    let most = |axis: usize, sign: f64| {
        let reach = |capsule: &Capsule| {
            let ends = capsule.ends.map(|end| sign * end[axis]);
            ends[0].max(ends[1]) + capsule.radius
        };
        cube.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
    };
    let faces =
        [(0, -1.0, -0.15), (0, 1.0, 0.35), (1, -1.0, 0.1), (1, 1.0, 0.1), (2, -1.0, -0.9), (2, 1.0, 1.1)];
    for (axis, sign, face) in faces {
        let most = most(axis, sign);
        assert!((-1e-9..5e-3 + 1e-9).contains(&(most - face)), "{axis} {sign}: {most}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn fault_242_a_mesh_that_is_elsewhere_or_broken_is_refused_by_its_name() {
    let folder = folder_with_a_cube("refused");
    let refused = |name: &str| {
        let text = urdf(&format!(r#"<mesh filename="{name}"/>"#));
        let meshes = Meshes::below(folder.join("meshes"));
        SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &meshes).unwrap_err()
    };
    let above = format!("../../{}/meshes/cube.obj", folder.file_name().unwrap().to_str().unwrap());
    let absolute = folder.join("meshes/cube.obj").display().to_string();
    for name in ["missing.stl", "cube.step", &above, &absolute] {
        let refused = refused(name);
        assert!(matches!(refused, UrdfError::NoMesh { line: 3, .. }), "{refused}");
    }
    let broken = refused("cut.stl");
    assert!(matches!(broken, UrdfError::BadMesh { line: 3, .. }), "{broken}");
    assert!(broken.to_string().contains("cut.stl"), "{broken}");
    // 200 m: nobody wrote the scale.
    let large = refused("cube.obj").to_string();
    assert!(large.contains("cube.obj") && large.contains("scale"), "{large}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn pairs_that_an_srdf_disables_are_not_checked() {
    let srdf = r#"<robot name="r"><group name="arm"><chain base_link="base" tip_link="tool"/></group>
        <disable_collisions link1="base" link2="arm" reason="Adjacent"/>
        <disable_collisions link1="base" link2="tool"/></robot>"#;
    let pairs = DisabledPair::from_srdf(srdf).unwrap();
    assert_eq!(pairs.len(), 2);
    assert_eq!(pairs[0].links, ["base", "arm"]);
    assert_eq!([&pairs[0].reason, &pairs[1].reason], [&Some("Adjacent".to_owned()), &None]);

    let seven = include_str!("reference/urdf/seven_axes.urdf");
    let names: Vec<String> = {
        let document = roxmltree::Document::parse(seven).unwrap();
        let links = document.descendants().filter(|node| node.has_tag_name("link"));
        links.filter_map(|link| link.attribute("name").map(str::to_owned)).collect()
    };
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let text = with_cylinders(seven, &names);
    let outline = || {
        let robot = arm::<7>(&text, "world_foot", "flange");
        SerialOutline::from_urdf(robot, &text, "world_foot", "flange", &Meshes::refused()).unwrap()
    };
    let links = outline().links();
    let (first, last) = (&links[0], links.last().unwrap());
    let pair = DisabledPair { links: [last.name.to_string(), first.name.to_string()], reason: None };
    let pairs_with = |disabled: &[DisabledPair]| {
        let build = Clearance::with_margin(0.0).robot("arm", outline()).unwrap();
        let at_rest = Stopping { reaction: 0.0, stop: Stop::Braking };
        build.ignore_disabled("arm", disabled).build(at_rest).unwrap().pairs()
    };
    assert_eq!(pairs_with(&[pair]) + 1, pairs_with(&[]));

    for (wrong, line) in [
        (srdf.replace("link1=\"base\" link2=\"tool\"", "link1=\"base\""), 3),
        (srdf.replace("link2=\"arm\"", "link2=\"base\""), 2),
        (srdf.replace("reason", "because"), 2),
        (srdf.replace("</robot>", "<robot>"), 3),
    ] {
        let refused = DisabledPair::from_srdf(&wrong).unwrap_err();
        assert!(refused.to_string().contains(&format!("line {line}")), "{refused}");
    }
}

/// An arm that turns about z, with a hand behind its tip: a finger that slides along x, one that turns about z, a camera on the upper link, and
/// a cap that turns without end.
const HAND: &str = r#"<robot name="r"><link name="base"/>
    <link name="arm"/>
    <link name="tool"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
    <link name="camera"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
    <link name="hand"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
    <link name="finger"><collision><origin xyz="0 0 0.05"/><geometry><sphere radius="0.01"/></geometry></collision></link>
    <link name="thumb"><collision><origin xyz="0.06 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
    <link name="nail"><collision><origin xyz="0.01 0 0"/><geometry><sphere radius="0.002"/></geometry></collision></link>
    <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.3"/>
        <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="2"/></joint>
    <joint name="mount" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.5 0 0"/></joint>
    <joint name="eye" type="fixed"><parent link="arm"/><child link="camera"/><origin xyz="0.2 0 0.1"/></joint>
    <joint name="wrist" type="fixed"><parent link="tool"/><child link="hand"/><origin xyz="0.1 0 0" rpy="0 0 0.5"/></joint>
    <joint name="slide" type="prismatic"><parent link="hand"/><child link="finger"/><origin xyz="0 0.02 0"/>
        <axis xyz="1 0 0"/><limit lower="-0.01" upper="0.05" velocity="0.1"/></joint>
    <joint name="bend" type="revolute"><parent link="hand"/><child link="thumb"/><origin xyz="0 -0.02 0"/>
        <axis xyz="0 0 1"/><limit lower="-0.3" upper="0.9" velocity="1"/></joint>
    <joint name="tap" type="continuous"><parent link="thumb"/><child link="nail"/><origin xyz="0.06 0 0"/>
        <axis xyz="0 1 0"/></joint></robot>"#;

/// The chain to a link of [`HAND`], whatever moves it.
fn place_of(link: &str, turn: f64, own: [f64; 3]) -> Pose {
    let [slide, bend, tap] = own;
    let arm = Pose::translation(0.0, 0.0, 0.3) * Pose::rotation(Vector3::z() * turn);
    let hand = arm * Pose::translation(0.6, 0.0, 0.0) * Pose::rotation(Vector3::z() * 0.5);
    let thumb = hand * Pose::translation(0.0, -0.02, 0.0) * Pose::rotation(Vector3::z() * bend);
    match link {
        "camera" => arm * Pose::translation(0.2, 0.0, 0.1),
        "hand" => hand,
        "finger" => hand * Pose::translation(slide, 0.02, 0.05),
        "thumb" => thumb * Pose::translation(0.06, 0.0, 0.0),
        "nail" => {
            thumb
                * Pose::translation(0.06, 0.0, 0.0)
                * Pose::rotation(Vector3::y() * tap)
                * Pose::translation(0.01, 0.0, 0.0)
        }
        other => panic!("{other}"),
    }
}

#[test]
fn what_hangs_on_the_links_is_part_of_the_shape_wherever_its_own_joints_stand() {
    let outline = SerialOutline::from_urdf(robot(HAND), HAND, "base", "tool", &Meshes::refused()).unwrap();
    let links = outline.links();
    let excess = Meshes::refused().excess;
    let mut random = Random::seeded(3);
    let mut within = |range: [f64; 2]| random.between(range[0], range[1]);
    for _ in 0..2000 {
        let turn = within([-2.0, 2.0]);
        let own = [within([-0.01, 0.05]), within([-0.3, 0.9]), within([-7.0, 7.0])];
        let mut capsules = Vec::new();
        outline.capsules(&[turn].into(), &mut |capsule| capsules.push(capsule));
        for (link, radius) in
            [("camera", 0.03), ("hand", 0.04), ("finger", 0.01), ("thumb", 0.01), ("nail", 0.002)]
        {
            let centre = place_of(link, turn, own).translation.vector;
            // The ball of the link is within one capsule.
            let holds = |(of, capsule): (&mrroc_robots::clearance::Link, &Capsule)| {
                &*of.name == link && distance_to_axis(capsule, &centre) + radius <= capsule.radius + 1e-12
            };
            assert!(links.iter().zip(&capsules).any(holds), "{link} at {own:?}");
        }
        // What is fixed has not grown; a slide by the stated excess at most, a turn within a turn by that of both.
        for (of, capsule) in links.iter().zip(&capsules) {
            let most = match &*of.name {
                "camera" => 0.03,
                "hand" => 0.04,
                "tool" => 0.02,
                "finger" | "thumb" => 0.01 + excess,
                "nail" => 0.002 + 2.0 * excess,
                other => panic!("{other}"),
            };
            assert!(capsule.radius <= most + 1e-12, "{}: {}", of.name, capsule.radius);
        }
    }
}

/// From a point to the line between a capsule's ends.
fn distance_to_axis(capsule: &Capsule, point: &Vector3<f64>) -> f64 {
    let along = capsule.ends[1] - capsule.ends[0];
    let share = ((point - capsule.ends[0]).dot(&along) / along.norm_squared().max(1e-300)).clamp(0.0, 1.0);
    (point - capsule.ends[0] - along * share).norm()
}

#[test]
fn branches_are_left_out_by_their_first_link_and_an_unknown_one_is_named() {
    let without = Meshes::refused().without("hand");
    let outline = SerialOutline::from_urdf(robot(HAND), HAND, "base", "tool", &without).unwrap();
    let links = outline.links();
    let mut names: Vec<&str> = links.iter().map(|link| &*link.name).collect();
    names.sort_unstable();
    assert_eq!(names, ["camera", "tool"]);
    let unknown = Meshes::refused().without("hant");
    let error = SerialOutline::from_urdf(robot(HAND), HAND, "base", "tool", &unknown).unwrap_err();
    assert!(error.to_string().contains("hant") && error.to_string().contains("hand"), "{error}");
}

#[test]
fn what_swings_far_off_the_chain_is_covered_by_one_ball_for_each_link() {
    // A second arm of 2 m on a shoulder that turns without end: pieces of 5 mm would be 1257.
    let text = HAND.replace(
        "xyz=\"0.01 0 0\"/><geometry><sphere radius=\"0.002\"",
        "xyz=\"2 0 0\"/><geometry><sphere radius=\"0.002\"",
    );
    let outline = SerialOutline::from_urdf(robot(&text), &text, "base", "tool", &Meshes::refused()).unwrap();
    let mut capsules = Vec::new();
    outline.capsules(&[0.0].into(), &mut |capsule| capsules.push(capsule));
    let nails: Vec<_> = outline
        .links()
        .iter()
        .zip(&capsules)
        .filter(|(link, _)| &*link.name == "nail")
        .map(|(_, c)| *c)
        .collect();
    assert!(!nails.is_empty() && nails.iter().all(|nail| nail.radius >= 2.002), "{nails:?}");
}
