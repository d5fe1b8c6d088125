//! `cell.toml`: the cell that it makes, and all its errors at once, each with its line and what to write instead.

mod poses;

use std::time::Duration;

use mrroc::cell_file::{Kinds, RobotEntry};
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_generators::generators::{Delay, Tell};
use mrroc_robots::{Irp6, Six, simulated};
use mrroc_tests::{ExactDrive, Gantry, Q};

const GOOD: &str = r#"
step_ms = 2

[robots.left]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
tool = { xyz = [0.0, 0.0, 0.1] }

[robots.right]
kind = "irp6"
start = [0, -1.57, 0.16, -0.16, 4.71, 0]
base = { xyz = [0.0, 1.5, 0.0], zyz = [2.5, 0.0, 0.0] }
"#;

fn hold(_: &mut Mp) -> Result<(), Fault> {
    Ok(())
}

fn complaints(text: &str) -> String {
    match CellFile::parse("cell.toml", text) {
        Ok(_) => panic!("nothing is wrong with\n{text}"),
        Err(error) => error.to_string(),
    }
}

fn refusal(text: &str) -> String {
    let file = CellFile::parse("cell.toml", text).expect("well-formed");
    match file.cell(&simulated()) {
        Ok(_) => panic!("nothing is wrong with\n{text}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_cell_is_made_of_its_file() {
    let file = CellFile::parse("cell.toml", GOOD).expect("nothing is wrong");
    let names: Vec<_> = file.robots().iter().map(|robot| robot.name()).collect();
    assert_eq!(names, ["left", "right"]);
    let report = file.cell(&simulated()).expect("kinds are known").program(|mp| {
        let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
        mp.wait_at_most((&mut left, &mut right), (), never {}, 2).unwrap_err();
        let (left, right) = (left.demanded().pose, right.demanded().pose);
        // The same joints: the flange is 0.1 m behind the tool, along the tool's axis; the other base is 1.5 m
        // away and turned by 2.5 rad.
        let flange = left * nalgebra::Translation3::new(0.0, 0.0, -0.1);
        let turned = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), 2.5);
        let expected = turned * flange.translation.vector + nalgebra::Vector3::y() * 1.5;
        assert!((right.translation.vector - expected).norm() < 1e-5, "{right} {expected}");
        Ok(())
    });
    report.run().expect("runs");
}

#[mrroc::condition(mp)]
fn never() -> bool {
    false
}

#[test]
fn everything_wrong_with_a_file_is_told_at_once() {
    let text = r#"
stepms = 2
stop_ms = -1

[robots.arm]
kinde = "irp6"
start = [0.0, "a", nan]

[robots."my arm"]
kind = "irp6"

[sensors.touch]
of = "army"
mode = "interactiv"
"#;
    insta::assert_snapshot!(complaints(text));
}

#[test]
fn broken_toml_is_shown_where_it_breaks() {
    insta::assert_snapshot!(complaints("step_ms = 2\n[robots.arm\nkind = \"irp6\"\n"));
}

#[test]
fn a_broken_line_is_told_once() {
    let told = complaints(&GOOD.replacen("4.71, 0.0]", "4.71, 0.0", 1));
    assert_eq!(told.matches("help").count(), 1, "{told}");
    assert!(told.contains("a bracket or a quote may be missing in the line above"), "{told}");
    let told = complaints(&GOOD.replacen("\"irp6\"", "irp6", 1));
    assert!(told.contains("write a text in quotes: \"irp6\""), "{told}");
}

#[test]
fn what_a_kind_cannot_take_is_told_for_all_robots_at_once() {
    let text = r#"
step_ms = 2
[robots.a]
kind = "irp7"
[robots.b]
kind = "irp6"
[robots.c]
kind = "irp6"
start = [0.0, 0.0]
[robots.d]
kind = "irp6"
start = [0.0, 0.5, 0.16, -0.16, 4.71, 0.0]
"#;
    insta::assert_snapshot!(refusal(text));
}

#[test]
fn a_sensor_needs_a_robot_a_period_and_a_mode_that_there_are() {
    let cell = |sensor: &str| format!("{GOOD}\n[sensors.s]\n{sensor}\n");
    for (sensor, told) in [
        ("mode = \"free running\"", "has no `period_ms`"),
        ("period_ms = 3", "only a free-running sensor has a period"),
        ("mode = 3", "write the name of a mode, in quotes"),
        ("of = \"leftt\"", "did you mean `left`?"),
        ("mode = \"free running\"\nperiod_ms = 0", "write a number of milliseconds from 0.1"),
    ] {
        let complaints = complaints(&cell(sensor));
        assert!(complaints.contains(told), "{complaints}");
    }
}

