//! Every bad URDF is refused with a message that names the element and says what to write.

use mrroc::robot::Robot;
use mrroc_robots::{Serial, UrdfError};
use nalgebra::{SVector, Vector2};

/// Two links moved by two joints, with a fixed tip; `{..}` is replaced by the tests.
const SOUND: &str = r#"<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="arm"><visual><geometry><mesh filename="../../arm.stl"/></geometry></visual></link>
  <link name="hand"/>
  <link name="tip"/>
  <joint name="turn" type="revolute">
    <origin xyz="0 0 0.5" rpy="0 0 0"/>
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" effort="5" velocity="3"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin xyz="0.4 0 0"/>
    <parent link="arm"/>
    <child link="hand"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.3" effort="5" velocity="1"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="hand"/>
    <child link="tip"/>
  </joint>
</robot>"#;

/// What the reader says of the sound text with `from` replaced by `to`.
fn refusal(from: &str, to: &str) -> String {
    assert!(SOUND.contains(from), "{from}");
    of(&SOUND.replacen(from, to, 1))
}

fn of(text: &str) -> String {
    between(text, "base", "tip")
}

fn between(text: &str, base: &str, tip: &str) -> String {
    match Serial::<2>::from_urdf(text, base, tip) {
        Ok(_) => panic!("it was read: {text}"),
        Err(why) => why.to_string(),
    }
}

#[test]
fn the_sound_text_gives_its_limits_and_names() {
    let robot = Serial::<2>::from_urdf(SOUND, "base", "tip")
        .and_then(|robot| robot.with_acceleration(Vector2::new(4.0, 5.0)))
        .and_then(|robot| robot.with_jerk(Vector2::new(40.0, 50.0)))
        .expect("sound");
    let limits = robot.limits();
    assert_eq!((limits.lower, limits.upper), (Vector2::new(-1.0, 0.0), Vector2::new(2.0, 0.3)));
    assert_eq!((limits.velocity, limits.acceleration), (Vector2::new(3.0, 1.0), Vector2::new(4.0, 5.0)));
    assert_eq!(limits.jerk, Some(Vector2::new(40.0, 50.0)));
    assert_eq!(robot.joint_names().collect::<Vec<_>>(), ["turn", "slide"]);
    let pose = robot.forward(&Vector2::new(0.0, 0.1));
    assert_eq!(pose.translation.vector, nalgebra::Vector3::new(0.5, 0.0, 0.5));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let why = Serial::<2>::from_urdf_file("/no/such/robot.urdf", "base", "tip").expect_err("no file");
    assert!(matches!(why, UrdfError::File { .. }));
    assert!(why.to_string().starts_with("/no/such/robot.urdf: No such file"), "{why}");
}

#[test]
fn what_is_not_xml_is_refused_with_line_and_column() {
    assert_eq!(refusal("</robot>", ""), "line 24, column 11: not well-formed XML: it ends inside an element");
    let why = refusal("<child link=\"arm\"/>", "<child link=\"arm\">");
    assert!(why.starts_with("line 13, column 3: not well-formed XML"), "{why}");
    assert!(of("").contains("not well-formed XML"));
}

#[test]
fn another_root_element_is_named() {
    assert_eq!(of("<sdf/>"), "line 1: the root element is <sdf>: a URDF begins with <robot>");
}

#[test]
fn xacro_is_refused_with_the_command_that_expands_it() {
    let help = "is xacro, not URDF: expand it first, `xacro robot.urdf.xacro > robot.urdf`";
    let text =
        "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:include filename=\"a\"/></robot>";
    assert_eq!(of(text), format!("line 2: <xacro:include> {help}"));
    assert_eq!(
        of("<robot><xacro:include filename=\"a\"/></robot>"),
        format!("line 1: the prefix xacro: {help}")
    );
    assert_eq!(refusal("0 0 0.5", "0 0 ${height}"), format!("line 8: xyz=\"0 0 ${{height}}\" {help}"));
}

