//! What the command line and the cell file ask of the bridge, found to be possible before DDS begins, or wrong: all of it, not the first mistake alone.
//!
//! In: options, the layout of a cell, and its file. Out: what the bridge begins with; or each mistake. `--check` ends with that.

use std::net::UdpSocket;
use std::process::ExitCode;

use mrroc_core::cell::Cell;
use mrroc_core::console::{complain, refused, say};
use mrroc_core::observe::layout::{Layout, SensorLayout};
use mrroc_core::sensor::Sensor as _;
use mrroc_external::{Goals, port_of_cell};
use mrroc_launch::cell_file::CellFile;
use ros2_client::{Name, NodeName};

use crate::clock::CellClock;
use crate::messages::RosType;
use crate::node::{Place, check_published};
use crate::options::Options;
use crate::outlet::{Durability, Outlet, Put, twice};
use crate::show::Topics;
use crate::topics::{self, Mapped, Recorded};
use crate::trajectories::{self, Request};

/// What the bridge begins with.
pub struct Checked<'a> {
    pub place: Place,
    /// The robot that the trajectories of a bag are for.
    pub robot: Option<usize>,
    /// The trajectories of a bag.
    pub from_bag: Option<Vec<Request>>,
    /// The port of the sensor of goals, where goals are taken.
    pub goals: Option<String>,
    /// The topics that are sensors, and their messages in a bag.
    pub mapped: Vec<Mapped<'a>>,
    pub recorded: Option<Recorded>,
}

/// Mistakes that were found.
#[derive(Default)]
struct Mistakes(Vec<String>);

impl Mistakes {
    fn take<T>(&mut self, found: Result<T, String>) -> Option<T> {
        found.map_err(|why| self.0.push(why)).ok()
    }

    fn take_all<T>(&mut self, found: Result<T, Vec<String>>) -> Option<T> {
        found.map_err(|all| self.0.extend(all)).ok()
    }
}

/// Finds out whether what is asked for is possible for a cell that has these robots with their URDFs.
///
/// # Errors
/// All that is wrong.
pub fn checked<'a>(
    options: &Options,
    layout: &'a Layout,
    urdfs: &[(String, Option<String>)],
    file: &'a CellFile,
) -> Result<Checked<'a>, Vec<String>> {
    let mut wrong = Mistakes::default();
    let named = NodeName::new("/", &options.node).map_err(|error| {
        format!("node `{}`: {error}\n help: write letters, digits and _, a letter first", options.node)
    });
    // A node that can have no such name is told of once, and not for each of its topics.
    let is_name = named.is_ok();
    let mut names = Names::of(if is_name { &options.node } else { "cell" });
    let opened = Topics::open(&mut names, layout, urdfs, CellClock::default());
    wrong.0.append(&mut names.wrong);
    let joints = wrong.take(opened).map(|topics| topics.joints());
    // Of topics that are not known nothing can be said.
    if is_name && joints.is_some() {
        wrong.take(check_published(&names.published, file.published()));
    }
    let domain = wrong.take(options.domain.map_or_else(users_domain, Ok));
    let bound = UdpSocket::bind((options.address, 0))
        .map_err(|error| format!("{} is no address of this machine: {error}", options.address));
    wrong.take(bound);
    wrong.take(named);
    let robot = wrong.take(only(layout, options.bags.robot.as_deref()));
    let from_bag = wrong.take(options.bags.goals());
    if let (Some(robot), Some(Some(goals)), Some(joints)) = (robot, &from_bag, joints) {
        wrong.0.extend(trajectories::mistakes(layout, joints, goals, robot));
    }
    let takes_goals = options.goals || options.bags.has_goals();
    let goals = wrong.take(takes_goals.then(|| port_of_goals(layout, file)).transpose());
    if options.goals {
        wrong.take(trajectories::check_actions(layout, &options.node));
    }
    let mapped = topics::mapped(layout, file);
    let mapped = wrong.take_all(mapped.map_err(|errors| errors.iter().map(ToString::to_string).collect()));
    let recorded = mapped.as_ref().zip(options.bags.sensors_from_bag.as_ref());
    let recorded = wrong.take_all(recorded.map(|(mapped, bag)| Recorded::read(bag, mapped)).transpose());
    match (domain, robot, from_bag, goals, mapped, recorded) {
        (Some(domain), Some(robot), Some(from_bag), Some(goals), Some(mapped), Some(recorded))
            if wrong.0.is_empty() =>
        {
            let topics = file.published().to_vec();
            let place = Place { domain, address: options.address, node: options.node.clone(), topics };
            Ok(Checked { place, robot, from_bag, goals, mapped, recorded })
        }
        _ => Err(wrong.0),
    }
}