#[test]
fn a_plant_needs_a_port_that_the_program_of_the_cell_knows() {
    let cell = |plant: &str| GOOD.replacen("tool = {", &format!("plant = {plant}\ntool = {{"), 1);
    for (plant, told) in [
        ("\"mujoco\"", "write { port = \"mujoco\" }"),
        ("{ }", "a plant without `port`"),
        ("{ port = 3 }", "a name, in quotes"),
        ("{ port = \"my world\" }", "write port = \"..\" with such a name"),
        ("{ port = \"w\", timeout_ms = 55000 }", "milliseconds up to 50000"),
        ("{ port = \"w\", timeout = 5 }", "unknown key `timeout`"),
    ] {
        let complaints = complaints(&cell(plant));
        assert!(complaints.contains(told), "{complaints}");
    }
    let told = refusal(&cell("{ port = \"w\" }"));
    assert!(told.contains("robot `left` is in a simulator, and this program has no port for one"), "{told}");
}

#[test]
fn fault_156_two_programs_of_others_cannot_call_at_one_address_nor_where_a_node_waits() {
    let sensor = |name: &str, address: &str| {
        format!(
            "[sensors.{name}]\nmode = \"free running\"\nperiod_ms = 4\nstale_after_ms = 100\n[sensors.{name}.external]\nrate_hz = \
             30.0\nleast = [0.0]\nlargest = [1.0]\naddress = \"{address}\"\n"
        )
    };
    let cell = |other: &str| format!("{GOOD}\n{}{}", sensor("s", "192.168.1.2:7449"), sensor("t", other));
    let told = complaints(&cell("192.168.1.2:7449"));
    assert!(told.contains("sensor `s` has this address already"), "{told}");
    assert!(told.contains("write a port of its own, such as \"192.168.1.2:7450\""), "{told}");
    let right = cell("192.168.1.2:7450");
    assert_eq!(CellFile::parse("cell.toml", &right).expect("two ports").gateways().count(), 2);
    let told = complaints(&(right + "[nodes.left]\naddress = \"192.168.1.2:7450\"\nmp = true\n"));
    assert!(told.contains("the program of sensor `t` calls at this address"), "{told}");
}

#[test]
fn fault_121_a_program_of_another_needs_an_age_a_rate_and_bounds() {
    const SENSOR: &str = "mode = \"free running\"\nperiod_ms = 4\nstale_after_ms = 100";
    const TABLE: &str = "rate_hz = 30.0\nleast = [0.0]\nlargest = [1.0]";
    let cell =
        |sensor: &str, table: &str| format!("{GOOD}\n[sensors.s]\n{sensor}\n[sensors.s.external]\n{table}\n");
    CellFile::parse("cell.toml", &cell(SENSOR, TABLE)).expect("nothing is wrong with it");
    for (sensor, table, told) in [
        (SENSOR, "", "has a program of another, and no `rate_hz`"),
        (SENSOR, "rate_hz = 30.0\nlargest = [1.0]", "and no `least`"),
        (SENSOR, "rate_hz = 30.0\nleast = [1.0]", "and no `largest`"),
        (
            SENSOR,
            "rate_hz = 0.0\nleast = [0.0]\nlargest = [1.0]",
            "write a number of readings a second from 0.1",
        ),
        (
            SENSOR,
            "rate_hz = 5.0\nleast = [0.0]\nlargest = [1.0]",
            "readings come every 200.0 ms and are too old sooner",
        ),
        (
            SENSOR,
            "rate_hz = 30.0\nleast = [2.0]\nlargest = [1.0]",
            "a number of `least` is larger than that of `largest`",
        ),
        (SENSOR, &format!("{TABLE}\nper_second = [0.0]"), "a change that is not above 0"),
        (SENSOR, &format!("{TABLE}\nport = \"my camera\""), "write port = \"..\" with such a name"),
        (SENSOR, &format!("{TABLE}\naddress = \"192.168.1.2\""), "is no address of a network with a port"),
        (
            SENSOR,
            &format!("{TABLE}\naddress = \"0.0.0.0:7449\""),
            "is no address at which a program could find",
        ),
        (SENSOR, &format!("{TABLE}\nrate = 3"), "did you mean `rate_hz`?"),
        ("mode = \"free running\"\nperiod_ms = 4", TABLE, "and no `stale_after_ms`"),
        ("stale_after_ms = 100", TABLE, "for which nobody waits"),
    ] {
        let complaints = complaints(&cell(sensor, table));
        assert!(complaints.contains(told), "{told}: {complaints}");
    }
    let file = CellFile::parse("cell.toml", &cell(SENSOR, TABLE)).expect("nothing is wrong with it");
    // The program of the cell computes a sensor that the file gives to another.
    let told = file.sensor("s", Here).map(drop).expect_err("not its own").to_string();
    assert!(told.contains("the program of the cell computes sensor `s` itself"), "{told}");
    let told = file.external("t").map(drop).expect_err("no such sensor").to_string();
    assert!(told.contains("[sensors.t], which is not there"), "{told}");
    let external = file.external("s").expect("it is there");
    assert_eq!((external.address(), file.gateways().count()), (None, 0));
    let elsewhere = cell(SENSOR, &format!("{TABLE}\naddress = \"192.168.1.2:7449\""));
    let elsewhere = CellFile::parse("cell.toml", &elsewhere).expect("nothing is wrong with it");
    let gateway = elsewhere.gateways().next().expect("its program is on another machine");
    assert_eq!(
        (gateway.name(), gateway.address()),
        ("s", Some(std::net::SocketAddr::from(([192, 168, 1, 2], 7449))))
    );
    let told = external.believable(&["x".to_owned(), "y".to_owned()]).expect_err("two numbers").to_string();
    assert!(
        told.contains("`least` has 1 numbers, a reading has 2")
            && told.contains("write one for each of: x, y"),
        "{told}"
    );
}