#[test]
fn entities_long_tags_and_huge_files_are_refused_quickly() {
    let bomb = "<!DOCTYPE robot [<!ENTITY a \"aaaa\">]><robot/>";
    assert_eq!(of(bomb), "line 1: a document type declaration: remove <!DOCTYPE ..>, URDF has none");
    let long = format!("<robot>\n<link {}/></robot>", "a=\"\" ".repeat(100_000));
    assert_eq!(
        of(&long),
        "line 2: an element of more than 128 attributes: remove what a URDF has no need of"
    );
    let at = of("<?xml version=\"1.0\"?>\n<!-- of a robot -->\n<!DOCTYPE robot><robot/>");
    assert_eq!(at, "line 3: a document type declaration: remove <!DOCTYPE ..>, URDF has none");
    // Long texts, comments and blanks are none of its elements.
    let talk = format!("<!-- a < b {} --><note>{}</note>", "c".repeat(5000), " ".repeat(5000));
    assert_eq!(of(&format!("<robot>{talk}</robot>")), of("<robot></robot>"));
    let huge = " ".repeat(9 << 20);
    assert!(of(&huge).starts_with("the URDF has more than 8388608 bytes"));
    let many = format!("<robot>{}</robot>", "<a/>".repeat(1_000_000));
    assert!(of(&many).starts_with("the URDF has more than"));
    let deep = "<robot>".repeat(100_000);
    assert!(of(&deep).contains("not well-formed XML"));
}

#[test]
fn fault_76_namespaces_of_a_urdf_that_are_nested_without_measure_are_refused() {
    // Some seconds of comparisons for the XML reader, if it saw them.
    let nested: String = (0..4000).map(|i| format!("<a xmlns:n{i}=\"u\">")).collect();
    assert_eq!(
        of(&format!("<robot>\n{nested}")),
        "line 2: more than 32 declarations of namespaces within one another: remove what a URDF has no need of"
    );
}

#[test]
fn sixty_thousand_links_are_read_in_time_that_grows_with_them() {
    let mut text = String::from("<robot>\n<link name=\"l0\"/>\n");
    for i in 1..60_000 {
        text += &format!(
            "<link name=\"l{i}\"/>\n<joint name=\"j{i}\" type=\"fixed\"><parent link=\"l{}\"/><child link=\"l{i}\"/></joint>\n",
            i - 1
        );
    }
    text += "</robot>";
    assert!(between(&text, "l0", "l59999").contains("has 0 moving joints (none), Serial<2> was asked for"));
}

#[test]
fn a_link_that_was_asked_for_and_is_not_there_is_named_with_those_that_are() {
    assert_eq!(
        between(SOUND, "bsae", "tip"),
        "the URDF has no link \"bsae\", asked for as base: write one of its 4 links, such as base, arm, hand, tip"
    );
    assert!(between(SOUND, "base", "tool").starts_with(
        "the URDF has no link \"tool\", asked for as tip: write one of its 4 links, such as tip"
    ));
}

#[test]
fn a_tip_that_does_not_hang_on_the_base_is_refused() {
    assert_eq!(
        between(SOUND, "tip", "base"),
        "link \"base\" does not hang on link \"tip\": it is the other way round: swap base and tip"
    );
    let two = SOUND.replace("<link name=\"tip\"/>", "<link name=\"tip\"/><link name=\"other\"/>");
    assert_eq!(
        between(&two, "other", "tip"),
        "link \"tip\" does not hang on link \"other\": its topmost link is \"base\": write that as base, or one below it"
    );
}

#[test]
fn a_chain_with_another_number_of_joints_says_what_to_write() {
    let count = |base, tip| between(SOUND, base, tip);
    assert_eq!(
        count("base", "arm"),
        "the chain from \"base\" to \"arm\" has 1 moving joints (turn), Serial<2> was asked for: write Serial<1>"
    );
    assert!(count("base", "base").ends_with("choose a tip beyond a joint that moves"));
    let why = Serial::<6>::from_urdf(SOUND, "base", "tip").expect_err("two joints").to_string();
    assert!(
        why.ends_with("has 2 moving joints (turn, slide), Serial<6> was asked for: write Serial<2>"),
        "{why}"
    );
}

