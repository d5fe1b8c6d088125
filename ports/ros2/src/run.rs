//! The program: its command line, and its life beside the cell.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{complain, refused};
use mrroc_core::observe::layout::Layout;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::{CellState, Request};
use mrroc_external::Subscriber;
use mrroc_launch::cell_file::CellFile;
use mrroc_processes::{Caller, ConsoleMessage, Picture};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::bags;
use crate::buttons;
use crate::checks::{Checked, all_refused, check, checked, shown};
use crate::clock::{CellClock, now};
use crate::description::{Description, joint_names};
use crate::diagnostics;
use crate::moveit;
use crate::node::{RosNode, topic_name};
use crate::options::Options;
use crate::show::Topics;
use crate::topics::SensorTopics;
use crate::trajectories::Trajectories;

/// How often it is looked whether the cell has shown anything.
const LOOK: Duration = Duration::from_millis(1);
/// For how long images and readings are taken before pictures and goals are looked at: on a machine that is too slow for all of them, these have their turn, too,
/// since a cell stops robots that follow goals where the bridge is silent.
const TURN: Duration = Duration::from_millis(10);
/// The most memory that the bridge may take \[bytes\]. A packet that others forge can have the library for DDS ask for more and more: then the bridge ends, as if it were killed, and not
/// the cell beside it.
const MEMORY: u64 = 2 << 30;
/// How long it is waited before a cell that is not there is looked for again.
const AGAIN: Duration = Duration::from_millis(200);

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
        let (layout, urdfs) = shown(&mut cell);
        return match bags::export(recording, folder, &options.node, &layout, &urdfs) {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => refused(&why),
        };
    }
    if options.check {
        return check(assembled, &options);
    }
    match attend(port, assembled, &options) {
        Ok(never) => match never {},
        Err(wrong) => all_refused(&wrong),
    }
}

/// Writes what a configuration of MoveIt needs.
fn export_moveit(mut cell: Cell, folder: &Path, node: &str) -> Result<(), String> {
    let (layout, urdfs) = shown(&mut cell);
    let described = layout.robots.iter().zip(&urdfs).map(|(robot, (name, urdf))| {
        let read =
            |urdf: &String| Description::read(urdf.clone(), &topic_name(name), robot.joints.len()).ok();
        joint_names(urdf.as_ref().and_then(read).as_ref(), robot.joints.len())
    });
    let joints: Vec<_> = described.collect();
    let texts = [
        ("moveit_controllers.yaml", moveit::controllers(&layout, &joints, node)),
        ("joint_limits.yaml", moveit::limits(&layout, &joints)),
    ];
    write_new(folder, &texts)?.iter().for_each(|file| complain(&format!("wrote {}", file.display())));
    Ok(())
}

/// Writes files into a folder, which is made where it is not there, and none where one of them is there already: it may have been changed by hand.
fn write_new(folder: &Path, texts: &[(&str, String)]) -> Result<Vec<PathBuf>, String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let files: Vec<_> = texts.iter().map(|(name, _)| folder.join(name)).collect();
    if let Some(there) = files.iter().find(|file| file.exists()) {
        return Err(format!(
            "{} is there already\n help: move it away, or name another folder",
            there.display()
        ));
    }
    for (file, (_, text)) in files.iter().zip(texts) {
        let written = File::create_new(file).and_then(|mut new| new.write_all(text.as_bytes()));
        written.map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(files)
}

fn attend(
    port: &str,
    (mut cell, cell_file): (Cell, CellFile),
    options: &Options,
) -> Result<core::convert::Infallible, Vec<String>> {
    let (layout, urdfs) = shown(&mut cell);
    let checked = checked(options, &layout, &urdfs, &cell_file)?;
    show(port, &layout, &urdfs, checked, options).map_err(|why| vec![why])
}

fn show(
    port: &str,
    layout: &Layout,
    urdfs: &[(String, Option<String>)],
    Checked { place, robot, from_bag, goals, mapped, recorded }: Checked<'_>,
    options: &Options,
) -> Result<core::convert::Infallible, String> {
    limit_memory(MEMORY)?;
    let file = options.cell.clone();
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
    let mut topics = Topics::open(&mut node, layout, urdfs, CellClock::default())?;
    if options.buttons {
        buttons::offer(&mut node, &file)?;
    }
    let waiting = from_bag.as_ref().map_or_else(String::new, |goals| {
        format!(", with {} trajectories of a bag for when the cell's program takes goals", goals.len())
    });
    let goals = goals.map(|port| Trajectories::at(&port, layout, topics.joints()));
    let mut goals = goals.transpose()?;
    if let Some(goals) = goals.as_mut().filter(|_| options.goals) {
        goals.offer(&mut node, layout)?;
    }
    if let Some((goals, from_bag)) = goals.as_mut().zip(from_bag) {
        goals.play(from_bag, robot);
    }
    let mut readings = SensorTopics::open(&mut node, mapped, recorded)?;
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
        "node /{}: domain {} at {}, {buttons}, {trajectories}{waiting}",
        place.node, place.domain, place.address
    ));
    let mut serve_readings = |subscriber: &mut Subscriber| {
        while let Some(step) = subscriber.step() {
            readings.step(&step);
        }
        readings.serve(&node);
    };
    show_for_ever(&mut subscriber, &mut topics, &pictures, &mut goals, &mut serve_readings)
}

/// Limits the memory of this process, whatever its threads ask for.
fn limit_memory(bytes: u64) -> Result<(), String> {
    let Rlimit { current, maximum } = getrlimit(Resource::Data);
    // What the user allows may be less.
    let current = Some(current.map_or(bytes, |allowed| allowed.min(bytes)));
    setrlimit(Resource::Data, Rlimit { current, maximum })
        .map_err(|error| format!("the memory of the bridge cannot be limited: {error}"))
}

fn show_for_ever(
    subscriber: &mut Subscriber,
    topics: &mut Topics<RosNode>,
    pictures: &Receiver<Option<Box<Picture>>>,
    goals: &mut Option<Trajectories>,
    serve_readings: &mut dyn FnMut(&mut Subscriber),
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
                topics.not_reachable();
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
        serve_readings(subscriber);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_of_moveit_is_written_over_and_none_is_written_beside_one_that_is_there() {
        let folder = std::env::temp_dir().join(format!("mrroc-ros2-export-{}", std::process::id()));
        let texts = [("a.yaml", "one".to_owned()), ("b.yaml", "two".to_owned())];
        assert_eq!(write_new(&folder, &texts), Ok(vec![folder.join("a.yaml"), folder.join("b.yaml")]));
        std::fs::remove_file(folder.join("a.yaml")).expect("it was written");
        std::fs::write(folder.join("b.yaml"), "by hand").expect("it was written");
        let why = write_new(&folder, &texts).expect_err("one is there");
        assert!(why.contains("b.yaml is there already"), "{why}");
        assert!(!folder.join("a.yaml").exists());
        assert_eq!(std::fs::read_to_string(folder.join("b.yaml")).expect("there"), "by hand");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