/// A sensor of the cell's own program.
struct Here;

impl mrroc::sensor::VirtualSensor for Here {
    type Kind = Height;

    fn aggregate(&mut self, _: &mrroc::sensor::ReadingOrder<()>) -> Result<Above, Fault> {
        Ok(Above { z: 0.0 })
    }
}

struct Height;

#[derive(Clone, Copy, mrroc::payload::Payload)]
struct Above {
    z: f64,
}

impl mrroc::sensor::Sensor for Height {
    const KIND: &'static str = "height";
    type Reading = Above;
    type Configuration = ();
}

#[test]
fn a_sensor_of_the_file_without_a_vsp_is_refused_with_the_line_to_write() {
    let text = format!("{GOOD}\n[sensors.touch]\nof = \"left\"\n");
    let file = CellFile::parse("cell.toml", &text).expect("well-formed");
    let error = file.cell(&simulated()).expect("kinds are known").program(hold).run().expect_err("no VSP");
    assert_eq!(error, CellError::NoVsp("touch".to_owned()));
    assert!(error.to_string().contains(".sensor(file.sensor(\"touch\", ..)?)"), "{error}");
}

#[test]
fn a_program_for_a_robot_that_is_not_there_or_of_another_kind_is_refused() {
    let cell = || CellFile::parse("cell.toml", GOOD).expect("well-formed").cell(&simulated()).expect("known");
    let error = cell().ecp::<Irp6>("lft", |_| Ok(())).run().expect_err("no such robot");
    assert!(error.to_string().contains("`lft`") && error.to_string().contains("left, right"), "{error}");
    let error = cell().ecp::<Gantry>("left", |_| Ok(())).run().expect_err("another kind");
    assert!(error.to_string().contains("another kind, gantry"), "{error}");
}

#[test]
fn a_kind_of_the_users_own_takes_the_place_of_a_simulated_one() {
    let kinds = Kinds::new().with("slides", |entry| {
        let robot = Gantry::default();
        let drives = ExactDrive::new(entry.start(&robot)?, mrroc_tests::MS);
        Ok(RobotSetup::new(entry.name(), robot, drives))
    });
    let text = "step_ms = 1\n[robots.g]\nkind = \"slides\"\nstart = [0.1, 0.2, 0.3]\n";
    let file = CellFile::parse("cell.toml", text).expect("well-formed");
    let seen = std::rc::Rc::new(std::cell::RefCell::new(Vec::new()));
    let keep = std::rc::Rc::clone(&seen);
    let cell: Cell = file.cell(&kinds).expect("known").watch(move |seen| {
        let mut tool = None;
        seen.frames(&mut |frame| tool = Some(frame.translation.vector));
        keep.borrow_mut().push((seen.robot.to_owned(), seen.demanded.to_vec(), tool));
    });
    cell.program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.wait_at_most((&mut g,), (), never {}, 2).map(drop).or(Ok(()))
    })
    .run()
    .expect("runs");
    let expected = Q::<3>::new(0.1, 0.2, 0.3);
    assert!(seen.borrow().len() >= 2);
    for (name, joints, tool) in seen.borrow().iter() {
        assert_eq!((name.as_str(), joints.as_slice(), *tool), ("g", expected.as_slice(), Some(expected)));
    }
}