/// `count` continuous joints in a row.
fn row_of(count: usize) -> String {
    let mut text = String::from("<robot><link name=\"l0\"/>");
    for i in 1..=count {
        text += &format!(
            "<link name=\"l{i}\"/><joint name=\"j{i}\" type=\"continuous\"><parent link=\"l{}\"/><child link=\"l{i}\"/>\
             <limit velocity=\"1\"/></joint>",
            i - 1
        );
    }
    text + "</robot>"
}

#[test]
fn a_chain_longer_than_any_robot_is_refused() {
    assert!(between(&row_of(9), "l0", "l9").ends_with("a robot has at most 8, choose a shorter chain"));
    assert_eq!(
        between(&row_of(17), "l0", "l17"),
        "the chain from \"l0\" to \"l17\" has more than 16 joints that move, mimic joints included"
    );
}

#[test]
fn loops_and_second_parents_are_refused() {
    let second = "</joint><joint name=\"strut\" type=\"fixed\"><parent link=\"base\"/><child link=\"tip\"/></joint></robot>";
    assert_eq!(
        refusal("</joint>\n</robot>", second),
        "line 24: link \"tip\" is the child of joint \"mount\" and of joint \"strut\": a URDF is a tree, a link has one parent"
    );
    let why = refusal("<parent link=\"base\"/>", "<parent link=\"tip\"/>");
    assert!(why.contains("closes a loop through link"), "{why}");
    assert!(why.ends_with("a URDF is a tree"), "{why}");
}

#[test]
fn names_that_are_missing_twice_there_or_of_no_link_are_refused() {
    assert_eq!(
        refusal("<link name=\"hand\"/>", "<link/>"),
        "line 5: a link has no attribute name: write <link name=\"..\">"
    );
    assert_eq!(
        refusal("<link name=\"hand\"/>", "<link name=\"arm\"/>"),
        "line 5: a second link \"arm\" (the first stands in line 4): rename one"
    );
    assert_eq!(
        refusal("name=\"slide\"", "name=\"turn\""),
        "line 14: a second joint \"turn\" (the first stands in line 7): rename one"
    );
    assert_eq!(
        refusal("<child link=\"arm\"/>", "<child link=\"arn\"/>"),
        "line 7: joint \"turn\": its child \"arn\" is no link of this file: \
         write one of its 4 links, such as arm, hand, base, tip"
    );
    assert_eq!(
        refusal("    <child link=\"arm\"/>\n", ""),
        "line 7: joint \"turn\" has no <child>: write <child link=\"..\"/>"
    );
    assert_eq!(
        refusal("<parent link=\"base\"/>", "<parent/>"),
        "line 9: joint \"turn\" <parent> has no attribute link: write link=\"..\""
    );
    let two = "<axis xyz=\"0 0 1\"/><axis xyz=\"0 1 0\"/>";
    assert_eq!(
        refusal("<axis xyz=\"0 0 1\"/>", two),
        "line 11: joint \"turn\" has a second <axis>: keep one"
    );
}

#[test]
fn joints_of_other_types_are_refused_in_the_chain_and_ignored_beside_it() {
    for kind in ["floating", "planar", "spherical", "Revolute", "screw"] {
        assert_eq!(
            refusal("revolute", kind),
            format!(
                "line 7: joint \"turn\" is of type \"{kind}\": write revolute, continuous, prismatic or fixed, \
                 or choose a chain without it"
            )
        );
    }
    let beside = "</joint><link name=\"ball\"/><joint name=\"free\" type=\"floating\"><parent link=\"base\"/>\
                  <child link=\"ball\"/></joint></robot>";
    let text = SOUND.replacen("</joint>\n</robot>", beside, 1);
    assert!(Serial::<2>::from_urdf(&text, "base", "tip").is_ok());
    assert!(
        refusal(" type=\"revolute\"", "")
            .starts_with("line 7: joint \"turn\" has no attribute type: write type=")
    );
}

