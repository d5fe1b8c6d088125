//! The program: its command line, and its life beside the cell.

use std::net::{IpAddr, Ipv4Addr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{complain, refused};
use mrroc_core::observe::layout::{Layout, SensorLayout};
use mrroc_core::operator::button::Button;
use mrroc_core::operator::{CellState, Request};
use mrroc_core::sensor::Sensor as _;
use mrroc_external::{Goals, Subscriber};
use mrroc_launch::cell_file::CellFile;
use mrroc_processes::{Caller, ConsoleMessage, Picture};

use crate::bags::{self, BagOptions};
use crate::buttons;
use crate::clock::{CellClock, now};
use crate::description::{Description, joint_names};
use crate::diagnostics;
use crate::moveit;
use crate::node::{Place, RosNode, topic_name};
use crate::show::Topics;
use crate::topics::SensorTopics;
use crate::trajectories::Trajectories;

/// How often it is looked whether the cell has shown anything.
const LOOK: Duration = Duration::from_millis(1);
/// For how long images and readings are taken before pictures and goals are looked at: on a machine that is too slow for all of them, these have their turn, too,
/// since a cell stops robots that follow goals where the bridge is silent.
const TURN: Duration = Duration::from_millis(10);
/// How long it is waited before a cell that is not there is looked for again.
const AGAIN: Duration = Duration::from_millis(200);

/// Shows the cell to the nodes of ROS 2, and lets them press its buttons.
#[derive(Debug, Parser)]
#[command(name = "ros2")]
struct Options {
    /// The file of the cell.
    #[arg(long, value_name = "FILE", default_value = "cell.toml")]
    cell: PathBuf,
    /// The domain of DDS, 0 to 232; without it `ROS_DOMAIN_ID`, or 0.
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(0..=232))]
    domain: Option<u16>,
    /// The address of this machine that other participants of DDS are told, and on whose network they are looked for.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,
    /// The name of the node.
    #[arg(long, value_name = "NAME", default_value = "cell")]
    node: String,
    /// Let other nodes press the buttons of the console, and set the speed: all that reach this machine.
    #[arg(long)]
    buttons: bool,
    /// Let other nodes have the robots follow trajectories that the cell's program takes: all that reach this machine.
    #[arg(long)]
    goals: bool,
    /// Write `moveit_controllers.yaml` and `joint_limits.yaml` for a configuration of MoveIt 2 into this folder, and end.
    #[arg(long, value_name = "FOLDER")]
    export_moveit: Option<PathBuf>,
    #[command(flatten)]
    bags: BagOptions,
    /// Options of the cell's own program.
    #[arg(last = true, value_name = "OPTIONS")]
    _own: Vec<std::ffi::OsString>,
}

/// The main function of a project's bridge: shows the cell that `cell` makes of `cell.toml`, and that runs as processes
/// [shown](mrroc_external::Subscribers) at the port of this name, until it is ended by a signal.
///
/// The exit status is 2 where it cannot begin.
pub fn run(port: &str, cell: impl FnOnce(&CellFile) -> Result<Cell, CellError>) -> ExitCode {
    let options = match Options::try_parse() {
        Ok(options) => options,
        Err(answer) => {
            // Whether it can be printed changes nothing.
            drop(answer.print());
            return ExitCode::from(answer.exit_code() as u8);
        }
    };
    let read = CellFile::read(&options.cell).map_err(CellError::from);
    let assembled = match read.and_then(|file| Ok((cell(&file)?, file))) {
        Ok(assembled) => assembled,
        Err(error) => return refused(&error),
    };
    if let Some(folder) = &options.export_moveit {
        return match export_moveit(assembled.0, folder, &options.node) {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => refused(&why),
        };
    }
    if let Some((folder, recording)) = options.bags.export_bag.as_ref().zip(options.bags.recording.as_ref()) {
        let mut cell = assembled.0;
        let (layout, urdfs) = own_robots(&mut cell);
        return match bags::export(recording, folder, &options.node, &layout, &urdfs) {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => refused(&why),
        };
    }
    match attend(port, assembled, &options) {
        Ok(never) => match never {},
        Err(why) => refused(&why),
    }
}