#[test]
fn homed_is_true_or_false_and_only_for_drives_that_can_be_unhomed() {
    let told = complaints(&GOOD.replacen("tool =", "homed = \"no\"\ntool =", 1));
    assert!(told.contains("cell.toml:7:9: a string where true or false is due"), "{told}");
    let told = complaints(&GOOD.replacen("tool =", "home = false\ntool =", 1));
    assert!(told.contains("did you mean `homed`?"), "{told}");
    let kinds = || {
        Kinds::new().with("slides", |entry| {
            let robot = Gantry::default();
            let drives = ExactDrive::new(entry.start(&robot)?, mrroc_tests::MS);
            Ok(RobotSetup::new(entry.name(), robot, drives))
        })
    };
    for (homed, taken) in [("true", true), ("false", false)] {
        let text =
            format!("step_ms = 1\n[robots.g]\nkind = \"slides\"\nstart = [0, 0, 0]\nhomed = {homed}\n");
        let made = CellFile::parse("cell.toml", &text).expect("well-formed").cell(&kinds());
        assert_eq!(made.is_ok(), taken);
        if let Err(why) = made {
            let why = why.to_string();
            assert!(why.starts_with("cell.toml:5:9: the drives of kind `slides` know"), "{why}");
            assert!(why.contains("leave `homed` out"), "{why}");
        }
    }
}

#[test]
fn what_a_cell_asks_of_the_machine_is_checked_like_everything_else() {
    let with = |table: &str| format!("{GOOD}\n[realtime]\n{table}");
    for good in [
        "priority = 50",
        "priority = 95\ncores = []\npermission = \"best effort\"",
        "priority = 1\nlock_memory = false\ncores = [0, 1]\npermission = \"required\"",
    ] {
        assert!(CellFile::parse("cell.toml", &with(good)).is_ok(), "{good}");
    }
    for (bad, told, help) in [
        ("", "[realtime] has no `priority`", "write priority = 50"),
        ("priority = 96", "96 is out of range", "write a priority from 1 to 95"),
        ("priority = 0", "0 is out of range", "write a priority from 1 to 95"),
        ("priority = 1.5", "1.5 is not a whole number", "write a priority from 1 to 95"),
        ("priority = 50\nprio = 1", "unknown key `prio`", "did you mean `priority`?"),
        ("priority = 50\ncores = [-1]", "-1 is out of range", "write the number of a core"),
        ("priority = 50\nlock_memory = 1", "a integer where true or false is due", "write true or false"),
        ("priority = 50\npermission = \"best\"", "no permission `best`", "best effort"),
    ] {
        let complaint = complaints(&with(bad));
        assert!(complaint.contains(told) && complaint.contains(help), "{bad}: {complaint}");
    }
}

/// A cell of three arms on two machines; `nodes` is what the file says of these, `arms` of each arm.
fn on_nodes(nodes: &str, arms: [&str; 3], rest: &str) -> String {
    let start = "start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]";
    let arm = |(name, says): (&str, &str)| format!("[robots.{name}]\nkind = \"irp6\"\n{start}\n{says}\n");
    let arms: String = ["one", "two", "three"].into_iter().zip(arms).map(arm).collect();
    format!("step_ms = 2\n{nodes}\n{arms}{rest}")
}

const NODES: &str = "[nodes.left]\naddress = \"10.0.0.1:7447\"\nmp = true\n[nodes.right]\naddress = \"10.0.0.2:7447\"\n\
                     [nodes.third]\naddress = \"10.0.0.3:7447\"";

#[test]
fn what_says_no_node_is_with_the_mp_and_a_sensor_with_its_robot() {
    let text = on_nodes(
        NODES,
        ["", "node = \"right\"", "node = \"third\""],
        "[sensors.eye]\nof = \"two\"\n[sensors.ear]\n",
    );
    let file = CellFile::parse("cell.toml", &text).expect("right");
    let nodes = file.nodes().expect("nodes");
    assert_eq!(nodes.first().expect("the MP's").address, ([10, 0, 0, 1], 7447).into());
    let of = |role, name: &str| {
        nodes.of(mrroc::fault::ProcessId::new(role, mrroc::fault::Name::new(name).expect("a name")))
    };
    use mrroc::fault::Role::{Ecp, Edp, Vsp};
    for role in [Ecp, Edp] {
        assert_eq!(["one", "two", "three"].map(|arm| of(role, arm)), [Some(0), Some(1), Some(2)]);
    }
    assert_eq!((of(Vsp, "eye"), of(Vsp, "ear")), (Some(1), Some(0)));
    // Another text is another cell.
    let other = CellFile::parse("cell.toml", &(text + "# more\n")).expect("right");
    assert_ne!(other.nodes().expect("nodes").file(), nodes.file());
    assert!(CellFile::parse("cell.toml", &on_nodes("", [""; 3], "")).expect("right").nodes().is_none());
}