#[test]
fn an_axis_without_direction_is_refused() {
    for zero in ["0 0 0", "1e-9 0 0"] {
        assert_eq!(
            refusal("0 0 1\"", &format!("{zero}\"")),
            format!("line 11: joint \"turn\" <axis>: xyz=\"{zero}\" is not an axis: it has no direction")
        );
    }
    assert_eq!(
        refusal("<axis xyz=\"0 0 1\"/>", "<axis/>"),
        "line 11: joint \"turn\" <axis> has no attribute xyz: write xyz=\"0 0 1\""
    );
}

/// Readers that skip what is no number would take "0 x 0 1" for an axis.
#[test]
fn numbers_that_are_none_too_few_or_too_many_are_refused() {
    for text in ["0 x 0 1", "0 0", "0 0 1 0", "0 0 NaN", "0 0 inf", "0,0,1", "", "0 0 1e999", "0x1 0 1"] {
        assert_eq!(
            refusal("0 0 1\"", &format!("{text}\"")),
            format!("line 11: joint \"turn\" <axis>: xyz=\"{text}\" is not three finite numbers")
        );
    }
    assert_eq!(
        refusal("rpy=\"0 0 0\"", "rpy=\"0 nan 0\""),
        "line 8: joint \"turn\" <origin>: rpy=\"0 nan 0\" is not three finite numbers"
    );
}

#[test]
fn a_misspelt_attribute_is_refused_and_not_left_out() {
    assert_eq!(
        refusal("rpy=", "ryp="),
        "line 8: joint \"turn\" <origin> has an attribute ryp, which is not read: write one of xyz, rpy, quat_xyzw"
    );
    assert!(
        refusal("upper=\"2\"", "uper=\"2\"").contains("<limit> has an attribute uper, which is not read")
    );
}

#[test]
fn limits_have_no_defaults() {
    assert_eq!(
        refusal("    <limit lower=\"-1\" upper=\"2\" effort=\"5\" velocity=\"3\"/>\n", ""),
        "line 7: joint \"turn\" has no <limit>: write <limit lower=\"..\" upper=\"..\" velocity=\"..\"/>"
    );
    assert_eq!(
        refusal("lower=\"-1\" ", ""),
        "line 12: joint \"turn\" <limit> has no attribute lower: write lower=\"..\""
    );
    assert_eq!(
        refusal("upper=\"2\" ", ""),
        "line 12: joint \"turn\" <limit> has no attribute upper: write upper=\"..\""
    );
    assert_eq!(
        refusal(" velocity=\"3\"", ""),
        "line 12: joint \"turn\" <limit> has no attribute velocity: write velocity=\"..\" [rad/s or m/s]"
    );
}

#[test]
fn limits_that_leave_nothing_to_move_in_are_refused() {
    for velocity in ["0", "-1"] {
        assert_eq!(
            refusal("velocity=\"3\"", &format!("velocity=\"{velocity}\"")),
            format!(
                "line 12: joint \"turn\" <limit>: velocity=\"{velocity}\" is not a finite number above 0"
            )
        );
    }
    assert!(refusal("velocity=\"3\"", "velocity=\"NaN\"").ends_with("is not a finite number"));
    for lower in ["2", "3"] {
        assert_eq!(
            refusal("lower=\"-1\"", &format!("lower=\"{lower}\"")),
            format!(
                "line 12: joint \"turn\": lower={lower} is not below upper=2: a fixed joint has type=\"fixed\""
            )
        );
    }
}