/// Checks all that can be checked without DDS and without a cell that runs.
pub fn check((mut cell, file): (Cell, CellFile), options: &Options) -> ExitCode {
    let (layout, urdfs) = shown(&mut cell);
    let Checked { place, from_bag, mapped, recorded, .. } = match checked(options, &layout, &urdfs, &file) {
        Ok(checked) => checked,
        Err(wrong) => return all_refused(&wrong),
    };
    let mut well = format!(
        "{}: nothing is wrong with what the bridge needs\n\nnode /{}: domain {} at {}\n",
        options.cell.display(),
        place.node,
        place.domain,
        place.address
    );
    for line in topics::described(&mapped, recorded.as_ref()) {
        well += &format!("{line}\n");
    }
    if let Some(goals) = from_bag {
        well += &format!("bag: {} trajectories\n", goals.len());
    }
    say(&well)
}

/// What is shown of a cell, its own robots and sensors, with the robots' URDFs in the same order.
pub fn shown(cell: &mut Cell) -> (Layout, Vec<(String, Option<String>)>) {
    let urdfs: Vec<_> = cell.robots_mut().map(|robot| (robot.name().to_owned(), robot.urdf())).collect();
    let whole = cell.layout();
    if !whole.cells.is_empty() {
        complain("warning: robots and sensors of lower cells are not shown");
    }
    let mut layout = whole.without_lower_cells();
    let mut robots = core::mem::take(&mut layout.robots);
    for (name, _) in &urdfs {
        let place = robots.iter().position(|robot| robot.name == *name);
        layout.robots.extend(place.map(|place| robots.swap_remove(place)));
    }
    (layout, urdfs)
}

/// Tells all that is wrong.
#[must_use = "the exit status tells that something is wrong"]
pub fn all_refused(wrong: &[String]) -> ExitCode {
    wrong.iter().fold(ExitCode::SUCCESS, |_, why| refused(why))
}

/// The domain that the user of this machine has set for all programs of ROS 2.
fn users_domain() -> Result<u16, String> {
    let domain = std::env::var_os("ROS_DOMAIN_ID").filter(|domain| !domain.is_empty());
    let Some(domain) = domain else { return Ok(0) };
    let read = domain.to_str().and_then(|domain| domain.parse().ok()).filter(|domain| *domain <= 232);
    read.ok_or_else(|| format!("ROS_DOMAIN_ID is `{}`\n help: it is a number, 0 to 232", domain.display()))
}

/// The place of the robot of a name, if one is given.
fn only(layout: &Layout, name: Option<&str>) -> Result<Option<usize>, String> {
    let Some(name) = name else { return Ok(None) };
    let place = layout.robots.iter().position(|robot| robot.name == name);
    let known: Vec<_> = layout.robots.iter().map(|robot| robot.name.as_str()).collect();
    place
        .map(Some)
        .ok_or_else(|| format!("--robot: the cell has no robot `{name}`\n help: it has {}", known.join(", ")))
}

/// The port of a cell's sensor of goals.
fn port_of_goals(layout: &Layout, file: &CellFile) -> Result<String, String> {
    let is_it = |sensor: &&SensorLayout| sensor.kind == Goals::KIND;
    let sensor = layout.sensors.iter().find(is_it).ok_or(
        "the cell has no sensor of goals\n help: give its MP one, by `mrroc_external::Goals::in_cell`",
    )?;
    let entry = file.external(&sensor.name).map_err(|error| error.to_string())?;
    Ok(port_of_cell(entry))
}

/// Topics of which the names alone are looked at.
struct Names {
    node: String,
    published: Vec<(String, Durability)>,
    wrong: Vec<String>,
}

/// Where nothing goes.
struct Nowhere;

impl Names {
    fn of(node: &str) -> Names {
        Names { node: node.to_owned(), published: Vec::new(), wrong: Vec::new() }
    }
}

impl Outlet for Names {
    type Topic<M: RosType> = Nowhere;

    fn node(&self) -> &str {
        &self.node
    }

    fn now(&self) -> u64 {
        crate::clock::now()
    }

    fn topic<M: RosType>(&mut self, name: &str, durability: Durability) -> Result<Nowhere, String> {
        if let Err(error) = Name::parse(name) {
            self.wrong.push(format!("topic {name}: {error}"));
        } else if self.published.iter().any(|(known, _)| known == name) {
            self.wrong.push(twice(name));
        }
        self.published.push((name.to_owned(), durability));
        Ok(Nowhere)
    }
}