#[test]
fn fault_140_what_is_on_no_node_or_on_the_wrong_one_is_refused_with_its_place() {
    let mp = "[nodes.left]\naddress = \"10.0.0.1:7447\"\nmp = true\n";
    for (text, told) in [
        (on_nodes(NODES, ["", "node = \"rihgt\"", ""], ""), "no node `rihgt`"),
        (on_nodes("", ["node = \"right\"", "", ""], ""), "write a table [nodes.right] with its address"),
        (on_nodes("[nodes.left]\naddress = \"10.0.0.1:7447\"", [""; 3], ""), "no node has the MP"),
        (
            on_nodes(&format!("{mp}[nodes.b]\naddress = \"10.0.0.2:1\"\nmp = true"), [""; 3], ""),
            "two nodes have the MP",
        ),
        (on_nodes("[nodes.left]\nmp = true", [""; 3], ""), "node `left` has no `address`"),
        (
            on_nodes("[nodes.left]\nmp = true\naddress = \"left\"", [""; 3], ""),
            "`left` is no address of a network with a port",
        ),
        (
            on_nodes("[nodes.left]\nmp = true\naddress = \"0.0.0.0:7447\"", [""; 3], ""),
            "at which others could find a node",
        ),
        (
            on_nodes(&format!("{mp}[nodes.b]\naddress = \"10.0.0.1:7447\""), [""; 3], ""),
            "node `left` has this address already",
        ),
        (
            on_nodes(NODES, ["node = \"right\"", "mounted_on = \"one\"", ""], ""),
            "robot `two` is mounted on `one`, which is on node `right`",
        ),
        (
            on_nodes(NODES, ["", "node = \"right\"", ""], "[sensors.eye]\nof = \"two\"\nnode = \"third\"\n"),
            "sensor `eye` is on node `third` and robot `two` on node `right`, and neither has the MP",
        ),
        (on_nodes(&format!("{mp}colour = 1"), [""; 3], ""), "unknown key `colour`"),
    ] {
        let error = CellFile::parse("cell.toml", &text).expect_err(told).to_string();
        assert!(error.contains(told) && error.contains("\n help: "), "{told}: {error}");
        let place =
            error.split_once("cell.toml:").and_then(|(_, at)| at.split(':').next()).map(str::parse::<usize>);
        assert!(matches!(place, Some(Ok(line)) if line > 1), "{error}");
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = CellFile::read("no/such/cell.toml").expect_err("not there").to_string();
    assert!(error.starts_with("no/such/cell.toml: cannot be read"), "{error}");
}

#[test]
fn places_are_right_whatever_the_text_is_made_of() {
    for (text, told) in [
        // A byte order mark, Windows' line ends, a tab, and letters of two bytes before the place.
        ("\u{feff}step_ms = 2\r\nrobot = 1\r\n", "cell.toml:2:1: unknown key `robot`"),
        ("step_ms = 2\n[robots.a]\n\tkinds = 1\n", "cell.toml:3:2: unknown key `kinds`"),
        ("step_ms = 2\n[robots.a]\nkind = 'żółw' \nstart = [1, 'ż', x]\n", "cell.toml:4:"),
        ("step_ms = 1e400\n", "cell.toml:1:11: not a finite number"),
        ("step_ms = 0xFFFFFFFF\n", "cell.toml:1:11: 4294967295 ms"),
        ("step_ms = 2\nstep_ms = 2\n", "cell.toml:2:1: duplicate key"),
        ("step_ms = 0.00000001\n", "a number of milliseconds from 0.1 to 60000"),
    ] {
        let complaints = complaints(text);
        assert!(complaints.contains(told), "{text:?}: {complaints}");
    }
}

#[test]
fn fault_65_a_cell_of_too_many_processes_and_a_second_program_are_refused() {
    let robot =
        |i: usize| format!("[robots.r{i}]\nkind = \"irp6\"\nstart = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]\n");
    let check = |robots: usize| {
        let text = format!("step_ms = 2\n{}", (0..robots).map(robot).collect::<String>());
        let file = CellFile::parse("cell.toml", &text).expect("well-formed");
        file.cell(&simulated()).expect("kinds are known").program(hold).check().map(|names| names.len())
    };
    // An MP, 95 ECPs, 95 EDPs and a plant.
    assert_eq!(check(95), Ok(95));
    assert_eq!(check(96), Err(CellError::TooMany { processes: 194, limit: 192 }));
    let file = CellFile::parse("cell.toml", GOOD).expect("well-formed");
    let cell = file
        .cell(&simulated())
        .expect("known")
        .ecp::<Irp6>("left", |_| Ok(()))
        .ecp::<Irp6>("left", |_| Ok(()));
    assert_eq!(cell.run().expect_err("two"), CellError::TwoPrograms("left".to_owned()));
}

#[test]
fn after_a_fault_a_cell_ends_or_awaits_a_reset_and_nothing_else() {
    let with = |value: &str| format!("step_ms = 2\nafter_fault = {value}\n[robots.arm]\nkind = \"irp6\"\n");
    for good in ["\"end\"", "\"await reset\""] {
        CellFile::parse("cell.toml", &with(good)).unwrap_or_else(|why| panic!("{good}: {why}"));
    }
    let wrong = complaints(&with("\"awaits reset\""));
    assert!(wrong.contains("2:15") && wrong.contains("did you mean `await reset`?"), "{wrong}");
    let number = complaints(&with("1"));
    assert!(number.contains("write \"end\" or \"await reset\""), "{number}");
}

#[test]
fn a_recording_needs_a_file_and_robots_and_sensors_that_there_are() {
    let cell = |recording: &str| format!("{GOOD}\n[recording]\n{recording}\n");
    CellFile::parse("cell.toml", &cell("file = \"run.mcap\"\nrobots = [\"left\"]"))
        .expect("nothing is wrong");
    for (recording, told) in [
        ("", "[recording] has no `file`"),
        ("fil = \"run.mcap\"", "did you mean `file`?"),
        ("file = 3", "the name of a file, in quotes"),
        ("file = \"run.mcap\"\nrobots = [\"lefd\"]", "did you mean `left`?"),
        ("file = \"run.mcap\"\nrobots = \"left\"", "a list of names of robots, in quotes"),
        ("file = \"run.mcap\"\nsensors = [\"touch\"]", "`touch` is none of the sensors"),
    ] {
        let complaint = complaints(&cell(recording));
        assert!(complaint.contains(told), "{complaint}");
    }
    let dry = complaints(&format!("dry_run = 1\n{GOOD}"));
    assert!(dry.contains("true or false"), "{dry}");
}

/// Drives that are hardware, and must not be touched.
struct Untouched;

impl<R: Robot> Driver<R> for Untouched {
    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }
    fn hardware(&self) -> Option<String> {
        Some("a controller".to_owned())
    }
    fn open(&mut self) -> Result<(), DriveFault> {
        panic!("opened")
    }
    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        panic!("read")
    }
    fn tick(&mut self, _: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        panic!("driven")
    }
}