#[test]
fn a_continuous_joint_needs_a_velocity_and_has_a_thousand_turns() {
    let endless = SOUND.replacen("revolute", "continuous", 1);
    let robot = Serial::<2>::from_urdf(&endless, "base", "tip")
        .and_then(|robot| robot.with_acceleration(Vector2::new(1.0, 1.0)))
        .expect("sound");
    assert_eq!(robot.limits().lower[0], -2000.0 * std::f64::consts::PI);
    assert_eq!(robot.limits().upper[0], 2000.0 * std::f64::consts::PI);
    let limit = "    <limit lower=\"-1\" upper=\"2\" effort=\"5\" velocity=\"3\"/>\n";
    assert_eq!(
        of(&endless.replacen(limit, "", 1)),
        "line 7: joint \"turn\" has no <limit>: write <limit velocity=\"..\"/>"
    );
}

#[test]
fn accelerations_are_demanded_of_the_caller_and_checked() {
    let given = |acceleration: Vector2<f64>| {
        Serial::<2>::from_urdf(SOUND, "base", "tip")
            .and_then(|robot| robot.with_acceleration(acceleration))
            .expect_err("it will not do")
            .to_string()
    };
    assert_eq!(
        given(Vector2::new(1.0, 0.0)),
        "joint \"slide\": acceleration 0 is not a finite number above 0"
    );
    assert!(given(Vector2::new(f64::NAN, 1.0)).starts_with("joint \"turn\": acceleration NaN"));
    let stated = SOUND.replacen("velocity=\"3\"", "velocity=\"3\" acceleration=\"6\" deceleration=\"5\"", 1);
    let why = Serial::<2>::from_urdf(&stated, "base", "tip")
        .and_then(|robot| robot.with_acceleration(Vector2::new(5.5, 1.0)))
        .expect_err("above the file's");
    assert_eq!(
        why.to_string(),
        "joint \"turn\": acceleration 5.5 exceeds 5, which the URDF states: give at most that"
    );
}

#[test]
fn position_limits_are_narrowed_and_never_widened() {
    let robot = Serial::<2>::from_urdf(SOUND, "base", "tip")
        .and_then(|robot| robot.with_acceleration(Vector2::new(1.0, 1.0)))
        .expect("sound");
    let narrower = robot.clone().with_positions(Vector2::new(-0.5, 0.1), Vector2::new(2.0, 0.2));
    let narrower = narrower.expect("within");
    assert_eq!((narrower.limits().lower[0], narrower.limits().upper[1]), (-0.5, 0.2));
    for (lower, upper) in [(0.1, 0.4), (0.2, 0.2), (-0.1, 0.2), (f64::NAN, 0.2)] {
        let why = robot.clone().with_positions(Vector2::new(-1.0, lower), Vector2::new(2.0, upper));
        assert_eq!(
            why.expect_err("no range within").to_string(),
            format!(
                "joint \"slide\": positions {lower} to {upper} are no range within 0 to 0.3: narrow them"
            )
        );
    }
}

/// The slide made to follow the turn.
fn mimicking(mimic: &str) -> String {
    SOUND.replacen("<axis xyz=\"1 0 0\"/>", &format!("<axis xyz=\"1 0 0\"/>{mimic}"), 1)
}

fn refusal_of_one(text: &str) -> String {
    Serial::<1>::from_urdf(text, "base", "tip").expect_err("it will not do").to_string()
}

#[test]
fn a_joint_that_follows_narrows_the_limits_of_its_leader() {
    let text = mimicking("<mimic joint=\"turn\" multiplier=\"-0.5\" offset=\"0.1\"/>");
    let robot = Serial::<1>::from_urdf(&text, "base", "tip")
        .and_then(|robot| robot.with_acceleration([1.0].into()))
        .expect("sound");
    // 0 <= 0.1 - 0.5 q <= 0.3 means -0.4 <= q <= 0.2; 0.5 qdot <= 1 means qdot <= 2.
    let limits = robot.limits();
    assert!((limits.lower[0] + 0.4).abs() < 1e-15 && (limits.upper[0] - 0.2).abs() < 1e-15, "{limits:?}");
    assert_eq!(limits.velocity[0], 2.0);
}