/// What a cell is made of, with its own robots alone, and their URDFs in the same order.
fn own_robots(cell: &mut Cell) -> (Layout, Vec<(String, Option<String>)>) {
    let urdfs: Vec<_> = cell.robots_mut().map(|robot| (robot.name().to_owned(), robot.urdf())).collect();
    let mut layout = cell.layout();
    if urdfs.len() < layout.robots.len() {
        complain("warning: robots of lower cells are not shown");
    }
    let mut robots = core::mem::take(&mut layout.robots);
    for (name, _) in &urdfs {
        let place = robots.iter().position(|robot| robot.name == *name);
        layout.robots.extend(place.map(|place| robots.swap_remove(place)));
    }
    (layout, urdfs)
}

/// Writes what a configuration of MoveIt needs.
fn export_moveit(mut cell: Cell, folder: &Path, node: &str) -> Result<(), String> {
    let (layout, urdfs) = own_robots(&mut cell);
    let described = layout.robots.iter().zip(&urdfs).map(|(robot, (name, urdf))| {
        let read =
            |urdf: &String| Description::read(urdf.clone(), &topic_name(name), robot.joints.len()).ok();
        joint_names(urdf.as_ref().and_then(read).as_ref(), robot.joints.len())
    });
    let joints: Vec<_> = described.collect();
    let write = |name: &str, text: String| {
        let file = folder.join(name);
        std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))?;
        complain(&format!("wrote {}", file.display()));
        Ok::<(), String>(())
    };
    write("moveit_controllers.yaml", moveit::controllers(&layout, &joints, node))?;
    write("joint_limits.yaml", moveit::limits(&layout, &joints))
}

/// The domain that the user of this machine has set for all programs of ROS 2.
fn users_domain() -> Result<u16, String> {
    let domain = std::env::var_os("ROS_DOMAIN_ID").filter(|domain| !domain.is_empty());
    let Some(domain) = domain else { return Ok(0) };
    let read = domain.to_str().and_then(|domain| domain.parse().ok()).filter(|domain| *domain <= 232);
    read.ok_or_else(|| format!("ROS_DOMAIN_ID is `{}`\n help: it is a number, 0 to 232", domain.display()))
}