#[test]
fn drives_of_the_kind_that_was_replaced_stand_in_for_hardware_or_else_ideal_ones() {
    let real = |entry: &RobotEntry| Ok(RobotSetup::new(entry.name(), Irp6::nominal(), Untouched));
    let file = CellFile::parse("cell.toml", GOOD).expect("well-formed");
    // Simulated motors are behind their demands; ideal drives never are.
    for (kinds, lags) in [(simulated().with("irp6", real), true), (Kinds::new().with("irp6", real), false)] {
        let cell = file.cell(&kinds).expect("known").simulated().expect("they stand in");
        let off = std::rc::Rc::new(std::cell::Cell::new(0.0_f64));
        let seen = std::rc::Rc::clone(&off);
        let cell = cell.watch(move |period| {
            let apart = period.demanded.iter().zip(period.measured).map(|(a, b)| (a - b).abs());
            seen.set(apart.fold(seen.get(), f64::max));
        });
        let moved = cell.program(|mp| {
            let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
            // Encoders of simulated drives count.
            let off = left.demanded().joints - Irp6::READY;
            assert!(off.amax() < 1e-5, "{off}");
            mp.move_robots((&mut left, &mut right), (), Turn(0)).map(drop)
        });
        moved.run().expect("within the limits");
        assert_eq!(off.get() > 1e-6, lags, "{}", off.get());
        assert!(off.get() < 0.01);
    }
    // Where a robot starts, a stand-in has to be told.
    let without = GOOD.replace("start = [0,", "# start = [0,");
    let file = CellFile::parse("cell.toml", &without).expect("well-formed");
    let refused = file.cell(&Kinds::new().with("irp6", real)).expect("known").simulated();
    let refused = refused.err().expect("refused").to_string();
    assert!(refused.contains("cell.toml:9:9: robot `right` has no `start`"), "{refused}");
}

/// Turns the first joints to and fro by a cosine of 0.05 rad, in a second.
struct Turn(u32);