#[test]
fn mimicry_that_cannot_be_is_refused() {
    assert_eq!(
        refusal_of_one(&mimicking("<mimic joint=\"finger\"/>")),
        "line 14: joint \"slide\" mimics \"finger\", which is no moving joint between base and tip: \
         choose a chain that contains both, or make it fixed"
    );
    assert!(refusal_of_one(&mimicking("<mimic joint=\"mount\"/>")).contains("no moving joint between"));
    assert_eq!(
        refusal_of_one(&mimicking("<mimic joint=\"slide\"/>")),
        "line 14: joint \"slide\" mimics itself, through slide: name a joint that moves by itself"
    );
    assert_eq!(
        refusal_of_one(&mimicking("<mimic joint=\"turn\" multiplier=\"0\" offset=\"1\"/>")),
        "line 14: joint \"slide\" mimics with multiplier 0, so it stands at its offset 1, outside of its limits 0 to 0.3: \
         correct the multiplier or the offset"
    );
    assert!(
        refusal_of_one(&mimicking("<mimic joint=\"turn\" offset=\"5\"/>")).contains("widen one of the two")
    );
    assert_eq!(
        refusal_of_one(&mimicking("<mimic/>")),
        "line 18: joint \"slide\" <mimic> has no attribute joint: write <mimic joint=\"..\" multiplier=\"1\" offset=\"0\"/>"
    );
    assert!(
        refusal_of_one(&mimicking("<mimic joint=\"turn\" multiplier=\"x\"/>"))
            .ends_with("is not a finite number")
    );
}

#[test]
fn a_joint_may_follow_a_joint_that_follows() {
    let text = mimicking("<mimic joint=\"tilt\" multiplier=\"0.1\"/>").replacen(
        "<joint name=\"mount\" type=\"fixed\">",
        "<joint name=\"tilt\" type=\"continuous\"><mimic joint=\"turn\" multiplier=\"2\" offset=\"0.5\"/>",
        1,
    );
    let robot = Serial::<1>::from_urdf(&text, "base", "tip")
        .and_then(|robot| robot.with_acceleration([1.0].into()))
        .expect("sound");
    // The slide: 0.1 (2 q + 0.5), at least 0.
    assert!((robot.limits().lower[0] + 0.25).abs() < 1e-15, "{:?}", robot.limits());
    let at = robot.forward(&SVector::<f64, 1>::new(0.0)).translation.vector;
    assert!((at.x - 0.45).abs() < 1e-15, "{at}");
}

#[test]
fn quaternions_are_read_from_version_1_1_and_refused_before() {
    let with = |version: &str, origin: &str| {
        SOUND.replacen("name=\"two\"", &format!("name=\"two\" version=\"{version}\""), 1).replacen(
            "rpy=\"0 0 0\"",
            origin,
            1,
        )
    };
    let half = "quat_xyzw=\"0 0 0.7071067811865476 0.7071067811865476\"";
    let robot = Serial::<2>::from_urdf(&with("1.1", half), "base", "tip")
        .and_then(|robot| robot.with_acceleration(Vector2::new(1.0, 1.0)))
        .expect("sound");
    // A quarter turn about z brings the slide from x to y.
    let at = robot.forward(&Vector2::zeros()).translation.vector;
    assert!((at - nalgebra::Vector3::new(0.0, 0.4, 0.5)).amax() < 1e-15, "{at}");
    assert!(of(&with("1.0", half)).contains("quat_xyzw, which is read from version 1.1"));
    assert!(
        of(&with("1.1", &format!("rpy=\"0 0 0\" {half}"))).ends_with("has both rpy and quat_xyzw: keep one")
    );
    assert!(of(&with("1.1", "quat_xyzw=\"0 0 0 0\"")).ends_with("is not a quaternion x y z w of length 1"));
}

/// Every prefix of a sound text is refused, none panics.
#[test]
fn a_truncated_text_is_refused_wherever_it_ends() {
    for end in 0..SOUND.len() - 1 {
        assert!(Serial::<2>::from_urdf(&SOUND[..end], "base", "tip").is_err(), "{end}");
    }
}
