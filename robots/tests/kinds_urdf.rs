//! `kind = "urdf"` of a `cell.toml`: an arm that a file describes runs in a cell, or is refused where the mistake stands.

use mrroc::prelude::*;
use mrroc_launch::cell_file::CellFile;
use mrroc_robots::{Serial, simulated};
use nalgebra::SVector;

/// Read as if it stood beside the URDFs of the reference data.
fn file(robot: &str) -> CellFile {
    let name = format!("{}/tests/reference/urdf/cell.toml", env!("CARGO_MANIFEST_DIR"));
    CellFile::parse(&name, &format!("step_ms = 2\nstop_ms = 3000\n[robots.arm]\n{robot}"))
        .expect("well-formed")
}

const THREE_PARALLEL: &str = r#"kind = "urdf"
file = "three_parallel.urdf"
tip = "wrist_3"
acceleration = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0]
start = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
base = { xyz = [0.3, 0.1, 0.5] }
tool = { xyz = [0.0, 0.0, 0.1] }
"#;

fn refusal(robot: &str) -> String {
    match file(robot).cell(&simulated()) {
        Ok(_) => panic!("nothing is wrong with\n{robot}"),
        Err(why) => why.to_string(),
    }
}

/// The same text but for one line, which is left out where `to` is empty.
fn with(line: &str, to: &str) -> String {
    assert!(THREE_PARALLEL.lines().any(|known| known.starts_with(line)), "{line}");
    THREE_PARALLEL
        .lines()
        .map(|known| if known.starts_with(line) { to } else { known })
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn an_arm_that_a_file_describes_runs_in_a_cell() {
    let text = include_str!("reference/urdf/three_parallel.urdf");
    let arm = Serial::<6>::from_urdf(text, "base", "wrist_3")
        .and_then(|arm| arm.with_acceleration(SVector::repeat(10.0)))
        .expect("sound");
    let start = SVector::<f64, 6>::from([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]);
    let expected = Pose::translation(0.3, 0.1, 0.5) * arm.forward(&start) * Pose::translation(0.0, 0.0, 0.1);
    let report = file(THREE_PARALLEL)
        .cell(&simulated())
        .unwrap_or_else(|why| panic!("{why}"))
        .program(move |mp| {
            let mut arm = mp.robot::<Serial<6>>("arm")?;
            mp.wait_at_most((&mut arm,), (), never {}, 2).unwrap_err();
            let off = arm.demanded().pose.inverse() * expected;
            // It begins where the encoders are, a pulse from the start.
            assert!(off.translation.vector.norm() < 1e-4 && off.rotation.angle() < 1e-3, "{off}");
            Ok(())
        })
        .run();
    assert!(report.is_ok(), "{:?}", report.err().map(|why| why.to_string()));
}

#[condition(mp)]
fn never() -> bool {
    false
}

#[test]
fn a_program_for_another_number_of_joints_is_told_so() {
    let cell = file(THREE_PARALLEL).cell(&simulated()).unwrap_or_else(|why| panic!("{why}"));
    let why = cell.program(|mp| mp.robot::<Serial<7>>("arm").map(|_| ())).run().expect_err("it has six");
    assert!(why.to_string().contains("robot `arm` is of the kind urdf and has not 7 joints"), "{why}");
}

/// Where the message points, what it says, and what it says to write.
#[test]
fn what_is_wrong_with_the_file_is_told_where_the_cell_file_names_it() {
    let folder = format!("{}/tests/reference/urdf/", env!("CARGO_MANIFEST_DIR"));
    for (robot, place, told, help) in [
        (with("file", ""), "cell.toml:3:9", "robot `arm` has no `file`", "write file = \"arm.urdf\""),
        (with("tip", ""), "cell.toml:3:9", "robot `arm` has no `tip`", "write tip = \"tool0\""),
        (
            with("file", "file = \"nothing.urdf\""),
            "cell.toml:5:8",
            "nothing.urdf cannot be read: ",
            "as seen from the folder",
        ),
        (
            with("file", "file = \"../urdf_pinocchio.py\""),
            "cell.toml:5:8",
            "not well-formed XML",
            "mend the URDF",
        ),
        (
            with("tip", "tip = \"wrist_4\""),
            "cell.toml:6:7",
            "no link \"wrist_4\", asked for as tip",
            "wrist_3",
        ),
        (
            with("tip", "base_link = \"bas\"\ntip = \"wrist_3\""),
            "cell.toml:6:13",
            "no link \"bas\", asked for as base",
            "base_link",
        ),
        (
            with("tip", "base_link = \"wrist_3\"\ntip = \"base\""),
            "cell.toml:7:7",
            "the other way round",
            "other links",
        ),
        (with("tip", "tip = \"base\""), "cell.toml:6:7", "has 0 joints that move", "1 to 8"),
        (with("acceleration", ""), "cell.toml:3:9", "has no `acceleration`, and", "6 joints"),
        (
            with("acceleration", "acceleration = [1.0]"),
            "cell.toml:7:16",
            "has 1 numbers, the robot has 6 joints",
            "6 numbers",
        ),
        (
            with("acceleration", "acceleration = [1, 1, 1, 0, 1, 1]"),
            "cell.toml:7:16",
            "acceleration 0 is not a finite number above 0",
            "drives",
        ),
        (with("start", "start = [0, 0, 9, 0, 0, 0]"), "cell.toml:8:16", "outside its limits", "from -3.1416"),
    ] {
        let why = refusal(&robot);
        println!("{why}\n");
        assert!(
            why.contains(place) && why.contains(told) && why.contains(help),
            "{place} {told} {help}\n{why}"
        );
        assert!(why.starts_with(&folder), "{why}");
    }
}

/// Each is written to a file of its own, from a sound arm.
#[test]
fn a_chain_that_is_no_arm_is_told_with_its_line() {
    let sound = include_str!("reference/urdf/three_parallel.urdf");
    let folder = std::env::temp_dir().join(format!("mrroc-kinds-urdf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let limit = "<limit lower=\"-3.1416\" upper=\"3.1416\" effort=\"100\" velocity=\"3.15\"/>";
    let loops = "<joint name=\"back\" type=\"fixed\"><parent link=\"wrist_3\"/><child link=\"upper\"/></joint></robot>";
    for (name, text, told) in [
        ("no_limit", sound.replace(limit, ""), "joint \"elbow\" has no <limit>"),
        ("no_velocity", sound.replace(" velocity=\"3.15\"", ""), "velocity"),
        (
            "floating",
            sound.replace("name=\"elbow\" type=\"revolute\"", "name=\"elbow\" type=\"floating\""),
            "joint \"elbow\" is of type \"floating\"",
        ),
        ("closed", sound.replace("</robot>", loops), "link \"upper\" is the child of joint"),
        (
            "two_roots",
            sound.replace("</robot>", "<link name=\"table\"/></robot>"),
            "2 links of the URDF hang on no other (base, table)",
        ),
    ] {
        std::fs::write(folder.join("arm.urdf"), &text).expect("written");
        assert_ne!(text, sound, "{name}");
        let cell = folder.join("cell.toml");
        let text = format!("step_ms = 2\n[robots.arm]\n{}", with("file", "file = \"arm.urdf\""));
        let file = CellFile::parse(&cell.display().to_string(), &text).expect("well-formed");
        let Err(why) = file.cell(&simulated()) else { panic!("{name} is taken") };
        println!("{why}\n");
        assert!(why.to_string().contains(told), "{name}: {why}");
    }
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn other_kinds_refuse_keys_that_they_do_not_read() {
    let robot = "kind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\ntip = \"tool0\"\n";
    let why = refusal(robot);
    assert!(why.contains("cell.toml:6:7: the kind `irp6` does not read `tip`"), "{why}");
    let robot = "kind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\nacceleration = [1.0]\n";
    assert!(refusal(robot).contains("the kind `irp6` does not read `acceleration`"));
}

/// A file of URDF 1.2 may state accelerations: then the cell file need not, and may only lower them.
#[test]
fn accelerations_of_the_file_need_no_key() {
    let sound = include_str!("reference/urdf/three_parallel.urdf");
    let text = sound
        .replace("<robot name", "<robot version=\"1.2\" name")
        .replace(" effort=", " acceleration=\"7\" effort=");
    let folder = std::env::temp_dir().join(format!("mrroc-kinds-urdf12-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("arm.urdf"), text).expect("written");
    let cell = |robot: String| {
        let text = format!("step_ms = 2\nstop_ms = 3000\n[robots.arm]\n{robot}");
        let text = text.replace("three_parallel.urdf", "arm.urdf");
        CellFile::parse(&folder.join("cell.toml").display().to_string(), &text)
            .expect("well-formed")
            .cell(&simulated())
    };
    let made = cell(with("acceleration", "")).unwrap_or_else(|why| panic!("{why}"));
    assert!(made.layout().robots[0].joints.iter().all(|joint| joint.acceleration == 7.0));
    let Err(why) = cell(THREE_PARALLEL.to_owned()) else { panic!("10 is more than 7") };
    assert!(why.to_string().contains("acceleration 10 exceeds 7"), "{why}");
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn motors_are_coupled_only_where_the_links_have_masses() {
    let why = refusal(&format!("{THREE_PARALLEL}coupled = true\n"));
    assert!(
        why.contains("no masses are known of the links of robot `arm`") && why.contains(":11:11"),
        "{why}"
    );
    assert!(why.contains("<inertial>"), "{why}");
    let weighted = with("file =", "file = \"weighted_arm.urdf\"").replace("wrist_3", "tool0");
    let weighted = weighted
        .replace("start = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]", "start = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]");
    for homed in ["", "homed = false\n"] {
        let cell = file(&format!("{weighted}\ncoupled = true\n{homed}")).cell(&simulated());
        cell.unwrap_or_else(|why| panic!("{why}"));
    }
}