fn attend(
    port: &str,
    (mut cell, cell_file): (Cell, CellFile),
    options: &Options,
) -> Result<core::convert::Infallible, String> {
    let from_bag = options.bags.goals()?;
    let domain = options.domain.map_or_else(users_domain, Ok)?;
    UdpSocket::bind((options.address, 0))
        .map_err(|error| format!("{} is no address of this machine: {error}", options.address))?;
    let topics = cell_file.published().to_vec();
    let place = Place { domain, address: options.address, node: options.node.clone(), topics };
    let file = options.cell.clone();
    let (mut layout, urdfs) = own_robots(&mut cell);
    // Nor are readings of lower cells, which a recording has.
    layout.sensors.retain(|sensor| !sensor.name.contains('.'));
    let robot = only(&layout, options.bags.robot.as_deref())?;
    let names: Vec<_> = urdfs.iter().map(|(name, _)| name.as_str()).collect();
    let mut subscriber = Subscriber::at(port, &names)?;
    let (of, may_press) = (file.clone(), options.buttons);
    let check_speed = move |speed: f64| match (0.0..=1.0).contains(&speed) {
        // What is declared is 1.
        true if may_press || speed == 1.0 => Ok(()),
        true => Err("the bridge shows the cell only\n help: start it with --buttons".to_owned()),
        false => Err(format!("the speed is {speed}\n help: it is a share, from 0.0 to 1.0")),
    };
    let set_speed = move |speed: f64| buttons::press(&of, Button::Speed(speed)).map(drop);
    let mut node = RosNode::begin(&place, check_speed, set_speed)?;
    let mut topics = Topics::open(&mut node, &layout, &urdfs, CellClock::default())?;
    node.check_topics()?;
    if options.buttons {
        buttons::offer(&mut node, &file)?;
    }
    let waiting = from_bag.as_ref().map_or_else(String::new, |goals| {
        format!(", with {} trajectories of a bag for when the cell's program takes goals", goals.len())
    });
    let mut goals = match options.goals || from_bag.is_some() {
        true => Some(trajectories(&layout, &topics, &cell_file)?),
        false => None,
    };
    if let Some(goals) = goals.as_mut().filter(|_| options.goals) {
        goals.offer(&mut node, &layout)?;
    }
    if let Some((goals, from_bag)) = goals.as_mut().zip(from_bag) {
        goals.play(from_bag, robot);
    }
    let mut readings = SensorTopics::open(&mut node, &layout, &cell_file)?;
    let (show, pictures) = channel();
    let watches = move || loop {
        drop(watch(&file, &show));
        // There is none any more.
        drop(show.send(None));
        std::thread::sleep(AGAIN);
    };
    std::thread::Builder::new()
        .name("watches".to_owned())
        .spawn(watches)
        .map_err(|error| format!("no thread for pictures: {error}"))?;
    let with = |what: bool, name: &str| format!("{} {name}", if what { "with" } else { "without" });
    let (buttons, trajectories) = (with(options.buttons, "buttons"), with(options.goals, "goals"));
    complain(&format!(
        "node /{}: domain {domain} at {}, {buttons}, {trajectories}{waiting}",
        place.node, place.address
    ));
    let mut serve_readings = || readings.serve(&node);
    show_for_ever(&mut subscriber, &mut topics, &pictures, &mut goals, &mut serve_readings)
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

/// Trajectories for the program of a cell that has a sensor of goals.
fn trajectories(layout: &Layout, topics: &Topics<RosNode>, file: &CellFile) -> Result<Trajectories, String> {
    let is_it = |sensor: &&SensorLayout| sensor.kind == Goals::KIND;
    let sensor = layout.sensors.iter().find(is_it).ok_or(
        "the cell has no sensor of goals\n help: give its MP one, by `mrroc_external::Goals::in_cell`",
    )?;
    let port = file.external(&sensor.name).map_err(|error| error.to_string())?.port();
    Trajectories::at(port, layout, topics.joints())
}

fn show_for_ever(
    subscriber: &mut Subscriber,
    topics: &mut Topics<RosNode>,
    pictures: &Receiver<Option<Box<Picture>>>,
    goals: &mut Option<Trajectories>,
    serve_readings: &mut dyn FnMut(),
) -> Result<core::convert::Infallible, String> {
    let mut diagnosed = Instant::now();
    let mut told = (CellState::Idle, None);
    loop {
        let began = Instant::now();
        while began.elapsed() < TURN {
            let (image, reading) = (subscriber.image(), subscriber.reading());
            if let Some(image) = &image {
                let stamp = topics.image(image);
                if let Some(goals) = goals {
                    goals.image(image, stamp);
                }
            }
            if let Some(reading) = &reading {
                topics.reading_shown(reading);
            }
            if image.is_none() && reading.is_none() {
                break;
            }
        }
        // Each picture: what it alone shows is not to be lost.
        for picture in pictures.try_iter() {
            let Some(picture) = picture else {
                topics.state("not reachable");
                if let Some(goals) = goals {
                    goals.fault(None);
                }
                continue;
            };
            topics.picture(&picture);
            let says = (picture.state, picture.fault.clone());
            if let Some(goals) = goals {
                // A fault is told until another one comes: what counts is whether the cell stands by it.
                let stands =
                    !matches!(picture.state, CellState::Idle | CellState::Running | CellState::Suspended);
                goals.fault(picture.fault.as_deref().filter(|_| stands));
            }
            if says != told || diagnosed.elapsed() >= diagnostics::EVERY {
                (diagnosed, told) = (Instant::now(), says);
                topics.diagnose(&picture, now());
            }
        }
        if let Some(goals) = goals {
            goals.serve();
        }
        serve_readings();
        std::thread::sleep(LOOK);
    }
}

/// Takes the pictures of a running cell, until it ends.
fn watch(cell: &Path, show: &Sender<Option<Box<Picture>>>) -> std::io::Result<()> {
    let mut caller = Caller::to(cell)?;
    caller.asks.ask(&Request::Watch, None)?;
    loop {
        if let ConsoleMessage::Picture(picture) = caller.hears.hear()? {
            drop(show.send(Some(picture)));
        }
    }
}
