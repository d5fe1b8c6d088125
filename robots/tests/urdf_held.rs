//! A joint that mimics with multiplier 0 is a fixed joint, which stands at its offset.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_robots::clearance::Outline;
use mrroc_robots::{Driven, Meshes, Serial, SerialOutline};
use nalgebra::{Point3, SVector, Vector2, Vector3};

/// Two joints that move, and between them one that is held at 0.4 rad by multiplier 0, and a slide that follows that one: 3 times 0.4
/// and 0.05 make 1.25 m.
const HELD: &str = r#"<robot name="held"><link name="base"/><link name="arm"/>
<link name="bent"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/></inertial></link>
<link name="out"><inertial><mass value="3"/></inertial><collision><origin xyz="0 0 0.2"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="tip"/>
<joint name="turn" type="revolute"><origin xyz="0 0 0.5"/><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="2" velocity="3"/></joint>
<joint name="bend" type="revolute"><origin xyz="0.4 0 0" rpy="0.1 0 0"/><parent link="arm"/><child link="bent"/><axis xyz="1 2 2"/>
<limit lower="-1" upper="1" velocity="0.001"/><mimic joint="turn" multiplier="0" offset="0.4"/></joint>
<joint name="reach" type="prismatic"><origin xyz="0 0.1 0"/><parent link="bent"/><child link="out"/><axis xyz="0 1 0"/>
<limit lower="0" upper="2" velocity="0.001"/><mimic joint="bend" multiplier="3" offset="0.05"/></joint>
<joint name="wrist" type="revolute"><origin xyz="0 0 0.3"/><parent link="out"/><child link="tip"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="4"/></joint></robot>"#;

fn held() -> Serial<2> {
    Serial::<2>::from_urdf(HELD, "base", "tip")
        .and_then(|robot| robot.with_acceleration(Vector2::new(4.0, 5.0)))
        .expect("sound")
}

/// By hand, joint by joint: up to the link `out`.
fn up_to_out(q: f64) -> Pose {
    let turned = |axis: Vector3<f64>, angle: f64| Pose::rotation(axis * angle);
    Pose::translation(0.0, 0.0, 0.5)
        * turned(Vector3::z(), q)
        * Pose::translation(0.4, 0.0, 0.0)
        * turned(Vector3::x(), 0.1)
        * turned(Vector3::new(1.0, 2.0, 2.0) / 3.0, 0.4)
        * Pose::translation(0.0, 0.1 + 1.25, 0.0)
}

#[test]
fn its_place_is_that_of_its_offset_whatever_its_leader_does() {
    let robot = held();
    assert_eq!(robot.joint_names().collect::<Vec<_>>(), ["turn", "wrist"]);
    let mut random = Random::seeded(36);
    for _ in 0..100 {
        let q = Vector2::new(random.between(-1.0, 2.0), random.between(-3.0, 3.0));
        let by_hand =
            up_to_out(q[0]) * Pose::translation(0.0, 0.0, 0.3) * Pose::rotation(Vector3::y() * q[1]);
        let off = by_hand.inv_mul(&robot.forward(&q));
        assert!(off.translation.vector.norm() < 1e-14 && off.rotation.angle() < 1e-14, "{q}: {off}");
    }
}

#[test]
fn it_narrows_no_limits_and_moves_no_motor() {
    let robot = held();
    let limits = robot.limits();
    // Its own velocity of 1 mm/s and its range are asked of nobody.
    assert_eq!((limits.lower[0], limits.upper[0], limits.velocity[0]), (-1.0, 2.0, 3.0));
    // Weight: 2 kg on the link that is bent and 3 kg farther out are behind the upright axis, which they do not load; lying on its side,
    // with z to the horizon, they do.
    let q = Vector2::new(0.3, 0.2);
    let loads = |robot: &Serial<2>| robot.shafts(&robot.motors(&q), &Vector2::zeros()).loads;
    assert!(loads(&robot).amax() < 1e-12);
    let turned = Pose::rotation(Vector3::x() * -core::f64::consts::FRAC_PI_2);
    let robot = robot.with_base(turned);
    let bent = up_to_out(q[0]) * Pose::translation(0.0, -1.35, 0.0) * Point3::new(0.1, 0.2, 0.3);
    let out = up_to_out(q[0]) * Point3::origin();
    // z of the world is -y of the base here, so a turn by dq about its z raises a point by -x dq.
    let raised = -(2.0 * bent.x + 3.0 * out.x);
    let gear = robot.motors(&Vector2::new(1.0, 0.0))[0];
    let load = loads(&robot)[0] * gear;
    assert!((load - 9.80665 * raised).abs() < 1e-9, "{load} is not {}", 9.80665 * raised);
}