#[generator(mp)]
fn turn(c: &mut Turn, e: &State<(Irp6, Irp6)>) -> Step<(Irp6, Irp6)> {
    c.0 += 1;
    if c.0 > 500 {
        return Step::Done;
    }
    let angle = |k: u32| 0.025 * (1.0 - (std::f64::consts::TAU * f64::from(k) / 500.0).cos());
    let displacement = Six::new(angle(c.0) - angle(c.0 - 1), 0.0, 0.0, 0.0, 0.0, 0.0);
    Step::Next((
        Demand::joints(e.0.demanded().joints + displacement),
        Demand::joints(e.1.demanded().joints + displacement),
    ))
}

/// The hand stands on the arm's flange, 0.1 m ahead; in its own world its finger is half of its opening aside.
#[test]
fn a_gripper_is_mounted_on_an_arm() {
    const HAND: &str = r#"
step_ms = 2
[robots.hand]
kind = "gripper"
mounted_on = "arm"
base = { xyz = [0.0, 0.0, 0.1] }
start = [0.07]
[robots.arm]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
"#;
    let file = CellFile::parse("cell.toml", HAND).expect("nothing is wrong");
    assert_eq!(file.robots()[0].mounted_on(), Some("arm"));
    let cell = file.cell(&simulated()).expect("kinds are known");
    assert_eq!(cell.layout().robots[0].mounted_on.as_deref(), Some("arm"));
    let report = cell.program(|mp| {
        let mut hand = mp.robot::<mrroc_robots::Gripper>("hand")?;
        mp.wait_at_most((&mut hand,), (), never {}, 2).unwrap_err();
        let finger = hand.demanded().pose.translation.vector;
        assert!((finger - nalgebra::Vector3::new(0.035, 0.0, 0.1)).norm() < 1e-4, "{finger}");
        Ok(())
    });
    report.run().expect("it runs");
    for (on, told) in [
        ("am", "cell.toml:5:14: robot `hand` is mounted on `am`, which is no other robot of the cell"),
        ("hand", "cell.toml:5:14: robot `hand` is mounted on `hand`, which is no other robot of the cell"),
    ] {
        let why = complaints(&HAND.replace("mounted_on = \"arm\"", &format!("mounted_on = \"{on}\"")));
        assert!(why.contains(told) && why.contains("arm"), "{why}");
    }
    let circle = format!("{HAND}mounted_on = \"hand\"\n");
    let cell = CellFile::parse("cell.toml", &circle).expect("well-formed").cell(&simulated()).expect("known");
    let why = cell.program(hold).run().expect_err("a circle").to_string();
    assert!(why.contains("robot `hand` is mounted on `arm`, and that on it"), "{why}");
}

/// Set up in Rust, what a robot is mounted on is checked with the cell.
#[test]
fn a_robot_that_is_mounted_on_none_is_refused() {
    let hand = mrroc_robots::Gripper::new();
    let drives = mrroc_robots::Simulated::new(hand.clone(), &nalgebra::Vector1::new(0.07));
    let hand = RobotSetup::new("hand", hand, drives).mounted_on("arm");
    let why =
        Cell::new(Duration::from_millis(2)).robot(hand).program(hold).run().expect_err("no arm").to_string();
    assert!(why.contains("robot `hand` is mounted on `arm`, which is not there"), "{why}");
}

const SIGNALS: &str = r#"
step_ms = 2

[robots.arm]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
tool = "pen"

[robots.arm.inputs]
part_seen = "digital 3"
sucked = { channel = "digital 4", follows = "vacuum", after_ms = 150 }

[robots.arm.outputs]
vacuum = { channel = "digital 0", holds_body = true }
spindle = { channel = "digital 1", turns_tool = true, on_stop = false }
flow = { channel = "analog 0", on_stop = 0 }

[frames.table]
xyz = [0.4, 0.0, 0.1]

[tools.pen]
xyz = [0.0, 0.0, 0.1]
mass = 0.3
centre = [0.0, 0.0, 0.04]
inertia = [1e-4, 0.0, 0.0, 1e-4, 0.0, 2e-5]
"#;

