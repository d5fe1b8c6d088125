//! The program: its command line, and its life beside the cell.

use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{complain, refused};
use mrroc_core::operator::Request;
use mrroc_core::operator::button::Button;
use mrroc_external::Subscriber;
use mrroc_launch::cell_file::CellFile;
use mrroc_processes::{Caller, ConsoleMessage, Picture};

use crate::buttons;
use crate::node::{Place, RosNode};
use crate::show::Topics;

/// How often it is looked whether the cell has shown anything.
const LOOK: Duration = Duration::from_millis(1);
/// The time between two diagnostics.
const DIAGNOSED: Duration = Duration::from_secs(1);
/// How long it is waited before a cell that is not there is looked for again.
const AGAIN: Duration = Duration::from_millis(200);

/// Shows the cell to the nodes of ROS 2, and lets them press its buttons.
#[derive(Debug, Parser)]
#[command(name = "ros2")]
struct Options {
    /// The file of the cell.
    #[arg(long, value_name = "FILE", default_value = "cell.toml")]
    cell: PathBuf,
    /// The domain of DDS; without it `ROS_DOMAIN_ID`, or 0.
    #[arg(long, value_name = "NUMBER")]
    domain: Option<u16>,
    /// The address of this machine on the network where DDS speaks; whoever reaches it can press the buttons.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,
    /// The name of the node.
    #[arg(long, value_name = "NAME", default_value = "cell")]
    node: String,
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
    let assembled = CellFile::read(&options.cell).map_err(CellError::from).and_then(|file| cell(&file));
    let assembled = match assembled {
        Ok(assembled) => assembled,
        Err(error) => return refused(&error),
    };
    match attend(port, assembled, &options) {
        Ok(never) => match never {},
        Err(why) => refused(&why),
    }
}

/// The domain that the user of this machine has set for all programs of ROS 2.
fn users_domain() -> Result<u16, String> {
    let Some(domain) = std::env::var_os("ROS_DOMAIN_ID") else { return Ok(0) };
    let read = domain.to_str().and_then(|domain| domain.parse().ok());
    read.ok_or_else(|| format!("ROS_DOMAIN_ID is `{}`\n help: it is a number, 0 to 232", domain.display()))
}

fn attend(port: &str, mut cell: Cell, options: &Options) -> Result<core::convert::Infallible, String> {
    let domain = options.domain.map_or_else(users_domain, Ok)?;
    let place = Place { domain, address: options.address, node: options.node.clone() };
    let (layout, file) = (cell.layout(), options.cell.clone());
    let urdfs: Vec<_> = cell.robots_mut().map(|robot| robot.urdf()).collect();
    let names: Vec<_> = layout.robots.iter().map(|robot| robot.name.as_str()).collect();
    let mut subscriber = Subscriber::at(port, &names)?;
    let set_speed = {
        let file = file.clone();
        move |speed: f64| {
            if !(0.0..=1.0).contains(&speed) {
                return Err(format!("the speed is {speed}\n help: it is a share, from 0.0 to 1.0"));
            }
            buttons::press(&file, Button::Speed(speed)).map(drop)
        }
    };
    let mut node = RosNode::begin(&place, set_speed)?;
    let mut topics = Topics::open(&mut node, &layout, &urdfs)?;
    buttons::offer(&mut node, &file)?;
    let (show, pictures) = channel();
    let watches = move || loop {
        drop(watch(&file, &show));
        std::thread::sleep(AGAIN);
    };
    std::thread::Builder::new()
        .name("watches".to_owned())
        .spawn(watches)
        .map_err(|error| format!("no thread for pictures: {error}"))?;
    complain(&format!("node /{}: domain {domain} at {}", place.node, place.address));
    show_for_ever(&mut subscriber, &mut topics, &pictures)
}

fn show_for_ever(
    subscriber: &mut Subscriber,
    topics: &mut Topics,
    pictures: &Receiver<Option<Box<Picture>>>,
) -> Result<core::convert::Infallible, String> {
    let mut diagnosed = Instant::now();
    loop {
        while let Some(image) = subscriber.image() {
            topics.image(image);
        }
        match pictures.try_iter().last() {
            Some(Some(picture)) => {
                topics.picture(&picture);
                if diagnosed.elapsed() >= DIAGNOSED {
                    diagnosed = Instant::now();
                    topics.diagnose(&picture);
                }
            }
            Some(None) => topics.state("not running"),
            None => {}
        }
        std::thread::sleep(LOOK);
    }
}

/// Takes the pictures of a running cell, until it ends.
fn watch(cell: &Path, show: &Sender<Option<Box<Picture>>>) -> std::io::Result<()> {
    let _over = Over(show);
    let mut caller = Caller::to(cell)?;
    caller.asks.ask(&Request::Watch, None)?;
    loop {
        if let ConsoleMessage::Picture(picture) = caller.hears.hear()? {
            drop(show.send(Some(picture)));
        }
    }
}

/// Tells that there is no cell any more.
struct Over<'a>(&'a Sender<Option<Box<Picture>>>);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        drop(self.0.send(None));
    }
}