#[test]
fn it_is_the_robot_whose_joint_is_written_fixed_there() {
    let slide = |joint: &str| {
        let text = format!(
            "<robot name=\"r\"><link name=\"base\"/><link name=\"arm\"/><link name=\"hand\"><inertial><mass value=\"2\"/>\
             </inertial></link><joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"arm\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"2\" velocity=\"3\"/></joint>{joint}</robot>"
        );
        Serial::<1>::from_urdf(&text, "base", "hand")
            .and_then(|robot| robot.with_acceleration([4.0].into()))
            .expect("sound")
    };
    let ends = "<parent link=\"arm\"/><child link=\"hand\"/>";
    let fixed =
        slide(&format!("<joint name=\"out\" type=\"fixed\"><origin xyz=\"0.75 0 0\"/>{ends}</joint>"));
    // Also where its leader is no joint of the chain.
    for leader in ["turn", "finger"] {
        let held = slide(&format!(
            "<joint name=\"out\" type=\"prismatic\"><origin xyz=\"0.5 0 0\"/>{ends}<axis xyz=\"1 0 0\"/>\
             <limit lower=\"0\" upper=\"0.3\" velocity=\"1\"/><mimic joint=\"{leader}\" multiplier=\"0\" offset=\"0.25\"/></joint>"
        ));
        assert_eq!(held, fixed, "{leader}");
    }
}

#[test]
fn an_arm_with_one_still_has_its_closed_form() {
    let path = format!("{}/tests/reference/urdf/ortho_parallel.urdf", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("it is there");
    let more = "<link name=\"held\"/><joint name=\"hold\" type=\"revolute\"><parent link=\"tool0\"/><child link=\"held\"/>\
                <axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\"/>\
                <mimic joint=\"joint_2\" multiplier=\"0\" offset=\"0.3\"/></joint></robot>";
    let text = text.replace("</robot>", more);
    let arm = |tip: &str| {
        Serial::<6>::from_urdf(&text, "base_link", tip)
            .and_then(|robot| robot.with_acceleration(SVector::<f64, 6>::repeat(10.0)))
            .expect("sound")
    };
    let (plain, held) = (arm("tool0"), arm("held"));
    assert!(plain.is_closed_form() && held.is_closed_form());
    let q = SVector::<f64, 6>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
    let expected = plain.forward(&q) * Pose::rotation(Vector3::z() * 0.3);
    let off = expected.inv_mul(&held.forward(&q));
    assert!(off.translation.vector.norm() < 1e-14 && off.rotation.angle() < 1e-14, "{off}");
}

#[test]
fn shapes_behind_it_stand_where_it_has_them() {
    let outline =
        SerialOutline::from_urdf(held(), HELD, "base", "tip", &Meshes::refused()).expect("it has a shape");
    let q = Vector2::new(0.3, 0.2);
    let mut capsules = Vec::new();
    outline.capsules(&q, &mut |capsule| capsules.push(capsule));
    let ball = up_to_out(q[0]) * Point3::new(0.0, 0.0, 0.2);
    assert_eq!(capsules.len(), 1);
    assert!((capsules[0].ends[0] - ball.coords).amax() < 1e-14, "{} is not {ball}", capsules[0].ends[0]);
}