#[test]
fn signals_frames_and_tools_of_the_file_are_there_for_programs() {
    let file = CellFile::parse("cell.toml", SIGNALS).expect("sound");
    let cell = file.cell(&simulated()).expect("known kinds").program(|mp| {
        let mut arm = mp.robot::<Irp6>("arm")?;
        let (vacuum, flow) = (arm.output::<bool>("vacuum")?, arm.output::<f64>("flow")?);
        let sucked = arm.input::<bool>("sucked")?;
        arm.input::<bool>("part_seen")?;
        assert_eq!(mp.frame("table")?, Pose::translation(0.4, 0.0, 0.1));
        let pen = mp.tool("pen")?;
        assert_eq!((pen.frame, pen.load.mass), (Pose::translation(0.0, 0.0, 0.1), 0.3));
        assert_eq!(
            (pen.load.centre.z, pen.load.inertia[(0, 0)], pen.load.inertia[(2, 2)]),
            (0.04, 1e-4, 2e-5)
        );
        mp.move_robot(&mut arm, (), Tell::output(vacuum, true).and(flow, 0.5))?;
        mp.move_robot(&mut arm, (), Delay::lasting(0.2))?;
        assert!(arm.value(vacuum) && arm.value(sucked) && arm.value(flow) == 0.5);
        // 0.1 m from the flange along its z, as the pen is.
        let flange = Irp6::nominal().forward(&arm.demanded().joints);
        assert!(
            ((flange * pen.frame).translation.vector - arm.demanded().pose.translation.vector).norm() < 1e-12
        );
        Ok(())
    });
    cell.run().expect("its names are there");
}

#[test]
fn what_is_wrong_with_signals_frames_and_tools_is_told_with_what_to_write() {
    let wrong = SIGNALS
        .replace("\"pen\"", "\"pan\"")
        .replace("\"digital 3\"", "\"digital 33\"")
        .replace("follows = \"vacuum\", ", "")
        .replace("channel = \"digital 0\", ", "")
        .replace("turns_tool = true", "turns = true")
        .replace("on_stop = 0 ", "on_stop = \"off\" ")
        .replace("xyz = [0.4, 0.0, 0.1]", "place = [0.4, 0.0, 0.1]")
        .replace("2e-5]", "2e-3]");
    insta::assert_snapshot!(complaints(&wrong));
    let wrong = SIGNALS.replace("holds_body = true", "holds_body = true, on_stop = false");
    let cell =
        CellFile::parse("cell.toml", &wrong).expect("well-formed").cell(&simulated()).expect("known kinds");
    let refused = cell.program(hold).run().expect_err("it would let go").to_string();
    assert!(
        refused.starts_with("robot `arm`, signal `vacuum`: it holds a body, and a stop would let it fall"),
        "{refused}"
    );
}

#[test]
fn what_is_improbable_in_a_cell_is_asked_about() {
    let questions = |text: &str| {
        let file = CellFile::parse("cell.toml", text).expect("allowed");
        let layout = file.cell(&simulated()).expect("kinds are known").layout();
        let in_one_place = file.arms_in_one_place(&layout).len();
        (file.questions().map(ToString::to_string).unwrap_or_default(), in_one_place)
    };
    assert_eq!(questions(GOOD), (String::new(), 0));
    for (probable, improbable, line, asked) in [
        ("xyz = [0.0, 0.0, 0.1]", "xyz = [0.0, 0.0, 100]", 7, "100 m away: are these millimetres?"),
        ("xyz = [0.0, 0.0, 0.1]", "xyz = [0.0, 0.0, 5]", 7, "5 m away: are these millimetres?"),
        ("xyz = [0.0, 1.5, 0.0]", "xyz = [0.0, 600, 0.0]", 12, "600 m away: are these millimetres?"),
        ("zyz = [2.5, 0.0, 0.0]", "zyz = [90, 0.0, 0.0]", 12, "90 rad: are these degrees?"),
        ("zyz = [2.5, 0.0, 0.0]", "zyz = [2.5, -180, 0.0]", 12, "180 rad: are these degrees?"),
        ("zyz = [2.5, 0.0, 0.0]", "rpy = [0.0, 0.0, 90]", 12, "90 rad: are these degrees?"),
    ] {
        let (text, _) = questions(&GOOD.replace(probable, improbable));
        assert!(
            text.starts_with(&format!("cell.toml:{line}:")) && text.contains(asked),
            "{improbable}: {text}"
        );
    }
    let tool = "\n[tools.pen]\nxyz = [0.0, 0.0, 0.1]\nmass = 0.3\ncentre = [0, 0, 40]\n[frames.table]\nxyz = [400, 0, 0]\n";
    let (text, _) = questions(&format!("{GOOD}{tool}"));
    assert!(text.contains("40 m away") && text.contains("400 m away"), "{text}");
    // Without its base one arm stands in the other; a belt may.
    let in_one_place = GOOD.replace("base = { xyz = [0.0, 1.5, 0.0], zyz = [2.5, 0.0, 0.0] }", "");
    assert_eq!(questions(&in_one_place).1, 1);
    assert_eq!(questions(&format!("{GOOD}\n[robots.belt]\nkind = \"conveyor\"\nstart = [0]\n")).1, 0);
}