impl<M> Put<M> for Nowhere {
    fn put(&self, _: M) {}
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;
    use mrroc_core::observe::layout::SignalLayout;
    use mrroc_core::robot::Channel;
    use mrroc_robots::simulated;

    use super::*;

    const ARM: &str =
        "step_ms = 2\nrobots.arm = { kind = \"irp6\", start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0] }\n";

    /// What is wrong with these options, for a cell without sensors whose file has this, too.
    fn wrong(file: &str, options: &[&str]) -> Vec<String> {
        wrong_of(|_| (), file, options)
    }

    /// The same, with a layout that is changed before.
    fn wrong_of(change: impl FnOnce(&mut Layout), file: &str, options: &[&str]) -> Vec<String> {
        let cell = CellFile::parse("cell.toml", ARM).expect("a cell").cell(&simulated());
        let (mut layout, urdfs) = shown(&mut cell.expect("of one arm"));
        change(&mut layout);
        let file = CellFile::parse("cell.toml", &format!("{ARM}{file}")).expect("its form is right");
        let options = Options::try_parse_from([&["ros2"], options].concat()).expect("options");
        checked(&options, &layout, &urdfs, &file).err().unwrap_or_default()
    }

    #[test]
    fn topics_that_would_be_there_twice_and_tables_of_none_are_told_before_dds_begins() {
        let signal = |name: &str| SignalLayout {
            name: name.to_owned(),
            channel: Channel::Digital(0),
            is_output: true,
            note: String::new(),
        };
        let two = |layout: &mut Layout| layout.robots[0].signals.extend(["grip-a", "grip_a"].map(signal));
        let table = "[topics.\"/amr/joint_states\"]\ndepth = 5\n";
        let found = wrong_of(two, table, &["--domain", "3"]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("topic /arm/outputs/grip_a: it would be there twice"), "{found:?}");
        assert!(found[1].contains("the bridge publishes no topic `/amr/joint_states`"), "{found:?}");
        // Where the topics are not known, the table may be right.
        let same = |layout: &mut Layout| layout.robots.push(layout.robots[0].clone());
        let found = wrong_of(same, table, &["--domain", "3"]);
        assert!(found.len() == 1 && found[0].contains("would have the same topics /arm/"), "{found:?}");
        let found = wrong("[topics.\"/a-b/state\"]\ndepth = 5\n", &["--domain", "3", "--node", "a-b"]);
        assert!(found.len() == 1 && found[0].starts_with("node `a-b`"), "{found:?}");
    }

    #[test]
    fn of_a_cell_with_lower_cells_its_own_robots_are_shown() {
        let file = CellFile::parse("cell.toml", ARM).expect("a cell");
        let cell = || file.cell(&simulated()).expect("of one arm");
        let mut whole = cell().cell("press", cell());
        assert_eq!(whole.layout().robots.len(), 2);
        let (layout, urdfs) = shown(&mut whole);
        let names: Vec<_> = layout.robots.iter().map(|robot| &*robot.name).collect();
        assert_eq!((names, urdfs.len(), layout.cells.len()), (vec!["arm"], 1, 0));
    }

    #[test]
    fn all_mistakes_are_told_and_not_the_first_one_alone() {
        assert_eq!(wrong("", &["--domain", "3", "--buttons"]), Vec::<String>::new());
        let sensor = "[sensors.stick]\nmode = \"free running\"\nperiod_ms = 2\nstale_after_ms = 100\n\
                      [sensors.stick.external]\nrate_hz = 50.0\n[sensors.stick.external.topic]\nname = \"/x\"\n\
                      type = \"std_msgs/msg/Float64\"\nreading = \"data\"\n";
        let options = [
            "--node",
            "a-b",
            "--address",
            "192.0.2.1",
            "--goals",
            "--from-bag",
            "/nowhere/bag",
            "--robot",
            "amr",
        ];
        let found = wrong(sensor, &options);
        let expected = [
            "192.0.2.1 is no address of this machine",
            "node `a-b`",
            "--robot: the cell has no robot `amr`",
            "/nowhere/bag: No such file",
            "the cell has no sensor of goals",
            "the cell has no sensor `stick`",
        ];
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.contains(expected), "{expected}: {found}");
        }
        let found = wrong("", &["--node", "arm", "--sensors-from-bag", "/nowhere/bag", "--domain", "3"]);
        assert!(found.len() == 1 && found[0].contains("makes no topic a sensor"), "{found:?}");
    }
}
